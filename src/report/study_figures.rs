use super::axis::axis_label;
use super::load_run::LoadRun;
use super::scene::Role;
use super::{Chart, DrawingError, Figure, HeatMap, Positions, Series, SeriesStyle, short_unit};
use admire_identify::LoadedStudy;
use admire_identify::global::Prepared;
use admire_solver::mechanics::{Pose, Vec3, Vec6};
use admire_solver::model::{MarkerIx, SforceKind};
use admire_solver::system::Scratch;
use admire_study::deflection::{DeflectionForm, deflection};
use admire_study::wheel::WheelReading;

/// Maximum number of cases for which a heat map is readable.
const MAPPED: usize = 60;
/// Names of the six components of a bushing.
const AXES: [&str; 6] = ["x", "y", "z", "about x", "about y", "about z"];

/// Returns the axis label of a load. The unit of a force is added, unless the name of the load already contains a unit.
pub(super) fn load_axis(loaded: &LoadedStudy, name: &str) -> String {
    let load = loaded.programme.loads.iter().find(|load| load.name == name);
    let argument = load.and_then(|load| load.target.argument.as_deref());
    let turns = argument.is_some_and(|argument| argument.starts_with('T'));
    let is_force = load.is_some_and(|load| {
        let kind = load.target.kind.as_str();
        let is_torque = |force: &admire_solver::model::Sforce| {
            Some(force.header.id) == load.target.id && force.kind == SforceKind::Rotational
        };
        match kind {
            "SFORCE" => !loaded.model.sforces.iter().any(is_torque),
            "GFORCE" | "VFORCE" => !turns,
            _ => false,
        }
    });
    let unit = if is_force {
        short_unit(loaded.model.units.force.word)
    } else {
        String::new()
    };
    axis_label(name, &unit)
}

/// Pictures of a study that are drawn from the poses of its models. `positions` lists the models in the order of comparison, the best model
/// last.
pub(super) struct StudyFigures<'a> {
    pub loaded: &'a LoadedStudy,
    pub positions: &'a [Positions],
}

