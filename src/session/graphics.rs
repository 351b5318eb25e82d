//! Content of a graphics file: parts, markers, joints, springs, and the arrows of forces.

use std::collections::BTreeMap;

use admire_results::{GraphicsHead, GraphicsJoint, GraphicsMarker, GraphicsShape};
use admire_solver::mechanics::{Pose, psi_theta_phi};
use admire_solver::model::{MarkerIx, Model, Orientation, PartKind};
use admire_solver::system::{State, System};
use admire_syntax::{Dataset, Statement};

use super::measures::{Exerting, Measures};

/// Value of SEG that ADAMS writes for a spring whose GRAPHICS statement gives none.
const SEGMENTS: i64 = 20;

/// Arguments of a spring's GRAPHICS statement that give its sizes: diameters, then lengths.
const SIZES: [&str; 7] = ["DA", "DB", "DC", "LA", "LB", "LC", "LD"];

/// Moving parts and force arrows whose values every frame contains, in the order of these values.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawn {
    /// Indices of the moving parts in the model.
    parts: Vec<usize>,
    forces: Vec<ForceGraphic>,
}

/// Arrow of a force, drawn by a GRAPHICS statement.
#[derive(Clone, Debug)]
struct ForceGraphic {
    /// Statement keyword (ETYPE) and id (EID) of the force.
    element: (String, u32),
    /// Id of the marker (EMARKER) at which the force acts.
    marker: u32,
    /// Source of the force and marker in the compiled system; `None` if the system lacks one of them.
    place: Option<(Exerting, MarkerIx)>,
}

/// Returns the head of the graphics file for a model, and a description of the content of its frames.
pub(super) fn drawn(model: &Model, dataset: &Dataset) -> (GraphicsHead, Drawn) {
    let id = |part: usize| i64::from(model.parts[part].header.id);
    let moving: Vec<usize> = (0..model.parts.len())
        .filter(|&part| model.parts[part].kind != PartKind::Ground)
        .collect();
    let markers = model.markers.iter().filter(|marker| !marker.floating);
    let markers = markers.map(|marker| GraphicsMarker {
        id: i64::from(marker.header.id),
        part: id(marker.part.0),
        position: marker.qp.into(),
        angles: match marker.orientation {
            Orientation::Reuler(angles) => angles,
            Orientation::Points => psi_theta_phi(&marker.R),
        },
    });
    let marker_id = |marker: MarkerIx| i64::from(model.markers[marker.0].header.id);
    let joints = model.joints.iter().map(|joint| GraphicsJoint {
        id: i64::from(joint.header.id),
        markers: [marker_id(joint.i), marker_id(joint.j)],
    });
    let mut head = GraphicsHead {
        title: model.title.clone(),
        units: model.units,
        ground: model.ground().map_or(1, |ground| id(ground.0)),
        parts: moving.iter().map(|&part| id(part)).collect(),
        markers: markers.collect(),
        joints: joints.collect(),
        shapes: Vec::new(),
        input: moving
            .iter()
            .map(|&part| six(&model.parts[part].pose))
            .collect(),
    };
    let mut drawn = Drawn {
        parts: moving,
        forces: Vec::new(),
    };
    let graphics = dataset.statements().iter();
    for statement in graphics.filter(|statement| statement.kind() == Some("GRAPHICS")) {
        if let Some((shape, force)) = shape(statement, dataset) {
            head.shapes.push(shape);
            drawn.forces.extend(force);
        }
    }
    (head, drawn)
}

/// Returns the shape that a GRAPHICS statement draws, if it is a force or a spring. For a force, also returns its arrow.
fn shape(
    statement: &Statement,
    dataset: &Dataset,
) -> Option<(GraphicsShape, Option<ForceGraphic>)> {
    let id = i64::from(statement.number()?);
    let whole = |name: &str| statement.first(name).map(|value| value as i64);
    if statement.has("FORCE") {
        let kind = statement.text("ETYPE", dataset.source())?;
        let marker = whole("EMARKER")?;
        let force = ForceGraphic {
            element: (kind.trim().to_ascii_uppercase(), whole("EID")? as u32),
            marker: marker as u32,
            place: None,
        };
        return Some((GraphicsShape::Force { id, marker }, Some(force)));
    }
    statement.has("SPDP").then(|| {
        let spring = GraphicsShape::Spring {
            id,
            markers: ["I", "J"].map(|name| whole(name).unwrap_or(0)),
            counts: [
                whole("SEG").unwrap_or(SEGMENTS),
                whole("COILS").unwrap_or(0),
            ],
            sizes: SIZES.map(|name| statement.first(name).unwrap_or(0.0)),
        };
        (spring, None)
    })
}

impl Drawn {
    /// Updates the index of the force that each arrow shows. Must be called after the model was compiled again.
    pub(super) fn locate(&mut self, model: &Model, system: &System) {
        let elements = system
            .elements()
            .map(|(element, name)| ((name.kind, name.id), Exerting::Element(element)));
        let constraints = system
            .constraints()
            .map(|(constraint, name)| ((name.kind, name.id), Exerting::Constraint(constraint)));
        let exerting: BTreeMap<(&str, u32), Exerting> = elements.chain(constraints).collect();
        for force in &mut self.forces {
            let (kind, id) = &force.element;
            let by = exerting.get(&(kind.as_str(), *id)).copied();
            force.place = by.zip(model.marker(force.marker));
        }
    }

    /// Returns the poses of the parts and the loads of the forces at the current state. A force that is switched off or not in the system
    /// is zero.
    pub(super) fn frame(&self, measures: &mut Measures<'_>) -> (Vec<[f64; 6]>, Vec<[f64; 6]>) {
        let state: &State = measures.state;
        let poses = self.parts.iter().map(|&part| six(&state.poses[part]));
        let poses = poses.collect();
        let load = |force: &ForceGraphic| {
            let (by, marker) = force.place?;
            measures.load_on(by, marker)
        };
        let loads = self.forces.iter().map(load);
        (poses, loads.map(Option::unwrap_or_default).collect())
    }
}

/// Returns X, Y, Z, PSI, THETA and PHI of a pose.
fn six(pose: &Pose) -> [f64; 6] {
    let [psi, theta, phi] = psi_theta_phi(&pose.R);
    [pose.p.x, pose.p.y, pose.p.z, psi, theta, phi]
}
