//! Units as typed by the user: a unit system, or single units.

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::nearest;
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit};

/// Unit systems by their names in ADAMS/View, each with its units of force, mass, length and time.
const SYSTEMS: [(&str, [&str; 4]); 4] = [
    ("MMKS", ["NEWTON", "KILOGRAM", "MILLIMETER", "SECOND"]),
    ("MKS", ["NEWTON", "KILOGRAM", "METER", "SECOND"]),
    ("CGS", ["DYNE", "GRAM", "CENTIMETER", "SECOND"]),
    ("IPS", ["POUND_FORCE", "POUND_MASS", "INCH", "SECOND"]),
];

/// Parses the requested units. A unit that the text does not name keeps its old value.
pub(crate) fn units(text: &str, old: [Unit; 4]) -> Result<[Unit; 4], Diagnostic> {
    let tables = [FORCE_UNITS, MASS_UNITS, LENGTH_UNITS, TIME_UNITS];
    let mut found = old;
    let system = SYSTEMS
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(text.trim()));
    let words: Vec<&str> = match system {
        Some((_, words)) => words.to_vec(),
        None => text.split(',').map(str::trim).collect(),
    };
    for word in words {
        let known = tables.iter().enumerate().find_map(|(k, table)| {
            let same = |unit: &&Unit| {
                unit.keyword.eq_ignore_ascii_case(word) || unit.word.eq_ignore_ascii_case(word)
            };
            Some((k, *table.iter().find(same)?))
        });
        let Some((k, unit)) = known else {
            let known = tables
                .iter()
                .flat_map(|table| table.iter().map(|unit| unit.keyword));
            let known = known.chain(SYSTEMS.iter().map(|(name, _)| *name));
            let help = match nearest(word, known) {
                Some(near) => format!("did you mean {}?", near.to_lowercase()),
                None => "write mmks, mks, cgs, ips, or units such as meter,newton".to_string(),
            };
            let message = format!("`{word}` is not a unit");
            return Err(Diagnostic::error(Code::BadSetting, message).help(help));
        };
        found[k] = unit;
    }
    Ok(found)
}
