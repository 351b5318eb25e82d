use admire_diagnosis::{FittedModel, Outcome, Over, Remainder, Verdict};
use admire_identify::global::Row;
use admire_syntax::text::Decimals;

use super::chart::EXTENDED;
use super::diagnosis_phrases::{channel_sentence, next_text};
use super::diagnosis_tables::{groups, hold_out, missed, probability};
use super::diagnosis_text::diagnosis_sentences;
use super::diagnosis_view::{curves, diagnosis_scene, fit_in_words, headline};
use super::interval::IntervalScale;
use super::limits;
use super::number::unbroken;
use super::ranking::{ranking, words};
use super::scene::Role;
use super::{
    Align, Chart, DrawingError, Figure, HeatMap, Page, Scene, Series, SeriesStyle, Table, number,
    short_unit,
};
use admire_identify::settings::{NORMAL_QUANTILE_975, UNIDENTIFIABLE_LN_SD};
use admire_identify::{LackOfFitTest, LoadedStudy};
use admire_results::Timestamp;

/// Maximum number of cases for which a heat map is readable.
const MAPPED: usize = 60;

/// Report of a diagnosis as an HTML page.
pub struct DiagnosisReport<'a> {
    /// Study that was diagnosed.
    pub loaded: &'a LoadedStudy,
    /// Diagnosis, and the fitted models behind it.
    pub outcome: &'a Outcome<'a>,
    /// Changes from the deck to the extended deck, as a diff.
    pub diff: &'a str,
}

/// Draws the extra force that explains the remaining structure, over its coordinate.
fn remainder(found: &Remainder) -> Chart {
    let over = match (&found.load, found.over) {
        (Some(load), _) => load.clone(),
        (None, Over::Order) => "position in the order of the cases".to_string(),
        (None, _) => "deflection, units of the deck and radians".to_string(),
    };
    let series = |name: &str, mark: SeriesStyle, errors: f64| Series {
        name: name.to_string(),
        points: found
            .points
            .iter()
            .map(|p| (p.coordinate, p.force + errors * p.std_error))
            .collect(),
        mark,
    };
    Chart {
        title: format!("What remains, as a force at {}", found.address),
        x: over,
        y: "extra force or torque, units of the deck".to_string(),
        series: vec![
            series("extra force", SeriesStyle::LinePoints, 0.0),
            series("two standard errors above", SeriesStyle::Dashed, 2.0),
            series("two standard errors below", SeriesStyle::Dashed, -2.0),
        ],
        log_y: false,
        level: Some(0.0),
    }
}

