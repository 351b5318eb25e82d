use std::fmt;

use crate::declaration::{
    Argument, Count, Function, Grammar, Keyword, Law, LeftOut, Presence, Range, Solved, Statement,
    Value,
};

/// A problem in a grammar file, with its location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseError {
    /// Name of the file, as given by the caller.
    pub file: String,
    /// Line number, from 1.
    pub line: usize,
    /// The problem found in the line.
    pub problem: Problem,
}

/// Problem in a line of a grammar file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A word is not a valid keyword: capital letters (the shortest legal abbreviation) followed by lower-case letters.
    Keyword(String),
    /// A word is unexpected; holds a description of the words expected there, then the word found.
    Expected(&'static str, String),
    /// A line is outside of any statement and of any block of functions.
    Outside,
    /// A statement or a block of functions lacks a required line; holds the first word of that line, then the name of the statement or
    /// function.
    Missing(&'static str, String),
    /// A name is declared twice.
    Twice(String),
    /// A presence rule, a law, a `leftout` line or a reference contains a name that is not declared.
    Unknown(String),
    /// The default of this argument has a number of values that the count of the argument does not allow.
    DefaultCount(String),
    /// Two keywords in the same context have the same shortest legal abbreviation.
    Clash(String, String),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Keyword(word) => write!(
                f,
                "`{word}` is not a keyword with its must-type letters in front, in capitals"
            ),
            Self::Expected(what, word) => write!(f, "expected {what}, found `{word}`"),
            Self::Outside => write!(f, "this line is in no statement and no function block"),
            Self::Missing(what, name) => write!(f, "`{name}` has no `{what}`"),
            Self::Twice(name) => write!(f, "`{name}` is declared twice"),
            Self::Unknown(name) => write!(f, "`{name}` is not declared"),
            Self::DefaultCount(name) => write!(f, "`{name}` has a default of the wrong count"),
            Self::Clash(a, b) => write!(f, "the shortest forms of `{a}` and `{b}` are the same"),
        }
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.problem)
    }
}

impl std::error::Error for ParseError {}

/// The statement or block of functions to which the following lines belong.
enum Block {
    None,
    Statement(Box<Draft>),
    Functions(FunctionBlock),
}

struct Draft {
    statement: Statement,
    solved: Option<Solved>,
    role: Option<&'static str>,
}

struct FunctionBlock {
    solved: Option<Solved>,
    source: String,
}

