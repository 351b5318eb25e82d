use plotters::chart::ChartBuilder;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, IntoLogRange, LineSeries, PathElement, RGBColor,
    SVGBackend, WHITE,
};
use plotters::series::DashedLineSeries;
use plotters::style::{Color, ShapeStyle};

use super::DrawingError;

/// Colours that people with colour-blindness can tell apart (Okabe and Ito 2008).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
    RGBColor(140, 100, 60),
];

/// How a series is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// A dashed line.
    Dashed,
    /// Points only.
    Points,
    /// A line with its points.
    LinePoints,
}

/// One curve or cloud.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// (x, y); points that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
}

/// A picture with two axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x: String,
    /// Label of the y axis, with its unit.
    pub y: String,
    /// Curves.
    pub series: Vec<Series>,
    /// True for a logarithmic y axis; values that are not positive are left out then.
    pub log_y: bool,
    /// A horizontal line to compare with.
    pub level: Option<f64>,
}

impl Chart {
    /// The picture as an `<svg>` element, 880 by 420 and the names of its series beside it.
    ///
    /// # Errors
    /// When the drawing library cannot draw it.
    pub fn svg(&self) -> Result<String, DrawingError> {
        let usable =
            |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && (!self.log_y || p.1 > 0.0);
        let series: Vec<(usize, &Series, Vec<(f64, f64)>)> = self
            .series
            .iter()
            .enumerate()
            .map(|(k, s)| (k, s, s.points.iter().copied().filter(usable).collect()))
            .collect();
        let all = || series.iter().flat_map(|(_, _, points)| points.iter());
        let extent = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let (x0, x1) = padded(extent(&mut all().map(|p| p.0)), 0.02);
        let level = self.level.filter(|level| !self.log_y || *level > 0.0);
        let heights = extent(&mut all().map(|p| p.1).chain(level));
        let mut out = String::new();
        {
            let beside = Legend::of(&self.series);
            let canvas = SVGBackend::with_string(&mut out, (PLOT_WIDTH + beside.width, 420));
            let canvas = canvas.into_drawing_area();
            canvas.fill(&WHITE).map_err(|error| DrawingError {
                title: self.title.clone(),
                reason: error.to_string(),
            })?;
            let (root, margin) = canvas.split_horizontally(PLOT_WIDTH);
            let drawn = if self.log_y {
                let (low, high) = if heights.0.is_finite() {
                    heights
                } else {
                    (0.1, 10.0)
                };
                self.draw(
                    &root,
                    x0..x1,
                    (low / 1.3..high * 1.3).log_scale(),
                    &series,
                    level,
                )
            } else {
                let (y0, y1) = padded(heights, 0.06);
                self.draw(&root, x0..x1, y0..y1, &series, level)
            };
            // Presenting ends the picture: what is drawn afterwards would stand outside of it.
            let drawn = drawn
                .and_then(|()| beside.draw(&margin, &self.series))
                .and_then(|()| canvas.present().map_err(|error| error.to_string()));
            drawn.map_err(|reason| DrawingError {
                title: self.title.clone(),
                reason,
            })?;
        }
        Ok(out)
    }

    fn draw<Y>(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
        x: std::ops::Range<f64>,
        y: Y,
        series: &[(usize, &Series, Vec<(f64, f64)>)],
        level: Option<f64>,
    ) -> Result<(), String>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", 17))
            .margin(12)
            .margin_right(24)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(x.clone(), y)
            .map_err(|e| text(&e))?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .axis_desc_style(("sans-serif", 14))
            .label_style(("sans-serif", 12))
            .light_line_style(RGBColor(244, 244, 244))
            .bold_line_style(RGBColor(225, 225, 225))
            .y_label_formatter(&|v| short(*v))
            .x_label_formatter(&|v| short(*v))
            .draw()
            .map_err(|e| text(&e))?;
        if let Some(level) = level {
            let line =
                PathElement::new(vec![(x.start, level), (x.end, level)], RGBColor(90, 90, 90));
            chart
                .draw_series(std::iter::once(line))
                .map_err(|e| text(&e))?;
        }
        for (k, series, points) in series {
            let colour = COLOURS[k % COLOURS.len()];
            let line = ShapeStyle::from(&colour).stroke_width(2);
            let drawn = match series.mark {
                Mark::Line | Mark::LinePoints => {
                    chart.draw_series(LineSeries::new(points.iter().copied(), line))
                }
                Mark::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points.iter().copied(), 6, 4, line))
                }
                Mark::Points => {
                    chart.draw_series(points.iter().map(|p| Circle::new(*p, 3, colour.filled())))
                }
            };
            drawn.map_err(|e| text(&e))?;
            if series.mark == Mark::LinePoints {
                let dots = points.iter().map(|p| Circle::new(*p, 3, colour.filled()));
                chart.draw_series(dots).map_err(|e| text(&e))?;
            }
        }
        Ok(())
    }
}

