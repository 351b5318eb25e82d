//! Settings of the diagnosis: levels, limits, tolerances and numerical guards. `admire explain priors` prints them.

admire_study::constants! {
    // ## Fits: fit.rs, remainder.rs, other_solver.rs, progress.rs

    /// Maximum number of Gauss-Newton steps of a fit.
    MAX_FIT_ITERATIONS: usize = 16, "";
    /// Predicted decrease below which a fit counts as converged.
    CONVERGED_NATS: f64 = 1.0, "nats";
    /// Ratio of rms residual to declared noise above which a stiffness-only fit may be in a wrong minimum. Growing variance components would
    /// hide such a minimum.
    WRONG_MINIMUM_RMS_SIGMA: f64 = 1.3, "sigma";
    /// Largest change of the logarithm of a stiffness in a first guess, and in one round of the fit to another solver.
    MAX_LN_STIFFNESS_STEP: f64 = 0.8, "ln";
    /// Maximum number of sweeps in one search. One sweep solves all load cases once. The limit is checked between rounds only, so that results
    /// do not depend on the machine.
    MAX_SWEEPS: usize = 3000, "";
    /// Maximum number of rounds of the fit to another solver.
    OTHER_SOLVER_MAX_ROUNDS: usize = 5, "";
    /// Largest change of a stiffness or cause parameter at which the rounds of the fit to another solver end.
    OTHER_SOLVER_TOLERANCE_SD: f64 = 0.02, "sd";
    /// Difference of the solvers below which it is negligible against the noise of the marks.
    NEGLIGIBLE_DIFFERENCE_SIGMA: f64 = 0.1, "sigma";

    // ## Candidate effects and first guesses of their parameters: candidate_effect.rs, unknowns.rs, frame.rs, causes

    /// Fraction of its half-normal scale up to which a compliance counts as absent, and smallest first guess of a compliance.
    ABSENT_COMPLIANCE: f64 = 1e-3, "";
    /// Translational stiffness of a split part in the directions that do not yield.
    RIGID_STIFFNESS_N_PER_MM: f64 = 1e7, "N/mm";
    /// Rotational stiffness of a split part.
    RIGID_STIFFNESS_NMM_PER_RAD: f64 = 1e11, "N mm/rad";
    /// Stiffness of a split part in the directions that yield, before a fit.
    SPLIT_STIFFNESS_N_PER_MM: f64 = 1e6, "N/mm";
    /// Maximum number of sliders of one friction.
    MAX_SLIDERS: usize = 3, "";
    /// First guesses of the slip length of a friction, short, middle and long, as fractions of the displacement range.
    START_SLIP_LENGTHS: [f64; 3] = [0.01, 0.08, 0.3], "of range";
    /// First guesses of the force of a friction in the first case, as fractions of its limit: free, pushed and pulled.
    START_FRICTION_FORCES: [f64; 3] = [0.0, 1.0, -1.0], "";
    /// First guesses of the fraction of the distance that rubber flows in one case. Faster flow has ended before the reading. With a fraction
    /// near one, the force would depend on the last load step only, which looks like friction if the steps are equal.
    START_CREEP_RATES: [f64; 3] = [0.1, 0.3, 0.5], "";
    /// First guesses of the clearance of a stop, as fractions of the displacement range.
    START_CLEARANCES: [f64; 4] = [0.25, 0.5, 0.7, 0.85], "of range";
    /// Number of Karhunen-Loeve functions that represent a drift of the frame from case to case.
    FRAME_DRIFT_FUNCTIONS: usize = 6, "";

    // ## Readings far from the fit: diagnosis_problem.rs

    /// Residual beyond which a mark coordinate counts as far from the fit.
    FAR_MARK_SIGMA: f64 = 4.0, "sigma";
    /// Fraction of the mark coordinates below which far readings count as few.
    FEW_FAR_MARKS: f64 = 0.03, "";

    // ## Findings: findings.rs, averaged.rs, limits.rs

    /// Rms change of the marks by a finding below which the finding is minor.
    MINOR_MARKS_SIGMA: f64 = 0.2, "sigma";
    /// Change of the wheel angles by a finding below which the finding is minor.
    MINOR_WHEEL_DEG: f64 = 0.01, "deg";
    /// Loss of cross-validated log predictive density above which a cause is not listed. It covers the error of the comparison.
    CV_TOLERANCE_NATS: f64 = 0.5, "nats";
    /// Loss of cross-validated log predictive density above which a freed random effect is not listed. Without the cause its tolerance group
    /// absorbs it, with almost the same predictions.
    CV_RANDOM_EFFECT_TOLERANCE_NATS: f64 = 3.0, "nats";
    /// Largest deficit of a rival, in twice the log posterior odds.
    RIVAL_WINDOW_TWO_NATS: f64 = 6.0, "2 nats";
    /// Relative half width above which only the upper bound of an interval is stated.
    ONE_SIDED_HALF_WIDTH: f64 = 0.8, "";
    /// Probability of a model up to which its variances without tolerances are replaced by those with tolerances in the average over the
    /// models.
    AVERAGED_MIN_PROBABILITY: f64 = 0.01, "";
    /// Largest detection limit of a hardpoint that is reported.
    MAX_HARDPOINT_LIMIT_MM: f64 = 50.0, "mm";
    /// Largest detection limit of other causes that is reported, in prior standard deviations.
    MAX_CAUSE_LIMIT_SD: f64 = 20.0, "sd";

    // ## Force of unknown law: gaussian_process.rs, remainder.rs

    /// Gain in log evidence from which a site stands out, after subtracting the log of the number of sites and coordinates tried.
    GP_SITE_NATS: f64 = 5.0, "nats";
    /// Relative eigenvalue of the covariance below which a direction is left out.
    GP_ROUND_OFF: f64 = 1e-6, "";
    /// Tolerance of the low-rank covariance factor, for a diagonal of ones.
    GP_FACTOR_TOLERANCE: f64 = 1e-9, "";

    // ## Checks on other cases: diagnose.rs, cross_validation.rs

    /// Every how many cases one is held out, where the study names none.
    HOLD_OUT_PERIOD: usize = 4, "";
    /// P-value of the held-out readings under the extended model below which its causes are not trusted.
    HELD_OUT_LEVEL: f64 = 0.002, "";
    /// Minimum number of cases for a cross-validation.
    CV_MIN_CASES: usize = 4, "";
    /// Maximum number of groups of a cross-validation. The smallest are merged beyond it.
    CV_MAX_GROUPS: usize = 6, "";
    /// Number of blocks into which the cases are cut if they form a single group.
    CV_BLOCKS: usize = 4, "";
    /// Distance from the usual value of a load, as a fraction of its range, within which the load counts as usual.
    AT_REST_TOLERANCE: f64 = 1e-3, "of range";
    /// Spread of the gains of groups, relative to the overall gain, above which the gain is said to depend on the cases.
    UNEVEN_GAIN_RATIO: f64 = 1.5, "";

    // ## Curves of the report: wheel_run.rs

    /// Minimum number of successive cases in a run.
    RUN_MIN_CASES: usize = 4, "";
    /// Maximum number of channels for which curves are drawn.
    RUN_MAX_CHANNELS: usize = 8, "";
}
