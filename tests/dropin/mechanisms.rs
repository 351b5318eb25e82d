//! Mechanisms with known motions through `mdi`: Andrews' squeezer, a heavy top, the IFToMM benchmark, state matrices.

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

/// Checks the end of the motion against the reference, which has sixteen digits.
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

/// Checks the steady precession of a heavy top at 60 degrees, with A = 0.3 about its tip, C = 0.1, m g l = 4.905 and axial spin 60.
///
/// The precession rates are the roots of `A cos(theta) W^2 - C w W + m g l`.
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

const SI: &str = "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";

/// Returns a rod of 1 m and 1 kg from `a` to `b` with its origin at `a`; marker `part * 100` is at its middle, further markers are at both
/// ends.
fn rod(
    part: u32,
    [a, b]: [[f64; 3]; 2],
    thick: f64,
    [at_a, at_b]: [&str; 2],
    rest: &str,
) -> String {
    let d = [0, 1, 2].map(|k| b[k] - a[k]);
    let across = 1.0 / 12.0 + thick * thick / 16.0;
    let ip = d.map(|d| {
        if d == 0.0 {
            across
        } else {
            thick * thick / 8.0
        }
    });
    let (m, list) = (part * 100, |v: [f64; 3]| {
        format!("{},{},{}", v[0], v[1], v[2])
    });
    format!(
        "PART/{part}, MASS=1, CM={m}, IP={}, QG={}{rest}\nMARKER/{m}, PART={part}, QP={}\n\
         MARKER/{}, PART={part}{at_a}\nMARKER/{}, PART={part}, QP={}{at_b}\n",
        list(ip),
        list(a),
        list(d.map(|d| 0.5 * d)),
        m + 1,
        m + 2,
        list(d)
    )
}

/// A02 of the benchmark: a row of adjacent four-bar windows. PART/1001 is the second of the horizontal rods.
fn four_bars(windows: u32) -> String {
    let mut deck = format!("four-bars\n{SI}");
    let mut joints = Vec::new();
    for k in 0..=windows {
        let x = f64::from(k);
        let ends = [[x, 0.0, 0.0], [x, 1.0, 0.0]];
        deck += &rod(2 + k, ends, 0.1, ["", ""], ", VX=0.5, WZ=-1");
        deck += &format!("MARKER/{}, PART=1, QP={k},0,0\n", 9_000_000 + k);
        joints.push(((2 + k) * 100 + 1, 9_000_000 + k));
    }
    for k in 0..windows {
        let (x, part) = (f64::from(k), 1000 + k);
        let ends = [[x, 1.0, 0.0], [x + 1.0, 1.0, 0.0]];
        deck += &rod(part, ends, 0.1, ["", ""], ", VX=1");
        joints.push((part * 100 + 1, (2 + k) * 100 + 2));
        joints.push((part * 100 + 2, (3 + k) * 100 + 2));
    }
    for (k, (i, j)) in joints.iter().enumerate() {
        deck += &format!("JOINT/{}, REVOLUTE, I={i}, J={j}\n", k + 1);
    }
    deck + "ACCGRAV/JGRAV=-9.81\nINTEGRATOR/GSTIFF, ERROR=1E-6\nRESULTS/FORMATTED, XRF\nEND\n"
}

/// All rods stay parallel, so one equation holds: `J q'' = m g sin q` with q from the vertical. Returns the rates of q and q'.
fn rate_of_four_bars(windows: u32) -> impl Fn([f64; 2]) -> [f64; 2] {
    let [inertia, weight] = inertia_and_weight_of_four_bars(windows);
    move |[q, w]| [w, weight * q.sin() / inertia]
}

/// Returns the inertia for the rotation of the upright rods, and the weight for the height of their ends.
fn inertia_and_weight_of_four_bars(windows: u32) -> [f64; 2] {
    let n = f64::from(windows);
    let third = 1.0 / 3.0 + 0.01 / 16.0;
    [(n + 1.0) * third + n, (0.5 * (n + 1.0) + n) * 9.81]
}

