//! Conservation laws of motions: energy and momentum of random trees and loops of joints, and reversal of time.

use admire_solver::motion::Kept;

use crate::conserved::{Case, energy_off, mechanism};

#[test]
fn random_mechanisms_keep_their_energy() {
    for seed in 1..=30 {
        let off = energy_off(seed, 1e-6, 1.0);
        assert!(off < 1e-5, "seed {seed}: {off:e}");
    }
}

#[test]
fn free_mechanisms_keep_their_momentum() {
    for seed in 1..=20 {
        let case = Case::of(&mechanism(seed, false));
        let start = case.begun(case.system.state(), Kept::Data);
        let before = case.balance(&start);
        let after = case.balance(&case.integrated(start, 1e-6, 1.0));
        let size = 1.0 + before.2.norm() + before.3.norm();
        assert!((after.2 - before.2).norm() < 1e-5 * size, "seed {seed}");
        assert!((after.3 - before.3).norm() < 1e-5 * size, "seed {seed}");
        assert!(
            (after.1 - before.1).abs() < 1e-5 * (1.0 + before.1),
            "seed {seed}"
        );
    }
}

/// Checks that a mechanism with reversed velocities returns to its start.
#[test]
fn motions_go_back_the_way_they_came() {
    const ERROR: f64 = 1e-6;
    for seed in 1..=10 {
        let case = Case::of(&mechanism(seed, true));
        let start = case.begun(case.system.state(), Kept::Data);
        let mut there = case.integrated(start.clone(), ERROR, 0.5);
        let mut moved = 0.0_f64;
        for (a, b) in there.poses.iter().zip(&start.poses) {
            moved = moved.max((a.p - b.p).norm());
        }
        there.time = 0.0;
        for rates in &mut there.velocities {
            rates.linear = -rates.linear;
            rates.angular = -rates.angular;
        }
        let there = case.begun(there, Kept::Velocities);
        let back = case.integrated(there, ERROR, 0.5);
        for (a, b) in back.poses.iter().zip(&start.poses) {
            assert!((a.p - b.p).norm() < 100.0 * ERROR, "seed {seed}");
            assert!((a.R - b.R).norm() < 100.0 * ERROR, "seed {seed}");
        }
        assert!(moved > 0.01 || seed > 5, "seed {seed}: {moved}");
    }
}

/// Checks that the error decreases with ERROR over six decades. The measure is the energy, to which every part of the motion contributes.
#[test]
fn a_smaller_error_is_smaller() {
    for seed in [3, 7, 11] {
        let mut before = f64::INFINITY;
        for error in [1e-2, 1e-4, 1e-6, 1e-8] {
            let off = energy_off(seed, error, 1.0);
            assert!(off < 10.0 * error, "seed {seed}, {error:e}: {off:e}");
            assert!(
                off < before || off < 1e-9,
                "seed {seed}, {error:e}: {off:e} {before:e}"
            );
            before = off;
        }
    }
}
