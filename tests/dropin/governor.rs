//! The stiff flyball governor (A05 of the IFToMM benchmark) through `mdi`, compared with its equations in three coordinates.

use crate::run::{Results, folder, mdi};

const G: f64 = 9.81;
/// Distance of the pivots and rod ends from the axis, in m.
const ARM: f64 = 0.05;
/// Mass of a rod in kg; it is 1 m long and 0.01 m thick, with a ball of 5 kg at its end.
const ROD: f64 = 0.3;
const BALL: f64 = 5.0;
const THICK: f64 = 0.01;
const SLIDER: f64 = 3.0;
const STIFFNESS: f64 = 8e5;
const DAMPING: f64 = 4e4;
const REST: f64 = 0.5;

/// State: angle of the rods below the horizontal, its rate, height of the slider, its rate, angle of the shaft.
type Place = [f64; 5];

/// Returns the moment of inertia about the axis and its derivative with respect to the angle of the rods.
fn about_the_axis(angle: f64) -> (f64, f64) {
    let (sin, cos) = angle.sin_cos();
    let (first, second) = (ROD / 2.0 + BALL, ROD / 3.0 + BALL);
    let thin = ROD * THICK * THICK / 12.0;
    let rod = (ROD + BALL) * ARM * ARM
        + 2.0 * ARM * first * cos
        + second * cos * cos
        + thin * (1.0 + sin * sin);
    let slope = -2.0 * ARM * first * sin - 2.0 * second * cos * sin + 2.0 * thin * sin * cos;
    let fixed = SLIDER * 0.1 * 0.1 / 6.0 + ROD * THICK * THICK / 6.0;
    (fixed + 2.0 * rod, 2.0 * slope)
}

fn rate([angle, angle_rate, height, height_rate, _]: Place, momentum: f64) -> Place {
    let (sin, cos) = angle.sin_cos();
    let (inertia, slope) = about_the_axis(angle);
    let spin = momentum / inertia;
    // Vector from the slider to the middle of a rod.
    let (x, z) = (0.5 * cos, 1.0 - 0.5 * sin - height);
    let length = x.hypot(z);
    let (by_angle, by_height) = (-0.5 * (x * sin + z * cos) / length, -z / length);
    let speed = by_angle * angle_rate + by_height * height_rate;
    let pull = STIFFNESS * (length - REST) + DAMPING * speed;
    let about_the_pivot = ROD * (1.0 / 3.0 + THICK * THICK / 12.0) + BALL;
    let torque =
        0.5 * spin * spin * slope + 2.0 * G * (ROD / 2.0 + BALL) * cos - 2.0 * pull * by_angle;
    [
        angle_rate,
        torque / (2.0 * about_the_pivot),
        height_rate,
        -G - 2.0 * pull * by_height / SLIDER,
        spin,
    ]
}

/// Returns the states at equidistant times up to the end, by a Runge-Kutta method with steps small enough for its stability.
fn expected(start: Place, momentum: f64, end: f64, count: usize) -> Vec<Place> {
    let inside = 4000;
    let h = end / (count * inside) as f64;
    let add = |y: &Place, h: f64, k: &Place| -> Place { std::array::from_fn(|i| y[i] + h * k[i]) };
    let mut y = start;
    let mut out = vec![y];
    for _ in 0..count {
        for _ in 0..inside {
            let a = rate(y, momentum);
            let b = rate(add(&y, h / 2.0, &a), momentum);
            let c = rate(add(&y, h / 2.0, &b), momentum);
            let d = rate(add(&y, h, &c), momentum);
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
        }
        out.push(y);
    }
    out
}

fn deck() -> String {
    let turn = std::f64::consts::TAU;
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let centre = (ROD / 2.0 + BALL) / (ROD + BALL);
    let thin = ROD * THICK * THICK / 12.0;
    let across = ROD / 12.0 + thin + ROD * (centre - 0.5).powi(2) + BALL * (1.0 - centre).powi(2);
    let mut text = format!(
        "flyball governor
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
ACCGRAV/KGRAV=-{G}
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS={ROD}, CM=20, IP=0.0250025,0.0250025,0.000005, WZ={turn}
MARKER/20, PART=2, QP=0,0,0.5
MARKER/21, PART=2
JOINT/1, REVOLUTE, I=21, J=1
PART/3, MASS={SLIDER}, CM=30, IP=0.005,0.005,0.005, QG=0,0,0.5, WZ={turn}
MARKER/30, PART=3
JOINT/2, TRANSLATIONAL, I=30, J=21
"
    );
    for (k, (side, about)) in [(1.0, 90), (-1.0, 270)].into_iter().enumerate() {
        let part = 4 + k;
        let speed = side * turn * (ARM + centre * cos);
        text += &format!(
            "PART/{part}, MASS={}, CM={part}0, IP={},{across},{across}, QG={},0,1, REULER={about}D,30D,-90D
, VY={speed}, WX={}, WZ={}
MARKER/{part}0, PART={part}, QP={centre},0,0
MARKER/{part}1, PART={part}, REULER=0D,90D,0D
MARKER/{part}2, PART={part}, QP=0.5,0,0
MARKER/2{part}, PART=2, QP={},0,1, REULER={}D,90D,0D
MARKER/3{part}, PART=3, QP={},0,0
JOINT/{part}, REVOLUTE, I={part}1, J=2{part}
SPRINGDAMPER/{part}, TRANSLATIONAL, I={part}2, J=3{part}, K={STIFFNESS}, C={DAMPING}, LENGTH={REST}
",
            ROD + BALL,
            2.0 * thin,
            side * ARM,
            -turn * sin,
            turn * cos,
            side * ARM,
            about - 90,
            side * ARM,
        );
    }
    text + "INTEGRATOR/GSTIFF, ERROR=1E-6, HMAX=0.05\nRESULTS/FORMATTED, XRF\nEND\n"
}

/// Checks the height of the slider and the angle of the shaft over 10 s; the springs respond within 0.1 ms.
#[test]
fn a_stiff_governor_follows_its_equations() {
    let folder = folder(&[
        ("deck.adm", &deck()),
        (
            "run.acf",
            "\nfile/model=deck\nSIMULATE/DYNAMIC, END=10, STEPS=100\nstop\n",
        ),
    ]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    let found = Results::read_all(folder.path(), "deck.res");
    let start = [30_f64.to_radians(), 0.0, 0.5, 0.0, 0.0];
    let momentum = std::f64::consts::TAU * about_the_axis(start[0]).0;
    let expected = expected(start, momentum, 10.0, 100);
    let (heights, spins) = (
        found.column("PART_3_XFORM", "Z"),
        found.column("PART_2_XFORM", "WZ"),
    );
    assert_eq!(heights.len(), 101);
    let mut highest = f64::NEG_INFINITY;
    for (k, place) in expected.iter().enumerate() {
        let spin = momentum / about_the_axis(place[0]).0;
        assert!(
            (heights[k] - place[2]).abs() < 1e-5,
            "{k}: {} {}",
            heights[k],
            place[2]
        );
        assert!((spins[k] - spin).abs() < 1e-4, "{k}: {} {spin}", spins[k]);
        highest = highest.max(heights[k]);
    }
    // The slider moves considerably.
    assert!(highest - heights[0] > 0.05, "{highest}");
}
