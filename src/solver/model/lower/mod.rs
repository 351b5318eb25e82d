//! Lowering of statements to the model. A command is overlaid on the statement it redefines, which is then lowered again.

mod activation;
mod constraint;
mod data;
mod definitions;
mod dimensions;
mod force;
mod frame;
mod friction;
mod ids;
mod reader;
mod rules;
mod settings;
mod statement;
mod unsolved;

pub use self::definitions::Definitions;
use self::ids::{Ids, is_body};
use self::reader::{Context, Overlays, Reader};
use self::statement::statement as lower_statement;
use self::unsolved::unsolved;
use super::{Header, Joint, MarkerIx, Model, Part, PartIx, PartKind, Unsolved};
use crate::mechanics::Pose;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::files::Files;
use admire_syntax::grammar::StatementDef;
use admire_syntax::hash::QuickMap;
use admire_syntax::{Dataset, Overlay, Stated, Statement, floating_faults};

/// Resolves a dataset without reading other files; see `lower_with`.
pub fn lower(dataset: &Dataset) -> Checked<Model> {
    lower_with(dataset, &Files::default())
}

/// Resolves a dataset with the given supplementary files; no other file is read.
///
/// Diagnostics report undefined and duplicate ids, missing arguments, wrong counts and invalid frames. The model is completed as far as
/// possible. If the diagnostics contain an error, the model must not be solved.
pub(crate) fn lower_with(dataset: &Dataset, files: &Files) -> Checked<Model> {
    let lowering = lowered(dataset, files);
    Checked {
        value: lowering.model,
        diagnostics: lowering.diagnostics,
    }
}

fn lowered<'a>(dataset: &'a Dataset, files: &'a Files) -> Lowering<'a> {
    let mut lowering = Lowering {
        dataset,
        files,
        ids: Ids::of(dataset),
        settings: Overlays::new(),
        model: Model {
            // In a file without line ends, the first line is the whole file.
            title: dataset.title().chars().take(LONGEST_TITLE).collect(),
            ..Model::default()
        },
        diagnostics: Vec::new(),
        unique: QuickMap::default(),
    };
    let first_of_its_id: Vec<bool> = dataset
        .statements()
        .iter()
        .enumerate()
        .map(|(at, statement)| lowering.is_first(at, statement))
        .collect();
    let mut im_parts = Vec::new();
    let mut body = None;
    for (at, statement) in dataset.statements().iter().enumerate() {
        if let Some(def) = statement.def
            && first_of_its_id[at]
        {
            if statement.carries_markers() {
                body = def.id.zip(statement.number());
            }
            lowering.frame(at, statement, def, body, &mut im_parts);
        }
    }
    lowering.finish_frames(&im_parts);
    let joints = std::mem::take(&mut lowering.model.joints);
    lowering
        .ids
        .set_joints(joints.iter().map(|joint| joint.header.id));
    for (at, statement) in dataset.statements().iter().enumerate() {
        if let Some(def) = statement.def
            && first_of_its_id[at]
        {
            lowering.rest(at, statement, def, &joints);
        }
    }
    lowering.model.joints = joints;
    lowering.splines_of_files();
    lowering
}

struct Lowering<'a> {
    dataset: &'a Dataset,
    files: &'a Files,
    ids: Ids,
    /// Current form of the statements without an id: each later statement is overlaid on the earlier ones.
    settings: Overlays,
    model: Model,
    diagnostics: Vec<Diagnostic>,
    /// First statement with each id, by id space.
    unique: QuickMap<(&'static str, u32), usize>,
}

