use admire_results::{Catalogue, EntityKind, Numbering, Stored};
use admire_solver::model::{
    ArrayKind, LinearStates, MarkerIx, Model, PartIx, PartKind, Request, RequestKind,
    ResultsSettings, SpringKind, VectorForceKind,
};
use admire_solver::system::{ConstraintIx, ElementIx, System};
use admire_syntax::hash::QuickMap;
use admire_syntax::units::{Dimension, Units};

/// One entity of the results after the bodies, with the source of its values.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Item {
    /// Value and time derivative of a DIFF.
    Diff {
        /// Id of the DIFF.
        id: u32,
        /// Index of the DIFF in the model; `None` if the current model lacks it.
        at: Option<usize>,
    },
    /// Reaction of a constraint.
    Constraint {
        /// Keyword of the statement.
        kind: &'static str,
        /// Id of the statement.
        id: u32,
        /// Index of the constraint in the compiled system; `None` if the system lacks it.
        at: Option<ConstraintIx>,
    },
    /// Force and torque of a force element; some elements also have the rotation angles of I relative to J.
    Element {
        /// Keyword of the statement.
        kind: &'static str,
        /// Id of the statement.
        id: u32,
        /// True if the entity also has the columns ANGX, ANGY and ANGZ.
        angles: bool,
        /// Index of the element in the compiled system; `None` if the system lacks it.
        at: Option<ElementIx>,
    },
    /// Components of one request, or of several requests with the same RESULTS_NAME.
    Request(Vec<Component>),
    /// Value of a VARIABLE.
    Variable {
        /// Id of the VARIABLE.
        id: u32,
        /// Index of the VARIABLE in the model; `None` if the current model lacks it.
        at: Option<usize>,
    },
    /// Pose of the floating marker of a vector force.
    FloatingMarker {
        /// Id of the marker.
        id: u32,
        /// I marker of the vector force, to which the floating marker is attached; `None` if the current model lacks the force.
        on: Option<MarkerIx>,
    },
    /// Reaction of a GCON.
    Condition {
        /// Id of the GCON.
        id: u32,
        /// Marker at which the reaction is reported; `None` if there is none.
        at: Option<MarkerIx>,
    },
    /// Forces of an NFORCE; holds its id and the number of its I markers.
    Multi(u32, usize),
    /// Values of all VARIABLEs in a PINPUT or POUTPUT.
    Variables {
        /// Ids of the VARIABLEs.
        ids: Vec<u32>,
        /// Index of each VARIABLE in the model; `None` if the current model lacks it.
        at: Vec<Option<usize>>,
    },
    /// States and outputs of a system of linear state equations.
    LinearStates {
        /// Keyword of the statement.
        kind: &'static str,
        /// Id of the statement.
        id: u32,
        /// Number of columns of the entity.
        columns: usize,
        /// Index of the equations in the model; `None` if the current model lacks them.
        at: Option<usize>,
        /// Index of their first state among all dynamic states.
        first: usize,
        /// Index in the model of each VARIABLE that is an input of the equations; `None` if the current model lacks it.
        inputs: Vec<Option<usize>>,
    },
    /// Values of the FRICTION with this id.
    Friction(u32),
}

/// One column of a request.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Component {
    /// Id of the request.
    pub id: u32,
    /// Index of the request in the model; `None` if the current model lacks it.
    pub at: Option<usize>,
    /// Index of the component of the request, from 0 to 7.
    pub which: usize,
}

/// Result columns of a run, in the order in which their values are stored in an output step (guide/formats.md 6.1, 12).
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// Bodies with results and their kinds. A point mass has no angles.
    pub bodies: Vec<(PartIx, EntityKind)>,
    /// Kinematic quantities of bodies that are stored. Velocities and accelerations are zero in a static state.
    pub stored: Stored,
    /// Entities that follow the bodies.
    pub items: Vec<Item>,
    /// Names and ids of all columns.
    pub catalogue: Catalogue,
}

