//! Checks of the commands of a file in sequence, together with their deck: the objects that commands name, and the simulation time.
//!
//! The module opens no files; its caller supplies the decks.

use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::{STATEMENTS, nearest};
use crate::text::Span;
use crate::{Argument, CommandFile, Dataset, Statement, Wrong};

/// Checks one command file. `deck_of` returns the deck whose name is at the given span of the file, if that deck could be read.
///
/// The diagnostics are in the order of the commands.
pub(super) fn check(
    file: &CommandFile,
    mut deck_of: impl FnMut(Span) -> Option<Dataset>,
) -> Vec<Diagnostic> {
    let mut walk = Walk {
        file,
        found: Vec::new(),
    };
    let mut deck = file.head().and_then(|head| deck_of(head.model));
    let mut clock = Clock::start(deck.as_ref());
    for command in file.commands() {
        match command.kind() {
            Some("FILE") => {
                deck = command
                    .argument("MODEL")
                    .and_then(|model| deck_of(model.value_span()));
                clock = Clock::start(deck.as_ref());
            }
            Some("RELOAD") => {
                // Reloaded states have their own time, and a reloaded system has its own objects.
                clock = Clock::start(None);
                if command.has("SYSTEM") {
                    deck = None;
                }
            }
            Some("SIMULATE") => walk.simulate(command, &mut clock),
            Some("ACTIVATE" | "DEACTIVATE") => {
                if let Some(deck) = &deck {
                    walk.switched(command, deck);
                }
            }
            _ => {
                if let Some(deck) = &deck {
                    walk.objects(command, deck);
                }
            }
        }
    }
    walk.found
}

/// Bounds on the simulation time just before a command.
struct Clock {
    /// Lower bound of the current simulation time.
    earliest: f64,
    /// Latest END of all simulations so far.
    asked: f64,
    /// True if a simulation may stop before its END, because the deck has a SENSOR or could not be read.
    may_end_early: bool,
}

impl Clock {
    fn start(deck: Option<&Dataset>) -> Self {
        let has_sensor = |deck: &Dataset| {
            deck.statements()
                .iter()
                .any(|statement| statement.kind() == Some("SENSOR"))
        };
        Self {
            earliest: 0.0,
            asked: 0.0,
            may_end_early: deck.is_none_or(has_sensor),
        }
    }
}

struct Walk<'a> {
    file: &'a CommandFile,
    found: Vec<Diagnostic>,
}

