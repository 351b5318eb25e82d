"""Studies: stiffnesses from measurements, what a model gets wrong, and design to a target."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _admire
from ._axle import AxleTests, framed
from ._deck import Deck, read
from ._errors import Complaint, complaints_of
from ._frames import axes_for, needed, plot_bars
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

    def tune(
        self,
        *,
        restarts: int | None = None,
        draws: int | None = None,
        pareto: tuple[str | int, str | int] | None = None,
        progress: Progress = False,
    ) -> "Tuning":
        """Change numbers of the deck until its K&C characteristics are those of ``[target]``: :func:`tune` of this study."""
        return tune(self, restarts=restarts, draws=draws, pareto=pareto, progress=progress)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Study, (self.folder,))

    def __repr__(self) -> str:
        return f"<admire.Study: {self.folder}>"


@dataclass(frozen=True)
class Repeated:
    """What a bootstrap or a posterior says of a number, in its unit. ``interval95`` holds 2.5 to 97.5 percent of all values.

    ``width_ratio`` is its width over that of the interval by profile likelihood, both of ln K. ``effective_draws`` and ``r_hat`` (one
    where the chains agree) are those of a posterior.
    """

    median: float
    std_error: float
    interval95: tuple[float, float]
    width_ratio: float | None
    effective_draws: float | None = None
    r_hat: float | None = None


@dataclass(frozen=True)
class Parameter:
    """An identified number, in the deck's units (KT per radian). A side of ``interval95`` without a bound is ``None``.

    ``form`` is ``change`` or ``factor`` if that of numbers in the deck is identified, and ``None`` for a number itself. ``numbers`` then maps
    each address to its values before and after. ``profile95`` is the interval by profile likelihood if the fit was repeated, ``bootstrap``
    and ``posterior`` are the intervals of the repetitions.
    """

    address: str
    unit: str
    initial: float
    value: float
    std_error: float | None
    interval95: tuple[float | None, float | None]
    status: str
    tied: tuple[str, ...] = ()
    profile95: tuple[float | None, float | None] | None = None
    bootstrap: Repeated | None = None
    posterior: Repeated | None = None
    form: str | None = None
    numbers: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Identification:
    """The stiffnesses of a study with their uncertainty. ``json`` is ``identification.json``; in Jupyter the report is shown.

    ``bootstrap`` and ``posterior`` hold a row for each fit or draw, a column for each of ``parameters``, in their units. A fit without an
    answer is a row of NaN; draws stand chain after chain, 8 of the same length.
    """

    parameters: list[Parameter]
    method: str
    converged: bool
    summary: str
    deck: Deck = field(repr=False)
    json: dict[str, Any] = field(repr=False)
    html: str = field(repr=False)
    remarks: list[str] = field(repr=False, default_factory=list)
    bootstrap: NDArray[np.float64] | None = field(repr=False, default=None, compare=False)
    posterior: NDArray[np.float64] | None = field(repr=False, default=None, compare=False)

    def __getitem__(self, address: str) -> Parameter:
        """The number at an address."""
        for parameter in self.parameters:
            if address == parameter.address or address in parameter.tied:
                return parameter
        raise KeyError(address)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with a row for each number; the column ``unit`` and ``attrs["units"]`` state the units."""
        pd = needed("pandas", "to_pandas", "pandas")
        rows = [vars(parameter) for parameter in self.parameters]
        found: "pandas.DataFrame" = pd.DataFrame(rows).set_index("address")
        found.attrs["units"] = {parameter.address: parameter.unit for parameter in self.parameters}
        return found

    def plot(self, *, ax: Any = None) -> Any:
        """Plot the identified numbers with their 95 percent intervals, each over its start value.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ImportError
            If matplotlib is not installed.
        """
        shown = [own for own in self.parameters if own.initial and own.form != "change"]
        values = [parameter.value / parameter.initial for parameter in shown]

        def error(parameter: Parameter, side: int) -> float:
            bound = parameter.interval95[side]
            return 0.0 if bound is None else abs((bound - parameter.value) / parameter.initial)

        errors = [(error(parameter, 0), error(parameter, 1)) for parameter in shown]
        names = [parameter.address for parameter in shown]
        own = plot_bars(names, values, errors, "identified / start value", ax)
        own.axvline(1.0, color="grey", linewidth=0.8)
        return own

    def _ipython_key_completions_(self) -> list[str]:
        return [parameter.address for parameter in self.parameters]

    def _repr_html_(self) -> str:
        return framed(self.html)


