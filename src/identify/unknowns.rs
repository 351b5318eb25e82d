use std::collections::BTreeMap;

use crate::SetNumber;
use crate::settings::{AT_BOUND_SHARE, BOUND_LN_DISTANCE, SAME_CHANGE_ROUND_OFF};
use admire_solver::model::Model;
use admire_study::settings::{IdentifySettings, Initial, Symmetry};
use admire_study::{Study, did_you_mean};
use admire_syntax::Address;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;
use nalgebra::{DMatrix, DVector};

/// Location of an unknown in the deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    /// A stiffness of a bushing.
    Bushing {
        /// Index into [`Model::bushings`].
        bushing: usize,
        /// Axis 0 to 5: Kx, Ky, Kz, KTx, KTy, KTz.
        axis: usize,
    },
    /// A parameter of the deck that is not a bushing stiffness.
    Number,
}

/// Rule by which an unknown sets numbers of the deck. It also determines the coordinate of the fit.
#[derive(Clone, PartialEq, Debug)]
pub enum Assignment {
    /// The number at the address of the unknown equals the unknown. So do the numbers at these addresses, such as Ky of a round bushing in
    /// addition to its Kx. The coordinate is the logarithm of the value.
    Equal(Vec<Address>),
    /// Each number is its value in the deck times a power of the unknown. The exponent is the factor of the number. The coordinate is the
    /// logarithm of the value.
    Factor(Vec<SetNumber>),
    /// Each number is its value in the deck plus the unknown times the factor of the number. The coordinate is the value in units of `sd`.
    Change {
        /// Numbers that the unknown sets.
        numbers: Vec<SetNumber>,
        /// Prior standard deviation of the unknown, in the unit of the unknown.
        sd: f64,
    },
}

/// A parameter of the deck to identify.
#[derive(Clone, PartialEq, Debug)]
pub struct Unknown {
    /// Address of the parameter, as the study names it. `MARKER/7.QP.2` is a hardpoint along y of ground.
    pub address: Address,
    /// Numbers of the deck that the unknown sets.
    pub assignment: Assignment,
    /// Location of the parameter in the deck.
    pub place: Place,
    /// Unit of the parameter, spelled as in the result files; empty for a factor.
    pub unit: String,
    /// Value at which the identification starts.
    pub initial: f64,
    /// Value of the unknown at which the deck is unchanged.
    pub deck: f64,
    /// Prior mean of the coordinate; `None` for the coordinate of the initial value.
    pub mean: Option<f64>,
    /// Prior standard deviation of the coordinate; `None` for the standard deviation that the study states for all unknowns.
    pub sd: Option<f64>,
    /// Lower and upper bound of the coordinate.
    pub bounds: Option<[f64; 2]>,
}

impl Unknown {
    /// Returns the addresses and new values of the numbers that the unknown sets, if it has this value.
    pub(crate) fn assign(&self, value: f64) -> Vec<(Address, f64)> {
        let each = |numbers: &[SetNumber], of: &dyn Fn(&SetNumber) -> f64| {
            let numbers = numbers.iter();
            numbers.map(|own| (own.address.clone(), of(own))).collect()
        };
        match &self.assignment {
            Assignment::Equal(tied) => {
                let all = std::iter::once(&self.address).chain(tied);
                all.map(|address| (address.clone(), value)).collect()
            }
            Assignment::Factor(numbers) => {
                each(numbers, &|own| own.deck * libm::pow(value, own.factor))
            }
            Assignment::Change { numbers, .. } => {
                each(numbers, &|own| own.deck + own.factor * value)
            }
        }
    }

    /// Returns the value of the unknown at a coordinate of the fit.
    pub fn value(&self, x: f64) -> f64 {
        match self.assignment {
            Assignment::Equal(_) | Assignment::Factor(_) => libm::exp(x),
            Assignment::Change { sd, .. } => sd * x,
        }
    }

    /// Returns the derivative of the value with respect to the coordinate of the fit.
    pub fn value_rate(&self, x: f64) -> f64 {
        match self.assignment {
            Assignment::Equal(_) | Assignment::Factor(_) => libm::exp(x),
            Assignment::Change { sd, .. } => sd,
        }
    }

    /// Returns the coordinate of the fit for a value of the unknown. A value without a logarithm is replaced by 1 in the unit of the
    /// unknown.
    pub fn coordinate(&self, value: f64) -> f64 {
        match self.assignment {
            Assignment::Equal(_) | Assignment::Factor(_) if value > 0.0 => libm::log(value),
            Assignment::Equal(_) | Assignment::Factor(_) => 0.0,
            Assignment::Change { sd, .. } => value / sd,
        }
    }

