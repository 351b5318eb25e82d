use std::fmt::Write;

use crate::declaration::{
    Argument, Count, Grammar, Keyword, Law, LeftOut, Presence, Solved, Statement, Value,
};

/// Returns the Rust source text of `src/syntax/grammar/generated.rs`.
pub fn emit(grammar: &Grammar) -> String {
    let mut out = String::from(
        "//! Written by `cargo run -p grammar` from `grammar/*.grammar`. Do not edit.\n\n\
         use super::definition::{\n    ArgumentDef, Bound, Choice, Components, Count, FunctionDef, LawDef, LeftOut, Presence, Role,\n    Solved, StatementDef, ValueKind,\n};\n\
         use crate::units::Dimension;\n\n\
         /// Every statement and command.\n#[rustfmt::skip]\npub static STATEMENTS: &[StatementDef] = &[\n",
    );
    for statement in &grammar.statements {
        emit_statement(&mut out, statement);
    }
    out.push_str("];\n\n/// Every function of expressions.\n#[rustfmt::skip]\npub static FUNCTIONS: &[FunctionDef] = &[\n");
    for function in &grammar.functions {
        let _ = writeln!(
            out,
            "    FunctionDef {{ name: {:?}, count: {}, arguments: {:?}, solved: {}, doc: {:?}, source: {:?} }},",
            function.name,
            count(function.count),
            function.arguments,
            solved(&function.solved),
            function.doc,
            function.source,
        );
    }
    out.push_str("];\n");
    out
}

fn emit_statement(out: &mut String, statement: &Statement) {
    let id = match &statement.id {
        Some(space) => format!("Some({space:?})"),
        None => "None".to_string(),
    };
    let _ = writeln!(
        out,
        "    StatementDef {{\n        name: {:?}, minimum: {}, role: Role::{}, id: {id},\n        arguments: &[",
        statement.keyword.name, statement.keyword.minimum, statement.role,
    );
    for argument in &statement.arguments {
        emit_argument(out, argument);
    }
    let presence: Vec<String> = statement.presence.iter().map(presence).collect();
    let left_out: Vec<String> = statement.left_out.iter().map(left_out).collect();
    let laws: Vec<String> = statement.laws.iter().map(law).collect();
    let _ = writeln!(
        out,
        "        ],\n        presence: &[{}],\n        left_out: &[{}],\n        laws: &[{}],\n        solved: {},\n        doc: {:?},\n        source: {:?},\n        unchecked: {:?},\n    }},",
        presence.join(", "),
        left_out.join(", "),
        laws.join(", "),
        solved(&statement.solved),
        statement.doc,
        statement.source,
        statement.unchecked,
    );
}

fn emit_argument(out: &mut String, argument: &Argument) {
    let default: Vec<String> = argument.default.iter().map(|v| format!("{v:?}")).collect();
    let bound = |bound: Option<(f64, bool)>| match bound {
        None => "Bound::Open".to_string(),
        Some((value, true)) => format!("Bound::Inclusive({value:?})"),
        Some((value, false)) => format!("Bound::Exclusive({value:?})"),
    };
    let _ = writeln!(
        out,
        "            ArgumentDef {{ name: {:?}, minimum: {}, kind: {}, count: {}, default: &[{}], dimension: {}, components: Components::{}, lower: {}, upper: {}, required: {}, doc: {:?} }},",
        argument.keyword.name,
        argument.keyword.minimum,
        kind(&argument.value),
        count(argument.count),
        default.join(", "),
        dimension(argument.dimension),
        argument.components,
        bound(argument.range.lower),
        bound(argument.range.upper),
        argument.required,
        argument.doc,
    );
}

fn left_out(left: &LeftOut) -> String {
    format!(
        "LeftOut {{ arguments: &{:?}, effect: {:?} }}",
        left.names, left.effect
    )
}

