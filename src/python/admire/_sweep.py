"""Sweeps: thousands of variants of a deck."""

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
    """Result of a sweep. ``summary`` is ``summary.json``. Jupyter shows the report."""

    folder: str
    summary: dict[str, Any] = field(repr=False)

    @property
    def results(self) -> str:
        """Path of the results table, which has one row for each case."""
        return os.path.join(self.folder, "results.parquet")

    def to_pandas(self) -> pandas.DataFrame:
        """Return the results table as a frame. pandas needs pyarrow or fastparquet to read it."""
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
    """Run the cases of a SWEEP.toml, as ``admire sweep`` does, and write the results to the folder ``out``.

    If the folder contains an unfinished run of the same sweep, the run continues. ``jobs`` is the number of parallel cases; ``None``
    means one for each core. ``shard=(3, 8)`` runs the third of eight shards and returns ``None``; :func:`merge` joins the shards.
    ``allow_command`` allows the external program that the plan names, as in :func:`identify`.
    """
    command = _admire.program_of_sweep(os.fspath(plan))
    if command:
        warnings.warn(f"every case is solved by an external program, which the plan or its study names: {command}", stacklevel=2)
    with shown(progress) as told:
        text = _admire.sweep(os.fspath(plan), os.fspath(out), jobs, shard, told, allow_command)
    return None if text is None else Sweep(os.fspath(out), json.loads(text))


def merge(folder: str | os.PathLike[str]) -> Sweep:
    """Join the shards of a sweep into one table, as ``admire merge`` does.

    Raises :class:`DeckError` if a shard is missing or unfinished, or if the shards are of different versions or inputs.
    """
    return Sweep(os.fspath(folder), json.loads(_admire.merge_shards(os.fspath(folder))))
