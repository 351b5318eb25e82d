//! Descriptions of statements, arguments and functions as plain text, from the grammar.

use std::fmt::Write as _;

use super::spell_like;
use crate::grammar::{
    ArgumentDef, Bound, Count, FunctionDef, Presence, Role, Solved, StatementDef, ValueKind,
};
use crate::units::Dimension;

fn line(out: &mut String, text: &str) {
    out.push_str(text.trim_end());
    out.push('\n');
}

/// Formats a keyword with its shortest legal abbreviation in capitals and its other letters in lower case: `BUshing`.
pub fn minimal(name: &str, minimum: usize) -> String {
    let cut = minimum.min(name.len());
    format!("{}{}", &name[..cut], name[cut..].to_ascii_lowercase())
}

/// Returns the description of a statement or command.
pub fn statement(def: &StatementDef) -> String {
    let mut text = String::new();
    let out = &mut text;
    let id = if def.id.is_some() { "/id" } else { "/" };
    line(out, &format!("{}{id}", minimal(def.name, def.minimum)));
    line(out, &format!("  {}", def.doc));
    line(
        out,
        match def.role {
            Role::Dataset => "  Used in a dataset.",
            Role::Command => "  Used in a command file.",
            Role::Both => "  Used in a dataset; in a command file, it redefines the object.",
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
        let unchecked = format!(
            "  Not verified against the documentation: {}.",
            def.unchecked
        );
        line(out, &unchecked);
    }
    text
}

/// Returns the description of a function.
pub fn function(def: &FunctionDef) -> String {
    let mut text = String::new();
    let out = &mut text;
    let call = if def.arguments.is_empty() {
        def.name.to_string()
    } else {
        format!("{}({})", def.name, def.arguments)
    };
    line(out, &call);
    line(out, &format!("  {}", def.doc));
    line(out, &format!("  {}", solved(def.solved)));
    line(out, &format!("  Source: {}", def.source));
    text
}

/// Returns a sentence that says which solver handles the statement or function.
pub fn solved(solved: Solved) -> String {
    match solved {
        Solved::Native(what) => format!("Solved by the built-in solver ({what})."),
        Solved::NoEffect(why) => format!("No effect on statics: {why}."),
        Solved::External(why) | Solved::Subroutine(why) => {
            format!("Solved only by real ADAMS: {why}.")
        }
    }
}

/// Formats the type and count of an argument's value, for example ` = real[3]`; empty for a flag.
pub fn value(argument: &ArgumentDef) -> String {
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

/// Returns further facts about an argument: whether it is required, its default, dimension and bounds.
pub fn details(argument: &ArgumentDef) -> Vec<String> {
    let mut all = Vec::new();
    if argument.required {
        all.push("required".to_string());
    }
    if !argument.default.is_empty() {
        let shown: Vec<String> = argument
            .default
            .iter()
            .map(|value| match argument.dimension {
                // Angles are shown in degrees, although the grammar holds them in radians.
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

/// Formats a dimension in words, such as `force/length` or `mass length^2`; empty for a dimensionless number.
pub(crate) fn dimension_words(dimension: Dimension) -> String {
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
