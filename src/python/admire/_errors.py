"""Exceptions with the messages of the command line and their places."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Place:
    """Place in a file. Byte offsets count from 0, line and column from 1. Line and column are ``None`` if the text is not available."""

    file: str
    start: int
    end: int
    line: int | None
    column: int | None
    message: str


@dataclass(frozen=True)
class Complaint:
    """Message about a place in a file. ``severity`` is ``"error"``, ``"warning"`` or ``"note"``."""

    code: str
    severity: str
    message: str
    help: str | None = None
    places: tuple[Place, ...] = ()
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return self.text.rstrip() or self.message


def complaints_of(text: str) -> list[Complaint]:
    """Return the complaints in the JSON of the library."""
    return [_complaint(item) for item in json.loads(text)]


def _complaint(item: dict[str, Any]) -> Complaint:
    places = tuple(Place(**place) for place in item.pop("places"))
    return Complaint(places=places, **item)


class AdmireError(Exception):
    """Base of the exceptions of this package.

    ``complaints`` contains the messages, the most severe first, each with its places in the files.
    """

    complaints: list[Complaint]

    def __init__(self, text: str, complaints: str = "[]") -> None:
        super().__init__(text, complaints)
        self.complaints = complaints_of(complaints)

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def spans(self) -> list[tuple[str, int, int]]:
        """File, start offset and end offset in bytes of each place with an error."""
        return [
            (place.file, place.start, place.end)
            for complaint in self.complaints
            if complaint.severity == "error"
            for place in complaint.places
        ]


class DeckError(AdmireError):
    """A deck, command file, study or results file has errors."""


class AddressError(AdmireError, KeyError):
    """An address, a column or an option is invalid for this deck, run or study."""


class SolveError(AdmireError):
    """There is no equilibrium, no motion or no fit. ``run`` contains the results of a failed run up to the failure."""

    run: Any = None
