use std::fmt::Write as _;

use clap_complete::{ArgValueCompleter, CompletionCandidate};

use crate::diagnostic::Code;
use crate::grammar::{
    ArgumentDef, Bound, Count, FUNCTIONS, FunctionDef, Lookup, Presence, Role, STATEMENTS, Solved,
    StatementDef, ValueKind, find_function, find_statement, nearest,
};
use crate::syntax::spell_like;
use crate::units::Dimension;

use super::Outcome;
use super::shell::{Exit, Shell};

/// Say what a statement, a command, a function or a complaint's code means.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// `BUSHING`, `simulate`, `AZ`, `undefined-id`, ... Nothing lists them all.
    #[arg(add = ArgValueCompleter::new(complete))]
    word: Option<String>,
}

/// Prints the page of a word.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let Some(word) = &arguments.word else {
        shell.print(&list());
        return Ok(Exit::Fine);
    };
    match page(word) {
        Ok(text) => {
            shell.print(&text);
            Ok(Exit::Fine)
        }
        Err(text) => {
            shell.print(&text);
            Err(Exit::Findings)
        }
    }
}

/// Keywords, functions and codes that begin with what was typed.
fn complete(current: &std::ffi::OsStr) -> Vec<CompletionCandidate> {
    let typed = current.to_string_lossy();
    let statements = STATEMENTS.iter().map(|def| def.name);
    let functions = FUNCTIONS.iter().map(|def| def.name);
    let codes = Code::ALL.iter().map(|code| code.as_str());
    statements
        .chain(functions)
        .chain(codes)
        .filter(|word| {
            word.get(..typed.len())
                .is_some_and(|start| start.eq_ignore_ascii_case(&typed))
        })
        .map(CompletionCandidate::new)
        .collect()
}

fn list() -> String {
    let mut out =
        String::from("Statements and commands (the letters that must be typed are capitals):\n");
    for def in STATEMENTS {
        line(
            &mut out,
            &format!("  {:24} {}", minimal(def.name, def.minimum), def.doc),
        );
    }
    out.push_str("\nFunctions:\n");
    for def in FUNCTIONS {
        line(&mut out, &format!("  {:24} {}", def.name, def.doc));
    }
    out.push_str("\nCodes of complaints:\n");
    for code in Code::ALL {
        let first = code.explain().trim().lines().next().unwrap_or_default();
        line(
            &mut out,
            &format!("  {:24} {}", code.as_str(), first.trim()),
        );
    }
    out
}

/// The page of a word, or what to say when there is none.
fn page(word: &str) -> Result<String, String> {
    let mut out = String::new();
    if let Some(code) = Code::ALL
        .iter()
        .find(|code| code.as_str().eq_ignore_ascii_case(word))
    {
        line(&mut out, code.as_str());
        for text in code.explain().lines() {
            line(&mut out, &format!("  {}", text.trim()));
        }
        return Ok(out);
    }
    let statement = find_statement(word.as_bytes(), Role::Both);
    if let Lookup::Found(def) = statement {
        describe_statement(&mut out, def);
    }
    if let Some(def) = find_function(word.as_bytes()) {
        if !out.is_empty() {
            out.push('\n');
        }
        describe_function(&mut out, def);
    }
    if !out.is_empty() {
        return Ok(out);
    }
    if let Lookup::Ambiguous(names) = statement {
        return Err(format!("`{word}` may be {}\n", names.join(", ")));
    }
    let names = STATEMENTS
        .iter()
        .map(|def| def.name)
        .chain(FUNCTIONS.iter().map(|def| def.name))
        .chain(Code::ALL.iter().map(|code| code.as_str()));
    // Spelling is compared in capitals.
    let capitals: Vec<(String, &str)> = names
        .map(|name| (name.to_ascii_uppercase(), name))
        .collect();
    let near = nearest(word, capitals.iter().map(|(upper, _)| upper.as_str()))
        .and_then(|upper| capitals.iter().find(|(name, _)| name == upper))
        .or_else(|| {
            let begins = |name: &str| !word.is_empty() && name.starts_with(&word.to_uppercase());
            capitals.iter().find(|(name, _)| begins(name))
        });
    Err(match near {
        Some((_, name)) => format!("nothing is called `{word}`; did you mean `{name}`?\n"),
        None => format!("nothing is called `{word}`; `admire explain` lists all there is\n"),
    })
}

fn line(out: &mut String, text: &str) {
    out.push_str(text.trim_end());
    out.push('\n');
}

/// The letters that must be typed as capitals, the others small: `BUshing`.
fn minimal(name: &str, minimum: usize) -> String {
    let cut = minimum.min(name.len());
    format!("{}{}", &name[..cut], name[cut..].to_ascii_lowercase())
}

