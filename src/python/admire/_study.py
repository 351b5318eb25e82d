"""Studies: stiffnesses from measurements, and what a model gets wrong."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _admire
from ._deck import AxleTests, Deck, framed, read
from ._errors import Complaint, complaints_of
from ._progress import Progress, shown

if TYPE_CHECKING:
    import pandas


class Study:
    """A study folder: a deck, load cases and what was measured."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self._inner = _admire.Study.open(os.fspath(folder))

    @property
    def folder(self) -> str:
        """Where it is."""
        return os.fspath(self._inner.folder())

    @property
    def complaints(self) -> list[Complaint]:
        """Warnings and notes about its files."""
        return complaints_of(self._inner.complaints())

    @property
    def deck(self) -> Deck:
        """Its deck, read anew."""
        return read(self._inner.deck())

    def __reduce__(self) -> tuple[Any, ...]:
        return (Study, (self.folder,))

    def __repr__(self) -> str:
        return f"<admire.Study: {self.folder}>"


@dataclass(frozen=True)
class Parameter:
    """An identified number, in the deck's units (KT per radian). A side of ``interval95`` without a bound is ``None``."""

    address: str
    unit: str
    initial: float
    value: float
    std_error: float | None
    interval95: tuple[float | None, float | None]
    status: str
    tied: tuple[str, ...] = ()


@dataclass(frozen=True)
class Identification:
    """The stiffnesses of a study with their uncertainty. ``json`` is ``identification.json``; in Jupyter the report is shown."""

    parameters: list[Parameter]
    method: str
    converged: bool
    summary: str
    deck: Deck = field(repr=False)
    json: dict[str, Any] = field(repr=False)
    html: str = field(repr=False)
    remarks: list[str] = field(repr=False, default_factory=list)

    def __getitem__(self, address: str) -> Parameter:
        """The number at an address."""
        for parameter in self.parameters:
            if address == parameter.address or address in parameter.tied:
                return parameter
        raise KeyError(address)

    def to_pandas(self) -> "pandas.DataFrame":
        """A frame with a row for each number."""
        import pandas

        rows = [vars(parameter) for parameter in self.parameters]
        return pandas.DataFrame(rows).set_index("address")

    def _repr_html_(self) -> str:
        return framed(self.html)


@dataclass(frozen=True)
class Rival:
    """Another explanation that does as well; ``bic_behind`` is twice the logarithm of how much less probable it is."""

    cause: str
    address: str
    bic_behind: float


@dataclass(frozen=True)
class Finding:
    """One thing that a model gets wrong: the cause, its place, its probability and size, and what mending it gains."""

    cause: str
    address: str
    probability: float
    parameters: Mapping[str, float]
    std_error: Mapping[str, float]
    minor: bool
    evidence: Mapping[str, Any]
    gain: Mapping[str, Any]
    indistinguishable_from: tuple[Rival, ...] = ()
    members: tuple[str, ...] = ()
    form: str | None = None


@dataclass(frozen=True)
class Diagnosis:
    """What a model still gets wrong after its best fit. ``verdict`` is ``consistent``, ``discrepancy`` or ``unexplained``.

    ``deck`` is the deck with the causes modelled, ``commands`` the command file that runs it on any ADAMS, ``json`` is
    ``diagnosis.json``. In Jupyter the report is shown.
    """

    verdict: str
    findings: list[Finding]
    none_of_these: float
    sentences: list[str]
    deck: Deck = field(repr=False)
    commands: str = field(repr=False)
    json: dict[str, Any] = field(repr=False)
    html: str = field(repr=False)
    remarks: list[str] = field(repr=False, default_factory=list)

    def to_pandas(self) -> "pandas.DataFrame":
        """A frame with a row for each finding."""
        import pandas

        rows = [
            {"cause": f.cause, "address": f.address, "probability": f.probability, "minor": f.minor, **f.parameters}
            for f in self.findings
        ]
        return pandas.DataFrame(rows)

    def _repr_html_(self) -> str:
        return framed(self.html)


def _opened(study: Study | str | os.PathLike[str]) -> Study:
    opened = study if isinstance(study, Study) else Study(study)
    command = opened._inner.starts_program()
    if command:
        warnings.warn(f"every equilibrium is solved by a program that study.toml names: {command}", stacklevel=3)
    return opened


def identify(
    study: Study | str | os.PathLike[str],
    *,
    method: str | None = None,
    progress: Progress = False,
    force: bool = False,
) -> Identification:
    """Identifies the stiffnesses of a study: what ``admire identify`` does, without files.

    ``method``: gauss-newton, regression or direct, in place of the study's own. ``progress=True`` shows a line on standard error, a
    function is called in its place. ``force`` fits a study that cannot be meant, too.

    >>> import admire
    >>> found = admire.identify("corpus/pseudo-mcpherson", method="direct")
    >>> found["BUSHING/1.K.1"].unit
    'newton/mm'
    """
    opened = _opened(study)
    with shown(progress) as told:
        text, lead, deck, html, remarks = opened._inner.identify(method, force, told)
    value = json.loads(text)
    parameters = [
        Parameter(
            item["address"],
            item["unit"],
            item["initial"],
            item["value"],
            item["std_error"],
            tuple(item["interval95"]),
            item["status"],
            tuple(item.get("tied", ())),
        )
        for item in value["parameters"]
    ]
    name = os.path.join(opened.folder, "identified.adm")
    answer = Deck(_admire.Deck.parse(name, deck))
    return Identification(
        parameters, value["method"], value["converged"], lead, answer, value, html, remarks
    )


def diagnose(
    study: Study | str | os.PathLike[str], *, progress: Progress = False, force: bool = False
) -> Diagnosis:
    """Says what a model still gets wrong after its best fit: what ``admire diagnose`` does, without files."""
    opened = _opened(study)
    with shown(progress) as told:
        text, sentences, deck, commands, html, remarks = opened._inner.diagnose(force, told)
    value = json.loads(text)
    name = os.path.join(opened.folder, "extended.adm")
    return Diagnosis(
        value["verdict"],
        [_finding(item) for item in value["findings"]],
        value["none_of_these"],
        sentences,
        Deck(_admire.Deck.parse(name, deck)),
        commands,
        value,
        html,
        remarks,
    )


def _finding(item: Mapping[str, Any]) -> Finding:
    return Finding(
        item["cause"],
        item["address"],
        item["probability"],
        item["parameters"],
        item["std_error"],
        item["minor"],
        item["evidence"],
        item["gain"],
        tuple(Rival(**rival) for rival in item["indistinguishable_from"]),
        tuple(item.get("members", ())),
        item.get("form"),
    )


def kc(
    deck: Deck | str | os.PathLike[str],
    config: str | os.PathLike[str] = "kc.toml",
    *,
    convention: str = "adams-car",
) -> AxleTests:
    """Drives an axle through the standard K&C tests: :meth:`Deck.kc` of a deck or its path."""
    opened = deck if isinstance(deck, Deck) else read(deck)
    return opened.kc(config, convention=convention)
