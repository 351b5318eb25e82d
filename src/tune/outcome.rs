use serde::Serialize;

use crate::analysis::{self, Conflict};
use crate::answers::Answers;
use crate::cost::largest_reach;
use crate::evaluation::{Evaluation, Evaluator};
use crate::found::Found;
use crate::front::Front;
use crate::goal::GoalKind;
use crate::robust::Robust;
use crate::settings::{AGREEING_COST, AGREEING_SHARE, AT_BOUND, LIMIT_SLACK};
use crate::tune_error::TuneError;
use crate::tuning::Tuning;
use admire_identify::DeckUnknown;
use admire_kc::BenchError;
use admire_study::{GoalScope, UnknownForm};

/// A number of the deck that was changed.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NumberOutcome {
    /// Address of the number.
    pub address: String,
    /// Value in the deck of the study, in units of the deck and radians.
    pub before: f64,
    /// Value in the tuned deck, in units of the deck and radians.
    pub after: f64,
}

/// An unknown at the end of a search. `form` states whether its values are changes, factors or the numbers themselves. Angles are in
/// radians.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct UnknownOutcome {
    /// Name of the unknown.
    pub name: String,
    /// `change`, `factor` or `value`.
    pub form: &'static str,
    /// Unit of the values; empty if they have none.
    pub unit: String,
    /// Value at which the search began.
    pub start: f64,
    /// Value found.
    pub value: f64,
    /// Lower and upper bound.
    pub bounds: [f64; 2],
    /// `lower` or `upper` if this bound stops the search; `None` otherwise.
    pub at_bound: Option<&'static str>,
    /// Decrease of the cost per unit by which the bound is moved outward; zero if no bound stops the search.
    pub pull: f64,
    /// Share of this unknown in the changes of the goals' values: the size of the changes that its own move causes, in the linear model. The
    /// shares of all unknowns add up to 1.
    pub matters: f64,
    /// True if the solver computes the derivatives with respect to this unknown; false if they are finite differences.
    pub exact_derivatives: bool,
    /// Numbers of the deck that the unknown sets.
    pub numbers: Vec<NumberOutcome>,
}

/// A value that a goal compares, in the unit of the goal.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RowOutcome {
    /// Value of the test's variable.
    pub at: f64,
    /// Lower limit of the wanted value; `None` without a limit.
    pub least: Option<f64>,
    /// Upper limit of the wanted value; `None` without a limit.
    pub most: Option<f64>,
    /// Value in the deck of the study.
    pub before: f64,
    /// Value in the tuned deck.
    pub after: f64,
}

/// A goal at the end of a search.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct GoalOutcome {
    /// Name: test or load case, characteristic, and part of the characteristic.
    pub name: String,
    /// Name of the test; empty if the goal reads a load case.
    pub test: String,
    /// Label of the load case; `None` if the goal reads a test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// Name of the characteristic, force, position or reading.
    pub of: String,
    /// Part of the characteristic: `curve`, `value` or `gradient`.
    pub scope: &'static str,
    /// Kind of the goal: `squares`, `minimax` or `limit`.
    pub kind: &'static str,
    /// Unit of the values, of the misses and of the tolerance.
    pub unit: String,
    /// Unit of the test's variable.
    pub at_unit: String,
    /// Largest miss at which the goal counts as met. For a limit, only the unit in which misses are counted.
    pub tolerance: f64,
    /// Root mean square of the misses in the deck of the study.
    pub rms_before: f64,
    /// Root mean square of the misses in the tuned deck.
    pub rms_after: f64,
    /// Largest miss in the tuned deck.
    pub largest_after: f64,
    /// True if no miss exceeds the tolerance or, for a limit, a thousandth of the tolerance. In a robust target, the misses include two
    /// standard deviations.
    pub is_met: bool,
    /// Sum of the multipliers of a limit or minimax goal: a measure of how strongly the goal restricts the others. Zero if the goal does
    /// not restrict them.
    pub multiplier: f64,
    /// True if the solver computes the derivatives of the values; false if they are finite differences.
    pub exact_derivatives: bool,
    /// Change of the goal's value per unit of each unknown, or per percent of a factor, in the order of the unknowns. For a single value, the
    /// sign is kept. For a curve, it is the root mean square of the changes of its rows.
    pub sensitivities: Vec<f64>,
    /// The compared values.
    pub rows: Vec<RowOutcome>,
}

