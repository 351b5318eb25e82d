//! Evidence of a linear model with Gaussian priors whose sizes are unknown.
//!
//! Rows are independent, of a few classes of equal variance, so that Gram matrices by class hold all that is needed: other sizes cost
//! additions and one factorisation. With `S` the prior standard deviations, `z` the residual where the model was linearised and `x0`
//! the unknowns there, `M = I + S H S`, `b = S A'W z - x0/S` and
//! `ln Z = -(z'W z + |x0/S|^2 - b'M^-1 b)/2 - ln det M / 2 - sum ln var / 2 + sum ln p(sizes)`, constants left out.
//! Source: MacKay, Neural Computation 4 (1992) 415.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::columns::RowsByVarianceClass;
use super::factor::Factor;
use super::further::CrossProducts;
use super::group::{EffectGroup, VarianceComponents};
use super::reached::Solution;
use super::share::ClassGram;
use super::whitening::Whitening;

/// Prior of one unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Coefficient {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of its own: of the whole if it is in no group, else of what it has beyond its group.
    pub sd: f64,
    /// Its group of tolerances.
    pub group: Option<EffectGroup>,
}

impl Coefficient {
    /// A member of a group.
    pub const fn member(group: EffectGroup) -> Self {
        Self {
            mean: 0.0,
            sd: 0.0,
            group: Some(group),
        }
    }

    /// Prior standard deviation at these sizes.
    pub fn prior_sd(&self, sizes: &VarianceComponents) -> f64 {
        let tau = self.group.and_then(|group| sizes.of(group)).unwrap_or(0.0);
        libm::hypot(tau, self.sd)
    }
}

/// A model linearised at a point.
#[derive(Clone, Debug)]
pub struct LinearModel {
    shares: Vec<ClassGram>,
    /// One per column.
    pub unknowns: Vec<Coefficient>,
    /// Where it was linearised.
    pub at: DVector<f64>,
}

/// What the readings say of the unknowns at some sizes.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Logarithm of the evidence times the prior of the sizes.
    pub ln_z: f64,
    /// Step from where the model was linearised to the maximum.
    pub step: DVector<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// Squares of whitened residuals at the maximum, priors left out.
    pub chi_square: f64,
    /// How many unknowns the readings determine.
    pub effective: f64,
    /// Rows.
    pub count: f64,
    /// What the step gains, in nats.
    pub gain: f64,
    /// Sizes it belongs to.
    pub ln: Vec<f64>,
}

impl Posterior {
    /// Chi-square per degree of freedom.
    pub fn chi_square_per_dof(&self) -> f64 {
        self.chi_square / (self.count - self.effective).max(1.0)
    }

    /// Variances of the unknowns in `kept` as they would be if all others were known exactly; the share of tolerances in a variance is
    /// what this falls short of it.
    pub fn without(&self, kept: &[usize]) -> Vec<f64> {
        // With the others at their values the precision is the block of the inverse covariance.
        let Some(all) = Cholesky::new(self.covariance.clone()) else {
            return kept.iter().map(|k| self.covariance[(*k, *k)]).collect();
        };
        let precision = all.inverse();
        let block = precision.select_rows(kept).select_columns(kept);
        match Cholesky::new(block) {
            Some(block) => block.inverse().diagonal().iter().copied().collect(),
            None => kept.iter().map(|k| self.covariance[(*k, *k)]).collect(),
        }
    }
}

impl LinearModel {
    /// `jacobian` and `residual` (reading minus prediction) are those of turned rows, see [`Whitening::apply`].
    pub fn new(
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        residual: &DVector<f64>,
        unknowns: Vec<Coefficient>,
        at: DVector<f64>,
    ) -> Self {
        let classes = whitening.classes.iter().zip(&whitening.rows_of);
        let shares = classes.zip(&jacobian.classes).map(|((class, rows), A)| {
            ClassGram::new(class.clone(), A, &residual.select_rows(rows))
        });
        Self {
            shares: shares.collect(),
            unknowns,
            at,
        }
    }

