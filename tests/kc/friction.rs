//! Joints with friction: loops are closed and have the width of the closed form.

use admire_kc::{Branch, Hold, KcRun, Sample, TestKind, run};
use admire_solver::system::StickSlipState;

use crate::axles::{Axle, DOUBLE_WISHBONE, MCPHERSON, corpus, sprung_wishbone};

/// Swing axle: the carrier rotates about a longitudinal pin 600 mm inboard of the wheel, and a vertical spring acts at half this distance.
const SWING_AXLE: &str = "SWING AXLE
UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND
PART/1, GROUND
MARKER/1, PART = 1, QP = 0, -200, 300, REULER = 90D, 90D, 0D
MARKER/2, PART = 1
PART/2, MASS = 1E-9, CM = 20, IP = 1E-6, 1E-6, 1E-6
MARKER/20, PART = 2, QP = 0, -800, 300
MARKER/21, PART = 2, QP = 0, -200, 300, REULER = 90D, 90D, 0D
MARKER/22, PART = 2, QP = 0, -500, 300
JOINT/1, REVOLUTE, I = 21, J = 1
VFORCE/1, I = 22, JFLOAT = 23, RM = 2, FX = 0\\
, FY = 0\\
, FZ = -4000-100*(DZ(22,2,2)-300)
MARKER/23, PART = 1, FLOATING
FRICTION/1, JOINT = 1, MU_STATIC = 0.4, MU_DYNAMIC = 0.3, STICTION_TRANSITION_VELOCITY = 0.1
, MAX_STICTION_DEFORMATION = 0.01, PIN_RADIUS = 15
ACCGRAV/KGRAV = 0
END
";

const TOML: &str = "
[wheels]
mirror = true
left = { centre = 'MARKER/20', spin = 'y' }
";

fn tests_of(deck: &str, toml: &str) -> KcRun {
    let axle = Axle::new(deck, toml);
    let mut bench = axle.bench();
    run(&mut bench, &axle.model.units).unwrap_or_else(|why| panic!("{why}"))
}

/// Returns the load of the left wheel at ride height on both branches of a bounce test, and the slope and the half width of its gradient.
fn loads(run: &KcRun) -> ([f64; 2], f64, f64) {
    let test = run
        .tests
        .iter()
        .find(|t| t.kind == TestKind::Bounce)
        .unwrap();
    let at = |branch: Branch| {
        let mut all = test.samples.iter();
        all.find(|s| s.branch == branch && s.value == 0.0)
            .unwrap()
            .seen
            .load[0]
    };
    let mut gradients = test.gradients.iter();
    let gradient = gradients
        .find(|g| g.component == "vertical_left_force")
        .unwrap();
    (
        [at(Branch::Up), at(Branch::Down)],
        gradient.tangent,
        gradient.hysteresis,
    )
}

/// Checks the closed form. The pin resists with the moment `mu r N`, where N is the difference of spring and wheel load. With m = mu r, upward
/// travel has `F (L + m) = S (a + m)`; downward travel has -m.
#[test]
fn a_swing_axle_has_the_loop_of_its_pin() {
    let near = |found: f64, expected: f64, what: &str| {
        let apart = (found - expected).abs();
        assert!(apart < 1e-6 * expected.abs(), "{what}: {found} {expected}");
    };
    let (arm, place, spring, rate) = (600.0, 300.0, 4000.0, 100.0);
    for (word, mu) in [("dynamic", 0.3), ("static", 0.4)] {
        let toml = format!("{TOML}[choices]\nfriction = '{word}'\n");
        let (load, slope, width) = loads(&tests_of(SWING_AXLE, &toml));
        let of = |m: f64| (place + m) / (arm + m);
        let m = mu * 15.0;
        let [up, down] = [m, -m].map(of);
        near(load[0], spring * up, "up");
        near(load[1], spring * down, "down");
        near(width, spring * (up - down) / 2.0, "half width");
        near(slope, rate * place / arm * (up + down) / 2.0, "slope");
    }
    // The loop is the same with another number of points, because the law is rate-independent.
    let fine = format!("{TOML}[tests.bounce]\npoints = 41\n");
    let (coarse, fine) = (tests_of(SWING_AXLE, TOML), tests_of(SWING_AXLE, &fine));
    near(loads(&fine).0[0], loads(&coarse).0[0], "points");
}

