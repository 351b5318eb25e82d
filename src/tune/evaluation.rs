use std::collections::BTreeMap;

use crate::answers::Answers;
use crate::goal::Goal;
use crate::load_cases::Asked as OfCases;
use crate::settings::{DIFFERENCE_STEP, ROBUST_SD};
use crate::tolerance::{Tolerance, tolerances};
use crate::tune_error::has_errors;
use crate::tuning::{Tuning, rewritten};
use admire_identify::DeckUnknown;
use admire_kc::{Bench, BenchError, DeckChange, run};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};
use nalgebra::{DMatrix, RowDVector};

/// Results of the tests and load cases for one set of values of the unknowns.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Coordinates of the unknowns.
    pub x: Vec<f64>,
    /// Results of the tests and load cases.
    pub answers: Answers,
    /// Values of the rows of all goals, in order.
    pub values: Vec<f64>,
    /// Derivatives of the values, one column for each unknown; no columns if they were not requested.
    pub jacobian: DMatrix<f64>,
    /// Standard deviations of the values that result from the tolerances; `None` unless the target is robust.
    pub spread: Option<Spread>,
}

/// Standard deviations of the values that result from the tolerances, in the linear model.
#[derive(Clone, Debug)]
pub struct Spread {
    /// Standard deviation of each value.
    pub sd: Vec<f64>,
    /// Derivatives of the standard deviations, one column for each unknown; no columns if they were not requested.
    pub jacobian: DMatrix<f64>,
}

impl Evaluation {
    /// Returns the margin that a robust target adds to the miss of a row: [`ROBUST_SD`] times the standard deviation of its value. The
    /// margin is zero if the target is not robust.
    pub(crate) fn widening(&self, row: usize) -> f64 {
        let spread = self.spread.as_ref();
        spread.map_or(0.0, |spread| ROBUST_SD * spread.sd[row])
    }

    /// Returns the derivatives of [`Self::widening`] with respect to the unknowns.
    pub(crate) fn widening_change(&self, row: usize) -> RowDVector<f64> {
        match &self.spread {
            Some(spread) => spread.jacobian.row(row) * ROBUST_SD,
            None => RowDVector::zeros(self.jacobian.ncols()),
        }
    }
}

/// Runs the tests and load cases with their derivatives, and counts the runs.
#[derive(Debug)]
pub(crate) struct Evaluator<'a> {
    pub tuning: &'a Tuning,
    /// For each unknown, true if the solver computes its derivatives; otherwise they are finite differences.
    pub is_exact: Vec<bool>,
    /// Number of runs of the tests, including those for finite differences.
    pub runs: usize,
}

/// Linear model of the tolerances of a deck: the values of the tests, and their changes per standard deviation of each tolerance.
#[derive(Debug)]
pub(crate) struct Scatter {
    /// Deck with the numbers of the unknowns.
    pub dataset: Dataset,
    /// Values of the rows of all goals.
    pub values: Vec<f64>,
    /// Tolerances of the car.
    pub tolerances: Vec<Tolerance>,
    /// Change of each value (row) per standard deviation of each tolerance (column).
    pub columns: DMatrix<f64>,
}

impl Scatter {
    /// Returns the standard deviation of each value, in the linear model.
    pub(crate) fn sd(&self) -> Vec<f64> {
        self.columns.row_iter().map(|row| row.norm()).collect()
    }
}

/// Results of the tests and load cases of one deck.
struct Tested {
    dataset: Dataset,
    answers: Answers,
    values: Vec<f64>,
    /// Tolerances of the car, each with a flag. The flag is true if the solver computes the derivatives with respect to the tolerance. The list
    /// is empty if no tolerances were requested.
    tolerances: Vec<(Tolerance, bool)>,
}

