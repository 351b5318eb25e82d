//! Dry friction with memory. Knows no solver: when a state is accepted, and the anchor moves, is the caller's choice.

use super::deflection::Deflection;
use super::{Degenerate, Law, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

/// Dry friction with memory: a spring in series with a slider (Prandtl element) on one component of the deflection.
///
/// Law, u one of (x, y, z, AX, AY, AZ) in J axes: the component on I is `-f`, with `f = K (u - ANCHOR)` while `|f| <= LIMIT`
/// and `f = +-LIMIT` beyond (sliding). While it is evaluated the anchor stands still; [`ElastoSlip::anchor_after`] moves it
/// once an equilibrium is accepted (return mapping), which is what makes the force depend on the path. The derivative is the
/// consistent one: `-K` when sticking, 0 when sliding. At the very limit it sticks.
/// Parameters: K, LIMIT, ANCHOR. K > 0, LIMIT >= 0. Not an ADAMS element: ADAMS decks express it with a user routine or not at
/// all. Source: L. Prandtl, 1928, spring-slider element; return mapping as in one-dimensional perfect plasticity.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ElastoSlip {
    /// Which of (x, y, z, AX, AY, AZ): 0..6.
    pub component: usize,
}

/// The scalar law: force against the displacement, with its derivatives, and where the anchor goes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Slip {
    /// `f`, the force of the spring.
    pub force: f64,
    /// df/du.
    pub by_displacement: f64,
    /// df/dK.
    pub by_stiffness: f64,
    /// df/dLIMIT.
    pub by_limit: f64,
    /// df/dANCHOR.
    pub by_anchor: f64,
    /// The anchor once this displacement is accepted.
    pub anchor_after: f64,
}

impl Slip {
    /// At displacement `u` from the parameters K, LIMIT, ANCHOR.
    pub fn at(u: f64, theta: &[f64]) -> Self {
        let (k, limit, anchor) = (theta[0], theta[1], theta[2]);
        let trial = k * (u - anchor);
        if trial.abs() <= limit {
            Self {
                force: trial,
                by_displacement: k,
                by_stiffness: u - anchor,
                by_limit: 0.0,
                by_anchor: -k,
                anchor_after: anchor,
            }
        } else {
            let sign = trial.signum();
            Self {
                force: sign * limit,
                by_displacement: 0.0,
                by_stiffness: 0.0,
                by_limit: sign,
                by_anchor: 0.0,
                anchor_after: u - sign * limit / k,
            }
        }
    }

    /// True if the slider moved.
    pub fn slides(&self, anchor: f64) -> bool {
        self.anchor_after != anchor
    }
}

impl ElastoSlip {
    /// Where the anchor stands after an equilibrium at this motion was accepted.
    ///
    /// # Errors
    /// [`Degenerate`] where the angle is undefined.
    pub fn anchor_after(self, motion: &RelativeMotion, theta: &[f64]) -> Result<f64, Degenerate> {
        Ok(Slip::at(self.displacement(motion)?.0, theta).anchor_after)
    }

    /// The displacement and its derivative by the motion.
    fn displacement(self, motion: &RelativeMotion) -> Result<(f64, Vec6), Degenerate> {
        if self.component < 3 {
            let u = motion.p_ij_j[self.component];
            return Ok((u, Vec6::ith(self.component, 1.0)));
        }
        let d = Deflection::of(motion)?;
        let row = d.angle_rows.row(self.component - 3);
        Ok((
            d.component(self.component),
            Vec6::new(0.0, 0.0, 0.0, row[0], row[1], row[2]),
        ))
    }
}

impl Law for ElastoSlip {
    fn parameter_count(&self) -> usize {
        3
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let (u, row) = self.displacement(motion)?;
        let slip = Slip::at(u, theta);
        let c = self.component;
        out.value = Vec6::ith(c, -slip.force);
        out.by_motion = Mat6::zeros();
        out.by_motion
            .set_row(c, &(row.transpose() * -slip.by_displacement));
        if with_parameters {
            let columns = out.parameter_columns(3);
            columns[0][c] = -slip.by_stiffness;
            columns[1][c] = -slip.by_limit;
            columns[2][c] = -slip.by_anchor;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A full cycle of amplitude U beyond the limit encloses 4 LIMIT (U - LIMIT / K).
    #[test]
    fn a_cycle_dissipates_what_the_hysteresis_loop_encloses() {
        let (k, limit, amplitude) = (100.0, 50.0, 2.0);
        let mut anchor = 0.0;
        let mut work = 0.0;
        let mut before = (0.0, 0.0);
        let steps = 20_000;
        for cycle in 0..2 {
            work = 0.0;
            for n in 1..=steps {
                let phase = std::f64::consts::TAU * f64::from(n) / f64::from(steps);
                let u = amplitude * phase.sin();
                let slip = Slip::at(u, &[k, limit, anchor]);
                work += 0.5 * (slip.force + before.1) * (u - before.0);
                before = (u, slip.force);
                anchor = slip.anchor_after;
            }
            assert!(cycle == 0 || anchor.abs() <= amplitude);
        }
        let enclosed = 4.0 * limit * (amplitude - limit / k);
        assert!(
            (work - enclosed).abs() < 1e-5 * enclosed,
            "{work} {enclosed}"
        );
    }

    #[test]
    fn the_anchor_follows_so_that_the_force_stays_at_the_limit() {
        let slip = Slip::at(3.0, &[100.0, 50.0, 0.0]);
        assert!(slip.slides(0.0));
        let again = Slip::at(3.0, &[100.0, 50.0, slip.anchor_after]);
        assert_eq!((slip.force, again.force), (50.0, 50.0));
        // Turning round sticks at once, with the full stiffness.
        let back = Slip::at(2.9, &[100.0, 50.0, slip.anchor_after]);
        assert!((back.force - 40.0).abs() < 1e-12 && back.by_displacement == 100.0);
    }
}