fn all_close(run: &KcRun, bar: f64) -> f64 {
    let mut widest: f64 = 0.0;
    for test in &run.tests {
        let ends = |branch: Branch| -> (&Sample, &Sample) {
            let all: Vec<_> = test.samples.iter().filter(|s| s.branch == branch).collect();
            (all[0], all[all.len() - 1])
        };
        let ((up_low, up_high), (down_high, down_low)) = (ends(Branch::Up), ends(Branch::Down));
        for k in 0..up_low.readings.len() {
            // Only positions, angles and loads are compared, because quantities from derivatives belong to one branch.
            if k > 34 {
                break;
            }
            let of = |sample: &Sample| sample.readings[k].value;
            let values: Vec<f64> = test.samples.iter().map(of).collect();
            let (low, high) = values
                .iter()
                .fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            let range = (high - low).max(1e-3);
            for (a, b) in [(up_low, down_low), (up_high, down_high)] {
                let apart = (of(a) - of(b)).abs();
                let path = up_low.readings[k].path();
                assert!(
                    apart <= bar * range,
                    "{} {path}: {apart:e} of {range:e}",
                    test.kind.name()
                );
            }
        }
        for gradient in &test.gradients {
            if gradient.component == "vertical_left_force" {
                widest = widest.max(gradient.hysteresis);
            }
        }
    }
    widest
}

/// Checks every test on three kinds of axle: loops are closed, and without friction there are none.
#[test]
fn loops_close() {
    let rubs = |deck: String, joints: &[(u32, &str)], inactive: &str| {
        let mut text = deck.trim_end().strip_suffix("END").unwrap().to_string();
        for (joint, more) in joints {
            text += &format!(
                "FRICTION/{joint}, JOINT = {joint}, MU_STATIC = 0.2, MU_DYNAMIC = 0.15{more}{inactive}\n"
            );
        }
        text + "END\n"
    };
    let strut = ", PIN_RADIUS = 11, INITIAL_OVERLAP = 200";
    let ball = ", BALL_RADIUS = 12";
    let pin = ", PIN_RADIUS = 15, FRICTION_ARM = 15, BENDING_REACTION_ARM = 60";
    let cases = [
        (
            "mcpherson",
            corpus("pseudo-mcpherson/model.adm"),
            MCPHERSON,
            vec![(3, strut), (1, ball), (2, ball), (4, ball)],
        ),
        (
            "wishbone",
            sprung_wishbone(),
            DOUBLE_WISHBONE,
            vec![(11, pin), (21, pin), (12, pin), (22, pin)],
        ),
    ];
    for (name, deck, toml, joints) in cases {
        let with = tests_of(&rubs(deck.clone(), &joints, ""), toml);
        let width = all_close(&with, 1e-6);
        println!("{name}: {width:.1} N");
        assert!(width > 1.0, "{name}: {width}");
        assert!(
            with.tests
                .iter()
                .all(|t| t.samples.iter().all(|s| s.seen.friction.is_some()))
        );
        // Ride height is computed without friction.
        assert_eq!(
            with.ride.seen.friction,
            Some(StickSlipState::Released),
            "{name}"
        );
        let without = tests_of(&rubs(deck, &joints, ", INACTIVE = STATIC"), toml);
        let width = all_close(&without, 1e-9);
        let rate = |run: &KcRun| {
            let mut all = run.ride.readings.iter();
            all.find(|r| r.path() == "wheel_rate.left").unwrap().value
        };
        assert!((rate(&with) / rate(&without) - 1.0).abs() < 1e-9, "{name}");
        assert!(
            width < 1e-6 && without.ride.seen.friction.is_none(),
            "{name}: {width}"
        );
    }
}

/// Checks that a roll keeps the load of the axle, for axles with two wheels and for one wheel with its mirror image.
#[test]
fn a_roll_keeps_the_load_of_the_axle() {
    for (name, deck, toml) in [
        ("mcpherson", corpus("pseudo-mcpherson/model.adm"), MCPHERSON),
        ("wishbone", sprung_wishbone(), DOUBLE_WISHBONE),
    ] {
        let toml = format!("{toml}[tests.roll]\nhold = 'load'\n");
        let run = tests_of(&deck, &toml);
        let test = run.tests.iter().find(|t| t.kind == TestKind::Roll).unwrap();
        assert_eq!(test.settings.hold, Hold::Load);
        let axle_load: f64 = run.ride.seen.load.iter().sum();
        let mut rise: f64 = 0.0;
        for sample in &test.samples {
            let load: f64 = sample.seen.load.iter().sum();
            assert!(
                (load - axle_load).abs() < 1e-6 * axle_load,
                "{name} {load} {axle_load}"
            );
            let height = sample.inputs.height;
            assert!(
                (height[0] - height[1] - 2.0 * sample.value).abs() < 1e-9,
                "{name}"
            );
            rise = rise
                .max((height[0] + height[1] - run.ride.inputs.height.iter().sum::<f64>()).abs());
        }
        assert!(rise > 0.01, "{name}: {rise}");
        // The tangent is the slope of the recorded values.
        let fine = format!("{toml}range = [-0.5, 0.5]\npoints = 5\nwindow = 0.5\n");
        let fine = tests_of(&deck, &fine);
        let fine = fine
            .tests
            .iter()
            .find(|t| t.kind == TestKind::Roll)
            .unwrap();
        for gradient in &fine.gradients {
            let apart = (gradient.fitted - gradient.tangent).abs();
            assert!(
                apart < 1e-3 * gradient.tangent.abs().max(1e-6),
                "{name} {gradient:?}"
            );
        }
    }
}
