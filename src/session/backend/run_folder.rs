//! Files of one run of an external program: the user's deck with new parameter values, and a command file that applies the load cases.

use std::path::{Component, Path, PathBuf};

use sha2::Digest;

use super::{Load, SweepRequest};
use crate::{commands_for_other_model, find_file, folder_of, native_spelling};
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::files::references;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset, NewStatement};

/// Base name of all files of a run.
pub(super) const STEM: &str = "run";

/// Input files of a run. They contain every byte that can affect its result.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct RunFiles {
    /// Content of the deck `run.adm`.
    pub deck: Vec<u8>,
    /// Content of the command file `run.acf`.
    pub commands: Vec<u8>,
    /// Relative paths and contents of further files that the deck names and that lie in or below its folder. The run needs copies of them
    /// beside `run.adm`.
    pub beside: Vec<(PathBuf, Vec<u8>)>,
}

/// Largest size in bytes of a file named by the deck that is copied to run folders.
const MOST_BYTES: u64 = 64 << 20;

impl RunFiles {
    /// Creates the input files for a request.
    ///
    /// # Errors
    /// Returns an error if a parameter value cannot be set in the deck.
    pub(crate) fn of(request: &SweepRequest<'_>) -> Result<Self, Box<Diagnostic>> {
        let deck = deck(request)?;
        let commands = commands(request, &deck).into_bytes();
        Ok(Self {
            deck: deck.bytes().to_vec(),
            commands,
            beside: beside(request.dataset),
        })
    }

    /// Creates the input files for a deck with its own command file. Files that the deck names are looked up in the folder of `original`.
    pub(crate) fn of_deck(deck: &Source, commands: &Source, original: &Dataset) -> Self {
        Self {
            deck: with_xrf(Dataset::parse(deck.clone()).value)
                .bytes()
                .to_vec(),
            commands: commands_for_other_model(STEM, commands).bytes().to_vec(),
            beside: beside(original),
        }
    }

    /// Writes the input files to a folder.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub(crate) fn write(&self, folder: &Path) -> std::io::Result<()> {
        for (name, bytes) in &self.beside {
            let path = folder.join(name);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)?;
            }
            std::fs::write(path, bytes)?;
        }
        std::fs::write(folder.join(format!("{STEM}.adm")), &self.deck)?;
        std::fs::write(folder.join(format!("{STEM}.acf")), &self.commands)
    }

    /// Returns true if a folder contains exactly these input files.
    pub(crate) fn are_in(&self, folder: &Path) -> bool {
        let same =
            |name: &Path, bytes: &[u8]| std::fs::read(folder.join(name)).is_ok_and(|b| b == bytes);
        let own = |extension: &str| PathBuf::from(format!("{STEM}.{extension}"));
        same(&own("adm"), &self.deck)
            && same(&own("acf"), &self.commands)
            && self.beside.iter().all(|(name, bytes)| same(name, bytes))
    }

    /// Returns the SHA-256 hash of all input files in hexadecimal, by which a recorded run is found.
    pub(crate) fn key(&self) -> String {
        let mut hash = sha2::Sha256::new();
        let files = self.beside.iter().map(|(_, bytes)| bytes);
        for bytes in [&self.deck, &self.commands].into_iter().chain(files) {
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        }
        let digit = |half: u8| char::from(b"0123456789abcdef"[usize::from(half)]);
        hash.finalize()
            .iter()
            .flat_map(|byte| [digit(byte >> 4), digit(byte & 15)])
            .collect()
    }
}

/// Returns the relative paths and contents of all files that a deck names by relative paths in or below its own folder.
fn beside(dataset: &Dataset) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = folder_of(dataset.source());
    let mut found: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for reference in references(dataset) {
        let name = native_spelling(&reference.name);
        let inside = name.components().all(|c| matches!(c, Component::Normal(_)));
        if !inside || found.iter().any(|(known, _)| *known == name) {
            continue;
        }
        let Some(path) = find_file(&reference.name, "", &[&folder]).value else {
            continue;
        };
        // The real path is checked too, because a symbolic link may lead out of the folder.
        let real = |path: &Path| {
            let path = if path.as_os_str().is_empty() {
                Path::new(".")
            } else {
                path
            };
            path.canonicalize().ok()
        };
        let below = real(&folder)
            .zip(real(&path))
            .is_some_and(|(folder, path)| path.starts_with(folder));
        let small = std::fs::metadata(&path).is_ok_and(|m| m.is_file() && m.len() <= MOST_BYTES);
        if below
            && small
            && let Ok(bytes) = std::fs::read(&path)
        {
            found.push((name, bytes));
        }
    }
    found
}

