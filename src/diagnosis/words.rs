//! Diagnosis in sentences.

use super::channel_miss::ChannelMiss;
use super::diagnose::Outcome;
use super::diagnosis::LAW_MISFIT;
use super::fit::FittedModel;
use super::folds::Blind;
use super::hypothesis::Hypothesis;
use super::remainder::{Over, RemainderPoint};
use admire_identify::global::Row;
use admire_syntax::text::Decimals;

/// Significance of a stiffness bias, in combined standard errors, from which the report states it.
const NOTABLE: f64 = 2.0;

/// Deficit in nats within which the second-best site of the remainder is named as a rival.
const RIVAL_PLACE: f64 = 5.0;
/// Maximum number of failing tests listed.
const LISTED: usize = 6;

impl Outcome<'_> {
    /// Returns the diagnosis in sentences: errors of the model, causes and their probabilities, gain on cases that no fit used, bias of the
    /// stiffnesses, and remaining structure.
    pub fn sentences(&self) -> Vec<String> {
        let mut out = Vec::new();
        let (sigma, unit) = (
            self.subject.mark_sigma(),
            self.subject.problem.model.units.length.word,
        );
        let solver = self.diagnosis.solver.iter();
        out.extend(solver.map(|solver| solver.sentence(sigma, unit)));
        out.extend(self.worst_mark());
        out.extend(self.worst_angle());
        out.extend(self.channels().iter().map(ChannelMiss::sentence));
        out.extend(self.turned_part());
        out.extend(self.exactness());
        out.extend(self.probabilities());
        out.extend(self.left_by_laws());
        out.extend(self.gained());
        out.extend(self.cross_validated());
        out.extend(self.biases());
        if let Some(next) = &self.diagnosis.next_measurement {
            let loads = next
                .case
                .iter()
                .map(|(name, value)| (name.as_str(), *value));
            out.push(format!(
                "To measure next: {}; it {}.",
                loads_text(loads),
                next.why
            ));
        }
        let places = &self.diagnosis.unexplained.places;
        for place in places.iter().take(LISTED) {
            out.push(format!("What remains without a cause: {place}."));
        }
        if places.len() > LISTED {
            let more = places.len() - LISTED;
            out.push(format!("{more} more tests of structure fail."));
        }
        out.extend(self.remains());
        if self.is_stopped() {
            out.push("The search was interrupted. Further causes, and rivals of those found, were not looked for.".to_string());
        } else if self.cut_short {
            let sweeps = self.subject.sweeps();
            out.push(format!(
                "The search was ended by its budget: all load cases had been solved {sweeps} times. Further causes, and rivals of those found, were not looked for."
            ));
        }
        out
    }

    /// Names a case with its loads: `case 7 (vertical = 4500, longitudinal = -4000)`. Loads of zero are left out.
    fn case_text(&self, case: usize) -> String {
        let programme = self.subject.problem.programme;
        let of = &programme.cases[case];
        let loads = programme.loads.iter().map(|load| load.name.as_str());
        let loads = loads_text(loads.zip(of.values.iter().copied()));
        format!("case {} ({loads})", of.label)
    }

    /// Returns the number format for positions of marks.
    pub(super) fn decimals(&self) -> Decimals {
        Decimals::of_error(self.subject.mark_sigma())
    }

    /// Returns the number format for errors over the held-out cases.
    fn compared_decimals(&self) -> Decimals {
        match self.subject.compared() {
            ("mark", _) => self.decimals().finer(),
            (_, unit) => Decimals::of_error(unit).finer(),
        }
    }

    /// Returns true where the search was stopped by request, rather than ended by its budget.
    pub fn is_stopped(&self) -> bool {
        self.subject.progress().is_stopped()
    }

    fn findings_matter(&self) -> bool {
        let diagnosis = &self.diagnosis;
        diagnosis.unexplained.structured || diagnosis.findings.iter().any(|f| !f.minor)
    }

    /// Returns sentences on fitted laws that differ in detail from the true law, with the rms force difference.
    fn left_by_laws(&self) -> Vec<String> {
        let findings = self.diagnosis.findings.iter();
        let left = findings.filter_map(|finding| {
            let force = finding.parameters.get(LAW_MISFIT)?;
            Some(format!(
                "The law of {} {} is another one in detail: its force differs by {force:.3} rms from the one that was fitted.",
                finding.cause, finding.address
            ))
        });
        left.collect()
    }

    /// Returns a sentence on the rms error of the marks, and on the worst mark if findings matter.
    fn worst_mark(&self) -> Option<String> {
        let measurement = self.subject.problem.measurement;
        let residual = &self.baseline.residual;
        let (mut sum, mut count, mut worst) = (0.0, 0.0, (0.0, 0));
        for (k, row) in self.subject.rows.iter().enumerate() {
            let Row::Mark { axis, .. } = *row else {
                continue;
            };
            if self.subject.precision[k] == 0.0 {
                continue;
            }
            sum += residual[k].powi(2);
            count += 1.0;
            let size = residual.rows(k, 3 - axis).norm();
            if axis == 0 && size > worst.0 {
                worst = (size, k);
            }
        }
        if count == 0.0 {
            return None;
        }
        let unit = self.subject.sigma;
        let sigma = self.subject.mark_sigma();
        let rms = (sum / count).sqrt() * unit;
        let decimals = self.decimals();
        let mut text = format!(
            "After its best fit, tolerances included, the model misses the marks by {} rms per coordinate, where their noise is {}",
            decimals.told(rms),
            decimals.told(sigma)
        );
        if let (true, Row::Mark { case, reading, .. }) =
            (self.findings_matter(), self.subject.rows[worst.1])
        {
            let read = measurement.cases[case].marks[reading];
            let part = &measurement.parts[read.part];
            text += &format!(
                "; the worst is {} {} in {}, by {}",
                part.name,
                part.marks[read.mark].label,
                self.case_text(case),
                decimals.told(worst.0 * unit)
            );
        }
        Some(text + ".")
    }

    /// Returns sentences on the worst steer and camber error of the wheel, if above three standard deviations.
    fn worst_angle(&self) -> Vec<String> {
        let measurement = self.subject.problem.measurement;
        let Some(wheel) = &measurement.wheel else {
            return Vec::new();
        };
        let mut out = Vec::new();
        for (component, turn, more, less) in [
            (4, "turns the wheel", "too much", "too little"),
            (3, "leans the wheel", "too much", "too little"),
        ] {
            let rows = self.subject.rows.iter().enumerate();
            let worst = rows
                .filter(
                    |(_, row)| matches!(row, Row::Wheel { component: of, .. } if *of == component),
                )
                .map(|(k, row)| (self.baseline.residual[k], row.case()))
                .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
            let Some((residual, case)) = worst.filter(|(r, _)| r.abs() > 3.0) else {
                continue;
            };
            let Some(reading) = measurement.cases[case].wheel else {
                continue;
            };
            let read = [reading.camber_deg, reading.steer_deg][component - 3];
            let off = residual * wheel.sigma_angle_deg;
            let word = if off * read > 0.0 { more } else { less };
            out.push(format!(
                "The model {turn} {:.3} deg {word} in {}.",
                off.abs(),
                self.case_text(case)
            ));
        }
        out
    }

    /// Returns the rms error of each channel.
    pub fn channels(&self) -> Vec<ChannelMiss> {
        let measurement = self.subject.problem.measurement;
        let mut out = Vec::new();
        for (channel, info) in measurement.channels.iter().enumerate() {
            let rows = self.subject.rows.iter().enumerate().filter(
                |(_, row)| matches!(row, Row::Channel { channel: of, .. } if *of == channel),
            );
            let of = |fitted: &FittedModel| {
                let squares = rows.clone().map(|(k, _)| fitted.residual[k].powi(2));
                (squares.sum::<f64>() / rows.clone().count().max(1) as f64).sqrt() * info.sigma
            };
            if rows.clone().next().is_some() {
                out.push(ChannelMiss {
                    name: info.name.clone(),
                    behind: info.behind(),
                    before: of(&self.baseline),
                    after: of(&self.extended),
                    noise: info.sigma,
                });
            }
        }
        out
    }

    /// Returns a sentence on the part and case with the largest rotation between the original and the extended model.
    fn turned_part(&self) -> Option<String> {
        if !self.findings_matter() || self.subject.problem.measurement.wheel.is_some() {
            return None;
        }
        let mut worst = (0.0, 0, 0);
        for (case, (before, after)) in self
            .baseline
            .states
            .iter()
            .zip(&self.extended.states)
            .enumerate()
        {
            for part in &self.subject.problem.measurement.parts {
                let k = part.part.0;
                let turn = after.poses[k].R * before.poses[k].R.transpose();
                let angle = admire_solver::mechanics::log(&turn).norm().to_degrees();
                if angle > worst.0 {
                    worst = (angle, case, k);
                }
            }
        }
        let (angle, case, part) = worst;
        (angle > 1e-3).then(|| {
            let header = &self.subject.problem.model.parts[part].header;
            let name = if header.name.is_empty() {
                format!("PART/{}", header.id)
            } else {
                header.name.clone()
            };
            format!(
                "The model turns {name} {angle:.3} deg otherwise than the extended model does in {}.",
                self.case_text(case)
            )
        })
    }

    /// Returns sentences on the probability of each cause and of its rivals.
    fn probabilities(&self) -> Vec<String> {
        let findings = self.diagnosis.findings.iter();
        let acting = findings.filter(|f| !f.cause.is_told_by_marks());
        let mut out: Vec<String> = acting
            .map(|f| {
                let minor = if f.minor {
                    ", and its own effect is small"
                } else {
                    ""
                };
                let side = match f.form.as_deref() {
                    Some("point") => ", all parts that meet there together",
                    Some("part") => ", one side only",
                    _ => "",
                };
                let rivals = if f.indistinguishable_from.is_empty() {
                    String::new()
                } else {
                    let group = percent(f.group_probability);
                    format!("; that it or one of its rivals acts, {group}")
                };
                format!(
                    "The probability of {} at {}{side} is {}{minor}{rivals}.",
                    f.cause,
                    f.address,
                    percent(f.probability)
                )
            })
            .collect();
        if !out.is_empty() {
            out.push(
                "Places that are equivalent to those named were not all looked at.".to_string(),
            );
        }
        out.push(format!(
            "The probability that no cause of the catalogue acts is {}.",
            percent(self.diagnosis.none_of_these)
        ));
        out
    }

    /// Returns sentences on noise and tolerances as estimated from the readings.
    fn exactness(&self) -> Vec<String> {
        let mut out = Vec::new();
        let noise = &self.diagnosis.noise;
        if let (true, Some(declared), Some(estimated)) = (
            self.subject.declared_noise_rejected(),
            noise.declared,
            noise.estimated,
        ) {
            let decimals = self.decimals().finer();
            out.push(format!(
                "The study declares a noise of {} for the marks; marks of rigid parts show {}, which is used.",
                decimals.told(declared),
                decimals.told(estimated)
            ));
        }
        if let Some(dof) = noise.dof {
            out.push(format!(
                "The noise has heavy tails, like Student's t with {dof} degrees of freedom; far readings count less."
            ));
        }
        out.extend(self.misplaced_in_words());
        let count = self.subject.noise.outliers.len();
        if count > 0 {
            out.push(format!(
                "{count} readings of marks are plainly wrong and are left out."
            ));
        }
        out.extend(self.tolerances_in_words());
        out
    }

    fn gained(&self) -> Option<String> {
        if self.diagnosis.findings.is_empty() {
            return None;
        }
        let unseen = self.unseen.as_ref()?;
        let [before, after] = &unseen.tests;
        let decimals = self.decimals().finer();
        let mut parts = Vec::new();
        if let (Some(a), Some(b)) = (before.marks_rms, after.marks_rms) {
            let by = match &self.diagnosis.hold_out {
                Some(found) => format!(
                    " ({})",
                    fallen_by(decimals, found.gain, found.gain_std_error)
                ),
                None => String::new(),
            };
            parts.push(format!(
                "the rms of the marks goes from {} to {}{by}",
                decimals.told(a),
                decimals.told(b)
            ));
        }
        if let (Some([camber, steer]), Some([camber_after, steer_after])) =
            (before.wheel_deg_rms, after.wheel_deg_rms)
        {
            parts.push(format!(
                "camber from {camber:.4} to {camber_after:.4} deg, steer from {steer:.4} to {steer_after:.4} deg"
            ));
        }
        let held = match self.subject.cases_held_out().next() {
            Some(_) => "cases",
            None => "curves",
        };
        parts.extend(self.channels_gained());
        parts.push(format!(
            "chi-square per reading from {:.2} to {:.2} (p = {:.2})",
            before.chi_square / before.dof as f64,
            after.chi_square / after.dof as f64,
            after.p_value
        ));
        Some(format!(
            "On the {held} held out, with {} {} without them, {}.",
            chosen(&unseen.chosen.effects),
            if unseen.searched {
                "chosen and fitted"
            } else {
                "fitted (but not chosen)"
            },
            parts.join(", ")
        ))
    }

    /// Returns a sentence on the extra force that best describes the remaining structure.
    fn remains(&self) -> Option<String> {
        let found = self.diagnosis.unexplained.remainder.as_ref()?;
        let over = match (&found.load, found.over) {
            (Some(load), _) => format!("{load} changes"),
            (None, Over::Order) => "the cases follow each other".to_string(),
            (None, _) => "it deflects".to_string(),
        };
        let by_force = |a: &&RemainderPoint, b: &&RemainderPoint| a.force.total_cmp(&b.force);
        let least = found.points.iter().min_by(by_force)?;
        let most = found.points.iter().max_by(by_force)?;
        let at = |point: &RemainderPoint| {
            format!(
                "{:.3} +- {:.3} in case {}",
                point.force, point.std_error, point.case
            )
        };
        let rival = match &found.next {
            Some((address, behind)) if *behind < RIVAL_PLACE => {
                format!("; {address} does nearly as well")
            }
            _ => String::new(),
        };
        let decimals = self.compared_decimals();
        let predicts = found.held_out.as_ref().map_or_else(String::new, |held_out| {
            let place = if held_out.address == found.address {
                String::new()
            } else {
                format!(" (then at {})", held_out.address)
            };
            format!(
                " Found without the cases held out{place}, it predicts them to {} ({} without it); {:.0} percent of their readings lie within \
                 their 95 percent bands.",
                decimals.told(held_out.rms_after),
                decimals.told(held_out.rms_before),
                100.0 * held_out.within95
            )
        });
        Some(format!(
            "What remains is most like an extra force at {} that varies smoothly as {over}, from {} to {}: it takes up {:.0} percent of it{rival}.{predicts}",
            found.address,
            at(least),
            at(most),
            100.0 * found.share
        ))
    }

    /// Returns sentences on the prediction of groups of cases from the others.
    fn cross_validated(&self) -> Vec<String> {
        let Some(found) = &self.diagnosis.cross_validation else {
            return Vec::new();
        };
        let what = match found.of {
            "mark" => "the rms of the marks goes",
            _ => "the rms in units of the noise goes",
        };
        let decimals = self.compared_decimals();
        let mut out = vec![format!(
            "In {} groups of cases, each predicted from the others with the causes {}, {what} from {} to {} ({}).",
            found.groups.len(),
            if found.searched {
                "searched anew"
            } else {
                "chosen anew"
            },
            decimals.told(found.rms_before),
            decimals.told(found.rms_after),
            fallen_by(decimals, found.gain, found.gain_std_error)
        )];
        if let Some(groups) = found.spread() {
            let [least, most] = groups.map(|group| {
                format!(
                    "from {} to {} for {}",
                    decimals.told(group.rms_before),
                    decimals.told(group.rms_after),
                    labels(&group.cases)
                )
            });
            out.push(format!(
                "The gain depends on the cases that are held out: least {least}, most {most}."
            ));
        }
        out
    }

    /// Returns the change of the rms error of each channel in the held-out cases.
    fn channels_gained(&self) -> Vec<String> {
        let Some(unseen) = &self.unseen else {
            return Vec::new();
        };
        let [before, after] = &unseen.predicted;
        let channels = self.subject.problem.measurement.channels.iter();
        channels
            .enumerate()
            .filter_map(|(channel, info)| {
                let rows = self.subject.rows.iter().enumerate().filter(|(_, row)| {
                    matches!(row, Row::Channel { channel: of, .. } if *of == channel)
                        && self.subject.is_held_out_row(row)
                });
                let count = rows.clone().count();
                let rms = |blind: &Blind| {
                    let squares = rows.clone().map(|(k, _)| blind.misfit[k].powi(2));
                    (squares.sum::<f64>() / count as f64).sqrt() * info.sigma
                };
                (count > 0).then(|| {
                    let decimals = Decimals::of_error(info.sigma);
                    format!(
                        "{} from {} to {}{} rms",
                        info.name,
                        decimals.told(rms(before)),
                        decimals.told(rms(after)),
                        info.behind()
                    )
                })
            })
            .collect()
    }

    /// Returns a sentence on the three largest significant biases of stiffnesses in the original model.
    fn biases(&self) -> Option<String> {
        let mut biased: Vec<_> = self
            .stiffnesses
            .iter()
            .filter(|s| {
                s.is_identified()
                    && (s.before.0 - s.after.0).abs() > NOTABLE * libm::hypot(s.before.1, s.after.1)
            })
            .collect();
        biased.sort_by(|a, b| b.bias().abs().total_cmp(&a.bias().abs()));
        let listed: Vec<String> = biased
            .iter()
            .take(3)
            .map(|s| {
                let word = if s.bias() > 0.0 { "stiff" } else { "soft" };
                format!(
                    "{} {:.0} percent too {word}",
                    s.address,
                    100.0 * s.bias().abs()
                )
            })
            .collect();
        (!listed.is_empty()).then(|| format!("The wrong model had {}.", listed.join(", ")))
    }
}

