//! Dry friction with memory. The memory is the anchor: the displacement at which the spring of the element is unloaded. The caller decides when
//! a state is accepted, and then moves the anchor.

/// Result of evaluating a dry-friction element with memory: a spring in series with a slider (Prandtl element). Its force f depends on a
/// displacement u.
///
/// While `|K (u - ANCHOR)| <= LIMIT` the element sticks, and `f = K (u - ANCHOR)`. Beyond this limit, the element slides and `f = +-LIMIT`.
/// ANCHOR is the displacement at which the spring is unloaded. It is constant during an evaluation. `anchor_after` is its value once an
/// equilibrium is accepted (return mapping), so the force depends on the path. The derivatives are consistent with the return mapping: df/du is
/// K when sticking and 0 when sliding. K is positive, and LIMIT is not negative.
///
/// This is not an ADAMS element: ADAMS decks represent it by a user routine or not at all. Source: L. Prandtl, 1928, spring-slider element;
/// return mapping as in one-dimensional perfect plasticity.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Slip {
    /// Spring force f.
    pub force: f64,
    /// Derivative of the force with respect to the displacement, df/du.
    pub by_displacement: f64,
    /// Derivative of the force with respect to the stiffness, df/dK.
    pub by_stiffness: f64,
    /// Derivative of the force with respect to the force limit, df/dLIMIT.
    pub by_limit: f64,
    /// Derivative of the force with respect to the anchor (the displacement of the unloaded spring), df/dANCHOR.
    pub by_anchor: f64,
    /// Anchor (the displacement of the unloaded spring) after this displacement is accepted.
    pub anchor_after: f64,
}

impl Slip {
    /// Evaluates the element at displacement `u`; `theta` holds K, LIMIT and ANCHOR.
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

    /// Returns whether the slider moved away from `anchor`.
    pub fn slides(&self, anchor: f64) -> bool {
        self.anchor_after != anchor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A full cycle with an amplitude U that makes the element slide encloses the area 4 LIMIT (U - LIMIT / K).
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
    fn derivatives_are_those_of_the_branch() {
        // u = -0.7 differs from the anchor at 0.2 by more than 3 / 100, so the element slides; at 0.21 it sticks.
        for u in [-0.7, 0.21] {
            let theta = [100.0, 3.0, 0.2];
            let slip = Slip::at(u, &theta);
            let h = 1e-5;
            let by = |k: usize| {
                let at = |h: f64| {
                    let mut theta = theta;
                    theta[k] += h;
                    Slip::at(u, &theta).force
                };
                (at(h) - at(-h)) / (2.0 * h)
            };
            let by_displacement =
                (Slip::at(u + h, &theta).force - Slip::at(u - h, &theta).force) / (2.0 * h);
            for (exact, difference) in [
                (slip.by_displacement, by_displacement),
                (slip.by_stiffness, by(0)),
                (slip.by_limit, by(1)),
                (slip.by_anchor, by(2)),
            ] {
                assert!(
                    (exact - difference).abs() < 1e-7,
                    "{u}: {exact} {difference}"
                );
            }
        }
    }

    #[test]
    fn the_anchor_follows_so_that_the_force_stays_at_the_limit() {
        let slip = Slip::at(3.0, &[100.0, 50.0, 0.0]);
        assert!(slip.slides(0.0));
        let again = Slip::at(3.0, &[100.0, 50.0, slip.anchor_after]);
        assert_eq!((slip.force, again.force), (50.0, 50.0));
        // A reversal sticks at once, with the full stiffness.
        let back = Slip::at(2.9, &[100.0, 50.0, slip.anchor_after]);
        assert!((back.force - 40.0).abs() < 1e-12 && back.by_displacement == 100.0);
    }
}
