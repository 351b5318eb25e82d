//! Process tree of a run on Windows, which ends with the run: all its processes form one Windows job.
//!
//! The program joins the job before its first instruction, and its child processes are created inside the job: `mdi.bat`, the solver behind
//! it, and their own children. The job ends when its last handle is closed, however this process ends.

use std::io;
use std::os::windows::io::AsRawHandle;
use std::os::windows::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use process_wrap::std::{ChildWrapper, CommandWrap, CommandWrapper, JobObject};
use win32job::{ExtendedLimitInfo, Job};

/// CREATE_SUSPENDED: the process is suspended until it has joined the job.
const SUSPENDED: u32 = 0x0000_0004;

/// CREATE_NO_WINDOW: an invisible console of its own. Ctrl-C and Ctrl-Break then reach only this process, which ends the run.
const NO_WINDOW: u32 = 0x0800_0000;

/// Jobs of the current runs.
static RUNNING: Mutex<Vec<Arc<Job>>> = Mutex::new(Vec::new());

/// The processes of one run; they end when this value is dropped.
#[derive(Debug)]
pub(super) struct ProcessTree {
    child: Box<dyn ChildWrapper>,
    /// Handle of the job, which identifies it.
    job: isize,
}

/// Starts a command as a job of its own.
///
/// # Errors
/// When it cannot be started.
pub(super) fn start(command: Command) -> io::Result<ProcessTree> {
    let mut info = ExtendedLimitInfo::new();
    info.limit_kill_on_job_close();
    let job = Job::create_with_limit_info(&info).map_err(io::Error::other)?;
    let job = Arc::new(job);
    let mut command = CommandWrap::from(command);
    // The first wrapper suspends the program and resumes it; the second assigns it to the job in between.
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
    /// Returns the exit status of the program, or `None` while it is running.
    ///
    /// # Errors
    /// When the system does not report the status.
    pub(super) fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }
}

impl Drop for ProcessTree {
    fn drop(&mut self) {
        // It is no error if the program has already ended.
        let _ = self.child.start_kill();
        running().retain(|job| job.handle() != self.job);
        let _ = self.child.inner_mut().wait();
    }
}

/// Ends all current runs, before this process itself ends.
pub(super) fn end_runs() {
    running().clear();
}

fn running() -> MutexGuard<'static, Vec<Arc<Job>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Assigns a new process to a job.
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
            // The process is still suspended and would never be resumed.
            let _ = child.kill();
            io::Error::other(error)
        })
    }
}
