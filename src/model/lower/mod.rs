//! From statements to the model, and from commands to changes of it: one code path for both.

mod constraint;
mod data;
mod dimensions;
mod force;
mod frame;
mod friction;
mod ids;
mod reader;
mod rules;
mod settings;
mod unsolved;

use self::ids::{BODIES, Ids};
use self::reader::Reader;
use self::unsolved::unsolved;
use super::{Header, Joint, MarkerIx, Model, Part, PartIx, PartKind, Unsolved, object::Object};
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::grammar::{Solved, StatementDef};
use crate::mechanics::Pose;
use crate::syntax::files::Files;
use crate::syntax::hash::QuickMap;
use crate::syntax::{Dataset, Statement};
use crate::text::Source;

/// Calls `$do!(list, function that reads it, arguments...)` for the model's list that holds a kind of statement, or
/// `$none` for the others. Bodies, markers and settings are not among them.
macro_rules! in_list {
    ($kind:expr, $none:expr, $do:ident, $($arguments:tt)*) => {
        match $kind {
            "JPRIM" => $do!(primitives, constraint::primitive, $($arguments)*),
            "COUPLER" => $do!(couplers, constraint::coupler, $($arguments)*),
            "GEAR" => $do!(gears, constraint::gear, $($arguments)*),
            "FRICTION" => $do!(frictions, friction::friction, $($arguments)*),
            "GCON" => $do!(gcons, constraint::gcon, $($arguments)*),
            "MOTION" => $do!(motions, constraint::motion, $($arguments)*),
            "BUSHING" => $do!(bushings, force::bushing, $($arguments)*),
            "SPRINGDAMPER" => $do!(springdampers, force::springdamper, $($arguments)*),
            "SFORCE" => $do!(sforces, force::sforce, $($arguments)*),
            "GFORCE" | "VFORCE" | "VTORQUE" => {
                $do!(vector_forces, force::vector_force, $($arguments)*)
            }
            "NFORCE" => $do!(nforces, force::nforce, $($arguments)*),
            "VARIABLE" => $do!(variables, data::variable, $($arguments)*),
            "DIFF" => $do!(diffs, data::diff, $($arguments)*),
            "LSE" | "TFSISO" => $do!(linear_states, data::linear_states, $($arguments)*),
            "ARRAY" => $do!(arrays, data::array, $($arguments)*),
            "SPLINE" => $do!(splines, data::spline, $($arguments)*),
            "STRING" => $do!(strings, data::string, $($arguments)*),
            "SENSOR" => $do!(sensors, data::sensor, $($arguments)*),
            "PINPUT" | "POUTPUT" => $do!(plant_ports, data::plant_port, $($arguments)*),
            "REQUEST" => $do!(requests, data::request, $($arguments)*),
            kind if force::is_pair_force(kind) => {
                $do!(pair_forces, force::pair_force, $($arguments)*)
            }
            _ => $none,
        }
    };
}

/// Resolves a dataset without looking at other files; see `lower_with`.
pub fn lower(dataset: &Dataset) -> Checked<Model> {
    lower_with(dataset, &Files::default())
}