    /// Returns true if the coordinate of the fit is the logarithm of the value.
    pub fn is_logarithm(&self) -> bool {
        !matches!(self.assignment, Assignment::Change { .. })
    }

    /// Returns true if a coordinate lies at a bound that the study states. Also returns true if a logarithm is so far from its prior mean
    /// that the value is implausible for an axle.
    pub fn is_at_bound(&self, x: f64, mean: f64) -> bool {
        let is_stated = self.bounds.is_some_and(|bounds| {
            // A lower bound of zero has no logarithm: the distance of the bounds is infinite.
            let near = AT_BOUND_SHARE * (bounds[1] - bounds[0]).min(1.0);
            bounds.iter().any(|bound| (x - bound).abs() <= near)
        });
        is_stated || (self.is_logarithm() && (x - mean).abs() >= BOUND_LN_DISTANCE)
    }

    /// Returns `change` or `factor` if the unknown changes or scales numbers of the deck; `None` if it is a number of the deck itself.
    pub const fn form(&self) -> Option<&'static str> {
        match self.assignment {
            Assignment::Equal(_) => None,
            Assignment::Factor(_) => Some("factor"),
            Assignment::Change { .. } => Some("change"),
        }
    }

    /// Returns the addresses of the numbers that symmetry makes equal to the number of the unknown.
    pub fn tied(&self) -> &[Address] {
        match &self.assignment {
            Assignment::Equal(tied) => tied,
            Assignment::Factor(_) | Assignment::Change { .. } => &[],
        }
    }

    /// Returns the numbers that the unknown changes or scales; empty if the unknown is a number of the deck itself.
    pub fn changed_numbers(&self) -> &[SetNumber] {
        match &self.assignment {
            Assignment::Equal(_) => &[],
            Assignment::Factor(numbers) | Assignment::Change { numbers, .. } => numbers,
        }
    }

    /// Returns true if the unknown sets the number at this address.
    pub fn sets(&self, address: &Address) -> bool {
        match &self.assignment {
            Assignment::Equal(tied) => self.address == *address || tied.contains(address),
            Assignment::Factor(numbers) | Assignment::Change { numbers, .. } => {
                numbers.iter().any(|own| own.address == *address)
            }
        }
    }

    /// Returns true if the unknown includes a change of the deck by an error of the axle. `change` lists the numbers that the error
    /// changes, and the amounts. The unknown may change further numbers.
    pub fn includes(&self, change: &[(Address, f64)]) -> bool {
        let Assignment::Change { numbers, .. } = &self.assignment else {
            return false;
        };
        let mut ratios = change.iter().map(|(address, amount)| {
            let own = numbers.iter().find(|own| own.address == *address)?;
            Some(amount / own.factor)
        });
        let Some(Some(first)) = ratios.next() else {
            return false;
        };
        let near = |ratio: f64| (ratio / first - 1.0).abs() < SAME_CHANGE_ROUND_OFF;
        ratios.all(|ratio| ratio.is_some_and(near))
    }

    /// Returns the bushing stiffnesses that this unknown sets, as (bushing, axis) pairs. There are two pairs if x and y are tied, otherwise
    /// one. The list is empty for a parameter that is not a bushing stiffness.
    pub fn axes(&self) -> Vec<(usize, usize)> {
        match self.place {
            Place::Number => Vec::new(),
            Place::Bushing { bushing, axis } => (0..=self.tied().len())
                .map(|k| (bushing, axis + k))
                .collect(),
        }
    }
}

/// Returns the addresses and new values of the numbers that the unknowns set. If several unknowns change the same number, their changes are
/// added.
pub(crate) fn assigned(
    unknowns: &[Unknown],
    values: impl IntoIterator<Item = f64>,
) -> Vec<(Address, f64)> {
    let mut all: Vec<(Address, f64)> = Vec::new();
    for (unknown, value) in unknowns.iter().zip(values) {
        let own = unknown.assign(value);
        let Assignment::Change { numbers, .. } = &unknown.assignment else {
            all.extend(own);
            continue;
        };
        for (number, (address, value)) in numbers.iter().zip(own) {
            match all.iter_mut().find(|known| known.0 == address) {
                Some(known) => known.1 += value - number.deck,
                None => all.push((address, value)),
            }
        }
    }
    all
}

