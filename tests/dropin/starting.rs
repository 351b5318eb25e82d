//! Initial conditions of a joint, alone and with a MOTION on the same freedom.

use crate::run::{Ran, Results, folder, mdi};

/// Runs a part on a joint, driven by a motion, for one second in two steps.
fn run(joint: &str, motion: &str) -> (Results, Ran) {
    let deck = format!(
        "joint\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
         PART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, {joint}, I=20, J=1\n{motion}\n\
         REQUEST/1, F2=DZ(20,1)\\F3=AZ(20,1)\\F4=VZ(20,1)\\F6=WZ(20,1)\nIC/AERROR=1E-3\nKINEMATICS/ALIMIT=10D\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let acf = "\nfile/model=joint\nSIM/TRANS, END=1, STEPS=2\nstop\n";
    let folder = folder(&[("joint.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read_all(folder.path(), "joint.res"), ran)
}

/// Compares displacements and rates at 0, 0.5 and 1 s.
fn check(results: &Results, (place, rate): (&str, &str), places: [f64; 3], rates: [f64; 3]) {
    for (column, expected) in [(place, places), (rate, rates)] {
        let found = results.column("REQUEST_1", column);
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}

const SLIDE: (&str, &str) = ("U2", "U4");
const TURN: (&str, &str) = ("U3", "U6");

#[test]
fn a_motion_counts_before_the_initial_conditions_of_its_joint() {
    let told = |ran: &Ran, what: &str| {
        let said = format!("the initial {what} of JOINT/1 is ignored: MOTION/1 drives the joint");
        assert!(ran.stdout.contains(&said), "{}", ran.stdout);
    };
    for motion in ["JOINT=1", "I=20, J=1, Z"] {
        let (results, ran) = run(
            "TRANSLATIONAL, IC=1,2",
            &format!("MOTION/1, {motion}, FUNCTION=0.5*TIME"),
        );
        told(&ran, "displacement and velocity");
        check(&results, SLIDE, [0.0, 0.25, 0.5], [0.5; 3]);
    }
    // A velocity MOTION without ICDISP starts at the joint's initial position.
    let (results, ran) = run(
        "REVOLUTE, IC=1,2",
        "MOTION/1, JOINT=1, VELOCITY, FUNCTION=0.5",
    );
    told(&ran, "velocity");
    check(&results, TURN, [1.0, 1.25, 1.5], [0.5; 3]);
    let (results, ran) = run(
        "REVOLUTE, IC=1",
        "MOTION/1, JOINT=1, ACCELERATION, FUNCTION=0.5",
    );
    assert!(!ran.stdout.contains("drives the joint"));
    check(&results, TURN, [1.0, 1.0625, 1.25], [0.0, 0.25, 0.5]);
    let motion = "MOTION/1, JOINT=1, VELOCITY, ICDISP=0.25, FUNCTION=0.5";
    let (results, ran) = run("REVOLUTE, IC=1", motion);
    told(&ran, "displacement");
    check(&results, TURN, [0.25, 0.5, 0.75], [0.5; 3]);
}

/// Checks that the other freedom of the joint keeps its initial conditions.
#[test]
fn a_motion_along_a_joint_leaves_its_turn_alone() {
    let joint = "CYLINDRICAL, ICTRAN=0.1,0.2, ICROT=1,2";
    let motion = "MOTION/1, JOINT=1, TRANSLATIONAL, FUNCTION=0.5*TIME";
    let (results, _) = run(joint, motion);
    check(&results, SLIDE, [0.0, 0.25, 0.5], [0.5; 3]);
    check(&results, TURN, [1.0, 2.0, 3.0], [2.0; 3]);
}

#[test]
fn what_has_no_effect_is_told() {
    let (_, ran) = run("PLANAR, IC=1", "MOTION/1, JOINT=1, FUNCTION=0");
    assert!(
        ran.stdout
            .contains("IC of JOINT/1 has no effect: a PLANAR joint"),
        "{}",
        ran.stdout
    );
    let (_, ran) = run("REVOLUTE", "MOTION/1, JOINT=1, FUNCTION=TIME");
    for said in [
        "options without effect in IC: AERROR",
        "options without effect in KINEMATICS: ALIMIT",
    ] {
        assert!(ran.stdout.contains(said), "{}", ran.stdout);
    }
}
