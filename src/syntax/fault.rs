//! Faults of a single statement with respect to the grammar, as data: missing arguments, wrong numbers of values, undefined ids.
//!
//! The caller decides how severe each fault is.

use super::{Argument, Number, Statement, Value};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{ArgumentDef, Presence, Solved, StatementDef, ValueKind};
use crate::text::{Source, Span};

/// Kind of a fault, with the arguments or the id concerned.
#[derive(Clone, Copy, Debug)]
pub enum Wrong {
    /// A required argument is missing.
    Missing(&'static ArgumentDef),
    /// None of these arguments is present, although one of them is required.
    NoneOf(&'static [&'static str]),
    /// Some of these arguments are missing, although either all or none must be present.
    Partly(&'static [&'static str]),
    /// The first argument is present without the second, which it requires.
    Without(&'static str, &'static str),
    /// Both of these arguments are present, although they exclude each other.
    Both(&'static str, &'static str),
    /// The argument has this number of values, which the grammar does not allow.
    Count(&'static ArgumentDef, usize),
    /// No object in this id space has this id.
    Undefined(&'static str, u32),
    /// The argument is 0, although it must give the id of an object in this id space.
    Nothing(&'static ArgumentDef, &'static str),
    /// A number in this argument is not a valid id.
    NoId(&'static ArgumentDef),
    /// A number in this argument must be an integer, but it has a fraction or a degree suffix.
    NotWhole(&'static ArgumentDef),
}

/// A fault of a statement with respect to the grammar.
#[derive(Clone, Copy, Debug)]
pub struct Fault<'s> {
    /// The faulty statement.
    pub statement: &'s Statement,
    /// Kind of the fault.
    pub wrong: Wrong,
    place: Span,
}

impl Statement {
    /// Passes all faults of the statement to `found`. The function `defines` returns true if an object in an id space has an id.
    pub fn faults<'s>(
        &'s self,
        defines: impl Fn(&'static str, u32) -> bool,
        mut found: impl FnMut(Fault<'s>),
    ) {
        let Some(def) = self.def else { return };
        self.presence_faults(&mut found);
        let mut tell = |wrong, place| found(self.fault(wrong, place));
        for argument in &self.arguments {
            let Some(own) = argument.def else { continue };
            if let Some(given) = wrong_count(argument, own) {
                tell(Wrong::Count(own, given), argument.value_span());
            }
            match (&argument.value, own.kind) {
                (Value::Numbers(numbers), ValueKind::Reference(space)) => {
                    let needed = needs_object(def, own);
                    for number in numbers {
                        if number.value == 0.0 && !number.degrees {
                            if needed {
                                tell(Wrong::Nothing(own, space), number.span);
                            }
                        } else if let Some(wrong) = wrong_id(own, space, number, &defines) {
                            tell(wrong, number.span);
                        }
                    }
                }
                (Value::Numbers(numbers), ValueKind::Integer) => {
                    for number in numbers {
                        if number.value.fract() != 0.0 || number.degrees {
                            tell(Wrong::NotWhole(own), number.span);
                        }
                    }
                }
                (Value::Function(expression), _) => {
                    for (space, literal) in expression.references() {
                        let number = &expression.literals[literal];
                        if let Some(wrong) = wrong_id(own, space, number, &defines) {
                            tell(wrong, number.span);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Passes only the faults that concern which arguments are present: missing arguments, and arguments that exclude each other.
    pub fn presence_faults<'s>(&'s self, mut found: impl FnMut(Fault<'s>)) {
        let Some(def) = self.def else { return };
        let mut tell = |wrong, place| found(self.fault(wrong, place));
        for argument in def.arguments.iter().filter(|argument| argument.required) {
            if !self.has(argument.name) {
                tell(Wrong::Missing(argument), self.head());
            }
        }
        for rule in def.presence {
            self.breaches(rule, &mut tell);
        }
    }

    fn fault(&self, wrong: Wrong, place: Span) -> Fault<'_> {
        Fault {
            statement: self,
            wrong,
            place,
        }
    }

    /// Passes all violations of one presence rule, with their locations, to `tell`.
    fn breaches(&self, rule: &Presence, mut tell: impl FnMut(Wrong, Span)) {
        let place = |name| self.argument(name).map_or(self.keyword, |a| a.name);
        match *rule {
            Presence::Together(names) => {
                let there = self.present(names).count();
                if there > 0 && there < names.len() {
                    tell(Wrong::Partly(names), self.head());
                }
            }
            Presence::Requires([first, others @ ..]) if self.has(first) => {
                for other in others.iter().filter(|other| !self.has(other)) {
                    tell(Wrong::Without(first, other), self.head());
                }
            }
            Presence::Requires(_) => {}
            Presence::Exclusive(names) | Presence::OneOf(names) => {
                let mut there = self.present(names);
                match (there.next(), there.next()) {
                    (Some(first), Some(second)) => {
                        tell(Wrong::Both(first, second), place(second));
                    }
                    (None, _) if matches!(rule, Presence::OneOf(_)) => {
                        tell(Wrong::NoneOf(names), self.head());
                    }
                    _ => {}
                }
            }
        }
    }

    fn present(&self, names: &'static [&'static str]) -> impl Iterator<Item = &'static str> {
        names.iter().copied().filter(|name| self.has(name))
    }

    /// Returns the name used in messages: `BUSHING/3`, followed by the view name if there is one.
    pub fn title(&self, source: &Source) -> String {
        let kind = self.kind().unwrap_or("statement");
        let title = match self.number() {
            Some(id) => format!("{kind}/{id}"),
            None => kind.to_string(),
        };
        match self.view_name {
            Some(name) => format!("{title} ({})", source.text(name)),
            None => title,
        }
    }

    /// Returns the span from the keyword to the id.
    pub(crate) fn head(&self) -> Span {
        match self.id {
            Some((_, id)) => self.keyword.join(id),
            None => self.keyword,
        }
    }
}

/// Returns the number of values of an argument if the grammar does not allow this number. Flags with values and unreadable values are not
/// checked, because the parser has already reported them.
fn wrong_count(argument: &Argument, def: &ArgumentDef) -> Option<usize> {
    let given = match &argument.value {
        _ if def.kind == ValueKind::Flag => return None,
        Value::Numbers(numbers) => numbers.len(),
        Value::Words(spans) | Value::Texts(spans) => spans.len(),
        Value::Flag | Value::Function(_) | Value::User(_) | Value::Malformed(_) => return None,
    };
    let fits = given >= def.count.min && def.count.max.is_none_or(|max| given <= max);
    (!fits).then_some(given)
}

/// Returns true if an argument must not be 0. In other arguments, such as RM, or J of a REQUEST, 0 means ground or no object.
fn needs_object(def: &StatementDef, argument: &ArgumentDef) -> bool {
    let acts = !matches!(def.solved, Solved::NoEffect(_)) && def.name != "REQUEST";
    let attached = ["I", "J", "IFLOAT", "JFLOAT", "JOINT", "JOINTS"];
    acts && (argument.required || attached.contains(&argument.name))
}

fn wrong_id(
    argument: &'static ArgumentDef,
    space: &'static str,
    number: &Number,
    defines: impl Fn(&'static str, u32) -> bool,
) -> Option<Wrong> {
    match number.as_id().filter(|_| !number.degrees) {
        None => Some(Wrong::NoId(argument)),
        Some(id) if defines(space, id) => None,
        Some(id) => Some(Wrong::Undefined(space, id)),
    }
}

impl Fault<'_> {
    /// Returns the code under which the fault is reported.
    pub(crate) fn code(&self) -> Code {
        match self.wrong {
            Wrong::Missing(_) | Wrong::NoneOf(_) | Wrong::Partly(_) | Wrong::Without(..) => {
                Code::MissingArgument
            }
            Wrong::Both(..) => Code::ConflictingArguments,
            Wrong::Count(..) => Code::WrongCount,
            Wrong::Undefined(..) => Code::UndefinedId,
            Wrong::Nothing(..) | Wrong::NoId(_) | Wrong::NotWhole(_) => Code::WrongType,
        }
    }

    /// Converts the fault into a diagnostic. `source` is the file of the statement. `dataset` is the name of the dataset that should define
    /// the ids; the message uses it.
    pub fn diagnostic(&self, source: &Source, dataset: &str) -> Diagnostic {
        let title = self.statement.title(source);
        let written = source.text(self.place);
        let of_argument = |def: &ArgumentDef| format!("{}: {}", def.name, def.doc);
        let (message, help) = match self.wrong {
            Wrong::Missing(def) => {
                let message = format!("{title} needs {}: {}", def.name, def.doc);
                let value = match def.kind {
                    ValueKind::Flag => "",
                    _ => "= and its value",
                };
                (message, format!("add {}{value}", def.name))
            }
            Wrong::NoneOf(names) => (
                format!("{title} needs one of {}", names.join(", ")),
                "add one of them".to_string(),
            ),
            Wrong::Partly(names) => {
                let absent = names.iter().filter(|name| !self.statement.has(name));
                let absent: Vec<&str> = absent.copied().collect();
                (
                    format!("{title} needs all of {}", names.join(", ")),
                    format!("add {}", absent.join(", ")),
                )
            }
            Wrong::Without(first, other) => (
                format!("{first} of {title} needs {other}"),
                format!("add {other}, or remove {first}"),
            ),
            Wrong::Both(first, second) => (
                format!("{title} cannot have both {first} and {second}"),
                "remove one of them".to_string(),
            ),
            Wrong::Count(def, given) => {
                let wanted = match (def.count.min, def.count.max) {
                    (min, Some(max)) if max == min => format!("{min}"),
                    (min, Some(max)) => format!("{min} to {max}"),
                    (min, None) => format!("at least {min}"),
                };
                let values = match (def.count.min, def.count.max) {
                    (_, Some(1)) | (1, None) => "value",
                    _ => "values",
                };
                let message = format!(
                    "{} of {title} takes {wanted} {values}, not {given}",
                    def.name
                );
                (message, of_argument(def))
            }
            Wrong::Undefined(space, id) => {
                let object = format!("{}/{id}", space.to_uppercase());
                let message = format!("{title} names {object}, which is not in {dataset}");
                (
                    message,
                    format!("add {object}, or refer to an existing one"),
                )
            }
            Wrong::Nothing(def, space) => {
                let kind = space.to_uppercase();
                let message = format!("{} of {title} must name a {kind}, not 0", def.name);
                (message, of_argument(def))
            }
            Wrong::NoId(def) => {
                let message = match def.kind {
                    ValueKind::Reference(_) => {
                        format!("{} of {title} takes an id, not {written}", def.name)
                    }
                    _ => format!("{} of {title} needs an id here, not {written}", def.name),
                };
                (message, of_argument(def))
            }
            Wrong::NotWhole(def) => {
                let message = format!(
                    "{} of {title} takes a whole number, not {written}",
                    def.name
                );
                (message, of_argument(def))
            }
        };
        let mut complaint =
            Diagnostic::error(self.code(), message).label(source.name(), self.place, "");
        if let Wrong::Both(first, _) = self.wrong
            && let Some(first) = self.statement.argument(first)
        {
            complaint = complaint.label(source.name(), first.name, "");
        }
        complaint.help(help)
    }
}
