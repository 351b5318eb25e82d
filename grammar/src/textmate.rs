//! The TextMate grammar of datasets and command files, for the colours of editors.
//!
//! `adams.tmLanguage.json` beside this file contains the rules common to all statements. This module adds one rule for each statement of a dataset
//! and of a command file, with the keywords of its arguments in every legal abbreviation.

use std::fmt::Write;

use crate::declaration::{Argument, Grammar, Keyword, Statement, Value};

const TEMPLATE: &str = include_str!("adams.tmLanguage.json");

/// Regular expression for the text that follows a keyword without a value, such as a flag.
const ALONE: &str = r"\b(?=\s*(?:[,:;)&!\\]|$))";

/// End of a statement: a semicolon, or a line that is no continuation, comment or blank.
const END: &str = r";|^(?!\s*(?:[,!]|$))";

/// Continuation mark: `&`, or a comma, unless the next line begins like a statement.
const CONTINUES: &str = r"(?:(&)|,)\s*(!.*)?\n";
const CONTINUED: &str = r"(?i)(?<!\n)$|^(?=\s*[A-Z]\w*\s*/|\s*END\s*$)";

/// Returns the text of `src/lsp/vscode/syntaxes/adams.tmLanguage.json`.
pub fn textmate(grammar: &Grammar) -> String {
    let of = |role: &str| -> Vec<&Statement> {
        let all = grammar.statements.iter();
        all.filter(|s| s.role == role || s.role == "Both").collect()
    };
    let (dataset, commands) = (of("Dataset"), of("Command"));
    let arguments: String = grammar.statements.iter().map(arguments).collect();
    let named = |with_arguments: bool| -> String {
        let all = grammar.functions.iter();
        let some = all.filter(|f| f.arguments.is_empty() != with_arguments);
        some.map(|f| f.name.as_str()).collect::<Vec<_>>().join("|")
    };
    let keywords: Vec<&Keyword> = commands.iter().map(|s| &s.keyword).collect();
    let command = spellings(&keywords, &keywords).replace('\\', r"\\");
    TEMPLATE
        .replace("\"@dataset@\"", &statements(&dataset))
        .replace("\"@commands@\"", &statements(&commands))
        .replace("@command@", &command)
        .replace("\"@arguments@\": {}", arguments.trim_end_matches(",\n"))
        .replace("@functions@", &named(true))
        .replace("@names@", &named(false))
}

/// Returns the rules that recognise the statements of one kind of file.
fn statements(statements: &[&Statement]) -> String {
    let keywords: Vec<&Keyword> = statements.iter().map(|s| &s.keyword).collect();
    let mut out = String::new();
    for statement in statements {
        let name = statement.keyword.name.to_lowercase();
        let begin = format!(
            r"(?i)(?:^|(?<=;))\s*({})\b(?=\s*(?:[/,;&!]|$))",
            spellings(&[&statement.keyword], &keywords)
        );
        let id = match statement.id {
            Some(_) => r##"{ "include": "#id" }, "##,
            None => "",
        };
        let _ = write!(
            out,
            "{}        {{ \"name\": \"meta.statement.{name}.adams\", \"begin\": {begin:?}, \"end\": {END:?},\n          \
             \"beginCaptures\": {{ \"1\": {{ \"name\": \"keyword.control.adams\" }} }},\n          \
             \"patterns\": [{id}{{ \"include\": \"#{name}\" }}] }}",
            if out.is_empty() { "" } else { ",\n" },
        );
    }
    out.trim_start().to_string()
}

