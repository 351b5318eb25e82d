use admire_solver::model::Model;
use admire_study::settings::{IdentifySettings, Initial, Symmetry};
use admire_study::{Study, did_you_mean};
use admire_syntax::Address;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;

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

/// A parameter of the deck to identify.
#[derive(Clone, PartialEq, Debug)]
pub struct Unknown {
    /// Address of the parameter.
    pub address: Address,
    /// Addresses of further parameters that symmetry makes equal to this one, such as Ky of a round bushing if `address` is its Kx.
    pub tied: Vec<Address>,
    /// Location of the parameter in the deck.
    pub place: Place,
    /// Unit of the parameter, spelled as in the result files.
    pub unit: String,
    /// Value at which the identification starts.
    pub initial: f64,
    /// Value of the parameter in the deck.
    pub deck: f64,
    /// Mean of the logarithm in the prior; `None` for the logarithm of the initial value.
    pub mean: Option<f64>,
    /// Standard deviation of the logarithm in the prior; `None` for that of the study.
    pub sd: Option<f64>,
    /// Lower and upper bound of the logarithm.
    pub bounds: Option<[f64; 2]>,
}

impl Unknown {
    /// Iterates over the addresses that this unknown sets, each with `value`.
    pub(crate) fn assign(&self, value: f64) -> impl Iterator<Item = (Address, f64)> + '_ {
        std::iter::once(&self.address)
            .chain(&self.tied)
            .map(move |address| (address.clone(), value))
    }

    /// Returns the bushing stiffnesses that this unknown sets, as (bushing, axis) pairs. There are two pairs if x and y are tied, otherwise
    /// one. The list is empty for a parameter that is not a bushing stiffness.
    pub fn axes(&self) -> Vec<(usize, usize)> {
        match self.place {
            Place::Number => Vec::new(),
            Place::Bushing { bushing, axis } => {
                (0..=self.tied.len()).map(|k| (bushing, axis + k)).collect()
            }
        }
    }
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
                tied: Vec::new(),
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
            tied: if tied {
                vec![stiffness(bushing.header.id, axis + 1)]
            } else {
                Vec::new()
            },
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
