//! Tests at the design state of a real Adams/Car axle: characteristics computed from its compliance matrix against the values in its
//! results file.

use super::{
    Anti, Compliance, Mat12, Pairing, Side, Tyre, Vehicle, VerticalLoad, force_compliance, ride,
    roll, roll_centre, swing_arm,
};
use admire_solver::mechanics::Vec3;

const TYRE: f64 = 202.0;
const R0: f64 = 317.25;

/// Builds the compliance matrix: the left block from columns of the results file, the right block as its mirror image, with the right
/// wheel's own wheel rate.
fn golden() -> Compliance {
    let mut matrix = Mat12::zeros();
    let mut set = |i: usize, j: usize, value: f64| matrix[(i - 1, j - 1)] = value;
    set(3, 3, 1.0 / 40.0812911);
    set(2, 3, -8.7481135e-4);
    set(4, 3, -1.2274265e-5);
    set(5, 3, -5.3881023e-5);
    set(6, 3, -7.9388509e-7);
    set(1, 3, 1.5221579e-3);
    let first = [
        3.4800403e-4,
        2.0249302e-4,
        1.5224543e-3,
        -1.0232e-6,
        -2.67385e-6,
        3.58888e-7,
    ];
    for (k, value) in first.into_iter().enumerate() {
        set(k + 1, 1, value);
    }
    set(3, 5, -5.387816e-5);
    set(1, 5, -2.67301e-6);
    set(5, 5, 1.51701e-7);
    let one = Compliance {
        matrix,
        present: [true, false],
    };
    let mut both = one.mirrored(Side::Left);
    both.matrix[(8, 8)] = 1.0 / 39.9882297;
    both
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value} for {expected}: {:.1e}",
        value / expected - 1.0
    );
}

#[test]
fn rates_and_swing_arms() {
    let c = golden();
    let track = 1540.047957;
    near(ride::wheel_rate(&c, Side::Left), 40.0812911, 1e-9);
    near(ride::ride_rate(40.0812911, TYRE), 33.4450497, 1e-8);
    near(ride::ride_steer(&c, Side::Left), 3.18199393e-5, 1e-7);
    near(roll::suspension_roll_rate(&c, track), 47476111.54, 1e-8);
    near(
        roll::total_roll_rate(&c, track, Some(TYRE)),
        39623137.84,
        1e-8,
    );
    near(
        roll::roll_camber(&c, Side::Left, track, Some(TYRE)),
        0.684201454,
        1e-7,
    );
    near(
        roll::roll_caster(&c, Side::Left, track, Some(TYRE)),
        -1.38627840,
        1e-7,
    );
    // The part of C64 in the compliance at the patch is unknown here; it amounts to a relative 4e-5.
    near(
        roll::roll_steer(&c, &c, Side::Left, track, Some(TYRE)),
        -0.0204248418,
        5e-5,
    );
    let load = VerticalLoad::OneWheel;
    near(
        swing_arm::front_view_angle(&c, Side::Left, load),
        0.0350492093,
        1e-7,
    );
    near(
        swing_arm::front_view_length(&c, Side::Left, load),
        2033.90002,
        1e-7,
    );
    near(
        swing_arm::side_view_angle(&c, Side::Left, load),
        -0.0609345254,
        1e-7,
    );
    near(
        swing_arm::side_view_length(&c, Side::Left, load),
        463.905192,
        1e-7,
    );
    near(
        force_compliance::fore_aft_stiffness(&c, Side::Left, Pairing::Parallel),
        2873.53068,
        // C11 was inferred from the other entries, to a relative accuracy of 2.6e-7.
        3e-7,
    );
}

