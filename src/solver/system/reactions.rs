//! Reaction wrenches of constraints, computed from their Lagrange multipliers.

use super::Configuration;
use super::State;
use super::contribution::{Of, WrenchEnds};
use super::structure::{ConstraintEquation, ParameterSource};
use crate::constraint::Constraint;
use crate::mechanics::{Mat6, Vec6};

impl ConstraintEquation {
    /// Returns which equations of the constraint are ignored: all if the constraint is inactive, otherwise the redundant ones.
    pub(super) fn out(&self, state: &State) -> [bool; 6] {
        let mut out = [false; 6];
        for (k, out) in out.iter_mut().enumerate().take(self.count) {
            *out = !self.active || state.redundant.get(self.first + k) == Some(&true);
        }
        out
    }
}

impl Configuration<'_> {
    /// Computes the reaction of one term of a constraint into `scratch.contribution`, and the equations of the term into
    /// `scratch.equations`.
    ///
    /// With `gradients`, the wrench per unit of each multiplier is included. An inactive constraint has the same sparsity pattern with all
    /// entries zero.
    pub(super) fn term(&mut self, number: usize, term: usize, gradients: bool) {
        let joint = &self.system.joints[number];
        let out = joint.out(self.state);
        let scale = joint.terms[term].scale;
        let mut multipliers = [0.0; 6];
        for k in 0..joint.count {
            if !out[k] {
                multipliers[k] = scale * self.state.multipliers[joint.first + k];
            }
        }
        if joint.active {
            self.evaluate_term(joint, term, &multipliers);
        } else {
            self.scratch.equations = crate::constraint::Equations {
                count: joint.count,
                ..Default::default()
            };
        }
        let term = &joint.terms[term];
        let mut w = Vec6::zeros();
        for k in 0..joint.count {
            w -= self.scratch.equations.jacobian[k] * multipliers[k];
        }
        let ends = WrenchEnds {
            i: term.i,
            j: term.j,
            pair: term.pair,
            frame: Some(term.j),
            reaction: Some(self.system.owners[term.j]),
        };
        self.init_contribution(ends, w);
        if !gradients {
            return;
        }
        let scratch = &mut *self.scratch;
        let (equations, reaction) = (&scratch.equations, &mut scratch.contribution);
        for k in 0..joint.count {
            let of = Of::Unknown(self.system.first_equation + joint.first + k);
            let unit = if out[k] {
                Vec6::zeros()
            } else {
                equations.jacobian[k] * -scale
            };
            reaction.push_scalar(of, &unit);
        }
    }

    /// Sets the derivative of a term's reaction with respect to the relative rotation of its markers.
    pub(super) fn set_reaction_stiffness(&mut self) {
        let scratch = &mut *self.scratch;
        let (equations, reaction) = (&scratch.equations, &mut scratch.contribution);
        let mut D = Mat6::zeros();
        let curvature = reaction.R * equations.curvature * reaction.R.transpose();
        D.fixed_view_mut::<3, 3>(3, 3).copy_from(&-curvature);
        reaction.D = Some(D);
    }

    /// Evaluates one term of a constraint into `scratch.equations`.
    pub(super) fn evaluate_term(
        &mut self,
        joint: &ConstraintEquation,
        number: usize,
        multipliers: &[f64; 6],
    ) {
        let term = &joint.terms[number];
        let motion = self.motion(term.i, term.j, term.pair, term.law.uses_angles());
        let value;
        let theta = match &joint.drive {
            ParameterSource::Theta(range) => &self.parameters.theta()[range.clone()],
            ParameterSource::Function(function) => {
                value = [self.scratch.functions[*function].value];
                &value[..]
            }
            ParameterSource::Constant(held) => {
                value = [*held];
                &value[..]
            }
            ParameterSource::Rate(drive) => {
                value = [self.scratch.driven[drive.index][0]];
                &value[..]
            }
        };
        term.law
            .evaluate(&motion, theta, multipliers, &mut self.scratch.equations);
    }
}
