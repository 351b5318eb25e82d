//! Tests at the design state of a real Adams/Car axle: characteristics computed from its compliance matrix against the columns of its results
//! file.
//!
//! The left block of the matrix was computed by a model that repeats the poses of the real axle, without any column of the results file. The
//! entries of the right block that a test needs were computed from columns of swing arms and wheel rate. No test in this file checks these
//! columns.

use super::wheel::angle_rates;
use super::{
    Anti, AxlePlace, Compliance, Mat12, Pairing, Side, Tyre, Vehicle, VerticalLoad, contact,
    force_compliance, ride, roll, roll_centre, swing_arm,
};
use admire_solver::mechanics::Vec3;

const TYRE: Tyre = Tyre {
    radius: 317.25,
    stiffness: Some(202.0),
};

/// Compliance of the left wheel centre at design, in mm, N and rad. Rows and columns are X, Y, Z, RX, RY, RZ. The preloaded bushings make it
/// unsymmetric.
const LEFT: [[f64; 6]; 6] = include!("golden_compliance.in");

/// Wheel centres at design, left and right, in mm, from the poses of the parts in the results file.
const CENTRE: [Vec3; 2] = [
    Vec3::new(3002.999997352012, -770.0002984255863, 160.93),
    Vec3::new(3003.004627, 769.9973151, 160.93),
];
/// Contact points at design, left and right, in mm, from the same poses.
const CONTACT: [Vec3; 2] = [
    Vec3::new(3002.999997, -770.0042913, -134.1329051),
    Vec3::new(3003.004627, 770.0436657, -134.0774607),
];

fn left_spin() -> Vec3 {
    Vec3::new(
        1.3337987822204048e-6,
        -0.9999999999075484,
        1.3532336586056393e-5,
    )
}

fn track() -> f64 {
    contact::total_track(&CONTACT[0], &CONTACT[1])
}

fn golden() -> Compliance {
    let mut matrix = Mat12::zeros();
    for (i, row) in LEFT.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            matrix[(i, j)] = *entry;
        }
    }
    let one = Compliance {
        matrix,
        present: [true, false],
    };
    let mut both = one.mirrored(Side::Left);
    // Wheel rate, front view angle and length of the right wheel.
    let (c99, angle, length) = (1.0 / 39.9882297, 0.0349059146_f64, 2035.46035);
    for (row, value) in [
        (7, c99 * angle.tan()),
        (8, c99),
        (9, c99 / (length * angle.cos())),
    ] {
        both.matrix[(row, 8)] = value;
    }
    both
}

fn at_patches(c: &Compliance) -> Compliance {
    c.at([0, 1].map(|k| CONTACT[k] - CENTRE[k]))
}

#[track_caller]
fn near(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value} for {expected}: {:.1e}",
        value / expected - 1.0
    );
}

#[test]
fn rates_and_steer() {
    let (c, o, track) = (golden(), left_spin(), track());
    near(ride::wheel_rate(&c, Side::Left), 40.081291, 1e-8);
    let rate = ride::ride_rate(ride::wheel_rate(&c, Side::Left), 202.0);
    near(rate, 33.44505, 1e-8);
    near(ride::ride_steer(&c, Side::Left, &o), 3.1819939e-5, 1e-7);
    near(roll::suspension_roll_rate(&c, track), 47476111.54, 1e-8);
    let rate = roll::total_roll_rate(&c, track, TYRE.stiffness);
    near(rate, 39623137.84, 1e-8);
    let camber = roll::roll_camber(&c, Side::Left, track, TYRE.stiffness);
    near(camber, 0.68420145, 1e-7);
    let caster = roll::roll_caster(&c, Side::Left, track, TYRE.stiffness);
    near(caster, -1.3862784, 1e-7);
    let steer = roll::roll_steer(&at_patches(&c), Side::Left, &o, track, TYRE.stiffness);
    near(steer, -0.020424842, 1e-6);
}

/// The rotation about Z alone is not the derivative of the steer angle. Even at design, it differs from the real ride steer by 0.1 %, because the
/// wheel leans by 8e-4 degrees and pitches by 0.1 degrees per millimetre.
#[test]
fn the_turn_about_z_is_not_ride_steer() {
    let c = golden();
    let turn = -c.c(6, 3) / c.c(3, 3);
    assert!((turn / 3.1819939e-5 - 1.0).abs() > 5e-4);
    let w = Vec3::new(c.c(4, 3), c.c(5, 3), c.c(6, 3)) / c.c(3, 3);
    near(
        angle_rates(Side::Left, &left_spin(), &w).steer,
        3.1819939e-5,
        1e-7,
    );
}

