//! An open file: its pieces, where its objects are, and what there is to say of it.
//!
//! Knows no protocol. The reader and the rules of neighbours are asked again after every edit, for what the edit touched; what looks
//! at the whole file is told by a check in the background.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use super::excerpt::{Depth, Excerpt};
use crate::check::{Found, Told};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::Role;
use crate::syntax::catalogue::{Catalogue, Place};
use crate::syntax::lint::{Options, Reach, Suppressed, check_until};
use crate::syntax::pieces::{Piece, Pieces};
use crate::syntax::{Object, Statement};
use crate::text::{Edit, Source, Span};

/// After an edit the rules of neighbours are asked about so many pieces at most; the check of the whole file does the others.
const MOST_PIECES: usize = 64;

/// An open dataset or command file.
pub struct Document {
    pieces: Pieces,
    catalogue: Catalogue,
    /// Where the piece of a key stands.
    places: HashMap<u32, usize>,
    /// What rules of neighbours complain of, by the piece of the first label.
    near: HashMap<u32, Vec<Complaint>>,
    /// What looks at the whole file complains of.
    far: Vec<Complaint>,
    /// What comments of a piece silence, for those that have such comments.
    silences: HashMap<u32, Suppressed>,
}

/// A complaint whose places move with the text.
#[derive(Clone, Debug)]
struct Complaint {
    diagnostic: Diagnostic,
    /// Of each label; `None` for places in other files.
    labels: Vec<Option<Anchor>>,
    /// Of each edit of its fix.
    edits: Vec<Anchor>,
}

/// A place in a piece.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    piece: u32,
    span: Span,
}

impl Document {
    /// Reads a file and asks the rules of neighbours.
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

    /// Its pieces.
    pub fn pieces(&self) -> &Pieces {
        &self.pieces
    }

    /// The name of the file.
    pub fn name(&self) -> Arc<str> {
        self.pieces.name()
    }

    /// True for a command file.
    pub fn is_command_file(&self) -> bool {
        self.pieces.is_command_file()
    }

    /// Replaces text, reads again what that touches, and asks the rules of neighbours about it.
    pub fn edit(&mut self, span: Span, replacement: &[u8]) {
        let moved = self.moved(span, replacement.len());
        let old_count = self.pieces.pieces().len();
        let change = self.pieces.edit(span, replacement);
        let behind = old_count - (change.added.start + change.removed.len());
        // What stands before the pieces is as it was.
        let entering = self.body_entering(change.added.start);
        let before = Definitions::of(entering, &change.removed);
        for piece in &change.removed {
            self.catalogue.remove(piece);
            self.near.remove(&piece.key());
            self.silences.remove(&piece.key());
        }
        self.place();
        for at in change.added.clone() {
            self.take_up(at);
        }
        let after = Definitions::of(entering, &self.pieces.pieces()[change.added.clone()]);
        self.settle(moved);
        if self.is_command_file() {
            return;
        }
        let mut affected: BTreeSet<usize> = change.added.clone().collect();
        let mut changed = before.differing(&after);
        if before.body != after.body {
            let first = self.pieces.pieces().len() - behind;
            changed.extend(self.followers(first, &mut affected));
        }
        let gone: BTreeSet<u32> = change.removed.iter().map(|piece| piece.key()).collect();
        for (key, complaints) in &self.near {
            let points = |anchor: &Option<Anchor>| anchor.is_some_and(|a| gone.contains(&a.piece));
            if complaints.iter().any(|c| c.labels.iter().any(points)) {
                affected.extend(self.places.get(key));
            }
        }
        for object in changed {
            let definers = self.catalogue.definitions(object).iter().map(|p| p.piece);
            let keys = definers.chain(self.catalogue.referring(object));
            affected.extend(keys.filter_map(|key| self.places.get(&key)));
        }
        self.ask_neighbours(&nearest(affected, &change.added));
    }

