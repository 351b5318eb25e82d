"""Exceptions: the messages of the command line, with their places."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Place:
    """A place in a file. Offsets are in bytes from 0; line and column from 1, ``None`` where the text is not at hand."""

    file: str
    start: int
    end: int
    line: int | None
    column: int | None
    message: str


@dataclass(frozen=True)
class Complaint:
    """What there is to say of a place in a file. ``severity`` is ``"error"``, ``"warning"`` or ``"note"``."""

    code: str
    severity: str
    message: str
    help: str | None = None
    places: tuple[Place, ...] = ()
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return self.text.rstrip() or self.message


def complaints_of(text: str) -> list[Complaint]:
    """Complaints from the JSON of the library."""
    return [_complaint(item) for item in json.loads(text)]


def _complaint(item: dict[str, Any]) -> Complaint:
    places = tuple(Place(**place) for place in item.pop("places"))
    return Complaint(places=places, **item)


class AdmireError(Exception):
    """Base of the exceptions of this package.

    ``complaints`` are the messages, the reason first; each has its places, so that an editor can show them.
    """

    complaints: list[Complaint]

    def __init__(self, text: str, complaints: str = "[]") -> None:
        super().__init__(text, complaints)
        self.complaints = complaints_of(complaints)

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def spans(self) -> list[tuple[str, int, int]]:
        """File, first byte and end of each place that is an error."""
        return [
            (place.file, place.start, place.end)
            for complaint in self.complaints
            if complaint.severity == "error"
            for place in complaint.places
        ]


class DeckError(AdmireError):
    """A deck, command file, study or results file has errors."""


class AddressError(AdmireError, KeyError):
    """An address, a column or a name that means nothing there."""


class SolveError(AdmireError):
    """There is no equilibrium, no motion or no fit. ``run`` holds what there is of a run that failed on the way."""

    run: Any = None
