//! FRICTION of joints in motion through `mdi`: closed forms, an independent integration of the law, and the columns of the results.

use crate::run::{Ran, Results, folder, mdi};

const HEAD: &str = "\
friction
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
INTEGRATOR/GSTIFF, ERROR=1E-6
RESULTS/FORMATTED, XRF
";

/// Runs a deck and asserts that it runs to the end.
fn run(statements: &str, commands: &str) -> Results {
    let (results, ran) = attempt(statements, commands);
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    results
}

fn attempt(statements: &str, commands: &str) -> (Results, Ran) {
    let deck = format!("{HEAD}{statements}END\n");
    let acf = format!("\nfile/model=joint\n{commands}\nstop\n");
    let folder = folder(&[("joint.adm", &deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read_all(folder.path(), "joint.res"), ran)
}

fn near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() < error, "{found} and {expected}");
}

/// STEP5 as documented.
fn step5(x: f64, x0: f64, h0: f64, x1: f64, h1: f64) -> f64 {
    let t = ((x - x0) / (x1 - x0)).clamp(0.0, 1.0);
    h0 + (h1 - h0) * t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t)
}

const G: f64 = 9.81;
const STATIC: f64 = 0.5;
const DYNAMIC: f64 = 0.3;
const VS: f64 = 0.01;
const D: f64 = 0.001;

/// The friction law in one direction, from tables of real ADAMS (guide/motion.md).
fn coefficient(v: f64, creep: f64) -> f64 {
    let speed = v.abs();
    if speed >= VS {
        return -v.signum() * step5(speed, VS, STATIC, 1.5 * VS, DYNAMIC);
    }
    let beta = step5(speed, -VS, -1.0, VS, 1.0);
    -v.signum() * beta * STATIC - (1.0 - beta) * STATIC * step5(creep, -D, -1.0, D, 1.0)
}

/// A block of 2 kg on a rail along ground x, with its weight across the rail.
fn block(start: &str, force: &str) -> String {
    format!(
        "MARKER/11, PART=1, REULER=90D,90D,0D
PART/2, MASS=2, CM=20, IP=1,1,1{start}
MARKER/20, PART=2
MARKER/21, PART=2, REULER=90D,90D,0D
JOINT/1, TRANSLATIONAL, I=21, J=11
FRICTION/1, JOINT=1, MU_STATIC={STATIC}, MU_DYNAMIC={DYNAMIC}, STICTION_TRANSITION_VELOCITY={VS}
, MAX_STICTION_DEFORMATION={D}, INPUTS=REACTION_FORCE
ACCGRAV/KGRAV=-{G}
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=11, FUNCTION={force}
"
    )
}

/// Checks the deceleration by Coulomb's law, and then the full law by a Runge-Kutta method with small steps; creep begins when v falls
/// below VS.
#[test]
fn a_sliding_block_comes_to_rest() {
    let found = run(&block(", VX=2", "0"), "simulate/dynamic, end=1, dtout=0.01");
    let (x, v) = (
        found.column("PART_2_XFORM", "X"),
        found.column("PART_2_XFORM", "VX"),
    );
    let creep = found.column("FRICTION_1", "CREEP_Z");
    near(x[50], 2.0 * 0.5 - 0.5 * DYNAMIC * G * 0.25, 1e-6);
    near(v[50], 2.0 - DYNAMIC * G * 0.5, 1e-6);
    let slope = |y: [f64; 3], sticks: bool| {
        let creep = if sticks { y[2] } else { 0.0 };
        let mu = coefficient(y[1], creep);
        [y[1], mu * G, if sticks { y[1] } else { 0.0 }]
    };
    let step = |y: [f64; 3], h: f64, sticks: bool| {
        let add = |y: [f64; 3], h: f64, k: [f64; 3]| std::array::from_fn(|i| y[i] + h * k[i]);
        let a = slope(y, sticks);
        let b = slope(add(y, 0.5 * h, a), sticks);
        let c = slope(add(y, 0.5 * h, b), sticks);
        let d = slope(add(y, h, c), sticks);
        std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    };
    let reached = 1.5 * VS;
    let mut t = (2.0 - reached) / (DYNAMIC * G);
    let mut y = [
        (4.0 - reached * reached) / (2.0 * DYNAMIC * G),
        reached,
        0.0,
    ];
    let h = 2e-6;
    loop {
        let next: [f64; 3] = step(y, h, false);
        if next[1] < VS {
            let part = h * (y[1] - VS) / (y[1] - next[1]);
            y = step(y, part, false);
            t += part;
            break;
        }
        (y, t) = (next, t + h);
    }
    for output in [68, 70, 75, 80] {
        let end = 0.01 * f64::from(output);
        let count = ((end - t) / h).ceil();
        for _ in 0..count as usize {
            y = step(y, (end - t) / count, true);
        }
        t = end;
        let k = output as usize;
        near(x[k], y[0], 1e-7);
        near(v[k], y[1], 1e-7);
        near(creep[k], y[2], 1e-8);
    }
}

