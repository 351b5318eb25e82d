use std::collections::BTreeSet;

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset};

use super::distribution::Distribution;

/// What a number of a variation does to the values it is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Apply {
    /// It takes their place.
    #[default]
    Set,
    /// They are multiplied by it.
    Factor,
    /// It is added to them.
    Offset,
}

/// One number that varies.
#[derive(Clone, PartialEq, Debug)]
pub struct Variation {
    /// Its name: a column of the answer.
    pub name: String,
    /// The values of the deck it is about, and what they are there (angles in radians); NaN where nothing is written and the number
    /// takes its place.
    pub targets: Vec<(Address, f64)>,
    /// What it does to them.
    pub apply: Apply,
    /// Numbers that are set or added are degrees.
    pub degrees: bool,
    /// How it is distributed.
    pub distribution: Distribution,
}

impl Variation {
    /// The unit of its numbers; `None` for a factor, and where its values have none.
    pub(crate) fn unit(&self, units: &Units) -> Option<String> {
        let (address, _) = self.targets.first()?;
        let unit = match self.apply {
            Apply::Factor => String::new(),
            _ if self.degrees => "deg".to_string(),
            _ => units.name(address.dimension()),
        };
        (!unit.is_empty()).then_some(unit)
    }

    /// The values of the deck for a number of this variation.
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

/// The deck with the numbers of a case: one number for every variation. Markers are moved without being turned.
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
    // Values that are not written yet would be added at one place: one after the other.
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
