use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::axis::{Axis, short};
use super::{DrawingError, escape};

/// Drawing style of a series.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SeriesStyle {
    /// A line through the points.
    Line,
    /// A dashed line.
    Dashed,
    /// Points only.
    Points,
    /// A line with its points.
    LinePoints,
}

/// Series of a chart: a curve or a point cloud.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name of the series in the legend.
    pub name: String,
    /// Points as pairs of x and y. Points that are not finite are omitted.
    pub points: Vec<(f64, f64)>,
    /// Drawing style of the series.
    pub mark: SeriesStyle,
}

/// Chart of several series over two axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title of the chart.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x: String,
    /// Label of the y axis, with its unit.
    pub y: String,
    /// Series of the chart: curves and point clouds.
    pub series: Vec<Series>,
    /// True for a logarithmic y axis. Values that are not positive are then omitted.
    pub log_y: bool,
    /// Position of a horizontal reference line on the y axis.
    pub level: Option<f64>,
}

/// Width and height of a chart in pixels. Two charts fit side by side on a screen, and the text stays readable on a narrow screen.
const SIZE: (f64, f64) = (560.0, 340.0);
/// Margins around the plot in pixels: left, right, top, bottom.
const ROOM: [f64; 4] = [66.0, 14.0, 12.0, 46.0];
const LEGEND_ROW: f64 = 18.0;
/// Number of colours in the style sheet; further series repeat the colours with dashes.
const COLOURS: usize = 8;
/// Colour classes of series with a fixed role, by the name of the series. A role has the same colour in all charts, tables and views of a
/// page.
const ROLES: [(&str, &str); 8] = [
    ("measured", MEASURED),
    ("as read", MEASURED),
    ("initial", INITIAL),
    ("as the model was", INITIAL),
    ("identified", "s-fitted"),
    ("as it is extended", EXTENDED),
    ("two standard errors above", "s1"),
    ("two standard errors below", "s1"),
];
const MEASURED: &str = "s-measured";
/// Colour class of the original model, before a fit or an extension.
pub(super) const INITIAL: &str = "s-initial";
/// Colour class of the extended model.
pub(super) const EXTENDED: &str = "s-extended";

impl Chart {
    /// Draws the chart as an `<svg>` element. The page's style sheet defines the colours. The legend below the plot shows each name beside a
    /// sample of its line.
    ///
    /// # Errors
    /// None at present. The return type is shared with pictures that may fail.
    pub(crate) fn svg(&self) -> Result<String, DrawingError> {
        self.svg_in(&[])
    }

