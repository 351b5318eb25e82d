use super::{Arrow, Body, Frame, Kind, Placed, Role, Scene, point};
use admire_results::{Catalogue, Entity, EntityKind, ResultsError, ResultsReader};
use admire_solver::mechanics::{Pose, Vec3, euler313};
use admire_syntax::units::LENGTH_UNITS;

/// Steps of a results file, converted to frames of a scene.
#[derive(Clone, PartialEq, Debug)]
pub struct Motion {
    /// Frames, evenly spaced over the file. Their number is always below 800.
    pub frames: Vec<Frame>,
    /// Number of steps in the file.
    pub steps: usize,
    /// Addresses of the parts that have no results, and therefore stay in their design pose.
    pub missing: Vec<String>,
    /// True if some bodies of the results file match no part of the scene.
    pub others: bool,
}

/// Half the limit on the number of frames. When twice this number is reached, every second frame is dropped. More frames would make the page
/// too slow for browsers.
pub(crate) const MOST: usize = 400;

const COLUMNS: [&str; 6] = ["X", "Y", "Z", "PSI", "THETA", "PHI"];

/// Columns of a body's pose in the results file. Point masses have no angles.
struct Columns {
    place: [usize; 3],
    angles: Option<[usize; 3]>,
}

impl Columns {
    fn of(entity: &Entity) -> Option<Self> {
        let id = |name: &str| entity.component(name)?.id.checked_sub(1);
        let three = |from: usize| -> Option<[usize; 3]> {
            Some([
                id(COLUMNS[from])?,
                id(COLUMNS[from + 1])?,
                id(COLUMNS[from + 2])?,
            ])
        };
        Some(Self {
            place: three(0)?,
            angles: three(3),
        })
    }

    fn pose(&self, values: &[f64], length: f64, angle: f64) -> Option<Placed> {
        let three = |ids: [usize; 3], by: f64| ids.map(|id| values[id] * by);
        let p = Vec3::from(three(self.place, length));
        let a = three(self.angles.unwrap_or([0; 3]), angle);
        let R = match self.angles {
            Some(_) => euler313(a[0], a[1], a[2]),
            None => Pose::identity().R,
        };
        let pose = Pose { p, R };
        let finite = pose.p.iter().chain(pose.R.iter()).all(|x| x.is_finite());
        finite.then(|| Placed::new(&pose))
    }
}

fn is_body(entity: &Entity) -> bool {
    match entity.ent_type.as_deref() {
        Some(kind) => matches!(kind, "Part" | "Point_Mass" | "Flexible_Body"),
        None => entity.component("PSI").is_some(),
    }
}

/// Returns the forces in a results file. Each entry holds the index of the object in the scene, and the columns of the force on marker I in
/// ground axes.
fn forces(scene: &Scene, catalogue: &Catalogue) -> Vec<(usize, [usize; 3])> {
    let of = |(k, object): (usize, &super::Object)| {
        let (statement, id) = object.address.split_once('/')?;
        let kind = match statement {
            "SFORCE" => EntityKind::SingleComponentForce,
            "GFORCE" => EntityKind::GeneralForce,
            "VFORCE" => EntityKind::ForceVector,
            _ => return None,
        };
        let entity = catalogue.entity_of(kind.ent_type(), id.parse().ok()?)?;
        let column = |name: &str| entity.component(name)?.id.checked_sub(1);
        Some((k, [column("FX")?, column("FY")?, column("FZ")?]))
    };
    let drawn = scene.objects.iter().enumerate();
    drawn
        .filter(|(_, object)| object.kind == Kind::Force)
        .filter_map(of)
        .collect()
}

