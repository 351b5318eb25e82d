//! Edits of whole lines and blocks: new keys, rows and blocks that are split into left and right.

use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Edit, Span};

use crate::edit::with_blanks;

/// Returns the span of the whole lines that contain a span, without the last line end.
pub(crate) fn whole_lines(bytes: &[u8], span: Span) -> Span {
    let start = bytes[..span.start()]
        .iter()
        .rposition(|byte| matches!(byte, b'\n' | b'\r'))
        .map_or(0, |at| at + 1);
    let end = bytes[span.end()..]
        .iter()
        .position(|byte| matches!(byte, b'\n' | b'\r'))
        .map_or(bytes.len(), |at| span.end() + at);
    Span::new(start, end)
}

/// Returns the line end that follows a position, or the first line end of the file, or LF.
pub(crate) fn line_end(bytes: &[u8], at: usize) -> &'static [u8] {
    let first = |bytes: &[u8]| -> Option<&'static [u8]> {
        let at = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
        Some(match bytes[at..] {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        })
    };
    first(&bytes[at..])
        .or_else(|| first(bytes))
        .unwrap_or(b"\n")
}

/// Returns the edit that adds a line `KEY = value` after the last parameter of a block, in the style of that parameter. `value` is written as
/// it is.
pub(crate) fn new_key(file: &PropertyFile, block: usize, key: &str, value: &str) -> Vec<Edit> {
    let Some(block) = file.blocks.get(block) else {
        return Vec::new();
    };
    let bytes = file.source().bytes();
    let last = block.parameters.last();
    let after = whole_lines(bytes, last.map_or(block.heading, |last| last.span));
    let mut line = line_end(bytes, after.end()).to_vec();
    let style = last.and_then(|last| {
        let text = &bytes[after.range()];
        let equals = text.iter().position(|byte| *byte == b'=')?;
        let lead = text.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let behind = &text[equals + 1..];
        let blanks = behind
            .iter()
            .take_while(|b| b.is_ascii_whitespace())
            .count();
        (last.span.start() >= after.start()).then_some((lead, equals, blanks))
    });
    let (lead, equals, blanks) = style.unwrap_or((1, 0, 2));
    let name = format!("{}{key}", " ".repeat(lead));
    let name = with_blanks(&name, equals);
    let text = format!("{name}={}{value}", " ".repeat(blanks));
    line.extend_from_slice(text.as_bytes());
    vec![Edit::new(Span::at(after.end()), line)]
}

/// Returns the span of a block, including the rule of minus signs above its heading, up to the next block or the end of the file.
pub(crate) fn whole_block(file: &PropertyFile, block: usize) -> Option<Span> {
    let bytes = file.source().bytes();
    let start_of = |heading: Span| {
        let start = whole_lines(bytes, heading).start();
        let above = start.checked_sub(1)?;
        // A CR LF is one line end.
        let crlf = bytes[above] == b'\n' && above > 0 && bytes[above - 1] == b'\r';
        let end = if crlf { above - 1 } else { above };
        let line = whole_lines(bytes, Span::at(end));
        let is_rule = bytes[line.range()].trim_ascii_start().starts_with(b"$---");
        Some(if is_rule { line.start() } else { start })
    };
    let own = file.blocks.get(block)?.heading;
    let next = file.blocks[block + 1..]
        .iter()
        .find(|block| block.part.is_none())
        .map(|block| block.heading);
    let start = start_of(own).unwrap_or(0);
    let end = next.map_or(bytes.len(), |next| start_of(next).unwrap_or(bytes.len()));
    Some(Span::new(start, end.max(start)))
}

/// Returns the edit that inserts a copy of a block after the block itself.
pub(crate) fn repeated_block(file: &PropertyFile, block: usize) -> Option<Edit> {
    let bytes = file.source().bytes();
    let span = whole_block(file, block)?;
    let own = &bytes[span.range()];
    let mut copy = Vec::new();
    if !own.ends_with(b"\n") && !own.ends_with(b"\r") {
        copy.extend_from_slice(line_end(bytes, span.end()));
    }
    copy.extend_from_slice(own);
    Some(Edit::new(Span::at(span.end()), copy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::{Source, apply_edits};

    fn file(text: &str) -> PropertyFile {
        PropertyFile::parse(Source::new("a.sub", text)).value
    }

    #[test]
    fn a_new_key_stands_below_the_last_one_in_its_style() {
        for (text, expected) in [
            (
                "[A]\r\n X     =  1\r\n\r\n[B]\r\n",
                "[A]\r\n X     =  1\r\n NEW   =  2\r\n\r\n[B]\r\n",
            ),
            ("[A]\nX=1 ! note", "[A]\nX=1 ! note\nNEW=2"),
            ("[A]\n", "[A]\n NEW=  2\n"),
        ] {
            let file = file(text);
            let edits = new_key(&file, 0, "NEW", "2");
            let new = apply_edits(text.as_bytes(), &edits).expect("one place");
            assert_eq!(String::from_utf8(new).expect("text"), expected);
        }
    }

    #[test]
    fn a_block_is_repeated_with_its_rule() {
        let text = "$---A\n[A]\nX=1\n$---B\n[B]\nY=2\n(P)\n{t}\n'z'";
        let file = file(text);
        let twice = |block| {
            let edit = repeated_block(&file, block).expect("a block");
            let new = apply_edits(text.as_bytes(), &[edit]).expect("one place");
            String::from_utf8(new).expect("text")
        };
        assert_eq!(twice(0), text.replace("$---B", "$---A\n[A]\nX=1\n$---B"));
        assert_eq!(
            twice(1),
            format!("{text}\n$---B\n[B]\nY=2\n(P)\n{{t}}\n'z'")
        );
    }
}