/// A search from one start.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct StartOutcome {
    /// Values of the unknowns at the start.
    pub start: Vec<f64>,
    /// Values of the unknowns at the end.
    pub end: Vec<f64>,
    /// Cost at the end; `None` without an equilibrium at the start.
    pub cost: Option<f64>,
    /// Largest miss of any limit, in units of the tolerance of that limit.
    pub violation: f64,
    /// Number of evaluations with derivatives.
    pub evaluations: usize,
    /// True if this search converged.
    pub converged: bool,
    /// True if all goals are met at the end.
    pub met: bool,
    /// True if the end is as good as that of the best search.
    pub agrees: bool,
}

/// Result of a search, as written to `tuning.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// True if the best search converged.
    pub converged: bool,
    /// True if all goals are met.
    pub met: bool,
    /// Largest miss of any limit, in units of the tolerance of that limit. A value above 0.001 means that no point within the bounds was
    /// found at which all limits hold.
    pub violation: f64,
    /// True if all limits hold: no miss exceeds a thousandth of the tolerance.
    pub keeps_limits: bool,
    /// Cost of the deck of the study.
    pub cost_before: f64,
    /// Cost of the tuned deck.
    pub cost: f64,
    /// Number of evaluations with derivatives, over all starts.
    pub evaluations: usize,
    /// Number of runs of the tests and load cases, including those for finite differences.
    pub runs: usize,
    /// Number of starts from which the search ended as well as from the best one.
    pub agreeing: usize,
    /// Unknowns at the end of the best search.
    pub unknowns: Vec<UnknownOutcome>,
    /// Goals at the end of the best search.
    pub goals: Vec<GoalOutcome>,
    /// Pairs of goals that conflict.
    pub conflicts: Vec<Conflict>,
    /// Searches from all starts; the first begins at the start of the study.
    pub starts: Vec<StartOutcome>,
    /// Effect of the tolerances of the study on the tuned deck; `None` without the section `[tolerances]`, or before [`Tuning::robust`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robust: Option<Robust>,
    /// Pareto front of two goals, if it was requested with [`Tuning::front`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pareto: Option<Front>,
    /// Text of the tuned deck.
    #[serde(skip)]
    pub deck: Vec<u8>,
    /// Coordinates of the unknowns in the tuned deck.
    #[serde(skip)]
    pub x: Vec<f64>,
    /// Results of the tests and load cases on the tuned deck.
    #[serde(skip)]
    pub after: Answers,
}

impl Outcome {
    pub(crate) fn of(
        tuning: &Tuning,
        evaluator: &mut Evaluator<'_>,
        found: Vec<Found>,
    ) -> Result<Self, TuneError> {
        let feasible = |found: &Found| found.violation <= LIMIT_SLACK;
        let rank = |found: &Found| {
            let miss = if feasible(found) {
                0.0
            } else {
                found.violation
            };
            (miss, found.cost)
        };
        let with_end = found.iter().filter(|found| found.end.is_some());
        let best = with_end.min_by(|a, b| {
            let ((m, c), (n, d)) = (rank(a), rank(b));
            m.total_cmp(&n).then(c.total_cmp(&d))
        });
        let nowhere = || TuneError {
            unknowns: shown(tuning, &tuning.start()),
            why: BenchError::Deck(Vec::new()),
        };
        let best = best.ok_or_else(nowhere)?;
        let refuse = |why| TuneError {
            unknowns: shown(tuning, &best.x),
            why,
        };
        let deck = tuning
            .deck(&best.x)
            .map_err(|wrong| refuse(BenchError::Deck(vec![*wrong])))?;
        let end = best.end.as_ref().ok_or_else(nowhere)?;
        let near = AGREEING_COST.max(AGREEING_SHARE * best.cost);
        let agrees =
            |other: &Found| other.cost <= best.cost + near && (feasible(other) || !feasible(best));
        let starts: Vec<StartOutcome> = found
            .iter()
            .map(|own| StartOutcome {
                start: shown(tuning, &own.start),
                end: shown(tuning, &own.x),
                cost: own.end.is_some().then_some(own.cost),
                violation: if own.end.is_some() {
                    own.violation
                } else {
                    0.0
                },
                evaluations: own.evaluations,
                converged: own.is_converged,
                met: own.end.as_ref().is_some_and(|end| tuning.meets(end)),
                agrees: agrees(own),
            })
            .collect();
        let deck_x: Vec<f64> = tuning.unknowns.iter().map(DeckUnknown::deck).collect();
        let before = evaluator.as_it_is().ok_or_else(nowhere)?;
        let gradient = analysis::gradient(tuning, end, &best.pulls, &best.x);
        let matters = analysis::contributions(tuning, end, &best.x);
        let unknowns = tuning.unknowns.iter().enumerate().map(|(k, unknown)| {
            let x = best.x[k];
            let at_bound = stopped(unknown, x, gradient[k]);
            let pull = match at_bound {
                Some(_) => gradient[k].abs() / unknown.shown_rate(x),
                None => 0.0,
            };
            UnknownOutcome {
                name: unknown.name.clone(),
                form: unknown.form.word(),
                unit: match unknown.form {
                    UnknownForm::Factor => String::new(),
                    _ => tuning.model.units.name(unknown.dimension),
                },
                start: unknown.shown(unknown.start),
                value: unknown.shown(x),
                bounds: unknown.bounds.map(|bound| unknown.shown(bound)),
                at_bound,
                pull,
                matters: matters[k],
                exact_derivatives: evaluator.is_exact[k],
                numbers: numbers(unknown, &deck),
            }
        });
        Ok(Self {
            converged: best.is_converged,
            met: tuning.meets(end),
            violation: best.violation,
            keeps_limits: feasible(best),
            cost_before: tuning.cost(&before, &deck_x),
            cost: best.cost,
            evaluations: found.iter().map(|own| own.evaluations).sum(),
            runs: evaluator.runs,
            agreeing: starts.iter().filter(|start| start.agrees).count(),
            unknowns: unknowns.collect(),
            goals: goals(tuning, &before.values, best, end),
            conflicts: analysis::conflicts(tuning, end, &best.x),
            starts,
            robust: None,
            pareto: None,
            deck: deck.bytes().to_vec(),
            x: best.x.clone(),
            after: end.answers.clone(),
        })
    }
}

