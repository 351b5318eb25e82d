use super::Header;

/// Which loads of its joint cause friction: INPUTS.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub struct FrictionInputs {
    pub preload: bool,
    pub reaction_force: bool,
    pub bending_moment: bool,
    pub torsional_moment: bool,
}

/// FRICTION: friction in a joint.
#[derive(Clone, PartialEq, Debug)]
pub struct Friction {
    /// Id, name, origin.
    pub header: Header,
    /// Index of its JOINT in the model.
    pub joint: usize,
    /// Friction between the yoke of I and the cross, and between the cross and the yoke of J; of HOOKE and UNIVERSAL.
    pub yokes: [bool; 2],
    /// MU_STATIC.
    pub mu_static: f64,
    /// MU_DYNAMIC.
    pub mu_dynamic: f64,
    /// STICTION_TRANSITION_VELOCITY.
    pub stiction_velocity: f64,
    /// TRANSITION_VELOCITY_COEFFICIENT: the velocity of full dynamic friction over that.
    pub transition: f64,
    /// MAX_STICTION_DEFORMATION.
    pub deformation: f64,
    /// FRICTION_FORCE_PRELOAD.
    pub force_preload: f64,
    /// FRICTION_TORQUE_PRELOAD.
    pub torque_preload: f64,
    /// EFFECT: stiction.
    pub stiction: bool,
    /// EFFECT: sliding.
    pub sliding: bool,
    /// INPUTS.
    pub inputs: FrictionInputs,
    /// It acts in statics: neither INACTIVE=STATIC nor EFFECT=SLIDING.
    pub in_statics: bool,
    /// BALL_RADIUS.
    pub ball_radius: f64,
    /// PIN_RADIUS.
    pub pin_radius: f64,
    /// REACTION_ARM.
    pub reaction_arm: f64,
    /// FRICTION_ARM.
    pub friction_arm: f64,
    /// BENDING_REACTION_ARM.
    pub bending_arm: f64,
    /// INITIAL_OVERLAP.
    pub overlap: f64,
    /// OVERLAP_DELTA: change of the overlap with the displacement, 1, -1 or 0.
    pub overlap_by_displacement: f64,
}
