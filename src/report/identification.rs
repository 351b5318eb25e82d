//! The page of an identification.

use super::{Align, Chart, DrawingError, Mark, Page, Series, Table};
use crate::identify::{Fit, LoadedStudy, ParameterFit, Status};

/// What the page shows beside the fit.
#[derive(Clone, Debug)]
pub struct IdentificationReport<'a> {
    /// The study.
    pub loaded: &'a LoadedStudy,
    /// The answer.
    pub fit: &'a Fit,
    /// The identified deck's edits as a diff.
    pub diff: &'a str,
}

impl IdentificationReport<'_> {
    /// The whole page.
    ///
    /// # Errors
    /// When a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let title = self.loaded.dataset.title();
        let mut page = Page::new(title.trim(), &lead(self.fit));
        if !self.fit.remarks.is_empty() {
            page.list(&self.fit.remarks);
        }
        page.heading("Stiffnesses");
        page.table(&self.parameters());
        page.note(
            "K in force per length, KT in torque per radian, as in the deck. Intervals hold the true value in 95 of 100 repetitions of \
             the measurement if the model is right; whether it is, says the diagnosis.",
        );
        if let Some(chart) = self.convergence() {
            page.heading("Convergence");
            page.figure(&chart.svg()?, "Every number over its reference (or over its final value), iteration by iteration.");
        }
        if !self.fit.unidentifiable_directions.is_empty() {
            page.heading("What the data do not tell apart");
            let mut table = Table::new(&[
                ("combination of ln K", Align::Wrap),
                ("standard deviation", Align::Right),
            ]);
            for direction in &self.fit.unidentifiable_directions {
                let mut terms: Vec<_> = direction.combination.iter().collect();
                terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
                let text: Vec<String> = terms
                    .iter()
                    .map(|(name, weight)| format!("{weight:+.2} {name}"))
                    .collect();
                table.row([text.join("  "), format!("{:.2}", direction.sd_log)]);
            }
            page.table(&table);
        }
        if !self.fit.assembly_offsets.is_empty() {
            page.heading("Assembly offsets");
            page.table(&self.offsets());
            page.note("Three lengths, three angles in radians, in the axes of each bushing's J marker; with their standard errors.");
        }
        self.quality(&mut page);
        page.heading("What changes in the deck");
        page.verbatim(self.diff);
        let made = format!(
            "admire {} · inputs sha256 {}",
            env!("CARGO_PKG_VERSION"),
            self.fit.inputs_sha256
        );
        Ok(page.finish(&made))
    }

    fn parameters(&self) -> Table {
        let reference = self.loaded.reference_values();
        let known = reference.iter().any(Option::is_some);
        let mut columns = vec![
            ("number", Align::Left),
            ("unit", Align::Left),
            ("initial", Align::Right),
            ("identified", Align::Right),
            ("95 % interval", Align::Right),
        ];
        if known {
            columns.extend([
                ("reference", Align::Right),
                ("identified / reference", Align::Right),
            ]);
        }
        columns.push(("", Align::Left));
        let mut table = Table::new(&columns);
        for (parameter, reference) in self.fit.parameters.iter().zip(reference) {
            let mut cells = vec![
                self.named(parameter),
                parameter.unit.clone(),
                number(parameter.initial, None),
                number(parameter.value, parameter.std_error),
                interval(parameter),
            ];
            if known {
                cells.push(reference.map_or_else(String::new, |value| number(value, None)));
                cells.push(reference.map_or_else(String::new, |value| {
                    format!("{:.3}", parameter.value / value)
                }));
            }
            cells.push(status(parameter.status).to_string());
            let last = cells.len() - 1;
            table.row(cells);
            if parameter.status != Status::Identified {
                table.mark(last, "bad");
            }
        }
        table
    }

    /// `A.K.1 = A.K.2` where the deck names its bushings.
    fn named(&self, parameter: &ParameterFit) -> String {
        let name = |address: &str| {
            let bushing = self.loaded.model.bushings.iter().find(|bushing| {
                address
                    .strip_prefix("BUSHING/")
                    .and_then(|rest| rest.split('.').next())
                    == Some(bushing.header.id.to_string().as_str())
            });
            match (bushing, address.split_once('.')) {
                (Some(bushing), Some((_, number))) => format!("{}.{number}", bushing.header.name),
                _ => address.to_string(),
            }
        };
        std::iter::once(&parameter.address)
            .chain(&parameter.tied)
            .map(|a| name(a))
            .collect::<Vec<_>>()
            .join(" = ")
    }

    /// Figure 7 of the paper.
    fn convergence(&self) -> Option<Chart> {
        if self.fit.history.len() < 2 {
            return None;
        }
        let reference = self.loaded.reference_values();
        let series = self
            .fit
            .parameters
            .iter()
            .enumerate()
            .map(|(k, parameter)| {
                let over = reference[k].unwrap_or(parameter.value);
                let points = self
                    .fit
                    .history
                    .iter()
                    .enumerate()
                    .map(|(i, values)| (i as f64, values[k] / over));
                Series {
                    name: self.named(parameter),
                    points: points.collect(),
                    mark: Mark::LinePoints,
                }
            })
            .collect();
        Some(Chart {
            title: "Convergence".to_string(),
            x: "iteration".to_string(),
            y: "K / K reference".to_string(),
            series,
            log_y: true,
            level: Some(1.0),
        })
    }

    fn offsets(&self) -> Table {
        let names = ["bushing", "x", "y", "z", "about x", "about y", "about z"];
        let columns: Vec<(&str, Align)> = names
            .into_iter()
            .enumerate()
            .map(|(k, name)| (name, if k == 0 { Align::Left } else { Align::Right }))
            .collect();
        let mut table = Table::new(&columns);
        for offset in &self.fit.assembly_offsets {
            let values =
                offset
                    .delta
                    .iter()
                    .zip(&offset.std_error)
                    .map(|(delta, error)| match error {
                        Some(error) => format!(
                            "{} ± {}",
                            number(*delta, Some(*error)),
                            number(*error, Some(*error))
                        ),
                        None => number(*delta, None),
                    });
            table.row(std::iter::once(offset.address.clone()).chain(values));
        }
        table
    }

    fn quality(&self, page: &mut Page) {
        page.heading("How well the measurement is explained");
        let show = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.4}"));
        let mut rows: Vec<(String, Option<f64>, Option<f64>)> = Vec::new();
        if let Some(marks) = &self.fit.marks {
            rows.push(("marks, rms of one coordinate".into(), None, marks.rms));
            let name = "marks, chi-square per degree of freedom".into();
            rows.push((name, None, marks.chi2_per_dof));
        }
        let held = &self.fit.held_out;
        if !held.cases.is_empty() {
            let name = format!("marks of the held-out cases {}", held.cases.join(", "));
            rows.push((name, held.marks_rms_before, held.marks_rms_after));
        }
        if let Some(wheel) = &self.fit.wheel {
            let (before, after) = (wheel.camber_deg_rms_before, wheel.camber_deg_rms_after);
            rows.push(("camber, rms, deg".into(), Some(before), Some(after)));
            let (before, after) = (wheel.steer_deg_rms_before, wheel.steer_deg_rms_after);
            rows.push(("steer, rms, deg".into(), Some(before), Some(after)));
        }
        // A column for the model as it was only where something is known of it.
        let compared = rows.iter().any(|(_, before, _)| before.is_some());
        let mut columns = vec![("", Align::Left)];
        if compared {
            columns.push(("before", Align::Right));
        }
        columns.push(("after", Align::Right));
        let mut table = Table::new(&columns);
        for (name, before, after) in rows {
            let values = [show(before), show(after)];
            table.row(std::iter::once(name).chain(values.into_iter().skip(usize::from(!compared))));
        }
        page.table(&table);
    }
}

