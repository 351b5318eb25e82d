use super::Header;

/// INPUTS: the joint loads that cause friction.
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
    /// Index of the JOINT in the model.
    pub joint: usize,
    /// Whether there is friction between the yoke of I and the cross, and between the cross and the yoke of J (HOOKE and UNIVERSAL).
    pub yokes: [bool; 2],
    /// Static friction coefficient, MU_STATIC.
    pub mu_static: f64,
    /// Dynamic friction coefficient, MU_DYNAMIC.
    pub mu_dynamic: f64,
    /// Velocity below which the joint sticks, STICTION_TRANSITION_VELOCITY.
    pub stiction_velocity: f64,
    /// TRANSITION_VELOCITY_COEFFICIENT: ratio of the velocity of full dynamic friction to the stiction transition velocity.
    pub transition: f64,
    /// Maximum stiction deformation, MAX_STICTION_DEFORMATION.
    pub deformation: f64,
    /// Force preload, FRICTION_FORCE_PRELOAD.
    pub force_preload: f64,
    /// Torque preload, FRICTION_TORQUE_PRELOAD.
    pub torque_preload: f64,
    /// Whether EFFECT includes stiction.
    pub stiction: bool,
    /// Whether EFFECT includes sliding.
    pub sliding: bool,
    /// Loads that cause friction, INPUTS.
    pub inputs: FrictionInputs,
    /// Whether ADAMS applies the friction in statics: neither INACTIVE=STATIC nor EFFECT=SLIDING is given.
    pub in_statics: bool,
    /// Radius of the ball, BALL_RADIUS.
    pub ball_radius: f64,
    /// Radius of the pin, PIN_RADIUS.
    pub pin_radius: f64,
    /// Lever arm of the torsional reaction, REACTION_ARM.
    pub reaction_arm: f64,
    /// Lever arm of the friction caused by the axial force, FRICTION_ARM.
    pub friction_arm: f64,
    /// Lever arm of the bending reaction, BENDING_REACTION_ARM.
    pub bending_arm: f64,
    /// Initial overlap of the sliding bodies, INITIAL_OVERLAP.
    pub overlap: f64,
    /// Derivative of the overlap with respect to the displacement: 1, -1 or 0 (OVERLAP_DELTA).
    pub overlap_by_displacement: f64,
}
