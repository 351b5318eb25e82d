//! Background checks of whole files. A check that an edit has made outdated ends early and returns nothing.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender};

use admire_session::check::{DiagnosticSource, Found};
use admire_session::{check, folder_of, read_files};
use admire_syntax::lint::Options;
use admire_syntax::pieces::Pieces;
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};

/// A file to check.
pub(super) struct Job {
    /// Path of the file.
    pub path: PathBuf,
    /// Text of the file.
    pub text: Pieces,
    /// Text of the open decks, if the file is a command file.
    pub decks: HashMap<PathBuf, Pieces>,
    /// True if columns beyond 80 are reported.
    pub fortran: bool,
    /// Counter of the file's edits, and its value when the check was requested.
    pub edits: (Arc<AtomicU64>, u64),
}

/// Result of a check.
pub(super) struct Answer {
    /// Path of the file.
    pub path: PathBuf,
    /// Value of the edit counter when the check was requested.
    pub edits: u64,
    /// Findings of the check.
    pub found: Vec<Found>,
}

/// File size in bytes above which a file is checked only when typing pauses, because the processor is needed for the next keystroke.
const LARGE: usize = 1 << 20;
/// Time without an edit that counts as a pause in typing.
const PAUSE: Duration = Duration::from_millis(120);

/// Checks files until the job channel closes. If several jobs for one file are waiting, only the last is done.
pub(super) fn work(jobs: &Receiver<Job>, answers: &Sender<Answer>) {
    let mut waiting: Vec<Job> = Vec::new();
    let threads = all_but_one();
    while let Ok(job) = jobs.recv() {
        waiting.push(job);
        loop {
            waiting.extend(jobs.try_iter());
            waiting.retain(|job| !job.is_outdated());
            let Some(large) = waiting.first().map(|job| job.text.size() > LARGE) else {
                break;
            };
            if large && let Ok(next) = jobs.recv_timeout(PAUSE) {
                waiting.push(next);
                continue;
            }
            let job = waiting.remove(0);
            // A check that panics returns nothing; the next check may succeed.
            let found = catch_unwind(AssertUnwindSafe(|| match &threads {
                Some(threads) => threads.install(|| job.found()),
                None => job.found(),
            }));
            let Ok(Some(found)) = found else { continue };
            let answer = Answer {
                path: job.path,
                edits: job.edits.1,
                found,
            };
            if answers.send(answer).is_err() {
                return;
            }
        }
    }
}

/// Returns a thread pool for checks that leaves one processor free for the response to the next keystroke.
fn all_but_one() -> Option<rayon::ThreadPool> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = processors.saturating_sub(1).max(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().ok()
}

impl Job {
    fn is_outdated(&self) -> bool {
        self.edits.0.load(Ordering::Relaxed) != self.edits.1
    }

    fn found(&self) -> Option<Vec<Found>> {
        let source = self.text.source();
        if self.text.is_command_file() {
            return Some(self.of_commands(source));
        }
        let read = Dataset::parse(source);
        if self.is_outdated() {
            return None;
        }
        let folder = folder_of(read.value.source());
        let files = read_files(&read.value, &folder, &check::policy(&folder));
        let options = Options {
            fortran: self.fortran,
        };
        check::dataset(read, files, &options, || self.is_outdated())
    }

    fn of_commands(&self, source: Source) -> Vec<Found> {
        let deck = |path: &Path| {
            let path = super::workspace::normal(path);
            let source = match self.decks.get(&path) {
                Some(open) => open.source(),
                None => Source::read(&path).ok()?,
            };
            Some(Dataset::parse(source).value)
        };
        let found = check::command_file(CommandFile::parse(source), deck);
        let told = |diagnostic| Found::new(DiagnosticSource::File, diagnostic);
        found.into_iter().map(told).collect()
    }
}
