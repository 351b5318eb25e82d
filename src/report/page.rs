use std::fmt::Write as _;

use super::escape::{escape, prose};
use super::scene::{CLIENT, CLIENT_STYLE};
use super::{Figure, Scene, Table};

/// HTML page, built from top to bottom. It is self-contained and refers to no other file.
#[derive(Debug)]
pub struct Page {
    title: String,
    body: String,
    /// True if the page contains a three-dimensional view, and therefore its script.
    scenes: bool,
}

const STYLE: &str = include_str!("page.css");

impl Page {
    /// Creates a page with a title. Below the title follows `lead`, the result in one or two sentences.
    pub fn new(title: &str, lead: &str) -> Self {
        let mut page = Self {
            title: title.to_string(),
            body: String::new(),
            scenes: false,
        };
        page.push(format_args!(
            "<header><h1>{}</h1>\n<p class=\"lead\">{}</p></header>\n",
            escape(title),
            prose(lead)
        ));
        page
    }

    fn push(&mut self, text: std::fmt::Arguments<'_>) {
        self.body
            .write_fmt(text)
            .expect("writing into a String cannot fail");
    }

    /// Adds a section heading.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<h2>{}</h2>\n", escape(text)));
        self
    }

    /// Adds a paragraph.
    pub(crate) fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<p>{}</p>\n", prose(text)));
        self
    }

    /// Adds a paragraph in small print.
    pub fn note(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<p class=\"note\">{}</p>\n", prose(text)));
        self
    }

    /// Adds a bulleted list of sentences.
    pub(crate) fn list(&mut self, items: &[String]) -> &mut Self {
        self.body.push_str("<ul>\n");
        for item in items {
            self.push(format_args!("<li>{}</li>\n", prose(item)));
        }
        self.body.push_str("</ul>\n");
        self
    }

    /// Adds preformatted text, such as a diff.
    pub(crate) fn verbatim(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<pre>{}</pre>\n", escape(text)));
        self
    }

    /// Adds a table.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        self.push(format_args!("<div class=\"wide\">{}</div>\n", table.html()));
        self
    }

    /// Adds a list of names with values, such as the origin of the page.
    pub fn facts(&mut self, facts: &[(&str, String)]) -> &mut Self {
        self.body.push_str("<dl class=\"facts\">\n");
        for (name, value) in facts {
            self.push(format_args!(
                "<dt>{}</dt><dd>{}</dd>\n",
                escape(name),
                escape(value)
            ));
        }
        self.body.push_str("</dl>\n");
        self
    }

    /// Adds a subheading within a section.
    pub fn subheading(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<h3>{}</h3>\n", escape(text)));
        self
    }

    /// Adds one picture over the full width of the page.
    pub(crate) fn add(&mut self, figure: &Figure) -> &mut Self {
        self.body
            .push_str(&format!("<div class=\"wide\">{}</div>\n", figure.html()));
        self
    }

    /// Adds pictures, side by side if the window is wide enough.
    pub fn figures(&mut self, figures: &[Figure]) -> &mut Self {
        self.body.push_str("<div class=\"figures\">\n");
        for figure in figures {
            self.body.push_str(&figure.html());
        }
        self.body.push_str("</div>\n");
        self
    }

    /// Adds a three-dimensional view.
    pub(crate) fn scene(&mut self, scene: &Scene) -> &mut Self {
        self.scenes = true;
        self.body.push_str(&scene.html(false));
        self
    }

    /// Returns the complete page as HTML text. `footer` names the program and its inputs.
    pub fn finish(self, footer: &str) -> String {
        self.written("", footer)
    }

    /// Returns a complete page with a single three-dimensional view that fills the window, as HTML text.
    pub fn of_scene(scene: &Scene, lead: &str, footer: &str) -> String {
        let mut page = Self::new(&scene.title, lead);
        page.scenes = true;
        page.body.push_str(&scene.html(true));
        page.written(" class=\"full\"", footer)
    }

    fn written(self, class: &str, footer: &str) -> String {
        let (style, client) = if self.scenes {
            (CLIENT_STYLE, format!("<script>\n{CLIENT}</script>\n"))
        } else {
            ("", String::new())
        };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body{class}>\n{}<footer>{}</footer>\n{client}</body>\n</html>\n",
            escape(&self.title),
            self.body,
            escape(footer)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_texts_cannot_become_markup() {
        let mut page = Page::new("<script>alert(1)</script>", "a & b \"quoted\"");
        page.paragraph("</p><img src=x onerror='alert(1)'> `</code><img>` `<b>")
            .list(&["<li>".to_string()])
            .verbatim("</pre><b>");
        let html = page.finish("<footer>");
        assert!(!html.contains("<script"));
        assert!(!html.contains("<img"));
        assert!(!html.contains("</pre><b>") && !html.contains("<b>"));
        assert!(html.contains("<code>&lt;/code&gt;&lt;img&gt;</code>"));
        assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    }
}
