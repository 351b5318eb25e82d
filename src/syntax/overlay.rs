//! Redefinition of a statement by later statements: arguments that are given again replace the old ones, and all other arguments stay.

use std::borrow::Cow;

use super::{Argument, Number, Shared, Statement, Value};
use crate::grammar::{Presence, StatementDef};
use crate::text::{Source, Span};

/// Arguments that control a command and are not data of the redefined statement.
const COMMAND_WORDS: [&str; 2] = ["DEFAULT", "LIST"];

/// A statement and the text from which it was parsed.
#[derive(Clone, Debug)]
struct Layer {
    statement: Statement,
    source: Source,
}

/// A statement with its later redefinitions, as layers. An argument that was redefined is kept only in its latest layer.
#[derive(Clone, Debug)]
pub struct Overlay {
    first: Layer,
    /// Layers of the redefinitions, in the order in which they were made.
    above: Vec<Layer>,
}

impl Overlay {
    /// Creates an overlay of a statement without redefinitions.
    pub fn of(statement: &Statement, source: &Source) -> Self {
        Self {
            first: Layer {
                statement: without(statement, is_command_word),
                source: source.clone(),
            },
            above: Vec::new(),
        }
    }

    /// Adds a later statement or command as a layer.
    ///
    /// Each new argument replaces earlier arguments of the same name and earlier arguments that it excludes. If a replaced argument belongs
    /// to a group that must appear together, the whole group is replaced. DEFAULT removes all earlier arguments.
    pub fn put(&mut self, later: &Statement, source: &Source) {
        let all = later.has("DEFAULT");
        let gone = |old: &Argument| {
            all || later
                .arguments
                .iter()
                .any(|new| replaces(later.def, new, old))
        };
        let layers = std::iter::once(&mut self.first).chain(&mut self.above);
        for layer in layers {
            if layer.statement.arguments.iter().any(gone) {
                layer.statement = without(&layer.statement, gone);
            }
        }
        self.above
            .retain(|layer| !layer.statement.arguments.is_empty());
        let statement = without(later, is_command_word);
        if !statement.arguments.is_empty() {
            let source = source.clone();
            self.above.push(Layer { statement, source });
        }
    }

    /// Returns the redefined statement with all its current arguments, under the keyword and id of `command`, the latest redefinition.
    ///
    /// Only the definitions and values of the arguments may be used: their spans refer to different source texts.
    pub fn under(&self, command: &Statement) -> Statement {
        let arguments = self.stated().arguments();
        Statement {
            arguments: arguments.map(|(argument, _)| argument.clone()).collect(),
            ..command.clone()
        }
    }

    /// Returns a view of the statement with all redefinitions applied.
    pub fn stated(&self) -> Stated<'_> {
        Stated {
            statement: &self.first.statement,
            source: &self.first.source,
            above: &self.above,
        }
    }
}

fn without(statement: &Statement, gone: impl Fn(&Argument) -> bool) -> Statement {
    let kept = statement
        .arguments
        .iter()
        .filter(|argument| !gone(argument));
    Statement {
        arguments: kept.cloned().collect::<Shared<_>>(),
        ..statement.clone()
    }
}

fn is_command_word(argument: &Argument) -> bool {
    argument
        .kind()
        .is_some_and(|name| COMMAND_WORDS.contains(&name))
}

fn replaces(def: Option<&StatementDef>, new: &Argument, old: &Argument) -> bool {
    let (Some(def), Some(new), Some(old)) = (def, new.kind(), old.kind()) else {
        return false;
    };
    let together = |names: &[&'static str]| {
        names.contains(&old)
            && !names.contains(&new)
            && names.iter().any(|name| excludes(def, new, name))
    };
    new == old
        || excludes(def, new, old)
        || def.presence.iter().any(|presence| match presence {
            Presence::Together(names) => together(names),
            _ => false,
        })
}

/// Returns true if the grammar lets only one of two different arguments appear in a statement.
pub fn excludes(def: &StatementDef, a: &str, b: &str) -> bool {
    a != b
        && def.presence.iter().any(|presence| match presence {
            Presence::Exclusive(names) | Presence::OneOf(names) => {
                names.contains(&a) && names.contains(&b)
            }
            _ => false,
        })
}

