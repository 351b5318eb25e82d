use std::fmt::Write as _;

use super::axis::{Axis, short};
use super::escape;

/// Tornado chart: bars one below the other, each from a common start value to two end values.
#[derive(Clone, Debug)]
pub struct Bars {
    /// Title of the chart.
    pub title: String,
    /// Label of the value axis, with its unit.
    pub x: String,
    /// Name and two end values of each bar. The colour of the bar to the first value differs from the colour of the bar to the second value.
    pub rows: Vec<(String, [f64; 2])>,
    /// Start value of all bars.
    pub level: f64,
}

/// Width of the chart and height of one bar with its margin, in pixels.
const SIZE: (f64, f64) = (500.0, 26.0);
/// Margins in pixels: right, top, and bottom (for the axis).
const MARGINS_PX: [f64; 3] = [14.0, 8.0, 46.0];
/// Assumed width of a character in pixels. It is that of capitals in a wide font, so that no name is cut off.
const CHARACTER_PX: f64 = 7.3;
/// Margin around the names of the bars in pixels.
const NAME_MARGIN_PX: f64 = 16.0;
/// Minimum width of the column of names in pixels.
const MIN_NAMES_PX: f64 = 120.0;
/// Maximum number of characters shown of a bar's name.
const MAX_NAME_CHARACTERS: usize = 44;

impl Bars {
    /// Draws the chart as an `<svg>` element. The page's style sheet defines the colours.
    pub(crate) fn svg(&self) -> String {
        let ends = self.rows.iter().flat_map(|(_, ends)| ends.iter().copied());
        let axis = Axis::over(ends.chain([self.level]), false, 6);
        let letters = self.rows.iter().map(|(name, _)| name.chars().count());
        let longest = letters.max().unwrap_or(0).min(MAX_NAME_CHARACTERS) as f64;
        let left = (CHARACTER_PX * longest + NAME_MARGIN_PX).max(MIN_NAMES_PX);
        let [right, top, bottom] = MARGINS_PX;
        let wide = SIZE.0 - left - right;
        let tall = SIZE.1 * self.rows.len() as f64;
        let height = top + tall + bottom;
        let at = |value: f64| axis.share(value).map(|share| left + share * wide);
        let names: Vec<&str> = self.rows.iter().map(|(name, _)| name.as_str()).collect();
        let mut out = format!(
            "<svg class=\"chart bars\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {height}\" width=\"{}\" height=\"{height}\">\n",
            escape(&format!("{}: {}; {}", self.title, self.x, names.join(", "))),
            SIZE.0,
            SIZE.0
        );
        let floor = top + tall;
        for tick in &axis.ticks {
            let Some(x) = at(*tick) else { continue };
            _ = writeln!(
                out,
                "<path class=\"grid\" d=\"M{x:.1} {floor}V{top}\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                floor + 16.0,
                short(*tick)
            );
        }
        for (k, (name, ends)) in self.rows.iter().enumerate() {
            let y = top + SIZE.1 * k as f64;
            let shown: String = if name.chars().count() > MAX_NAME_CHARACTERS {
                let kept: String = name.chars().take(MAX_NAME_CHARACTERS - 1).collect();
                format!("{kept}\u{2026}")
            } else {
                name.clone()
            };
            _ = writeln!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 8.0,
                y + 0.5 * SIZE.1 + 4.0,
                escape(&shown)
            );
            for (end, class) in ends.iter().zip(["s2", "s1"]) {
                let (Some(from), Some(to)) = (at(self.level), at(*end)) else {
                    continue;
                };
                _ = writeln!(
                    out,
                    "<g class=\"{class}\"><path class=\"line\" style=\"stroke-width:14\" d=\"M{from:.1} {0:.1}H{to:.1}\"/></g>",
                    y + 0.5 * SIZE.1
                );
            }
        }
        if let Some(x) = at(self.level) {
            _ = writeln!(out, "<path class=\"axis\" d=\"M{x:.1} {floor}V{top}\"/>");
        }
        _ = write!(
            out,
            "<path class=\"axis\" d=\"M{left} {floor}H{}\"/>\n<text class=\"name\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n</svg>",
            left + wide,
            left + 0.5 * wide,
            height - 10.0,
            escape(&self.x)
        );
        out
    }

    /// Returns the data of the chart as CSV, one line per bar.
    pub(crate) fn csv(&self) -> String {
        let mut out = String::from("name,low,high\n");
        for (name, [low, high]) in &self.rows {
            _ = writeln!(out, "\"{}\",{low},{high}", name.replace('"', "\"\""));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bar_is_drawn_to_both_sides() {
        let bars = Bars {
            title: "toe".to_string(),
            x: "change [mm]".to_string(),
            rows: vec![
                ("K <1>".to_string(), [-2.0, 2.0]),
                ("b".to_string(), [1.0, f64::NAN]),
            ],
            level: 0.0,
        };
        let svg = bars.svg();
        assert_eq!(svg.matches("class=\"line\"").count(), 3);
        assert!(svg.contains("K &lt;1&gt;") && !svg.contains("NaN"));
        assert_eq!(bars.csv(), "name,low,high\n\"K <1>\",-2,2\n\"b\",1,NaN\n");
    }
}
