use std::collections::{BTreeMap, BTreeSet};

use super::context::Context;
use crate::car_field::{CarField, reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::expression::Node;
use crate::grammar::{FunctionDef, Solved};
use crate::text::Span;
use crate::{Stated, Statement, Value};

/// Reports statements and functions that ADAMS supports but the built-in solver does not, once for each kind of statement and each
/// function.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let mut external: BTreeMap<&str, (usize, &Statement, &str)> = BTreeMap::new();
    let mut inactive: BTreeMap<&str, (usize, &Statement)> = BTreeMap::new();
    let mut sticking: BTreeMap<&str, (usize, &Statement)> = BTreeMap::new();
    let mut users: BTreeMap<&str, (usize, Span)> = BTreeMap::new();
    let mut functions: BTreeMap<&str, (&FunctionDef, Span)> = BTreeMap::new();
    let mut bushings: BTreeSet<usize> = BTreeSet::new();
    let (mut first, mut others) = (None, Vec::new());
    for (field, read) in CarField::all(context.dataset) {
        match read {
            Ok(read) => {
                first = first.or(Some(field));
                others.extend(read.others);
                bushings.insert(field.span.start());
            }
            Err(why) => {
                let message = format!(
                    "{} is not read as a bushing of Adams/Car: {why}",
                    context.title(field)
                );
                found.push(context.warning(Code::CarBushing, field.head(), message));
            }
        }
    }
    if let Some(first) = first {
        let (message, help) = reading(bushings.len(), &others);
        let warning = context.warning(Code::CarBushing, first.head(), message);
        found.push(warning.help(help));
    }
    for statement in context.statements() {
        let Some(def) = statement.def else { continue };
        match def.solved {
            Solved::External(why) | Solved::Subroutine(why) => {
                external.entry(def.name).or_insert((0, statement, why)).0 += 1;
            }
            Solved::Native(_) if def.name == "FRICTION" => {
                let stated = Stated::plain(statement, context.dataset.source());
                let list = if stated.sticks_in_statics() {
                    &mut sticking
                } else {
                    &mut inactive
                };
                list.entry(def.name).or_insert((0, statement)).0 += 1;
            }
            Solved::Native(_) | Solved::NoEffect(_) => {}
        }
        for argument in &statement.arguments {
            match &argument.value {
                Value::User(span)
                    if def.solved.only_adams().is_none()
                        && !bushings.contains(&statement.span.start()) =>
                {
                    users.entry(def.name).or_insert((0, *span)).0 += 1;
                }
                Value::Function(expression) => {
                    for node in expression.root.walk() {
                        if let Node::Call { function, span, .. } = node
                            && function.solved.only_adams().is_some()
                        {
                            functions.entry(function.name).or_insert((function, *span));
                        }
                    }
                }
                _ => {}
            }
        }
    }
    for (kind, (count, first, why)) in external {
        let message = format!("the built-in solver ignores {count} {kind} of this dataset");
        let them = if count == 1 { "it" } else { "them" };
        found.push(
            context
                .warning(Code::NotSolvedNatively, first.head(), message)
                .help(format!(
                    "{why}; without {them}, the result differs from that of ADAMS"
                )),
        );
    }
    for (kind, (count, first)) in sticking {
        let message =
            format!("the built-in solver ignores {count} {kind} of this dataset in statics");
        found.push(
            context
                .warning(Code::NotSolvedInStatics, first.head(), message)
                .help("ADAMS applies this friction in statics; the built-in solver applies it only in kinematic and dynamic simulations"),
        );
    }
    for (kind, (count, first)) in inactive {
        let are = if count == 1 { "is" } else { "are" };
        let message = format!("{count} {kind} of this dataset {are} inactive in statics");
        found.push(
            context
                .note(Code::InactiveInStatics, first.head(), message)
                .help("as set by INACTIVE or EFFECT"),
        );
    }
    for (kind, (count, span)) in users {
        let message = match count {
            1 => format!("1 {kind} of this dataset takes its value from a user subroutine"),
            _ => format!("{count} {kind} of this dataset take their values from a user subroutine"),
        };
        found.push(
            context
                .warning(Code::UserSubroutine, span, message)
                .help("only real ADAMS with the library of the subroutine can evaluate it"),
        );
    }
    for (name, (function, span)) in functions {
        let Some(why) = function.solved.only_adams() else {
            continue;
        };
        let message = format!("{name} is not evaluated by the built-in solver");
        found.push(
            context
                .warning(Code::NotSolvedNatively, span, message)
                .help(why.to_string()),
        );
    }
}
