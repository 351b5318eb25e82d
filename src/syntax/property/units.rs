use super::block::Block;
use crate::diagnostic::{Code, Diagnostic};
use crate::text::Source;
use crate::units::{Dimension, FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units};

/// Units of a property file, given by their sizes in SI units and in radians.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PropertyUnits {
    /// Size of the force unit in newtons.
    pub force: f64,
    /// Size of the mass unit in kilograms.
    pub mass: f64,
    /// Size of the length unit in metres.
    pub length: f64,
    /// Size of the time unit in seconds.
    pub time: f64,
    /// Size of the angle unit in radians.
    pub angle: f64,
}

/// Further spellings of units in Adams/Car, with the corresponding keywords of UNITS. They are not abbreviations of these keywords and do
/// not occur in results files.
const MORE: &[(&str, &str)] = &[
    ("m", "METER"),
    ("in", "INCH"),
    ("ft", "FOOT"),
    ("n", "NEWTON"),
    ("kn", "KNEWTON"),
    ("lbf", "POUND_FORCE"),
    ("lb", "POUND_MASS"),
    ("lbm", "POUND_MASS"),
    ("g", "GRAM"),
    ("s", "SECOND"),
];

impl PropertyUnits {
    /// Reads the block `UNITS` of a file and reports unknown units.
    ///
    /// A missing or unknown unit defaults to the usual unit of Adams/Car: newton, kilogram, millimetre, second or degree.
    pub(super) fn read(block: &Block, source: &Source, diagnostics: &mut Vec<Diagnostic>) -> Self {
        let mut size = |name: &str, all: &[Unit], usual: f64| {
            let Some(parameter) = block.parameter(name) else {
                return usual;
            };
            let word = parameter.text(source).to_ascii_lowercase();
            let known = find(&word, all);
            if known.is_none() {
                diagnostics.push(unknown(&word, name).label(
                    source.name(),
                    parameter.value.span(),
                    "",
                ));
            }
            known.unwrap_or(usual)
        };
        let mut units = Self {
            force: size("FORCE", FORCE_UNITS, 1.0),
            mass: size("MASS", MASS_UNITS, 1.0),
            length: size("LENGTH", LENGTH_UNITS, 1e-3),
            time: size("TIME", TIME_UNITS, 1.0),
            angle: 1f64.to_radians(),
        };
        if let Some(parameter) = block.parameter("ANGLE") {
            let word = parameter.text(source).to_ascii_lowercase();
            if word.starts_with("rad") {
                units.angle = 1.0;
            } else if !word.starts_with("deg") {
                let place = parameter.value.span();
                diagnostics.push(unknown(&word, "ANGLE").label(source.name(), place, ""));
            }
        }
        units
    }

    /// Returns the factor that converts a value of this dimension from the units of the file to the units of a model, with angles in
    /// radians.
    pub fn factor(&self, dimension: Dimension, units: &Units) -> f64 {
        [
            (self.force / units.force.si, dimension.force),
            (self.mass / units.mass.si, dimension.mass),
            (self.length / units.length.si, dimension.length),
            (self.time / units.time.si, dimension.time),
            (self.angle, dimension.angle),
        ]
        .iter()
        .map(|(ratio, exponent)| ratio.powi(i32::from(*exponent)))
        .product()
    }
}

/// Returns the size of a unit in SI units. `word` may be its keyword, an abbreviation, its spelling in results files, or a spelling of
/// Adams/Car.
fn find(word: &str, all: &[Unit]) -> Option<f64> {
    let keyword = MORE
        .iter()
        .find(|(short, keyword)| *short == word && all.iter().any(|unit| unit.keyword == *keyword))
        .map_or_else(
            || word.to_ascii_uppercase(),
            |(_, keyword)| (*keyword).to_string(),
        );
    all.iter()
        .find(|unit| unit.keyword == keyword || unit.word.eq_ignore_ascii_case(word))
        .or_else(|| {
            let begins = |unit: &&Unit| keyword.len() >= 3 && unit.keyword.starts_with(&keyword);
            all.iter().find(begins)
        })
        .map(|unit| unit.si)
}

fn unknown(word: &str, name: &str) -> Diagnostic {
    Diagnostic::warning(
        Code::WrongType,
        format!("`{word}` is not a known unit of {}", name.to_lowercase()),
    )
}
