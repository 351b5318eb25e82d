use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::{FileReference, Files, references};
use admire_syntax::grammar::Solved;
use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Source, read_at_most};

use super::file_policy::FilePolicy;
use super::paths::find_file;

/// Size in bytes of the largest file that is read. The limit is needed because a command file may name any file.
pub(super) const LARGEST: u64 = 1 << 30;

/// Size in bytes of the largest file that is read as a property file.
const MOST_BYTES: u64 = 64 << 20;

/// Reads the property files that a dataset names by absolute paths or by paths relative to `folder`, if the policy allows it.
///
/// Each missing file is reported once: as a warning if results depend on it, as a note if only graphics or a subroutine would read it.
pub fn read_files(dataset: &Dataset, folder: &Path, policy: &FilePolicy) -> Checked<Files> {
    let mut files = Files::default();
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    let mut missing: BTreeMap<String, usize> = BTreeMap::new();
    for reference in references(dataset) {
        if files.get(&reference.name).is_some() {
            continue;
        }
        let label =
            |diagnostic: Diagnostic| diagnostic.label(dataset.source().name(), reference.span, "");
        let found = find_file(&reference.name, "", &[folder]);
        diagnostics.extend(found.diagnostics.into_iter().map(label));
        let Some(path) = found.value else {
            let here = label(absent(dataset, &reference));
            match missing.get(&reference.name) {
                Some(&told) if diagnostics[told].severity >= here.severity => {}
                Some(&told) => diagnostics[told] = here,
                None => {
                    missing.insert(reference.name.clone(), diagnostics.len());
                    diagnostics.push(here);
                }
            }
            continue;
        };
        if let Err(mut outside) = policy.check_read(&path) {
            // A file that must not be read has the same effect on the results as a missing file.
            outside.severity = Severity::Warning;
            diagnostics.push(label(outside));
            continue;
        }
        match property_file(&path) {
            Ok(Some(source)) => files.add(reference.name.clone(), source),
            Ok(None) => {}
            Err(error) => diagnostics.push(label(Diagnostic::warning(
                Code::CannotRead,
                format!("`{}` cannot be read: {error}", path.display()),
            ))),
        }
    }
    Checked {
        value: files,
        diagnostics,
    }
}

/// Returns the folder of the file from which a source was read; empty if the name of the source has no folder.
pub fn folder_of(source: &Source) -> PathBuf {
    Path::new(source.name())
        .parent()
        .map_or_else(PathBuf::new, Path::to_path_buf)
}

fn property_file(path: &Path) -> std::io::Result<Option<Source>> {
    if std::fs::metadata(path)?.len() > MOST_BYTES {
        return Ok(None);
    }
    let bytes = read_at_most(path, MOST_BYTES)?;
    let is_one = PropertyFile::is_one(&bytes);
    Ok(is_one.then(|| Source::new(path.display().to_string(), bytes)))
}

fn absent(dataset: &Dataset, reference: &FileReference) -> Diagnostic {
    let of_graphics = dataset.statements().iter().any(|statement| {
        statement.span.contains(reference.span)
            && statement
                .def
                .is_some_and(|def| matches!(def.solved, Solved::NoEffect(_)))
    });
    let mut diagnostic = Diagnostic::warning(
        Code::CannotRead,
        format!("the file `{}` does not exist", reference.name),
    );
    if of_graphics || !reference.needed {
        diagnostic.severity = Severity::Note;
    }
    diagnostic.help("its path is relative to the folder of the dataset")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beside_the_deck_are_read_and_missing_ones_are_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let spring = "[MDI_HEADER]\nFILE_TYPE='spr'\n[CURVE]\n{disp force}\n0 0\n1 2\n";
        std::fs::write(folder.path().join("a.spr"), spring).expect("writable");
        let text = "t\nSPLINE/1, FILE=A.SPR\nSPLINE/2, FILE=b.spr\nSTRING/3, STRING=c.bus\nGRAPHICS/4, EXTERNAL, RM=1, FILE=b.spr\n\
            GRAPHICS/5, EXTERNAL, RM=1, FILE=d.xmt_txt\nGRAPHICS/6, EXTERNAL, RM=1, FILE=d.xmt_txt\nEND\n";
        let name = folder.path().join("d.adm").display().to_string();
        let dataset = Dataset::parse(Source::new(name, text.as_bytes())).value;
        let policy = FilePolicy::new(folder.path());
        let read = read_files(&dataset, &folder_of(dataset.source()), &policy);
        assert!(read.value.get("A.SPR").is_some());
        let found: Vec<_> = read
            .diagnostics
            .iter()
            .map(|d| (d.code, d.severity))
            .filter(|(code, _)| *code != Code::FileNameCase)
            .collect();
        assert_eq!(
            found,
            [
                (Code::CannotRead, Severity::Warning),
                (Code::CannotRead, Severity::Note),
                (Code::CannotRead, Severity::Note)
            ]
        );
    }
}