impl Columns {
    /// Selects the columns that the RESULTS statement of a model requests.
    pub(crate) fn of(model: &Model, system: &System) -> Self {
        let settings = &model.results;
        let stored = Stored {
            displacements: !settings.no_displacements,
            velocities: !settings.no_velocities,
            accelerations: !settings.no_accelerations,
        };
        let mut builder = Builder {
            numbering: Numbering::new(model.units, stored),
            items: Vec::new(),
        };
        let mut bodies = Vec::new();
        if stored.displacements || stored.velocities || stored.accelerations {
            for (index, part) in model.parts.iter().enumerate() {
                let kind = match part.kind {
                    PartKind::Rigid => EntityKind::Part,
                    PartKind::PointMass => EntityKind::PointMass,
                    PartKind::Ground | PartKind::External => continue,
                };
                builder.number(kind, &part.header.name, part.header.id);
                bodies.push((PartIx(index), kind));
            }
            // The catalogue sorts objects by kind; a stable sort keeps the order of objects of the same kind.
            bodies.sort_by_key(|(_, kind)| *kind);
        }
        builder.add(model, settings);
        let Builder {
            numbering,
            mut items,
        } = builder;
        items.sort_by_key(|(kind, _)| *kind);
        let mut columns = Self {
            bodies,
            stored,
            items: items.into_iter().map(|(_, item)| item).collect(),
            catalogue: numbering.finish(),
        };
        columns.locate(model, system);
        columns
    }

    /// Updates the index of the object from which each entity gets its values. Must be called after the model was compiled again.
    pub(crate) fn locate(&mut self, model: &Model, system: &System) {
        let elements: QuickMap<_, _> = system
            .elements()
            .map(|(element, name)| ((name.kind, name.id), element))
            .collect();
        let constraints: QuickMap<_, _> = system
            .constraints()
            .map(|(constraint, name)| ((name.kind, name.id), constraint))
            .collect();
        let requests = places(model.requests.iter().map(|request| request.header.id));
        let variables = places(model.variables.iter().map(|variable| variable.header.id));
        for item in &mut self.items {
            match item {
                Item::Element { kind, id, at, .. } => *at = elements.get(&(*kind, *id)).copied(),
                Item::Constraint { kind, id, at } => *at = constraints.get(&(*kind, *id)).copied(),
                Item::FloatingMarker { id, on } => {
                    let floats = |jfloat: MarkerIx| model.markers[jfloat.0].header.id == *id;
                    let force = model.vector_forces.iter().find(|f| floats(f.jfloat));
                    *on = force.map(|force| force.i);
                }
                Item::Condition { id, at } => {
                    let gcon = model.gcons.iter().find(|gcon| gcon.header.id == *id);
                    *at = gcon.and_then(|gcon| gcon.i);
                }
                Item::LinearStates {
                    kind,
                    id,
                    at,
                    first,
                    inputs,
                    ..
                } => {
                    let mut all = model.linear_states.iter();
                    *at = all.position(|s| s.kind == *kind && s.header.id == *id);
                    if let Some(at) = *at {
                        // In the vector of dynamic states, the states of DIFFs come first. The states of linear state equations follow, in
                        // the order of the model.
                        let before = model.linear_states[..at].iter();
                        *first = model.diffs.len() + before.map(|s| s.a.len()).sum::<usize>();
                        *inputs = inputs_of(model, &model.linear_states[at]);
                    }
                }
                Item::Diff { id, at } => {
                    *at = model.diffs.iter().position(|diff| diff.header.id == *id);
                }
                Item::Variable { id, at } => *at = variables.get(id).copied(),
                Item::Variables { ids, at } => {
                    at.clear();
                    at.extend(ids.iter().map(|id| variables.get(id).copied()));
                }
                Item::Request(components) => {
                    for component in components {
                        component.at = requests.get(&component.id).copied();
                    }
                }
                Item::Multi(..) | Item::Friction(_) => {}
            }
        }
    }
}

/// Returns a map from each id to its position in the sequence `ids`.
pub(super) fn places(ids: impl Iterator<Item = u32>) -> QuickMap<u32, usize> {
    ids.enumerate().map(|(at, id)| (id, at)).collect()
}

/// Returns the index in the model of each VARIABLE in the input array of linear state equations.
fn inputs_of(model: &Model, states: &LinearStates) -> Vec<Option<usize>> {
    let mut arrays = model.arrays.iter();
    let inputs = arrays.find(|array| array.header.id == states.u);
    match inputs.map(|array| &array.kind) {
        Some(ArrayKind::Variables(ids)) => variables(model, ids),
        _ => Vec::new(),
    }
}

/// Returns the index of each VARIABLE in the model, given the ids.
fn variables(model: &Model, ids: &[u32]) -> Vec<Option<usize>> {
    let variable = |id: &u32| model.variables.iter().position(|v| v.header.id == *id);
    ids.iter().map(variable).collect()
}

struct Builder {
    numbering: Numbering,
    items: Vec<(EntityKind, Item)>,
}

impl Builder {
    fn number(&mut self, kind: EntityKind, name: &str, id: u32) {
        let name = (!name.is_empty()).then_some(name);
        self.numbering.object(kind, name, i64::from(id), 0);
    }

    fn item(&mut self, kind: EntityKind, name: &str, id: u32, item: Item) {
        self.number(kind, name, id);
        self.items.push((kind, item));
    }

