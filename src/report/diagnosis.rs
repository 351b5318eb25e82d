use admire_diagnosis::{FittedModel, Outcome, Over, Remainder};
use admire_identify::global::Row;
use admire_syntax::text::Decimals;

use super::axis::axis_label;
use super::diagnosis_phrases::channel_sentence;
use super::diagnosis_tables::{groups, hold_out, missed, probability};
use super::diagnosis_text::diagnosis_sentences;
use super::diagnosis_view::{
    answer, both_models, diagnosis_scene, fit_in_words, found_lines, runs,
};
use super::interval::IntervalScale;
use super::limits;
use super::load_run;
use super::number::unbroken;
use super::parameter_name::form_of;
use super::ranking::{ranking, words};
use super::scene::Role;
use super::study_figures::{StudyFigures, load_axis};
use super::{
    Align, Chart, DrawingError, Figure, HeatMap, Page, Scene, Series, SeriesStyle, Table, number,
    short_unit,
};
use admire_identify::settings::NORMAL_QUANTILE_975;
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
fn remainder(found: &Remainder, loaded: &LoadedStudy) -> Chart {
    let units = &loaded.model.units;
    let (force, length) = (short_unit(units.force.word), units.length.word);
    let [deflection, force] = match found.address.split('.').nth(1) {
        Some("K") => [
            axis_label("deflection", length),
            axis_label("extra force", &force),
        ],
        Some("KT") => [
            axis_label("deflection", "rad"),
            axis_label("extra torque", &format!("{force} {length}")),
        ],
        // The free axis of a joint is that of a translation or of a rotation.
        _ => [
            "deflection, in units of the deck".to_string(),
            "extra force or torque, in units of the deck".to_string(),
        ],
    };
    let over = match (&found.load, found.over) {
        (Some(load), _) => load_axis(loaded, load),
        (None, Over::Order) => "case, in the order of application".to_string(),
        (None, _) => deflection,
    };
    let series = |name: &str, mark: SeriesStyle, errors: f64| {
        let points = found.points.iter();
        let points = points.map(|p| (p.coordinate, p.force + errors * p.std_error));
        Series::new(name, mark, points.collect())
    };
    Chart {
        title: format!(
            "Unexplained residual as an extra force at {}",
            found.address
        ),
        x: over,
        y: force,
        series: vec![
            series("extra force", SeriesStyle::LinePoints, 0.0),
            series("plus two standard errors", SeriesStyle::Dashed, 2.0),
            series("minus two standard errors", SeriesStyle::Dashed, -2.0),
        ],
        level: Some(0.0),
        ..Chart::default()
    }
}

