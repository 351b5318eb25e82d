use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic};

use crate::front::permissions::make_executable;

use super::Outcome;
use super::shell::{Exit, Shell};

/// Put commands called like ADAMS' own into a folder; each runs this installation's `mdi`.
///
/// Put the folder first on the PATH, and a script written for ADAMS runs on admire.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The folder; it is made if missing.
    directory: PathBuf,
    /// Names of the commands. Without it `mdi`, `MDI`, and the names of the releases of ten years, `adams2016` to `adams2025_1`.
    #[arg(long, value_delimiter = ',', default_values_t = default_names(), hide_default_value = true)]
    names: Vec<String>,
    /// Replace files of these names that are there already.
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = "Examples:
  admire install-shims ~/bin/adams
  admire install-shims C:\\adams --names mdi,adams2023_4";

/// What the releases of the last ten years call their launcher.
const RELEASES: [&str; 31] = [
    "2016", "2017", "2017_1", "2017_2", "2018", "2018_1", "2019", "2019_1", "2019_2", "2020",
    "2020_1", "2021", "2021_0_1", "2021_0_2", "2021_1", "2021_2", "2021_3", "2021_4", "2022_1",
    "2022_2", "2022_3", "2022_4", "2023_1", "2023_2", "2023_3", "2023_4", "2023_4_1", "2024_1",
    "2024_1_1", "2024_2", "2025_1",
];

fn default_names() -> Vec<String> {
    let mut names = vec!["mdi".to_string(), "MDI".to_string()];
    names.extend(RELEASES.iter().map(|release| format!("adams{release}")));
    names
}

/// Writes a Unix shell script and a Windows batch file for each name.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let folder = &arguments.directory;
    let cannot = |path: &Path, error: &std::io::Error| {
        Diagnostic::error(
            Code::CannotWrite,
            format!("`{}` cannot be written: {error}", path.display()),
        )
    };
    let mdi = std::env::current_exe()
        .and_then(std::fs::canonicalize)
        .map(|admire| admire.with_file_name(format!("mdi{}", std::env::consts::EXE_SUFFIX)))
        .map_err(|error| shell.fail(cannot(folder, &error)))?;
    if !mdi.is_file() {
        let message = format!(
            "`{}` is not there, so that nothing could run",
            mdi.display()
        );
        return Err(shell.fail(Diagnostic::error(Code::CannotRead, message).help(
            "`cargo install --locked --path .` installs admire and mdi together; `cargo build --release` builds both",
        )));
    }
    std::fs::create_dir_all(folder).map_err(|error| shell.fail(cannot(folder, &error)))?;
    let plain = |name: &String| {
        !name.is_empty()
            && name
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
    };
    for name in &arguments.names {
        if !plain(name) {
            return Err(shell.usage(Diagnostic::error(
                Code::CannotWrite,
                format!("`{name}` is not a name for a command"),
            )));
        }
        for (file, text) in [
            (name.clone(), unix_shim(&mdi)),
            (format!("{name}.bat"), windows_shim(&mdi)),
        ] {
            let path = folder.join(file);
            if path.exists()
                && !arguments.force
                && std::fs::read(&path).ok() != Some(text.clone().into_bytes())
            {
                return Err(shell.usage(
                    Diagnostic::error(
                        Code::CannotWrite,
                        format!("`{}` is there already", path.display()),
                    )
                    .help("`--force` replaces it"),
                ));
            }
            shell.write(&path, text.as_bytes())?;
            make_executable(&path).map_err(|error| shell.fail(cannot(&path, &error)))?;
            shell.print(&format!("{}\n", path.display()));
        }
    }
    Ok(Exit::Fine)
}

fn unix_shim(mdi: &Path) -> String {
    let quoted = mdi.display().to_string().replace('\'', r"'\''");
    format!("#!/bin/sh\nexec '{quoted}' \"$@\"\n")
}

fn windows_shim(mdi: &Path) -> String {
    // `%` would be taken for a variable.
    let quoted = mdi.display().to_string().replace('%', "%%");
    format!("@echo off\r\n\"{quoted}\" %*\r\nexit /b %ERRORLEVEL%\r\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shims_quote_the_path() {
        let path = Path::new("/opt/it's here/mdi");
        assert_eq!(
            unix_shim(path),
            "#!/bin/sh\nexec '/opt/it'\\''s here/mdi' \"$@\"\n"
        );
        assert_eq!(
            windows_shim(Path::new(r"C:\100%\mdi.exe")),
            "@echo off\r\n\"C:\\100%%\\mdi.exe\" %*\r\nexit /b %ERRORLEVEL%\r\n"
        );
    }
}
