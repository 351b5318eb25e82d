//! The files at hand: those that are open in the editor, and those beside them as they are on disk.

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

/// A file and what is known of it.
pub(super) struct File {
    /// Its text.
    pub document: Document,
    /// What the editor calls it.
    pub uri: Uri,
    /// What is shown of the complaints about it.
    pub settings: Settings,
    /// The version of the editor; `None` for files that are not open.
    pub version: Option<i32>,
    /// Counts edits: a check of an older text is outdated.
    pub edits: Arc<AtomicU64>,
    /// When the file on disk was written.
    written: Option<SystemTime>,
    /// What was last shown of it.
    pub shown: Option<Vec<lsp_types::Diagnostic>>,
}

/// Every file at hand, by its path.
#[derive(Default)]
pub(super) struct Workspace {
    files: BTreeMap<PathBuf, File>,
    /// The folders the editor has open.
    pub folders: Vec<PathBuf>,
}

/// Larger files are not read for what they may say about others.
const MOST_BYTES: u64 = 256 << 20;
/// So many files of a folder are looked at.
const MOST_FILES: usize = 1000;

impl Workspace {
    /// A workspace of some folders, without files yet.
    pub(crate) fn of(folders: Vec<PathBuf>) -> Self {
        Self {
            folders,
            ..Self::default()
        }
    }

    /// Takes up a file the editor opened, and says what is wrong with its settings.
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

    /// Forgets what the editor had of a file.
    pub(crate) fn close(&mut self, uri: &Uri) {
        self.files.remove(&path_of(uri));
    }

    /// Reads the settings of all open files again, and says what is wrong with them.
    pub(crate) fn renew_settings(&mut self) -> Vec<Diagnostic> {
        let mut all = Vec::new();
        for (path, file) in &mut self.files {
            let (settings, wrong) = settings_of(path);
            file.settings = settings;
            all.extend(wrong);
        }
        all
    }

    /// An open file or one that was read.
    pub(crate) fn file(&self, path: &Path) -> Option<&File> {
        self.files.get(path)
    }

    /// An open file or one that was read, to change it.
    pub(crate) fn file_mut(&mut self, path: &Path) -> Option<&mut File> {
        self.files.get_mut(path)
    }

    /// All open files.
    pub(crate) fn open_files(&self) -> impl Iterator<Item = (&PathBuf, &File)> {
        self.files.iter().filter(|(_, file)| file.version.is_some())
    }

    /// All files, those too that were only read.
    pub(crate) fn all_files(&self) -> impl Iterator<Item = &File> {
        self.files.values()
    }

    /// Reads a file from disk, unless it is open or was read since it was written. False if it cannot be read.
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

    /// The deck a command of a file is run on: the one the last FILE command before it names, or the one the file begins with.
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
        // A deck that was never saved is only open.
        found.or_else(|| {
            let named = folder.join(written.trim());
            let beside = [named.clone(), named.with_extension("adm")];
            beside
                .into_iter()
                .find(|path| self.files.contains_key(path))
        })
    }

    /// All decks a command file names.
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

    /// The command files beside a deck and among the open ones that name it.
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

    /// A deck with its command files, or a command file with its decks and their other command files; the file itself is first.
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

/// The names of decks in a command file and where each counts from.
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

/// Where a FILE command names a deck.
pub(super) fn deck_argument(command: &Statement) -> Option<Span> {
    let argument = command.argument("MODEL")?;
    (command.kind() == Some("FILE")).then(|| argument.value_span())
}

/// The path of a file as it is compared with others.
pub(super) fn normal(path: &Path) -> PathBuf {
    dunce::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The path of what the editor names; its name itself for what is no file.
pub(super) fn path_of(uri: &Uri) -> PathBuf {
    let path = url::Url::parse(uri.as_str())
        .ok()
        .and_then(|url| url.to_file_path().ok());
    path.map_or_else(|| PathBuf::from(uri.as_str()), |path| normal(&path))
}

/// What the editor calls a file.
pub(super) fn uri_of(path: &Path) -> Option<Uri> {
    let absolute = std::path::absolute(path).ok()?;
    let url = url::Url::from_file_path(absolute).ok()?;
    url.as_str().parse().ok()
}

/// The settings for a file, and what is wrong with them.
fn settings_of(path: &Path) -> (Settings, Vec<Diagnostic>) {
    let Some(source) = table_above(path).and_then(|table| Source::read(&table).ok()) else {
        return (Settings::default(), Vec::new());
    };
    match Settings::parse(&source) {
        Ok(settings) => (settings, Vec::new()),
        Err(wrong) => (Settings::default(), wrong),
    }
}