/// Checks that, under a fraction of the maximum stiction, the creep at rest is the inverse of the quintic; above the maximum the block
/// slides.
#[test]
fn a_load_is_held_by_its_creep() {
    for (share, expected) in [
        (0.25, 0.134963289728),
        (0.5, 0.281127670421),
        (0.9, 0.621489245124),
    ] {
        let load = format!("{}*STEP(TIME,0,0,1,1)", share * STATIC * 2.0 * G);
        let found = run(&block("", &load), "simulate/dynamic, end=8, steps=80");
        let last = |name: &str| *found.column("FRICTION_1", name).last().unwrap();
        near(last("CREEP_Z") / D, expected, 1e-6);
        near(last("MU1"), share * STATIC, 1e-6);
        near(last("FX"), -share * STATIC * 2.0 * G, 1e-5);
    }
    let load = format!("{}", 1.1 * STATIC * 2.0 * G);
    let found = run(&block("", &load), "simulate/dynamic, end=1, steps=100");
    let v = found.column("PART_2_XFORM", "VX");
    near((v[100] - v[90]) / 0.1, (1.1 * STATIC - DYNAMIC) * G, 1e-6);
}

/// Checks that the printed coefficients satisfy the law row by row, from the printed velocity and creep.
#[test]
fn the_columns_satisfy_the_law() {
    let force = format!("{}*SIN(7*TIME)", 0.8 * STATIC * 2.0 * G * 1.4);
    let found = run(&block("", &force), "simulate/dynamic, end=4, steps=400");
    let column = |name: &str| found.column("FRICTION_1", name);
    let (v, c, mu, beta, mu_1) = (
        column("VZ"),
        column("CREEP_Z"),
        column("MUZ"),
        column("BETA"),
        column("MU1"),
    );
    let force = column("FX");
    let (mut stuck, mut slid) = (0, 0);
    for k in 1..v.len() {
        near(mu[k], coefficient(v[k], c[k]), 1e-12);
        near(force[k], mu[k] * 2.0 * G, 1e-9);
        if v[k].abs() < VS {
            near(beta[k], step5(v[k].abs(), -VS, -1.0, VS, 1.0), 1e-12);
            near(mu_1[k], STATIC * step5(c[k].abs(), -D, -1.0, D, 1.0), 1e-12);
            stuck += 1;
        } else {
            near(c[k], 0.0, 1e-300);
            slid += 1;
        }
    }
    assert!(stuck > 20 && slid > 100, "{stuck} {slid}");
    assert_eq!(found.column("FRICTION_1", "CREEP_AZ")[100], 0.0);
}

