//! An external program in a folder of its own, with a time limit.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::RunError;

/// What a run prints, on both of its outputs.
pub(super) const CONSOLE: &str = "console.log";

/// Runs a command line in `folder` to its end.
///
/// # Errors
/// [`RunError::Start`] when it cannot be started; [`RunError::Timeout`] when it was killed, with all it had started itself.
pub(super) fn execute(
    words: &[String],
    folder: &Path,
    timeout: Duration,
) -> Result<ExitStatus, RunError> {
    let Some((program, arguments)) = words.split_first() else {
        return Err(RunError::Start {
            program: String::new(),
            reason: "no program is given".to_string(),
        });
    };
    let start = |error: std::io::Error| RunError::Start {
        program: program.clone(),
        reason: error.to_string(),
    };
    // Into a file: a pipe that nobody empties would hang the run.
    let log = File::create(folder.join(CONSOLE)).map_err(start)?;
    let also = log.try_clone().map_err(start)?;
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(log)
        .stderr(also)
        .spawn()
        .map_err(start)?;
    let begin = Instant::now();
    let mut pause = Duration::from_micros(200);
    loop {
        match child.try_wait().map_err(start)? {
            Some(status) => return Ok(status),
            None if begin.elapsed() > timeout => {
                kill_tree(&mut child);
                return Err(RunError::Timeout {
                    seconds: timeout.as_secs_f64(),
                    tail: tail(folder),
                });
            }
            None => std::thread::sleep(pause),
        }
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

/// Ends a process and what it started: ADAMS' own `mdi` is a script, and the solver behind it holds the licence.
fn kill_tree(child: &mut Child) {
    let quietly = |program: &str, arguments: &[String]| {
        Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stderr(Stdio::null())
            .output()
    };
    if cfg!(windows) {
        let id = child.id().to_string();
        let _ = quietly("taskkill", &["/T", "/F", "/PID", &id].map(String::from));
    } else if let Ok(listed) = quietly("ps", &["-A", "-o", "pid=,ppid="].map(String::from)) {
        let below = descendants(child.id(), &String::from_utf8_lossy(&listed.stdout));
        if !below.is_empty() {
            let mut words = vec!["-s".to_string(), "KILL".to_string()];
            words.extend(below.iter().map(u32::to_string));
            let _ = quietly("kill", &words);
        }
    }
    // The answer is no longer wanted; that it has just ended is no error.
    let _ = child.kill();
    let _ = child.wait();
}

/// The processes below `root` in a table with a process and its parent on each line.
fn descendants(root: u32, table: &str) -> Vec<u32> {
    let pairs: Vec<(u32, u32)> = table
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?.parse().ok()?, words.next()?.parse().ok()?))
        })
        .collect();
    let mut found = vec![root];
    let mut at = 0;
    while at < found.len() {
        let parent = found[at];
        for &(process, of) in &pairs {
            if of == parent && !found.contains(&process) {
                found.push(process);
            }
        }
        at += 1;
    }
    found.split_off(1)
}

/// The last lines a run printed, for a person.
pub(super) fn tail(folder: &Path) -> String {
    let mut lines = Vec::new();
    for name in [CONSOLE, "run.msg"] {
        let bytes = std::fs::read(folder.join(name)).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        lines = text
            .lines()
            .filter(|line| !line.trim().is_empty())
            .map(str::to_string)
            .collect();
        if !lines.is_empty() {
            break;
        }
    }
    lines.split_off(lines.len().saturating_sub(12)).join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_of_children_are_found_and_strangers_are_not() {
        let table = "    1     0\n   10     1\n   11    10\n   12    11\n   20     1\n  bad line\n";
        assert_eq!(descendants(10, table), [11, 12]);
        assert!(descendants(12, table).is_empty());
        // A table that goes round does not hang.
        assert_eq!(descendants(5, "5 6\n6 5\n"), [6]);
    }
}