impl DiagnosisReport<'_> {
    /// Returns the page as HTML text.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let diagnosis = &self.outcome.diagnosis;
        // Larger tolerances reduce any chi-square, so chi-square is shown only if the model explains the data.
        let lead = match diagnosis.verdict {
            Verdict::Consistent => format!(
                "The model explains the data to their noise and to tolerances of the size shown below, with a chi-square of {:.2} per degree \
                 of freedom.",
                diagnosis.baseline.chi2_per_dof
            ),
            Verdict::Discrepancy => "The model is wrong in what is listed below.".to_string(),
            Verdict::Unexplained => "Structure remains that no known cause explains.".to_string(),
        };
        let scene = diagnosis_scene(self.loaded, self.outcome);
        let title = format!("Diagnosis of {}", self.loaded.dataset.title().trim());
        let mut page = Page::new(&title, &headline(self.loaded, self.outcome, &scene));
        page.facts(&[
            ("Study", self.loaded.study.folder.display().to_string()),
            ("Deck", self.loaded.study.deck_path.display().to_string()),
            ("Date", format!("{} UTC", Timestamp::now().date_time())),
            (
                "Made by",
                format!("admire {}, built-in solver", super::VERSION),
            ),
            (
                "Inputs",
                format!("SHA-256 {}", self.loaded.study.inputs_sha256()),
            ),
        ]);
        page.paragraph(&format!("{lead} {}", fit_in_words(self.outcome)));
        let channels = self.outcome.channels();
        let mut sentences = diagnosis_sentences(self.outcome);
        if channels.len() > 1 {
            // Several similar sentences are easier to read as a table.
            sentences.retain(|text| channels.iter().all(|miss| channel_sentence(miss) != *text));
            page.table(&missed(&channels));
        }
        page.list(
            &sentences
                .iter()
                .map(|text| scene.naming(text))
                .collect::<Vec<_>>(),
        );
        if !diagnosis.findings.is_empty() {
            page.heading("Causes");
            page.table(&ranking(diagnosis, self.loaded, &scene));
            page.note(
                "Probabilities are those of the cause at its place, among all models looked at. Causes after \"or\" do as well on these \
                 readings, and are less probable by a factor of twenty at most.",
            );
            if let Some(next) = &diagnosis.next_measurement {
                page.paragraph(&format!(
                    "To measure next: {}.",
                    scene.naming(&next_text(next))
                ));
            }
            page.heading("Gain on load cases held out");
            if let Some(found) = &diagnosis.hold_out {
                page.table(&hold_out(
                    found,
                    self.loaded.model.units.length.word,
                    &scene,
                ));
                page.note(if found.searched {
                    "Neither the choice of causes nor the fits saw these cases: the whole search was done again without them."
                } else {
                    "The fits did not see these cases. The causes were chosen with them."
                });
            }
            page.table(&self.gains(&scene));
            page.note("Both models are refitted without the cases held out. The causes themselves were chosen with them.");
            if let Some(found) = &diagnosis.cross_validation {
                page.table(&groups(found, self.loaded.model.units.length.word, &scene));
                page.note(if found.searched {
                    "Each group of like loads predicted from the others, by a search of their own."
                } else {
                    "Each group of like loads predicted from the others, by the model that those choose among all that were fitted."
                });
            }
            page.heading("Stiffnesses without and with the causes");
            page.table(&self.stiffnesses(&scene));
            page.note(
                "The bar is the 95 percent interval with the cause in the model, on a logarithmic scale around its estimate; the diamond is what the \
                 model without the cause had. Not determined: one of the two is known to no better than half of itself.",
            );
        }
        page.heading("The mechanism");
        page.scene(&scene);
        let runs = curves(self.loaded, self.outcome)?;
        if !runs.is_empty() {
            page.heading("Curves of the rig");
            page.figures(&runs);
        }
        page.heading("Noise and tolerances");
        page.table(&self.tolerances());
        page.note(
            "Standard deviations that the readings ask for, as far as they see them, beside what is usual. A cause is a member of a group \
             that stands out of its group.",
        );
        if !diagnosis.detection_limits.is_empty() {
            page.heading("What cannot be seen");
            page.table(&limits::of_points(diagnosis, &scene));
            page.note(
                "How far off, in mm, a point of the car has to be along each axis of ground to be named with even odds among tolerances of \
                 the size above; empty where the readings do not see it.",
            );
            page.table(&limits::of_causes(diagnosis, self.loaded, &scene));
            page.note(
                "How large each other cause has to be, to first order, at the places where it is seen best and worst; and at how many places it is not seen. diagnosis.json lists all places, couplings and higher terms.",
            );
        }
        page.heading("Residuals");
        let mut figures = vec![Figure::of_roles(
            &self.by_case(),
            &[Role::Initial, Role::Extended],
            "Rms of prediction minus reading in each case, in standard deviations of the readings; one is noise.",
        )?];
        if let Some(chart) = self.force() {
            figures.push(Figure::chart(
                &chart,
                "The residual that follows a force most closely, before and after.",
            )?);
        }
        if let Some(found) = &diagnosis.unexplained.remainder {
            figures.push(Figure::chart(
                &remainder(found),
                "An extra force at one place, a smooth function of one coordinate, that takes up most of what no cause explains; with twice its \
                 standard error. It shows where to look and is no law.",
            )?);
        }
        page.figures(&figures);
        if self.outcome.baseline.states.len() <= MAPPED && self.marks() > 0 {
            for (title, map) in [("before", self.map(false)), ("after", self.map(true))] {
                let caption = format!(
                    "Largest coordinate of prediction minus reading {title} the extension, in sigmas: case by mark."
                );
                page.add(&Figure::map(&map, &caption));
            }
        }
        page.heading("Tests of structure");
        page.table(&self.structure());
        page.note(
            "Chi-square of what the fit leaves along the named directions, with the covariance that the fit leaves it; the worst of many \
             is corrected for their number.",
        );
        if !self.diff.is_empty() {
            page.heading("The extension");
            page.verbatim(self.diff);
        }
        Ok(page.finish("admire diagnose"))
    }

    fn marks(&self) -> usize {
        let measurement = self.outcome.subject.problem.measurement;
        measurement.parts.iter().map(|part| part.marks.len()).sum()
    }

    fn tolerances(&self) -> Table {
        let mut table = Table::new(&[
            ("what", Align::Left),
            ("found", Align::Right),
            ("usual or declared", Align::Right),
            ("unit", Align::Left),
        ]);
        let diagnosis = &self.outcome.diagnosis;
        let shown =
            |value: Option<f64>| value.map_or_else(String::new, |v| number(v, Some(v.abs() * 0.1)));
        if diagnosis.noise.estimated.is_some() || diagnosis.noise.declared.is_some() {
            table.row([
                "noise of marks".to_string(),
                shown(diagnosis.noise.estimated),
                shown(diagnosis.noise.declared),
                self.loaded.model.units.length.word.to_string(),
            ]);
        }
        for (name, size) in &diagnosis.tolerances {
            table.row([
                name.clone(),
                shown(Some(size.sd)),
                shown(Some(size.usual)),
                size.unit.to_string(),
            ]);
        }
        table
    }

    fn stiffnesses(&self, scene: &Scene) -> Table {
        let all = &self.outcome.stiffnesses;
        let sides = |after: (f64, f64)| {
            [-1.0, 1.0].map(|side| 1.0 + side * NORMAL_QUANTILE_975 * after.1 / after.0)
        };
        let widest = all
            .iter()
            .filter(|found| found.is_identified())
            .flat_map(|found| {
                let [low, high] = sides(found.after);
                [low, high, found.before.0 / found.after.0]
            });
        let scale = IntervalScale::over(widest).coloured(EXTENDED);
        let picture = scale.ends();
        let mut table = Table::new(&[
            ("number", Align::Left),
            ("unit", Align::Left),
            ("as the model was", Align::Right),
            ("as it is extended", Align::Right),
            (picture.as_str(), Align::Left),
            ("bias", Align::Right),
        ]);
        for stiffness in all {
            let (before, after) = (stiffness.before, stiffness.after);
            let shown = |(value, error): (f64, f64)| {
                if error > UNIDENTIFIABLE_LN_SD * value {
                    return unbroken("not determined");
                }
                format!(
                    "{} ± {}",
                    number(value, Some(error)),
                    number(error, Some(error))
                )
            };
            let unit = self
                .loaded
                .unknowns
                .iter()
                .find(|unknown| unknown.address.to_string() == stiffness.address)
                .map_or_else(String::new, |unknown| unbroken(&short_unit(&unknown.unit)));
            table.row([
                scene.named(&stiffness.address),
                unit,
                shown(before),
                shown(after),
                shown(after),
                if stiffness.is_identified() {
                    format!("{:+.1} %", (1e3 * stiffness.bias()).round() / 10.0 + 0.0)
                } else {
                    "not determined".to_string()
                },
            ]);
            if !stiffness.is_identified() {
                table.mark(5, "soft");
                continue;
            }
            let [low, high] = sides(after);
            let low = Some(low).filter(|low| *low > 0.0);
            let diamond = Some((before.0 / after.0, Role::Initial.colour()));
            let picture = scale.svg(low, Some(high), diamond, &shown(after));
            table.picture(4, picture);
            if (before.0 - after.0).abs() > 2.0 * libm::hypot(before.1, after.1) {
                table.mark(5, "bad");
            }
        }
        table
    }

    /// Draws the rms residual of each case, by the original and by the extended model.
    fn by_case(&self) -> Chart {
        let rows = &self.outcome.subject.rows;
        let series = |name: &str, fit: &FittedModel| {
            let mut sums = vec![(0.0, 0.0); fit.states.len()];
            for (k, row) in rows.iter().enumerate() {
                let sum = &mut sums[row.case()];
                sum.0 += fit.residual[k].powi(2);
                sum.1 += 1.0;
            }
            let points = sums.iter().enumerate().filter(|(_, sum)| sum.1 > 0.0);
            Series {
                name: name.to_string(),
                points: points
                    .map(|(k, sum)| ((k + 1) as f64, (sum.0 / sum.1).sqrt()))
                    .collect(),
                mark: if fit.states.len() > MAPPED {
                    SeriesStyle::Points
                } else {
                    SeriesStyle::LinePoints
                },
            }
        };
        Chart {
            title: "Residuals by case".to_string(),
            x: "case, in the order of application".to_string(),
            y: "rms residual, sigmas".to_string(),
            series: vec![
                series("as the model was", &self.outcome.baseline),
                series("as it is extended", &self.outcome.extended),
            ],
            log_y: false,
            level: Some(1.0),
        }
    }

    /// Draws the residual that follows an element force most closely, over that force. Returns `None` if no residual follows a force.
    fn force(&self) -> Option<Chart> {
        let trend = self.outcome.trend()?;
        let series = |name: &str, points: Vec<(f64, f64)>| Series {
            name: name.to_string(),
            points,
            mark: SeriesStyle::Points,
        };
        Some(Chart {
            title: format!(
                "Residual of {} against the force in {}",
                trend.what, trend.element
            ),
            x: format!(
                "force in {}, {}",
                trend.element,
                short_unit(self.loaded.model.units.force.word)
            ),
            y: match &trend.unit {
                Some(unit) => format!("mean residual, {}, {unit}", trend.what),
                None => format!("mean residual, {}", trend.what),
            },
            series: vec![
                series("as the model was", trend.before),
                series("as it is extended", trend.after),
            ],
            log_y: false,
            level: Some(0.0),
        })
    }

    /// Tabulates errors of prediction and fit without and with each finding.
    fn gains(&self, scene: &Scene) -> Table {
        let length = self.loaded.model.units.length.word;
        let (before, after) = (
            format!("error without it, {length}"),
            format!("with it, {length}"),
        );
        let findings = &self.outcome.diagnosis.findings;
        let of_marks = findings
            .iter()
            .any(|f| f.gain.held_out_rms_before.is_some());
        let mut columns = vec![("finding", Align::Left)];
        if of_marks {
            columns.extend([
                (before.as_str(), Align::Right),
                (after.as_str(), Align::Right),
            ]);
        }
        columns.extend([
            ("chi-square per degree of freedom without", Align::Right),
            ("with", Align::Right),
        ]);
        let mut table = Table::new(&columns);
        let rms = |value: Option<f64>| {
            value.map_or_else(String::new, |v| Decimals::of_error(v).finer().format(v))
        };
        for finding in findings {
            let gain = &finding.gain;
            let place = scene.named(&finding.address);
            let mut row = vec![format!("{}, {place}", words(finding.cause))];
            if of_marks {
                row.extend([gain.held_out_rms_before, gain.held_out_rms_after].map(rms));
            }
            row.extend([
                format!("{:.2}", gain.chi2_per_dof_before),
                format!("{:.2}", gain.chi2_per_dof_after),
            ]);
            table.row(row);
        }
        table
    }

    fn structure(&self) -> Table {
        let mut table = Table::new(&[
            ("where", Align::Left),
            ("chi-square before", Align::Right),
            ("dof", Align::Right),
            ("p before", Align::Right),
            ("chi-square after", Align::Right),
            ("p after", Align::Right),
        ]);
        let [before, after] = &self.outcome.structure;
        for test in before.iter().take(16) {
            // The most significant tests of the extended model may differ from those of the original model.
            let later = after.iter().find(|other| other.what == test.what);
            let value = |test: &LackOfFitTest| test.statistic.map(|s| format!("{:.1}", s.value));
            let dof = test.statistic.map(|statistic| statistic.dof.to_string());
            table.row([
                test.what.clone(),
                value(test).unwrap_or_default(),
                dof.unwrap_or_default(),
                probability(test.p_value),
                later.and_then(value).unwrap_or_default(),
                later.map_or_else(String::new, |test| probability(test.p_value)),
            ]);
        }
        table
    }

    /// Draws a heat map of the residuals by case and mark: of the extended model if `after` is set, otherwise of the original model.
    fn map(&self, after: bool) -> HeatMap {
        let outcome = self.outcome;
        let fitted = if after {
            &outcome.extended
        } else {
            &outcome.baseline
        };
        let measurement = outcome.subject.problem.measurement;
        let mut columns = Vec::new();
        let mut first = Vec::new();
        for part in &measurement.parts {
            first.push(columns.len());
            columns.extend(
                part.marks
                    .iter()
                    .map(|m| format!("{} {}", part.name, m.label)),
            );
        }
        let mut values = vec![vec![None; columns.len()]; measurement.cases.len()];
        for (k, row) in outcome.subject.rows.iter().enumerate() {
            let Row::Mark { case, reading, .. } = *row else {
                continue;
            };
            let read = measurement.cases[case].marks[reading];
            let value = fitted.residual[k];
            let cell: &mut Option<f64> = &mut values[case][first[read.part] + read.mark];
            if cell.is_none_or(|old| old.abs() < value.abs()) {
                *cell = Some(value);
            }
        }
        HeatMap {
            title: format!("Residuals {}", if after { "after" } else { "before" }),
            rows: measurement
                .cases
                .iter()
                .map(|c| format!("case {}", c.label))
                .collect(),
            columns,
            values,
            limit: 6.0,
            what: "residual, sigmas".to_string(),
        }
    }
}
