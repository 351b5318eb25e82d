//! What a fit may change: unknowns, their priors, and the numbers of the deck they set.
//!
//! Knows neither solvers nor measurements.

use nalgebra::DVector;

use admire_solver::mechanics::Vec3;
use admire_solver::model::MarkerIx;
use admire_solver::system::{Parameters, Slot};
use admire_syntax::Address;

/// A stiffness of a bushing with the preload of the same direction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Component {
    /// K or KT.
    pub stiffness: Slot,
    /// FORCE or TORQUE; `None` for stiffnesses of other elements.
    pub preload: Option<Slot>,
}

/// What one unknown sets.
#[derive(Clone, PartialEq, Debug)]
pub enum Target {
    /// x = ln K of these components (several under a symmetry).
    Stiffness(Vec<Component>),
    /// x = delta0 of equation 9 in length units or radians: the bushing's two sides sit displaced by it in every load case, so
    /// that `F = -K (delta - delta0)` and the preload in the deck is `FORCE + K delta0`.
    Offset(Component),
    /// `theta = deck + factor * x` for each of these slots.
    Number(Vec<(Slot, f64)>),
    /// The same with a factor for every load case: a load's gain, a load along another direction.
    PerCase(Vec<(Slot, Vec<f64>)>),
    /// x in radians by which markers turn on their parts, each about an axis of its own.
    Turn(Vec<(MarkerIx, Vec3)>),
}

/// One unknown of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct FitUnknown {
    /// Addresses of the numbers it stands for.
    pub addresses: Vec<Address>,
    /// What it sets.
    pub target: Target,
    /// Where it starts; for stiffnesses ln K.
    pub start: f64,
    /// Prior mean.
    pub mean: f64,
    /// Prior standard deviation; infinite for none.
    pub sd: f64,
}

/// A direction in theta: slots and the change of each per unit of an unknown.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Direction {
    /// The place of the unknown among those of the fit.
    pub unknown: usize,
    /// The same in every load case.
    pub always: Vec<(Slot, f64)>,
    /// One factor for every load case.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// Markers that turn, about axes of their own.
    pub turns: Vec<(MarkerIx, Vec3)>,
}

impl Direction {
    /// Slots and changes in one load case.
    pub fn in_case(&self, case: usize) -> impl Iterator<Item = (Slot, f64)> + '_ {
        let own = self
            .per_case
            .iter()
            .map(move |(slot, factors)| (*slot, factors[case]));
        self.always.iter().copied().chain(own)
    }
}

/// The numbers of a deck for every load case, the loads apart.
#[derive(Clone, PartialEq, Debug)]
pub struct Numbers {
    /// The same in every load case.
    pub theta: Parameters,
    /// What is added to a slot in each load case, after the loads are set.
    pub per_case: Vec<(Slot, Vec<f64>)>,
    /// The unknowns these belong to; empty if nobody says.
    pub x: Vec<f64>,
}

/// The unknowns of a fit over the numbers of one deck.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct FitUnknowns {
    list: Vec<FitUnknown>,
    /// Load share of each stiffness where it was asked for; springs in series else.
    shares: Vec<f64>,
}

/// The step of a spring with share `s` that changes its ln K by `change`.
fn step_of(s: f64, change: f64) -> f64 {
    libm::expm1(change) / (1.0 + s * libm::expm1(change))
}

/// Shares below this are round-off.
const LEAST_SHARE: f64 = 1e-4;

impl FitUnknowns {
    /// A list of unknowns.
    pub fn new(list: Vec<FitUnknown>) -> Self {
        Self {
            list,
            shares: Vec::new(),
        }
    }

    /// All of them, in order.
    pub fn list(&self) -> &[FitUnknown] {
        &self.list
    }

