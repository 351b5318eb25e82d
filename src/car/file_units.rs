//! Units of a file, as factors to the units of a model and as names.

use admire_syntax::property::PropertyFile;
use admire_syntax::units::{Dimension, FORCE_UNITS, LENGTH_UNITS, Unit, Units};

/// Returns the factor from the units of a file to the units of a model. A file without units has the units of the model.
pub(crate) fn factor(file: &PropertyFile, dimension: Dimension, units: &Units) -> f64 {
    file.units
        .as_ref()
        .map_or(1.0, |own| own.factor(dimension, units))
}

/// Returns the name of the length unit of a file.
pub(crate) fn length_word(file: &PropertyFile, units: &Units) -> String {
    word(file.units.map(|own| own.length), LENGTH_UNITS, units.length)
}

/// Returns the name of the force unit of a file.
pub(crate) fn force_word(file: &PropertyFile, units: &Units) -> String {
    word(file.units.map(|own| own.force), FORCE_UNITS, units.force)
}

/// Returns the name of the torque unit of a file, such as `newton-mm`.
pub(crate) fn torque_word(file: &PropertyFile, units: &Units) -> String {
    format!("{}-{}", force_word(file, units), length_word(file, units))
}

/// Returns the name of the angle unit of a file. Without a unit, angles are in radians.
pub(crate) fn angle_word(file: &PropertyFile) -> String {
    let is_radian = file.units.is_none_or(|own| own.angle == 1.0);
    if is_radian { "rad" } else { "deg" }.to_string()
}

/// Returns the name of the unit with this size in SI units, or of the unit of the model if the file has none.
fn word(size: Option<f64>, all: &[Unit], of_model: Unit) -> String {
    let Some(size) = size else {
        return of_model.word.to_string();
    };
    let known = all.iter().find(|unit| unit.si == size);
    known.map_or_else(String::new, |unit| unit.word.to_string())
}
