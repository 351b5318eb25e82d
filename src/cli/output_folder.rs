//! A folder that takes outputs: what an earlier run wrote there is replaced, anything else only with `--force`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use admire_syntax::diagnostic::{Code, Diagnostic};

use super::shell::{Exit, Shell};

/// The list of what runs wrote into a folder, beside the files themselves.
const MANIFEST: &str = "admire-outputs.json";

/// Whether files that no earlier run wrote may be replaced.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Replacing {
    /// Replace files of the output folder that no earlier run wrote there, or that were changed since; fit what is not plausible, too.
    #[arg(long)]
    pub(super) force: bool,
}

/// What `admire-outputs.json` holds: each file with the SHA-256 of its bytes as they were written.
#[derive(Default, Serialize, Deserialize)]
struct Manifest {
    /// Tells the file from one of somebody else.
    written_by: String,
    files: BTreeMap<String, String>,
    /// Those of a run that goes on, or that ended before all of them were there.
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

    /// True if a file may be replaced unasked: it is not there, it holds these bytes already, or it is as a run left it.
    fn gives_up(&self, folder: &Path, name: &Path, new: Option<&[u8]>) -> bool {
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

/// How a file is called in the manifest, on all systems.
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

/// Refuses before the work begins what [`write_folder`] would refuse after it: outputs of these names would replace files of the
/// user's.
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
        .filter(|name| !manifest.gives_up(folder, name, None))
        .map(|name| folder.join(name))
        .collect();
    refuse(taken, replacing, shell)
}

/// Writes files into a folder, each whole or not at all, and lists them in its manifest. Files of the user's are replaced only if
/// that was asked for, and named.
pub(super) fn write_folder(
    folder: &Path,
    files: &[(PathBuf, Vec<u8>)],
    replacing: Replacing,
    shell: &Shell,
) -> Result<(), Exit> {
    let mut manifest = Manifest::read(folder);
    let mut taken: Vec<PathBuf> = files
        .iter()
        .filter(|(name, bytes)| !manifest.gives_up(folder, name, Some(bytes)))
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
            let message = format!("{}: {error}", folder.display());
            shell.fail(Diagnostic::error(Code::CannotWrite, message))
        })
    };
    let listed = |manifest: &Manifest| {
        let text = serde_json::to_string_pretty(manifest).expect("names and digits print");
        shell.write(&list, (text + "\n").as_bytes())
    };
    // Told first: a run that ends half-way leaves files that the next one may replace.
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

/// Gives up if files would be replaced that may not; says which are replaced where that was asked for.
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
            format!("replaced, as --force asks: {names}"),
        )]);
        return Ok(());
    }
    Err(shell.fail(
        Diagnostic::error(
            Code::CannotWrite,
            format!("nothing is written: {names} is there already, and no list of outputs beside it has it as it is"),
        )
        .help("name another folder, or replace it with --force"),
    ))
}
