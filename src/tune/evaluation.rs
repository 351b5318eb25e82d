use crate::settings::DIFFERENCE_STEP;
use crate::tuning::Tuning;
use admire_identify::DeckUnknown;
use admire_kc::{Bench, BenchError, KcRun, run};
use admire_solver::model::{MarkerIx, Model};
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};
use nalgebra::DMatrix;

/// Results of the tests for one set of numbers.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Coordinates of the unknowns.
    pub x: Vec<f64>,
    /// Results of the tests.
    pub run: KcRun,
    /// Values of all rows of all goals, in their order.
    pub values: Vec<f64>,
    /// Derivatives of the values, one column for each unknown; no columns if they were not asked for.
    pub jacobian: DMatrix<f64>,
}

/// Runs the tests and their derivatives, and counts the runs.
#[derive(Debug)]
pub(crate) struct Evaluator<'a> {
    pub tuning: &'a Tuning,
    /// Unknowns along which the solver differentiates.
    pub is_exact: Vec<bool>,
    /// Number of runs of the tests, those for differences included.
    pub runs: usize,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(tuning: &'a Tuning) -> Self {
        let Tuning {
            config,
            dataset,
            files,
            model,
            ..
        } = tuning;
        let mut bench = Bench::new(config, dataset, files, model).ok();
        let wheels = wheel_markers(tuning);
        let is_exact = |unknown: &DeckUnknown| {
            let seen = unknown.markers.iter().any(|marker| wheels.contains(marker));
            let moves_wheel = seen || moves_one_of(unknown, &wheels, model);
            let mut known = |address: &Address| {
                let bench = bench.as_mut();
                bench.is_some_and(|bench| bench.has_derivative(address).unwrap_or(false))
            };
            !moves_wheel && unknown.numbers.iter().all(|number| known(&number.address))
        };
        Self {
            is_exact: tuning.unknowns.iter().map(is_exact).collect(),
            tuning,
            runs: 0,
        }
    }

    /// Runs the tests for coordinates of the unknowns, with the derivatives if `derivatives` is true. `None` if the numbers cannot be written
    /// into the deck, or a test has no equilibrium there.
    pub(crate) fn evaluate(&mut self, x: &[f64], derivatives: bool) -> Option<Evaluation> {
        let tuning = self.tuning;
        let (run, values) = self.tests(x, derivatives)?;
        let count = if derivatives { x.len() } else { 0 };
        let mut jacobian = DMatrix::zeros(values.len(), count);
        let mut differences: Vec<Option<Vec<f64>>> = Vec::new();
        let goals_exact = tuning.goals.iter().all(|goal| goal.is_exact);
        for k in 0..count {
            let needed = !(self.is_exact[k] && goals_exact);
            differences.push(needed.then(|| self.difference(x, k, &values)).flatten());
            if needed && differences[k].is_none() {
                return None;
            }
        }
        let mut row = 0;
        for goal in &tuning.goals {
            for own in &goal.rows {
                for k in 0..count {
                    jacobian[(row, k)] = match &differences[k] {
                        Some(column) if !(self.is_exact[k] && goal.is_exact) => column[row],
                        _ => own.change(&goal.of, &run, k),
                    };
                }
                row += 1;
            }
        }
        jacobian
            .iter()
            .all(|entry| entry.is_finite())
            .then(|| Evaluation {
                x: x.to_vec(),
                run,
                values,
                jacobian,
            })
    }

    /// Returns the derivatives of all values with respect to unknown `k`, by a finite difference towards the more distant bound.
    fn difference(&mut self, x: &[f64], k: usize, values: &[f64]) -> Option<Vec<f64>> {
        let [least, most] = self.tuning.unknowns[k].bounds;
        let step = DIFFERENCE_STEP * self.tuning.scale()[k];
        let step = if most - x[k] > x[k] - least {
            step
        } else {
            -step
        };
        let mut moved = x.to_vec();
        moved[k] += step;
        let (_, other) = self.tests(&moved, false)?;
        let pairs = other.iter().zip(values);
        Some(pairs.map(|(other, value)| (other - value) / step).collect())
    }

    fn tests(&mut self, x: &[f64], derivatives: bool) -> Option<(KcRun, Vec<f64>)> {
        let tuning = self.tuning;
        let deck = tuning.deck(x).ok()?;
        self.runs += 1;
        let along = |k: usize| -> Vec<(Address, f64)> { tuning.unknowns[k].rates(x[k]) };
        let directions = if derivatives {
            (0..x.len()).map(along).collect()
        } else {
            Vec::new()
        };
        let found = tests_on(tuning, deck, directions).ok()?;
        let values = values(tuning, &found);
        values
            .iter()
            .all(|value| value.is_finite())
            .then_some((found, values))
    }
}

/// Returns the values of all rows of all goals in a run.
pub(crate) fn values(tuning: &Tuning, run: &KcRun) -> Vec<f64> {
    let goals = tuning.goals.iter();
    goals
        .flat_map(|goal| goal.rows.iter().map(|row| row.value(&goal.of, run)))
        .collect()
}

/// Runs the tests on a deck, with derivatives along these directions.
fn tests_on(
    tuning: &Tuning,
    deck: Source,
    directions: Vec<Vec<(Address, f64)>>,
) -> Result<KcRun, BenchError> {
    let dataset = Dataset::parse(deck).value;
    let lowered = Model::lower_with(&dataset, &tuning.files);
    let refused = |found: Vec<_>| BenchError::Deck(found);
    if crate::tuning::has_errors(&lowered.diagnostics) {
        return Err(refused(lowered.diagnostics));
    }
    let model = lowered.value;
    let bench = Bench::new(&tuning.config, &dataset, &tuning.files, &model);
    let mut bench = bench.map_err(refused)?;
    bench.differentiate(directions);
    run(&mut bench, &model.units)
}

/// Returns the markers of the wheel centres and of the spin axes.
fn wheel_markers(tuning: &Tuning) -> Vec<MarkerIx> {
    let mut found = Vec::new();
    for wheel in tuning.config.wheels.iter().flatten() {
        for name in [&wheel.centre, &wheel.spin] {
            let address = Address::parse(&name.text, &tuning.dataset).ok();
            let address = address.filter(|address| address.kind == "MARKER");
            found.extend(address.and_then(|address| tuning.model.marker(address.id?)));
        }
    }
    found
}

/// Returns true if the numbers of an unknown move one of these markers, or a marker in whose frame one of them is given.
fn moves_one_of(unknown: &DeckUnknown, wheels: &[MarkerIx], model: &Model) -> bool {
    let numbers = unknown.numbers.iter();
    let markers = numbers.filter(|number| number.address.kind == "MARKER");
    let moved: Vec<MarkerIx> = markers
        .filter_map(|number| model.marker(number.address.id?))
        .collect();
    let parts = |number: &&admire_identify::SetNumber| {
        matches!(
            number.address.argument.as_deref(),
            Some("QG" | "REULER" | "ZG" | "XG")
        ) && number.address.kind == "PART"
    };
    unknown.numbers.iter().any(|number| parts(&number))
        || wheels
            .iter()
            .any(|wheel| moved.contains(wheel) || model.moves_with(*wheel, &moved))
}