@dataclass(frozen=True)
class Rival:
    """Another explanation that does as well: its probability; ``bic_behind`` is twice the logarithm by which its model is less probable."""

    cause: str
    address: str
    probability: float
    bic_behind: float


@dataclass(frozen=True)
class Finding:
    """One thing that a model gets wrong: the cause, its place, its probability and size, and what mending it gains.

    ``group_probability`` is the probability that this cause acts or one of ``indistinguishable_from`` does.
    """

    cause: str
    address: str
    probability: float
    group_probability: float
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
        """Return a frame with a row for each finding."""
        pd = needed("pandas", "to_pandas", "pandas")
        rows = [
            {"cause": f.cause, "address": f.address, "probability": f.probability, "minor": f.minor, **f.parameters}
            for f in self.findings
        ]
        table: "pandas.DataFrame" = pd.DataFrame(rows)
        return table

    def plot(self, *, ax: Any = None) -> Any:
        """Plot the probability of each finding, and that of none of the known causes.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot.

        Returns
        -------
        matplotlib.axes.Axes
        """
        names = [f"{found.cause} {found.address}" for found in self.findings] + ["none of these"]
        values = [found.probability for found in self.findings] + [self.none_of_these]
        own = plot_bars(names, values, None, "probability", ax)
        own.set_xlim(0.0, 1.0)
        return own

    def _repr_html_(self) -> str:
        return framed(self.html)


@dataclass(frozen=True)
class Candidate:
    """A measurement that could be added, and what it would do.

    ``kind`` is ``load``, ``repeat``, ``loop``, ``mark``, ``curve`` or ``load-cell``; ``cases`` holds its load cases by the columns of the
    study, none for an instrument. ``sd_log`` has the standard deviation of each of ``Plan.combinations`` with it, ``curves`` that of
    the predicted wheel, ``causes`` what it would say of two explanations that are undecided.
    """

    kind: str
    what: str
    cases: tuple[Mapping[str, float], ...]
    score: float
    information: float | None
    sd_log: tuple[float, ...]
    curves: Mapping[str, float] | None = None
    causes: Mapping[str, float] | None = None


