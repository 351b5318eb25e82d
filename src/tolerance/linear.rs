//! Evidence of a linear model with Gaussian priors whose sizes are unknown.
//!
//! Rows are independent, of a few classes of equal variance, so that Gram matrices by class hold all that is needed: other sizes cost
//! additions and one factorisation. With `S` the prior standard deviations, `z` the residual where the model was linearised and `x0`
//! the unknowns there, `M = I + S H S`, `b = S A'W z - x0/S` and
//! `ln Z = -(z'W z + |x0/S|^2 - b'M^-1 b)/2 - ln det M / 2 - sum ln var / 2 + sum ln p(sizes)`, constants left out.
//! Source: MacKay, Neural Computation 4 (1992) 415.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::group::{Group, Sizes};
use super::whitening::{Class, Whitening};

/// Prior of one unknown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Unknown {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of its own: of the whole if it is in no group, else of what it has beyond its group.
    pub sd: f64,
    /// Its group of tolerances.
    pub group: Option<Group>,
}

impl Unknown {
    /// A member of a group.
    pub(crate) const fn member(group: Group) -> Self {
        Self {
            mean: 0.0,
            sd: 0.0,
            group: Some(group),
        }
    }

    /// Prior standard deviation at these sizes.
    pub(crate) fn prior_sd(&self, sizes: &Sizes) -> f64 {
        let tau = self.group.and_then(|group| sizes.of(group)).unwrap_or(0.0);
        libm::hypot(tau, self.sd)
    }
}

/// Rows of one class.
#[derive(Clone, Debug)]
struct Share {
    class: Class,
    count: f64,
    /// `A'A`, `A'z`, `z'z`.
    H: DMatrix<f64>,
    g: DVector<f64>,
    q: f64,
}

/// A model linearised at a point.
#[derive(Clone, Debug)]
pub struct Linear {
    shares: Vec<Share>,
    /// One per column.
    pub unknowns: Vec<Unknown>,
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
    pub(crate) fn chi_square_per_dof(&self) -> f64 {
        self.chi_square / (self.count - self.effective).max(1.0)
    }

    /// The step to the maximum with some unknowns moving by given amounts instead.
    pub(crate) fn step_with(&self, given: &[(usize, f64)]) -> DVector<f64> {
        let places: Vec<usize> = given.iter().map(|(place, _)| *place).collect();
        let off = DVector::from_iterator(
            given.len(),
            given.iter().map(|(place, value)| value - self.step[*place]),
        );
        let across = self.covariance.select_columns(&places);
        let own = across.select_rows(&places);
        match Cholesky::new(own) {
            Some(factor) => &self.step + across * factor.solve(&off),
            None => self.step.clone(),
        }
    }

