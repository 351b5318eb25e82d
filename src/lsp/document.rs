//! An open file: its pieces, the positions of its objects, and its diagnostics.
//!
//! This module is independent of the protocol. A piece is a run of whole lines that is parsed separately. After every edit, the reader and
//! the neighbourhood rules run again on the affected pieces. A neighbourhood rule depends on one statement, on the statements that this
//! statement names, and on statements with the same id. Rules about the whole file run in a background check.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use super::complaint::{Anchor, AnchoredDiagnostic, Candidate, new_place, shifted};
use super::definitions::{Definitions, is_known_body};
use super::excerpt::{Depth, Excerpt};
use admire_session::check::{DiagnosticSource, Found};
use admire_syntax::catalogue::{Catalogue, Place};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::Role;
use admire_syntax::lint::{Options, Reach, Suppressed, check_until};
use admire_syntax::pieces::Pieces;
use admire_syntax::text::{Source, Span};
use admire_syntax::{ObjectId, Statement};

/// Largest number of affected pieces that the neighbourhood rules check after an edit. The check of the whole file covers the remaining
/// pieces.
const MOST_PIECES: usize = 64;
/// Largest number of affected pieces checked after an edit, in a file with more than [`MOST_PIECES`] pieces. It is exceeded only if the edit itself
/// touches more pieces. The limit is smaller for such a file because the check of the whole file takes longer, and typing must remain responsive.
const MOST_OF_MANY: usize = 12;

/// An open dataset or command file.
pub struct Document {
    pieces: Pieces,
    catalogue: Catalogue,
    /// Index of each piece in the file, by the key of the piece.
    places: HashMap<u32, usize>,
    /// Diagnostics of the neighbourhood rules, by the key of the piece that contains the first label.
    near: HashMap<u32, Vec<AnchoredDiagnostic>>,
    /// Diagnostics of the checks of the whole file.
    far: Vec<AnchoredDiagnostic>,
    /// Suppression comments, by the key of their piece.
    silences: HashMap<u32, Suppressed>,
}

impl Document {
    /// Reads a file and runs the neighbourhood rules.
    pub fn open(source: &Source, is_command_file: bool) -> Self {
        let role = if is_command_file {
            Role::Command
        } else {
            Role::Dataset
        };
        let mut document = Self {
            pieces: Pieces::parse(source, role),
            catalogue: Catalogue::default(),
            places: HashMap::new(),
            near: HashMap::new(),
            far: Vec::new(),
            silences: HashMap::new(),
        };
        document.place();
        for at in 0..document.pieces.pieces().len() {
            document.take_up(at);
        }
        let few = document.pieces.pieces().len() <= MOST_PIECES;
        if few {
            document.ask_neighbours(&(0..document.pieces.pieces().len()).collect());
        }
        document
    }

    /// Returns the pieces of the file.
    pub fn pieces(&self) -> &Pieces {
        &self.pieces
    }

    /// Returns the name of the file.
    pub fn name(&self) -> Arc<str> {
        self.pieces.name()
    }

    /// Returns true for a command file.
    pub(crate) fn is_command_file(&self) -> bool {
        self.pieces.is_command_file()
    }

