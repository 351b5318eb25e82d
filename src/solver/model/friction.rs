use super::Header;

/// INPUTS: joint loads that cause friction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub struct FrictionInputs {
    pub preload: bool,
    pub reaction_force: bool,
    pub bending_moment: bool,
    pub torsional_moment: bool,
}

/// FRICTION statement: friction in a joint.
#[derive(Clone, PartialEq, Debug)]
pub struct Friction {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Index of the JOINT in the model.
    pub joint: usize,
    /// Whether friction acts at each yoke of a HOOKE or UNIVERSAL joint. Entry 0 is between the yoke of I and the cross, entry 1 between
    /// the cross and the yoke of J.
    pub yokes: [bool; 2],
    /// Static friction coefficient, MU_STATIC.
    pub mu_static: f64,
    /// Dynamic friction coefficient, MU_DYNAMIC.
    pub mu_dynamic: f64,
    /// Velocity below which the joint sticks, STICTION_TRANSITION_VELOCITY.
    pub stiction_velocity: f64,
    /// TRANSITION_VELOCITY_COEFFICIENT: velocity of full dynamic friction divided by the stiction transition velocity.
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
    /// REACTION_ARM: lever arm of the torsional reaction.
    pub reaction_arm: f64,
    /// Lever arm of the friction caused by the axial force, FRICTION_ARM.
    pub friction_arm: f64,
    /// Lever arm of the bending reaction, BENDING_REACTION_ARM.
    pub bending_arm: f64,
    /// INITIAL_OVERLAP: initial overlap of the sliding bodies.
    pub overlap: f64,
    /// OVERLAP_DELTA as the derivative of the overlap with respect to the displacement: 1, -1 or 0.
    pub overlap_by_displacement: f64,
}
