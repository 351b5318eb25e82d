//! Settings of tuning. `admire explain priors` prints them.

admire_study::constants! {
    /// Step of the finite differences that replace derivatives which the solver does not compute, in units of the natural size of an
    /// unknown.
    DIFFERENCE_STEP: f64 = 1e-4, "";
    /// Predicted decrease of the cost by the next step below which a search counts as converged. A goal with a miss equal to its tolerance
    /// costs 0.5.
    CONVERGED_DECREMENT: f64 = 1e-7, "";
    /// Step size below which a search counts as converged, in units of the natural size of each unknown.
    CONVERGED_STEP: f64 = 1e-7, "";
    /// Largest miss at which a limit counts as kept, in units of its tolerance.
    LIMIT_SLACK: f64 = 1e-3, "";
    /// Initial penalty on limits, in units of the cost of a goal.
    FIRST_PENALTY: f64 = 10.0, "";
    /// Factor by which the penalty grows after a round of multipliers that reduces the misses of the limits too little.
    PENALTY_GROWTH: f64 = 10.0, "";
    /// Ratio of the largest miss of a limit after a round to that before the round, above which the penalty grows.
    ENOUGH_REDUCTION: f64 = 0.25, "";
    /// Largest penalty on limits.
    MAX_PENALTY: f64 = 1e6, "";
    /// Maximum number of rounds of multipliers.
    MULTIPLIER_ROUNDS: usize = 30, "";
    /// Relative excess of a start's final cost over the best cost, up to which the start agrees with the best.
    AGREEING_SHARE: f64 = 0.01, "";
    /// Absolute excess of a start's final cost over the best cost, up to which the start agrees with the best.
    AGREEING_COST: f64 = 1e-4, "";
    /// Distance from a bound at which an unknown counts as being at the bound, in units of the distance between the bounds.
    AT_BOUND: f64 = 1e-6, "";
    /// Cosine of the angle between the directions that improve two goals, below which the goals conflict.
    CONFLICT_COSINE: f64 = -0.3, "";
    /// Distance below which a marker that joins no parts counts as coinciding with a hardpoint.
    SAME_PLACE_M: f64 = 1e-6, "m";
    /// Change of a reading along a motion without stiffness, up to which an equilibrium determines the reading. It is relative to the
    /// reading, or in units of the deck if the reading is below one. The motion is scaled so that its largest rotation is one radian.
    FREE_CHANGE: f64 = 1e-6, "";
    /// Number of standard deviations by which the tolerances may shift a value while a robust goal is still met.
    ROBUST_SD: f64 = 2.0, "sd";
    /// Number of draws from the linear model of the tolerances.
    LINEAR_DRAWS: usize = 20_000, "";
    /// Seed of the draws from the tolerances.
    TOLERANCE_SEED: u64 = 1, "";
    /// Factor by which the standard deviation of a tolerance is reduced, to find the gain in good axles.
    TIGHTENED: f64 = 0.5, "";
    /// Number of points of a Pareto front.
    FRONT_POINTS: usize = 11, "";
    /// Weight of a goal at its own end of a Pareto front. The other goal then has its usual weight of 1.
    FRONT_END_WEIGHT: f64 = 1e4, "";
    /// Distance between neighbouring points of a Pareto front below which no point is sought between them, in units of the extent of the
    /// front.
    FRONT_SPACING: f64 = 0.01, "";
    /// Difference of misses up to which two points of a Pareto front count as equal, in units of the extent of the front.
    FRONT_SLACK: f64 = 1e-4, "";
}