fn describe_statement(out: &mut String, def: &StatementDef) {
    let id = if def.id.is_some() { "/id" } else { "/" };
    line(out, &format!("{}{id}", minimal(def.name, def.minimum)));
    line(out, &format!("  {}", def.doc));
    line(
        out,
        match def.role {
            Role::Dataset => "  Stands in a dataset.",
            Role::Command => "  Stands in a command file.",
            Role::Both => "  Stands in a dataset, and in a command file to redefine.",
        },
    );
    line(out, &format!("  {}", solved(def.solved)));
    if !def.arguments.is_empty() {
        line(out, "");
    }
    for argument in def.arguments {
        let head = format!(
            "{}{}",
            minimal(argument.name, argument.minimum),
            value(argument)
        );
        line(out, &format!("  {head:38} {}", argument.doc));
        let more = details(argument);
        if !more.is_empty() {
            line(out, &format!("  {:38} ({})", "", more.join("; ")));
        }
    }
    for presence in def.presence {
        let (rule, names) = match presence {
            Presence::Exclusive(names) => ("at most one of", names),
            Presence::Together(names) => ("all or none of", names),
            Presence::OneOf(names) => ("exactly one of", names),
            Presence::Requires(names) => {
                let (first, others) = names.split_first().expect("a rule names arguments");
                line(out, &format!("  {first} needs {}", others.join(", ")));
                continue;
            }
        };
        line(out, &format!("  {rule} {}", names.join(", ")));
    }
    line(out, &format!("\n  Source: {}", def.source));
    if !def.unchecked.is_empty() {
        let text = format!("  Not compared with the documentation: {}.", def.unchecked);
        line(out, &text);
    }
}

fn describe_function(out: &mut String, def: &FunctionDef) {
    let call = if def.arguments.is_empty() {
        def.name.to_string()
    } else {
        format!("{}({})", def.name, def.arguments)
    };
    line(out, &call);
    line(out, &format!("  {}", def.doc));
    line(out, &format!("  {}", solved(def.solved)));
    line(out, &format!("  Source: {}", def.source));
}

fn solved(solved: Solved) -> String {
    match solved {
        Solved::Native(what) => format!("Solved by the built-in solver ({what})."),
        Solved::NoEffect(why) => format!("No effect on statics: {why}."),
        Solved::External(why) => format!("Only real ADAMS: {why}."),
    }
}

fn value(argument: &ArgumentDef) -> String {
    let kind = match argument.kind {
        ValueKind::Flag => return String::new(),
        ValueKind::Real => "real".to_string(),
        ValueKind::Integer => "integer".to_string(),
        ValueKind::Reference(space) => format!("{space} id"),
        ValueKind::Choice(choices) => choices
            .iter()
            .map(|choice| minimal(choice.name, choice.minimum))
            .collect::<Vec<_>>()
            .join("|"),
        ValueKind::Function => "function".to_string(),
        ValueKind::Text => "text".to_string(),
        ValueKind::TextList => "text:text:...".to_string(),
        ValueKind::File => "file".to_string(),
    };
    let count = match argument.count {
        Count {
            min: 1,
            max: Some(1),
        } => String::new(),
        Count {
            min,
            max: Some(max),
        } if min == max => format!("[{min}]"),
        Count {
            min,
            max: Some(max),
        } => format!("[{min}..{max}]"),
        Count { min, max: None } => format!("[{min}..]"),
    };
    format!(" = {kind}{count}")
}

fn details(argument: &ArgumentDef) -> Vec<String> {
    let mut all = Vec::new();
    if argument.required {
        all.push("required".to_string());
    }
    if !argument.default.is_empty() {
        let shown: Vec<String> = argument
            .default
            .iter()
            .map(|value| match argument.dimension {
                // As people write angles.
                Dimension::ANGLE if *value != 0.0 => spell_like(*value, b"1D"),
                _ => value.to_string(),
            })
            .collect();
        all.push(format!("default {}", shown.join(", ")));
    }
    let dimension = dimension_words(argument.dimension);
    if !dimension.is_empty() {
        all.push(dimension);
    }
    match argument.lower {
        Bound::Open => {}
        Bound::Inclusive(bound) => all.push(format!(">= {bound}")),
        Bound::Exclusive(bound) => all.push(format!("> {bound}")),
    }
    match argument.upper {
        Bound::Open => {}
        Bound::Inclusive(bound) => all.push(format!("<= {bound}")),
        Bound::Exclusive(bound) => all.push(format!("< {bound}")),
    }
    all
}

/// `force/length`, `mass length^2`; empty for a pure number.
fn dimension_words(dimension: Dimension) -> String {
    let all = [
        ("force", dimension.force),
        ("mass", dimension.mass),
        ("length", dimension.length),
        ("time", dimension.time),
        ("angle", dimension.angle),
    ];
    let mut out = String::new();
    for (word, exponent) in all.iter().filter(|(_, e)| *e > 0) {
        let _ = write!(out, " {word}");
        if *exponent > 1 {
            let _ = write!(out, "^{exponent}");
        }
    }
    let mut out = out.trim().to_string();
    for (word, exponent) in all.iter().filter(|(_, e)| *e < 0) {
        if out.is_empty() {
            out.push('1');
        }
        let _ = write!(out, "/{word}");
        if *exponent < -1 {
            let _ = write!(out, "^{}", -exponent);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_their_page() {
        let text = page("Undefined-Id").unwrap();
        assert!(
            text.starts_with("undefined-id\n  An id that no statement"),
            "{text}"
        );
        assert!(
            page("undefined-ids")
                .unwrap_err()
                .contains("`undefined-id`")
        );
    }

    #[test]
    fn dimensions_are_words() {
        assert_eq!(dimension_words(Dimension::NONE), "");
        assert_eq!(
            dimension_words(Dimension::new(1, 0, 1, 0, -1)),
            "force length/angle"
        );
        assert_eq!(
            dimension_words(Dimension::new(0, 0, 1, -2, 0)),
            "length/time^2"
        );
    }
}