/// Checks a wheel on a pin along ground x, with oblique weight and its centre beside the joint.
///
/// Radial force, axial force and bending moment all brake the wheel.
#[test]
fn a_wheel_on_a_pin_slows_down_evenly() {
    let wheel = "MARKER/11, PART=1, REULER=90D,90D,0D
PART/2, MASS=3, CM=20, IP=0.5,0.5,0.5, WX=20
MARKER/20, PART=2, QP=0.1,0,0
MARKER/21, PART=2, REULER=90D,90D,0D
JOINT/1, REVOLUTE, I=21, J=11
FRICTION/1, JOINT=1, MU_STATIC=0.4, MU_DYNAMIC=0.2, STICTION_TRANSITION_VELOCITY=0.001, PIN_RADIUS=0.05, FRICTION_ARM=0.07
, BENDING_REACTION_ARM=0.5INPUTS
ACCGRAV/KGRAV=-8, IGRAV=-6
";
    let (radial, axial, bending) = (3.0 * 8.0, 3.0 * 6.0, 3.0 * 8.0 * 0.1);
    let load = [
        ("", 0.05 * (radial + bending / 0.5) + 0.07 * axial),
        (", INPUTS=REACTION_FORCE", 0.05 * radial + 0.07 * axial),
        (", INPUTS=BENDING_MOMENT", 0.05 * bending / 0.5),
        (", INPUTS=NONE", 0.0),
    ];
    for (inputs, arm) in load {
        let found = run(
            &wheel.replace("INPUTS", inputs),
            "simulate/dynamic, end=1, steps=20",
        );
        let w = found.column("PART_2_XFORM", "WX");
        near(w[20], 20.0 - 0.2 * arm / 0.5, 2e-5);
        near(found.column("FRICTION_1", "TX")[10], -0.2 * arm, 1e-6);
    }
    // A preload torque alone also brakes.
    let preload = ", FRICTION_TORQUE_PRELOAD=2, INPUTS=PRELOAD";
    let found = run(
        &wheel.replace("INPUTS", preload),
        "simulate/dynamic, end=1, steps=20",
    );
    near(found.column("PART_2_XFORM", "WX")[20], 16.0, 2e-5);
}

/// Checks a pendulum on a torsion spring under Coulomb friction: each half swing loses 2 T0 / k of amplitude, until it sticks.
#[test]
fn a_pendulum_decays_by_the_same_every_half_swing() {
    let pendulum = "MARKER/11, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1, REULER=0,0,0.5
MARKER/20, PART=2
JOINT/1, REVOLUTE, I=20, J=1
SPRINGDAMPER/1, ROTATIONAL, I=20, J=11, KT=100
FRICTION/1, JOINT=1, MU_STATIC=0, MU_DYNAMIC=0, STICTION_TRANSITION_VELOCITY=1E-4, FRICTION_TORQUE_PRELOAD=2
, MAX_STICTION_DEFORMATION=1E-5
";
    let found = run(
        pendulum,
        "simulate/dynamic, end=5, dtout=0.0314159265358979323846",
    );
    let phi = found.column("PART_2_XFORM", "PSI");
    let phi: Vec<f64> = phi
        .iter()
        .zip(found.column("PART_2_XFORM", "PHI"))
        .map(|(a, b)| a + b)
        .collect();
    // Half a swing takes pi / 10; step 0 is the assembly, where the motion also begins.
    for half in 0..12 {
        let sign = if half % 2 == 0 { 1.0 } else { -1.0 };
        near(phi[10 * half], sign * (0.5 - 0.04 * half as f64), 3e-5);
    }
    // After twelve half swings 0.02 is left, where the pendulum is held at 2 N m.
    let last = *phi.last().unwrap();
    near(last, 0.02, 5e-4);
}

/// Checks stick-slip of a block of 2 kg on a spring of 200 N/m whose other end moves at 0.1 m/s, by Coulomb's law.
///
/// It breaks loose when the spring reaches the static limit, swings about the dynamic limit in the frame of the drive, and sticks again at
/// zero velocity.
#[test]
fn a_block_that_is_pulled_sticks_and_slips() {
    let (k, m, drive, slow) = (200.0_f64, 2.0, 0.1, 1e-6);
    let deck = block("", &format!("{k}*({drive}*TIME-DX(20))"))
        .replace(&format!("VELOCITY={VS}"), &format!("VELOCITY={slow}"))
        .replace(&format!("DEFORMATION={D}"), "DEFORMATION=1E-8");
    let found = run(&deck, "simulate/dynamic, end=3, dtout=0.01");
    let omega = (k / m).sqrt();
    let over = (STATIC - DYNAMIC) * m * G / k;
    let loose = STATIC * m * G / k / drive;
    let slip = (std::f64::consts::PI + 2.0 * (drive / omega / over).atan()) / omega;
    let period = slip + 2.0 * over / drive;
    // The static limit acts until the speed reaches 1.5 times the transition velocity; until then the velocity is `k drive t^2 / 2 m`.
    let late = (2.0 * 1.5 * slow * m / (k * drive)).sqrt();
    let fastest = drive + omega * over.hypot(drive / omega);
    let x = found.column("PART_2_XFORM", "X");
    let mut moved = [0, 0];
    for (x, t) in x.iter().zip(found.column("time", "TIME")) {
        let since = t - loose;
        let rounds = (since / period).floor().max(-1.0);
        let t = since - rounds * period;
        let expected = if since < 0.0 {
            0.0
        } else {
            // Stretch of the spring beyond the dynamic limit, and displacement of the drive.
            let t = t.min(slip);
            let stretch = over * (omega * t).cos() + drive / omega * (omega * t).sin();
            rounds * drive * period + drive * t + over - stretch
        };
        moved[usize::from(since > 0.0 && t < slip)] += 1;
        // The block lags by this time, during which the drive has moved on.
        near(
            *x,
            expected,
            (rounds + 1.0) * late * (fastest + drive) + 1e-6,
        );
    }
    // Both phases occur in three periods.
    assert!(moved[0] > 100 && moved[1] > 100, "{moved:?}");
}