/// Derivatives that a run of the tests must provide.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Asked {
    /// True for derivatives with respect to the unknowns.
    derivatives: bool,
    /// True for derivatives with respect to the tolerances.
    spread: bool,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(tuning: &'a Tuning) -> Self {
        let Tuning { model, rig, .. } = tuning;
        let mut bench = tuning.bench(&tuning.dataset, model);
        let in_cases = tuning.cases.differentiable(model);
        let is_exact = |unknown: &DeckUnknown| {
            let mut markers = unknown.markers.iter();
            let numbers = unknown.numbers.iter().map(|number| &number.address);
            let moves_wheel = markers.any(|marker| rig.wheels.contains(marker))
                || rig.are_moved_by(numbers.clone(), model);
            let in_tests = match &mut bench {
                Ok(None) => true,
                Ok(Some(bench)) => !moves_wheel && have_derivatives(bench, numbers.clone()),
                Err(_) => false,
            };
            in_tests && in_cases.as_ref().is_ok_and(|own| own.has_all(numbers))
        };
        Self {
            is_exact: tuning.unknowns.iter().map(is_exact).collect(),
            tuning,
            runs: 0,
        }
    }

    /// Runs the tests at the given coordinates of the unknowns. Returns derivatives if `derivatives` is true. Returns `None` if the numbers
    /// cannot be written into the deck, or if a test has no equilibrium.
    pub(crate) fn evaluate(&mut self, x: &[f64], derivatives: bool) -> Option<Evaluation> {
        let tuning = self.tuning;
        let asked = Asked {
            derivatives,
            spread: tuning.target.robust,
        };
        let here = self.tests(x, asked)?;
        let count = if derivatives { x.len() } else { 0 };
        let rows = here.values.len();
        let mut spread = None;
        if asked.spread {
            let sd = self.scatter(&here, count)?.sd();
            spread = Some(Spread {
                sd,
                jacobian: DMatrix::zeros(rows, count),
            });
        }
        let mut differences: Vec<Option<Vec<f64>>> = Vec::new();
        let goals_exact = tuning.goals.iter().all(|goal| goal.is_exact);
        for k in 0..count {
            let needed = !(self.is_exact[k] && goals_exact);
            let mut found = None;
            if needed || spread.is_some() {
                let (step, moved) = self.moved(x, k);
                let asked = Asked {
                    derivatives: false,
                    ..asked
                };
                let there = self.tests(&moved, asked)?;
                let rates = |there: &[f64], here: &[f64]| -> Vec<f64> {
                    let pairs = there.iter().zip(here);
                    pairs.map(|(there, here)| (there - here) / step).collect()
                };
                if let Some(spread) = &mut spread {
                    let sd = self.scatter(&there, 0)?.sd();
                    let column = rates(&sd, &spread.sd);
                    spread.jacobian.column_mut(k).copy_from_slice(&column);
                }
                found = needed.then(|| rates(&there.values, &here.values));
            }
            differences.push(found);
        }
        let mut jacobian = DMatrix::zeros(rows, count);
        let mut row = 0;
        for goal in &tuning.goals {
            for own in &goal.rows {
                for k in 0..count {
                    jacobian[(row, k)] = match &differences[k] {
                        Some(column) if !(self.is_exact[k] && goal.is_exact) => column[row],
                        _ => goal.change(own, &here.answers, k),
                    };
                }
                row += 1;
            }
        }
        let is_finite = |matrix: &DMatrix<f64>| matrix.iter().all(|entry| entry.is_finite());
        let is_whole =
            is_finite(&jacobian) && spread.iter().all(|spread| is_finite(&spread.jacobian));
        is_whole.then(|| Evaluation {
            x: x.to_vec(),
            answers: here.answers,
            values: here.values,
            jacobian,
            spread,
        })
    }

    /// Runs the tests on the deck of the study without changes and without derivatives. Returns `None` like [`Self::evaluate`].
    pub(crate) fn as_it_is(&mut self) -> Option<Evaluation> {
        let tuning = self.tuning;
        let deck = tuning.dataset.source().clone();
        self.runs += 1;
        let spread = tuning.target.robust;
        let here = tests_on(tuning, deck, (Vec::new(), spread), Vec::new()).ok()?;
        let sd = if spread {
            Some(self.scatter(&here, 0)?.sd())
        } else {
            None
        };
        let none = || DMatrix::zeros(here.values.len(), 0);
        Some(Evaluation {
            x: Vec::new(),
            jacobian: none(),
            spread: sd.map(|sd| Spread {
                sd,
                jacobian: none(),
            }),
            values: here.values,
            answers: here.answers,
        })
    }

    /// Runs the tests at the given coordinates of the unknowns. Returns the values with the changes that the tolerances cause. Returns `None`
    /// like [`Self::evaluate`].
    pub(crate) fn scattered(&mut self, x: &[f64]) -> Option<Scatter> {
        let asked = Asked {
            derivatives: false,
            spread: true,
        };
        let here = self.tests(x, asked)?;
        self.scatter(&here, 0)
    }

    /// Runs the tests on a deck in which each tolerance deviates by `z` standard deviations. Returns `None` if there is no equilibrium.
    pub(crate) fn drawn(
        &mut self,
        dataset: &Dataset,
        tolerances: &[Tolerance],
        z: &[f64],
    ) -> Option<Vec<f64>> {
        let mut numbers: BTreeMap<&Address, f64> = BTreeMap::new();
        let mut turns: BTreeMap<usize, Vec3> = BTreeMap::new();
        for (tolerance, z) in tolerances.iter().zip(z).filter(|(_, z)| **z != 0.0) {
            for (address, change) in &tolerance.change.numbers {
                let value = || dataset.value_at(address).unwrap_or_default();
                *numbers.entry(address).or_insert_with(value) += z * change;
            }
            for (marker, turn) in &tolerance.change.turns {
                *turns.entry(marker.0).or_default() += turn * *z;
            }
        }
        let numbers: Vec<(Address, f64)> = numbers
            .into_iter()
            .map(|(address, value)| (address.clone(), value))
            .collect();
        let deck = rewritten(dataset, &numbers).ok()?;
        let turns = turns.into_iter();
        let turns = turns
            .map(|(marker, turn)| (MarkerIx(marker), turn))
            .collect();
        self.runs += 1;
        let found = tests_on(self.tuning, deck, (Vec::new(), false), turns).ok()?;
        Some(found.values)
    }

    /// Returns the step of a finite difference for unknown `k`, and the coordinates moved by it. The step goes towards the bound that is
    /// further away.
    fn moved(&self, x: &[f64], k: usize) -> (f64, Vec<f64>) {
        let [least, most] = self.tuning.unknowns[k].bounds;
        let step = DIFFERENCE_STEP * self.tuning.scale()[k];
        let step = if most - x[k] > x[k] - least {
            step
        } else {
            -step
        };
        let mut moved = x.to_vec();
        moved[k] += step;
        (step, moved)
    }

    fn tests(&mut self, x: &[f64], asked: Asked) -> Option<Tested> {
        let tuning = self.tuning;
        let deck = tuning.deck(x).ok()?;
        self.runs += 1;
        let along = |k: usize| DeckChange::of_numbers(tuning.unknowns[k].rates(x[k]));
        let directions = if asked.derivatives {
            (0..x.len()).map(along).collect()
        } else {
            Vec::new()
        };
        tests_on(tuning, deck, (directions, asked.spread), Vec::new()).ok()
    }

    /// Returns the changes of all values that the tolerances cause. `first` is the index of the first tolerance among the directions of the run.
    /// Derivatives that the solver does not compute are central differences over one standard deviation to each side.
    fn scatter(&mut self, here: &Tested, first: usize) -> Option<Scatter> {
        let goals: &[Goal] = &self.tuning.goals;
        let tolerances: Vec<Tolerance> =
            here.tolerances.iter().map(|(own, _)| own.clone()).collect();
        let mut columns = DMatrix::zeros(here.values.len(), tolerances.len());
        for (k, (_, is_exact)) in here.tolerances.iter().enumerate() {
            let mut difference = None;
            if !is_exact || goals.iter().any(|goal| !goal.is_exact) {
                let mut z = vec![0.0; tolerances.len()];
                z[k] = 1.0;
                let plus = self.drawn(&here.dataset, &tolerances, &z)?;
                z[k] = -1.0;
                let minus = self.drawn(&here.dataset, &tolerances, &z)?;
                difference = Some((plus, minus));
            }
            let mut row = 0;
            for goal in goals {
                for own in &goal.rows {
                    columns[(row, k)] = match &difference {
                        Some((plus, minus)) if !(*is_exact && goal.is_exact) => {
                            0.5 * (plus[row] - minus[row])
                        }
                        _ => goal.change(own, &here.answers, first + k),
                    };
                    row += 1;
                }
            }
        }
        columns
            .iter()
            .all(|entry| entry.is_finite())
            .then(|| Scatter {
                dataset: here.dataset.clone(),
                values: here.values.clone(),
                tolerances,
                columns,
            })
    }
}

