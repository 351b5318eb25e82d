use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::axis::{Axis, short};
use super::legend::Legend;
use super::series::{Series, SeriesStyle};
use super::{DrawingError, escape};

/// Chart of several series over two axes.
#[derive(Clone, Debug, Default)]
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
    /// Values that the y axis covers in addition to those of the series, for a scale shared with other charts.
    pub reach: Option<[f64; 2]>,
}

/// Width and height of a chart in pixels. Two charts fit side by side on a screen, and the text stays readable on a narrow screen.
const SIZE: (f64, f64) = (560.0, 330.0);
/// Margins around the plot in pixels: left, right, top, bottom.
const ROOM: [f64; 4] = [66.0, 14.0, 10.0, 46.0];
/// Number of colours in the style sheet; further series repeat the colours with dashes.
const COLOURS: usize = 8;
/// Largest ratio of the ranges of two charts that still share a scale. At a larger ratio, the curves of one chart would look flat.
const MAX_RATIO: f64 = 8.0;

impl Chart {
    /// Sets a common scale for charts with equal y labels, unless the curves of one of them would then look flat.
    pub(crate) fn equalise(charts: &mut [Self]) {
        let ranges: Vec<Option<[f64; 2]>> = charts.iter().map(Self::range).collect();
        let scales: Vec<Option<[f64; 2]>> = charts
            .iter()
            .map(|chart| {
                let same = charts.iter().zip(&ranges);
                let same = same.filter(|(other, _)| other.y == chart.y && !other.log_y);
                let same: Vec<[f64; 2]> = same.filter_map(|(_, range)| *range).collect();
                let width = |[low, high]: [f64; 2]| high - low;
                let least = same.iter().map(|r| width(*r)).fold(f64::INFINITY, f64::min);
                let all = same
                    .into_iter()
                    .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
                (width(all) <= MAX_RATIO * least).then_some(all)
            })
            .collect();
        for (chart, scale) in charts.iter_mut().zip(scales) {
            chart.reach = scale;
        }
    }

