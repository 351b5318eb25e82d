//! Motions known in closed form, or by an ordinary differential equation of one angle, through `mdi`.

use std::f64::consts::{PI, TAU};

use crate::common::shared;
use crate::run::{Results, folder, mdi};
use crate::squeezer::squeezer;

const SI: &str = "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";

fn run(deck: &str, commands: &str) -> Results {
    let acf = format!("\nfile/model=deck\n{commands}\nstop\n");
    let folder = folder(&[("deck.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    Results::read_all(folder.path(), "deck.res")
}

fn near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() < error, "{found} and {expected}");
}

/// Compares every output of a column with a function of time.
fn all_near(results: &Results, column: (&str, &str), error: f64, expected: impl Fn(f64) -> f64) {
    let times = results.column("time", "TIME");
    for (time, found) in times.iter().zip(results.column(column.0, column.1)) {
        let expected = expected(*time);
        assert!(
            (found - expected).abs() < error,
            "{column:?} at {time}: {found} and {expected}"
        );
    }
}

/// Integrates `q'' = second(q, q')` from rest at zero by a Runge-Kutta method; returns q and its rate every 0.01 s up to the end.
fn swung(second: impl Fn(f64, f64) -> f64, end: f64) -> Vec<[f64; 2]> {
    let h = 5e-4;
    let rate = |[q, w]: [f64; 2]| [w, second(q, w)];
    let from = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let mut y = [0.0; 2];
    let mut out = vec![y];
    for step in 1..=(end / h).round() as usize {
        let a = rate(y);
        let b = rate(from(y, a, h / 2.0));
        let c = rate(from(y, b, h / 2.0));
        let d = rate(from(y, c, h));
        y = [0, 1].map(|k| y[k] + h / 6.0 * (a[k] + 2.0 * (b[k] + c[k]) + d[k]));
        if step % 20 == 0 {
            out.push(y);
        }
    }
    out
}

/// Checks a pendulum (1 kg at 2 m, 0.1 kg m2) on several joints against its equation.
///
/// The tables of real ADAMS deviate by 4e-4 of the range for the spherical and universal joint, and by 2e-5 for the sprung joint. They are
/// therefore not accurate enough as a reference.
#[test]
fn pendulums_on_every_joint_follow_their_equation() {
    let Some(decks) = shared("real-dynamics/chrono-joints") else {
        return;
    };
    let spring = "SFORCE/1, FUNCTION=-200*AZ(207,208)-10*WZ(207,208,208)\n";
    for (name, redefined, stiffness, damping) in [
        ("Revolute", "", 0.0, 0.0),
        ("Spherical", "", 0.0, 0.0),
        ("Universal", "", 0.0, 0.0),
        ("RotSpring", spring, 200.0, 10.0),
    ] {
        let path = decks.join(format!("test_{name}_Case01.adm"));
        let deck = std::fs::read_to_string(path).unwrap();
        let deck =
            deck.trim_end().trim_end_matches("END").to_string() + "\nRESULTS/FORMATTED, XRF\nEND\n";
        let commands =
            format!("{redefined}INTEGRATOR/GSTIFF, ERROR=1e-8\nSIMULATE/DYNAMIC, END=5, STEPS=500");
        let found = run(&deck, &commands);
        let weight = 9.80665 * 2.0;
        let second = |q: f64, w: f64| (weight * q.cos() - stiffness * q - damping * w) / 4.1;
        let expected = swung(second, 5.0);
        let spins = ["WX", "WY", "WZ"].map(|axis| found.column("PART_2_XFORM", axis));
        assert_eq!(spins[0].len(), expected.len());
        for (k, [_, rate]) in expected.iter().enumerate() {
            let spin = spins.iter().map(|w| w[k] * w[k]).sum::<f64>().sqrt();
            assert!(
                (spin - rate.abs()).abs() < 1e-7,
                "{name} {k}: {spin} {rate}"
            );
        }
    }
}

/// Checks initial accelerations and the first two multipliers against the reference of the test set for initial value problems.
#[test]
fn andrews_squeezer_begins_as_the_reference_does() {
    let found = run(&squeezer(), "SIMULATE/DYNAMIC, END=0.001, STEPS=1");
    let first = |entity: &str, component: &str| found.column(entity, component)[0];
    let beta = first("PART_10_XFORM", "WDZ");
    near(beta, 14_222.443_919_954_1, 1e-7);
    near(
        first("PART_20_XFORM", "WDZ") - beta,
        -10_666.832_939_965_6,
        1e-7,
    );
    near(first("JOINT_8", "FX").abs(), 98.566_870_396_241_1, 1e-9);
    near(first("JOINT_8", "FY").abs(), 6.122_688_344_255_66, 1e-9);
}

/// Checks a mass on a shaking base with each damping element: transmissibility and phase follow from `k + i w c`.
#[test]
fn a_mass_on_a_shaker_answers_as_its_spring_and_damper_do() {
    let (mass, k, c, size) = (10.0, 4e4, 150.0, 1e-3);
    let diagonal = |value: f64| {
        let entries = (0..36).map(|at| if at % 7 == 0 { value } else { 0.0 });
        entries.map(|x| x.to_string()).collect::<Vec<_>>().join(",")
    };
    let field = format!(
        "FIELD/1, I=30, J=21, LENGTH=0,0,0,0,0,0\n, KMATRIX={}",
        diagonal(k)
    );
    let elements = [
        format!("SFORCE/1, TRANSLATIONAL, I=30, J=22, FUNCTION=-{k}*(DM(30,22)-1)-{c}*VR(30,22)"),
        format!("SPRINGDAMPER/1, TRANSLATIONAL, I=30, J=22, K={k}, C={c}, LENGTH=1"),
        format!("BUSHING/1, I=30, J=21, K=1E5,1E5,{k}, C=10,10,{c}, KT=10,10,10, CT=1,1,1"),
        format!("{field}\n, CRATIO={}", c / k),
        format!("{field}\n, CMATRIX={}", diagonal(c)),
    ];
    for n in 0..20 {
        let w = TAU * f64::from(n + 1);
        let element = &elements[n as usize % elements.len()];
        let deck = format!(
            "shaker\n{SI}PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/22, PART=2, QP=0,0,-1\n\
             PART/3, MASS={mass}, CM=30, IP=1,1,1\nMARKER/30, PART=3\nJOINT/1, TRANSLATIONAL, I=20, J=1\nJOINT/2, TRANSLATIONAL, I=30, J=1\n\
             MOTION/1, JOINT=1, TRANSLATIONAL, FUNCTION={size}*SIN({w:.17}*TIME)\n{element}\nINTEGRATOR/GSTIFF, ERROR=1E-8\n\
             RESULTS/FORMATTED, XRF\nEND\n"
        );
        // The transient decays as exp(-7.5 t).
        let found = run(
            &deck,
            &format!(
                "SIMULATE/DYNAMIC, END=3, STEPS=1\nSIMULATE/DYNAMIC, DURATION={}, STEPS=16",
                TAU / w
            ),
        );
        let complex = |re: f64, im: f64| nalgebra::Complex::new(re, im);
        let answer = complex(k, w * c) / complex(k - mass * w * w, w * c);
        let times = found.column("time", "TIME");
        let places = found.column("PART_3_XFORM", "Z");
        assert_eq!(places.len(), 18);
        for (time, place) in times.iter().zip(&places).filter(|(time, _)| **time >= 3.0) {
            let expected = size * (answer * complex(0.0, w * time).exp()).im;
            let off = (place - expected).abs() / (size * answer.norm());
            assert!(off < 1e-6, "{element}, {w}: {off:e}");
        }
    }
}

/// Checks a driven slider crank, known in closed form, for every command that moves it; the reaction on its slider is its inertia force.
#[test]
fn a_slider_crank_is_where_its_drive_puts_it() {
    let (r, l) = (0.1, 0.3);
    let deck = format!(
        "crank\n{SI}PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nMARKER/21, PART=2, QP={r},0,0\n\
         PART/3, MASS=1, CM=30, IP=1,1,1, QG={r},0,0\nMARKER/30, PART=3\nMARKER/31, PART=3, QP={l},0,0\n\
         PART/4, MASS=1, CM=40, IP=1,1,1, QG=0.4,0,0\nMARKER/40, PART=4\nMARKER/41, PART=4, REULER=90D,90D,0\n\
         MARKER/11, PART=1, REULER=90D,90D,0\nJOINT/1, REVOLUTE, I=20, J=1\nJOINT/2, REVOLUTE, I=30, J=21\n\
         JOINT/3, REVOLUTE, I=40, J=31\nJOINT/4, TRANSLATIONAL, I=41, J=11\n\
         MOTION/1, JOINT=1, ROTATIONAL, FUNCTION=3*TIME+0.5*SIN(2*TIME)\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let angle = |t: f64| 3.0 * t + 0.5 * (2.0 * t).sin();
    let (rate, second) = (
        |t: f64| 3.0 + (2.0 * t).cos(),
        |t: f64| -2.0 * (2.0 * t).sin(),
    );
    // Position of the slider as a function of the angle, with two derivatives.
    let place = |t: f64| {
        let (s, c) = angle(t).sin_cos();
        let q = (l * l - r * r * s * s).sqrt();
        let by = -r * s - r * r * s * c / q;
        let twice = -r * c - r * r * ((c * c - s * s) / q + r * r * s * s * c * c / q.powi(3));
        (r * c + q, by, twice)
    };
    let acceleration = |t: f64| place(t).2 * rate(t) * rate(t) + place(t).1 * second(t);
    for command in ["KINEMATIC", "DYNAMIC", "TRANSIENT"] {
        let found = run(&deck, &format!("SIMULATE/{command}, END=3, STEPS=100"));
        all_near(&found, ("PART_4_XFORM", "X"), 1e-12, |t| place(t).0);
        let speed = |t: f64| place(t).1 * rate(t);
        all_near(&found, ("PART_4_XFORM", "VX"), 1e-12, speed);
        all_near(&found, ("PART_4_XFORM", "ACCX"), 1e-11, acceleration);
        let pushed = found.column("JOINT_3", "FX");
        for (t, force) in found.column("time", "TIME").iter().zip(pushed) {
            near(force.abs(), acceleration(*t).abs(), 1e-11);
        }
    }
}

/// Checks that a MOTION has the exact second derivative of its function, independent of the output interval.
///
/// Cases are a fast sine, and a spline at the ends of its data, where the natural spline has zero second derivative. A variable in between
/// changes nothing.
#[test]
fn a_driven_acceleration_is_that_of_its_function() {
    let deck = |statements: &str| {
        format!(
            "block\n{SI}PART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n\
             {statements}RESULTS/FORMATTED, XRF\nEND\n"
        )
    };
    let sine = "0.01*SIN(314*TIME)";
    for statements in [
        format!("MOTION/1, JOINT=1, FUNCTION={sine}\n"),
        format!("VARIABLE/1, FUNCTION={sine}\nMOTION/1, JOINT=1, FUNCTION=VARVAL(1)\n"),
    ] {
        for command in ["KINEMATIC", "DYNAMIC"] {
            let found = run(
                &deck(&statements),
                &format!("SIMULATE/{command}, END=2, STEPS=5"),
            );
            let second = |t: f64| -0.01 * 314.0 * 314.0 * (314.0 * t).sin();
            all_near(&found, ("PART_2_XFORM", "ACCZ"), 1e-9, second);
            all_near(&found, ("MOTION_1", "FZ"), 2e-9, |t| 2.0 * second(t));
        }
    }
    // The natural spline through 0, 1, 0: its first half is 1.5 t - t^3 / 2.
    let spline = "SPLINE/1, X=0,1,2, Y=0,1,0\nMOTION/1, JOINT=1, FUNCTION=CUBSPL(TIME,0,1)\n";
    let found = run(&deck(spline), "SIMULATE/KINEMATIC, END=2, STEPS=8");
    let second = |t: f64| -3.0 * (1.0 - (t - 1.0).abs());
    all_near(&found, ("PART_2_XFORM", "ACCZ"), 1e-12, second);
}

/// Checks a slider whose position is the square of a fast crank's x by a GCON, `0.01 cos(100 t)^2`, with a large output interval.
#[test]
fn a_condition_on_a_fast_crank_has_its_acceleration() {
    let deck = format!(
        "crank\n{SI}PART/2, MASS=1, CM=20, IP=0.1,0.1,0.1, WZ=100\nMARKER/20, PART=2\nMARKER/21, PART=2, QP=0.1,0,0\n\
         JOINT/1, REVOLUTE, I=20, J=1\nPART/3, MASS=1, CM=30, IP=1,1,1\nMARKER/30, PART=3, REULER=90D,90D,0\n\
         MARKER/13, PART=1, REULER=90D,90D,0\nJOINT/2, TRANSLATIONAL, I=30, J=13\n\
         GCON/1, FUNCTION=DX(30,1)-DX(21,1)**2\nMOTION/1, JOINT=1, VELOCITY, ICDISP=0, FUNCTION=100\n\
         RESULTS/FORMATTED, XRF\nEND\n"
    );
    let found = run(&deck, "SIMULATE/KINEMATIC, END=2, STEPS=5");
    all_near(&found, ("PART_3_XFORM", "X"), 1e-12, |t| {
        0.01 * (100.0 * t).cos().powi(2)
    });
    all_near(&found, ("PART_3_XFORM", "ACCX"), 1e-5, |t| {
        -200.0 * (200.0 * t).cos()
    });
}

/// Checks that a MOTION by velocity starts from the current position, if it is activated later or redefined from a displacement.
#[test]
fn a_rate_begins_where_the_parts_are() {
    for (motion, commands) in [
        ("VELOCITY, FUNCTION=0.5", "ACTIVATE/MOTION, ID=1"),
        (
            "FUNCTION=0.1*TIME",
            "ACTIVATE/MOTION, ID=1\nMOTION/1, VELOCITY, FUNCTION=0.5",
        ),
        (
            "ACCELERATION, ICVEL=0.5, FUNCTION=0",
            "ACTIVATE/MOTION, ID=1",
        ),
    ] {
        let commands = format!(
            "DEACTIVATE/MOTION, ID=1\nSIM/DYN, END=0.4, STEPS=4\n{commands}\nSIM/DYN, END=0.8, STEPS=4\n\
             DEACTIVATE/MOTION, ID=1\nSIM/DYN, END=1.2, STEPS=4"
        );
        let deck = format!(
            "ball\n{SI}PART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n\
             ACCGRAV/KGRAV=-9.81\nMOTION/1, JOINT=1, {motion}\nRESULTS/FORMATTED, XRF\nEND\n"
        );
        let results = run(&deck, &commands);
        let at = |from: f64, v: f64, t: f64| from + v * t - 0.5 * 9.81 * t * t;
        let caught = at(1.0, 0.0, 0.4);
        for (t, z) in results
            .column("time", "TIME")
            .iter()
            .zip(results.column("PART_2_XFORM", "Z"))
        {
            let expected = match *t {
                t if t < 0.45 => at(1.0, 0.0, t),
                t if t < 0.85 => caught + 0.5 * (t - 0.4),
                t => at(caught + 0.2, 0.5, t - 0.8),
            };
            near(z, expected, 1e-8);
        }
    }
}

/// Checks an implicit DIFF, a second-order TFSISO, and an LSE compared with DIFFs of the same equations.
#[test]
fn dynamic_states_follow_their_equations() {
    let deck = format!(
        "states\n{SI}PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n\
         DIFF/1, IC=0,0, IMPLICIT, FUNCTION=DIF1(1)**3+DIF1(1)-TIME\nVARIABLE/1, FUNCTION=1\n\
         ARRAY/1, X\nARRAY/2, U, VARIABLES=1\nARRAY/3, Y\nVARIABLE/2, FUNCTION=ARYVAL(3,1)\nVARIABLE/3, FUNCTION=4*ARYVAL(1,1)\n\
         TFSISO/1, X=1, U=2, Y=3, NUMERATOR=4, DENOMINATOR=4,0.8,1\n\
         ARRAY/11, X, SIZE=2\nARRAY/12, U, VARIABLES=1\nARRAY/13, Y, SIZE=1\nARRAY/14, IC, SIZE=2, NUMBERS=0.3,-0.2\n\
         MATRIX/1, FULL=RORDER, ROWS=2, COLUMNS=2, VALUES=0,1,-4,-0.8\nMATRIX/2, FULL=RORDER, ROWS=2, COLUMNS=1, VALUES=0,4\n\
         MATRIX/3, FULL=RORDER, ROWS=1, COLUMNS=2, VALUES=1,0\nLSE/1, X=11, U=12, Y=13, A=1, B=2, C=3, IC=14\n\
         DIFF/2, IC=0.3, FUNCTION=DIF(3)\nDIFF/3, IC=-0.2, FUNCTION=4*VARVAL(1)-4*DIF(2)-0.8*DIF(3)\n\
         INTEGRATOR/GSTIFF, ERROR=1E-6\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let found = run(&deck, "SIMULATE/DYNAMIC, END=5, STEPS=50");
    // With the rate p, t = p^3 + p, and the state is the integral of p dt.
    let rate = |t: f64| {
        let mut p = t;
        for _ in 0..60 {
            p -= (p * p * p + p - t) / (3.0 * p * p + 1.0);
        }
        p
    };
    all_near(&found, ("DIFF_1", "DQ"), 1e-9, rate);
    let state = |t: f64| 0.75 * rate(t).powi(4) + 0.5 * rate(t).powi(2);
    all_near(&found, ("DIFF_1", "Q"), 1e-6, state);
    // Solution of s^2 + 0.8 s + 4 from (y, y'): one plus a decaying oscillation.
    let turn = (4.0_f64 - 0.16).sqrt();
    let swing = move |y: f64, dy: f64| {
        move |t: f64| {
            let (sin, cos) = (turn * t).sin_cos();
            1.0 + (-0.4 * t).exp() * ((y - 1.0) * cos + (dy + 0.4 * (y - 1.0)) / turn * sin)
        }
    };
    // Arrays without a size get the size of their equations.
    for column in [("TFSISO_1", "Y1"), ("VARIABLE_2", "Q"), ("VARIABLE_3", "Q")] {
        all_near(&found, column, 1e-6, swing(0.0, 0.0));
    }
    for column in [("LSE_1", "Y1"), ("DIFF_2", "Q")] {
        all_near(&found, column, 1e-6, swing(0.3, -0.2));
    }
}

/// Checks a heavy top released at 60 degrees: its nutation by its equation, and the conserved energy and moments.
#[test]
fn a_heavy_top_nods_as_its_equation_says() {
    let (a, c, weight, spin, tilt) = (0.3, 0.1, 4.905, 60.0, PI / 3.0);
    let deck = format!(
        "top\n{SI}PART/2, MASS=1, CM=20, IP=0.05,0.05,0.1, REULER=0,60D,0, WZ={spin}\nMARKER/20, PART=2, QP=0,0,0.5\nMARKER/21, PART=2\n\
         JOINT/1, SPHERICAL, I=21, J=1\nACCGRAV/KGRAV=-9.81\nINTEGRATOR/GSTIFF, ERROR=1E-8\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let found = run(&deck, "SIMULATE/DYNAMIC, END=10, STEPS=1000");
    let vertical = c * spin * tilt.cos();
    let precession = |theta: f64| (vertical - c * spin * theta.cos()) / (a * theta.sin().powi(2));
    let second = |q: f64, _: f64| {
        let (sin, cos) = (tilt + q).sin_cos();
        let turn = precession(tilt + q);
        ((a * turn * cos - c * spin) * turn + weight) * sin / a
    };
    let expected = swung(second, 10.0);
    let thetas = found.column("PART_2_XFORM", "THETA");
    let psis = found.column("PART_2_XFORM", "PSI");
    let spins = ["WX", "WY", "WZ"].map(|axis| found.column("PART_2_XFORM", axis));
    assert_eq!(thetas.len(), expected.len());
    let mut deepest = tilt;
    for k in 0..thetas.len() {
        let (theta, psi) = (thetas[k], psis[k]);
        near(theta, tilt + expected[k][0], 1e-7);
        deepest = deepest.max(theta);
        let axis = [
            psi.sin() * theta.sin(),
            -psi.cos() * theta.sin(),
            theta.cos(),
        ];
        let w = [spins[0][k], spins[1][k], spins[2][k]];
        let along: f64 = axis.iter().zip(w).map(|(e, w)| e * w).sum();
        let square: f64 = w.iter().map(|w| w * w).sum();
        near(along, spin, 1e-6 * spin);
        let energy =
            0.5 * (a * (square - along * along) + c * along * along) + weight * theta.cos();
        let first = 0.5 * c * spin * spin + weight * tilt.cos();
        near(energy, first, 1e-6 * first);
        near(
            a * (w[2] - along * axis[2]) + c * along * axis[2],
            vertical,
            1e-6,
        );
    }
    // The top falls until its precession stops the fall.
    assert!(deepest > tilt + 0.01, "{deepest}");
}

/// A01 of the IFToMM benchmark: the simple pendulum conserves its energy.
#[test]
fn a_simple_pendulum_keeps_its_energy() {
    let deck = format!(
        "pendulum\n{SI}PART/2, MASS=1, CM=20, QG=-1,0,0, IP=1e-9,1e-9,1e-9\nMARKER/20, PART=2\nMARKER/21, PART=2, QP=1,0,0\n\
         JOINT/1, REVOLUTE, I=21, J=1\nACCGRAV/JGRAV=-9.81\nINTEGRATOR/GSTIFF, ERROR=1E-8\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let found = run(&deck, "SIMULATE/DYNAMIC, END=10, STEPS=1000");
    let column = |name: &str| found.column("PART_2_XFORM", name);
    let (x, y, vx, vy) = (column("X"), column("Y"), column("VX"), column("VY"));
    for k in 0..=1000 {
        near(
            0.5 * (vx[k] * vx[k] + vy[k] * vy[k]) + 9.81 * y[k],
            0.0,
            1e-6,
        );
        near(x[k].hypot(y[k]), 1.0, 1e-12);
    }
    assert!(x.iter().any(|x| *x > 0.9));
}

/// Checks `aview-hpc`: a ball in free fall with its own command file, which contains a Windows path.
///
/// Velocities and accelerations are compared with the results of real ADAMS. The height of ADAMS deviates from `g t^2 / 2` by 1.5e-4 inch,
/// ours does not.
#[test]
fn a_falling_ball_falls_as_real_adams_has_it() {
    let Some(from) = shared("real-decks/aview-hpc") else {
        return;
    };
    let read = |name: &str| std::fs::read_to_string(from.join(name)).unwrap();
    let folder = folder(&[
        ("test.adm", &read("test.adm")),
        ("test.acf", &read("test.acf")),
    ]);
    let ran = mdi(folder.path(), &["ru-s", "test"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let [theirs, ours] = [&*from, folder.path()].map(|place| Results::read_all(place, "test.res"));
    assert_eq!(theirs.entities(), ours.entities());
    let times = ours.column("time", "TIME");
    assert_eq!(times.len(), 26);
    for component in ["VX", "VY", "VZ", "ACCX", "ACCY", "ACCZ", "WX", "WY", "WZ"] {
        let pairs = theirs.column("PART_2_XFORM", component);
        for (a, b) in pairs.iter().zip(ours.column("PART_2_XFORM", component)) {
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{component}: {a} {b}");
        }
    }
    let heights = theirs.column("PART_2_XFORM", "Y");
    let own = ours.column("PART_2_XFORM", "Y");
    for ((t, theirs), ours) in times.iter().zip(&heights).zip(&own) {
        near(*ours, -0.5 * 386.088_582_7 * t * t, 1e-9);
        near(*theirs, *ours, 1.5e-4);
    }
}

/// Checks dry friction of 5 N in the form of old decks: it holds a block under 3 N in both directions, reports the holding force, and
/// yields to 7 N.
#[test]
fn dry_friction_holds_through_several_simulations() {
    for brake in ["-SIGN(5,VZ(20,1))", "IF(VZ(20,1):5,0,-5)"] {
        let deck = format!(
            "block\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
             PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n\
             SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION={brake}\n\
             SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=3\n\
             REQUEST/1, F2=DZ(20,1)\\F3=SFORCE(1,0,4,1)\\F4=ACCZ(20,1)\nRESULTS/FORMATTED, XRF\nEND\n"
        );
        let acf = "\nfile/model=block\nSIM/DYN, END=1, STEPS=4\nSFORCE/2, FUNCTION=-3\nSIM/DYN, END=2, STEPS=4\n\
                   SFORCE/2, FUNCTION=7\nSIM/DYN, END=3, STEPS=4\nstop\n";
        let folder = folder(&[("block.adm", &deck), ("run.acf", acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
        let found = Results::read_all(folder.path(), "block.res");
        let [z, force, a] = ["U2", "U3", "U4"].map(|c| found.column("REQUEST_1", c));
        let times = found.column("time", "TIME");
        let (mut held, mut slid) = (0, 0);
        for (k, &time) in times.iter().enumerate() {
            // A simulation starts with the force between its two values, and its first row shows that value.
            if [0.0, 1.0, 2.0]
                .iter()
                .any(|start| (time - start).abs() < 1e-9)
            {
                continue;
            }
            let (place, brake, rate) = match time {
                time if time < 1.0 => (0.0, -3.0, 0.0),
                time if time < 2.0 => (0.0, 3.0, 0.0),
                _ => ((time - 2.0).powi(2), -5.0, 2.0),
            };
            if time < 2.0 {
                held += 1;
            } else {
                slid += 1;
            }
            assert!((z[k] - place).abs() < 1e-5, "{time} {}", z[k]);
            assert!((force[k] - brake).abs() < 1e-6, "{time} {}", force[k]);
            assert!((a[k] - rate).abs() < 1e-6, "{time} {}", a[k]);
        }
        assert_eq!((held, slid), (6, 4));
    }
}
