//! Typed view of a spring property file (`.spr`).

use admire_syntax::property::PropertyFile;
use admire_syntax::units::Units;

/// Contents of a spring property file, in the units of a model.
#[derive(Clone, PartialEq, Debug)]
pub struct Spring {
    /// Length at which the spring force is zero: FREE_LENGTH of `[SPRING_DATA]`.
    pub free_length: Option<f64>,
    /// Displacements of the curve; positive in compression, zero at the free length.
    pub displacement: Vec<f64>,
    /// Forces of the curve; positive in compression.
    pub force: Vec<f64>,
}

impl Spring {
    /// Reads the contents of a parsed file in the units of a model; `None` if the file has no `[CURVE]`.
    pub fn of(file: &PropertyFile, units: &Units) -> Option<Self> {
        let (displacement, force) = file.curve("CURVE")?.in_units(file.units.as_ref(), units);
        Some(Self {
            free_length: file.free_length(units),
            displacement,
            force,
        })
    }
}