fn shown(tuning: &Tuning, x: &[f64]) -> Vec<f64> {
    let each = tuning.unknowns.iter().zip(x);
    each.map(|(unknown, x)| unknown.shown(*x)).collect()
}

/// Returns the bound that stops an unknown. The unknown lies at this bound, and the cost would decrease beyond it.
fn stopped(unknown: &DeckUnknown, x: f64, gradient: f64) -> Option<&'static str> {
    let [least, most] = unknown.bounds;
    let near = AT_BOUND * (most - least);
    if x <= least + near && gradient > 0.0 {
        Some("lower")
    } else if x >= most - near && gradient < 0.0 {
        Some("upper")
    } else {
        None
    }
}

fn numbers(unknown: &DeckUnknown, deck: &admire_syntax::text::Source) -> Vec<NumberOutcome> {
    let tuned = admire_syntax::Dataset::parse(deck.clone()).value;
    let each = unknown.numbers.iter().map(|number| NumberOutcome {
        address: number.address.to_string(),
        before: number.deck,
        after: tuned.value_at(&number.address).unwrap_or(number.deck),
    });
    each.collect()
}

fn goals(tuning: &Tuning, before: &[f64], best: &Found, end: &Evaluation) -> Vec<GoalOutcome> {
    let mut all = Vec::new();
    for (goal, range) in tuning.ranges() {
        let (old, new) = (&before[range.clone()], &end.values[range.clone()]);
        let rms = |values: &[f64]| {
            let squares = goal.rows.iter().zip(values).map(|(row, value)| {
                let miss = row.miss(*value);
                miss * miss
            });
            (squares.sum::<f64>() / goal.rows.len() as f64).sqrt()
        };
        let largest = goal
            .rows
            .iter()
            .zip(new)
            .map(|(row, value)| row.miss(*value).abs())
            .fold(0.0, f64::max);
        let kind = match goal.kind {
            GoalKind::Squares => "squares",
            GoalKind::Minimax => "minimax",
            GoalKind::Limit => "limit",
        };
        let rows = goal.rows.iter().zip(old).zip(new);
        let finite = |bound: f64| bound.is_finite().then_some(bound);
        all.push(GoalOutcome {
            name: goal.name(),
            test: goal.test.clone(),
            case: goal.case.clone(),
            of: goal.of.clone(),
            scope: match goal.scope {
                GoalScope::Curve => "curve",
                GoalScope::Value => "value",
                GoalScope::Gradient => "gradient",
            },
            kind,
            unit: goal.unit.clone(),
            at_unit: goal.at_unit.clone(),
            tolerance: goal.tolerance,
            rms_before: rms(old),
            rms_after: rms(new),
            largest_after: largest,
            is_met: largest_reach(goal, range.clone(), end) <= goal.allowed(),
            multiplier: best
                .pulls
                .get(range.clone())
                .map_or(0.0, |own| own.iter().sum()),
            exact_derivatives: goal.is_exact,
            sensitivities: analysis::sensitivities(tuning, end, range, &best.x),
            rows: rows
                .map(|((row, before), after)| RowOutcome {
                    at: row.at,
                    least: finite(row.wanted[0]),
                    most: finite(row.wanted[1]),
                    before: *before,
                    after: *after,
                })
                .collect(),
        });
    }
    all
}
