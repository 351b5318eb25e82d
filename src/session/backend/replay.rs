use super::answer::{Answer, read};
use super::bushing_check::ForceFrame;
use super::run_folder::RunFiles;
use super::{Backend, BackendError, Recording, RunError, Sweep, SweepRequest};

/// Backend that returns recorded runs. It starts no program; a request that was not recorded is an error.
#[derive(Clone, Debug)]
pub struct ReplayBackend {
    recording: Recording,
    frame: Option<ForceFrame>,
}

impl ReplayBackend {
    /// Creates a backend that returns the runs in a recording.
    pub fn new(recording: Recording) -> Self {
        Self {
            recording,
            frame: None,
        }
    }
}

impl Backend for ReplayBackend {
    fn name(&self) -> &'static str {
        "replay"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let folder = &self.recording.folder;
        let files = RunFiles::of(request).map_err(|diagnostic| BackendError::Run {
            reason: Box::new(RunError::Deck(diagnostic.message)),
            folder: folder.clone(),
            dead: false,
        })?;
        let Some(run) = self.recording.find(&files) else {
            return Err(BackendError::NotRecorded {
                key: files.key(),
                recorded: self.recording.count(),
                folder: folder.clone(),
            });
        };
        let Answer { sweep, frame } =
            read(&run, request, self.frame).map_err(|reason| BackendError::Run {
                reason: Box::new(reason),
                folder: run,
                dead: false,
            })?;
        self.frame = frame;
        Ok(sweep)
    }

    fn remarks(&self) -> Vec<String> {
        super::command::frame_remark(self.frame)
            .into_iter()
            .collect()
    }
}
