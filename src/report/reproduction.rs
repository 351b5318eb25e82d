//! Page that repeats the validations of the published method (the paper) with this program.

use super::scene::Role;
use super::{Align, Chart, DrawingError, Figure, Page, Series, SeriesStyle, Table};
use admire_results::Timestamp;
use serde::Serialize;

/// Table of texts: column headings, and rows of the same length.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Comparison {
    /// Title of the table.
    pub title: String,
    /// Column headings.
    pub head: Vec<String>,
    /// Rows, each with one text per column.
    pub rows: Vec<Vec<String>>,
}

/// Chart of wheel angles over one load.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct ReproducedCurves {
    /// Title of the chart.
    pub title: String,
    /// Load with its unit, on the x axis.
    pub x: String,
    /// Angle with its unit, on the y axis.
    pub y: String,
    /// Curves of the chart.
    pub curves: Vec<Curve>,
}

/// Repetition of one of the paper's validations.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct ReproducedSection {
    /// Title of the section, such as `4.2 pseudo McPherson, no noise`.
    pub title: String,
    /// Tables of the section.
    pub tables: Vec<Comparison>,
    /// Charts of the section.
    pub figures: Vec<ReproducedCurves>,
    /// Findings from the tables, one sentence each.
    pub findings: Vec<String>,
    /// Limits of the comparison with the paper, with the reason for each.
    pub limits: Vec<String>,
}

/// Curve of an angle over a load.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Curve {
    /// Name of the curve in the legend.
    pub name: String,
    /// Pairs of load and angle in degrees, in the order of application.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// Returns the curve as changes of the angle. The reference is the point at zero load, or the first point if no load is zero.
    #[must_use]
    pub fn since_zero(mut self) -> Self {
        let zero = self.points.iter().find(|(load, _)| *load == 0.0);
        let zero = zero
            .or(self.points.first())
            .map_or(0.0, |(_, angle)| *angle);
        for (_, angle) in &mut self.points {
            *angle -= zero;
        }
        self
    }

    /// Returns the rms difference of two curves over the same loads.
    pub fn distance(&self, other: &Self) -> f64 {
        let squares: f64 = self
            .points
            .iter()
            .zip(&other.points)
            .map(|((_, a), (_, b))| (a - b).powi(2))
            .sum();
        (squares / self.points.len().min(other.points.len()).max(1) as f64).sqrt()
    }
}

/// Report of the repeated validations as an HTML page.
#[derive(Clone, Debug)]
pub struct ReproductionReport<'a> {
    /// Sections of the page, one per validation.
    pub sections: &'a [ReproducedSection],
}

impl ReproductionReport<'_> {
    /// Returns the page as HTML text.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let mut page = Page::new(
            "Reproduction",
            "Validation cases of the paper, recomputed",
            "The three validation cases of the paper, recomputed: tables and figures of the paper and of admire side by side.",
        );
        page.origin(&[
            (
                "Paper",
                "Iterative identification of stiffness parameters in a car suspension elastokinematic model, Meissonnier and others, 2006"
                    .to_string(),
            ),
            ("Date", format!("{} UTC", Timestamp::now().date_time())),
            ("Made by", format!("admire {}, built-in solver", super::VERSION)),
        ]);
        let shown = self
            .sections
            .iter()
            .position(|section| !section.figures.is_empty());
        page.meaning();
        if let Some(shown) = shown {
            page.figures(&Self::figures(&self.sections[shown])?);
        }
        let answer = |section: &ReproducedSection| {
            let finding = section.findings.last()?;
            Some(format!("{}: {finding}", section.title))
        };
        page.found(&[("Found", self.sections.iter().filter_map(answer).collect())]);
        for (k, section) in self.sections.iter().enumerate() {
            page.detail(&section.title);
            page.list(&section.findings);
            for comparison in &section.tables {
                page.subheading(&comparison.title);
                let columns: Vec<(&str, Align)> = comparison
                    .head
                    .iter()
                    .enumerate()
                    .map(|(k, name)| {
                        (
                            name.as_str(),
                            if k == 0 { Align::Left } else { Align::Right },
                        )
                    })
                    .collect();
                let mut table = Table::new(&columns);
                for row in &comparison.rows {
                    table.row(row.iter().cloned());
                }
                page.table(&table);
            }
            if Some(k) != shown {
                page.figures(&Self::figures(section)?);
            }
            page.subheading("Results that cannot be compared");
            page.list(&section.limits);
        }
        Ok(page.finish(&format!("admire {}", super::VERSION)))
    }

    /// Draws the charts of a section.
    fn figures(section: &ReproducedSection) -> Result<Vec<Figure>, DrawingError> {
        let drawn = section.figures.iter().map(|figure| {
            let series = figure.curves.iter().enumerate().map(|(k, curve)| {
                let mark = match k {
                    0 => SeriesStyle::Dashed,
                    1 => SeriesStyle::LinePoints,
                    _ => SeriesStyle::Line,
                };
                // The first curve is that of the deck as given.
                Series {
                    role: (k == 0).then_some(Role::Given),
                    ..Series::new(&curve.name, mark, curve.points.clone())
                }
            });
            let chart = Chart {
                title: figure.title.clone(),
                x: figure.x.clone(),
                y: figure.y.clone(),
                series: series.collect(),
                ..Chart::default()
            };
            Figure::chart(&chart, "")
        });
        drawn.collect()
    }
}