    fn add(&mut self, model: &Model, settings: &ResultsSettings) {
        if !settings.no_reaction_forces {
            self.add_constraints(model);
        }
        if !settings.no_applied_forces {
            self.add_forces(model);
        }
        if !settings.no_system_elements {
            for diff in &model.diffs {
                let (name, id) = (&diff.header.name, diff.header.id);
                let item = Item::Diff { id, at: None };
                self.item(EntityKind::DifferentialEquation, name, id, item);
            }
            for variable in &model.variables {
                let (name, id) = (&variable.header.name, variable.header.id);
                let item = Item::Variable { id, at: None };
                self.item(EntityKind::Variable, name, id, item);
            }
            self.add_ports(model);
            self.add_linear_states(model);
        }
        if !settings.no_requests {
            self.add_requests(model);
        }
        if !settings.no_floating_markers {
            for force in &model.vector_forces {
                let marker = &model.markers[force.jfloat.0].header;
                let (id, on) = (marker.id, None);
                let item = Item::FloatingMarker { id, on };
                self.item(EntityKind::FloatingMarker, &marker.name, id, item);
            }
        }
    }

    fn add_constraints(&mut self, model: &Model) {
        macro_rules! each {
            ($($list:ident $kind:ident $word:literal),+) => {
                $(for object in &model.$list {
                    let (name, id) = (&object.header.name, object.header.id);
                    let item = Item::Constraint { kind: $word, id, at: None };
                    self.item(EntityKind::$kind, name, id, item);
                })+
            };
        }
        each!(
            joints Joint "JOINT",
            primitives PrimitiveJoint "JPRIM",
            motions Motion "MOTION",
            gears Gear "GEAR",
            couplers Coupler "COUPLER"
        );
        for gcon in &model.gcons {
            let (name, id) = (&gcon.header.name, gcon.header.id);
            let item = Item::Condition { id, at: None };
            self.item(EntityKind::UserConstraint, name, id, item);
        }
    }

    fn add_ports(&mut self, model: &Model) {
        for port in &model.plant_ports {
            let kind = match port.kind {
                "PINPUT" => EntityKind::PlantInput,
                "POUTPUT" => EntityKind::PlantOutput,
                _ => continue,
            };
            let ids = port.variables.clone();
            let (name, id) = (&port.header.name, port.header.id);
            let name = (!name.is_empty()).then_some(name.as_str());
            self.numbering.object(kind, name, i64::from(id), ids.len());
            let at = Vec::new();
            self.items.push((kind, Item::Variables { ids, at }));
        }
    }

    /// Adds the states of linear state equations as X1, X2, ... and their outputs as Y1, Y2, ...; the names that ADAMS uses are not
    /// documented.
    fn add_linear_states(&mut self, model: &Model) {
        for states in &model.linear_states {
            let kind = match states.kind {
                "TFSISO" => EntityKind::TransferFunction,
                _ => EntityKind::LinearStateEquation,
            };
            let columns: Vec<String> = (1..=states.a.len())
                .map(|k| format!("X{k}"))
                .chain((1..=states.c.len()).map(|k| format!("Y{k}")))
                .collect();
            let columns: Vec<(&str, Option<&str>)> =
                columns.iter().map(|name| (name.as_str(), None)).collect();
            let (name, id) = (&states.header.name, i64::from(states.header.id));
            self.numbering.named(kind, Some(name), id, None, &columns);
            let item = Item::LinearStates {
                kind: states.kind,
                id: states.header.id,
                columns: columns.len(),
                at: None,
                first: 0,
                inputs: Vec::new(),
            };
            self.items.push((kind, item));
        }
    }

    /// Adds the forces of each NFORCE: FX to TZ at the first I marker, FX_2 to TZ_2 at the second, and so on. The names that ADAMS uses are
    /// not documented.
    fn add_multi_point_forces(&mut self, model: &Model) {
        let units = [Dimension::FORCE, Dimension::TORQUE].map(|d| model.units.name(d));
        for force in &model.nforces {
            let mut columns: Vec<(String, Option<&str>)> = Vec::new();
            for marker in 1..=force.i.len() {
                for (k, name) in ["FX", "FY", "FZ", "TX", "TY", "TZ"].iter().enumerate() {
                    let name = match marker {
                        1 => (*name).to_string(),
                        _ => format!("{name}_{marker}"),
                    };
                    columns.push((name, Some(units[k / 3].as_str())));
                }
            }
            let columns: Vec<(&str, Option<&str>)> = columns
                .iter()
                .map(|(name, unit)| (name.as_str(), *unit))
                .collect();
            let (name, id) = (&force.header.name, force.header.id);
            let kind = EntityKind::MultiPointForce;
            self.numbering
                .named(kind, Some(name), i64::from(id), None, &columns);
            self.items.push((kind, Item::Multi(id, force.i.len())));
        }
    }