impl Lowering<'_> {
    /// Returns whether a statement is the first with its id, and reports a duplicate.
    fn is_first(&mut self, at: usize, statement: &Statement) -> bool {
        let (Some(space), Some((id, span))) = (statement.def.and_then(|def| def.id), statement.id)
        else {
            return true;
        };
        if !self.ids.repeats() {
            return true;
        }
        let first = *self.unique.entry((space, id)).or_insert(at);
        if first == at {
            return true;
        }
        let source = self.dataset.source();
        let mut diagnostic = Diagnostic::error(
            Code::DuplicateId,
            format!(
                "{}/{id} is defined twice; the first definition is used",
                statement.kind().unwrap_or_default()
            ),
        )
        .label(source.name(), span, "defined again here");
        if let Some((_, span)) = self.dataset.statements()[first].id {
            diagnostic = diagnostic.label(source.name(), span, "first defined here");
        }
        self.diagnostics.push(diagnostic);
        false
    }

    /// Lowers a statement if it is a body, marker or joint; other statements refer to these by index. Skips all other statements.
    fn frame(
        &mut self,
        at: usize,
        statement: &Statement,
        def: &'static StatementDef,
        body: Option<(&'static str, u32)>,
        im_parts: &mut Vec<(PartIx, MarkerIx)>,
    ) {
        let is_body = is_body(def);
        if !(is_body || def.name == "MARKER" || def.name == "JOINT") || statement.id.is_none() {
            return;
        }
        let body = body.and_then(|(space, id)| self.ids.index(space, id));
        let context = Context {
            dataset: self.dataset,
            over: &self.settings,
            ids: &self.ids,
            joints: &[],
        };
        let stated = Stated::plain(statement, self.dataset.source());
        let mut reader = Reader::new(context, stated, def, at, &mut self.diagnostics);
        if is_body && let Some(im) = reader.marker("IM") {
            im_parts.push((PartIx(self.model.parts.len()), im));
        }
        lower_statement(&mut reader, body.map(PartIx), &mut self.model);
    }

    /// Completes the model data that depend on all bodies and markers. Checks that there is exactly one ground, places markers given
    /// relative to other markers, and converts inertia given about other markers.
    fn finish_frames(&mut self, im_parts: &[(PartIx, MarkerIx)]) {
        let source = self.dataset.source();
        let grounds: Vec<usize> = self
            .model
            .parts
            .iter()
            .filter(|part| part.kind == PartKind::Ground)
            .map(|part| part.header.origin)
            .collect();
        for extra in grounds.iter().skip(1) {
            let keyword = self.dataset.statements()[*extra].keyword;
            self.diagnostics.push(
                Diagnostic::error(Code::NoGround, "a dataset can have only one ground part").label(
                    source.name(),
                    keyword,
                    "a second ground part",
                ),
            );
        }
        if grounds.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(Code::NoGround, "the dataset has no ground part")
                    .label(source.name(), self.dataset.title_span(), "in this dataset")
                    .help("add a ground part, such as PART/1, GROUND"),
            );
            // A ground part keeps every body index valid.
            self.model.parts.push(ground());
        }
        for marker in frame::place_relative(&mut self.model) {
            let origin = self.model.markers[marker.0].header.origin;
            let keyword = self.dataset.statements()[origin].keyword;
            self.diagnostics.push(
                Diagnostic::error(
                    Code::UndefinedId,
                    "markers are defined relative to each other in a loop",
                )
                .label(source.name(), keyword, "this marker is part of the loop"),
            );
        }
        for (part, im) in im_parts {
            frame::inertia_about(&mut self.model, *part, *im);
        }
    }

    /// Reads splines from property files and converts them to the units of the model, which may be stated after the spline in the dataset.
    fn splines_of_files(&mut self) {
        for (at, statement) in self.dataset.statements().iter().enumerate() {
            let stated = Stated::plain(statement, self.dataset.source());
            let of_file = |_: &_| is_supplied(&stated, self.files);
            let Some(def) = statement
                .def
                .filter(|def| def.name == "SPLINE")
                .filter(of_file)
            else {
                continue;
            };
            let first = statement
                .number()
                .is_some_and(|id| self.dataset.position(def.name, Some(id)) == Some(at));
            if !first {
                continue;
            }
            let context = Context {
                dataset: self.dataset,
                over: &self.settings,
                ids: &self.ids,
                joints: &[],
            };
            let mut reader = Reader::new(context, stated, def, at, &mut self.diagnostics);
            let spline = data::spline_of_file(&mut reader, self.files, &self.model.units);
            self.model.splines.extend(spline);
        }
    }

    /// Lowers all other statements and applies the rules that hold for every statement.
    fn rest(
        &mut self,
        at: usize,
        statement: &Statement,
        def: &'static StatementDef,
        joints: &[Joint],
    ) {
        let source = self.dataset.source();
        if def.id.is_none() {
            self.settings
                .entry((def.name, None))
                .and_modify(|earlier| earlier.put(statement, source))
                .or_insert_with(|| Overlay::of(statement, source));
        }
        let context = Context {
            dataset: self.dataset,
            over: &self.settings,
            ids: &self.ids,
            joints,
        };
        let settings = def
            .id
            .is_none()
            .then(|| self.settings.get(&(def.name, None)));
        let stated = match settings.flatten() {
            Some(settings) => settings.stated(),
            None => Stated::plain(statement, source),
        };
        let diagnostics = &mut self.diagnostics;
        rules::check(source, statement, &self.ids, None, diagnostics);
        diagnostics.extend(floating_faults(statement, source, self.dataset));
        dimensions::check(stated, def, context, diagnostics);
        let moves = def.name == "MARKER" && frame::moves(&stated);
        let done = is_body(def) || def.name == "JOINT" || def.name == "MARKER" && !moves;
        if done && def.solved.only_adams().is_none() {
            return;
        }
        if def.id.is_some() && statement.id.is_none() {
            return;
        }
        if def.name == "SPLINE" && is_supplied(&stated, self.files) {
            return;
        }
        let known = diagnostics.len();
        let mut reader = Reader::new(context, stated, def, at, diagnostics);
        if let Some((code, why)) = unsolved(&reader) {
            self.model.unsolved.push(Unsolved {
                header: reader.header(),
                kind: def.name,
                code,
                why,
            });
            return;
        }
        lower_statement(&mut reader, None, &mut self.model);
        forget_repeated(&mut self.diagnostics, known);
    }
}

