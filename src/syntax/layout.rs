//! Uniform layout of the statements in a file: line breaks and blanks between words. Words and comments do not change.

use super::style::Style;
use super::{Argument, CommandFile, Dataset, Statement, Token, TokenKind};
use crate::text::{Edit, Source, Span};

/// Returns the edits that give all statements touching `span` the layout that prevails in the dataset.
pub fn layout(dataset: &Dataset, span: Span) -> Vec<Edit> {
    let style = Style::of(dataset);
    let meets = |statement: &&Statement| {
        statement.span.start() <= span.end() && span.start() <= statement.span.end()
    };
    let statements = dataset.statements().iter().filter(meets);
    statements
        .filter_map(|statement| relaid(dataset, statement, &style))
        .collect()
}

/// Returns the edits that give all commands touching `span` the layout that prevails in the command file.
pub fn layout_of_commands(file: &CommandFile, span: Span) -> Vec<Edit> {
    layout(&Dataset::of_commands(file), span)
}

/// Returns the edit that lays out one statement again.
///
/// Returns `None` if the statement already has this layout, or if a new layout would lose something, such as a comment inside the
/// statement.
fn relaid(dataset: &Dataset, statement: &Statement, style: &Style) -> Option<Edit> {
    // In a STRING, blanks may belong to the text. ADAMS/View writes `STRING =text` there, but ` = ` everywhere else.
    if statement.kind() == Some("STRING") {
        return None;
    }
    let source = dataset.source();
    let (head, mut at) = head(source, statement)?;
    let mut text = head;
    for (k, argument) in statement.arguments.iter().enumerate() {
        let separated = separation(source.slice(Span::new(at, argument.name.start())))?;
        let value = match value(source, argument) {
            Written::Nothing => None,
            Written::Value(value) => Some(value),
            Written::Other => return None,
        };
        text.push_str(if separated { "\\" } else { "" });
        let name = source.text(argument.name);
        let first = k == 0 && text.ends_with('/') && statement.id.is_none();
        if first && style.behind_slash {
            let written = style.argument(&name, value.as_deref());
            text.push_str(written.trim_start_matches([' ', '&', ',', '\r', '\n']));
        } else {
            text.push_str(&style.argument(&name, value.as_deref()));
        }
        at = end_of(source, argument);
    }
    let rest = source.slice(Span::new(at, statement.span.end()));
    let rest = String::from_utf8_lossy(rest).trim().to_string();
    if !matches!(rest.as_str(), "" | ";" | "\\" | "\\;") {
        return None;
    }
    text.push_str(&rest);
    let old = source.text(statement.span);
    if text == old || !means_the_same(dataset, statement, &text) {
        return None;
    }
    Some(Edit::new(statement.span, text))
}

/// Returns the keyword, slash and id of a statement as text, and the offset at which they end.
fn head(source: &Source, statement: &Statement) -> Option<(String, usize)> {
    statement.def?;
    let keyword = source.text(statement.keyword);
    let bytes = source.slice(Span::new(statement.keyword.end(), statement.span.end()));
    let blanks = bytes.len() - bytes.trim_ascii_start().len();
    let slash = bytes[blanks..].first() == Some(&b'/');
    let mut text = keyword.into_owned();
    let mut end = statement.keyword.end();
    if slash {
        text.push('/');
        end += blanks + 1;
    }
    if let Some((_, span)) = statement.id {
        text.push_str(&source.text(span));
        end = span.end();
    }
    Some((text, end))
}

/// Returns true if the separator between two arguments contains a backslash. Returns `None` if the separator contains anything else than
/// blanks, line ends, commas, `&` and one backslash.
fn separation(between: &[u8]) -> Option<bool> {
    let mut backslash = false;
    for byte in between {
        match byte {
            b' ' | b'\t' | b'\r' | b'\n' | b',' | b'&' => {}
            b'\\' if !backslash => backslash = true,
            _ => return None,
        }
    }
    Some(backslash)
}

/// Returns the offset at which an argument ends; the closing quote of a quoted text belongs to the argument.
fn end_of(source: &Source, argument: &Argument) -> usize {
    let end = argument.span.end();
    let quoted = source.bytes().get(end) == Some(&b'"');
    end + usize::from(quoted && opens_quote(source.slice(argument.span)))
}

fn opens_quote(text: &[u8]) -> bool {
    text.iter().filter(|byte| **byte == b'"').count() % 2 == 1
}

/// Text after the name of an argument.
enum Written {
    /// No text: the argument is a flag.
    Nothing,
    /// A value.
    Value(String),
    /// Text that a new layout cannot preserve.
    Other,
}

/// Returns the text of an argument's value. Values in quotes or of several lines stay unchanged; in other values, each run of blanks
/// becomes one blank.
fn value(source: &Source, argument: &Argument) -> Written {
    let written = source.text(Span::new(argument.name.end(), end_of(source, argument)));
    let Some(value) = written.trim_start().strip_prefix('=') else {
        let nothing = written.trim().is_empty();
        return if nothing {
            Written::Nothing
        } else {
            Written::Other
        };
    };
    let value = value.trim();
    if value.contains('!') {
        return Written::Other;
    }
    if value.contains(['\n', '\r', '"']) {
        return Written::Value(value.to_string());
    }
    let words: Vec<&str> = value.split_ascii_whitespace().collect();
    let mut text = words.join(" ");
    // In a list of numbers, `1 ,2` and `1,2` become `1, 2`.
    if !argument.numbers().is_empty() && !text.contains('(') {
        let numbers: Vec<&str> = text.split(',').map(str::trim).collect();
        text = numbers.join(", ");
    }
    Written::Value(text)
}

