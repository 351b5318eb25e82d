//! Assignments on the command line, such as `BUSHING/*.K.1*=1.2`. With a pattern, one assignment sets the values at several addresses.

use crate::front::{is_angle, rounded};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Address, Argument, Dataset, Value, number, spell_like};

use super::shell::{Exit, Shell};

/// Operator before the equals sign.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Operator {
    Set,
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// Parsed assignment from the command line.
pub(super) struct Assignment<'a> {
    /// Text before the operator: an address or a pattern.
    pub left: &'a str,
    operator: Operator,
    value: &'a str,
}

impl<'a> Assignment<'a> {
    /// Returns the text before the operator; `None` if the text is not an assignment.
    pub(crate) fn left(text: &'a str) -> Option<&'a str> {
        Some(operator(text.split_once('=')?.0).0)
    }

    /// Parses an assignment.
    pub(crate) fn of(text: &'a str, shell: &Shell) -> Result<Self, Exit> {
        let Some((left, value)) = text.split_once('=') else {
            return Err(shell.usage(
                Diagnostic::error(Code::BadNumber, format!("`{text}` has no `=`"))
                    .help("write ADDRESS=VALUE, or ADDRESS*=FACTOR, +=, -=, /="),
            ));
        };
        let (left, operator) = operator(left);
        Ok(Self {
            left,
            operator,
            value: value.trim(),
        })
    }
}

impl Operator {
    fn apply(self, old: f64, operand: f64) -> f64 {
        match self {
            Self::Add => old + operand,
            Self::Subtract => old - operand,
            Self::Multiply => old * operand,
            Self::Divide => old / operand,
            Self::Set => operand,
        }
    }
}

impl Assignment<'_> {
    /// Returns the new text of a value. `old` is its current number, `None` if it is not a number. `written` is its current text. A computed number
    /// is written in the style of `written`.
    pub(super) fn reckoned(
        &self,
        address: &str,
        old: Option<f64>,
        written: &[u8],
        shell: &Shell,
    ) -> Result<String, Exit> {
        if self.operator == Operator::Set {
            return Ok(self.value.to_string());
        }
        let Some(operand) = plain_number(self.value) else {
            let message = format!(
                "`{}` is not a plain number, but *=, /=, += and -= need one",
                self.value
            );
            return Err(shell.usage(Diagnostic::error(Code::BadNumber, message)));
        };
        let Some(old) = old else {
            let message =
                format!("{address} is not a number, so *=, /=, += and -= cannot change it");
            return Err(shell.fail(Diagnostic::error(Code::WrongType, message)));
        };
        let new = rounded(self.operator.apply(old, operand));
        if !new.is_finite() {
            let message =
                format!("the new value of {address} would be {new}, which is not a finite number");
            return Err(shell.fail(Diagnostic::error(Code::OutOfRange, message)));
        }
        Ok(spell_like(new, written))
    }
}

/// Expands an assignment into plain assignments, each with an address and the text of its new value. With `degrees`, numbers for angles without a
/// suffix are in degrees.
pub(super) fn expanded(
    assignment: &str,
    dataset: &Dataset,
    degrees: bool,
    shell: &Shell,
) -> Result<Vec<(Address, String)>, Exit> {
    let assignment = Assignment::of(assignment, shell)?;
    let addresses = Address::matching(assignment.left, dataset).map_err(|mut refused| {
        refused.labels.clear();
        refused.message = format!("`{}`: {}", assignment.left, refused.message);
        shell.fail(refused)
    })?;
    evaluated(&assignment, addresses, dataset, degrees, shell)
}

