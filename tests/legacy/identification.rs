//! Our own identification of a study folder, to compare clients with.

use std::ops::ControlFlow;
use std::path::Path;

use admire::backend::NativeBackend;
use admire::identify::{Fit, Problem, regression, unknowns};
use admire::model::Model;
use admire::rig::{Measurement, Study, programme};
use admire::syntax::Dataset;

/// The paper's loop on the built-in solver, as `study.toml` asks for it.
pub fn by_regression(folder: &Path) -> Fit {
    let study = Study::read(folder);
    let study = study.value.expect("a study");
    let dataset = Dataset::parse(study.deck.clone()).value;
    let model = Model::lower(&dataset).value;
    let measurement = Measurement::resolve(&study, &model);
    assert!(!measurement.has_errors(), "{:?}", measurement.diagnostics);
    let measurement = measurement.value;
    let mut complaints = Vec::new();
    let programme = programme(&study, &dataset, &measurement, &mut complaints);
    let unknowns = unknowns(&study, &model, |_| None, &mut complaints);
    assert!(complaints.is_empty(), "{complaints:?}");
    let problem = Problem {
        dataset: &dataset,
        model: &model,
        programme: &programme,
        measurement: &measurement,
        settings: &study.identify,
        regression: &study.regression,
        unknowns,
    };
    let mut progress = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
    regression::identify(&problem, &mut NativeBackend::new(), &mut progress).expect("a fit")
}
