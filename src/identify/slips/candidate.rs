//! Possible slips in the input of a study, each represented by the change that would correct it.

use super::unit_pairs::{UnitPair, angles, forces, lengths, stiffnesses, torsional};
use crate::LoadedStudy;
use crate::settings::LOAD_SIDE_MM;
use crate::tolerance::{Effect, acts_at};
use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, SpringKind};
use admire_study::Measurement;
use admire_syntax::Address;

/// A change of the input of a study.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Change {
    /// Multiplies the load columns with these indices by a factor.
    Loads(Vec<usize>, f64),
    /// Exchanges the two load columns with these indices.
    Exchange(usize, usize),
    /// Sets parameters of the deck to these values.
    Numbers(Vec<(Address, f64)>),
    /// Multiplies the readings of the channel with this index by a factor.
    Channel(usize, f64),
}

impl Change {
    /// Returns the load programme after the change.
    pub(super) fn programme(&self, of: &LoadProgramme) -> LoadProgramme {
        let mut new = of.clone();
        for case in &mut new.cases {
            match self {
                Self::Loads(columns, factor) => {
                    for column in columns {
                        case.values[*column] *= factor;
                    }
                }
                Self::Exchange(a, b) => case.values.swap(*a, *b),
                Self::Numbers(_) | Self::Channel(..) => {}
            }
        }
        new
    }

    /// Returns the measurement after the change.
    pub(super) fn measurement(&self, of: &Measurement) -> Measurement {
        let mut new = of.clone();
        if let Self::Channel(channel, factor) = self {
            let values = new
                .cases
                .iter_mut()
                .map(|case| &mut case.channels[*channel]);
            values.flatten().for_each(|value| *value *= factor);
        }
        new
    }

    /// Returns the deck parameters that the change sets, with their values; empty for other kinds of changes.
    pub(super) fn numbers(&self) -> &[(Address, f64)] {
        match self {
            Self::Numbers(numbers) => numbers,
            _ => &[],
        }
    }
}

/// A possible slip in the input.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Candidate {
    /// Description of the correction, without a full stop.
    pub remedy: String,
    /// Change that corrects the slip.
    pub change: Change,
}

/// Possible slips that concern the same quantity, such as one load column.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Family {
    /// Possible slips of the quantity.
    pub candidates: Vec<Candidate>,
    /// Effect on the deck of multiplying the quantity by a factor near one; `None` for slips that are not factors.
    pub by_factor: Option<Effect>,
    /// True if the quantity is a stiffness of a bushing. A deck may have many of them, so their number is limited.
    pub is_of_a_bushing: bool,
}

/// Returns all possible slips of a study, grouped by quantity.
pub(super) fn families(study: &LoadedStudy) -> Vec<Family> {
    let mut out = loads(study);
    out.extend(exchanges(study));
    out.extend(springs(study));
    out.extend(bushings(study));
    out.extend(load_points(study));
    out.extend(channels(study));
    out.retain(|family| !family.candidates.is_empty());
    out
}