    /// Draws the chart as an `<svg>` element in given colours. `colours` holds colour indices of the style sheet, counted from 1, for the
    /// first series. The other series take the colour of their position in the chart.
    ///
    /// # Errors
    /// The same as [`Self::svg`].
    pub(crate) fn svg_in(&self, colours: &[usize]) -> Result<String, DrawingError> {
        let class = |name: &str, k: usize, mark: SeriesStyle| match colours.get(k) {
            Some(colour) => format!("s{colour}{}", dashed(mark == SeriesStyle::Dashed)),
            None => class(name, k, mark),
        };
        let points = || self.series.iter().flat_map(|series| series.points.iter());
        let usable =
            |(x, y): &&(f64, f64)| x.is_finite() && y.is_finite() && (!self.log_y || *y > 0.0);
        let level = self.level.filter(|level| !self.log_y || *level > 0.0);
        let x = Axis::over(points().filter(usable).map(|p| p.0), false, 6);
        let y = Axis::over(
            points().filter(usable).map(|p| p.1).chain(level),
            self.log_y,
            5,
        );
        let (rows, legend) = self.legend(&class);
        let height = SIZE.1 + rows as f64 * LEGEND_ROW;
        let [left, right, top, bottom] = ROOM;
        let (wide, tall) = (SIZE.0 - left - right, SIZE.1 - top - bottom);
        let px = |value: f64| x.share(value).map(|share| left + share * wide);
        let py = |value: f64| y.share(value).map(|share| top + (1.0 - share) * tall);
        let mut out = format!(
            "<svg class=\"chart\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {height}\" width=\"{}\" height=\"{height}\">\n",
            escape(&self.described()),
            SIZE.0,
            SIZE.0
        );
        let mut push = |text: std::fmt::Arguments<'_>| {
            out.write_fmt(text).expect("a String takes all");
        };
        let (x0, x1, y0, y1) = (left, left + wide, top + tall, top);
        for tick in &x.ticks {
            let Some(at) = px(*tick) else { continue };
            push(format_args!(
                "<path class=\"grid\" d=\"M{at:.1} {y0}V{y1}\"/><text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                y0 + 16.0,
                short(*tick)
            ));
        }
        for tick in &y.ticks {
            let Some(at) = py(*tick) else { continue };
            push(format_args!(
                "<path class=\"grid\" d=\"M{x0} {at:.1}H{x1}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
                x0 - 6.0,
                at + 4.0,
                short(*tick)
            ));
        }
        push(format_args!(
            "<path class=\"axis\" d=\"M{x0} {y1}V{y0}H{x1}\"/>\n\
             <text class=\"name\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
             <text class=\"name\" transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
            left + wide / 2.0,
            SIZE.1 - 10.0,
            escape(&self.x),
            top + tall / 2.0,
            escape(&self.y)
        ));
        if let Some(at) = level.and_then(py) {
            push(format_args!(
                "<path class=\"level\" d=\"M{x0} {at:.1}H{x1}\"/>\n"
            ));
        }
        for (k, series) in self.series.iter().enumerate() {
            let spots: Vec<(f64, f64)> = series
                .points
                .iter()
                .filter(usable)
                .filter_map(|p| Some((px(p.0)?, py(p.1)?)))
                .collect();
            let class = class(&series.name, k, series.mark);
            push(format_args!("<g class=\"{class}\">"));
            if series.mark != SeriesStyle::Points && spots.len() > 1 {
                push(format_args!(
                    "<path class=\"line\" d=\"{}\"/>",
                    path(&spots)
                ));
            }
            if matches!(series.mark, SeriesStyle::Points | SeriesStyle::LinePoints)
                || spots.len() == 1
            {
                for spot in &spots {
                    push(format_args!("{}", symbol(k, *spot)));
                }
            }
            push(format_args!("</g>\n"));
        }
        push(format_args!("{legend}</svg>"));
        Ok(out)
    }

    /// Describes the chart in words, for readers who cannot see it.
    fn described(&self) -> String {
        let names: Vec<&str> = self
            .series
            .iter()
            .map(|series| series.name.as_str())
            .collect();
        format!(
            "{}: {} against {}; {}",
            self.title,
            self.y,
            self.x,
            names.join(", ")
        )
    }

    /// Draws the legend. Returns the number of its rows, and the SVG text with each name beside a sample of its line or symbol.
    fn legend(&self, class: &dyn Fn(&str, usize, SeriesStyle) -> String) -> (usize, String) {
        if self.series.len() < 2 {
            return (0, String::new());
        }
        let longest = self
            .series
            .iter()
            .map(|s| s.name.chars().count())
            .max()
            .unwrap_or(0);
        // Eight pixels per letter suffice for most sans-serif fonts of this size, even for the larger font of narrow windows.
        let column = 44.0 + 8.0 * longest as f64;
        let columns = (((SIZE.0 - 20.0) / column) as usize).max(1);
        let mut out = String::new();
        for (k, series) in self.series.iter().enumerate() {
            let x = 20.0 + (k % columns) as f64 * column;
            let y = SIZE.1 + (k / columns) as f64 * LEGEND_ROW + 6.0;
            let class = class(&series.name, k, series.mark);
            write!(out, "<g class=\"{class}\">").expect("a String takes all");
            if series.mark != SeriesStyle::Points {
                write!(out, "<path class=\"line\" d=\"M{x} {y}h26\"/>")
                    .expect("a String takes all");
            }
            if matches!(series.mark, SeriesStyle::Points | SeriesStyle::LinePoints) {
                out.push_str(&symbol(k, (x + 13.0, y)));
            }
            let (tx, ty, name) = (x + 32.0, y + 4.0, escape(&series.name));
            writeln!(out, "<text x=\"{tx}\" y=\"{ty}\">{name}</text></g>")
                .expect("a String takes all");
        }
        (self.series.len().div_ceil(columns), out)
    }

    /// Returns the data of the chart as CSV, one line per point.
    pub(crate) fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut out = format!("series,{},{}\n", quoted(&self.x), quoted(&self.y));
        for series in &self.series {
            for (x, y) in &series.points {
                writeln!(out, "{},{x},{y}", quoted(&series.name)).expect("a String takes all");
            }
        }
        out
    }
}

/// Returns the SVG path through points. A segment that is traversed again is drawn only once; otherwise overlapping dashes would fill each
/// other's gaps.
fn path(spots: &[(f64, f64)]) -> String {
    let places: Vec<String> = spots
        .iter()
        .map(|p| format!("{:.1} {:.1}", p.0, p.1))
        .collect();
    let (mut out, mut drawn) = (String::new(), BTreeSet::new());
    let mut pen = None;
    for pair in places.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        if from == to || !drawn.insert((from.min(to), from.max(to))) {
            continue;
        }
        if pen != Some(from) {
            write!(out, "M{from}").expect("a String takes all");
        }
        write!(out, "L{to}").expect("a String takes all");
        pen = Some(to);
    }
    out
}

