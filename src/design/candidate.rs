//! Candidate measurements: load cases, repetitions, loops, marks, wheel curves and load cells.

use super::load_values::{ends, plain, round, shown, usual};
use crate::settings::{
    ASSUMED_MARK_MM, ASSUMED_WHEEL_ANGLE_DEG, ASSUMED_WHEEL_POSITION_MM, LOAD_CELL_NOISE,
    MAX_LOAD_CASES, MAX_LOAD_CELLS, MAX_MARK_POSITIONS, MAX_REPEATED_CASES, RANGE_TOLERANCE,
};
use serde::Serialize;

use admire_diagnosis::DiagnosisProblem;
use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model, PartIx, PartKind};
use admire_study::Available;

/// Kind of a candidate measurement.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// New load case.
    Load,
    /// Repetition of a load case of the study.
    Repeat,
    /// Loop of one load: up and back, then to the other side and back.
    Loop,
    /// New mark (measured point) on a part, read in all cases.
    Mark,
    /// New curve of the wheel, read in all cases.
    Curve,
    /// New load cell in an element, read in all cases.
    LoadCell,
}

/// Candidate for the next measurement.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct ProposedMeasurement {
    /// Kind of measurement.
    pub kind: Kind,
    /// Instruction for the measurement, in words.
    pub what: String,
    /// New load cases, mark, wheel component or load cell that this measurement adds to the study.
    pub new: New,
    /// True if the laboratory of the study can take this measurement.
    pub is_available: bool,
}

/// Load cases or instrument that a candidate measurement adds to the study.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum New {
    /// Load cases in order, with one value per load. All instruments of the study are read in these cases.
    Cases(Vec<Vec<f64>>),
    /// Position of a new mark on a part, in the frame of the part.
    Mark(PartIx, Vec3),
    /// Component of the wheel, with the standard deviation of one reading. Components 0 to 2 are x, y and z of the centre, 3 is camber, 4 is
    /// toe.
    Wheel(usize, f64),
    /// Deck functions that are read, as a range of indices into [`ProposedMeasurements::functions`].
    Functions(std::ops::Range<usize>),
}

/// All candidate measurements that a plan considers.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct ProposedMeasurements {
    /// Candidates in the order of their creation.
    pub list: Vec<ProposedMeasurement>,
    /// Deck functions that the load cells read.
    pub functions: Vec<String>,
    /// Number of load combinations that were not considered, to limit the effort.
    pub left_out: usize,
}

impl ProposedMeasurement {
    fn cases(kind: Kind, what: String, cases: Vec<Vec<f64>>) -> Self {
        Self {
            kind,
            what,
            new: New::Cases(cases),
            is_available: true,
        }
    }

    /// Returns the load cases of the candidate; empty for an instrument.
    pub(super) fn sequence(&self) -> &[Vec<f64>] {
        match &self.new {
            New::Cases(cases) => cases,
            _ => &[],
        }
    }
}

impl ProposedMeasurements {
    /// Creates candidate load cases: each available load alone, and pairs of them. Each load is at an end of its range. A load whose range
    /// is not stated deviates from its usual value in both directions, by its largest deviation in the study times each of `factors`.
    pub(super) fn loads(programme: &LoadProgramme, available: &Available, factors: &[f64]) -> Self {
        let usual = usual(programme);
        let ends = |load: usize, factor: f64| ends(programme, available, &usual, load, factor);
        let mut new = Self::default();
        let mut add = |sides: &[(usize, f64)], factor: f64| {
            if new.list.len() == MAX_LOAD_CASES {
                new.left_out += 1;
                return;
            }
            let mut values = usual.clone();
            for (load, value) in sides {
                values[*load] = *value;
            }
            let each = sides
                .iter()
                .map(|(load, _)| shown(programme, *load, values[*load]));
            let mut what = each.collect::<Vec<_>>().join(", ");
            if factor > 1.0 {
                what += " (beyond)";
            }
            let known = |of: &ProposedMeasurement| of.sequence()[0] == values;
            if !new.list.iter().any(known) {
                new.list
                    .push(ProposedMeasurement::cases(Kind::Load, what, vec![values]));
            }
        };
        for factor in factors {
            for load in 0..usual.len() {
                for value in ends(load, *factor) {
                    add(&[(load, value)], *factor);
                }
            }
        }
        for factor in factors {
            for a in 0..usual.len() {
                for b in a + 1..usual.len() {
                    for one in ends(a, *factor) {
                        for other in ends(b, *factor) {
                            add(&[(a, one), (b, other)], *factor);
                        }
                    }
                }
            }
        }
        new
    }

