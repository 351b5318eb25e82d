use super::Scene;
use super::scene::{Arrow, Frame, Mark, Placed, Role, on_marker, point};
use admire_identify::LoadedStudy;
use admire_kc::{Bench, Config};
use admire_session::backend::Sweep;
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::MarkerIx;
use admire_syntax::files::Files;
use admire_syntax::text::Source;

/// Poses of a model's parts in every load case of a study.
#[derive(Clone, PartialEq, Debug)]
pub struct Positions {
    /// Role of this set of positions, which determines its name and its colour.
    pub role: Role,
    /// Poses of all parts of the model, by case. `None` for a case without an equilibrium.
    pub cases: Vec<Option<Vec<Pose>>>,
}

impl Positions {
    /// Creates a set of positions from a sweep, which solves all load cases of a study.
    pub fn of(role: Role, sweep: &Sweep) -> Self {
        let cases = 0..sweep.cases.len();
        Self {
            role,
            cases: cases
                .map(|case| sweep.equilibrium(case).map(|found| found.poses.clone()))
                .collect(),
        }
    }
}

impl Scene {
    /// Creates the scene of a study's model in its design position, with the wheel if the study or the `kc.toml` in its folder names one.
    pub fn of_study(loaded: &LoadedStudy) -> Self {
        let model = &loaded.model;
        let mut scene = Self::of(model, Some(&loaded.dataset));
        if let Some((marker, axis)) = wheel_marker(loaded) {
            let marker = &model.markers[marker.0];
            let own = Pose {
                p: marker.qp,
                R: marker.R,
            };
            let local = on_marker(&own, axis);
            let spin = model.parts[marker.part.0].pose.R * local.R.column(2);
            scene.look_along(&spin);
            scene.add_wheel(marker.part.0, &local, None, 1.0 / model.units.length.si);
        } else {
            scene.add_kc_wheels(loaded);
        }
        scene
    }

    /// Adds the wheels that `kc.toml` in the folder of the study names. A file that is missing or does not suit the deck adds none.
    fn add_kc_wheels(&mut self, loaded: &LoadedStudy) -> Option<()> {
        let model = &loaded.model;
        let units = &model.units;
        let source = Source::read(&loaded.study.folder.join("kc.toml")).ok()?;
        let config = Config::read(&source, 1e-3 / units.length.si, 1.0 / units.force.si).value?;
        let files = Files::default();
        let bench = Bench::new(&config, &loaded.dataset, &files, model).ok()?;
        let radius = config.tyre.map(|tyre| tyre.radius);
        for wheel in &bench.wheels {
            self.look_along(&wheel.design.R.column(2).into_owned());
            self.add_wheel(wheel.part, &wheel.local, radius, 1.0 / units.length.si);
        }
        Some(())
    }
}

/// Creates the scene of a study, with one frame per load case. Each frame shows the measured poses, the poses of the models in `positions`,
/// and the loads as arrows.
pub(crate) fn study_scene(loaded: &LoadedStudy, positions: &[Positions]) -> Scene {
    let model = &loaded.model;
    let measurement = &loaded.measurement;
    let mut scene = Scene::of_study(loaded);
    scene.per = "case".to_string();
    let mut marks = Vec::new();
    for (part, marked) in measurement.parts.iter().enumerate() {
        for (mark, on_part) in marked.marks.iter().enumerate() {
            marks.push((part, mark));
            scene.marks.push(Mark {
                label: on_part.label.clone(),
                part: marked.part.0,
                p: point(&on_part.p),
            });
        }
    }
    let read = !marks.is_empty();
    scene.sets = Vec::new();
    if read {
        scene.sets.push(Role::Measured);
    }
    scene.sets.extend(positions.iter().map(|set| set.role));
    if scene.sets.is_empty() {
        scene.sets.push(Role::Model);
        return scene;
    }
    for (case, of) in measurement.cases.iter().enumerate() {
        let mut poses = Vec::new();
        if read {
            let measured = measurement.poses(case, model);
            poses.push(
                measured
                    .iter()
                    .map(|pose| pose.as_ref().map(|found| Placed::new(&found.pose)))
                    .collect(),
            );
        }
        let shown = |set: &Positions| -> Vec<Option<Placed>> {
            match set.cases.get(case).and_then(Option::as_ref) {
                Some(poses) => poses.iter().map(|pose| Some(Placed::new(pose))).collect(),
                None => vec![None; model.parts.len()],
            }
        };
        poses.extend(positions.iter().map(shown));
        let place = |&(part, mark): &(usize, usize)| {
            let mut readings = of.marks.iter();
            let reading = readings.find(|reading| reading.part == part && reading.mark == mark)?;
            Some(point(&reading.x))
        };
        let stands = positions
            .last()
            .and_then(|set| set.cases.get(case)?.as_ref());
        let held = if of.held_out { " (held out)" } else { "" };
        let arrows = arrows(loaded, &scene, case, stands);
        scene.frames.push(Frame {
            label: of.label.clone(),
            note: format!("{}{held}", loads(loaded, case)),
            poses,
            marks: marks.iter().map(place).collect(),
            arrows,
        });
    }
    scene
}

