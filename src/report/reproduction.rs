//! Page of the paper's validations, repeated with this program.

use super::{Align, Chart, DrawingError, Figure, Mark, Page, Series, Table};
use admire_identify::reproduction::Section;
use admire_results::Timestamp;

/// Report of the repeated validations.
#[derive(Clone, Debug)]
pub struct ReproductionReport<'a> {
    /// Validations.
    pub sections: &'a [Section],
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
        let answer = |section: &Section| {
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
                figures.push(Figure::chart(&chart, "")?);
            }
            page.figures(&figures);
            page.subheading("What cannot be compared");
            page.list(&section.limits);
        }
        Ok(page.finish(&format!("admire {}", super::VERSION)))
    }
}
