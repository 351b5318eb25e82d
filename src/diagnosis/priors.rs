//! Priors of the diagnosis that are fixed in the code and cannot be set in `study.toml`. `admire explain priors` prints them.
//!
//! The priors of the causes are in `admire_study::CausePriors`. The priors of tolerances and noise are in `admire_identify::priors`.

admire_study::constants! {
    // ## Causes

    /// Prior probability of a progressive law in one translation of a bushing, given a progressive law in another translation of the same
    /// bushing.
    PROGRESSIVE_IN_OTHER_AXIS: f64 = 0.15, "";
    /// Prior standard deviation of the logarithm of a compliance. The median of this prior is the half-normal scale of the compliance. A fit
    /// uses the logarithm as its unknown.
    COMPLIANCE_LN_SD: f64 = 2.0, "ln";
    /// Lever arm that converts the plausible size of a force to the plausible size of a torque.
    FORCE_LEVER_MM: f64 = 100.0, "mm";

    // ## Force of unknown law, a Gaussian process: gaussian_process.rs

    /// Length scales tried for a smooth force, as fractions of the range of the coordinate.
    GP_LENGTH_SCALES: [f64; 4] = [0.06, 0.15, 0.4, 1.0], "of range";
    /// Length scales tried for the misfit of a force law, as fractions of the range of the coordinate. They are short, because such a force
    /// jumps where the motion reverses. The first value makes the cases practically independent.
    GP_MISFIT_LENGTH_SCALES: [f64; 4] = [1e-3, 0.02, 0.06, 0.15], "of range";
    /// Standard deviations tried for the force, as fractions of the typical force at the site. The typical force of a bushing component is
    /// the largest force in that component. The typical force of a joint is the largest force in any bushing.
    GP_FORCE_SIZES: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0], "";
}
