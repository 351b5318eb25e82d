//! Values in display units, the same on pages, on the terminal and in tables.

use super::test_kind::Driven;
use super::{Reading, Unit};
use admire_syntax::units::{Units, short_unit};

/// Returns true for decks in newtons and metric lengths. All other decks are displayed in their own units.
fn metric(units: &Units) -> bool {
    units.force.word == "newton" && matches!(units.length.word, "mm" | "cm" | "meter")
}

/// Converts a value to display units: angles to degrees, compliances to values per kilonewton. Returns the value and its unit.
pub fn shown(value: f64, unit: Unit, units: &Units) -> (f64, String) {
    let (force, length) = (units.force.si, units.length.si);
    let people = match unit {
        _ if !metric(units) => None,
        Unit::Force => Some((1.0, "N")),
        Unit::Rate => Some((force / length * 1e-3, "N/mm")),
        Unit::RollRate => Some((force * length * 1f64.to_radians(), "Nm/deg")),
        Unit::AnglePerLength => Some((1f64.to_degrees() / length, "deg/m")),
        Unit::LengthPerForce => Some((length * 1e6 / force, "mm/kN")),
        Unit::AnglePerForce => Some((1f64.to_degrees() * 1e3 / force, "deg/kN")),
        Unit::AnglePerTorque => {
            let torque = force * length;
            Some((1f64.to_degrees() * 100.0 / torque, "deg/100 Nm"))
        }
        _ => None,
    };
    if unit == Unit::Percent {
        return (value, "%".to_string());
    }
    if let Some((factor, word)) = people {
        return (factor * value, word.to_string());
    }
    let word = short_unit(&unit.word(units));
    if unit.is_angle() {
        (value.to_degrees(), word.replacen("rad", "deg", 1))
    } else {
        (value, word)
    }
}

/// Converts a slope with respect to a test's variable to display units. Returns the slope and its unit.
pub fn slope(value: f64, unit: Unit, driven: Driven, units: &Units) -> (f64, String) {
    let (value, word) = shown(value, unit, units);
    let (force, length) = (units.force.si, units.length.si);
    let (factor, per) = match driven {
        Driven::Steering => (1.0, " per unit of steering.drive"),
        _ if !metric(units) => {
            let variable = match driven {
                Driven::Height(_) => Unit::Length,
                Driven::Mz(_) => Unit::Torque,
                _ => Unit::Force,
            };
            return (value, format!("{word} per {}", variable.word(units)));
        }
        Driven::Height(_) if unit == Unit::Force => (1e-3 / length, "/mm"),
        Driven::Height(_) => (1.0 / length, "/m"),
        Driven::Fx(_) | Driven::Fy(_) => (1e3 / force, "/kN"),
        Driven::Mz(_) => (100.0 / (force * length), "/100 Nm"),
    };
    (factor * value, word + per)
}

/// Returns the display unit of a test's variable.
pub fn driven_unit(driven: Driven, units: &Units) -> String {
    match driven {
        Driven::Height(_) => Unit::Length.word(units),
        Driven::Steering => "units of steering.drive".to_string(),
        Driven::Fx(_) | Driven::Fy(_) => shown(0.0, Unit::Force, units).1,
        Driven::Mz(_) => shown(0.0, Unit::Torque, units).1,
    }
}

/// Returns the size of a column's unit, in units of the deck and radians. `word` is a unit that [`shown`] writes, one of the deck's own units,
/// or begins with `deg`; an empty word means the deck's own unit. Returns `None` for any other word.
pub fn unit_in_deck(word: &str, units: &Units) -> Option<f64> {
    let mut all = Unit::ALL.iter().map(|unit| shown(1.0, *unit, units));
    if let Some((factor, _)) = all.find(|(_, known)| known == word) {
        return Some(1.0 / factor);
    }
    let is_own = word.is_empty() || Unit::ALL.iter().any(|unit| unit.word(units) == word);
    match word {
        _ if is_own => Some(1.0),
        _ if word.starts_with("deg") => Some(1f64.to_radians()),
        _ => None,
    }
}

/// Returns the heading of a reading's column, such as `toe_angle.left [deg]`.
pub(super) fn head(reading: &Reading, units: &Units) -> String {
    let unit = shown(0.0, reading.unit, units).1;
    if unit.is_empty() {
        reading.path()
    } else {
        format!("{} [{unit}]", reading.path())
    }
}