/// Returns the entry of the repository that recognises the arguments of a statement.
fn arguments(statement: &Statement) -> String {
    let all: Vec<&Keyword> = statement.arguments.iter().map(|a| &a.keyword).collect();
    let some = |wanted: &dyn Fn(&Argument) -> bool| {
        let chosen = statement.arguments.iter().filter(|a| wanted(a));
        spellings(&chosen.map(|a| &a.keyword).collect::<Vec<_>>(), &all)
    };
    let mut words: Vec<String> = Vec::new();
    for argument in &statement.arguments {
        if let Value::Word(choices) = &argument.value {
            let choices: Vec<&Keyword> = choices.iter().collect();
            for choice in &choices {
                let spelling = spellings(&[choice], &choices);
                if !words.contains(&spelling) {
                    words.push(spelling);
                }
            }
        }
    }
    let is_text = |a: &Argument| matches!(a.value, Value::Text | Value::Texts | Value::File);
    // Each rule consists of the kind of keyword, all keywords of this kind, and the surrounding expression.
    let rules = [
        (
            "flag",
            some(&|a| a.value == Value::Flag),
            r"(?:^|([,/]))\s*(@)",
        ),
        (
            "text",
            some(&is_text),
            r#"\b(@)\s*(=)\s*([^\s",;&!](?:[^,;&!]*[^\s,;&!])?)"#,
        ),
        (
            "argument",
            some(&|a| a.value != Value::Flag),
            r"\b(@)\b(?=\s*=)",
        ),
        ("word", words.join("|"), r"([=:,(])\s*(@)"),
    ];
    let mut patterns = Vec::new();
    for (kind, words, shape) in rules {
        if words.is_empty() {
            continue;
        }
        let mut expression = format!("(?i){}", shape.replace('@', &words));
        let scopes: &[&str] = match kind {
            "flag" => &["punctuation.separator", "storage.modifier"],
            "text" => &["variable.parameter", "keyword.operator", "string.unquoted"],
            "word" => &["punctuation.separator", "constant.language"],
            _ => &["variable.parameter"],
        };
        let captures = (1..)
            .zip(scopes)
            .map(|(at, scope)| format!(r#""{at}": {{ "name": "{scope}.adams" }}"#));
        let captures = captures.collect::<Vec<_>>().join(", ");
        if matches!(kind, "flag" | "word") {
            expression += ALONE;
        }
        patterns.push(format!(
            "      {{ \"match\": {expression:?}, \"captures\": {{ {captures} }} }}"
        ));
    }
    let name = statement.keyword.name.to_lowercase();
    patterns.push(format!(
        "      {{ \"begin\": {CONTINUES:?}, \"end\": {CONTINUED:?}, \"applyEndPatternLast\": 1,\n        \
         \"beginCaptures\": {{ \"1\": {{ \"name\": \"punctuation.separator.continuation.adams\" }}, \"2\": {{ \"name\": \"comment.line.exclamation.adams\" }} }},\n        \
         \"patterns\": [{{ \"include\": \"#between\" }}, {{ \"include\": \"#{name}\" }}] }}"
    ));
    patterns.push(r##"      { "include": "#values" }"##.to_string());
    format!(
        "    \"{name}\": {{ \"patterns\": [\n{}\n    ] }},\n",
        patterns.join(",\n")
    )
}

/// Returns a regular expression for all spellings of the given keywords that are unambiguous among `all`.
fn spellings(keywords: &[&Keyword], all: &[&Keyword]) -> String {
    let each = keywords.iter().map(|keyword| spelling(keyword, all));
    each.collect::<Vec<_>>().join("|")
}

/// Returns a regular expression for the spellings of one keyword: those that `src/syntax/grammar/lookup.rs` resolves to it.
fn spelling(keyword: &Keyword, all: &[&Keyword]) -> String {
    let name = keyword.name.as_str();
    let extended = all
        .iter()
        .any(|k| k.name != name && k.name.starts_with(name));
    let mut out = String::new();
    let mut open = 0;
    for (at, letter) in name.char_indices() {
        if at > 0 && is_spelling(&name[..at], keyword, all) {
            out += "(?:";
            open += 1;
        }
        out.push(letter);
    }
    if name.len() >= 5 && !extended {
        out += r"\w*";
    }
    out + &")?".repeat(open)
}

/// Returns true if this beginning of a keyword is a legal abbreviation of this keyword, and of no other keyword in `all`.
fn is_spelling(typed: &str, keyword: &Keyword, all: &[&Keyword]) -> bool {
    let mut prefixed = all.iter().filter(|k| k.name.starts_with(typed));
    if all.iter().any(|k| k.name == typed) {
        return false;
    }
    let reached = all
        .iter()
        .filter(|k| k.name.starts_with(typed) && k.minimum <= typed.len());
    match reached.collect::<Vec<_>>().as_slice() {
        [] => prefixed.all(|k| k.name == keyword.name),
        [one] => one.name == keyword.name,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn abbreviations_are_those_of_the_lookup() {
        let keyword = |name: &str, minimum| Keyword {
            name: name.to_string(),
            minimum,
        };
        let (k, kt, torque, torsion) = (
            keyword("K", 1),
            keyword("KTX", 3),
            keyword("TORQUE", 4),
            keyword("TORSION", 4),
        );
        let all = [&k, &kt, &torque, &torsion];
        // `K` is a complete keyword. `KT` is the beginning of only one keyword, and `TOR` the beginning of two.
        assert_eq!(spelling(&k, &all), "K");
        assert_eq!(spelling(&kt, &all), "KT(?:X)?");
        assert_eq!(spelling(&torque, &all), r"TORQ(?:U(?:E\w*)?)?");
    }
}
