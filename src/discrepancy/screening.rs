//! Score tests: what each hypothesis would gain, from the sensitivities at hand and without any refit.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::background::Background;
use super::columns::{ColumnOf, Columns};
use super::extended::Fitted;
use super::hypothesis::{self, Hypothesis};
use super::subject::Subject;
use super::survey::Survey;

/// What a hypothesis promises at a fit.
#[derive(Clone, Debug)]
pub struct Score {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// First guess of the numbers, in units of their priors.
    pub estimate: Vec<f64>,
    /// How the unknowns of the fit would move with it.
    pub step: Vec<f64>,
    /// Fall of chi-square, priors included, less the penalty of the numbers that the data determine.
    pub net: f64,
}

/// Penalty of a hypothesis with so many numbers, chosen among `places`, from `rows` readings: the Schwarz criterion, and two
/// log-likelihoods for each doubling of the places tried.
pub fn penalty(numbers: f64, rows: f64, places: usize) -> f64 {
    numbers * rows.max(2.0).ln() + 2.0 * (places.max(1) as f64).ln()
}

/// Scores every hypothesis that is not in the fit already; best first.
pub fn screen(subject: &Subject<'_>, fitted: &Fitted) -> Vec<Score> {
    let survey = Survey::new(subject, fitted);
    let mut hypotheses = hypothesis::all(&survey);
    hypotheses.retain(|h| !fitted.chosen.iter().any(|chosen| chosen.same(h)));
    let places = hypotheses.len();
    let columns = survey.columns(&hypotheses);
    score(fitted, hypotheses, columns, places)
}

/// What each of these promises at a fit, as one of as many as there are of them; in their order.
pub fn promises(
    fitted: &Fitted,
    survey: &Survey<'_>,
    hypotheses: &[Hypothesis],
) -> Vec<Option<Score>> {
    let of = |hypothesis: &Hypothesis| {
        let one = vec![hypothesis.clone()];
        let columns = survey.columns(&one);
        score(fitted, one, columns, hypotheses.len()).pop()
    };
    hypotheses.iter().map(of).collect()
}

/// A hypothesis' own columns against the fit: what of them the fit's unknowns cannot do.
struct Against<'a> {
    /// Jacobian of the fit, rows that it has not seen zero.
    own: &'a DMatrix<f64>,
    residual: &'a DVector<f64>,
    covariance: &'a DMatrix<f64>,
    columns: &'a Columns,
    /// `own^T solved`.
    cross: &'a DMatrix<f64>,
    /// All of these whitened once more, for columns of a few rows that are not whitened yet.
    twice: Option<(&'a Background, DMatrix<f64>, DVector<f64>, DMatrix<f64>)>,
}

impl Against<'_> {
    /// `own^T X`, `X^T X` and `X^T r` of these numbers.
    fn products(
        &self,
        numbers: std::ops::Range<usize>,
    ) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let (n, k) = (self.own.ncols(), numbers.len());
        let mut cross = DMatrix::zeros(n, k);
        let mut square = DMatrix::zeros(k, k);
        let mut with_residual = DVector::zeros(k);
        let of = &self.columns.of[numbers];
        for (c, column) in of.iter().enumerate() {
            match column {
                ColumnOf::Solved(at) => {
                    cross.set_column(c, &self.cross.column(*at));
                    with_residual[c] = self.columns.solved.column(*at).dot(self.residual);
                }
                ColumnOf::Rows(rows) => {
                    let (own, residual) = match &self.twice {
                        Some((_, own, residual, _)) => (own, residual),
                        None => (self.own, self.residual),
                    };
                    for (row, value) in rows {
                        with_residual[c] += value * residual[*row];
                        for (sum, own) in cross.column_mut(c).iter_mut().zip(own.row(*row).iter()) {
                            *sum += value * own;
                        }
                    }
                }
            }
            for (d, other) in of.iter().enumerate().take(c + 1) {
                let sum = self.dot(column, other);
                (square[(c, d)], square[(d, c)]) = (sum, sum);
            }
        }
        (cross, square, with_residual)
    }

    fn dot(&self, a: &ColumnOf, b: &ColumnOf) -> f64 {
        let solved = &self.columns.solved;
        let twice = self.twice.as_ref();
        match (a, b) {
            (ColumnOf::Solved(a), ColumnOf::Solved(b)) => solved.column(*a).dot(&solved.column(*b)),
            (ColumnOf::Solved(a), ColumnOf::Rows(rows))
            | (ColumnOf::Rows(rows), ColumnOf::Solved(a)) => {
                let solved = twice.map_or(solved, |(.., solved)| solved);
                rows.iter().map(|(row, v)| v * solved[(*row, *a)]).sum()
            }
            (ColumnOf::Rows(a), ColumnOf::Rows(b)) => {
                let of = |row: &usize| {
                    let same = b.iter().filter(|(other, _)| other == row);
                    same.map(|(_, v)| v).sum::<f64>()
                };
                let plain: f64 = a.iter().map(|(row, v)| v * of(row)).sum();
                plain - twice.map_or(0.0, |(background, ..)| background.dot(a, b))
            }
        }
    }
}

