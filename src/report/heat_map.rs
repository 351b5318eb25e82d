use std::fmt::Write as _;

use super::escape;

/// Heat map: values over two lists of names, as coloured cells. Negative values are blue, positive values red.
#[derive(Clone, Debug)]
pub(crate) struct HeatMap {
    /// Title of the map.
    pub title: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Values, one list per row; `None` for a cell without a value.
    pub values: Vec<Vec<Option<f64>>>,
    /// Value at which a cell has full colour.
    pub limit: f64,
    /// Quantity shown, with its unit.
    pub what: String,
}

const CELL: (usize, usize) = (22, 18);
/// Minimum width of the column of row names in pixels.
const MIN_LEFT_PX: usize = 170;
/// Width of a character in pixels, of a wide font.
const CHARACTER_PX: f64 = 6.5;
const TOP: usize = 120;

impl HeatMap {
    /// Draws the map as an `<svg>` element. Each cell shows its value as a tooltip.
    pub(crate) fn svg(&self) -> String {
        let letters = self.rows.iter().map(|name| name.chars().count());
        let longest = letters.max().unwrap_or(0) as f64;
        let left = ((CHARACTER_PX * longest) as usize + 12).max(MIN_LEFT_PX);
        let width = left + self.columns.len() * CELL.0 + 30;
        let height = TOP + self.rows.len() * CELL.1 + 40;
        let mut out = format!(
            "<svg class=\"map\" role=\"img\" aria-label=\"{}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n",
            escape(&format!("{}: {}", self.title, self.what))
        );
        let mut push = |text: String| out.push_str(&text);
        for (c, name) in self.columns.iter().enumerate() {
            let (x, y) = (left + c * CELL.0 + 14, TOP - 6);
            push(format!(
                "<text transform=\"translate({x},{y}) rotate(-60)\">{}</text>\n",
                escape(name)
            ));
        }
        for (r, name) in self.rows.iter().enumerate() {
            let y = TOP + r * CELL.1;
            push(format!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n",
                left - 6,
                y + 13,
                escape(name)
            ));
            for (c, value) in self.values.get(r).into_iter().flatten().enumerate() {
                let Some(value) = value.filter(|v| v.is_finite()) else {
                    continue;
                };
                let x = left + c * CELL.0;
                let (colour, cover) = self.colour(value);
                let column = self.columns.get(c).map_or("", String::as_str);
                push(format!(
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"{colour}\" fill-opacity=\"{cover:.2}\"><title>{}</title></rect>\n",
                    CELL.0 - 1,
                    CELL.1 - 1,
                    escape(&format!("{name}, {column}: {value:.3}"))
                ));
            }
        }
        write!(
            out,
            "<text x=\"{left}\" y=\"{}\" class=\"name\">{}; red is positive, blue is negative, full colour at {}</text>\n</svg>",
            height - 12,
            escape(&self.what),
            super::number(self.limit, Some(0.1 * self.limit))
        )
        .expect("a String takes all");
        out
    }

    /// Returns the data of the map as CSV, one line per row.
    pub(crate) fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut out = quoted(&self.what);
        for column in &self.columns {
            write!(out, ",{}", quoted(column)).expect("a String takes all");
        }
        out.push('\n');
        for (name, values) in self.rows.iter().zip(&self.values) {
            out.push_str(&quoted(name));
            for value in values {
                let text = value.map_or_else(String::new, |value| value.to_string());
                write!(out, ",{text}").expect("a String takes all");
            }
            out.push('\n');
        }
        out
    }

    /// Returns the colour and the opacity of a value. Zero is transparent, so the map suits light and dark pages.
    fn colour(&self, value: f64) -> (&'static str, f64) {
        let share = (value / self.limit.max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0);
        let full = if share < 0.0 {
            "rgb(33,102,172)"
        } else {
            "rgb(178,24,43)"
        };
        (full, share.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_coloured_by_sign_and_size() {
        let map = HeatMap {
            title: "<t>".to_string(),
            rows: vec!["case 1".to_string()],
            columns: vec!["a".to_string(), "b".to_string(), "c".to_string()],
            values: vec![vec![Some(-2.0), None, Some(1.0)]],
            limit: 1.0,
            what: "sigma".to_string(),
        };
        let svg = map.svg();
        assert_eq!(svg.matches("<rect").count(), 2);
        assert!(svg.contains("rgb(33,102,172)") && svg.contains("rgb(178,24,43)"));
        assert!(svg.contains("&lt;t&gt;"));
    }
}
