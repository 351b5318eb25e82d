//! Measured curves for comparison with K&C tests.

use admire_kc::{Config, unit_in_deck};
use admire_report::MeasuredCurve;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::units::Units;

/// Reads a table with the columns `test`, `value` and characteristics.
///
/// The heading of a column may end in a unit as in `curves.csv`, such as `[deg]`. Without a unit, values are in the deck's units and
/// radians. Cells may be empty. Commas, semicolons and tabs are accepted as separators; with the latter two, decimals may have commas.
pub(crate) fn measured(
    source: &Source,
    config: &Config,
    units: &Units,
) -> Result<Checked<Vec<MeasuredCurve>>, Diagnostic> {
    let path = source.name();
    let refuse =
        |message: String| Diagnostic::error(Code::BadNumber, format!("`{path}`: {message}"));
    let bytes = source.bytes();
    let head = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let separator = [b';', b'\t']
        .into_iter()
        .find(|s| head.contains(s))
        .unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .comment(Some(b'#'))
        .from_reader(bytes);
    let heads = reader
        .headers()
        .map_err(|error| refuse(error.to_string()))?
        .clone();
    let find = |name: &str| {
        heads
            .iter()
            .position(|head| head.trim().eq_ignore_ascii_case(name))
    };
    let (Some(test), Some(value)) = (find("test"), find("value")) else {
        return Err(refuse(
            "the columns `test` and `value` are needed".to_string(),
        ));
    };
    let mut columns = Vec::new();
    for (k, head) in heads.iter().enumerate() {
        let (path, unit) = head
            .split_once('[')
            .map_or((head, ""), |(a, b)| (a, b.trim_end_matches([']', ' '])));
        if k != test && k != value && path.contains('.') {
            let factor = unit_in_deck(unit.trim(), units);
            columns.push((k, path.trim().to_string(), factor));
        }
    }
    let mut curves: Vec<MeasuredCurve> = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| refuse(error.to_string()))?;
        let number = |k: usize| -> Result<Option<f64>, Diagnostic> {
            let text = record.get(k).unwrap_or_default().trim();
            if text.is_empty() {
                return Ok(None);
            }
            let text = if separator == b',' {
                text.to_string()
            } else {
                text.replace(',', ".")
            };
            match text.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(Some(value)),
                _ => Err(refuse(format!("row {}: `{text}` is not a number", row + 2))),
            }
        };
        let name = record.get(test).unwrap_or_default().trim();
        if !config.tests.iter().any(|(kind, _)| kind.name() == name) {
            continue;
        }
        let Some(at) = number(value)? else { continue };
        for (k, path, factor) in &columns {
            let Some(read) = number(*k)? else { continue };
            let point = (at, read * factor);
            match curves
                .iter_mut()
                .find(|c| c.test == name && c.path == *path)
            {
                Some(curve) => curve.points.push(point),
                None => curves.push(MeasuredCurve {
                    test: name.to_string(),
                    path: path.clone(),
                    points: vec![point],
                }),
            }
        }
    }
    let mut diagnostics = Vec::new();
    if curves.is_empty() {
        let message = format!("`{path}` has no curve of a test that is run");
        diagnostics.push(Diagnostic::warning(Code::MissingColumn, message));
    }
    Ok(Checked {
        value: curves,
        diagnostics,
    })
}
