//! Tests for structure in the residuals of a fit that noise alone would not show.
//!
//! A deficient model may still pass the chi-square test, because a small error common to all cases disappears in the noise of many readings.
//! The tests in this module examine combinations of readings in which such errors accumulate. They do not name causes; that is the task of the
//! diagnosis.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

use super::Problem;
use super::global::Row;
use super::global::gauss_newton::Minimum;
use super::tolerance::covariance_root;
use crate::settings::{
    ABSORBED_VARIANCE_SHARE, LACK_OF_FIT_LEVEL, MIN_POSE_MARKS, MIN_RUN_CASES, MIN_SCATTER_DOF,
};
use admire_solver::mechanics::Vec3;
use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_study::orientation::chi_square_p_value;

/// Kind of structure in the residuals that a lack-of-fit test detects.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LackOfFitAspect {
    /// Excessive scatter of all readings together.
    All,
    /// Excessive scatter of the readings of one case, part or channel. A single outlier is enough to fail such a test.
    Scatter,
    /// Excessive error of one reading of one mark.
    Mark,
    /// Pattern across several readings, such as a constant error or a trend.
    Pattern,
}

/// Value of a chi-square statistic with its degrees of freedom.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ChiSquare {
    /// Value of the statistic.
    pub value: f64,
    /// Degrees of freedom of the statistic.
    pub dof: usize,
}

impl ChiSquare {
    /// Returns the probability of a larger value by chance.
    pub fn p_value(self) -> f64 {
        chi_square_p_value(self.value, self.dof)
    }
}

/// Result of a lack-of-fit test of the residuals.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct LackOfFitTest {
    /// Description of the structure that the test looks for.
    pub what: String,
    /// Probability that noise alone produces at least this much structure. If the test reports the worst of several alternatives, the
    /// probability is corrected for their number.
    pub p_value: f64,
    /// Kind of structure that the test detects.
    #[serde(skip)]
    pub aspect: LackOfFitAspect,
    /// Chi-square statistic of the test; `None` if the test uses another statistic.
    #[serde(skip)]
    pub statistic: Option<ChiSquare>,
}

impl LackOfFitTest {
    /// Creates the result of a test for a pattern that uses no chi-square statistic.
    const fn of_pattern(what: String, p_value: f64) -> Self {
        Self {
            what,
            p_value,
            aspect: LackOfFitAspect::Pattern,
            statistic: None,
        }
    }
}

/// Returns true if the tests together show structure: the smallest p-value times the number of tests (Bonferroni correction) is below the
/// significance level.
pub fn is_structured(tests: &[LackOfFitTest]) -> bool {
    worst(tests).is_some_and(|worst| worst.p_value * (tests.len() as f64) < LACK_OF_FIT_LEVEL)
}

/// Returns the test with the smallest p-value; `None` for an empty list.
pub fn worst(tests: &[LackOfFitTest]) -> Option<&LackOfFitTest> {
    tests.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value))
}

/// A linear combination of residuals: pairs of row index and weight.
type Contrast = Vec<(usize, f64)>;

/// Whitened residuals of a fit. In the linear model with Gaussian priors, their covariance is `I - Q Q'` with `Q = J L`, where `J` is the
/// Jacobian and `L L'` the posterior covariance of the unknowns.
pub struct Residuals<'a> {
    rows: &'a [Row],
    r: &'a DVector<f64>,
    Q: DMatrix<f64>,
}

impl<'a> Residuals<'a> {
    /// Creates the residuals at the minimum of a fit; `covariance` is the posterior covariance of its unknowns.
    pub(crate) fn new(rows: &'a [Row], minimum: &'a Minimum, covariance: &DMatrix<f64>) -> Self {
        let evaluation = &minimum.evaluation;
        let taken = &evaluation.jacobian * covariance_root(covariance);
        let (known, free) = (taken.ncols(), evaluation.free.len());
        // Free motions remove the residual along their row directions entirely.
        let mut Q = taken.resize_horizontally(known + free, 0.0);
        for (k, direction) in evaluation.free.iter().enumerate() {
            for (row, weight) in direction {
                Q[(*row, known + k)] = *weight;
            }
        }
        Self {
            rows,
            r: &evaluation.residual,
            Q,
        }
    }

