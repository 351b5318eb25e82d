//! Settings of the diagnosis: levels, limits, tolerances and numerical guards. `admire explain priors` prints them.

admire_study::constants! {
    // ## Fits: fit.rs, remainder.rs, unknowns.rs, other_solver.rs, progress.rs

    /// Maximum number of Gauss-Newton steps of a fit.
    MAX_FIT_ITERATIONS: usize = 16, "";
    /// Deficit of the predicted log evidence against the leading set, above which a fit stops.
    LEAD_FAR_NATS: f64 = 50.0, "nats";
    /// Deficit against the leading set above which a fit stops, even if it gained `LEAD_CLOSE_RISE` times the predicted log evidence.
    LEAD_CLOSE_NATS: f64 = 7.0, "nats";
    /// Factor on the predicted gain of a fit, which gives the largest gain in log evidence that is considered possible.
    LEAD_CLOSE_RISE: f64 = 3.0, "";
    /// Deficit of the predicted log evidence against the leading set, above which a fit stops in its first steps.
    LEAD_LOST_NATS: f64 = 200.0, "nats";
    /// Number of most recent steps from which the rate of progress of a fit is estimated.
    PACE_STEPS: usize = 3, "";
    /// Number of steps in which the log evidence of a fit must rise by `STILL_NATS`.
    STILL_STEPS: usize = 4, "";
    /// Smallest rise of the log evidence in `STILL_STEPS` steps, below which a fit stops.
    STILL_NATS: f64 = 0.2, "nats";
    /// Predicted decrease of the negative log posterior below which a fit takes no further step.
    NEGLIGIBLE_GAIN_NATS: f64 = 0.01, "nats";
    /// Predicted decrease of the negative log posterior below which a fit counts as converged.
    CONVERGED_NATS: f64 = 1.0, "nats";
    /// Ratio of rms residual to declared noise above which a stiffness-only fit may have ended in a wrong minimum. A second start is then
    /// tried, because growing variance components would hide the wrong minimum.
    WRONG_MINIMUM_RMS_SIGMA: f64 = 1.3, "sigma";
    /// Prior standard deviation of an unknown that is fixed at its bound. It is so small that the readings do not move the unknown.
    HELD_UNKNOWN_SD: f64 = 1e-6, "";
    /// Largest change of the logarithm of a stiffness: in a first guess, and in one round of the fit to another solver.
    MAX_LN_STIFFNESS_STEP: f64 = 0.8, "ln";
    /// Maximum number of sweeps in one search. One sweep solves all load cases once. The limit is checked between rounds of the search only,
    /// so that results do not depend on the machine.
    MAX_SWEEPS: usize = 3000, "";
    /// Maximum number of rounds of the fit to a solver other than the built-in solver.
    OTHER_SOLVER_MAX_ROUNDS: usize = 5, "";
    /// Largest change of a stiffness or cause parameter in one round, in standard deviations, at which the fit to another solver ends.
    OTHER_SOLVER_TOLERANCE_SD: f64 = 0.02, "sd";
    /// Rms difference between two solvers up to which the difference is negligible, relative to the noise of the marks.
    NEGLIGIBLE_DIFFERENCE_SIGMA: f64 = 0.1, "sigma";

    // ## Candidate effects and first guesses of their parameters: candidate_effect.rs, unknowns.rs, frame.rs, causes

    /// Smallest compliance, as a fraction of its half-normal scale. A smaller compliance counts as absent, and first guesses are not
    /// smaller.
    ABSENT_COMPLIANCE: f64 = 1e-3, "";
    /// Translational stiffness between a split-off part and its old part, in the rigid directions.
    RIGID_STIFFNESS_N_PER_MM: f64 = 1e7, "N/mm";
    /// Rotational stiffness between a split-off part and its old part.
    RIGID_STIFFNESS_NMM_PER_RAD: f64 = 1e11, "N mm/rad";
    /// Translational stiffness between a split-off part and its old part in the compliant directions, before a fit.
    SPLIT_STIFFNESS_N_PER_MM: f64 = 1e6, "N/mm";
    /// Maximum number of sliders in one friction law.
    MAX_SLIDERS: usize = 3, "";
    /// First guesses of the creep rate: the fraction of the remaining distance by which rubber flows in one case. Faster flow has ended
    /// before the reading. With a fraction near one, the force would depend on the last load step only, which looks like friction if the
    /// steps are equal.
    START_CREEP_RATES: [f64; 3] = [0.1, 0.3, 0.5], "";
    /// First guesses of the stiffness within a free play, in prior standard deviations of its logarithm. A fit from a stiff spring may end with less
    /// play than there is.
    START_PLAY_STIFFNESSES: [f64; 2] = [0.0, -2.0], "sd";
    /// First guesses of the clearance of a stop, as fractions of the displacement range.
    START_CLEARANCES: [f64; 4] = [0.25, 0.5, 0.7, 0.85], "of range";
    /// Number of Karhunen-Loeve functions that represent a drift of the measuring frame from case to case.
    FRAME_DRIFT_FUNCTIONS: usize = 6, "";

    // ## Errors of the rig: rig_errors.rs

    /// Largest number of errors of single cases, of loads or of the measuring frame. In a study with more, these errors are left out.
    MAX_CASE_ERRORS: usize = 400, "";
    /// Largest number of loads for which a compliance of the mount is considered.
    MAX_MOUNT_LOADS: usize = 12, "";

    // ## Readings far from the fit: diagnosis_problem.rs, base_fit.rs

    /// Maximum number of rounds in which readings far from the fit are judged.
    OUTLIER_ROUNDS: usize = 3, "";

    /// Residual beyond which a mark coordinate counts as far from the fit.
    FAR_MARK_SIGMA: f64 = 4.0, "sigma";
    /// Fraction of the mark coordinates below which the coordinates far from the fit count as few.
    FEW_FAR_MARKS: f64 = 0.03, "";

    // ## Findings: findings.rs, averaged.rs, limits.rs

    /// Rms change of the marks by the effect of a finding, below which the finding is minor.
    MINOR_MARKS_SIGMA: f64 = 0.2, "sigma";
    /// Rms change of the wheel angles by the effect of a finding, below which the finding is minor.
    MINOR_WHEEL_DEG: f64 = 0.01, "deg";
    /// Largest deficit of a rival explanation against the leading model, in twice the log posterior odds.
    RIVAL_WINDOW_TWO_NATS: f64 = 6.0, "";
    /// Relative half width of an interval above which only its upper bound is stated.
    ONE_SIDED_HALF_WIDTH: f64 = 0.8, "";
    /// Probability up to which a model's variances without tolerances are not computed. The average over the models then uses its variances
    /// with tolerances instead.
    AVERAGED_MIN_PROBABILITY: f64 = 0.01, "";
    /// Largest detection limit of a hardpoint that is reported.
    MAX_HARDPOINT_LIMIT_MM: f64 = 50.0, "mm";
    /// Largest detection limit of any other cause that is reported, in prior standard deviations.
    MAX_CAUSE_LIMIT_SD: f64 = 20.0, "sd";

    // ## Force of unknown law: gaussian_process.rs, remainder.rs

    /// Gain in log evidence from which a force at a site stands out. The log of the number of sites and coordinates tried is added to it.
    GP_SITE_NATS: f64 = 5.0, "nats";
    /// Eigenvalue of the covariance, relative to the largest eigenvalue, below which the direction of its eigenvector is left out.
    GP_ROUND_OFF: f64 = 1e-6, "";
    /// Tolerance of the low-rank factor of a covariance with unit diagonal.
    GP_FACTOR_TOLERANCE: f64 = 1e-9, "";

    // ## Checks on other cases: diagnose.rs, cross_validation.rs

    /// Number of cases per period. If the study names no held-out cases, the last case of each period is held out.
    HOLD_OUT_PERIOD: usize = 4, "";
    /// P-value of the held-out readings under the extended model, below which these readings count as unexplained.
    HELD_OUT_LEVEL: f64 = 0.002, "";
    /// Minimum number of cases for a cross-validation.
    CV_MIN_CASES: usize = 4, "";
    /// Maximum number of groups of a cross-validation. If there are more, the smallest groups are merged.
    CV_MAX_GROUPS: usize = 6, "";
    /// Number of blocks into which the cases are cut if they form a single group.
    CV_BLOCKS: usize = 4, "";
    /// Distance from the usual value of a load, as a fraction of its range, within which the load counts as usual.
    AT_REST_TOLERANCE: f64 = 1e-3, "of range";
    /// Difference between the largest and the smallest gain of the cross-validation groups, relative to the overall gain, above which the gain is
    /// reported as uneven.
    UNEVEN_GAIN_RATIO: f64 = 1.5, "";

    // ## Curves of the report: wheel_run.rs

    /// Minimum number of successive cases in a run that is drawn as a curve.
    RUN_MIN_CASES: usize = 4, "";
    /// Maximum number of channels for which curves are drawn.
    RUN_MAX_CHANNELS: usize = 8, "";

    // ## Selection of effects: closure.rs, select.rs

    /// Occam's window: largest deficit in log posterior against the best set at which a set of effects is kept.
    OCCAM_WINDOW_NATS: f64 = 8.0, "nats";
    /// Probability of a set of effects, relative to the best set, above which the set is fitted. A set that predicts the same as a fitted set is
    /// not fitted.
    RESOLVED_PROBABILITY: f64 = 0.01, "";
    /// Squared distance between the predictions of two sets of effects, up to which the two predictions count as the same.
    EQUIVALENT_DISTANCE: f64 = 1.0, "sigma^2";
    /// Deflection, in the deck's length unit or in rad, up to which a component counts as unmoved because of round-off.
    ROUND_OFF_DEFLECTION: f64 = 1e-9, "";
    /// Difference of squared distances below which the difference is round-off.
    ROUND_OFF_DISTANCE: f64 = 1e-6, "sigma^2";
    /// Maximum number of effects in a set.
    MAX_EFFECTS: usize = 12, "";
    /// Maximum number of sets whose neighbours are evaluated at one fit. A neighbour differs by one added, dropped or exchanged effect.
    MAX_EXPANSIONS: usize = 60, "";
    /// Probability above which a cause is named.
    NAMED_PROBABILITY: f64 = 0.5, "";
    /// Maximum number of fits in one selection of effects.
    MAX_SELECTION_FITS: usize = 40, "";
    /// Maximum number of fits at which the effects are linearised.
    MAX_SELECTION_POINTS: usize = 12, "";
    /// Number of values of the limit, of the slip length and of the first force of a friction law that are scanned at a site.
    LAW_GRID: [usize; 3] = [16, 10, 5], "";
    /// Decades of the limit and of the slip length that the grid covers, below the largest values.
    LAW_GRID_DECADES: f64 = 3.0, "";
    /// Largest limit of a friction law that is scanned, in prior standard deviations.
    LAW_MAX_LIMIT_SD: f64 = 10.0, "sd";
    /// Number of times that the steps of the grid of friction laws are halved around the best value.
    LAW_REFINEMENTS: usize = 6, "";
    /// Slip length of a friction law with which a fit starts, as a fraction of the range of the displacement.
    START_SLIP_LENGTH: f64 = 0.1, "of range";
    /// Largest change of the logarithm of a stiffness from a fit to the start of the next fit.
    MAX_LN_STIFFNESS_START: f64 = 1.2, "ln";
}
