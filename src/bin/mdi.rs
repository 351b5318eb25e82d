//! The drop-in solver `mdi`, which has the command line of ADAMS.

fn main() -> std::process::ExitCode {
    admire_session::mdi(std::env::args_os().collect()).into()
}
