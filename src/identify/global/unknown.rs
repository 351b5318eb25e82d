//! Unknowns of a fit, their priors, and the numbers of the deck they set.
//!
//! Independent of solvers and measurements.

use crate::settings::MIN_LOAD_SHARE;
use nalgebra::DVector;

use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;
use admire_solver::system::{Parameters, Slot};
use admire_syntax::Address;

/// A stiffness of a bushing with the preload along the same axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Component {
    /// Slot of K or KT.
    pub stiffness: Slot,
    /// Slot of FORCE or TORQUE; `None` for stiffnesses of other elements.
    pub preload: Option<Slot>,
}

/// Numbers of the deck that an unknown sets.
#[derive(Clone, PartialEq, Debug)]
pub enum UnknownTarget {
    /// Stiffness: x = ln K of these components, several of them under a symmetry.
    Stiffness(Vec<Component>),
    /// Assembly offset: x = delta0 of equation 9, in length units or radians. The two sides of the bushing are displaced by it in every load
    /// case, so that `F = -K (delta - delta0)` and the preload in the deck becomes `FORCE + K delta0`.
    Offset(Component),
    /// Additive change: `theta = deck + factor * x` for each of these slots.
    Number(Vec<(Slot, f64)>),
    /// Additive change with one factor per load case, such as the gain of a load or a load along another direction.
    PerCase(Vec<(Slot, Vec<f64>)>),
    /// Rotation x, in radians, of markers on their parts, each about its own axis.
    Turn(Vec<(MarkerIx, Vec3)>),
}

/// One unknown of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct FitUnknown {
    /// Addresses of the numbers that the unknown sets.
    pub addresses: Vec<Address>,
    /// Numbers of the deck that the unknown sets, and how.
    pub target: UnknownTarget,
    /// Starting value; ln K for stiffnesses.
    pub start: f64,
    /// Prior mean.
    pub mean: f64,
    /// Prior standard deviation; infinite for no prior.
    pub sd: f64,
}

/// Derivative of theta with respect to one unknown.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Direction {
    /// Index of the unknown among the unknowns of the fit.
    pub unknown: usize,
    /// Slots with the change per unit, the same in every load case.
    pub always: Vec<(Slot, f64)>,
    /// Slots with the change per unit in every load case.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// Markers that rotate by one radian per unit, each about its own axis.
    pub turns: Vec<(MarkerIx, Vec3)>,
}

impl Direction {
    /// Iterates over slots and changes in one load case.
    pub fn in_case(&self, case: usize) -> impl Iterator<Item = (Slot, f64)> + '_ {
        let own = self
            .per_case
            .iter()
            .map(move |(slot, factors)| (*slot, factors[case]));
        self.always.iter().copied().chain(own)
    }
}

/// Numbers of a deck for all load cases, without the loads.
#[derive(Clone, PartialEq, Debug)]
pub struct Numbers {
    /// Numbers that are the same in every load case.
    pub theta: Parameters,
    /// Amounts added to a slot in each load case, after the loads are set.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// Unknowns that the numbers belong to; empty if unspecified.
    pub x: Vec<f64>,
}

/// Unknowns of a fit that set numbers of one deck.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct FitUnknowns {
    list: Vec<FitUnknown>,
    /// Load share of each unknown, if set; otherwise all springs count as being in series.
    shares: Vec<f64>,
}

/// Returns the step of a spring with load share `s` that changes its ln K by `change`.
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

    /// Returns all unknowns in order.
    pub fn list(&self) -> &[FitUnknown] {
        &self.list
    }

    /// Returns the number of unknowns.
    #[expect(clippy::len_without_is_empty, reason = "a fit has unknowns")]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns the starting values.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.list.iter().map(|unknown| unknown.start).collect()
    }

    /// Returns the springs of all stiffness unknowns in order.
    pub fn springs(&self) -> Vec<Component> {
        let of = |unknown: &FitUnknown| match &unknown.target {
            UnknownTarget::Stiffness(components) => components.clone(),
            _ => Vec::new(),
        };
        self.list.iter().flat_map(of).collect()
    }

    /// Sets the load share of each of [`Self::springs`]; an unknown with several springs gets their mean. An empty list resets all springs
    /// to being in series.
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

    /// Returns the load share of unknown `k`; `None` if it is no stiffness.
    fn share(&self, k: usize) -> Option<f64> {
        let unknown = self.list.get(k)?;
        let stiffness = matches!(unknown.target, UnknownTarget::Stiffness(_));
        stiffness.then(|| self.shares.get(k).copied().unwrap_or(1.0))
    }

    /// Returns the unknowns after a step of the linear model; x may hold further unknowns.
    ///
    /// Under a given force, a spring parallel to the stiffness K_s of the rest of the model deflects by 1/(K + K_s). A step of ln K is
    /// linear in this compliance. With the load share s = K/(K + K_s), the new stiffness is given by `K_new + K_s = (K + K_s)/(1 - s step)`.
    /// For s = 1 (in series) the step is linear in 1/K, for s near 0 (imposed deflection) in K. This widens the range of the linear model
    /// and saves half of the sweeps.
    pub fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let to = |(k, (x, step)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => x + libm::log1p(step / (1.0 - s * step)),
            None => x + step,
        };
        x.iter().zip(step.iter()).enumerate().map(to).collect()
    }

    /// Returns the step by which [`Self::moved`] leads from one point to another.
    pub(crate) fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        let of = |(k, (from, to)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => step_of(s, to - from),
            None => to - from,
        };
        let steps = from.iter().zip(to).enumerate().map(of);
        DVector::from_iterator(from.len(), steps)
    }

    /// Returns the lower and upper bounds of a step that moves no unknown by more than `reach` natural units.
    pub fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        let of = |(k, scale): (usize, &f64)| match self.share(k) {
            Some(s) => (step_of(s, -reach), step_of(s, reach)),
            None => (-reach * scale, reach * scale),
        };
        scale.iter().enumerate().map(of).unzip()
    }

    /// Returns the deck's numbers at these unknowns.
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
        // Preloads depend on the stiffnesses, which are all set by now.
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

    /// Returns the derivative of theta with respect to each unknown, at these unknowns.
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
