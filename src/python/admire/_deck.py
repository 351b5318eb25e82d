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
from ._axle import AxleTests
from ._errors import AddressError, Complaint, SolveError, complaints_of
from ._frames import needed
from ._objects import Objects
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
        """Return a frame with the numbers of the deck as index."""
        pd = needed("pandas", "to_pandas", "pandas")

        table: "pandas.DataFrame" = pd.DataFrame(self.values, index=self.by, columns=self.of)
        return table


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

    @classmethod
    def from_string(cls, text: str | bytes, name: str = "deck.adm") -> "Deck":
        """Make a deck of its text.

        Parameters
        ----------
        text : str or bytes
            Whole text of a dataset, title line included.
        name : str
            Name that complaints use, and path that :meth:`save` writes to. Files that the deck names are looked for beside it.

        Returns
        -------
        Deck

        Examples
        --------
        >>> import admire
        >>> deck = admire.Deck.from_string("a block\\nPART/1, GROUND\\nPART/2, MASS = 3, CM = 20\\nMARKER/20, PART = 2\\nEND\\n")
        >>> deck["PART/2.MASS"]
        3.0
        """
        raw = text.encode() if isinstance(text, str) else bytes(text)
        return cls(_admire.Deck.parse(name, raw))

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

    def diff(self, other: "Deck", *, rtol: float = 0.0, atol: float = 0.0) -> list[Change]:
        """Return what changed from this deck to another, whatever their layout.

        Parameters
        ----------
        other : Deck
            The changed deck.
        rtol, atol : float
            Numbers within this relative or absolute tolerance are the same.

        Returns
        -------
        list of Change
            In the order of the decks.
        """
        return [_change(item) for item in json.loads(self._inner.diff(other._inner, rtol, atol))]

    def objects(self, kind: str) -> Objects:
        """Return the objects of a kind.

        Parameters
        ----------
        kind : str
            Keyword of a statement: ``"BUSHING"``, ``"beam"``.

        Returns
        -------
        Objects
            Addresses in the order of the deck; empty if there are none.

        Examples
        --------
        >>> import admire
        >>> admire.read("corpus/pseudo-mcpherson/model.adm").bushings
        Objects(['BUSHING/1', 'BUSHING/2', 'BUSHING/3'])
        """
        try:
            return Objects(self, [address for address, _ in self._inner.values(f"{kind.upper()}/*")])
        except AddressError:
            return Objects(self, [])

    @property
    def parts(self) -> Objects:
        """Parts, ground included."""
        return self.objects("PART")

    @property
    def markers(self) -> Objects:
        """Markers."""
        return self.objects("MARKER")

    @property
    def bushings(self) -> Objects:
        """Bushings."""
        return self.objects("BUSHING")

    @property
    def joints(self) -> Objects:
        """Joints."""
        return self.objects("JOINT")

    @property
    def springs(self) -> Objects:
        """Spring-dampers, translational and torsional."""
        return self.objects("SPRINGDAMPER")

    @property
    def forces(self) -> Objects:
        """Forces with a function: SFORCE, GFORCE, VFORCE and VTORQUE."""
        kinds = ("SFORCE", "GFORCE", "VFORCE", "VTORQUE")
        return Objects(self, [address for kind in kinds for address in self.objects(kind)])

    @property
    def motions(self) -> Objects:
        """Motions."""
        return self.objects("MOTION")

    @property
    def requests(self) -> Objects:
        """Requests."""
        return self.objects("REQUEST")

    def _ipython_key_completions_(self) -> list[str]:
        found = [address for address, _ in self._inner.values("*")] if self.parts else []
        for kind in ("BUSHING", "JOINT", "SPRINGDAMPER", "SFORCE", "GFORCE", "VFORCE", "VTORQUE", "MOTION", "REQUEST"):
            found.extend(address for address in self.objects(kind) if address not in found)
        for bushing in self.bushings:
            found.extend(f"{bushing}.{name}" for name in ("K", "KT", "C", "CT", "FORCE", "TORQUE"))
        return found

    def _repr_html_(self) -> str:
        from ._tools import view

        return view(self)._repr_html_()

    def solve(
        self,
        values: Mapping[str, Value] | None = None,
        *,
        file: str | os.PathLike[str] | None = None,
        commands: str | None = None,
        check: bool = True,
        progress: Progress = False,
    ) -> Run:
        """Find an equilibrium, or execute commands. The deck stays as it is, and nothing is written.

        Parameters
        ----------
        values : mapping, optional
            Values for addresses, ``{"SFORCE/3": 4500.0}``, that count in this run alone.
        file : path, optional
            Command file (.acf), executed on this deck whatever model it names.
        commands : str, optional
            The commands themselves, one a line. Without ``file`` and ``commands``, the static equilibrium is found.
        check : bool
            Raise if the run did not succeed.
        progress : bool or callable
            Show progress on standard error, or call a function with stage, remark, count and total.

        Returns
        -------
        Run

        Raises
        ------
        DeckError
            If the deck or the commands have errors.
        SolveError
            If there is no answer. Its attribute ``run`` holds what there is.
        TypeError
            If both ``file`` and ``commands`` are given, or a path or text without its keyword.

        Examples
        --------
        >>> import admire
        >>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
        >>> deck.solve({"SFORCE/3": 1000.0}).exit_code
        0
        >>> deck.solve(commands="SIMULATE/STATICS").kinds
        ['input', 'static']
        """
        if values is not None and not isinstance(values, Mapping):
            raise TypeError("values must be a mapping; a path is file=..., a text of commands is commands=...")
        if file is not None and commands is not None:
            raise TypeError("give file= or commands=, not both")
        given = _given(values) if values else []
        path = None if file is None else os.fspath(file)
        text = "SIMULATE/STATICS\n" if commands is None else commands.rstrip("\n") + "\n"
        if progress is False:
            run = Run(self._inner.run(given, path, text, None))
        else:
            with shown(progress) as told:
                run = Run(self._inner.run(given, path, text, told))
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
        """Return how the equilibrium changes with the numbers of the deck.

        Parameters
        ----------
        of : str or iterable of str
            Parts (their motion along x, y, z and about them), forces and joints (their force and torque on I), ``REQUEST/1.F2``.
        by : str or iterable of str
            Numbers such as ``BUSHING/1.K``; all that have an effect if there are none.
        time : float
            Time at which functions are taken, in the deck's unit.

        Returns
        -------
        Sensitivity
            Exact derivatives, in the deck's units.
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
        """Drive the axle through the K&C tests that a configuration asks for.

        Parameters
        ----------
        config : path
            The configuration, kc.toml.
        convention : str
            Axes of the answer: ``adams-car``, ``iso`` or ``sae``.
        compare : Deck, iterable or mapping of Deck
            Other decks in the same units, shown beside in the report; a mapping gives them names of your own.
        measured : path, optional
            CSV of measured curves with the columns test, value and characteristics such as ``toe_angle.left [deg]``: what
            ``admire import-kc`` writes.

        Returns
        -------
        AxleTests

        Examples
        --------
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