#[test]
fn swing_arms_and_roll_centre() {
    let (c, load) = (golden(), VerticalLoad::OneWheel);
    for (value, expected) in [
        (
            swing_arm::front_view_angle(&c, Side::Left, load),
            0.0350492093,
        ),
        (
            swing_arm::front_view_length(&c, Side::Left, load),
            2033.90002,
        ),
        (
            swing_arm::side_view_angle(&c, Side::Left, load),
            -0.0609345254,
        ),
        (
            swing_arm::side_view_length(&c, Side::Left, load),
            463.905192,
        ),
    ] {
        near(value, expected, 1e-7);
    }
    let found = roll_centre(&at_patches(&c), &CONTACT, load);
    println!("{found:?}");
    let apart = |value: f64, expected: f64| (value - expected).abs();
    assert!(apart(found.vertical, 138.67375) < 1e-4);
    assert!(apart(found.lateral, -0.561571325) < 1e-3);
    assert!(apart(found.to_patch[0], -769.442720) < 1e-3);
    assert!(apart(found.to_patch[1], 770.605237) < 1e-3);
}

#[test]
fn forces() {
    use force_compliance::{
        aligning_camber, aligning_steer, fore_aft_stiffness, lateral_camber, lateral_deflection,
        lateral_steer,
    };
    let (c, side, r0, pairing) = (golden(), Side::Left, TYRE.radius, Pairing::Parallel);
    for (value, expected) in [
        (lateral_deflection(&c, side, r0, pairing), 6.4794647e-4),
        (lateral_steer(&c, side, r0, pairing), -4.7432468e-7),
        (lateral_camber(&c, side, r0, pairing), 1.1595939e-5),
        (aligning_steer(&c, side, pairing), 5.9443882e-9),
        (aligning_camber(&c, side, pairing), -2.1004222e-9),
        (fore_aft_stiffness(&c, side, pairing), 2873.5307),
    ] {
        near(value, expected, 2e-8);
    }
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
        axle: AxlePlace::Rear,
    };
    let weight = 1600.0 * 9.80665;
    for (anti, percent, height) in [
        (Anti::LiftBraking, 221.599704, -36.8843001),
        (Anti::SquatAcceleration, 32.951929, 31.4953521),
    ] {
        let found = anti.percent(&c, Side::Left, &v, TYRE.radius, None);
        near(found, percent, 1e-7);
        let found = anti.height_per_g(&c, Side::Left, &v, &TYRE, None, weight);
        near(found, height, 1e-7);
    }
}

/// Both lines start from the same height, regardless of the heights of the patches. With slopes 0.2 and 0.1 over a track of 1500, they meet a third
/// of the track from the left patch.
#[test]
fn roll_centre_of_patches_at_different_heights() {
    let mut matrix = Mat12::identity();
    (matrix[(1, 2)], matrix[(7, 8)]) = (-0.2, 0.1);
    let c = Compliance {
        matrix,
        present: [true; 2],
    };
    for lower in [0.0, 80.0] {
        let contact = [
            Vec3::new(0.0, -750.0, -130.0 - lower),
            Vec3::new(0.0, 750.0, -130.0),
        ];
        let found = roll_centre(&c, &contact, VerticalLoad::OneWheel);
        near(found.lateral, -250.0, 1e-12);
        near(found.vertical, 100.0, 1e-12);
        near(found.to_patch[0], -500.0, 1e-12);
        near(found.to_patch[1], 1000.0, 1e-12);
    }
}

/// On a live axle, the torque of the drive shaft moves load from one wheel to the other. Thus the harmonic mean of both anti percentages equals the
/// percentage without that torque, for forces at the patch such as braking forces.
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
        axle: AxlePlace::Rear,
    };
    let track = Some(1540.0);
    let of = |side| Anti::SquatAcceleration.percent(&c, side, &v, TYRE.radius, track);
    let (left, right) = (of(Side::Left), of(Side::Right));
    // Full braking force on the front axle acts rearward and down instead of forward and up; the ratio is the same.
    let without = Anti::DiveBraking.percent(&c, Side::Left, &v, TYRE.radius, track);
    near(2.0 / (1.0 / left + 1.0 / right), -without, 1e-12);
    // The shaft torque unloads the left wheel by R0 / 3.5 / 1540, compared with h / 2L.
    let share = TYRE.radius / 3.5 / 1540.0 / (500.0 / 5400.0);
    near(right / left, (1.0 - share) / (1.0 + share), 1e-12);
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
