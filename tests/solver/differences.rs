//! Central differences by the numbers of theta.

use admire::system::{Slot, System};

/// The step of a difference by a number whose value is `here`.
pub fn step(system: &System, slot: Slot, here: f64) -> f64 {
    let dimension = system.catalogue().info(slot).dimension;
    let is_angle = dimension.angle != 0 && dimension.force == 0;
    1e-3 * here.abs().max(if is_angle { 0.1 } else { 10.0 })
}

/// Richardson's extrapolation of central differences with a step and with half of it.
pub fn richardson(coarse: &[f64], fine: &[f64]) -> Vec<f64> {
    let pairs = coarse.iter().zip(fine);
    pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect()
}
