/// History-dependent state of an effect. It is stored in VARIABLEs of the deck and updated after the equilibrium of each load case.
#[derive(Clone, PartialEq, Debug)]
pub struct HistoryState {
    /// Ids of the VARIABLEs that store the state, in the order of the state values of `law`.
    pub variables: Vec<u32>,
    /// Ids of the I and J markers between which the displacement is measured.
    pub markers: [u32; 2],
    /// Component of the displacement in J axes: 0 to 2 for x, y, z, and 3 to 5 for AX, AY, AZ.
    pub component: usize,
    /// Evolution law of the state.
    pub law: MemoryLaw,
}

/// Evolution law of a state that depends on the history of a displacement `u`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum MemoryLaw {
    /// A spring in series with a slider (Prandtl). The state is the anchor, the displacement at which the force is zero.
    Slip {
        /// Stiffness of the spring.
        stiffness: f64,
        /// Forces at which the slider slips: first towards positive displacements, then towards negative displacements.
        limits: [f64; 2],
        /// Force before the first case, in the design position, as a fraction of the limit. It is positive if the spring is extended.
        start: f64,
    },
    /// Dahl friction, `df/du = k (1 - f sgn(du) / F)`. The state consists of the displacement and the force at the last equilibrium.
    Dahl {
        /// Stiffness `k`, at zero force.
        stiffness: f64,
        /// Limit `F` that the force approaches.
        limit: f64,
        /// Force before the first case, as for [`MemoryLaw::Slip`].
        start: f64,
    },
    /// Creep of rubber. The state is the crept deflection. In every case it moves towards the actual deflection by a fixed fraction of their
    /// difference.
    Creep {
        /// Fraction of the difference per case, from 0 (no creep) to 1 (complete creep within a case).
        rate: f64,
    },
}

impl MemoryLaw {
    /// Returns the state before the first case. `u` is the displacement in the design position.
    pub(crate) fn before(self, u: f64) -> Vec<f64> {
        match self {
            Self::Slip {
                stiffness,
                limits,
                start,
            } => {
                let limit = limits[usize::from(start < 0.0)];
                vec![u - start * limit / stiffness]
            }
            Self::Dahl { limit, start, .. } => vec![u, start * limit],
            Self::Creep { .. } => vec![0.0],
        }
    }

    /// Returns the state after an equilibrium at displacement `u`. `held` is the state before this equilibrium.
    pub(crate) fn after(self, held: &[f64], u: f64) -> Vec<f64> {
        match self {
            Self::Slip {
                stiffness, limits, ..
            } => {
                let [plus, minus] = limits.map(|limit| limit / stiffness);
                vec![u - (u - held[0]).clamp(-minus, plus)]
            }
            Self::Dahl {
                stiffness, limit, ..
            } => {
                // The force after a monotonic path from (u0, f0) is s F - (s F - f0) exp(-k |u - u0| / F) with s = sgn(u - u0).
                let (u0, f0) = (held[0], held[1]);
                let goal = (u - u0).signum() * limit;
                let force = goal - (goal - f0) * libm::exp(-stiffness * (u - u0).abs() / limit);
                vec![u, force]
            }
            Self::Creep { rate } => vec![held[0] + rate * (u - held[0])],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slider_drags_its_anchor() {
        let law = MemoryLaw::Slip {
            stiffness: 4000.0,
            limits: [200.0, 200.0],
            start: 0.0,
        };
        // The slider moves at a displacement of 200 N / (4000 N/mm) = 0.05 mm from the anchor.
        let after = |anchor, u| law.after(&[anchor], u)[0];
        assert_eq!(after(0.0, 0.03), 0.0);
        assert!((after(0.0, 0.20) - 0.15).abs() < 1e-12);
        assert!((after(0.15, 0.12) - 0.15).abs() < 1e-12);
        assert!((after(0.15, -0.2) + 0.15).abs() < 1e-12);
    }

    #[test]
    fn each_way_has_its_own_limit() {
        let law = MemoryLaw::Slip {
            stiffness: 1000.0,
            limits: [300.0, 100.0],
            start: 0.0,
        };
        assert!((law.after(&[0.0], 1.0)[0] - 0.7).abs() < 1e-12);
        assert!((law.after(&[0.0], -1.0)[0] + 0.9).abs() < 1e-12);
    }

    #[test]
    fn the_state_before_the_first_case_is_a_force_at_the_design_position() {
        let slip = |start| MemoryLaw::Slip {
            stiffness: 4000.0,
            limits: [200.0, 100.0],
            start,
        };
        let force = |start: f64| 4000.0 * (1.5 - slip(start).before(1.5)[0]);
        assert!((force(0.0)).abs() < 1e-9);
        assert!((force(1.0) - 200.0).abs() < 1e-9);
        assert!((force(-0.5) + 50.0).abs() < 1e-9);
    }

    #[test]
    fn dahl_starts_with_its_stiffness_and_ends_at_its_limit() {
        let law = MemoryLaw::Dahl {
            stiffness: 4000.0,
            limit: 200.0,
            start: 0.0,
        };
        let after = |held: &[f64], u| law.after(held, u)[1];
        assert!((after(&[0.0, 0.0], 1e-6) - 4000.0 * 1e-6).abs() < 1e-6);
        assert!((after(&[0.0, 0.0], 5.0) - 200.0).abs() < 1e-9);
        // After a reversal from one limit and a long displacement, the force reaches the other limit.
        assert!((after(&[5.0, 200.0], -5.0) + 200.0).abs() < 1e-9);
        assert_eq!(after(&[1.0, 50.0], 1.0), 50.0);
    }

    #[test]
    fn creep_follows_the_deflection() {
        let law = MemoryLaw::Creep { rate: 0.25 };
        assert_eq!(law.after(&[0.0], 2.0), [0.5]);
        assert_eq!(law.after(&[2.0], 2.0), [2.0]);
    }
}
