//! What the tables of the guide say of single words: keys of a study, fields of the answers, columns, causes.
//!
//! The first cell of a row names the word in backticks; the headings of the columns say what the other cells tell.

use super::{PAGES, Page};

/// A row of a table of the guide.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Entry {
    /// The word, without backticks and without the `[]` of lists.
    pub term: String,
    /// The page it stands on.
    pub page: &'static str,
    /// The heading it stands under.
    pub section: &'static str,
    /// Heading and text of the other cells that hold something.
    pub cells: Vec<(&'static str, &'static str)>,
}

/// Pages whose tables explain words.
const EXPLAINING: [&str; 5] = ["study", "diagnosis", "plan", "kc", "sweep"];

/// Every word that a table explains, in the order of the pages.
pub fn entries() -> impl Iterator<Item = Entry> {
    let explaining = |page: &&Page| EXPLAINING.contains(&page.topic);
    PAGES.iter().filter(explaining).flat_map(of_page)
}

/// The words of this name: the whole one, the last piece of a dotted one, those that begin with it, or what it is a component of. The
/// unit behind a column (`toe_angle.left [rad]`) does not matter.
pub fn find(word: &str) -> Vec<Entry> {
    let word = word.split_once(" [").map_or(word, |(name, _)| name);
    let all = |is: &dyn Fn(&str) -> bool| -> Vec<Entry> {
        entries().filter(|entry| is(&entry.term)).collect()
    };
    let last = |term: &str| term.rsplit('.').next() == Some(word);
    let within = |term: &str| {
        let rest = term.strip_prefix(word);
        rest.is_some_and(|rest| rest.starts_with('.'))
    };
    // A piece in capitals, such as NAME, stands for any.
    let own = |piece: &str| piece.len() > 1 && piece.chars().all(|c| c.is_ascii_uppercase());
    let fits = |term: &str| {
        let (terms, words) = (term.split('.'), word.split('.'));
        term.contains('.')
            && terms.clone().count() == words.clone().count()
            && terms.zip(words).all(|(t, w)| t == w || own(t))
    };
    let ways: [&dyn Fn(&str) -> bool; 4] = [&|term| term == word, &fits, &last, &within];
    let found = ways.into_iter().map(all).find(|found| !found.is_empty());
    match (found, word.rsplit_once('.')) {
        (Some(found), _) => found,
        // Components are those of characteristics and of counts, not of a study's keys.
        (None, Some((whole, _))) => {
            let mut found = all(&|term| term == whole);
            found.retain(|entry| entry.page == "kc" || entry.page == "sweep");
            found
        }
        (None, None) => Vec::new(),
    }
}

/// What a key of `study.toml` means, in one line.
pub fn meaning(key: &str) -> Option<&'static str> {
    let key = key.strip_suffix(".NAME").unwrap_or(key);
    let here = |entry: &Entry| entry.page == "study" && entry.term == key;
    let found = entries().find(here)?;
    found.cells.last().map(|(_, text)| *text)
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
            section = heading.trim_start_matches('#').trim();
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
        let others: Vec<(&str, &str)> = heads
            .iter()
            .copied()
            .zip(row.iter().copied())
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

/// The cells of a row behind its first bar; a bar in backticks parts nothing.
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
                .any(|(head, text)| *head == "unit" && *text == "length")
        );
        assert!(find("sigma").len() > 1);
        assert!(find("no such word").is_empty() && find("no.such").is_empty());
        assert_eq!(find("toe_angle.left [rad]")[0].term, "toe_angle");
        assert_eq!(find("identify.frame_sd").len(), 2);
        assert_eq!(find("tests.bounce.hold")[0].term, "tests.TEST.hold");
    }
}
