//! Which programs a study or a sweep may start.
//!
//! A study can name any program, and a study may come from anybody. A program is started only where the user has allowed it once (a hash of
//! the command is remembered in the configuration of the user), or where the study was begun by `admire new` of the same user. ADAMS' own
//! command line (`mdi` of the PATH, or the one of this installation) is the user's program and needs no permission.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::Study;
use crate::digest;
use crate::settings::BackendChoice;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

/// Where permissions are remembered, below the folder for settings of programs: a line each, a hash and what it stands for.
const FILE: &str = "admire/allowed";

/// ADAMS' command line, and its words.
const SOLVER: &str = "mdi";
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

/// A program that a study or a sweep names.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NamedProgram {
    /// The file that names it.
    file: PathBuf,
    /// Program and arguments.
    words: Vec<String>,
}

impl NamedProgram {
    /// The program that a study starts for every equilibrium; `None` if it starts none, or ADAMS' own.
    pub fn of_study(study: &Study) -> Option<Self> {
        let starts = study.solver.backend == BackendChoice::Command;
        let file = study.folder.join("study.toml");
        starts.then(|| Self::named_in(&file, &study.solver.command))?
    }

    /// The program that a file names; `None` if it is ADAMS' own.
    pub fn named_in(file: &Path, words: &[String]) -> Option<Self> {
        let words = beside(&folder_of(file), words);
        (!is_solver(&words)).then(|| Self {
            file: file.to_path_buf(),
            words,
        })
    }

    /// True if it may be started: the user has allowed it, or has begun the study.
    pub fn is_allowed(&self) -> bool {
        let known = remembered();
        let is_known = |hash: &str| known.lines().any(|line| line.starts_with(hash));
        let own = folder_of(&self.file).canonicalize();
        is_known(&self.hash()) || own.is_ok_and(|folder| is_known(&hash_of_folder(&folder)))
    }

    /// Remembers that the user allows it.
    ///
    /// # Errors
    /// When the configuration of the user cannot be written.
    pub fn allow(&self) -> io::Result<()> {
        remember(&self.hash(), &self.shown())
    }

    /// Why it is not started; `help` says how it is allowed.
    pub fn refusal(&self, help: &str) -> Diagnostic {
        let message = format!(
            "{} names a program that was not allowed yet: {}",
            self.file.display(),
            self.shown()
        );
        Diagnostic::error(Code::RunsProgram, message).help(help.to_string())
    }

    /// What is asked of a person.
    pub fn question(&self) -> String {
        format!(
            "{} names a program that is started for every run:\n  {}\nstart it, now and later? [no] ",
            self.file.display(),
            self.shown()
        )
    }

    /// The command as a line; words with blanks have quotes.
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

    /// Hash of the command, and of every file among its words that came with the study.
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

/// True for ADAMS' command line: `mdi`, wherever the PATH finds it, or the one beside this program, and words that only say to execute the
/// command file of the run.
fn is_solver(words: &[String]) -> bool {
    let Some((program, arguments)) = words.split_first() else {
        return false;
    };
    let beside = || {
        let own = std::env::current_exe().ok()?;
        let own = own.with_file_name(format!("{SOLVER}{}", std::env::consts::EXE_SUFFIX));
        Some(own.canonicalize().ok()? == Path::new(program).canonicalize().ok()?)
    };
    let known = |word: &String| ARGUMENTS.contains(&word.as_str());
    arguments.iter().all(known) && (program == SOLVER || beside().unwrap_or(false))
}

/// A command with its program as it is called from anywhere: one with a path lies beside the file that names it.
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

/// Remembers that the user has begun the study in a folder.
///
/// # Errors
/// When there is no such folder, or the configuration of the user cannot be written.
pub fn trust_study(folder: &Path) -> io::Result<()> {
    let folder = folder.canonicalize()?;
    remember(&hash_of_folder(&folder), &folder.display().to_string())
}

fn hash_of_folder(folder: &Path) -> String {
    let name = folder.as_os_str().as_encoded_bytes();
    hash(&[b"study".to_vec(), name.to_vec()])
}

/// A hash that tells the parts apart.
fn hash(parts: &[Vec<u8>]) -> String {
    digest(parts.iter().map(Vec::as_slice))
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// The file of permissions, in the folder that the system has for settings of a user.
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
    let file = file().ok_or_else(|| io::Error::other("there is no folder for settings"))?;
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut options = std::fs::File::options();
    let what = what.replace(char::is_control, " ");
    // One write: lines of two processes do not mix.
    let line = format!("{hash}  {what}\n");
    options
        .create(true)
        .append(true)
        .open(&file)?
        .write_all(line.as_bytes())
}