/// Resolves a dataset. Complaints: undefined and duplicate ids, missing arguments, wrong counts, frames that cannot be made.
/// The model is as good as it could be made; with errors among the complaints it must not be solved. What `files` do not hold is
/// not read.
pub fn lower_with(dataset: &Dataset, files: &Files) -> Checked<Model> {
    let mut lowering = Lowering {
        dataset,
        files,
        ids: Ids::of(dataset),
        model: Model {
            // A file without line ends is all title.
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
    let mut rm_markers = Vec::new();
    let mut im_parts = Vec::new();
    let mut body = None;
    for (at, statement) in dataset.statements().iter().enumerate() {
        if let Some(def) = statement.def
            && first_of_its_id[at]
        {
            if statement.carries_markers() {
                body = def.id.zip(statement.number());
            }
            lowering.frame(at, statement, def, body, &mut rm_markers, &mut im_parts);
        }
    }
    lowering.finish_frames(&rm_markers, &im_parts);
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
    Checked {
        value: lowering.model,
        diagnostics: lowering.diagnostics,
    }
}

struct Lowering<'a> {
    dataset: &'a Dataset,
    files: &'a Files,
    ids: Ids<'a>,
    model: Model,
    diagnostics: Vec<Diagnostic>,
    /// The statement that has an id first, by id space.
    unique: QuickMap<(&'static str, u32), usize>,
}

impl Lowering<'_> {
    /// False, with a complaint, for a statement whose id is taken.
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
                "{}/{id} is defined twice; the first one counts",
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

    /// Bodies, markers and joints: what others refer to by place.
    fn frame(
        &mut self,
        at: usize,
        statement: &Statement,
        def: &'static StatementDef,
        body: Option<(&'static str, u32)>,
        rm_markers: &mut Vec<(MarkerIx, MarkerIx)>,
        im_parts: &mut Vec<(PartIx, MarkerIx)>,
    ) {
        let is_body = is_body(def);
        if !(is_body || def.name == "MARKER" || def.name == "JOINT") || statement.id.is_none() {
            return;
        }
        let (ids, diagnostics) = (&self.ids, &mut self.diagnostics);
        let mut reader = Reader::of_dataset(self.dataset, at, def, ids, &[], diagnostics);
        if is_body {
            let part = frame::part(&mut reader, None);
            if let Some(im) = reader.marker("IM", None) {
                im_parts.push((PartIx(self.model.parts.len()), im));
            }
            self.model.parts.extend(part);
        } else if def.name == "MARKER" {
            let marker = frame::marker_after(&mut reader, body);
            if let Some(rm) = frame::rm_of(statement, &self.ids) {
                rm_markers.push((MarkerIx(self.model.markers.len()), rm));
            }
            self.model.markers.extend(marker);
        } else {
            let joint = constraint::joint(&mut reader, None);
            self.model.joints.extend(joint);
        }
    }

    /// What needs all bodies and markers: exactly one ground, frames given in other frames, inertia given about other markers.
    fn finish_frames(
        &mut self,
        rm_markers: &[(MarkerIx, MarkerIx)],
        im_parts: &[(PartIx, MarkerIx)],
    ) {
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
                Diagnostic::error(Code::NoGround, "a dataset has one ground part only").label(
                    source.name(),
                    keyword,
                    "a second one",
                ),
            );
        }
        if grounds.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(Code::NoGround, "no part is the ground")
                    .label(source.name(), self.dataset.title_span(), "in this dataset")
                    .help("add a part at rest: PART/1, GROUND"),
            );
            // Every index of a body stays valid.
            self.model.parts.push(ground());
        }
        for marker in frame::resolve_rm(&mut self.model, rm_markers) {
            let origin = self.model.markers[marker.0].header.origin;
            let keyword = self.dataset.statements()[origin].keyword;
            self.diagnostics.push(
                Diagnostic::error(
                    Code::UndefinedId,
                    "markers are given in each other's frames",
                )
                .label(source.name(), keyword, "in a circle with this one"),
            );
        }
        for (part, im) in im_parts {
            let part = &mut self.model.parts[part.0];
            if let Some(cm) = part.cm.filter(|cm| cm != im) {
                let (cm, im) = (&self.model.markers[cm.0], &self.model.markers[im.0]);
                frame::inertia_at_cm(part, cm, im);
            }
        }
    }

    /// True for a SPLINE whose file was read.
    fn is_supplied(&self, statement: &Statement) -> bool {
        statement.kind() == Some("SPLINE")
            && statement
                .text("FILE", self.dataset.source())
                .is_some_and(|name| self.files.get(&name).is_some())
    }

    /// Splines from other files: they are turned into the units of the model, which may be stated behind them.
    fn splines_of_files(&mut self) {
        for (at, statement) in self.dataset.statements().iter().enumerate() {
            let Some(def) = statement.def.filter(|_| self.is_supplied(statement)) else {
                continue;
            };
            let first = statement
                .number()
                .is_some_and(|id| self.dataset.position(def.name, Some(id)) == Some(at));
            if !first {
                continue;
            }
            let (ids, diagnostics) = (&self.ids, &mut self.diagnostics);
            let mut reader = Reader::of_dataset(self.dataset, at, def, ids, &[], diagnostics);
            let spline = data::spline_of_file(&mut reader, self.files, &self.model.units);
            self.model.splines.extend(spline);
        }
    }

    /// Everything else, and the rules that hold for every statement.
    fn rest(
        &mut self,
        at: usize,
        statement: &Statement,
        def: &'static StatementDef,
        joints: &[Joint],
    ) {
        let source = self.dataset.source();
        rules::check(
            source,
            statement,
            def,
            &self.ids,
            true,
            &mut self.diagnostics,
        );
        dimensions::check(source, statement, def, &self.ids, &mut self.diagnostics);
        let done =
            is_body(def) || def.name == "JOINT" || def.name == "MARKER" && !frame::moves(statement);
        if done && !matches!(def.solved, Solved::External(_)) {
            return;
        }
        if def.id.is_some() && statement.id.is_none() {
            return;
        }
        if self.is_supplied(statement) {
            return;
        }
        if let Some(why) = unsolved(statement, def, source) {
            self.model.unsolved.push(Unsolved {
                header: Header {
                    id: statement.number().unwrap_or(0),
                    name: self.dataset.name(statement).into_owned(),
                    origin: at,
                    active: true,
                },
                kind: def.name,
                why,
            });
            return;
        }
        let known = self.diagnostics.len();
        let (ids, diagnostics) = (&self.ids, &mut self.diagnostics);
        let mut reader = Reader::of_dataset(self.dataset, at, def, ids, joints, diagnostics);
        macro_rules! push {
            ($list:ident, $read:path, ) => {
                self.model.$list.extend($read(&mut reader, None))
            };
        }
        in_list!(
            def.name,
            {
                settings::settings(&mut reader, &mut self.model);
            },
            push,
        );
        forget_repeated(&mut self.diagnostics, known);
    }
}

