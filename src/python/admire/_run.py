"""Runs in memory and results files: columns as NumPy arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _admire
from ._errors import Complaint, complaints_of
from ._frames import Column, dataset, frame, plot_columns

if TYPE_CHECKING:
    import pandas
    import xarray


def _numbers(block: _admire.Block | _admire.Run) -> Column:
    """Return numbers of the library as an array, without copying them."""
    found: Column = np.asarray(block, dtype=np.float64)
    return found


class Run:
    """Results of executing commands on a deck, all in memory.

    ``run["KNUCKLE.X"]`` is a read-only column with one value per step. The first step is the model as it was read. The values have full
    precision, while a results file rounds them (RESULTS/DECIMALPLACES, default 17).

    >>> import admire
    >>> run = admire.read("corpus/pseudo-mcpherson/model.adm").solve()
    >>> run.kinds
    ['input', 'static']
    """

    def __init__(self, inner: _admire.Run) -> None:
        self._inner = inner
        self._values: Column | None = None

    @property
    def values(self) -> Column:
        """All values, one row for each step, with the columns in the order of the results file."""
        if self._values is None:
            self._values = _numbers(self._inner)
        return self._values

    @property
    def columns(self) -> list[str]:
        """Full names of the columns."""
        return [name for name, _ in self._inner.columns()]

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column; empty if a column has no unit."""
        return dict(self._inner.columns())

    @property
    def kinds(self) -> list[str]:
        """Kind of each step: ``input``, ``static``, ``quasiStatic``, ``kinematic``, ``dynamic``, ..."""
        return self._inner.kinds()

    @property
    def time(self) -> Column:
        """Time of each step."""
        return self["time.TIME"]

    @property
    def messages(self) -> str:
        """Contents of the message file (.msg)."""
        return self._inner.messages()

    @property
    def complaints(self) -> list[Complaint]:
        """Warnings and errors in the order in which they occurred."""
        return complaints_of(self._inner.complaints())

    @property
    def exit_code(self) -> int:
        """Exit code of ``admire solve`` for this run: 0 success, 1 errors in the input, 3 a simulation failed."""
        return self._inner.exit_code()

    @property
    def balance(self) -> dict[str, tuple[float, str]]:
        """Largest imbalance of a part over all static solutions, from sums of its loads that are independent of the solver.

        The keys are ``"force"`` and ``"torque"``. Each value is the imbalance in units of the deck, and the part. Empty without a static
        solution.
        """
        return self._inner.balance()

    @property
    def seconds(self) -> float:
        """Elapsed time of the run in seconds."""
        return self._inner.elapsed()

    @property
    def files(self) -> list[str]:
        """Other files of the run: ``msg``, and those of ``req``, ``gra`` and ``out`` that the deck requests."""
        return self._inner.files()

    def file(self, name: str) -> bytes:
        """Return the bytes of one of ``files``."""
        found = self._inner.file(name)
        if found is None:
            raise KeyError(name)
        return found

    def __getitem__(self, name: str) -> Column:
        """Return a column, such as ``KNUCKLE.X``, ``knuckle_XFORM.X`` or ``BUSHING/1.FX``. Case is ignored."""
        return self.values[:, self._inner.position(name)]

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and self._inner.position(name) >= 0
        except KeyError:
            return False

    def __len__(self) -> int:
        return len(self.kinds)

    def select(self, *patterns: str) -> dict[str, Column]:
        """Return the columns that match any pattern: ``*`` matches any text, ``?`` one character, an entity all its components."""
        return {name: self.values[:, at] for name, at in self._inner.select(list(patterns))}

    def _chosen(self, patterns: tuple[str, ...]) -> dict[str, Column]:
        if patterns:
            return {"time.TIME": self.time, **self.select(*patterns)}
        return {name: self.values[:, at] for name, at in zip(self.columns, self._inner.positions())}

    def to_pandas(self, *patterns: str) -> "pandas.DataFrame":
        """Return a frame with one row for each step.

        Parameters
        ----------
        *patterns : str
            Names of columns, as in :meth:`select`; by default, all columns.

        Returns
        -------
        pandas.DataFrame
            The time is the index, the kind of each step the column ``step``, and ``attrs["units"]`` contains the units.
        """
        return frame(self._chosen(patterns), self.kinds, self.units)

    def to_xarray(self, *patterns: str) -> "xarray.Dataset":
        """Return a dataset with the dimension ``step``.

        Parameters
        ----------
        *patterns : str
            Names of columns, as in :meth:`select`; by default, all columns.

        Returns
        -------
        xarray.Dataset
            Time and kind of each step are coordinates; ``attrs["units"]`` of each variable is its unit.
        """
        return dataset(self._chosen(patterns), self.kinds, self.units, repr(self))

    def plot(self, *patterns: str, x: str = "time.TIME", ax: Any = None, **options: Any) -> Any:
        """Plot columns over time or over another column, one chart for each unit.

        Parameters
        ----------
        *patterns : str
            Names of columns, as in :meth:`select`.
        x : str
            Column of the horizontal axis.
        ax : matplotlib.axes.Axes or a sequence of them, optional
            Axes to plot into, one for each unit; new axes by default.
        **options
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib.axes.Axes or numpy.ndarray of Axes
            A single axes if all columns have the same unit.

        Raises
        ------
        ImportError
            If matplotlib is not installed.
        """
        over = next(iter(self.select(x)))
        return plot_columns(self.select(over, *patterns), self.units, over, ax, options)

    def _ipython_key_completions_(self) -> list[str]:
        return self.columns

    def write(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the file of the run with this extension (.res, .msg, .req, .gra, .out), with the bytes that ``admire solve`` writes."""
        self._inner.write(os.fspath(path), overwrite)

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, self._inner.state())

    def __repr__(self) -> str:
        return f"<admire.Run: {len(self)} steps of {len(self.columns)} columns, exit code {self.exit_code}>"


def _restored(text: str, values: bytes) -> Run:
    return Run(_admire.Run.restore(text, values))


class Results:
    """Results file (.res, .req, .gra) of any size. Names are read at once; values are read step by step when they are requested."""

    def __init__(self, inner: _admire.Results) -> None:
        self._inner = inner
        self._kept: dict[str, Column] = {}

    @property
    def path(self) -> str:
        """Path of the file."""
        return os.fspath(self._inner.path())

    @property
    def title(self) -> str:
        """Title of the model."""
        return self._inner.title()

    @property
    def solver(self) -> str:
        """Solver that wrote the file."""
        return self._inner.solver()

    @property
    def columns(self) -> list[str]:
        """Full names of the columns."""
        return [name for name, _ in self._inner.columns()]

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column as spelled in the file; empty if a column has no unit."""
        return dict(self._inner.columns())

    @property
    def time(self) -> Column:
        """Time of each step."""
        return self["time.TIME"]

    def __getitem__(self, name: str) -> Column:
        """Return a column with one value per step. It is read once and kept. ``select`` reads several columns faster."""
        if name not in self._kept:
            self._kept[name] = _numbers(self._inner.column(name))[:, 0]
        return self._kept[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def select(
        self,
        *patterns: str,
        steps: str = "",
        kind: str | Iterable[str] = (),
        times: tuple[float, float] = (-np.inf, np.inf),
    ) -> dict[str, Column]:
        """Return the columns that match the patterns. Steps are selected by ``steps="2-5,last"``, ``kind="dynamic"``, ``times=(0, 1.5)``."""
        names, _, values = self._rows(patterns, steps, kind, times)
        return {name: values[:, at] for at, name in enumerate(names)}

    def to_pandas(
        self,
        *patterns: str,
        steps: str = "",
        kind: str | Iterable[str] = (),
        times: tuple[float, float] = (-np.inf, np.inf),
    ) -> "pandas.DataFrame":
        """Return the columns of :meth:`select` as a data frame.

        Returns
        -------
        pandas.DataFrame
            The time is the index, the kind of each step the column ``step``, and ``attrs["units"]`` contains the units.
        """
        columns, kinds = self._chosen(patterns, steps, kind, times)
        return frame(columns, kinds, self.units)

    def to_xarray(
        self,
        *patterns: str,
        steps: str = "",
        kind: str | Iterable[str] = (),
        times: tuple[float, float] = (-np.inf, np.inf),
    ) -> "xarray.Dataset":
        """Return the columns of :meth:`select` as a dataset over ``step``; ``attrs["units"]`` of each variable is its unit."""
        columns, kinds = self._chosen(patterns, steps, kind, times)
        return dataset(columns, kinds, self.units, self.title)

    def plot(self, *patterns: str, x: str = "time.TIME", ax: Any = None, **options: Any) -> Any:
        """Plot columns over time or over another column, one chart for each unit; see :meth:`Run.plot`."""
        over = next(iter(self.select(x)))
        columns = self.select(over, *patterns)
        return plot_columns(columns, self.units, over, ax, options)

    def _ipython_key_completions_(self) -> list[str]:
        return self.columns

    def _chosen(
        self,
        patterns: tuple[str, ...],
        steps: str,
        kind: str | Iterable[str],
        times: tuple[float, float],
    ) -> tuple[dict[str, Column], list[str]]:
        wanted = ("time.TIME", *patterns) if patterns else ()
        names, kinds, values = self._rows(wanted, steps, kind, times)
        return {name: values[:, at] for at, name in enumerate(names)}, kinds

    def _rows(
        self,
        patterns: Iterable[str],
        steps: str,
        kind: str | Iterable[str],
        times: tuple[float, float],
    ) -> tuple[list[str], list[str], Column]:
        kinds = [kind] if isinstance(kind, str) else list(kind)
        columns, found, values = self._inner.select(list(patterns), steps, kinds, times)
        return [name for name, _ in columns], found, _numbers(values)

    def __reduce__(self) -> tuple[Any, ...]:
        return (results, (self.path,))

    def __repr__(self) -> str:
        return f"<admire.Results: {self.path}, {len(self.columns)} columns>"


def results(path: str | os.PathLike[str]) -> Results:
    """Open a results file (.res, .req, .gra or formatted results).

    >>> import admire
    >>> run = admire.read("corpus/pseudo-mcpherson/model.adm").solve()
    >>> run.write("target/doctest.res", overwrite=True)
    >>> admire.results("target/doctest.res").columns == run.columns
    True
    """
    return Results(_admire.Results.open(os.fspath(path)))
