//! Wrenches of force elements: force laws between two markers, and vector forces given by functions.

use super::chain::turn;
use super::contribution::{ByRate, Of, WrenchEnds};
use super::structure::{Action, Element, ParameterSource};
use super::{Configuration, NoValue};
use crate::element::{CarNumbers, Wrench};
use crate::mechanics::{Mat6, Vec6};

/// Derivatives to be computed with a wrench.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum DerivativeRequest {
    /// Value only.
    Value,
    /// Value and derivatives with respect to the unknowns.
    Tangent,
    /// Value and derivatives with respect to the parameters of the law, left in `scratch.wrench`.
    Parameters,
}

impl Configuration<'_> {
    /// Computes the wrench of an element into `scratch.contribution`. An inactive element gives a zero wrench with the same sparsity
    /// pattern.
    pub(super) fn element(&mut self, number: usize, ask: DerivativeRequest) -> Result<(), NoValue> {
        let element = &self.system.elements[number];
        let ends = WrenchEnds {
            i: element.i,
            j: element.j,
            pair: element.pair,
            frame: element.frame,
            reaction: element.reaction,
        };
        match &element.action {
            Action::Law(_, drive) => {
                if element.active {
                    self.evaluate_law(element, ask == DerivativeRequest::Parameters)?;
                } else {
                    self.scratch.wrench.clear();
                }
                self.init_contribution(ends, self.scratch.wrench.value);
                if ask != DerivativeRequest::Tangent {
                    return Ok(());
                }
                let scratch = &mut *self.scratch;
                let out = &mut scratch.contribution;
                out.D = Some(turn(&out.R, &scratch.wrench.by_motion));
                if self.state.moves() && element.damping.is_some() {
                    let E = if element.active {
                        let R = self.scratch.markers[element.j].R;
                        turn(&R, &self.scratch.wrench.by_rate)
                    } else {
                        Mat6::zeros()
                    };
                    let rate = self.by_rate((element.i, element.j), E);
                    self.scratch.contribution.rate = Some(rate);
                }
                let scratch = &mut *self.scratch;
                let out = &mut scratch.contribution;
                if let (ParameterSource::Function(function), Some(unit)) =
                    (drive, scratch.wrench.by_parameter.first())
                {
                    out.push_scalar(Of::Function(*function), unit);
                }
            }
            Action::Vector(components) => {
                let mut w = Vec6::zeros();
                if element.active {
                    for k in 0..6 {
                        w[k] = components[k].map_or(0.0, |f| self.scratch.functions[f].value);
                    }
                }
                self.init_contribution(ends, w);
                if ask != DerivativeRequest::Tangent {
                    return Ok(());
                }
                let out = &mut self.scratch.contribution;
                for k in 0..6 {
                    if let Some(function) = components[k] {
                        let on = f64::from(u8::from(element.active));
                        out.push_scalar(Of::Function(function), &Vec6::ith(k, on));
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the velocity dependence of a wrench: its derivative `E` with respect to the velocity of I relative to J (ground axes), and
    /// the quantities that the chain rule needs.
    pub(super) fn by_rate(&self, (i, j): (usize, usize), E: Mat6) -> ByRate {
        let (i, j) = (self.moving_frame(Some(i)), self.moving_frame(Some(j)));
        ByRate {
            unknowns: self.system.moving_unknowns,
            E,
            w_c: j.w,
            x: i.v - j.v - j.w.cross(&(i.pose.p - j.pose.p)),
            y: i.w - j.w,
        }
    }

    /// Evaluates the force law of an element into `scratch.wrench`, in J axes.
    fn evaluate_law(&mut self, element: &Element, with_parameters: bool) -> Result<(), NoValue> {
        let Action::Law(law, drive) = &element.action else {
            return Ok(());
        };
        let motion = self.motion(element.i, element.j, element.pair, law.uses_angles());
        let value;
        let (theta, with_parameters) = match drive {
            ParameterSource::Theta(range) => {
                (&self.parameters.theta()[range.clone()], with_parameters)
            }
            ParameterSource::Function(function) => {
                value = [self.scratch.functions[*function].value];
                (&value[..], true)
            }
            ParameterSource::Constant(held) => {
                value = [*held];
                (&value[..], true)
            }
            // Only constraints have a drive of this kind.
            ParameterSource::Rate(_) => (&[][..], false),
        };
        let rates = match &element.damping {
            Some(damping) if self.moving() => {
                Some((damping, self.relative_rates(element.i, element.j)))
            }
            _ => None,
        };
        let wrench: &mut Wrench = &mut self.scratch.wrench;
        let numbers = CarNumbers {
            theta,
            curves: self.parameters.curves(),
        };
        law.evaluate(&motion, numbers, with_parameters, wrench)
            .map_err(|reason| NoValue {
                element: element.name.clone(),
                reason: reason.into(),
            })?;
        if let Some((damping, rates)) = rates {
            damping.add(&motion, &rates, wrench);
        }
        Ok(())
    }
}
