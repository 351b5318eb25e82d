"""Decks: values by address, equilibria and runs."""

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
    """Values at several addresses. An arithmetic operation applies to each value: ``deck["BUSHING/*.K.1"] *= 1.2``."""

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
    """Difference between two decks. ``kind`` is ``added``, ``removed``, ``number`` or ``text``. Angles are in radians."""

    address: str
    kind: str
    name: str | None = None
    before: float | str | None = None
    after: float | str | None = None


@dataclass(frozen=True)
class Sensitivity:
    """Exact derivatives of an equilibrium in the deck's units: ``values[i, j]`` is the derivative of ``of[j]`` by ``by[i]``."""

    of: list[str]
    by: list[str]
    at: NDArray[np.float64]
    values: NDArray[np.float64]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype=dtype) if copy or dtype is not None else self.values

    def __getitem__(self, key: tuple[str, str]) -> float:
        """Return one derivative, such as ``table["BUSHING/1.K.1", "PART/4 x"]``."""
        by, of = key
        return float(self.values[self.by.index(by), self.of.index(of)])

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with one row for each parameter and one column for each result."""
        pd = needed("pandas", "to_pandas", "pandas")

        table: "pandas.DataFrame" = pd.DataFrame(self.values, index=self.by, columns=self.of)
        return table


class Deck:
    """ADAMS dataset (.adm): values by address, equilibrium, and simulation runs.

    An address is ``BUSHING/12.K.2``, ``front_arm.K`` or ``SFORCE/3``. In a pattern, ``*`` matches any id or name. Numbers are in the
    deck's units, angles in radians. A change keeps every byte of the file except the bytes of the changed value.

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
        """Create a deck from its text.

        Parameters
        ----------
        text : str or bytes
            Complete text of a dataset, including the title line.
        name : str
            Name of the deck in messages. Files that the deck names are searched in the folder of this name.

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
        """Path of the file that the deck was read from, or the name given to :meth:`from_string`."""
        return self._inner.name()

    @property
    def title(self) -> str:
        """Title of the deck, which is its first line."""
        return self._inner.title()

    @property
    def text(self) -> str:
        """Complete text. A text that is not UTF-8 is decoded as Latin-1; ``bytes(deck)`` returns the original bytes."""
        raw = self._inner.bytes()
        try:
            return raw.decode()
        except UnicodeDecodeError:
            return raw.decode("latin-1")

    def __bytes__(self) -> bytes:
        return self._inner.bytes()

    def copy(self) -> "Deck":
        """Return an independent deck with the same text and file."""
        return Deck(self._inner.copy())

    __copy__ = copy

    def __deepcopy__(self, memo: object) -> "Deck":
        return self.copy()

    def __getitem__(self, address: str) -> Any:
        """Return the value at an address, or for a pattern the value at each matching address.

        A number is returned as float or int, several numbers as an array, a flag as bool, and a function or word as text. For the
        address of an object alone, the statement is returned as text. An argument that is not written has its default value.
        """
        if any(mark in address for mark in "*?["):
            return Values({name: _array(value) for name, value in self._inner.values(address)})
        return _array(self._inner.get(address))

    def __setitem__(self, address: str, value: Value | Mapping[str, Value]) -> None:
        """Set the value at an address, or at each address that matches a pattern. A mapping sets a separate value at each address."""
        if isinstance(value, Mapping):
            self.update(value)
        else:
            self.update({address: value})

    def update(self, values: Mapping[str, Value]) -> None:
        """Set several values. If one of them is refused, none is set."""
        self._inner.set(_given(values))

    def save(self, path: str | os.PathLike[str] | None = None, *, overwrite: bool = False, force: bool = False) -> None:
        """Write the deck to its own file, or to another file, which then becomes its own file.

        The file is replaced atomically. Another file that exists is replaced only with ``overwrite``. With ``force``, the deck is saved
        even if its file was changed since it was read, or if the deck has a new error.
        """
        if path is None:
            self._inner.save(force)
        else:
            self._inner.save_as(os.fspath(path), overwrite, force)

    def check(self) -> list[Complaint]:
        """Return the messages of ``admire check`` about the deck, in the order of the file."""
        return complaints_of(self._inner.check())

    def diff(self, other: "Deck", *, rtol: float = 0.0, atol: float = 0.0) -> list[Change]:
        """Return the differences from this deck to another deck, regardless of their layout.

        Parameters
        ----------
        other : Deck
            The changed deck.
        rtol, atol : float
            Numbers within this relative or absolute tolerance count as equal.

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
        """Forces defined by functions: SFORCE, GFORCE, VFORCE and VTORQUE."""
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
        """Find the static equilibrium, or execute commands. The deck is not changed, and no file is written.

        Parameters
        ----------
        values : mapping, optional
            Values at addresses for this run only, such as ``{"SFORCE/3": 4500.0}``.
        file : path, optional
            Command file (.acf), executed on this deck regardless of the model that it names.
        commands : str, optional
            Text of the commands, one per line. Without ``file`` and ``commands``, the static equilibrium is found.
        check : bool
            Raise an exception if the run did not succeed.
        progress : bool or callable
            Show progress on standard error, or call a function with the stage, a detail, the count and the total.

        Returns
        -------
        Run

        Raises
        ------
        DeckError
            If the deck or the commands have errors.
        SolveError
            If there is no equilibrium or no motion. The attribute ``run`` contains the results up to the failure.
        TypeError
            If both ``file`` and ``commands`` are given, or if ``values`` is not a mapping.

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
            raise TypeError("values must be a mapping; pass a command file as file=..., and the text of commands as commands=...")
        if file is not None and commands is not None:
            raise TypeError("pass file= or commands=, not both")
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
        """Return the derivatives of the equilibrium with respect to parameters of the deck.

        Parameters
        ----------
        of : str or iterable of str
            Results: parts (their motion along and about x, y, z), forces and joints (their force and torque on I), or ``REQUEST/1.F2``.
        by : str or iterable of str
            Parameters such as ``BUSHING/1.K``; by default, all parameters with an effect.
        time : float
            Time at which the equilibrium is solved, in the deck's time unit.

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
        """Run the K&C tests of a configuration on the axle.

        Parameters
        ----------
        config : path
            Path of the configuration kc.toml.
        convention : str
            Axes of the results: ``adams-car``, ``iso`` or ``sae``.
        compare : Deck, iterable or mapping of Deck
            Other decks in the same units, shown in the report for comparison. The keys of a mapping are their names in the report.
        measured : path, optional
            CSV of measured curves, as written by ``admire import-kc``, with the columns test, value and characteristics such as
            ``toe_angle.left [deg]``.

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
        """Return true if the deck has the object and, if the address names an argument, the argument."""
        if not isinstance(address, str):
            return False
        try:
            return self[address] is not None
        except KeyError:
            return False

    def __iter__(self) -> Iterator[Any]:
        raise TypeError('a deck is not iterable; deck["BUSHING/*"] returns all objects of a kind')

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
    """Read a dataset (.adm).

    >>> import admire
    >>> admire.read("corpus/pseudo-mcpherson/model.adm")["SFORCE/3"]  # doctest: +ELLIPSIS
    'SFORCE/3...
    """
    return Deck(_admire.Deck.open(os.fspath(path)))
