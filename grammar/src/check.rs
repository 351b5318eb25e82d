use std::collections::{BTreeMap, BTreeSet};

use crate::declaration::{Grammar, Keyword, Value};
use crate::parse::{ParseError, Problem};

/// Checks the rules that involve several lines of the grammar.
///
/// Names of statements, arguments and functions must be unique. A reference must name an existing id space. Presence rules, laws and
/// `leftout` lines must name arguments of their own statement. The shortest legal abbreviations of all keywords in the same context must
/// differ.
pub(crate) fn check(grammar: &Grammar) -> Result<(), ParseError> {
    let spaces: BTreeSet<&str> = grammar
        .statements
        .iter()
        .filter_map(|s| s.id.as_deref())
        .collect();
    let mut names = BTreeSet::new();
    for statement in &grammar.statements {
        let fail = |problem| ParseError {
            file: statement.place.0.clone(),
            line: statement.place.1,
            problem,
        };
        if !names.insert(statement.keyword.name.as_str()) {
            return Err(fail(Problem::Twice(statement.keyword.name.clone())));
        }
        let keywords: Vec<&Keyword> = statement.arguments.iter().map(|a| &a.keyword).collect();
        clash(&keywords).map_err(fail)?;
        for argument in &statement.arguments {
            match &argument.value {
                Value::Reference(space) if !spaces.contains(space.as_str()) => {
                    return Err(fail(Problem::Unknown(space.clone())));
                }
                Value::Word(choices) => clash(&choices.iter().collect::<Vec<_>>()).map_err(fail)?,
                _ => {}
            }
        }
        let presence = statement.presence.iter().flat_map(|p| &p.names);
        let laws = statement.laws.iter();
        let numbers = laws.flat_map(|law| law.arguments.iter().chain(&law.flag));
        let left_out = statement.left_out.iter().flat_map(|left| &left.names);
        for name in presence.chain(numbers).chain(left_out) {
            if !keywords.iter().any(|k| k.name == *name) {
                return Err(fail(Problem::Unknown(name.clone())));
            }
        }
    }
    clash(
        &grammar
            .statements
            .iter()
            .map(|s| &s.keyword)
            .collect::<Vec<_>>(),
    )
    .map_err(|problem| ParseError {
        file: "grammar".into(),
        line: 0,
        problem,
    })?;
    let mut functions = BTreeSet::new();
    for function in &grammar.functions {
        if !functions.insert(function.name.as_str()) {
            return Err(ParseError {
                file: function.place.0.clone(),
                line: function.place.1,
                problem: Problem::Twice(function.name.clone()),
            });
        }
    }
    Ok(())
}

fn clash(keywords: &[&Keyword]) -> Result<(), Problem> {
    let mut shortest: BTreeMap<&str, &str> = BTreeMap::new();
    for keyword in keywords {
        if let Some(other) = shortest.insert(&keyword.name[..keyword.minimum], &keyword.name) {
            return Err(if other == keyword.name {
                Problem::Twice(other.to_string())
            } else {
                Problem::Clash(other.to_string(), keyword.name.clone())
            });
        }
    }
    Ok(())
}
