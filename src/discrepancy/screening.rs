//! Score tests: what each hypothesis would gain, from the sensitivities at hand and without any refit.

use nalgebra::{DMatrix, DVector};

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
    score(fitted, hypotheses, &columns, places)
}

fn score(
    fitted: &Fitted,
    hypotheses: Vec<Hypothesis>,
    columns: &DMatrix<f64>,
    places: usize,
) -> Vec<Score> {
    let rows: Vec<usize> = (0..fitted.weights.len())
        .filter(|k| fitted.weights[*k] > 0.0)
        .collect();
    let own = fitted.minimum.evaluation.jacobian.select_rows(&rows);
    let residual = DVector::from_iterator(
        rows.len(),
        rows.iter().map(|k| fitted.minimum.evaluation.residual[*k]),
    );
    let columns = columns.select_rows(&rows);
    let covariance = fitted.covariance();
    let cross = own.tr_mul(&columns);
    let projected = &covariance * &cross;
    // The fit may have stopped a little short of its minimum; what is left of the gradient is projected out too.
    let mut gradient = own.tr_mul(&residual);
    for (k, prior) in fitted.priors.iter().enumerate() {
        if prior.sd.is_finite() && prior.sd > 0.0 {
            gradient[k] += (fitted.minimum.x[k] - prior.mean) / (prior.sd * prior.sd);
        }
    }
    let scores = columns.tr_mul(&residual) - projected.tr_mul(&gradient);
    let count = rows.len() as f64;
    let mut first = 0;
    let mut out = Vec::with_capacity(hypotheses.len());
    for hypothesis in hypotheses {
        let k = hypothesis.numbers.len();
        let span = (first, k);
        first += k;
        let own = columns.columns(span.0, k);
        let information = own.tr_mul(&own)
            - cross
                .columns(span.0, k)
                .tr_mul(&projected.columns(span.0, k));
        let Some(inverse) =
            nalgebra::Cholesky::new(information + DMatrix::identity(k, k)).map(|c| c.inverse())
        else {
            continue;
        };
        let s = -scores.rows(span.0, k);
        let estimate = &inverse * &s;
        let gain = s.dot(&estimate);
        if !gain.is_finite() || (hypothesis.one_sided && estimate[0] <= 0.0) {
            continue;
        }
        let numbers = (k as f64 - inverse.trace()).max(0.0);
        // A number the data do not determine at all cannot explain anything either.
        if numbers < 1e-3 {
            continue;
        }
        out.push(Score {
            net: gain - penalty(numbers, count, places),
            hypothesis,
            estimate: estimate.iter().copied().collect(),
        });
    }
    out.sort_by(|a, b| b.net.total_cmp(&a.net));
    out
}
