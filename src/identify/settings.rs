//! Settings of the identification: significance levels, limits, convergence tolerances and numerical guards. `admire explain priors` prints
//! them.

admire_study::constants! {
    // ## Statistics, also used by the diagnosis and the report

    /// 97.5 percent quantile of the standard normal distribution: half width of a two-sided 95 percent interval in standard deviations.
    pub NORMAL_QUANTILE_975: f64 = 1.959_963_984_540_054, "sd";
    /// Significance level of the chi-square test and of the lack-of-fit tests: probability of rejecting a correct model.
    pub LACK_OF_FIT_LEVEL: f64 = 1e-3, "";
    /// Standard deviation of ln K above which an identified parameter K counts as unidentifiable. For a change, it is the posterior
    /// standard deviation in units of the prior standard deviation.
    pub UNIDENTIFIABLE_LN_SD: f64 = 0.5, "ln";
    /// Standard deviation of ln K of an identified parameter K above which a profile-likelihood interval replaces the normal interval. For
    /// a change, it is the posterior standard deviation in units of the prior standard deviation.
    pub POOR_NORMAL_LN_SD: f64 = 0.3, "ln";
    /// Residual above which Huber's loss lowers the weight of a reading. This value gives 95 percent efficiency under Gaussian noise.
    pub HUBER_THRESHOLD_SIGMA: f64 = 1.345, "sigma";
    /// Variance that a fit leaves in a contrast (a linear combination of readings), relative to its noise, below which the fit has absorbed the
    /// contrast.
    pub ABSORBED_VARIANCE_SHARE: f64 = 0.01, "";
    /// Magnitude of a component below which a parameter is left out when a poorly determined direction (a unit vector) is listed.
    pub NAMED_COMPONENT: f64 = 0.15, "";
    /// Gain in log-likelihood of the Student t over the Gaussian distribution above which the noise counts as heavy-tailed. About 1 in 400
    /// studies with Gaussian noise exceeds this gain.
    pub HEAVY_TAILS_NATS: f64 = 4.0, "nats";
    /// Gain in log-likelihood of the Student t over the Gaussian distribution above which the noise may be heavy-tailed. About 1 in 13 studies
    /// with Gaussian noise exceeds this gain.
    pub POSSIBLE_HEAVY_TAILS_NATS: f64 = 1.0, "nats";

    // ## Unknowns: mirror.rs

    /// Distance between a hardpoint and the mirror image of another hardpoint, below which the two hardpoints form a left-right pair.
    MIRRORED_POINT_MM: f64 = 0.1, "mm";

    // ## Gauss-Newton fit: global/gauss_newton.rs, global/fit.rs

    /// Predicted decrease of the objective by the next step below which a fit has converged. Such a step would move no unknown by more than
    /// about a hundredth of its standard deviation.
    CONVERGED_DECREMENT_NATS: f64 = 1e-4, "nats";
    /// Step size below which a fit has converged: the largest change of any unknown in units of its scale. Convergence is nearly quadratic, so
    /// a further step would gain nothing.
    CONVERGED_STEP: f64 = 1e-6, "";
    /// Maximum number of trial steps of a fit, including rejected steps.
    MAX_TRIAL_STEPS: usize = 100, "";
    /// Maximum size of the trust region, in natural units of the unknowns. The natural unit of a stiffness is a change by a factor of e.
    MAX_TRUST_REGION: f64 = 1.5, "";
    /// Size of the trust region, in natural units of the unknowns, below which round-off hides any decrease of the objective.
    MIN_TRUST_REGION: f64 = 1e-9, "";
    /// Factor by which the trust region is multiplied after rejected steps.
    TRUST_REGION_SHRINKAGE: f64 = 0.3, "";
    /// Maximum number of further steps after a step that increases the objective. If none of them reaches an objective below the best one
    /// so far, all are rejected.
    MAX_STEPS_AFTER_UPHILL: usize = 3, "";
    /// Predicted decrease below which a step counts as late, that is, close to the minimum. The objective is half a chi-square, so all unknowns
    /// together then move by at most two standard deviations.
    LATE_STEP_NATS: f64 = 2.0, "nats";
    /// Predicted fraction of the objective that must remain after a step for the step to count as late. If the residuals nearly vanish, their
    /// curvature has no effect and needs no correction.
    LATE_STEP_REMAINDER: f64 = 0.9, "";
    /// Maximum number of times that a rejected late step is repeated with the updated curvature before the trust region is reduced.
    MAX_LATE_RETRIES: usize = 6, "";
    /// Ratio of observed to predicted curvature along a step below which the secant correction of the Hessian is halved.
    CURVATURE_RATIO_LOW: f64 = 0.7, "";
    /// Ratio of observed to predicted curvature along a step above which the secant correction of the Hessian is increased.
    CURVATURE_RATIO_HIGH: f64 = 1.1, "";
    /// Rms of the whitened residuals above which a fit counts as far from its solution, so the homotopy is tried.
    FAR_FIT_RMS_SIGMA: f64 = 3.0, "sigma";
    /// Maximum number of stages of the homotopy: a sequence of fits with inflated noise that approaches a distant solution.
    HOMOTOPY_MAX_STAGES: usize = 12, "";
    /// Maximum number of trial steps in one stage of the homotopy.
    HOMOTOPY_MAX_STEPS: usize = 8, "";
    /// Ratio of the rms residuals of successive stages above which the homotopy ends, because it makes no more progress.
    HOMOTOPY_STALL_RATIO: f64 = 0.8, "";
    /// Predicted decrease of the objective by the next step below which a stage of the homotopy has converged.
    HOMOTOPY_DECREMENT_NATS: f64 = 0.1, "nats";
    /// Step size below which a stage of the homotopy has converged: the largest change of any unknown in units of its scale.
    HOMOTOPY_STEP: f64 = 1e-2, "";
    /// Probability that Gaussian noise alone produces at least one reading of a study that is taken for an outlier.
    OUTLIER_FALSE_ALARM: f64 = 1e-3, "";
    /// Distance from a stated bound at which an identified parameter counts as being at the bound. It is a fraction of the distance between
    /// the bounds, or of one unit of the coordinate if that is smaller.
    AT_BOUND_SHARE: f64 = 1e-6, "";
    /// Relative difference up to which an unknown and an error of the axle change the deck in the same direction. It allows for round-off
    /// in the axes of markers.
    SAME_CHANGE_ROUND_OFF: f64 = 1e-9, "";
    /// Smallest standard deviation for which a point of a SPLINE gets a separate unknown, as a fraction of the stated standard deviation.
    /// It is the part that the smooth change at the other points leaves open. No reading resolves a thousandth.
    SMALLEST_SMOOTH_SHARE: f64 = 1e-3, "";
    /// Distance of ln K from its prior mean at which an identified parameter K counts as being at a bound.
    BOUND_LN_DISTANCE: f64 = 14.0, "ln";
    /// Difference between the direct solution and the fit above which a remark is made, in standard deviations of the direct solution.
    CONTRADICTION_SD: f64 = 6.0, "sd";

    // ## Derivatives and predictions: global/differences.rs, channel.rs, native.rs, unknown.rs, observation.rs, marginal.rs

    /// Central-difference step for whole sweeps, in units of an unknown; for ln K this is a relative change of 0.001. With this step,
    /// truncation error and the rounding of a results file to ten digits are about equally large.
    DIFFERENCE_STEP: f64 = 1e-3, "";
    /// Central-difference step, in units of an unknown, for the direct effect of an unknown on a channel with all parts fixed.
    CHANNEL_DIFFERENCE_STEP: f64 = 1e-5, "";
    /// Change of an unknown above which an equilibrium is solved from the previous solution instead of an extrapolation.
    MAX_EXTRAPOLATED_STEP: f64 = 0.5, "";
    /// Lower limit of the load share of a spring: the fraction of a force along the spring that the spring itself carries. Smaller values are
    /// round-off.
    MIN_LOAD_SHARE: f64 = 1e-4, "";
    /// Noise assigned to mark coordinates that are declared free of noise, relative to the largest coordinate.
    MIN_RELATIVE_MARK_SIGMA: f64 = 1e-12, "";
    /// Prior standard deviation that is used for an unknown without a prior, in the unit of the unknown.
    FLAT_PRIOR_SD: f64 = 1e6, "";

    // ## Free (zero-stiffness) motions of a model: global/free.rs, native.rs, observation.rs

    /// Change of a reading by a free motion of one radian or one model length, in units of its noise, below which the reading counts as
    /// unaffected.
    FREE_UNAFFECTED_SIGMA: f64 = 1e-3, "sigma";
    /// Residual above which a reading is downweighted when a part is placed along its free motions, as a multiple of the median residual in the
    /// case.
    FREE_OUTLIER_RATIO: f64 = 3.0, "";
    /// Maximum number of reweighting passes when a part is placed along its free motions.
    FREE_MAX_PASSES: usize = 4, "";
    /// Eigenvalue below which a combination of free motions counts as round-off, relative to the largest eigenvalue.
    FREE_ROUND_OFF: f64 = 1e-12, "";
    /// Step along a free motion, in radians or model lengths, below which the placement of a part has converged.
    FREE_PLACED_STEP: f64 = 1e-4, "";
    /// Maximum length of one step along a free motion, in radians or model lengths.
    FREE_MAX_STEP: f64 = 0.5, "";
    /// Maximum number of steps for the placement of a part along its free motions.
    FREE_MAX_STEPS: usize = 20, "";

    // ## Profile-likelihood intervals: global/profile.rs, global/confidence.rs

    /// Rise of the objective at the ends of a 95 percent profile-likelihood interval: half the 95 percent quantile of chi-square with one
    /// degree of freedom.
    HALF_CHI_SQUARE_95: f64 = 1.920_729, "nats";
    /// Distance of an interval end from the estimate above which this side of the profile-likelihood interval counts as unbounded.
    PROFILE_MAX_LN_DISTANCE: f64 = 7.0, "ln";
    /// Maximum displacement of the other unknowns along the path of a profile, in natural units.
    PROFILE_MAX_OTHER_STEP: f64 = 3.0, "";
    /// Maximum difference between the rise at a profile point and 1.92 at which the interval end is interpolated. The square root of the rise
    /// is interpolated linearly.
    PROFILE_INTERPOLATION_NATS: f64 = 0.4, "nats";
    /// Maximum number of profile points computed for one side of an interval.
    PROFILE_MAX_POINTS: usize = 10, "";
    /// Maximum number of model evaluations at a profile point before a fit with derivatives replaces them.
    PROFILE_MAX_EVALUATIONS: usize = 6, "";
    /// Number of model evaluations at a profile point above which the quadratic approximation counts as poor. There may then be several local
    /// minima.
    PROFILE_FEW_EVALUATIONS: usize = 2, "";
    /// Predicted decrease of the objective by a further constrained step below which a profile point is accepted.
    PROFILE_DECREMENT_NATS: f64 = 0.05, "nats";
    /// Step size below which a fit with derivatives at a profile point has converged: the largest change of any unknown in units of its scale.
    PROFILE_STEP: f64 = 1e-4, "";
    /// Maximum number of trial steps of a fit with derivatives at a profile point.
    PROFILE_MAX_TRIAL_STEPS: usize = 25, "";
    /// Central-difference step for the derivative of an unknown with respect to its step coordinate.
    PROFILE_DIFFERENCE_STEP: f64 = 1e-6, "";

    // ## Direct solution: direct/mod.rs, bounded.rs

    /// Noise assigned to marks that are declared exact, in the length unit of the deck. Without it, their weights would be infinite.
    DIRECT_MIN_MARK_SIGMA: f64 = 1e-6, "length";
    /// Maximum change of ln K of a parameter K in one round of the direct solution.
    DIRECT_MAX_LN_STEP: f64 = 1.5, "ln";
    /// Maximum distance of ln K of a parameter K from its starting value in the direct solution.
    DIRECT_MAX_LN_DISTANCE: f64 = 9.0, "ln";
    /// Number of times that the poses are moved onto the equilibrium equations for one set of parameter values.
    DIRECT_POSE_CORRECTIONS: usize = 3, "";
    /// Initial Levenberg-Marquardt damping of the normal equations, relative to their diagonal.
    DIRECT_DAMPING: f64 = 1e-3, "";
    /// Factor by which the damping is multiplied after a rejected step.
    DIRECT_DAMPING_INCREASE: f64 = 8.0, "";
    /// Divisor by which the damping is reduced after an accepted step.
    DIRECT_DAMPING_DECREASE: f64 = 5.0, "";
    /// Damping above which the direct solution ends, because no step reduces the misfit.
    DIRECT_MAX_DAMPING: f64 = 1e6, "";
    /// Absolute part of the step in ln K below which the direct solution has converged.
    DIRECT_LN_TOLERANCE: f64 = 1e-7, "ln";
    /// Relative part of the step in ln K below which the direct solution has converged, in standard deviations of ln K.
    DIRECT_SD_TOLERANCE: f64 = 0.05, "sd";
    /// Number of rounds with the poses as measured, before the poses are corrected; one entry per attempt. With few rounds, poorly determined
    /// stiffnesses do not collapse. With many rounds, well-determined stiffnesses come close to the solution.
    DIRECT_MEASURED_POSE_ROUNDS: [usize; 2] = [2, 12], "";
    /// P-value of the chi-square misfit above which an attempt of the direct solution is accepted.
    DIRECT_ACCEPTED_P_VALUE: f64 = 1e-3, "";
    /// Maximum number of block exchanges of active bounds in a bounded least-squares problem.
    MAX_BLOCK_EXCHANGES: usize = 12, "";
    /// Maximum number of rounds of the active-set method for a bounded least-squares problem.
    MAX_ACTIVE_SET_ROUNDS: usize = 400, "";

    // ## Tests of a fit and noise of channels: lack_of_fit.rs, noise.rs

    /// Minimum number of marks of a part in a case with which its pose error can be separated from the noise of the marks.
    MIN_POSE_MARKS: usize = 3, "";
    /// Minimum number of degrees of freedom in the scatter of the marks for a test of pose errors against this scatter.
    MIN_SCATTER_DOF: f64 = 12.0, "";
    /// Minimum number of cases for the runs test of the signs of a series of residuals.
    MIN_RUN_CASES: usize = 6, "";
    /// Relative change of the estimated noise of a channel between fits below which the estimate has converged.
    CHANNEL_NOISE_TOLERANCE: f64 = 0.01, "";
    /// Maximum number of fits made to estimate the noise of the channels.
    CHANNEL_NOISE_MAX_FITS: usize = 5, "";

    // ## Outliers and noise of marks: tolerance/part_marks.rs, misplaced.rs, noise.rs, rigidity_screen.rs, tails.rs

    /// Residual at and above which a mark is examined as a possible outlier.
    SUSPECT_MARK_SIGMA: f64 = 6.0, "sigma";
    /// Residual above which a mark is an outlier, provided that the other marks of its part agree with each other.
    OUTLIER_MARK_SIGMA: f64 = 8.0, "sigma";
    /// Chi-square per degree of freedom of the rigid-body fit below which the marks of a part agree with each other.
    AGREEING_MARKS_CHI_SQUARE: f64 = 12.0, "";
    /// Minimum difference in chi-square between leaving out the best and the second-best candidate for a wrong mark. If the difference is
    /// smaller, either mark may be the wrong one.
    CLEAR_OUTLIER_CHI_SQUARE: f64 = 25.0, "";
    /// Minimum number of wrong readings from which a mark is taken to be displaced or loose.
    LOOSE_MARK_READINGS: usize = 3, "";
    /// Maximum deviation of the errors of a mark from their mean, relative to the mean, for the mark to count as consistently displaced.
    LOOSE_MARK_SPREAD: f64 = 0.5, "";
    /// Minimum residual of a wrong mark against the model, relative to the largest residual of its part in the case.
    WRONG_MARK_SHARE: f64 = 0.4, "";
    /// Ratio of the second-largest to the largest residual below which a single one of three marks stands out.
    LONE_MARK_SHARE: f64 = 0.25, "";
    /// Number of cases up to which a mark that stands out is always suspected to be wrong.
    LONE_MARK_CASES: usize = 2, "";
    /// Reciprocal of the largest fraction of cases in which a mark that stands out is suspected to be wrong. A mark that stands out in more
    /// cases points to an error of the model.
    LONE_MARK_CASE_DIVISOR: usize = 10, "";
    /// Difference between the logarithms of declared and estimated noise above which the declared noise is rejected, in standard deviations of
    /// the estimate.
    NOISE_REJECTION_SD: f64 = 4.0, "sd";
    /// Allowance added to the limit at which the declared noise is rejected, if the noise may be heavy-tailed; on the logarithmic scale.
    HEAVY_TAILS_LN_ALLOWANCE: f64 = 0.3, "ln";
    /// Maximum number of passes of the screen for outliers among the marks.
    MARK_SCREENING_PASSES: usize = 4, "";
    /// Ratio of the standard deviation of a Gaussian variable to the median of its absolute value.
    SD_PER_MEDIAN_ABSOLUTE: f64 = 1.4826, "";
    /// Candidate degrees of freedom of the Student t distribution that is fitted to residuals and compared with a Gaussian.
    STUDENT_T_DOF: [f64; 9] = [2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 30.0], "";
    /// Number of fixed-point iterations for the scale of the Student t distribution.
    STUDENT_T_SCALE_ITERATIONS: usize = 40, "";

    // ## Variance components and whitening: tolerance/group.rs, maximise_evidence.rs, class.rs, columns.rs, free.rs, cross_products.rs,
    // point.rs, whitening.rs

    /// Distance of the logarithm of a size above its prior median beyond which the size is implausibly large, in prior standard deviations.
    STRAINED_LN_SD: f64 = 2.5, "sd";
    /// Distance of the logarithm of a size below its upper bound within which the size counts as being at the bound, hence implausibly large.
    STRAINED_BOUND_LN: f64 = 0.01, "ln";
    /// Maximum number of evaluations of the evidence in one maximisation.
    EVIDENCE_MAX_EVALUATIONS: usize = 30, "";
    /// Predicted or achieved gain in log evidence of a step below which the maximisation of the evidence ends.
    EVIDENCE_TOLERANCE_NATS: f64 = 0.02, "nats";
    /// Maximum change of any log standard deviation in one step of the maximisation of the evidence.
    EVIDENCE_MAX_LN_STEP: f64 = 1.5, "ln";
    /// Ratio up to which two variance coefficients count as equal, so that their rows belong to the same variance class (rows of equal
    /// variance).
    EQUAL_VARIANCE_RATIO: f64 = 1.05, "";
    /// Fraction of the largest entry of a column below which the entries of the column in a variance class count as zero. Rigid motion of a
    /// part leaves round-off in the rows that describe relative motion of its marks.
    ZERO_COLUMN_SHARE: f64 = 1e-12, "";
    /// Eigenvalue below which a direction of free motion counts as round-off, relative to the largest eigenvalue.
    FREE_DIRECTION_ROUND_OFF: f64 = 1e-9, "";
    /// Relative contribution of a variance component to the variance of a row, at the prior medians, below which the component is dropped as
    /// round-off.
    VARIANCE_TERM_ROUND_OFF: f64 = 1e-6, "";
    /// Eigenvalue below which the effect of a rotation on the marks of a part counts as zero, relative to the largest eigenvalue.
    MARK_ROTATION_ROUND_OFF: f64 = 1e-6, "";
    /// Number of matrix columns that are processed together, small enough for the processor's cache.
    COLUMN_BLOCK: usize = 64, "";
    /// Distance in the design position below which two markers belong to the same hardpoint.
    SHARED_HARDPOINT_MM: f64 = 1e-3, "mm";

    // ## Slips in the deck or the files: slips/search.rs, thinned.rs, bench.rs, candidate.rs, unit_pairs.rs, apart.rs

    /// Minimum number of load cases beyond the number of coefficients of a linear function of the loads. With fewer cases, there is no
    /// search for slips.
    SLIP_MIN_SPARE_CASES: usize = 4, "";
    /// Maximum number of load cases used in the search for a slip: enough for the ends and middles of the usual three loads.
    SLIP_MAX_CASES: usize = 12, "";
    /// Maximum number of trial steps in the fit of the unchanged study.
    SLIP_UNCHANGED_MAX_STEPS: usize = 40, "";
    /// Predicted decrease of the objective by the next step below which a fit in the search for a slip has converged.
    SLIP_DECREMENT_NATS: f64 = 1e-2, "nats";
    /// Maximum number of candidate slips in each round of fits.
    SLIP_ROUND_CANDIDATES: [usize; 3] = [usize::MAX, 12, 4], "";
    /// Maximum number of trial steps of the fit of a candidate slip, in each round of fits.
    SLIP_ROUND_STEPS: [usize; 3] = [3, 4, 20], "";
    /// Maximum number of equilibria solved in the search for a slip, after the fit of the study itself. When it is exceeded, no further
    /// candidate is fitted.
    SLIP_MAX_EQUILIBRIA: usize = 6_000, "";
    /// Minimum fraction of the squared residuals that a factor near one must explain for a candidate slip to be tried. Used only if the fit of
    /// the unchanged study follows the readings.
    SLIP_MIN_GAIN: f64 = 0.1, "";
    /// Maximum number of bushing slips tried if the fit of the unchanged study does not follow the readings. The predicted gains are then
    /// unreliable.
    SLIP_MAX_BUSHINGS: usize = 8, "";
    /// Rms of the residuals that tolerances cannot absorb, in units of their noise, below which the readings count as explained and no slip is
    /// searched for.
    SLIP_EXPLAINED_RMS_SIGMA: f64 = 1.1, "sigma";
    /// Rms of the residuals that tolerances cannot absorb, in units of their noise, up to which an understated noise level may be the
    /// explanation.
    SLIP_NOISE_RMS_SIGMA: f64 = 2.0, "sigma";
    /// Ratio of the residual rms after and before a correction below which a slip is certain. At this ratio, half of the squared residuals
    /// remain. The residuals of effects that the model lacks would remain in full, because no unit factor explains them.
    SLIP_CERTAIN_RATIO: f64 = 0.7, "";
    /// Ratio of the residual rms after and before a correction below which a slip is reported as possible.
    SLIP_POSSIBLE_RATIO: f64 = 0.9, "";
    /// Ratio of the residual rms of a correction to the lowest rms of all corrections, up to which the correction counts as equally good.
    SLIP_EQUAL_RATIO: f64 = 1.1, "";
    /// Residual rms below which a fit follows the readings, relative to the rms variation of the readings over the cases.
    SLIP_FOLLOWS_MOVEMENT: f64 = 0.05, "";
    /// Residual rms below which a fit follows the readings, in units of their noise.
    SLIP_FOLLOWS_RMS_SIGMA: f64 = 10.0, "sigma";
    /// Residual rms below which a corrected study fits the readings, relative to the rms variation of the readings over the cases.
    SLIP_FITS_MOVEMENT: f64 = 0.25, "";
    /// Noise assigned to exact readings in the search for a slip, in the unit of the reading.
    SLIP_MIN_SIGMA: f64 = 1e-12, "";
    /// Distance from a coordinate plane below which the point of a load counts as lying on neither side of the plane.
    LOAD_SIDE_MM: f64 = 20.0, "mm";
    /// Log-ratio up to which two unit factors count as equal.
    EQUAL_UNIT_FACTOR_LN: f64 = 0.03, "ln";
    /// Largest distance between the markers of a joint or bushing, along its constrained directions, that assembly tolerances explain.
    ASSEMBLY_DISTANCE_MM: f64 = 2.0, "mm";
    /// Largest rotation between the markers of a bushing, about its constrained directions, that assembly tolerances explain.
    ASSEMBLY_ANGLE_DEG: f64 = 2.0, "deg";
    /// Rotation between the markers of a bushing above which the rotation is reported even without a known correction. Smaller rotations may be
    /// intended.
    REPORTED_BUSHING_ANGLE_DEG: f64 = 10.0, "deg";
}
