//! Sites at which a force may act that the model lacks, and the response of the model to such a force.

use nalgebra::{DMatrix, DVector};

use super::candidate_effect::CandidateEffect;
use super::elastic_element::ElasticElement;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;
use crate::priors::FORCE_LEVER_MM;
use crate::settings::ROUND_OFF_DEFLECTION;
use admire_identify::tolerance::{
    LinearModel, Posterior, RowsByVarianceClass, VarianceComponents, transposed,
};
use admire_solver::model::{JointKind, MarkerIx};

/// Component of an element along which a force may act.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    /// Address of the component of a bushing, such as `BUSHING/2.K.1`, or of a joint with a free motion.
    pub address: String,
    /// Markers I and J of the element.
    pub pair: (MarkerIx, MarkerIx),
    /// Component along the axes of J: 0 to 2 for translations, 3 to 5 for rotations.
    pub axis: usize,
    /// Displacement of I relative to J along the component, in each case.
    pub displacement: Vec<f64>,
    /// Typical force at the site. For a bushing component, it is the largest force in that component; for a joint, the largest force in any
    /// bushing.
    pub force: f64,
}

/// Sites of a model, with the responses to unit forces there, computed at the end of a fit.
pub(super) struct Sites {
    pub all: Vec<Site>,
    /// Effect of a unit force on all rows, one matrix per site with one column per case. The force acts in that case only.
    pub effects: Vec<DMatrix<f64>>,
    /// Change of the displacement at a site by a unit force there, in each case.
    pub compliance: Vec<Vec<f64>>,
}

/// Linear model of a fit, reduced to the force at one site in each case. All unknowns of the fit are marginalised.
pub(super) struct SiteModel {
    /// Decrease of the fit's unknowns per unit force in each case, one column per case. By this decrease, the unknowns absorb part of the
    /// effect of the force.
    pub absorbed: DMatrix<f64>,
    /// Information matrix of the forces in all cases.
    pub information: DMatrix<f64>,
    /// Information matrix as the difference `D - B'B`: the diagonal `D` with the fit's unknowns fixed, and the matrix `B`. The subtracted
    /// term is the information lost because the unknowns are estimated too. `None` if cases share rows, or if there are too few cases for
    /// the split to save work.
    parts: Option<(DVector<f64>, DMatrix<f64>)>,
    /// Gradient of the log evidence with respect to the force in each case.
    pub gradient: DVector<f64>,
}

impl Sites {
    /// Finds the sites, and computes the responses there.
    pub(super) fn new(survey: &OperatingPoints<'_>) -> Self {
        let all = sites(survey);
        let asked: Vec<_> = all.iter().map(|site| (site.pair, site.axis)).collect();
        let (effects, compliance) = survey.unit_force_effects(&asked);
        Self {
            all,
            effects,
            compliance,
        }
    }
}

impl SiteModel {
    /// Reduces the linear model of a fit. `effect` holds the effect of a unit force in each case on all rows. `residual` and `jacobian` are those
    /// of [`FittedModel::whitened_at`] at the variance components `sizes`.
    pub(super) fn new(
        fitted: &FittedModel,
        effect: &DMatrix<f64>,
        sizes: &VarianceComponents,
        posterior: &Posterior,
        (residual, jacobian): &(DVector<f64>, DMatrix<f64>),
    ) -> Self {
        let weights = fitted.whitening.weights(&sizes.ln);
        let mut effect = fitted.whitening.apply(effect);
        for (mut row, weight) in effect.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let cross = transposed(jacobian, &effect);
        let absorbed = transposed(&posterior.covariance, &cross);
        let held = transposed(&effect, &effect);
        let parts = (2 * cross.nrows() < held.ncols())
            .then(|| information_parts(&held, &posterior.covariance, &cross))
            .flatten();
        Self {
            information: held - transposed(&cross, &absorbed),
            parts,
            gradient: effect.tr_mul(residual),
            absorbed,
        }
    }

