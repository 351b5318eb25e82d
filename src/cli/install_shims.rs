use std::path::{Path, PathBuf};

use admire_session::own_program;
use admire_syntax::diagnostic::{Code, Diagnostic};

use crate::front::permissions::make_executable;

use super::Outcome;
use super::shell::{Exit, Shell};

/// Put commands with the names of ADAMS' own commands into a folder; each runs this installation's `mdi`.
///
/// If the folder is first on the PATH, a script written for ADAMS runs on admire.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Folder for the commands; it is created if missing.
    directory: PathBuf,
    /// Names of the commands; by default, `mdi`, `MDI`, and the launchers of the ADAMS releases of ten years, `adams2016` to `adams2025_1`.
    #[arg(long, value_delimiter = ',', default_values_t = default_names(), hide_default_value = true)]
    names: Vec<String>,
    /// Replace existing files with these names.
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = "Examples:
  admire install-shims ~/bin/adams
  admire install-shims C:\\adams --names mdi,adams2023_4";

/// Versions in the launcher names of the releases of the last ten years.
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

/// Writes a batch file for each name, and on Unix also a shell script.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let folder = &arguments.directory;
    let cannot = |path: &Path, error: &std::io::Error| {
        Diagnostic::error(
            Code::CannotWrite,
            format!("`{}` cannot be written: {error}", path.display()),
        )
    };
    let mdi = own_program()
        .and_then(dunce::canonicalize)
        .map(|admire| admire.with_file_name(format!("mdi{}", std::env::consts::EXE_SUFFIX)))
        .map_err(|error| shell.fail(cannot(folder, &error)))?;
    if !mdi.is_file() {
        let message = format!(
            "`{}` does not exist, so the commands could not start the solver",
            mdi.display()
        );
        return Err(shell.fail(Diagnostic::error(Code::CannotRead, message).help(
            "`cargo install --locked --path .` installs admire and mdi together; `cargo build --release` builds both",
        )));
    }
    let whole = std::fs::create_dir_all(folder)
        .and_then(|()| dunce::canonicalize(folder))
        .map_err(|error| shell.fail(cannot(folder, &error)))?;
    let plain = |name: &String| {
        !name.is_empty()
            && name
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
    };
    for name in &arguments.names {
        if !plain(name) {
            return Err(shell.usage(
                Diagnostic::error(
                    Code::CannotWrite,
                    format!("`{name}` cannot be the name of a command"),
                )
                .help("use letters, digits, `_`, `-` and `.` only"),
            ));
        }
        let mut files = vec![(format!("{name}.bat"), windows_shim(&mdi, &whole))];
        if cfg!(unix) {
            files.insert(0, (name.clone(), unix_shim(&mdi)));
        }
        for (file, text) in files {
            let path = folder.join(file);
            if path.exists()
                && !arguments.force
                && std::fs::read(&path).ok() != Some(text.clone().into_bytes())
            {
                return Err(shell.usage(
                    Diagnostic::error(
                        Code::CannotWrite,
                        format!("`{}` already exists", path.display()),
                    )
                    .help("--force replaces the file"),
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

fn windows_shim(mdi: &Path, folder: &Path) -> String {
    let ends = "%*\r\nexit /b %ERRORLEVEL%\r\n";
    // A single `%` would begin the name of a variable.
    let quoted = |path: &str| path.replace('%', "%%");
    let whole = quoted(&mdi.to_string_lossy());
    if whole.is_ascii() {
        return format!("@echo off\r\n\"{whole}\" {ends}");
    }
    // A batch file is read in the console's code page, whose encoding of non-ASCII letters may differ. `%~dp0` is the folder of the batch
    // file itself.
    if let Some(steps) = steps(folder, mdi).filter(|steps| steps.is_ascii()) {
        return format!("@echo off\r\n\"%~dp0{}\" {ends}", quoted(&steps));
    }
    // The program itself runs in the code page that was set before.
    format!(
        "@echo off\r\nsetlocal\r\n\
        for /f \"tokens=2 delims=:.\" %%p in ('chcp') do set \"page=%%p\"\r\n\
        chcp 65001 >nul\r\nset \"mdi={whole}\"\r\nchcp %page% >nul\r\n\"%mdi%\" {ends}"
    )
}

/// Returns the relative path from a folder to a file, both absolute; `None` if they are on different drives.
fn steps(folder: &Path, file: &Path) -> Option<String> {
    let (from, to): (Vec<_>, Vec<_>) = (folder.components().collect(), file.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let names = to[common..]
        .iter()
        .map(|part| part.as_os_str().to_string_lossy());
    let up = std::iter::repeat_n("..".into(), from.len() - common);
    (common > 0).then(|| up.chain(names).collect::<Vec<_>>().join("\\"))
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
            windows_shim(Path::new(r"C:\100%\mdi.exe"), Path::new(r"C:\bin")),
            "@echo off\r\n\"C:\\100%%\\mdi.exe\" %*\r\nexit /b %ERRORLEVEL%\r\n"
        );
        // A non-ASCII path is replaced by a relative path if possible; otherwise the batch file switches the code page.
        let mdi = Path::new("/users/j\u{fc}rgen/.cargo/bin/mdi.exe");
        let near = windows_shim(mdi, Path::new("/users/j\u{fc}rgen/bin"));
        assert!(
            near.contains("\r\n\"%~dp0..\\.cargo\\bin\\mdi.exe\" %*\r\n"),
            "{near}"
        );
        let far = windows_shim(mdi, Path::new("/bin"));
        assert!(
            far.contains("chcp 65001") && far.contains("\"%mdi%\" %*"),
            "{far}"
        );
    }
}
