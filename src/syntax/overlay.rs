//! Statements that later ones change: an argument that is named again replaces the old one, all others stay.

use std::borrow::Cow;

use super::{Argument, Number, Shared, Statement, Value};
use crate::grammar::{Presence, StatementDef};
use crate::text::{Source, Span};

/// Arguments of commands that are no data of the statement.
const COMMAND_WORDS: [&str; 2] = ["DEFAULT", "LIST"];

/// A statement and the text it was read from.
#[derive(Clone, Debug)]
struct Layer {
    statement: Statement,
    source: Source,
}

/// A statement with what was put over it. Each argument stands in one layer only.
#[derive(Clone, Debug)]
pub struct Overlay {
    first: Layer,
    /// The earliest first.
    above: Vec<Layer>,
}

impl Overlay {
    /// A statement as it was read.
    pub fn of(statement: &Statement, source: &Source) -> Self {
        Self {
            first: Layer {
                statement: without(statement, is_command_word),
                source: source.clone(),
            },
            above: Vec::new(),
        }
    }

    /// Puts the arguments of a later statement or command over it. They replace those of the same name, and those they exclude; with one
    /// of these go all that stand together with it. DEFAULT drops everything before it.
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

    /// All its arguments in one statement, with keyword and id of the command that was put over it last. Of its arguments only what they
    /// are means anything: they were read from several texts.
    pub fn under(&self, command: &Statement) -> Statement {
        let arguments = self.stated().arguments();
        Statement {
            arguments: arguments.map(|(argument, _)| argument.clone()).collect(),
            ..command.clone()
        }
    }

    /// The statement as it stands now.
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

/// True if two arguments cannot stand in one statement.
pub fn excludes(def: &StatementDef, a: &str, b: &str) -> bool {
    a != b
        && def.presence.iter().any(|presence| match presence {
            Presence::Exclusive(names) | Presence::OneOf(names) => {
                names.contains(&a) && names.contains(&b)
            }
            _ => false,
        })
}

/// A statement as it stands: as it was read, or with what was put over it.
#[derive(Clone, Copy)]
pub struct Stated<'a> {
    statement: &'a Statement,
    source: &'a Source,
    above: &'a [Layer],
}

impl<'a> Stated<'a> {
    /// A statement that nothing was put over.
    pub fn plain(statement: &'a Statement, source: &'a Source) -> Self {
        Self {
            statement,
            source,
            above: &[],
        }
    }

    /// The id, if it has one.
    pub fn number(&self) -> Option<u32> {
        self.statement.number()
    }

    /// Its name, if the file gives one.
    pub fn view_name(&self) -> Option<Cow<'a, str>> {
        Some(self.source.text(self.statement.view_name?))
    }

    /// Where its keyword stands.
    pub fn keyword(&self) -> (&'a Source, Span) {
        (self.source, self.statement.keyword)
    }

    /// Where the keyword of what was put over it last stands.
    pub fn latest_keyword(&self) -> (&'a Source, Span) {
        self.above.last().map_or(self.keyword(), |layer| {
            (&layer.source, layer.statement.keyword)
        })
    }

    /// The latest first.
    fn layers(&self) -> impl Iterator<Item = (&'a Statement, &'a Source)> + use<'a> {
        let above = self.above.iter().rev();
        above
            .map(|layer| (&layer.statement, &layer.source))
            .chain(std::iter::once((self.statement, self.source)))
    }

    /// Every argument, those of the earliest layer first, with the text it was read from.
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

    /// The argument with this whole keyword (in capitals), if it is there.
    pub fn argument(&self, name: &str) -> Option<&'a Argument> {
        self.found(name).map(|(argument, _)| argument)
    }

    /// Every argument with this keyword, in order: SPLINE has several Y.
    pub fn all<'n>(&self, name: &'n str) -> impl Iterator<Item = &'a Argument> + use<'a, 'n> {
        let arguments = self.arguments().map(|(argument, _)| argument);
        arguments.filter(move |argument| argument.kind() == Some(name))
    }

    /// True if the word stands among the arguments.
    pub fn has(&self, name: &str) -> bool {
        self.found(name).is_some()
    }

    /// Of these words those that stand in one layer, the latest that has any.
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

    /// The numbers of an argument; empty if it is absent or holds none.
    pub fn numbers(&self, name: &str) -> &'a [Number] {
        self.argument(name).map_or(&[], Argument::numbers)
    }

    /// The first number of an argument.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().map(|number| number.value)
    }

    /// The text of an argument; of a function what is written.
    pub fn text(&self, name: &str) -> Option<Cow<'a, str>> {
        let (argument, source) = self.found(name)?;
        argument.text(source)
    }

    /// The texts or words of an argument.
    pub fn texts(&self, name: &str) -> Option<Vec<Cow<'a, str>>> {
        let (argument, source) = self.found(name)?;
        Some(argument.texts(source))
    }

    /// The choice words of an argument, whole and in capitals.
    pub fn choices(&self, name: &str) -> Option<Vec<&'static str>> {
        let (argument, source) = self.found(name)?;
        Some(argument.choices(source))
    }

    /// True for an argument whose value is `USER(...)`.
    pub fn is_user(&self, name: &str) -> bool {
        self.argument(name)
            .is_some_and(|argument| matches!(argument.value, Value::User(_)))
    }

    /// Where the value of an argument stands; the keyword of the statement if it is not written.
    pub fn place(&self, name: &str) -> (&'a Source, Span) {
        self.found(name)
            .map_or(self.keyword(), |(argument, source)| {
                (source, argument.value_span())
            })
    }

    /// True for a FRICTION whose stiction acts in statics too: nothing but INACTIVE=STATIC or EFFECT=SLIDING keeps it from that
    /// (`state_friction`: INACTIVE has no default, EFFECT is ALL).
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
