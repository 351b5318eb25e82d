//! Checks of every page: it is in the book, its links lead to existing targets, and its paragraphs are short.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::link::{Link, links};
use crate::{PAGES, Page, page};

/// Largest size of a picture in bytes.
const MAX_PICTURE_BYTES: u64 = 150_000;
/// Number of words that a paragraph must not reach.
const MAX_PARAGRAPH_WORDS: usize = 90;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the pieces of a page, each with the number of its first line: paragraphs, list items, table rows and headings. Code is left out.
fn pieces(text: &str) -> Vec<(usize, String)> {
    let (mut code, mut goes_on) = (false, false);
    let mut found: Vec<(usize, String)> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let text = line.trim();
        if text.starts_with("```") {
            code = !code;
        }
        if code || text.is_empty() || text.starts_with("```") {
            goes_on = false;
            continue;
        }
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        let item = text.starts_with("* ")
            || text.starts_with("- ")
            || ((1..3).contains(&digits) && text[digits..].starts_with(". "));
        let alone = text.starts_with(['|', '#']);
        match found.last_mut().filter(|_| goes_on && !item && !alone) {
            Some((_, piece)) => {
                piece.push(' ');
                piece.push_str(text);
            }
            None => found.push((number, text.to_string())),
        }
        goes_on = !alone;
    }
    found
}

/// Returns the address of a heading as mdBook makes it: letters in lower case, blanks as hyphens, other characters left out.
fn anchor(heading: &str) -> String {
    let kept = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        _ => None,
    };
    heading.trim().chars().filter_map(kept).collect()
}

fn anchors(page: &Page) -> BTreeSet<String> {
    let pieces = pieces(page.text).into_iter();
    let headings = pieces.filter(|(_, piece)| piece.starts_with('#'));
    headings
        .map(|(_, heading)| anchor(heading.trim_start_matches('#')))
        .collect()
}

/// Returns a description of the fault of a link on a page; `None` for a valid link.
fn fault(from: &Page, link: &Link) -> Option<String> {
    let address = link.address;
    if link.is_web() {
        return None;
    }
    if link.picture {
        let size = std::fs::metadata(folder().join(address)).map(|file| file.len());
        return match size {
            Ok(size) if size <= MAX_PICTURE_BYTES => None,
            Ok(size) => Some(format!("the picture has {size} bytes")),
            Err(why) => Some(why.to_string()),
        };
    }
    if let Some(report) = address.strip_prefix("reports/") {
        // A command of the page must create the report.
        let name = report.trim_end_matches(".html");
        let made = from
            .text
            .contains(&format!("--out target/gallery/{name}\n"));
        return (!made).then(|| "no command of the page makes it".to_string());
    }
    let (file, heading) = address.split_once('#').unwrap_or((address, ""));
    let to = match file.strip_suffix(".md") {
        Some(topic) => PAGES.iter().find(|page| page.topic == topic),
        None => Some(from).filter(|_| file.is_empty()),
    };
    match to {
        None => Some("there is no such page".to_string()),
        Some(to) if heading.is_empty() || anchors(to).contains(heading) => None,
        Some(to) => Some(format!("page `{}` has no heading `{heading}`", to.topic)),
    }
}

#[test]
fn every_page_has_a_heading_and_is_found_by_its_topic() {
    for entry in PAGES {
        assert!(entry.text.starts_with("# "), "{}", entry.topic);
        assert!(entry.title().len() > 3, "{}", entry.topic);
        assert_eq!(
            page(&entry.topic.to_uppercase().replace('_', "-")).map(|page| page.topic),
            Some(entry.topic)
        );
    }
}

/// Checks that the book has the same pages as the terminal, in the same parts and order.
#[test]
fn the_book_has_every_page() {
    let summary = include_str!("SUMMARY.md");
    let (mut part, mut found) = ("", Vec::new());
    for line in summary.lines().skip(1) {
        if let Some(heading) = line.strip_prefix("# ") {
            part = heading;
        }
        found.extend(
            links(line)
                .iter()
                .filter_map(Link::topic)
                .map(|topic| (part, topic)),
        );
    }
    let all: Vec<_> = PAGES.iter().map(|page| (page.part, page.topic)).collect();
    assert_eq!(found, all);
    let files = std::fs::read_dir(folder()).expect("the folder of the crate");
    let names = files.map(|file| file.expect("an entry").file_name());
    let pages = names.filter(|name| Path::new(name).extension().is_some_and(|end| end == "md"));
    assert_eq!(
        pages.count(),
        PAGES.len() + 1,
        "a page that is not in lib.rs"
    );
}

/// Checks that every link leads to an existing page, heading or picture, and that every page named in backticks exists.
#[test]
fn every_link_leads_somewhere() {
    let (mut faults, mut count) = (Vec::new(), 0);
    for entry in PAGES {
        for (number, piece) in pieces(entry.text) {
            for link in links(&piece) {
                count += 1;
                if let Some(why) = fault(entry, &link) {
                    faults.push(format!(
                        "{}.md:{number}: {}: {why}",
                        entry.topic, link.address
                    ));
                }
            }
        }
        for (at, _) in entry.text.match_indices("page `") {
            let name = entry.text[at + "page `".len()..].split('`').next();
            let name = name.unwrap_or_default();
            if page(name).is_none() {
                faults.push(format!("{}.md: page `{name}`", entry.topic));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(
        count > 2 * PAGES.len(),
        "{count} links on {} pages",
        PAGES.len()
    );
}

/// Checks that no page is isolated: each page links to another page, and another page links to it.
#[test]
fn every_page_leads_on_and_is_reached() {
    let leads = |from: &Page| -> BTreeSet<String> {
        let pieces = pieces(from.text);
        let links = pieces.iter().flat_map(|(_, piece)| links(piece));
        let topics = links.filter_map(|link| link.topic().map(String::from));
        topics.filter(|topic| topic != from.topic).collect()
    };
    let reached: BTreeSet<String> = PAGES.iter().flat_map(leads).collect();
    for entry in PAGES {
        assert!(
            reached.contains(entry.topic),
            "nothing leads to {}",
            entry.topic
        );
        assert!(!leads(entry).is_empty(), "{} leads nowhere", entry.topic);
    }
}

/// Checks that table cells, list items and paragraphs of prose are short.
#[test]
fn paragraphs_are_short() {
    let mut long = Vec::new();
    for entry in PAGES {
        for (number, piece) in pieces(entry.text) {
            let cells = piece.split(" | ");
            let words = cells.map(|cell| cell.split_whitespace().count()).max();
            if let Some(words) = words.filter(|words| *words >= MAX_PARAGRAPH_WORDS) {
                long.push(format!("{}.md:{number}: {words} words", entry.topic));
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
}
