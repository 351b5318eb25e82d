//! Typed view of a tyre property file (`.tir`).

use admire_syntax::property::PropertyFile;
use admire_syntax::units::{Dimension, Units};

use crate::file_units::factor;

/// Size and vertical stiffness of a tyre, in the units of a model. The coefficients of its slip forces are not read.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Tire {
    /// Kind of tyre model, such as `PAC2002`: PROPERTY_FILE_FORMAT of `[MODEL]`.
    pub format: Option<String>,
    /// Unloaded radius: UNLOADED_RADIUS of `[DIMENSION]`.
    pub unloaded_radius: Option<f64>,
    /// Width of the section: WIDTH of `[DIMENSION]`.
    pub width: Option<f64>,
    /// Radius of the rim: RIM_RADIUS of `[DIMENSION]`.
    pub rim_radius: Option<f64>,
    /// Force per length: VERTICAL_STIFFNESS of `[VERTICAL]`.
    pub vertical_stiffness: Option<f64>,
    /// Force per velocity: VERTICAL_DAMPING of `[VERTICAL]`.
    pub vertical_damping: Option<f64>,
    /// Nominal wheel load: FNOMIN of `[VERTICAL]`.
    pub nominal_load: Option<f64>,
}

impl Tire {
    /// Reads the contents of a parsed file in the units of a model. A value that is missing in the file is `None`.
    pub fn of(file: &PropertyFile, units: &Units) -> Self {
        let stiffness = Dimension::new(1, 0, -1, 0, 0);
        let damping = Dimension::new(1, 0, -1, 1, 0);
        let number = |block: &str, name: &str, dimension| {
            Some(file.number(block, name)? * factor(file, dimension, units))
        };
        let format = file
            .block("MODEL")
            .and_then(|block| block.parameter("PROPERTY_FILE_FORMAT"));
        Self {
            format: format.map(|word| word.text(file.source()).into_owned()),
            unloaded_radius: number("DIMENSION", "UNLOADED_RADIUS", Dimension::LENGTH),
            width: number("DIMENSION", "WIDTH", Dimension::LENGTH),
            rim_radius: number("DIMENSION", "RIM_RADIUS", Dimension::LENGTH),
            vertical_stiffness: number("VERTICAL", "VERTICAL_STIFFNESS", stiffness),
            vertical_damping: number("VERTICAL", "VERTICAL_DAMPING", damping),
            nominal_load: number("VERTICAL", "FNOMIN", Dimension::FORCE),
        }
    }
}