/// True for PART, POINT_MASS and the bodies only real ADAMS solves.
fn is_body(def: &StatementDef) -> bool {
    def.id.is_some_and(|space| BODIES.contains(&space))
}

/// What a rule of the grammar has said already is not said again by the reader of the same statement.
fn forget_repeated(diagnostics: &mut Vec<Diagnostic>, known: usize) {
    let place = |diagnostic: &Diagnostic| {
        (
            diagnostic.code,
            diagnostic.labels.first().map(|label| label.span),
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

/// More characters of a first line are no title.
const LONGEST_TITLE: usize = 4096;

impl Model {
    /// Resolves a dataset without looking at other files; see [`lower`].
    pub fn lower(dataset: &Dataset) -> Checked<Self> {
        lower(dataset)
    }

    /// Resolves a dataset whose splines may stand in other files; see `lower_with`.
    pub fn lower_with(dataset: &Dataset, files: &Files) -> Checked<Self> {
        lower_with(dataset, files)
    }

    /// Applies a command that redefines an object (`SFORCE/3, FUNCTION=100`), changes settings (`EQUILIBRIUM/ERROR=1E-6`), or
    /// turns objects on and off (`DEACTIVATE/MOTION, ID=4`): only what is given changes. `source` is the command file.
    pub fn redefine(&mut self, command: &Statement, source: &Source) -> Vec<Diagnostic> {
        let mut diagnostics = Vec::new();
        let Some(def) = command.def else {
            return diagnostics;
        };
        match def.name {
            "ACTIVATE" => self.activate(command, source, true, &mut diagnostics),
            "DEACTIVATE" => self.activate(command, source, false, &mut diagnostics),
            _ => self.change(command, def, source, &mut diagnostics),
        }
        diagnostics
    }

    fn change(
        &mut self,
        command: &Statement,
        def: &'static StatementDef,
        source: &Source,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let ids = Ids::Model(self);
        rules::check(source, command, def, &ids, false, diagnostics);
        let mut reader = Reader {
            source,
            statement: command,
            def,
            ids: &ids,
            joints: &self.joints,
            diagnostics,
            origin: 0,
            dataset: None,
        };
        let Some(id) = command.number() else {
            let mut settings = Settings::of(self);
            if settings::settings(&mut reader, &mut settings.0) {
                settings.put_back(self);
            }
            return;
        };
        if let Some(unsolved) = self
            .unsolved
            .iter()
            .find(|unsolved| unsolved.kind == def.name && unsolved.header.id == id)
        {
            let diagnostic = Diagnostic::warning(
                Code::NotSolvedNatively,
                format!("{} is not solved: {}", reader.called(), unsolved.why),
            );
            reader.complain(diagnostic, command.keyword);
            return;
        }
        macro_rules! replace {
            ($list:ident, $read:path, ) => {{
                let is_it =
                    |object: &_| Object::header(object).id == id && Object::is(object, def.name);
                match self.$list.iter().position(is_it) {
                    Some(at) => {
                        if let Some(new) = $read(&mut reader, Some(&self.$list[at])) {
                            self.$list[at] = new;
                        }
                    }
                    None => undefined(&mut reader),
                }
            }};
        }
        match def.name {
            "PART" | "POINT_MASS" | "FLEX_BODY" => replace!(parts, frame::part,),
            "MARKER" => {
                let rm = frame::rm_of(command, &ids);
                replace!(markers, frame::marker,);
                if let (Some(rm), Some(marker)) = (rm, self.marker(id)) {
                    frame::place_in(self, marker, rm);
                }
            }
            "JOINT" => replace!(joints, constraint::joint,),
            kind => in_list!(kind, {}, replace,),
        }
    }

    fn activate(
        &mut self,
        command: &Statement,
        source: &Source,
        active: bool,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let numbers = |name: &str| -> Vec<u32> {
            command
                .numbers(name)
                .iter()
                .filter_map(|number| reader::as_id(number.value))
                .collect()
        };
        let (ids, range) = (numbers("ID"), numbers("RANGE"));
        let chosen = |id: u32| {
            ids.contains(&id)
                || matches!(range[..], [from, to] if (from..=to).contains(&id))
                || command.has("ALL")
        };
        for kind in command
            .arguments
            .iter()
            .filter_map(crate::syntax::Argument::kind)
        {
            let mut found = 0;
            macro_rules! set {
                ($list:ident, $read:path, ) => {
                    for object in &mut self.$list {
                        if Object::is(object, kind) && chosen(Object::header(object).id) {
                            Object::header_mut(object).active = active;
                            found += 1;
                        }
                    }
                };
            }
            match kind {
                "JOINT" => set!(joints, constraint::joint,),
                kind => in_list!(kind, {}, set,),
            }
            for unsolved in &mut self.unsolved {
                if unsolved.kind == kind && chosen(unsolved.header.id) {
                    unsolved.header.active = active;
                    found += 1;
                }
            }
            let is_kind = !matches!(kind, "ID" | "RANGE" | "ALL");
            if is_kind && found == 0 && !matches!(kind, "FRICTION" | "CLEARANCE" | "FEMDATA") {
                diagnostics.push(
                    Diagnostic::warning(Code::UndefinedId, format!("no {kind} has such an id"))
                        .label(source.name(), command.span, ""),
                );
            }
        }
    }
}

fn undefined(reader: &mut Reader) {
    // The words of ADAMS, which goes on all the same.
    let diagnostic = Diagnostic::warning(
        Code::UndefinedId,
        format!(
            "{} is not defined in the data set. Command ignored.",
            reader.called()
        ),
    );
    let span = reader
        .statement
        .id
        .map_or(reader.statement.keyword, |(_, span)| span);
    reader.complain(diagnostic, span);
}

/// The settings of a model apart from its objects, while the objects are read for ids.
struct Settings(Model);

impl Settings {
    fn of(model: &Model) -> Self {
        Self(Model {
            gravity: model.gravity,
            units: model.units,
            equilibrium: model.equilibrium.clone(),
            integrator: model.integrator.clone(),
            kinematics: model.kinematics.clone(),
            output: model.output.clone(),
            results: model.results.clone(),
            ..Model::default()
        })
    }

    fn put_back(self, model: &mut Model) {
        model.gravity = self.0.gravity;
        model.units = self.0.units;
        model.equilibrium = self.0.equilibrium;
        model.integrator = self.0.integrator;
        model.kinematics = self.0.kinematics;
        model.output = self.0.output;
        model.results = self.0.results;
    }
}
