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
    if !is_force || name.contains(['[', '(']) {
        return name.to_string();
    }
    format!("{name}, {}", short_unit(loaded.model.units.force.word))
}

/// Pictures of a study that are drawn from the poses of its models. `positions` lists the models in the order of comparison, the best model
/// last.
pub(super) struct StudyFigures<'a> {
    pub loaded: &'a LoadedStudy,
    pub positions: &'a [Positions],
}

impl StudyFigures<'_> {
    fn mark(&self, set: usize) -> SeriesStyle {
        if set + 1 == self.positions.len() {
            SeriesStyle::Line
        } else {
            SeriesStyle::Dashed
        }
    }

    /// Returns the roles of the curves in a chart: the measurement, then each model.
    fn roles(&self) -> Vec<Role> {
        let models = self.positions.iter().map(|positions| positions.role);
        std::iter::once(Role::Measured).chain(models).collect()
    }

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
        let mut roles: Vec<Role> = self
            .positions
            .iter()
            .map(|positions| positions.role)
            .collect();
        let mut series: Vec<Series> = self
            .positions
            .iter()
            .enumerate()
            .map(|(set, positions)| Series {
                name: positions.name.clone(),
                points: cases().filter_map(|case| rms(set, case)).collect(),
                mark: self.mark(set),
            })
            .collect();
        let last = self.positions.len() - 1;
        let held: Vec<(f64, f64)> = cases()
            .filter(|case| measurement.cases[*case].held_out)
            .filter_map(|case| rms(last, case))
            .collect();
        if !held.is_empty() {
            series.push(Series {
                name: format!("{}, cases no fit saw", self.positions[last].name),
                points: held,
                mark: SeriesStyle::Points,
            });
            roles.push(self.positions[last].role);
        }
        let chart = Chart {
            title: "Error of the model, case by case".to_string(),
            x: "case, in the order of application".to_string(),
            y: format!("rms of one mark coordinate, {}", self.length()),
            series,
            log_y: true,
            level: (measurement.sigma > 0.0).then_some(measurement.sigma),
        };
        let caption = "Prediction minus reading of the marks. The dotted line is the standard deviation of one reading.";
        Figure::of_roles(&chart, &roles, caption).map(Some)
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
            ("sigmas".to_string(), sigma)
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
            let name = &self.positions[set].name;
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
                what: format!("prediction minus reading, worst coordinate, {unit}"),
            };
            Figure::map(
                &map,
                "Blue is negative, red positive, blank is zero. Point at a cell for its value.",
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
            let line = |name: &str, stiffness: f64, mark| Series {
                name: name.to_string(),
                points: [low, high]
                    .map(|d| (d * scale, load(stiffness, d)))
                    .to_vec(),
                mark,
            };
            let mut series = vec![line("identified law", identified, SeriesStyle::Line)];
            let mut roles = vec![Role::Fitted];
            if initial != identified {
                series.push(line("initial law", initial, SeriesStyle::Dashed));
                roles.push(Role::Initial);
            }
            roles.push(Role::Measured);
            if !read.is_empty() {
                series.push(Series {
                    name: "measured deflection, force of the model".to_string(),
                    points: read,
                    mark: SeriesStyle::Points,
                });
            }
            let unit = if turning {
                format!("torque on J, {force} {}", self.length())
            } else {
                format!("force on J, {force}")
            };
            let chart = Chart {
                title: format!("{} {}", law.header.name, AXES[axis]),
                x: format!(
                    "deflection {}, {}",
                    AXES[axis],
                    if turning { "deg" } else { self.length() }
                ),
                y: unit,
                series,
                log_y: false,
                level: Some(0.0),
            };
            out.push(Figure::of_roles(&chart, &roles, "")?);
        }
        Ok(out)
    }

    /// Returns, for each load, the cases in which all other loads have their values of the first case. Loads with fewer than three different
    /// values in these cases are omitted.
    fn runs(&self) -> Vec<(usize, Vec<usize>)> {
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

    /// Draws the curves of a K&C rig over each load that varies alone, in the order of application.
    pub(crate) fn curves(&self) -> Result<Vec<Figure>, DrawingError> {
        let (measurement, programme) = (&self.loaded.measurement, &self.loaded.programme);
        // Only channels that follow from the poses of the parts alone can be drawn.
        let is_curve = |channel: &admire_study::Channel| {
            channel.is_read_by_case() && !channel.helpers.is_empty()
        };
        if self.positions.is_empty() || !measurement.channels.iter().any(is_curve) {
            return Ok(Vec::new());
        }
        let Ok(prepared) = Prepared::new(&self.loaded.problem()) else {
            return Ok(Vec::new());
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
        for (load, cases) in self.runs() {
            let of = &programme.loads[load];
            let value = |case: usize| programme.cases[case].values[load];
            for (k, channel) in measurement.channels.iter().enumerate() {
                if !is_curve(channel) {
                    continue;
                }
                let measured = cases
                    .iter()
                    .filter_map(|case| Some((value(*case), measurement.cases[*case].channels[k]?)));
                let mut series = vec![Series {
                    name: "measured".to_string(),
                    points: measured.collect(),
                    mark: SeriesStyle::Points,
                }];
                for (set, (positions, shown)) in self.positions.iter().zip(&shown).enumerate() {
                    let at = |case: usize| *shown.get(case)?.as_ref()?.get(k)?;
                    let points = cases.iter().filter_map(|case| {
                        let zero = match channel.reference(*case) {
                            Some(zero) => at(zero)?,
                            None => 0.0,
                        };
                        Some((value(*case), at(*case)? - zero))
                    });
                    series.push(Series {
                        name: positions.name.clone(),
                        points: once(points.collect()),
                        mark: self.mark(set),
                    });
                }
                let unit = channel.unit.as_deref().unwrap_or_default();
                let chart = Chart {
                    title: format!("{} against {}", channel.name, of.name),
                    x: load_axis(self.loaded, &of.name),
                    y: format!("{}, {unit}", channel.name),
                    series,
                    log_y: false,
                    level: None,
                };
                out.push(Figure::of_roles(
                    &chart,
                    &self.roles(),
                    "The other loads stand still.",
                )?);
            }
        }
        Ok(out)
    }

    /// Draws camber, steer and position of the wheel over each load that varies alone, in the order of application.
    pub(crate) fn wheel(&self) -> Result<Vec<Figure>, DrawingError> {
        let (measurement, programme) = (&self.loaded.measurement, &self.loaded.programme);
        let Some(wheel) = &measurement.wheel else {
            return Ok(Vec::new());
        };
        let model = &self.loaded.model;
        let marker = &model.markers[wheel.marker.0];
        let own = Pose {
            p: marker.qp,
            R: marker.R,
        };
        let length = self.length();
        let channels: [(&str, &str, fn(&WheelReading) -> f64); 4] = [
            ("Camber", "deg", |reading| reading.camber_deg),
            ("Steer", "deg", |reading| reading.steer_deg),
            ("Wheel x", length, |reading| reading.position.x),
            ("Wheel z", length, |reading| reading.position.z),
        ];
        let mut out = Vec::new();
        for (load, cases) in self.runs() {
            let of = &programme.loads[load];
            let value = |case: usize| programme.cases[case].values[load];
            for (name, unit, of_reading) in channels {
                let read = cases.iter().filter_map(|case| {
                    let reading = measurement.cases[*case].wheel.as_ref()?;
                    Some((value(*case), of_reading(reading)))
                });
                let mut series = vec![Series {
                    name: "measured".to_string(),
                    points: read.collect(),
                    mark: SeriesStyle::Points,
                }];
                series.extend(self.positions.iter().enumerate().map(|(set, positions)| {
                    let points = cases.iter().filter_map(|case| {
                        let poses = positions.cases.get(*case)?.as_ref()?;
                        let at = poses[marker.part.0].compose(&own);
                        Some((value(*case), of_reading(&wheel.spin.reading(&at))))
                    });
                    Series {
                        name: positions.name.clone(),
                        points: once(points.collect()),
                        mark: self.mark(set),
                    }
                }));
                let chart = Chart {
                    title: format!("{name} against {}", of.name),
                    x: load_axis(self.loaded, &of.name),
                    y: format!("{}, {unit}", name.to_lowercase()),
                    series,
                    log_y: false,
                    level: None,
                };
                out.push(Figure::of_roles(
                    &chart,
                    &self.roles(),
                    "The other loads stand still.",
                )?);
            }
        }
        Ok(out)
    }
}

/// Largest difference at which two values of a curve count as equal, relative to the range of the curve.
const ONE: f64 = 2e-3;

/// Reduces a curve that returns along itself to a single pass; otherwise overlapping dashes would hide each other's gaps. A hysteresis loop
/// is kept in the order driven.
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
