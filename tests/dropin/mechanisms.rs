//! Mechanisms with known motions through `mdi`: Andrews' squeezer, a heavy top, state matrices.

use std::path::Path;

use crate::run::{Ran, Results, folder, mdi, text};
use crate::squeezer::{expected, squeezer};

fn near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() < error, "{found} and {expected}");
}

fn run(deck: &str, commands: &str) -> (Results, Ran, tempfile::TempDir) {
    let acf = format!("\nfile/model=deck\n{commands}\nstop\n");
    let folder = folder(&[("deck.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    (Results::read_all(folder.path(), "deck.res"), ran, folder)
}

/// The reference has sixteen digits.
#[test]
fn andrews_squeezer_ends_where_the_reference_does() {
    let expected = expected();
    for steps in [30, 300] {
        let commands = format!("SIMULATE/DYNAMIC, END=0.03, STEPS={steps}");
        let (found, ran, _folder) = run(&squeezer(), &commands);
        assert!(ran.stdout.contains("redundant constraints"));
        for (k, expected) in expected.iter().enumerate() {
            let entity = format!("PART_{}_XFORM", 10 * (k + 1));
            let psi = *found.column(&entity, "PSI").last().unwrap();
            let phi = *found.column(&entity, "PHI").last().unwrap();
            let turn = std::f64::consts::TAU;
            let off = (psi + phi - expected) / turn;
            near((off - off.round()) * turn, 0.0, 1e-6);
        }
    }
}

/// A heavy top, A .3 about its tip, C .1, m g l 4.905, at 60 degrees, axial spin 60: it precesses evenly at the roots of
/// `A cos(theta) W^2 - C w W + m g l`.
#[test]
fn a_heavy_top_precesses_evenly() {
    let (tilt, spin) = (std::f64::consts::FRAC_PI_3, 60.0);
    let (a, b, c) = (0.3 * tilt.cos(), -0.1 * spin, 9.81 * 0.5);
    let root = f64::sqrt(b * b - 4.0 * a * c);
    for rate in [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)] {
        let deck = format!(
            "top
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=0.05,0.05,0.1, REULER=0,60D,0, WX=0, WY={:.17}, WZ={spin}
MARKER/20, PART=2, QP=0,0,0.5
MARKER/21, PART=2
JOINT/1, SPHERICAL, I=21, J=1
ACCGRAV/KGRAV=-9.81
INTEGRATOR/GSTIFF, ERROR=1E-6
RESULTS/FORMATTED, XRF
END
",
            rate * tilt.sin()
        );
        let (found, _, _folder) = run(&deck, "SIMULATE/DYNAMIC, END=2, STEPS=40");
        let column = |name: &str| found.column("PART_2_XFORM", name);
        // The axis is (sin PSI sin THETA, -cos PSI sin THETA, cos THETA).
        for (k, (psi, theta)) in column("PSI").iter().zip(column("THETA")).enumerate() {
            near(theta, tilt, 1e-5);
            let time = found.steps[k][0];
            let off = (psi - rate * time) / std::f64::consts::TAU;
            near(off - off.round(), 0.0, 1e-4);
        }
    }
}

/// The numbers of a file that MATLAB's `load` reads.
fn matrix(folder: &Path, name: &str) -> Vec<Vec<f64>> {
    text(folder, name)
        .lines()
        .map(|line| {
            line.split_whitespace()
                .map(|x| x.parse().unwrap())
                .collect()
        })
        .collect()
}

fn same(found: &[Vec<f64>], expected: &[&[f64]]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(*expected) {
            near(*found, *expected, 1e-9);
        }
    }
}

/// A block of 2 kg on a spring of 100 N/m and 2 Ns/m, pushed by an input that a first-order filter follows; place and acceleration are
/// outputs.
#[test]
fn state_matrices_are_those_of_the_equations() {
    let deck = "block
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
MARKER/30, PART=1, QP=0,0,2
PART/2, MASS=2, CM=20, IP=1,1,1, QG=0,0,1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=30, K=100, C=2, LENGTH=0.5
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=VARVAL(1)+5*DIF(1)
VARIABLE/1, FUNCTION=0
VARIABLE/2, FUNCTION=10*DZ(20,1,1)
VARIABLE/3, FUNCTION=ACCZ(20)+VARVAL(1)
DIFF/1, IC=0, FUNCTION=-3*DIF(1)+4*VARVAL(1)
PINPUT/1, VARIABLES=1
POUTPUT/2, VARIABLES=2,3
ACCGRAV/KGRAV=-9.81
RESULTS/FORMATTED, XRF
END
";
    let commands = "SIM/STAT\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=2, FILE=plant, FORMAT=MATLAB";
    let (_, ran, folder) = run(deck, commands);
    assert!(
        ran.stdout.contains("3 states, 1 inputs, 2 outputs"),
        "{}",
        ran.stdout
    );
    let read = |suffix: &str| matrix(folder.path(), &format!("plant{suffix}"));
    same(
        &read("a"),
        &[&[0.0, 1.0, 0.0], &[-50.0, -1.0, 2.5], &[0.0, 0.0, -3.0]],
    );
    same(&read("b"), &[&[0.0], &[0.5], &[4.0]]);
    same(&read("c"), &[&[10.0, 0.0, 0.0], &[-50.0, -1.0, 2.5]]);
    same(&read("d"), &[&[0.0], &[1.5]]);
    let states = text(folder.path(), "plantst");
    let lines: Vec<&str> = states.lines().collect();
    assert_eq!(lines.len(), 3, "{states}");
    assert!(
        lines[0].contains("PART/2") && lines[0].contains("along z"),
        "{states}"
    );
    assert!(
        lines[1].contains("rate of") && lines[2].contains("DIFF/1"),
        "{states}"
    );
    // Without inputs there is A alone; what is not there is named.
    let acf = "\nfile/model=deck\nSIM/STAT\nLINEAR/STATEMAT, FORMAT=MATLAB\nLINEAR/STATEMAT, PINPUT=9\nstop\n";
    let folder = crate::run::folder(&[("deck.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(matrix(folder.path(), "deck.a").len(), 3);
    assert!(
        ran.code == 1 && ran.stdout.contains("PINPUT/9"),
        "{}",
        ran.stdout
    );
}

/// A ball in flight, saved and reloaded in another run, goes on as it flew.
#[test]
fn a_saved_motion_goes_on() {
    let deck = "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,2,3, VX=3, VZ=4, WX=1, WZ=2
MARKER/20, PART=2
ACCGRAV/KGRAV=-9.81
RESULTS/FORMATTED, XRF
END
";
    let (whole, _, folder) = run(
        deck,
        "SIM/DYN, END=0.4, STEPS=4\nSAVE/FILE=half.sav\nSIM/DYN, END=0.8, STEPS=4",
    );
    let saved = std::fs::read_to_string(folder.path().join("half.sav")).unwrap();
    let acf = "\nfile/model=deck\nRELOAD/FILE=half.sav\nSIM/DYN, END=0.8, STEPS=4\nstop\n";
    let other = crate::run::folder(&[("deck.adm", deck), ("run.acf", acf), ("half.sav", &saved)]);
    let ran = mdi(other.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let after = Results::read_all(other.path(), "deck.res");
    for name in ["X", "Z", "VX", "VZ", "WX", "WY", "WZ", "PSI", "THETA"] {
        let last = |r: &Results| *r.column("PART_2_XFORM", name).last().unwrap();
        near(last(&after), last(&whole), 1e-4);
    }
    near(
        *after.column("PART_2_XFORM", "X").last().unwrap(),
        2.4,
        1e-9,
    );
}

/// A push of two milliseconds between two stages of a step is not stepped over: v = impulse / m.
#[test]
fn a_short_push_is_not_stepped_over() {
    let deck = "push
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=2, CM=20, IP=1,2,3
MARKER/20, PART=2
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1
, FUNCTION=1000*(STEP(TIME,0.303,0,0.304,1)-STEP(TIME,0.305,0,0.306,1))
INTEGRATOR/GSTIFF, ERROR=1E-6
RESULTS/FORMATTED, XRF
END
";
    let (found, _, _folder) = run(deck, "SIM/DYN, END=1, STEPS=10");
    let v = found.column("PART_2_XFORM", "VZ");
    near(v[3], 0.0, 1e-12);
    near(v[4], 1.0, 1e-6);
    near(*v.last().unwrap(), 1.0, 1e-6);
}

/// A block of 1 kg on an NFORCE of 100 N/m with CRATIO 0.02, that is 2 Ns/m: -1 +- i sqrt(99), by CMATRIX the same.
#[test]
fn multi_point_forces_damp() {
    let mut unit = vec!["0"; 36];
    unit[14] = "100";
    let stiffness = unit.join(",");
    unit[14] = "2";
    let damping = unit.join(",");
    for more in ["CRATIO=0.02", "CMATRIX=2"] {
        let deck = format!(
            "block
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
MATRIX/1, FULL=CORDER, ROWS=6, COLUMNS=6, VALUES={stiffness}
MATRIX/2, FULL=CORDER, ROWS=6, COLUMNS=6, VALUES={damping}
NFORCE/1, IMARKERS=20, J=1, KMATRIX=1, {more}
END
"
        );
        let (_, ran, folder) = run(&deck, "SIM/INITIAL_CONDITIONS\nLINEAR/EIGENSOL");
        let modes = text(folder.path(), "deck.modes.json");
        let modes: serde_json::Value = serde_json::from_str(&modes).unwrap();
        let mode = &modes["modes"][0];
        near(mode["real"].as_f64().unwrap(), -1.0, 1e-9);
        near(mode["imaginary"].as_f64().unwrap(), 99f64.sqrt(), 1e-9);
        assert_eq!(
            modes["modes"].as_array().unwrap().len(),
            1,
            "{}",
            ran.stdout
        );
    }
}