/// Returns true if `text` parses to the same statement as before, word by word.
fn means_the_same(dataset: &Dataset, statement: &Statement, text: &str) -> bool {
    let source = dataset.source();
    let alone = Source::new(source.name(), format!("t\n{text}\nEND\n"));
    let read = Dataset::parse(alone);
    let [new, end] = read.value.statements() else {
        return false;
    };
    let same_argument = |(a, b): (&Argument, &Argument)| {
        let (old, new) = (a.numbers(), b.numbers());
        a.def == b.def
            && std::mem::discriminant(&a.value) == std::mem::discriminant(&b.value)
            && old.len() == new.len()
            && old.iter().zip(new).all(|(old, new)| old.value == new.value)
            && words(source, Argument::value_span(a)) == words(read.value.source(), b.value_span())
    };
    let said = |dataset: &Dataset, statement: &Statement| {
        let tokens = dataset.statement_tokens(statement);
        spoken(dataset.source(), tokens)
    };
    let old = spoken(source, dataset.statement_tokens(statement));
    end.is_end(read.value.source())
        && statement.id.map(|(id, _)| id) == new.number()
        && statement.arguments.len() == new.arguments.len()
        && statement
            .arguments
            .iter()
            .zip(&*new.arguments)
            .all(same_argument)
        && old == said(&read.value, new)
}

fn words(source: &Source, span: Span) -> Vec<String> {
    let text = source.text(span);
    text.split_ascii_whitespace()
        .map(str::to_string)
        .collect::<Vec<_>>()
        .concat()
        .split(',')
        .map(str::to_string)
        .collect()
}

/// Returns the words and punctuation marks of a statement, without separators.
fn spoken(source: &Source, tokens: impl Iterator<Item = Token>) -> Vec<String> {
    tokens
        .filter(|token| {
            !token.kind.is_trivia()
                && !matches!(
                    token.kind,
                    TokenKind::Continuation | TokenKind::Punctuation(b',')
                )
        })
        .map(|token| source.text(token.span).into_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(text: &str) -> String {
        let dataset = Dataset::parse(Source::new("a", text.as_bytes())).value;
        let all = Span::new(0, text.len());
        let edited = dataset.edited(&layout(&dataset, all)).expect("apart").value;
        // Laying out the result again must change nothing.
        assert_eq!(layout(&edited, Span::new(0, edited.bytes().len())), []);
        String::from_utf8(edited.bytes().to_vec()).expect("text")
    }

    #[test]
    fn statements_without_id_begin_as_most_of_them_do() {
        let markers = "MARKER/1\n, PART = 1\nMARKER/2\n, PART = 1\n";
        let view = format!(
            "t\nUNITS/\n, FORCE = NEWTON\n, MASS = KILOGRAM\n{markers}STRING/1\n, STRING =text\nACCGRAV/\n, JGRAV = -9.8\nOUTPUT/REQSAVE\nEND\n"
        );
        assert_eq!(
            laid(&view),
            view.replace("OUTPUT/REQSAVE", "OUTPUT/\n, REQSAVE")
        );
        let own = format!("t\nUNITS/FORCE = NEWTON\n, MASS = KILOGRAM\n{markers}END\n");
        assert_eq!(laid(&own), own);
    }

    #[test]
    fn statements_take_the_layout_of_the_file_and_keep_their_words() {
        let view = "t\nPART/1\n, GROUND\nMARKER/1\n, PART = 1\nPART/2, MASS=1,CM=20 , IP=1 ,2,\t3\nMARKER/20,PART=2\nSFORCE/1, I=1, J=20, ROT, \
                    FUNCTION = 2*TIME\\, ACTIONONLY ! a\nMARKER/3\n, PART = 1\nEND\n";
        assert_eq!(
            laid(view),
            "t\nPART/1\n, GROUND\nMARKER/1\n, PART = 1\nPART/2\n, MASS = 1\n, CM = 20\n, IP = 1, 2, 3\nMARKER/20\n, PART = 2\nSFORCE/1\n, I = 1\
             \n, J = 20\n, ROT\n, FUNCTION = 2*TIME\\\n, ACTIONONLY ! a\nMARKER/3\n, PART = 1\nEND\n"
        );
        let short = "t\r\nPART/1,GROUND\r\nMARKER/1,PART=1\r\nMARKER/5,PART=1\r\nMARKER/2\r\n, PART = 1\r\n, QP = 1,\r\n  2, 3\r\nMARKER/4\r\n! why\r\n, PART=1\r\nEND\r\n";
        assert_eq!(
            laid(short),
            "t\r\nPART/1, GROUND\r\nMARKER/1, PART=1\r\nMARKER/5, PART=1\r\nMARKER/2, PART=1, QP=1,\r\n  2, 3\r\nMARKER/4\r\n! why\r\n, PART=1\r\nEND\r\n"
        );
    }
}
