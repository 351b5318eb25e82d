//! Folder of a sweep: its contents, and the checks before it is used.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use admire_study::leftover;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

use super::plan::SweepPlan;
use super::shard::Shard;

/// Identity of a sweep folder, stored in `sweep.json`.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// Fixed text that distinguishes `sweep.json` from files of other programs.
    pub written_by: String,
    /// Version of the program.
    pub version: String,
    /// SHA-256 over all inputs.
    pub inputs_sha256: String,
    /// SHA-256 of the bytes of each input, keyed by file name.
    pub inputs: BTreeMap<String, String>,
    /// Number of cases.
    pub cases: u64,
    /// Number of shards.
    pub shards: u64,
    /// Names of the varied parameters.
    pub vary: Vec<String>,
    /// Kind of plan.
    pub plan: String,
}

const WRITER: &str = "admire sweep";
const MANIFEST: &str = "sweep.json";
const SHARDS: &str = "shards";

/// Names of the files and folders that a sweep writes into its folder, apart from the files of its shards.
pub(crate) const ANSWERS: [&str; 4] = ["results.parquet", "summary.json", "report.html", "slurm"];

impl Manifest {
    /// Creates the manifest for a plan.
    pub fn of(plan: &SweepPlan, shards: u64, version: &str) -> Self {
        let name = |source: &Source| {
            let path = Path::new(source.name());
            path.file_name().map_or_else(
                || source.name().to_string(),
                |n| n.to_string_lossy().into_owned(),
            )
        };
        let mut all = Sha256::new();
        let mut inputs = BTreeMap::new();
        for source in &plan.inputs {
            let digest = Sha256::digest(source.bytes());
            all.update(digest);
            // Files of the same name from different folders are distinguished by an appended `+`.
            let mut key = name(source);
            while inputs.contains_key(&key) {
                key.push('+');
            }
            inputs.insert(key, hexadecimal(&digest));
        }
        Self {
            written_by: WRITER.to_string(),
            version: version.to_string(),
            inputs_sha256: hexadecimal(&all.finalize()),
            inputs,
            cases: plan.cases(),
            shards,
            vary: plan.variations.iter().map(|v| v.name.clone()).collect(),
            plan: plan.design.plan.word().to_string(),
        }
    }

    /// Returns the key that identifies the journals of a shard.
    pub(crate) fn key(&self, shard: Shard) -> Vec<u8> {
        format!(
            "{}\n{}\n{}\n{shard}",
            self.version, self.inputs_sha256, self.cases
        )
        .into_bytes()
    }
}

pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in bytes {
        _ = write!(text, "{byte:02x}");
    }
    text
}

/// Folder of a sweep.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SweepFolder {
    /// Path of the folder.
    pub path: PathBuf,
    /// Manifest of the sweep.
    pub manifest: Manifest,
}

impl SweepFolder {
    /// Checks that a folder can be used for a sweep, without writing anything.
    ///
    /// # Errors
    /// A diagnostic for a folder of another sweep, a folder with foreign files, or a folder that cannot be written.
    pub fn look(path: &Path, manifest: Manifest) -> Result<Self, Diagnostic> {
        let folder = Self {
            path: path.to_path_buf(),
            manifest,
        };
        folder.refuse_strangers()?;
        if let Some(there) = read_manifest(path)? {
            folder.refuse_other(&there)?;
        }
        folder.refuse_unwritable()?;
        Ok(folder)
    }

    /// Checks that the folder is writable, by creating an anonymous temporary file there or in its nearest existing parent.
    fn refuse_unwritable(&self) -> Result<(), Diagnostic> {
        let shards = self.path.join(SHARDS);
        let mut there = shards.ancestors().filter(|above| above.exists());
        let there = there.next().unwrap_or(Path::new("."));
        match tempfile::tempfile_in(there) {
            Ok(_) => Ok(()),
            Err(error) => {
                let message = format!("nothing can be written into `{}`: {error}", there.display());
                Err(Diagnostic::error(Code::CannotWrite, message))
            }
        }
    }