    /// Keeps what a check of the whole file found, if it was of the text as it is now.
    pub fn told(&mut self, found: Vec<Found>) {
        self.far.clear();
        self.near.clear();
        for found in found {
            let complaint = match found.told {
                // The pieces tell that themselves.
                Told::Reader => continue,
                Told::Neighbourhood | Told::File => self.anchored(found.diagnostic),
            };
            let Some(complaint) = complaint else { continue };
            match complaint.labels.first() {
                Some(Some(anchor)) if found.told == Told::Neighbourhood => {
                    self.near.entry(anchor.piece).or_default().push(complaint);
                }
                _ => self.far.push(complaint),
            }
        }
    }

    /// All there is to say of it so far, in the order of the file, with places in the file as it is now.
    pub fn complaints(&self) -> Vec<Found> {
        let mut all: Vec<Found> = Vec::new();
        for (at, piece) in self.pieces.pieces().iter().enumerate() {
            let base = self.pieces.start(at);
            let own = piece.diagnostics().iter().map(|found| shifted(found, base));
            all.extend(own.map(|found| Found::new(Told::Reader, found)));
        }
        if !self.is_command_file() && !self.pieces.has_end() {
            let found = crate::syntax::missing_end(&self.name(), self.pieces.size());
            all.push(Found::new(Told::Reader, found));
        }
        let near = self.near.values().flatten();
        let near = near.filter_map(|complaint| self.resolved(complaint));
        all.extend(near.map(|found| Found::new(Told::Neighbourhood, found)));
        let seen: BTreeSet<_> = all.iter().map(|found| place(&found.diagnostic)).collect();
        let far = self.far.iter().filter_map(|c| self.resolved(c));
        let far = far.filter(|found| !seen.contains(&place(found)));
        all.extend(far.map(|found| Found::new(Told::File, found)));
        all.retain(|found| !self.is_silenced(&found.diagnostic));
        all.sort_by_cached_key(|found| {
            let label = found.diagnostic.labels.first();
            (label.map(|label| label.span), found.diagnostic.code)
        });
        all
    }

    /// The statement at a place: the piece and the statement in it.
    pub fn statement(&self, (piece, at): (usize, usize)) -> &Statement {
        &self.pieces.pieces()[piece].statements()[at]
    }

    /// Every statement with its place and where its piece begins.
    pub fn statements(&self) -> impl Iterator<Item = ((usize, usize), usize, &Statement)> {
        let pieces = self.pieces.pieces().iter().enumerate();
        pieces.flat_map(move |(piece, read)| {
            let base = self.pieces.start(piece);
            let all = read.statements().iter().enumerate();
            all.map(move |(at, statement)| ((piece, at), base, statement))
        })
    }

    /// Where an object is defined, the first place first.
    pub fn definitions(&self, object: Object) -> Vec<(usize, usize)> {
        self.in_order(self.catalogue.definitions(object))
    }

    /// The statements with a view name, in the order of the file.
    pub fn named(&self, name: &str) -> Vec<(usize, usize)> {
        self.in_order(self.catalogue.named(name))
    }

    /// The pieces that refer to an object, in their order.
    pub fn referring(&self, object: Object) -> Vec<usize> {
        let mut pieces: Vec<usize> = self
            .catalogue
            .referring(object)
            .filter_map(|key| self.places.get(&key).copied())
            .collect();
        pieces.sort_unstable();
        pieces
    }

    /// Every object with the place that defines it first.
    pub fn objects(&self) -> impl Iterator<Item = (Object, (usize, usize))> {
        let all = self.catalogue.objects();
        all.filter_map(|(object, places)| Some((object, *self.in_order(places).first()?)))
    }

    /// The body that a marker at a place follows.
    pub fn body_before(&self, (piece, at): (usize, usize)) -> Option<(usize, usize)> {
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
            .filter_map(|place| Some((*self.places.get(&place.piece)?, place.at)))
            .collect();
        found.sort_unstable();
        found
    }

    /// Renews where the pieces stand.
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

