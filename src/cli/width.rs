//! Text width: tables and prose fit a terminal of 80 columns.

use comfy_table::{ColumnConstraint, Table};

/// Number of columns for tables and prose.
pub(super) const WIDTH: usize = 80;

/// Formats a table without trailing blanks. If the table is too wide, the gaps between its columns are narrowed. If it is still too wide, the columns
/// are split into blocks, each of which repeats the first column.
pub(super) fn table_text(table: &Table) -> String {
    if let Some(text) = within(table) {
        return text;
    }
    let mut narrow = table.clone();
    for column in narrow.column_iter_mut() {
        column.set_padding((0, 1));
    }
    if let Some(text) = within(&narrow) {
        return text;
    }
    let count = narrow.column_iter().count();
    let block = |from: usize, to: usize| {
        let mut part = narrow.clone();
        for (k, column) in part.column_iter_mut().enumerate() {
            if k > 0 && !(from..to).contains(&k) {
                column.set_constraint(ColumnConstraint::Hidden);
            }
        }
        part
    };
    let mut blocks = Vec::new();
    let mut from = 1;
    while from < count {
        let mut to = from + 1;
        while to < count && within(&block(from, to + 1)).is_some() {
            to += 1;
        }
        blocks.push(text_of(&block(from, to)));
        from = to;
    }
    blocks.join("\n")
}

/// Wraps a text to the width, with `head` before the first line and with the same indentation on all further lines. The result ends with a
/// line end.
pub(super) fn hanging(head: &str, text: &str) -> String {
    let margin = head.chars().count();
    let mut out = head.to_string();
    let mut column = margin;
    for word in text.split_whitespace() {
        let width = word.chars().count();
        if column > margin && column + 1 + width > WIDTH {
            out.push('\n');
            out.push_str(&" ".repeat(margin));
            column = margin;
        }
        if column > margin {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += width;
    }
    out.push('\n');
    out
}

/// Breaks long lines of a text at blanks. Continuation lines are indented by two more columns than the line itself. Short lines are
/// unchanged.
pub(super) fn wrapped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let blanks = line.chars().take_while(|c| *c == ' ').count();
        let margin = blanks + 2;
        let mut rest = line;
        let mut column = 0;
        while let Some(at) = broken(rest, column, blanks) {
            out.push_str(rest[..at].trim_end());
            out.push('\n');
            out.push_str(&" ".repeat(margin));
            rest = rest[at..].trim_start_matches(' ');
            column = margin;
        }
        out.push_str(rest);
    }
    out
}

/// Returns the offset at which a line that starts at `column` is broken: at the last blank within the width, or else at the first blank
/// beyond it.
fn broken(line: &str, column: usize, blanks: usize) -> Option<usize> {
    let text = line.trim_end();
    if column + text.chars().count() <= WIDTH {
        return None;
    }
    let first = if column == 0 { blanks } else { 0 };
    let gaps = text
        .char_indices()
        .enumerate()
        .filter(|(k, (_, c))| *c == ' ' && *k > first)
        .map(|(k, (at, _))| (column + k, at));
    let (mut last, mut next) = (None, None);
    for (k, at) in gaps {
        if k <= WIDTH {
            last = Some(at);
        } else {
            next = next.or(Some(at));
        }
    }
    last.or(next)
}

/// Formats a table if it fits the width.
fn within(table: &Table) -> Option<String> {
    let text = text_of(table);
    let fits = text.lines().all(|line| line.chars().count() <= WIDTH);
    fits.then_some(text)
}

fn text_of(table: &Table) -> String {
    let lines = table.to_string();
    lines
        .lines()
        .fold(String::new(), |text, line| text + line.trim_end() + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_tables_stand_in_blocks() {
        let mut table = Table::new();
        table.load_style(comfy_table::presets::NOTHING);
        let cells = |word: &str| (0..9).map(|k| format!("{word}{k:08}")).collect::<Vec<_>>();
        table.set_header(cells("h"));
        table.add_row(cells("a"));
        table.add_row(cells("b"));
        let text = table_text(&table);
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        // Every cell occurs once, and the first column occurs in both blocks.
        for word in ["h", "a", "b"] {
            assert_eq!(text.matches(&format!("{word}00000000")).count(), 2);
            for cell in cells(word).iter().skip(1) {
                assert_eq!(text.matches(cell).count(), 1, "{text}");
            }
        }
        assert!(text.contains("\n\nh00000000"));
    }

    #[test]
    fn long_lines_go_on_below_and_short_ones_stay() {
        let row = format!("{:30}b  c\n\n", "  a");
        assert_eq!(wrapped(&row), row);
        let long = format!("  {}\nx", "word ".repeat(40).trim_end());
        let text = wrapped(&long);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH));
        assert!(
            text.starts_with("  word ") && text.contains("\n    word ") && text.ends_with("\nx")
        );
        assert_eq!(
            text.split_whitespace().count(),
            long.split_whitespace().count()
        );
        // Text without blanks is not broken.
        let path = "p/".repeat(60);
        assert_eq!(wrapped(&path), path);
        assert_eq!(
            wrapped(&format!("at {path} there")),
            format!("at\n  {path}\n  there")
        );
    }
}