@dataclass(frozen=True)
class Plan:
    """What to measure next: ``candidates``, the best first. ``json`` is ``plan.json``.

    ``combinations`` are the worst-determined combinations of ln K, each a mapping of addresses to shares with its standard deviation
    in ``sd_log``. ``suggested`` holds load cases among the first candidates as rows for the end of the study's own table.
    """

    aim: str
    combinations: list[Mapping[str, float]]
    sd_log: list[float]
    candidates: list[Candidate]
    suggested: str = field(repr=False)
    json: dict[str, Any] = field(repr=False)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with a row for each candidate; ``fall_K1`` is the part by which the first standard deviation falls."""
        pd = needed("pandas", "to_pandas", "pandas")

        def row(found: Candidate) -> dict[str, Any]:
            falls = {f"fall_K{k + 1}": 1 - after / before for k, (before, after) in enumerate(zip(self.sd_log, found.sd_log))}
            return {"kind": found.kind, "what": found.what, "score": found.score, "information": found.information, **falls}

        table: "pandas.DataFrame" = pd.DataFrame([row(found) for found in self.candidates])
        return table

    def plot(self, *, count: int = 10, ax: Any = None) -> Any:
        """Plot the scores of the first candidates.

        Parameters
        ----------
        count : int
            Number of candidates.
        ax : matplotlib.axes.Axes, optional
            Where to plot.

        Returns
        -------
        matplotlib.axes.Axes
        """
        first = self.candidates[:count]
        return plot_bars([found.what for found in first], [found.score for found in first], None, "score", ax)


@dataclass(frozen=True)
class TunedNumber:
    """An unknown of a search for a target. ``form`` says whether its values are changes, factors or values, in ``unit``.

    ``at_bound`` is ``lower`` or ``upper`` if the bound stops the search there. ``numbers`` holds the address of each number of the deck
    that it sets, with its value before and after.
    """

    name: str
    form: str
    unit: str
    start: float
    value: float
    bounds: tuple[float, float]
    at_bound: str | None
    numbers: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class TunedGoal:
    """A goal of a search: its misses before and after in ``unit``, and whether it is met.

    ``at`` holds the values of the test's variable in ``at_unit``; ``before``, ``after``, ``least`` and ``most`` the characteristic of the
    deck, of the tuned deck and its limits there. ``least`` and ``most`` are equal where one value is wanted, and infinite without a limit.
    ``share`` is the share of axles that meet the goal if they differ by the tolerances of the study, of the linear model.
    """

    name: str
    unit: str
    at_unit: str
    tolerance: float
    rms_before: float
    rms_after: float
    largest_after: float
    is_met: bool
    at: NDArray[np.float64] = field(repr=False, compare=False)
    before: NDArray[np.float64] = field(repr=False, compare=False)
    after: NDArray[np.float64] = field(repr=False, compare=False)
    least: NDArray[np.float64] = field(repr=False, compare=False)
    most: NDArray[np.float64] = field(repr=False, compare=False)
    share: float | None = None


@dataclass(frozen=True)
class Tuning:
    """A deck with the wanted characteristics: what moved and what is met. ``json`` is ``tuning.json``; in Jupyter the report is shown.

    ``agreeing`` is the number of starts whose end is as good as the best. ``front`` holds a row for each point of the Pareto front that was
    asked for: the misses of both goals. ``share`` and ``share_drawn`` are the shares of axles that meet all goals with the tolerances of
    the study, by the linear model and by axles that were drawn and solved.
    """

    unknowns: list[TunedNumber]
    goals: list[TunedGoal]
    converged: bool
    met: bool
    agreeing: int
    summary: str
    deck: Deck = field(repr=False)
    json: dict[str, Any] = field(repr=False)
    html: str = field(repr=False)
    front: NDArray[np.float64] | None = field(repr=False, default=None, compare=False)
    share: float | None = None
    share_drawn: float | None = None

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with a row for each unknown; the column ``unit`` states its unit."""
        pd = needed("pandas", "to_pandas", "pandas")
        keys = ("name", "form", "unit", "start", "value", "at_bound")
        rows = [{key: getattr(unknown, key) for key in keys} for unknown in self.unknowns]
        table: "pandas.DataFrame" = pd.DataFrame(rows).set_index("name")
        return table

    def plot(self, goal: int | str = 0, *, ax: Any = None) -> Any:
        """Plot the curve of a goal before and after, with what is wanted.

        Parameters
        ----------
        goal : int or str
            Place of the goal, from 0 on, or its name.
        ax : matplotlib.axes.Axes, optional
            Where to plot.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        KeyError
            If no goal has this name.
        ImportError
            If matplotlib is not installed.
        """
        if isinstance(goal, str):
            named = [own for own in self.goals if own.name == goal]
            if not named:
                raise KeyError(goal)
            found = named[0]
        else:
            found = self.goals[goal]
        own = axes_for(1, ax, "plot")[0]
        own.plot(found.at, found.before, label="before", marker=".")
        own.plot(found.at, found.after, label="tuned", marker=".")
        for limit in (found.least, found.most):
            if np.isfinite(limit).all():
                own.plot(found.at, limit, color="grey", linestyle="--")
            if (found.least == found.most).all():
                break
        own.set_xlabel(f"[{found.at_unit}]")
        own.set_ylabel(f"{found.name} [{found.unit}]")
        own.legend()
        return own

    def _repr_html_(self) -> str:
        return framed(self.html)


def _opened(study: Study | str | os.PathLike[str]) -> Study:
    opened = study if isinstance(study, Study) else Study(study)
    command = opened._inner.starts_program()
    if command:
        warnings.warn(f"the program named in study.toml solves every equilibrium: {command}", stacklevel=3)
    return opened


