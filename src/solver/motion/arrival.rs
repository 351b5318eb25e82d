//! Test whether a motion has reached a given time.

/// Returns true if the time left until `end` is round-off, relative to `end` or to the largest step size `largest`.
pub fn has_arrived(time: f64, end: f64, largest: f64) -> bool {
    end - time <= 1e-12 * end.abs().max(largest)
}
