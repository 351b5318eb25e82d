use std::time::{Duration, Instant};

use super::{BackendError, RunError};

/// First and longest pause between two attempts to get a licence. Each pause is twice as long as the preceding pause, up to the longest.
const PAUSES: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(30));

/// Words in messages about a missing licence that mean that waiting cannot help (FlexNet errors -1, -5, -8, -10).
const LASTING: [&str; 5] = [
    "expired",
    "no such feature",
    "does not exist",
    "invalid",
    "cannot find license file",
];

/// An error that may contain a [`RunError`].
pub(super) trait Reasoned {
    /// Returns the reason of the error, if a run of an external program failed.
    fn reason(&mut self) -> Option<&mut RunError>;
}

impl Reasoned for RunError {
    fn reason(&mut self) -> Option<&mut RunError> {
        Some(self)
    }
}

impl Reasoned for BackendError {
    fn reason(&mut self) -> Option<&mut RunError> {
        match self {
            Self::Run { reason, .. } => Some(&mut **reason),
            _ => None,
        }
    }
}

/// Repeats a run while its program gets no licence, for at most the time `limit`.
///
/// The first missing licence is logged as a warning. An error is returned at once if it has another cause, or if waiting cannot help.
///
/// # Errors
/// Returns the error of the last attempt. If the licence is missing, the error contains the time waited.
pub(super) fn patiently<T, E: Reasoned>(
    limit: Duration,
    mut attempt: impl FnMut() -> Result<T, E>,
) -> Result<T, E> {
    let begun = Instant::now();
    let mut pause = PAUSES.0;
    loop {
        let mut error = match attempt() {
            Ok(answer) => return Ok(answer),
            Err(error) => error,
        };
        let Some(RunError::Licence { line, waited }) = error.reason() else {
            return Err(error);
        };
        let spent = begun.elapsed();
        *waited = spent.as_secs_f64().round();
        let left = limit.saturating_sub(spent);
        if is_lasting(line) || left.is_zero() {
            return Err(error);
        }
        if pause == PAUSES.0 {
            log::warn!(
                "no licence ({line}): requesting it again for up to {} s",
                left.as_secs_f64().round()
            );
        }
        std::thread::sleep(pause.min(left));
        pause = (2 * pause).min(PAUSES.1);
    }
}

fn is_lasting(line: &str) -> bool {
    let line = line.to_ascii_lowercase();
    LASTING.iter().any(|word| line.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(line: &str) -> RunError {
        RunError::Licence {
            line: line.to_string(),
            waited: 0.0,
        }
    }

    #[test]
    fn a_licence_that_comes_free_is_taken() {
        let mut attempts = 0;
        let answer = patiently(Duration::from_secs(60), || {
            attempts += 1;
            if attempts == 1 {
                Err(refused("License request denied: all in use"))
            } else {
                Ok(attempts)
            }
        });
        assert_eq!(answer.ok(), Some(2));
    }

    #[test]
    fn what_waiting_does_not_help_against_is_told_at_once() {
        for (line, limit) in [("License expired", 60), ("license denied", 0)] {
            let mut attempts = 0;
            let answer: Result<(), _> = patiently(Duration::from_secs(limit), || {
                attempts += 1;
                Err(refused(line))
            });
            assert!(answer.is_err());
            assert_eq!(attempts, 1, "{line}");
        }
    }
}