/// Parses the text of one grammar file and appends its declarations to the grammar.
///
/// # Errors
/// Returns an error for the first line that violates the format.
pub fn parse(file: &str, text: &str, grammar: &mut Grammar) -> Result<(), ParseError> {
    let mut block = Block::None;
    for (index, line) in text.lines().enumerate() {
        let fail = |problem| ParseError {
            file: file.to_string(),
            line: index + 1,
            problem,
        };
        let (code, doc) = split_comment(line);
        let words: Vec<&str> = code.split_whitespace().collect();
        let Some(&first) = words.first() else {
            continue;
        };
        let rest = code.trim_start()[first.len()..].trim();
        match (first, &mut block) {
            ("statement", _) => {
                finish(&mut block, grammar)?;
                block = Block::Statement(Box::new(
                    header(&words, doc, (file.to_string(), index + 1)).map_err(fail)?,
                ));
            }
            ("functions", _) => {
                finish(&mut block, grammar)?;
                block = Block::Functions(FunctionBlock {
                    solved: None,
                    source: String::new(),
                });
            }
            (_, Block::None) => return Err(fail(Problem::Outside)),
            ("role", Block::Statement(draft)) => {
                let roles = [
                    ("dataset", "Dataset"),
                    ("command", "Command"),
                    ("both", "Both"),
                ];
                let found = roles.iter().find(|(word, _)| *word == rest);
                let expected = || Problem::Expected("dataset, command or both", rest.into());
                draft.role = Some(found.ok_or_else(expected).map_err(fail)?.1);
            }
            ("solved", Block::Statement(draft)) => {
                draft.solved = Some(solved(rest).map_err(fail)?);
            }
            ("solved", Block::Functions(functions)) => {
                functions.solved = Some(solved(rest).map_err(fail)?);
            }
            ("source", Block::Statement(draft)) => draft.statement.source = rest.to_string(),
            ("unchecked", Block::Statement(draft)) => {
                draft.statement.unchecked = quoted(rest).map_err(fail)?;
            }
            ("source", Block::Functions(functions)) => functions.source = rest.to_string(),
            ("exclusive" | "together" | "requires" | "oneof", Block::Statement(draft)) => {
                let rule = match first {
                    "exclusive" => "Exclusive",
                    "together" => "Together",
                    "requires" => "Requires",
                    _ => "OneOf",
                };
                let names = words[1..].iter().map(ToString::to_string).collect();
                draft.statement.presence.push(Presence { rule, names });
            }
            ("leftout", Block::Statement(draft)) => {
                draft.statement.left_out.push(left_out(rest).map_err(fail)?);
            }
            ("law", Block::Statement(draft)) => {
                let missing = || Problem::Expected("the name of a law", String::new());
                let law = Law::read(&words[1..]).ok_or_else(missing).map_err(fail)?;
                draft.statement.laws.push(law);
            }
            (_, Block::Statement(draft)) => {
                let argument = argument(first, rest, doc).map_err(fail)?;
                draft.statement.arguments.push(argument);
            }
            (_, Block::Functions(functions)) => {
                let Some(solved) = functions.solved.clone() else {
                    return Err(fail(Problem::Missing("solved", first.into())));
                };
                grammar.functions.push(Function {
                    name: first.to_string(),
                    count: count_of(rest).map_err(fail)?,
                    arguments: if rest == "-" {
                        String::new()
                    } else {
                        rest.to_string()
                    },
                    solved,
                    doc: doc.to_string(),
                    source: functions.source.replace("{}", &first.to_lowercase()),
                    place: (file.to_string(), index + 1),
                });
            }
        }
    }
    finish(&mut block, grammar)
}

/// Splits a line at the first `#` outside of quotes into code and description. For a remark (`##`), the description is empty.
fn split_comment(line: &str) -> (&str, &str) {
    let mut quoted = false;
    for (at, c) in line.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '#' if !quoted => {
                let doc = &line[at + 1..];
                return (
                    &line[..at],
                    if doc.starts_with('#') { "" } else { doc.trim() },
                );
            }
            _ => {}
        }
    }
    (line, "")
}

fn finish(block: &mut Block, grammar: &mut Grammar) -> Result<(), ParseError> {
    let Block::Statement(draft) = std::mem::replace(block, Block::None) else {
        return Ok(());
    };
    let Draft {
        mut statement,
        solved,
        role,
    } = *draft;
    let fail = |what| ParseError {
        file: statement.place.0.clone(),
        line: statement.place.1,
        problem: Problem::Missing(what, statement.keyword.name.clone()),
    };
    let solved = solved.ok_or_else(|| fail("solved"))?;
    let role = role.ok_or_else(|| fail("role"))?;
    if statement.source.is_empty() {
        return Err(fail("source"));
    }
    statement.solved = solved;
    statement.role = role;
    grammar.statements.push(statement);
    Ok(())
}

fn header(words: &[&str], doc: &str, place: (String, usize)) -> Result<Draft, Problem> {
    let name = words
        .get(1)
        .ok_or(Problem::Expected("a keyword", String::new()))?;
    let keyword = keyword(name)?;
    let id = match words.get(2..).unwrap_or_default() {
        [] => None,
        ["/", "id"] => Some(keyword.name.to_lowercase()),
        ["/", "id", space] => Some((*space).to_string()),
        other => return Err(Problem::Expected("`/ id` or `/ id space`", other.join(" "))),
    };
    Ok(Draft {
        statement: Statement {
            keyword,
            role: "Both",
            id,
            arguments: Vec::new(),
            presence: Vec::new(),
            left_out: Vec::new(),
            laws: Vec::new(),
            solved: Solved::Native(String::new()),
            doc: doc.to_string(),
            source: String::new(),
            unchecked: String::new(),
            place,
        },
        solved: None,
        role: None,
    })
}