/// Computes the new value of each address, as text.
pub(super) fn evaluated(
    assignment: &Assignment<'_>,
    addresses: Vec<Address>,
    dataset: &Dataset,
    degrees: bool,
    shell: &Shell,
) -> Result<Vec<(Address, String)>, Exit> {
    let Assignment {
        operator, value, ..
    } = *assignment;
    if operator == Operator::Set {
        return Ok(addresses
            .into_iter()
            .map(|address| {
                let text = match plain_number(value) {
                    Some(number) if degrees && is_angle(&address, dataset) => format!("{number}D"),
                    _ => value.to_string(),
                };
                (address, text)
            })
            .collect());
    }
    let Some((operand, has_suffix)) = number::parse_number(value.as_bytes()) else {
        return Err(shell.usage(Diagnostic::error(
            Code::BadNumber,
            format!("`{value}` is not a number, but *=, /=, += and -= need one"),
        )));
    };
    let mut all = Vec::new();
    for address in addresses
        .iter()
        .flat_map(|address| places(address, dataset))
    {
        let Some(old) = dataset.value_at(&address) else {
            let message =
                format!("{address} is not a number, so *=, /=, += and -= cannot change it");
            return Err(shell.fail(Diagnostic::error(Code::WrongType, message)));
        };
        // If an angle is written in degrees, its new value is computed in degrees, because values in degrees have fewer digits.
        let written = dataset
            .number_at(&address)
            .is_some_and(|number| number.degrees);
        let in_degrees = written || degrees && is_angle(&address, dataset);
        let old = if in_degrees {
            rounded(old.to_degrees())
        } else {
            old
        };
        // A number to add or subtract has the unit of the value. A factor is dimensionless.
        let term = match (in_degrees, degrees && !has_suffix) {
            (true, false) => rounded(operand.to_degrees()),
            _ => operand,
        };
        let new = match operator {
            Operator::Add | Operator::Subtract | Operator::Set => operator.apply(old, term),
            Operator::Multiply | Operator::Divide => operator.apply(old, operand),
        };
        if !new.is_finite() {
            let message =
                format!("the new value of {address} would be {new}, which is not a finite number");
            return Err(shell.fail(Diagnostic::error(Code::OutOfRange, message)));
        }
        let suffix = if in_degrees { "D" } else { "" };
        let new = rounded(new);
        // The new text follows the style of the old number. `spell_like` expects an angle in radians.
        let text = match dataset.number_at(&address) {
            Some(number) if written || !in_degrees => {
                let value = if in_degrees { new.to_radians() } else { new };
                spell_like(value, dataset.source().slice(number.span))
            }
            _ => format!("{new}{suffix}"),
        };
        all.push((address, text));
    }
    Ok(all)
}

/// Splits the text before the equals sign into address and operator. A star directly after a dot or slash belongs to the pattern.
fn operator(left: &str) -> (&str, Operator) {
    let left = left.trim();
    let Some(last) = left.chars().next_back() else {
        return (left, Operator::Set);
    };
    let before = &left[..left.len() - last.len_utf8()];
    let operator = match last {
        '*' if before.ends_with(['.', '/']) => return (left, Operator::Set),
        '*' => Operator::Multiply,
        '/' => Operator::Divide,
        '+' => Operator::Add,
        '-' => Operator::Subtract,
        _ => return (left, Operator::Set),
    };
    (before.trim_end(), operator)
}

/// Expands the address of an argument with several numbers into the addresses of these numbers.
fn places(address: &Address, dataset: &Dataset) -> Vec<Address> {
    let Some(name) = address
        .argument
        .as_deref()
        .filter(|_| address.index.is_none())
    else {
        return vec![address.clone()];
    };
    let count = dataset.find(address).map_or(0, |statement| {
        match statement.argument(name).map(|argument| &argument.value) {
            Some(Value::Numbers(_)) => statement.all(name).flat_map(Argument::numbers).count(),
            _ => 0,
        }
    });
    if count < 2 {
        return vec![address.clone()];
    }
    let place = |index| Address {
        index: Some(index),
        ..address.clone()
    };
    (1..=count).map(place).collect()
}

fn plain_number(value: &str) -> Option<f64> {
    number::parse_number(value.as_bytes())
        .filter(|(_, degrees)| !degrees)
        .map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_behind_dots_are_patterns() {
        let read = |text| {
            let (left, operator) = operator(text);
            let mark = match operator {
                Operator::Set => "=",
                Operator::Add => "+",
                Operator::Subtract => "-",
                Operator::Multiply => "*",
                Operator::Divide => "/",
            };
            format!("{left} {mark}")
        };
        assert_eq!(read("BUSHING/*.K.1*"), "BUSHING/*.K.1 *");
        assert_eq!(read("BUSHING/1.K.*"), "BUSHING/1.K.* =");
        assert_eq!(read("BUSHING/1.K.**"), "BUSHING/1.K.* *");
        assert_eq!(read("BUSHING/1.K.* *"), "BUSHING/1.K.* *");
        assert_eq!(read("arm.K /"), "arm.K /");
        assert_eq!(read("MARKER/1.QP.3-"), "MARKER/1.QP.3 -");
    }
}
