/// Text made safe for HTML: no character of it can open a tag, an entity or leave an attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are not allowed in HTML; a deck may hold any byte.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A sentence made safe, what stands in backticks set as code.
pub(super) fn prose(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut pieces = text.split('`');
    out.push_str(&escape(pieces.next().unwrap_or_default()));
    while let Some(code) = pieces.next() {
        match pieces.next() {
            Some(behind) => {
                out += &format!("<code>{}</code>{}", escape(code), escape(behind));
            }
            // A single one is a character like any other.
            None => out += &format!("`{}", escape(code)),
        }
    }
    out
}
