//! Extraction of parts with their attached elements as a separate dataset.

use std::collections::{BTreeMap, BTreeSet};

use super::{Model, PartKind};
use crate::mechanics::psi_theta_phi;
use admire_syntax::car_field::CarField;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::Edit;
use admire_syntax::{Dataset, NewStatement, ObjectId, Removal, Statement, Topology};

/// Returns the edits that reduce a dataset to some bodies, the elements attached to them, and the objects that these elements refer to.
///
/// Markers on other bodies become ground markers at their design position. The elements then act on the bodies as if the rest of the model
/// were at rest.
///
/// The diagnostics are warnings about functions that measure markers which are now at rest.
///
/// # Errors
/// Returns `no-ground` if there is no ground part. Returns `unknown-target` if an element needs an object that is not attached to the
/// bodies, or a marker on a body whose position only ADAMS can compute.
pub fn extract(
    dataset: &Dataset,
    model: &Model,
    bodies: &BTreeSet<ObjectId>,
) -> Result<Checked<Vec<Edit>>, Diagnostic> {
    let statements = dataset.statements();
    let ground = model.ground().ok_or_else(|| {
        Diagnostic::error(
            Code::NoGround,
            "the dataset has no ground part to attach the extract to",
        )
    })?;
    let ground: ObjectId = ("part", model.parts[ground.0].header.id);
    let topology = Topology::of(dataset);
    let places: BTreeMap<ObjectId, usize> = statements
        .iter()
        .enumerate()
        .rev()
        .filter_map(|(at, statement)| Some((statement.object()?, at)))
        .collect();
    let mut chosen = Chosen {
        dataset,
        places: &places,
        bodies,
        ground,
        topology: &topology,
        bushings: CarField::all(dataset)
            .filter_map(|(field, read)| Some((field.number()?, read.ok()?)))
            .collect(),
        kept: BTreeSet::new(),
        measured: Vec::new(),
    };
    for (at, statement) in statements.iter().enumerate() {
        let own = statement
            .object()
            .is_some_and(|object| bodies.contains(&object) || object == ground);
        let of_marker = statement.kind() == Some("MARKER")
            && statement
                .number()
                .and_then(|id| topology.body(id))
                .is_some_and(|body| bodies.contains(&body));
        let touches = !statement.is_body()
            && statement.kind() != Some("MARKER")
            && topology
                .attached(statement)
                .iter()
                .any(|body| bodies.contains(body));
        // Settings have no id and are kept; arguments of settings that refer to removed objects are deleted below.
        if own || of_marker || touches || statement.object().is_none() {
            chosen.kept.insert(at);
        }
    }
    chosen.close()?;
    chosen.driven();
    chosen.close()?;
    let removed: BTreeSet<usize> = (0..statements.len())
        .filter(|at| !chosen.kept.contains(at))
        .collect();
    let mut removal = Removal {
        statements: removed,
        arguments: BTreeSet::new(),
    };
    for at in &chosen.kept {
        let statement = &statements[*at];
        if statement.object().is_some() && !statement.is_body() {
            continue;
        }
        for (k, argument) in statement.arguments.iter().enumerate() {
            let lost = argument.references().iter().any(|reference| {
                places
                    .get(&(reference.space, reference.id))
                    .is_some_and(|place| removal.statements.contains(place))
            });
            if lost {
                removal.arguments.insert((*at, k));
            }
        }
    }
    let mut edits = dataset.removal_edits(&removal);
    for at in &chosen.kept {
        let statement = &statements[*at];
        if statement.kind() == Some("MARKER")
            && let Some(id) = statement.number()
            && let Some(body) = topology.body(id)
            && body != ground
            && !bodies.contains(&body)
        {
            edits.push(on_ground(dataset, model, statement, ground.1)?);
        }
    }
    Ok(Checked {
        value: edits,
        diagnostics: chosen.measured,
    })
}

struct Chosen<'a> {
    dataset: &'a Dataset,
    places: &'a BTreeMap<ObjectId, usize>,
    bodies: &'a BTreeSet<ObjectId>,
    ground: ObjectId,
    topology: &'a Topology,
    /// FIELDs of Adams/Car by id, with the curves and arrays that they name.
    bushings: BTreeMap<u32, CarField>,
    kept: BTreeSet<usize>,
    measured: Vec<Diagnostic>,
}

