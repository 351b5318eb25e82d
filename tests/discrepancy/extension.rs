//! Check that the exported extended files, run by the drop-in solver, reproduce the extended fit.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use admire_diagnosis::{Outcome, diagnose, held_out};
use admire_identify::LoadedStudy;
use admire_results::{StepKind, XrfReader};
use admire_session::Session;
use admire_solver::mechanics::{Vec3, euler313};

use crate::plant::{Plant, study};

/// Runs `extended.acf` and compares the position of every part of the deck in every case, to a millionth of a millimetre.
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

/// Rewrites the axes of markers as points; `words` are their angles in degrees, as spelled in the deck.
fn by_points(deck: &Path, markers: &[([f64; 3], &str)]) {
    let mut text = std::fs::read_to_string(deck).unwrap();
    for (origin, words) in markers {
        let angles: Vec<f64> = words
            .split(", ")
            .map(|word| {
                word.trim_end_matches('D')
                    .parse::<f64>()
                    .unwrap()
                    .to_radians()
            })
            .collect();
        let axes = euler313(angles[0], angles[1], angles[2]);
        let point = |axis: usize, length: f64| {
            let at = Vec3::from(*origin) + length * axes.column(axis);
            format!("{:.12}, {:.12}, {:.12}", at.x, at.y, at.z)
        };
        let points = format!("ZP = {}, XP = {}", point(2, 1.0), point(0, 40.0));
        let angles = format!("REULER = {words}");
        assert!(text.contains(&angles), "{angles}");
        text = text.replace(&angles, &points);
    }
    std::fs::write(deck, text).unwrap();
}

/// Checks that points that define the axes of a marker are rotated with it.
///
/// A bushing rotated about one axis is equivalent to one with coupling; a bushing rotated about two axes is not.
#[test]
fn a_turned_bushing_whose_markers_have_points() {
    let plant = Plant {
        truth: ("bushing-orientation", "BUSHING/1"),
        turned: vec![(1, 0, 14.0), (2, 0, 14.0), (1, 1, 12.0), (2, 1, 12.0)],
        ..Plant::nothing()
    };
    let folder = study("pseudo-mcpherson", &plant, 0.02, 23, None);
    let markers = [
        (
            [0.0; 3],
            "-39.30443017783D, 84.30774983023D, 9.464977668106D",
        ),
        ([60.0, -370.0, 205.0], "-94.26789330029D, 94.0D, 7.0D"),
    ];
    by_points(&folder.path().join("model.adm"), &markers);
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let problem = loaded.problem();
    let outcome = diagnose(&problem, held_out(&loaded.study, &loaded.measurement)).unwrap();
    let first = &outcome.diagnosis.findings[0];
    assert_eq!((first.cause.as_str(), first.address.as_str()), plant.truth);
    reproduces(&outcome);
}
