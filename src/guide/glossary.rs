//! Lookup of single words in the tables of the guide: keys of a study, fields of results, columns of tables, causes, and words of the field.
//!
//! The first cell of a table row contains the word in backticks. The column headings describe the other cells of the row. Two headings have a
//! meaning of their own: `see` names other words in backticks, and `read on` links to another page.

use std::sync::LazyLock;

use super::link::{in_words, links};
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
    /// Cells of the table row after the first, without empty cells. Each has its column heading and its text, with links replaced by their
    /// words.
    pub cells: Vec<(&'static str, String)>,
    /// Words whose entries belong to this one.
    pub see: Vec<String>,
    /// Picture in characters, one line each; empty for most words.
    pub picture: Vec<&'static str>,
    /// Topic of the page to read on: the page that the row links to, else the page that contains the table.
    pub read_on: &'static str,
}

impl Entry {
    /// Returns true for a word of the field, such as `camber`, that is neither a key nor a column.
    pub fn is_word(&self) -> bool {
        self.page == WORDS
    }
}

/// Topic of the page with the words of the field. Some of its rows have several spellings.
const WORDS: &str = "words";

/// Topics of the guide pages whose tables explain words.
const EXPLAINING: [&str; 9] = [
    "study",
    "diagnosis",
    "rig",
    "plan",
    "car",
    "kc",
    "sweep",
    "formats",
    WORDS,
];

/// All words that tables explain, in the order of the pages.
static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let explaining = |page: &&Page| EXPLAINING.contains(&page.topic);
    PAGES.iter().filter(explaining).flat_map(of_page).collect()
});

/// Returns all words that tables explain, in the order of the pages.
pub fn entries() -> impl Iterator<Item = Entry> {
    ENTRIES.iter().cloned()
}

/// Returns the entries that explain a word: first words of the field, then the keys, columns and causes of this name. The entries to which the
/// words of the field refer follow.
///
/// A word of the field is found in any spelling: case, hyphens, blanks, British or American, singular or plural. A unit after the word
/// (`toe_angle.left [rad]`) is ignored.
pub fn find(word: &str) -> Vec<Entry> {
    let word = word.split_once(" [").map_or(word, |(name, _)| name);
    let mut found: Vec<Entry> = ENTRIES
        .iter()
        .filter(|entry| entry.is_word() && is_spelling(word, &entry.term))
        .cloned()
        .collect();
    let see: Vec<String> = found.iter().flat_map(|entry| entry.see.clone()).collect();
    let further = see.iter().flat_map(|term| find_term(term));
    for entry in find_term(word).into_iter().chain(further) {
        if !found.contains(&entry) {
            found.push(entry);
        }
    }
    found
}

