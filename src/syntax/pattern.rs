//! Address patterns, which match several addresses at once: `BUSHING/*.K.1`, `front_*.KT.*`.

use glob::{MatchOptions, Pattern};

use super::address::argument;
use super::{Address, Argument, Dataset, Statement, Value};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{Lookup, Role, find_statement};
use crate::text::Span;

const ANY_CASE: MatchOptions = MatchOptions {
    case_sensitive: false,
    require_literal_separator: false,
    require_literal_leading_dot: false,
};

impl Address {
    /// Returns true if a text is a pattern: it contains `*` (any text), `?` (any character) or brackets such as `[1-5]` (one of several
    /// characters).
    pub fn is_pattern(text: &str) -> bool {
        text.contains(['*', '?', '['])
    }

    /// Returns all addresses that match a pattern, in the order of the dataset. A text that is not a pattern is parsed as a single address.
    ///
    /// A pattern matches ids (`BUSHING/*`, `BUSHING/1?`) or ADAMS/View names (`front_*`). An index `*` after the argument matches all of
    /// its values. An object matches by its name only if its statement contains the argument.
    ///
    /// # Errors
    /// Returns the errors of [`Address::parse`], and `undefined-id` if nothing matches.
    pub fn matching(text: &str, dataset: &Dataset) -> Result<Vec<Self>, Diagnostic> {
        let text = text.trim();
        if !Self::is_pattern(text) {
            return Ok(vec![Self::parse(text, dataset)?]);
        }
        let (whole, places) = match text.strip_suffix(".*") {
            // A final star denotes all values of an argument, provided that an argument precedes it.
            Some(before) if before.contains('.') => (before, true),
            _ => (text, false),
        };
        let found = if Self::is_pattern(whole) {
            objects(whole, dataset)?
        } else {
            vec![Self::parse(whole, dataset)?]
        };
        let found: Vec<Self> = if places {
            found
                .iter()
                .flat_map(|address| every_place(address, dataset))
                .collect()
        } else {
            found
        };
        if found.is_empty() {
            return Err(refused(
                Code::UndefinedId,
                format!("nothing in this dataset matches {text}"),
                text,
            ));
        }
        Ok(found)
    }
}

fn refused(code: Code, message: String, text: &str) -> Diagnostic {
    Diagnostic::error(code, message)
        .label("address", Span::new(0, text.len()), "")
        .help("* stands for any text, ? for one character: BUSHING/*.K.1, front_*.KT")
}

fn compiled(pattern: &str, text: &str) -> Result<Pattern, Diagnostic> {
    Pattern::new(pattern.trim()).map_err(|error| {
        refused(
            Code::SyntaxError,
            format!("{text} is not a valid pattern: {error}"),
            text,
        )
    })
}

/// Returns the addresses that match a pattern; a final star for all values was already removed from the pattern.
fn objects(text: &str, dataset: &Dataset) -> Result<Vec<Address>, Diagnostic> {
    if let Some((keyword, rest)) = text.split_once('/')
        && let Lookup::Found(def) = find_statement(keyword.trim().as_bytes(), Role::Dataset)
    {
        let (ids, rest) = rest.split_once('.').unwrap_or((rest, ""));
        let ids = compiled(ids, text)?;
        // The argument is parsed even if no id matches, so that an error in it is reported.
        argument(def, None, rest, text)?;
        return dataset
            .statements()
            .iter()
            .filter(|statement| statement.kind() == Some(def.name))
            .filter_map(Statement::number)
            .filter(|id| ids.matches(&id.to_string()))
            .map(|id| argument(def, Some(id), rest, text))
            .collect();
    }
    let ends = std::iter::once(text.len()).chain(text.rmatch_indices('.').map(|(at, _)| at));
    for end in ends.take(8) {
        let names = compiled(&text[..end], text)?;
        let rest = text[end..].trim_start_matches('.');
        let found: Vec<Address> = dataset
            .view_names()
            .filter(|(name, _)| names.matches_with(name, ANY_CASE))
            .filter_map(|(_, statement)| {
                let address = argument(statement.def?, statement.number(), rest, text).ok()?;
                let written = address
                    .argument
                    .as_ref()
                    .is_none_or(|name| statement.has(name));
                written.then_some(address)
            })
            .collect();
        if !found.is_empty() {
            return Ok(found);
        }
    }
    Ok(Vec::new())
}

/// Returns one address for each value of an argument.
fn every_place(address: &Address, dataset: &Dataset) -> Vec<Address> {
    let name = address.argument.as_deref().unwrap_or("FUNCTION");
    let count = dataset.find(address).map_or(0, |statement| {
        match statement.argument(name).map(|argument| &argument.value) {
            Some(Value::Function(expression)) => expression.literals.len(),
            _ => statement.all(name).flat_map(Argument::numbers).count(),
        }
    });
    (1..=count)
        .map(|index| Address {
            index: Some(index),
            ..address.clone()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::Source;

    fn found(text: &str) -> String {
        let deck = "t\n! adams_view_name='front_left'\nBUSHING/1, I=1, J=2, K=1,2,3\n! adams_view_name='front_right'\n\
                    BUSHING/12, I=1, J=2, K=4,5,6\nBUSHING/3, I=1, J=2\n! adams_view_name='front'\nSFORCE/3, I=1, J=2, ROT, FUNCTION=2*TIME+3\nEND\n";
        let dataset = Dataset::parse(Source::new("a.adm", deck.as_bytes())).value;
        match Address::matching(text, &dataset) {
            Ok(all) => all
                .iter()
                .map(Address::to_string)
                .collect::<Vec<_>>()
                .join(" "),
            Err(refused) => format!("{}: {}", refused.code, refused.message),
        }
    }

    #[test]
    fn ids_names_and_places() {
        assert_eq!(
            found("BUSHING/*.K.1"),
            "BUSHING/1.K.1 BUSHING/12.K.1 BUSHING/3.K.1"
        );
        assert_eq!(found("bu/1?.k"), "BUSHING/12.K");
        assert_eq!(found("front_*.K.2"), "BUSHING/1.K.2 BUSHING/12.K.2");
        assert_eq!(found("FRONT*.K"), "BUSHING/1.K BUSHING/12.K");
        assert_eq!(
            found("BUSHING/12.K.*"),
            "BUSHING/12.K.1 BUSHING/12.K.2 BUSHING/12.K.3"
        );
        assert_eq!(
            found("front.FUNCTION.*"),
            "SFORCE/3.FUNCTION.1 SFORCE/3.FUNCTION.2"
        );
        assert_eq!(found("BUSHING/*"), "BUSHING/1 BUSHING/12 BUSHING/3");
        assert!(found("BUSHING/*.KK").starts_with("unknown-argument"));
        assert!(found("rear_*.K").starts_with("undefined-id"));
        assert!(found("JOINT/*").starts_with("undefined-id"));
    }
}