    /// Creates the model of a site at which the forces are measured with this information matrix.
    #[cfg(test)]
    pub(super) fn of_readings(information: DMatrix<f64>, gradient: DVector<f64>) -> Self {
        Self {
            absorbed: DMatrix::zeros(0, 0),
            information,
            parts: None,
            gradient,
        }
    }

    /// Returns the log likelihood ratio of forces at the site, one per case, against no force, in nats.
    pub(super) fn ln_likelihood(&self, forces: &DVector<f64>) -> f64 {
        forces.dot(&self.gradient) - 0.5 * self.information_of(forces)
    }

    /// Returns the information `p' M p` of a pattern `p` of forces, with the information matrix `M`.
    pub(super) fn information_of(&self, pattern: &DVector<f64>) -> f64 {
        match &self.parts {
            Some((held, root)) => {
                let squares = pattern.component_mul(pattern);
                squares.dot(held) - (root * pattern).norm_squared()
            }
            None => pattern.dot(&(&self.information * pattern)),
        }
    }
}

/// Splits the information matrix `held - cross' covariance cross` into the diagonal of `held` and a matrix `B` with `B'B = cross' covariance
/// cross`. Returns `None` if `held` is not diagonal, because cases share rows, or if the covariance is not positive definite.
fn information_parts(
    held: &DMatrix<f64>,
    covariance: &DMatrix<f64>,
    cross: &DMatrix<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let is_diagonal = (0..held.ncols()).all(|k| {
        let column = held.column(k);
        (0..held.nrows()).all(|row| row == k || column[row] == 0.0)
    });
    let root = is_diagonal.then(|| covariance.clone().cholesky())??.l();
    Some((held.diagonal(), root.tr_mul(cross)))
}

/// Linear model of a fit without some of its effects: posterior, and whitened residual and Jacobian, at the fit's variance components.
pub(super) struct Reduced {
    pub posterior: Posterior,
    pub whitened: (DVector<f64>, DMatrix<f64>),
}

impl Reduced {
    /// Removes the effects for which `is_out` is true from the linear model of a fit. Such an effect must vanish if its parameters are zero, as a
    /// force of unknown law does. Laws with memory that stay in the model are free only in their force; their other parameters keep the fitted
    /// values. Returns `None` if the linear model has no finite solution.
    pub(super) fn without(
        fitted: &FittedModel,
        is_out: impl Fn(&CandidateEffect) -> bool,
    ) -> Option<Self> {
        let sizes = &fitted.sizes;
        let (mut out, mut held): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        for (effect, places) in fitted.effects.iter().zip(&fitted.parameter_index) {
            if is_out(effect) {
                out.extend(places);
            } else {
                let numbers = places.iter().enumerate();
                held.extend(
                    numbers
                        .filter(|(n, _)| effect.is_held(*n))
                        .map(|(_, at)| at),
                );
            }
        }
        if out.is_empty() && held.is_empty() {
            return Some(Self {
                posterior: fitted.posterior.clone(),
                whitened: fitted.whitened(),
            });
        }
        let whole = fitted.whitened_jacobian();
        let mut residual = fitted.whitened_residual();
        for k in &out {
            residual.axpy(fitted.x[*k], &whole.column(*k), 1.0);
        }
        let is_kept = |k: &usize| !out.contains(k) && !held.contains(k);
        let kept: Vec<usize> = (0..fitted.x.len()).filter(is_kept).collect();
        let mut jacobian = whole.select_columns(&kept);
        let model = LinearModel::new(
            &fitted.whitening,
            &RowsByVarianceClass::new(&fitted.whitening, &jacobian),
            &residual,
            kept.iter().map(|k| fitted.priors[*k]).collect(),
            DVector::from_iterator(kept.len(), kept.iter().map(|k| fitted.x[*k])),
        );
        let posterior = model.posterior(sizes)?;
        let weights = fitted.whitening.weights(&sizes.ln);
        residual -= &jacobian * &posterior.step;
        residual.component_mul_assign(&weights);
        for (mut row, weight) in jacobian.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        Some(Self {
            posterior,
            whitened: (residual, jacobian),
        })
    }
}