/// Returns true if the solver can differentiate with respect to all these numbers.
fn have_derivatives<'n>(
    bench: &mut Bench<'_>,
    numbers: impl IntoIterator<Item = &'n Address>,
) -> bool {
    let mut numbers = numbers.into_iter();
    numbers.all(|address| bench.has_derivative(address).unwrap_or(false))
}

/// Returns the values of the rows of all goals.
fn values(tuning: &Tuning, found: &Answers) -> Vec<f64> {
    let goals = tuning.goals.iter();
    goals
        .flat_map(|goal| goal.rows.iter().map(|row| goal.value(row, found)))
        .collect()
}

/// Runs the tests and load cases on a deck in which the markers `turned` are rotated. The results are differentiated along `directions`,
/// and also along the tolerances if `spread` is true.
fn tests_on(
    tuning: &Tuning,
    deck: Source,
    (mut directions, spread): (Vec<DeckChange>, bool),
    turned: Vec<(MarkerIx, Vec3)>,
) -> Result<Tested, BenchError> {
    let dataset = Dataset::parse(deck).value;
    let lowered = Model::lower_with(&dataset, &tuning.files);
    let refused = |found: Vec<_>| BenchError::Deck(found);
    if has_errors(&lowered.diagnostics) {
        return Err(refused(lowered.diagnostics));
    }
    let model = lowered.value;
    let mut bench = tuning.bench(&dataset, &model).map_err(refused)?;
    let mut own = Vec::new();
    if spread {
        let in_cases = tuning.cases.differentiable(&model)?;
        let settings = &tuning.study.tolerances;
        for tolerance in tolerances(settings, &model, &tuning.rig) {
            let numbers = tolerance.change.numbers.iter().map(|(address, _)| address);
            let in_tests = match &mut bench {
                None => true,
                Some(bench) => !tolerance.moves_wheel && have_derivatives(bench, numbers.clone()),
            };
            let is_exact = in_tests && in_cases.has_all(numbers);
            directions.push(tolerance.change.clone());
            own.push((tolerance, is_exact));
        }
    }
    let asked = OfCases {
        directions: &directions,
        turned: &turned,
    };
    let cases = tuning.cases.solve(&model, &asked)?;
    let run = match &mut bench {
        None => None,
        Some(bench) => {
            bench.differentiate(directions);
            bench.turn(turned);
            Some(run(bench, &model.units)?)
        }
    };
    let found = Answers { run, cases };
    let values = values(tuning, &found);
    if !values.iter().all(|value| value.is_finite()) {
        return Err(refused(Vec::new()));
    }
    Ok(Tested {
        answers: found,
        values,
        tolerances: own,
        dataset,
    })
}
