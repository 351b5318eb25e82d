//! Unknowns of a fit, their priors, and the deck parameters that they set.
//!
//! This module is independent of solvers and measurements.

use crate::settings::MIN_LOAD_SHARE;
use nalgebra::DVector;

use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;
use admire_solver::system::{Parameters, Slot};
use admire_syntax::Address;

/// Slots of a stiffness and of the preload along the same axis, for a bushing or another element.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Component {
    /// Slot of the stiffness, K or KT.
    pub stiffness: Slot,
    /// Slot of the preload, FORCE or TORQUE; `None` for a stiffness that does not belong to a bushing.
    pub preload: Option<Slot>,
}

/// Deck parameters that an unknown `x` sets, and how they depend on `x`.
#[derive(Clone, PartialEq, Debug)]
pub enum UnknownTarget {
    /// Stiffness: `x = ln K` of these components. There are several if a symmetry makes stiffnesses equal.
    Stiffness(Vec<Component>),
    /// Common factor: each parameter is multiplied by `exp(factor * x)`, with its own `factor`.
    Factor(Vec<(Slot, f64)>),
    /// Assembly offset: `x = delta0` of equation 9 of the paper, in length units or radians. The two sides of the bushing are displaced by
    /// `delta0` in every load case, so `F = -K (delta - delta0)`. The preload in the deck becomes `FORCE + K delta0`.
    Offset(Component),
    /// Additive change: the parameter in each slot becomes its deck value plus `factor * x`.
    Number(Vec<(Slot, f64)>),
    /// Additive change with one factor per load case, such as the gain error of a load, or a load that also acts along another direction.
    PerCase(Vec<(Slot, Vec<f64>)>),
    /// Rotation of markers on their parts by the angle `x` in radians, each marker about its given axis.
    Turn(Vec<(MarkerIx, Vec3)>),
}

/// One unknown of a fit that sets parameters of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct FitUnknown {
    /// Addresses of the parameters that the unknown sets.
    pub addresses: Vec<Address>,
    /// Parameters that the unknown sets, and how they depend on it.
    pub target: UnknownTarget,
    /// Starting value of the unknown. For a stiffness or a factor, it is the logarithm.
    pub start: f64,
    /// Mean of the prior.
    pub mean: f64,
    /// Prior standard deviation; infinite without a prior.
    pub sd: f64,
    /// Lower and upper bound; `None` without bounds.
    pub bounds: Option<[f64; 2]>,
}

/// Derivative of the deck parameters with respect to one unknown.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Direction {
    /// Index of the unknown among the unknowns of the fit.
    pub unknown: usize,
    /// Slots of the parameters that change equally in every load case, each with its change per unit of the unknown.
    pub always: Vec<(Slot, f64)>,
    /// Slots of the parameters whose change depends on the load case, each with its change per unit of the unknown in every case.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// Markers that rotate by one radian per unit of the unknown, each about its given axis.
    pub turns: Vec<(MarkerIx, Vec3)>,
}

impl Direction {
    /// Iterates over the slots that change in one load case, each with its change per unit of the unknown.
    pub fn in_case(&self, case: usize) -> impl Iterator<Item = (Slot, f64)> + '_ {
        let own = self
            .per_case
            .iter()
            .map(move |(slot, factors)| (*slot, factors[case]));
        self.always.iter().copied().chain(own)
    }
}

/// Parameter values of a deck for all load cases, before the loads are set.
#[derive(Clone, PartialEq, Debug)]
pub struct Numbers {
    /// Parameter values that are the same in every load case.
    pub theta: Parameters,
    /// Slots with the amount that is added in each load case after the loads are set.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// Values of the unknowns from which the parameter values were computed; empty if unspecified.
    pub x: Vec<f64>,
}

/// List of the unknowns of a fit that set parameters of the deck.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct FitUnknowns {
    list: Vec<FitUnknown>,
    /// Load share of each unknown, see [`Self::moved`]. If the list is empty, all springs have share 1.
    shares: Vec<f64>,
}

/// Returns the step coordinate of a spring with load share `s` for which its ln K changes by `change`.
fn step_of(s: f64, change: f64) -> f64 {
    libm::expm1(change) / (1.0 + s * libm::expm1(change))
}

impl FitUnknowns {
    /// Creates the list of unknowns.
    pub fn new(list: Vec<FitUnknown>) -> Self {
        Self {
            list,
            shares: Vec::new(),
        }
    }