def identify(
    study: Study | str | os.PathLike[str],
    *,
    method: str | None = None,
    bootstrap: int | None = None,
    posterior: int | None = None,
    seed: int = 0,
    jobs: int | None = None,
    progress: Progress = False,
    force: bool = False,
    allow_command: bool = False,
) -> Identification:
    """Identify the stiffnesses of a study: what ``admire identify`` does, without files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    method : str, optional
        ``gauss-newton``, ``regression`` or ``direct``, in place of the study's own.
    bootstrap : int, optional
        Number of fits to readings drawn anew from the fit and its residuals: intervals that do not take the noise as stated.
    posterior : int, optional
        Number of draws from the posterior: intervals that do not take the model as linear. Both are for ``gauss-newton`` and the
        built-in solver.
    seed : int
        Another seed gives other random numbers.
    jobs : int, optional
        Number of fits at a time; as many as there are cores if absent.
    progress : bool or callable
        Show a line on standard error, or call a function with stage, remark, count and total.
    force : bool
        Fit an implausible study, too.
    allow_command : bool
        Start the program that a study of somebody else names. One of a study that ``admire new`` began here, or that was allowed
        once, is started anyway.

    Returns
    -------
    Identification
        The answers of ``admire identify --bootstrap N --posterior N``, bit for bit.

    Raises
    ------
    DeckError
        If the study has errors.
    SolveError
        If there is no equilibrium or no fit.

    Examples
    --------
    >>> import admire
    >>> found = admire.identify("corpus/pseudo-mcpherson", method="direct")
    >>> found["BUSHING/1.K.1"].unit
    'newton/mm'
    """
    opened = _opened(study)
    with shown(progress) as observer:
        text, lead, deck, html, remarks, tables = opened._inner.identify(
            method, force, (bootstrap, posterior, seed, jobs), observer, allow_command
        )
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
            tuple(item["profile95"]) if "profile95" in item else None,
            _repeated(item.get("bootstrap")),
            _repeated(item.get("posterior")),
            item.get("form"),
            {own["address"]: (own["before"], own["after"]) for own in item.get("numbers", ())},
        )
        for item in value["parameters"]
    ]
    name = os.path.join(opened.folder, "identified.adm")
    answer = Deck(_admire.Deck.parse(name, deck))
    made = [None if table is None else np.asarray(table, dtype=np.float64) for table in tables]
    return Identification(
        parameters, value["method"], value["converged"], lead, answer, value, html, remarks, *made
    )


def _repeated(item: Mapping[str, Any] | None) -> Repeated | None:
    if item is None:
        return None
    return Repeated(**{**item, "interval95": tuple(item["interval95"])})


def diagnose(
    study: Study | str | os.PathLike[str],
    *,
    check_gain: str = "held-out",
    progress: Progress = False,
    force: bool = False,
    allow_command: bool = False,
) -> Diagnosis:
    """Say what a model still gets wrong after its best fit: what ``admire diagnose`` does, without files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    check_gain : str
        How much is done to learn what the causes gain in cases that were not used: ``quick``, ``held-out`` or ``folds``.
    progress, force, allow_command
        As of :func:`identify`.

    Returns
    -------
    Diagnosis
    """
    opened = _opened(study)
    with shown(progress) as observer:
        text, sentences, deck, commands, html, remarks = opened._inner.diagnose(force, check_gain, observer, allow_command)
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
        item["group_probability"],
        item["parameters"],
        item["std_error"],
        item["minor"],
        item["evidence"],
        item["gain"],
        tuple(Rival(**rival) for rival in item["indistinguishable_from"]),
        tuple(item.get("members", ())),
        item.get("form"),
    )


def plan(
    study: Study | str | os.PathLike[str],
    *,
    aim: str = "all",
    count: int = 10,
    progress: Progress = False,
    force: bool = False,
) -> Plan:
    """Rank measurements that could be added to a study by what each would gain: what ``admire plan`` does, without files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder. The built-in solver plans, whatever the study names.
    aim : str
        ``stiffnesses``, ``curves``, ``causes`` or ``all``; the last two take as long as a diagnosis.
    count : int
        Number of candidates among which load cases are ``suggested``.
    progress, force
        As of :func:`identify`.

    Returns
    -------
    Plan

    Examples
    --------
    >>> import admire
    >>> found = admire.plan("corpus/pseudo-mcpherson", aim="stiffnesses")
    >>> found.candidates[0].sd_log[0] < found.sd_log[0]
    True
    """
    opened = study if isinstance(study, Study) else Study(study)
    with shown(progress) as observer:
        text, suggested = opened._inner.plan(aim, count, force, observer)
    value = json.loads(text)
    candidates = [
        Candidate(
            item["kind"],
            item["what"],
            tuple(item["cases"]),
            item["score"],
            item["information"],
            tuple(item["sd_log"]),
            item["curves"],
            item["causes"],
        )
        for item in value["candidates"]
    ]
    combinations = value["combinations"]
    return Plan(
        value["aim"],
        [item["combination"] for item in combinations],
        [item["sd_log"] for item in combinations],
        candidates,
        suggested,
        value,
    )


