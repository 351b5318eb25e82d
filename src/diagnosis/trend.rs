//! Residual that depends most strongly on the force in an element, for a plot in the report.

use super::diagnose::Outcome;
use super::operating_points::OperatingPoints;
use admire_identify::global::Row;

/// Residual of a group of readings as a function of the force in one element.
#[derive(Clone, PartialEq, Debug)]
pub struct Trend {
    /// Name of the element.
    pub element: String,
    /// Name of the residual: the marks of a part in one direction, or a channel.
    pub what: String,
    /// Unit of the residual, if it has one.
    pub unit: Option<String>,
    /// Points of the original model, one per case: force, and mean residual (prediction minus reading). Residuals are in
    /// the unit `unit`, forces in the unit of the deck.
    pub before: Vec<(f64, f64)>,
    /// Points of the extended model, one per case: the same force as in `before`, and the extended model's mean residual.
    pub after: Vec<(f64, f64)>,
}

/// Group of residual rows whose mean is computed for each case.
struct Group {
    what: String,
    unit: Option<String>,
    scale: f64,
    rows: Vec<Vec<usize>>,
}

impl Outcome<'_> {
    /// Returns the strongest trend of a residual with the force in an element. Returns `None` if no force varies.
    pub fn trend(&self) -> Option<Trend> {
        let subject = &self.subject;
        let forces = OperatingPoints::new(subject, &self.baseline).forces();
        let groups = self.groups();
        let means = |fit: &super::fit::FittedModel, group: &Group| -> Vec<Option<f64>> {
            let residual = &fit.residual;
            group
                .rows
                .iter()
                .map(|rows| {
                    let sum: f64 = rows.iter().map(|k| residual[*k]).sum();
                    (!rows.is_empty()).then(|| sum / rows.len() as f64 * group.scale)
                })
                .collect()
        };
        let mut best: Option<(f64, usize, usize)> = None;
        for (g, group) in groups.iter().enumerate() {
            let values = means(&self.baseline, group);
            for (f, (_, force)) in forces.iter().enumerate() {
                let pairs: Vec<(f64, f64)> = force
                    .iter()
                    .zip(&values)
                    .filter_map(|(x, y)| Some((*x, (*y)?)))
                    .collect();
                // Strength of the trend in units of the noise.
                let strength = slope_strength(&pairs) / group.scale;
                if strength.is_finite() && best.is_none_or(|(old, ..)| strength > old) {
                    best = Some((strength, g, f));
                }
            }
        }
        let (_, g, f) = best?;
        let points = |fit| {
            let values = means(fit, &groups[g]);
            forces[f]
                .1
                .iter()
                .zip(values)
                .filter_map(|(x, y)| Some((*x, y?)))
                .collect()
        };
        Some(Trend {
            element: forces[f].0.clone(),
            what: groups[g].what.clone(),
            unit: groups[g].unit.clone(),
            before: points(&self.baseline),
            after: points(&self.extended),
        })
    }

    fn groups(&self) -> Vec<Group> {
        let measurement = self.subject.problem.measurement;
        let cases = measurement.cases.len();
        let group = |what: String, unit, scale: f64, accept: &dyn Fn(&Row) -> bool| {
            let mut rows = vec![Vec::new(); cases];
            for (k, row) in self.subject.rows.iter().enumerate() {
                if accept(row) {
                    rows[row.case()].push(k);
                }
            }
            Group {
                what,
                unit,
                scale,
                rows,
            }
        };
        let mut out = Vec::new();
        for (k, part) in measurement.parts.iter().enumerate() {
            for (axis, word) in ["x", "y", "z"].into_iter().enumerate() {
                out.push(group(
                    format!("{} along {word}", part.name),
                    Some(self.subject.problem.model.units.length.word.to_string()),
                    self.subject.sigma,
                    &|row| {
                        matches!(*row, Row::Mark { case, reading, axis: of }
                            if of == axis && measurement.cases[case].marks[reading].part == k)
                    },
                ));
            }
        }
        for (k, channel) in measurement.channels.iter().enumerate() {
            out.push(group(
                channel.name.clone(),
                channel.unit.clone(),
                channel.sigma,
                &|row| matches!(*row, Row::Channel { channel: of, .. } if of == k),
            ));
        }
        out
    }
}

/// Returns the strength of a trend: the square root of the sum of squares that a straight line explains.
fn slope_strength(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (mx, my) = pairs
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in pairs {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
    }
    xy.abs() / xx.sqrt()
}
