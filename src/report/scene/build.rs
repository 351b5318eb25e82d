use super::hull::hull;
use super::shapes::{Shape, shapes};
use super::{Body, End, Highlight, Kind, Object, Placed, Role, Scene, point};
use crate::short_unit;
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{
    JointKind, MarkerIx, Model, PartKind, PrimitiveKind, SforceKind, SpringKind, VectorForceKind,
};
use admire_syntax::Dataset;

impl Scene {
    /// Creates the scene of a model in its design position. If the dataset is given, the shapes of its GRAPHICS statements are drawn, too.
    pub fn of(model: &Model, dataset: Option<&Dataset>) -> Self {
        let objects = objects(model);
        let shapes = dataset.map(|dataset| shapes(dataset, model));
        let gravity = model.gravity;
        let up = if gravity.norm() > 0.0 && gravity.iter().all(|g| g.is_finite()) {
            -gravity.normalize()
        } else {
            Vec3::z()
        };
        Self {
            title: model.title.trim().to_string(),
            length: model.units.length.word.to_string(),
            force: short_unit(model.units.force.word),
            up: point(&up),
            along: along(&up, &up.cross(&Vec3::x())),
            parts: bodies(model, &objects, &shapes.unwrap_or_default()),
            objects,
            wheels: Vec::new(),
            marks: Vec::new(),
            sets: vec![Role::Model],
            per: "step".to_string(),
            frames: Vec::new(),
            highlight: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Highlights the object or part to which an address belongs, such as `BUSHING/2.K.1`, `PART/4`, `MARKER/7` or `SFORCE/2<-SFORCE/3`.
    /// Returns false if no such object or part is drawn.
    pub fn highlight(&mut self, address: &str, label: &str) -> bool {
        let found = self.owner(address);
        if let Some(address) = &found
            && self.highlight.iter().all(|mark| mark.address != *address)
        {
            self.highlight.push(Highlight {
                address: address.clone(),
                label: label.to_string(),
            });
        }
        found.is_some()
    }

    /// Returns an address preceded by the name of its element, such as `A (BUSHING/1.K.1)`.
    pub fn named(&self, address: &str) -> String {
        let owner = self.owner(address);
        let objects = self
            .objects
            .iter()
            .map(|object| (&object.address, &object.name));
        let parts = self.parts.iter().map(|part| (&part.address, &part.name));
        let mut all = objects.chain(parts);
        match owner.and_then(|owner| all.find(|(of, _)| **of == owner)) {
            Some((_, name)) => format!("{name} ({address})"),
            None => address.to_string(),
        }
    }

    /// Lists several addresses, grouped by the name of their element: `TIE_INNER (MARKER/16, MARKER/15)`.
    pub(crate) fn named_all(&self, addresses: &[String]) -> String {
        let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
        for address in addresses {
            let named = self.named(address);
            let name = named.strip_suffix(&format!(" ({address})"));
            let name = name.unwrap_or_default().to_string();
            match groups.iter_mut().find(|(own, _)| *own == name) {
                Some((_, members)) => members.push(address),
                None => groups.push((name, vec![address])),
            }
        }
        let texts = groups.iter().map(|(name, members)| {
            let members = members.join(", ");
            if name.is_empty() {
                members
            } else {
                format!("{name} ({members})")
            }
        });
        texts.collect::<Vec<_>>().join(", ")
    }

    /// Returns a text in which the name of the element precedes every address, such as `JOINT/3` or `BUSHING/1.K.2`.
    pub(crate) fn naming(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len());
        let is_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_');
        let mut rest = text;
        while let Some(start) = rest.find(is_word) {
            out += &rest[..start];
            rest = &rest[start..];
            let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            let (word, behind) = rest.split_at(end);
            // A trailing full stop belongs to the sentence.
            let address = word.trim_end_matches('.');
            let is_address = address.split_once('/').is_some_and(|(kind, id)| {
                kind.len() > 2
                    && kind.chars().all(|c| c.is_ascii_uppercase())
                    && id.starts_with(|c: char| c.is_ascii_digit())
            });
            if is_address && !out.ends_with('(') {
                out += &self.named(address);
                out += &word[address.len()..];
            } else {
                out += word;
            }
            rest = behind;
        }
        out + rest
    }

    /// Returns the address of the drawn object or part to which an address belongs. Returns `None` if no such object or part is drawn.
    fn owner(&self, address: &str) -> Option<String> {
        let address = address.split("<-").next()?.to_ascii_uppercase();
        let address = address.split('.').next()?.to_string();
        if self.object(&address).is_some() || self.parts.iter().any(|part| part.address == address)
        {
            return Some(address);
        }
        let id: u32 = address.strip_prefix("MARKER/")?.parse().ok()?;
        let holder = self
            .objects
            .iter()
            .find(|object| object.markers.contains(&id))?;
        Some(holder.address.clone())
    }

    /// Returns the index of the object with an address such as `BUSHING/1`.
    pub(crate) fn object(&self, address: &str) -> Option<usize> {
        self.objects
            .iter()
            .position(|object| object.address == address)
    }
}

/// Returns the ground axis along which the vehicle travels: the axis nearest to the horizontal direction normal to `spin`, the spin axis of
/// the wheels. Returns y if that direction is undefined.
pub(crate) fn along(up: &Vec3, spin: &Vec3) -> [f64; 3] {
    let across = spin.cross(up);
    let sizes = across.map(f64::abs);
    let sizes = if sizes.max() > 0.0 {
        sizes
    } else {
        Vec3::new(0.0, 1.0, 0.0)
    };
    let mut axis = [0.0; 3];
    axis[sizes.imax()] = 1.0;
    axis
}

/// Returns the pose of a marker in the frame of its part.
fn frame(model: &Model, marker: MarkerIx) -> Pose {
    let marker = &model.markers[marker.0];
    Pose {
        p: marker.qp,
        R: marker.R,
    }
}

fn end(model: &Model, marker: MarkerIx) -> Option<End> {
    // A floating marker has no position of its own.
    let of = &model.markers[marker.0];
    (!of.floating).then(|| End {
        part: of.part.0,
        at: Placed::new(&frame(model, marker)),
    })
}

fn objects(model: &Model) -> Vec<Object> {
    let mut out = Vec::new();
    let mut add = |header: &admire_solver::model::Header,
                   statement: &str,
                   kind: Kind,
                   form: &str,
                   i: MarkerIx,
                   j: Option<MarkerIx>| {
        let marker = i;
        let Some(i) = end(model, i).filter(|_| header.active) else {
            return;
        };
        let ids = std::iter::once(marker).chain(j);
        let markers = ids
            .map(|marker| model.markers[marker.0].header.id)
            .collect();
        out.push(Object {
            name: header.name.clone(),
            address: format!("{statement}/{}", header.id),
            kind,
            form: form.to_string(),
            i,
            j: j.and_then(|j| end(model, j)),
            markers,
        });
    };
    for joint in &model.joints {
        let form = match joint.kind {
            JointKind::Spherical => "spherical",
            JointKind::Revolute => "revolute",
            JointKind::Translational => "translational",
            JointKind::Cylindrical => "cylindrical",
            JointKind::Planar => "planar",
            JointKind::Fixed => "fixed",
            JointKind::Hooke => "hooke",
            JointKind::Universal => "universal",
            JointKind::Convel => "convel",
            JointKind::Screw { .. } => "screw",
            JointKind::RackPin { .. } => "rackpin",
        };
        add(
            &joint.header,
            "JOINT",
            Kind::Joint,
            form,
            joint.i,
            Some(joint.j),
        );
    }
    for primitive in &model.primitives {
        let form = match primitive.kind {
            PrimitiveKind::AtPoint => "atpoint",
            PrimitiveKind::Inline => "inline",
            PrimitiveKind::Inplane => "inplane",
            PrimitiveKind::Orientation => "orientation",
            PrimitiveKind::ParallelAxes => "parallel axes",
            PrimitiveKind::Perpendicular => "perpendicular",
        };
        let (i, j) = (primitive.i, primitive.j);
        add(
            &primitive.header,
            "JPRIM",
            Kind::Primitive,
            form,
            i,
            Some(j),
        );
    }
    for motion in &model.motions {
        add(
            &motion.header,
            "MOTION",
            Kind::Motion,
            "motion",
            motion.i,
            Some(motion.j),
        );
    }
    for bushing in &model.bushings {
        add(
            &bushing.header,
            "BUSHING",
            Kind::Bushing,
            "bushing",
            bushing.i,
            Some(bushing.j),
        );
    }
    for force in &model.pair_forces {
        let kind = match force.def.name {
            "BEAM" => Kind::Beam,
            _ => Kind::Field,
        };
        let mut header = force.header.clone();
        if let Some(car) = &force.car {
            header.name.clone_from(&car.bushing);
        }
        add(
            &header,
            force.def.name,
            kind,
            force.law.name,
            force.i,
            Some(force.j),
        );
    }
    for force in &model.nforces {
        for i in &force.i {
            add(
                &force.header,
                "NFORCE",
                Kind::Field,
                "nforce",
                *i,
                Some(force.j),
            );
        }
    }
    for spring in &model.springdampers {
        let form = match spring.kind {
            SpringKind::Translational => "translational",
            SpringKind::Rotational => "rotational",
        };
        add(
            &spring.header,
            "SPRINGDAMPER",
            Kind::Spring,
            form,
            spring.i,
            Some(spring.j),
        );
    }
    for force in &model.sforces {
        let form = match (force.kind, force.action_only) {
            (SforceKind::Translational, false) => "translational",
            (SforceKind::Translational, true) => "translational, action only",
            (SforceKind::Rotational, false) => "rotational",
            (SforceKind::Rotational, true) => "rotational, action only",
        };
        add(
            &force.header,
            "SFORCE",
            Kind::Force,
            form,
            force.i,
            Some(force.j),
        );
    }
    for force in &model.vector_forces {
        let (statement, form) = match force.kind {
            VectorForceKind::Gforce => ("GFORCE", "force and torque"),
            VectorForceKind::Vforce => ("VFORCE", "force"),
            VectorForceKind::Vtorque => ("VTORQUE", "torque"),
        };
        add(
            &force.header,
            statement,
            Kind::Force,
            form,
            force.i,
            force.rm,
        );
    }
    out
}

fn bodies(model: &Model, objects: &[Object], shapes: &[Shape]) -> Vec<Body> {
    let mut corners: Vec<Vec<Vec3>> = vec![Vec::new(); model.parts.len()];
    for object in objects {
        for end in std::iter::once(&object.i).chain(&object.j) {
            let [x, y, z, ..] = end.at.0;
            corners[end.part].push(Vec3::new(x, y, z));
        }
    }
    let mut of = |k: usize, part: &admire_solver::model::Part| {
        let ground = part.kind == PartKind::Ground;
        let mut points = std::mem::take(&mut corners[k]);
        points.retain(|p| p.iter().all(|x| x.is_finite()));
        let cm = part.cm.map(|marker| model.markers[marker.0].qp);
        // For a part without extent, the centre of mass serves as a corner.
        if !ground && hull(&points).edges.is_empty() {
            points.extend(cm);
            if points.is_empty() && !shapes.iter().any(|shape| shape.part == k) {
                let own = model
                    .markers
                    .iter()
                    .filter(|m| m.part.0 == k && !m.floating);
                points.extend(own.map(|marker| marker.qp));
            }
        }
        let outline = if ground {
            super::Hull::default()
        } else {
            hull(&points)
        };
        let mut body = Body {
            name: part.header.name.clone(),
            address: match part.kind {
                PartKind::PointMass => format!("POINT_MASS/{}", part.header.id),
                _ => format!("PART/{}", part.header.id),
            },
            ground,
            design: Placed::new(&part.pose),
            points: points.iter().map(point).collect(),
            faces: outline.faces,
            edges: outline.edges,
            lines: Vec::new(),
        };
        for shape in shapes.iter().filter(|shape| shape.part == k) {
            for line in &shape.lines {
                let first = body.points.len();
                body.points.extend(line.iter().map(point));
                body.lines.push((first..body.points.len()).collect());
            }
        }
        body
    };
    model
        .parts
        .iter()
        .enumerate()
        .map(|(k, part)| of(k, part))
        .collect()
}
