//! The user guide, shown both in the documentation and in the terminal by `admire guide TOPIC`.
//!
//! [`PAGES`] contains all pages as text. [`glossary`] looks up words in the tables of the pages, for the terminal and for the schema of a
//! study. The crate has no dependencies.
#![warn(unreachable_pub)]
// Private modules link to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod glossary;

/// One page of the guide.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// Topic of the page, as given to `admire guide`.
    pub topic: &'static str,
    /// Text of the page in Markdown; the first line is the heading.
    pub text: &'static str,
}

impl Page {
    /// Returns the heading of the page, without the leading `#`.
    pub fn title(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
    }
}

/// Declares a module for each page, with the text of the page as its documentation, and the list [`PAGES`].
macro_rules! pages {
    ($($topic:ident)*) => {
        $(
            #[doc = include_str!(concat!(stringify!($topic), ".md"))]
            pub mod $topic {}
        )*

        /// All pages, in reading order.
        pub static PAGES: &[Page] = &[
            $(Page { topic: stringify!($topic), text: include_str!(concat!(stringify!($topic), ".md")) },)*
        ];
    };
}

pages! {
    tutorial
    drop_in
    windows
    motion
    real_adams
    study
    diagnosis
    plan
    rebuild
    toolkit
    editors
    python
    conventions
    car
    kc
    sweep
    mathematics
    formats
    paper
    coverage
    benchmarks
}

/// Returns the page with this topic. Case is ignored, and hyphens are read as underscores.
pub fn page(topic: &str) -> Option<&'static Page> {
    let topic = topic.to_ascii_lowercase().replace('-', "_");
    PAGES.iter().find(|page| page.topic == topic)
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Checks that each page named in backticks on another page exists.
    #[test]
    fn the_pages_a_page_sends_to_exist() {
        for entry in PAGES {
            for (at, _) in entry.text.match_indices("page `") {
                let name: String = entry.text[at + "page `".len()..]
                    .chars()
                    .take_while(|&c| c != '`')
                    .collect();
                assert!(page(&name).is_some(), "{}: page `{name}`", entry.topic);
            }
        }
    }
}
