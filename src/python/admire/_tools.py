"""3-D views of mechanisms, comparisons of results, the virtual rig, and new studies."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from . import _admire
from ._axle import framed
from ._deck import Deck, read
from ._frames import needed
from ._run import Results, Run
from ._study import Study

if TYPE_CHECKING:
    import pandas

Stepped = Union[Run, Results, str, "os.PathLike[str]"]


@contextlib.contextmanager
def _as_file(run: Stepped) -> Iterator[str]:
    """Give the path of results; a run in memory is written to a temporary file."""
    if isinstance(run, Results):
        yield run.path
    elif isinstance(run, Run):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "run.res")
            run.write(path)
            yield path
    else:
        yield os.fspath(run)


@dataclass(frozen=True)
class View:
    """Page with a mechanism in three dimensions, which Jupyter shows. ``html`` is the complete page."""

    html: str = field(repr=False)

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the page.

        Parameters
        ----------
        path : path
            Path of the page, which any browser opens without a network.
        overwrite : bool
            Replace the file if it exists.

        Raises
        ------
        FileExistsError
            If the file exists and ``overwrite`` is false.
        """
        with open(path, "w" if overwrite else "x", encoding="utf-8") as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        return framed(self.html)


def view(deck: Deck | str | os.PathLike[str], run: Stepped | None = None, *, highlight: Iterable[str] = ()) -> View:
    """Show a mechanism in three dimensions, as ``admire view`` does, without writing files.

    Parameters
    ----------
    deck : Deck or path
        The deck.
    run : Run, Results or path, optional
        Results whose steps move the mechanism.
    highlight : iterable of str
        Addresses of parts, joints and forces to highlight.

    Returns
    -------
    View

    Raises
    ------
    DeckError
        If the deck has errors, or the results move none of its parts.
    AddressError
        If an address is not that of a part, joint or force in the view.

    Examples
    --------
    >>> import admire
    >>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
    >>> "BUSHING/1" in admire.view(deck, deck.solve(), highlight=["BUSHING/1"]).html
    True
    """
    opened = deck if isinstance(deck, Deck) else read(deck)
    if run is None:
        return View(opened._inner.page(None, list(highlight)))
    with _as_file(run) as path:
        return View(opened._inner.page(path, list(highlight)))


@dataclass(frozen=True)
class Comparison:
    """Differences between two results. ``json`` is the output of ``admire compare --format json``."""

    agrees: bool
    json: dict[str, Any] = field(repr=False)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with one row for each common column: largest difference, unit, steps beyond the tolerance."""
        pd = needed("pandas", "to_pandas", "pandas")
        table: "pandas.DataFrame" = pd.DataFrame(self.json["columns"])
        return table

    def __bool__(self) -> bool:
        return self.agrees


def compare(a: Stepped, b: Stepped, *, rtol: float = 0.0, atol: float = 0.0, floor: float = 1e-12) -> Comparison:
    """Compare two results, column by column and step by step, as ``admire compare`` does.

    Parameters
    ----------
    a, b : Run, Results or path
        The results.
    rtol, atol : float
        Values are equal if they differ by at most ``atol + rtol * max(abs(a), abs(b))``, in the unit of the column.
    floor : float
        Fraction of the largest value in a unit up to which a difference counts as round-off; 0 compares exactly.

    Returns
    -------
    Comparison
        Its truth value is true if the results agree.

    Examples
    --------
    >>> import admire
    >>> deck = admire.read("corpus/pseudo-mcpherson/model.adm")
    >>> bool(admire.compare(deck.solve(), deck.solve()))
    True
    >>> admire.compare(deck.solve(), deck.solve({"SFORCE/3": 1000.0})).agrees
    False
    """
    with _as_file(a) as first, _as_file(b) as second:
        text, agrees = _admire.compare_results(first, second, rtol, atol, floor)
    return Comparison(agrees, json.loads(text))


@dataclass(frozen=True)
class RigRun:
    """Output of the virtual rig: the new ``study``, and ``truth``, the planted effects as text."""

    study: Study
    truth: str


def rig(
    study: Study | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    seed: int = 0,
    sigma: float | None = None,
    effects: str | Iterable[str] = (),
    tolerances: str = "",
    overwrite: bool = False,
) -> RigRun:
    """Measure the deck of a study on the virtual rig, and write the resulting study folder, as ``admire rig`` does.

    Parameters
    ----------
    study : Study or path
        The study, or its folder; its own readings need not exist.
    out : path
        Folder to write.
    seed : int
        Seed of the measurement noise.
    sigma : float, optional
        Standard deviation of one mark coordinate in the deck's length unit, instead of the study's value.
    effects : str or iterable of str
        Effects to plant, such as ``cause@address:name=value,...``; the page ``rig`` of the guide lists them.
    tolerances : str
        Additional small errors in many places, as standard deviations: ``hardpoints=0.3,load_gain=0.005``.
    overwrite : bool
        Replace files that exist in the folder.

    Returns
    -------
    RigRun

    Raises
    ------
    DeckError
        If the study has errors, or a load case has no equilibrium.
    FileExistsError
        If a file exists and ``overwrite`` is false. No file is written in this case.
    ValueError
        If an effect or a tolerance cannot be read.
    """
    folder = study.folder if isinstance(study, Study) else os.fspath(study)
    planted = [effects] if isinstance(effects, str) else list(effects)
    files, truth = _admire.virtual_rig_run(folder, seed, sigma, planted, tolerances)
    _write(Path(out), files, overwrite)
    return RigRun(Study(out), truth)


def new(
    folder: str | os.PathLike[str],
    deck: Deck | str | os.PathLike[str],
    *,
    measured: str | Iterable[str] = "marks",
    bushings: Iterable[str] = (),
    overwrite: bool = False,
) -> list[str]:
    """Create a study of a deck, as ``admire new`` does.

    Parameters
    ----------
    folder : path
        Folder of the study; it is created if missing.
    deck : Deck or path
        The deck, which is copied into the study.
    measured : str or iterable of str
        What was measured: ``marks``, ``wheel``, ``curves`` or ``readings``.
    bushings : iterable of str
        Addresses of the bushings to identify; by default, all bushings.
    overwrite : bool
        Replace files that exist in the folder.

    Returns
    -------
    list of str
        Paths of the written files. The comments in ``study.toml`` describe the missing entries.

    Raises
    ------
    DeckError
        If the deck has errors.
    FileExistsError
        If a file exists and ``overwrite`` is false. No file is written in this case.
    ValueError
        If ``measured`` holds another word.
    """
    opened = deck if isinstance(deck, Deck) else read(deck)
    kinds = [measured] if isinstance(measured, str) else list(measured)
    name = os.path.basename(opened.name)
    texts, _ = _admire.study_files(opened._inner, name, kinds, list(bushings))
    files = [(file, text.encode()) for file, text in texts]
    target = Path(folder)
    if not (target / name).exists() or (target / name).read_bytes() != bytes(opened):
        files.append((name, bytes(opened)))
    written = _write(target, files, overwrite)
    _admire.trust(os.fspath(folder))
    return written


def _write(folder: Path, files: list[tuple[str, bytes]], overwrite: bool) -> list[str]:
    paths = [folder / name for name, _ in files]
    taken = [str(path) for path in paths if path.exists()]
    if taken and not overwrite:
        raise FileExistsError(f"nothing is written, because overwrite is false and these files exist: {', '.join(taken)}")
    for path, (_, raw) in zip(paths, files):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(raw)
    return [str(path) for path in paths]
