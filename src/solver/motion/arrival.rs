//! When a motion is at a time.

/// True if what is left of the way to a time is round-off beside it or the longest step.
pub fn has_arrived(time: f64, end: f64, largest: f64) -> bool {
    end - time <= 1e-12 * end.abs().max(largest)
}
