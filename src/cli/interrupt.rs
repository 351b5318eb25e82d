use std::sync::atomic::{AtomicBool, Ordering};

use admire_session::backend::end_runs;

use super::shell::Exit;

/// Set by the first Ctrl-C; the second ends the process at once.
static ASKED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C asks a run to stop after its present step, so that what it found so far is kept.
pub(super) fn listen() {
    // Without a handler Ctrl-C still ends the process: nothing is lost but the results so far.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            end_runs();
            std::process::exit(Exit::Interrupted as i32);
        }
        eprintln!("stopping after this step; once more to give up at once");
    });
}

/// True once Ctrl-C was pressed.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
