//! What is left of the forces on each part, summed anew.

use crate::mechanics::Vec3;
use crate::system::{Name, NoValue, Parameters, Scratch, State, System};

/// Share of the largest sum of sizes on a part that may be left by round-off.
const ROUND_OFF: f64 = 1e-9;
/// So many times IMBALANCE may be left: it holds for single components.
const COMPONENTS: f64 = 10.0;

/// What is left at one part.
#[derive(Clone, PartialEq, Debug)]
pub struct Left {
    /// Length of the force or torque that is left.
    pub size: f64,
    /// The part where it is.
    pub part: Name,
}

/// The largest force and torque that are left over on a part, in units of the deck: force, and force times length.
///
/// They are summed from the single loads of the free-body diagrams, torques about part origins. The residual that Newton's
/// method brought to zero is put together in another way.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Balance {
    /// Where the largest force is left; `None` if no part moves.
    pub force: Option<Left>,
    /// Where the largest torque is left; `None` if no part turns.
    pub torque: Option<Left>,
    /// The largest sum of sizes of forces on a part.
    forces: f64,
    /// The largest sum of sizes of torques on a part.
    torques: f64,
}

impl Balance {
    /// Sums the loads on every part.
    ///
    /// # Errors
    /// [`NoValue`] if an element is undefined in this state.
    pub fn of(system: &System, parameters: &Parameters, state: &State) -> Result<Self, NoValue> {
        let mut scratch = Scratch::new(system);
        let loads = system.look(parameters, state, &mut scratch)?.loads()?;
        let mut sums = vec![(Vec3::zeros(), Vec3::zeros()); system.bodies.len()];
        let mut sizes = vec![(0.0, 0.0); system.bodies.len()];
        for load in &loads {
            let part = load.part.0;
            let torque = load.torque_about(&state.poses[part].p);
            sums[part].0 += load.force;
            sums[part].1 += torque;
            sizes[part].0 += load.force.norm();
            sizes[part].1 += torque.norm();
        }
        let mut out = Self::default();
        for (part, body) in system.bodies.iter().enumerate() {
            let left = |size: f64, before: &mut Option<Left>| {
                // A NaN must not hide.
                if before.as_ref().is_none_or(|before| !(size <= before.size)) {
                    let part = system.part_name(crate::model::PartIx(part)).clone();
                    *before = Some(Left { size, part });
                }
            };
            if body.freedoms >= 3 {
                left(sums[part].0.norm(), &mut out.force);
                out.forces = out.forces.max(sizes[part].0);
            }
            if body.freedoms == 6 {
                left(sums[part].1.norm(), &mut out.torque);
                out.torques = out.torques.max(sizes[part].1);
            }
        }
        Ok(out)
    }

    /// True if no more is left than the tolerance IMBALANCE and round-off explain.
    pub fn holds(&self, imbalance: f64) -> bool {
        let within = |left: &Option<Left>, sizes: f64| {
            let most = COMPONENTS * imbalance + ROUND_OFF * sizes;
            left.as_ref().is_none_or(|left| left.size <= most)
        };
        within(&self.force, self.forces) && within(&self.torque, self.torques)
    }

    /// The worse of two in each of the two kinds.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        let larger = |a: Option<Left>, b: Option<Left>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.size > a.size { b } else { a }),
            (a, b) => a.or(b),
        };
        Self {
            force: larger(self.force, other.force),
            torque: larger(self.torque, other.torque),
            forces: self.forces.max(other.forces),
            torques: self.torques.max(other.torques),
        }
    }
}