    /// Returns the smallest and the largest y value; `None` without values.
    fn range(&self) -> Option<[f64; 2]> {
        let all = self.series.iter().flat_map(|series| &series.points);
        let all = all.map(|point| point.1).filter(|y| y.is_finite());
        all.map(|y| [y, y])
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Draws the chart as an `<svg>` element. The page's style sheet defines the colours, and its script reads the scales from the element.
    ///
    /// # Errors
    /// None at present. The return type is shared with pictures that may fail.
    pub(crate) fn svg(&self) -> Result<String, DrawingError> {
        let points = || self.series.iter().flat_map(|series| series.points.iter());
        let usable =
            |(x, y): &&(f64, f64)| x.is_finite() && y.is_finite() && (!self.log_y || *y > 0.0);
        let level = self.level.filter(|level| !self.log_y || *level > 0.0);
        let x = Axis::over(points().filter(usable).map(|p| p.0), false, 6);
        let ys = points().filter(usable).map(|p| p.1);
        let y = Axis::over(
            ys.chain(level).chain(self.reach.into_iter().flatten()),
            self.log_y,
            5,
        );
        let [left, right, top, bottom] = ROOM;
        let (wide, tall) = (SIZE.0 - left - right, SIZE.1 - top - bottom);
        let px = |value: f64| x.share(value).map(|share| left + share * wide);
        let py = |value: f64| y.share(value).map(|share| top + (1.0 - share) * tall);
        let (x0, x1, y0, y1) = (left, left + wide, top + tall, top);
        let mut out = format!(
            "<svg class=\"chart\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" data-plot=\"{x0} {x1} {y1} {y0}\" \
             data-x=\"{}\" data-y=\"{}\">\n<g class=\"ticks\">",
            escape(&self.described()),
            SIZE.0,
            SIZE.1,
            SIZE.0,
            SIZE.1,
            x.ends(),
            y.ends()
        );
        let mut push = |text: std::fmt::Arguments<'_>| {
            out.write_fmt(text).expect("a String takes all");
        };
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
            "</g>\n<path class=\"axis\" d=\"M{x0} {y1}V{y0}H{x1}\"/>\n\
             <text class=\"name\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
             <text class=\"name\" transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n<g class=\"plot\">",
            left + wide / 2.0,
            SIZE.1 - 8.0,
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
            push(format_args!("<g class=\"{}\">", class(series, k)));
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
        push(format_args!("</g>\n</svg>"));
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

    /// Returns the legend of the chart: each name beside a sample of its line or symbol.
    pub(crate) fn legend(&self) -> Legend {
        Legend::of(self.series.iter().enumerate().map(|(k, series)| {
            let sign = move |at| symbol(k, at);
            (class(series, k), series.mark, sign, series.name.as_str())
        }))
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

/// Returns the colour class of a series.
fn class(series: &Series, k: usize) -> String {
    let is_dashed = series.mark == SeriesStyle::Dashed || (k >= COLOURS && series.role.is_none());
    let dash = if is_dashed { " dashed" } else { "" };
    match series.role {
        Some(role) => format!("{}{dash}", role.class()),
        None => format!("s{}{dash}", 1 + k % COLOURS),
    }
}

/// Draws a point of series `k`: a circle, square, triangle or diamond, so that point clouds differ in more than colour.
fn symbol(k: usize, (x, y): (f64, f64)) -> String {
    let shape = match k % 4 {
        0 => {
            return format!(
                "<circle class=\"dot\" transform=\"translate({x:.1} {y:.1})\" r=\"3.2\"/>"
            );
        }
        1 => "M-2.8 -2.8h5.6v5.6h-5.6z",
        2 => "M0 -3.8l3.6 6.2h-7.2z",
        _ => "M0 -3.8l3.8 3.8l-3.8 3.8l-3.8 -3.8z",
    };
    format!("<path class=\"dot\" transform=\"translate({x:.1} {y:.1})\" d=\"{shape}\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Role;

    fn chart(log_y: bool, points: Vec<(f64, f64)>) -> Chart {
        Chart {
            title: "a <b> & c".to_string(),
            x: "iteration".to_string(),
            y: "K / K_ref".to_string(),
            series: vec![
                Series::new("Kx <1>", SeriesStyle::LinePoints, points),
                Series::new("Ky", SeriesStyle::Dashed, vec![(0.0, 2.0), (1.0, 1.0)]),
            ],
            log_y,
            level: Some(1.0),
            reach: None,
        }
    }

    #[test]
    fn texts_are_escaped_and_every_point_is_drawn() {
        let chart = chart(false, vec![(0.0, 0.5), (1.0, 0.9), (2.0, f64::NAN)]);
        let svg = chart.svg().unwrap();
        assert!(svg.starts_with("<svg"));
        assert!(svg.contains("a &lt;b&gt; &amp; c") && svg.contains("Kx &lt;1&gt;"));
        assert!(!svg.contains("NaN"));
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(
            chart
                .csv()
                .starts_with("series,\"iteration\",\"K / K_ref\"\n\"Kx <1>\",0,0.5\n")
        );
    }

    #[test]
    fn the_legend_shows_each_line_as_it_is_drawn() {
        let chart = chart(false, vec![(0.0, 0.5), (1.0, 0.9)]);
        for text in [chart.svg().unwrap(), chart.legend().html()] {
            assert_eq!(text.matches("class=\"s2 dashed\"").count(), 1);
            assert_eq!(text.matches("class=\"s1\"").count(), 1);
        }
    }

    #[test]
    fn a_role_has_one_colour_wherever_its_series_stands() {
        let points = || vec![(0.0, 1.0), (1.0, 2.0)];
        let drawn = |series: Vec<Series>| {
            let chart = Chart {
                series,
                ..chart(false, vec![])
            };
            chart.svg().unwrap().matches("class=\"s-given").count()
        };
        let (read, was) = (
            Series::of(Role::Measured, points()),
            Series::of(Role::Given, points()),
        );
        assert_eq!(drawn(vec![read.clone(), was.clone()]), 1);
        assert_eq!(drawn(vec![was, read]), 1);
    }

    /// Charts of toe over two loads have the same scale, as long as the curves of both are visible.
    #[test]
    fn charts_of_one_quantity_share_their_scale() {
        let of = |most: f64| Chart {
            y: "toe [deg]".to_string(),
            series: vec![Series::of(Role::Measured, vec![(0.0, 0.0), (1.0, most)])],
            ..Chart::default()
        };
        let mut near = [of(1.0), of(3.0)];
        Chart::equalise(&mut near);
        assert_eq!(near[0].reach, Some([0.0, 3.0]));
        assert!(near[0].svg().unwrap().contains("data-y=\"-1.5"));
        let mut far = [of(1.0), of(30.0)];
        Chart::equalise(&mut far);
        assert_eq!(far[0].reach, None);
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
        assert!(Chart::default().svg().is_ok());
    }
}
