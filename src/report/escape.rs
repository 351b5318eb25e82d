/// Escapes text for HTML. No character of the result can open a tag or an entity, or end an attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are invalid in HTML, but a deck may contain any byte.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Escapes a sentence for HTML. Text in backticks is set as code.
pub(super) fn prose(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut pieces = text.split('`');
    out.push_str(&escape(pieces.next().unwrap_or_default()));
    while let Some(code) = pieces.next() {
        match pieces.next() {
            Some(behind) => {
                out += &format!("<code>{}</code>{}", escape(code), escape(behind));
            }
            // A single backtick is an ordinary character.
            None => out += &format!("`{}", escape(code)),
        }
    }
    out
}
