//! Which stiffnesses of a deck are unknown, under which symmetry, and where they start.

use super::unknown::{Component, Meaning, Unknown};
use crate::model::{Bushing, Model};
use crate::rig::settings::{IdentifySettings, Initial, Symmetry};
use crate::syntax::Address;
use crate::system::System;

/// A bushing that is identified.
#[derive(Clone, PartialEq, Debug)]
pub struct Identified<'a> {
    /// The bushing.
    pub bushing: &'a Bushing,
    /// Its symmetry.
    pub symmetry: Symmetry,
}

impl Identified<'_> {
    /// Groups of components that share one stiffness: 0 to 2 are Kx, Ky, Kz, 3 to 5 are KTx, KTy, KTz.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        match self.symmetry {
            Symmetry::None => (0..6).map(|k| vec![k]).collect(),
            Symmetry::RadialZ => vec![vec![0, 1], vec![2], vec![3, 4], vec![5]],
        }
    }

    /// Stiffness of a component in the deck.
    pub fn deck_value(&self, component: usize) -> f64 {
        if component < 3 {
            self.bushing.k[component]
        } else {
            self.bushing.kt[component - 3]
        }
    }
}

/// The address of a bushing's number: component 0 to 2 of the first word, 3 to 5 of the second.
pub fn bushing_address(id: u32, words: [&str; 2], component: usize) -> Address {
    Address {
        kind: "BUSHING".to_string(),
        id: Some(id),
        argument: Some(words[component / 3].to_string()),
        index: Some(component % 3 + 1),
    }
}

/// Where a stiffness starts. A deck's zero has no logarithm: it starts from the paper's value then.
pub fn initial_value(initial: Initial, deck: f64, component: usize) -> f64 {
    let paper = |translational: f64, rotational_per_degree: f64| {
        if component < 3 {
            translational
        } else {
            rotational_per_degree.to_degrees()
        }
    };
    match initial {
        Initial::Deck if deck > 0.0 => deck,
        Initial::Deck => paper(1e4, 1e4),
        Initial::Values {
            translational,
            rotational_per_degree,
        } => paper(translational, rotational_per_degree),
    }
}

/// The bushings a study names, or all of the deck. Names the study spells wrongly are left to the study's own checks.
pub fn identified<'a>(model: &'a Model, settings: &IdentifySettings) -> Vec<Identified<'a>> {
    let is = |bushing: &Bushing, name: &str| {
        let name = name.trim();
        name.strip_prefix("BUSHING/").and_then(|id| id.parse().ok()) == Some(bushing.header.id)
            || bushing.header.name.eq_ignore_ascii_case(name)
    };
    let wanted = |bushing: &Bushing| {
        settings
            .bushings
            .as_ref()
            .is_none_or(|names| names.iter().any(|name| is(bushing, &name.text)))
    };
    let symmetry_of = |bushing: &Bushing| {
        let named = settings
            .symmetry_of
            .iter()
            .find(|(name, _)| is(bushing, &name.text));
        named.map_or(settings.symmetry, |(_, symmetry)| *symmetry)
    };
    model
        .bushings
        .iter()
        .filter(|bushing| bushing.header.active && wanted(bushing))
        .map(|bushing| Identified {
            bushing,
            symmetry: symmetry_of(bushing),
        })
        .collect()
}

/// Unknowns ln K of these bushings, then of other numbers of the deck, then assembly offsets where their prior has a width.
///
/// # Panics
/// Never for bushings and addresses of the system's own model.
pub fn unknowns(
    system: &System,
    bushings: &[Identified<'_>],
    others: &[(Address, f64)],
    settings: &IdentifySettings,
) -> Vec<Unknown> {
    let slot = |address: &Address| system.catalogue().slot(address);
    let mut out = Vec::new();
    let mut offsets = Vec::new();
    for identified in bushings {
        let id = identified.bushing.header.id;
        for group in identified.groups() {
            let components: Vec<Component> = group
                .iter()
                .filter_map(|&k| {
                    let stiffness = slot(&bushing_address(id, ["K", "KT"], k))?;
                    Some(Component {
                        stiffness,
                        preload: slot(&bushing_address(id, ["FORCE", "TORQUE"], k)),
                    })
                })
                .collect();
            let deck =
                group.iter().map(|&k| identified.deck_value(k)).sum::<f64>() / group.len() as f64;
            let start = initial_value(settings.initial, deck, group[0]).ln();
            for (component, k) in components.iter().zip(&group) {
                let angular = *k >= 3;
                let sd = if angular {
                    settings.offset_sd.angle_deg.to_radians()
                } else {
                    settings.offset_sd.length
                };
                if sd > 0.0 {
                    offsets.push(Unknown {
                        addresses: vec![bushing_address(id, ["FORCE", "TORQUE"], *k)],
                        meaning: Meaning::Offset(*component),
                        start: 0.0,
                        mean: 0.0,
                        sd,
                    });
                }
            }
            out.push(Unknown {
                addresses: group
                    .iter()
                    .map(|&k| bushing_address(id, ["K", "KT"], k))
                    .collect(),
                meaning: Meaning::Stiffness(components),
                start,
                mean: start,
                sd: settings.prior_log_sd,
            });
        }
    }
    for (address, deck) in others {
        let Some(stiffness) = slot(address) else {
            continue;
        };
        let start = deck.abs().max(f64::MIN_POSITIVE).ln();
        out.push(Unknown {
            addresses: vec![address.clone()],
            meaning: Meaning::Stiffness(vec![Component {
                stiffness,
                preload: None,
            }]),
            start,
            mean: start,
            sd: settings.prior_log_sd,
        });
    }
    out.append(&mut offsets);
    out
}
