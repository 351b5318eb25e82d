//! Files of the session: the files open in the editor, and further files as they are on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::SystemTime;

use lsp_types::Uri;

use super::document::Document;
use super::position::decoded;
use admire_session::check::{Settings, is_command_file, table_above};
use admire_session::find_file;
use admire_syntax::Statement;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::{Source, Span, read_at_most};

/// A file with its state in the server.
pub(super) struct File {
    /// Text and diagnostics.
    pub document: Document,
    /// URI of the file in the editor.
    pub uri: Uri,
    /// Settings that select the diagnostics to publish.
    pub settings: Settings,
    /// Version number that the editor gives to the file; `None` for a file that is not open.
    pub version: Option<i32>,
    /// Number of edits. It shows whether the text has changed since a check was requested.
    pub edits: Arc<AtomicU64>,
    /// Modification time of the file on disk.
    written: Option<SystemTime>,
    /// Diagnostics that were published last.
    pub shown: Option<Vec<lsp_types::Diagnostic>>,
}

/// All files of the session, keyed by path.
#[derive(Default)]
pub(super) struct Workspace {
    files: BTreeMap<PathBuf, File>,
    /// Folders open in the editor.
    pub folders: Vec<PathBuf>,
}

/// Largest size in bytes of a file that is read from disk.
const MOST_BYTES: u64 = 256 << 20;
/// Largest number of command files that are read from the folder of a deck.
const MOST_FILES: usize = 1000;

impl Workspace {
    /// Creates a workspace with the given folders, without files.
    pub(crate) fn of(folders: Vec<PathBuf>) -> Self {
        Self {
            folders,
            ..Self::default()
        }
    }

    /// Adds a file opened in the editor, and returns the errors in its settings.
    pub(crate) fn open(
        &mut self,
        uri: Uri,
        version: i32,
        text: &str,
        commands: bool,
    ) -> Vec<Diagnostic> {
        let path = path_of(&uri);
        let commands = commands || is_command_file(&path);
        let source = Source::new(path.display().to_string(), text.as_bytes());
        let (settings, wrong) = settings_of(&path);
        let file = File {
            document: Document::open(&source, commands),
            uri,
            settings,
            version: Some(version),
            edits: Arc::default(),
            written: None,
            shown: None,
        };
        self.files.insert(path, file);
        wrong
    }

    /// Removes a file closed in the editor.
    pub(crate) fn close(&mut self, uri: &Uri) {
        self.files.remove(&path_of(uri));
    }

    /// Reads the settings of all files again, and returns the errors in them.
    pub(crate) fn renew_settings(&mut self) -> Vec<Diagnostic> {
        let mut all = Vec::new();
        for (path, file) in &mut self.files {
            let (settings, wrong) = settings_of(path);
            file.settings = settings;
            all.extend(wrong);
        }
        all
    }

    /// Returns a file that is open or has been read.
    pub(crate) fn file(&self, path: &Path) -> Option<&File> {
        self.files.get(path)
    }

    /// Returns a file that is open or has been read, mutably.
    pub(crate) fn file_mut(&mut self, path: &Path) -> Option<&mut File> {
        self.files.get_mut(path)
    }

    /// Returns all open files.
    pub(crate) fn open_files(&self) -> impl Iterator<Item = (&PathBuf, &File)> {
        self.files.iter().filter(|(_, file)| file.version.is_some())
    }

    /// Returns all files, including those that are not open.
    pub(crate) fn all_files(&self) -> impl Iterator<Item = &File> {
        self.files.values()
    }

    /// Reads a file from disk, unless it is open or has not changed since it was last read. Returns false if it cannot be read.
    pub(crate) fn read(&mut self, path: &Path) -> bool {
        if self.file(path).is_some_and(|file| file.version.is_some()) {
            return true;
        }
        let written = std::fs::metadata(path).and_then(|m| m.modified()).ok();
        let known = self.file(path);
        if known.is_some_and(|file| file.written == written && written.is_some()) {
            return true;
        }
        let Some((bytes, uri)) = read_at_most(path, MOST_BYTES).ok().zip(uri_of(path)) else {
            self.files.remove(path);
            return false;
        };
        let source = Source::new(path.display().to_string(), decoded(bytes));
        let file = File {
            document: Document::open(&source, is_command_file(path)),
            uri,
            settings: Settings::default(),
            version: None,
            edits: Arc::default(),
            written,
            shown: None,
        };
        self.files.insert(path.to_path_buf(), file);
        true
    }

    /// Returns the deck of the command at offset `before`. The last FILE command before the offset names it, or else the first line of the
    /// command file.
    pub(crate) fn deck_of(&self, commands: &Path, before: usize) -> Option<PathBuf> {
        let document = &self.file(commands)?.document;
        let names = decks_named(document);
        let last = names.into_iter().rev().find(|(at, _)| *at <= before);
        self.deck_named(commands, &last?.1)
    }