/// Returns the values of the unknowns that best reproduce the numbers of another deck, in the least-squares sense. A value is `None` if the
/// deck lacks a number of the unknown, or if an unknown that is a factor would have to be zero or negative.
pub(crate) fn values_in(
    unknowns: &[Unknown],
    number: impl Fn(&Address) -> Option<f64>,
) -> Vec<Option<f64>> {
    // Several unknowns may change one number.
    let mut places: BTreeMap<&Address, usize> = BTreeMap::new();
    let (mut changes, mut moved) = (Vec::new(), Vec::new());
    let mut values: Vec<Option<f64>> = Vec::new();
    for unknown in unknowns {
        values.push(match &unknown.assignment {
            Assignment::Equal(_) => number(&unknown.address),
            Assignment::Factor(numbers) => factor_in(numbers, &number),
            Assignment::Change { .. } => None,
        });
        if let Assignment::Change { numbers, .. } = &unknown.assignment {
            let is_known = numbers.iter().all(|own| number(&own.address).is_some());
            for own in numbers.iter().filter(|_| is_known) {
                places.entry(&own.address).or_insert_with(|| {
                    moved.push(number(&own.address).unwrap_or_default() - own.deck);
                    moved.len() - 1
                });
            }
            if is_known {
                changes.push((values.len() - 1, numbers));
            }
        }
    }
    if changes.is_empty() {
        return values;
    }
    let mut factors = DMatrix::zeros(moved.len(), changes.len());
    for (column, (_, numbers)) in changes.iter().enumerate() {
        for own in *numbers {
            factors[(places[&own.address], column)] += own.factor;
        }
    }
    let round_off = f64::EPSILON * factors.norm() * factors.nrows() as f64;
    let solved = factors
        .svd(true, true)
        .solve(&DVector::from_vec(moved), round_off);
    if let Ok(solved) = solved {
        for ((at, _), value) in changes.iter().zip(solved.iter()) {
            values[*at] = Some(*value);
        }
    }
    values
}

/// Returns the common factor that best reproduces the numbers of another deck.
fn factor_in(numbers: &[SetNumber], number: impl Fn(&Address) -> Option<f64>) -> Option<f64> {
    let (mut above, mut below) = (0.0, 0.0);
    for own in numbers {
        let ratio = number(&own.address)? / own.deck;
        if ratio <= 0.0 {
            return None;
        }
        above += own.factor * libm::log(ratio);
        below += own.factor * own.factor;
    }
    Some(libm::exp(above / below))
}

/// Returns true if several unknowns change points of the same SPLINE, as the unknowns of a smooth change do.
pub(crate) fn share_a_spline(unknowns: &[Unknown]) -> bool {
    let is_shared =
        |unknown: &Unknown| unknown.address.kind == "SPLINE" && unknown.changed_numbers().len() > 1;
    let mut ids: Vec<Option<u32>> = Vec::new();
    for unknown in unknowns.iter().filter(|unknown| is_shared(unknown)) {
        if ids.contains(&unknown.address.id) {
            return true;
        }
        ids.push(unknown.address.id);
    }
    false
}

/// Returns the address of a bushing parameter. The first of `words` is the argument for axes 0 to 2, the second for axes 3 to 5.
pub(crate) fn bushing_number(id: u32, words: [&str; 2], axis: usize) -> Address {
    Address {
        kind: "BUSHING".to_string(),
        id: Some(id),
        argument: Some(words[axis / 3].to_string()),
        index: Some(axis % 3 + 1),
    }
}

/// Returns the address of a bushing stiffness: argument `K` for axes 0 to 2, argument `KT` for axes 3 to 5.
pub(crate) fn stiffness(id: u32, axis: usize) -> Address {
    bushing_number(id, ["K", "KT"], axis)
}

/// Returns the index of the bushing in the model, found by its address, id or view name.
fn bushing(name: &str, model: &Model) -> Option<usize> {
    let name = name.trim();
    let id = match name.split_once('/') {
        Some((kind, id)) => {
            let kind = kind.trim().to_uppercase();
            let known = kind.len() >= 2 && "BUSHING".starts_with(&kind);
            known.then(|| id.trim().parse::<u32>().ok()).flatten()
        }
        None => name.parse().ok(),
    };
    model.bushings.iter().position(|bushing| match id {
        Some(id) => bushing.header.id == id,
        None => bushing.header.name.eq_ignore_ascii_case(name),
    })
}

