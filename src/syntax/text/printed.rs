//! Text from files or paths in a form that is safe to print on a terminal: without control sequences and marks that change the text
//! direction.

use std::borrow::Cow;

/// Returns true for a character that controls the terminal instead of being shown.
///
/// Such characters are the C0 and C1 controls, except line ends and tabs, and the marks that change the direction of text (UAX 9).
fn is_command(c: char, next: Option<char>) -> bool {
    match c {
        '\n' | '\t' => false,
        '\r' => next != Some('\n'),
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
            true
        }
        c => c.is_control(),
    }
}

fn each(text: &str) -> impl Iterator<Item = (char, bool)> {
    let mut rest = text.chars().peekable();
    std::iter::from_fn(move || {
        let c = rest.next()?;
        Some((c, is_command(c, rest.peek().copied())))
    })
}

fn is_harmless(text: &str) -> bool {
    // Most texts are ASCII without control characters; a check of the bytes suffices for them.
    text.bytes()
        .all(|byte| matches!(byte, b' '..=b'~' | b'\n' | b'\t'))
        || each(text).all(|(_, command)| !command)
}

/// Returns a text that is safe to print on a terminal. Control characters are written as in JSON (`\u001b`), so that JSON text keeps its
/// meaning.
pub fn printable(text: &str) -> Cow<'_, str> {
    if is_harmless(text) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for (c, command) in each(text) {
        if command {
            out += &format!("\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// Returns a text that is safe to print and in which every character keeps its byte offset. Control characters become `?` or another
/// character of the same length.
pub fn masked(text: &str) -> Cow<'_, str> {
    if is_harmless(text) {
        return Cow::Borrowed(text);
    }
    let mask = |(c, command): (char, bool)| match (command, c.len_utf8()) {
        (false, _) => c,
        (true, 1) => '?',
        (true, 2) => '\u{bf}',
        (true, _) => '\u{fffd}',
    };
    Cow::Owned(each(text).map(mask).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_a_terminal_is_spelled_out() {
        for (text, shown) in [
            ("plain\ttext\r\n", "plain\ttext\r\n"),
            ("t\u{e9}\u{b7}", "t\u{e9}\u{b7}"),
            ("\u{1b}[31mred", "\\u001b[31mred"),
            ("\u{1b}]0;title\u{7}", "\\u001b]0;title\\u0007"),
            ("\u{9b}31m", "\\u009b31m"),
            ("over\rwritten", "over\\u000dwritten"),
            ("a\u{202e}b\u{2066}", "a\\u202eb\\u2066"),
            ("\u{7f}", "\\u007f"),
        ] {
            assert_eq!(printable(text), shown);
            assert_eq!(masked(text).len(), text.len());
            assert!(each(&masked(text)).all(|(_, command)| !command));
        }
        // In JSON, the escaped character has the same meaning as the character itself.
        let value = serde_json::json!({ "a\u{202e}": "\u{9b}\u{1b}" });
        let text = printable(&value.to_string()).into_owned();
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            value
        );
    }
}