    /// Replaces text, parses the touched pieces again, and runs the neighbourhood rules on the affected pieces.
    pub fn edit(&mut self, span: Span, replacement: &[u8]) {
        let old_live = self.pieces.live().len();
        let change = self.pieces.edit(span, replacement);
        let (start, behind) = (change.added.start, change.added.end);
        // The position of END decides which pieces after the edit belong to the dataset.
        let live = self.pieces.live().len().max(behind);
        let old_behind = start + change.removed.len();
        let was_live = old_live.max(old_behind) - old_behind + behind;
        let revived = was_live.min(live)..live;
        let lost = live.min(was_live)..was_live;
        // The text before the first changed piece is unchanged.
        let entering = self.body_entering(start);
        let all = self.pieces.pieces();
        let removed = &change.removed[..old_live.clamp(start, old_behind) - start];
        let before = Definitions::of(entering, removed.iter().chain(&all[few(&lost)]));
        for piece in &change.removed {
            self.catalogue.remove(piece);
            self.near.remove(&piece.key());
            self.silences.remove(&piece.key());
        }
        self.place();
        for at in change.added.clone() {
            self.take_up(at);
        }
        let all = self.pieces.pieces();
        let added = &all[start..self.pieces.live().len().clamp(start, behind)];
        let after = Definitions::of(entering, added.iter().chain(&all[few(&revived)]));
        for piece in &all[revived.clone()] {
            self.near.remove(&piece.key());
        }
        let mut gone: HashMap<u32, usize> = HashMap::new();
        let mut base = self.pieces.start(start);
        for piece in &change.removed {
            gone.insert(piece.key(), base);
            base += piece.size();
        }
        self.settle(&gone, span, replacement.len());
        if self.is_command_file() {
            return;
        }
        let mut affected: BTreeSet<usize> = change.added.clone().chain(few(&revived)).collect();
        let mut changed = before.differing(&after);
        if before.body != after.body {
            changed.extend(self.followers(behind, &mut affected));
        }
        for (key, complaints) in &self.near {
            let points =
                |anchor: &Option<Anchor>| anchor.is_some_and(|a| gone.contains_key(&a.piece));
            if complaints.iter().any(|c| c.labels.iter().any(points)) {
                affected.extend(self.places.get(key));
            }
        }
        for object in changed {
            let definers = self.catalogue.definitions(object).iter().map(|p| p.piece);
            let keys = definers.chain(self.catalogue.referring(object));
            affected.extend(keys.filter_map(|key| self.live_place(key)));
        }
        let most = match self.pieces.pieces().len() {
            0..=MOST_PIECES => MOST_PIECES,
            _ => MOST_OF_MANY,
        };
        self.ask_neighbours(&nearest(affected, &change.added, most));
    }

    /// Stores the findings of a check of the whole file. The check must have used the current text.
    pub fn store_findings(&mut self, found: Vec<Found>) {
        self.far.clear();
        self.near.clear();
        for found in found {
            let complaint = match found.told {
                // The pieces hold the diagnostics of the reader themselves.
                DiagnosticSource::Reader => continue,
                DiagnosticSource::Neighbourhood | DiagnosticSource::File => {
                    self.anchored(found.diagnostic)
                }
            };
            let Some(complaint) = complaint else { continue };
            match complaint.labels.first() {
                Some(Some(anchor)) if found.told == DiagnosticSource::Neighbourhood => {
                    self.near.entry(anchor.piece).or_default().push(complaint);
                }
                _ => self.far.push(complaint),
            }
        }
    }

    /// Returns all current diagnostics in the order of the file, with positions in the current text.
    pub fn complaints(&self) -> Vec<Found> {
        self.complaints_where(|_| true, usize::MAX).0
    }

