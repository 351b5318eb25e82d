//! An external program in a folder of its own, with a time limit.

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

/// What a run prints, on both of its outputs.
pub(super) const CONSOLE: &str = "console.log";

/// A run that prints more bytes is ended.
const LARGEST_CONSOLE: u64 = 64 << 20;

/// A run that writes more bytes into its folder is ended.
const LARGEST_FOLDER: u64 = 8 << 30;

/// Runs a command line in `folder` to its end.
///
/// # Errors
/// [`RunError::Start`] when it cannot be started; [`RunError::Timeout`] and [`RunError::Output`] when it was killed. However it ends,
/// all it had started ends with it.
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
    let mut command = if cfg!(windows) {
        // Windows itself looks beside this program first, and for nothing but an .exe; `mdi` of ADAMS is a .bat.
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

/// Ends all runs that go on, and removes their folders: before this process ends itself.
pub fn end_runs() {
    process_tree::end_runs();
    scratch_folder::remove_all();
}

/// What of a run's output is larger than any answer, if anything is.
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

/// The first bytes of a file that a run wrote, as text; nothing if there is none.
pub(super) fn beginning(path: &Path) -> String {
    let mut bytes = Vec::new();
    // What can be read is read.
    let _ = File::open(path).map(|file| file.take(LARGEST_CONSOLE).read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The last bytes of such a file.
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

/// The last lines a run printed, for a person.
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
