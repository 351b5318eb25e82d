//! The command `admire`.

fn main() -> std::process::ExitCode {
    admire::cli::run(std::env::args_os().collect()).into()
}
