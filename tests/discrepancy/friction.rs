//! Friction by other laws than a slider, and with limits that differ by direction.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::found::UP_AND_DOWN;
use super::plant::{Friction, FrictionLaw, Plant, study};
use admire_diagnosis::{Cause, Diagnosis, Verdict, diagnose, held_out};
use admire_identify::LoadedStudy;

/// Checks friction by Dahl's law, which no hypothesis has.
///
/// Friction at its location must be named first, and no other element with a probability above one half.
fn gives_way_by_degrees(friction: Friction, place: &'static str, seed: u64) {
    let plant = Plant {
        truth: ("dry-friction", place),
        friction: Some(friction),
        ..Plant::nothing()
    };
    let folder = study("pseudo-mcpherson", &plant, 0.02, seed, Some(UP_AND_DOWN));
    friction_alone(folder.path(), place);
}

fn friction_alone(study: &Path, place: &str) -> Diagnosis {
    let loaded = LoadedStudy::read(study).value.unwrap();
    let held = held_out(&loaded.study, &loaded.measurement);
    let diagnosis = diagnose(&loaded.problem(), held).unwrap().diagnosis;
    let named: Vec<_> = diagnosis
        .findings
        .iter()
        .map(|f| (f.cause, f.address.as_str(), f.probability))
        .collect();
    println!("{}: {:?} {named:?}", study.display(), diagnosis.verdict);
    let (cause, at, _) = named[0];
    assert_eq!((cause, at), (Cause::DryFriction, place));
    let elsewhere = named.iter().any(|(_, at, p)| *at != place && *p > 0.5);
    assert!(!elsewhere, "{named:?}");
    assert!(named.iter().all(|(_, _, p)| *p <= 1.0), "{named:?}");
    assert_eq!(diagnosis.verdict, Verdict::Discrepancy);
    diagnosis
}

const STRUT: Friction = Friction {
    law: FrictionLaw::Dahl,
    force: 150.0,
    stiffness: 300.0,
    i: 11,
    j: 12,
    part_of_j: 4,
    axis: 2,
};

// One test per seed, so that they run in parallel.
#[test]
fn friction_of_a_strut_that_gives_way_by_degrees() {
    gives_way_by_degrees(STRUT, "JOINT/3", 27);
}

#[test]
#[ignore = "minutes: .ci/full"]
fn friction_of_a_strut_that_gives_way_by_degrees_in_other_noise() {
    gives_way_by_degrees(STRUT, "JOINT/3", 28);
}

#[test]
#[ignore = "minutes: .ci/full"]
fn friction_of_a_bushing_that_gives_way_by_degrees() {
    let friction = Friction {
        law: FrictionLaw::Dahl,
        force: 1500.0,
        stiffness: 1000.0,
        i: 3,
        j: 4,
        part_of_j: 1,
        axis: 0,
    };
    for seed in [27, 28] {
        gives_way_by_degrees(friction, "BUSHING/2.K.1", seed);
    }
}

const TOLERANCES: &str =
    "hardpoints=0.2,load_gain=0.003,load_direction_deg=0.057,marks_on_parts=0.1,pose=0.02";

/// Measures a study with the rig and returns the folder of the result.
fn measured(base: &tempfile::TempDir, seed: &str, options: &[&str]) -> PathBuf {
    let out = base.path().join(seed);
    let mut rig = Command::new(env!("CARGO_BIN_EXE_admire"));
    rig.arg("rig").arg(base.path()).arg("--out").arg(&out);
    let done = rig.args(["--seed", seed]).args(options).output().unwrap();
    assert!(done.status.success(), "{done:?}");
    out
}

/// Checks friction by Dahl's law with tolerances, planted by the rig. Fits that stop at a kink assign it to a bushing or find a coupling
/// besides.
fn gives_way_on_tolerances(force: &str, stiffness: &str, seed: &str) {
    let folder = study(
        "pseudo-mcpherson",
        &Plant::nothing(),
        0.02,
        1,
        Some(UP_AND_DOWN),
    );
    let effect = format!("dry-friction@JOINT/3:force={force},stiffness={stiffness},law=dahl");
    let study = measured(
        &folder,
        seed,
        &["--tolerances", TOLERANCES, "--effect", &effect],
    );
    friction_alone(&study, "JOINT/3");
}

#[test]
#[ignore = "minutes: .ci/full"]
fn friction_of_a_strut_that_gives_way_by_degrees_on_tolerances() {
    gives_way_on_tolerances("60", "41.5", "1026");
}

#[test]
#[ignore = "minutes: .ci/full"]
fn stiffer_friction_of_a_strut_that_gives_way_by_degrees_on_tolerances() {
    gives_way_on_tolerances("100", "219.2", "1086");
}

/// Checks friction of 1,500 N in one direction and 300 N in the other, as the rig plants it. Its estimated asymmetry must match.
#[test]
fn friction_that_differs_by_direction() {
    let folder = study(
        "pseudo-mcpherson",
        &Plant::nothing(),
        0.02,
        1,
        Some(UP_AND_DOWN),
    );
    for seed in ["11", "12"] {
        let effect = "asymmetric-friction@BUSHING/1.K.1:force=1500,back=300,stiffness=6000";
        let study = measured(&folder, seed, &["--effect", effect]);
        let diagnosis = friction_alone(&study, "BUSHING/1.K.1");
        let (numbers, errors) = {
            let found = &diagnosis.findings[0];
            (&found.parameters, &found.std_error)
        };
        for (name, planted) in [("force", 900.0), ("asymmetry", 600.0)] {
            let off = (numbers[name] - planted) / errors[name];
            assert!(off.abs() < 3.0, "{name}: {numbers:?}, {errors:?}");
        }
    }
}
