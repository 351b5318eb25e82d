"""Studies: stiffnesses from measurements, faults of a model, and design to a target."""

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
    """Study folder: a deck, load cases and measurements."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self._inner = _admire.Study.open(os.fspath(folder))

    @property
    def folder(self) -> str:
        """Path of the study folder."""
        return os.fspath(self._inner.folder())

    @property
    def complaints(self) -> list[Complaint]:
        """Warnings and notes about the files of the study."""
        return complaints_of(self._inner.complaints())

    @property
    def deck(self) -> Deck:
        """Deck of the study, read from its file."""
        return read(self._inner.deck())

    def tune(
        self,
        *,
        restarts: int | None = None,
        draws: int | None = None,
        pareto: tuple[str | int, str | int] | None = None,
        progress: Progress = False,
    ) -> "Tuning":
        """Change numbers of the deck until its K&C characteristics meet ``[target]``; see :func:`tune`."""
        return tune(self, restarts=restarts, draws=draws, pareto=pareto, progress=progress)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Study, (self.folder,))

    def __repr__(self) -> str:
        return f"<admire.Study: {self.folder}>"


@dataclass(frozen=True)
class Repeated:
    """Distribution of a parameter by bootstrap or posterior, in its unit. ``interval95`` is from the 2.5 to the 97.5 percent quantile.

    ``width_ratio`` is the width of this interval relative to the profile-likelihood interval, both of ln K. ``effective_draws`` and
    ``r_hat`` (1 if the chains agree) exist only for a posterior.
    """

    median: float
    std_error: float
    interval95: tuple[float, float]
    width_ratio: float | None
    effective_draws: float | None = None
    r_hat: float | None = None


@dataclass(frozen=True)
class Parameter:
    """Identified parameter in the deck's units (KT per radian). An end of ``interval95`` without a bound is ``None``.

    ``form`` is ``change`` or ``factor`` if the unknown is a common change or factor of numbers in the deck, otherwise ``None``.
    ``numbers`` then maps the address of each number to its values before and after. ``profile95`` is the profile-likelihood interval if
    the fit was repeated. ``bootstrap`` and ``posterior`` are the results of the repetitions.
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
    """Identified stiffnesses of a study with their uncertainty. ``json`` is ``identification.json``. Jupyter shows the report.

    ``bootstrap`` and ``posterior`` have one row for each fit or draw, and one column for each of ``parameters``, in their units. A failed
    fit is a row of NaN. The draws are ordered by chain: 8 chains of the same length.
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
        """Return the parameter at an address."""
        for parameter in self.parameters:
            if address == parameter.address or address in parameter.tied:
                return parameter
        raise KeyError(address)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with one row for each parameter. The column ``unit`` and ``attrs["units"]`` contain the units."""
        pd = needed("pandas", "to_pandas", "pandas")
        rows = [vars(parameter) for parameter in self.parameters]
        found: "pandas.DataFrame" = pd.DataFrame(rows).set_index("address")
        found.attrs["units"] = {parameter.address: parameter.unit for parameter in self.parameters}
        return found

    def plot(self, *, ax: Any = None) -> Any:
        """Plot the identified parameters with their 95 percent intervals, relative to their start values.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to plot into; a new one by default.

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
    """Alternative explanation that the readings do not exclude. ``bic_behind`` is twice the log posterior odds of the finding against it."""

    cause: str
    address: str
    probability: float
    bic_behind: float


@dataclass(frozen=True)
class Finding:
    """Fault of a model: its cause, place, probability and size, and the gain of correcting it.

    ``group_probability`` is the probability that this cause or one of ``indistinguishable_from`` acts.
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
    """Faults of a model that remain after its best fit. ``verdict`` is ``consistent``, ``discrepancy`` or ``unexplained``.

    ``deck`` is the deck extended by the causes. ``commands`` is the command file that runs the extended deck on any ADAMS. ``json`` is
    ``diagnosis.json``. Jupyter shows the report.
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
        """Return a frame with one row for each finding."""
        pd = needed("pandas", "to_pandas", "pandas")
        rows = [
            {"cause": f.cause, "address": f.address, "probability": f.probability, "minor": f.minor, **f.parameters}
            for f in self.findings
        ]
        table: "pandas.DataFrame" = pd.DataFrame(rows)
        return table

    def plot(self, *, ax: Any = None) -> Any:
        """Plot the probability of each finding, and the probability that none of the known causes acts.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to plot into; a new one by default.

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
    """Measurement that could be added, and its expected effect.

    ``kind`` is ``load``, ``repeat``, ``loop``, ``mark``, ``curve`` or ``load-cell``. ``cases`` contains its load cases by the columns of
    the study, and is empty for an instrument. With this measurement, ``sd_log`` contains the standard deviation of each of
    ``Plan.combinations``, ``curves`` that of the predicted wheel, and ``causes`` the effect on the choice between two undecided causes.
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
    """Recommended measurements: ``candidates``, the best first. ``json`` is ``plan.json``.

    ``combinations`` are the worst-determined combinations of ln K, each a mapping of addresses to shares. ``sd_log`` contains their
    standard deviations. ``suggested`` contains the load cases of the first candidates as rows to append to the study's load case file.
    """

    aim: str
    combinations: list[Mapping[str, float]]
    sd_log: list[float]
    candidates: list[Candidate]
    suggested: str = field(repr=False)
    json: dict[str, Any] = field(repr=False)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a frame with one row for each candidate. ``fall_K1`` is the relative decrease of the first standard deviation."""
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
            Axes to plot into; a new one by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        first = self.candidates[:count]
        return plot_bars([found.what for found in first], [found.score for found in first], None, "score", ax)