    /// Adds the columns of each FRICTION: forces in ground axes, and coefficients, surface velocities and creeps in the axes of I.
    fn add_frictions(&mut self, model: &Model) {
        let unit = |dimension: Dimension| model.units.name(dimension);
        let (force, torque) = (unit(Dimension::FORCE), unit(Dimension::TORQUE));
        let (speed, length) = (
            unit(Dimension::new(0, 0, 1, -1, 0)),
            unit(Dimension::LENGTH),
        );
        let columns: Vec<(&str, Option<&str>)> = [
            (&["FX", "FY", "FZ"][..], Some(force.as_str())),
            (&["TX", "TY", "TZ"], Some(torque.as_str())),
            (&["MUX", "MUY", "MUZ", "MURX", "MURY", "MURZ", "MU1"], None),
            (&["VX", "VY", "VZ", "WX", "WY", "WZ"], Some(speed.as_str())),
            (
                &[
                    "CREEP_X", "CREEP_Y", "CREEP_Z", "CREEP_AX", "CREEP_AY", "CREEP_AZ",
                ],
                Some(length.as_str()),
            ),
            (&["BETA"], None),
        ]
        .into_iter()
        .flat_map(|(names, unit)| names.iter().map(move |name| (*name, unit)))
        .collect();
        for friction in &model.frictions {
            let (name, id) = (&friction.header.name, friction.header.id);
            let kind = EntityKind::Friction;
            let name = (!name.is_empty()).then_some(name.as_str());
            self.numbering
                .named(kind, name, i64::from(id), None, &columns);
            self.items.push((kind, Item::Friction(id)));
        }
    }

    fn add_forces(&mut self, model: &Model) {
        let mut add =
            |entity: EntityKind, word: &'static str, header: &admire_solver::model::Header| {
                let item = Item::Element {
                    kind: word,
                    id: header.id,
                    angles: entity.has_angles(),
                    at: None,
                };
                self.item(entity, &header.name, header.id, item);
            };
        for force in &model.sforces {
            add(EntityKind::SingleComponentForce, "SFORCE", &force.header);
        }
        for spring in &model.springdampers {
            let entity = match spring.kind {
                SpringKind::Translational => EntityKind::TranslationalSpringDamper,
                SpringKind::Rotational => EntityKind::RotationalSpringDamper,
            };
            add(entity, "SPRINGDAMPER", &spring.header);
        }
        for bushing in &model.bushings {
            add(EntityKind::Bushing, "BUSHING", &bushing.header);
        }
        for force in &model.pair_forces {
            let entity = EntityKind::of_law(force.law.entity);
            add(entity, force.def.name, &force.header);
        }
        for force in &model.vector_forces {
            let (entity, word) = match force.kind {
                VectorForceKind::Gforce => (EntityKind::GeneralForce, "GFORCE"),
                VectorForceKind::Vforce => (EntityKind::ForceVector, "VFORCE"),
                VectorForceKind::Vtorque => (EntityKind::TorqueVector, "VTORQUE"),
            };
            add(entity, word, &force.header);
        }
        self.add_multi_point_forces(model);
        self.add_frictions(model);
    }

    /// Adds the requests. All requests with the same RESULTS_NAME form one result set, whose object id is 0.
    fn add_requests(&mut self, model: &Model) {
        let mut done = vec![false; model.requests.len()];
        for first in 0..model.requests.len() {
            if done[first] {
                continue;
            }
            let request = &model.requests[first];
            let shared = request.results_name.as_deref();
            let members: Vec<usize> = (first..model.requests.len())
                .filter(|&k| {
                    k == first
                        || shared.is_some() && model.requests[k].results_name.as_deref() == shared
                })
                .collect();
            let mut values = Vec::new();
            let mut columns: Vec<(String, Option<String>)> = Vec::new();
            for member in members {
                done[member] = true;
                let request = &model.requests[member];
                for (component, name, unit) in components(request, &model.units, model.output.ypr) {
                    values.push(Component {
                        id: request.header.id,
                        at: None,
                        which: component,
                    });
                    columns.push((name, unit));
                }
            }
            let columns: Vec<(&str, Option<&str>)> = columns
                .iter()
                .map(|(name, unit)| (name.as_str(), unit.as_deref()))
                .collect();
            let id = if shared.is_some() {
                0
            } else {
                i64::from(request.header.id)
            };
            let name = shared.unwrap_or(&request.header.name);
            let comment = (!request.comment.is_empty()).then_some(request.comment.as_str());
            self.numbering
                .named(EntityKind::Request, Some(name), id, comment, &columns);
            self.items
                .push((EntityKind::Request, Item::Request(values)));
        }
    }
}

