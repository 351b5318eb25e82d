use std::fmt::Write as _;

use super::Table;

/// Text made safe for HTML: no character of it can open a tag, an entity or leave an attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are not allowed in HTML; a deck may hold any byte.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// One page, built from top to bottom. It refers to nothing outside of itself.
#[derive(Debug)]
pub struct Page {
    title: String,
    body: String,
}

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#57606a;--line:#d0d7de;--paper:#fff;--good:#116329;--bad:#a40e26;--band:#f6f8fa}
@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--soft:#9198a1;--line:#3d444d;--paper:#0d1117;--good:#3fb950;--bad:#f85149;--band:#151b23}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:72rem;margin:2rem auto;padding:0 1.5rem}
h1{font-size:1.6rem;margin:0 0 .2rem}h2{font-size:1.15rem;margin:2.2rem 0 .6rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
p.lead{font-size:1.15rem;max-width:60rem}p.note,figcaption{color:var(--soft);font-size:.9rem;max-width:60rem}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.92rem}.wide{overflow-x:auto}
th,td{padding:.22rem .7rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:baseline}
td.right{white-space:nowrap}
td.wrap{white-space:normal;min-width:14rem}th{color:var(--soft);font-weight:600}td.right,th.right{text-align:right}tbody tr:hover{background:var(--band)}
.good{color:var(--good)}.bad{color:var(--bad)}.soft{color:var(--soft)}
figure{margin:1rem 0}figure svg{max-width:100%;height:auto;background:#fff;border:1px solid var(--line);border-radius:4px}
pre{background:var(--band);border:1px solid var(--line);border-radius:4px;padding:.6rem .9rem;overflow-x:auto;font-size:.85rem}
footer{margin:3rem 0 1rem;color:var(--soft);font-size:.85rem}
";

impl Page {
    /// A page with a title and, under it, the answer in a sentence or two.
    pub fn new(title: &str, lead: &str) -> Self {
        let mut page = Self {
            title: title.to_string(),
            body: String::new(),
        };
        page.push(format_args!(
            "<h1>{}</h1>\n<p class=\"lead\">{}</p>\n",
            escape(title),
            escape(lead)
        ));
        page
    }

    fn push(&mut self, text: std::fmt::Arguments<'_>) {
        self.body
            .write_fmt(text)
            .expect("writing into a String cannot fail");
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<h2>{}</h2>\n", escape(text)));
        self
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<p>{}</p>\n", escape(text)));
        self
    }

    /// A paragraph of small print.
    pub fn note(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<p class=\"note\">{}</p>\n", escape(text)));
        self
    }

    /// A list of sentences.
    pub fn list(&mut self, items: &[String]) -> &mut Self {
        self.body.push_str("<ul>\n");
        for item in items {
            self.push(format_args!("<li>{}</li>\n", escape(item)));
        }
        self.body.push_str("</ul>\n");
        self
    }

    /// Text as it is, for example a diff.
    pub fn verbatim(&mut self, text: &str) -> &mut Self {
        self.push(format_args!("<pre>{}</pre>\n", escape(text)));
        self
    }

    /// A table.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        self.push(format_args!("<div class=\"wide\">{}</div>\n", table.html()));
        self
    }

    /// A picture with a caption. `svg` comes from this module's charts, which escape their texts themselves.
    pub fn figure(&mut self, svg: &str, caption: &str) -> &mut Self {
        self.push(format_args!(
            "<figure>{svg}<figcaption>{}</figcaption></figure>\n",
            escape(caption)
        ));
        self
    }

    /// The whole page as one file. `footer` says what made it and from what.
    pub fn finish(self, footer: &str) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{}<footer>{}</footer>\n</body>\n</html>\n",
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
        page.paragraph("</p><img src=x onerror='alert(1)'>")
            .list(&["<li>".to_string()])
            .verbatim("</pre><b>");
        let html = page.finish("<footer>");
        assert!(!html.contains("<script"));
        assert!(!html.contains("<img"));
        assert!(!html.contains("</pre><b>"));
        assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
    }
}
