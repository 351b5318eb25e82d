//! Section `[priors]` of `study.toml`: probabilities and sizes of the causes of a diagnosis, before any reading is taken into account.

use super::constant::Constant;
use super::section::Section;
use admire_syntax::diagnostic::Diagnostic;

/// Declares the priors. Each prior is a field of [`CausePriors`], a key of `[priors]`, and an entry in the output of `admire explain priors`.
macro_rules! priors {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:literal, $unit:literal, $least:literal to $most:literal;)+) => {
        /// Settings of `[priors]`: prior probabilities and prior standard deviations of the causes of a diagnosis.
        #[derive(Clone, Copy, PartialEq, Debug)]
        pub struct CausePriors {
            $($(#[doc = $doc])+ pub $name: f64,)+
        }

        impl Default for CausePriors {
            fn default() -> Self {
                Self { $($name: $value,)+ }
            }
        }

        impl CausePriors {
            /// All priors with their default values.
            pub const TABLE: &'static [Constant] = &[
                $(Constant {
                    name: stringify!($name),
                    value: stringify!($value),
                    unit: $unit,
                    meaning: concat!($($doc),+),
                },)+
            ];

            pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
                Self {
                    $($name: section.number(stringify!($name), $value, $least..=$most, out),)+
                }
            }
        }
    };
}

priors! {
    /// Probability of each class of causes, divided equally among its places and forms.
    class_probability = 0.05, "", 1e-6 to 0.5;
    /// Standard deviation of each coordinate of a connection point; all parts that meet there are displaced together.
    hardpoint_mm = 3.0, "mm", 1e-3 to 1e3;
    /// Standard deviation of each coordinate of a connection on one part alone; the axle is then assembled under strain.
    part_end_mm = 1.5, "mm", 1e-3 to 1e3;
    /// Standard deviation of each coordinate of the point where a load acts.
    load_point_mm = 10.0, "mm", 1e-3 to 1e3;
    /// Standard deviation of the offset between the two sides of a bushing at design.
    bushing_offset_mm = 0.5, "mm", 1e-4 to 1e2;
    /// Standard deviation of the angle between the two sides of a bushing at design.
    bushing_offset_deg = 0.5, "deg", 1e-4 to 90.0;
    /// Standard deviation of the orientation of both sides of a bushing together.
    bushing_orientation_deg = 9.74, "deg", 1e-3 to 180.0;
    /// Standard deviation of the gain of a load.
    load_gain = 0.03, "", 1e-5 to 1.0;
    /// Standard deviation of the fraction of one load that also acts along another load.
    load_crosstalk = 0.02, "", 1e-5 to 1.0;
    /// Standard deviation of a rubber stiffness, relative to its value in the deck.
    rubber_stiffness = 0.4, "", 1e-4 to 3.0;
    /// Standard deviation of a spring rate, relative to its value in the deck.
    spring_rate = 0.1, "", 1e-4 to 3.0;
    /// Standard deviation of a spring preload, relative to its value in the deck.
    spring_preload = 0.05, "", 1e-4 to 3.0;
    /// Half-normal scale of the compliance of a link along its line.
    link_compliance_mm_per_n = 1e-4, "mm/N", 1e-9 to 1.0;
    /// Half-normal scale of the compliance of a part where a joint is fixed to it.
    body_compliance_mm_per_n = 1e-4, "mm/N", 1e-9 to 1.0;
    /// Half-normal scale of the compliance of the seat of a spring.
    spring_seat_compliance_mm_per_n = 5e-4, "mm/N", 1e-9 to 1.0;
    /// Probability that a part yields in line with a link beside it, relative to other directions.
    in_line_odds = 0.5, "", 1e-3 to 1.0;
    /// Half-normal scale of a friction force.
    friction_n = 300.0, "N", 1e-3 to 1e6;
    /// Median slip length of friction, as a fraction of the range of the deflection.
    slip_length = 0.06, "of range", 1e-4 to 1.0;
    /// Standard deviation of the logarithm of the slip length.
    slip_length_ln_sd = 1.5, "ln", 0.01 to 5.0;
    /// Probability that friction reaches its limit gradually (Dahl) rather than at once.
    gradual_friction = 0.3, "", 1e-3 to 0.999;
    /// Probability that the limit of a friction differs by direction.
    friction_asymmetry = 0.1, "", 1e-3 to 0.999;
    /// Standard deviation of the difference between the friction limits of both directions, relative to the friction force.
    friction_asymmetry_size = 0.3, "", 1e-3 to 2.0;
    /// Half-normal scale of the play of a joint.
    free_play_mm = 0.2, "mm", 1e-4 to 1e2;
    /// Force that takes up the play of a joint, as a fraction of the largest force at the joint; grease and friction hold the joint within its play.
    free_play_held = 0.02, "", 1e-4 to 1.0;
    /// Standard deviation of the logarithm of the stiffness within the play.
    free_play_stiffness_ln_sd = 1.5, "ln", 0.01 to 5.0;
    /// Median contact stiffness at the end of the play.
    contact_stiffness_n_per_mm = 1e5, "N/mm", 1.0 to 1e9;
    /// Standard deviation of the logarithm of the contact stiffness.
    contact_stiffness_ln_sd = 1.0, "ln", 0.01 to 5.0;
    /// Half-normal scale of the stiffness of a stop.
    stop_stiffness_n_per_mm = 2000.0, "N/mm", 1e-2 to 1e8;
    /// Compression at which the cubic term has doubled the force of a progressive stop, as a fraction of the range of the deflection.
    stop_hardening = 0.3, "of range", 1e-3 to 10.0;
    /// Standard deviation of the clearance of a stop, as a fraction of the range of the deflection.
    stop_clearance = 0.2, "of range", 1e-3 to 10.0;
    /// Increase of the rate of progressive rubber at the largest deflection: half-normal scale, relative to the rate.
    progressive_stiffness = 0.5, "", 1e-3 to 100.0;
    /// Standard deviation of the coupling of two axes, relative to the geometric mean of their stiffnesses.
    bushing_coupling = 0.1, "", 1e-4 to 1.0;
    /// Probability that a coupling grows with the deflection.
    growing_coupling = 0.3, "", 1e-3 to 0.999;
    /// Half-normal scale of the fraction of a stiffness that relaxes.
    creep_share = 0.3, "", 1e-3 to 1.0;
    /// Standard deviation of the fraction of the relaxation that takes place within one case.
    creep_rate = 0.15, "", 1e-3 to 1.0;
    /// Probability of creep relative to other classes: the cases of most measurements follow one another faster than rubber relaxes.
    creep_odds = 0.2, "", 1e-3 to 1.0;
    /// Standard deviation of the shift of the measuring frame in a case.
    frame_shift_mm = 0.2, "mm", 1e-4 to 1e2;
    /// Standard deviation of the rotation of the measuring frame in a case.
    frame_turn_deg = 0.03, "deg", 1e-4 to 90.0;
    /// Standard deviation of the gain of a channel.
    channel_gain = 0.1, "", 1e-4 to 1.0;
    /// Probability of a force whose law the catalogue lacks, relative to the classes of causes.
    unmodelled_force_odds = 0.1, "", 1e-6 to 1.0;
    /// Probability that the true force at the site of a cause deviates from the law of the cause.
    law_misfit = 0.5, "", 1e-3 to 0.999;
    /// Largest deviation of the true force from the law of a cause, relative to the usual force at the site.
    law_misfit_size = 0.3, "", 1e-3 to 10.0;
}
