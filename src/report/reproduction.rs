//! The page of the paper's validations run again.

use super::{Align, Chart, DrawingError, Mark, Page, Series, Table};
use crate::identify::reproduction::Section;

/// What the page shows.
#[derive(Clone, Debug)]
pub struct ReproductionReport<'a> {
    /// The validations.
    pub sections: &'a [Section],
}

impl ReproductionReport<'_> {
    /// The whole page.
    ///
    /// # Errors
    /// When a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let mut page = Page::new(
            "The paper's validations, run again",
            "Iterative identification of stiffness parameters in a car suspension elastokinematic model (Meissonnier and others, \
             2006): its tables beside ours.",
        );
        for section in self.sections {
            page.heading(&section.title);
            page.list(&section.findings);
            for comparison in &section.tables {
                page.paragraph(&comparison.title);
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
            for figure in &section.figures {
                let series = figure.curves.iter().enumerate().map(|(k, curve)| Series {
                    name: curve.name.clone(),
                    points: curve.points.clone(),
                    mark: if k < 2 { Mark::LinePoints } else { Mark::Line },
                });
                let chart = Chart {
                    title: figure.title.clone(),
                    x: figure.x.clone(),
                    y: figure.y.clone(),
                    series: series.collect(),
                    log_y: false,
                    level: None,
                };
                page.figure(&chart.svg()?, &figure.title);
            }
            page.paragraph("What cannot be compared:");
            page.list(&section.limits);
        }
        Ok(page.finish(&format!("admire {}", env!("CARGO_PKG_VERSION"))))
    }
}