/// Checks that redundant equations are found in large mechanisms: three per window, without which no freedom would remain.
///
/// Up to about a hundred windows they are rotations, as in ADAMS; in larger mechanisms an elimination selects them.
#[test]
fn a_long_row_of_four_bars_moves() {
    for windows in [100, 200] {
        let commands = "SIMULATE/DYNAMIC, END=0.2, STEPS=2";
        let (found, ran, _folder) = run(&four_bars(windows), commands);
        assert!(!ran.stdout.contains("kinematically determinate"));
        let out = ran.stdout.split("deactivating constraint equation  ");
        let out: Vec<&str> = out.skip(1).collect();
        assert_eq!(out.len() as u32, 3 * windows);
        if windows == 100 {
            assert!(out.iter().all(|name| !name.starts_with("D.")), "{out:?}");
        }
        let rate = rate_of_four_bars(windows);
        let mut exact = [0.0, 1.0];
        for _ in 0..200 {
            exact = runge_kutta(&rate, exact, 1e-3);
        }
        let last = |component: &str| {
            *found
                .column("PART_1001_XFORM", component)
                .last()
                .expect("a value")
        };
        near(last("X"), 1.0 + exact[0].sin(), 1e-6);
        near(last("Y"), exact[0].cos(), 1e-6);
    }
}

/// Checks singular positions: the rods are collinear ten times in ten seconds, where the mechanism could branch into other motions.
#[test]
fn four_bars_pass_their_singular_positions() {
    let (found, ran, _folder) = run(&four_bars(2), "SIMULATE/DYNAMIC, END=10, STEPS=1000");
    assert!(ran.stdout.contains("redundant constraints"));

    let rate = rate_of_four_bars(2);
    let mut exact: [f64; 2] = [0.0, 1.0];
    let (x, y) = (
        found.column("PART_1001_XFORM", "X"),
        found.column("PART_1001_XFORM", "Y"),
    );
    assert_eq!(x.len(), 1001);
    let mut turned = 0;
    for k in 0..x.len() {
        near(x[k], 1.0 + exact[0].sin(), 1e-5);
        near(y[k], exact[0].cos(), 1e-5);
        let before = exact[0];
        for _ in 0..20 {
            exact = runge_kutta(&rate, exact, 0.01 / 20.0);
        }
        let quarter = |q: f64| (q / std::f64::consts::PI + 0.5).floor();
        turned += usize::from(quarter(before) != quarter(exact[0]));
    }
    assert_eq!(turned, 10, "positions in one line");

    // The energy computed from the velocity of one rod equals the initial energy.
    let [vx, vy] = ["VX", "VY"].map(|component| found.column("PART_1001_XFORM", component));
    let [inertia, weight] = inertia_and_weight_of_four_bars(2);
    let energy = |k: usize| 0.5 * inertia * (vx[k] * vx[k] + vy[k] * vy[k]) + weight * y[k];
    for k in 0..x.len() {
        let drift = energy(k) / energy(0) - 1.0;
        assert!(drift.abs() < 1e-6, "{k}: {drift:e}");
    }
}

/// Takes one step of the classical fourth-order Runge-Kutta method.
fn runge_kutta(rate: impl Fn([f64; 2]) -> [f64; 2], y: [f64; 2], h: f64) -> [f64; 2] {
    let from = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let a = rate(y);
    let b = rate(from(a, 0.5 * h));
    let c = rate(from(b, 0.5 * h));
    let d = rate(from(c, h));
    [0, 1].map(|k| y[k] + h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]))
}

