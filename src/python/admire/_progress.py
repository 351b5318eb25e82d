"""Progress of a long computation: a line on standard error, or calls of a function."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

#: Function that is called with the stage, a detail, the number of finished items and the upper bound of their number (``None`` if unknown).
Report = Callable[[str, str, int, "int | None"], object]
#: ``True`` shows a line on standard error. A function is called instead of showing the line.
Progress = Union[bool, Report]


@contextmanager
def shown(progress: Progress) -> Iterator[Report | None]:
    """Provide the function that the library calls during a computation."""
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