    /// How many.
    #[expect(clippy::len_without_is_empty, reason = "a fit has unknowns")]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Where a fit starts.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.list.iter().map(|unknown| unknown.start).collect()
    }

    /// The springs of all stiffnesses, in order.
    pub fn springs(&self) -> Vec<Component> {
        let of = |unknown: &FitUnknown| match &unknown.target {
            Target::Stiffness(components) => components.clone(),
            _ => Vec::new(),
        };
        self.list.iter().flat_map(of).collect()
    }

    /// Takes the load share of each of [`Self::springs`]; several springs of one unknown count by their mean. None at all where the
    /// backend knows none: then all count as springs in series.
    pub fn set_load_shares(&mut self, shares: &[f64]) {
        if shares.is_empty() {
            self.shares.clear();
            return;
        }
        let mut left = shares.iter().map(|share| {
            if share.is_finite() {
                share.clamp(LEAST_SHARE, 1.0)
            } else {
                1.0
            }
        });
        let of = |unknown: &FitUnknown| match &unknown.target {
            Target::Stiffness(components) if !components.is_empty() => {
                left.by_ref().take(components.len()).sum::<f64>() / components.len() as f64
            }
            _ => 1.0,
        };
        self.shares = self.list.iter().map(of).collect();
    }

    /// The load share of unknown `k`; `None` if it is no stiffness.
    fn share(&self, k: usize) -> Option<f64> {
        let unknown = self.list.get(k)?;
        let stiffness = matches!(unknown.target, Target::Stiffness(_));
        stiffness.then(|| self.shares.get(k).copied().unwrap_or(1.0))
    }

    /// Where a step of a linear model leads; x may hold more than these unknowns.
    ///
    /// A spring beside which the rest of the model resists with K_s deflects by 1/(K + K_s) under a given force. A step of ln K is
    /// made in that, with the share s = K/(K + K_s): `K_+ + K_s = (K + K_s)/(1 - s step)`. In series, s = 1, that is linear in 1/K;
    /// for springs that others hold, s near 0, in K. It makes the linear model good far away: half of the sweeps are saved.
    pub fn moved(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let to = |(k, (x, step)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => x + libm::log1p(step / (1.0 - s * step)),
            None => x + step,
        };
        x.iter().zip(step.iter()).enumerate().map(to).collect()
    }

    /// The step that [`Self::moved`] leads from one place to another.
    pub(crate) fn step_to(&self, from: &[f64], to: &[f64]) -> DVector<f64> {
        let of = |(k, (from, to)): (usize, (&f64, &f64))| match self.share(k) {
            Some(s) => step_of(s, to - from),
            None => to - from,
        };
        let steps = from.iter().zip(to).enumerate().map(of);
        DVector::from_iterator(from.len(), steps)
    }

    /// Lower and upper bound of a step that moves no unknown by more than `reach` natural units.
    pub fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        let of = |(k, scale): (usize, &f64)| match self.share(k) {
            Some(s) => (step_of(s, -reach), step_of(s, reach)),
            None => (-reach * scale, reach * scale),
        };
        scale.iter().enumerate().map(of).unzip()
    }

    /// The deck's numbers at these unknowns.
    pub fn numbers(&self, deck: &Parameters, x: &[f64]) -> Numbers {
        let mut theta = deck.clone();
        let mut per_case = Vec::new();
        for (unknown, value) in self.list.iter().zip(x) {
            match &unknown.target {
                Target::Stiffness(components) => {
                    for component in components {
                        theta.set(component.stiffness, libm::exp(*value));
                    }
                }
                Target::Number(slots) => {
                    for (slot, factor) in slots {
                        theta.set(*slot, theta.get(*slot) + factor * value);
                    }
                }
                Target::PerCase(slots) => {
                    let scaled = |factors: &[f64]| factors.iter().map(|f| f * value).collect();
                    per_case.extend(slots.iter().map(|(slot, factors)| (*slot, scaled(factors))));
                }
                Target::Turn(markers) => {
                    for (marker, axis) in markers.iter().filter(|_| *value != 0.0) {
                        theta.turn(*marker, axis, *value);
                    }
                }
                Target::Offset(_) => {}
            }
        }
        // Preloads follow the stiffnesses, which are all set by now.
        for (unknown, value) in self.list.iter().zip(x) {
            if let Target::Offset(Component {
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

    /// For each unknown the change of theta per unit of it, at these unknowns.
    pub fn directions(&self, theta: &Parameters, x: &[f64]) -> Vec<Direction> {
        let offset_of = |slot: Slot| {
            self.list
                .iter()
                .zip(x)
                .find_map(|(unknown, value)| match unknown.target {
                    Target::Offset(Component { stiffness, preload }) if stiffness == slot => {
                        Some((preload, *value))
                    }
                    _ => None,
                })
        };
        let of = |unknown: &FitUnknown| match &unknown.target {
            Target::Stiffness(components) => components
                .iter()
                .flat_map(|component| {
                    let K = theta.get(component.stiffness);
                    let preload = offset_of(component.stiffness)
                        .and_then(|(preload, delta0)| Some((preload?, K * delta0)))
                        .filter(|(_, change)| *change != 0.0);
                    std::iter::once((component.stiffness, K)).chain(preload)
                })
                .collect(),
            Target::Offset(Component { stiffness, preload }) => preload
                .iter()
                .map(|slot| (*slot, theta.get(*stiffness)))
                .collect(),
            Target::Number(slots) => slots.clone(),
            Target::PerCase(_) | Target::Turn(_) => Vec::new(),
        };
        let per_case = |unknown: &FitUnknown| match &unknown.target {
            Target::PerCase(slots) => slots.clone(),
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
                    Target::Turn(markers) => markers.clone(),
                    _ => Vec::new(),
                },
            })
            .collect()
    }
}