    /// Variances of the unknowns in `kept` as they would be if all others were known exactly; the share of tolerances in a variance is
    /// what this falls short of it.
    pub(crate) fn without(&self, kept: &[usize]) -> Vec<f64> {
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

impl Linear {
    /// `jacobian` and `residual` (reading minus prediction) are those of turned rows, see [`Whitening::apply`].
    pub(crate) fn new(
        whitening: &Whitening,
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        unknowns: Vec<Unknown>,
        at: DVector<f64>,
    ) -> Self {
        let shares = whitening.classes.iter().enumerate().map(|(k, class)| {
            let rows: Vec<usize> = (0..residual.len())
                .filter(|row| whitening.class_of[*row] == Some(k))
                .collect();
            let A = jacobian.select_rows(&rows);
            let z = residual.select_rows(&rows);
            let transposed = A.transpose();
            Share {
                class: *class,
                count: rows.len() as f64,
                H: &transposed * &A,
                g: &transposed * &z,
                q: z.norm_squared(),
            }
        });
        Self {
            shares: shares.collect(),
            unknowns,
            at,
        }
    }

    /// With further columns of turned rows, and their unknowns, at zero.
    #[must_use]
    pub(crate) fn with(
        &self,
        whitening: &Whitening,
        (jacobian, residual): (&DMatrix<f64>, &DVector<f64>),
        further: &DMatrix<f64>,
        unknowns: &[Unknown],
    ) -> Self {
        let (n, k) = (self.unknowns.len(), further.ncols());
        let mut new = self.clone();
        new.unknowns.extend_from_slice(unknowns);
        new.at = new.at.resize_vertically(n + k, 0.0);
        for (at, share) in new.shares.iter_mut().enumerate() {
            let rows: Vec<usize> = (0..residual.len())
                .filter(|row| whitening.class_of[*row] == Some(at))
                .collect();
            let E = further.select_rows(&rows).transpose();
            let cross = &E * jacobian.select_rows(&rows);
            let own = &E * E.transpose();
            let g = &E * residual.select_rows(&rows);
            let mut H =
                std::mem::replace(&mut share.H, DMatrix::zeros(0, 0)).resize(n + k, n + k, 0.0);
            H.view_mut((n, 0), (k, n)).copy_from(&cross);
            H.view_mut((0, n), (n, k)).copy_from(&cross.transpose());
            H.view_mut((n, n), (k, k)).copy_from(&own);
            share.H = H;
            let mut longer =
                std::mem::replace(&mut share.g, DVector::zeros(0)).resize_vertically(n + k, 0.0);
            longer.rows_mut(n, k).copy_from(&g);
            share.g = longer;
        }
        new
    }

    /// The same where residual and some columns have changed.
    #[must_use]
    pub(crate) fn moved(
        &self,
        whitening: &Whitening,
        (jacobian, residual): (&DMatrix<f64>, &DVector<f64>),
        changed: &[usize],
        at: DVector<f64>,
    ) -> Self {
        let mut new = self.clone();
        new.at = at;
        let own = jacobian.select_columns(changed);
        for (k, share) in new.shares.iter_mut().enumerate() {
            let rows: Vec<usize> = (0..residual.len())
                .filter(|row| whitening.class_of[*row] == Some(k))
                .collect();
            let A = jacobian.select_rows(&rows);
            let z = residual.select_rows(&rows);
            let cross = own.select_rows(&rows).transpose() * &A;
            for (row, to) in cross.row_iter().zip(changed) {
                share.H.row_mut(*to).copy_from(&row);
                share.H.column_mut(*to).copy_from(&row.transpose());
            }
            share.g = A.tr_mul(&z);
            share.q = z.norm_squared();
        }
        new
    }

    /// Information, `A'W z`, `z'W z` and the logarithms of all variances at these sizes.
    fn sums(&self, ln: &[f64]) -> (DMatrix<f64>, DVector<f64>, f64, f64) {
        let n = self.unknowns.len();
        let (mut H, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let (mut q, mut logs) = (0.0, 0.0);
        for share in &self.shares {
            let variance = share.class.variance(ln);
            let precision = 1.0 / variance;
            for (to, from) in H.as_mut_slice().iter_mut().zip(share.H.as_slice()) {
                *to += from * precision;
            }
            g.axpy(precision, &share.g, 1.0);
            q += share.q * precision;
            logs += share.count * libm::log(variance);
        }
        (H, g, q, logs)
    }

    fn prior_sds(&self, sizes: &Sizes) -> DVector<f64> {
        DVector::from_iterator(
            self.unknowns.len(),
            self.unknowns.iter().map(|unknown| unknown.prior_sd(sizes)),
        )
    }

    /// Factor of `M`, `S`, `b`, the information, `z'W z + |x0/S|^2` and the logarithms of variances.
    fn solved(&self, sizes: &Sizes, damping: f64) -> Option<Solved> {
        let S = self.prior_sds(sizes);
        let (H, g, q, logs) = self.sums(&sizes.ln);
        let n = S.len();
        let mut M = H.clone();
        for column in 0..n {
            for row in 0..n {
                M[(row, column)] *= S[row] * S[column];
            }
            M[(column, column)] += 1.0 + damping;
        }
        let from = DVector::from_fn(n, |k, _| {
            if S[k] > 0.0 {
                (self.at[k] - self.unknowns[k].mean) / S[k]
            } else {
                0.0
            }
        });
        let b = g.component_mul(&S) - &from;
        let factor = Cholesky::new(M)?;
        let mu = factor.solve(&b);
        let log_det: f64 = factor
            .l_dirty()
            .diagonal()
            .iter()
            .map(|d| libm::log(*d))
            .sum::<f64>()
            * 2.0;
        let prior: f64 = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| size.ln_prior(*ln))
            .sum();
        let ln_z =
            -0.5 * (q + from.norm_squared() - b.dot(&mu)) - 0.5 * log_det - 0.5 * logs + prior;
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
    fn ln_z(&self, sizes: &Sizes) -> f64 {
        self.solved(sizes, 0.0)
            .map_or(f64::NEG_INFINITY, |solved| solved.ln_z)
    }

    /// The evidence, its gradient by the logarithms of the sizes, and Fisher's information of each alone.
    pub(crate) fn evidence(&self, sizes: &Sizes) -> Option<(f64, Vec<f64>, Vec<f64>)> {
        let solved = self.solved(sizes, 0.0)?;
        let inverse = inverse(&solved.factor);
        let (S, mu) = (&solved.S, &solved.mu);
        let mut gradient: Vec<f64> = sizes
            .ln
            .iter()
            .zip(sizes.each())
            .map(|(ln, size)| -(ln - libm::log(size.usual)) / (size.ln_sd * size.ln_sd))
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
        for share in &self.shares {
            let by: Vec<(usize, f64)> = share
                .class
                .by_size(&sizes.ln)
                .into_iter()
                .flatten()
                .collect();
            if by.is_empty() {
                continue;
            }
            let variance = share.class.variance(&sizes.ln);
            let left = share.q - 2.0 * share.g.dot(&step) + step.dot(&(&share.H * &step));
            let mut spread = 0.0;
            for column in 0..S.len() {
                let mut sum = 0.0;
                for row in 0..S.len() {
                    sum += share.H[(row, column)] * inverse[(row, column)] * S[row];
                }
                spread += sum * S[column];
            }
            let rate = 0.5 * ((left + spread) / variance - share.count) / variance;
            for (at, by) in by {
                gradient[at] += rate * by;
                let free = (share.count - spread / variance).max(0.0);
                information[at] += 0.5 * free * (by / variance).powi(2);
            }
        }
        Some((solved.ln_z, gradient, information))
    }

    /// The posterior at these sizes; `None` if the model has no finite answer.
    pub(crate) fn posterior(&self, sizes: &Sizes) -> Option<Posterior> {
        self.damped(sizes, 0.0)
    }

    /// The posterior if the unknowns were also known to be near where the model was linearised: a prior `1 / sqrt(damping)` times as wide
    /// as their own holds them there. Its step is that of Levenberg and Marquardt in units of the priors.
    pub(crate) fn damped(&self, sizes: &Sizes, damping: f64) -> Option<Posterior> {
        let solved = self.solved(sizes, damping)?;
        let inverse = inverse(&solved.factor);
        let S = &solved.S;
        let n = S.len();
        let effective = (0..n)
            .filter(|k| S[*k] > 0.0)
            .map(|k| 1.0 - inverse[(k, k)])
            .sum();
        let covariance = DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * S[a] * S[b]);
        let step = solved.mu.component_mul(S);
        let chi_square = self
            .shares
            .iter()
            .map(|share| {
                let left = share.q - 2.0 * share.g.dot(&step) + step.dot(&(&share.H * &step));
                left.max(0.0) / share.class.variance(&sizes.ln)
            })
            .sum();
        let finite = step.iter().all(|x| x.is_finite()) && solved.ln_z.is_finite();
        finite.then_some(Posterior {
            ln_z: solved.ln_z,
            step,
            covariance,
            chi_square,
            effective,
            count: self.shares.iter().map(|share| share.count).sum(),
            gain: 0.5 * (solved.b.dot(&solved.mu)).max(0.0),
            ln: sizes.ln.clone(),
        })
    }

    /// What the objective `z'W z + |x/S|^2` is where the model was linearised.
    pub(crate) fn objective(&self, sizes: &Sizes) -> f64 {
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
    pub(crate) fn sized(&self, sizes: &Sizes) -> Sizes {
        super::sizes::climb(sizes, |sizes| self.evidence(sizes))
    }
}

/// Blocks up to this size are inverted one column after the other.
const SMALL: usize = 24;

/// `M^-1 = V'V` with `V = L^-1`, by blocks: matrix products take most of the time.
fn inverse(factor: &Cholesky<f64, Dyn>) -> DMatrix<f64> {
    let L = factor.l_dirty();
    let n = L.nrows();
    let mut V = DMatrix::zeros(n, n);
    invert_lower(L, &mut V, 0, n);
    V.transpose() * V
}

/// The inverse of the triangle of `L` in rows and columns `first..last`.
fn invert_lower(L: &DMatrix<f64>, V: &mut DMatrix<f64>, first: usize, last: usize) {
    if last - first <= SMALL {
        for column in first..last {
            V[(column, column)] = 1.0 / L[(column, column)];
            for row in column + 1..last {
                let mut sum = 0.0;
                for k in column..row {
                    sum -= L[(row, k)] * V[(k, column)];
                }
                V[(row, column)] = sum / L[(row, row)];
            }
        }
        return;
    }
    let middle = usize::midpoint(first, last);
    invert_lower(L, V, first, middle);
    invert_lower(L, V, middle, last);
    let (a, b) = (middle - first, last - middle);
    let below = L.view((middle, first), (b, a)) * V.view((first, first), (a, a));
    let block = V.view((middle, middle), (b, b)) * below;
    V.view_mut((middle, first), (b, a)).copy_from(&-block);
}

struct Solved {
    factor: Cholesky<f64, Dyn>,
    S: DVector<f64>,
    mu: DVector<f64>,
    from: DVector<f64>,
    b: DVector<f64>,
    ln_z: f64,
}

#[cfg(test)]
mod tests {
    use super::super::group::Scale;
    use super::super::whitening::MarkBlock;
    use super::*;
    use crate::mechanics::Vec3;
    use crate::rig::ToleranceSettings;
    use crate::rig::noise::Noise;

    /// Four marks of two parts in six cases, with three stiffnesses and six members of two groups.
    fn linear(sizes: &Sizes) -> (Linear, Whitening, DMatrix<f64>, DVector<f64>) {
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
        let whitening = Whitening::new(&marks, &[], &precision, sizes);
        let J = DMatrix::from_fn(n, 9, |_, _| 3.0 * noise.normal());
        let z = DVector::from_fn(n, |_, _| 2.0 * noise.normal());
        let unknown = |k: usize| match k {
            0..=2 => Unknown {
                mean: 0.3,
                sd: 3.0,
                group: None,
            },
            3..=5 => Unknown::member(Group::Hardpoints),
            6 => Unknown {
                sd: 0.4,
                ..Unknown::member(Group::LoadGains)
            },
            _ => Unknown::member(Group::LoadGains),
        };
        let at = DVector::from_fn(9, |k, _| 0.01 * k as f64);
        let turned = (whitening.apply(&J), whitening.apply_vector(&z));
        let linear = Linear::new(
            &whitening,
            &turned.0,
            &turned.1,
            (0..9).map(unknown).collect(),
            at,
        );
        (linear, whitening, turned.0, turned.1)
    }

    /// Against the density of a Gaussian with the covariance of readings written out.
    #[test]
    fn evidence_is_the_density_of_the_readings() {
        let sizes = Sizes::new(&ToleranceSettings::default(), 0.0, 1.0);
        let (linear, whitening, J, z) = linear(&sizes);
        let used: Vec<usize> = (0..144)
            .filter(|k| whitening.class_of[*k].is_some())
            .collect();
        assert_eq!(used.len(), 143);
        let (J, z) = (J.select_rows(&used), z.select_rows(&used));
        let density = |sizes: &Sizes| {
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
        let mut sizes = Sizes::new(&ToleranceSettings::default(), 0.0, 1.0);
        sizes.add_scale(Scale::Marks, true);
        let (linear, ..) = linear(&sizes);
        let (_, gradient, _) = linear.evidence(&sizes).unwrap();
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
}
