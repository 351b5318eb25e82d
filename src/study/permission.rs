//! Permission for a study or a sweep plan to start external programs.
//!
//! A study can name any program, and a study may come from anybody. A program is started only if the user has allowed it before, or if the same
//! user created the study with `admire new`. Permissions are stored as hashes of commands and folders in the user's configuration. The command
//! line of ADAMS needs no permission: `mdi` from the PATH, or the `mdi` of this installation.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::Study;
use crate::digest;
use crate::settings::BackendChoice;
use admire_session::own_program;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

/// Path of the permissions file, relative to the user's configuration folder. Each line of the file holds a hash, and the command or folder
/// that was hashed.
const FILE: &str = "admire/allowed";

/// Name of the program that is the command line of ADAMS.
const SOLVER: &str = "mdi";
/// Arguments of `mdi` with which it does nothing but run the command file.
const ARGUMENTS: [&str; 8] = [
    "-c",
    "ru-standard",
    "ru-solver",
    "ru-s",
    "i",
    "b",
    "{acf}",
    "exit",
];

/// An external program that a study or a sweep plan names.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NamedProgram {
    /// Path of the file that names the program.
    file: PathBuf,
    /// Program and its arguments.
    words: Vec<String>,
}

impl NamedProgram {
    /// Returns the program that a study starts for every equilibrium. Returns `None` if the study starts no program, or only the command line
    /// of ADAMS.
    pub fn of_study(study: &Study) -> Option<Self> {
        let starts = study.solver.backend == BackendChoice::Command;
        let file = study.folder.join("study.toml");
        starts.then(|| Self::named_in(&file, &study.solver.command))?
    }

    /// Returns the program that a file names; `None` if it is the command line of ADAMS.
    pub fn named_in(file: &Path, words: &[String]) -> Option<Self> {
        let words = beside(&folder_of(file), words);
        (!is_solver(&words)).then(|| Self {
            file: file.to_path_buf(),
            words,
        })
    }

    /// Returns true if the user has allowed the program or has created the study.
    pub fn is_allowed(&self) -> bool {
        let known = remembered();
        let is_known = |hash: &str| known.lines().any(|line| line.starts_with(hash));
        let own = folder_of(&self.file).canonicalize();
        is_known(&self.hash()) || own.is_ok_and(|folder| is_known(&hash_of_folder(&folder)))
    }

    /// Stores the user's permission for the program.
    ///
    /// # Errors
    /// Fails if the user's configuration cannot be written.
    pub fn allow(&self) -> io::Result<()> {
        remember(&self.hash(), &self.shown())
    }

    /// Returns the diagnostic for a program without permission. `help` explains how to allow the program.
    pub fn refusal(&self, help: &str) -> Diagnostic {
        let message = format!(
            "{} names a program that has not been allowed: {}",
            self.file.display(),
            self.shown()
        );
        Diagnostic::error(Code::RunsProgram, message).help(help.to_string())
    }

    /// Returns the question that asks the user for permission. It contains the full command.
    pub fn question(&self) -> String {
        format!(
            "{} names a program that is started for every run:\n  {}\nallow it, now and in future? [no] ",
            self.file.display(),
            self.shown()
        )
    }

    /// Formats the command as one line. Words that contain blanks are quoted.
    fn shown(&self) -> String {
        let quoted = |word: &String| {
            if word.contains(char::is_whitespace) {
                format!("'{word}'")
            } else {
                word.clone()
            }
        };
        let words: Vec<String> = self.words.iter().map(quoted).collect();
        words.join(" ")
    }

    /// Returns a hash of the command and of the contents of every file that it names inside the study folder.
    fn hash(&self) -> String {
        let folder = folder_of(&self.file).canonicalize().ok();
        let own = |word: &String| {
            let path = Path::new(word).canonicalize().ok()?;
            let came_along = path.starts_with(folder.as_ref()?);
            let source = came_along.then(|| Source::read(&path).ok())??;
            Some(source.bytes().to_vec())
        };
        let mut parts = vec![b"command".to_vec()];
        for word in &self.words {
            parts.push(word.as_bytes().to_vec());
            parts.push(own(word).unwrap_or_default());
        }
        hash(&parts)
    }
}

/// Returns true if a command is the command line of ADAMS with harmless arguments: `mdi` from the PATH or beside this program, with arguments
/// that only run the command file.
fn is_solver(words: &[String]) -> bool {
    let Some((program, arguments)) = words.split_first() else {
        return false;
    };
    let beside = || {
        let own = own_program().ok()?;
        let own = own.with_file_name(format!("{SOLVER}{}", std::env::consts::EXE_SUFFIX));
        Some(own.canonicalize().ok()? == Path::new(program).canonicalize().ok()?)
    };
    let known = |word: &String| ARGUMENTS.contains(&word.as_str());
    arguments.iter().all(known) && (program == SOLVER || beside().unwrap_or(false))
}

/// Returns the command with the path of its program made absolute, so it works from any working directory. A relative path refers to `folder`,
/// the folder of the file that names the program. A program name without a path is unchanged.
pub fn beside(folder: &Path, words: &[String]) -> Vec<String> {
    let mut words = words.to_vec();
    if let Some(program) = words.first_mut()
        && Path::new(program.as_str()).components().count() > 1
    {
        let beside = folder.join(program.as_str());
        let beside = std::path::absolute(&beside).unwrap_or(beside);
        *program = beside.display().to_string();
    }
    words
}

/// Stores that the user created the study in this folder, so its programs may be started.
///
/// # Errors
/// Fails if the folder does not exist, or if the user's configuration cannot be written.
pub fn trust_study(folder: &Path) -> io::Result<()> {
    let folder = folder.canonicalize()?;
    remember(&hash_of_folder(&folder), &folder.display().to_string())
}

fn hash_of_folder(folder: &Path) -> String {
    let name = folder.as_os_str().as_encoded_bytes();
    hash(&[b"study".to_vec(), name.to_vec()])
}

/// Returns a hash of several parts. The hash also depends on the boundaries between the parts.
fn hash(parts: &[Vec<u8>]) -> String {
    digest(parts.iter().map(Vec::as_slice))
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Returns the path of the permissions file in the system's folder for user settings; `None` if there is no such folder.
fn file() -> Option<PathBuf> {
    let folder = |name: &str| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    let settings = if cfg!(windows) {
        folder("APPDATA")
    } else {
        let usual = if cfg!(target_os = "macos") {
            "Library/Application Support"
        } else {
            ".config"
        };
        folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(usual)))
    };
    Some(settings?.join(FILE))
}

fn remembered() -> String {
    let read = file().and_then(|file| Source::read(&file).ok());
    read.map_or_else(String::new, |source| {
        String::from_utf8_lossy(source.bytes()).into_owned()
    })
}

fn remember(hash: &str, what: &str) -> io::Result<()> {
    if remembered().lines().any(|line| line.starts_with(hash)) {
        return Ok(());
    }
    let file = file().ok_or_else(|| {
        io::Error::other(
            "no folder for settings is known: set XDG_CONFIG_HOME or HOME (on Windows APPDATA)",
        )
    })?;
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut options = std::fs::File::options();
    let what = what.replace(char::is_control, " ");
    // Each line is written by a single call, so the lines of two processes do not mix.
    let line = format!("{hash}  {what}\n");
    options
        .create(true)
        .append(true)
        .open(&file)?
        .write_all(line.as_bytes())
}