    /// With a set of so many further columns, and their unknowns, at zero.
    #[must_use]
    pub fn with(
        &self,
        further: &CrossProducts,
        (set, count): (usize, usize),
        unknown: Coefficient,
    ) -> Self {
        let n = self.unknowns.len();
        let shares = self.shares.iter().zip(further.blocks(set));
        let mut new = Self {
            shares: shares.map(|(share, block)| share.with(n, &block)).collect(),
            unknowns: self.unknowns.clone(),
            at: self.at.clone().resize_vertically(n + count, 0.0),
        };
        new.unknowns.resize(n + count, unknown);
        new
    }

    /// The same where the residual and some columns of `jacobian` have changed, in ascending order, to their `own`.
    #[must_use]
    pub fn moved(
        &self,
        whitening: &Whitening,
        jacobian: &RowsByVarianceClass,
        (changed, own): (&[usize], &RowsByVarianceClass),
        residual: &DVector<f64>,
        at: DVector<f64>,
    ) -> Self {
        let columns = jacobian.classes.iter().zip(&own.classes);
        let shares = self.shares.iter().zip(&whitening.rows_of).zip(columns);
        let shares = shares.map(|((share, rows), (A, own))| {
            share.moved(A, (changed, own), &residual.select_rows(rows))
        });
        Self {
            shares: shares.collect(),
            unknowns: self.unknowns.clone(),
            at,
        }
    }

    /// Without some of its rows, of which `turned` has the columns and `residual` reading minus prediction.
    #[must_use]
    pub fn without(
        &self,
        whitening: &Whitening,
        (turned, residual): (&DMatrix<f64>, &DVector<f64>),
        left_out: &[bool],
    ) -> Self {
        let of_class = |rows: &Vec<usize>| {
            let rows = rows.iter().filter(|row| left_out[**row]);
            rows.copied().collect::<Vec<usize>>()
        };
        let rows_of: Vec<Vec<usize>> = whitening.rows_of.iter().map(of_class).collect();
        let columns = RowsByVarianceClass::of_rows(&rows_of, turned);
        let shares = self.shares.iter().zip(&rows_of).zip(&columns.classes);
        let rest = shares.map(|((share, rows), A)| {
            let out = ClassGram::new(share.class.clone(), A, &residual.select_rows(rows));
            share.less(&out)
        });
        Self {
            shares: rest.collect(),
            unknowns: self.unknowns.clone(),
            at: self.at.clone(),
        }
    }

    /// Information (its lower triangle), `A'W z`, `z'W z` and the logarithms of all variances at these sizes.
    fn sums(&self, ln: &[f64]) -> (DMatrix<f64>, DVector<f64>, f64, f64) {
        let n = self.unknowns.len();
        let (mut H, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let (mut q, mut logs) = (0.0, 0.0);
        for share in &self.shares {
            let variance = share.class.variance(ln);
            share.add_to(1.0 / variance, &mut H, &mut g);
            q += share.q / variance;
            logs += share.count * libm::log(variance);
        }
        (H, g, q, logs)
    }

    fn prior_sds(&self, sizes: &VarianceComponents) -> DVector<f64> {
        DVector::from_iterator(
            self.unknowns.len(),
            self.unknowns.iter().map(|unknown| unknown.prior_sd(sizes)),
        )
    }

    /// The linear model at these sizes; `None` if it has no finite answer.
    fn solved(&self, sizes: &VarianceComponents, damping: f64) -> Option<Solved> {
        let S = self.prior_sds(sizes);
        let (mut M, g, q, logs) = self.sums(&sizes.ln);
        let n = S.len();
        for k in 0..n {
            let column = &mut M.as_mut_slice()[k * n..(k + 1) * n];
            for (value, s) in column[k..].iter_mut().zip(&S.as_slice()[k..]) {
                *value *= S[k] * s;
            }
            column[k] += 1.0 + damping;
        }
        let from = DVector::from_fn(n, |k, _| {
            if S[k] > 0.0 {
                (self.at[k] - self.unknowns[k].mean) / S[k]
            } else {
                0.0
            }
        });
        let b = g.component_mul(&S) - &from;
        let factor = Factor::new(M)?;
        let mu = factor.solve(&b);
        let prior: f64 = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| size.ln_prior(*ln))
            .sum();
        let ln_z =
            -0.5 * (q + from.norm_squared() - b.dot(&mu)) - 0.5 * factor.ln_det() - 0.5 * logs
                + prior;
        Some(Solved {
            factor,
            S,
            mu,
            from,
            b,
            ln_z,
        })
    }

