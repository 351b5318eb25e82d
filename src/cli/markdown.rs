//! Pages of the guide formatted for a terminal: paragraphs and tables fit the width, code is unchanged.

use admire_guide::link::in_words;

use super::width::{WIDTH, hanging, wrapped};

/// Largest width in characters of the first column of a table, which contains the words that the table explains. A longer cell gets a
/// separate line.
const FIRST_COLUMN_WIDTH: usize = 34;
/// Blanks between two columns of a table.
const COLUMN_GAP: usize = 2;

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
            out += &hanging(&head, &in_words(&text[mark..]));
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
    found.iter().map(|cell| in_words(cell.trim())).collect()
}

/// Formats a table within the terminal width; the row of dashes is skipped. No word is broken: a first cell that is wider than its column has
/// a line of its own. If the words of a row do not fit beside each other, every cell has a line of its own, with its heading.
fn table(mut rows: Vec<Vec<String>>) -> String {
    rows.retain(|row| !is_rule(row));
    let Some(widths) = widths(&rows) else {
        return as_lists(&rows);
    };
    let mut out = String::new();
    for row in &rows {
        let mut cells: Vec<Vec<String>> = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| lines(cell, *width))
            .collect();
        let is_wide = |lines: &Vec<String>| lines.iter().any(|line| length(line) > widths[0]);
        if let Some(first) = cells.first_mut().filter(|first| is_wide(first)) {
            out += &std::mem::take(first).join(" ");
            out.push('\n');
        }
        for k in 0..cells.iter().map(Vec::len).max().unwrap_or_default() {
            let mut line = String::new();
            for (cell, width) in cells.iter().zip(&widths) {
                let text = cell.get(k).map_or("", String::as_str);
                line += &format!("{text:w$}", w = width + COLUMN_GAP);
            }
            out += line.trim_end();
            out.push('\n');
        }
    }
    out
}

fn is_rule(row: &[String]) -> bool {
    let is_dashes = |cell: &String| !cell.is_empty() && cell.chars().all(|c| "-: ".contains(c));
    row.iter().all(is_dashes)
}

fn length(text: &str) -> usize {
    text.chars().count()
}

/// Returns the widths of the columns, or `None` if the longest words of the columns do not fit beside each other.
fn widths(rows: &[Vec<String>]) -> Option<Vec<usize>> {
    let count = rows.iter().map(Vec::len).max()?;
    let most = |of: &dyn Fn(&str) -> usize, k: usize| {
        let cells = rows.iter().filter_map(|row| row.get(k));
        cells.map(|cell| of(cell)).max().unwrap_or_default()
    };
    let longest_word = |cell: &str| cell.split_whitespace().map(length).max().unwrap_or(0);
    let whole: Vec<usize> = (0..count).map(|k| most(&length, k)).collect();
    let mut least: Vec<usize> = (0..count).map(|k| most(&longest_word, k)).collect();
    least[0] = if whole[0] <= FIRST_COLUMN_WIDTH {
        whole[0]
    } else {
        least[0].min(FIRST_COLUMN_WIDTH)
    };
    let wanted: Vec<usize> = whole
        .iter()
        .zip(&least)
        .map(|(w, l)| w.max(l) - l)
        .collect();
    let spare = WIDTH.checked_sub(least.iter().sum::<usize>() + COLUMN_GAP * (count - 1))?;
    let all = wanted.iter().sum::<usize>();
    let share = |wanted: usize| {
        if all <= spare {
            wanted
        } else {
            spare * wanted / all
        }
    };
    Some(
        least
            .iter()
            .zip(wanted)
            .map(|(l, w)| l + share(w))
            .collect(),
    )
}

/// Breaks a cell into lines of at most `width` characters, between words.
fn lines(cell: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in cell.split_whitespace() {
        match lines.last_mut() {
            Some(line) if length(line) + 1 + length(word) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_string()),
        }
    }
    lines
}

/// Formats a table as a list: the first cell of a row, and below it the other cells, each after its heading.
fn as_lists(rows: &[Vec<String>]) -> String {
    let Some((heads, rows)) = rows.split_first() else {
        return String::new();
    };
    let mut out = String::new();
    for row in rows {
        out += &hanging("", row.first().map_or("", String::as_str));
        for (head, cell) in heads
            .iter()
            .zip(row)
            .skip(1)
            .filter(|(_, cell)| !cell.is_empty())
        {
            out += &hanging("    ", &format!("{head}: {cell}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_guide::PAGES;

    /// Only the addresses of links are omitted, and only code may be wider than the terminal.
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
                words(&text) >= words(&in_words(page.text)) * 98 / 100,
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

    /// Words between backticks are not broken across lines, so that they can be searched and copied.
    #[test]
    fn no_identifier_is_broken() {
        let mut broken = Vec::new();
        for page in PAGES {
            let shown = in_lines(page.text);
            let prose = page.text.split("```").step_by(2);
            for line in prose.flat_map(str::lines) {
                let words = line.split('`').skip(1).step_by(2);
                let words = words.filter(|word| !word.contains(' '));
                broken.extend(words.filter(|word| !shown.contains(*word)));
            }
        }
        assert!(broken.is_empty(), "{broken:#?}");
    }

    #[test]
    fn a_wide_word_is_not_broken() {
        let word = "a.".repeat(30);
        let page = format!("| key | unit | meaning |\n|---|---|---|\n| `{word}` | mm | so far |\n");
        let shown = format!("key{:61}unit  meaning\n`{word}`  mm    so far\n", "");
        assert_eq!(in_lines(&page), shown);
        let wide = "w".repeat(50);
        let page = format!("| a | b | c |\n|---|---|---|\n| x | {wide} | {wide} |\n");
        assert_eq!(
            in_lines(&page),
            format!("x\n    b: {wide}\n    c: {wide}\n")
        );
    }
}