/// Returns the deck with the parameter values of the request, and with RESULTS/XRF added if the deck lacks it.
fn deck(request: &SweepRequest<'_>) -> Result<Dataset, Box<Diagnostic>> {
    let mut deck = request.dataset.clone();
    for (address, value) in request.theta {
        let edits = deck.set(address, *value).map_err(Box::new)?;
        deck = edited(&deck, &edits);
    }
    Ok(with_xrf(deck))
}

/// Returns the deck with RESULTS/XRF added if the deck lacks it.
fn with_xrf(deck: Dataset) -> Dataset {
    let has_xrf = deck
        .statement("RESULTS", None)
        .map(|results| results.has("XRF"));
    let edits = match (has_xrf, deck.statement("RESULTS", None)) {
        (Some(true), _) => return deck,
        (Some(false), Some(results)) => {
            vec![admire_syntax::text::Edit::new(
                admire_syntax::text::Span::at(results.span.end()),
                ", XRF",
            )]
        }
        _ => deck.add(&NewStatement {
            kind: "RESULTS".to_string(),
            id: None,
            view_name: None,
            arguments: vec![("XRF".to_string(), None)],
        }),
    };
    edited(&deck, &edits)
}

fn edited(deck: &Dataset, edits: &[admire_syntax::text::Edit]) -> Dataset {
    deck.edited(edits)
        .expect("edits of one value do not overlap")
        .value
}

/// Returns the command file: a blank line, FILE/MODEL, and for each load case the commands that set its loads and SIMULATE/STATIC.
fn commands(request: &SweepRequest<'_>, deck: &Dataset) -> String {
    let mut out = format!("\nfile/model={STEM}\n");
    for case in &request.programme.cases {
        // Characters in the label that would end or continue the comment line are replaced by blanks.
        let ends = |c: char| c.is_control() || matches!(c, '&' | ';');
        out += &format!("! case {}\n", case.label.replace(ends, " "));
        for command in redefinitions(&request.programme.loads, &case.values, deck) {
            out += &command;
            out.push('\n');
        }
        out += "simulate/static\n";
    }
    out += "stop\n";
    out
}

/// Returns the commands that set the loads of a load case.
///
/// A command replaces the whole list of values of an argument. Loads that are values of the same list therefore share a command, which also
/// repeats the other values of the list from the deck.
fn redefinitions(loads: &[Load], values: &[f64], deck: &Dataset) -> Vec<String> {
    let mut lists: Vec<(Address, Vec<f64>)> = Vec::new();
    let mut out = Vec::new();
    for (load, value) in loads.iter().zip(values) {
        let target = &load.target;
        let Some(index) = target.index else {
            let argument = target.argument.as_deref().unwrap_or("FUNCTION");
            out.push(format!(
                "{}, {argument}={}",
                object(target),
                spelled(*value)
            ));
            continue;
        };
        let whole = Address {
            index: None,
            ..target.clone()
        };
        let at = lists
            .iter()
            .position(|(address, _)| *address == whole)
            .unwrap_or_else(|| {
                let count = deck.find(&whole).map_or(0, |statement| {
                    statement
                        .numbers(whole.argument.as_deref().unwrap_or_default())
                        .len()
                });
                let of = |k| {
                    deck.value_at(&Address {
                        index: Some(k),
                        ..whole.clone()
                    })
                    .unwrap_or(0.0)
                };
                // Arguments such as QP and REULER need three numbers, even if the deck gives fewer.
                lists.push((
                    whole.clone(),
                    (1..=count.max(3).max(index)).map(of).collect(),
                ));
                lists.len() - 1
            });
        lists[at].1[index - 1] = *value;
    }
    for (address, values) in lists {
        let list: Vec<String> = values.iter().map(|value| spelled(*value)).collect();
        let argument = address.argument.as_deref().unwrap_or_default();
        out.push(format!(
            "{}, {argument}={}",
            object(&address),
            list.join(",")
        ));
    }
    out
}

fn object(address: &Address) -> String {
    address.id.map_or_else(
        || format!("{}/", address.kind),
        |id| format!("{}/{id}", address.kind),
    )
}

/// Formats a number with the fewest digits that read back as the same double.
fn spelled(value: f64) -> String {
    format!("{value:?}").replace('e', "E")
}