/// Checks a sleeve that slides and rotates: friction opposes the resultant surface velocity, so for m R^2 = I its direction is constant.
#[test]
fn a_sleeve_slows_down_along_its_screw() {
    let sleeve = "MARKER/11, PART=1, REULER=90D,90D,0D
PART/2, MASS=2, CM=20, IP=0.02,0.02,0.02, VX=3, WX=40
MARKER/20, PART=2
MARKER/21, PART=2, REULER=90D,90D,0D
JOINT/1, CYLINDRICAL, I=21, J=11
FRICTION/1, JOINT=1, MU_STATIC=0.5, MU_DYNAMIC=0.3, STICTION_TRANSITION_VELOCITY=0.001, PIN_RADIUS=0.1, FRICTION_FORCE_PRELOAD=1
ACCGRAV/KGRAV=-9.81
";
    let found = run(sleeve, "simulate/dynamic, end=1, steps=20");
    // Surface speeds are 3 and 4, with resultant 5; the load is weight plus preload.
    let left = 5.0 - 0.3 * (2.0 * G + 1.0) / 2.0;
    near(found.column("PART_2_XFORM", "VX")[20], 0.6 * left, 1e-5);
    near(found.column("PART_2_XFORM", "WX")[20], 8.0 * left, 1e-4);
    near(found.column("FRICTION_1", "MUZ")[10], -0.18, 1e-9);
    near(found.column("FRICTION_1", "MURZ")[10], -0.24, 1e-9);
}

/// Checks ball joints and crosses: a body with its centre in the joint slows down by the friction torque.
#[test]
fn balls_and_crosses_slow_down_evenly() {
    let body = |joint: &str, spin: &str, friction: &str| {
        format!(
            "PART/2, MASS=2, CM=20, IP=0.1,0.1,0.1, {spin}
MARKER/20, PART=2
MARKER/21, PART=2REULER
JOINT/1, {joint}, I=21, J=1
FRICTION/1, JOINT=1, MU_STATIC=0.5, MU_DYNAMIC=0.3, STICTION_TRANSITION_VELOCITY=0.001, {friction}
ACCGRAV/KGRAV=-9.81
"
        )
    };
    let braked = 0.3 * 0.02 * 2.0 * G / 0.1;
    // Spherical: |T| = BALL_RADIUS |mu| |F|, against the spin.
    let ball = body("SPHERICAL", "WX=6, WY=-3, WZ=2", "BALL_RADIUS=0.02").replace("REULER", "");
    let found = run(&ball, "simulate/dynamic, end=1, steps=20");
    for (name, start) in [("WX", 6.0), ("WY", -3.0), ("WZ", 2.0)] {
        let w = found.column("PART_2_XFORM", name)[20];
        near(w, start * (1.0 - braked / 7.0), 1e-5);
    }
    // Hooke: pins along x of I and y of J; universal: along z of I and z of J. The weight is across the pin.
    let cases = [
        ("HOOKE", "", "WX=6", "WX", "I_YOKE"),
        ("HOOKE", "", "WY=6", "WY", "J_YOKE"),
        ("UNIVERSAL", ", REULER=90D,90D,0D", "WX=6", "WX", "I_YOKE"),
    ];
    for (joint, turned, spin, column, yoke) in cases {
        let friction = format!("{yoke}, PIN_RADIUS=0.02, FRICTION_ARM=0.02");
        let deck = body(joint, spin, &friction).replace("REULER", turned);
        let found = run(&deck, "simulate/dynamic, end=1, steps=20");
        near(found.column("PART_2_XFORM", column)[20], 6.0 - braked, 1e-5);
        let other = if yoke == "I_YOKE" { "J_YOKE" } else { "I_YOKE" };
        let free = run(
            &deck.replace(yoke, other),
            "simulate/dynamic, end=1, steps=20",
        );
        near(free.column("PART_2_XFORM", column)[20], 6.0, 1e-6);
    }
}

