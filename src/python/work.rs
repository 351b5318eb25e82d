//! Long work beside the interpreter: without its lock, on threads of the package's own, while the caller listens for Ctrl-C.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use crossbeam_channel::{RecvTimeoutError, bounded};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::front::Error;
use admire_diagnosis::SharedProgress;

use super::refusal::raised;

/// Between two looks for signals and at the progress.
const TICK: Duration = Duration::from_millis(50);
/// So long an interrupted computation may take to end by itself; then it is left behind.
const GRACE: Duration = Duration::from_millis(400);
/// As large as the stack of a main thread.
const STACK: usize = 8 << 20;

/// The threads, and the process they belong to: a child of `fork` has none of them.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut held = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let own = std::process::id();
    if let Some((process, pool)) = &*held
        && *process == own
    {
        return Ok(Arc::clone(pool));
    }
    let built = ThreadPoolBuilder::new().stack_size(STACK).build();
    let pool = Arc::new(built.map_err(|error| PyRuntimeError::new_err(error.to_string()))?);
    if let Some((_, gone)) = held.replace((own, Arc::clone(&pool))) {
        // Its threads stayed with the parent: nobody can wait for them.
        std::mem::forget(gone);
    }
    Ok(pool)
}

/// Leaves the threads to a job that does not end; the next one has threads of its own.
fn abandon() {
    *POOL.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// The process that loaded the package.
static LOADED_BY: OnceLock<u32> = OnceLock::new();

/// Remembers the process that loads the package.
pub(super) fn loaded() {
    LOADED_BY.get_or_init(std::process::id);
}

/// Does a job that is over in milliseconds, in the calling thread and without the lock of the interpreter: to wake another thread would
/// take as long as the job.
pub(super) fn at_once<T: Send + 'static>(
    py: Python<'_>,
    job: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    if LOADED_BY.get() != Some(&std::process::id()) {
        // What the job shares among threads stayed with the parent of this process.
        return work(py, &SharedProgress::default(), None, job);
    }
    match py.detach(|| catch_unwind(AssertUnwindSafe(job))) {
        Ok(done) => done.map_err(|error| raised(py, &error)),
        Err(_) => Err(PyRuntimeError::new_err("admire failed; this is a bug")),
    }
}

/// Does a job without the lock of the interpreter. `watched` is stopped by Ctrl-C, which raises within a second whatever the job does;
/// `progress` is called with stage, remark, count and total whenever these change.
pub(super) fn work<T: Send + 'static>(
    py: Python<'_>,
    watched: &SharedProgress,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = bounded(1);
    let pool = pool()?;
    pool.spawn(move || {
        // Nobody listens any more after an interrupt.
        let _ = send.send(catch_unwind(AssertUnwindSafe(job)));
    });
    drop(pool);
    let mut shown = None;
    loop {
        match py.detach(|| receive.recv_timeout(TICK)) {
            Ok(Ok(Ok(done))) => return Ok(done),
            Ok(Ok(Err(error))) => return Err(raised(py, &error)),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("admire failed; this is a bug"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        let heard = py.check_signals().and_then(|()| match progress {
            Some(progress) => {
                let now = watched.stand();
                if shown.as_ref() != Some(&now) {
                    progress.call1((&now.stage, &now.detail, now.done, now.most))?;
                    shown = Some(now);
                }
                Ok(())
            }
            None => Ok(()),
        });
        if let Err(interrupt) = heard {
            watched.stop();
            if py.detach(|| receive.recv_timeout(GRACE)).is_err() {
                abandon();
            }
            return Err(interrupt);
        }
    }
}
