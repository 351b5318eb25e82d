use std::fmt::Write as _;

use super::escape::{escape, prose};
use super::scene::{CLIENT, CLIENT_STYLE};
use super::{Figure, Scene, Table};

/// HTML page, built from top to bottom. It is self-contained and refers to no other file.
///
/// Every page has the same parts in the same order: the answer in one sentence, its meaning, the findings, and the folded details. A part without
/// content is left out, also from the list of contents.
#[derive(Debug)]
pub struct Page {
    /// Kind of result, such as `Diagnosis`.
    kind: String,
    title: String,
    answer: String,
    /// Origin of the page, as pairs of name and value.
    facts: Vec<(String, String)>,
    parts: Vec<Part>,
    /// True if the page contains a three-dimensional view, and therefore its script.
    scenes: bool,
}

/// Part of a page below its answer.
#[derive(Debug)]
struct Part {
    title: String,
    html: String,
    /// True for a part of the details.
    folded: bool,
}

const STYLE: &str = include_str!("page.css");
/// Script that opens details, and shows the values of a chart at the pointer.
const SCRIPT: &str = include_str!("page.js");
/// Names of the facts that are shown below the answer, each with alternative names. The other facts are in the last section of the details.
const BY_LINE: [&[&str]; 2] = [&["Study", "Deck", "Files", "Paper"], &["Date"]];

impl Page {
    /// Creates a page of a kind of result, such as `Diagnosis`, with a title. `answer` is the result in one or two sentences.
    pub fn new(kind: &str, title: &str, answer: &str) -> Self {
        Self {
            kind: kind.to_string(),
            title: title.to_string(),
            answer: answer.to_string(),
            facts: Vec::new(),
            parts: Vec::new(),
            scenes: false,
        }
    }

    /// Sets the origin of the page, by name: study, deck, date, version and so on.
    pub fn origin(&mut self, facts: &[(&str, String)]) -> &mut Self {
        let facts = facts.iter();
        self.facts = facts
            .map(|(name, value)| ((*name).to_string(), value.clone()))
            .collect();
        self
    }

    /// Begins the part that shows the meaning of the answer: the curves before and after, and the mechanism.
    pub fn meaning(&mut self) -> &mut Self {
        self.part("What it means", false)
    }

    /// Adds the part with the findings, their uncertainty, their gain and the next step. Each line has a name and its texts; a line without texts is
    /// left out.
    pub fn found(&mut self, lines: &[(&str, Vec<String>)]) -> &mut Self {
        self.part("What was found", false);
        let mut html = String::new();
        for (name, texts) in lines.iter().filter(|(_, texts)| !texts.is_empty()) {
            html += &format!("<dt>{}</dt>", escape(name));
            for text in texts {
                html += &format!("<dd>{}</dd>\n", prose(text));
            }
        }
        if !html.is_empty() {
            self.push(&format!("<dl class=\"found\">\n{html}</dl>\n"));
        }
        self
    }

    /// Begins a part of the details, which are folded.
    pub fn detail(&mut self, title: &str) -> &mut Self {
        self.part(title, true)
    }

    fn part(&mut self, title: &str, folded: bool) -> &mut Self {
        self.parts.push(Part {
            title: title.to_string(),
            html: String::new(),
            folded,
        });
        self
    }

    fn push(&mut self, html: &str) {
        if self.parts.is_empty() {
            self.part("", false);
        }
        if let Some(part) = self.parts.last_mut() {
            part.html += html;
        }
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<p>{}</p>\n", prose(text)));
        self
    }

