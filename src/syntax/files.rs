//! File names that occur in a dataset, and a collection of the files that were read.

use std::collections::BTreeMap;

use super::{Dataset, Value};
use crate::grammar::ValueKind;
use crate::text::{Source, Span};

/// An occurrence of a file name in a dataset.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FileReference {
    /// File name as written, without quotes.
    pub name: String,
    /// Location of the name.
    pub span: Span,
    /// True if the statement is incomplete without the file, as for a FILE argument; false if a STRING text only looks like a file name.
    pub needed: bool,
}

/// File name extensions of Adams/Car property files and of road and tyre files. A STRING text with such an extension counts as a file name.
const ENDINGS: [&str; 8] = ["bus", "spr", "bum", "reb", "dpr", "tir", "rdf", "xml"];

/// Returns all file names in a dataset: FILE arguments, and STRING texts with the extension of a property file.
///
/// Adams/Car passes the texts of such STRING statements to its subroutines.
pub fn references(dataset: &Dataset) -> Vec<FileReference> {
    let mut found = Vec::new();
    for statement in dataset.statements() {
        for argument in &statement.arguments {
            let Value::Texts(spans) = &argument.value else {
                continue;
            };
            let needed = argument.def.is_some_and(|def| def.kind == ValueKind::File);
            if !needed && statement.kind() != Some("STRING") {
                continue;
            }
            for span in spans {
                let name = dataset.source().text(*span).trim().to_string();
                let ending = name.rsplit_once('.').map(|(_, ending)| ending);
                let looks = ending.is_some_and(|ending| {
                    ENDINGS
                        .iter()
                        .any(|known| ending.eq_ignore_ascii_case(known))
                });
                if !name.is_empty() && (needed || looks) {
                    found.push(FileReference {
                        name,
                        span: *span,
                        needed,
                    });
                }
            }
        }
    }
    found
}

/// Contents of files; the key of each file is its name as written in a dataset.
#[derive(Clone, Debug, Default)]
pub struct Files(BTreeMap<String, Source>);

impl Files {
    /// Adds a file; `name` is its name as written in a dataset.
    pub fn add(&mut self, name: impl Into<String>, source: Source) {
        self.0.insert(name.into(), source);
    }

    /// Returns the file with this name, which is given as written in a dataset.
    pub fn get(&self, name: &str) -> Option<&Source> {
        self.0.get(name.trim())
    }

    /// Iterates over all files.
    pub fn sources(&self) -> impl Iterator<Item = &Source> {
        self.0.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_arguments_and_strings_that_end_like_property_files() {
        let text = "t\nSTRING/1, STRING=mdids://acar/bushings.tbl/a.bus\nSTRING/2, STRING=Hello. World\nSPLINE/3, FILE=\"b.spr\", BLOCK=CURVE\nEND\n";
        let dataset = Dataset::parse(Source::new("a.adm", text.as_bytes())).value;
        let found: Vec<_> = references(&dataset)
            .into_iter()
            .map(|file| (file.name, file.needed))
            .collect();
        assert_eq!(
            found,
            [
                ("mdids://acar/bushings.tbl/a.bus".to_string(), false),
                ("b.spr".to_string(), true)
            ]
        );
    }
}
