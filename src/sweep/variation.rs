use std::collections::BTreeSet;

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset};

use super::distribution::Distribution;

/// Effect of a varied number on its values in the deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Apply {
    /// The number replaces the values.
    #[default]
    Set,
    /// The values are multiplied by the number.
    Factor,
    /// The number is added to the values.
    Offset,
}

/// Varied number.
#[derive(Clone, PartialEq, Debug)]
pub struct Variation {
    /// Name, and column of the table.
    pub name: String,
    /// Addresses of the values in the deck, with their nominal values (angles in radians). NaN where the deck has no value to replace.
    pub targets: Vec<(Address, f64)>,
    /// Effect of the number on the values.
    pub apply: Apply,
    /// True if set or added numbers are in degrees.
    pub degrees: bool,
    /// Distribution of the number.
    pub distribution: Distribution,
}

impl Variation {
    /// Returns the unit of the number; `None` for a factor or dimensionless values.
    pub(crate) fn unit(&self, units: &Units) -> Option<String> {
        let (address, _) = self.targets.first()?;
        let unit = match self.apply {
            Apply::Factor => String::new(),
            _ if self.degrees => "deg".to_string(),
            _ => units.name(address.dimension()),
        };
        (!unit.is_empty()).then_some(unit)
    }

    /// Returns the values in the deck for a number of this variation.
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

/// Returns the deck with the numbers of a case, one number for every variation. Markers are moved without rotation.
///
/// # Errors
/// A value that cannot be written at its address.
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
    // Missing values would all be inserted at the same place, so they are written one after the other.
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