fn dashed(is: bool) -> &'static str {
    if is { " dashed" } else { "" }
}

fn class(name: &str, k: usize, mark: SeriesStyle) -> String {
    let own = name.split(',').next().unwrap_or_default();
    let role = ROLES.iter().find(|(name, _)| *name == own);
    let dash = dashed(mark == SeriesStyle::Dashed || (k >= COLOURS && role.is_none()));
    match role {
        Some((_, class)) => format!("{class}{dash}"),
        None => format!("s{}{dash}", 1 + k % COLOURS),
    }
}

/// Draws a point of series `k`: a circle, square, triangle or diamond, so that point clouds differ in more than colour.
fn symbol(k: usize, (x, y): (f64, f64)) -> String {
    match k % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\"/>"),
        1 => format!("<path d=\"M{:.1} {:.1}h5.6v5.6h-5.6z\"/>", x - 2.8, y - 2.8),
        2 => format!("<path d=\"M{x:.1} {:.1}l3.6 6.2h-7.2z\"/>", y - 3.8),
        _ => format!(
            "<path d=\"M{x:.1} {:.1}l3.8 3.8l-3.8 3.8l-3.8 -3.8z\"/>",
            y - 3.8
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(log_y: bool, points: Vec<(f64, f64)>) -> Chart {
        Chart {
            title: "a <b> & c".to_string(),
            x: "iteration".to_string(),
            y: "K / K_ref".to_string(),
            series: vec![
                Series {
                    name: "Kx <1>".to_string(),
                    points,
                    mark: SeriesStyle::LinePoints,
                },
                Series {
                    name: "Ky".to_string(),
                    points: vec![(0.0, 2.0), (1.0, 1.0)],
                    mark: SeriesStyle::Dashed,
                },
            ],
            log_y,
            level: Some(1.0),
        }
    }

    #[test]
    fn texts_are_escaped_and_every_point_is_drawn() {
        let chart = chart(false, vec![(0.0, 0.5), (1.0, 0.9), (2.0, f64::NAN)]);
        let svg = chart.svg().unwrap();
        assert!(svg.starts_with("<svg"));
        assert!(svg.contains("a &lt;b&gt; &amp; c") && svg.contains("Kx &lt;1&gt;"));
        assert!(!svg.contains("NaN"));
        let dots = svg.matches("<circle").count();
        assert_eq!(dots, 3, "two points and one in the legend");
        assert!(
            chart
                .csv()
                .starts_with("series,\"iteration\",\"K / K_ref\"\n\"Kx <1>\",0,0.5\n")
        );
    }

    #[test]
    fn the_legend_shows_each_line_as_it_is_drawn() {
        let svg = chart(false, vec![(0.0, 0.5), (1.0, 0.9)]).svg().unwrap();
        // Each series has its class twice: in the plot and in the legend.
        assert_eq!(svg.matches("class=\"s2 dashed\"").count(), 2);
        assert_eq!(svg.matches("class=\"s1\"").count(), 2);
    }

    #[test]
    fn a_role_has_one_colour_wherever_its_series_stands() {
        let named = |name: &str, mark| Series {
            name: name.to_string(),
            points: vec![(0.0, 1.0), (1.0, 2.0)],
            mark,
        };
        let drawn = |series: Vec<Series>| {
            let svg = Chart {
                series,
                ..chart(false, vec![])
            }
            .svg()
            .unwrap();
            svg.matches("class=\"s-initial").count()
        };
        let (read, was) = (
            named("as read", SeriesStyle::Points),
            named("as the model was", SeriesStyle::Dashed),
        );
        assert_eq!(drawn(vec![read, was.clone()]), 2, "curve and legend");
        let unseen = named("initial, cases no fit saw", SeriesStyle::Points);
        assert_eq!(drawn(vec![was, unseen]), 4);
    }

    #[test]
    fn a_way_back_along_itself_is_drawn_once() {
        let loop_of = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (1.0, 1.0), (0.0, 5.0)];
        assert_eq!(path(&loop_of), "M0.0 0.0L1.0 1.0L2.0 0.0M1.0 1.0L0.0 5.0");
        assert_eq!(path(&loop_of[..3]), "M0.0 0.0L1.0 1.0L2.0 0.0");
    }

    #[test]
    fn empty_and_degenerate_data_still_draw() {
        assert!(chart(true, vec![]).svg().is_ok());
        assert!(chart(true, vec![(0.0, -1.0), (0.0, 0.0)]).svg().is_ok());
        let empty = Chart {
            series: vec![],
            level: None,
            ..chart(false, vec![])
        };
        assert!(empty.svg().is_ok());
    }
}
