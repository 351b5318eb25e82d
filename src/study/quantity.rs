//! Numbers with a written unit, such as `"3 mm"`.

use toml::de::DeValue;

use super::section::{Section, SpannedText, ValueType, number_of};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use admire_syntax::units::{
    Dimension, FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units,
};

/// A number of `study.toml`, with its unit if the file states one.
#[derive(Clone, PartialEq, Debug)]
pub struct Quantity {
    /// The number as written.
    pub value: f64,
    /// Unit as written, such as `mm` or `N/mm`. If it is empty, the number is in the units of the deck.
    pub unit: String,
    /// The whole text, with its position in `study.toml`.
    pub spelled: SpannedText,
}

impl Quantity {
    /// Splits a text into its number and its unit; `None` if it does not begin with a finite number.
    pub(crate) fn of(spelled: SpannedText) -> Option<Self> {
        let text = spelled.text.trim();
        let end = (1..=text.len())
            .rev()
            .filter(|end| text.is_char_boundary(*end))
            .find(|end| text[..*end].parse::<f64>().is_ok())?;
        let (value, unit) = (text[..end].parse().ok()?, text[end..].trim().to_string());
        f64::is_finite(value).then_some(Self {
            value,
            unit,
            spelled,
        })
    }

    /// Returns the value in the units of a deck, with angles in radians. `dimension` is the dimension of the number in the deck.
    ///
    /// # Errors
    /// A diagnostic at the text if the unit is unknown or has another dimension.
    pub fn in_units(
        &self,
        dimension: Dimension,
        units: &Units,
        study: &Source,
    ) -> Result<f64, Diagnostic> {
        if self.unit.is_empty() {
            return Ok(self.value);
        }
        let complain = |message: String| {
            Diagnostic::error(Code::BadSetting, message).label(study.name(), self.spelled.span, "")
        };
        let (size, own) = unit(&self.unit).ok_or_else(|| {
            complain(format!("`{}` is not a unit", self.unit))
                .help("write units such as mm, N/mm, N mm/deg, deg, kg; or a bare number in the units of the deck")
        })?;
        // Angles have no dimension in products such as a torque per radian.
        let plain = |dimension: Dimension| Dimension {
            angle: 0,
            ..dimension
        };
        if plain(own) != plain(dimension) {
            let wanted = units.name(dimension);
            let wanted = if wanted.is_empty() {
                "no unit".to_string()
            } else {
                format!("a unit like `{wanted}`")
            };
            return Err(complain(format!(
                "`{}` has the wrong dimension: the number in the deck has {wanted}",
                self.unit
            )));
        }
        Ok(self.value * size / units.si(dimension))
    }

    /// Returns the value of a number without a unit. A percentage is divided by 100.
    ///
    /// # Errors
    /// A diagnostic at the text if another unit is written.
    pub fn plain(&self, study: &Source) -> Result<f64, Diagnostic> {
        match self.unit.as_str() {
            "" => Ok(self.value),
            "%" => Ok(self.value / 100.0),
            _ => {
                let message = format!("`{}` must be a factor or a percentage", self.spelled.text);
                let error = Diagnostic::error(Code::BadSetting, message);
                Err(error.label(study.name(), self.spelled.span, ""))
            }
        }
    }
}

