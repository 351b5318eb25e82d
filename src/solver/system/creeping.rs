//! Joint friction in a row of equilibria: what a slow rig sees of it.
//!
//! The law of friction at rest: the coefficient grows with the creep up to MAX_STICTION_DEFORMATION, from where the surfaces slide. Between
//! two equilibria the creep is the displacement; what lies beyond the limit is slid away, so that the force is that of an elastic slider
//! and does not depend on the rate.

use super::surface::Friction;
use super::{Parameters, Scratch, State, StictionState, System};
use crate::element::FrictionLaw;
use crate::mechanics::Vec3;

/// The coefficient that sliding surfaces have in a row of equilibria.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum SlidingWith {
    /// MU_DYNAMIC: the rig moves faster than STICTION_TRANSITION_VELOCITY. MU_STATIC where EFFECT = STICTION.
    #[default]
    Dynamic,
    /// MU_STATIC.
    Static,
}

impl SlidingWith {
    /// `dynamic` or `static`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Dynamic => "dynamic",
            Self::Static => "static",
        }
    }
}

/// What the surfaces of a deck do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StickSlipState {
    /// All slide.
    Sliding,
    /// Some slide.
    Mixed,
    /// None slides.
    Sticking,
    /// Nothing rubs for now: as after a shake.
    Released,
}

impl StickSlipState {
    /// `sliding`, `mixed` or `sticking`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Mixed => "mixed",
            Self::Sticking => "sticking",
            Self::Released => "released",
        }
    }
}

impl Friction {
    fn counts_at_rest(&self) -> bool {
        self.active && self.at_rest.is_some()
    }
}

impl System {
    /// Lets the joints of these FRICTIONs creep in statics, too. Then [`System::creep_on`] moves the surfaces on from one equilibrium to
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

    /// True if any friction acts in statics.
    pub fn creeps(&self) -> bool {
        self.frictions.iter().any(Friction::counts_at_rest)
    }

    /// Moves the surfaces on to an equilibrium: the creep starts from here at the first call, and ends at the limit of sliding. Tells
    /// what the surfaces do; `None` without any.
    pub fn advance_friction(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Option<StickSlipState> {
        /// So near the limit surfaces slide: round-off leaves a creep on either side of it.
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
