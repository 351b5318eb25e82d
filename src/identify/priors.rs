//! Priors of the variance components, which are the standard deviations ("sizes") of tolerances and noise. `admire explain priors` prints them.
//!
//! The prior of a size is a lognormal distribution, given by its median, the standard deviation of the logarithm, and bounds.

admire_study::constants! {
    // ## Tolerances of the axle

    /// Prior median of the standard deviation of each hardpoint coordinate of a production axle.
    pub HARDPOINT_MEDIAN_MM: f64 = 0.2, "mm";
    /// Prior median of the standard deviation of the offset between the two sides of a bushing or joint, per coordinate.
    OFFSET_MEDIAN_MM: f64 = 0.05, "mm";
    /// Ratio of the offset between the two sides of a bushing or joint to the hardpoint error, used where the study states the hardpoint error.
    OFFSET_PER_HARDPOINT: f64 = 0.25, "";
    /// Prior median of the standard deviation of the axis direction of a bushing or joint.
    AXIS_MEDIAN_DEG: f64 = 0.1, "deg";
    /// Prior median of the relative standard deviation of a spring force in the design position.
    PRELOAD_MEDIAN: f64 = 0.003, "";
    /// Upper bound of the relative standard deviation of a spring force in the design position.
    PRELOAD_MAX: f64 = 0.01, "";
    /// Prior median of the relative standard deviation of a spring rate.
    SPRING_RATE_MEDIAN: f64 = 0.015, "";
    /// Upper bound of the relative standard deviation of a spring rate.
    SPRING_RATE_MAX: f64 = 0.025, "";
    /// Prior median of the relative standard deviation of a bushing stiffness that is not identified.
    KNOWN_STIFFNESS_MEDIAN: f64 = 0.03, "";
    /// Upper bound of the relative standard deviation of a bushing stiffness that is not identified.
    KNOWN_STIFFNESS_MAX: f64 = 0.1, "";

    // ## Loads of the rig

    /// Prior median of the standard deviation of each coordinate of a point at which a load acts.
    LOAD_POINT_MEDIAN_MM: f64 = 0.5, "mm";
    /// Prior median of the relative standard deviation of the gain of a load.
    LOAD_GAIN_MEDIAN: f64 = 0.003, "";
    /// Upper bound of the relative standard deviation of the gain of a load.
    LOAD_GAIN_MAX: f64 = 0.01, "";
    /// Prior median of the standard deviation of a load in a single case, relative to the largest value of the load over all cases.
    LOAD_REPEATABILITY_MEDIAN: f64 = 0.001, "";
    /// Upper bound of the standard deviation of a load in a single case, relative to the largest value of the load over all cases.
    LOAD_REPEATABILITY_MAX: f64 = 0.01, "";
    /// Ratio of two prior medians: the error of a load in a case where it is zero, over its error in a case where it acts.
    IDLE_LOAD_RATIO: f64 = 0.3, "";
    /// Prior median of the crosstalk (standard deviation): the fraction of a load that also acts along another load.
    LOAD_DIRECTION_MEDIAN: f64 = 0.001, "";
    /// Prior median of the standard deviation of the displacement of the axle's mount on the rig at the largest value of a load.
    MOUNT_YIELD_MEDIAN_MM: f64 = 0.02, "mm";

    // ## Marks and the measuring frame

    /// Prior median of the standard deviation of a mark coordinate on its part, where the study does not state it.
    MARK_MEDIAN_MM: f64 = 0.01, "mm";
    /// Prior median of the misalignment (standard deviation) of a measuring frame that was aligned with the axle.
    ALIGNMENT_MEDIAN_MM: f64 = 0.05, "mm";
    /// Upper bound of the misalignment (standard deviation) of a measuring frame that clearly differs from the deck's frame.
    ALIGNMENT_MAX_MM: f64 = 20.0, "mm";
    /// Prior median of the standard deviation of the measuring frame's translation in a case.
    FRAME_SHIFT_MEDIAN_MM: f64 = 0.005, "mm";
    /// Upper bound of the standard deviation of the measuring frame's translation in a case.
    FRAME_SHIFT_MAX_MM: f64 = 0.2, "mm";
    /// Negligible size of the measuring frame's translation, used if the study states only the frame's rotation.
    FRAME_SHIFT_NEGLIGIBLE_MM: f64 = 1e-6, "mm";
    /// Prior median of the standard deviation of the measuring frame's rotation in a case.
    FRAME_TURN_MEDIAN_RAD: f64 = 1e-5, "rad";
    /// Upper bound of the standard deviation of the measuring frame's rotation in a case.
    FRAME_TURN_MAX_RAD: f64 = 5e-4, "rad";
    /// Negligible size of the measuring frame's rotation, used if the study states only the frame's translation.
    FRAME_TURN_NEGLIGIBLE_RAD: f64 = 1e-9, "rad";
    /// Prior median of the pose noise: standard deviation of a common translation of all marks of a part in a case.
    POSE_SHIFT_MEDIAN_MM: f64 = 0.003, "mm";
    /// Prior median of the pose noise: standard deviation of a common rotation of all marks of a part in a case.
    POSE_TURN_MEDIAN_RAD: f64 = 3e-5, "rad";
    /// Lever arm by which a pose noise stated as a translation is divided to obtain its rotation.
    POSE_ARM_MM: f64 = 100.0, "mm";

    // ## Widths of these priors

    /// Width of the prior of a size that the study states: standard deviation of its logarithm.
    STATED_LN_SD: f64 = 0.25, "ln";
    /// Width of the prior of a size that is similar for most axles and rigs (gain, preload, spring rate, stiffness): standard deviation of its
    /// logarithm.
    NARROW_LN_SD: f64 = 0.5, "ln";
    /// Width of the prior of most other sizes: standard deviation of their logarithm.
    USUAL_LN_SD: f64 = 0.7, "ln";
    /// Width of the prior of a size that varies widely between rigs: standard deviation of its logarithm.
    WIDE_LN_SD: f64 = 1.0, "ln";
    /// Width of the prior of the pose noise of a part: standard deviation of its logarithm.
    POSE_LN_SD: f64 = 1.5, "ln";
    /// Width of the prior of the factor on a noise level that the study declares: standard deviation of its logarithm.
    DECLARED_NOISE_LN_SD: f64 = 0.5, "ln";
    /// Width of the prior of the factor on a guessed noise level: standard deviation of its logarithm.
    GUESSED_NOISE_LN_SD: f64 = 3.0, "ln";
    /// Distance of the lower bound of a size below its median, in standard deviations of the logarithm.
    LOWER_BOUND_LN_SD: f64 = 4.0, "sd";
    /// Distance of the upper bound of a size above its median, in standard deviations of the logarithm.
    UPPER_BOUND_LN_SD: f64 = 2.5, "sd";
}
