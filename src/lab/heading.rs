//! Headings of columns: name and unit.

use super::quantity::{Quantity, is_unit};
use admire_syntax::text::Span;

/// Heading of a column.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Heading {
    /// Name of the column without its unit, unique within its table.
    pub name: String,
    /// Unit that the heading or the row of units states; `None` if there is none.
    pub unit: Option<String>,
    /// Text of the heading as written.
    pub written: String,
    /// Place of the heading.
    pub span: Span,
    /// Name and whole text in lower case with single blanks, by which mappings find the column.
    keys: [String; 2],
}

impl Heading {
    /// Creates a heading from its text and the cell of the row of units. The cell counts if the text states no unit.
    pub(crate) fn new(written: &str, units: Option<&str>, span: Span) -> Self {
        let (name, own) = name_and_unit(written);
        let below = units.map(unbracketed).filter(|unit| !unit.is_empty());
        Self {
            keys: [folded(&name), folded(written)],
            name,
            unit: own.or(below).map(str::to_string),
            written: written.to_string(),
            span,
        }
    }

    /// Appends a number to the heading, which distinguishes it from an earlier heading with the same text.
    pub(crate) fn number(&mut self, count: usize) {
        self.name = format!("{} #{count}", self.name);
        self.written.clone_from(&self.name);
        self.keys = [folded(&self.name), folded(&self.name)];
    }

    /// Returns the name in lower case with single blanks.
    pub(crate) fn name_key(&self) -> &str {
        &self.keys[0]
    }

    /// Returns the whole text in lower case with single blanks.
    pub(crate) fn written_key(&self) -> &str {
        &self.keys[1]
    }
}

/// Returns the text in lower case with single blanks.
pub(crate) fn folded(text: &str) -> String {
    let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
    words.join(" ")
}

/// Returns a unit without brackets around it.
pub(crate) fn unbracketed(text: &str) -> &str {
    text.trim()
        .trim_start_matches(['[', '(', '{'])
        .trim_end_matches([']', ')', '}'])
        .trim()
}

/// Splits a heading such as `Toe [min]`, `Toe (min)`, `Toe / min`, `Toe in min` or `toe_min` into the name and the unit. Square brackets
/// always hold a unit; the other spellings count if the word is a unit.
fn name_and_unit(heading: &str) -> (String, Option<&str>) {
    let heading = heading.trim();
    let joined = |before: &str, behind: &str| -> String {
        let pieces = [before.trim(), behind.trim()];
        pieces.join(" ").trim().to_string()
    };
    if let Some((before, rest)) = heading.split_once('[')
        && let Some((unit, behind)) = rest.split_once(']')
    {
        return (joined(before, behind), Some(unit.trim()));
    }
    if let Some((before, rest)) = heading.rsplit_once('(')
        && let Some((unit, behind)) = rest.split_once(')')
        && is_unit(unit)
    {
        return (joined(before, behind), Some(unit.trim()));
    }
    for mark in [" / ", "/", " in ", "_", ", "] {
        if let Some((name, unit)) = heading.rsplit_once(mark)
            && Quantity::of_unit(unit).is_some()
            && !name.trim().is_empty()
            && !(mark == "_" && unit == "in")
        {
            return (name.trim().to_string(), Some(unit.trim()));
        }
    }
    (heading.to_string(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_in_headings() {
        for (heading, name, unit) in [
            ("Toe [min]", "Toe", Some("min")),
            ("Spur (\u{b0}) links", "Spur links", Some("\u{b0}")),
            ("Camber (left)", "Camber (left)", None),
            ("Fz / kN", "Fz", Some("kN")),
            ("Radhub in mm", "Radhub", Some("mm")),
            ("toe_in", "toe_in", None),
            ("travel_mm", "travel", Some("mm")),
            ("Load [weird]", "Load", Some("weird")),
        ] {
            assert_eq!(
                name_and_unit(heading),
                (name.to_string(), unit),
                "{heading}"
            );
        }
    }

    #[test]
    fn the_row_of_units_counts_below_a_bare_heading() {
        let heading = |text, unit| Heading::new(text, unit, Span::at(0)).unit;
        assert_eq!(heading("Toe", Some("[min]")), Some("min".to_string()));
        assert_eq!(heading("Toe [deg]", Some("min")), Some("deg".to_string()));
        assert_eq!(heading("Toe", Some("")), None);
        assert_eq!(
            Heading::new("Toe  [DEG]", None, Span::at(0)).written_key(),
            "toe [deg]"
        );
    }
}