    /// Returns a new list in which the loads of the candidates deviate less from their usual values. `reach` holds, for each candidate, the ratio of
    /// its deflections to the largest deflections in the study. The load deviations are divided by this ratio. Candidates within the range of the
    /// study are left out. Also returns the index of each candidate in the new list; `None` if it is left out.
    pub(super) fn reduced(
        &self,
        programme: &LoadProgramme,
        reach: &[f64],
    ) -> (Self, Vec<Option<usize>>) {
        let usual = usual(programme);
        let mut new = Self::default();
        let mut places = Vec::new();
        for (candidate, reach) in self.list.iter().zip(reach) {
            let New::Cases(cases) = &candidate.new else {
                places.push(None);
                continue;
            };
            if !(*reach > 1.0 + RANGE_TOLERANCE) {
                places.push(None);
                continue;
            }
            let nearer = |values: &Vec<f64>| {
                let each = values.iter().zip(&usual);
                each.map(|(value, usual)| usual + (value - usual) / reach)
                    .collect()
            };
            places.push(Some(new.list.len()));
            new.list.push(ProposedMeasurement {
                new: New::Cases(cases.iter().map(nearer).collect()),
                ..candidate.clone()
            });
        }
        (new, places)
    }

    /// Removes candidate load cases that only repeat cases of the study. If the laboratory can repeat cases, adds repetitions of up to
    /// `MAX_REPEATED_CASES` cases of the study instead.
    pub(super) fn repeats(&mut self, programme: &LoadProgramme, available: &Available) {
        let is_there = |values: &Vec<f64>| programme.cases.iter().any(|c| c.values == *values);
        self.list
            .retain(|candidate| !candidate.sequence().iter().all(is_there));
        if !available.repeats {
            return;
        }
        let mut seen: Vec<(&[f64], Vec<&str>)> = Vec::new();
        for case in &programme.cases {
            match seen.iter_mut().find(|(values, _)| *values == case.values) {
                Some((_, labels)) => labels.push(&case.label),
                None => seen.push((&case.values, vec![&case.label])),
            }
        }
        let step = seen.len().div_ceil(MAX_REPEATED_CASES).max(1);
        for (values, labels) in seen.iter().step_by(step) {
            let what = match labels.len() {
                1 => format!("case {} again", labels[0]),
                count => format!("case {} again (measured {count} times so far)", labels[0]),
            };
            let cases = vec![values.to_vec()];
            self.list
                .push(ProposedMeasurement::cases(Kind::Repeat, what, cases));
        }
    }

    /// Adds a loop of each available load: from the usual value to one end of its range and back, then to the other end and back.
    pub(super) fn loops(&mut self, programme: &LoadProgramme, available: &Available) {
        let usual = usual(programme);
        for load in 0..usual.len() {
            let ends = ends(programme, available, &usual, load, 1.0);
            let [Some(first), last] = [ends.first(), ends.get(1)] else {
                continue;
            };
            let at = |side: f64| {
                let end = if side > 0.0 { Some(first) } else { last };
                let away = end.map_or(0.0, |end| end - usual[load]);
                let mut values = usual.clone();
                values[load] = round(programme, load, values[load] + side.abs() * away);
                values
            };
            let cases: Vec<Vec<f64>> = [0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0]
                .map(at)
                .to_vec();
            let (low, high) = (cases[6][load], cases[2][load]);
            let what = format!(
                "loop {} to {}",
                shown(programme, load, low),
                plain(programme, load, high)
            );
            self.list
                .push(ProposedMeasurement::cases(Kind::Loop, what, cases));
        }
    }