impl DiagnosisReport<'_> {
    /// Returns the page as HTML text.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn html(&self) -> Result<String, DrawingError> {
        let diagnosis = &self.outcome.diagnosis;
        let models = both_models(self.loaded, self.outcome);
        let scene = diagnosis_scene(self.loaded, self.outcome, &models);
        let study = StudyFigures {
            loaded: self.loaded,
            positions: &models,
        };
        let title = self.loaded.dataset.title();
        let answer = answer(self.loaded, self.outcome, &scene);
        let mut page = Page::new("Diagnosis", title.trim(), &answer);
        page.origin(&[
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
        let mut runs = runs(self.loaded, self.outcome);
        if runs.is_empty() {
            runs = study.marks();
        }
        page.meaning();
        page.figures(&load_run::figures(&load_run::telling(&runs))?);
        page.scene(&scene);
        page.found(&found_lines(self.loaded, self.outcome, &scene));
        if !diagnosis.findings.is_empty() {
            self.causes(&mut page, &scene);
        }
        page.detail("Summary of the diagnosis");
        page.paragraph(&fit_in_words(self.outcome));
        let sentences = diagnosis_sentences(self.outcome).into_iter();
        // Several similar sentences are easier to read as a table.
        let channels = self.outcome.channels();
        let is_row = |text: &String| {
            channels.len() > 1 && channels.iter().any(|miss| channel_sentence(miss) == *text)
        };
        let sentences = sentences.filter(|text| !is_row(text));
        page.list(
            &sentences
                .map(|text| scene.naming(&text))
                .collect::<Vec<_>>(),
        );
        if channels.len() > 1 {
            page.detail("Errors of the channels");
            page.table(&missed(&channels));
        }
        if runs.len() > 2 {
            page.detail("Curves against each load");
            page.figures(&load_run::figures(&runs)?);
        }
        self.residuals(&mut page, &study)?;
        page.detail("Noise and tolerances");
        page.table(&self.tolerances());
        page.note(
            "Standard deviations. An effect is reported as a cause only if it is large for the standard deviation of its group.",
        );
        if !diagnosis.detection_limits.is_empty() {
            page.detail("Detection limits");
            page.table(&limits::of_points(diagnosis, &scene));
            page.note(
                "Smallest error of each hardpoint, in mm along each ground axis, that the diagnosis detects with a probability of 50 % in spite of the tolerances above. Empty: the readings cannot detect an error in this direction.",
            );
            page.table(&limits::of_causes(diagnosis, self.loaded, &scene));
            page.note(
                "Smallest size of each other cause that the diagnosis detects, to first order: at the place where it is easiest to detect, and at the place where it is hardest. The last column counts the places where it cannot be detected. diagnosis.json lists all places, couplings and higher-order terms.",
            );
        }
        page.detail("Tests for structure in the residuals");
        page.table(&self.structure());
        page.note(
            "Each test takes chi-square of one set of residuals, with their covariance. Where the worst of several sets is tested, p is corrected for their number.",
        );
        if !self.diff.is_empty() {
            page.detail("Changes to the deck");
            page.verbatim(self.diff);
        }
        Ok(page.finish(&format!("admire {}", super::VERSION)))
    }

    /// Adds the details of the causes: the table of the causes and their rivals, the errors in held-out cases, and the stiffnesses without and
    /// with the causes.
    fn causes(&self, page: &mut Page, scene: &Scene) {
        let diagnosis = &self.outcome.diagnosis;
        let length = self.loaded.model.units.length.word;
        page.detail("Causes and alternatives");
        page.table(&ranking(diagnosis, self.loaded, scene));
        page.note(
            "Each probability is that of the cause at this place, over all models that were examined. A cause after \"or\" explains the readings almost as well: it is at most twenty times less probable.",
        );
        page.detail("Error in the load cases held out");
        if let Some(found) = &diagnosis.hold_out {
            page.table(&hold_out(found, length, scene));
            page.note(if found.searched {
                "The causes were searched for again and fitted without these cases."
            } else {
                "The models were fitted without these cases, but the causes were chosen with them."
            });
        }
        page.table(&self.gains(scene));
        page.note("Both models were fitted again without the cases held out. The causes were chosen with them.");
        if let Some(found) = &diagnosis.cross_validation {
            page.table(&groups(found, length, scene));
            page.note(if found.searched {
                "Each row is a group of cases with similar loads. It is predicted by a model that was searched for and fitted in the other groups alone."
            } else {
                "Each row is a group of cases with similar loads. It is predicted by the model that fits the other groups best, among all models that were fitted."
            });
        }
        page.detail("Stiffnesses without and with the causes");
        page.table(&self.stiffnesses(scene));
        page.note(
            "The bar is the 95 % interval of the stiffness in the extended model, on a logarithmic scale around the estimate. The diamond is the estimate without the causes. Not determined: the standard error of one of the two estimates exceeds half of its value.",
        );
    }

    /// Adds the residuals: their rms in each case, the residual that correlates best with a force, the remainder as an extra force, and maps by
    /// case and mark.
    fn residuals(&self, page: &mut Page, study: &StudyFigures<'_>) -> Result<(), DrawingError> {
        page.detail("Residuals");
        let mut figures = vec![Figure::chart(
            &self.by_case(),
            "Rms of prediction minus reading in each case, divided by the standard deviation of the readings. A value of 1 is noise.",
        )?];
        figures.extend(study.by_case()?);
        if let Some(chart) = self.force() {
            figures.push(Figure::chart(
                &chart,
                "The residual that correlates best with a force, for the identified and the extended model.",
            )?);
        }
        if let Some(found) = &self.outcome.diagnosis.unexplained.remainder {
            figures.push(Figure::chart(
                &remainder(found, self.loaded),
                "Extra force at one place, fitted as a smooth function of one coordinate, with two standard errors. It reproduces most of the residual that no cause explains. It shows where to look and is not a force law.",
            )?);
        }
        page.figures(&figures);
        if self.outcome.baseline.states.len() <= MAPPED && self.marks() > 0 {
            for (role, map) in [
                (Role::Identified, self.map(false)),
                (Role::Extended, self.map(true)),
            ] {
                let caption = format!(
                    "Prediction minus reading of each mark in each case, {} model, in standard deviations of the noise; largest of the three coordinates.",
                    role.name()
                );
                page.add(&Figure::map(&map, &caption));
            }
        }
        Ok(())
    }

    fn marks(&self) -> usize {
        let measurement = self.outcome.subject.problem.measurement;
        measurement.parts.iter().map(|part| part.marks.len()).sum()
    }

    fn tolerances(&self) -> Table {
        let mut table = Table::new(&[
            ("group", Align::Left),
            ("sd, estimated", Align::Right),
            ("sd, usual or declared", Align::Right),
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
        let all = &self.outcome.corrected;
        let sides = |after: (f64, f64)| {
            [-1.0, 1.0].map(|side| 1.0 + side * NORMAL_QUANTILE_975 * after.1 / after.0)
        };
        let widest = all
            .iter()
            .filter(|found| found.is_identified() && !found.is_change)
            .flat_map(|found| {
                let [low, high] = sides(found.after);
                [low, high, found.before.0 / found.after.0]
            });
        let scale = IntervalScale::over(widest, Role::Extended.class());
        let picture = scale.ends();
        let mut table = Table::new(&[
            ("parameter", Align::Left),
            ("unit", Align::Left),
            ("identified model", Align::Right),
            ("extended model", Align::Right),
            (picture.as_str(), Align::Left),
            ("bias of identified model", Align::Right),
        ]);
        for own in all {
            let (before, after) = (own.before, own.after);
            let unit = unbroken(&short_unit(&own.unit));
            let shown = |(value, error): (f64, f64), is_identified: bool| {
                if !is_identified {
                    return unbroken("not determined");
                }
                format!(
                    "{} ± {}",
                    number(value, Some(error)),
                    number(error, Some(error))
                )
            };
            let text = shown(after, own.identified[1]);
            table.row([
                form_of(own.is_change.then_some("change"), scene.named(&own.address)),
                unit.clone(),
                shown(before, own.identified[0]),
                text.clone(),
                String::new(),
                if !own.is_identified() {
                    "not determined".to_string()
                } else if own.is_change {
                    format!("{} {unit}", number(own.bias(), Some(after.1)))
                } else {
                    format!("{:+.1} %", (1e3 * own.bias()).round() / 10.0 + 0.0)
                },
            ]);
            if !own.is_identified() {
                table.mark(5, "soft");
                continue;
            }
            if !own.is_change {
                let [low, high] = sides(after);
                let low = Some(low).filter(|low| *low > 0.0);
                let diamond = Some((before.0 / after.0, Role::Identified.class()));
                let picture = scale.svg(low, Some(high), diamond, &text);
                table.picture(4, picture);
            }
            if (before.0 - after.0).abs() > 2.0 * libm::hypot(before.1, after.1) {
                table.mark(5, "bad");
            }
        }
        table
    }

    /// Draws the rms residual of each case, by the identified and by the extended model.
    fn by_case(&self) -> Chart {
        let rows = &self.outcome.subject.rows;
        let series = |role: Role, fit: &FittedModel| {
            let mut sums = vec![(0.0, 0.0); fit.states.len()];
            for (k, row) in rows.iter().enumerate() {
                let sum = &mut sums[row.case()];
                sum.0 += fit.residual[k].powi(2);
                sum.1 += 1.0;
            }
            let points = sums.iter().enumerate().filter(|(_, sum)| sum.1 > 0.0);
            let points = points.map(|(k, sum)| ((k + 1) as f64, (sum.0 / sum.1).sqrt()));
            let mut series = Series::of(role, points.collect());
            if fit.states.len() > MAPPED {
                series.mark = SeriesStyle::Points;
            }
            series
        };
        Chart {
            title: "Residuals by case".to_string(),
            x: "case, in the order of application".to_string(),
            y: "rms residual / standard deviation".to_string(),
            series: vec![
                series(Role::Identified, &self.outcome.baseline),
                series(Role::Extended, &self.outcome.extended),
            ],
            level: Some(1.0),
            ..Chart::default()
        }
    }

    /// Draws the residual that follows an element force most closely, over that force. Returns `None` if no residual follows a force.
    fn force(&self) -> Option<Chart> {
        let trend = self.outcome.trend()?;
        let series = |role: Role, points: Vec<(f64, f64)>| Series {
            mark: SeriesStyle::Points,
            ..Series::of(role, points)
        };
        Some(Chart {
            title: format!(
                "Residual of {} against the force in {}",
                trend.what, trend.element
            ),
            x: axis_label(
                &format!("force in {}", trend.element),
                &short_unit(self.loaded.model.units.force.word),
            ),
            y: axis_label(
                &format!("mean residual of {}", trend.what),
                trend.unit.as_deref().unwrap_or_default(),
            ),
            series: vec![
                series(Role::Identified, trend.before),
                series(Role::Extended, trend.after),
            ],
            level: Some(0.0),
            ..Chart::default()
        })
    }

    /// Tabulates errors of prediction and fit without and with each finding.
    fn gains(&self, scene: &Scene) -> Table {
        let length = self.loaded.model.units.length.word;
        let (before, after) = (
            format!("rms error of marks without it, {length}"),
            format!("rms error of marks with it, {length}"),
        );
        let findings = &self.outcome.diagnosis.findings;
        let of_marks = findings
            .iter()
            .any(|f| f.gain.held_out_rms_before.is_some());
        let mut columns = vec![("cause", Align::Left)];
        if of_marks {
            columns.extend([
                (before.as_str(), Align::Right),
                (after.as_str(), Align::Right),
            ]);
        }
        columns.extend([
            ("chi-square per degree of freedom without it", Align::Right),
            ("chi-square per degree of freedom with it", Align::Right),
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
            ("residuals tested", Align::Left),
            ("chi-square, identified", Align::Right),
            ("degrees of freedom", Align::Right),
            ("p, identified", Align::Right),
            ("chi-square, extended", Align::Right),
            ("p, extended", Align::Right),
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
            title: format!(
                "Residuals, {}",
                if after {
                    Role::Extended
                } else {
                    Role::Identified
                }
                .name()
            ),
            rows: measurement
                .cases
                .iter()
                .map(|c| format!("case {}", c.label))
                .collect(),
            columns,
            values,
            limit: 6.0,
            what: "residual, standard deviations".to_string(),
        }
    }
}
