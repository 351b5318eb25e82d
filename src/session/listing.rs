//! Output of the commands LIST, INFO and TIME, which print values of the current model.
//!
//! The layout of ADAMS for this output is not published; the layout used here is specific to `admire` (guide/formats.md 6.5).

use std::borrow::Cow;
use std::fmt::Write as _;

use admire_solver::model::{Definitions, Header, MarkerIx, Request, RequestKind};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::{Argument, Stated, Statement, Value, excludes};

use super::loaded::Loaded;
use super::message::exponent;
use super::run_state::{Flow, Locate as _, Place, Session};

/// One argument of a statement, with its value as text. A repeated argument, such as Y of a SPLINE, has one value for each occurrence.
struct Given {
    name: &'static str,
    values: Vec<String>,
}

/// Formats the statement that a command names, with one argument on each line; `None` if the statement does not exist.
fn listed(definitions: &Definitions, command: &Statement) -> Option<String> {
    let def = command.def?;
    let statement = definitions.statement(def, command.number());
    if statement.is_none() && def.id.is_some() {
        return None;
    }
    let mut all = statement
        .as_ref()
        .map_or_else(Vec::new, |s| given(&s.stated()));
    // An argument that the statement does not give is shown with its default, unless a given argument excludes it.
    for argument in def.arguments {
        let known = all.iter().any(|given| given.name == argument.name);
        let replaced = all
            .iter()
            .any(|given| excludes(def, given.name, argument.name));
        if !known && !replaced && !argument.default.is_empty() {
            let values: Vec<String> = argument.default.iter().map(ToString::to_string).collect();
            all.push(Given {
                name: argument.name,
                values: vec![values.join(", ")],
            });
        }
    }
    let mut text = match (command.number(), &statement) {
        (Some(id), Some(statement)) => {
            let name = statement.stated().view_name();
            let name = name.map_or_else(|| format!("{}_{id}", def.name), Cow::into_owned);
            format!("\n {}/{id}   model.{name}\n\n", def.name)
        }
        _ => format!("\n {}/\n\n", def.name),
    };
    for given in &all {
        for value in &given.values {
            let line = match value.as_str() {
                "" => format!("   {}\n", given.name),
                value => format!("   {:<12} = {value}\n", given.name),
            };
            text += &line;
        }
    }
    Some(text + "\n")
}

/// Returns the arguments of a statement with their values, in the order of the statement.
fn given(statement: &Stated) -> Vec<Given> {
    let mut all: Vec<Given> = Vec::new();
    for (argument, source) in statement.arguments() {
        let Some(name) = argument.kind() else {
            continue;
        };
        let value = value(argument, source);
        match all.iter_mut().find(|given| given.name == name) {
            Some(given) => given.values.push(value),
            None => all.push(Given {
                name,
                values: vec![value],
            }),
        }
    }
    all
}

fn value(argument: &Argument, source: &Source) -> String {
    match &argument.value {
        Value::Numbers(numbers) => {
            let words: Vec<_> = numbers.iter().map(|n| source.text(n.span)).collect();
            words.join(", ")
        }
        Value::Words(_) | Value::Texts(_) => argument.texts(source).join(":"),
        _ => argument
            .text(source)
            .map_or_else(String::new, std::borrow::Cow::into_owned),
    }
}

