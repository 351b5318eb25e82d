//! The user guide: the pages that `admire guide TOPIC` shows in a terminal and that mdBook makes a site of (`book.toml`, `SUMMARY.md`).
//!
//! [`PAGES`] contains all pages as text. [`glossary`] looks up words in the tables of the pages, for the terminal and for the schema of a
//! study. [`link`] finds the links between pages. The crate has no dependencies.
#![warn(unreachable_pub)]
// Private modules link to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod glossary;
pub mod link;
#[cfg(test)]
mod tests;

/// One page of the guide.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// Part of the guide that the page belongs to.
    pub part: &'static str,
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

/// Declares the list [`PAGES`] from the parts of the guide and the topics of their pages.
macro_rules! pages {
    ($($part:literal { $($topic:ident)* })*) => {
        /// All pages, in reading order.
        pub static PAGES: &[Page] = &[
            $($(Page {
                part: $part,
                topic: stringify!($topic),
                text: include_str!(concat!(stringify!($topic), ".md")),
            },)*)*
        ];
    };
}

pages! {
    "Start" { install tutorial gallery matlab windows }
    "User guide" {
        study diagnosis rig plan kc tune motion sweep drop_in real_adams toolkit editors python car rebuild conventions words
    }
    "Theory" { mathematics paper }
    "Evidence and benchmarks" { benchmarks coverage formats }
}

/// Returns the page with this topic. Case is ignored, and hyphens are read as underscores.
pub fn page(topic: &str) -> Option<&'static Page> {
    let topic = topic.to_ascii_lowercase().replace('-', "_");
    PAGES.iter().find(|page| page.topic == topic)
}