#[test]
fn anti_effects() {
    let c = golden();
    let v = Vehicle {
        wheelbase: 2700.0,
        cg_height: 500.0,
        sprung_mass: 1600.0,
        front_brake: 0.45,
        front_drive: 0.0,
        axle_ratio: None,
    };
    near(
        Anti::LiftBraking.percent(&c, Side::Left, &v, R0, None),
        221.599704,
        1e-5,
    );
    near(
        Anti::SquatAcceleration.percent(&c, Side::Left, &v, R0, None),
        32.951929,
        1e-5,
    );
    let tyre = Tyre {
        radius: R0,
        stiffness: Some(TYRE),
    };
    let weight = 1600.0 * 9.80665;
    near(
        Anti::LiftBraking.height_per_g(&c, Side::Left, &v, &tyre, None, weight),
        -36.8843001,
        1e-5,
    );
    near(
        Anti::SquatAcceleration.height_per_g(&c, Side::Left, &v, &tyre, None, weight),
        31.4953521,
        1e-5,
    );
}

/// On a live axle, the drive shaft's torque adds to the load of one wheel what it takes from the load of the other wheel. Thus the harmonic
/// mean of both anti percentages equals the percentage without that torque, for forces at the patch such as braking forces.
#[test]
fn a_live_axle() {
    let c = golden().mirrored(Side::Left);
    let v = Vehicle {
        wheelbase: 2700.0,
        cg_height: 500.0,
        sprung_mass: 1600.0,
        front_brake: 1.0,
        front_drive: 0.0,
        axle_ratio: Some(3.5),
    };
    let track = Some(1540.0);
    let of = |side| Anti::SquatAcceleration.percent(&c, side, &v, R0, track);
    let (left, right) = (of(Side::Left), of(Side::Right));
    // Full braking force on the front axle acts rearward and down instead of forward and up; the ratio is the same.
    let without = Anti::DiveBraking.percent(&c, Side::Left, &v, R0, track);
    near(2.0 / (1.0 / left + 1.0 / right), -without, 1e-12);
    // The shaft torque unloads the left wheel by R0 / 3.5 / 1540, compared with h / 2L.
    let share = R0 / 3.5 / 1540.0 / (500.0 / 5400.0);
    near(right / left, (1.0 - share) / (1.0 + share), 1e-12);
}

/// The two slopes are chosen so that the lines meet at the roll centre in the real results; `roll_centre` must return this point.
#[test]
fn roll_centre_of_two_slopes() {
    let contact = [
        Vec3::new(3003.0, -770.0042913, -134.1329051),
        Vec3::new(3003.0, 770.0436657, -134.1329051),
    ];
    let (height, lateral) = (138.673752, -0.561571325);
    let mut matrix = Mat12::identity();
    matrix[(1, 2)] = -height / (lateral - contact[0].y);
    matrix[(7, 8)] = height / (contact[1].y - lateral);
    let c = Compliance {
        matrix,
        present: [true; 2],
    };
    let found = roll_centre(&c, &contact, VerticalLoad::OneWheel);
    near(found.vertical, height, 1e-12);
    near(found.lateral, lateral, 1e-11);
    near(found.to_patch[0], -769.442720, 1e-9);
    near(found.to_patch[1], 770.605237, 1e-9);
}

/// At the patch, displacements refer to the point below the wheel. A force there equals the same force at the wheel centre plus its moment.
#[test]
fn transfer_to_the_patch() {
    let matrix = Mat12::from_fn(|i, j| (1.0 + i as f64 + 0.1 * j as f64).sin());
    let c = Compliance {
        matrix,
        present: [true; 2],
    };
    let r = 300.0;
    let at = c.at([Vec3::new(0.0, 0.0, -r); 2]);
    // Column of a longitudinal force at the patch: column 1 - R column 5. Column of a lateral force: column 2 + R column 4. The
    // displacement of the patch is u + r x d.
    for i in 4..=6 {
        near(at.c(i, 1), c.c(i, 1) - r * c.c(i, 5), 1e-12);
        near(at.c(i, 8), c.c(i, 8) + r * c.c(i, 10), 1e-12);
    }
    near(at.c(1, 6), c.c(1, 6) - r * c.c(5, 6), 1e-12);
    near(at.c(2, 6), c.c(2, 6) + r * c.c(4, 6), 1e-12);
}
