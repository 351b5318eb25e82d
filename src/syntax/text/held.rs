//! Files and folders that another program holds.
//!
//! Windows refuses to replace, write or remove what somebody has opened: MATLAB, an editor, a virus scanner, a process that is just
//! ending. Most let go soon. Elsewhere nobody is in the way.

use std::io::{Error, Result};
use std::time::Duration;

/// Between two attempts, in milliseconds: two seconds in all.
const PAUSES: [u64; 9] = [5, 10, 25, 60, 100, 200, 400, 600, 600];

/// Does something with a file, again and again for two seconds while another program holds the file.
///
/// # Errors
/// That of the last attempt, or of the first that has another reason.
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

/// True for what Windows says of what somebody holds: access denied, sharing violation, lock violation, folder not empty.
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
        // Not for ever, and not for another reason.
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