    /// Adds new marks on all movable parts, at positions where the deck has markers.
    pub(super) fn marks(&mut self, model: &Model, available: &Available) {
        for (k, part) in model.parts.iter().enumerate() {
            if part.kind == PartKind::Ground {
                continue;
            }
            let is_available = available.marks.holds(&PartIx(k));
            let mut places: Vec<(u32, Vec3)> = Vec::new();
            for marker in model.markers.iter().filter(|m| m.part == PartIx(k)) {
                let far = |(_, place): &(u32, Vec3)| (place - marker.qp).norm() > 1e-6;
                if places.iter().all(far) {
                    places.push((marker.header.id, marker.qp));
                }
            }
            let step = places.len().div_ceil(MAX_MARK_POSITIONS).max(1);
            for (id, place) in places.iter().step_by(step) {
                let name = if part.header.name.is_empty() {
                    format!("PART/{}", part.header.id)
                } else {
                    part.header.name.clone()
                };
                self.list.push(ProposedMeasurement {
                    kind: Kind::Mark,
                    what: format!("mark on {name} near MARKER/{id}"),
                    new: New::Mark(PartIx(k), *place),
                    is_available,
                });
            }
        }
    }

    /// Adds the wheel curves that the study does not measure. If the study defines no wheel, the curves describe the marker where the loads
    /// act.
    pub(super) fn curves(&mut self, subject: &DiagnosisProblem<'_>) {
        let measurement = subject.problem.measurement;
        let read = |words: [&str; 2]| {
            measurement.wheel.is_some()
                || measurement.channels.iter().any(|channel| {
                    if !channel.is_read_by_case() {
                        return false;
                    }
                    let texts = [&channel.name, &channel.column.0].map(|text| text.to_lowercase());
                    words
                        .iter()
                        .any(|word| texts.iter().any(|t| t.contains(word)))
                })
        };
        let mm = subject.millimetre();
        let (angle, place) = (ASSUMED_WHEEL_ANGLE_DEG, ASSUMED_WHEEL_POSITION_MM * mm);
        let mut curves = [
            (4, ["toe", "steer"], "toe of the wheel".to_string(), angle),
            (
                3,
                ["camber", "camber"],
                "camber of the wheel".to_string(),
                angle,
            ),
            (
                0,
                ["base", "base"],
                "wheel centre along x".to_string(),
                place,
            ),
            (
                1,
                ["track", "track"],
                "wheel centre along y".to_string(),
                place,
            ),
            (
                2,
                ["travel", "travel"],
                "wheel centre along z".to_string(),
                place,
            ),
        ];
        let is_named = measurement.wheel.is_some()
            || measurement.channels.iter().any(|c| !c.helpers.is_empty());
        if !is_named {
            let Some(marker) = loaded_marker(subject) else {
                return;
            };
            let id = subject.problem.model.markers[marker.0].header.id;
            let words = ["rotation about z", "rotation about x", "x", "y", "z"];
            for ((.., what, _), word) in curves.iter_mut().zip(words) {
                *what = format!("{word} of MARKER/{id}");
            }
        }
        for (component, words, what, sigma) in curves {
            if !read(words) {
                self.list.push(ProposedMeasurement {
                    kind: Kind::Curve,
                    what,
                    new: New::Wheel(component, sigma),
                    is_available: measurement.available.wheel,
                });
            }
        }
    }

