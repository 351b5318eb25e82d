//! Tests for systematic structure in the residuals. Each test also locates the structure that it finds.

use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;
use super::residual_covariance::{ByCase, Contrast, ResidualCovariance};
use admire_identify::global::Row;
use admire_identify::settings::LACK_OF_FIT_LEVEL;
use admire_identify::{ChiSquare, LackOfFitAspect, LackOfFitTest};
use admire_solver::mechanics::Vec3;

/// Creates a lack-of-fit test from a chi-square statistic.
const fn chi_square_test(
    aspect: LackOfFitAspect,
    what: String,
    statistic: ChiSquare,
    p_value: f64,
) -> LackOfFitTest {
    LackOfFitTest {
        what,
        p_value,
        aspect,
        statistic: Some(statistic),
    }
}

/// Runs all tests of structure, and returns them in the order of increasing p-value. The tests are: chi-square over all rows; chi-square of
/// each case, part, wheel and channel; trends with each load, with the force in each element and with the order of application; loading
/// against unloading; a rigid motion of all marks in one case; a constant error of one mark; and an error of a single mark reading.
pub(super) fn lack_of_fit_tests(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
) -> Vec<LackOfFitTest> {
    let influence = ResidualCovariance::new(fitted);
    let mut tests = Tests {
        subject,
        by_case: influence.by_case(&by_case(subject)),
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

/// Returns the p-value of a test, corrected for the number of tests. The test over all readings is not corrected, because it is a single
/// overall test; the other tests are its follow-up.
fn corrected(test: &LackOfFitTest, count: usize) -> f64 {
    let asked = match test.aspect {
        LackOfFitAspect::All => 1.0,
        _ => count as f64,
    };
    (test.p_value * asked).min(1.0)
}

/// Returns true if a test is significant after correction for `count` tests.
pub(super) fn is_significant(test: &LackOfFitTest, count: usize) -> bool {
    corrected(test, count) < LACK_OF_FIT_LEVEL
}

/// Returns the smallest p-value of the tests, corrected for their number.
pub(super) fn least(tests: &[LackOfFitTest]) -> f64 {
    let values = tests.iter().map(|test| corrected(test, tests.len()));
    values.fold(1.0, f64::min)
}

/// Returns true if noise does not explain the residuals: the smallest corrected p-value is below the significance level. A correct model
/// fails the test over all readings in about one study of a thousand, and any of the other tests in about one more. A wrong model is usually
/// far below the level.
pub(super) fn is_structured(tests: &[LackOfFitTest]) -> bool {
    least(tests) < LACK_OF_FIT_LEVEL
}

/// Returns true if only isolated readings are significantly off. Such readings are single marks, or the scatter of a case, part or channel,
/// without a pattern.
pub(super) fn is_of_far_readings(tests: &[LackOfFitTest]) -> bool {
    let significant = tests
        .iter()
        .filter(|test| is_significant(test, tests.len()));
    let mut aspects = significant.map(|test| test.aspect);
    aspects
        .clone()
        .any(|aspect| matches!(aspect, LackOfFitAspect::Mark | LackOfFitAspect::Scatter))
        && aspects.all(|aspect| aspect != LackOfFitAspect::Pattern)
}

struct Tests<'a> {
    subject: &'a DiagnosisProblem<'a>,
    influence: &'a ResidualCovariance<'a>,
    /// Contrasts (sums of residual rows) of each case: one for each direction of each part, five for the wheel, and one for each channel.
    by_case: ByCase,
    out: Vec<LackOfFitTest>,
}

impl Tests<'_> {
    fn overall(&mut self, fitted: &FittedModel) {
        let value =
            fitted.posterior.chi_square * self.subject.variance_factor(0..self.subject.rows.len());
        let dof = (fitted.posterior.count - fitted.posterior.effective)
            .max(1.0)
            .round() as usize;
        let statistic = ChiSquare { value, dof };
        self.out.push(chi_square_test(
            LackOfFitAspect::All,
            "all readings".to_string(),
            statistic,
            statistic.p_value(),
        ));
    }

    /// Adds a pattern test of the contrasts summed over the cases, with one weight per case.
    fn put(&mut self, what: String, weights: &[f64]) {
        if let Some(statistic) = self.by_case.test(weights) {
            let p_value = statistic.p_value();
            let test = chi_square_test(LackOfFitAspect::Pattern, what, statistic, p_value);
            self.out.push(test);
        }
    }

    /// Tests each named set of contrasts. Adds only the most significant test, with its p-value corrected for the number of sets.
    fn worst(&mut self, aspect: LackOfFitAspect, named: Vec<(String, Vec<Contrast>)>) {
        let count = named.len() as f64;
        let tests = named.into_iter().filter_map(|(what, contrasts)| {
            let statistic = self.influence.test(&contrasts)?;
            let p_value = (statistic.p_value() * count).min(1.0);
            let per_dof = statistic.value / statistic.dof as f64;
            Some((per_dof, chi_square_test(aspect, what, statistic, p_value)))
        });
        let worst = tests.min_by(|(a_per_dof, a), (b_per_dof, b)| {
            let by_value = b_per_dof.total_cmp(a_per_dof);
            a.p_value.total_cmp(&b.p_value).then(by_value)
        });
        let worst = worst.map(|(_, test)| test);
        self.out.extend(worst);
    }

    /// Adds a scatter test of all rows for which `accept` is true.
    fn rows(&mut self, what: String, accept: impl Fn(&Row) -> bool) {
        let rows = self.subject.rows.iter().enumerate();
        let rows: Vec<usize> = rows
            .filter(|(_, row)| accept(row))
            .map(|(k, _)| k)
            .collect();
        if let Some(statistic) = self.influence.test_rows(&rows) {
            let statistic = ChiSquare {
                value: statistic.value * self.subject.variance_factor(rows),
                ..statistic
            };
            let p_value = statistic.p_value();
            let test = chi_square_test(LackOfFitAspect::Scatter, what, statistic, p_value);
            self.out.push(test);
        }
    }

    fn groups(&mut self) {
        let measurement = self.subject.problem.measurement;
        for (k, case) in measurement.cases.iter().enumerate() {
            self.rows(format!("case {}", case.label), |row| row.case() == k);
        }
        for (k, part) in measurement.parts.iter().enumerate() {
            self.rows(format!("marks of {}", part.name), |row| {
                matches!(*row, Row::Mark { case, reading, .. }
                    if measurement.cases[case].marks[reading].part == k)
            });
        }
        self.rows("the wheel against the marks".to_string(), |row| {
            matches!(row, Row::Wheel { .. })
        });
        for (k, channel) in measurement.channels.iter().enumerate() {
            self.rows(
                format!("channel {}", channel.name),
                |row| matches!(*row, Row::Channel { channel: of, .. } if of == k),
            );
        }
    }

    fn trend(&mut self, what: String, by_case: &[f64]) {
        let mean = by_case.iter().sum::<f64>() / by_case.len().max(1) as f64;
        let centred: Vec<f64> = by_case.iter().map(|v| v - mean).collect();
        let size = centred.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if size <= 1e-9 * mean.abs() || size == 0.0 {
            return;
        }
        self.put(what, &centred);
    }

    fn trends(&mut self, fitted: &FittedModel) {
        let programme = self.subject.problem.programme;
        for (k, load) in programme.loads.iter().enumerate() {
            let values: Vec<f64> = programme.cases.iter().map(|c| c.values[k]).collect();
            self.trend(format!("trend with {}", load.target), &values);
            if let Some(ways) = both_ways(&values) {
                self.put(
                    format!("loading against unloading of {}", load.target),
                    &ways,
                );
            }
        }
        for (name, force) in OperatingPoints::new(self.subject, fitted).forces() {
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
        self.worst(LackOfFitAspect::Pattern, motions);
        let constants = constants.into_iter().map(|((part, mark), columns)| {
            let part = &measurement.parts[part];
            let what = format!("mark {} {} in all cases", part.name, part.marks[mark].label);
            (what, columns)
        });
        self.worst(LackOfFitAspect::Pattern, constants.collect());
        self.worst(LackOfFitAspect::Mark, single);
    }
}

/// Returns the contrasts (sums of residual rows) of each case: one for each direction of each part, five for the wheel, and one for each
/// channel.
fn by_case(subject: &DiagnosisProblem<'_>) -> Vec<Vec<Contrast>> {
    let measurement = subject.problem.measurement;
    let parts = measurement.parts.len();
    let count = 3 * parts + 5 + measurement.channels.len();
    let mut out = vec![vec![Contrast::new(); count]; measurement.cases.len()];
    for (at, row) in subject.rows.iter().enumerate() {
        let column = match *row {
            Row::Mark {
                case,
                reading,
                axis,
            } => 3 * measurement.cases[case].marks[reading].part + axis,
            Row::Wheel { component, .. } => 3 * parts + component,
            Row::Channel { channel, .. } => 3 * parts + 5 + channel,
        };
        out[row.case()][column].push((at, 1.0));
    }
    out
}

/// Returns one value per case: 1 if the case was reached by increasing the load, and -1 if it was reached by decreasing the load. Cases
/// outside the load range that is covered in both directions get zero. Returns `None` if no part of the range is covered in both directions.
fn both_ways(values: &[f64]) -> Option<Vec<f64>> {
    let way = |k: usize| match k.checked_sub(1).map(|before| values[k] - values[before]) {
        Some(step) if step > 0.0 => 1.0,
        Some(step) if step < 0.0 => -1.0,
        _ => 0.0,
    };
    let range = |sign: f64| {
        let of = (0..values.len())
            .filter(|k| way(*k) == sign)
            .map(|k| values[k]);
        of.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (up, down) = (range(1.0), range(-1.0));
    let (low, high) = (up.0.max(down.0), up.1.min(down.1));
    let ways: Vec<f64> = (0..values.len())
        .map(|k| {
            let met = (low..=high).contains(&values[k]);
            if met { way(k) } else { 0.0 }
        })
        .collect();
    (ways.contains(&1.0) && ways.contains(&-1.0)).then_some(ways)
}

#[cfg(test)]
mod tests {
    use super::{both_ways, chi_square_test, is_structured};
    use admire_identify::{ChiSquare, LackOfFitAspect, LackOfFitTest};
    use admire_study::noise::Noise;

    #[test]
    fn a_load_that_only_goes_one_way_has_no_way_back() {
        assert_eq!(both_ways(&[5.0, 4.0, 3.0, 1.0]), None);
        assert_eq!(both_ways(&[1.0, 2.0, 2.0, 8.0]), None);
        // The load falls to values that it never had while it increased.
        assert_eq!(both_ways(&[0.0, 5.0, 6.0, -1.0, -2.0]), None);
    }

    #[test]
    fn only_loads_met_both_ways_are_compared() {
        let ways = both_ways(&[0.0, 1.0, 2.0, 3.0, 2.0, 1.0]).unwrap();
        assert_eq!(ways, [0.0, 1.0, 1.0, 0.0, -1.0, -1.0]);
    }

    /// Under noise alone, about one study of a thousand fails the test over all readings, and about one more fails the most significant
    /// single test.
    #[test]
    fn noise_has_structure_in_two_of_a_thousand_studies() {
        let mut noise = Noise::new(5, "structure");
        let studies = 20_000;
        let structured = (0..studies)
            .filter(|_| {
                let squares: Vec<f64> = (0..50).map(|_| noise.normal().powi(2)).collect();
                let test = |aspect, value, dof| {
                    let statistic = ChiSquare { value, dof };
                    chi_square_test(aspect, String::new(), statistic, statistic.p_value())
                };
                let mut tests: Vec<LackOfFitTest> = squares
                    .iter()
                    .map(|s| test(LackOfFitAspect::Mark, *s, 1))
                    .collect();
                tests.push(test(
                    LackOfFitAspect::All,
                    squares.iter().sum(),
                    squares.len(),
                ));
                is_structured(&tests)
            })
            .count();
        // The two tests share readings: at most 40 failures are expected, with a standard deviation of 6.
        assert!((20..=55).contains(&structured), "{structured}");
    }
}