fn score(
    fitted: &Fitted,
    hypotheses: Vec<Hypothesis>,
    mut columns: Columns,
    places: usize,
) -> Vec<Score> {
    let seen = |row: usize| fitted.weights[row] > 0.0;
    let mut own = fitted.minimum.evaluation.jacobian.clone();
    let mut residual = fitted.minimum.evaluation.residual.clone();
    for row in (0..residual.len()).filter(|row| !seen(*row)) {
        own.row_mut(row).fill(0.0);
        columns.solved.row_mut(row).fill(0.0);
        residual[row] = 0.0;
    }
    for column in &mut columns.of {
        if let ColumnOf::Rows(rows) = column {
            rows.retain(|(row, _)| seen(*row));
        }
    }
    let covariance = fitted.covariance();
    // The fit may have stopped a little short of its minimum; what is left of the gradient is projected out too.
    let mut gradient = own.tr_mul(&residual);
    for (k, prior) in fitted.priors.iter().enumerate() {
        if prior.sd.is_finite() && prior.sd > 0.0 {
            gradient[k] += (fitted.minimum.x[k] - prior.mean) / (prior.sd * prior.sd);
        }
    }
    let rest = -(&covariance * &gradient);
    let count: f64 = fitted.weights.iter().sum();
    let twice = fitted.background.as_deref().map(|background| {
        let (mut own, mut residual) = (own.clone(), residual.clone());
        let mut solved = columns.solved.clone();
        background.whiten_columns(&mut own);
        background.whiten_columns(&mut solved);
        background.whiten(&mut residual);
        (background, own, residual, solved)
    });
    let against = Against {
        twice,
        cross: &own.tr_mul(&columns.solved),
        own: &own,
        residual: &residual,
        covariance: &covariance,
        columns: &columns,
    };
    let mut first = 0;
    let with_numbers: Vec<_> = hypotheses
        .into_iter()
        .map(|hypothesis| {
            let numbers = first..first + hypothesis.numbers.len();
            first = numbers.end;
            (hypothesis, numbers)
        })
        .collect();
    let of = |(hypothesis, numbers): (Hypothesis, std::ops::Range<usize>)| {
        let k = numbers.len();
        let (cross, square, with_residual) = against.products(numbers);
        let projected = against.covariance * &cross;
        let information = square - cross.tr_mul(&projected);
        let factor = nalgebra::Cholesky::new(information + DMatrix::identity(k, k))?;
        let inverse = factor.inverse();
        let s = projected.tr_mul(&gradient) - with_residual;
        let estimate = &inverse * &s;
        let gain = s.dot(&estimate);
        if !gain.is_finite() || (hypothesis.one_sided && estimate[0] <= 0.0) {
            return None;
        }
        let numbers = (k as f64 - inverse.trace()).max(0.0);
        // A number the data do not determine at all cannot explain anything either.
        if numbers < 1e-3 {
            return None;
        }
        Some(Score {
            net: gain - penalty(numbers, count, places),
            hypothesis,
            step: (&rest - projected * &estimate).iter().copied().collect(),
            estimate: estimate.iter().copied().collect(),
        })
    };
    let mut out: Vec<Score> = with_numbers.into_par_iter().filter_map(of).collect();
    out.sort_by(|a, b| b.net.total_cmp(&a.net));
    out
}
