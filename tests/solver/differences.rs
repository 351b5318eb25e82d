//! Central differences with respect to parameters, and of the residual along a motion.

use admire_solver::system::{Parameters, Scratch, Slot, State, System};

/// Returns the step of a difference with respect to a parameter of value `here`.
pub fn step(system: &System, slot: Slot, here: f64) -> f64 {
    let dimension = system.catalogue().info(slot).dimension;
    let is_angle = dimension.angle != 0 && dimension.force == 0;
    1e-3 * here.abs().max(if is_angle { 0.1 } else { 10.0 })
}

/// Applies Richardson's extrapolation to central differences with a full and a half step.
pub fn richardson(coarse: &[f64], fine: &[f64]) -> Vec<f64> {
    let pairs = coarse.iter().zip(fine);
    pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect()
}

/// Returns central differences of the residual along a motion of all unknowns: with a step of 2e-3 of the motion, and with half of this step.
pub fn along(
    system: &System,
    parameters: &Parameters,
    state: &State,
    dx: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let mut scratch = Scratch::new(system);
    let mut at = |h: f64| {
        let mut moved = state.clone();
        let step: Vec<f64> = dx.iter().map(|d| d * h).collect();
        system.advance(&mut moved, &step);
        let mut g = vec![0.0; dx.len()];
        system
            .residual(parameters, &moved, &mut scratch, &mut g)
            .unwrap();
        g
    };
    let mut difference = |h: f64| -> Vec<f64> {
        let (plus, minus) = (at(h), at(-h));
        let both = plus.iter().zip(&minus);
        both.map(|(p, m)| (p - m) / (2.0 * h)).collect()
    };
    (difference(2e-3), difference(1e-3))
}
