//! The drop-in solver with ADAMS' own command line.

fn main() -> std::process::ExitCode {
    admire_session::mdi()
}
