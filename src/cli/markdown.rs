//! Pages of the guide formatted for a terminal: paragraphs and tables fit the width, code is unchanged.

use comfy_table::{ColumnConstraint, ContentArrangement, Table, Width, presets};

use super::width::{WIDTH, hanging, table_text, wrapped};

/// Width in characters up to which the first column of a table is not broken. This column contains the words that the table explains.
const WORD: usize = 34;

/// Formats a page of the guide.
pub(super) fn in_lines(page: &str) -> String {
    let mut out = String::new();
    let mut lines = page.lines().peekable();
    while let Some(line) = lines.next() {
        if line.starts_with("```") {
            for code in lines.by_ref().take_while(|line| !line.starts_with("```")) {
                out += &code_lines(code.trim_end());
            }
        } else if line.starts_with('|') {
            let mut rows = vec![cells(line)];
            while let Some(row) = lines.next_if(|next| next.starts_with('|')) {
                rows.push(cells(row));
            }
            out += &table(rows);
        } else if line.trim().is_empty() {
            out.push('\n');
        } else if let Some(heading) = line.strip_prefix('#') {
            let marks = 1 + heading.bytes().take_while(|byte| *byte == b'#').count();
            out += &hanging(&format!("{} ", &line[..marks]), &line[marks..]);
        } else if line.len() > 3 && line.bytes().all(|byte| byte == b'-') {
            out += &"-".repeat(WIDTH);
            out.push('\n');
        } else {
            let mut text = line.trim().to_string();
            while let Some(more) = lines.next_if(|next| goes_on(next)) {
                text.push(' ');
                text += more.trim();
            }
            let margin = line.len() - line.trim_start().len();
            let mark = item(line.trim_start());
            let head = format!("{}{}", " ".repeat(margin), &line.trim_start()[..mark]);
            out += &hanging(&head, &linked(&text[mark..]));
        }
    }
    out
}

/// Formats a line of code, indented. If the line is too wide, its comment is moved above it. A long command is broken with backslashes.
fn code_lines(code: &str) -> String {
    let indented = |text: &str| format!("    {text}").trim_end().to_string() + "\n";
    if code.chars().count() + 4 <= WIDTH {
        return indented(code);
    }
    if let Some((before, comment)) = code.rsplit_once("  # ").or_else(|| code.rsplit_once(" # "))
        && !before.trim().is_empty()
    {
        let blanks = before.len() - before.trim_start().len();
        let head = format!("    {}# ", " ".repeat(blanks));
        let above = hanging(&head, comment);
        let above = above.replace(
            &format!("\n{}", " ".repeat(head.len())),
            &format!("\n{head}"),
        );
        return above + &code_lines(before.trim_end());
    }
    let text = wrapped(&indented(code));
    if code.starts_with("$ ") {
        return text.trim_end().replace('\n', " \\\n") + "\n";
    }
    text
}

/// Returns true for a line that continues the previous paragraph or list item.
fn goes_on(line: &str) -> bool {
    let begins = |start: &str| line.starts_with(start);
    !(line.trim().is_empty()
        || begins("```")
        || begins("|")
        || begins("#")
        || item(line.trim_start()) > 0)
}

/// Returns the length of the list marker at the start of a line (`* `, `- `, `12. `); 0 if there is none.
fn item(line: &str) -> usize {
    if line.starts_with("* ") || line.starts_with("- ") {
        return 2;
    }
    let digits = line.bytes().take_while(u8::is_ascii_digit).count();
    if (1..3).contains(&digits) && line[digits..].starts_with(". ") {
        digits + 2
    } else {
        0
    }
}

/// Formats the links in a text for a terminal. A link to another page becomes the page's name, any other link its address. Code is
/// unchanged.
fn linked(text: &str) -> String {
    let pieces = text.split('`').enumerate();
    let each = pieces.map(|(k, piece)| match k % 2 {
        0 => of_prose(piece),
        _ => piece.to_string(),
    });
    each.collect::<Vec<_>>().join("`")
}

/// Formats the links in a piece of text that contains no code.
fn of_prose(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    let link = |text: &str| {
        let close = text.find("](")?;
        let end = close + text[close..].find(')')?;
        let name = text[1..close].to_string();
        let is_plain = !name.is_empty() && !name.contains(['[', ']']);
        is_plain.then(|| (name, text[close + 2..end].to_string(), end + 1))
    };
    while let Some(at) = rest.find('[') {
        out += &rest[..at];
        rest = &rest[at..];
        if let Some((name, address, end)) = link(rest) {
            out += &match address.strip_suffix(".md") {
                Some(page) => format!("{name} (page `{page}`)"),
                None => format!("{name} ({address})"),
            };
            rest = &rest[end..];
        } else {
            out.push('[');
            rest = &rest[1..];
        }
    }
    out + rest
}

/// Splits a table row into cells. A bar within backticks does not separate cells.
fn cells(row: &str) -> Vec<String> {
    let row = row.trim().trim_start_matches('|');
    let (mut found, mut cell, mut code) = (Vec::new(), String::new(), false);
    for c in row.chars() {
        match c {
            '|' if !code => found.push(std::mem::take(&mut cell)),
            c => {
                code ^= c == '`';
                cell.push(c);
            }
        }
    }
    if !cell.trim().is_empty() {
        found.push(cell);
    }
    found.iter().map(|cell| linked(cell.trim())).collect()
}

/// Formats a table within the terminal width. The row of dashes is skipped.
fn table(rows: Vec<Vec<String>>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(WIDTH as u16);
    let is_rule = |row: &&Vec<String>| {
        let mut cells = row.iter();
        cells.all(|cell| !cell.is_empty() && cell.chars().all(|c| "-: ".contains(c)))
    };
    let first = rows
        .iter()
        .map(|row| row.first().map_or(0, |c| c.chars().count()));
    let first = first.max().unwrap_or_default();
    for row in rows.iter().filter(|row| !is_rule(row)) {
        table.add_row(row);
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if k == 0 && first <= WORD {
            column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(
                first as u16 + 2,
            )));
        }
    }
    table_text(&table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_guide::PAGES;

    /// No text is lost, and only code may be wider than the terminal.
    #[test]
    fn pages_keep_to_the_width() {
        for page in PAGES {
            let text = in_lines(page.text);
            let wide: Vec<&str> = text
                .lines()
                .filter(|line| line.chars().count() > WIDTH && !line.starts_with("    "))
                .filter(|line| {
                    line.split_whitespace()
                        .all(|word| word.chars().count() < 60)
                })
                .collect();
            assert!(wide.is_empty(), "{}: {wide:#?}", page.topic);
            let words = |text: &str| -> usize { text.matches(char::is_alphabetic).count() };
            assert!(
                words(&text) >= words(page.text) * 98 / 100,
                "{}",
                page.topic
            );
        }
    }

    #[test]
    fn lists_links_and_code() {
        let page = "# A\n\nSee [sweeps](sweep.md) and `a[1](2)`\nor so.\n* one\n  more\n1. two\n\n```console\n$ x\n```\n";
        let expected = "# A\n\nSee sweeps (page `sweep`) and `a[1](2)` or so.\n* one more\n1. two\n\n    $ x\n";
        assert_eq!(in_lines(page), expected);
    }
}
