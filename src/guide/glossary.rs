//! Lookup of single words in the tables of the guide: keys of a study, fields of results, columns of tables, and causes.
//!
//! The first cell of a table row contains the word in backticks. The column headings describe the other cells of the row.

use super::link::in_words;
use super::{PAGES, Page};

/// A word that a table in the guide explains.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Entry {
    /// The word, without backticks and without the `[]` that marks a list.
    pub term: String,
    /// Topic of the page that contains the table.
    pub page: &'static str,
    /// Heading of the section that contains the table.
    pub section: &'static str,
    /// The other cells of the table row that are not empty: for each of them, the column heading and the text, with links as words.
    pub cells: Vec<(&'static str, String)>,
}

/// Topics of the guide pages whose tables explain words.
const EXPLAINING: [&str; 7] = [
    "study",
    "diagnosis",
    "plan",
    "car",
    "kc",
    "sweep",
    "formats",
];

/// Returns all words that tables explain, in the order of the pages.
pub fn entries() -> impl Iterator<Item = Entry> {
    let explaining = |page: &&Page| EXPLAINING.contains(&page.topic);
    PAGES.iter().filter(explaining).flat_map(of_page)
}

/// Returns the entries that explain a word.
///
/// The following kinds of match are tried in turn, until one of them finds entries:
/// - the whole term equals the word;
/// - a dotted term with placeholders in capitals, such as `tests.TEST.hold`, matches the word;
/// - the last piece of a dotted term equals the word;
/// - a term begins with the word and a dot;
/// - the whole term equals the word in another case.
///
/// If nothing matches a word with dots, its last piece is taken for a component and dropped. The rest is then looked up on the pages `kc`
/// and `sweep` only. A unit after the word (`toe_angle.left [rad]`) is ignored.
pub fn find(word: &str) -> Vec<Entry> {
    let word = word.split_once(" [").map_or(word, |(name, _)| name);
    let all = |is: &dyn Fn(&str) -> bool| -> Vec<Entry> {
        entries().filter(|entry| is(&entry.term)).collect()
    };
    let last = |term: &str| term.rsplit('.').next() == Some(word);
    let within = |term: &str| {
        let rest = term.strip_prefix(word);
        // Extensions of files, such as `.sub`, are no parts of an empty word.
        !word.is_empty() && rest.is_some_and(|rest| rest.starts_with('.'))
    };
    // A piece of a term in capitals, such as NAME, is a placeholder that matches any word.
    let own = |piece: &str| piece.len() > 1 && piece.chars().all(|c| c.is_ascii_uppercase());
    let fits = |term: &str| {
        let (terms, words) = (term.split('.'), word.split('.'));
        term.contains('.')
            && terms.clone().count() == words.clone().count()
            && terms.zip(words).all(|(t, w)| t == w || own(t))
    };
    let whole = |term: &str| term == word;
    let any_case = |term: &str| term.eq_ignore_ascii_case(word);
    let ways: [&dyn Fn(&str) -> bool; 5] = [&whole, &fits, &last, &within, &any_case];
    let found = ways.into_iter().map(all).find(|found| !found.is_empty());
    match (found, word.rsplit_once('.')) {
        (Some(found), _) => found,
        // Only characteristics and counts have components; keys of a study have no components.
        (None, Some((whole, _))) => {
            let mut found = all(&|term| term == whole);
            found.retain(|entry| entry.page == "kc" || entry.page == "sweep");
            found
        }
        (None, None) => Vec::new(),
    }
}

/// Returns the one-line explanation of a key of `study.toml`, if the guide explains the key.
pub fn meaning(key: &str) -> Option<String> {
    let key = key.strip_suffix(".NAME").unwrap_or(key);
    let here = |entry: &Entry| entry.page == "study" && entry.term == key;
    let mut found = entries().find(here)?;
    found.cells.pop().map(|(_, text)| text)
}

fn of_page(page: &'static Page) -> Vec<Entry> {
    let (mut found, mut section) = (Vec::new(), "");
    let mut heads: Option<Vec<&str>> = None;
    let mut code = false;
    for line in page.text.lines() {
        code ^= line.starts_with("```");
        if code {
            continue;
        }
        if let Some(heading) = line.strip_prefix('#') {
            // Sections of the page on formats are numbered.
            let numbered = |c: char| "#. ".contains(c) || c.is_ascii_digit();
            section = heading.trim_matches(' ').trim_start_matches(numbered);
        }
        let Some(row) = line.strip_prefix("| ").map(cells) else {
            if !line.starts_with('|') {
                heads = None;
            }
            continue;
        };
        let Some(heads) = &heads else {
            heads = Some(row);
            continue;
        };
        let others: Vec<(&str, String)> = heads
            .iter()
            .copied()
            .zip(row.iter().map(|text| in_words(text)))
            .skip(1)
            .filter(|(_, text)| !text.is_empty())
            .collect();
        for term in row
            .first()
            .copied()
            .unwrap_or_default()
            .split('`')
            .skip(1)
            .step_by(2)
        {
            found.push(Entry {
                term: term.replace("[]", ""),
                page: page.topic,
                section,
                cells: others.clone(),
            });
        }
    }
    found
}

/// Splits a table row, given without its leading bar, into cells. A bar inside backticks does not separate cells.
fn cells(row: &'static str) -> Vec<&'static str> {
    let (mut found, mut start, mut code) = (Vec::new(), 0, false);
    for (at, byte) in row.bytes().enumerate() {
        match byte {
            b'`' => code = !code,
            b'|' if !code => {
                found.push(row[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_found_by_its_word_and_by_the_last_piece_of_it() {
        let found = find("marks.sigma");
        assert_eq!(found[0].section, "study.toml");
        assert!(
            found[0]
                .cells
                .iter()
                .any(|(head, text)| *head == "unit" && text == "length")
        );
        assert!(find("sigma").len() > 1);
        assert!(find("no such word").is_empty() && find("no.such").is_empty());
        assert_eq!(find("toe_angle.left [rad]")[0].term, "toe_angle");
        assert_eq!(find("identify.frame_sd").len(), 2);
        assert_eq!(find("HOOKE")[0].section, "JOINT");
        assert_eq!(find("tests.bounce.hold")[0].term, "tests.TEST.hold");
    }
}
