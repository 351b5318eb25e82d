//! Whether residuals still have structure, and where.

use super::extended::Fitted;
use super::influence::{Contrast, Influence};
use super::subject::Subject;
use super::survey::Survey;
use crate::identify::global::Row;
use crate::mechanics::Vec3;
use crate::rig::orientation::chi_square_p_value;

/// One test of structure.
#[derive(Clone, PartialEq, Debug)]
pub struct StructureTest {
    /// What it looks at, as a person would say it.
    pub what: String,
    /// Chi-square.
    pub value: f64,
    /// Its degrees of freedom.
    pub dof: usize,
    /// Its p-value; for the worst of many, corrected for their number.
    pub p_value: f64,
}

/// Tests of structure, smallest p first: chi-square over all rows, of every case, part, direction and channel; trends with each load,
/// with the force in each element and with the order of application; loading against unloading; a rigid motion of all marks in one
/// case; a constant or a single error of one mark.
pub fn structure(subject: &Subject<'_>, fitted: &Fitted) -> Vec<StructureTest> {
    let influence = Influence::new(fitted);
    let mut tests = Tests {
        subject,
        influence: &influence,
        out: Vec::new(),
    };
    tests.overall(fitted);
    tests.groups();
    tests.trends(fitted);
    tests.marks();
    let mut out = tests.out;
    out.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    out
}

struct Tests<'a> {
    subject: &'a Subject<'a>,
    influence: &'a Influence<'a>,
    out: Vec<StructureTest>,
}