/// Returns the components of a request that are written, each with its index from 0 to 7, its name and its unit.
///
/// Names come from CNAMES or TITLE; a component with an empty name is not written. A request that consists of functions has only the
/// components for which a function is given.
///
/// The default names of ADAMS are not documented, so its usual column headings are used as default names.
pub(super) fn components(
    request: &Request,
    units: &Units,
    ypr: bool,
) -> Vec<(usize, String, Option<String>)> {
    let usual = usual_names(&request.kind, ypr);
    let (translation, rotation) = match &request.kind {
        RequestKind::Displacement { .. } => (Dimension::LENGTH, Dimension::ANGLE),
        RequestKind::Velocity { .. } => (
            Dimension::new(0, 0, 1, -1, 0),
            Dimension::new(0, 0, 0, -1, 1),
        ),
        RequestKind::Acceleration { .. } => (
            Dimension::new(0, 0, 1, -2, 0),
            Dimension::new(0, 0, 0, -2, 1),
        ),
        RequestKind::Force { .. } => (Dimension::FORCE, Dimension::TORQUE),
        RequestKind::Functions(_) | RequestKind::User(_) => (Dimension::NONE, Dimension::NONE),
    };
    let mut out = Vec::new();
    for k in 0..8 {
        let given = request.component_names.as_ref();
        let name = match given {
            Some(names) => names.get(k).cloned().unwrap_or_default(),
            None => usual[k].to_string(),
        };
        let exists = match &request.kind {
            RequestKind::Functions(functions) => functions[k].is_some(),
            RequestKind::User(_) => false,
            _ => true,
        };
        if name.is_empty() || !exists {
            continue;
        }
        let dimension = if k < 4 { translation } else { rotation };
        let unit = match request.component_units.get(k).map(String::as_str) {
            Some(word) if !word.is_empty() => unit_of_word(word, units),
            _ => units.name(dimension),
        };
        out.push((k, name, (!unit.is_empty()).then_some(unit)));
    }
    out
}

/// Returns the default names of the eight components of a request. If `ypr` is true, the angles of displacements are YAW, PITCH and ROLL.
pub(super) fn usual_names(kind: &RequestKind, ypr: bool) -> [&'static str; 8] {
    match kind {
        RequestKind::Displacement { .. } if ypr => {
            ["MAG", "X", "Y", "Z", "AMAG", "YAW", "PITCH", "ROLL"]
        }
        RequestKind::Displacement { .. } => ["MAG", "X", "Y", "Z", "AMAG", "PSI", "THETA", "PHI"],
        RequestKind::Velocity { .. } => ["VM", "VX", "VY", "VZ", "WM", "WX", "WY", "WZ"],
        RequestKind::Acceleration { .. } => {
            ["ACCM", "ACCX", "ACCY", "ACCZ", "WDM", "WDX", "WDY", "WDZ"]
        }
        RequestKind::Force { .. } => ["FM", "FX", "FY", "FZ", "TM", "TX", "TY", "TZ"],
        RequestKind::Functions(_) | RequestKind::User(_) => {
            ["U1", "U2", "U3", "U4", "U5", "U6", "U7", "U8"]
        }
    }
}

/// Returns the unit for a word of CUNITS, such as `"length"`, `"force"` or `"no_units"`. A word that is itself a unit is returned
/// unchanged.
fn unit_of_word(word: &str, units: &Units) -> String {
    let dimension = match word.to_ascii_lowercase().as_str() {
        "no_units" | "none" => return "no_units".to_string(),
        "length" => Dimension::LENGTH,
        "angle" => Dimension::ANGLE,
        "force" => Dimension::FORCE,
        "torque" => Dimension::TORQUE,
        "mass" => Dimension::MASS,
        "time" => Dimension::TIME,
        "velocity" => Dimension::new(0, 0, 1, -1, 0),
        "acceleration" => Dimension::new(0, 0, 1, -2, 0),
        "angular_velocity" => Dimension::new(0, 0, 0, -1, 1),
        "angular_acceleration" => Dimension::new(0, 0, 0, -2, 1),
        "stiffness" => Dimension::new(1, 0, -1, 0, 0),
        "torsion_stiffness" => Dimension::new(1, 0, 1, 0, -1),
        _ => return word.to_string(),
    };
    units.name(dimension)
}