    /// The body that a marker at the beginning of a piece would follow.
    fn body_entering(&self, at: usize) -> Option<Object> {
        let before = &self.pieces.pieces()[..at];
        let all = before
            .iter()
            .rev()
            .flat_map(|p| p.statements().iter().rev());
        all.into_iter().find(|s| is_known_body(s))?.object()
    }

    /// Markers that follow the body of the pieces before `first`, and the pieces they are in.
    fn followers(&self, first: usize, affected: &mut BTreeSet<usize>) -> Vec<Object> {
        let mut found = Vec::new();
        for (at, piece) in self.pieces.pieces().iter().enumerate().skip(first) {
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

    /// Asks the rules of neighbours about the statements of some pieces.
    fn ask_neighbours(&mut self, pieces: &BTreeSet<usize>) {
        if self.is_command_file() {
            return;
        }
        let asked = pieces.iter().flat_map(|piece| {
            let count = self.pieces.pieces()[*piece].statements().len();
            (0..count).map(move |at| (*piece, at))
        });
        let excerpt = Excerpt::of(self, asked, Depth::One);
        let options = Options::default();
        let found = check_until(&excerpt.dataset, &options, Reach::Neighbours, || false);
        let mut new: HashMap<u32, Vec<Complaint>> = pieces
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
            let own: Vec<Complaint> = of_comments
                .iter()
                .flat_map(|silences| &silences.diagnostics)
                .filter_map(|found| self.anchored(shifted(found, base)))
                .collect();
            new.entry(piece.key()).or_default().extend(own);
        }
        self.near.extend(new);
    }

    fn is_silenced(&self, found: &Diagnostic) -> bool {
        // What is wrong with such a comment is told in any case.
        if self.silences.is_empty() || found.code == Code::UnknownKey {
            return false;
        }
        let everywhere = |silences: &Suppressed| silences.covers_file(found.code);
        if self.silences.values().any(everywhere) {
            return true;
        }
        let Some(label) = found.labels.first() else {
            return false;
        };
        let Some(at) = self.pieces.at(label.span.start()) else {
            return false;
        };
        let own = self.silences.get(&self.pieces.pieces()[at].key());
        let base = self.pieces.start(at);
        own.is_some_and(|silences| silences.covers_at(found.code, label.span.start() - base))
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

    fn anchored(&self, diagnostic: Diagnostic) -> Option<Complaint> {
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
        Some(Complaint {
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

    /// A complaint with its places as they are now; `None` if its own place is gone.
    fn resolved(&self, complaint: &Complaint) -> Option<Diagnostic> {
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

    /// The places of complaints of the whole file after an edit.
    fn moved(&self, edited: Span, length: usize) -> Vec<Moved> {
        let place = |anchor: Anchor| {
            let span = self.span_of(anchor);
            span.map_or(NewPlace::Gone, |span| new_place(span, edited, length))
        };
        let label = |anchor: &Option<Anchor>| anchor.map_or(NewPlace::Elsewhere, place);
        let complaints = self.far.iter();
        complaints
            .map(|complaint| Moved {
                labels: complaint.labels.iter().map(label).collect(),
                edits: complaint.edits.iter().map(|a| place(*a)).collect(),
            })
            .collect()
    }

    /// Gives complaints of the whole file their new places; those without one are gone until the next check.
    fn settle(&mut self, moved: Vec<Moved>) {
        let far = std::mem::take(&mut self.far);
        for (mut complaint, moved) in far.into_iter().zip(moved) {
            if moved.labels.first() == Some(&NewPlace::Gone) {
                continue;
            }
            complaint.labels.clear();
            let labels = std::mem::take(&mut complaint.diagnostic.labels);
            for (label, place) in labels.into_iter().zip(moved.labels) {
                let anchor = match place {
                    NewPlace::Gone => continue,
                    NewPlace::Elsewhere => None,
                    NewPlace::At(span) => self.anchor(span),
                };
                complaint.diagnostic.labels.push(label);
                complaint.labels.push(anchor);
            }
            let edit = |place: &NewPlace| match place {
                NewPlace::At(span) => self.anchor(*span),
                NewPlace::Gone | NewPlace::Elsewhere => None,
            };
            let edits: Option<Vec<Anchor>> = moved.edits.iter().map(edit).collect();
            if edits.is_none() {
                complaint.diagnostic.fix = None;
            }
            complaint.edits = edits.unwrap_or_default();
            self.far.push(complaint);
        }
    }
}

/// Where the places of a complaint will be after an edit: of its labels, and of the edits of its fix.
struct Moved {
    labels: Vec<NewPlace>,
    edits: Vec<NewPlace>,
}

/// Where a place will be after an edit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NewPlace {
    /// In another file.
    Elsewhere,
    /// The edit reaches it.
    Gone,
    /// Here.
    At(Span),
}

/// Where a span is once as many bytes as `length` are in place of `edited`.
fn new_place(span: Span, edited: Span, length: usize) -> NewPlace {
    if span.end() < edited.start() {
        return NewPlace::At(span);
    }
    if span.start() < edited.end() {
        return NewPlace::Gone;
    }
    let shift = |offset: usize| offset - edited.len() + length;
    NewPlace::At(Span::new(shift(span.start()), shift(span.end())))
}

/// What some pieces define, as far as others see it.
struct Definitions {
    of: BTreeMap<Object, Vec<u64>>,
    /// The body that markers behind them follow.
    body: Option<Object>,
}

impl Definitions {
    /// What pieces behind a body define.
    fn of(entering: Option<Object>, pieces: &[Arc<Piece>]) -> Self {
        let (mut of, mut body) = (BTreeMap::<Object, Vec<u64>>::new(), entering);
        for piece in pieces {
            for statement in piece.statements() {
                let Some(object) = statement.object() else {
                    continue;
                };
                if is_known_body(statement) {
                    body = Some(object);
                }
                let mut hasher = DefaultHasher::new();
                piece.source().slice(statement.span).hash(&mut hasher);
                let name = statement.view_name.map(|name| piece.source().slice(name));
                name.hash(&mut hasher);
                if statement.follows_body() {
                    body.hash(&mut hasher);
                }
                of.entry(object).or_default().push(hasher.finish());
            }
        }
        Self { of, body }
    }

    /// Objects that are not the same in both.
    fn differing(&self, other: &Self) -> Vec<Object> {
        let objects: BTreeSet<&Object> = self.of.keys().chain(other.of.keys()).collect();
        let differs = |object: &&Object| self.of.get(*object) != other.of.get(*object);
        objects.into_iter().filter(differs).copied().collect()
    }
}

/// A body whose markers need not name it, with an id.
fn is_known_body(statement: &Statement) -> bool {
    statement.carries_markers() && statement.object().is_some()
}

/// The pieces that are re-read, and of the others those that stand nearest.
fn nearest(affected: BTreeSet<usize>, edited: &std::ops::Range<usize>) -> BTreeSet<usize> {
    if affected.len() <= MOST_PIECES {
        return affected;
    }
    let mut all: Vec<usize> = affected.into_iter().collect();
    all.sort_by_key(|at| match at {
        at if edited.contains(at) => 0,
        at => at.abs_diff(edited.start).max(1),
    });
    all.truncate(MOST_PIECES.max(edited.len().min(4 * MOST_PIECES)));
    all.into_iter().collect()
}

/// A complaint of a piece with its places in the file.
fn shifted(found: &Diagnostic, base: usize) -> Diagnostic {
    let mut found = found.clone();
    let shift = |span: Span| Span::new(base + span.start(), base + span.end());
    for label in &mut found.labels {
        label.span = shift(label.span);
    }
    if let Some(fix) = &mut found.fix {
        for Edit { span, .. } in &mut fix.edits {
            *span = shift(*span);
        }
    }
    found
}

/// What is said and where that begins.
fn place(found: &Diagnostic) -> (Code, Option<usize>) {
    let label = found.labels.first();
    (found.code, label.map(|label| label.span.start()))
}