    /// Creates the folder of a sweep, or opens it again if it belongs to the same sweep.
    ///
    /// # Errors
    /// A diagnostic for a folder of another sweep, a folder with foreign files, or a folder that cannot be written.
    pub fn begin(path: &Path, manifest: Manifest) -> Result<Self, Diagnostic> {
        let io = |error: std::io::Error| {
            Diagnostic::error(
                Code::CannotWrite,
                format!("`{}` cannot be written: {error}", path.display()),
            )
        };
        let folder = Self::look(path, manifest)?;
        std::fs::create_dir_all(path.join(SHARDS)).map_err(io)?;
        if let Some(there) = read_manifest(path)? {
            folder.refuse_other(&there)?;
        } else {
            let text =
                serde_json::to_string_pretty(&folder.manifest).expect("names and digits print");
            // Shards that start at the same time write identical files.
            let new = tempfile::Builder::new()
                .prefix(".sweep-")
                .tempfile_in(path)
                .map_err(io)?;
            std::fs::write(new.path(), text + "\n").map_err(io)?;
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                let all = std::fs::Permissions::from_mode(0o644);
                std::fs::set_permissions(new.path(), all).map_err(io)?;
            }
            new.persist(path.join(MANIFEST))
                .map_err(|failed| io(failed.error))?;
        }
        Ok(folder)
    }

    /// Opens the folder of a sweep that has already been created.
    ///
    /// # Errors
    /// A diagnostic for a folder without a manifest, or with foreign files.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        let Some(manifest) = read_manifest(path)? else {
            let message = format!(
                "`{}` is not a folder of a sweep: it has no {MANIFEST}",
                path.display()
            );
            return Err(Diagnostic::error(Code::CannotRead, message)
                .help("`admire sweep SWEEP.toml --out DIR` creates one"));
        };
        let folder = Self {
            path: path.to_path_buf(),
            manifest,
        };
        folder.refuse_strangers()?;
        Ok(folder)
    }

    fn refuse_other(&self, there: &Manifest) -> Result<(), Diagnostic> {
        let own = &self.manifest;
        let refuse = |what: String, help: &str| {
            let message = format!("`{}` {what}", self.path.display());
            Err(Diagnostic::error(Code::CannotWrite, message).help(help.to_string()))
        };
        if there.inputs_sha256 != own.inputs_sha256 {
            let changed: Vec<&str> = own
                .inputs
                .iter()
                .filter(|(name, digest)| there.inputs.get(*name) != Some(digest))
                .map(|(name, _)| name.as_str())
                .collect();
            let what = format!(
                "holds cases of other inputs: {}",
                if changed.is_empty() {
                    "other files".to_string()
                } else {
                    format!("{} changed since then", changed.join(", "))
                }
            );
            return refuse(what, "name another folder for the changed sweep");
        }
        if there.version != own.version {
            let what = format!(
                "holds cases of admire {}, but this is admire {}",
                there.version, own.version
            );
            return refuse(
                what,
                "cases of two versions are not mixed: name another folder, or continue with the other version",
            );
        }
        if there.shards != own.shards {
            let what = format!(
                "is divided into {} shards, not {}",
                there.shards, own.shards
            );
            let help = format!(
                "continue with --shard I/{}, or name another folder",
                there.shards
            );
            return refuse(what, &help);
        }
        Ok(())
    }

    /// Refuses a folder with files that no sweep writes.
    fn refuse_strangers(&self) -> Result<(), Diagnostic> {
        let mut strangers = Vec::new();
        let io = |error: std::io::Error| {
            let message = format!("`{}` cannot be read: {error}", self.path.display());
            Diagnostic::error(Code::CannotRead, message)
        };
        let mut look = |folder: &Path, known: &dyn Fn(&str) -> bool| -> Result<(), Diagnostic> {
            if !folder.exists() {
                return Ok(());
            }
            for entry in std::fs::read_dir(folder).map_err(io)? {
                let entry = entry.map_err(io)?;
                if !known(&entry.file_name().to_string_lossy()) {
                    strangers.push(format!("`{}`", entry.path().display()));
                }
            }
            Ok(())
        };
        look(&self.path, &|name| {
            let plain = name.strip_suffix(".tmp").unwrap_or(name);
            name == MANIFEST
                || name == SHARDS
                || name.starts_with(".sweep-")
                // The file was left by a run that was killed while it wrote a result. The next run that writes removes the file.
                || leftover::is_ours(name)
                || ANSWERS.contains(&plain)
        })?;
        look(&self.path.join(SHARDS), &|name| {
            let stem = name.split('.').next().unwrap_or(name);
            let rest = &name[stem.len()..];
            Shard::of_stem(stem).is_some()
                && [".journal", ".parquet", ".parquet.tmp"].contains(&rest)
        })?;
        if strangers.is_empty() {
            return Ok(());
        }
        strangers.sort();
        let message = format!(
            "`{}` holds files that no sweep has written: {}",
            self.path.display(),
            strangers.join(", ")
        );
        Err(Diagnostic::error(Code::CannotWrite, message)
            .help("give the sweep a folder of its own"))
    }

    /// Returns the path of a shard's journal.
    pub(crate) fn journal(&self, shard: Shard) -> PathBuf {
        self.path
            .join(SHARDS)
            .join(format!("{}.journal", shard.stem()))
    }

    /// Returns the path of a shard's finished part file.
    pub fn part(&self, shard: Shard) -> PathBuf {
        self.path
            .join(SHARDS)
            .join(format!("{}.parquet", shard.stem()))
    }

    /// Returns the path of the complete table of results.
    pub fn results(&self) -> PathBuf {
        self.path.join(ANSWERS[0])
    }

    /// Iterates over all shards of the sweep.
    pub fn shards(&self) -> impl Iterator<Item = Shard> + use<> {
        let of = self.manifest.shards;
        (1..=of).map(move |number| Shard { number, of })
    }
}

fn read_manifest(path: &Path) -> Result<Option<Manifest>, Diagnostic> {
    let file = path.join(MANIFEST);
    let bytes = match std::fs::read(&file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => {
            let message = format!("`{}` cannot be read: {error}", file.display());
            return Err(Diagnostic::error(Code::CannotRead, message));
        }
    };
    let manifest = serde_json::from_slice::<Manifest>(&bytes).ok();
    if let Some(manifest) = manifest.filter(|manifest| manifest.written_by == WRITER) {
        return Ok(Some(manifest));
    }
    let message = format!("`{}` was not written by a sweep", file.display());
    Err(Diagnostic::error(Code::CannotRead, message).help("give the sweep a folder of its own"))
}
