//! The command `admire`.

fn main() -> std::process::ExitCode {
    admire::cli::main()
}