def tune(
    study: Study | str | os.PathLike[str],
    *,
    restarts: int | None = None,
    draws: int | None = None,
    pareto: tuple[str | int, str | int] | None = None,
    progress: Progress = False,
) -> Tuning:
    """Change numbers of a deck until its K&C characteristics are those of ``[target]``: what ``admire tune`` does, without files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    restarts : int, optional
        Number of further starts within the bounds, in place of the study's own.
    draws : int, optional
        Number of axles to draw with the tolerances of the study, in place of the study's own; 0 draws none.
    pareto : pair of str or int, optional
        Two goals whose Pareto front is sought, by their names or by their numbers as ``admire tune`` counts them, from 1 on.
    progress : bool or callable
        As of :func:`identify`.

    Returns
    -------
    Tuning

    Raises
    ------
    DeckError
        If the study has errors or no target.
    SolveError
        If the axle has no equilibrium at any start.
    AdmireError
        If ``pareto`` names no goal.

    Examples
    --------
    >>> import admire
    >>> found = admire.tune("corpus/double-wishbone", restarts=0)
    >>> found.met, found.goals[0].name
    (True, 'bounce toe_angle.left')
    """
    opened = study if isinstance(study, Study) else Study(study)
    pair = None if pareto is None else (str(pareto[0]), str(pareto[1]))
    with shown(progress) as observer:
        text, summary, deck, html = opened._inner.tune(restarts, draws, pair, observer)
    value = json.loads(text)
    robust = value.get("robust")
    shares: list[float | None] = [None] * len(value["goals"])
    if robust is not None:
        shares = [goal["share"] for goal in robust["goals"]]
    drawn = None if robust is None else robust["drawn"]
    front = value.get("pareto")
    return Tuning(
        [_tuned_number(item) for item in value["unknowns"]],
        [_tuned_goal(item, share) for item, share in zip(value["goals"], shares)],
        value["converged"],
        value["met"],
        value["agreeing"],
        summary,
        Deck(_admire.Deck.parse(os.path.join(opened.folder, "tuned.adm"), deck)),
        value,
        html,
        None if front is None else np.array([point["misses"] for point in front["points"]], dtype=np.float64),
        None if robust is None else robust["share"],
        None if drawn is None else drawn["share"],
    )


def _tuned_number(item: Mapping[str, Any]) -> TunedNumber:
    return TunedNumber(
        item["name"],
        item["form"],
        item["unit"],
        item["start"],
        item["value"],
        (item["bounds"][0], item["bounds"][1]),
        item["at_bound"],
        {number["address"]: (number["before"], number["after"]) for number in item["numbers"]},
    )


def _tuned_goal(item: Mapping[str, Any], share: float | None) -> TunedGoal:
    def column(key: str, without: float) -> NDArray[np.float64]:
        return np.array([without if row[key] is None else row[key] for row in item["rows"]], dtype=np.float64)

    return TunedGoal(
        item["name"],
        item["unit"],
        item["at_unit"],
        item["tolerance"],
        item["rms_before"],
        item["rms_after"],
        item["largest_after"],
        item["is_met"],
        column("at", np.nan),
        column("before", np.nan),
        column("after", np.nan),
        column("least", -np.inf),
        column("most", np.inf),
        share,
    )


def kc(
    deck: Deck | str | os.PathLike[str],
    config: str | os.PathLike[str] = "kc.toml",
    *,
    convention: str = "adams-car",
    compare: Deck | Iterable[Deck] | Mapping[str, Deck] = (),
    measured: str | os.PathLike[str] | None = None,
) -> AxleTests:
    """Drives an axle through the standard K&C tests: :meth:`Deck.kc` of a deck or its path."""
    opened = deck if isinstance(deck, Deck) else read(deck)
    return opened.kc(config, convention=convention, compare=compare, measured=measured)
