//! All processes a run starts on Windows, ended with it: they are one job of the system.
//!
//! The program joins the job before its first instruction, and what it starts is born into it: `mdi.bat`, the solver behind it, and
//! what these leave behind. The job ends when its last handle is closed, however this process ends.

use std::io;
use std::os::windows::io::AsRawHandle;
use std::os::windows::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use process_wrap::std::{ChildWrapper, CommandWrap, CommandWrapper, JobObject};
use win32job::{ExtendedLimitInfo, Job};

/// CREATE_SUSPENDED, for as long as it takes to join the job.
const SUSPENDED: u32 = 0x0000_0004;

/// CREATE_NO_WINDOW: a console of its own that nobody sees. Ctrl-C and Ctrl-Break reach this process alone, which ends the run.
const NO_WINDOW: u32 = 0x0800_0000;

/// Runs that go on now.
static RUNNING: Mutex<Vec<Arc<Job>>> = Mutex::new(Vec::new());

/// The processes of one run; they end when it goes out of scope.
#[derive(Debug)]
pub(super) struct ProcessTree {
    child: Box<dyn ChildWrapper>,
    /// The handle of its job, which tells it from others.
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
    // The first one suspends the program and lets it go again; the second one comes between.
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
    /// How the program ended; `None` while it goes on.
    ///
    /// # Errors
    /// When the system does not tell.
    pub(super) fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }
}

impl Drop for ProcessTree {
    fn drop(&mut self) {
        // What has ended by itself is no error.
        let _ = self.child.start_kill();
        running().retain(|job| job.handle() != self.job);
        let _ = self.child.inner_mut().wait();
    }
}

/// Ends all runs that go on: before this process ends itself.
pub(super) fn end_runs() {
    running().clear();
}

fn running() -> MutexGuard<'static, Vec<Arc<Job>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts a new process into a job.
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
            // It has not begun, and nobody would let it go.
            let _ = child.kill();
            io::Error::other(error)
        })
    }
}