/// Names and values of the components of a request that INFO prints.
type Components = [(&'static str, f64); 7];

impl Session<'_> {
    /// Executes LIST: prints the arguments and values of a statement.
    #[allow(clippy::unnecessary_wraps)] // Every command ends in a Flow.
    pub(super) fn list(&mut self, command: &Statement) -> Flow {
        let asked = self.loaded.as_ref().filter(|_| command.has("LIST"));
        if let Some(text) = asked.and_then(|loaded| listed(&loaded.definitions, command)) {
            self.messages.say(&text);
        }
        Ok(())
    }

    /// Executes TIME: prints the current time.
    #[allow(clippy::unnecessary_wraps)] // Every command ends in a Flow.
    pub(super) fn print_time(&mut self) -> Flow {
        let now = self.loaded.as_ref().map_or(0.0, Loaded::time);
        self.messages.say(&format!("  Time = {now}\n"));
        Ok(())
    }

    /// Executes INFO: prints the motion of one marker relative to another, or the forces between them. Errors in the command are only
    /// warnings, because they do not affect results.
    pub(super) fn info(&mut self, command: &Statement, source: &Source) -> Flow {
        let Some(loaded) = &mut self.loaded else {
            return self.no_model(command, source);
        };
        let text = match loaded.info(command) {
            Ok(text) => text,
            Err(refused) => {
                let place = Some(Place {
                    source,
                    span: command.span,
                });
                let refused = place.label(refused);
                self.complain(&refused);
                return Ok(());
            }
        };
        self.messages.say(&text);
        Ok(())
    }
}

impl Loaded {
    fn info(&mut self, command: &Statement) -> Result<String, Diagnostic> {
        let wrong = |code, message: &str, help: &str| {
            Err(Diagnostic::warning(code, message.to_string()).help(help.to_string()))
        };
        let help = "for example INFO/DISPLACEMENT, I=12, J=31";
        let mut ends = [None; 3];
        for (end, name) in ends.iter_mut().zip(["I", "J", "RM"]) {
            // An id of zero means the ground coordinate system.
            let Some(id) = command.first(name).filter(|id| *id > 0.0) else {
                continue;
            };
            let Some(marker) = self.model.marker(id as u32) else {
                let message = format!("MARKER/{id} is not in the model");
                return wrong(Code::UndefinedId, &message, help);
            };
            *end = Some(marker);
        }
        let [Some(i), j, rm] = ends else {
            return wrong(Code::MissingArgument, "INFO needs an I marker", help);
        };
        let kinds: [(
            &str,
            fn(MarkerIx, Option<MarkerIx>, Option<MarkerIx>) -> RequestKind,
        ); 4] = [
            ("DISPLACEMENT", |i, j, rm| RequestKind::Displacement {
                i,
                j,
                rm,
            }),
            ("VELOCITY", |i, j, rm| RequestKind::Velocity { i, j, rm }),
            ("ACCELERATION", |i, j, rm| RequestKind::Acceleration {
                i,
                j,
                rm,
            }),
            ("FORCE", |i, j, rm| RequestKind::Force { i, j, rm }),
        ];
        let asked: Vec<_> = kinds.iter().filter(|(word, _)| command.has(word)).collect();
        if asked.is_empty() {
            let message = "INFO names no quantity";
            let help = "give DISPLACEMENT, VELOCITY, ACCELERATION or FORCE";
            return wrong(Code::MissingArgument, message, help);
        }
        let title = |marker: Option<MarkerIx>| {
            marker.map_or_else(
                || "ground".to_string(),
                |marker| format!("MARKER/{}", self.model.markers[marker.0].header.id),
            )
        };
        let (of, from, axes) = (title(Some(i)), title(j), title(rm));
        let time = self.time();
        let mut text = String::new();
        for (word, kind) in asked {
            let values = self.evaluate_request(kind(i, j, rm))?;
            let word = word.to_ascii_lowercase();
            let relation = if word == "force" { "by" } else { "from" };
            _ = writeln!(
                text,
                "\n  Time = {}: {word} of {of} {relation} {from}, in the axes of {axes}",
                exponent(time, 5)
            );
            for (name, value) in values {
                _ = writeln!(text, "   {name:<6} = {:>13}", exponent(value, 6));
            }
        }
        Ok(text + "\n")
    }

    /// Evaluates a request, which need not be in the dataset, at the current state.
    fn evaluate_request(&mut self, kind: RequestKind) -> Result<Components, Diagnostic> {
        let names = match kind {
            RequestKind::Displacement { .. } => ["MAG", "X", "Y", "Z", "PSI", "THETA", "PHI"],
            RequestKind::Velocity { .. } => ["VM", "VX", "VY", "VZ", "WX", "WY", "WZ"],
            RequestKind::Acceleration { .. } => {
                ["ACCM", "ACCX", "ACCY", "ACCZ", "WDTX", "WDTY", "WDTZ"]
            }
            _ => ["FM", "FX", "FY", "FZ", "TX", "TY", "TZ"],
        };
        let values = self.answer(Request {
            header: Header {
                id: 0,
                name: "INFO".to_string(),
                origin: usize::MAX,
                active: true,
            },
            kind,
            comment: String::new(),
            component_names: None,
            component_units: Vec::new(),
            results_name: None,
        });
        let Some(v) = values else {
            return Err(Diagnostic::warning(
                Code::NotSolvedNatively,
                "the quantity that INFO asks for is undefined in this state".to_string(),
            ));
        };
        // The fifth component is omitted: it is the magnitude of the rotation, or empty.
        let values = [v[0], v[1], v[2], v[3], v[5], v[6], v[7]];
        Ok(std::array::from_fn(|k| (names[k], values[k])))
    }
}
