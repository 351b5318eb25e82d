//! Links in the text of a page: `[words](study.md#heading)`, `[words](https://...)` and pictures, `![words](file.png)`.
//!
//! Code between backticks contains no links, but the words of a link may contain code.

use std::ops::Range;

/// A link or a picture in a text.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Link<'a> {
    /// Words that the reader sees.
    pub words: &'a str,
    /// Address: a file of the guide, a heading as in `#units`, both, or an address of the web.
    pub address: &'a str,
    /// True for a picture.
    pub picture: bool,
    /// Place of the whole link in the text, in bytes.
    pub place: Range<usize>,
}

impl<'a> Link<'a> {
    /// Returns the topic of the page that the link leads to; `None` if it leads to no other page.
    pub fn topic(&self) -> Option<&'a str> {
        let file = self
            .address
            .split_once('#')
            .map_or(self.address, |(file, _)| file);
        file.strip_suffix(".md").filter(|_| !self.is_web())
    }

    /// Returns true for an address of the web.
    pub fn is_web(&self) -> bool {
        self.address.starts_with("https://") || self.address.starts_with("http://")
    }

    /// Returns the link as plain text for a terminal. The name of the page or the web address follows the words, unless it equals them.
    fn in_words(&self) -> String {
        let words = self.words;
        match self.topic() {
            _ if self.picture => format!("(picture: {words})"),
            Some(topic) if words != format!("`{topic}`") => format!("{words} (page `{topic}`)"),
            None if self.is_web() && words != self.address => format!("{words} ({})", self.address),
            _ => words.to_string(),
        }
    }
}

/// Returns the links of a text in their order. The text contains no code blocks.
pub fn links(text: &str) -> Vec<Link<'_>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < text.len() {
        match bytes[at] {
            b'`' => at = after_code(text, at),
            b'[' => match link(text, at) {
                Some(link) => {
                    at = link.place.end;
                    found.push(link);
                }
                None => at += 1,
            },
            _ => at += 1,
        }
    }
    found
}

/// Returns a text with its links as plain text for a terminal.
pub fn in_words(text: &str) -> String {
    let (mut out, mut done) = (String::with_capacity(text.len()), 0);
    for link in links(text) {
        out += &text[done..link.place.start];
        out += &link.in_words();
        done = link.place.end;
    }
    out + &text[done..]
}

/// Returns the offset after the code that begins with the backtick at `at`. For an unpaired backtick, this is the offset after the backtick.
fn after_code(text: &str, at: usize) -> usize {
    let close = text[at + 1..].find('`');
    close.map_or(at + 1, |length| at + length + 2)
}

/// Returns the link whose words begin with the bracket at `open`.
fn link(text: &str, open: usize) -> Option<Link<'_>> {
    let bytes = text.as_bytes();
    let mut close = open + 1;
    loop {
        match bytes.get(close)? {
            b'`' => close = after_code(text, close),
            b'[' => return None,
            b']' => break,
            _ => close += 1,
        }
    }
    let address = text[close..].strip_prefix("](")?;
    let length = address.find([')', ' ', '\n'])?;
    if close == open + 1 || length == 0 || !address[length..].starts_with(')') {
        return None;
    }
    let picture = open > 0 && bytes[open - 1] == b'!';
    Some(Link {
        words: &text[open + 1..close],
        address: &address[..length],
        picture,
        place: open - usize::from(picture)..close + 2 + length + 1,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_reads_as_words_in_a_terminal() {
        let cases = [
            ("see [sweeps](sweep.md).", "see sweeps (page `sweep`)."),
            ("page [`kc`](kc.md#forces)", "page `kc`"),
            (
                "[the `[kc]` table](study.md)",
                "the `[kc]` table (page `study`)",
            ),
            ("[units](#units)", "units"),
            ("[whole report](reports/a.html)", "whole report"),
            ("[a](https://b.c/d.md)", "a (https://b.c/d.md)"),
            ("![a bar](b.png) and", "(picture: a bar) and"),
        ];
        for (text, words) in cases {
            assert_eq!(in_words(text), words);
        }
        for same in [
            "`a[1](2)`",
            "x[1] (2)",
            "[](a.md)",
            "a ` b [",
            "[a [b",
            "[a](b c)",
        ] {
            assert_eq!(in_words(same), same);
            assert!(links(same).is_empty(), "{same}");
        }
    }
}
