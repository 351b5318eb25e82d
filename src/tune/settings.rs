//! Settings of the search for a target. `admire explain priors` prints them.

admire_study::constants! {
    /// Step of the differences that replace derivatives which the solver does not have, in units of the natural size of an unknown.
    DIFFERENCE_STEP: f64 = 1e-4, "";
    /// Predicted decrease of the cost by the next step below which a search has converged. A goal that is missed by its tolerance costs 0.5.
    CONVERGED_DECREMENT: f64 = 1e-7, "";
    /// Step below which a search has converged, in units of the natural size of an unknown.
    CONVERGED_STEP: f64 = 1e-7, "";
    /// Miss of a limit that counts as none, in units of its tolerance.
    LIMIT_SLACK: f64 = 1e-3, "";
    /// First penalty on limits, in units of the cost of a goal.
    FIRST_PENALTY: f64 = 10.0, "";
    /// Factor of the penalty after a round of multipliers that reduced the misses of the limits too little.
    PENALTY_GROWTH: f64 = 10.0, "";
    /// Reduction of the largest miss of a limit in one round that counts as enough.
    ENOUGH_REDUCTION: f64 = 0.25, "";
    /// Largest penalty on limits.
    MAX_PENALTY: f64 = 1e6, "";
    /// Maximum number of rounds of multipliers.
    MULTIPLIER_ROUNDS: usize = 30, "";
    /// Excess of the cost of a start over the best cost, relative to it, up to which the start agrees with the best.
    AGREEING_SHARE: f64 = 0.01, "";
    /// Excess of the cost of a start over the best cost up to which the start agrees with the best, whatever the best cost is.
    AGREEING_COST: f64 = 1e-4, "";
    /// Distance from a bound, in units of the width between the bounds, up to which an unknown is at its bound.
    AT_BOUND: f64 = 1e-6, "";
    /// Cosine of the directions in which two goals are improved, below which they conflict.
    CONFLICT_COSINE: f64 = -0.3, "";
    /// Distance below which a marker that joins no parts is at a hardpoint.
    SAME_PLACE_M: f64 = 1e-6, "m";
    /// Change of a reading along a motion without stiffness, relative to the reading or in units of the deck, up to which an equilibrium
    /// determines it. The motion is scaled so that its largest rotation is one radian.
    FREE_CHANGE: f64 = 1e-6, "";
    /// Number of standard deviations of the tolerances for which a robust goal is met.
    ROBUST_SD: f64 = 2.0, "sd";
    /// Number of draws from the linear model of the tolerances.
    LINEAR_DRAWS: usize = 20_000, "";
    /// Seed of the draws from the tolerances.
    TOLERANCE_SEED: u64 = 1, "";
    /// Factor of the standard deviation of a tolerance that is tightened.
    TIGHTENED: f64 = 0.5, "";
    /// Number of points of a Pareto front.
    FRONT_POINTS: usize = 11, "";
    /// Weight of a goal at its end of a Pareto front, where the other goal has its usual weight of 1.
    FRONT_END_WEIGHT: f64 = 1e4, "";
    /// Distance of neighbours on a Pareto front below which no point is sought between them, in units of the extent of the front.
    FRONT_SPACING: f64 = 0.01, "";
    /// Miss by which a point of a Pareto front is worse than another and still counts as equal, in units of the extent of the front.
    FRONT_SLACK: f64 = 1e-4, "";
}
