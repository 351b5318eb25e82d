//! Whether residuals still have structure, and where.

use super::extended::Fitted;
use super::subject::Subject;
use crate::identify::global::Row;
use crate::rig::orientation::chi_square_p_value;

/// One test of structure.
#[derive(Clone, PartialEq, Debug)]
pub struct StructureTest {
    /// What it looks at, as a person would say it.
    pub what: String,
    /// Its p-value.
    pub p_value: f64,
}

/// Chi-square over all rows, of every case, part and direction; and the mean of each mark over all cases. Smallest p first.
pub fn structure(subject: &Subject<'_>, fitted: &Fitted) -> Vec<StructureTest> {
    let measurement = subject.problem.measurement;
    let residual = &fitted.minimum.evaluation.residual;
    let weights = &fitted.weights;
    let rows: f64 = weights.iter().sum();
    let dof = fitted.dof(&fitted.covariance());
    // Unknowns have taken their share of the noise from all rows alike.
    let share = dof / rows.max(1.0);
    let mut out = Vec::new();
    let mut test = |what: String, accept: &dyn Fn(&Row) -> bool| {
        let chosen: Vec<f64> = (0..subject.rows.len())
            .filter(|k| weights[*k] > 0.0 && accept(&subject.rows[*k]))
            .map(|k| residual[k] * residual[k])
            .collect();
        let dof = (chosen.len() as f64 * share).round() as usize;
        if dof > 0 {
            let p_value = chi_square_p_value(chosen.iter().sum(), dof);
            out.push(StructureTest { what, p_value });
        }
    };
    test("all readings".to_string(), &|_| true);
    for (k, case) in measurement.cases.iter().enumerate() {
        test(format!("case {}", case.label), &|row| row.case() == k);
    }
    for (k, part) in measurement.parts.iter().enumerate() {
        test(format!("marks of {}", part.name), &|row| {
            matches!(*row, Row::Mark { case, reading, .. }
                if measurement.cases[case].marks[reading].part == k)
        });
    }
    for (axis, word) in ["x", "y", "z"].into_iter().enumerate() {
        test(
            format!("marks along {word}"),
            &|row| matches!(*row, Row::Mark { axis: of, .. } if of == axis),
        );
    }
    test("the wheel".to_string(), &|row| {
        matches!(row, Row::Wheel { .. })
    });
    for (k, channel) in measurement.channels.iter().enumerate() {
        test(
            format!("channel {}", channel.name),
            &|row| matches!(*row, Row::Channel { channel: of, .. } if of == k),
        );
    }
    out.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    out
}