fn kind(value: &Value) -> String {
    match value {
        Value::Flag => "ValueKind::Flag".into(),
        Value::Real => "ValueKind::Real".into(),
        Value::Integer => "ValueKind::Integer".into(),
        Value::Reference(space) => format!("ValueKind::Reference({space:?})"),
        Value::Word(choices) => {
            let choice =
                |c: &Keyword| format!("Choice {{ name: {:?}, minimum: {} }}", c.name, c.minimum);
            let choices: Vec<String> = choices.iter().map(choice).collect();
            format!("ValueKind::Choice(&[{}])", choices.join(", "))
        }
        Value::Function => "ValueKind::Function".into(),
        Value::Text => "ValueKind::Text".into(),
        Value::Texts => "ValueKind::TextList".into(),
        Value::File => "ValueKind::File".into(),
    }
}

fn count(count: Count) -> String {
    format!("Count {{ min: {}, max: {:?} }}", count.min, count.max)
}

fn dimension(exponents: [i8; 5]) -> String {
    let named = [
        ([0, 0, 0, 0, 0], "NONE"),
        ([0, 0, 1, 0, 0], "LENGTH"),
        ([0, 0, 0, 0, 1], "ANGLE"),
        ([1, 0, 0, 0, 0], "FORCE"),
        ([1, 0, 1, 0, 0], "TORQUE"),
        ([0, 1, 0, 0, 0], "MASS"),
        ([0, 0, 0, 1, 0], "TIME"),
    ];
    if let Some((_, name)) = named.iter().find(|(e, _)| *e == exponents) {
        return format!("Dimension::{name}");
    }
    let [force, mass, length, time, angle] = exponents;
    format!("Dimension::new({force}, {mass}, {length}, {time}, {angle})")
}

fn solved(solved: &Solved) -> String {
    match solved {
        Solved::Native(name) => format!("Solved::Native({name:?})"),
        Solved::NoEffect(why) => format!("Solved::NoEffect({why:?})"),
        Solved::External(why) => format!("Solved::External({why:?})"),
        Solved::Subroutine(why) => format!("Solved::Subroutine({why:?})"),
    }
}

/// Formats a law as Rust source. The type name of its objects in results is derived from its name: `translational_spring_damper` becomes
/// `Translational_Spring_Damper`.
fn law(law: &Law) -> String {
    let words: Vec<String> = law
        .name
        .split('_')
        .map(|word| word[..1].to_uppercase() + &word[1..])
        .collect();
    format!(
        "LawDef {{ name: {:?}, entity: {:?}, arguments: &{:?}, flag: {:?} }}",
        law.name,
        words.join("_"),
        law.arguments,
        law.flag
    )
}

fn presence(presence: &Presence) -> String {
    format!("Presence::{}(&{:?})", presence.rule, presence.names)
}

const BEGIN: &str = "<!-- coverage: cargo run -p grammar -->\n";
const END: &str = "<!-- end of coverage -->";

/// Returns the guide page with a new coverage table between its two marker comments, or `None` if one of them is missing.
pub fn with_coverage(page: &str, grammar: &Grammar) -> Option<String> {
    let begin = page.find(BEGIN)? + BEGIN.len();
    let end = begin + page[begin..].find(END)?;
    Some(format!(
        "{}{}{}",
        &page[..begin],
        coverage(grammar),
        &page[end..]
    ))
}

/// Returns the coverage table of the guide in Markdown. It lists every statement and says whether it is read, edited, linted and solved
/// natively.
pub fn coverage(grammar: &Grammar) -> String {
    let mut out = String::from(
        "| statement | read | edited | linted | solved natively |\n|---|---|---|---|---|\n",
    );
    let mut statements: Vec<&Statement> = grammar.statements.iter().collect();
    statements.sort_by(|a, b| a.keyword.cmp(&b.keyword));
    for statement in statements {
        let solved = match &statement.solved {
            Solved::Native(_) => "yes".to_string(),
            Solved::NoEffect(why) => format!("no effect on statics: {why}"),
            Solved::External(why) | Solved::Subroutine(why) => format!("no: {why}"),
        };
        let _ = writeln!(
            out,
            "| {} | yes | yes | yes | {solved} |",
            statement.keyword.name
        );
    }
    out
}