/// Checks a heavy body off its cross with friction in both pins, which stick and are loaded by radial force, axial force, moment and
/// preload.
///
/// The reference comes from the Newton-Euler equations of two angles with loads by fixed-point iteration, integrated with SciPy's Radau and
/// DOP853 between the events.
#[test]
fn a_body_on_a_cross_with_two_pins_follows_its_equations() {
    let known = [
        (
            4,
            [-2.01181079, -0.364157, 1.03973002],
            [4.53442666, 2.53845208, 22.79817301],
            [0.21855267, 0.31022068, -0.11295086],
        ),
        (
            10,
            [0.91700685, 0.92063478, -0.18406956],
            [-0.25614649, -6.71146625, 18.32582933],
            [-0.20210834, -0.22699257, 0.04056894],
        ),
        (
            20,
            [0.18698484, 0.22864151, -0.0497239],
            [0.82484821, -5.41657082, 18.00024556],
            [-0.24655595, -0.31978587, 0.06556534],
        ),
    ];
    let universal = (", REULER=90D,90D,0D", ", REULER=180D,90D,0D");
    for (joint, (i, j)) in [("HOOKE", ("", "")), ("UNIVERSAL", universal)] {
        let deck = format!(
            "MARKER/2, PART=1{j}
PART/2, MASS=2, CM=20, IP=0.05,0.08,0.03, VX=-0.4, VY=0.8, VZ=0.2, WX=2, WY=1, WZ=0
MARKER/20, PART=2, QP=0.1,0.15,-0.4
MARKER/21, PART=2{i}
JOINT/1, {joint}, I=21, J=2
FRICTION/1, JOINT=1, I_YOKE, J_YOKE, MU_STATIC=0.5, MU_DYNAMIC=0.3, STICTION_TRANSITION_VELOCITY=0.01,
, MAX_STICTION_DEFORMATION=0.001, PIN_RADIUS=0.02, FRICTION_ARM=0.03, BENDING_REACTION_ARM=0.05, FRICTION_TORQUE_PRELOAD=0.05
ACCGRAV/KGRAV=-9.81
"
        );
        let found = run(&deck, "simulate/dynamic, end=3, steps=20");
        for (row, w, force, torque) in known {
            for (k, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
                let at = |of: &str, what: &str| found.column(of, &format!("{what}{axis}"))[row];
                near(at("PART_2_XFORM", "W"), w[k], 1e-5);
                near(at("JOINT_1", "F"), force[k], 1e-4);
                near(at("FRICTION_1", "T"), torque[k], 1e-4);
            }
        }
    }
}

