//! Processes of a run on Windows: they form one Windows job, which ends with the run.
//!
//! The program joins the job before it executes its first instruction. Its child processes are then created inside the job: `mdi.bat`, the
//! solver started by it, and their own children. When the last handle of the job is closed, Windows ends all processes in it. This holds no
//! matter how the process of `admire` ends.

use std::io;
use std::os::windows::io::AsRawHandle;
use std::os::windows::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use process_wrap::std::{ChildWrapper, CommandWrap, CommandWrapper, JobObject};
use win32job::{ExtendedLimitInfo, Job};

/// CREATE_SUSPENDED: the new process is suspended until it has joined the job.
const SUSPENDED: u32 = 0x0000_0004;

/// CREATE_NO_WINDOW: the new process gets an invisible console of its own. Ctrl-C and Ctrl-Break then reach only the process of `admire`,
/// which ends the run.
const NO_WINDOW: u32 = 0x0800_0000;

/// Jobs of all current runs.
static RUNNING: Mutex<Vec<Arc<Job>>> = Mutex::new(Vec::new());

/// The processes of one run; they end when this value is dropped.
#[derive(Debug)]
pub(super) struct ProcessTree {
    child: Box<dyn ChildWrapper>,
    /// Handle of the job, by which the job is found in [`RUNNING`].
    job: isize,
}

/// Starts a command in a new job of its own.
///
/// # Errors
/// Returns an error if the command cannot be started.
pub(super) fn start(command: Command) -> io::Result<ProcessTree> {
    let mut info = ExtendedLimitInfo::new();
    info.limit_kill_on_job_close();
    let job = Job::create_with_limit_info(&info).map_err(io::Error::other)?;
    let job = Arc::new(job);
    let mut command = CommandWrap::from(command);
    // The wrapper `JobObject` suspends the program and later resumes it; in between, the wrapper `Joins` assigns it to the job.
    command.wrap(JobObject).wrap(Joins(Arc::clone(&job)));
    let child = command.spawn()?;
    let tree = ProcessTree {
        child,
        job: job.handle(),
    };
    running().push(job);
    Ok(tree)
}

impl ProcessTree {
    /// Returns the exit status of the program, or `None` while the program is running.
    ///
    /// # Errors
    /// Returns an error if the operating system does not report the status.
    pub(super) fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }
}

impl Drop for ProcessTree {
    fn drop(&mut self) {
        // The program may already have ended, so an error is ignored.
        let _ = self.child.start_kill();
        running().retain(|job| job.handle() != self.job);
        let _ = self.child.inner_mut().wait();
    }
}

/// Ends all current runs; called before the process of `admire` ends.
pub(super) fn end_runs() {
    running().clear();
}

fn running() -> MutexGuard<'static, Vec<Arc<Job>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Wrapper that assigns a new process to a job.
#[derive(Debug)]
struct Joins(Arc<Job>);

impl CommandWrapper for Joins {
    fn pre_spawn(&mut self, command: &mut Command, _: &CommandWrap) -> io::Result<()> {
        command.creation_flags(SUSPENDED | NO_WINDOW);
        Ok(())
    }

    fn post_spawn(
        &mut self,
        _: &mut Command,
        child: &mut Child,
        _: &CommandWrap,
    ) -> io::Result<()> {
        let joined = self.0.assign_process(child.as_raw_handle() as isize);
        joined.map_err(|error| {
            // The suspended process would never be resumed.
            let _ = child.kill();
            io::Error::other(error)
        })
    }
}
