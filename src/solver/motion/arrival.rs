//! The test whether a motion has reached a time.

/// Returns true if the time left until `end` is round-off of `end` or of the longest step `largest`.
pub fn has_arrived(time: f64, end: f64, largest: f64) -> bool {
    end - time <= 1e-12 * end.abs().max(largest)
}
