use std::sync::atomic::{AtomicBool, Ordering};

use admire_session::backend::end_runs;

use super::shell::Exit;

/// Set by the first Ctrl-C; the second Ctrl-C ends the process at once.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Installs a handler: the first Ctrl-C requests a stop after the current step, so that the results so far are kept.
pub(super) fn listen() {
    // Without a handler Ctrl-C still ends the process, but the results so far are lost.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            end_runs();
            std::process::exit(Exit::Interrupted as i32);
        }
        eprintln!("stopping after this step; once more to give up at once");
    });
}

/// Returns true after the first Ctrl-C.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
