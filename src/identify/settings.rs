//! Settings of the identification: levels, limits, tolerances and numerical guards. `admire explain priors` prints them.

admire_study::constants! {
    // ## Statistics, also used by the diagnosis and the report

    /// 97.5 percent quantile of the standard normal distribution, for two-sided 95 percent intervals.
    pub NORMAL_QUANTILE_975: f64 = 1.959_963_984_540_054, "sd";
    /// Significance level of the chi-square test and of the lack-of-fit tests: probability of rejecting a correct model.
    pub LACK_OF_FIT_LEVEL: f64 = 1e-3, "";
    /// Standard deviation of ln K above which a number counts as unidentifiable.
    pub UNIDENTIFIABLE_LN_SD: f64 = 0.5, "ln";
    /// Standard deviation of ln K above which a profile-likelihood interval replaces the normal interval.
    pub POOR_NORMAL_LN_SD: f64 = 0.3, "ln";
    /// Residual beyond which Huber's loss lowers the weight of a reading: 95 percent efficiency under Gaussian noise.
    pub HUBER_THRESHOLD_SIGMA: f64 = 1.345, "sigma";
    /// Residual variance of a contrast, relative to its noise, below which the fit has absorbed the contrast.
    pub ABSORBED_VARIANCE_SHARE: f64 = 0.01, "";
    /// Component of a unit direction of stiffnesses below which the stiffness is left out of the direction's name.
    pub NAMED_COMPONENT: f64 = 0.15, "";
    /// Gain in log-likelihood of Student's t over the Gaussian above which heavy tails are accepted. About 1 in 400 studies with Gaussian
    /// noise exceeds it.
    pub HEAVY_TAILS_NATS: f64 = 4.0, "nats";
    /// Gain in log-likelihood of Student's t over the Gaussian above which heavy tails are possible. About 1 in 13 studies with Gaussian
    /// noise exceeds it.
    pub POSSIBLE_HEAVY_TAILS_NATS: f64 = 1.0, "nats";

    // ## Gauss-Newton fit: global/gauss_newton.rs, global/fit.rs

    /// Predicted decrease of the objective by the next step below which a fit has converged. That step would move no unknown by more than
    /// about a hundredth of its standard deviation.
    CONVERGED_DECREMENT_NATS: f64 = 1e-4, "nats";
    /// Largest step of any unknown, in units of its scale, below which a fit has converged. Convergence is nearly quadratic, so that a
    /// further step gains nothing.
    CONVERGED_STEP: f64 = 1e-6, "";
    /// Maximum number of trial steps of a fit, including rejected ones.
    MAX_TRIAL_STEPS: usize = 100, "";
    /// Largest trust region, in natural units of the unknowns: e-folds of a stiffness.
    MAX_TRUST_REGION: f64 = 1.5, "";
    /// Trust region, in natural units of the unknowns, below which round-off hides any progress.
    MIN_TRUST_REGION: f64 = 1e-9, "";
    /// Factor on the trust region after rejected steps.
    TRUST_REGION_SHRINKAGE: f64 = 0.3, "";
    /// Maximum number of steps that follow an uphill step before all of them are rejected.
    MAX_STEPS_AFTER_UPHILL: usize = 3, "";
    /// Predicted decrease below which a step counts as late. The objective is half a chi-square, so that all unknowns together then move by
    /// at most two standard deviations.
    LATE_STEP_NATS: f64 = 2.0, "nats";
    /// Fraction of the objective that must remain after a step for it to count as late. Where the residuals nearly vanish, their curvature
    /// has no effect.
    LATE_STEP_REMAINDER: f64 = 0.9, "";
    /// Maximum number of late steps retried with the updated curvature before the trust region shrinks.
    MAX_LATE_RETRIES: usize = 6, "";
    /// Ratio of observed to predicted curvature below which the secant correction of the Hessian is halved.
    CURVATURE_RATIO_LOW: f64 = 0.7, "";
    /// Ratio of observed to predicted curvature above which the secant correction of the Hessian is increased.
    CURVATURE_RATIO_HIGH: f64 = 1.1, "";
    /// Rms of the whitened residuals above which a fit counts as far from its solution.
    FAR_FIT_RMS_SIGMA: f64 = 3.0, "sigma";
    /// Maximum number of stages of the homotopy, which approaches a far solution by fits with inflated noise.
    HOMOTOPY_MAX_STAGES: usize = 12, "";
    /// Maximum number of trial steps in a stage of the homotopy.
    HOMOTOPY_MAX_STEPS: usize = 8, "";
    /// Ratio of successive misfits above which the stages of the homotopy end.
    HOMOTOPY_STALL_RATIO: f64 = 0.8, "";
    /// Predicted decrease below which a stage of the homotopy has converged.
    HOMOTOPY_DECREMENT_NATS: f64 = 0.1, "nats";
    /// Largest step of any unknown, in units of its scale, below which a stage of the homotopy has converged.
    HOMOTOPY_STEP: f64 = 1e-2, "";
    /// Probability that Gaussian noise produces an outlier anywhere in a study.
    OUTLIER_FALSE_ALARM: f64 = 1e-3, "";
    /// Distance of ln K from its prior mean at which a number counts as being at a bound.
    BOUND_LN_DISTANCE: f64 = 14.0, "ln";
    /// Distance between direct solution and fit that leads to a remark, in standard deviations of the direct solution.
    CONTRADICTION_SD: f64 = 6.0, "sd";

    // ## Derivatives and predictions: global/differences.rs, channel.rs, native.rs, unknown.rs, observation.rs, marginal.rs

    /// Central-difference step in units of an unknown; for ln K a relative change of 0.001. Truncation error and the ten digits of a results
    /// file then contribute about equally.
    DIFFERENCE_STEP: f64 = 1e-3, "";
    /// Central-difference step, in units of an unknown, for the explicit dependence of a channel on the unknowns with all parts fixed.
    CHANNEL_DIFFERENCE_STEP: f64 = 1e-5, "";
    /// Change of an unknown beyond which an equilibrium starts from the old solution instead of an extrapolation.
    MAX_EXTRAPOLATED_STEP: f64 = 0.5, "";
    /// Smallest load share of a spring in its load path; smaller values are round-off.
    MIN_LOAD_SHARE: f64 = 1e-4, "";
    /// Smallest noise of a mark coordinate, relative to the largest coordinate, for readings declared free of noise.
    MIN_RELATIVE_MARK_SIGMA: f64 = 1e-12, "";
    /// Prior standard deviation that represents an unknown without a prior, in the unit of the unknown.
    FLAT_PRIOR_SD: f64 = 1e6, "";

    // ## Motions along which a model is free: global/free.rs, observation.rs

    /// Change of a reading per radian or model length of a free motion, over its noise, below which the reading counts as unaffected.
    FREE_UNAFFECTED_SIGMA: f64 = 1e-3, "sigma";
    /// Residual beyond which a reading is downweighted when a part is placed along its free motions, as a multiple of the median of its case.
    FREE_OUTLIER_RATIO: f64 = 3.0, "";
    /// Maximum number of passes that determine the weights of readings along free motions.
    FREE_MAX_PASSES: usize = 4, "";
    /// Relative eigenvalue of a free motion below which it counts as round-off.
    FREE_ROUND_OFF: f64 = 1e-12, "";
    /// Step along a free motion, in radians or model lengths, below which a prediction counts as placed.
    FREE_PLACED_STEP: f64 = 1e-4, "";
    /// Longest step along a free motion, in radians or model lengths.
    FREE_MAX_STEP: f64 = 0.5, "";
    /// Maximum number of steps that place a prediction along its free motions.
    FREE_MAX_STEPS: usize = 20, "";

    // ## Profile-likelihood intervals: global/profile.rs, global/confidence.rs

    /// Half the 95 percent quantile of chi-square with one degree of freedom: rise of the objective at the ends of an interval.
    HALF_CHI_SQUARE_95: f64 = 1.920_729, "nats";
    /// Distance from the estimate beyond which a side of an interval counts as unbounded.
    PROFILE_MAX_LN_DISTANCE: f64 = 7.0, "ln";
    /// Largest displacement of the other unknowns along the path, in natural units.
    PROFILE_MAX_OTHER_STEP: f64 = 3.0, "";
    /// Largest distance of a rise from 1.92 at which the end is interpolated. The square root of the rise is taken as linear between points.
    PROFILE_INTERPOLATION_NATS: f64 = 0.4, "nats";
    /// Maximum number of profile points on one side of an interval.
    PROFILE_MAX_POINTS: usize = 10, "";
    /// Maximum number of evaluations per point before a fit with derivatives follows.
    PROFILE_MAX_EVALUATIONS: usize = 6, "";
    /// Number of evaluations per point above which the quadratic approximation counts as poor. Several local minima are then possible.
    PROFILE_FEW_EVALUATIONS: usize = 2, "";
    /// Predicted decrease by a constrained step below which a point is accepted.
    PROFILE_DECREMENT_NATS: f64 = 0.05, "nats";
    /// Largest step of any unknown, in units of its scale, below which a fit with derivatives has converged.
    PROFILE_STEP: f64 = 1e-4, "";
    /// Maximum number of trial steps of a fit with derivatives.
    PROFILE_MAX_TRIAL_STEPS: usize = 25, "";
    /// Central-difference step for the derivative of an unknown by its step.
    PROFILE_DIFFERENCE_STEP: f64 = 1e-6, "";

    // ## Direct solution: direct/mod.rs, bounded.rs

    /// Noise assigned to marks that are declared exact, whose weights would otherwise be infinite, in the length unit of the deck.
    DIRECT_MIN_MARK_SIGMA: f64 = 1e-6, "length";
    /// Largest change of ln K in one round.
    DIRECT_MAX_LN_STEP: f64 = 1.5, "ln";
    /// Largest distance of ln K from its start.
    DIRECT_MAX_LN_DISTANCE: f64 = 9.0, "ln";
    /// Number of pose corrections for one set of values.
    DIRECT_POSE_CORRECTIONS: usize = 3, "";
    /// Initial damping of the normal equations, relative to their diagonal.
    DIRECT_DAMPING: f64 = 1e-3, "";
    /// Factor on the damping after a rejected step.
    DIRECT_DAMPING_INCREASE: f64 = 8.0, "";
    /// Divisor of the damping after an accepted step.
    DIRECT_DAMPING_DECREASE: f64 = 5.0, "";
    /// Damping beyond which no descent is possible.
    DIRECT_MAX_DAMPING: f64 = 1e6, "";
    /// Absolute part of the change of ln K that counts as converged.
    DIRECT_LN_TOLERANCE: f64 = 1e-7, "ln";
    /// Part of the change of ln K that counts as converged, relative to the standard deviation of ln K.
    DIRECT_SD_TOLERANCE: f64 = 0.05, "sd";
    /// Number of rounds with the poses as measured before they are corrected, one entry per attempt. Few rounds keep poorly determined
    /// stiffnesses from collapsing; many rounds bring well-determined ones close to the solution.
    DIRECT_MEASURED_POSE_ROUNDS: [usize; 2] = [2, 12], "";
    /// P-value of the misfit above which an attempt is accepted.
    DIRECT_ACCEPTED_P_VALUE: f64 = 1e-3, "";
    /// Maximum number of block exchanges of a bounded least-squares problem.
    MAX_BLOCK_EXCHANGES: usize = 12, "";
    /// Maximum number of rounds of the active-set method for a bounded least-squares problem.
    MAX_ACTIVE_SET_ROUNDS: usize = 400, "";

    // ## Tests of a fit and noise of channels: lack_of_fit.rs, noise.rs

    /// Minimum number of marks of a part in a case that separate its pose error from the noise of the marks.
    MIN_POSE_MARKS: usize = 3, "";
    /// Minimum degrees of freedom of the scatter of the marks that serves as reference for pose errors.
    MIN_SCATTER_DOF: f64 = 12.0, "";
    /// Minimum number of cases of a series in which sign runs are counted.
    MIN_RUN_CASES: usize = 6, "";
    /// Relative change of the noise of a channel below which its estimate has converged.
    CHANNEL_NOISE_TOLERANCE: f64 = 0.01, "";
    /// Maximum number of fits that estimate the noise of channels.
    CHANNEL_NOISE_MAX_FITS: usize = 5, "";

    // ## Outliers and noise of marks: tolerance/part_marks.rs, misplaced.rs, noise.rs, rigidity_screen.rs, tails.rs

    /// Residual from which a mark is examined as a possible outlier.
    SUSPECT_MARK_SIGMA: f64 = 6.0, "sigma";
    /// Residual from which a mark is an outlier if the other marks of its part agree.
    OUTLIER_MARK_SIGMA: f64 = 8.0, "sigma";
    /// Sum of squared residuals per degree of freedom, over the variance, below which the marks of a part agree.
    AGREEING_MARKS_CHI_SQUARE: f64 = 12.0, "";
    /// Minimum difference in the sum of squared residuals, over the variance, between the best and the second-best exclusion of a mark.
    /// Below it, the wrong mark is ambiguous.
    CLEAR_OUTLIER_CHI_SQUARE: f64 = 25.0, "";
    /// Minimum number of wrong readings of a mark that came loose.
    LOOSE_MARK_READINGS: usize = 3, "";
    /// Largest distance of single errors from their mean, relative to the mean, at which the readings of a mark count as consistently
    /// displaced.
    LOOSE_MARK_SPREAD: f64 = 0.5, "";
    /// Minimum model residual of a wrong mark, relative to the largest residual of its part in the case.
    WRONG_MARK_SHARE: f64 = 0.4, "";
    /// Residual of the other two of three marks, relative to the largest one, below which a single mark stands out.
    LONE_MARK_SHARE: f64 = 0.25, "";
    /// Number of cases in which a mark may always stand out and still be suspected.
    LONE_MARK_CASES: usize = 2, "";
    /// Reciprocal of the largest fraction of cases in which a suspected mark may stand out; if it does more often, the model is at fault.
    LONE_MARK_CASE_DIVISOR: usize = 10, "";
    /// Number of standard deviations of the log noise estimate beyond which the declared noise is rejected.
    NOISE_REJECTION_SD: f64 = 4.0, "sd";
    /// Additional tolerance of the log noise estimate where tails are heavy.
    HEAVY_TAILS_LN_ALLOWANCE: f64 = 0.3, "ln";
    /// Maximum number of screening passes over the marks.
    MARK_SCREENING_PASSES: usize = 4, "";
    /// Ratio of the standard deviation to the median absolute value of a Gaussian.
    SD_PER_MEDIAN_ABSOLUTE: f64 = 1.4826, "";
    /// Candidate degrees of freedom of Student's t. The Gaussian is the reference.
    STUDENT_T_DOF: [f64; 9] = [2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 30.0], "";
    /// Number of fixed-point iterations for the scale of Student's t.
    STUDENT_T_SCALE_ITERATIONS: usize = 40, "";

    // ## Variance components and whitening: tolerance/group.rs, maximise_evidence.rs, class.rs, columns.rs, free.rs, cross_products.rs,
    // point.rs, whitening.rs

    /// Number of prior standard deviations above the median, in the logarithm, beyond which a size is implausibly large.
    STRAINED_LN_SD: f64 = 2.5, "sd";
    /// Distance of the logarithm of a size from its upper bound at which the size is implausibly large.
    STRAINED_BOUND_LN: f64 = 0.01, "ln";
    /// Maximum number of evaluations in a maximisation of the evidence.
    EVIDENCE_MAX_EVALUATIONS: usize = 30, "";
    /// Predicted or achieved gain of a step below which the maximisation of the evidence ends.
    EVIDENCE_TOLERANCE_NATS: f64 = 0.02, "nats";
    /// Largest change of any log standard deviation in one step.
    EVIDENCE_MAX_LN_STEP: f64 = 1.5, "ln";
    /// Largest ratio of two variance coefficients that count as equal.
    EQUAL_VARIANCE_RATIO: f64 = 1.05, "";
    /// Fraction of its largest entry below which the entries of a column in a class count as zero. Rigid motion of a part leaves round-off in
    /// the rows that describe relative motion of its marks.
    ZERO_COLUMN_SHARE: f64 = 1e-12, "";
    /// Relative eigenvalue below which a direction of free motion of a part counts as round-off.
    FREE_DIRECTION_ROUND_OFF: f64 = 1e-9, "";
    /// Relative contribution to a variance, at the prior medians, below which a term counts as round-off.
    VARIANCE_TERM_ROUND_OFF: f64 = 1e-6, "";
    /// Relative eigenvalue below which a rotation of the marks of a part counts as zero.
    MARK_ROTATION_ROUND_OFF: f64 = 1e-6, "";
    /// Number of columns processed together, small enough for the processor's cache.
    COLUMN_BLOCK: usize = 64, "";
    /// Distance at design below which two markers share a hardpoint.
    SHARED_HARDPOINT_MM: f64 = 1e-3, "mm";

    // ## Slips in the deck or the files: slips/search.rs, thinned.rs, bench.rs, candidate.rs, unit_pairs.rs, apart.rs

    /// Minimum surplus of cases over the coefficients of a linear function of the loads.
    SLIP_MIN_SPARE_CASES: usize = 4, "";
    /// Number of cases sufficient to detect a slip: the ends and middles of the usual three loads.
    SLIP_MAX_CASES: usize = 12, "";
    /// Maximum number of trial steps in the fit of the unchanged study.
    SLIP_UNCHANGED_MAX_STEPS: usize = 40, "";
    /// Predicted decrease below which a fit of the search has converged.
    SLIP_DECREMENT_NATS: f64 = 1e-2, "nats";
    /// Maximum number of candidates in each round of fits.
    SLIP_ROUND_CANDIDATES: [usize; 3] = [usize::MAX, 12, 4], "";
    /// Maximum number of trial steps of a fit in each round.
    SLIP_ROUND_STEPS: [usize; 3] = [3, 4, 20], "";
    /// Effort limit of the search: number of equilibria solved after the fit of the study itself. Beyond it, no further candidate is fitted.
    SLIP_MAX_EQUILIBRIA: usize = 6_000, "";
    /// Minimum fraction of the residual squares that a factor near one must explain for a slip to be tried; used if the fit follows the
    /// readings.
    SLIP_MIN_GAIN: f64 = 0.1, "";
    /// Maximum number of bushing slips tried if the fit does not follow the readings, where the predicted gain is unreliable.
    SLIP_MAX_BUSHINGS: usize = 8, "";
    /// Rms of the residuals beyond tolerances, over their noise, below which they count as explained and no slip is searched.
    SLIP_EXPLAINED_RMS_SIGMA: f64 = 1.1, "sigma";
    /// Rms of the residuals beyond tolerances, over their noise, that an understated noise level still explains.
    SLIP_NOISE_RMS_SIGMA: f64 = 2.0, "sigma";
    /// Ratio of the corrected to the original rms below which a slip is certain; half of the squares remain. Effects that a model lacks are
    /// not affected by a unit factor and would remain in full.
    SLIP_CERTAIN_RATIO: f64 = 0.7, "";
    /// Ratio of the corrected to the original rms below which a slip is reported as possible.
    SLIP_POSSIBLE_RATIO: f64 = 0.9, "";
    /// Ratio to the lowest residual rms up to which other corrections count as equally good.
    SLIP_EQUAL_RATIO: f64 = 1.1, "";
    /// Residual rms below which a fit follows the readings, relative to the movement of the readings.
    SLIP_FOLLOWS_MOVEMENT: f64 = 0.05, "";
    /// Residual rms below which a fit follows the readings, relative to their noise.
    SLIP_FOLLOWS_RMS_SIGMA: f64 = 10.0, "sigma";
    /// Residual rms below which a corrected study fits, relative to the movement of the readings.
    SLIP_FITS_MOVEMENT: f64 = 0.25, "";
    /// Noise assigned to readings that are declared exact, in the unit of the reading.
    SLIP_MIN_SIGMA: f64 = 1e-12, "";
    /// Distance of a load's point from a coordinate plane below which the point is on neither side.
    LOAD_SIDE_MM: f64 = 20.0, "mm";
    /// Largest log-ratio of two unit factors that count as equal.
    EQUAL_UNIT_FACTOR_LN: f64 = 0.03, "ln";
    /// Largest distance between two markers, along the constrained directions, that assembly tolerances allow.
    ASSEMBLY_DISTANCE_MM: f64 = 2.0, "mm";
    /// Largest rotation between two markers, about the constrained directions, that assembly tolerances allow.
    ASSEMBLY_ANGLE_DEG: f64 = 2.0, "deg";
    /// Rotation between the markers of a bushing above which it is reported even without a known correction. Smaller rotations may be
    /// intended.
    REPORTED_BUSHING_ANGLE_DEG: f64 = 10.0, "deg";
}
