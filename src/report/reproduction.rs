//! Page of the paper's validations, repeated with this program.

use super::{Align, Chart, DrawingError, Figure, Page, Series, SeriesStyle, Table};
use admire_results::Timestamp;
use serde::Serialize;

/// A table of texts: a head, and rows of the same length.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Comparison {
    /// Title.
    pub title: String,
    /// Column heads.
    pub head: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<String>>,
}

/// Curves over one load.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct ReproducedCurves {
    /// Title.
    pub title: String,
    /// Load with its unit, the abscissa.
    pub x: String,
    /// Angle with its unit, the ordinate.
    pub y: String,
    /// Curves.
    pub curves: Vec<Curve>,
}

/// One of the paper's validations.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct ReproducedSection {
    /// Title, such as `4.2 pseudo McPherson, no noise`.
    pub title: String,
    /// Tables.
    pub tables: Vec<Comparison>,
    /// Curves.
    pub figures: Vec<ReproducedCurves>,
    /// Findings from the tables, one sentence each.
    pub findings: Vec<String>,
    /// Limits of the comparison, with reasons.
    pub limits: Vec<String>,
}

/// An angle over a load.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Curve {
    /// Whose.
    pub name: String,
    /// (load, angle in degrees), in the order of application.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// The same as a change from where `load` is zero, or from its first point.
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

    /// Rms difference of two curves over the same loads.
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

/// Report of the repeated validations.
#[derive(Clone, Debug)]
pub struct ReproductionReport<'a> {
    /// The validations.
    pub sections: &'a [ReproducedSection],
}

impl ReproductionReport<'_> {
    /// Creates the page.
    ///
    /// # Errors
    /// When a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let mut page = Page::new(
            "The paper's validations, run again",
            "The published method was run again on the models of its own validation; below, each of its tables stands beside ours.",
        );
        page.facts(&[
            (
                "Paper",
                "Iterative identification of stiffness parameters in a car suspension elastokinematic model, Meissonnier and others, 2006"
                    .to_string(),
            ),
            ("Date", format!("{} UTC", Timestamp::now().date_time())),
            ("Made by", format!("admire {}, built-in solver", super::VERSION)),
        ]);
        let answer = |section: &ReproducedSection| {
            let finding = section.findings.last()?;
            Some(format!("{}: {finding}", section.title))
        };
        page.list(&self.sections.iter().filter_map(answer).collect::<Vec<_>>());
        for section in self.sections {
            page.heading(&section.title);
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
            let mut figures = Vec::new();
            for figure in &section.figures {
                let series = figure.curves.iter().enumerate().map(|(k, curve)| Series {
                    name: curve.name.clone(),
                    points: curve.points.clone(),
                    mark: if k < 2 {
                        SeriesStyle::LinePoints
                    } else {
                        SeriesStyle::Line
                    },
                });
                let chart = Chart {
                    title: figure.title.clone(),
                    x: figure.x.clone(),
                    y: figure.y.clone(),
                    series: series.collect(),
                    log_y: false,
                    level: None,
                };
                figures.push(Figure::chart(&chart, "")?);
            }
            page.figures(&figures);
            page.subheading("What cannot be compared");
            page.list(&section.limits);
        }
        Ok(page.finish(&format!("admire {}", super::VERSION)))
    }
}
