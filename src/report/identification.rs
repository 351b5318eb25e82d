//! Page that reports an identification.

use super::convergence::convergence;
use super::headline::{found_lines, strained};
use super::interval::IntervalScale;
use super::load_run;
use super::number::{counted, number, rounded, unbroken};
use super::parameter_name::form_of;
use super::repeats::repeats;
use super::scene::Role;
use super::short_unit;
use super::study_figures::StudyFigures;
use super::{Align, DrawingError, Page, Positions, Table, headline, study_scene};
use admire_identify::lack_of_fit::{is_structured, worst};
use admire_identify::{Fit, FitVerdict, LoadedStudy, ParameterFit, Status};
use admire_results::Timestamp;
use admire_syntax::text::Decimals;

/// Colour class of reference values; no model has this colour.
const REFERENCE: &str = "s6";

/// Report of an identification as an HTML page.
#[derive(Clone, Debug)]
pub struct IdentificationReport<'a> {
    /// Study that was identified.
    pub loaded: &'a LoadedStudy,
    /// Result of the fit.
    pub fit: &'a Fit,
    /// Changes from the deck to the identified deck, as a diff.
    pub diff: &'a str,
    /// Poses of the model with its initial and with its identified parameters, where equilibria were found.
    pub positions: &'a [Positions],
}

