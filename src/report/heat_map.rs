use std::fmt::Write as _;

use super::escape;

/// Values over two lists of names, as coloured cells: blue below zero, red above.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Title.
    pub title: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One list per row; `None` where there is no value.
    pub values: Vec<Vec<Option<f64>>>,
    /// The value of full colour.
    pub limit: f64,
    /// What the values are, with the unit.
    pub what: String,
}

const CELL: (usize, usize) = (22, 18);
const LEFT: usize = 170;
const TOP: usize = 120;

impl HeatMap {
    /// The picture as an `<svg>` element. Each cell tells its value when pointed at.
    pub fn svg(&self) -> String {
        let width = LEFT + self.columns.len() * CELL.0 + 30;
        let height = TOP + self.rows.len() * CELL.1 + 40;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
             <text x=\"8\" y=\"18\" font-size=\"15\">{}</text>\n",
            escape(&self.title)
        );
        let mut push = |text: String| out.push_str(&text);
        for (c, name) in self.columns.iter().enumerate() {
            let (x, y) = (LEFT + c * CELL.0 + 14, TOP - 6);
            push(format!(
                "<text transform=\"translate({x},{y}) rotate(-60)\">{}</text>\n",
                escape(name)
            ));
        }
        for (r, name) in self.rows.iter().enumerate() {
            let y = TOP + r * CELL.1;
            push(format!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n",
                LEFT - 6,
                y + 13,
                escape(name)
            ));
            for (c, value) in self.values.get(r).into_iter().flatten().enumerate() {
                let Some(value) = value.filter(|v| v.is_finite()) else {
                    continue;
                };
                let (x, colour) = (LEFT + c * CELL.0, self.colour(value));
                let column = self.columns.get(c).map_or("", String::as_str);
                push(format!(
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"{colour}\"><title>{}</title></rect>\n",
                    CELL.0 - 1,
                    CELL.1 - 1,
                    escape(&format!("{name}, {column}: {value:.3}"))
                ));
            }
        }
        write!(
            out,
            "<text x=\"{LEFT}\" y=\"{}\" fill=\"#555\">{}; full colour at {:.3}</text>\n</svg>",
            height - 12,
            escape(&self.what),
            self.limit
        )
        .expect("a String takes all");
        out
    }

    fn colour(&self, value: f64) -> String {
        let share = (value / self.limit.max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0);
        let (full, weight) = if share < 0.0 {
            ([33u8, 102, 172], -share)
        } else {
            ([178, 24, 43], share)
        };
        let blend = |k: usize| (247.0 + (f64::from(full[k]) - 247.0) * weight).round() as u8;
        format!("rgb({},{},{})", blend(0), blend(1), blend(2))
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