    fn deck_named(&self, commands: &Path, written: &str) -> Option<PathBuf> {
        let folder = commands.parent().unwrap_or(Path::new(""));
        let found = find_file(written, "adm", &[folder]).value;
        let found = found.map(|path| normal(&path));
        // A deck that has never been saved exists only as an open file.
        found.or_else(|| {
            let named = folder.join(written.trim());
            let beside = [named.clone(), named.with_extension("adm")];
            beside
                .into_iter()
                .find(|path| self.files.contains_key(path))
        })
    }

    /// Returns all decks that a command file names.
    pub(crate) fn decks_of(&self, commands: &Path) -> Vec<PathBuf> {
        let Some(file) = self.file(commands) else {
            return Vec::new();
        };
        let names = decks_named(&file.document);
        let mut found: Vec<PathBuf> = names
            .iter()
            .filter_map(|(_, name)| self.deck_named(commands, name))
            .collect();
        found.sort();
        found.dedup();
        found
    }

    /// Returns the command files that name a deck. The open files and the files in the deck's folder are searched.
    pub(crate) fn commands_of(&mut self, deck: &Path) -> Vec<PathBuf> {
        let beside = deck.parent().map(std::fs::read_dir);
        let mut candidates: Vec<PathBuf> = beside
            .and_then(Result::ok)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| normal(&entry.path()))
            .filter(|path| is_command_file(path))
            .take(MOST_FILES)
            .collect();
        candidates.retain(|path| self.read(path));
        let open = self.open_files();
        let open = open.filter(|(_, file)| file.document.is_command_file());
        candidates.extend(open.map(|(path, _)| path.clone()));
        candidates.sort();
        candidates.dedup();
        candidates.retain(|path| self.decks_of(path).iter().any(|named| named == deck));
        candidates
    }

    /// Returns the files that belong together. For a deck these are the deck and its command files. For a command file they are the file,
    /// its decks and their other command files. The file at `path` comes first.
    pub(crate) fn together(&mut self, path: &Path) -> Vec<PathBuf> {
        let is_commands = |file: &File| file.document.is_command_file();
        let mut found = vec![path.to_path_buf()];
        let decks = if self.file(path).is_some_and(is_commands) {
            let mut decks = self.decks_of(path);
            decks.retain(|deck| self.read(deck));
            decks
        } else {
            vec![path.to_path_buf()]
        };
        for deck in decks {
            let commands = self.commands_of(&deck);
            found.push(deck);
            found.extend(commands);
        }
        let mut seen = std::collections::BTreeSet::new();
        found.retain(|path| seen.insert(path.clone()));
        found
    }
}

/// Returns the deck names in a command file, each with the offset from which on it applies.
fn decks_named(document: &Document) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let text = |span: Span| {
        let piece = document.pieces().pieces().first()?;
        Some(piece.source().text(span).into_owned())
    };
    if let Some(name) = document.pieces().head().and_then(|head| text(head.model)) {
        found.push((0, name));
    }
    for (_, base, command) in document.statements() {
        if let Some(name) = deck_argument(command).and_then(text) {
            found.push((base + command.span.start(), name));
        }
    }
    found
}

/// Returns the span of the deck name in a FILE command; `None` for any other command.
pub(super) fn deck_argument(command: &Statement) -> Option<Span> {
    let argument = command.argument("MODEL")?;
    (command.kind() == Some("FILE")).then(|| argument.value_span())
}

/// Returns the canonical path of a file, for comparison with other paths.
pub(super) fn normal(path: &Path) -> PathBuf {
    dunce::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// Returns the path of a URI from the editor. A URI that is not a file is returned as text in a path.
pub(super) fn path_of(uri: &Uri) -> PathBuf {
    let path = url::Url::parse(uri.as_str())
        .ok()
        .and_then(|url| url.to_file_path().ok());
    path.map_or_else(|| PathBuf::from(uri.as_str()), |path| normal(&path))
}

/// Returns the URI of a file.
pub(super) fn uri_of(path: &Path) -> Option<Uri> {
    let absolute = std::path::absolute(path).ok()?;
    let url = url::Url::from_file_path(absolute).ok()?;
    url.as_str().parse().ok()
}

/// Returns the settings for a file, and the errors in them.
fn settings_of(path: &Path) -> (Settings, Vec<Diagnostic>) {
    let Some(source) = table_above(path).and_then(|table| Source::read(&table).ok()) else {
        return (Settings::default(), Vec::new());
    };
    match Settings::parse(&source) {
        Ok(settings) => (settings, Vec::new()),
        Err(wrong) => (Settings::default(), wrong),
    }
}