/// Formats a positive factor with four significant digits.
fn four_digits(factor: f64) -> String {
    let digits = 3 - libm::log10(factor).floor() as i32;
    let text = format!("{factor:.*}", digits.max(0) as usize);
    if digits <= 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Returns one candidate for each unit pair, which multiplies the quantity `what` by the factor of the pair.
fn scaled(
    what: &str,
    pairs: &[UnitPair],
    change: impl Fn(f64) -> Change,
) -> impl Iterator<Item = Candidate> {
    pairs.iter().map(move |pair| Candidate {
        remedy: format!(
            "{what} multiplied by {}, as if stated in {}",
            four_digits(pair.factor),
            pair.unit
        ),
        change: change(pair.factor),
    })
}

/// Returns the indices of the load columns that are nonzero in at least one case.
pub(super) fn acting(programme: &LoadProgramme) -> Vec<usize> {
    let acts = |k: &usize| programme.cases.iter().any(|case| case.values[*k] != 0.0);
    (0..programme.loads.len()).filter(acts).collect()
}

/// Returns the possible slips of each load column with nonzero loads, and of all force columns together.
fn loads(study: &LoadedStudy) -> Vec<Family> {
    let (programme, units) = (&study.programme, &study.model.units);
    let columns = acting(programme);
    let is_force = |k: &usize| acts_at(&study.model, &programme.loads[*k].target).is_some();
    let family = |name: &str, columns: &[usize], pairs: &[UnitPair]| {
        let change = |factor: f64| Change::Loads(columns.to_vec(), factor);
        let mut candidates = vec![Candidate {
            remedy: format!("{name} with the opposite sign"),
            change: change(-1.0),
        }];
        candidates.extend(scaled(name, pairs, change));
        let values = |k: usize| programme.cases.iter().map(|case| case.values[k]).collect();
        let targets = columns.iter();
        let by = targets.map(|k| (programme.loads[*k].target.clone(), values(*k)));
        Family {
            candidates,
            by_factor: Some(Effect::PerCase(by.collect())),
            is_of_a_bushing: false,
        }
    };
    let mut out = Vec::new();
    for k in &columns {
        let load = &programme.loads[*k];
        let pairs = if is_force(k) {
            forces(units)
        } else if load.name.ends_with("_deg") {
            angles()
        } else {
            lengths(units)
        };
        let name = format!("the load column `{}`", load.name);
        out.push(family(&name, &[*k], &pairs));
    }
    let together: Vec<usize> = columns.into_iter().filter(is_force).collect();
    if together.len() > 1 {
        out.push(family("all force columns", &together, &forces(units)));
    }
    out
}

/// Returns one candidate for each pair of force columns that act at the same point: the exchange of the two columns.
fn exchanges(study: &LoadedStudy) -> Vec<Family> {
    let programme = &study.programme;
    let columns = acting(programme);
    let point = |k: usize| acts_at(&study.model, &programme.loads[k].target);
    let mut out = Vec::new();
    for (at, a) in columns.iter().enumerate() {
        for b in &columns[at + 1..] {
            if point(*a).is_none() || point(*a) != point(*b) {
                continue;
            }
            let [first, second] = [a, b].map(|k| &programme.loads[*k].name);
            out.push(Family {
                candidates: vec![Candidate {
                    remedy: format!("the load columns `{first}` and `{second}` exchanged"),
                    change: Change::Exchange(*a, *b),
                }],
                by_factor: None,
                is_of_a_bushing: false,
            });
        }
    }
    out
}

/// Returns true if the parameter at this address is identified.
fn is_sought(study: &LoadedStudy, address: &Address) -> bool {
    let mut unknowns = study.unknowns.iter();
    unknowns.any(|unknown| unknown.sets(address))
}

/// Returns the possible slips of deck parameters that are scaled together. The result is empty if one of the parameters is identified or all
/// are zero.
fn of_numbers(
    study: &LoadedStudy,
    what: &str,
    numbers: &[(Address, f64)],
    pairs: &[UnitPair],
) -> Family {
    let acting: Vec<(Address, f64)> = numbers.iter().filter(|n| n.1 != 0.0).cloned().collect();
    if acting.is_empty() || acting.iter().any(|(address, _)| is_sought(study, address)) {
        return Family::default();
    }
    let change = |factor: f64| {
        let scaled = |(address, value): &(Address, f64)| (address.clone(), value * factor);
        Change::Numbers(acting.iter().map(scaled).collect())
    };
    Family {
        candidates: scaled(what, pairs, change).collect(),
        by_factor: Some(Effect::Always(acting.clone())),
        is_of_a_bushing: acting.iter().any(|(address, _)| address.kind == "BUSHING"),
    }
}

/// Returns the possible slips of spring rates and spring forces.
fn springs(study: &LoadedStudy) -> Vec<Family> {
    let units = &study.model.units;
    let of = |spring: &admire_solver::model::SpringDamper| {
        let id = spring.header.id;
        let (rate, force, pairs) = match spring.kind {
            SpringKind::Translational => ("K", "FORCE", stiffnesses(units)),
            SpringKind::Rotational => ("KT", "TORQUE", torsional(units)),
        };
        let family = |argument: &str, value: f64, pairs: &[UnitPair]| {
            let address = Address::of_argument("SPRINGDAMPER", id, argument, None);
            let what = format!("{address} = {value}");
            of_numbers(study, &what, &[(address, value)], pairs)
        };
        [
            family(rate, spring.stiffness, &pairs),
            family(force, spring.preload, &forces(units)),
        ]
    };
    let springs = study.model.springdampers.iter();
    springs.filter(|s| s.header.active).flat_map(of).collect()
}

/// Returns the possible slips of bushing stiffnesses that are not identified.
fn bushings(study: &LoadedStudy) -> Vec<Family> {
    let units = &study.model.units;
    let of = |bushing: &admire_solver::model::Bushing| {
        let id = bushing.header.id;
        let numbers = |argument: &str, values: [f64; 3]| -> Vec<(Address, f64)> {
            let values = values.into_iter().enumerate();
            values
                .map(|(k, value)| {
                    (
                        Address::of_argument("BUSHING", id, argument, Some(k + 1)),
                        value,
                    )
                })
                .collect()
        };
        let (k, kt) = (numbers("K", bushing.k), numbers("KT", bushing.kt));
        let both = [k.clone(), kt.clone()].concat();
        let thousand: Vec<UnitPair> = [(1e3, "thousands"), (1e-3, "thousandths")]
            .map(|(factor, unit)| UnitPair {
                factor,
                unit: unit.to_string(),
            })
            .to_vec();
        [
            of_numbers(study, &format!("BUSHING/{id}.K"), &k, &stiffnesses(units)),
            of_numbers(study, &format!("BUSHING/{id}.KT"), &kt, &torsional(units)),
            of_numbers(
                study,
                &format!("K and KT of BUSHING/{id}"),
                &both,
                &thousand,
            ),
        ]
    };
    let bushings = study.model.bushings.iter();
    bushings.filter(|b| b.header.active).flat_map(of).collect()
}

/// Returns the possible slips of load points: positions mirrored in a coordinate plane of ground or of the part.
fn load_points(study: &LoadedStudy) -> Vec<Family> {
    let model = &study.model;
    let mut seen: Vec<MarkerIx> = Vec::new();
    for load in &study.programme.loads {
        let marker = acts_at(model, &load.target);
        seen.extend(marker.filter(|marker| !seen.contains(marker)));
    }
    let near = LOAD_SIDE_MM * 1e-3 / model.units.length.si;
    let of = |marker: MarkerIx| {
        let own = &model.markers[marker.0];
        let pose = &model.parts[own.part.0].pose;
        let x = pose.point(&own.qp);
        let turned = |of: &Vec3, axis: usize| {
            let mut new = *of;
            new[axis] = -new[axis];
            new
        };
        let mut places: Vec<(&str, usize, Vec3)> = Vec::new();
        for axis in 0..3 {
            if x[axis].abs() > near {
                let local = pose.R.transpose() * (turned(&x, axis) - pose.p);
                places.push(("ground", axis, local));
            }
            if own.qp[axis].abs() > near {
                places.push(("part", axis, turned(&own.qp, axis)));
            }
        }
        let id = own.header.id;
        let candidate = |(frame, axis, qp): (&str, usize, Vec3)| {
            let numbers =
                (0..3).map(|k| (Address::of_argument("MARKER", id, "QP", Some(k + 1)), qp[k]));
            Candidate {
                remedy: format!(
                    "MARKER/{id} on the other side (opposite sign of {} in {frame} axes)",
                    ["x", "y", "z"][axis]
                ),
                change: Change::Numbers(numbers.collect()),
            }
        };
        Family {
            candidates: places.into_iter().map(candidate).collect(),
            by_factor: None,
            is_of_a_bushing: false,
        }
    };
    seen.into_iter().map(of).collect()
}

/// Returns the possible slips of channels: readings with the wrong sign.
fn channels(study: &LoadedStudy) -> Vec<Family> {
    let channels = study.measurement.channels.iter().enumerate();
    let read = channels.filter(|(_, channel)| channel.is_read_by_case());
    let of = |(k, channel): (usize, &admire_study::Channel)| Family {
        candidates: vec![Candidate {
            remedy: format!("`{}` with the opposite sign", channel.name),
            change: Change::Channel(k, -1.0),
        }],
        by_factor: None,
        is_of_a_bushing: false,
    };
    read.map(of).collect()
}
