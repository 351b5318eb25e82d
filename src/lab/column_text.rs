//! Text of an entry of a mapping: its line of TOML, with placeholders for missing words.

use super::characteristic::Target;
use super::column::Column;
use super::missing::Missing;
use admire_kc::Side;

/// Placeholder for a missing word.
pub(crate) const FILL_IN: &str = "?";

/// Returns a text as a TOML string.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

impl Column {
    /// Returns the line of the mapping for this column. Missing words are written as `?`, with the possible words in a comment above.
    pub(crate) fn line(&self, missing: &[Missing]) -> String {
        let mut pairs = Vec::new();
        let mut pair = |key: &str, value: Option<&str>| {
            if let Some(value) = value {
                pairs.push(format!("{key} = {}", quoted(value)));
            }
        };
        let or_mark = |value: Option<&str>, point: Missing| {
            let mark = missing.contains(&point).then_some(FILL_IN);
            mark.or(value).map(str::to_string)
        };
        pair("is", self.is.map(Target::word));
        pair("load", self.load.as_deref());
        let sign = self
            .load_sign
            .map(|sign| if sign < 0.0 { "-" } else { "+" });
        pair("load_sign", or_mark(sign, Missing::LoadSign).as_deref());
        let side = or_mark(self.side.map(Side::word), Missing::Side);
        pair("side", side.as_deref());
        let unit = or_mark(self.unit.as_deref(), Missing::Unit);
        pair("unit", unit.as_deref());
        let positive = or_mark(self.positive.as_deref(), Missing::Positive);
        pair("positive", positive.as_deref());
        if missing.contains(&Missing::OverMm) {
            pairs.push(format!("over_mm = {}", quoted(FILL_IN)));
        } else if let Some(over) = self.over_mm {
            pairs.push(format!("over_mm = {over:?}"));
        }
        let wanted = missing.iter().map(|point| filled(&point.wanted(self)));
        let remarks: String = wanted.collect();
        format!(
            "{remarks}{} = {{ {} }}",
            quoted(&self.name),
            pairs.join(", ")
        )
    }
}

/// Returns a comment line that states what must be filled in. The comment is above its line, so that a narrow terminal does not wrap the line.
pub(crate) fn filled(wanted: &str) -> String {
    format!("# FILL IN {wanted}\n")
}