/// Returns the keys, columns and causes of this name.
///
/// The following kinds of match are tried in turn, until one of them finds entries:
/// - the whole term equals the word;
/// - a dotted term with placeholders in capitals, such as `tests.TEST.hold`, matches the word;
/// - the last piece of a dotted term equals the word;
/// - a term begins with the word and a dot;
/// - the whole term equals the word in another spelling.
///
/// If nothing matches a word with dots, its last piece is taken for a component and dropped. The rest is then looked up on the pages `kc`
/// and `sweep` only.
fn find_term(word: &str) -> Vec<Entry> {
    let all = |is: &dyn Fn(&str) -> bool| -> Vec<Entry> {
        let terms = ENTRIES.iter().filter(|entry| !entry.is_word());
        terms.filter(|entry| is(&entry.term)).cloned().collect()
    };
    let last = |term: &str| term.rsplit('.').next() == Some(word);
    let within = |term: &str| {
        let rest = term.strip_prefix(word);
        // A file extension such as `.sub` is not a component of an empty word.
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
    let spelling = |term: &str| is_spelling(word, term);
    let ways: [&dyn Fn(&str) -> bool; 5] = [&whole, &fits, &last, &within, &spelling];
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

/// Returns true if a word is another spelling or the plural of a term.
fn is_spelling(word: &str, term: &str) -> bool {
    let (word, term) = (letters(word), letters(term));
    if term.is_empty() {
        return false;
    }
    let endings = [
        ("s", ""),
        ("es", ""),
        ("es", "is"),
        ("ies", "y"),
        ("ices", "ix"),
    ];
    let plural = |(plural, singular): &(&str, &str)| {
        let stem = word.strip_suffix(plural);
        stem.is_some_and(|stem| term.strip_suffix(singular) == Some(stem))
    };
    word == term || endings.iter().any(plural)
}

/// Returns the letters and digits of a word in lower case and American spelling.
fn letters(word: &str) -> String {
    let kept = word.chars().filter(|c| c.is_alphanumeric());
    let lower: String = kept.flat_map(char::to_lowercase).collect();
    lower.replace("centre", "center").replace("tyre", "tire")
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
        let cell = |heading| heads.iter().position(|head| *head == heading);
        let cell = |heading| cell(heading).and_then(|k| row.get(k).copied());
        let see: Vec<String> = cell("see").map(terms).unwrap_or_default();
        let link = cell("read on").and_then(|text| links(text).into_iter().next());
        let read_on = link.and_then(|link| link.topic()).unwrap_or(page.topic);
        let others: Vec<(&str, String)> = heads
            .iter()
            .copied()
            .zip(row.iter().map(|text| in_words(text)))
            .skip(1)
            .filter(|(head, text)| !text.is_empty() && *head != "see" && *head != "read on")
            .collect();
        for term in row.first().copied().map(terms).unwrap_or_default() {
            found.push(Entry {
                term,
                page: page.topic,
                section,
                cells: others.clone(),
                see: see.clone(),
                picture: Vec::new(),
                read_on,
            });
        }
    }
    for (term, picture) in pictures(page.text) {
        for entry in found.iter_mut().filter(|entry| entry.term == term) {
            entry.picture.clone_from(&picture);
        }
    }
    found
}

/// Returns the pictures of a page, each with its word. A picture is a block of code that begins with "```text fingerprint WORD".
fn pictures(text: &'static str) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut lines = text.lines();
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        if let Some(term) = line.strip_prefix("```text fingerprint ") {
            let picture = lines.by_ref().take_while(|line| !line.starts_with("```"));
            found.push((term.trim(), picture.collect()));
        }
    }
    found
}