/// Parses the text of a `leftout` line after its first word: `NAME ... "effect"`.
fn left_out(text: &str) -> Result<LeftOut, Problem> {
    let (names, effect) = text.split_at(text.find('"').unwrap_or(text.len()));
    Ok(LeftOut::new(names, quoted(effect)?))
}

fn keyword(word: &str) -> Result<Keyword, Problem> {
    let minimum = word
        .find(|c: char| c.is_ascii_lowercase())
        .unwrap_or(word.len());
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if minimum == 0
        || !word.chars().all(legal)
        || word[minimum..].contains(|c: char| c.is_ascii_uppercase())
    {
        return Err(Problem::Keyword(word.into()));
    }
    Ok(Keyword {
        name: word.to_uppercase(),
        minimum,
    })
}

fn quoted(text: &str) -> Result<String, Problem> {
    text.trim()
        .strip_prefix('"')
        .and_then(|inner| inner.strip_suffix('"'))
        .map(ToString::to_string)
        .ok_or(Problem::Expected("a text in quotes", text.into()))
}

fn solved(text: &str) -> Result<Solved, Problem> {
    let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
    match word {
        "native" => Ok(Solved::Native(rest.trim().to_string())),
        "no-effect" => Ok(Solved::NoEffect(quoted(rest)?)),
        "external" => Ok(Solved::External(quoted(rest)?)),
        "subroutine" => Ok(Solved::Subroutine(quoted(rest)?)),
        _ => {
            let expected = "native, no-effect, external or subroutine";
            Err(Problem::Expected(expected, text.into()))
        }
    }
}

fn argument(name: &str, rest: &str, doc: &str) -> Result<Argument, Problem> {
    let keyword = keyword(name)?;
    let mut words = rest.split_whitespace().peekable();
    let word = words.next().unwrap_or_default();
    let (kind, count) = match word.find('[') {
        Some(at) => (&word[..at], count(&word[at..])?),
        None => (
            word,
            Count {
                min: 1,
                max: Some(1),
            },
        ),
    };
    let inner = |prefix: &str| kind.strip_prefix(prefix).and_then(|k| k.strip_suffix('>'));
    let value = match kind {
        "flag" => Value::Flag,
        "real" => Value::Real,
        "int" => Value::Integer,
        "function" => Value::Function,
        "text" => Value::Text,
        "texts" => Value::Texts,
        "file" => Value::File,
        _ => {
            if let Some(space) = inner("ref<") {
                Value::Reference(space.to_string())
            } else if let Some(choices) = inner("word<") {
                Value::Word(
                    choices
                        .split('|')
                        .map(self::keyword)
                        .collect::<Result<_, _>>()?,
                )
            } else {
                return Err(Problem::Expected("a type", word.into()));
            }
        }
    };
    let count = if value == Value::Flag {
        Count {
            min: 0,
            max: Some(0),
        }
    } else {
        count
    };
    let mut argument = Argument {
        keyword,
        value,
        count,
        default: Vec::new(),
        dimension: [0; 5],
        components: "Alike",
        range: Range::default(),
        required: false,
        doc: doc.to_string(),
    };
    let number = |word: Option<&str>| {
        let word = word.unwrap_or_default();
        match word.strip_suffix('D') {
            Some(degrees) => degrees.parse().map(f64::to_radians),
            None => word.parse(),
        }
        .map_err(|_| Problem::Expected("a number", word.into()))
    };
    while let Some(word) = words.next() {
        match word {
            "required" => argument.required = true,
            "=" => {
                while let Some(&next) = words.peek() {
                    let Ok(value) = number(Some(next)) else { break };
                    argument.default.push(value);
                    words.next();
                }
            }
            ">" => argument.range.lower = Some((number(words.next())?, false)),
            ">=" => argument.range.lower = Some((number(words.next())?, true)),
            "<" => argument.range.upper = Some((number(words.next())?, false)),
            "<=" => argument.range.upper = Some((number(words.next())?, true)),
            _ => match word.strip_prefix('[').and_then(|w| w.strip_suffix(']')) {
                Some("motion") => argument.components = "Motion",
                Some("wrench") => argument.components = "Wrench",
                Some("wrench/motion") => argument.components = "Stiffness",
                Some("wrench*time/motion") => argument.components = "Damping",
                Some(text) => argument.dimension = dimension(text)?,
                None => {
                    return Err(Problem::Expected(
                        "required, =, a range or a dimension",
                        word.into(),
                    ));
                }
            },
        }
    }
    let too_many = count.max.is_some_and(|max| argument.default.len() > max);
    if too_many || (!argument.default.is_empty() && argument.default.len() < count.min) {
        return Err(Problem::DefaultCount(argument.keyword.name));
    }
    Ok(argument)
}