impl StudyFigures<'_> {
    /// Draws the rms residual of the marks in each case. Points show the cases that no fit used.
    pub(crate) fn by_case(&self) -> Result<Option<Figure>, DrawingError> {
        let measurement = &self.loaded.measurement;
        if measurement.cases.iter().all(|case| case.marks.is_empty()) || self.positions.is_empty() {
            return Ok(None);
        }
        let rms = |set: usize, case: usize| {
            let squares: Vec<f64> = self
                .misfits(set, case)
                .map(|(_, r)| r.norm_squared())
                .collect();
            let count = 3.0 * squares.len() as f64;
            (count > 0.0).then(|| {
                (
                    (case + 1) as f64,
                    (squares.iter().sum::<f64>() / count).sqrt(),
                )
            })
        };
        let cases = || 0..measurement.cases.len();
        let of = |(set, positions): (usize, &Positions)| {
            let points = cases().filter_map(|case| rms(set, case)).collect();
            Series::of(positions.role, points)
        };
        let mut series: Vec<Series> = self.positions.iter().enumerate().map(of).collect();
        let last = self.positions.len() - 1;
        let held: Vec<(f64, f64)> = cases()
            .filter(|case| measurement.cases[*case].held_out)
            .filter_map(|case| rms(last, case))
            .collect();
        if !held.is_empty() {
            let role = self.positions[last].role;
            series.push(Series {
                name: format!("{}, held-out cases", role.name()),
                mark: SeriesStyle::Points,
                ..Series::of(role, held)
            });
        }
        let chart = Chart {
            title: "Error of the marks by case".to_string(),
            x: "case, in the order of application".to_string(),
            y: axis_label("rms error per coordinate", self.length()),
            series,
            log_y: true,
            level: (measurement.sigma > 0.0).then_some(measurement.sigma),
            ..Chart::default()
        };
        let caption = "Rms of prediction minus reading of the marks, per coordinate. The dotted line is the standard deviation of one reading.";
        Figure::chart(&chart, caption).map(Some)
    }

    fn length(&self) -> &'static str {
        self.loaded.model.units.length.word
    }

    /// Returns prediction minus reading of every mark read in a case. Each entry holds the part index, the mark index and the vector in
    /// ground axes.
    fn misfits(
        &self,
        set: usize,
        case: usize,
    ) -> impl Iterator<Item = ((usize, usize), Vec3)> + '_ {
        let measurement = &self.loaded.measurement;
        let poses = self.positions[set].cases.get(case).and_then(Option::as_ref);
        poses.into_iter().flat_map(move |poses| {
            measurement.cases[case].marks.iter().map(move |reading| {
                let part = &measurement.parts[reading.part];
                let predicted = poses[part.part.0].point(&part.marks[reading.mark].p);
                ((reading.part, reading.mark), predicted - reading.x)
            })
        })
    }

    /// Draws heat maps of the residuals by case and mark, one map per model.
    pub(crate) fn maps(&self) -> Vec<Figure> {
        let measurement = &self.loaded.measurement;
        let mut first = Vec::new();
        let mut columns = Vec::new();
        for part in &measurement.parts {
            first.push(columns.len());
            columns.extend(
                part.marks
                    .iter()
                    .map(|mark| format!("{} {}", part.name, mark.label)),
            );
        }
        if measurement.cases.len() > MAPPED || columns.is_empty() {
            return Vec::new();
        }
        let sigma = measurement.sigma;
        let (unit, scale) = if sigma > 0.0 {
            ("standard deviations".to_string(), sigma)
        } else {
            (self.length().to_string(), 1.0)
        };
        let map = |set: usize| {
            let mut largest = 0.0_f64;
            let values: Vec<Vec<Option<f64>>> = (0..measurement.cases.len())
                .map(|case| {
                    let mut row = vec![None; columns.len()];
                    for ((part, mark), misfit) in self.misfits(set, case) {
                        // Each cell shows the worst coordinate with its sign.
                        let value = misfit
                            .iter()
                            .copied()
                            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
                        let value = value.map(|value| value / scale);
                        largest = largest.max(value.map_or(0.0, f64::abs));
                        row[first[part] + mark] = value;
                    }
                    row
                })
                .collect();
            let name = self.positions[set].role.name();
            let map = HeatMap {
                title: format!("Residuals, {name}"),
                rows: measurement
                    .cases
                    .iter()
                    .map(|case| format!("case {}", case.label))
                    .collect(),
                columns: columns.clone(),
                values,
                limit: if sigma > 0.0 { 6.0 } else { largest },
                what: format!("prediction minus reading, largest of three coordinates, {unit}"),
            };
            Figure::map(
                &map,
                "Blue is negative, red is positive, white is zero. Hover over a cell to see its value.",
            )
        };
        (0..self.positions.len()).map(map).collect()
    }

    /// Draws force over deflection of one bushing, one chart for each component that moves. Lines show the force laws, points the
    /// measurement. `stiffness` holds the initial and the identified stiffnesses.
    pub(crate) fn bushing(
        &self,
        bushing: usize,
        stiffness: [[f64; 6]; 2],
    ) -> Result<Vec<Figure>, DrawingError> {
        let (model, measurement) = (&self.loaded.model, &self.loaded.measurement);
        let law = &model.bushings[bushing];
        let Some(fitted) = self.positions.last() else {
            return Ok(Vec::new());
        };
        let mut preload = [0.0; 6];
        preload[..3].copy_from_slice(&law.force);
        preload[3..].copy_from_slice(&law.torque);
        let mut found: Vec<(Option<Vec6>, Vec6)> = Vec::new();
        for case in 0..measurement.cases.len() {
            let Some(poses) = fitted.cases.get(case).and_then(Option::as_ref) else {
                continue;
            };
            let part = |marker: MarkerIx| model.markers[marker.0].part.0;
            let at = |i: &Pose, j: &Pose| {
                let own = |marker: MarkerIx| Pose {
                    p: model.markers[marker.0].qp,
                    R: model.markers[marker.0].R,
                };
                deflection(i, &own(law.i), j, &own(law.j), DeflectionForm::Corrected)
            };
            let read = measurement.poses(case, model);
            let both = read[part(law.i)].as_ref().zip(read[part(law.j)].as_ref());
            let read = both.map(|(i, j)| at(&i.pose, &j.pose));
            found.push((read, at(&poses[part(law.i)], &poses[part(law.j)])));
        }
        let force = short_unit(model.units.force.word);
        let mut out = Vec::new();
        for axis in 0..6 {
            let turning = axis >= 3;
            let scale = if turning { 1f64.to_degrees() } else { 1.0 };
            // The plotted force acts on marker J, so it increases with the deflection.
            let load = |stiffness: f64, d: f64| stiffness * d - preload[axis];
            let [initial, identified] = [stiffness[0][axis], stiffness[1][axis]];
            let read: Vec<(f64, f64)> = found
                .iter()
                .filter_map(|(read, model)| {
                    Some((read.as_ref()?[axis] * scale, load(identified, model[axis])))
                })
                .collect();
            let reach = found.iter().flat_map(|(read, model)| {
                [Some(model[axis]), read.as_ref().map(|read| read[axis])]
            });
            let (low, high) = reach.flatten().fold((0.0_f64, 0.0_f64), |(low, high), d| {
                (low.min(d), high.max(d))
            });
            if high - low < 1e-12 {
                continue;
            }
            let line = |role: Role, stiffness: f64| {
                let ends = [low, high].map(|d| (d * scale, load(stiffness, d)));
                Series::of(role, ends.to_vec())
            };
            let mut series = vec![line(Role::Identified, identified)];
            if initial != identified {
                series.push(line(Role::Given, initial));
            }
            if !read.is_empty() {
                series.push(Series::of(Role::Measured, read));
            }
            let (what, unit, moves) = if turning {
                ("torque on J", format!("{force} {}", self.length()), "deg")
            } else {
                ("force on J", force.clone(), self.length())
            };
            let chart = Chart {
                title: format!("{} {}", law.header.name, AXES[axis]),
                x: axis_label(&format!("deflection {}", AXES[axis]), moves),
                y: axis_label(what, &unit),
                series,
                level: Some(0.0),
                ..Chart::default()
            };
            out.push(Figure::chart(&chart, "")?);
        }
        Ok(out)
    }

    /// Returns, for each load, the cases in which all other loads have their values of the first case. Loads with fewer than three different
    /// values in these cases are omitted.
    fn alone(&self) -> Vec<(usize, Vec<usize>)> {
        let programme = &self.loaded.programme;
        let Some(rest) = programme.cases.first().map(|case| &case.values) else {
            return Vec::new();
        };
        let of = |load: usize| {
            let alone = |case: &usize| {
                let values = programme.cases[*case].values.iter().zip(rest);
                values.enumerate().all(|(k, (a, b))| k == load || a == b)
            };
            let cases: Vec<usize> = (0..programme.cases.len()).filter(alone).collect();
            let mut levels: Vec<f64> = cases
                .iter()
                .map(|case| programme.cases[*case].values[load])
                .collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup();
            (levels.len() >= 3).then_some((load, cases))
        };
        (0..programme.loads.len()).filter_map(of).collect()
    }

    /// Returns the readings of wheel and channels over each load that varies alone.
    pub(crate) fn runs(&self) -> Vec<LoadRun> {
        let mut out = self.wheel();
        out.extend(self.channels());
        out
    }

    /// Returns a run of one reading, as measured and by each model.
    fn run(
        &self,
        (what, unit): (&str, &str),
        (load, cases): &(usize, Vec<usize>),
        measured: impl Fn(usize) -> Option<f64>,
        predicted: impl Fn(usize, usize) -> Option<f64>,
    ) -> LoadRun {
        let programme = &self.loaded.programme;
        let value = |case: usize| programme.cases[case].values[*load];
        let points = |of: &dyn Fn(usize) -> Option<f64>| -> Vec<(f64, f64)> {
            let read = cases
                .iter()
                .filter_map(|case| Some((value(*case), of(*case)?)));
            read.collect()
        };
        let mut series = vec![Series::of(Role::Measured, points(&measured))];
        series.retain(|series| !series.points.is_empty());
        for (set, positions) in self.positions.iter().enumerate() {
            let own = once(points(&|case| predicted(set, case)));
            series.push(Series::of(positions.role, own));
        }
        LoadRun {
            what: what.to_string(),
            unit: unit.to_string(),
            load: load_axis(self.loaded, &programme.loads[*load].name),
            series,
            unseen: false,
        }
    }

    /// Returns the curves of a K&C rig. Only channels that follow from the poses of the parts alone can be predicted.
    fn channels(&self) -> Vec<LoadRun> {
        let measurement = &self.loaded.measurement;
        let is_curve = |channel: &admire_study::Channel| {
            channel.is_read_by_case() && !channel.helpers.is_empty()
        };
        if self.positions.is_empty() || !measurement.channels.iter().any(is_curve) {
            return Vec::new();
        }
        let Ok(prepared) = Prepared::new(&self.loaded.problem()) else {
            return Vec::new();
        };
        let (system, theta) = (&prepared.system, prepared.system.parameters());
        let mut scratch = Scratch::new(system);
        let mut read = |poses: &Option<Vec<Pose>>| {
            let poses = poses.as_ref()?;
            Some(prepared.channels.at(system, &theta, poses, &mut scratch))
        };
        let shown: Vec<Vec<Option<Vec<Option<f64>>>>> = self
            .positions
            .iter()
            .map(|positions| positions.cases.iter().map(&mut read).collect())
            .collect();
        let mut out = Vec::new();
        for alone in self.alone() {
            for (k, channel) in measurement.channels.iter().enumerate() {
                if !is_curve(channel) {
                    continue;
                }
                let at = |set: usize, case: usize| *shown[set].get(case)?.as_ref()?.get(k)?;
                out.push(self.run(
                    (&channel.name, channel.unit.as_deref().unwrap_or_default()),
                    &alone,
                    |case| measurement.cases[case].channels[k],
                    |set, case| {
                        let zero = match channel.reference(case) {
                            Some(zero) => at(set, zero)?,
                            None => 0.0,
                        };
                        Some(at(set, case)? - zero)
                    },
                ));
            }
        }
        out
    }

    /// Returns steer, camber and position of the wheel.
    fn wheel(&self) -> Vec<LoadRun> {
        let measurement = &self.loaded.measurement;
        let Some(wheel) = &measurement.wheel else {
            return Vec::new();
        };
        let model = &self.loaded.model;
        let marker = &model.markers[wheel.marker.0];
        let own = Pose {
            p: marker.qp,
            R: marker.R,
        };
        let length = self.length();
        let readings: [(&str, &str, fn(&WheelReading) -> f64); 4] = [
            ("steer", "deg", |reading| reading.steer_deg),
            ("camber", "deg", |reading| reading.camber_deg),
            ("wheel x", length, |reading| reading.position.x),
            ("wheel z", length, |reading| reading.position.z),
        ];
        let mut out = Vec::new();
        for alone in self.alone() {
            for (name, unit, of) in readings {
                out.push(self.run(
                    (name, unit),
                    &alone,
                    |case| measurement.cases[case].wheel.as_ref().map(of),
                    |set, case| {
                        let poses = self.positions[set].cases.get(case)?.as_ref()?;
                        let at = poses[marker.part.0].compose(&own);
                        Some(of(&wheel.spin.reading(&at)))
                    },
                ));
            }
        }
        out
    }

    /// Returns the displacement of one mark of each part over each load that varies alone, along one axis. The mark and the axis with the
    /// largest gain by the model are chosen.
    pub(crate) fn marks(&self) -> Vec<LoadRun> {
        let (model, measurement) = (&self.loaded.model, &self.loaded.measurement);
        let mut out: Vec<LoadRun> = Vec::new();
        for alone in self.alone() {
            for (part, marked) in measurement.parts.iter().enumerate() {
                let runs = marked.marks.iter().enumerate().flat_map(|(mark, on_part)| {
                    let design = model.parts[marked.part.0].pose.point(&on_part.p);
                    let alone = &alone;
                    (0..3).map(move |axis| {
                        let name =
                            format!("{} mark {}, {}", marked.name, on_part.label, AXES[axis]);
                        self.run(
                            (&name, self.length()),
                            alone,
                            |case| {
                                let mut all = measurement.cases[case].marks.iter();
                                let read = all.find(|r| r.part == part && r.mark == mark)?;
                                Some(read.x[axis] - design[axis])
                            },
                            |set, case| {
                                let poses = self.positions[set].cases.get(case)?.as_ref()?;
                                let at = poses[marked.part.0].point(&on_part.p);
                                Some(at[axis] - design[axis])
                            },
                        )
                    })
                });
                let runs = runs.filter(|run| run.gain().is_finite());
                out.extend(runs.max_by(|a, b| a.gain().total_cmp(&b.gain())));
            }
        }
        out
    }
}

/// Largest difference at which two values of a curve count as equal, relative to the range of the curve.
const ONE: f64 = 2e-3;

/// Reduces a curve that returns along the same path to a single pass; otherwise overlapping dashes would fill each other's gaps. A hysteresis loop
/// keeps its points in the order driven.
fn once(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut sorted = points.clone();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(p.1), high.max(p.1))
        });
    let (mut one, mut again) = (true, false);
    for pair in sorted.windows(2) {
        if pair[0].0 == pair[1].0 {
            again = true;
            one &= (pair[0].1 - pair[1].1).abs() <= ONE * (high - low);
        }
    }
    if !(one && again) {
        return points;
    }
    sorted.dedup_by(|a, b| a.0 == b.0);
    sorted
}

#[cfg(test)]
mod tests {
    use super::once;

    #[test]
    fn a_way_back_is_drawn_once_and_a_loop_twice() {
        let there = vec![(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (1.0, 2.0), (0.0, 0.0)];
        assert_eq!(once(there), [(0.0, 0.0), (1.0, 2.0), (2.0, 4.0)]);
        let loops = vec![(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (1.0, 2.5), (0.0, 0.4)];
        assert_eq!(once(loops.clone()), loops);
    }
}
