//! The double wishbone of the corpus, in states that Adams/Car 2024.1 reports.

use admire_kc::{Given, Inputs, Side, Variant};

use crate::axles::{Axle, DOUBLE_WISHBONE, corpus};

/// Error due to the ten digits of the Adams datasets, as in `tests/solver/double_wishbone.rs`.
const ASSEMBLY_MM: f64 = 2e-7;
const ASSEMBLY_DEG: f64 = 5e-8;
const HELD: Variant = Variant {
    height_held: true,
    steering_locked: true,
};

#[test]
fn wheel_centre_toe_and_camber() {
    let axle = Axle::new(&corpus("double-wishbone/model.adm"), DOUBLE_WISHBONE);
    let mut bench = axle.bench();
    let states = corpus("double-wishbone/states.csv");
    let mut seen = 0;
    for row in states.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|w| w.parse().unwrap()).collect();
        let inputs = Inputs {
            height: [row[0]; 2],
            steer: Some(row[1]),
            ..Inputs::default()
        };
        let mut chain = bench.chain(HELD).unwrap();
        let found = bench
            .observe(HELD, &mut chain, &inputs, None, "state")
            .unwrap();
        let readings = found.axle.readings(&Given::default());
        let of = |path: &str| readings.iter().find(|r| r.path() == path).unwrap().value;
        for (path, expected, bar) in [
            ("wheelenv_output.wheel_ctr_x_left", row[2], ASSEMBLY_MM),
            ("wheelenv_output.wheel_ctr_y_left", row[3], ASSEMBLY_MM),
            ("wheelenv_output.wheel_ctr_z_left", row[4], ASSEMBLY_MM),
            (
                "toe_angle.left",
                row[5].to_radians(),
                ASSEMBLY_DEG.to_radians(),
            ),
            (
                "camber_angle.left",
                row[6].to_radians(),
                ASSEMBLY_DEG.to_radians(),
            ),
        ] {
            assert!(
                (of(path) - expected).abs() < bar,
                "{path}: {} {expected}",
                of(path)
            );
        }
        // Only the rig holds the wheels, so no compliance is defined.
        assert_eq!(found.axle.compliance, None);
        seen += 1;
    }
    assert_eq!(seen, 3);
}

/// Checks caster and kingpin inclination at design: the line through the ball joints in the drawing.
#[test]
fn caster_and_kingpin_of_the_drawing() {
    let axle = Axle::new(&corpus("double-wishbone/model.adm"), DOUBLE_WISHBONE);
    let mut bench = axle.bench();
    let mut chain = bench.chain(HELD).unwrap();
    let found = bench
        .observe(HELD, &mut chain, &Inputs::default(), None, "design")
        .unwrap();
    // Lower ball joint (-267, -750, 130), upper (-307, -675, 555).
    let (caster, kingpin) = ((-40.0_f64 / 425.0).atan(), (75.0_f64 / 425.0).atan());
    for side in Side::BOTH {
        let axis = found.axle.wheels[side.index()].unwrap().axis.unwrap();
        assert!((axis.caster() - caster).abs() < 1e-12);
        assert!((axis.kingpin_inclination(side) - kingpin).abs() < 1e-12);
        assert_eq!(axis.pitch, 0.0);
    }
}

/// Checks the screw axis under steering. With rigid links and a locked lower ball joint, neither ball joint moves, so the axis is the line
/// through them.
#[test]
fn the_instant_axis_is_the_line_of_the_ball_joints() {
    let deck = crate::axles::sprung_wishbone();
    let lock = |toml: &str| {
        toml.replace(
            "steer_axis = ['MARKER/131', 'MARKER/132']",
            "travel_lock = 'MARKER/131'",
        )
        .replace(
            "steer_axis = ['MARKER/231', 'MARKER/232']",
            "travel_lock = 'MARKER/231'",
        )
    };
    let axis = |toml: &str| {
        let axle = Axle::new(&deck, toml);
        let mut bench = axle.bench();
        let mut chain = bench.chain(HELD).unwrap();
        let inputs = Inputs {
            height: [20.0, 5.0],
            steer: Some(4.0),
            ..Inputs::default()
        };
        let found = bench
            .observe(HELD, &mut chain, &inputs, None, "steered")
            .unwrap();
        found.axle.wheels.map(|wheel| {
            let wheel = wheel.unwrap();
            (wheel.axis.unwrap(), wheel.wheel.centre)
        })
    };
    let geometric = axis(DOUBLE_WISHBONE);
    let instant = axis(&lock(DOUBLE_WISHBONE));
    for k in 0..2 {
        let ((a, centre), (b, _)) = (geometric[k], instant[k]);
        assert!((a.direction - b.direction).norm() < 1e-9, "{a:?} {b:?}");
        assert!((a.location(&centre) - b.location(&centre)).norm() < 1e-6);
        assert!(b.pitch.abs() < 1e-6, "{}", b.pitch);
    }
}