/// Parses a count in one of the forms `[3]`, `[3..6]` and `[1..]`.
fn count(text: &str) -> Result<Count, Problem> {
    let bad = || Problem::Expected("a count like [3], [3..6] or [1..]", text.into());
    let inner = text
        .strip_prefix('[')
        .and_then(|t| t.strip_suffix(']'))
        .ok_or_else(bad)?;
    let number = |t: &str| t.parse::<usize>().map_err(|_| bad());
    match inner.split_once("..") {
        None => {
            let n = number(inner)?;
            Ok(Count {
                min: n,
                max: Some(n),
            })
        }
        Some((min, "")) => Ok(Count {
            min: number(min)?,
            max: None,
        }),
        Some((min, max)) => Ok(Count {
            min: number(min)?,
            max: Some(number(max)?),
        }),
    }
}

/// Parses a dimension; returns the exponents of force, mass, length, time and angle.
///
/// The text is a product or quotient of `force`, `mass`, `length`, `time`, `angle`, `torque` and `1`, which may have exponents after `^`:
/// `mass*length^2`, `force/length`.
fn dimension(text: &str) -> Result<[i8; 5], Problem> {
    let mut out = [0; 5];
    let mut sign = 1;
    let mut rest = text;
    loop {
        let end = rest.find(['*', '/']).unwrap_or(rest.len());
        let (base, power) = rest[..end].split_once('^').unwrap_or((&rest[..end], "1"));
        let bad = || Problem::Expected("a dimension", text.into());
        let power = sign * power.parse::<i8>().map_err(|_| bad())?;
        let base: [i8; 5] = match base {
            "1" => [0; 5],
            "force" => [1, 0, 0, 0, 0],
            "mass" => [0, 1, 0, 0, 0],
            "length" => [0, 0, 1, 0, 0],
            "time" => [0, 0, 0, 1, 0],
            "angle" => [0, 0, 0, 0, 1],
            "torque" => [1, 0, 1, 0, 0],
            _ => return Err(bad()),
        };
        for (exponent, b) in out.iter_mut().zip(base) {
            *exponent += power * b;
        }
        match rest[end..].chars().next() {
            None => return Ok(out),
            Some(c) => {
                sign = if c == '/' { -1 } else { 1 };
                rest = &rest[end + 1..];
            }
        }
    }
}