/// Returns the unknowns that a study selects: the bushing stiffnesses bushing by bushing, then the other parameters. `number` looks up a
/// parameter that is not a bushing stiffness and returns its address, value and dimension.
///
/// For each address that matches nothing in the deck, an error with its position in `study.toml` is added to `out`.
pub fn unknowns(
    study: &Study,
    model: &Model,
    number: impl Fn(&str) -> Option<(Address, f64, Dimension)>,
    out: &mut Vec<Diagnostic>,
) -> Vec<Unknown> {
    let settings = &study.identify;
    let bushings: Vec<String> = model
        .bushings
        .iter()
        .flat_map(|found| {
            [
                format!("BUSHING/{}", found.header.id),
                found.header.name.clone(),
            ]
        })
        .filter(|name| !name.is_empty())
        .collect();
    let mut missing = |text: &str, span, what: &str| {
        let help = if what == "BUSHING" {
            did_you_mean(text, "the deck", &bushings)
        } else {
            "write the address of a number, such as SPRINGDAMPER/1.K or BEAM/2.E; `admire get` lists them"
                .to_string()
        };
        out.push(
            Diagnostic::error(
                Code::UnknownTarget,
                format!("`{text}` is not a {what} of the deck"),
            )
            .label(study.source.name(), span, "")
            .help(help),
        );
    };
    let mut chosen = Vec::new();
    match &settings.bushings {
        None => chosen.extend(0..model.bushings.len()),
        Some(names) => {
            for name in names {
                match bushing(&name.text, model) {
                    Some(at) if !chosen.contains(&at) => chosen.push(at),
                    Some(_) => {}
                    None => missing(&name.text, name.span, "BUSHING"),
                }
            }
        }
    }
    let mut round: Vec<bool> = vec![settings.symmetry == Symmetry::RadialZ; model.bushings.len()];
    for (name, symmetry) in &settings.symmetry_of {
        match bushing(&name.text, model) {
            Some(at) => round[at] = *symmetry == Symmetry::RadialZ,
            None => missing(&name.text, name.span, "BUSHING"),
        }
    }
    let mut unknowns = Vec::new();
    for at in chosen {
        unknowns.extend(of_bushing(settings, model, at, round[at]));
    }
    for name in &settings.stiffnesses {
        match number(&name.text) {
            Some((address, deck, dimension)) => unknowns.push(Unknown {
                address,
                assignment: Assignment::Equal(Vec::new()),
                place: Place::Number,
                unit: model.units.name(dimension),
                initial: deck,
                deck,
                mean: None,
                sd: None,
                bounds: None,
            }),
            None => missing(&name.text, name.span, "number"),
        }
    }
    unknowns
}

/// Dimension of a translational stiffness: force per length.
const STIFFNESS: Dimension = Dimension::new(1, 0, -1, 0, 0);

fn of_bushing(settings: &IdentifySettings, model: &Model, at: usize, round: bool) -> Vec<Unknown> {
    let bushing = &model.bushings[at];
    let axes: &[usize] = if round {
        &[0, 2, 3, 5]
    } else {
        &[0, 1, 2, 3, 4, 5]
    };
    let unknown = |&axis: &usize| {
        let deck = if axis < 3 {
            bushing.k[axis]
        } else {
            bushing.kt[axis - 3]
        };
        let (dimension, value) = if axis < 3 {
            let value = match settings.initial {
                Initial::Deck => deck,
                Initial::Values { translational, .. } => {
                    translational.in_units(&model.units, STIFFNESS)
                }
            };
            (STIFFNESS, value)
        } else {
            let value = match settings.initial {
                Initial::Deck => deck,
                Initial::Values {
                    rotational_per_degree,
                    ..
                } => {
                    let value = rotational_per_degree.in_units(&model.units, Dimension::TORQUE);
                    value.to_degrees()
                }
            };
            (Dimension::new(1, 0, 1, 0, -1), value)
        };
        let tied = round && axis % 3 == 0;
        Unknown {
            address: stiffness(bushing.header.id, axis),
            assignment: Assignment::Equal(if tied {
                vec![stiffness(bushing.header.id, axis + 1)]
            } else {
                Vec::new()
            }),
            place: Place::Bushing { bushing: at, axis },
            unit: model.units.name(dimension),
            initial: value,
            deck,
            mean: None,
            sd: None,
            bounds: None,
        }
    };
    axes.iter().map(unknown).collect()
}