/// A read-only view of a statement with all its redefinitions applied, if there are any.
#[derive(Clone, Copy)]
pub struct Stated<'a> {
    statement: &'a Statement,
    source: &'a Source,
    above: &'a [Layer],
}

impl<'a> Stated<'a> {
    /// Returns a view of a statement that has no redefinitions.
    pub fn plain(statement: &'a Statement, source: &'a Source) -> Self {
        Self {
            statement,
            source,
            above: &[],
        }
    }

    /// Returns the id of the statement, if it has one.
    pub fn number(&self) -> Option<u32> {
        self.statement.number()
    }

    /// Returns the ADAMS/View name of the statement, if the file gives one.
    pub fn view_name(&self) -> Option<Cow<'a, str>> {
        Some(self.source.text(self.statement.view_name?))
    }

    /// Returns the source text and the span of the statement's keyword.
    pub fn keyword(&self) -> (&'a Source, Span) {
        (self.source, self.statement.keyword)
    }

    /// Returns the location of the keyword in the latest redefinition, or in the statement itself if there is no redefinition.
    pub fn latest_keyword(&self) -> (&'a Source, Span) {
        self.above.last().map_or(self.keyword(), |layer| {
            (&layer.source, layer.statement.keyword)
        })
    }

    /// Iterates over the layers, the latest first.
    fn layers(&self) -> impl Iterator<Item = (&'a Statement, &'a Source)> + use<'a> {
        let above = self.above.iter().rev();
        above
            .map(|layer| (&layer.statement, &layer.source))
            .chain(std::iter::once((self.statement, self.source)))
    }

    /// Iterates over all arguments and their source texts, from the earliest layer to the latest.
    pub fn arguments(&self) -> impl Iterator<Item = (&'a Argument, &'a Source)> + use<'a> {
        let above = self.above.iter();
        let above = above.map(|layer| (&layer.statement, &layer.source));
        std::iter::once((self.statement, self.source))
            .chain(above)
            .flat_map(|(statement, source)| statement.arguments.iter().map(move |a| (a, source)))
    }

    fn found(&self, name: &str) -> Option<(&'a Argument, &'a Source)> {
        self.layers()
            .find_map(|(statement, source)| Some((statement.argument(name)?, source)))
    }

    /// Returns the latest argument with this full keyword (in capitals), if it exists.
    pub fn argument(&self, name: &str) -> Option<&'a Argument> {
        self.found(name).map(|(argument, _)| argument)
    }

    /// Iterates over all arguments with this full keyword, from the earliest layer to the latest; a SPLINE may have several Y.
    pub fn all<'n>(&self, name: &'n str) -> impl Iterator<Item = &'a Argument> + use<'a, 'n> {
        let arguments = self.arguments().map(|(argument, _)| argument);
        arguments.filter(move |argument| argument.kind() == Some(name))
    }

    /// Returns true if the statement has an argument with this full keyword.
    pub fn has(&self, name: &str) -> bool {
        self.found(name).is_some()
    }

    /// Finds the latest layer that contains any of the given arguments, and returns the given arguments that it contains.
    pub fn latest<'n>(
        &self,
        words: &'n [&'static str],
    ) -> impl Iterator<Item = &'static str> + use<'a, 'n> {
        let latest = self
            .layers()
            .find(|(statement, _)| words.iter().any(|word| statement.has(word)));
        let stands =
            move |word: &&'static str| latest.is_some_and(|(statement, _)| statement.has(word));
        words.iter().copied().filter(stands)
    }

    /// Returns the numbers of an argument; empty if it is absent or has no numbers.
    pub fn numbers(&self, name: &str) -> &'a [Number] {
        self.argument(name).map_or(&[], Argument::numbers)
    }

    /// Returns the first number of an argument.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().map(|number| number.value)
    }

    /// Returns the text of an argument; for a function, its source text.
    pub fn text(&self, name: &str) -> Option<Cow<'a, str>> {
        let (argument, source) = self.found(name)?;
        argument.text(source)
    }

    /// Returns the texts or words of an argument.
    pub fn texts(&self, name: &str) -> Option<Vec<Cow<'a, str>>> {
        let (argument, source) = self.found(name)?;
        Some(argument.texts(source))
    }

    /// Returns the choice words of an argument, spelled out and in capitals.
    pub fn choices(&self, name: &str) -> Option<Vec<&'static str>> {
        let (argument, source) = self.found(name)?;
        Some(argument.choices(source))
    }

    /// Returns true if the value of the argument is `USER(...)`.
    pub fn is_user(&self, name: &str) -> bool {
        self.argument(name)
            .is_some_and(|argument| matches!(argument.value, Value::User(_)))
    }

    /// Returns the location of an argument's value, or of the statement's keyword if the argument is not written.
    pub fn place(&self, name: &str) -> (&'a Source, Span) {
        self.found(name)
            .map_or(self.keyword(), |(argument, source)| {
                (source, argument.value_span())
            })
    }

    /// Returns true for a FRICTION whose stiction also acts in statics: it has neither INACTIVE nor EFFECT=SLIDING.
    ///
    /// The page `state_friction` gives no default for INACTIVE; for EFFECT it gives the default ALL.
    pub fn sticks_in_statics(&self) -> bool {
        let slides_only = self
            .choices("EFFECT")
            .is_some_and(|effect| effect == ["SLIDING"]);
        !slides_only && !self.has("INACTIVE") && !self.has("INACTIVE_DURING")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CommandFile, Dataset};

    fn shown(overlay: &Overlay) -> Vec<String> {
        let stated = overlay.stated();
        let text =
            |(argument, source): (&Argument, &Source)| source.text(argument.span).into_owned();
        stated.arguments().map(text).collect()
    }

    fn over(statement: &str, commands: &str) -> Overlay {
        let deck = Source::new("a.adm", format!("t\n{statement}\nEND\n").into_bytes());
        let deck = Dataset::parse(deck).value;
        let file = Source::new("a.acf", format!("\n{commands}\n").into_bytes());
        let file = CommandFile::parse(file).value;
        let mut overlay = Overlay::of(&deck.statements()[0], deck.source());
        for command in file.commands() {
            overlay.put(command, file.source());
        }
        overlay
    }

    #[test]
    fn what_is_named_again_is_replaced_and_the_rest_stays() {
        let bushing = over(
            "BUSHING/1, I=1, J=2, K=1,2,3",
            "BUSHING/1, K=4,5,6\nBUSHING/1, K=7,8,9, LIST",
        );
        assert_eq!(shown(&bushing), ["I=1", "J=2", "K=7,8,9"]);
        assert_eq!(bushing.above.len(), 1);
        let numbers = |n: &Number| n.value;
        let k: Vec<f64> = bushing.stated().numbers("K").iter().map(numbers).collect();
        assert_eq!(k, [7.0, 8.0, 9.0]);
        let spline = over(
            "SPLINE/1, X=1,2, Y=1,5,6, Y=2,7,8",
            "SPLINE/1, Y=1,0,0, Y=2,1,1",
        );
        assert_eq!(spline.stated().all("Y").count(), 2);
    }

    #[test]
    fn what_is_excluded_goes_with_what_stands_together_with_it() {
        let marker = over("MARKER/1, PART=2, REULER=1,2,3", "MARKER/1, ZP=1,0,0");
        assert_eq!(shown(&marker), ["PART=2", "ZP=1,0,0"]);
        let motion = over("MOTION/1, I=1, J=2, Z, FUN=0", "MOTION/1, JOINT=3");
        assert_eq!(shown(&motion), ["Z", "FUN=0", "JOINT=3"]);
        let settings = over("EQUIL/ERR=1, TLIM=3", "EQUIL/DEFAULT, IMB=2");
        assert_eq!(shown(&settings), ["IMB=2"]);
        let method = over("INTEGRATOR/WSTIFF, SI2", "INTEGRATOR/GSTIFF");
        let words: Vec<_> = method.stated().latest(&["GSTIFF", "WSTIFF"]).collect();
        assert_eq!(words, ["GSTIFF"]);
    }
}
