//! First-order and total Sobol indices with their standard errors.

use super::random::Stream;

/// Number of bootstrap resamples of the blocks, for the standard errors.
const RESAMPLES: u64 = 200;

/// Sobol indices of one parameter: shares of a result's variance.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Index {
    /// First-order index: variance of the result's conditional mean given the parameter, divided by the total variance.
    pub first: f64,
    /// Standard error of the first-order index, from resampling of the base points.
    pub first_error: f64,
    /// Total index: mean variance of the result that remains if all other parameters are known, divided by the total variance.
    pub total: f64,
    /// Standard error of the total index, from resampling of the base points.
    pub total_error: f64,
}

/// Computes the Sobol indices of `numbers` parameters from the results of the plan `sobol-indices`. The results are in the order of the
/// cases: A, B, then A with one parameter taken from B, for each parameter.
///
/// The first-order index follows Saltelli et al. 2010 (table 2, b), the total index Jansen 1999. Blocks in which a case has no result are
/// left out. Returns the indices and the number of blocks used; `None` with fewer than two blocks, or if the result does not vary.
pub(crate) fn indices(answers: &[f64], numbers: usize) -> Option<(Vec<Index>, usize)> {
    let blocks: Vec<&[f64]> = answers
        .chunks_exact(numbers + 2)
        .filter(|block| block.iter().all(|value| value.is_finite()))
        .collect();
    let count = blocks.len();
    if count < 2 {
        return None;
    }
    // The mean is subtracted because otherwise the products lose digits.
    let mean = blocks.iter().map(|block| block[0] + block[1]).sum::<f64>() / (2 * count) as f64;
    let all: Vec<f64> = estimate(blocks.iter().copied(), numbers, mean)?;
    let draws = Stream::named(0, "resamples of the base points");
    let mut sums = vec![(0.0, 0.0); 2 * numbers];
    let mut drawn = 0.0;
    for resample in 0..RESAMPLES {
        let pick = (0..count as u64)
            .map(|k| blocks[draws.below(resample * count as u64 + k, count as u64) as usize]);
        let Some(found) = estimate(pick, numbers, mean) else {
            continue;
        };
        drawn += 1.0;
        for ((sum, squares), (value, center)) in sums.iter_mut().zip(found.iter().zip(&all)) {
            let d = value - center;
            *sum += d;
            *squares += d * d;
        }
    }
    let error = |k: usize| {
        let (sum, squares) = sums[k];
        ((squares - sum * sum / drawn) / (drawn - 1.0))
            .max(0.0)
            .sqrt()
    };
    let found = (0..numbers).map(|k| Index {
        first: all[k],
        first_error: error(k),
        total: all[numbers + k],
        total_error: error(numbers + k),
    });
    Some((found.collect(), count))
}

/// Returns the first-order indices of all parameters, followed by the total indices; `None` if the result does not vary.
fn estimate<'b>(
    blocks: impl Iterator<Item = &'b [f64]>,
    numbers: usize,
    mean: f64,
) -> Option<Vec<f64>> {
    let mut out = vec![0.0; 2 * numbers];
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for block in blocks {
        let (a, b) = (block[0] - mean, block[1] - mean);
        sum += a + b;
        squares += a * a + b * b;
        count += 1.0;
        for k in 0..numbers {
            let mixed = block[2 + k] - mean;
            out[k] += b * (mixed - a);
            out[numbers + k] += 0.5 * (a - mixed) * (a - mixed);
        }
    }
    let center = sum / (2.0 * count);
    let variance = squares / (2.0 * count) - center * center;
    // A smaller variance is round-off.
    if !(variance > 1e-24 * mean * mean) {
        return None;
    }
    for value in &mut out {
        *value /= count * variance;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::super::design::{Design, Plan, Point};
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn indices_of_the_ishigami_function_are_those_of_its_closed_form() {
        // Ishigami and Homma 1990: sin x1 + a sin^2 x2 + b x3^4 sin x1 on (-pi, pi), a = 7, b = 0.1.
        let (a, b): (f64, f64) = (7.0, 0.1);
        let f = |x: &[f64]| x[0].sin() + a * x[1].sin().powi(2) + b * x[2].powi(4) * x[0].sin();
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let v2 = a * a / 8.0;
        let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        let expected = [
            (v1 / v, (v1 + v13) / v),
            (v2 / v, v2 / v),
            (0.0, v13 / v),
            (0.0, 0.0),
        ];
        for seed in 1..=3 {
            let names = ["x1", "x2", "x3", "without effect"];
            let design = Design::new(Plan::SobolIndices, 4096, seed, &names);
            let answers: Vec<f64> = (0..design.cases())
                .map(|case| match design.point(case) {
                    Point::Unit(u) => {
                        let x: Vec<f64> = u.iter().map(|u| PI * (2.0 * u - 1.0)).collect();
                        1e6 + f(&x)
                    }
                    other => panic!("{other:?}"),
                })
                .collect();
            let (found, blocks) = indices(&answers, 4).unwrap();
            assert_eq!(blocks, 4096);
            for (index, (first, total)) in found.iter().zip(expected) {
                assert!(
                    (index.first - first).abs() < 4.0 * index.first_error + 1e-6,
                    "{index:?} {first}"
                );
                assert!(
                    (index.total - total).abs() < 4.0 * index.total_error + 1e-6,
                    "{index:?} {total}"
                );
                assert!(
                    index.first_error < 0.03 && index.total_error < 0.03,
                    "{index:?}"
                );
            }
        }
    }

    #[test]
    fn blocks_without_an_answer_are_left_out_and_constants_have_no_indices() {
        let mut answers: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        answers[5] = f64::NAN;
        assert_eq!(indices(&answers, 2).unwrap().1, 9);
        assert!(indices(&[3.0; 40], 2).is_none());
        assert!(indices(&answers[..4], 2).is_none());
    }
}