impl Tests<'_> {
    fn overall(&mut self, fitted: &Fitted) {
        let value: f64 = (0..self.subject.rows.len())
            .filter(|k| self.influence.sees(*k))
            .map(|k| fitted.minimum.evaluation.residual[k].powi(2))
            .sum();
        let dof = fitted.dof(&fitted.covariance()).round() as usize;
        self.out.push(StructureTest {
            what: "all readings".to_string(),
            value,
            dof,
            p_value: chi_square_p_value(value, dof),
        });
    }

    fn put(&mut self, what: String, contrasts: &[Contrast]) {
        if let Some(statistic) = self.influence.test(contrasts) {
            self.out.push(StructureTest {
                what,
                value: statistic.value,
                dof: statistic.dof,
                p_value: statistic.p_value(),
            });
        }
    }

    /// The worst of several, its p-value corrected for their number.
    fn worst(&mut self, named: Vec<(String, Vec<Contrast>)>) {
        let count = named.len() as f64;
        let tests = named.into_iter().filter_map(|(what, contrasts)| {
            let statistic = self.influence.test(&contrasts)?;
            Some(StructureTest {
                what,
                value: statistic.value,
                dof: statistic.dof,
                p_value: (statistic.p_value() * count).min(1.0),
            })
        });
        let worst = tests.min_by(|a, b| {
            let by_value = (b.value / b.dof as f64).total_cmp(&(a.value / a.dof as f64));
            a.p_value.total_cmp(&b.p_value).then(by_value)
        });
        self.out.extend(worst);
    }

    /// Each row for itself.
    fn rows(&self, accept: impl Fn(&Row) -> bool) -> Vec<Contrast> {
        let rows = self.subject.rows.iter().enumerate();
        rows.filter(|(_, row)| accept(row))
            .map(|(k, _)| vec![(k, 1.0)])
            .collect()
    }

    fn groups(&mut self) {
        let measurement = self.subject.problem.measurement;
        for (k, case) in measurement.cases.iter().enumerate() {
            let rows = self.rows(|row| row.case() == k);
            self.put(format!("case {}", case.label), &rows);
        }
        for (k, part) in measurement.parts.iter().enumerate() {
            let rows = self.rows(|row| {
                matches!(*row, Row::Mark { case, reading, .. }
                    if measurement.cases[case].marks[reading].part == k)
            });
            self.put(format!("marks of {}", part.name), &rows);
        }
        for (axis, word) in ["x", "y", "z"].into_iter().enumerate() {
            let rows = self.rows(|row| matches!(*row, Row::Mark { axis: of, .. } if of == axis));
            self.put(format!("marks along {word}"), &rows);
        }
        let rows = self.rows(|row| matches!(row, Row::Wheel { .. }));
        self.put("the wheel against the marks".to_string(), &rows);
        for (k, channel) in measurement.channels.iter().enumerate() {
            let rows = self.rows(|row| matches!(*row, Row::Channel { channel: of, .. } if of == k));
            self.put(format!("channel {}", channel.name), &rows);
        }
    }

    /// One column for each direction of each part, for the wheel and for each channel, weighted by a number of each case.
    fn weighted(&self, by_case: &[f64]) -> Vec<Contrast> {
        let measurement = self.subject.problem.measurement;
        let parts = measurement.parts.len();
        let mut columns = vec![Contrast::new(); 3 * parts + 5 + measurement.channels.len()];
        for (at, row) in self.subject.rows.iter().enumerate() {
            let column = match *row {
                Row::Mark {
                    case,
                    reading,
                    axis,
                } => 3 * measurement.cases[case].marks[reading].part + axis,
                Row::Wheel { component, .. } => 3 * parts + component,
                Row::Channel { channel, .. } => 3 * parts + 5 + channel,
            };
            columns[column].push((at, by_case[row.case()]));
        }
        columns.retain(|column| column.iter().any(|(_, weight)| *weight != 0.0));
        columns
    }

    fn trend(&mut self, what: String, by_case: &[f64]) {
        let mean = by_case.iter().sum::<f64>() / by_case.len().max(1) as f64;
        let centred: Vec<f64> = by_case.iter().map(|v| v - mean).collect();
        let size = centred.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if size <= 1e-9 * mean.abs() || size == 0.0 {
            return;
        }
        let columns = self.weighted(&centred);
        self.put(what, &columns);
    }

    fn trends(&mut self, fitted: &Fitted) {
        let programme = self.subject.problem.programme;
        for (k, load) in programme.loads.iter().enumerate() {
            let values: Vec<f64> = programme.cases.iter().map(|c| c.values[k]).collect();
            self.trend(format!("trend with {}", load.target), &values);
            // Where a load has only gone one way, loading and unloading are the same test as the trend.
            let steps: Vec<f64> = std::iter::once(values[0].signum())
                .chain(values.windows(2).map(|w| match w[1] - w[0] {
                    0.0 => 0.0,
                    change => change.signum(),
                }))
                .collect();
            if steps.contains(&1.0) && steps.contains(&-1.0) {
                let columns = self.weighted(&steps);
                self.put(
                    format!("loading against unloading of {}", load.target),
                    &columns,
                );
            }
        }
        for (name, force) in Survey::new(self.subject, fitted).forces() {
            self.trend(format!("trend with the force in {name}"), &force);
        }
        let order: Vec<f64> = (0..programme.cases.len()).map(|k| k as f64).collect();
        self.trend("trend with the order of the cases".to_string(), &order);
    }

    fn marks(&mut self) {
        let measurement = self.subject.problem.measurement;
        let rows = &self.subject.rows;
        let mut motions: Vec<(String, Vec<Contrast>)> = measurement
            .cases
            .iter()
            .map(|case| {
                let what = format!("all marks moved together in case {}", case.label);
                (what, vec![Contrast::new(); 6])
            })
            .collect();
        let mut constants: std::collections::BTreeMap<(usize, usize), Vec<Contrast>> =
            std::collections::BTreeMap::new();
        let mut single: Vec<(String, Vec<Contrast>)> = Vec::new();
        for (at, row) in rows.iter().enumerate() {
            let Row::Mark {
                case,
                reading,
                axis,
            } = *row
            else {
                continue;
            };
            let read = measurement.cases[case].marks[reading];
            let of_mark = constants
                .entry((read.part, read.mark))
                .or_insert_with(|| vec![Contrast::new(); 3]);
            of_mark[axis].push((at, 1.0));
            let motion = &mut motions[case].1;
            motion[axis].push((at, 1.0));
            for k in 0..3 {
                let lever = Vec3::ith(k, 1.0).cross(&read.x)[axis];
                motion[3 + k].push((at, lever));
            }
            if axis == 0 {
                let part = &measurement.parts[read.part];
                let what = format!(
                    "mark {} {} in case {}",
                    part.name, part.marks[read.mark].label, measurement.cases[case].label
                );
                let columns = (0..3).map(|k| vec![(at + k, 1.0)]).collect();
                single.push((what, columns));
            }
        }
        motions.retain(|(_, columns)| !columns[0].is_empty());
        self.worst(motions);
        let constants = constants.into_iter().map(|((part, mark), columns)| {
            let part = &measurement.parts[part];
            let what = format!("mark {} {} in all cases", part.name, part.marks[mark].label);
            (what, columns)
        });
        self.worst(constants.collect());
        self.worst(single);
    }
}
