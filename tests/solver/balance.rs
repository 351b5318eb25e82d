//! Newton's law on every part of every solved deck: all forces on a part cancel to round-off, and so do all torques.

use std::fs;
use std::path::Path;

use admire_solver::mechanics::Vec3;
use admire_solver::model::{Model, PartKind};
use admire_solver::statics::{Report, Solver, StaticSettings};
use admire_solver::system::{Parameters, Scratch, State, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use crate::common::{files_below, shared};

/// Checks that the loads on every moving part cancel to the imbalance that the solver reports, and to round-off of their own magnitudes.
pub fn check(
    model: &Model,
    system: &System,
    parameters: &Parameters,
    state: &State,
    report: &Report,
) {
    let mut scratch = Scratch::new(system);
    let mut here = system.evaluate(parameters, state, &mut scratch).unwrap();
    let loads = here.loads().unwrap();
    let mut seen = vec![false; model.parts.len()];
    let mut sums = vec![(Vec3::zeros(), Vec3::zeros(), 0.0, 0.0); model.parts.len()];
    for load in &loads {
        let origin = state.poses[load.part.0].p;
        let torque = load.torque_about(&origin);
        let sum = &mut sums[load.part.0];
        sum.0 += load.force;
        sum.1 += torque;
        sum.2 += load.force.norm();
        sum.3 += load.torque.norm() + (load.point - origin).norm() * load.force.norm();
        seen[load.part.0] = true;
    }
    for ((part, (F, T, force, torque)), seen) in model.parts.iter().zip(&sums).zip(&seen) {
        let name = &part.header.name;
        if matches!(part.kind, PartKind::Ground | PartKind::External) {
            continue;
        }
        assert!(*seen || part.mass == 0.0, "{name} feels nothing");
        let left = report.imbalance;
        assert!(
            F.amax() <= left + 1e-11 * force,
            "{name}: {F} of {force:e}, {left:e} left"
        );
        if part.kind == PartKind::Rigid {
            assert!(
                T.amax() <= left + 1e-11 * torque,
                "{name}: {T} of {torque:e}, {left:e} left"
            );
        }
    }
}

fn read(path: &Path) -> Option<Model> {
    let bytes = fs::read(path).unwrap();
    let parsed = Dataset::parse(Source::new("deck", bytes));
    let lowered = Model::lower(&parsed.value);
    (!parsed.has_errors() && !lowered.has_errors()).then_some(lowered.value)
}

/// Solves all solvable decks below a folder with tight tolerances. Returns their number.
fn sweep(folder: &Path) -> usize {
    let mut solved = 0;
    for path in files_below(folder, "adm") {
        let Some(model) = read(&path) else { continue };
        let compiled = System::compile(&model);
        if compiled.has_errors() {
            continue;
        }
        let system = compiled.value;
        let (parameters, mut state) = (system.parameters(), system.state());
        let mut solver = Solver::new(&system);
        let settings = StaticSettings {
            maxit: 200,
            ..StaticSettings::tight()
        };
        if let Ok(report) = solver.solve(&system, &parameters, &mut state, &settings) {
            println!("{}: {:.1e} left", path.display(), report.imbalance);
            check(&model, &system, &parameters, &state, &report);
            solved += 1;
        }
    }
    solved
}

#[test]
fn every_part_of_every_deck() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    assert!(sweep(&corpus) >= 5);
    for (folder, least) in [("reference", 2), ("real-decks", 5)] {
        if let Some(folder) = shared(folder) {
            assert!(sweep(&folder) >= least);
        }
    }
}

/// Checks the reference axles in each of their load cases.
#[test]
fn every_part_in_every_load_case() {
    for stem in [
        "reference/pseudo-mcpherson/mcph_ref",
        "reference/multilink/ocp_ref",
    ] {
        let Some((model, expected)) = crate::reference::load(stem) else {
            return;
        };
        let system = System::compile(&model).value;
        let (mut parameters, mut state) = (system.parameters(), system.state());
        let mut solver = Solver::new(&system);
        for case in expected["cases"].as_array().unwrap() {
            for (id, direction) in (1..).zip(["longitudinal", "lateral", "vertical"]) {
                let address = crate::reference::address("SFORCE", id);
                let slot = system.catalogue().slot(&address).unwrap();
                parameters.set(slot, case["load"][direction].as_f64().unwrap());
            }
            let report = solver
                .solve(&system, &parameters, &mut state, &StaticSettings::tight())
                .unwrap();
            check(&model, &system, &parameters, &state, &report);
        }
    }
}