impl Walk<'_> {
    fn complain(
        &mut self,
        severity: Severity,
        code: Code,
        span: Span,
        message: String,
        help: &str,
    ) {
        let mut diagnostic =
            Diagnostic::error(code, message).label(self.file.source().name(), span, "");
        diagnostic.severity = severity;
        self.found.push(diagnostic.help(help));
    }

    /// Checks the times of a SIMULATE command; END must be later than the time at which the simulation begins (`com_simulate`).
    fn simulate(&mut self, command: &Statement, clock: &mut Clock) {
        let typed = command
            .argument("TYPE")
            .map(|argument| argument.choices(self.file.source()))
            .unwrap_or_default();
        let asks = |name: &str| command.has(name) || typed.contains(&name);
        let place = command.keyword;
        let timed = |name| {
            let number = *command.numbers(name).first()?;
            Some((number.value, number.span))
        };
        let (end, duration) = (timed("END"), timed("DURATION"));
        let counted = command.has("STEPS") || command.has("DTOUT");
        let moves = asks("DYNAMICS") || asks("KINEMATICS") || asks("TRANSIENT");
        if (moves || asks("STATICS") && counted) && end.is_none() && duration.is_none() {
            let help = if moves {
                "add END= or DURATION="
            } else {
                "add END= or DURATION=; a single equilibrium has no STEPS or DTOUT"
            };
            let message = "the simulation has no END or DURATION".to_string();
            self.complain(Severity::Error, Code::MissingArgument, place, message, help);
        }
        if asks("STATICS") && !counted && (end.is_some() || duration.is_some()) {
            self.complain(
                Severity::Warning,
                Code::MissingArgument,
                place,
                "the quasi-static simulation has no STEPS or DTOUT: it solves only the equilibrium at its end, in one step"
                    .to_string(),
                "add STEPS= or DTOUT=, or remove END for an equilibrium at the current time",
            );
        }
        if let Some((end, span)) = end {
            if end < clock.asked || end == clock.earliest && !clock.may_end_early {
                // An END before a previous END is possible only if a sensor stopped the previous simulation early.
                let sure = end <= clock.earliest && !clock.may_end_early;
                let (severity, message) = if sure {
                    let now = clock.earliest;
                    (
                        Severity::Error,
                        format!("the simulation ends at time {end}, but the time is already {now}"),
                    )
                } else {
                    let asked = clock.asked;
                    (
                        Severity::Warning,
                        format!(
                            "the simulation ends at time {end}, but an earlier one was to end at {asked}"
                        ),
                    )
                };
                let help = "END is a time, not a duration: give a later one, or write DURATION=";
                self.complain(severity, Code::OutOfRange, span, message, help);
            }
            clock.asked = clock.asked.max(end);
            if !clock.may_end_early {
                clock.earliest = clock.earliest.max(end);
            }
        } else if let Some((duration, _)) = duration.filter(|(duration, _)| *duration > 0.0)
            && !clock.may_end_early
        {
            clock.earliest += duration;
            clock.asked = clock.earliest;
        }
    }

    /// Checks an ACTIVATE or DEACTIVATE command: every ID exists, and RANGE contains at least one object.
    fn switched(&mut self, command: &Statement, deck: &Dataset) {
        let kinds: Vec<&'static str> = command
            .arguments
            .iter()
            .filter_map(Argument::kind)
            .filter(|kind| {
                STATEMENTS
                    .iter()
                    .any(|def| def.name == *kind && def.id.is_some())
            })
            .collect();
        let [kind] = kinds.as_slice() else {
            return;
        };
        for number in command.numbers("ID") {
            if number
                .as_id()
                .is_some_and(|id| deck.statement(kind, Some(id)).is_none())
            {
                self.absent(kind, number.value, number.span, deck);
            }
        }
        if let [from, to] = command.numbers("RANGE") {
            let inside = |statement: &Statement| {
                statement.kind() == Some(kind)
                    && statement
                        .number()
                        .is_some_and(|id| (from.value..=to.value).contains(&f64::from(id)))
            };
            if !deck.statements().iter().any(inside) {
                let message = format!(
                    "no {kind} of {} has an id from {} to {}",
                    deck.source().name(),
                    from.value,
                    to.value
                );
                let help = in_deck(kind, deck);
                let span = from.span.join(to.span);
                self.complain(Severity::Warning, Code::UndefinedId, span, message, &help);
            }
        }
    }

    /// Checks a command that redefines an object: the object and all objects it refers to must be in the deck.
    fn objects(&mut self, command: &Statement, deck: &Dataset) {
        let Some(def) = command.def else { return };
        if let (Some(_), Some((id, span))) = (def.id, command.id)
            && STATEMENTS.iter().any(|other| other.name == def.name)
            && deck.statement(def.name, Some(id)).is_none()
        {
            self.absent(def.name, f64::from(id), span, deck);
        }
        let defines = |space: &str, id| {
            let kind = space.to_uppercase();
            deck.statement(&kind, Some(id)).is_some()
        };
        command.faults(defines, |fault| {
            if matches!(fault.wrong, Wrong::Undefined(..)) {
                let complaint = fault.diagnostic(self.file.source(), deck.source().name());
                self.found.push(complaint);
            }
        });
    }

    fn absent(&mut self, kind: &str, id: f64, span: Span, deck: &Dataset) {
        let message = format!("{kind}/{id} is not in {}", deck.source().name());
        let ids = ids(kind, deck);
        let help = match nearest(&id.to_string(), ids.iter().map(String::as_str)) {
            Some(near) => format!("did you mean {kind}/{near}?"),
            None => in_deck(kind, deck),
        };
        self.complain(Severity::Error, Code::UndefinedId, span, message, &help);
    }
}

fn ids(kind: &str, deck: &Dataset) -> Vec<String> {
    deck.statements()
        .iter()
        .filter(|statement| statement.kind() == Some(kind))
        .filter_map(|statement| Some(statement.number()?.to_string()))
        .collect()
}

/// Lists the ids of all objects of a kind in a deck, for a help text.
fn in_deck(kind: &str, deck: &Dataset) -> String {
    const SHOWN: usize = 8;
    match ids(kind, deck).as_slice() {
        [] => format!("the deck has no {kind}"),
        all if all.len() <= SHOWN => format!("the deck has {kind}/{}", all.join(", ")),
        all => format!(
            "the deck has {} objects of this kind, from {kind}/{}",
            all.len(),
            all[0]
        ),
    }
}