/// Returns the words in backticks of a table cell.
fn terms(cell: &str) -> Vec<String> {
    let words = cell.split('`').skip(1).step_by(2);
    words.map(|word| word.replace("[]", "")).collect()
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
    use std::collections::BTreeMap;

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
        assert!(find("").is_empty() && find("-").is_empty() && find("s").is_empty());
        assert_eq!(find("toe_angle.left [rad]")[0].term, "toe_angle");
        assert_eq!(find("identify.frame_sd").len(), 2);
        assert_eq!(find("HOOKE")[0].section, "JOINT");
        assert_eq!(find("tests.bounce.hold")[0].term, "tests.TEST.hold");
    }

    /// Words that an engineer types without having read a page.
    const TYPED: &str = "camber, toe, caster, kingpin, bump steer, roll steer, roll centre, scrub, trail, wheel rate, anti-dive, compliance steer, \
        chi-square, p-value, hardpoint, sigma, standard deviation, held out, degrees of freedom, covariance, prior, posterior, evidence, \
        interval, identifiable, bushing, preload, free length, slip, hysteresis, tolerance, outlier, mark, load case, K&C, wheel centre, \
        contact patch, track, steer axis, Ackermann, steady state, residual, standard error, correlation, dof, ride height, roll stiffness, \
        anti-squat, ride rate, motion ratio, instant centre, jounce, rebound, friction, free play, stiffness, channel, equilibrium, \
        compliance matrix, confidence interval, rms, noise, cause, fingerprint, wheelbase, tyre stiffness, roll angle, dry friction";

    #[test]
    fn what_engineers_type_gets_an_answer_and_a_page() {
        for word in TYPED.split(',').map(str::trim) {
            let found = find(word);
            assert!(!found.is_empty(), "nothing explains `{word}`");
            for entry in found {
                assert!(crate::page(entry.read_on).is_some(), "{word}: {entry:?}");
                let text = entry
                    .cells
                    .iter()
                    .map(|(_, text)| text.len())
                    .sum::<usize>();
                assert!(text > 0, "{word}: {entry:?}");
            }
        }
    }

    #[test]
    fn spellings_of_a_word_lead_to_one_entry() {
        for (word, spellings) in [
            (
                "roll centre",
                "Roll Center, roll-centre, ROLL_CENTRE, roll centres",
            ),
            ("toe", "TOE, Toe, toe-in"),
            ("contact patch", "contact patches, Contact-Patch"),
            ("steer axis", "steering axis, steer axes"),
            ("p-value", "p value, P-values"),
            ("bushing", "bushings, bush, bushes"),
            ("Ackermann", "ackerman"),
            ("caster", "castor"),
            ("K&C", "k&c"),
            ("chi-square", "chi2, Chi Squared"),
            ("hysteresis", "hystereses"),
        ] {
            let row = |word: &str| {
                let found = find(word).into_iter().next();
                found.map(|entry| (entry.section, entry.cells))
            };
            for other in spellings.split(',').map(str::trim) {
                assert_eq!(row(other), row(word), "{other}");
            }
        }
    }

    /// Checks that a word comes with the rows to which it refers. Formula and sign of a word are stated only once, in the table of its column.
    #[test]
    fn a_word_brings_the_rows_that_it_refers_to() {
        let said = |word: &str, term: &str, head: &str| {
            let found = find(word).into_iter().find(|entry| entry.term == term);
            let cells = found.unwrap_or_else(|| panic!("{word}: {term}")).cells;
            let cell = cells.into_iter().find(|(name, _)| *name == head);
            cell.map(|(_, text)| text).unwrap_or_default()
        };
        assert_eq!(said("camber", "camber_angle", "positive"), "top outboard");
        assert_eq!(said("toe", "toe_angle", "positive"), "toe-in");
        assert_eq!(said("castor", "caster_angle", "positive"), "rearward");
        assert_eq!(said("camber", "camber", "unit"), "deg");
        assert_eq!(find("camber")[0].read_on, "kc");
        assert_eq!(find("camber_angle")[0].read_on, "kc");
    }

    #[test]
    fn the_page_of_words_is_consistent() {
        let mut rows = BTreeMap::new();
        for entry in entries().filter(Entry::is_word) {
            assert_ne!(entry.read_on, WORDS, "{}", entry.term);
            for term in &entry.see {
                assert!(!find_term(term).is_empty(), "{}: see {term}", entry.term);
            }
            let meaning = entry.cells.iter().find(|(head, _)| *head == "meaning");
            let sentences =
                meaning.map_or(0, |(_, text)| (text.clone() + " ").matches(". ").count());
            assert!((1..=3).contains(&sentences), "{}: {sentences}", entry.term);
            let before = rows.insert(letters(&entry.term), entry.cells);
            assert!(before.is_none(), "`{}` is listed twice", entry.term);
        }
        assert!(rows.len() > 100);
    }

    /// Checks that every cause on the page about diagnoses has an effect and a fingerprint, and that every effect has an example.
    #[test]
    fn every_cause_has_an_effect_and_a_fingerprint() {
        let of = |section| entries().filter(move |entry| entry.section == section);
        let causes: Vec<Entry> = of("What is searched").collect();
        assert!(causes.len() > 18);
        for cause in causes {
            let found = find(&cause.term);
            assert_eq!(found[0], cause);
            let effect = found.iter().find(|entry| entry.page == "rig");
            let effect = effect.unwrap_or_else(|| panic!("{} has no fingerprint", cause.term));
            assert!(
                effect
                    .cells
                    .iter()
                    .any(|(head, _)| head.starts_with("fingerprint"))
            );
        }
        for effect in entries().filter(|entry| entry.page == "rig") {
            let example = &effect.cells[0].1;
            let own = example.starts_with(&format!("`{}@", effect.term));
            assert!(own || example == "none", "{}: {example}", effect.term);
        }
    }
}
