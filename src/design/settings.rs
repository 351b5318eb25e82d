//! Settings of the design of measurements: effort limits, assumed noise and levels. `admire explain priors` prints them.

admire_study::constants! {
    // ## Candidates: candidate.rs

    /// Load deviation of candidates beyond the range applied, as a factor on the largest load deviation in the study.
    BEYOND_RANGE_FACTOR: f64 = 1.25, "";
    /// Maximum number of load cases considered as candidates.
    MAX_LOAD_CASES: usize = 160, "";
    /// Maximum number of cases considered for repetition.
    MAX_REPEATED_CASES: usize = 24, "";
    /// Maximum number of mark positions considered on one part.
    MAX_MARK_POSITIONS: usize = 6, "";
    /// Maximum number of elements considered for a load cell.
    MAX_LOAD_CELLS: usize = 24, "";
    /// Standard deviation assumed for a wheel angle that the study does not measure.
    ASSUMED_WHEEL_ANGLE_DEG: f64 = 0.01, "deg";
    /// Standard deviation per coordinate that is assumed for the position of the wheel centre, if the study does not measure it.
    ASSUMED_WHEEL_POSITION_MM: f64 = 0.05, "mm";
    /// Standard deviation per coordinate that is assumed for mark readings, if the study has no marks.
    ASSUMED_MARK_MM: f64 = 0.05, "mm";
    /// Standard deviation of a load cell reading, as a fraction of the largest force that the cell measures.
    LOAD_CELL_NOISE: f64 = 0.005, "of full scale";

    /// Excess over the range of deflections of the study, as a fraction, up to which a load case counts as within it.
    RANGE_TOLERANCE: f64 = 0.01, "";
    /// Lower limit of the deflection range of the study, in standard deviations of the noise of a mark. Smaller ranges are replaced by this
    /// limit.
    LEAST_RANGE_SIGMAS: f64 = 10.0, "sigma";

    // ## Criteria: plan.rs, rivals.rs, next_measurement.rs

    /// Number of worst-determined combinations of unknowns that the plan considers.
    WORST_COMBINATIONS: usize = 3, "";
    /// Maximum number of cases in which the plan predicts the position and the angles of the wheel.
    MAX_WHEEL_CASES: usize = 40, "";
    /// Minimum probability of a rival model. The probability is conditional on either the rival or the leading model being true.
    RIVAL_MIN_PROBABILITY: f64 = 0.01, "";
    /// Chi-square above which a load case is reported to distinguish two explanations.
    SEPARATION_CHI_SQUARE: f64 = 6.0, "";
    /// Maximum number of instruments that are named if no load distinguishes two explanations.
    MAX_SEPARATORS: usize = 3, "";
}