impl IdentificationReport<'_> {
    /// Returns the page as HTML text.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let title = self.loaded.dataset.title();
        let figures = StudyFigures {
            loaded: self.loaded,
            positions: self.positions,
        };
        let answer = headline::identification(self.loaded, self.fit);
        let mut page = Page::new("Identification", title.trim(), &answer);
        page.origin(&self.origin());
        let mut runs = figures.runs();
        let is_wheel = !runs.is_empty();
        if !is_wheel {
            runs = figures.marks();
        }
        page.meaning();
        page.figures(&load_run::figures(&load_run::telling(&runs))?);
        page.scene(&study_scene(self.loaded, self.positions));
        page.found(&found_lines(self.loaded, self.fit));
        page.table(&self.parameters());
        page.note("The bar is the 95 % interval on a logarithmic scale around the estimate; a diamond is the reference.");
        page.detail("Summary of the fit");
        page.paragraph(&lead(self.fit));
        page.note(
            "If the model is right, the intervals contain the true value in 95 of 100 repetitions of the measurement; `admire diagnose` tests the model. Not determined: the readings contain too little information about the parameter.",
        );
        self.tolerances(&mut page);
        repeats(&mut page, self.fit, &|parameter| self.named(parameter));
        page.detail("Errors before and after");
        self.quality(&mut page);
        page.figures(&figures.by_case()?.into_iter().collect::<Vec<_>>());
        if runs.len() > 2 && is_wheel {
            page.detail("Curves against each load");
            page.figures(&load_run::figures(&runs)?);
        }
        self.laws(&mut page, &figures)?;
        if !self.fit.unidentifiable_directions.is_empty() {
            page.detail("Combinations that the readings do not determine");
            page.table(&self.directions());
        }
        if !self.fit.assembly_offsets.is_empty() {
            page.detail("Assembly offsets");
            page.table(&self.offsets());
            page.note("Three displacements in the length unit of the deck and three angles in radians, in the axes of the J marker of the bushing, with standard errors.");
        }
        self.tests(&mut page);
        page.detail("Residuals by case and mark");
        for map in figures.maps() {
            page.add(&map);
        }
        page.detail("Convergence");
        let convergence = convergence(self.loaded, self.fit, |address| {
            self.element_and_number(address)
        })?;
        if !convergence.is_empty() {
            page.note("Each parameter at each iteration, divided by its reference, or by its final value if there is no reference.");
            page.figures(&convergence);
        }
        page.detail("Changes to the deck");
        page.verbatim(self.diff);
        Ok(page.finish(&format!("admire {}", super::VERSION)))
    }

    /// Tabulates the combinations of numbers that the readings do not determine.
    fn directions(&self) -> Table {
        let mut table = Table::new(&[
            ("parameters that can change together", Align::Wrap),
            ("by a factor of", Align::Right),
            ("sd of the logarithm", Align::Right),
        ]);
        for direction in &self.fit.unidentifiable_directions {
            let mut terms: Vec<_> = direction.combination.iter().collect();
            terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let text = terms.iter().map(|(name, weight)| {
                let way = if **weight > 0.0 { "up" } else { "down" };
                format!("{} {way} ({weight:+.2})", self.address_named(name))
            });
            let factor = libm::exp(direction.sd_log);
            table.row([
                text.collect::<Vec<_>>().join(", "),
                number(factor, Some(factor * 0.1)),
                format!("{:.2}", direction.sd_log),
            ]);
        }
        table
    }

    /// Tabulates the numbers with their intervals. A number that the readings do not determine has no value, only the bounds of its interval.
    fn parameters(&self) -> Table {
        let reference = self.loaded.reference_values();
        let known = reference.iter().any(Option::is_some);
        // A change has no ratio to another.
        let is_ratio = |parameter: &&ParameterFit| parameter.form != Some("change");
        let ratios = self.fit.parameters.iter().filter(is_ratio);
        let ratios = ratios.flat_map(|parameter| {
            let sides = parameter.interval95.into_iter().flatten();
            sides.map(move |side| side / parameter.value)
        });
        let scale = IntervalScale::over(ratios, Role::Identified.class());
        let picture = scale.ends();
        let mut columns = vec![
            ("parameter", Align::Left),
            ("unit", Align::Left),
            (Role::Given.name(), Align::Right),
            (Role::Identified.name(), Align::Right),
            ("95 % interval", Align::Right),
            (picture.as_str(), Align::Left),
        ];
        if known {
            columns.extend([
                ("reference", Align::Right),
                ("identified / reference", Align::Right),
            ]);
        }
        let mut table = Table::new(&columns);
        for (parameter, reference) in self.fit.parameters.iter().zip(reference) {
            let is_known = parameter.status != Status::Unidentifiable;
            let value = number(parameter.value, parameter.std_error);
            let mut cells = vec![
                self.named(parameter),
                unbroken(&short_unit(&parameter.unit)),
                number(parameter.initial, None),
                match parameter.status {
                    Status::Identified => value,
                    // The word used in the JSON file is too wide for a column.
                    Status::Unidentifiable => unbroken("not determined"),
                    Status::Bound => unbroken(&format!("{value}, at a bound")),
                },
                interval(parameter),
                String::new(),
            ];
            if known {
                cells.push(reference.map_or_else(String::new, |value| number(value, None)));
                let ratio = reference.filter(|_| is_known && is_ratio(&parameter));
                cells.push(ratio.map_or_else(String::new, |value| {
                    format!("{:.3}", parameter.value / value)
                }));
            }
            table.row(cells);
            let ratio = |value: Option<f64>| value.map(|value| value / parameter.value);
            let [low, high] = parameter.interval95;
            if is_known && is_ratio(&parameter) && (low.is_some() || high.is_some()) {
                let reference = ratio(reference).map(|at| (at, REFERENCE));
                let text = interval(parameter);
                table.picture(5, scale.svg(ratio(low), ratio(high), reference, &text));
            }
            if parameter.status != Status::Identified {
                table.mark(3, "soft");
            }
        }
        table
    }

    /// Returns the name of a parameter, with view names where the deck has them: `A (BUSHING/1.K.1) = A (BUSHING/1.K.2)`.
    fn named(&self, parameter: &ParameterFit) -> String {
        let names = std::iter::once(&parameter.address)
            .chain(&parameter.tied)
            .map(|address| self.address_named(address))
            .collect::<Vec<_>>();
        form_of(parameter.form, names.join(" = "))
    }

    fn address_named(&self, address: &str) -> String {
        match self.element_and_number(address) {
            (element, number) if number.is_empty() => element,
            (element, number) => match element.strip_suffix(')') {
                Some(open) => format!("{open}.{number})"),
                None => format!("{element}.{number}"),
            },
        }
    }

    /// Splits an address into the element and the parameter in it: `BUSHING/1.K.1` into `A (BUSHING/1)` and `K.1`.
    fn element_and_number(&self, address: &str) -> (String, String) {
        let (element, number) = address.split_once('.').unwrap_or((address, ""));
        let name = self.loaded.model.bushings.iter().find(|bushing| {
            element.strip_prefix("BUSHING/") == Some(bushing.header.id.to_string().as_str())
        });
        let element = name.map_or_else(
            || element.to_string(),
            |bushing| format!("{} ({element})", bushing.header.name),
        );
        (element, number.to_string())
    }

    /// Lists the origin of the page: study, deck, date, version, cases, units and inputs.
    fn origin(&self) -> Vec<(&'static str, String)> {
        let study = &self.loaded.study;
        let measurement = &self.loaded.measurement;
        let held = measurement
            .cases
            .iter()
            .filter(|case| case.held_out)
            .count();
        let units = &self.loaded.model.units;
        vec![
            ("Study", study.folder.display().to_string()),
            ("Deck", study.deck_path.display().to_string()),
            ("Date", format!("{} UTC", Timestamp::now().date_time())),
            (
                "Made by",
                format!(
                    "admire {}, solver: {}, method: {}",
                    super::VERSION,
                    self.fit.backend,
                    self.fit.method
                ),
            ),
            (
                "Cases",
                format!("{}, {held} of them held out", measurement.cases.len()),
            ),
            (
                "Units",
                format!(
                    "{}, {} and rad, as in the deck",
                    short_unit(units.force.word),
                    units.length.word
                ),
            ),
            ("Inputs", format!("SHA-256 {}", self.fit.inputs_sha256)),
        ]
    }

    /// Draws force over deflection of every bushing with an identified parameter.
    fn laws(&self, page: &mut Page, figures: &StudyFigures<'_>) -> Result<(), DrawingError> {
        let problem = self.loaded.problem();
        let (initial, values) = (problem.initial(), self.fit.values());
        let mut begun = false;
        for bushing in problem.bushings() {
            let stiffness = [&initial, &values].map(|values| problem.stiffnesses(bushing, values));
            let charts = figures.bushing(bushing, stiffness)?;
            if charts.is_empty() {
                continue;
            }
            if !begun {
                page.detail("Force against deflection");
                page.note(
                    "The lines are the laws before and after the fit. Each point is a load case: the deflection measured by the marks, and the force of the fitted model. Points off the line are noise or errors of the law.",
                );
                begun = true;
            }
            let header = &self.loaded.model.bushings[bushing].header;
            page.subheading(&format!("{} (BUSHING/{})", header.name, header.id));
            page.figures(&charts);
        }
        Ok(())
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
        let show = |value: Option<f64>| {
            value.map_or_else(String::new, |v| Decimals::of_error(v).finer().format(v))
        };
        let mut rows: Vec<(String, Option<f64>, Option<f64>)> = Vec::new();
        if let Some(written) = &self.fit.written {
            let name = "marks, rms per coordinate, deck alone".into();
            let (before, after) = (written.marks_rms_before, written.marks_rms_after);
            rows.push((name, Some(before), Some(after)));
        }
        if let Some(marks) = &self.fit.marks {
            let name = "marks, rms per coordinate, with the fitted tolerances";
            rows.push((name.into(), None, marks.rms));
            let name = "marks, chi-square per degree of freedom".into();
            rows.push((name, None, marks.chi2_per_dof));
        }
        let held = &self.fit.held_out;
        if !held.cases.is_empty() {
            let name = format!(
                "marks, rms per coordinate, held-out cases {}",
                held.cases.join(", ")
            );
            rows.push((name, held.marks_rms_before, held.marks_rms_after));
        }
        for curve in &held.curves {
            let unit = curve.unit.as_deref().map(|unit| format!(", {unit}"));
            let unit = unit.unwrap_or_default();
            let name = format!("held-out curve {}, rms{unit}", curve.name);
            rows.push((name, Some(curve.rms_before), Some(curve.rms_after)));
        }
        if let Some(wheel) = &self.fit.wheel {
            let (before, after) = (wheel.camber_deg_rms_before, wheel.camber_deg_rms_after);
            rows.push(("camber, rms, deg".into(), Some(before), Some(after)));
            let (before, after) = (wheel.steer_deg_rms_before, wheel.steer_deg_rms_after);
            rows.push(("steer, rms, deg".into(), Some(before), Some(after)));
        }
        // The column of the initial model is shown only if it contains values.
        let compared = rows.iter().any(|(_, before, _)| before.is_some());
        let mut columns = vec![("error", Align::Left)];
        if compared {
            columns.push((Role::Given.name(), Align::Right));
        }
        columns.push((Role::Identified.name(), Align::Right));
        let mut table = Table::new(&columns);
        for (name, before, after) in rows {
            let values = [show(before), show(after)];
            table.row(std::iter::once(name).chain(values.into_iter().skip(usize::from(!compared))));
        }
        page.table(&table);
    }
}