/// Checks that FRICTION(id, index) returns the numbers of the results, in the axes of J: the momentum lost by one block is gained by a
/// second one.
#[test]
fn functions_read_friction() {
    let other = "PART/3, MASS=5, CM=30, IP=1,1,1
MARKER/30, PART=3
SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=30, J=11, FUNCTION=FRICTION(1,3)
REQUEST/1, F2=FRICTION(1,3)\\F3=FRICTION(1,9)\\F4=FRICTION(1,13)\\F6=FRICTION(1,16)\\F7=FRICTION(1,22)\\F8=FRICTION(1,26)
"
    .replace("\\\\", "\\");
    let deck = format!("{}{other}", block(", VX=2", "0"));
    let found = run(&deck, "simulate/dynamic, end=1, dtout=0.01");
    let (one, two) = (
        found.column("PART_2_XFORM", "VX"),
        found.column("PART_3_XFORM", "VX"),
    );
    let lost = 2.0 * (one[100] - 2.0);
    near(5.0 * two[100], lost, 1e-5);
    assert!(lost < -3.9);
    let columns = [
        ("U2", "FX"),
        ("U3", "MUZ"),
        ("U4", "MU1"),
        ("U6", "VZ"),
        ("U7", "CREEP_Z"),
        ("U8", "BETA"),
    ];
    for (of_request, of_friction) in columns {
        let read = found.column("REQUEST_1", of_request);
        let said = found.column("FRICTION_1", of_friction);
        for k in [3, 67, 69, 90] {
            near(read[k], said[k], 1e-9);
        }
    }
    let bad = deck.replace("FRICTION(1,26)", "FRICTION(1,27)");
    let (_, ran) = attempt(&bad, "simulate/dynamic, end=0.1, steps=2");
    assert_eq!(ran.code, 1);
    assert!(ran.stdout.contains("1 to 26"), "{}", ran.stdout);
}