@dataclass(frozen=True)
class TunedNumber:
    """Unknown of a search for a target. ``form`` states whether its values are changes, factors or values, in ``unit``.

    ``at_bound`` is ``lower`` or ``upper`` if the result is at this bound. ``numbers`` maps the address of each changed number of the deck
    to its values before and after.
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
    """Goal of a search: its deviations before and after in ``unit``, and whether it is met.

    ``at`` contains the values of the test's variable in ``at_unit``. At these values, ``before`` and ``after`` are the characteristic of
    the deck and of the tuned deck, and ``least`` and ``most`` its limits. The limits are equal for a wanted value, and infinite if there
    is none. ``share`` is the share of axles within the tolerances of the study that meet the goal, by the linear model.
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
    """Result of a search for a target: changed numbers and goals. ``json`` is ``tuning.json``. Jupyter shows the report.

    ``agreeing`` is the number of start points whose result is as good as the best. ``front`` has one row for each point of the requested
    Pareto front: the deviations of both goals. ``share`` and ``share_drawn`` are the shares of axles within the tolerances of the study
    that meet all goals, by the linear model and by solving drawn axles.
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
        """Return a frame with one row for each unknown; the column ``unit`` contains its unit."""
        pd = needed("pandas", "to_pandas", "pandas")
        keys = ("name", "form", "unit", "start", "value", "at_bound")
        rows = [{key: getattr(unknown, key) for key in keys} for unknown in self.unknowns]
        table: "pandas.DataFrame" = pd.DataFrame(rows).set_index("name")
        return table

    def plot(self, goal: int | str = 0, *, ax: Any = None) -> Any:
        """Plot the curve of a goal before and after the search, with its limits.

        Parameters
        ----------
        goal : int or str
            Index of the goal, from 0, or its name.
        ax : matplotlib.axes.Axes, optional
            Axes to plot into; a new one by default.

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
    """Identify the stiffnesses of a study, as ``admire identify`` does, without writing files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    method : str, optional
        ``gauss-newton``, ``regression`` or ``direct``, instead of the study's own method.
    bootstrap : int, optional
        Number of fits to readings drawn from the fit and its residuals. The intervals do not rely on the stated noise.
    posterior : int, optional
        Number of draws from the posterior. The intervals do not assume a linear model. Bootstrap and posterior need ``gauss-newton``
        and the built-in solver.
    seed : int
        Seed of the random numbers.
    jobs : int, optional
        Number of parallel threads; by default, one for each core.
    progress : bool or callable
        Show a line on standard error, or call a function with the stage, a detail, the count and the total.
    force : bool
        Fit the study even if it is implausible.
    allow_command : bool
        Start the external program that the study names. This permission is not needed for a study that ``admire new`` created here,
        or for a program that was allowed before.

    Returns
    -------
    Identification
        Results identical to those of ``admire identify --bootstrap N --posterior N``.

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
    """Diagnose the faults of a model that remain after its best fit, as ``admire diagnose`` does, without writing files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    check_gain : str
        Method for measuring the gain of the causes in held-out load cases: ``quick``, ``held-out`` or ``folds``.
    progress, force, allow_command
        See :func:`identify`.

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
    """Rank measurements that could be added to a study by their expected gain, as ``admire plan`` does, without writing files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder. The plan is computed by the built-in solver, even if the study names another solver.
    aim : str
        ``stiffnesses``, ``curves``, ``causes`` or ``all``; the last two take as long as a diagnosis.
    count : int
        Number of candidates whose load cases are listed in ``suggested``.
    progress, force
        See :func:`identify`.

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
    """Change numbers of a deck until its K&C characteristics meet ``[target]``, as ``admire tune`` does, without writing files.

    Parameters
    ----------
    study : Study or path
        The study, or its folder.
    restarts : int, optional
        Number of further start points within the bounds, instead of the study's own number.
    draws : int, optional
        Number of axles to solve with drawn tolerances, instead of the study's own number; 0 solves none.
    pareto : pair of str or int, optional
        Two goals whose Pareto front is computed, by name or by number (from 1, as in ``admire tune``).
    progress : bool or callable
        See :func:`identify`.

    Returns
    -------
    Tuning

    Raises
    ------
    DeckError
        If the study has errors or no target.
    SolveError
        If the axle has no equilibrium at any start point.
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
    """Run the standard K&C tests on the axle of a deck, given as a deck or its path; see :meth:`Deck.kc`."""
    opened = deck if isinstance(deck, Deck) else read(deck)
    return opened.kc(config, convention=convention, compare=compare, measured=measured)
