use admire_syntax::units::{Dimension, Units};

use super::entity_kind::Shape;
use super::{Catalogue, Component, Entity, EntityKind};

/// Kinematic quantities of bodies that are stored. RESULTS/NODISPLACEMENTS, NOVELOCITIES and NOACCELERATIONS switch them off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Stored {
    /// True if the displacements of bodies are stored.
    pub displacements: bool,
    /// True if the velocities of bodies are stored.
    pub velocities: bool,
    /// True if the accelerations of bodies are stored.
    pub accelerations: bool,
}

impl Default for Stored {
    fn default() -> Self {
        Self {
            displacements: true,
            velocities: true,
            accelerations: true,
        }
    }
}

/// Builder of the catalogue for a run; it names and numbers the columns as ADAMS does (guide/formats.md 6.1, 12).
///
/// TIME has id 1. The displacements of all bodies follow, then the velocities of all bodies, then their accelerations.
///
/// The other objects come next, sorted by kind in the order of [`EntityKind`]; objects of the same kind have the order in which they were
/// added. The values in an output step have the same order as the columns.
#[derive(Clone, Debug)]
pub struct Numbering {
    units: Units,
    stored: Stored,
    objects: Vec<(EntityKind, Entity)>,
}

const LINEAR: [[&str; 3]; 3] = [
    ["X", "Y", "Z"],
    ["VX", "VY", "VZ"],
    ["ACCX", "ACCY", "ACCZ"],
];
const ANGULAR: [[&str; 3]; 3] = [
    ["PSI", "THETA", "PHI"],
    ["WX", "WY", "WZ"],
    ["WDX", "WDY", "WDZ"],
];

impl Numbering {
    /// Creates a builder without objects, for a dataset with the given units.
    pub fn new(units: Units, stored: Stored) -> Self {
        Self {
            units,
            stored,
            objects: Vec::new(),
        }
    }

    /// Adds an object with the columns that its kind has.
    ///
    /// `view_name` is the full ADAMS/View name (`.model.testrig.arm`); without it, the object is named by its kind and id. `channels` is
    /// the number of variables in a PINPUT or POUTPUT and is ignored for other kinds.
    pub fn object(&mut self, kind: EntityKind, view_name: Option<&str>, id: i64, channels: usize) {
        let components = match kind.shape() {
            Shape::Pose | Shape::Position | Shape::Named => Vec::new(),
            Shape::Place => self.kinematic(0, true),
            Shape::Force => self.force(false),
            Shape::ForceAndAngles => self.force(true),
            Shape::Value => vec![component("Q", None)],
            Shape::ValueAndDerivative => vec![component("Q", None), component("DQ", None)],
            Shape::Inputs => (1..=channels)
                .map(|n| component(format!("IN{n}"), None))
                .collect(),
            Shape::Outputs => (1..=channels)
                .map(|n| component(format!("OUT{n}"), None))
                .collect(),
        };
        self.add(kind, view_name, id, None, components);
    }

    /// Adds a request, or another object whose statement gives the names of the columns. Each column has an optional unit.
    pub fn named(
        &mut self,
        kind: EntityKind,
        view_name: Option<&str>,
        id: i64,
        comment: Option<&str>,
        columns: &[(&str, Option<&str>)],
    ) {
        let components = columns
            .iter()
            .map(|&(name, unit)| component(name, unit.map(str::to_string)))
            .collect();
        self.add(kind, view_name, id, comment, components);
    }

    fn add(
        &mut self,
        kind: EntityKind,
        view_name: Option<&str>,
        id: i64,
        comment: Option<&str>,
        components: Vec<Component>,
    ) {
        let object = view_name.map_or_else(|| kind.default_name(id), without_model);
        let last = object.rsplit('.').next().unwrap_or(&object);
        let suffix = if kind.is_body() || kind == EntityKind::FloatingMarker {
            "_XFORM"
        } else {
            ""
        };
        let entity = Entity {
            name: format!("{last}{suffix}"),
            ent_type: Some(kind.ent_type().to_string()),
            object_id: Some(id),
            comment: comment.map(str::to_string),
            components,
            entity: Some(object),
        };
        self.objects.push((kind, entity));
    }

    /// Assigns the ids of all columns and returns the catalogue.
    pub fn finish(mut self) -> Catalogue {
        let mut next = 1;
        let mut number = |components: &mut [Component]| {
            for component in components {
                component.id = next;
                next += 1;
            }
        };
        let mut time = vec![component("TIME", self.unit(Dimension::TIME))];
        number(&mut time);
        let mut objects = std::mem::take(&mut self.objects);
        objects.sort_by_key(|(kind, _)| *kind);
        let stored = [
            self.stored.displacements,
            self.stored.velocities,
            self.stored.accelerations,
        ];
        for order in (0..3).filter(|&order| stored[order]) {
            for (kind, entity) in objects.iter_mut().filter(|(kind, _)| kind.is_body()) {
                let mut more = self.kinematic(order, kind.shape() == Shape::Pose);
                number(&mut more);
                entity.components.append(&mut more);
            }
        }
        for (_, entity) in objects.iter_mut().filter(|(kind, _)| !kind.is_body()) {
            number(&mut entity.components);
        }
        let mut entities = vec![Entity {
            name: "time".to_string(),
            components: time,
            ..Entity::default()
        }];
        entities.extend(objects.into_iter().map(|(_, entity)| entity));
        Catalogue::new(entities)
    }

    fn unit(&self, dimension: Dimension) -> Option<String> {
        Some(self.units.name(dimension)).filter(|name| !name.is_empty())
    }

    /// Returns the displacement columns (`order` 0), velocity columns (1) or acceleration columns (2) of a body.
    fn kinematic(&self, order: usize, angles: bool) -> Vec<Component> {
        let time = -(order as i8);
        let linear = Dimension {
            time,
            ..Dimension::LENGTH
        };
        let angular = Dimension {
            time,
            ..Dimension::ANGLE
        };
        let mut components = self.each(&LINEAR[order], linear);
        if angles {
            components.extend(self.each(&ANGULAR[order], angular));
        }
        components
    }

    fn force(&self, angles: bool) -> Vec<Component> {
        let mut components = self.each(&["FX", "FY", "FZ"], Dimension::FORCE);
        components.extend(self.each(&["TX", "TY", "TZ"], Dimension::TORQUE));
        if angles {
            components.extend(self.each(&["ANGX", "ANGY", "ANGZ"], Dimension::ANGLE));
        }
        components
    }

    fn each(&self, names: &[&str], dimension: Dimension) -> Vec<Component> {
        names
            .iter()
            .map(|&name| component(name, self.unit(dimension)))
            .collect()
    }
}

fn component(name: impl Into<String>, units: Option<String>) -> Component {
    Component {
        name: name.into(),
        units,
        plot_label: None,
        id: 0,
    }
}

/// Removes the model name from a full name: `.model.testrig.arm` becomes `testrig.arm`.
///
/// A name without a leading dot contains no model name and is returned unchanged.
pub(super) fn without_model(view_name: &str) -> String {
    match view_name.strip_prefix('.') {
        Some(full) => full.split_once('.').map_or(full, |(_, object)| object),
        None => view_name,
    }
    .to_string()
}