/// Returns whether a SPLINE takes its points from a file that was read. Returns false if points (X, Y) were given after FILE.
fn is_supplied(spline: &Stated, files: &Files) -> bool {
    spline.latest(&["FILE", "X", "Y"]).next() == Some("FILE")
        && spline
            .text("FILE")
            .is_some_and(|name| files.get(&name).is_some())
}

/// Removes diagnostics of the reader that repeat diagnostics of the grammar rules for the same statement.
fn forget_repeated(diagnostics: &mut Vec<Diagnostic>, known: usize) {
    let place = |diagnostic: &Diagnostic| {
        (
            diagnostic.code,
            diagnostic.labels.first().map(|label| label.span.start()),
        )
    };
    let mut at = known;
    while at < diagnostics.len() {
        let repeated = diagnostics[..known]
            .iter()
            .rev()
            .take(8)
            .any(|before| place(before) == place(&diagnostics[at]));
        if repeated {
            diagnostics.remove(at);
        } else {
            at += 1;
        }
    }
}

fn ground() -> Part {
    Part {
        header: Header {
            id: 0,
            name: "ground".into(),
            origin: 0,
            active: true,
        },
        kind: PartKind::Ground,
        mass: 0.0,
        cm: None,
        ip: [0.0; 6],
        pose: Pose::identity(),
        exact: [false; 6],
        start: super::InitialVelocity::default(),
    }
}

/// Maximum number of title characters kept.
const LONGEST_TITLE: usize = 4096;

impl Model {
    /// Resolves a dataset without reading other files; see [`lower`].
    pub fn lower(dataset: &Dataset) -> Checked<Self> {
        lower(dataset)
    }

    /// Resolves a dataset whose splines may be in the given files; see `lower_with`.
    pub fn lower_with(dataset: &Dataset, files: &Files) -> Checked<Self> {
        lower_with(dataset, files)
    }
}
