"""How far a long computation is: a line on standard error, or a function of the caller's."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

#: Called with the stage, a remark, how much is done and of how much at most (``None`` where that is not known).
Report = Callable[[str, str, int, "int | None"], object]
#: ``True`` shows a line on standard error; a function is called in its place.
Progress = Union[bool, Report]


@contextmanager
def shown(progress: Progress) -> Iterator[Report | None]:
    """The function that the library calls while it works."""
    if progress is False:
        yield None
        return
    if progress is not True:
        yield progress
        return
    began = time.monotonic()
    width = 0

    def line(stage: str, detail: str, done: int, most: int | None) -> None:
        nonlocal width
        count = f" {done}" if done else ""
        total = f" of at most {most}" if done and most else ""
        remark = f", {detail}" if detail else ""
        text = f"{stage}{count}{total}{remark}, {time.monotonic() - began:.0f} s"
        sys.stderr.write("\r" + text.ljust(width))
        sys.stderr.flush()
        width = len(text)

    try:
        yield line
    finally:
        if width:
            sys.stderr.write("\r" + " " * width + "\r")
            sys.stderr.flush()