impl IdentificationReport<'_> {
    /// Adds a table of the tolerances that the intervals include.
    fn tolerances(&self, page: &mut Page) {
        if self.fit.tolerances.is_empty() {
            return;
        }
        page.detail("Tolerances included in the intervals");
        let mut table = Table::new(&[
            ("group", Align::Left),
            ("standard deviation", Align::Right),
            ("usual standard deviation", Align::Right),
            ("unit", Align::Left),
        ]);
        for (name, size) in &self.fit.tolerances {
            let [sd, usual] = [size.sd, size.usual].map(|value| rounded(value, 2));
            table.row([name.clone(), sd, usual, size.unit.to_string()]);
        }
        page.table(&table);
        page.note(
            "Estimated from the readings with the usual values as prior, or stated in `[tolerances]` of study.toml.",
        );
        let mut table = Table::new(&[
            ("parameter", Align::Left),
            ("share of the variance due to tolerances", Align::Right),
        ]);
        for parameter in &self.fit.parameters {
            if let Some(share) = parameter.tolerance_share {
                table.row([self.named(parameter), format!("{:.0} %", 100.0 * share)]);
            }
        }
        if self
            .fit
            .parameters
            .iter()
            .any(|p| p.tolerance_share.is_some())
        {
            page.table(&table);
        }
    }

    /// Adds a table of the residuals, and the tests that compare them with noise.
    fn tests(&self, page: &mut Page) {
        let Some(test) = &self.fit.fit_test else {
            return;
        };
        page.detail("Test of the residuals against noise");
        let mut table = Table::new(&[
            ("readings", Align::Left),
            ("count", Align::Right),
            ("rms residual / noise", Align::Right),
        ]);
        for kind in &test.readings {
            let rms = format!("{:.3}", kind.rms_over_sigma);
            table.row([kind.kind.clone(), kind.count.to_string(), rms]);
        }
        page.table(&table);
        page.note(&format!(
            "Chi-square is {:.1} with {:.1} degrees of freedom. Noise of the stated size gives this value or more with a probability of {}.",
            test.chi2,
            test.dof,
            probability(test.p_value)
        ));
        if self.fit.structure.is_empty() {
            return;
        }
        let mut table = Table::new(&[
            ("pattern tested in the residuals", Align::Wrap),
            ("probability from noise alone", Align::Right),
        ]);
        let mut tests: Vec<_> = self.fit.structure.iter().collect();
        tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        for test in tests.iter().take(12) {
            table.row([test.what.clone(), probability(test.p_value)]);
        }
        page.table(&table);
        page.note(&format!(
            "The smallest probabilities of {} tests. With noise alone, one of them is below {:.0e} in one study of a thousand.",
            tests.len(),
            1e-3 / tests.len() as f64
        ));
    }
}

