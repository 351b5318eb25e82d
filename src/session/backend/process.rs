//! Execution of an external program in a folder of its own, with a time limit.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

#[cfg(windows)]
use super::job as process_tree;
#[cfg(not(windows))]
use super::process_tree;
use super::{RunError, scratch_folder};

/// Name of the file that receives the standard output and standard error of a run.
pub(super) const CONSOLE: &str = "console.log";

/// Largest allowed size in bytes of the console output; a run with more output is killed.
const LARGEST_CONSOLE: u64 = 64 << 20;

/// Largest allowed size in bytes of the run folder; a run that writes more is killed.
const LARGEST_FOLDER: u64 = 8 << 30;

/// Runs a command line in `folder` until it ends. All processes that it started end with it.
///
/// # Errors
/// Returns [`RunError::Start`] if the command cannot be started. Returns [`RunError::Timeout`] or [`RunError::Output`] if the run took too
/// long or wrote too much and was killed.
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
    // The output goes to a file, because a full pipe would block the run.
    let log = File::create(folder.join(CONSOLE)).map_err(start)?;
    let also = log.try_clone().map_err(start)?;
    let mut command = if cfg!(windows) {
        // The program is looked up here, because Windows would search only for an .exe, and first in the folder of `admire`. The `mdi` of
        // ADAMS is a .bat.
        let found = which::which(program).map_err(|e| start(std::io::Error::other(e)))?;
        Command::new(found)
    } else {
        Command::new(program)
    };
    command
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(log)
        .stderr(also);
    let mut tree = process_tree::start(command).map_err(start)?;
    let begin = Instant::now();
    let mut pause = Duration::from_micros(200);
    loop {
        if let Some(status) = tree.try_wait().map_err(start)? {
            return Ok(status);
        }
        let late = begin.elapsed() > timeout;
        let too_much = too_much(folder);
        if late || too_much.is_some() {
            drop(tree);
            let tail = tail(folder);
            return Err(match too_much {
                Some(what) => RunError::Output { what, tail },
                None => RunError::Timeout {
                    seconds: timeout.as_secs_f64(),
                    tail,
                },
            });
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

/// Ends all current runs and removes their folders; called before the process of `admire` ends.
pub fn end_runs() {
    process_tree::end_runs();
    scratch_folder::remove_all();
}

/// Returns a description of the excess if the output of a run is larger than any valid result.
fn too_much(folder: &Path) -> Option<String> {
    let (mut all, mut console) = (0, 0);
    for entry in std::fs::read_dir(folder).ok()?.flatten() {
        let size = entry.metadata().map_or(0, |metadata| metadata.len());
        all += size;
        if entry.file_name() == CONSOLE {
            console = size;
        }
    }
    if console > LARGEST_CONSOLE {
        Some(format!("printed more than {} MB", LARGEST_CONSOLE >> 20))
    } else if all > LARGEST_FOLDER {
        Some(format!("wrote more than {} GB", LARGEST_FOLDER >> 30))
    } else {
        None
    }
}

/// Returns the first [`LARGEST_CONSOLE`] bytes of a file as text; empty if there is no such file.
pub(super) fn beginning(path: &Path) -> String {
    let mut bytes = Vec::new();
    // After a read error, the bytes read so far are used.
    let _ = File::open(path).map(|file| file.take(LARGEST_CONSOLE).read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns the last 16 KiB of a file as text.
fn end(path: &Path) -> String {
    const SHOWN: u64 = 16 << 10;
    let mut bytes = Vec::new();
    let _ = File::open(path).and_then(|mut file| {
        let size = file.metadata()?.len();
        file.seek(SeekFrom::Start(size.saturating_sub(SHOWN)))?;
        file.take(SHOWN).read_to_end(&mut bytes)
    });
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns the last lines that a run printed to its console or, if there are none, to its message file.
pub(super) fn tail(folder: &Path) -> String {
    let mut lines = Vec::new();
    for name in [CONSOLE, "run.msg"] {
        lines = end(&folder.join(name))
            .lines()
            .filter(|line| !line.trim().is_empty())
            .map(|line| line.chars().take(500).collect::<String>())
            .collect();
        if !lines.is_empty() {
            break;
        }
    }
    lines.split_off(lines.len().saturating_sub(12)).join("\n")
}