/// Checks a motion after statics: friction exerts no force in statics, with one message, and the motion begins with undeformed stiction.
///
/// An added load is then shared by the spring and the creep: `k c + S(c, -D, -1, D, 1) MU_STATIC N = load`.
#[test]
fn a_motion_after_statics_begins_with_undeformed_stiction() {
    let (k, added) = (1000.0, 3.0);
    let spring = format!("5-{k}*DX(20)+{added}*STEP(TIME,0,0,1,1)");
    let deck = block(", VX=2", &spring).replace(", VX=2", "");
    let (found, ran) = attempt(
        &deck,
        "simulate/static\nsimulate/dynamic, end=8, steps=80\nsimulate/static",
    );
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    let told = "FRICTION/1 exerts no friction in statics";
    assert_eq!(ran.stdout.matches(told).count(), 1, "{}", ran.stdout);
    let x = found.column("PART_2_XFORM", "X");
    near(x[0], 5.0 / k, 1e-9);
    assert_eq!(found.column("FRICTION_1", "FX")[0], 0.0);
    let held = |c: f64| k * c + STATIC * 2.0 * G * step5(c, -D, -1.0, D, 1.0) - added;
    let (mut low, mut high) = (0.0, D);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if held(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let end = x.len() - 2;
    near(x[end], 5.0 / k + low, 1e-8);
    near(found.column("FRICTION_1", "CREEP_Z")[end], low, 1e-8);
    near(found.column("FRICTION_1", "FX")[end], k * low - added, 1e-5);
    assert!(low > 0.1 * D && low < 0.5 * D, "{low}");
    // A final static analysis releases the friction surfaces again.
    near(x[end + 1], (5.0 + added) / k, 1e-9);
    assert_eq!(found.column("FRICTION_1", "FX")[end + 1], 0.0);
    // A motion alone gives no message; statics after a motion does.
    let (_, ran) = attempt(&deck, "simulate/dynamic, end=0.1, steps=2");
    assert!(!ran.stdout.contains(told), "{}", ran.stdout);
    let (_, ran) = attempt(&deck, "simulate/dynamic, end=0.1, steps=2\nsimulate/static");
    assert_eq!(ran.stdout.matches(told).count(), 1, "{}", ran.stdout);
}

/// Checks that small motions about rest stick, right after statics as well as after a motion at rest.
///
/// At zero, both quintic steps have the slope 15/8, divided by D for the creep and by VS for the velocity.
#[test]
fn small_motions_about_rest_stick() {
    let deck = format!("{HEAD}{}END\n", block("", "5-100*DX(20)"));
    let grip = 15.0 / 8.0 * STATIC * 2.0 * G;
    let (stiff, damp) = (100.0 + grip / D, grip / VS);
    let half = damp / 4.0;
    let apart = (half * half - stiff / 2.0).sqrt();
    for before in [
        "simulate/static",
        "simulate/static\nsimulate/dynamic, end=0.1, steps=1",
    ] {
        let acf = format!("\nfile/model=joint\n{before}\nlinear/eigensol\nstop\n");
        let folder = folder(&[("joint.adm", &deck), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let text = std::fs::read(folder.path().join("joint.modes.json")).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let modes = value["modes"].as_array().unwrap();
        let found: Vec<f64> = modes.iter().map(|m| m["real"].as_f64().unwrap()).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        near(found[0], -half + apart, 1e-4);
        near(found[1], -half - apart, 1e-4);
    }
}

/// Checks a driven block, x = 0.004 sin 4t, which sticks while its speed is below VS.
///
/// Its creep is the displacement since the speed fell below VS, independent of the output interval. The motor carries inertia and friction.
#[test]
fn a_driven_block_creeps_from_where_it_began_to_stick() {
    let deck = block("", "0") + "MOTION/1, JOINT=1, FUNCTION=0.004*SIN(4*TIME)\n";
    let quarter = std::f64::consts::FRAC_PI_2;
    for command in ["kinematic, end=2, dtout=0.1", "dynamic, end=2, dtout=0.01"] {
        let found = run(&deck, &format!("simulate/{command}"));
        let column = |name: &str| found.column("FRICTION_1", name);
        let (creep, force, motor) = (
            column("CREEP_Z"),
            column("FX"),
            found.column("MOTION_1", "FX"),
        );
        let mut stuck = 0;
        for (k, t) in found.column("time", "TIME").iter().enumerate() {
            let v = 0.016 * (4.0 * t).cos();
            // The nearest turning point, and the angle before it at which the speed fell to VS.
            let turn = quarter * (2.0 * ((4.0 * t - quarter) / (2.0 * quarter)).round() + 1.0);
            let began = turn - (VS / 0.016).asin();
            let sticks = v.abs() < VS;
            let way = if sticks {
                0.004 * ((4.0 * t).sin() - began.sin())
            } else {
                0.0
            };
            stuck += usize::from(sticks);
            near(creep[k], way, 1e-9);
            near(force[k], coefficient(v, way) * 2.0 * G, 1e-5);
            near(motor[k] + force[k], 2.0 * -0.064 * (4.0 * t).sin(), 1e-5);
        }
        assert!(stuck > 5, "{stuck}");
    }
}

/// Checks a block driven more slowly than VS, x = 0.0002 sin 4t, which creeps from the start. A block held in place does not creep.
#[test]
fn a_driven_block_creeps_from_the_start() {
    for (size, command) in [
        (0.0002, "kinematic, end=0.3, dtout=0.1"),
        (0.0002, "dynamic, end=0.3, dtout=0.1"),
        (0.0, "dynamic, end=0.3, dtout=0.1"),
    ] {
        let drive = format!("MOTION/1, JOINT=1, FUNCTION={size}*SIN(4*TIME)\n");
        let found = run(&(block("", "0") + &drive), &format!("simulate/{command}"));
        let creep = found.column("FRICTION_1", "CREEP_Z");
        for (t, creep) in found.column("time", "TIME").iter().zip(creep) {
            near(creep, size * (4.0 * t).sin(), 1e-12);
        }
    }
}

/// Checks that INACTIVE=STATIC, which is the behaviour anyway, suppresses the message, and that another formulation is refused.
#[test]
fn friction_may_be_off_in_statics() {
    let deck = block(", VX=2", "0");
    let both = "simulate/static\nsimulate/dynamic, end=0.1, steps=2";
    let off = deck.replace("INPUTS=REACTION_FORCE", "INACTIVE=STATIC");
    let spring = "SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=20, J=11, FUNCTION=5-100*DX(20)\n";
    let (found, ran) = attempt(&format!("{off}{spring}"), both);
    assert!(
        ran.code == 0 && !ran.stdout.contains("exerts no friction"),
        "{}",
        ran.stdout
    );
    near(found.column("PART_2_XFORM", "X")[0], 0.05, 1e-9);
    assert_eq!(found.column("FRICTION_1", "FX")[0], 0.0);
    assert!(found.column("FRICTION_1", "FX").last().unwrap().abs() > 1.0);
    let (_, ran) = attempt(
        &deck.replace("MU_STATIC", "FORMULATION=LUGRE, MU_STATIC"),
        "simulate/dynamic, end=0.1, steps=2",
    );
    assert!(
        ran.code == 1 && ran.stdout.contains("LUGRE"),
        "{}",
        ran.stdout
    );
}
