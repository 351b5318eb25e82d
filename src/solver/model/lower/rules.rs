//! Faults of a statement that prevent a model from being solved.

use super::ids::Ids;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::grammar::{Solved, ValueKind, nearest};
use admire_syntax::text::Source;
use admire_syntax::{Argument, Fault, Statement, Wrong};

/// Arguments whose numbers must lie within their bounds; an empty list means all arguments of the statement. Outside these bounds, a
/// simulation is meaningless.
const BOUNDED: [(&str, &[&str]); 6] = [
    ("FRICTION", &[]),
    (
        "INTEGRATOR",
        &["ADAPTIVITY", "ERROR", "HINIT", "HMAX", "HMIN", "MAXIT"],
    ),
    ("KINEMATICS", &["HMAX"]),
    ("PART", &["MASS"]),
    ("POINT_MASS", &["MASS"]),
    ("SENSOR", &[]),
];

/// Reports numbers of the [`BOUNDED`] arguments that are out of bounds.
fn check_bounds(source: &Source, statement: &Statement, diagnostics: &mut Vec<Diagnostic>) {
    let kind = statement.kind();
    let Some((kind, names)) = BOUNDED.iter().find(|(bounded, _)| kind == Some(*bounded)) else {
        return;
    };
    let defined = statement.arguments.iter().filter_map(|a| Some((a, a.def?)));
    for (argument, def) in defined.filter(|(_, def)| names.is_empty() || names.contains(&def.name))
    {
        for number in argument.numbers().iter().filter(|n| !def.admits(n.value)) {
            let message = format!("{} of {kind} must be {}", def.name, def.wanted());
            let complaint = Diagnostic::error(Code::OutOfRange, message);
            diagnostics.push(complaint.label(source.name(), number.span, ""));
        }
    }
}

/// Reports arguments that only real ADAMS evaluates. Reports nothing if one of them has the value OFF, because the feature is then switched
/// off.
fn check_left_out(source: &Source, statement: &Statement, diagnostics: &mut Vec<Diagnostic>) {
    for left in statement.def.map_or(&[][..], |def| def.left_out) {
        let names = left.arguments.iter();
        let written: Vec<_> = names.filter_map(|name| statement.argument(name)).collect();
        let is_off = |argument: &&Argument| argument.choices(source).contains(&"OFF");
        let Some(first) = written.first().filter(|_| !written.iter().any(is_off)) else {
            continue;
        };
        let names: Vec<&str> = written.iter().filter_map(|a| a.kind()).collect();
        let have = if names.len() == 1 { "has" } else { "have" };
        let message = format!(
            "{} of {} {have} no effect in the built-in solver",
            names.join(", "),
            statement.title(source)
        );
        diagnostics.push(
            Diagnostic::warning(Code::NotSolvedNatively, message)
                .label(source.name(), first.span, "")
                .help(format!("in real ADAMS: {}", left.effect)),
        );
    }
}

/// Reports the faults of one statement. For a command, `dataset` is the dataset that the command modifies; absent arguments are then
/// allowed.
pub(super) fn check(
    source: &Source,
    statement: &Statement,
    ids: &Ids,
    dataset: Option<&Source>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    check_bounds(source, statement, diagnostics);
    check_left_out(source, statement, diagnostics);
    let of = dataset.map_or("this dataset", |dataset| dataset.name());
    statement.faults(
        |space, id| ids.defines(space, id),
        |fault| {
            if dataset.is_some() && is_absence(&fault) || is_harmless(&fault) {
                return;
            }
            let mut complaint = fault.diagnostic(source, of);
            if let Wrong::Undefined(space, id) = fault.wrong {
                let solved = statement.def.map(|def| def.solved);
                if !matches!(solved, Some(Solved::Native(_))) {
                    complaint.severity = Severity::Warning;
                }
                // Similar ids are suggested only for the first 50 diagnostics: in a deck that lost its parts, every line has a fault.
                if diagnostics.len() < 50
                    && let Some(near) = near(ids, space, id)
                {
                    complaint = complaint.help(format!("did you mean {near}?"));
                }
            }
            diagnostics.push(complaint);
        },
    );
}

/// Reports arguments that an object still lacks after a command was overlaid on it. `whole` is the resulting statement, with the keyword
/// and id of the command.
pub(super) fn check_redefined(
    source: &Source,
    whole: &Statement,
    dataset: &Source,
    diagnostics: &mut Vec<Diagnostic>,
) {
    whole.presence_faults(|fault| {
        if is_absence(&fault) && !is_harmless(&fault) {
            diagnostics.push(fault.diagnostic(source, dataset.name()));
        }
    });
}

/// Returns whether a fault is a missing argument.
fn is_absence(fault: &Fault<'_>) -> bool {
    matches!(
        fault.wrong,
        Wrong::Missing(_) | Wrong::NoneOf(_) | Wrong::Partly(_) | Wrong::Without(..)
    )
}

/// Returns whether a fault leaves the model unaffected. This holds for a wrong number of text values. In statements that have no effect, it
/// also holds for non-integer numbers and wrong combinations of arguments.
fn is_harmless(fault: &Fault<'_>) -> bool {
    match fault.wrong {
        Wrong::NoneOf(_)
        | Wrong::Partly(_)
        | Wrong::Without(..)
        | Wrong::Both(..)
        | Wrong::NotWhole(_) => {
            let solved = fault.statement.def.map(|def| def.solved);
            matches!(solved, Some(Solved::NoEffect(_)))
        }
        Wrong::Count(argument, _) => matches!(
            argument.kind,
            ValueKind::Text | ValueKind::TextList | ValueKind::File
        ),
        Wrong::Missing(_) | Wrong::Undefined(..) | Wrong::Nothing(..) | Wrong::NoId(_) => false,
    }
}

/// Returns the object whose id is most similar to an undefined one.
fn near(ids: &Ids, space: &'static str, id: u32) -> Option<String> {
    let all: Vec<String> = ids.all(space).iter().map(u32::to_string).collect();
    let near = nearest(&id.to_string(), all.iter().map(String::as_str))?;
    Some(format!("{}/{near}", space.to_uppercase()))
}
