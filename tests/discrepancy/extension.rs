//! The extended files alone, run by the drop-in solver, are the extended fit.

use std::fs::File;
use std::io::BufReader;

use admire::discrepancy::Outcome;
use admire::mechanics::Vec3;
use admire::results::{StepKind, XrfReader};
use admire::session::Session;

/// Runs `extended.acf` and compares the place of every part of the deck in every case: to a millionth of a millimetre.
pub fn reproduces(outcome: &Outcome<'_>) {
    let folder = tempfile::tempdir().unwrap();
    let path = |file: &str| folder.path().join(file);
    std::fs::write(path("extended.adm"), outcome.extended_deck()).unwrap();
    std::fs::write(path("extended.acf"), outcome.extended_commands()).unwrap();
    let mut console = Vec::new();
    let ending = Session::new(Box::new(&mut console), folder.path()).run_file("extended.acf");
    let console = String::from_utf8_lossy(&console).into_owned();
    assert_eq!(ending.exit_code(true), 0, "{console}");
    let file = File::open(path("extended.res")).expect("the deck asks for results");
    let mut reader = XrfReader::open("extended.res", BufReader::new(file)).unwrap();
    let parts = &outcome.subject.problem.model.parts;
    let places: Vec<Option<[usize; 3]>> = parts
        .iter()
        .map(|part| {
            let id = i64::from(part.header.id);
            let entity = reader.catalogue().entity_of("Part", id)?;
            Some(["X", "Y", "Z"].map(|name| entity.component(name).unwrap().id))
        })
        .collect();
    assert!(places.iter().flatten().count() >= parts.len() - 1);
    let (mut case, mut values) = (0, Vec::new());
    while let Some(step) = reader.next_step().unwrap() {
        if step.kind == StepKind::Input {
            continue;
        }
        step.values(&mut values).unwrap();
        let state = &outcome.plain.states[case];
        for (place, pose) in places.iter().zip(&state.poses) {
            let Some(ids) = place else { continue };
            let [x, y, z] = ids.map(|id| values[id - 1]);
            let off = (Vec3::new(x, y, z) - pose.p).norm();
            assert!(off < 1e-6, "case {case}: {off} mm off\n{console}");
        }
        case += 1;
    }
    assert_eq!(case, outcome.plain.states.len(), "{console}");
}
