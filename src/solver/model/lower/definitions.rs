use super::activation::activate;
use super::ids::{Ids, is_body};
use super::reader::{Context, Overlays, Reader};
use super::statement::statement as lower_statement;
use super::unsolved::unsolved;
use super::{data, dimensions, frame, is_supplied, lowered, rules};
use crate::model::object::{EachList, Object};
use crate::model::{Header, Joint, Model, Part, PartIx, PartKind, Unsolved};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::grammar::StatementDef;
use admire_syntax::text::Source;
use admire_syntax::{Dataset, Overlay, Statement, as_id, floating_faults};

/// Statements that define a model: the statements of its dataset, with the commands overlaid on them.
#[derive(Clone, Debug)]
pub struct Definitions {
    dataset: Dataset,
    files: Files,
    ids: std::sync::Arc<Ids>,
    over: Overlays,
    /// Commands that have changed the model, one per line, as written.
    commands: Vec<u8>,
}

impl Definitions {
    /// Resolves a dataset as `lower_with` does, and keeps its definitions for later changes by commands.
    pub fn lower(dataset: &Dataset, files: &Files) -> Checked<(Model, Self)> {
        let lowering = lowered(dataset, files);
        let definitions = Self {
            dataset: dataset.clone(),
            files: files.clone(),
            ids: std::sync::Arc::new(lowering.ids),
            over: lowering.settings,
            commands: Vec::new(),
        };
        Checked {
            value: (lowering.model, definitions),
            diagnostics: lowering.diagnostics,
        }
    }

    /// Returns the dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Returns the commands that changed the model since it was resolved, in the form of a command file without its blank first line.
    pub fn commands(&self) -> &[u8] {
        &self.commands
    }

    /// Applies a command to the model.
    ///
    /// The command redefines an object (`SFORCE/3, FUNCTION=100`), changes settings (`EQUILIBRIUM/ERROR=1E-6`), or activates and
    /// deactivates objects (`DEACTIVATE/MOTION, ID=4`). The arguments of the command replace the same arguments of the statement, which is
    /// then lowered again. `source` is the command file. If the returned diagnostics contain an error, nothing is changed.
    pub fn redefine(
        &mut self,
        model: &mut Model,
        command: &Statement,
        source: &Source,
    ) -> Vec<Diagnostic> {
        let complaints = self.put_over(model, command, source);
        if !has_errors(&complaints) {
            self.commands.extend_from_slice(source.slice(command.span));
            self.commands.push(b'\n');
        }
        complaints
    }

    fn put_over(
        &mut self,
        model: &mut Model,
        command: &Statement,
        source: &Source,
    ) -> Vec<Diagnostic> {
        let Some(def) = command.def else {
            return Vec::new();
        };
        match def.name {
            "ACTIVATE" => return activate(model, command, source, true),
            "DEACTIVATE" => return activate(model, command, source, false),
            _ => {}
        }
        let mut diagnostics = Vec::new();
        let dataset = self.dataset.source();
        rules::check(source, command, &self.ids, Some(dataset), &mut diagnostics);
        diagnostics.extend(floating_faults(command, source, &self.dataset));
        if has_errors(&diagnostics) {
            return diagnostics;
        }
        let key = (def.name, command.number());
        let settings = def.id.is_none().then(|| Overlay::of(command, source));
        let Some(mut overlay) = self.statement(def, key.1).or(settings) else {
            // ADAMS prints this message and continues.
            let message = match command.number() {
                Some(id) => format!("{}/{id}", def.name),
                None => def.name.to_string(),
            } + " is not defined in the data set. Command ignored.";
            let span = command.id.map_or(command.keyword, |(_, span)| span);
            diagnostics.push(Diagnostic::warning(Code::UndefinedId, message).label(
                source.name(),
                span,
                "",
            ));
            return diagnostics;
        };
        overlay.put(command, source);
        if def.id.is_some() {
            let whole = overlay.under(command);
            rules::check_redefined(source, &whole, dataset, &mut diagnostics);
            if has_errors(&diagnostics) {
                return diagnostics;
            }
        }
        let before = self.over.insert(key, overlay);
        let mut complaints = Vec::new();
        self.lower_again(model, def, key.1, &mut complaints);
        if has_errors(&complaints) {
            match before {
                Some(before) => self.over.insert(key, before),
                None => self.over.remove(&key),
            };
        }
        // Faults of the dataset itself were reported when it was read.
        let of_command = |complaint: &Diagnostic| {
            complaint.severity == Severity::Error
                || complaint
                    .labels
                    .first()
                    .is_some_and(|label| *label.file == *source.name())
        };
        diagnostics.extend(complaints.into_iter().filter(of_command));
        diagnostics
    }

    /// Returns the current form of a statement, with all commands overlaid. Returns `None` if the dataset does not define the statement.
    pub fn statement(&self, def: &'static StatementDef, id: Option<u32>) -> Option<Overlay> {
        if let Some(overlay) = self.over.get(&(def.name, id)) {
            return Some(overlay.clone());
        }
        let statement = self.dataset.statement(def.name, Some(id?))?;
        Some(Overlay::of(statement, self.dataset.source()))
    }

    fn context<'a>(&'a self, joints: &'a [Joint]) -> Context<'a> {
        Context {
            dataset: &self.dataset,
            over: &self.over,
            ids: &self.ids,
            joints,
        }
    }

