//! Settings of the design of measurements: effort limits, assumed noise and levels. `admire explain priors` prints them.

admire_study::constants! {
    // ## Candidates: candidate.rs

    /// Factor on the largest load deviation of the study, for candidates beyond the range applied.
    BEYOND_RANGE_FACTOR: f64 = 1.25, "";
    /// Maximum number of load cases considered.
    MAX_LOAD_CASES: usize = 160, "";
    /// Maximum number of cases considered for repetition.
    MAX_REPEATED_CASES: usize = 24, "";
    /// Maximum number of mark positions considered on a part.
    MAX_MARK_POSITIONS: usize = 6, "";
    /// Maximum number of elements considered for a load cell.
    MAX_LOAD_CELLS: usize = 24, "";
    /// Assumed standard deviation of a wheel angle that the study does not measure.
    ASSUMED_WHEEL_ANGLE_DEG: f64 = 0.01, "deg";
    /// Assumed standard deviation of a wheel position that the study does not measure.
    ASSUMED_WHEEL_POSITION_MM: f64 = 0.05, "mm";
    /// Assumed standard deviation of a mark coordinate, where the study has no marks.
    ASSUMED_MARK_MM: f64 = 0.05, "mm";
    /// Standard deviation of a load cell, as a fraction of the largest force it measures.
    LOAD_CELL_NOISE: f64 = 0.005, "of full scale";

    // ## Criteria: plan.rs, rivals.rs, next_measurement.rs

    /// Number of worst-determined combinations of stiffnesses considered.
    WORST_COMBINATIONS: usize = 3, "";
    /// Maximum number of cases at which the wheel is predicted.
    MAX_WHEEL_CASES: usize = 40, "";
    /// Probability of a second model, given that it or the leading model is true, up to which it does not count as a rival.
    RIVAL_MIN_PROBABILITY: f64 = 0.01, "";
    /// Chi-square above which a load case is said to separate two explanations.
    SEPARATION_CHI_SQUARE: f64 = 6.0, "";
}
