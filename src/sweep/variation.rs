use std::collections::BTreeSet;

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset};

use super::distribution::Distribution;

/// Way in which a varied parameter changes its values in the deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Apply {
    /// The parameter replaces the values.
    #[default]
    Set,
    /// The values are multiplied by the parameter.
    Factor,
    /// The parameter is added to the values.
    Offset,
}

/// Varied parameter of a sweep.
#[derive(Clone, PartialEq, Debug)]
pub struct Variation {
    /// Name of the parameter, and of its column in the table.
    pub name: String,
    /// Addresses of the values in the deck, each with its nominal value (angles in radians). The nominal value is NaN if the deck gives
    /// none.
    pub targets: Vec<(Address, f64)>,
    /// Way in which the parameter changes the values.
    pub apply: Apply,
    /// True if values that are set or added are given in degrees.
    pub degrees: bool,
    /// Distribution of the parameter.
    pub distribution: Distribution,
}

impl Variation {
    /// Returns the unit of the parameter; `None` for a factor or a dimensionless value.
    pub(crate) fn unit(&self, units: &Units) -> Option<String> {
        let (address, _) = self.targets.first()?;
        let unit = match self.apply {
            Apply::Factor => String::new(),
            _ if self.degrees => "deg".to_string(),
            _ => units.name(address.dimension()),
        };
        (!unit.is_empty()).then_some(unit)
    }

    /// Returns the values in the deck for a given value of the parameter, each with its address.
    pub(crate) fn values(&self, number: f64) -> impl Iterator<Item = (&Address, f64)> {
        let plain = if self.degrees {
            number.to_radians()
        } else {
            number
        };
        self.targets.iter().map(move |(address, old)| {
            let new = match self.apply {
                Apply::Set => plain,
                Apply::Factor => old * number,
                Apply::Offset => old + plain,
            };
            (address, new)
        })
    }
}

/// Returns the deck with the parameter values of a case, one for every variation. Markers are moved without rotation.
///
/// # Errors
/// A diagnostic if a value cannot be written at its address.
pub(crate) fn varied(
    deck: &Dataset,
    variations: &[Variation],
    numbers: &[f64],
) -> Result<Source, Box<Diagnostic>> {
    let values: Vec<(&Address, f64)> = variations
        .iter()
        .zip(numbers)
        .flat_map(|(variation, number)| variation.values(*number))
        .collect();
    let beside: BTreeSet<&Address> = values.iter().map(|(address, _)| *address).collect();
    let mut edits: Vec<Edit> = Vec::new();
    for (address, value) in &values {
        edits.extend(deck.set_beside(address, *value, &beside)?);
    }
    if let Ok(bytes) = apply_edits(deck.bytes(), &edits) {
        return Ok(Source::new(deck.source().name(), bytes));
    }
    // Missing arguments would all be inserted at the same place, so they are written one after the other.
    let mut deck = deck.clone();
    for (address, value) in &values {
        let edits = deck.set_beside(address, *value, &beside)?;
        deck = deck
            .edited(&edits)
            .map_err(|conflict| {
                Box::new(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
            })?
            .value;
    }
    Ok(deck.source().clone())
}
