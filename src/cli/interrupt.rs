use std::sync::atomic::{AtomicBool, Ordering};

use admire_session::backend::end_runs;

use super::shell::Exit;

/// True after the first Ctrl-C. The second Ctrl-C ends the process at once.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Installs the Ctrl-C handler. The first Ctrl-C requests a stop after the current step of the computation, so that the results so far are
/// kept.
pub(super) fn listen() {
    // If the handler cannot be installed, Ctrl-C still ends the process, but the results so far are lost.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            end_runs();
            std::process::exit(Exit::Interrupted as i32);
        }
        eprintln!("stopping after this step; press Ctrl-C again to stop at once");
    });
}

/// Returns true after the first Ctrl-C.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
