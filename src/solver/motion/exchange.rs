//! Which of the constraint equations that depend on each other are left out, decided anew as the mechanism moves.

use super::bordered::plain_weight;
use super::consistent::Consistent;
use super::error::MotionFailure;
use crate::system::{Parameters, State, System};

/// An equation that is left out may count this much of one that is kept. What is left out agrees with the others to 1e-6 of its length where
/// that is decided, and must hold to 1e-4 everywhere: half of the digits between are for this, half for the way of a step.
const EXCHANGED: f64 = 10.0;

impl Consistent {
    /// Exchanges equations that are left out for kept ones that hold no better what both hold; true if any was.
    ///
    /// An equation that was left out is a sum of the others, `g_d = sum c_k g_k`: what these leave open is open there times c. Where c is
    /// large, as where `Zi.Yj` of a crank that has turned by 90 degrees holds nothing any more and `Zi.Xj` would, the two change places:
    /// the volume of the kept gradients grows by c (S. Goreinov, E. Tyrtyshnikov, The maximal-volume concept in approximation by low-rank
    /// matrices, Contemporary Mathematics 280, 2001). Scalar products are exchanged for scalar products, distances for distances.
    ///
    /// # Errors
    /// [`Reason`] where a function has no value.
    pub(super) fn exchange_equations(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<bool, MotionFailure> {
        if !self.look_at_removed(system, parameters, state)? {
            return Ok(false);
        }
        let plain = plain_weight(system);
        let n = system.first_equation;
        let kinds = system.exchangeable();
        let mut gradients = vec![Vec::new(); system.equations];
        for &(row, column, value) in &self.rows.entries {
            gradients[row as usize].push((column as usize, value));
        }
        let weights: Vec<f64> = system
            .bodies
            .iter()
            .flat_map(|body| (0..body.freedoms).map(|k| plain[(k, k)]))
            .collect();
        let lengths: Vec<f64> = gradients
            .iter()
            .map(|row| {
                let squares = row.iter().map(|(column, by)| by * by / weights[*column]);
                squares.sum::<f64>().sqrt()
            })
            .collect();
        let mut exchanged = false;
        // Every exchange makes the volume larger: none comes back.
        for _ in 0..system.equations {
            let holds = |k: usize| system.holds_places(state, k);
            self.bordered.factor(system, &self.rows, holds, |_| plain);
            let mut most = (EXCHANGED, None);
            for out in (0..system.equations).filter(|&k| state.redundant[k]) {
                let active = system.equation_is_active(out) && !system.is_nonholonomic[out];
                let Some(kind) = kinds[out].filter(|_| active && lengths[out] > 0.0) else {
                    continue;
                };
                self.border.fill(0.0);
                for &(column, by) in &gradients[out] {
                    self.border[column] += by;
                }
                self.bordered.solve(&mut self.border);
                for kept in (0..system.equations).filter(|&k| holds(k)) {
                    let share = self.border[n + kept].abs() * lengths[kept] / lengths[out];
                    if kinds[kept] == Some(kind) && share > most.0 {
                        most = (share, Some((out, kept)));
                    }
                }
            }
            let Some((out, kept)) = most.1 else {
                break;
            };
            state.redundant[out] = false;
            state.redundant[kept] = true;
            state.multipliers[kept] = 0.0;
            exchanged = true;
        }
        Ok(exchanged)
    }
}