    /// Adds load cells in bushings, FIELDs and joints, each with three force components.
    pub(super) fn load_cells(&mut self, model: &Model, available: &Available) {
        let bushings = model.elastic_pairs().map(|pair| {
            let function = if pair.kind == "BUSHING" {
                "BUSH"
            } else {
                pair.kind
            };
            ([pair.kind, function], pair.header, pair.j)
        });
        let joints = model.joints.iter();
        let joints = joints.map(|j| (["JOINT", "JOINT"], &j.header, j.j));
        let all = bushings.chain(joints);
        let active = all.filter(|(_, header, _)| header.active);
        for ([kind, function], header, frame) in active.take(MAX_LOAD_CELLS) {
            let first = self.functions.len();
            let frame = model.markers[frame.0].header.id;
            for component in 2..=4 {
                let force = format!("{function}({},0,{component},{frame})", header.id);
                self.functions.push(force);
            }
            let address = format!("{kind}/{}", header.id);
            self.list.push(ProposedMeasurement {
                kind: Kind::LoadCell,
                what: format!("load cell in {address}"),
                new: New::Functions(first..self.functions.len()),
                is_available: available.load_cells.holds(&address),
            });
        }
    }
}

/// Returns the standard deviation of a load cell that measures `forces`.
pub(super) fn sigma_of_a_cell(forces: impl Iterator<Item = f64>) -> f64 {
    LOAD_CELL_NOISE * forces.fold(0.0_f64, |most, force| most.max(force.abs()))
}

/// Returns the standard deviation of the readings of a new mark, per coordinate and in the deck's length unit.
pub(super) fn sigma_of_a_mark(subject: &DiagnosisProblem<'_>) -> f64 {
    if subject.compares_marks() {
        subject.sigma
    } else {
        ASSUMED_MARK_MM * subject.millimetre()
    }
}

/// Returns the marker at which the loads act. It is taken from the first load that acts at a marker.
pub(super) fn loaded_marker(subject: &DiagnosisProblem<'_>) -> Option<MarkerIx> {
    let problem = &subject.problem;
    let mut loads = problem.programme.loads.iter();
    loads.find_map(|load| admire_identify::tolerance::acts_at(problem.model, &load.target))
}

#[cfg(test)]
mod tests {
    use super::{Kind, ProposedMeasurements};
    use crate::settings::BEYOND_RANGE_FACTOR;
    use admire_session::backend::{Load, LoadCase, LoadProgramme};
    use admire_study::{Available, LoadRange};
    use admire_syntax::text::Source;
    use admire_syntax::{Address, Dataset};

    fn programme(names: [&str; 2], cases: &[[f64; 2]]) -> LoadProgramme {
        let text = b"t\nSFORCE/1, I=1, J=2, FUNCTION=0\nEND\n";
        let dataset = Dataset::parse(Source::new("model.adm", text.to_vec())).value;
        let load = |name: &str| Load {
            name: name.to_string(),
            target: Address::parse("SFORCE/1", &dataset).unwrap(),
        };
        let case = |(k, values): (usize, &[f64; 2])| LoadCase {
            label: format!("{}", k + 1),
            values: values.to_vec(),
        };
        LoadProgramme {
            loads: names.map(load).to_vec(),
            cases: cases.iter().enumerate().map(case).collect(),
        }
    }

    /// Load cases as on a rig: the lateral load is varied at a vertical preload.
    const CASES: [[f64; 2]; 6] = [
        [1500.0, 0.0],
        [4500.0, 0.0],
        [7500.0, 0.0],
        [4500.0, -4000.0],
        [4500.0, 2000.0],
        [4500.0, 2000.0],
    ];

    #[test]
    fn loads_go_both_ways_from_where_they_usually_are() {
        let programme = programme(["vertical", "lateral"], &CASES);
        let usual = Available::default();
        let found = ProposedMeasurements::loads(&programme, &usual, &[1.0, BEYOND_RANGE_FACTOR]);
        let values: Vec<&[f64]> = found.list.iter().map(|c| &c.sequence()[0][..]).collect();
        let alone = [
            [7500.0, 0.0],
            [1500.0, 0.0],
            [4500.0, 4000.0],
            [4500.0, -4000.0],
            [8250.0, 0.0],
            [750.0, 0.0],
            [4500.0, 5000.0],
            [4500.0, -5000.0],
        ];
        assert_eq!(&values[..8], &alone.each_ref().map(|a| &a[..]));
        assert_eq!(values.len(), 16);
        assert!(values.contains(&&[750.0, 5000.0][..]));
        let what = &found.list.last().unwrap().what;
        assert_eq!(what, "vertical 750, lateral -5000 (beyond)");
    }