/// Returns the result in a few sentences, with objections first.
pub fn lead(fit: &Fit) -> String {
    let of = |status: Status| {
        fit.parameters
            .iter()
            .filter(|parameter| parameter.status == status)
            .count()
    };
    let ending = if fit.converged {
        ""
    } else {
        ", without converging,"
    };
    let are = if of(Status::Identified) == 1 {
        "is"
    } else {
        "are"
    };
    let equilibria = if fit.solver_runs == 1 {
        "equilibrium"
    } else {
        "equilibria"
    };
    let found = format!(
        "{} of {} parameters {are} identified by {} after {}{ending} ({} {equilibria}).",
        of(Status::Identified),
        fit.parameters.len(),
        fit.method,
        counted(fit.iterations, "iteration"),
        fit.solver_runs,
    );
    let explained = explained(fit);
    let misfit = fit
        .fit_test
        .as_ref()
        .is_some_and(|test| test.verdict == FitVerdict::Misfit);
    let structured = worst(&fit.structure).filter(|_| is_structured(&fit.structure));
    let strained = strained(fit);
    let mut sentences = if let Some(strained) = strained {
        vec![strained, found]
    } else if misfit {
        vec![explained, found]
    } else if structured.is_some() {
        // Structure in the residuals is an objection even if chi-square is small.
        vec![found]
    } else {
        vec![found, explained]
    };
    if fit.interrupted {
        let interrupted = format!(
            "The fit was interrupted: {} of {} parameters are affected.",
            fit.affected.len(),
            fit.parameters.len()
        );
        sentences.insert(0, interrupted);
    }
    if let Some(worst) = structured {
        sentences.push(format!(
            "The residuals have structure, most clearly in \"{}\" (p = {}). Run `admire diagnose` to find the cause.",
            worst.what,
            probability(worst.p_value)
        ));
    } else if misfit || fit.tolerances.values().any(|size| size.strained) {
        sentences.push("Run `admire diagnose` to find what the model lacks.".to_string());
    }
    sentences.retain(|sentence| !sentence.is_empty());
    sentences.join(" ")
}

