//! Priors of the variance components: standard deviations ("sizes") of tolerances and noise. `admire explain priors` prints them.
//!
//! The prior of a size is lognormal, with a median, a standard deviation of the logarithm, and bounds.

admire_study::constants! {
    // ## Tolerances of the axle

    /// Median position error of the hardpoints of a production axle.
    pub HARDPOINT_MEDIAN_MM: f64 = 0.2, "mm";
    /// Median relative displacement of the two sides of bushings and joints.
    OFFSET_MEDIAN_MM: f64 = 0.05, "mm";
    /// Median relative displacement of the two sides of bushings and joints, relative to a position error of the hardpoints that the study
    /// states.
    OFFSET_PER_HARDPOINT: f64 = 0.25, "";
    /// Median direction error of the axes of bushings and joints.
    AXIS_MEDIAN_DEG: f64 = 0.1, "deg";
    /// Median relative error of a spring force at design.
    PRELOAD_MEDIAN: f64 = 0.003, "";
    /// Upper bound of the relative error of a spring force at design.
    PRELOAD_MAX: f64 = 0.01, "";
    /// Median relative error of a spring rate.
    SPRING_RATE_MEDIAN: f64 = 0.015, "";
    /// Upper bound of the relative error of a spring rate.
    SPRING_RATE_MAX: f64 = 0.025, "";
    /// Median relative error of a bushing stiffness that is not identified.
    KNOWN_STIFFNESS_MEDIAN: f64 = 0.03, "";
    /// Upper bound of the relative error of a bushing stiffness that is not identified.
    KNOWN_STIFFNESS_MAX: f64 = 0.1, "";

    // ## Loads of the rig

    /// Median position error of the points at which the loads act.
    LOAD_POINT_MEDIAN_MM: f64 = 0.5, "mm";
    /// Median relative gain error of a load.
    LOAD_GAIN_MEDIAN: f64 = 0.003, "";
    /// Upper bound of the relative gain error of a load.
    LOAD_GAIN_MAX: f64 = 0.01, "";
    /// Median error of a load in a single case, relative to the largest value of the load.
    LOAD_REPEATABILITY_MEDIAN: f64 = 0.001, "";
    /// Upper bound of the error of a load in a single case, relative to the largest value of the load.
    LOAD_REPEATABILITY_MAX: f64 = 0.01, "";
    /// Median error of a load that is zero in a case, relative to the median error of a load that acts.
    IDLE_LOAD_RATIO: f64 = 0.3, "";
    /// Median fraction of one load that acts along another.
    LOAD_DIRECTION_MEDIAN: f64 = 0.001, "";
    /// Median displacement of an axle's mount at the largest value of a load.
    MOUNT_YIELD_MEDIAN_MM: f64 = 0.02, "mm";

    // ## Marks and the measuring frame

    /// Median position error of a mark on its part, where the study states no noise of such positions.
    MARK_MEDIAN_MM: f64 = 0.01, "mm";
    /// Median misalignment of a measuring frame that was aligned with the axle.
    ALIGNMENT_MEDIAN_MM: f64 = 0.05, "mm";
    /// Upper bound of the misalignment of a measuring frame that differs from the deck's frame.
    ALIGNMENT_MAX_MM: f64 = 20.0, "mm";
    /// Median translation of the measuring frame in a case.
    FRAME_SHIFT_MEDIAN_MM: f64 = 0.005, "mm";
    /// Upper bound of the translation of the measuring frame in a case.
    FRAME_SHIFT_MAX_MM: f64 = 0.2, "mm";
    /// Median translation of the measuring frame in a case where the study states only a rotation.
    FRAME_SHIFT_NEGLIGIBLE_MM: f64 = 1e-6, "mm";
    /// Median rotation of the measuring frame in a case.
    FRAME_TURN_MEDIAN_RAD: f64 = 1e-5, "rad";
    /// Upper bound of the rotation of the measuring frame in a case.
    FRAME_TURN_MAX_RAD: f64 = 5e-4, "rad";
    /// Median rotation of the measuring frame in a case where the study states only a translation.
    FRAME_TURN_NEGLIGIBLE_RAD: f64 = 1e-9, "rad";
    /// Median rigid translation of all marks of a part in a case.
    POSE_SHIFT_MEDIAN_MM: f64 = 0.003, "mm";
    /// Median rigid rotation of all marks of a part in a case.
    POSE_TURN_MEDIAN_RAD: f64 = 3e-5, "rad";
    /// Lever arm that converts a pose noise stated as a translation to a rotation.
    POSE_ARM_MM: f64 = 100.0, "mm";

    // ## Widths of these priors

    /// Standard deviation of the logarithm of a size that the study states.
    STATED_LN_SD: f64 = 0.25, "ln";
    /// Standard deviation of the logarithm of a size that is similar in most axles and rigs: gains, preloads, spring rates, stiffnesses.
    NARROW_LN_SD: f64 = 0.5, "ln";
    /// Standard deviation of the logarithm of most sizes.
    USUAL_LN_SD: f64 = 0.7, "ln";
    /// Standard deviation of the logarithm of a size that varies widely between rigs.
    WIDE_LN_SD: f64 = 1.0, "ln";
    /// Standard deviation of the logarithm of the pose noise of a part.
    POSE_LN_SD: f64 = 1.5, "ln";
    /// Standard deviation of the logarithm of a factor on a declared noise.
    DECLARED_NOISE_LN_SD: f64 = 0.5, "ln";
    /// Standard deviation of the logarithm of a factor on a guessed noise.
    GUESSED_NOISE_LN_SD: f64 = 3.0, "ln";
    /// Number of standard deviations of the logarithm between the median of a size and its lower bound.
    LOWER_BOUND_LN_SD: f64 = 4.0, "sd";
    /// Number of standard deviations of the logarithm between the median of a size and its upper bound.
    UPPER_BOUND_LN_SD: f64 = 2.5, "sd";
}
