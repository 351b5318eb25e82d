"""Decks: values by address, equilibria, runs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _admire
from ._errors import Complaint, SolveError, complaints_of
from ._progress import Progress, shown
from ._run import Run

if TYPE_CHECKING:
    import pandas

Value = Union[float, bool, str, Sequence[float], NDArray[np.float64]]


class Values(dict[str, Any]):
    """Values of several addresses. Arithmetic goes through all of them: ``deck["BUSHING/*.K.1"] *= 1.2``."""

    def _each(self, change: Callable[[Any], Any]) -> "Values":
        return Values({address: change(value) for address, value in self.items()})

    def __mul__(self, factor: float) -> "Values":
        return self._each(lambda value: value * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> "Values":
        return self._each(lambda value: value / divisor)

    def __add__(self, term: float) -> "Values":
        return self._each(lambda value: value + term)

    def __sub__(self, term: float) -> "Values":
        return self._each(lambda value: value - term)


@dataclass(frozen=True)
class Change:
    """A difference of two decks. ``kind`` is ``added``, ``removed``, ``number`` or ``text``; angles are in radians."""

    address: str
    kind: str
    name: str | None = None
    before: float | str | None = None
    after: float | str | None = None


@dataclass(frozen=True)
class Sensitivity:
    """Exact derivatives of an equilibrium: ``values[i, j]`` is that of ``of[j]`` by the number ``by[i]``, in the deck's units."""

    of: list[str]
    by: list[str]
    at: NDArray[np.float64]
    values: NDArray[np.float64]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype=dtype) if copy or dtype is not None else self.values

    def __getitem__(self, key: tuple[str, str]) -> float:
        """``table["BUSHING/1.K.1", "PART/4 x"]``."""
        by, of = key
        return float(self.values[self.by.index(by), self.of.index(of)])

    def to_pandas(self) -> "pandas.DataFrame":
        """A frame with the numbers as index."""
        import pandas

        return pandas.DataFrame(self.values, index=self.by, columns=self.of)


@dataclass(frozen=True)
class AxleTests:
    """Characteristics of an axle under the standard K&C tests. ``values`` is ``kc.json``; in Jupyter the report is shown."""

    values: dict[str, Any]
    curves_csv: str
    gradients_csv: str
    html: str
    complaints: list[Complaint]

    def curves(self) -> "pandas.DataFrame":
        """The curves, a row for each state of each test."""
        return _table(self.curves_csv)

    def gradients(self) -> "pandas.DataFrame":
        """The gradients of each test."""
        return _table(self.gradients_csv)

    def _repr_html_(self) -> str:
        return framed(self.html)

    def __repr__(self) -> str:
        return f"<admire.AxleTests: {', '.join(sorted(self.values))}>"


def _table(text: str) -> "pandas.DataFrame":
    import io

    import pandas

    return pandas.read_csv(io.StringIO(text), comment="#")


def framed(page: str) -> str:
    """A whole page inside of another, as Jupyter shows it."""
    import html

    return f'<iframe srcdoc="{html.escape(page)}" style="width:100%;height:80vh;border:0"></iframe>'