/// Width of a chart without its legend, in pixels.
const PLOT_WIDTH: u32 = 880;

/// The names of the series, beside the plot so that they hide nothing.
struct Legend {
    /// Width in pixels; zero where one series needs no name.
    width: u32,
    columns: u32,
    column_width: u32,
}

impl Legend {
    const ROWS: usize = 24;
    const ROW_HEIGHT: i32 = 16;

    fn of(series: &[Series]) -> Self {
        if series.len() < 2 {
            return Self {
                width: 0,
                columns: 1,
                column_width: 0,
            };
        }
        let longest = series.iter().map(|s| s.name.chars().count()).max();
        // Seven pixels a letter hold the widest of a sans-serif font of this size on average.
        let column_width = 34 + 7 * longest.unwrap_or(0) as u32;
        let columns = series.len().div_ceil(Self::ROWS) as u32;
        Self {
            width: columns * column_width,
            columns,
            column_width,
        }
    }

    fn draw(
        &self,
        area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
        series: &[Series],
    ) -> Result<(), String> {
        if self.width == 0 {
            return Ok(());
        }
        let rows = series.len().div_ceil(self.columns as usize);
        for (k, series) in series.iter().enumerate() {
            let x = (k / rows) as i32 * self.column_width as i32;
            let y = 20 + (k % rows) as i32 * Self::ROW_HEIGHT;
            let style = ShapeStyle::from(&COLOURS[k % COLOURS.len()]).stroke_width(3);
            let from = if series.mark == Mark::Points {
                x + 7
            } else {
                x
            };
            area.draw(&PathElement::new(vec![(from, y), (x + 16, y)], style))
                .map_err(|error| error.to_string())?;
            let name = plotters::element::Text::new(
                series.name.clone(),
                (x + 22, y - 7),
                ("sans-serif", 12),
            );
            area.draw(&name).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

/// An extent with some room; a usable one where nothing or only one value is there.
fn padded((low, high): (f64, f64), share: f64) -> (f64, f64) {
    if !low.is_finite() || !high.is_finite() {
        return (0.0, 1.0);
    }
    let width = high - low;
    let room = if width > 0.0 {
        width * share
    } else {
        low.abs().max(1.0) * 0.1
    };
    (low - room, high + room)
}

/// A tick label without needless digits.
fn short(value: f64) -> String {
    // Ticks are sums of steps: what should be zero may be left with their round-off.
    if value.abs() < 1e-12 {
        return "0".to_string();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.1e}");
    }
    let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
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
                    mark: Mark::LinePoints,
                },
                Series {
                    name: "Ky".to_string(),
                    points: vec![(0.0, 2.0), (1.0, 1.0)],
                    mark: Mark::Dashed,
                },
            ],
            log_y,
            level: Some(1.0),
        }
    }

    #[test]
    fn texts_are_escaped_and_every_point_is_drawn() {
        let svg = chart(false, vec![(0.0, 0.5), (1.0, 0.9), (2.0, f64::NAN)])
            .svg()
            .unwrap();
        assert!(svg.starts_with("<svg"));
        assert!(svg.contains("a &lt;b&gt; &amp; c") && svg.contains("Kx &lt;1&gt;"));
        assert_eq!(svg.matches("<circle").count(), 2, "the NaN is left out");
        let end = svg.find("</svg>").unwrap();
        assert!(
            svg[end..].trim_end() == "</svg>",
            "nothing stands outside of the picture"
        );
        assert!(svg.rfind("Kx &lt;1&gt;").unwrap() < end);
    }

    #[test]
    fn empty_and_degenerate_data_still_draw() {
        assert!(chart(true, vec![]).svg().is_ok());
        assert!(chart(true, vec![(0.0, -1.0), (0.0, 0.0)]).svg().is_ok());
        assert!(
            Chart {
                series: vec![],
                level: None,
                ..chart(false, vec![])
            }
            .svg()
            .is_ok()
        );
    }

    #[test]
    fn tick_labels_are_short() {
        assert_eq!(
            ["0", "0.5", "1200", "1.0e-5"],
            [0.0, 0.5, 1200.0, 1e-5]
                .map(short)
                .each_ref()
                .map(String::as_str)
        );
    }
}
