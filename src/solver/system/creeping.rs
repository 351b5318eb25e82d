//! Joint friction in a sequence of equilibria, as measured on a slow rig.
//!
//! In the friction law at rest, the coefficient grows with the creep up to MAX_STICTION_DEFORMATION. Beyond that creep, the surfaces slide.
//! Between two equilibria, the creep changes by the displacement, and creep beyond the limit is converted to sliding. The force therefore
//! equals the force of a spring-slider element and is independent of the rate.

use super::surface::JointFriction;
use super::{Parameters, Scratch, State, StictionState, System};
use crate::element::FrictionLaw;
use crate::mechanics::Vec3;

/// Friction coefficient of sliding surfaces in a sequence of equilibria.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum SlidingWith {
    /// Dynamic coefficient MU_DYNAMIC, for a rig that moves faster than STICTION_TRANSITION_VELOCITY. MU_STATIC is used where EFFECT =
    /// STICTION.
    #[default]
    Dynamic,
    /// Static coefficient MU_STATIC.
    Static,
}

impl SlidingWith {
    /// Returns the keyword: `dynamic` or `static`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Dynamic => "dynamic",
            Self::Static => "static",
        }
    }
}

/// Stick-slip state of all friction surfaces of a deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StickSlipState {
    /// All surfaces slide.
    Sliding,
    /// Some surfaces slide and others stick.
    Mixed,
    /// No surface slides.
    Sticking,
    /// Friction is temporarily absent, as after shaking the rig.
    Released,
}

impl StickSlipState {
    /// Returns the keyword: `sliding`, `mixed`, `sticking` or `released`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Mixed => "mixed",
            Self::Sticking => "sticking",
            Self::Released => "released",
        }
    }
}

impl JointFriction {
    fn counts_at_rest(&self) -> bool {
        self.active && self.at_rest.is_some()
    }
}

impl System {
    /// Enables the FRICTIONs with these ids in statics. [`System::advance_friction`] then updates their surfaces from one equilibrium to
    /// the next.
    pub fn enable_static_friction(&mut self, ids: &[u32], with: SlidingWith) {
        for friction in &mut self.frictions {
            if ids.contains(&friction.name.id) {
                let law = friction.law;
                let dynamic = with == SlidingWith::Dynamic && friction.slips;
                let mu_static = if dynamic {
                    law.mu_dynamic
                } else {
                    law.mu_static
                };
                friction.at_rest = Some(FrictionLaw { mu_static, ..law });
            }
        }
    }

    /// Returns whether any friction acts in statics.
    pub fn creeps(&self) -> bool {
        self.frictions.iter().any(JointFriction::counts_at_rest)
    }

    /// Updates the friction surfaces after an equilibrium has been found.
    ///
    /// The first call starts the creep at the present position. Later calls limit the creep to the sliding limit. Returns the state of the
    /// surfaces, or `None` if no friction acts in statics.
    pub fn advance_friction(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Option<StickSlipState> {
        /// Creep, relative to the limit, from which surfaces count as sliding. Round-off leaves the creep of sliding surfaces on either
        /// side of the limit.
        const NEAR: f64 = 1.0 - 1e-6;
        if !self.creeps() {
            return None;
        }
        let mut grips = std::mem::take(&mut state.grips);
        self.at(parameters, state, scratch).place_markers();
        let (mut sliding, mut all) = (0, 0);
        for (friction, grip) in self.frictions.iter().zip(&mut grips) {
            if !friction.counts_at_rest() {
                continue;
            }
            let here = self.at(parameters, state, scratch);
            let limit = friction.law.deformation;
            let crept = if grip.sticking {
                here.creep(friction, grip)
            } else {
                Vec3::zeros()
            };
            let (place, turn) = here.joint_place(friction);
            let size = crept.norm();
            all += 1;
            sliding += usize::from(size >= limit * NEAR);
            *grip = StictionState {
                sticking: true,
                creep: if size > limit {
                    crept * (limit / size)
                } else {
                    crept
                },
                place,
                turn,
                first: grip.first.or(Some(place)),
            };
        }
        state.grips = grips;
        Some(match sliding {
            0 => StickSlipState::Sticking,
            n if n == all => StickSlipState::Sliding,
            _ => StickSlipState::Mixed,
        })
    }
}