/// Creates a scene from the bodies in a results file, for a file without its deck. The bodies have no extent.
pub fn bodies(title: &str, reader: &dyn ResultsReader) -> Scene {
    let units = &reader.header().units;
    let parts = reader
        .catalogue()
        .entities
        .iter()
        .filter(|entity| is_body(entity) && Columns::of(entity).is_some())
        .map(|entity| Body {
            name: entity.entity.clone().unwrap_or_else(|| entity.name.clone()),
            address: entity
                .object_id
                .map_or_else(|| entity.name.clone(), |id| format!("PART/{id}")),
            ground: false,
            design: Placed::new(&Pose::identity()),
            points: Vec::new(),
            faces: Vec::new(),
            edges: Vec::new(),
            lines: Vec::new(),
        });
    Scene {
        title: title.to_string(),
        length: units.length.clone(),
        force: String::new(),
        up: [0.0, 0.0, 1.0],
        along: [1.0, 0.0, 0.0],
        parts: parts.collect(),
        objects: Vec::new(),
        wheels: Vec::new(),
        marks: Vec::new(),
        sets: vec![Role::Model],
        per: "step".to_string(),
        frames: Vec::new(),
        highlight: Vec::new(),
        notes: Vec::new(),
    }
}

/// Reads the remaining steps of a results file as frames of a scene. Parts of the scene are matched to bodies of the file by id, or else by
/// name.
///
/// # Errors
/// [`ResultsError`] if the file is corrupt; no frames are returned then.
pub fn motion(scene: &Scene, reader: &mut dyn ResultsReader) -> Result<Motion, ResultsError> {
    let units = &reader.header().units;
    let angle = if units.angle == "deg" {
        1f64.to_radians()
    } else {
        1.0
    };
    let si = |word: &str| {
        LENGTH_UNITS
            .iter()
            .find(|unit| unit.word == word)
            .map(|unit| unit.si)
    };
    let length = match (si(&units.length), si(&scene.length)) {
        (Some(file), Some(own)) => file / own,
        _ => 1.0,
    };
    let entities: Vec<&Entity> = reader
        .catalogue()
        .entities
        .iter()
        .filter(|e| is_body(e))
        .collect();
    let mut used = vec![false; entities.len()];
    let of = |part: &Body| {
        let id = part
            .address
            .rsplit('/')
            .next()
            .and_then(|id| id.parse::<i64>().ok());
        let named = |entity: &&Entity| {
            let object = entity.entity.as_deref().unwrap_or(&entity.name);
            object.eq_ignore_ascii_case(&part.name)
        };
        let at = entities
            .iter()
            .position(|e| id.is_some() && e.object_id == id)
            .or_else(|| entities.iter().position(named))?;
        Some((at, Columns::of(entities[at])?))
    };
    let columns: Vec<Option<Columns>> = scene
        .parts
        .iter()
        .map(|part| {
            let (at, columns) = of(part).filter(|_| !part.ground)?;
            used[at] = true;
            Some(columns)
        })
        .collect();
    let missing = scene.parts.iter().zip(&columns);
    let missing = missing
        .filter(|(part, columns)| !part.ground && columns.is_none())
        .map(|(part, _)| part.address.clone())
        .collect();
    let others = used.contains(&false);
    let forces = forces(scene, reader.catalogue());
    let mut frames: Vec<Frame> = Vec::new();
    // One step out of every `stride` steps is kept. The stride doubles when the frames reach twice `MOST`.
    let (mut stride, mut steps, mut values) = (1, 0, Vec::new());
    while let Some(step) = reader.next_step()? {
        if steps % stride == 0 {
            step.values(&mut values)?;
            let poses = scene
                .parts
                .iter()
                .zip(&columns)
                .map(|(part, columns)| match columns {
                    Some(columns) => columns.pose(&values, length, angle),
                    None => Some(part.design),
                });
            let arrows = forces.iter().map(|(object, ids)| Arrow {
                object: *object,
                force: point(&Vec3::from(ids.map(|id| values[id]))),
            });
            frames.push(Frame {
                arrows: arrows.filter(|arrow| arrow.force != [0.0; 3]).collect(),
                label: format!("{}", steps + 1),
                note: format!(
                    "{} at time {}",
                    step.kind.step_type(),
                    values.first().unwrap_or(&0.0)
                ),
                poses: vec![poses.collect()],
                ..Frame::default()
            });
        }
        steps += 1;
        if frames.len() == 2 * MOST {
            stride *= 2;
            let mut keep = 0;
            frames.retain(|_| {
                keep += 1;
                keep % 2 == 1
            });
        }
    }
    Ok(Motion {
        frames,
        steps,
        missing,
        others,
    })
}
