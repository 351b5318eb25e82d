//! Columns of a block, with their descriptions from a mapping.

use super::block::Block;
use super::characteristic::{Characteristic, Target};
use super::column::Column;
use super::heading::{Heading, folded};
use super::mapping::Mapping;
use super::missing::Missing;
use super::quantity::Quantity;
use admire_kc::Side;

/// Column of a block that is imported.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    /// Index of the column in the block.
    pub at: usize,
    /// Index of the entry in the mapping.
    pub entry: usize,
    /// Content of the column; `None` if the column is only a load.
    pub is: Option<Target>,
    /// Side of the wheel; `None` if a column of the block contains the side, or if the characteristic has no side.
    pub side: Option<Side>,
    /// Unit in the laboratory's spelling.
    pub unit: Option<String>,
    /// Factor of the unit; 1 for the steering input.
    pub factor: f64,
    /// Quantity of the unit; `None` for the steering input and for words.
    pub quantity: Option<Quantity>,
}

impl Resolved {
    /// Returns the characteristic that the column holds.
    pub(crate) fn characteristic(&self) -> Option<Characteristic> {
        match self.is {
            Some(Target::Characteristic(of)) => Some(of),
            _ => None,
        }
    }
}

/// Returns the column of a block that an entry names: the only column with this complete heading, otherwise the only column with this name. `Err`
/// holds the number of matching columns.
pub(crate) fn find(entry: &Column, block: &Block) -> Result<usize, usize> {
    let asked = folded(&entry.name);
    let only = |is: &dyn Fn(&Heading) -> bool| {
        let found: Vec<usize> = (0..block.headings.len())
            .filter(|at| is(&block.headings[*at]))
            .collect();
        match found[..] {
            [only] => Ok(only),
            _ => Err(found.len()),
        }
    };
    only(&|heading| heading.written_key() == asked)
        .or_else(|_| only(&|heading| heading.name_key() == asked))
}

/// Returns true if a column of the block contains the side of each row.
pub(crate) fn tells_sides(mapping: &Mapping, block: &Block) -> bool {
    let mut entries = mapping.columns.iter();
    entries.any(|entry| entry.is == Some(Target::Side) && find(entry, block).is_ok())
}

/// Resolves an entry of the mapping for a column of a block.
///
/// # Errors
/// Returns the missing information: the unit, the sign, the side, the length of an angle, the sign of a load.
pub(crate) fn resolve(
    mapping: &Mapping,
    entry: usize,
    block: &Block,
    at: usize,
) -> Result<Resolved, Vec<Missing>> {
    let column = &mapping.columns[entry];
    let heading = &block.headings[at];
    let mut missing = Vec::new();
    let unit = column.unit.clone().or_else(|| heading.unit.clone());
    let mut resolved = Resolved {
        at,
        entry,
        is: column.is,
        side: None,
        unit,
        factor: 1.0,
        quantity: None,
    };
    let is_word = matches!(column.is, Some(Target::Test | Target::Side | Target::Time));
    let is_number = !is_word || column.load.is_some();
    if !is_number {
        return Ok(resolved);
    }
    let known = resolved.unit.as_deref().and_then(Quantity::of_unit);
    let characteristic = resolved.characteristic();
    let wanted = match characteristic {
        Some(of) => of.quantity(),
        None => known.map(|(quantity, _)| quantity),
    };
    match (characteristic, wanted, known) {
        (Some(_), None, _) => {
            if resolved.unit.is_none() {
                missing.push(Missing::Unit);
            }
        }
        (_, Some(Quantity::Angle), Some((Quantity::Length, factor))) => {
            (resolved.factor, resolved.quantity) = (factor, Some(Quantity::Length));
            if column.over_mm.is_none() {
                missing.push(Missing::OverMm);
            }
        }
        (_, Some(wanted), _) => {
            let unit = resolved.unit.as_deref();
            match unit.and_then(|unit| wanted.factor(unit)) {
                Some(factor) if column.over_mm.is_none() => {
                    (resolved.factor, resolved.quantity) = (factor, Some(wanted));
                }
                // The unit is an angle, although the angle is measured as a displacement.
                _ => missing.push(Missing::Unit),
            }
        }
        (None, None, _) => missing.push(Missing::Unit),
    }
    if let Some(of) = characteristic {
        if of.is_sided() {
            resolved.side = column.side.or(block.side).or(mapping.file.side);
            if resolved.side.is_none() && !tells_sides(mapping, block) {
                missing.push(Missing::Side);
            }
        }
        if column.positive.is_none() && !of.senses().is_empty() {
            missing.push(Missing::Positive);
        }
    }
    if column.load.is_some() && column.load_sign.is_none() {
        missing.push(Missing::LoadSign);
    }
    if missing.is_empty() {
        Ok(resolved)
    } else {
        Err(missing)
    }
}