    /// Candidates stay within a stated range. A load that is not listed keeps its usual value.
    #[test]
    fn loads_stay_in_the_range_that_is_stated() {
        let programme = programme(["vertical", "lateral"], &CASES);
        let values = |available: &Available| -> Vec<Vec<f64>> {
            let found =
                ProposedMeasurements::loads(&programme, available, &[1.0, BEYOND_RANGE_FACTOR]);
            let each = found.list.iter();
            each.map(|candidate| candidate.sequence()[0].clone())
                .collect()
        };
        let mut available = Available {
            other_loads: LoadRange::Fixed,
            ..Available::default()
        };
        assert!(values(&available).is_empty());
        let range = LoadRange::Between([-1000.0, 500.0]);
        available.loads.insert("lateral".to_string(), range);
        assert_eq!(values(&available), [[4500.0, 500.0], [4500.0, -1000.0]]);
        available.other_loads = LoadRange::Applied;
        available.loads.clear();
        let applied = values(&available);
        assert!(applied.contains(&vec![7500.0, -4000.0]), "{applied:?}");
        let inside =
            |v: &Vec<f64>| (1500.0..=7500.0).contains(&v[0]) && (-4000.0..=2000.0).contains(&v[1]);
        assert!(applied.iter().all(inside), "{applied:?}");
    }

    /// If loads deflect the mechanism twice as far as in the study, their deviations from the usual loads are halved.
    #[test]
    fn loads_beyond_the_range_seen_are_reduced() {
        let programme = programme(["vertical", "lateral"], &CASES);
        let found = ProposedMeasurements::loads(&programme, &Available::default(), &[1.0]);
        let mut reach = vec![1.0; found.list.len()];
        reach[2] = 2.0;
        let (nearer, places) = found.reduced(&programme, &reach);
        assert_eq!(found.list[2].sequence()[0], [4500.0, 4000.0]);
        assert_eq!(nearer.list.len(), 1);
        assert_eq!(nearer.list[0].sequence()[0], [4500.0, 2000.0]);
        assert_eq!((places[2], places[1]), (Some(0), None));
    }

    #[test]
    fn what_is_there_is_a_repetition() {
        let programme = programme(["vertical", "lateral"], &CASES);
        let mut found = ProposedMeasurements::loads(&programme, &Available::default(), &[1.0]);
        found.repeats(&programme, &Available::default());
        let of = |kind: Kind| found.list.iter().filter(move |c| c.kind == kind);
        assert!(of(Kind::Load).all(|c| !CASES.contains(&[c.sequence()[0][0], c.sequence()[0][1]])));
        let names: Vec<&str> = of(Kind::Repeat).map(|c| c.what.as_str()).collect();
        assert_eq!(names.len(), 5);
        assert_eq!(names[4], "case 5 again (measured 2 times so far)");
    }

    /// Loads in degrees are rounded in degrees.
    #[test]
    fn angles_are_set_in_degrees() {
        let radians = CASES.map(|[a, b]| [a, f64::to_radians(b / 100.0)]);
        let programme = programme(["vertical", "steer_deg"], &radians);
        let usual = Available::default();
        let found = ProposedMeasurements::loads(&programme, &usual, &[BEYOND_RANGE_FACTOR]);
        assert_eq!(found.list[2].what, "steer_deg 50 (beyond)");
        let value = crate::load_values::in_the_file(&programme, 1, found.list[2].sequence()[0][1]);
        assert_eq!(value, 50.0);
    }
}