/// Describes the result of the goodness-of-fit test in words.
fn explained(fit: &Fit) -> String {
    let Some(test) = &fit.fit_test else {
        let rms = fit.marks.and_then(|marks| marks.rms);
        return rms.map_or_else(String::new, |rms| {
            format!("The rms error of the marks is then {rms:.2e}, in the length unit of the deck.")
        });
    };
    let (p, factor) = (probability(test.p_value), test.noise_factor());
    match test.verdict {
        FitVerdict::Misfit => format!(
            "The model does not explain the readings within their noise: chi-square is {:.0} with {:.0} degrees of freedom (p = {p}), as if the noise were {factor:.2} times the stated noise. Do not trust the intervals.",
            test.chi2, test.dof,
        ),
        FitVerdict::Noise => format!(
            "The model then explains the readings as well as their noise allows (chi-square {:.2} per degree of freedom, p = {p}).",
            test.chi2 / test.dof,
        ),
        FitVerdict::NoiseOverstated => format!(
            "The model then explains the readings better than their stated noise allows (chi-square {:.2} per degree of freedom): the noise is {factor:.2} times the stated noise, and the intervals are too wide.",
            test.chi2 / test.dof,
        ),
    }
}

/// Formats a p-value for the report.
fn probability(p: f64) -> String {
    if p < 1e-300 {
        "0".to_string()
    } else if p < 1e-3 {
        format!("{p:.0e}")
    } else {
        format!("{p:.3}")
    }
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

/// Returns the status of a parameter in words; empty for an identified parameter.
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