    /// Logarithm of the evidence at these sizes.
    #[cfg(test)]
    fn ln_z(&self, sizes: &VarianceComponents) -> f64 {
        self.solved(sizes, 0.0)
            .map_or(f64::NEG_INFINITY, |solved| solved.ln_z)
    }

    /// The evidence, its gradient by the logarithms of the sizes, and, if asked for, Fisher's information of each alone.
    pub(crate) fn evidence(
        &self,
        sizes: &VarianceComponents,
        with_information: bool,
    ) -> Option<(f64, Vec<f64>, Vec<f64>)> {
        let solved = self.solved(sizes, 0.0)?;
        let mut inverse = solved.factor.inverse();
        let (S, mu) = (&solved.S, &solved.mu);
        let n = S.len();
        let mut gradient: Vec<f64> = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| -(ln - libm::log(size.median)) / (size.ln_sd * size.ln_sd))
            .collect();
        let mut information: Vec<f64> = sizes.each().map(|size| size.ln_sd.powi(-2)).collect();
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let Some(at) = unknown.group.and_then(|group| sizes.group(group)) else {
                continue;
            };
            let phi = libm::exp(2.0 * sizes.ln[at]) / (S[k] * S[k]).max(f64::MIN_POSITIVE);
            // Where the unknown ends, in units of its prior.
            let end = solved.from[k] + mu[k];
            gradient[at] += phi * (end * end + inverse[(k, k)] - 1.0);
            information[at] += 2.0 * (phi * (1.0 - inverse[(k, k)])).powi(2);
        }
        let step = mu.component_mul(S);
        // The covariance, what stands beside the diagonal doubled: products with symmetric matrices read one triangle only.
        for k in 0..n {
            let column = &mut inverse.as_mut_slice()[k * n..(k + 1) * n];
            for (value, s) in column[k..].iter_mut().zip(&S.as_slice()[k..]) {
                *value *= 2.0 * S[k] * s;
            }
            column[k] *= 0.5;
        }
        let covariance = inverse;
        for share in &self.shares {
            let by = share.class.by_size(&sizes.ln);
            if by.is_empty() {
                continue;
            }
            let variance = share.class.variance(&sizes.ln);
            let spread = share.product(&covariance);
            let expected = share.left(&step) + spread;
            let rate = 0.5 * (expected / variance - share.count) / variance;
            for (at, by) in &by {
                gradient[*at] += rate * by;
            }
            if with_information {
                let free = (share.count - spread / variance).max(0.0);
                for (at, by) in by {
                    information[at] += 0.5 * free * (by / variance).powi(2);
                }
            }
        }
        Some((solved.ln_z, gradient, information))
    }

    /// The posterior at these sizes; `None` if the model has no finite answer.
    pub fn posterior(&self, sizes: &VarianceComponents) -> Option<Posterior> {
        let solved = self.solved(sizes, 0.0)?;
        let inverse = solved.factor.inverse();
        let S = &solved.S;
        let n = S.len();
        let effective = (0..n)
            .filter(|k| S[*k] > 0.0)
            .map(|k| 1.0 - inverse[(k, k)])
            .sum();
        let mut covariance = inverse;
        for k in 0..n {
            for row in k..n {
                let value = covariance[(row, k)] * S[row] * S[k];
                covariance[(row, k)] = value;
                covariance[(k, row)] = value;
            }
        }
        let reached = solved.reached()?;
        let chi_square = self
            .shares
            .iter()
            .map(|share| share.left(&reached.step).max(0.0) / share.class.variance(&sizes.ln))
            .sum();
        Some(Posterior {
            ln_z: reached.ln_z,
            gain: reached.gain,
            step: reached.step,
            covariance,
            chi_square,
            effective,
            count: self.shares.iter().map(|share| share.count).sum(),
            ln: sizes.ln.clone(),
        })
    }

    /// Where the unknowns end if they were also known to be near where the model was linearised: a prior `1 / sqrt(damping)` times as wide
    /// as their own holds them there. The step is that of Levenberg and Marquardt in units of the priors.
    pub fn solve(&self, sizes: &VarianceComponents, damping: f64) -> Option<Solution> {
        self.solved(sizes, damping)?.reached()
    }

    /// What the objective `z'W z + |x/S|^2` is where the model was linearised.
    pub fn objective(&self, sizes: &VarianceComponents) -> f64 {
        let S = self.prior_sds(sizes);
        let data: f64 = self
            .shares
            .iter()
            .map(|share| share.q / share.class.variance(&sizes.ln))
            .sum();
        let prior: f64 = (0..S.len())
            .filter(|k| S[*k] > 0.0)
            .map(|k| ((self.at[k] - self.unknowns[k].mean) / S[k]).powi(2))
            .sum();
        data + prior
    }

    /// The sizes of greatest evidence, from where `sizes` are.
    pub fn maximise_evidence(&self, sizes: &VarianceComponents) -> VarianceComponents {
        super::sizes::climb(sizes, |sizes, first| self.evidence(sizes, first))
    }
}

