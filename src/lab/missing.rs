//! Information that may be missing for a column of a mapping.

use super::characteristic::Target;
use super::column::Column;
use super::quantity::Quantity;

/// Missing information about a column.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Missing {
    /// Unit of the column, or a unit that is consistent with its content.
    Unit,
    /// Length over which an angle was measured as a displacement.
    OverMm,
    /// Side of the wheel.
    Side,
    /// Positive direction of the values.
    Positive,
    /// Sign of the load in the deck.
    LoadSign,
}

impl Missing {
    /// Returns the words that may be filled in for this column.
    pub(crate) fn wanted(self, column: &Column) -> String {
        match self {
            Self::Unit => {
                if let Some(Target::Characteristic(of)) = column.is {
                    return of.quantity().map_or_else(
                        || "unit of the steering input".to_string(),
                        |quantity| format!("unit: {}", quantity.described()),
                    );
                }
                let all = Quantity::ALL.map(Quantity::described);
                format!("unit: {}", all.join("; "))
            }
            Self::OverMm => {
                "over_mm: length over which the angle was measured, in mm, such as the diameter of the rim"
                    .to_string()
            }
            Self::Side => "side: left or right".to_string(),
            Self::Positive => match column.is {
                Some(Target::Characteristic(of)) => {
                    let words: Vec<&str> = of.senses().iter().map(|(word, _)| *word).collect();
                    format!("positive: {}", words.join(", "))
                }
                _ => String::new(),
            },
            Self::LoadSign => "load_sign: + if the deck and the laboratory use the same sign for this load, otherwise -".to_string(),
        }
    }

    pub(crate) const fn described(self) -> &'static str {
        match self {
            Self::Unit => "the unit of these columns is not clear",
            Self::OverMm => {
                "these angles are given as lengths, but the length over which they were measured is not stated"
            }
            Self::Side => "the side of these columns is not clear",
            Self::Positive => "the positive direction of these columns is not stated",
            Self::LoadSign => "the sign of these loads in the deck is not stated",
        }
    }
}
