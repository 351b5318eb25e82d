use super::escape;
use super::series::SeriesStyle;

/// Legend of one or more charts: names beside samples of their lines or symbols.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct Legend {
    entries: Vec<String>,
}

/// Width and height of a sample, in pixels.
const SAMPLE: (f64, f64) = (28.0, 12.0);

impl Legend {
    /// Creates a legend from the colour class, the style, the symbol and the name of each series. A single series needs no legend.
    pub(super) fn of<'a, S: Fn((f64, f64)) -> String>(
        series: impl Iterator<Item = (String, SeriesStyle, S, &'a str)>,
    ) -> Self {
        let (width, height) = SAMPLE;
        let middle = (width / 2.0, height / 2.0);
        let entry = |(class, style, symbol, name): (String, SeriesStyle, S, &str)| {
            let name = escape(name);
            let line = if style == SeriesStyle::Points {
                String::new()
            } else {
                format!(
                    "<path class=\"line\" d=\"M1 {}H{}\"/>",
                    middle.1,
                    width - 1.0
                )
            };
            let dot = if matches!(style, SeriesStyle::Points | SeriesStyle::LinePoints) {
                symbol(middle)
            } else {
                String::new()
            };
            format!(
                "<span><svg class=\"key\" role=\"img\" aria-label=\"{name}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\
                 <g class=\"{class}\">{line}{dot}</g></svg>{name}</span>"
            )
        };
        let entries: Vec<String> = series.map(entry).collect();
        if entries.len() < 2 {
            return Self::default();
        }
        Self { entries }
    }

    /// Returns the legend as an HTML element; empty without entries.
    pub(super) fn html(&self) -> String {
        if self.entries.is_empty() {
            return String::new();
        }
        format!("<p class=\"legend\">{}</p>\n", self.entries.join("\n"))
    }
}
