"""Sweeps: variants of a deck by the thousand."""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _admire
from ._axle import framed
from ._progress import Progress, shown

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Sweep:
    """The answer of a sweep. ``summary`` is ``summary.json``; in Jupyter the report is shown."""

    folder: str
    summary: dict[str, Any] = field(repr=False)

    @property
    def results(self) -> str:
        """The path of the table, one row a case."""
        return os.path.join(self.folder, "results.parquet")

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a frame; pandas needs pyarrow or fastparquet for it."""
        import pandas

        return pandas.read_parquet(self.results)

    def _repr_html_(self) -> str:
        with open(os.path.join(self.folder, "report.html"), encoding="utf-8") as file:
            return framed(file.read())


def sweep(
    plan: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    shard: tuple[int, int] | None = None,
    progress: Progress = False,
    allow_command: bool = False,
) -> Sweep | None:
    """Runs the cases of a SWEEP.toml into the folder ``out``: what ``admire sweep`` does, in this process.

    A folder that the same sweep began goes on where it stopped. ``jobs`` cases run at a time, as many as there are cores if ``None``.
    ``shard=(3, 8)`` runs the third of eight parts and gives ``None``; :func:`merge` joins them.
    ``allow_command`` starts the program that a plan of somebody else names, as in :func:`identify`.
    """
    command = _admire.program_of_sweep(os.fspath(plan))
    if command:
        warnings.warn(f"every case is solved by a program that is named by the plan or its study: {command}", stacklevel=2)
    with shown(progress) as told:
        text = _admire.sweep(os.fspath(plan), os.fspath(out), jobs, shard, told, allow_command)
    return None if text is None else Sweep(os.fspath(out), json.loads(text))


def merge(folder: str | os.PathLike[str]) -> Sweep:
    """Joins the shards of a sweep into one table: what ``admire merge`` does.

    Raises :class:`DeckError` while a shard is missing or unfinished, and where parts are of different versions or inputs.
    """
    return Sweep(os.fspath(folder), json.loads(_admire.merge_shards(os.fspath(folder))))