    /// Returns the chi-square of the residuals along these contrasts, and its degrees of freedom. Combinations of the contrasts that the fit
    /// has absorbed are excluded.
    fn along(&self, contrasts: &[Contrast]) -> (f64, f64) {
        let mut C = DMatrix::zeros(self.rows.len(), contrasts.len());
        for (k, contrast) in contrasts.iter().enumerate() {
            for (row, weight) in contrast {
                C[(*row, k)] += weight;
            }
        }
        let C = &orthonormal(C);
        if C.ncols() == 0 {
            return (0.0, 0.0);
        }
        let s = C.tr_mul(self.r);
        let taken = self.Q.tr_mul(C);
        let covariance = DMatrix::identity(C.ncols(), C.ncols()) - taken.tr_mul(&taken);
        let eigen = symmetric_eigen(covariance);
        let (mut chi2, mut dof) = (0.0, 0.0);
        for (direction, left) in eigen
            .eigenvectors
            .column_iter()
            .zip(eigen.eigenvalues.iter())
        {
            if *left > ABSORBED_VARIANCE_SHARE {
                chi2 += direction.dot(&s).powi(2) / left;
                dof += 1.0;
            }
        }
        (chi2, dof)
    }
}

/// Tests the residuals of a fit over the cases that it used. The tests look for constant errors of parts, for trends over the order of the
/// cases, and for runs of equal sign. They also compare loading with unloading, and pose errors of parts with the scatter of their marks.
pub fn lack_of_fit_tests(problem: &Problem<'_>, left: &Residuals<'_>) -> Vec<LackOfFitTest> {
    let mut tests = Tests {
        problem,
        left,
        out: Vec::new(),
    };
    tests.parts();
    tests.poses();
    tests.hysteresis();
    tests.out
}

struct Tests<'a> {
    problem: &'a Problem<'a>,
    left: &'a Residuals<'a>,
    out: Vec<LackOfFitTest>,
}