/// Formats a gain with its standard error, which does not exist for a single case.
fn fallen_by(decimals: Decimals, gain: f64, std_error: f64) -> String {
    let gain = decimals.told(gain);
    if std_error.is_finite() {
        format!("by {gain} +- {}", decimals.told(std_error))
    } else {
        format!("by {gain}, in one case")
    }
}

/// Lists causes by name and site.
fn chosen(causes: &[Hypothesis]) -> String {
    let names: Vec<String> = Hypothesis::causes(causes)
        .map(ToString::to_string)
        .collect();
    match names.as_slice() {
        [] => "no cause".to_string(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Formats case labels: `case 7`, `8 cases from 1 to 8`, `cases 1, 4, 9`.
fn labels(cases: &[String]) -> String {
    match cases {
        [one] => format!("case {one}"),
        [first, .., last] if cases.len() > 6 => {
            format!("{} cases from {first} to {last}", cases.len())
        }
        _ => format!("cases {}", cases.join(", ")),
    }
}

/// Lists the non-zero loads as text.
fn loads_text<'a>(loads: impl Iterator<Item = (&'a str, f64)>) -> String {
    let listed: Vec<String> = loads
        .filter(|(_, value)| *value != 0.0)
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    if listed.is_empty() {
        "no load".to_string()
    } else {
        listed.join(", ")
    }
}

/// Formats a probability as a rounded percentage, with open ends below 1 and above 99 percent.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.0 => "above 99 percent".to_string(),
        p if p < 1.0 => "below 1 percent".to_string(),
        p => format!("{p:.0} percent"),
    }
}
