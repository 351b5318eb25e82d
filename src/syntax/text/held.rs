//! Waiting for files and folders that another program holds open.
//!
//! Windows does not let a program replace, write or remove a file that is open elsewhere: in MATLAB, an editor, a virus scanner, or a
//! process that is just ending. Most programs release the file soon. Other systems have no such restriction.

use std::io::{Error, Result};
use std::time::Duration;

/// Pauses between the attempts, in milliseconds; their sum is two seconds.
const PAUSES: [u64; 9] = [5, 10, 25, 60, 100, 200, 400, 600, 600];

/// Runs a file operation. While another program holds the file open, the operation is repeated for up to two seconds.
///
/// # Errors
/// Returns the error of the last attempt. An error with another cause is returned at once.
pub fn patiently<T>(attempt: impl FnMut() -> Result<T>) -> Result<T> {
    let wait = |pause| std::thread::sleep(Duration::from_millis(pause));
    repeated(attempt, is_held, wait).map_err(|error| {
        if is_held(&error) {
            let why = "another program may hold it open (MATLAB, an editor, a virus scanner): close it there and try again";
            return Error::new(error.kind(), format!("{error}; {why}"));
        }
        error
    })
}

/// Returns true for the errors by which Windows reports a file in use: access denied, sharing violation, lock violation, folder not empty.
fn is_held(error: &Error) -> bool {
    cfg!(windows) && matches!(error.raw_os_error(), Some(5 | 32 | 33 | 145))
}

fn repeated<T>(
    mut attempt: impl FnMut() -> Result<T>,
    passes: impl Fn(&Error) -> bool,
    mut wait: impl FnMut(u64),
) -> Result<T> {
    for pause in PAUSES {
        match attempt() {
            Err(error) if passes(&error) => wait(pause),
            outcome => return outcome,
        }
    }
    attempt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_for_a_while_is_waited_for() {
        let busy = || Error::from(std::io::ErrorKind::ResourceBusy);
        let (mut left, mut waited) = (4, 0);
        let attempt = || {
            left -= 1;
            if left == 0 { Ok("done") } else { Err(busy()) }
        };
        let done = repeated(attempt, |_| true, |pause| waited += pause).unwrap();
        assert_eq!((done, waited), ("done", 40));
        // The attempts end after two seconds, and an error with another cause ends them at once.
        let (mut count, mut waited) = (0, 0);
        let attempt = || {
            count += 1;
            Err::<(), _>(busy())
        };
        assert!(repeated(attempt, |_| true, |pause| waited += pause).is_err());
        assert_eq!((count, waited), (10, 2000));
        let mut count = 0;
        let attempt = || {
            count += 1;
            Err::<(), _>(busy())
        };
        assert!(repeated(attempt, |_| false, |_| {}).is_err());
        assert_eq!(count, 1);
    }
}