impl Tests<'_> {
    fn put(&mut self, what: String, (chi2, dof): (f64, f64)) {
        if let Ok(distribution) = ChiSquared::new(dof) {
            self.out.push(LackOfFitTest {
                statistic: Some(ChiSquare {
                    value: chi2,
                    dof: dof as usize,
                }),
                ..LackOfFitTest::of_pattern(what, distribution.sf(chi2))
            });
        }
    }

    /// Returns the index of the series that a row belongs to. A series is one quantity over all cases: the marks of a part along one axis, a
    /// component of the wheel reading, or a channel.
    fn sequence(&self, row: Row) -> usize {
        let measurement = self.problem.measurement;
        let parts = 3 * measurement.parts.len();
        match row {
            Row::Mark {
                case,
                reading,
                axis,
            } => 3 * measurement.cases[case].marks[reading].part + axis,
            Row::Wheel { component, .. } => parts + component,
            Row::Channel { channel, .. } => parts + 5 + channel,
        }
    }

    /// Returns the name and the range of series indices of each part, of the wheel and of each channel.
    fn owners(&self) -> Vec<(String, std::ops::Range<usize>)> {
        let measurement = self.problem.measurement;
        let mut owners = Vec::new();
        for (k, part) in measurement.parts.iter().enumerate() {
            owners.push((part.name.clone(), 3 * k..3 * k + 3));
        }
        let next = 3 * measurement.parts.len();
        if measurement.wheel.is_some() {
            owners.push(("the wheel".to_string(), next..next + 5));
        }
        for (k, channel) in measurement.channels.iter().enumerate() {
            owners.push((
                format!("channel {}", channel.name),
                next + 5 + k..next + 6 + k,
            ));
        }
        owners
    }

    /// Returns one contrast per series in the range. `by_case` holds the weight of the rows of each case.
    fn contrasts(&self, range: &std::ops::Range<usize>, by_case: &[f64]) -> Vec<Contrast> {
        let mut contrasts = vec![Contrast::new(); range.len()];
        for (at, row) in self.left.rows.iter().enumerate() {
            let sequence = self.sequence(*row);
            if range.contains(&sequence) {
                contrasts[sequence - range.start].push((at, by_case[row.case()]));
            }
        }
        contrasts
    }

    /// Tests each part, the wheel and each channel for constant errors, for trends over the order of the cases, and for runs of equal sign.
    fn parts(&mut self) {
        let cases = self.problem.measurement.cases.len();
        let constant = vec![1.0; cases];
        let order: Vec<f64> = (0..cases)
            .map(|case| case as f64 - 0.5 * (cases as f64 - 1.0))
            .collect();
        for (name, range) in self.owners() {
            let constant = self.contrasts(&range, &constant);
            self.put(
                format!("{name}: the same error in all cases"),
                self.left.along(&constant),
            );
            let order = self.contrasts(&range, &order);
            self.put(
                format!("{name}: an error that grows from case to case"),
                self.left.along(&order),
            );
            if let Some(p_value) = self.runs(&range) {
                let what = format!("{name}: signs of the errors over the order of the cases");
                self.out.push(LackOfFitTest::of_pattern(what, p_value));
            }
        }
    }

    /// Applies the Wald-Wolfowitz runs test to all series of a range together. Returns the probability that chance produces as few runs of
    /// equal sign or fewer; `None` if the series are too short.
    fn runs(&self, range: &std::ops::Range<usize>) -> Option<f64> {
        let (mut less, mut variance) = (0.0, 0.0);
        for sequence in range.clone() {
            let mut by_case = std::collections::BTreeMap::new();
            for (at, row) in self.left.rows.iter().enumerate() {
                if self.sequence(*row) == sequence {
                    *by_case.entry(row.case()).or_insert(0.0) += self.left.r[at];
                }
            }
            let signs: Vec<bool> = by_case.values().map(|sum| *sum > 0.0).collect();
            let n = signs.len() as f64;
            let up = signs.iter().filter(|sign| **sign).count() as f64;
            let pairs = 2.0 * up * (n - up);
            if signs.len() < MIN_RUN_CASES || pairs == 0.0 {
                continue;
            }
            let runs = 1 + signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
            less += pairs / n + 1.0 - runs as f64;
            variance += pairs * (pairs - n) / (n * n * (n - 1.0));
        }
        let z = less / f64::sqrt(variance);
        Normal::new(0.0, 1.0)
            .ok()
            .filter(|_| z.is_finite())
            .map(|normal| normal.sf(z))
    }

    /// Compares the pose errors of parts with the scatter of their marks by an F test, which does not depend on the stated noise. A model error
    /// moves all marks of a part together as a rigid body, whereas noise moves each mark independently.
    fn poses(&mut self) {
        let measurement = self.problem.measurement;
        let left = self.left;
        let mut blocks = std::collections::BTreeMap::<(usize, usize), Vec<(usize, Vec3)>>::new();
        for (at, row) in left.rows.iter().enumerate() {
            if let Row::Mark {
                case,
                reading,
                axis: 0,
            } = *row
            {
                let read = &measurement.cases[case].marks[reading];
                blocks
                    .entry((case, read.part))
                    .or_default()
                    .push((at, read.x));
            }
        }
        // Sum of squared residuals and its expectation for unit noise: first of the rigid motions, then in total.
        let (mut whole, mut all) = ((0.0, 0.0), (0.0, 0.0));
        for block in blocks
            .values()
            .filter(|block| block.len() >= MIN_POSE_MARKS)
        {
            let rows: Vec<usize> = block.iter().flat_map(|(at, _)| *at..at + 3).collect();
            let centre = block.iter().map(|(_, x)| x).sum::<Vec3>() / block.len() as f64;
            let size = block
                .iter()
                .map(|(_, x)| (x - centre).norm())
                .fold(0.0, f64::max);
            let rigid = orthonormal(DMatrix::from_fn(rows.len(), 6, |row, k| {
                let along = Vec3::ith(k % 3, 1.0);
                let x = block[row / 3].1 - centre;
                if k < 3 {
                    along[row % 3]
                } else {
                    along.cross(&x)[row % 3] / size
                }
            }));
            let r = left.r.select_rows(&rows);
            let Q = left.Q.select_rows(&rows);
            whole.0 += rigid.tr_mul(&r).norm_squared();
            whole.1 += rigid.ncols() as f64 - rigid.tr_mul(&Q).norm_squared();
            all.0 += r.norm_squared();
            all.1 += r.len() as f64 - Q.norm_squared();
        }
        let scatter = (all.0 - whole.0, all.1 - whole.1);
        if scatter.1 >= MIN_SCATTER_DOF
            && scatter.0 > 0.0
            && let Ok(distribution) = FisherSnedecor::new(whole.1, scatter.1)
        {
            let ratio = (whole.0 / whole.1) / (scatter.0 / scatter.1);
            self.out.push(LackOfFitTest::of_pattern(
                "pose errors of the parts against the scatter of their marks".to_string(),
                distribution.sf(ratio),
            ));
        }
    }

    /// Compares loading with unloading, for each load that both rises and falls.
    fn hysteresis(&mut self) {
        let programme = self.problem.programme;
        let last = self.owners().last().map_or(0, |(_, range)| range.end);
        for (k, load) in programme.loads.iter().enumerate() {
            let values: Vec<f64> = programme.cases.iter().map(|case| case.values[k]).collect();
            if let Some(by_case) = hysteresis_contrast(&values) {
                let contrasts = self.contrasts(&(0..last), &by_case);
                let what = format!("loading against unloading of {}", load.target);
                self.put(what, self.left.along(&contrasts));
            }
        }
    }
}

