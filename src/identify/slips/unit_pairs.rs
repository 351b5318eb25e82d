//! Conversion factors that correct numbers entered in a wrong unit.

use crate::settings::EQUAL_UNIT_FACTOR_LN;
use std::f64::consts::PI;

use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, Unit, Units};

/// Factor that corrects a number, and the unit in which the number was probably written.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct UnitPair {
    /// Factor by which the number must be multiplied.
    pub factor: f64,
    /// Name of the unit that explains the factor.
    pub unit: String,
}

/// Units of force that are commonly confused.
const FORCES: [&str; 4] = ["NEWTON", "KNEWTON", "POUND_FORCE", "KILOGRAM_FORCE"];
/// Units of length that are commonly confused.
const LENGTHS: [&str; 5] = ["MILLIMETER", "CENTIMETER", "METER", "INCH", "FOOT"];

fn named(units: &'static [Unit], names: &'static [&str]) -> impl Iterator<Item = &'static Unit> {
    units.iter().filter(|unit| names.contains(&unit.keyword))
}

/// Returns the distinct factors that differ from one. Their reciprocals follow, for numbers that were multiplied where they should have been
/// divided.
fn pairs(all: impl IntoIterator<Item = (f64, String)>) -> Vec<UnitPair> {
    let mut out: Vec<UnitPair> = Vec::new();
    let mut add = |factor: f64, unit: String| {
        let is_new = |known: f64| libm::log(known / factor).abs() > EQUAL_UNIT_FACTOR_LN;
        if is_new(1.0) && out.iter().all(|pair| is_new(pair.factor)) {
            out.push(UnitPair { factor, unit });
        }
    };
    let all: Vec<(f64, String)> = all.into_iter().collect();
    for (factor, unit) in &all {
        add(*factor, unit.clone());
    }
    for (factor, unit) in all {
        add(1.0 / factor, format!("{unit} and converted the wrong way"));
    }
    out
}

/// Returns the factors from commonly confused force units to the force unit of the deck.
pub(super) fn forces(units: &Units) -> Vec<UnitPair> {
    let own = units.force.si;
    pairs(named(FORCE_UNITS, &FORCES).map(|unit| (unit.si / own, unit.word.to_string())))
}

/// Returns the factors from commonly confused length units to the length unit of the deck.
pub(super) fn lengths(units: &Units) -> Vec<UnitPair> {
    let own = units.length.si;
    pairs(named(LENGTH_UNITS, &LENGTHS).map(|unit| (unit.si / own, unit.word.to_string())))
}

/// Returns the factors for angles in degrees, which the solver takes in radians.
pub(super) fn angles() -> Vec<UnitPair> {
    pairs([(PI / 180.0, "degrees".to_string())])
}

/// Returns the factors from commonly confused stiffness units to the stiffness unit of the deck.
pub(super) fn stiffnesses(units: &Units) -> Vec<UnitPair> {
    let own = units.force.si / units.length.si;
    let of = [
        ("NEWTON", "METER"),
        ("NEWTON", "CENTIMETER"),
        ("NEWTON", "MILLIMETER"),
        ("POUND_FORCE", "INCH"),
        ("KILOGRAM_FORCE", "MILLIMETER"),
        ("KNEWTON", "MILLIMETER"),
    ];
    pairs(of.into_iter().filter_map(|(force, length)| {
        let force = FORCE_UNITS.iter().find(|unit| unit.keyword == force)?;
        let length = LENGTH_UNITS.iter().find(|unit| unit.keyword == length)?;
        let unit = format!("{}/{}", force.word, length.word);
        Some((force.si / length.si / own, unit))
    }))
}

/// Returns the factors from commonly confused torsional stiffness units to the unit of the deck, which is per radian.
pub(super) fn torsional(units: &Units) -> Vec<UnitPair> {
    let own = units.force.si * units.length.si;
    let per_degree = 180.0 / PI;
    let of = [
        ("MILLIMETER", "rad", 1.0),
        ("MILLIMETER", "deg", per_degree),
        ("METER", "rad", 1.0),
        ("METER", "deg", per_degree),
    ];
    pairs(of.into_iter().filter_map(|(length, angle, factor)| {
        let length = LENGTH_UNITS.iter().find(|unit| unit.keyword == length)?;
        let unit = format!("newton-{}/{angle}", length.word);
        Some((length.si * factor / own, unit))
    }))
}