/// Returns the components of all elastic elements that deflect, and the free motions of joints.
pub(crate) fn sites(survey: &OperatingPoints<'_>) -> Vec<Site> {
    let mut out = Vec::new();
    let mut put = |address: String, pair, axis: usize, displacement: Vec<f64>, force: f64| {
        let low = displacement.iter().copied().fold(f64::INFINITY, f64::min);
        let high = displacement
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let range = high - low;
        if range.is_finite() && range > ROUND_OFF_DEFLECTION {
            out.push(Site {
                address,
                pair,
                axis,
                displacement,
                force,
            });
        }
    };
    let mut largest = 0.0_f64;
    for element in ElasticElement::all(survey) {
        for axis in 0..6 {
            let u: Vec<f64> = element.deflections.iter().map(|d| d[axis]).collect();
            let most = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            let force = element.stiffness[axis] * most;
            if axis < 3 {
                largest = largest.max(force);
            }
            put(element.address(axis), element.pair, axis, u, force);
        }
    }
    let lever = FORCE_LEVER_MM * survey.millimetre();
    for joint in survey.model.joints.iter().filter(|j| j.header.active) {
        let axes: &[usize] = match joint.kind {
            JointKind::Translational => &[2],
            JointKind::Cylindrical => &[2, 5],
            JointKind::Revolute => &[5],
            _ => continue,
        };
        let readings = survey.constraint("JOINT", joint.header.id);
        for &axis in axes {
            let of = |r: &admire_solver::system::Reading| match axis {
                0..3 => r.motion.p_ij_j[axis],
                _ => r.motion.angles[axis - 3],
            };
            let u: Vec<f64> = readings.iter().map(of).collect();
            let force = if axis < 3 { largest } else { largest * lever };
            let address = format!("JOINT/{}", joint.header.id);
            put(address, (joint.i, joint.j), axis, u, force);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts of the information matrix give the same information of a pattern as the whole matrix. There are no parts if cases share
    /// rows.
    #[test]
    fn the_parts_of_the_information_give_what_the_matrix_gives() {
        let (unknowns, cases) = (3, 9);
        let wave = |seed: f64| move |i: usize, k: usize| (seed * (1 + i + 7 * k) as f64).sin();
        let cross = DMatrix::from_fn(unknowns, cases, wave(0.7));
        let half = DMatrix::from_fn(unknowns, unknowns, wave(1.3));
        let covariance = &half * half.transpose() + DMatrix::identity(unknowns, unknowns);
        let held = DMatrix::from_diagonal(&DVector::from_fn(cases, |k, _| 20.0 + k as f64));
        let information = &held - cross.transpose() * &covariance * &cross;
        let gradient = DVector::from_fn(cases, |k, _| k as f64);
        let mut site = SiteModel::of_readings(information, gradient);
        let pattern = DVector::from_fn(cases, |k, _| (0.4 * k as f64).cos());
        let whole = [site.information_of(&pattern), site.ln_likelihood(&pattern)];
        site.parts = information_parts(&held, &covariance, &cross);
        assert!(site.parts.is_some());
        let parts = [site.information_of(&pattern), site.ln_likelihood(&pattern)];
        for (whole, parts) in whole.iter().zip(parts) {
            assert!(
                (whole - parts).abs() < 1e-11 * whole.abs(),
                "{whole} {parts}"
            );
        }
        let mut shared = held;
        (shared[(0, 1)], shared[(1, 0)]) = (0.5, 0.5);
        assert!(information_parts(&shared, &covariance, &cross).is_none());
    }
}