/// The answer in two sentences.
pub fn lead(fit: &Fit) -> String {
    let of = |status: Status| {
        fit.parameters
            .iter()
            .filter(|parameter| parameter.status == status)
            .count()
    };
    let explained = fit.marks.map_or_else(String::new, |marks| match (marks.rms, marks.chi2_per_dof) {
        (Some(rms), Some(chi2)) => {
            let verdict = if chi2 < 1.3 { "as well as their noise allows" } else { "worse than their noise allows" };
            format!(" The model then explains the marks to {rms:.3} rms, {verdict} (chi-square {chi2:.2} per degree of freedom).")
        }
        (Some(rms), None) => format!(" The model then explains the marks to {rms:.2e} rms."),
        _ => String::new(),
    });
    let ending = if fit.converged {
        ""
    } else {
        " without converging"
    };
    format!(
        "{} of {} numbers are identified by {} after {} iterations{ending} ({} equilibria).{explained}",
        of(Status::Identified),
        fit.parameters.len(),
        fit.method,
        fit.iterations,
        fit.solver_runs,
    )
}

/// A value with no more digits than its standard error deserves: two digits of the error.
pub fn number(value: f64, std_error: Option<f64>) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = match std_error.filter(|error| *error > 0.0 && error.is_finite()) {
        Some(error) => (value.abs().log10().floor() - error.log10().floor() + 2.0).clamp(1.0, 8.0),
        None => 6.0,
    };
    rounded(value, digits as i32)
}

fn rounded(value: f64, digits: i32) -> String {
    let exponent = value.abs().log10().floor() as i32;
    let decimals = digits - 1 - exponent;
    if !(-5..=9).contains(&exponent) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    if decimals >= 0 {
        let text = format!("{value:.*}", decimals as usize);
        return if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text
        };
    }
    let unit = 10f64.powi(-decimals);
    format!("{:.0}", (value / unit).round() * unit)
}

fn interval(parameter: &ParameterFit) -> String {
    let [low, high] = parameter.interval95;
    if low.is_none() && high.is_none() {
        return String::new();
    }
    let show =
        |side: Option<f64>| side.map_or_else(|| "no bound".to_string(), |value| rounded(value, 3));
    let digits = |side: Option<f64>| {
        side.map_or_else(|| show(side), |value| number(value, parameter.std_error))
    };
    format!("{} … {}", digits(low), digits(high))
}

/// A word for a person.
pub fn status(status: Status) -> &'static str {
    match status {
        Status::Identified => "",
        Status::Unidentifiable => "unidentifiable",
        Status::Bound => "at a bound",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_the_digits_their_error_deserves() {
        assert_eq!(number(13_874.234, Some(31.0)), "13874");
        assert_eq!(number(13_874.234, Some(3_100.0)), "13900");
        assert_eq!(number(0.123_456, Some(0.001)), "0.1235");
        assert_eq!(number(10_000.0, None), "10000");
        assert_eq!(number(572_957.795_13, None), "572958");
        assert_eq!(number(1.5e-9, Some(1e-10)), "1.50e-9");
    }
}