/// A04 of the benchmark: Bricard's loop of six revolute joints along the edges of a cube.
///
/// It moves although it has one more equation than it has freedoms, and conserves its energy.
#[test]
fn bricards_loop_moves_and_keeps_its_energy() {
    const CORNERS: [[f64; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, -1.0, 1.0],
        [0.0, -1.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    let (x, y, z) = (", REULER=90D,90D,0", ", REULER=0,-90D,0", "");
    let axes = [y, z, x, y, z, x];
    let thick = 0.1;
    let mut deck = format!(
        "bricard\n{SI}MARKER/11, PART=1{}\nMARKER/12, PART=1, QP=0,0,1{}\n",
        axes[0], axes[5]
    );
    for k in 0..5 {
        let part = k as u32 + 2;
        let ends = [CORNERS[k], CORNERS[k + 1]];
        deck += &rod(part, ends, thick, [axes[k], axes[k + 1]], "");
        let before = if k == 0 { 11 } else { part * 100 - 98 };
        let joint = format!("REVOLUTE, I={}, J={before}", part * 100 + 1);
        deck += &format!("JOINT/{}, {joint}\n", k + 1);
    }
    deck += "JOINT/6, REVOLUTE, I=602, J=12\nACCGRAV/JGRAV=-9.81\nINTEGRATOR/GSTIFF, ERROR=1E-6\n\
             RESULTS/FORMATTED, XRF\nEND\n";
    let (found, ..) = run(&deck, "SIMULATE/DYNAMIC, END=10, STEPS=500");
    let column = |part: usize, name: &str| found.column(&format!("PART_{part}_XFORM"), name);
    let three = |part: usize, names: [&str; 3]| names.map(|name| column(part, name));
    let rods: Vec<[[Vec<f64>; 3]; 4]> = (2..7)
        .map(|part| {
            [
                three(part, ["X", "Y", "Z"]),
                three(part, ["VX", "VY", "VZ"]),
                three(part, ["WX", "WY", "WZ"]),
                three(part, ["PSI", "THETA", "PHI"]),
            ]
        })
        .collect();
    let energy = |step: usize| -> f64 {
        let at = |columns: &[Vec<f64>; 3]| {
            nalgebra::Vector3::new(columns[0][step], columns[1][step], columns[2][step])
        };
        let of = |k: usize| {
            let [p, v, w, angles] = &rods[k];
            let (p, v, w, angles) = (at(p), at(v), at(w), at(angles));
            let turn = |axis, angle| nalgebra::Rotation3::from_axis_angle(&axis, angle);
            let (z, x) = (nalgebra::Vector3::z_axis(), nalgebra::Vector3::x_axis());
            let turned = turn(z, angles[0]) * turn(x, angles[1]) * turn(z, angles[2]);
            let along =
                nalgebra::Vector3::from(CORNERS[k + 1]) - nalgebra::Vector3::from(CORNERS[k]);
            let (axis, middle) = (turned * along, turned * along * 0.5);
            // A round rod: J w = across w + (along - across) axis (axis . w).
            let (across, own) = (1.0 / 12.0 + thick * thick / 16.0, thick * thick / 8.0);
            let spin = axis.dot(&w);
            let turning = across * (w.norm_squared() - spin * spin) + own * spin * spin;
            0.5 * (v + w.cross(&middle)).norm_squared() + 0.5 * turning + 9.81 * (p + middle).y
        };
        (0..5).map(of).sum()
    };
    let first = energy(0);
    for step in 0..=500 {
        near(energy(step), first, 1e-6);
    }
    // The far corner moves over its whole range.
    let way = column(5, "X");
    let low = way.iter().copied().fold(f64::INFINITY, f64::min);
    near(low, -1.0, 1e-3);
}

/// Returns the numbers of a file for MATLAB's `load`.
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

/// Checks the state matrices of a block of 2 kg on a spring of 100 N/m and 2 Ns/m, driven by an input and its first-order filter.
///
/// Position and acceleration are outputs.
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
    // Without inputs only A is written; missing objects are named.
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

/// Checks a block of 2 kg on a spring of 100 N/m and 0.4 Ns/m that slides on an arm rotating at 3 rad/s, `r'' = -41 r - 0.2 r'` about its
/// rest.
///
/// The state matrix contains this equation along the arm, chosen by RM or by PSTATE. With one coordinate in ground, `y = r sin(3 t)`, its
/// coefficients hold only for an instant: `y'' = (-50 + 0.2 q - 2 q^2) y + (-0.2 + 2 q) y'`, `q = 3 cot(3 t)`.
#[test]
fn states_of_a_moving_system_are_coordinates_and_their_rates() {
    let deck = "arm
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1, WZ=3
MARKER/20, PART=2
MARKER/25, PART=2, REULER=90D,90D,0D
JOINT/1, REVOLUTE, I=20, J=1
MOTION/1, JOINT=1, VELOCITY, FUNCTION=3
PART/3, MASS=2, CM=30, IP=0.1,0.1,0.1, QG=0.7,0,0, VX=0.2, VY=2.1, WZ=3
MARKER/30, PART=3
MARKER/31, PART=3, REULER=90D,90D,0D
JOINT/2, TRANSLATIONAL, I=31, J=25
SPRINGDAMPER/1, TRANSLATIONAL, I=30, J=20, K=100, LENGTH=0.5, C=0.4
SFORCE/1, TRANSLATIONAL, I=30, J=20, FUNCTION=VARVAL(1)
VARIABLE/1, FUNCTION=0
VARIABLE/2, FUNCTION=DX(30,20,20)
VARIABLE/3, FUNCTION=ACCX(30,20,20,20)
VARIABLE/4, FUNCTION=VX(30,20,20)
PINPUT/1, VARIABLES=1
POUTPUT/1, VARIABLES=2,3
PSTATE/1, VARIABLES=2
PSTATE/2, VARIABLES=4
INTEGRATOR/GSTIFF, ERROR=1E-6
END
";
    let q = 3.0 / 2.1f64.tan();
    let (near, s) = (1e-6, 2.1f64.sin());
    for (asked, by_place, by_rate, scale, of_place) in [
        (
            "",
            -50.0 + 0.2 * q - 2.0 * q * q,
            -0.2 + 2.0 * q,
            s,
            -41.0 + 0.2 * q,
        ),
        (", RM=20", -41.0, -0.2, 1.0, -41.0),
        (", PSTATE=1", -41.0, -0.2, 1.0, -41.0),
    ] {
        let commands = format!(
            "SIM/DYN, END=0.7, STEPS=7\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=1, FILE=arm, FORMAT=MATLAB{asked}\nLINEAR/EIGENSOL{asked}"
        );
        let (_, ran, folder) = run(deck, &commands);
        let read = |suffix: &str| matrix(folder.path(), &format!("arm{suffix}"));
        let close = |found: Vec<Vec<f64>>, expected: &[[f64; 2]]| {
            for (row, expected) in found.iter().zip(expected) {
                for (a, b) in row.iter().zip(expected) {
                    assert!((a - b).abs() < near, "{asked}: {found:?} {expected:?}");
                }
            }
        };
        close(read("a"), &[[0.0, 1.0], [by_place, by_rate]]);
        close(
            read("c"),
            &[[1.0 / scale, 0.0], [of_place / scale, -0.2 / scale]],
        );
        assert!((read("b")[1][0] - 0.5 * scale).abs() < near);
        // EIGENSOL has the same states.
        let swing = (-by_place - 0.25 * by_rate * by_rate).sqrt() / std::f64::consts::TAU;
        let table = ran.stdout.split("E I G E N").nth(1).unwrap();
        let row = table.lines().nth(2).unwrap();
        let found: f64 = row.rsplit(' ').next().unwrap().parse().unwrap();
        assert!((found - swing).abs() < 1e-5, "{asked}: {row} {swing}");
    }
    let acf = "\nfile/model=deck\nSIM/DYN, END=0.7, STEPS=7\nLINEAR/EIGENSOL, PSTATE=2\nLINEAR/EIGENSOL, RM=99\nstop\n";
    let folder = crate::run::folder(&[("deck.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 1);
    for told in ["VARIABLE/4 is not a coordinate", "MARKER/99"] {
        assert!(ran.stdout.contains(told), "{}", ran.stdout);
    }
}

/// Checks that a ball in flight, saved and reloaded in another run, continues its flight.
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

/// Checks that a force pulse of two milliseconds inside a large step is not skipped: v = impulse / m.
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

/// Checks the damping of an NFORCE of 100 N/m with CRATIO 0.02 or an equal CMATRIX, that is 2 Ns/m, on 1 kg: eigenvalues -1 +- i sqrt(99).
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