/// The linear model at some sizes.
struct Solved {
    /// Of `M`.
    factor: Factor,
    S: DVector<f64>,
    /// `M^-1 b`.
    mu: DVector<f64>,
    /// `x0 / S`.
    from: DVector<f64>,
    b: DVector<f64>,
    ln_z: f64,
}

impl Solved {
    fn reached(self) -> Option<Solution> {
        let step = self.mu.component_mul(&self.S);
        let finite = step.iter().all(|x| x.is_finite()) && self.ln_z.is_finite();
        finite.then(|| Solution {
            ln_z: self.ln_z,
            gain: 0.5 * self.b.dot(&self.mu).max(0.0),
            step,
            factor: self.factor,
            S: self.S,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::super::group::NoiseScale;
    use super::super::whitening::MarkBlock;
    use super::*;
    use admire_solver::mechanics::Vec3;
    use admire_study::ToleranceSettings;
    use admire_study::noise::Noise;

    /// Four marks of two parts in six cases, with three stiffnesses and six members of two groups.
    fn linear(sizes: &VarianceComponents) -> (LinearModel, Whitening, DMatrix<f64>, DVector<f64>) {
        let mut noise = Noise::new(3, "evidence");
        let mut block = |first: usize| MarkBlock {
            rows: (0..4).map(|k| first + 3 * k).collect(),
            levers: (0..4)
                .map(|_| Vec3::from_fn(|_, _| 100.0 * noise.normal()))
                .collect(),
            unit: 0.03,
        };
        let marks: Vec<MarkBlock> = (0..12).map(|k| block(12 * k)).collect();
        let n = 144;
        let mut precision: Vec<f64> = (0..n).map(|_| 1.0 + 0.5 * noise.normal().abs()).collect();
        precision[7] = 0.0;
        let whitening = Whitening::new(&marks, &[], &precision, sizes, &[]);
        let J = DMatrix::from_fn(n, 9, |_, _| 3.0 * noise.normal());
        let z = DVector::from_fn(n, |_, _| 2.0 * noise.normal());
        let unknown = |k: usize| match k {
            0..=2 => Coefficient {
                mean: 0.3,
                sd: 3.0,
                group: None,
            },
            3..=5 => Coefficient::member(EffectGroup::Hardpoints),
            6 => Coefficient {
                sd: 0.4,
                ..Coefficient::member(EffectGroup::LoadGains)
            },
            _ => Coefficient::member(EffectGroup::LoadGains),
        };
        let at = DVector::from_fn(9, |k, _| 0.01 * k as f64);
        let turned = (whitening.apply(&J), whitening.apply_vector(&z));
        let linear = LinearModel::new(
            &whitening,
            &RowsByVarianceClass::new(&whitening, &turned.0),
            &turned.1,
            (0..9).map(unknown).collect(),
            at,
        );
        (linear, whitening, turned.0, turned.1)
    }

    /// Against the density of a Gaussian with the covariance of readings written out.
    #[test]
    fn evidence_is_the_density_of_the_readings() {
        let sizes = VarianceComponents::new(&ToleranceSettings::default(), (0.0, [0.0; 2]), 1.0);
        let (linear, whitening, J, z) = linear(&sizes);
        let used: Vec<usize> = (0..144)
            .filter(|k| whitening.class_of[*k].is_some())
            .collect();
        assert_eq!(used.len(), 143);
        let (J, z) = (J.select_rows(&used), z.select_rows(&used));
        let density = |sizes: &VarianceComponents| {
            let S2 = DMatrix::from_diagonal(&DVector::from_iterator(
                9,
                linear.unknowns.iter().map(|u| u.prior_sd(sizes).powi(2)),
            ));
            let weights = whitening.weights(&sizes.ln).select_rows(&used);
            let C =
                &J * S2 * J.transpose() + DMatrix::from_diagonal(&weights.map(|w| 1.0 / (w * w)));
            let from = DVector::from_fn(9, |k, _| linear.unknowns[k].mean - linear.at[k]);
            let r = &z - &J * from;
            let factor = Cholesky::new(C).unwrap();
            let log_det: f64 = factor
                .l_dirty()
                .diagonal()
                .iter()
                .map(|d| 2.0 * d.ln())
                .sum();
            let prior: f64 = sizes
                .ln
                .iter()
                .zip(sizes.each())
                .map(|(ln, s)| s.ln_prior(*ln))
                .sum();
            -0.5 * r.dot(&factor.solve(&r)) - 0.5 * log_det + prior
        };
        let other = sizes.at(sizes.ln.iter().map(|ln| ln + 0.7).collect());
        for sizes in [&sizes, &other] {
            let value = linear.ln_z(sizes);
            assert!(
                (value - density(sizes)).abs() < 1e-6 * value.abs(),
                "{value}"
            );
        }
    }

    #[test]
    fn the_gradient_by_the_sizes_is_that_of_differences() {
        let mut sizes =
            VarianceComponents::new(&ToleranceSettings::default(), (0.0, [0.0; 2]), 1.0);
        sizes.add_scale(NoiseScale::Marks, true);
        let (linear, ..) = linear(&sizes);
        let (_, gradient, _) = linear.evidence(&sizes, true).unwrap();
        for k in 0..sizes.ln.len() {
            let at = |h: f64| {
                let mut ln = sizes.ln.clone();
                ln[k] += h;
                linear.ln_z(&sizes.at(ln))
            };
            let by = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!(
                (by - gradient[k]).abs() < 1e-4 * (1.0 + by.abs()),
                "{k}: {by} {}",
                gradient[k]
            );
        }
    }

    /// Half of what the objective of the linear model is above its minimum: at no step, what the whole step gains.
    #[test]
    fn a_step_is_below_the_maximum_by_what_it_does_not_gain() {
        let mut sizes =
            VarianceComponents::new(&ToleranceSettings::default(), (0.0, [0.0; 2]), 1.0);
        sizes.add_scale(NoiseScale::Marks, true);
        let (linear, ..) = linear(&sizes);
        let reached = linear.solve(&sizes, 0.0).unwrap();
        assert!(reached.gain > 1.0);
        for part in [0.0, 0.5, 1.0, 3.0] {
            let above = reached.above(&(part * &reached.step));
            let expected = (part - 1.0_f64).powi(2) * reached.gain;
            assert!((above - expected).abs() < 1e-9 * reached.gain, "{part}");
        }
    }

    /// Columns that are added or replaced leave what a model made anew of all of them has.
    #[test]
    fn a_model_with_other_columns_is_that_made_anew() {
        let sizes = VarianceComponents::new(&ToleranceSettings::default(), (0.0, [0.0; 2]), 1.0);
        let (linear, whitening, J, z) = linear(&sizes);
        let unknowns = &linear.unknowns;
        let alike = |a: &LinearModel, b: &LinearModel| {
            let (a, b) = (a.ln_z(&sizes), b.ln_z(&sizes));
            assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
        };
        let mut at = linear.at.clone();
        at.rows_mut(7, 2).fill(0.0);
        let (known, mut other) = (J.columns(0, 7).into_owned(), J.clone());
        let further = J.columns(7, 2).into_owned();
        let by_class = |J: &DMatrix<f64>| RowsByVarianceClass::new(&whitening, J);
        let (known, J) = (by_class(&known), by_class(&J));
        let columns = |range: Range<usize>| further.columns(range.start, range.len()).into_owned();
        let further = CrossProducts::new(&whitening, (&known, &z), (&[0..0, 0..2], columns));
        let few = at.rows(0, 7).into_owned();
        let few = LinearModel::new(&whitening, &known, &z, unknowns[..7].to_vec(), few);
        let whole = LinearModel::new(&whitening, &J, &z, unknowns.clone(), at);
        alike(&few.with(&further, (1, 2), unknowns[8]), &whole);

        other.column_mut(3).scale_mut(1.7);
        other.column_mut(8).scale_mut(-0.4);
        let (own, left) = (by_class(&other.select_columns(&[3, 8])), &z * 0.9);
        let at = linear.at.clone();
        let moved = linear.moved(&whitening, &J, (&[3, 8], &own), &left, at.clone());
        let anew = LinearModel::new(&whitening, &by_class(&other), &left, unknowns.clone(), at);
        alike(&moved, &anew);
        assert!((moved.ln_z(&sizes) - linear.ln_z(&sizes)).abs() > 1.0);
    }

    /// Rows that are taken out leave what a model of the others has.
    #[test]
    fn a_model_without_some_rows_is_that_of_the_others() {
        let sizes = VarianceComponents::new(&ToleranceSettings::default(), (0.0, [0.0; 2]), 1.0);
        let (linear, whitening, J, z) = linear(&sizes);
        let left_out: Vec<bool> = (0..144).map(|row| row >= 96).collect();
        let less = linear.without(&whitening, (&J, &z), &left_out);
        let rows = |rows: &Vec<usize>| rows.iter().copied().filter(|row| *row < 96).collect();
        let mut few = whitening.clone();
        few.rows_of = whitening.rows_of.iter().map(rows).collect();
        let unknowns = linear.unknowns.clone();
        let other = LinearModel::new(
            &few,
            &RowsByVarianceClass::new(&few, &J),
            &z,
            unknowns,
            linear.at.clone(),
        );
        let (less, other) = (less.ln_z(&sizes), other.ln_z(&sizes));
        assert!((less - other).abs() < 1e-9 * other.abs(), "{less} {other}");
        assert!((less - linear.ln_z(&sizes)).abs() > 1.0);
    }
}
