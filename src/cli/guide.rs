use std::fmt::Write as _;

use clap_complete::{ArgValueCompleter, CompletionCandidate};

use admire_guide::{PAGES, page};
use admire_syntax::grammar::nearest;

use super::Outcome;
use super::markdown::in_lines;
use super::shell::{Exit, Shell};

/// Show a page of the guide, or the list of its pages.
///
/// On a terminal, the program in `$PAGER` shows the page, or `less` if it is not set. Examples: `admire guide`, `admire guide study`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Page to show; without it, the list of pages is shown.
    #[arg(add = ArgValueCompleter::new(complete))]
    topic: Option<String>,
}

/// Prints the page or the list of pages.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let Some(topic) = &arguments.topic else {
        let mut out = String::new();
        let mut part = "";
        for page in PAGES {
            if page.part != part {
                part = page.part;
                writeln!(out, "{part}").expect("writing to a string");
            }
            writeln!(out, "  {:12} {}", page.topic, page.title()).expect("writing to a string");
        }
        shell.print(&out);
        return Ok(Exit::Fine);
    };
    if let Some(page) = page(topic) {
        shell.page(&in_lines(page.text));
        return Ok(Exit::Fine);
    }
    let topics: Vec<String> = PAGES.iter().map(|page| page.topic.to_uppercase()).collect();
    let help = nearest(topic, topics.iter().map(String::as_str)).map_or_else(
        || format!("the pages are {}", topics.join(", ").to_lowercase()),
        |near| format!("did you mean `{}`?", near.to_lowercase()),
    );
    shell.say(&format!("error: the guide has no page `{topic}`; {help}\n"));
    Err(Exit::Usage)
}

fn complete(current: &std::ffi::OsStr) -> Vec<CompletionCandidate> {
    let typed = current.to_string_lossy();
    PAGES
        .iter()
        .filter(|page| page.topic.starts_with(&*typed))
        .map(|page| CompletionCandidate::new(page.topic))
        .collect()
}
