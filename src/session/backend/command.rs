use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use super::answer::{Answer, read, run_command};
use super::bushing_check::ForceFrame;
use super::licence::patiently;
use super::process::tail;
use super::run_folder::{RunFiles, STEM};
use super::scratch_folder::ScratchFolder;
use super::{Backend, BackendError, Recording, RunError, Sweep, SweepRequest};

/// Backend that runs any external program with the command line of ADAMS.
///
/// Each run gets a new folder, so that no file of an earlier run can be mistaken for its result. The folder of a failed run is kept.
#[derive(Clone, Debug)]
pub struct CommandBackend {
    /// Program and its arguments; `{acf}` is replaced by the name of the command file.
    pub command: Vec<String>,
    /// Time after which a run is killed.
    pub timeout: Duration,
    /// Time during which a run is repeated if the program gets no licence.
    pub licence_wait: Duration,
    /// Number of runs that [`Backend::sweeps`] makes in parallel.
    pub jobs: usize,
    /// Folder in which numbered run folders are created and kept. If it is `None`, run folders are temporary.
    pub keep: Option<PathBuf>,
    /// Recording to which successful runs are copied, so that [`ReplayBackend`](super::ReplayBackend) can return them later.
    pub record: Option<Recording>,
    runs: usize,
    failed: usize,
    /// Number of consecutive runs that had to be killed, up to the latest run.
    killed: usize,
    frame: Option<ForceFrame>,
}

impl CommandBackend {
    /// Creates a backend for a command line, which makes one run at a time in temporary folders.
    pub fn new(command: Vec<String>, timeout: Duration) -> Self {
        Self {
            command,
            timeout,
            licence_wait: Duration::ZERO,
            jobs: 1,
            keep: None,
            record: None,
            runs: 0,
            failed: 0,
            killed: 0,
            frame: None,
        }
    }

    /// Returns the number of runs made so far, and the number of these runs that gave no valid result.
    pub const fn tally(&self) -> (usize, usize) {
        (self.runs, self.failed)
    }

    /// Makes the run with this number, and repeats it while the program gets no licence.
    fn run(&self, number: usize, request: &SweepRequest<'_>) -> Result<Answer, BackendError> {
        patiently(self.licence_wait, || self.attempt(number, request))
    }

    fn attempt(&self, number: usize, request: &SweepRequest<'_>) -> Result<Answer, BackendError> {
        let no_folder = |error: std::io::Error| BackendError::Run {
            reason: Box::new(RunError::Files(error.to_string())),
            folder: self.keep.clone().unwrap_or_default(),
            dead: false,
        };
        let prefix = format!("run-{number:04}-");
        let folder = match &self.keep {
            Some(keep) => ScratchFolder::lasting(keep, &prefix),
            None => ScratchFolder::temporary(),
        }
        .map_err(no_folder)?;
        match self.run_in(folder.path(), request) {
            Ok(answer) => Ok(answer),
            Err(reason) => Err(BackendError::Run {
                reason: Box::new(reason),
                folder: folder.keep(),
                dead: false,
            }),
        }
    }

    fn run_in(&self, folder: &Path, request: &SweepRequest<'_>) -> Result<Answer, RunError> {
        let files = |error: std::io::Error| RunError::Files(error.to_string());
        let given = RunFiles::of(request).map_err(|d| RunError::Deck(d.message))?;
        given.write(folder).map_err(files)?;
        // The time is read from a file in the folder, because the clock of a network file system may differ from the clock of this
        // computer.
        let begun = modified(&folder.join(format!("{STEM}.acf"))).map_err(files)?;
        run_command(&self.command, folder, self.timeout)?;
        for extension in ["res", "msg"] {
            let name = format!("{STEM}.{extension}");
            if modified(&folder.join(&name)).is_ok_and(|written| written < begun) {
                return Err(RunError::Results {
                    reason: format!("`{name}` is older than the run: it is from an earlier run"),
                    tail: tail(folder),
                });
            }
        }
        if !given.are_in(folder) {
            return Err(RunError::Results {
                reason: "the deck or the command file differs from the one that the run was given"
                    .to_string(),
                tail: tail(folder),
            });
        }
        let answer = read(folder, request, self.frame)?;
        if let Some(recording) = &self.record {
            recording.keep(&given, folder).map_err(|error| {
                RunError::Files(format!("{}: {error}", recording.folder.display()))
            })?;
        }
        Ok(answer)
    }

