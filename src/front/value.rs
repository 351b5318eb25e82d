//! Values in a deck, by address.

use serde_json::{Value, json};

use admire_syntax as syntax;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::{STATEMENTS, ValueKind};
use admire_syntax::units::Dimension;
use admire_syntax::{Address, Argument, Dataset};

/// Returns the value at an address: a number, a list of numbers, a text, or the statement as written. If the argument is missing in the
/// deck, its default value is returned.
pub(crate) fn value(
    dataset: &Dataset,
    address: &Address,
    degrees: bool,
) -> Result<Value, Diagnostic> {
    let source = dataset.source();
    if address.kind == "TITLE" {
        return Ok(json!(dataset.title()));
    }
    let statement = dataset.find(address);
    let Some(name) = &address.argument else {
        return Ok(statement.map_or(Value::Null, |found| json!(source.text(found.span))));
    };
    let def = STATEMENTS
        .iter()
        .find(|def| def.name == address.kind)
        .and_then(|def| def.arguments.iter().find(|argument| argument.name == name));
    let whole =
        def.is_some_and(|def| matches!(def.kind, ValueKind::Integer | ValueKind::Reference(_)));
    let in_degrees = degrees && is_angle(address, dataset);
    let number = |value: f64| {
        let value = if in_degrees {
            rounded(value.to_degrees())
        } else {
            value
        };
        if whole && value.fract() == 0.0 {
            json!(value as i64)
        } else {
            json!(value)
        }
    };
    if let Some(value) = dataset.value_at(address) {
        return Ok(number(value));
    }
    let written = statement.and_then(|statement| Some((statement, statement.argument(name)?)));
    let Some((statement, argument)) = written else {
        let default = def.map_or(&[][..], |def| def.default);
        return match address.index {
            Some(index) => {
                let room = def.and_then(|def| def.count.max);
                match default.get(index - 1) {
                    Some(value) => Ok(number(*value)),
                    None if room.is_none_or(|most| index <= most) => Ok(Value::Null),
                    None => Err(beyond(address, room)),
                }
            }
            None if default.is_empty() => Ok(Value::Null),
            None => Ok(default.iter().copied().map(number).collect()),
        };
    };
    let numbers: Vec<Value> = statement
        .all(name)
        .flat_map(Argument::numbers)
        .map(|one| number(one.value))
        .collect();
    let texts = argument.texts(source);
    let mut values = if numbers.is_empty() {
        texts.iter().map(|text| json!(text)).collect()
    } else {
        numbers
    };
    match address.index {
        Some(index) if index <= values.len() => Ok(values.swap_remove(index - 1)),
        Some(_) => {
            let literals = match &argument.value {
                syntax::Value::Function(expression) => expression.literals.len(),
                _ => values.len(),
            };
            Err(beyond(address, Some(literals)).label(source.name(), argument.span, ""))
        }
        None => Ok(match (values.len(), argument.text(source)) {
            (0, Some(text)) => json!(text),
            (0, None) => match &argument.value {
                syntax::Value::Flag => json!(true),
                _ => json!(source.text(argument.value_span())),
            },
            (1, _) => values.swap_remove(0),
            _ => Value::Array(values),
        }),
    }
}

/// Creates the error for an index that exceeds the number of values in the argument.
fn beyond(address: &Address, count: Option<usize>) -> Diagnostic {
    let count = count.unwrap_or(0);
    let what = Address {
        index: None,
        ..address.clone()
    };
    let values = if count == 1 { "value" } else { "values" };
    Diagnostic::error(
        Code::OutOfRange,
        format!("{address} does not exist: {what} has {count} {values}"),
    )
}

/// Returns true if the value at the address is an angle. A number inside a function is an angle only if it has the suffix D for degrees.
pub(crate) fn is_angle(address: &Address, dataset: &Dataset) -> bool {
    match address.definition() {
        Some(def) if def.kind == ValueKind::Real => def.dimension == Dimension::ANGLE,
        Some(def) if def.kind == ValueKind::Function => {
            address.index.is_some()
                && dataset
                    .number_at(address)
                    .is_some_and(|number| number.degrees)
        }
        _ => false,
    }
}

/// Rounds a computed number to fifteen significant digits, so that rounding errors do not appear in a deck.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// Parses an address typed by the user; errors refer to the typed text.
pub(crate) fn address(text: &str, dataset: &Dataset) -> Result<Address, Diagnostic> {
    Address::parse(text, dataset).map_err(|refused| typed(refused, text))
}

/// Adapts a diagnostic to a text typed by the user, which is in no file.
pub(crate) fn typed(mut refused: Diagnostic, text: &str) -> Diagnostic {
    refused.labels.clear();
    refused.message = format!("`{text}`: {}", refused.message);
    refused
}