/// Returns a contrast over the cases between loading and unloading. It is +1 where the load increases in magnitude and -1 where it decreases
/// without reaching zero, orthogonalised against a parabola in the load. Returns `None` unless both occur and a contrast remains.
fn hysteresis_contrast(values: &[f64]) -> Option<Vec<f64>> {
    let before = std::iter::once(0.0).chain(values.iter().copied());
    let steps: Vec<f64> = before
        .zip(values)
        .map(|(before, now)| {
            let grows = now.abs() - before.abs();
            if *now == 0.0 || grows == 0.0 || (before * now < 0.0 && grows < 0.0) {
                0.0
            } else {
                grows.signum()
            }
        })
        .collect();
    if !steps.contains(&1.0) || !steps.contains(&-1.0) {
        return None;
    }
    let size = values
        .iter()
        .fold(0.0_f64, |size, value| size.max(value.abs()));
    let known = DMatrix::from_fn(values.len(), 3, |case, power| {
        (values[case] / size).powi(power as i32)
    });
    let known = orthonormal(known);
    let mut left = DVector::from_vec(steps);
    let before = left.norm();
    for _ in 0..2 {
        left -= &known * known.tr_mul(&left);
    }
    (left.norm() > 0.1 * before).then(|| left.as_slice().to_vec())
}

/// Returns an orthonormal basis of the space that the columns span.
fn orthonormal(columns: DMatrix<f64>) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for column in columns.column_iter() {
        let mut rest = column.into_owned();
        let size = rest.norm();
        for _ in 0..2 {
            for known in &basis {
                let along = known.dot(&rest);
                rest.axpy(-along, known, 1.0);
            }
        }
        let left = rest.norm();
        if left > 1e-6 * size && left > 0.0 {
            basis.push(rest / left);
        }
    }
    if basis.is_empty() {
        return DMatrix::zeros(columns.nrows(), 0);
    }
    DMatrix::from_columns(&basis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_that_only_grows_is_not_unloaded() {
        assert!(hysteresis_contrast(&[1.0, 2.0, 3.0, 4.0]).is_none());
        // The load returns to zero while another load starts. This does not count as unloading.
        assert!(hysteresis_contrast(&[1.0, 2.0, 3.0, 0.0, 0.0, -1.0, -2.0]).is_none());
        // The load changes sign and increases in the other direction.
        assert!(hysteresis_contrast(&[1.0, 2.0, -2.5, -3.0]).is_none());
        let loop_ =
            hysteresis_contrast(&[1.0, 2.0, 3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -3.0, -2.0, -1.0])
                .unwrap();
        assert!(loop_[0] > 0.5 && loop_[4] < -0.5, "{loop_:?}");
    }

    /// Without structure in the residuals, the statistic has the mean of a chi-square with one degree of freedom. A contrast that the fit has
    /// absorbed has no degrees of freedom.
    #[test]
    fn a_contrast_is_tested_against_what_the_fit_left() {
        let rows: Vec<Row> = (0..400)
            .map(|case| Row::Channel { case, channel: 0 })
            .collect();
        let mut noise = admire_study::noise::Noise::new(3, "structure");
        let jacobian = DMatrix::from_fn(
            400,
            2,
            |row, k| if k == 0 { 1.0 } else { row as f64 / 400.0 },
        );
        let covariance = (jacobian.tr_mul(&jacobian)).try_inverse().unwrap();
        let contrast: Contrast = (0..400)
            .map(|row| (row, (row as f64 / 9.0).sin()))
            .collect();
        let absorbed: Contrast = (0..400).map(|row| (row, 1.0)).collect();
        let (mut sum, trials) = (0.0, 300);
        for _ in 0..trials {
            let read = DVector::from_fn(400, |_, _| noise.normal());
            let r = &read - &jacobian * (&covariance * jacobian.tr_mul(&read));
            let left = Residuals {
                rows: &rows,
                r: &r,
                Q: &jacobian * covariance_root(&covariance),
            };
            let (chi2, dof) = left.along(std::slice::from_ref(&contrast));
            assert_eq!(dof, 1.0);
            sum += chi2;
            assert_eq!(left.along(std::slice::from_ref(&absorbed)).1, 0.0);
        }
        // Chi-square with one degree of freedom has mean 1; the mean of 300 trials has standard deviation sqrt(2 / 300).
        assert!((sum / f64::from(trials) - 1.0).abs() < 0.25, "{sum}");
    }
}
