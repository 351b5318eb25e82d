//! Long computations in a Python process. They run without the interpreter's lock on threads of this package, while the calling thread handles
//! Ctrl-C.

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

/// Interval between checks for signals and progress.
const TICK: Duration = Duration::from_millis(50);
/// Time allowed for an interrupted computation to end. After this time, the computation is abandoned.
const GRACE: Duration = Duration::from_millis(400);
/// Stack size of the threads in bytes, equal to the usual stack size of a main thread.
const STACK: usize = 8 << 20;

/// Thread pool, with the id of the process that created it. A child process created by `fork` does not inherit the threads.
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
        // The threads of the old pool exist only in the parent process and cannot be joined.
        std::mem::forget(gone);
    }
    Ok(pool)
}

/// Abandons the current threads, which run a job that does not end. The next job gets new threads.
fn abandon() {
    *POOL.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// Id of the process that loaded the package.
static LOADED_BY: OnceLock<u32> = OnceLock::new();

/// Records the process that loads the package.
pub(super) fn loaded() {
    LOADED_BY.get_or_init(std::process::id);
}

/// Runs a job of a few milliseconds in the calling thread, without the interpreter's lock. Waking another thread would take as long as the
/// job itself.
pub(super) fn at_once<T: Send + 'static>(
    py: Python<'_>,
    job: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    if LOADED_BY.get() != Some(&std::process::id()) {
        // After `fork`, thread state that the job may use is invalid.
        return work(py, &SharedProgress::default(), None, job);
    }
    match py.detach(|| catch_unwind(AssertUnwindSafe(job))) {
        Ok(done) => done.map_err(|error| raised(py, &error)),
        Err(_) => Err(PyRuntimeError::new_err(
            "internal error of admire; please report it",
        )),
    }
}

/// Runs a job without the interpreter's lock. Ctrl-C stops `watched` and raises the exception within a second, whatever the job does.
/// `progress` is called with stage, detail, count and total whenever one of these changes.
pub(super) fn work<T: Send + 'static>(
    py: Python<'_>,
    watched: &SharedProgress,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = bounded(1);
    let pool = pool()?;
    pool.spawn(move || {
        // After an interrupt, no thread receives the result.
        let _ = send.send(catch_unwind(AssertUnwindSafe(job)));
    });
    drop(pool);
    let mut shown = None;
    loop {
        match py.detach(|| receive.recv_timeout(TICK)) {
            Ok(Ok(Ok(done))) => return Ok(done),
            Ok(Ok(Err(error))) => return Err(raised(py, &error)),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "internal error of admire; please report it",
                ));
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