    /// Lowers the current form of a statement and replaces the object that the statement defined before.
    fn lower_again(
        &self,
        model: &mut Model,
        def: &'static StatementDef,
        id: Option<u32>,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let joints = std::mem::take(&mut model.joints);
        let lowered = self.lower_alone(model, &joints, def, id, diagnostics);
        model.joints = joints;
        let (Some(mut fresh), Some(id), false) = (lowered, id, has_errors(diagnostics)) else {
            return;
        };
        let mut find = Find {
            kind: def.name,
            id,
            found: None,
        };
        model.each_list(&mut Model::default(), &mut find);
        if let Some(header) = find.found {
            let mut replace = Replace {
                kind: def.name,
                header,
            };
            model.each_list(&mut fresh, &mut replace);
            self.finish_frame(model, def, id);
        }
    }

    /// Lowers a statement alone into an empty model. Settings are applied to `model` directly, and `None` is returned.
    fn lower_alone(
        &self,
        model: &mut Model,
        joints: &[Joint],
        def: &'static StatementDef,
        id: Option<u32>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Model> {
        let context = self.context(joints);
        let Some(id) = id else {
            let stated = self.over.get(&(def.name, None))?.stated();
            let mut reader = Reader::new(context, stated, def, 0, diagnostics);
            lower_statement(&mut reader, None, model);
            return None;
        };
        let stated = context.stated(def.name, id)?;
        let origin = self.dataset.position(def.name, Some(id))?;
        dimensions::check(stated, def, context, diagnostics);
        let mut reader = Reader::new(context, stated, def, origin, diagnostics);
        let mut fresh = Model::default();
        if def.name == "SPLINE" && is_supplied(&stated, &self.files) {
            let spline = data::spline_of_file(&mut reader, &self.files, &model.units);
            fresh.splines.extend(spline);
            return Some(fresh);
        }
        let why = unsolved(&reader);
        if why.is_none() || is_body(def) || def.name == "MARKER" {
            let own = |marker: usize| model.markers.get(marker).map(|marker| marker.part);
            let body = self.ids.index("marker", id).and_then(own);
            lower_statement(&mut reader, body, &mut fresh);
        }
        if let Some((code, why)) = why {
            let message = format!("{} is not solved: {why}", reader.called());
            let (source, span) = reader.latest_keyword();
            reader.complain(Diagnostic::warning(code, message), source, span);
            fresh.unsolved.push(Unsolved {
                header: reader.header(),
                kind: def.name,
                code,
                why,
            });
        }
        let is_ground = |parts: &[Part]| {
            let own = parts.iter().find(|part| part.header.id == id);
            own.is_some_and(|part| part.kind == PartKind::Ground)
        };
        if def.name == "PART" && is_ground(&fresh.parts) != is_ground(&model.parts) {
            let message = format!(
                "a command cannot change whether {} is the ground part",
                reader.called()
            );
            let (source, span) = reader.latest_keyword();
            reader.complain(Diagnostic::error(Code::NoGround, message), source, span);
        }
        Some(fresh)
    }

    /// Recomputes the data of the model that depend on a redefined body or marker: frames given relative to RM, and inertia given about IM.
    fn finish_frame(&self, model: &mut Model, def: &'static StatementDef, id: u32) {
        let Some(stated) = self.context(&[]).stated(def.name, id) else {
            return;
        };
        let marker = |name: &str| self.ids.marker(as_id(stated.first(name)?)?);
        let Some(at) = def.id.and_then(|space| self.ids.index(space, id)) else {
            return;
        };
        if def.name == "MARKER" || is_body(def) {
            frame::place_relative(model);
        }
        if is_body(def)
            && let Some(im) = marker("IM")
        {
            frame::inertia_about(model, PartIx(at), im);
        }
    }
}

/// Visitor of the model's lists that finds the header of an object.
struct Find {
    kind: &'static str,
    id: u32,
    found: Option<Header>,
}

impl EachList for Find {
    fn list<T: Object>(&mut self, list: &mut Vec<T>, _: &mut Vec<T>) {
        let own = |object: &&T| object.is(self.kind) && object.header().id == self.id;
        if self.found.is_none() && T::may_be(self.kind) {
            self.found = list.iter().find(own).map(|object| object.header().clone());
        }
    }
}

/// Visitor of the model's lists that replaces the object with the given header by a new object. If one statement defines objects in several
/// lists, each object is replaced in its list.
struct Replace {
    kind: &'static str,
    header: Header,
}

impl EachList for Replace {
    fn list<T: Object>(&mut self, list: &mut Vec<T>, fresh: &mut Vec<T>) {
        let own = |object: &T| object.is(self.kind) && object.header().id == self.header.id;
        let old = T::may_be(self.kind).then(|| list.iter().position(own));
        match (old.flatten(), fresh.pop()) {
            (Some(at), Some(mut new)) => {
                *new.header_mut() = self.header.clone();
                list[at] = new;
            }
            (Some(at), None) => {
                list.remove(at);
            }
            (None, Some(mut new)) => {
                *new.header_mut() = self.header.clone();
                let origin = self.header.origin;
                let at = list.partition_point(|object| object.header().origin < origin);
                list.insert(at, new);
            }
            (None, None) => {}
        }
    }
}

fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|d| d.severity == Severity::Error)
}