impl Chosen<'_> {
    /// Adds the objects that the kept statements refer to.
    fn close(&mut self) -> Result<(), Diagnostic> {
        let mut open: Vec<usize> = self.kept.iter().copied().collect();
        while let Some(at) = open.pop() {
            let statement = &self.dataset.statements()[at];
            if statement.object().is_none() {
                continue;
            }
            let field = statement
                .number()
                .filter(|_| statement.kind() == Some("FIELD"));
            if let Some(car) = field.and_then(|id| self.bushings.get(&id)) {
                let curves = car.curves.iter().map(|id| ("spline", *id));
                let arrays = car.arrays.iter().map(|id| ("array", *id));
                let named = curves.chain(arrays);
                self.kept
                    .extend(named.filter_map(|object| self.places.get(&object)));
            }
            for argument in &statement.arguments {
                for reference in argument.references() {
                    let Some(&place) = self.places.get(&(reference.space, reference.id)) else {
                        continue;
                    };
                    let named = &self.dataset.statements()[place];
                    if named.is_body() {
                        // A reference to a body adds nothing: markers on other bodies are placed on ground afterwards.
                        continue;
                    }
                    if !self.kept.contains(&place) {
                        if !is_data(named) {
                            return Err(self.refuse(statement, named));
                        }
                        self.kept.insert(place);
                        open.push(place);
                    }
                    if matches!(argument.value, admire_syntax::Value::Function(_)) {
                        self.measures(statement, named);
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds motions, friction, couplers and graphics that refer to joints and forces, if all objects they refer to are kept.
    fn driven(&mut self) {
        for (at, statement) in self.dataset.statements().iter().enumerate() {
            let names: Vec<usize> = statement
                .arguments
                .iter()
                .flat_map(admire_syntax::Argument::references)
                .filter_map(|reference| self.places.get(&(reference.space, reference.id)).copied())
                .collect();
            let of_elements = names.iter().any(|place| {
                let named = &self.dataset.statements()[*place];
                !named.is_body() && !is_data(named)
            });
            if of_elements
                && !self.kept.contains(&at)
                && names.iter().all(|place| self.kept.contains(place))
            {
                self.kept.insert(at);
            }
        }
    }

    fn measures(&mut self, statement: &Statement, marker: &Statement) {
        let body = marker.number().and_then(|id| self.topology.body(id));
        if marker.kind() == Some("MARKER")
            && body.is_some_and(|body| body != self.ground && !self.bodies.contains(&body))
        {
            let message = format!(
                "{} measures {}, which is at rest in the extract",
                title(self.dataset, statement),
                title(self.dataset, marker)
            );
            if self.measured.iter().all(|found| found.message != message) {
                self.measured.push(
                    Diagnostic::warning(Code::UnknownTarget, message)
                        .label(self.dataset.source().name(), statement.keyword, "")
                        .help("extract the other part, too, if its motion matters"),
                );
            }
        }
    }

    fn refuse(&self, statement: &Statement, named: &Statement) -> Diagnostic {
        let message = format!(
            "{} needs {}, which is not attached to the extracted bodies",
            title(self.dataset, statement),
            title(self.dataset, named)
        );
        Diagnostic::error(Code::UnknownTarget, message)
            .label(self.dataset.source().name(), statement.keyword, "")
            .help("extract one of its parts, too")
    }
}

/// Returns whether a statement is data: other statements use it, and it is attached to no body. Data are kept if a kept statement refers to them.
fn is_data(statement: &Statement) -> bool {
    matches!(
        statement.kind(),
        Some(
            "MARKER"
                | "SPLINE"
                | "CURVE"
                | "SURFACE"
                | "VARIABLE"
                | "ARRAY"
                | "MATRIX"
                | "STRING"
                | "DIFF"
                | "LSE"
                | "GSE"
                | "TFSISO"
                | "SENSOR"
                | "PINPUT"
                | "POUTPUT"
                | "PSTATE"
                | "MATERIAL"
                | "SECTION"
                | "GRAPHICS"
        )
    )
}

fn title(dataset: &Dataset, statement: &Statement) -> String {
    let kind = statement.kind().unwrap_or("statement");
    let id = statement.number().unwrap_or_default();
    match statement.view_name {
        Some(name) => format!("{kind}/{id} ({})", dataset.source().text(name)),
        None => format!("{kind}/{id}"),
    }
}

/// Returns the edit that places a marker on ground at its design position.
fn on_ground(
    dataset: &Dataset,
    model: &Model,
    statement: &Statement,
    ground: u32,
) -> Result<Edit, Diagnostic> {
    let id = statement.number().unwrap_or_default();
    let found = model.marker(id).map(|index| &model.markers[index.0]);
    let part = found.map(|marker| &model.parts[marker.part.0]);
    let (Some(marker), Some(part)) = (found, part.filter(|part| part.kind != PartKind::External))
    else {
        let message = format!(
            "the position of {} is computed only by ADAMS",
            title(dataset, statement)
        );
        return Err(Diagnostic::error(Code::UnknownTarget, message)
            .label(dataset.source().name(), statement.keyword, "")
            .help("extract the body of this marker, too"));
    };
    let mut arguments = vec![("PART".to_string(), Some(ground.to_string()))];
    if marker.floating {
        arguments.push(("FLOATING".to_string(), None));
    } else {
        let p = part.pose.point(&marker.qp);
        let angles = psi_theta_phi(&(part.pose.R * marker.R));
        let list = |values: [f64; 3], suffix: &str| {
            values
                .map(|value| format!("{}{suffix}", rounded(value)))
                .join(", ")
        };
        arguments.push(("QP".to_string(), Some(list([p.x, p.y, p.z], ""))));
        arguments.push((
            "REULER".to_string(),
            Some(list(angles.map(f64::to_degrees), "D")),
        ));
    }
    let new = NewStatement {
        kind: "MARKER".to_string(),
        id: Some(id),
        view_name: None,
        arguments,
    };
    Ok(Edit::new(statement.span, dataset.written(&new)))
}

/// Rounds to fifteen significant digits, and sets the round-off of rotations to zero.
fn rounded(value: f64) -> f64 {
    let value: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    if value.abs() < 1e-12 { 0.0 } else { value }
}
