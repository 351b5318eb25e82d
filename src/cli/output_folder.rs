//! Output folder of a command. Files written by an earlier run are replaced; other files are replaced only with `--force`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::front::car_files::{FOLDER, possible_names};
use admire_identify::LoadedStudy;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::shell::{Exit, Shell};

/// Name of the file that lists the files written into a folder by earlier runs.
const MANIFEST: &str = "admire-outputs.json";

/// Option that allows replacing files that no earlier run wrote.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Replacing {
    /// Replace output files even if no earlier run wrote them, or if they were changed since.
    #[arg(long)]
    pub(super) force: bool,
}

/// The same option for a command that fits a study.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Forced {
    /// Replace output files even if no earlier run wrote them, or if they were changed since. Also fit an implausible study.
    #[arg(long)]
    pub(super) force: bool,
}

impl Forced {
    /// Returns the part of the option that concerns files.
    pub(super) fn replacing(self) -> Replacing {
        Replacing { force: self.force }
    }
}

/// Returns the folder of a file; the working directory for a bare name.
pub(super) fn folder_beside(file: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).to_path_buf()
}

/// Returns the output folder of a command: the named folder, or else `out-COMMAND` in the folder `beside`.
pub(super) fn output_folder(named: Option<&Path>, beside: &Path, command: &str) -> PathBuf {
    named.map_or_else(|| beside.join(format!("out-{command}")), Path::to_path_buf)
}

/// Contents of `admire-outputs.json`: each output file with the SHA-256 of its bytes when it was written.
#[derive(Default, Serialize, Deserialize)]
struct Manifest {
    /// Fixed text that distinguishes this file from files of other programs.
    written_by: String,
    files: BTreeMap<String, String>,
    /// Files of a run that is in progress, or of a run that ended before all its files were written.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    begun: BTreeMap<String, String>,
}

const WRITER: &str = "admire";

impl Manifest {
    fn read(folder: &Path) -> Self {
        std::fs::read(folder.join(MANIFEST))
            .ok()
            .and_then(|bytes| serde_json::from_slice::<Self>(&bytes).ok())
            .filter(|manifest| manifest.written_by == WRITER)
            .unwrap_or_default()
    }

    /// Returns true if a file may be replaced without `--force`: it does not exist, it already contains the bytes `new`, or it is unchanged
    /// since a run wrote it.
    fn may_replace(&self, folder: &Path, name: &Path, new: Option<&[u8]>) -> bool {
        let path = folder.join(name);
        if path.symlink_metadata().is_err() {
            return true;
        }
        let Ok(there) = std::fs::read(&path) else {
            return false;
        };
        let (name, sum) = (key(name), sha256(&there));
        let ours = [&self.files, &self.begun].map(|files| files.get(&name) == Some(&sum));
        new == Some(there.as_slice()) || ours.contains(&true)
    }
}

/// Returns the name of a file as written in the manifest, with `/` as separator on all systems.
fn key(name: &Path) -> String {
    let parts: Vec<String> = name
        .components()
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    parts.join("/")
}

fn sha256(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in Sha256::digest(bytes) {
        write!(text, "{byte:02x}").expect("writing to a string");
    }
    text
}

/// Refuses to start a computation if [`write_folder`] would refuse its outputs, because they would replace the user's files.
pub(super) fn refuse_replacing(
    folder: &Path,
    names: &[&str],
    replacing: Replacing,
    shell: &Shell,
) -> Result<(), Exit> {
    let manifest = Manifest::read(folder);
    let taken = names
        .iter()
        .map(Path::new)
        .filter(|name| !manifest.may_replace(folder, name, None))
        .map(|name| folder.join(name))
        .collect();
    refuse(taken, replacing, shell)
}

/// Refuses to start a computation if its files for Adams/Car would replace the user's files.
pub(super) fn refuse_car_files(
    loaded: &LoadedStudy,
    folder: &Path,
    replacing: Replacing,
    shell: &Shell,
) -> Result<(), Exit> {
    let names = possible_names(loaded);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    refuse_replacing(folder, &names, replacing, shell)
}

/// Returns the folder of the files for Adams/Car among the files of a result; `None` if there are none.
pub(super) fn folder_for_car(folder: &Path, files: &[(PathBuf, Vec<u8>)]) -> Option<PathBuf> {
    let inside = |(name, _): &(PathBuf, Vec<u8>)| name.starts_with(FOLDER);
    files.iter().any(inside).then(|| folder.join(FOLDER))
}

/// Writes files into a folder, each atomically, and lists them in the folder's manifest. Files of the user are replaced only with
/// `--force`, and the replaced files are then reported.
pub(super) fn write_folder(
    folder: &Path,
    files: &[(PathBuf, Vec<u8>)],
    replacing: Replacing,
    shell: &Shell,
) -> Result<(), Exit> {
    let mut manifest = Manifest::read(folder);
    let mut taken: Vec<PathBuf> = files
        .iter()
        .filter(|(name, bytes)| !manifest.may_replace(folder, name, Some(bytes)))
        .map(|(name, _)| folder.join(name))
        .collect();
    let list = folder.join(MANIFEST);
    if manifest.written_by.is_empty() && list.symlink_metadata().is_ok() {
        taken.push(list.clone());
    }
    refuse(taken, replacing, shell)?;
    manifest.written_by = WRITER.to_string();
    let made = |folder: &Path| {
        std::fs::create_dir_all(folder).map_err(|error| {
            let message = format!(
                "the folder `{}` cannot be created: {error}",
                folder.display()
            );
            shell.fail(Diagnostic::error(Code::CannotWrite, message))
        })
    };
    let listed = |manifest: &Manifest| {
        let text = serde_json::to_string_pretty(manifest).expect("names and digits print");
        shell.write(&list, (text + "\n").as_bytes())
    };
    // The list is written before the files, so that the next run may replace the files of an interrupted run.
    let sums = files.iter().map(|(name, bytes)| (key(name), sha256(bytes)));
    manifest.begun = sums.collect();
    made(folder)?;
    listed(&manifest)?;
    for (name, bytes) in files {
        let path = folder.join(name);
        made(path.parent().unwrap_or(folder))?;
        shell.write(&path, bytes)?;
    }
    let done = std::mem::take(&mut manifest.begun);
    manifest.files.extend(done);
    listed(&manifest)
}

/// Refuses to replace the files in `taken`. With `--force`, reports their names and accepts.
fn refuse(taken: Vec<PathBuf>, replacing: Replacing, shell: &Shell) -> Result<(), Exit> {
    if taken.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = taken
        .iter()
        .map(|path| format!("`{}`", path.display()))
        .collect();
    let names = names.join(", ");
    if replacing.force {
        shell.complain(&[Diagnostic::note(
            Code::CannotWrite,
            format!("replaced because of --force: {names}"),
        )]);
        return Ok(());
    }
    Err(shell.fail(
        Diagnostic::error(
            Code::CannotWrite,
            format!("nothing is written, because these files are not the unchanged output of an earlier run: {names}"),
        )
        .help("name another folder, or replace the files with --force"),
    ))
}