    fn take(&mut self, outcome: Result<Answer, BackendError>) -> Result<Sweep, BackendError> {
        self.runs += 1;
        match outcome {
            Ok(answer) => {
                self.frame = self.frame.or(answer.frame);
                self.killed = 0;
                Ok(answer.sweep)
            }
            Err(mut error) => {
                self.failed += 1;
                if let BackendError::Run { reason, dead, .. } = &mut error {
                    let killed = is_killed(reason);
                    self.killed = if killed { self.killed + 1 } else { 0 };
                    *dead = self.failed == self.runs || self.killed >= MOST_KILLED;
                }
                Err(error)
            }
        }
    }
}

/// Number of consecutive killed runs after which the program is given up.
const MOST_KILLED: usize = 3;

const fn is_killed(reason: &RunError) -> bool {
    matches!(reason, RunError::Timeout { .. } | RunError::Output { .. })
}

fn modified(path: &Path) -> std::io::Result<SystemTime> {
    std::fs::metadata(path)?.modified()
}

impl Backend for CommandBackend {
    fn name(&self) -> &'static str {
        "command"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let outcome = self.run(self.runs + 1, request);
        self.take(outcome)
    }

    fn sweeps(&mut self, requests: &[SweepRequest<'_>]) -> Vec<Result<Sweep, BackendError>> {
        let mut answers: Vec<Result<Sweep, BackendError>> = Vec::new();
        let lasting = |answers: &[Result<Sweep, BackendError>]| {
            let failed = answers.iter().filter_map(|answer| answer.as_ref().err());
            failed.rev().find(|error| error.is_lasting()).cloned()
        };
        // Requests run one by one until a run gives a result, so that a program that does not work is started only once.
        while let Some(request) = requests.get(answers.len())
            && (self.jobs < 2 || self.runs == self.failed)
            && lasting(&answers).is_none()
        {
            answers.push(self.sweep(request));
        }
        if let Some(error) = lasting(&answers) {
            answers.resize_with(requests.len(), || Err(error.clone()));
            return answers;
        }
        let requests = &requests[answers.len()..];
        let workers = self.jobs.min(requests.len());
        let (next, killed) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let done: Mutex<Vec<(usize, Result<Answer, BackendError>)>> = Mutex::new(Vec::new());
        let this = &*self;
        std::thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(|| {
                    loop {
                        let at = next.fetch_add(1, Ordering::Relaxed);
                        if killed.load(Ordering::Relaxed) >= MOST_KILLED {
                            break;
                        }
                        let Some(request) = requests.get(at) else {
                            break;
                        };
                        let outcome = this.run(this.runs + 1 + at, request);
                        if let Err(BackendError::Run { reason, .. }) = &outcome
                            && is_killed(reason)
                        {
                            killed.fetch_add(1, Ordering::Relaxed);
                        }
                        done.lock()
                            .unwrap_or_else(PoisonError::into_inner)
                            .push((at, outcome));
                    }
                });
            }
        });
        let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        done.sort_by_key(|(at, _)| *at);
        let all = answers.len() + requests.len();
        answers.extend(done.into_iter().map(|(_, outcome)| self.take(outcome)));
        // If several runs had to be killed, the remaining requests were not started; they get the last error.
        let failed = answers
            .iter()
            .rev()
            .find_map(|answer| answer.as_ref().err());
        if let Some(mut error) = failed.cloned().filter(|_| answers.len() < all) {
            if let BackendError::Run { dead, .. } = &mut error {
                *dead = true;
            }
            answers.resize_with(all, || Err(error.clone()));
        }
        answers
    }

    fn remarks(&self) -> Vec<String> {
        frame_remark(self.frame).into_iter().collect()
    }
}

/// Returns a remark for the user that says in which axes the results give bushing forces.
pub(super) fn frame_remark(frame: Option<ForceFrame>) -> Option<String> {
    frame.map(|frame| {
        format!("the bushing forces of the results are in {frame}, where they fit the deflections")
    })
}