    /// Returns all unknowns in the order of the list.
    pub fn list(&self) -> &[FitUnknown] {
        &self.list
    }

    /// Returns the number of unknowns.
    #[expect(clippy::len_without_is_empty, reason = "a fit has unknowns")]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns the starting values of all unknowns.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.list.iter().map(|unknown| unknown.start).collect()
    }

    /// Returns the springs of all stiffness unknowns, in the order of the unknowns.
    pub fn springs(&self) -> Vec<Component> {
        let of = |unknown: &FitUnknown| match &unknown.target {
            UnknownTarget::Stiffness(components) => components.clone(),
            _ => Vec::new(),
        };
        self.list.iter().flat_map(of).collect()
    }

    /// Sets the load shares, one per entry of [`Self::springs`]. An unknown with several springs gets the mean of their shares. An empty list
    /// resets all shares to 1.
    pub fn set_load_shares(&mut self, shares: &[f64]) {
        if shares.is_empty() {
            self.shares.clear();
            return;
        }
        let mut left = shares.iter().map(|share| {
            if share.is_finite() {
                share.clamp(MIN_LOAD_SHARE, 1.0)
            } else {
                1.0
            }
        });
        let of = |unknown: &FitUnknown| match &unknown.target {
            UnknownTarget::Stiffness(components) if !components.is_empty() => {
                left.by_ref().take(components.len()).sum::<f64>() / components.len() as f64
            }
            _ => 1.0,
        };
        self.shares = self.list.iter().map(of).collect();
    }

    /// Returns the load share of unknown `k`; `None` if the unknown is no stiffness.
    fn share(&self, k: usize) -> Option<f64> {
        let unknown = self.list.get(k)?;
        let stiffness = matches!(unknown.target, UnknownTarget::Stiffness(_));
        stiffness.then(|| self.shares.get(k).copied().unwrap_or(1.0))
    }

    /// Returns the unknowns after a step of the linear model. Unknowns in `x` beyond this list are moved linearly.
    ///
    /// A spring of stiffness `K` acts in parallel to the stiffness `K_s` of the rest of the model, so a unit force deflects it by `1/(K +
    /// K_s)`. Steps of a stiffness are linear in this compliance. With the load share `s = K/(K + K_s)`, the new stiffness is given by `K_new +
    /// K_s = (K + K_s)/(1 - s step)`. For `s = 1` (spring in series) the step is linear in `1/K`; for `s` near 0 (imposed deflection) it is
    /// linear in `K`. This widens the range of the linear model and saves half of the sweeps.
    pub fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let to = |(k, (x, step)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => x + libm::log1p(step / (1.0 - s * step)),
            None => x + step,
        };
        x.iter().zip(step.iter()).enumerate().map(to).collect()
    }

    /// Returns the step with which [`Self::moved`] goes from the unknowns `from` to the unknowns `to`.
    pub(crate) fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        let of = |(k, (from, to)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => step_of(s, to - from),
            None => to - from,
        };
        let steps = from.iter().zip(to).enumerate().map(of);
        DVector::from_iterator(from.len(), steps)
    }

    /// Returns the lower and upper bounds of a step with which no unknown moves by more than `reach` natural units.
    pub fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        let of = |(k, scale): (usize, &f64)| match self.share(k) {
            Some(s) => (step_of(s, -reach), step_of(s, reach)),
            None => (-reach * scale, reach * scale),
        };
        scale.iter().enumerate().map(of).unzip()
    }

    /// Returns the lower and upper bounds of a step from `x` in the step coordinates. `None` if no unknown has bounds. Unknowns in `x` beyond
    /// this list have none.
    pub fn bounds(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.list.iter().all(|unknown| unknown.bounds.is_none()) {
            return None;
        }
        let of = |(k, x): (usize, &f64)| {
            let own = self.list.get(k).and_then(|unknown| unknown.bounds);
            let Some([least, most]) = own else {
                return (f64::NEG_INFINITY, f64::INFINITY);
            };
            match self.share(k) {
                Some(s) => (step_of(s, least - x), step_of(s, most - x)),
                None => (least - x, most - x),
            }
        };
        Some(x.iter().enumerate().map(of).unzip())
    }

    /// Returns the unknown that lies furthest beyond its bound, and that bound. Returns `None` if all are within their bounds. The unknowns
    /// in `held` are ignored.
    pub fn furthest_beyond_bounds(&self, x: &[f64], held: &[(usize, f64)]) -> Option<(usize, f64)> {
        let of = |(k, (unknown, x)): (usize, (&FitUnknown, &f64))| {
            let [least, most] = unknown.bounds?;
            let nearest = x.clamp(least, most);
            let beyond = (x - nearest).abs() / unknown.sd;
            let is_held = held.iter().any(|(own, _)| *own == k);
            (beyond > 0.0 && !is_held).then_some((k, nearest, beyond))
        };
        let all = self.list.iter().zip(x).enumerate().filter_map(of);
        let furthest = all.max_by(|a, b| a.2.total_cmp(&b.2))?;
        Some((furthest.0, furthest.1))
    }

    /// Returns the parameter values of the deck for the values `x` of the unknowns. `deck` holds the values in the deck itself.
    pub fn numbers(&self, deck: &Parameters, x: &[f64]) -> Numbers {
        let mut theta = deck.clone();
        let mut per_case = Vec::new();
        for (unknown, value) in self.list.iter().zip(x) {
            match &unknown.target {
                UnknownTarget::Stiffness(components) => {
                    for component in components {
                        theta.set(component.stiffness, libm::exp(*value));
                    }
                }
                UnknownTarget::Factor(slots) => {
                    for (slot, factor) in slots {
                        theta.set(*slot, theta.get(*slot) * libm::exp(factor * value));
                    }
                }
                UnknownTarget::Number(slots) => {
                    for (slot, factor) in slots {
                        theta.set(*slot, theta.get(*slot) + factor * value);
                    }
                }
                UnknownTarget::PerCase(slots) => {
                    let scaled = |factors: &[f64]| factors.iter().map(|f| f * value).collect();
                    per_case.extend(slots.iter().map(|(slot, factors)| (*slot, scaled(factors))));
                }
                UnknownTarget::Turn(markers) => {
                    for (marker, axis) in markers.iter().filter(|_| *value != 0.0) {
                        theta.turn(*marker, axis, *value);
                    }
                }
                UnknownTarget::Offset(_) => {}
            }
        }
        // Offsets come last, because the preloads depend on the stiffnesses.
        for (unknown, value) in self.list.iter().zip(x) {
            if let UnknownTarget::Offset(Component {
                stiffness,
                preload: Some(preload),
            }) = unknown.target
            {
                theta.set(preload, theta.get(preload) + theta.get(stiffness) * value);
            }
        }
        Numbers {
            theta,
            per_case,
            x: x.to_vec(),
        }
    }

    /// Returns the derivative of the deck parameters with respect to each unknown, at the values `x` of the unknowns. `theta` holds the
    /// parameter values there.
    pub fn directions(&self, theta: &Parameters, x: &[f64]) -> Vec<Direction> {
        let offset_of = |slot: Slot| {
            self.list
                .iter()
                .zip(x)
                .find_map(|(unknown, value)| match unknown.target {
                    UnknownTarget::Offset(Component { stiffness, preload })
                        if stiffness == slot =>
                    {
                        Some((preload, *value))
                    }
                    _ => None,
                })
        };
        let of = |unknown: &FitUnknown| match &unknown.target {
            UnknownTarget::Stiffness(components) => components
                .iter()
                .flat_map(|component| {
                    let K = theta.get(component.stiffness);
                    let preload = offset_of(component.stiffness)
                        .and_then(|(preload, delta0)| Some((preload?, K * delta0)))
                        .filter(|(_, change)| *change != 0.0);
                    std::iter::once((component.stiffness, K)).chain(preload)
                })
                .collect(),
            UnknownTarget::Offset(Component { stiffness, preload }) => preload
                .iter()
                .map(|slot| (*slot, theta.get(*stiffness)))
                .collect(),
            UnknownTarget::Factor(slots) => slots
                .iter()
                .map(|(slot, factor)| (*slot, factor * theta.get(*slot)))
                .collect(),
            UnknownTarget::Number(slots) => slots.clone(),
            UnknownTarget::PerCase(_) | UnknownTarget::Turn(_) => Vec::new(),
        };
        let per_case = |unknown: &FitUnknown| match &unknown.target {
            UnknownTarget::PerCase(slots) => slots.clone(),
            _ => Vec::new(),
        };
        self.list
            .iter()
            .enumerate()
            .map(|(k, unknown)| Direction {
                unknown: k,
                always: of(unknown),
                per_case: per_case(unknown),
                turns: match &unknown.target {
                    UnknownTarget::Turn(markers) => markers.clone(),
                    _ => Vec::new(),
                },
            })
            .collect()
    }
}