    /// Adds a paragraph in small print.
    pub fn note(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<p class=\"note\">{}</p>\n", prose(text)));
        self
    }

    /// Adds a bulleted list of sentences.
    pub fn list(&mut self, items: &[String]) -> &mut Self {
        let items = items
            .iter()
            .map(|item| format!("<li>{}</li>\n", prose(item)));
        self.push(&format!("<ul>\n{}</ul>\n", items.collect::<String>()));
        self
    }

    /// Adds preformatted text, such as a diff.
    pub(crate) fn verbatim(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<pre>{}</pre>\n", escape(text)));
        self
    }

    /// Adds a table.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        self.push(&format!("<div class=\"wide\">{}</div>\n", table.html()));
        self
    }

    /// Adds a subheading within a part.
    pub fn subheading(&mut self, text: &str) -> &mut Self {
        self.push(&format!("<h4>{}</h4>\n", escape(text)));
        self
    }

    /// Adds one picture over the full width of the page.
    pub(crate) fn add(&mut self, figure: &Figure) -> &mut Self {
        self.push(&format!(
            "<div class=\"wide\">{}</div>\n",
            figure.html(true, true)
        ));
        self
    }

    /// Adds pictures, side by side if the window is wide enough. A legend or a caption that all pictures share is shown once.
    pub fn figures(&mut self, figures: &[Figure]) -> &mut Self {
        let Some(first) = figures.first() else {
            return self;
        };
        let several = figures.len() > 1;
        let one_legend = several && figures.iter().all(|other| other.legend == first.legend);
        let one_caption = several && figures.iter().all(|other| other.caption == first.caption);
        if one_legend {
            self.push(&first.legend.html());
        }
        let all: String = figures
            .iter()
            .map(|figure| figure.html(!one_legend, !one_caption))
            .collect();
        let class = if several { "figures" } else { "figures one" };
        self.push(&format!("<div class=\"{class}\">\n{all}</div>\n"));
        if one_caption && !first.caption.is_empty() {
            self.note(&first.caption);
        }
        self
    }

    /// Adds a three-dimensional view.
    pub fn scene(&mut self, scene: &Scene) -> &mut Self {
        self.scenes = true;
        self.push(&scene.html(false));
        self
    }

    /// Returns the complete page as HTML text. `footer` names the program and its inputs.
    pub fn finish(mut self, footer: &str) -> String {
        if !self.facts.is_empty() {
            self.detail("Inputs and program version");
            let facts = self.facts.iter().map(|(name, value)| {
                format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value))
            });
            let facts: String = facts.collect();
            self.push(&format!("<dl class=\"facts\">\n{facts}</dl>\n"));
        }
        self.parts.retain(|part| !part.html.is_empty());
        let body = format!(
            "{}<div class=\"sheet\">\n{}<main>\n{}</main>\n</div>\n",
            self.header(),
            self.contents(),
            self.body()
        );
        self.written("", &body, footer)
    }

    /// Returns a complete page with a single three-dimensional view that fills the window, as HTML text.
    pub fn of_scene(scene: &Scene, answer: &str, footer: &str) -> String {
        let mut page = Self::new("", &scene.title, answer);
        page.scenes = true;
        let body = page.header() + &scene.html(true);
        page.written(" class=\"full\"", &body, footer)
    }

    fn header(&self) -> String {
        let kind = match self.kind.as_str() {
            "" => String::new(),
            kind => format!("<p class=\"kind\">{}</p>\n", escape(kind)),
        };
        let facts = BY_LINE.iter().filter_map(|names| {
            let of = |name: &&str| self.facts.iter().find(|(own, _)| own == name);
            let (_, value) = names.iter().find_map(of)?;
            Some(format!("<span>{}</span>", escape(value)))
        });
        let facts: String = facts.collect();
        let by_line = if facts.is_empty() {
            facts
        } else {
            format!("<p class=\"by-line\">{facts}</p>\n")
        };
        format!(
            "<header>{kind}<h1>{}</h1>\n<p class=\"lead\">{}</p>\n{by_line}</header>\n",
            escape(&self.title),
            prose(&self.answer)
        )
    }

    /// Returns the list of contents, with a link to each part.
    fn contents(&self) -> String {
        let link = |k: usize, part: &Part| {
            format!(
                "<li><a href=\"#part-{k}\">{}</a></li>\n",
                escape(&part.title)
            )
        };
        let named = || {
            let all = self.parts.iter().enumerate();
            all.filter(|(_, part)| !part.title.is_empty())
        };
        if named().count() < 2 {
            return String::new();
        }
        let of = |folded: bool| -> String {
            let parts = named().filter(|(_, part)| part.folded == folded);
            parts.map(|(k, part)| link(k, part)).collect()
        };
        let mut all = of(false);
        let folded = of(true);
        if !folded.is_empty() {
            all += &format!("<li><a href=\"#details\">Details</a>\n<ul>\n{folded}</ul>\n</li>\n");
        }
        format!("<nav aria-label=\"Contents\">\n<ul>\n{all}</ul>\n</nav>\n")
    }

    fn body(&self) -> String {
        let mut out = String::new();
        let (folded, open): (Vec<_>, Vec<_>) = self
            .parts
            .iter()
            .enumerate()
            .partition(|(_, part)| part.folded);
        let push = |out: &mut String, text: std::fmt::Arguments<'_>| {
            out.write_fmt(text).expect("a String takes all");
        };
        for (k, Part { title, html, .. }) in open {
            let title = escape(title);
            let heading = if title.is_empty() {
                title
            } else {
                format!("<h2>{title}</h2>\n")
            };
            push(
                &mut out,
                format_args!("<section id=\"part-{k}\">\n{heading}{html}</section>\n"),
            );
        }
        if folded.is_empty() {
            return out;
        }
        out += "<section id=\"details\">\n<h2>Details <button type=\"button\" class=\"open-all\">Open all</button></h2>\n";
        for (k, Part { title, html, .. }) in folded {
            push(
                &mut out,
                format_args!(
                    "<details id=\"part-{k}\"><summary><h3>{}</h3></summary>\n{html}</details>\n",
                    escape(title)
                ),
            );
        }
        out + "</section>\n"
    }

    fn written(&self, class: &str, body: &str, footer: &str) -> String {
        let (style, client) = if self.scenes {
            (CLIENT_STYLE, CLIENT)
        } else {
            ("", "")
        };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body{class}>\n{body}<footer>{}</footer>\n\
             <script>\n{SCRIPT}{client}</script>\n</body>\n</html>\n",
            escape(&self.title),
            escape(footer)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_texts_cannot_become_markup() {
        let evil = "<script>alert(1)</script>";
        let mut page = Page::new(evil, evil, "a & b \"quoted\"");
        page.origin(&[("Deck", evil.to_string())]);
        page.detail(evil)
            .paragraph("</p><img src=x onerror='alert(1)'> `</code><img>` `<b>")
            .list(&["<li>".to_string()])
            .verbatim("</pre><b>");
        page.found(&[(evil, vec![evil.to_string()])]);
        let html = page.finish("<footer>");
        assert_eq!(html.matches("<script").count(), 1, "its own");
        assert!(!html.contains("<img"));
        assert!(!html.contains("</pre><b>") && !html.contains("<b>"));
        assert!(html.contains("<code>&lt;/code&gt;&lt;img&gt;</code>"));
        assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    }

    /// The answer comes first and the details come last, in whatever order the page is filled in. A part without content is absent.
    #[test]
    fn the_answer_comes_first_and_details_are_folded() {
        let mut page = Page::new("Diagnosis", "axle", "The tie rod yields.");
        page.origin(&[
            ("Deck", "a.adm".to_string()),
            ("Inputs", "12ab".to_string()),
        ]);
        page.detail("Residuals").note("small");
        page.detail("Nothing");
        page.meaning().note("toe");
        page.found(&[("Found", vec!["one".to_string()]), ("Gain", Vec::new())]);
        let html = page.finish("admire");
        let at = |text: &str| html.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(at("The tie rod yields.") < at("<h2>What it means"));
        assert!(at("<h2>What it means") < at("<h2>What was found"));
        assert!(at("<dt>Found</dt>") < at("<h3>Residuals</h3>"));
        assert!(!html.contains("Nothing") && !html.contains("<dt>Gain"));
        // Each link of the contents leads to a part, and the details are initially closed.
        for link in html.split("href=\"#").skip(1) {
            let id = link.split('"').next().unwrap();
            assert_eq!(html.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
        }
        assert!(
            !html.contains("<details open") && at("12ab") > at("<h3>Inputs and program version")
        );
    }
}
