//! Summary of a model.

use std::collections::{BTreeMap, HashSet};

use super::{Model, PartKind};
use crate::mechanics::Vec3;
use admire_syntax::grammar::ValueKind;
use admire_syntax::{Dataset, Value};

/// Key facts about a model.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct Summary {
    /// Title: the first line of the dataset.
    pub title: String,
    /// Unit names of force, mass, length and time, such as `newton`, `kg`, `mm`, `sec`.
    pub units: [&'static str; 4],
    /// Whether the dataset states its units.
    pub units_stated: bool,
    /// Units consistency factor: force * UCF = mass * acceleration.
    pub ucf: f64,
    /// Number of statements for each full keyword, in alphabetical order. Statements with an unknown keyword count under `(unknown)`.
    pub statements: BTreeMap<&'static str, usize>,
    /// Total mass of all parts and point masses except ground.
    pub mass: f64,
    /// Centre of the total mass in ground axes, at the positions in the dataset. Absent if the total mass is zero.
    pub centre_of_mass: Option<[f64; 3]>,
    /// Ids and names of the markers that nothing refers to, in order of appearance.
    pub unused_markers: Vec<(u32, String)>,
    /// Whether USER subroutines are called. Their parameters can also refer to markers.
    pub calls_subroutines: bool,
    /// Kind, id and reason of each statement that the built-in solver leaves out.
    pub unsolved: Vec<(&'static str, u32, String)>,
}

/// Summarises a dataset and the model it was lowered to.
pub fn summary(dataset: &Dataset, model: &Model) -> Summary {
    let mut statements = BTreeMap::new();
    for statement in dataset.statements() {
        *statements
            .entry(statement.kind().unwrap_or("(unknown)"))
            .or_insert(0) += 1;
    }
    let (mass, moment) = model
        .parts
        .iter()
        .filter(|part| part.kind != PartKind::Ground)
        .fold((0.0, Vec3::zeros()), |(mass, moment), part| {
            let cm = part
                .cm
                .map_or(part.pose.p, |cm| part.pose.point(&model.markers[cm.0].qp));
            (mass + part.mass, moment + cm * part.mass)
        });
    let (used, calls_subroutines) = used_markers(dataset);
    let units = &model.units;
    Summary {
        title: model.title.clone(),
        units: [
            units.force.word,
            units.mass.word,
            units.length.word,
            units.time.word,
        ],
        units_stated: units.stated,
        ucf: units.ucf,
        statements,
        mass,
        centre_of_mass: (mass > 0.0).then(|| (moment / mass).into()),
        unused_markers: model
            .markers
            .iter()
            .filter(|marker| !used.contains(&marker.header.id))
            .map(|marker| (marker.header.id, marker.header.name.clone()))
            .collect(),
        calls_subroutines,
        unsolved: model
            .unsolved
            .iter()
            .map(|unsolved| (unsolved.kind, unsolved.header.id, unsolved.why.clone()))
            .collect(),
    }
}

/// Returns the ids of the markers that arguments or functions refer to, and whether the dataset contains USER calls.
fn used_markers(dataset: &Dataset) -> (HashSet<u32>, bool) {
    let mut used = HashSet::new();
    let mut calls = false;
    for argument in dataset
        .statements()
        .iter()
        .flat_map(|statement| &statement.arguments)
    {
        match (&argument.value, argument.def.map(|def| def.kind)) {
            (Value::Numbers(numbers), Some(ValueKind::Reference("marker"))) => {
                used.extend(numbers.iter().map(|number| number.value as u32));
            }
            (Value::Function(expression), _) => used.extend(
                expression
                    .references()
                    .into_iter()
                    .filter(|(space, _)| *space == "marker")
                    .map(|(_, literal)| expression.literals[literal].value as u32),
            ),
            (Value::User(_), _) => calls = true,
            _ => {}
        }
    }
    (used, calls)
}