/// Derives the allowed number of arguments from the declared argument list. Optional arguments are in brackets; `...` means that there is
/// no upper limit.
fn count_of(shown: &str) -> Result<Count, Problem> {
    if shown.is_empty() {
        return Err(Problem::Expected(
            "the arguments, or - for none",
            shown.into(),
        ));
    }
    if shown == "-" {
        return Ok(Count {
            min: 0,
            max: Some(0),
        });
    }
    let (mut depth, mut min, mut max) = (0_usize, 0, 0);
    let mut fresh = true;
    for c in shown.chars() {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            ',' | ':' => fresh = true,
            c if c.is_alphanumeric() && fresh => {
                fresh = false;
                max += 1;
                min += usize::from(depth == 0);
            }
            _ => {}
        }
    }
    let open = shown.contains("...");
    Ok(Count {
        min,
        max: (!open).then_some(max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check;

    const SMALL: &str = "\
statement BUshing / id            # A bushing.
  role     both
  solved   native bushing
  source   page.html
  unchecked \"K # and TYPE\"
  I        ref<bushing> required  # action marker
  K        real[3]  = 0 0 0  [torque/angle^2]  >= 0   # stiffness
  TYpe     word<Ring|SOlid>[1..]
  oneof    I K
  law      spring K for TYPE
functions measures
  solved   external \"why # not\"
  source   cfunc_{}.html
  DX       i[,j][,k]              # x
  POLY     x,x0,a0[,...]
  TIME     -
";

    fn read(text: &str) -> Result<Grammar, ParseError> {
        let mut grammar = Grammar::default();
        parse("small.grammar", text, &mut grammar)?;
        check(&grammar)?;
        Ok(grammar)
    }

    #[test]
    fn every_kind_of_line_is_read() {
        let grammar = read(SMALL).unwrap();
        let bushing = &grammar.statements[0];
        assert_eq!(
            (bushing.keyword.name.as_str(), bushing.keyword.minimum),
            ("BUSHING", 2)
        );
        assert_eq!(bushing.id.as_deref(), Some("bushing"));
        assert_eq!(bushing.unchecked, "K # and TYPE");
        let k = &bushing.arguments[1];
        assert_eq!(k.dimension, [1, 0, 1, 0, -2]);
        assert_eq!(k.default, [0.0; 3]);
        let law = &bushing.laws[0];
        assert_eq!(
            (law.name.as_str(), law.flag.as_deref()),
            ("spring", Some("TYPE"))
        );
        assert_eq!(law.arguments, ["K"]);
        assert_eq!(k.range.lower, Some((0.0, true)));
        assert_eq!(bushing.arguments[2].count, Count { min: 1, max: None });
        let counts: Vec<_> = grammar
            .functions
            .iter()
            .map(|f| (f.count.min, f.count.max))
            .collect();
        assert_eq!(counts, [(1, Some(3)), (3, None), (0, Some(0))]);
        assert_eq!(grammar.functions[0].source, "cfunc_dx.html");
        assert_eq!(
            grammar.functions[0].solved,
            Solved::External("why # not".into())
        );
    }

    #[test]
    fn errors_are_located() {
        let twice = SMALL.replace("TYpe ", "K    ");
        let reel = SMALL.replace("real[3]", "reel[3]");
        let cases = [
            (reel, "small.grammar:7: expected a type, found `reel[3]`"),
            (
                SMALL.replace("BUshing", "buSHING"),
                "small.grammar:1: `buSHING` is not a keyword with its must-type letters in front, in capitals",
            ),
            (
                SMALL.replace("oneof    I K", "oneof    I Q"),
                "small.grammar:1: `Q` is not declared",
            ),
            (twice, "small.grammar:1: `K` is declared twice"),
            (
                SMALL.replace("  role     both\n", ""),
                "small.grammar:1: `BUSHING` has no `role`",
            ),
            (
                SMALL.replace("= 0 0 0", "= 0 0"),
                "small.grammar:7: `K` has a default of the wrong count",
            ),
        ];
        for (text, message) in cases {
            assert_eq!(read(&text).unwrap_err().to_string(), message);
        }
    }
}