class Deck:
    """A dataset (.adm): its values by address, its equilibrium, its runs.

    An address is ``BUSHING/12.K.2``, ``front_arm.K``, ``SFORCE/3``; in a pattern ``*`` stands for any id or name. Numbers are in the
    deck's units, angles in radians. A change keeps every byte of the file but those of the value.

    >>> import admire
    >>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
    >>> deck["BUSHING/1.K.1"] = 12000.0
    >>> deck["BUSHING/1.K"]
    array([12000., 10000., 10000.])
    >>> [change.address for change in admire.read(deck.name).diff(deck)]
    ['BUSHING/1.K.1']
    """

    def __init__(self, inner: _admire.Deck) -> None:
        self._inner = inner

    @property
    def name(self) -> str:
        """The path it was read from, or the name it was given."""
        return self._inner.name()

    @property
    def title(self) -> str:
        """The first line."""
        return self._inner.title()

    @property
    def text(self) -> str:
        """The whole text. Bytes that are not UTF-8 are read as Latin-1; ``bytes(deck)`` has them as they are."""
        raw = self._inner.bytes()
        try:
            return raw.decode()
        except UnicodeDecodeError:
            return raw.decode("latin-1")

    def __bytes__(self) -> bytes:
        return self._inner.bytes()

    def copy(self) -> "Deck":
        """A deck of its own with the same text and file."""
        return Deck(self._inner.copy())

    __copy__ = copy

    def __deepcopy__(self, memo: object) -> "Deck":
        return self.copy()

    def __getitem__(self, address: str) -> Any:
        """The value at an address; of a pattern the value of each address.

        A number is a float or int, several numbers an array, a flag a bool, a function or word a text, and an object without an
        argument its statement. What is not written has its default.
        """
        if any(mark in address for mark in "*?["):
            return Values({name: _array(value) for name, value in self._inner.values(address)})
        return _array(self._inner.get(address))

    def __setitem__(self, address: str, value: Value | Mapping[str, Value]) -> None:
        """Gives an address, or each of a pattern, a new value; a mapping gives each address its own."""
        if isinstance(value, Mapping):
            self.update(value)
        else:
            self.update({address: value})

    def update(self, values: Mapping[str, Value]) -> None:
        """Sets several values, all or none of them."""
        self._inner.set(_given(values))

    def save(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False, force: bool = False) -> None:
        """Writes the deck into its own file, or into another one, which is its own from then on.

        The file is written whole or not at all. A file that was changed since it was read is not replaced, another file only with
        ``overwrite``, and a deck with a new error only with ``force``.
        """
        if path is None:
            self._inner.save(force)
        else:
            self._inner.save_as(os.fspath(path), overwrite, force)

    def check(self) -> list[Complaint]:
        """Everything there is to say of the deck, in the order of the file: what ``admire check`` tells."""
        return complaints_of(self._inner.check())

    def diff(self, other: "Deck", *, rel: float = 0.0, abs: float = 0.0) -> list[Change]:
        """What changed from this deck to another, whatever their layout. Numbers within the tolerances are the same."""
        return [_change(item) for item in json.loads(self._inner.diff(other._inner, rel, abs))]

    def solve(
        self,
        what: str | os.PathLike[str] | Mapping[str, Value] | None = None,
        *,
        check: bool = True,
        progress: Progress = False,
    ) -> Run:
        """Executes a command file, or finds an equilibrium.

        ``what`` is the path of a command file (.acf), which is executed on this deck whatever model it names; a text with a line end:
        the commands themselves; or values for addresses, ``{"SFORCE/3": 4500.0}``, with which the static equilibrium is found, the
        deck being left as it is. Without it the equilibrium of the deck is found. Nothing is written.

        With ``check`` a run that did not succeed raises: :class:`DeckError` for errors of the deck or the commands,
        :class:`SolveError` where there is no answer. Its attribute ``run`` holds what there is.

        >>> import admire
        >>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
        >>> run = deck.solve({"SFORCE/3": 1000.0})
        >>> run.exit_code
        0
        """
        values: list[tuple[str, Any]] = []
        path: str | None = None
        commands = "SIMULATE/STATICS\n"
        if isinstance(what, Mapping):
            values = _given(what)
        elif isinstance(what, str) and "\n" in what:
            commands = what
        elif what is not None:
            path = os.fspath(what)
        if progress is False:
            run = Run(self._inner.run(values, path, commands, None))
        else:
            with shown(progress) as told:
                run = Run(self._inner.run(values, path, commands, told))
        if check and run.exit_code != 0:
            try:
                run._inner.succeeded()
            except SolveError as error:
                error.run = run
                raise
        return run

    def sensitivity(
        self, *, of: str | Iterable[str], by: str | Iterable[str] = (), time: float = 0.0
    ) -> Sensitivity:
        """How the equilibrium changes with the numbers of the deck.

        ``of``: parts (their motion along x, y, z and about them), forces and joints (their force and torque on I), ``REQUEST/1.F2``.
        ``by``: numbers such as ``BUSHING/1.K``; all that have an effect if there are none.
        """
        names = [of] if isinstance(of, str) else list(of)
        numbers = [by] if isinstance(by, str) else list(by)
        columns, addresses, at, values = self._inner.sensitivity(names, numbers, time)
        return Sensitivity(columns, addresses, np.asarray(at), np.array(values, dtype=np.float64))

    def kc(
        self,
        config: str | os.PathLike[str],
        *,
        convention: str = "adams-car",
        compare: "Deck | Iterable[Deck] | Mapping[str, Deck]" = (),
        measured: str | os.PathLike[str] | None = None,
    ) -> AxleTests:
        """Drives the axle through the K&C tests that ``config`` (kc.toml) asks for. ``convention``: adams-car, iso or sae.

        ``compare``: other decks in the same units, shown beside in the report; a mapping gives them names of your own. ``measured``: a
        CSV of measured curves with the columns test, value and characteristics such as ``toe_angle.left [deg]``, shown beside too.

        >>> import admire
        >>> deck = admire.read("corpus/multilink/model.adm")
        >>> stiffer = deck.copy()
        >>> stiffer["BUSHING/*.K.*"] *= 2.0
        >>> tests = deck.kc("corpus/multilink/kc.toml", compare={"stiffer": stiffer})
        """
        others = [compare] if isinstance(compare, Deck) else compare
        if isinstance(others, Mapping):
            named = [(name, other._inner) for name, other in others.items()]
        else:
            named = [(_stem(other.name), other._inner) for other in others]
        file = None if measured is None else os.fspath(measured)
        values, curves, gradients, html, told = self._inner.kc(os.fspath(config), convention, named, file)
        return AxleTests(json.loads(values), curves, gradients, html, complaints_of(told))

    def __contains__(self, address: object) -> bool:
        """True if the deck has an object with this address and, where one is named, this argument."""
        if not isinstance(address, str):
            return False
        try:
            return self[address] is not None
        except KeyError:
            return False

    def __iter__(self) -> Iterator[Any]:
        raise TypeError('a deck is not iterable; deck["BUSHING/*"] has all objects of a kind')

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, (self.name, bytes(self)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Deck) and bytes(self) == bytes(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<admire.Deck: {self.name}, {self.title!r}>"


def _restored(name: str, raw: bytes) -> Deck:
    return Deck(_admire.Deck.parse(name, raw))


def _stem(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0]


def _array(value: Any) -> Any:
    if isinstance(value, list) and all(isinstance(item, (int, float)) for item in value):
        return np.asarray(value, dtype=float)
    return value


def _given(values: Mapping[str, Value]) -> list[tuple[str, Any]]:
    plain = []
    for address, value in values.items():
        if isinstance(value, (np.ndarray, np.generic)):
            value = value.tolist()
        plain.append((address, value))
    return plain


def _change(item: dict[str, Any]) -> Change:
    change = item["change"]
    if isinstance(change, str):
        return Change(item["address"], change, item["name"])
    ((kind, values),) = change.items()
    return Change(item["address"], kind, item["name"], values["before"], values["after"])


def read(path: str | os.PathLike[str]) -> Deck:
    """Reads a dataset (.adm).

    >>> import admire
    >>> admire.read("corpus/pseudo-mcpherson/model.adm")["SFORCE/3"]  # doctest: +ELLIPSIS
    'SFORCE/3...
    """
    return Deck(_admire.Deck.open(os.fspath(path)))
