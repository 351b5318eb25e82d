//! Massless parts in motion, positioned by springs, damping or constraints, compared with closed forms.

use crate::run::{Ran, Results, folder, mdi, text};

/// A block of 2 kg and a massless slider between it and ground, on the same rail.
const RAIL: &str = "rail
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, REULER=90D,90D,0
PART/2, QG=1,0,0
MARKER/20, PART=2, REULER=90D,90D,0
PART/3, MASS=2, CM=30, IP=1,1,1, QG=2.1,0,0
MARKER/30, PART=3, REULER=90D,90D,0
JOINT/1, TRANSLATIONAL, I=20, J=1
JOINT/2, TRANSLATIONAL, I=30, J=1
INTEGRATOR/ERROR=1E-7
RESULTS/XRF
";

fn run(deck: &str, commands: &str) -> (Results, Ran) {
    let acf = format!("\nfile/model=small\n{commands}\nstop\n");
    let folder = folder(&[("small.adm", &format!("{deck}END\n")), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read_all(folder.path(), "small.res"), ran)
}

fn worst(found: &[f64], expected: impl Fn(usize) -> f64) -> f64 {
    let off = found
        .iter()
        .enumerate()
        .map(|(k, x)| (x - expected(k)).abs());
    off.fold(0.0, f64::max)
}

/// Checks springs of 300 and 600 N/m in series, which act like one of 200 N/m.
///
/// The block swings by 0.1 m about x = 2 at 10 rad/s, and the slider by 200/300 of that. The slider starts away from its equilibrium.
#[test]
fn springs_in_a_row_swing_as_one() {
    let springs = "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=300, LENGTH=1
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K=600, LENGTH=1\n";
    let (results, ran) = run(&format!("{RAIL}{springs}"), "SIM/DYN, END=2, STEPS=100");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let swing = |k: usize| 0.1 * (10.0 * 0.02 * k as f64).cos();
    let block = results.column("PART_3_XFORM", "X");
    assert_eq!(block.len(), 101);
    assert!(worst(&block, |k| 2.0 + swing(k)) < 1e-6);
    let slider = results.column("PART_2_XFORM", "X");
    assert!(worst(&slider[1..], |k| 1.0 + swing(k + 1) / 1.5) < 1e-6);
    let speed = results.column("PART_2_XFORM", "VX");
    let expected = |k: usize| -(10.0 * 0.02 * (k + 1) as f64).sin() / 1.5;
    assert!(worst(&speed[1..], expected) < 1e-5);
}

/// Checks a damper and a spring in series: with c y' = k (x - y) and 2 x'' = -k (x - y), f = k (x - y) obeys f'' + (k/c) f' + (k/2) f = 0.
#[test]
fn a_damper_and_a_spring_in_a_row_creep() {
    let (k, c) = (200.0_f64, 50.0);
    let row = format!(
        "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, C={c}, LENGTH=1
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K={k}, LENGTH=1\n"
    );
    let (results, ran) = run(&format!("{RAIL}{row}"), "SIM/DYN, END=2, STEPS=100");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    // Initial values f = 20 N and f' = -k y' = -k f / c.
    let (decay, stiffness) = (k / c, k / 2.0);
    let turn = (stiffness - decay * decay / 4.0).sqrt();
    let force = |t: f64| {
        let slope = (-20.0 * decay + 20.0 * decay / 2.0) / turn;
        (-decay * t / 2.0).exp() * (20.0 * (turn * t).cos() + slope * (turn * t).sin())
    };
    let x = results.column("PART_3_XFORM", "X");
    let y = results.column("PART_2_XFORM", "X");
    let found: Vec<f64> = x.iter().zip(&y).map(|(x, y)| k * (x - y - 1.0)).collect();
    assert!(worst(&found, |n| force(0.02 * n as f64)) < 2e-4);
}

/// Checks two bushings in series, with a massless part of six freedoms between them, which act like one of half the stiffness.
#[test]
fn bushings_in_a_row_are_one_of_half() {
    let head = "bushings
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/3, MASS=2, CM=30, IP=0.2,0.3,0.4, QG=0.01,0.02,-0.01, VX=0.1, WZ=0.02
MARKER/30, PART=3, QP=0.1,0.2,0.05
MARKER/31, PART=3
ACCGRAV/KGRAV=-9.81
INTEGRATOR/ERROR=1E-7
RESULTS/XRF
";
    let law = |scale: f64| {
        let of = |values: [f64; 3]| values.map(|v| (v * scale).to_string()).join(",");
        let (k, kt) = (of([4e4; 3]), of([2e5; 3]));
        let (c, ct) = (of([40.0; 3]), of([200.0; 3]));
        format!("K={k}, KT={kt}, C={c}, CT={ct}")
    };
    let two = format!(
        "{head}PART/2, QG=0.005,0.01,-0.005\nMARKER/2, PART=2\nMARKER/3, PART=2\nBUSHING/1, I=2, J=1, {0}\nBUSHING/2, I=31, J=3, {0}\n",
        law(1.0)
    );
    let one = format!("{head}BUSHING/1, I=31, J=1, {}\n", law(0.5));
    let (two, ran) = run(&two, "SIM/DYN, END=0.5, STEPS=50");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let (one, _) = run(&one, "SIM/DYN, END=0.5, STEPS=50");
    for component in ["X", "Y", "Z"] {
        let expected = one.column("PART_3_XFORM", component);
        let found = two.column("PART_3_XFORM", component);
        // Half of the rotation is in the force axes of the second bushing, which is a second-order difference.
        let off = worst(&found, |k| expected[k]);
        assert!(off < 2e-6, "{component} {off:e}");
    }
}

/// Checks the eigenvalues of a system with a massless part on stiffness alone, and with damping.
#[test]
fn eigenvalues_leave_out_what_has_no_mass() {
    let modes = |statements: &str| {
        let deck = format!("{RAIL}{statements}END\n");
        let acf = "\nfile/model=small\nSIM/STAT\nLINEAR/EIGENSOL\nstop\n";
        let folder = folder(&[("small.adm", &deck), ("run.acf", acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        let text = std::fs::read(folder.path().join("small.modes.json"));
        let text = text.unwrap_or_else(|_| panic!("{}", ran.stdout));
        let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let modes = value["modes"].as_array().unwrap().clone();
        let number = |mode: &serde_json::Value, key: &str| mode[key].as_f64().unwrap();
        let found: Vec<(f64, f64)> = modes
            .iter()
            .map(|mode| (number(mode, "real"), number(mode, "imaginary")))
            .collect();
        found
    };
    let near = |found: (f64, f64), real: f64, imaginary: f64| {
        let off = (found.0 - real).abs().max((found.1 - imaginary).abs());
        assert!(off < 1e-8, "{found:?}");
    };
    let springs = "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=300, LENGTH=1
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K=600, LENGTH=1\n";
    let found = modes(springs);
    assert_eq!(found.len(), 1, "{found:?}");
    near(found[0], 0.0, 10.0);
    // With a damper of 30 Ns/m on the first spring: 2 s^2 + 600 (300 + 30 s) / (900 + 30 s) = 0, that is s^3 + 30 s^2 + 300 s + 3000.
    let damped = springs.replace("K=300", "K=300, C=30");
    let found = modes(&damped);
    assert_eq!(found.len(), 2, "{found:?}");
    for (real, imaginary) in found {
        let s = nalgebra::Complex::new(real, imaginary);
        let left = ((s + 30.0) * s + 300.0) * s + 3000.0;
        assert!(left.norm() < 1e-6, "{s} {left}");
    }
}

/// Returns the matrices written by a run, the file of states, and the run itself.
fn state_matrices(statements: &str) -> ([Vec<Vec<f64>>; 4], String, Ran) {
    let ports = "SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=VARVAL(1)
VARIABLE/1, FUNCTION=0
VARIABLE/2, FUNCTION=DX(30)
VARIABLE/3, FUNCTION=DX(20)
PINPUT/1, VARIABLES=1
POUTPUT/2, VARIABLES=2,3
";
    let deck = format!("{RAIL}{ports}{statements}END\n");
    let acf = "\nfile/model=small\nSIM/STAT\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=2, FILE=plant, FORMAT=MATLAB\nstop\n";
    let folder = folder(&[("small.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let text = |suffix: &str| {
        let path = folder.path().join(format!("plant{suffix}"));
        std::fs::read_to_string(path).unwrap_or_default()
    };
    let numbers = |line: &str| {
        line.split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect()
    };
    let read = |suffix: &str| text(suffix).lines().map(numbers).collect();
    (["a", "b", "c", "d"].map(read), text("st"), ran)
}

fn same(found: &[Vec<f64>], expected: &[&[f64]]) {
    let all: Vec<f64> = found.concat();
    let known: Vec<f64> = expected.concat();
    assert_eq!((found.len(), all.len()), (expected.len(), known.len()));
    let off = worst(&all, |k| known[k]);
    assert!(off < 1e-9, "{found:?} {expected:?}");
}

/// Checks springs of 300 and 600 N/m with a force w on the massless slider: y = (600 x + w)/900 and 2 x'' = -600 (x - y).
#[test]
fn state_matrices_have_no_states_of_what_stiffness_alone_holds() {
    let springs = "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=300, LENGTH=1
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K=600, LENGTH=1\n";
    let ([a, b, c, d], states, ran) = state_matrices(springs);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    same(&a, &[&[0.0, 1.0], &[-100.0, 0.0]]);
    same(&b, &[&[0.0], &[1.0 / 3.0]]);
    same(&c, &[&[1.0, 0.0], &[2.0 / 3.0, 0.0]]);
    same(&d, &[&[0.0], &[1.0 / 900.0]]);
    assert_eq!(states.matches("PART/3").count(), 2, "{states}");
    // The velocity of the slider would be 2/3 x' + w'/900, with the derivative of the input.
    let other = springs.to_string() + "VARIABLE/4, FUNCTION=VX(20)\nPOUTPUT/3, VARIABLES=4\n";
    let deck = format!(
        "{RAIL}SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=VARVAL(1)\nVARIABLE/1, FUNCTION=0\nPINPUT/1, VARIABLES=1\n{other}"
    );
    let commands = "SIM/STAT\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=3, FORMAT=MATLAB";
    let acf = format!("\nfile/model=small\n{commands}\nstop\n");
    let folder = folder(&[("small.adm", &format!("{deck}END\n")), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let told = "VARIABLE/4 depends on the rate of an input";
    assert!(ran.stdout.contains(told), "{}", ran.stdout);
}

/// Checks a damper of 30 Ns/m on the first spring, which makes the slider a state: 30 y' = -900 y + 600 x + w.
#[test]
fn state_matrices_have_a_state_of_what_damping_holds() {
    let damped = "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=300, C=30, LENGTH=1
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K=600, LENGTH=1\n";
    let ([a, b, c, d], states, ran) = state_matrices(damped);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    same(
        &a,
        &[&[-30.0, 20.0, 0.0], &[0.0, 0.0, 1.0], &[300.0, -300.0, 0.0]],
    );
    same(&b, &[&[1.0 / 30.0], &[0.0], &[0.0]]);
    same(&c, &[&[0.0, 1.0, 0.0], &[1.0, 0.0, 0.0]]);
    same(&d, &[&[0.0], &[0.0]]);
    assert_eq!(states.lines().count(), 3, "{states}");
    // A slider that nothing holds is refused by name.
    let (_, _, ran) = state_matrices("SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=1, K=600, LENGTH=1\n");
    assert!(
        ran.stdout.contains("PART/2 along x has no inertia"),
        "{}",
        ran.stdout
    );
}

#[test]
fn state_matrices_without_states_are_those_of_the_outputs() {
    let deck = "statemat without freedom
PART/1, GROUND
PART/2, MASS=1, CM=2, IP=1,1,1
MARKER/1, PART=1
MARKER/2, PART=2
JOINT/1, FIXED, I=2, J=1
VARIABLE/1, FUNCTION=0
VARIABLE/2, FUNCTION=2*VARVAL(1)
VARIABLE/3, FUNCTION=TIME
PINPUT/1, VARIABLES=1
POUTPUT/1, VARIABLES=2,3
END
";
    let acf =
        "deck\n\nSIM/STAT\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=1, FILE=mat, FORMAT=MATLAB\nSTOP\n";
    let folder = folder(&[("deck.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "b", "run.acf"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
    let d = text(folder.path(), "matd");
    let numbers: Vec<f64> = d.split_whitespace().map(|x| x.parse().unwrap()).collect();
    assert_eq!(numbers, [2.0, 0.0]);
    assert_eq!(text(folder.path(), "mata").trim(), "");
}