/// Returns the marker at the wheel centre and its spin axis, from `[wheel]` or `[kc]` of the study.
fn wheel_marker(loaded: &LoadedStudy) -> Option<(MarkerIx, usize)> {
    if let Some(wheel) = &loaded.measurement.wheel {
        return Some((wheel.marker, wheel.spin.axis));
    }
    let (kc, _) = loaded.study.kc.as_ref()?;
    let id = kc.marker.text.rsplit('/').next()?.parse().ok()?;
    Some((loaded.model.marker(id)?, kc.axis.axis))
}

/// Lists the loads of a case in words.
fn loads(loaded: &LoadedStudy, case: usize) -> String {
    let programme = &loaded.programme;
    let Some(case) = programme.cases.get(case) else {
        return String::new();
    };
    let texts = programme.loads.iter().zip(&case.values);
    let texts: Vec<String> = texts
        .map(|(load, value)| format!("{} {}", load.name, super::number(*value, None)))
        .collect();
    texts.join(", ")
}

/// Returns the forces among the loads of a case as arrows, in ground axes. An SFORCE acts along the line between its markers, or along the z
/// axis of J if it acts on I alone. GFORCE and VFORCE are given by component.
fn arrows(
    loaded: &LoadedStudy,
    scene: &Scene,
    case: usize,
    stands: Option<&Vec<Pose>>,
) -> Vec<Arrow> {
    let model = &loaded.model;
    let frame = |marker: MarkerIx| {
        let marker = &model.markers[marker.0];
        let part = stands.map_or(model.parts[marker.part.0].pose, |poses| {
            poses[marker.part.0]
        });
        part.compose(&Pose {
            p: marker.qp,
            R: marker.R,
        })
    };
    let mut out: Vec<(usize, Vec3)> = Vec::new();
    let Some(values) = loaded.programme.cases.get(case) else {
        return Vec::new();
    };
    for (load, value) in loaded.programme.loads.iter().zip(&values.values) {
        let Some(id) = load.target.id else { continue };
        let Some(object) = scene.object(&format!("{}/{id}", load.target.kind)) else {
            continue;
        };
        let force = match load.target.kind.as_str() {
            "SFORCE" => {
                let found = model.sforces.iter().find(|force| force.header.id == id);
                let Some(force) = found
                    .filter(|force| force.kind == admire_solver::model::SforceKind::Translational)
                else {
                    continue;
                };
                let (i, j) = (frame(force.i), frame(force.j));
                let line = i.p - j.p;
                if force.action_only || line.norm() == 0.0 {
                    j.R.column(2) * *value
                } else {
                    line.normalize() * *value
                }
            }
            "GFORCE" | "VFORCE" => {
                let found = model
                    .vector_forces
                    .iter()
                    .find(|force| force.header.id == id);
                let argument = load.target.argument.as_deref();
                let axis = ["FX", "FY", "FZ"]
                    .iter()
                    .position(|name| Some(*name) == argument);
                let (Some(force), Some(axis)) = (found, axis) else {
                    continue;
                };
                let axes = force.rm.map_or_else(Pose::identity, frame).R;
                axes.column(axis) * *value
            }
            _ => continue,
        };
        match out.iter_mut().find(|(of, _)| *of == object) {
            Some((_, sum)) => *sum += force,
            None => out.push((object, force)),
        }
    }
    out.into_iter()
        .filter(|(_, force)| force.norm() > 0.0 && force.iter().all(|x| x.is_finite()))
        .map(|(object, force)| Arrow {
            object,
            force: point(&force),
        })
        .collect()
}