    /// Returns the `most` most severe diagnostics accepted by `wanted`, in the order of the file, and the number of accepted diagnostics
    /// left out.
    pub(crate) fn complaints_where(
        &self,
        wanted: impl Fn(&Diagnostic) -> bool,
        most: usize,
    ) -> (Vec<Found>, usize) {
        let missing = admire_syntax::missing_end(&self.name(), self.pieces.size());
        let mut all: Vec<Candidate<'_>> = Vec::new();
        for (at, piece) in self.pieces.live().iter().enumerate() {
            let base = self.pieces.start(at);
            all.extend(
                piece
                    .diagnostics()
                    .iter()
                    .map(|found| Candidate::read(found, base)),
            );
        }
        if !self.is_command_file() && !self.pieces.has_end() {
            all.push(Candidate::read(&missing, 0));
        }
        let near = self.near.values().flatten();
        all.extend(near.filter_map(|c| self.candidate(c, DiagnosticSource::Neighbourhood)));
        let seen: HashSet<(Code, Option<usize>)> = all.iter().map(Candidate::place).collect();
        let far = self
            .far
            .iter()
            .filter_map(|c| self.candidate(c, DiagnosticSource::File));
        all.extend(far.filter(|found| !seen.contains(&found.place())));
        all.retain(|found| wanted(found.diagnostic) && !self.is_silenced(found));
        let others = all.len().saturating_sub(most);
        if others > 0 {
            all.sort_by_key(|found| (std::cmp::Reverse(found.diagnostic.severity), found.span));
            all.truncate(most);
        }
        all.sort_by_key(|found| (found.span, found.diagnostic.code));
        let found = |candidate: Candidate<'_>| {
            let diagnostic = match candidate.kept {
                Some(complaint) => self.resolved(complaint)?,
                None => shifted(candidate.diagnostic, candidate.base),
            };
            Some(Found::new(candidate.told, diagnostic))
        };
        (all.into_iter().filter_map(found).collect(), others)
    }

    /// Returns a stored diagnostic as a candidate for publication, or `None` if the text at its position is gone.
    fn candidate<'a>(
        &self,
        complaint: &'a AnchoredDiagnostic,
        told: DiagnosticSource,
    ) -> Option<Candidate<'a>> {
        let first = complaint.diagnostic.labels.first();
        let span = match complaint.labels.first() {
            // In pieces after END, only diagnostics about suppression comments remain.
            Some(Some(anchor))
                if complaint.diagnostic.code != Code::UnknownKey
                    && self.live_place(anchor.piece).is_none() =>
            {
                return None;
            }
            Some(Some(anchor)) => Some(self.span_of(*anchor)?),
            _ => first.map(|label| label.span),
        };
        Some(Candidate {
            told,
            diagnostic: &complaint.diagnostic,
            span,
            base: 0,
            kept: Some(complaint),
        })
    }

    /// Returns the statement with the given index within the piece of the given index.
    pub fn statement(&self, (piece, at): (usize, usize)) -> &Statement {
        &self.pieces.pieces()[piece].statements()[at]
    }

    /// Returns every statement, with its (piece, statement) indices and the offset of its piece.
    pub fn statements(&self) -> impl Iterator<Item = ((usize, usize), usize, &Statement)> {
        let pieces = self.pieces.live().iter().enumerate();
        pieces.flat_map(move |(piece, read)| {
            let base = self.pieces.start(piece);
            let all = read.statements().iter().enumerate();
            all.map(move |(at, statement)| ((piece, at), base, statement))
        })
    }

    /// Returns the (piece, statement) indices of the definitions of an object, in the order of the file.
    pub fn definitions(&self, object: ObjectId) -> Vec<(usize, usize)> {
        self.in_order(self.catalogue.definitions(object))
    }

    /// Returns the indices of the pieces that refer to an object, in the order of the file.
    pub(crate) fn referring(&self, object: ObjectId) -> Vec<usize> {
        let mut pieces: Vec<usize> = self
            .catalogue
            .referring(object)
            .filter_map(|key| self.live_place(key))
            .collect();
        pieces.sort_unstable();
        pieces
    }

    /// Returns every object, with the (piece, statement) indices of its first definition.
    pub(crate) fn objects(&self) -> impl Iterator<Item = (ObjectId, (usize, usize))> {
        let all = self.catalogue.objects();
        all.filter_map(|(object, places)| Some((object, *self.in_order(places).first()?)))
    }

    /// Returns the (piece, statement) indices of the body to which a marker without a PART belongs.
    pub(crate) fn body_before(&self, (piece, at): (usize, usize)) -> Option<(usize, usize)> {
        let pieces = self.pieces.pieces();
        let last = |piece: usize, statements: &[Statement]| {
            let body = statements.iter().rposition(is_known_body);
            body.map(|at| (piece, at))
        };
        last(piece, &pieces[piece].statements()[..at]).or_else(|| {
            (0..piece)
                .rev()
                .find_map(|piece| last(piece, pieces[piece].statements()))
        })
    }

    fn in_order(&self, places: &[Place]) -> Vec<(usize, usize)> {
        let mut found: Vec<(usize, usize)> = places
            .iter()
            .filter_map(|place| Some((self.live_place(place.piece)?, place.at)))
            .collect();
        found.sort_unstable();
        found
    }

    /// Returns the index of the piece with this key, or `None` if the piece follows END.
    fn live_place(&self, key: u32) -> Option<usize> {
        let at = *self.places.get(&key)?;
        (at < self.pieces.live().len()).then_some(at)
    }

    /// Updates the map from piece keys to piece indices.
    fn place(&mut self) {
        let pieces = self.pieces.pieces().iter().enumerate();
        self.places = pieces.map(|(at, piece)| (piece.key(), at)).collect();
    }

    fn take_up(&mut self, at: usize) {
        let piece = &self.pieces.pieces()[at];
        self.catalogue.add(piece);
        if memchr::memmem::find(piece.source().bytes(), b"admire:").is_some() {
            let silences = Suppressed::of(piece.source(), piece.statements());
            self.silences.insert(piece.key(), silences);
        }
    }

    /// Returns the body to which a marker at the start of piece `at` would belong.
    fn body_entering(&self, at: usize) -> Option<ObjectId> {
        let before = &self.pieces.pieces()[..at];
        let all = before
            .iter()
            .rev()
            .flat_map(|p| p.statements().iter().rev());
        all.into_iter().find(|s| is_known_body(s))?.object()
    }

    /// Returns the markers in piece `first` and in later pieces that belong to the last body before piece `first`. Adds the pieces of these
    /// markers to `affected`.
    fn followers(&self, first: usize, affected: &mut BTreeSet<usize>) -> Vec<ObjectId> {
        let mut found = Vec::new();
        for (at, piece) in self.pieces.live().iter().enumerate().skip(first) {
            for statement in piece.statements() {
                if is_known_body(statement) {
                    return found;
                }
                if statement.follows_body() {
                    affected.insert(at);
                    found.extend(statement.object());
                }
            }
        }
        found
    }

    /// Runs the neighbourhood rules on the statements of the given pieces.
    fn ask_neighbours(&mut self, pieces: &BTreeSet<usize>) {
        if self.is_command_file() {
            return;
        }
        let asked = pieces.iter().flat_map(|piece| {
            let piece_of = self.pieces.live().get(*piece);
            let count = piece_of.map_or(0, |live| live.statements().len());
            (0..count).map(move |at| (*piece, at))
        });
        let excerpt = Excerpt::of(self, asked, Depth::One);
        let options = Options::default();
        let found = check_until(&excerpt.dataset, &options, Reach::Neighbours, || false);
        let mut new: HashMap<u32, Vec<AnchoredDiagnostic>> = pieces
            .iter()
            .map(|at| (self.pieces.pieces()[*at].key(), Vec::new()))
            .collect();
        for (_, mut diagnostic) in found.unwrap_or_default() {
            let Some(first) = diagnostic.labels.first() else {
                continue;
            };
            if !excerpt.place(first.span).is_some_and(|(_, asked)| asked) {
                continue;
            }
            for label in &mut diagnostic.labels {
                if let Some((span, _)) = excerpt.place(label.span) {
                    label.span = span;
                }
            }
            for edit in diagnostic.fix.iter_mut().flat_map(|fix| &mut fix.edits) {
                if let Some((span, _)) = excerpt.place(edit.span) {
                    edit.span = span;
                }
            }
            if let Some(complaint) = self.anchored(diagnostic)
                && let Some(Some(anchor)) = complaint.labels.first()
                && let Some(own) = new.get_mut(&anchor.piece)
            {
                own.push(complaint);
            }
        }
        for at in pieces {
            let piece = &self.pieces.pieces()[*at];
            let base = self.pieces.start(*at);
            let of_comments = self.silences.get(&piece.key());
            let own: Vec<AnchoredDiagnostic> = of_comments
                .iter()
                .flat_map(|silences| &silences.diagnostics)
                .filter_map(|found| self.anchored(shifted(found, base)))
                .collect();
            new.entry(piece.key()).or_default().extend(own);
        }
        self.near.extend(new);
    }

    fn is_silenced(&self, found: &Candidate<'_>) -> bool {
        let code = found.diagnostic.code;
        // Diagnostics about suppression comments cannot be suppressed.
        if self.silences.is_empty() || code == Code::UnknownKey {
            return false;
        }
        let everywhere = |silences: &Suppressed| silences.covers_file(code);
        if self.silences.values().any(everywhere) {
            return true;
        }
        let Some(span) = found.span else {
            return false;
        };
        let Some(at) = self.pieces.at(span.start()) else {
            return false;
        };
        let own = self.silences.get(&self.pieces.pieces()[at].key());
        let base = self.pieces.start(at);
        own.is_some_and(|silences| silences.covers_at(code, span.start() - base))
    }

    fn anchor(&self, span: Span) -> Option<Anchor> {
        let at = self.pieces.at(span.start())?;
        let base = self.pieces.start(at);
        let last = self.pieces.size().max(span.start());
        Some(Anchor {
            piece: self.pieces.pieces()[at].key(),
            span: Span::new(span.start() - base, span.end().min(last) - base),
        })
    }

    fn anchored(&self, diagnostic: Diagnostic) -> Option<AnchoredDiagnostic> {
        let name = self.name();
        let labels = diagnostic
            .labels
            .iter()
            .map(|label| {
                (label.file == name)
                    .then(|| self.anchor(label.span))
                    .flatten()
            })
            .collect();
        let fix = diagnostic.fix.iter().flat_map(|fix| &fix.edits);
        let edits = fix
            .map(|edit| self.anchor(edit.span))
            .collect::<Option<Vec<Anchor>>>()?;
        Some(AnchoredDiagnostic {
            diagnostic,
            labels,
            edits,
        })
    }

    fn span_of(&self, anchor: Anchor) -> Option<Span> {
        let base = self.pieces.start(*self.places.get(&anchor.piece)?);
        Some(Span::new(
            base + anchor.span.start(),
            base + anchor.span.end(),
        ))
    }

    /// Returns a stored diagnostic with positions in the current text, or `None` if the text at its first label is gone.
    fn resolved(&self, complaint: &AnchoredDiagnostic) -> Option<Diagnostic> {
        let mut found = complaint.diagnostic.clone();
        let mut labels = Vec::with_capacity(found.labels.len());
        for (k, (mut label, anchor)) in found.labels.into_iter().zip(&complaint.labels).enumerate()
        {
            match anchor.map(|anchor| self.span_of(anchor)) {
                Some(Some(span)) => label.span = span,
                Some(None) if k == 0 => return None,
                Some(None) => continue,
                None => {}
            }
            labels.push(label);
        }
        found.labels = labels;
        if let Some(fix) = &mut found.fix {
            let spans: Option<Vec<Span>> =
                complaint.edits.iter().map(|a| self.span_of(*a)).collect();
            match spans {
                Some(spans) => {
                    for (edit, span) in fix.edits.iter_mut().zip(spans) {
                        edit.span = span;
                    }
                }
                None => found.fix = None,
            }
        }
        Some(found)
    }

    /// Moves diagnostics of the whole file from removed pieces to the pieces that replace them. `gone` holds the offset of each removed
    /// piece by its key. A diagnostic is dropped until the next check if the text at its own position was edited.
    fn settle(&mut self, gone: &HashMap<u32, usize>, edited: Span, length: usize) {
        let far = std::mem::take(&mut self.far);
        let place = |document: &Self, anchor: Anchor| match gone.get(&anchor.piece) {
            None => Some(anchor),
            Some(base) => {
                let old = Span::new(base + anchor.span.start(), base + anchor.span.end());
                document.anchor(new_place(old, edited, length)?)
            }
        };
        for mut complaint in far {
            let labels = complaint.labels.iter().flatten();
            let mut anchors = labels.chain(&complaint.edits);
            if !anchors.any(|anchor| gone.contains_key(&anchor.piece)) {
                self.far.push(complaint);
                continue;
            }
            let labels = std::mem::take(&mut complaint.diagnostic.labels);
            let anchors = std::mem::take(&mut complaint.labels);
            let mut lost = false;
            for (k, (label, anchor)) in labels.into_iter().zip(anchors).enumerate() {
                let new = anchor.map(|anchor| place(self, anchor));
                if new.is_some_and(|new| new.is_none()) {
                    lost |= k == 0;
                    continue;
                }
                complaint.diagnostic.labels.push(label);
                complaint.labels.push(new.flatten());
            }
            if lost {
                continue;
            }
            let edits = complaint.edits.iter().map(|anchor| place(self, *anchor));
            let edits: Option<Vec<Anchor>> = edits.collect();
            if edits.is_none() {
                complaint.diagnostic.fix = None;
            }
            complaint.edits = edits.unwrap_or_default();
            self.far.push(complaint);
        }
    }
}

/// Returns the first [`MOST_PIECES`] of the given pieces.
fn few(pieces: &Range<usize>) -> Range<usize> {
    pieces.start..pieces.end.min(pieces.start + MOST_PIECES)
}

/// Returns the edited pieces and the affected pieces nearest to them. The result has at most `most` pieces, or as many as were edited if
/// that is more.
fn nearest(affected: BTreeSet<usize>, edited: &Range<usize>, most: usize) -> BTreeSet<usize> {
    let most = most.max(edited.len().min(MOST_PIECES));
    if affected.len() <= most {
        return affected;
    }
    let mut all: Vec<usize> = affected.into_iter().collect();
    all.sort_by_key(|at| match at {
        at if edited.contains(at) => 0,
        at => at.abs_diff(edited.start).max(1),
    });
    all.truncate(most);
    all.into_iter().collect()
}