impl Section<'_> {
    /// Returns the value of a key as true or false; false if the key is absent.
    pub(super) fn flag(&mut self, key: &'static str, out: &mut Vec<Diagnostic>) -> bool {
        self.note(key, ValueType::Flag);
        let Some((value, span)) = self.get(key) else {
            return false;
        };
        let DeValue::Boolean(flag) = value else {
            self.wrong(key, span, "true or false", out);
            return false;
        };
        *flag
    }

    /// Returns the value of a key as a list of finite numbers; `None` if the key is absent.
    pub(super) fn numbers(
        &mut self,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Vec<f64>> {
        self.note(key, ValueType::Numbers);
        let (value, span) = self.get(key)?;
        let all = value.as_array().and_then(|array| {
            let numbers = array.iter().map(|item| number_of(item.get_ref()));
            numbers.collect::<Option<Vec<f64>>>()
        });
        if all.is_none() {
            self.wrong(key, span, "a list of numbers", out);
        }
        all
    }

    /// Returns the value of a key as a number with or without a unit; `None` if the key is absent.
    pub(super) fn quantity(
        &mut self,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Quantity> {
        self.note(key, ValueType::Quantity);
        let (value, span) = self.get(key)?;
        let found = quantity_of(value, span);
        if found.is_none() {
            self.wrong(key, span, "a number, or a string such as \"3 mm\"", out);
        }
        found
    }

    /// Returns the value of a key as a lower and an upper bound; `None` if the key is absent.
    pub(super) fn bounds(
        &mut self,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<[Quantity; 2]> {
        self.note(key, ValueType::Bounds);
        let (value, span) = self.get(key)?;
        let both = value.as_array().and_then(|array| {
            let each = array.iter();
            let all: Option<Vec<Quantity>> = each
                .map(|item| quantity_of(item.get_ref(), Span::from(item.span())))
                .collect();
            <[Quantity; 2]>::try_from(all?).ok()
        });
        if both.is_none() {
            let expected = "a lower and an upper bound, such as [\"-10 mm\", \"10 mm\"]";
            self.wrong(key, span, expected, out);
        }
        both
    }
}

/// Returns a value of the file as a quantity; `None` if it is neither a number nor a text that begins with a number.
fn quantity_of(value: &DeValue<'_>, span: Span) -> Option<Quantity> {
    if let Some(number) = number_of(value) {
        return Some(Quantity {
            value: number,
            unit: String::new(),
            spelled: SpannedText {
                text: number.to_string(),
                span,
            },
        });
    }
    let text = value.as_str()?.to_string();
    Quantity::of(SpannedText { text, span })
}

/// Returns the size of a unit in SI units (N, kg, m, s, rad), and its dimension. Products are written with a blank, `*` or `-`, quotients with `/`.
/// Every unit after the first `/` is in the denominator.
fn unit(text: &str) -> Option<(f64, Dimension)> {
    let (mut size, mut dimension) = (1.0, Dimension::NONE);
    let (above, below) = text.split_once('/').unwrap_or((text, ""));
    let parts = |text: &str| -> Vec<String> {
        let words = text.split([' ', '*', '-', '/', '(', ')']);
        words
            .filter(|word| !word.is_empty())
            .map(str::to_string)
            .collect()
    };
    for (words, power) in [(parts(above), 1_i8), (parts(below), -1)] {
        for word in words {
            let (one, of) = single(&word)?;
            size *= f64::powi(one, power.into());
            dimension = Dimension {
                force: dimension.force + power * of.force,
                mass: dimension.mass + power * of.mass,
                length: dimension.length + power * of.length,
                time: dimension.time + power * of.time,
                angle: dimension.angle + power * of.angle,
            };
        }
    }
    Some((size, dimension))
}

/// Returns a single unit, in the spelling of engineers or of ADAMS.
fn single(word: &str) -> Option<(f64, Dimension)> {
    let short = match word {
        "N" => (1.0, Dimension::FORCE),
        "kN" => (1e3, Dimension::FORCE),
        "mm" => (1e-3, Dimension::LENGTH),
        "cm" => (1e-2, Dimension::LENGTH),
        "m" => (1.0, Dimension::LENGTH),
        "in" => (0.0254, Dimension::LENGTH),
        "Nm" => (1.0, Dimension::TORQUE),
        "Nmm" => (1e-3, Dimension::TORQUE),
        "kg" => (1.0, Dimension::MASS),
        "g" => (1e-3, Dimension::MASS),
        "t" => (1e3, Dimension::MASS),
        "s" => (1.0, Dimension::TIME),
        "rad" => (1.0, Dimension::ANGLE),
        "mrad" => (1e-3, Dimension::ANGLE),
        "deg" | "°" => (1f64.to_radians(), Dimension::ANGLE),
        _ => {
            let tables = [
                (FORCE_UNITS, Dimension::FORCE),
                (MASS_UNITS, Dimension::MASS),
                (LENGTH_UNITS, Dimension::LENGTH),
                (TIME_UNITS, Dimension::TIME),
            ];
            return tables.into_iter().find_map(|(table, dimension)| {
                let same = |unit: &&Unit| {
                    unit.keyword.eq_ignore_ascii_case(word) || unit.word.eq_ignore_ascii_case(word)
                };
                table.iter().find(same).map(|unit| (unit.si, dimension))
            });
        }
    };
    Some(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(text: &str) -> Quantity {
        let span = Span::at(0);
        let text = text.to_string();
        Quantity::of(SpannedText { text, span }).expect("a quantity")
    }

    #[test]
    fn units_are_converted_to_those_of_the_deck() {
        let (deck, study) = (Units::default(), Source::new("study.toml", Vec::new()));
        let of = |text: &str, dimension| quantity(text).in_units(dimension, &deck, &study);
        let rate = Dimension::new(1, 0, -1, 0, 0);
        let near = |found: Result<f64, Diagnostic>, wanted: f64| {
            let found = found.expect("a unit of this dimension");
            assert!(
                (found - wanted).abs() < 1e-12 * wanted.abs(),
                "{found} {wanted}"
            );
        };
        near(of("3 mm", Dimension::LENGTH), 3.0);
        near(of("3", Dimension::LENGTH), 3.0);
        near(of("-0.3cm", Dimension::LENGTH), -3.0);
        near(of("2 kN/m", rate), 2.0);
        near(
            of("1 Nm/deg", Dimension::new(1, 0, 1, 0, -1)),
            1e3_f64.to_degrees(),
        );
        near(of("90 deg", Dimension::ANGLE), 90f64.to_radians());
        assert!(of("3 mm", rate).is_err() && of("3 ells", rate).is_err());
        near(quantity("10 %").plain(&study), 0.1);
        assert!(quantity("10 mm").plain(&study).is_err());
        let none = SpannedText {
            text: "mm".to_string(),
            span: Span::at(0),
        };
        assert_eq!(Quantity::of(none), None);
    }
}
