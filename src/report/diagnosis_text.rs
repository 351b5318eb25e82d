//! Sentences of a diagnosis in the report.

use admire_diagnosis::{HoldOutPrediction, LAW_MISFIT, Outcome, Over, RemainderPoint};
use admire_identify::global::Row;
use admire_syntax::text::Decimals;
use admire_syntax::units::short_unit;

use super::diagnosis_phrases::{
    channel_sentence, chosen, fallen_by, labels, loads_text, next_text, percent, solver_sentence,
};
use super::ranking::is_rotation;

/// Bias of a stiffness, in standard errors, above which a sentence states it.
const NOTABLE_BIAS_SD: f64 = 2.0;
/// Largest deficit of the second-best site of the extra force, in nats, at which that site is named.
const RIVAL_PLACE_NATS: f64 = 5.0;
/// Maximum number of failed tests of structure that are listed.
const LISTED_TESTS: usize = 6;

/// Returns the sentences of a diagnosis. They state the misfit of the model and its place, the causes that explain it, and the gain on held-out
/// cases. They also state the bias of the stiffnesses in the wrong model, and the structure that remains unexplained.
pub fn diagnosis_sentences(outcome: &Outcome<'_>) -> Vec<String> {
    Text { outcome }.sentences()
}

/// Rms errors of a channel in the readings held out, without and with the causes.
pub(super) struct ChannelGain {
    /// Name of the channel.
    pub(super) name: String,
    /// Unit of the channel with a leading blank; empty if the channel has no unit.
    pub(super) behind: String,
    /// Standard deviation of the noise of one reading.
    pub(super) sigma: f64,
    /// Rms errors without causes and with the chosen causes, in the unit of the channel.
    pub(super) rms: [f64; 2],
}

/// Writer of the sentences of one diagnosis.
pub(super) struct Text<'a> {
    pub(super) outcome: &'a Outcome<'a>,
}

impl Text<'_> {
    fn sentences(&self) -> Vec<String> {
        let mut out = Vec::new();
        let (sigma, unit) = (self.outcome.subject.mark_sigma(), self.length());
        let solver = self.outcome.diagnosis.solver.iter();
        out.extend(solver.map(|solver| solver_sentence(solver, sigma, unit)));
        out.extend(self.worst_mark());
        out.extend(self.worst_angle());
        out.extend(self.outcome.channels().iter().map(channel_sentence));
        out.extend(self.turned_part());
        out.extend(self.exactness());
        out.extend(self.probabilities());
        out.extend(self.left_by_laws());
        out.extend(self.gained());
        out.extend(self.cross_validated());
        out.extend(self.biases());
        if let Some(next) = &self.outcome.diagnosis.next_measurement {
            out.push(format!("Next measurement: {}.", next_text(next)));
        }
        let places = &self.outcome.diagnosis.unexplained.places;
        for place in places.iter().take(LISTED_TESTS) {
            out.push(format!("Unexplained structure in the residuals: {place}."));
        }
        if places.len() > LISTED_TESTS {
            let more = places.len() - LISTED_TESTS;
            let tests = if more == 1 {
                "test of the residuals fails"
            } else {
                "tests of the residuals fail"
            };
            out.push(format!("{more} more {tests}."));
        }
        out.extend(self.remains());
        if self.outcome.is_stopped() {
            out.push("The search was interrupted. Further causes and alternatives to those found may exist.".to_string());
        } else if self.outcome.is_late {
            out.push("The search was stopped by the time limit `--budget`. Further causes and alternatives to those found may exist.".to_string());
        } else if self.outcome.cut_short {
            let sweeps = self.outcome.subject.sweeps();
            out.push(format!(
                "The search was stopped by its limit: all load cases had been solved {sweeps} times. Further causes and alternatives to those found may exist."
            ));
        }
        out
    }

    /// Returns the name of a case with its loads: `case 7 (vertical = 4500, longitudinal = -4000)`. Loads of zero are left out.
    fn case_text(&self, case: usize) -> String {
        let programme = self.outcome.subject.problem.programme;
        let of = &programme.cases[case];
        let loads = programme.loads.iter().map(|load| load.name.as_str());
        let loads = loads_text(loads.zip(of.values.iter().copied()));
        format!("case {} ({loads})", of.label)
    }

    /// Returns the length unit of the deck.
    pub(super) fn length(&self) -> &'static str {
        self.outcome.subject.problem.model.units.length.word
    }

    /// Returns the number format for mark positions.
    pub(super) fn decimals(&self) -> Decimals {
        Decimals::of_error(self.outcome.subject.mark_sigma())
    }

    /// Returns the number format for errors over the held-out cases.
    pub(super) fn compared_decimals(&self) -> Decimals {
        match self.outcome.subject.compared() {
            ("mark", _) => self.decimals().finer(),
            (_, unit) => Decimals::of_error(unit).finer(),
        }
    }

    fn findings_matter(&self) -> bool {
        let diagnosis = &self.outcome.diagnosis;
        diagnosis.unexplained.structured || diagnosis.findings.iter().any(|f| !f.minor)
    }

    /// Returns sentences about fitted force laws that differ in detail from the true law, with the rms difference of the force.
    fn left_by_laws(&self) -> Vec<String> {
        let findings = self.outcome.diagnosis.findings.iter();
        let left = findings.filter_map(|finding| {
            let force = finding.parameters.get(LAW_MISFIT)?;
            let units = &self.outcome.subject.problem.model.units;
            let force_unit = short_unit(units.force.word);
            let unit = if is_rotation(&finding.address) {
                format!(" {force_unit} {}", units.length.word)
            } else {
                format!(" {force_unit}")
            };
            Some(format!(
                "The fitted law of {} at {} is not exact: the force in the load cases deviates from the law by {force:.3}{unit} rms.",
                finding.cause, finding.address
            ))
        });
        left.collect()
    }

    /// Returns a sentence about the rms error of the marks. After a major finding or with unexplained structure, it also names the mark with the
    /// largest error.
    fn worst_mark(&self) -> Option<String> {
        let measurement = self.outcome.subject.problem.measurement;
        let residual = &self.outcome.baseline.residual;
        let (mut sum, mut count, mut worst) = (0.0, 0.0, (0.0, 0));
        for (k, row) in self.outcome.subject.rows.iter().enumerate() {
            let Row::Mark { axis, .. } = *row else {
                continue;
            };
            if self.outcome.subject.precision[k] == 0.0 {
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
        let unit = self.outcome.subject.sigma;
        let sigma = self.outcome.subject.mark_sigma();
        let rms = (sum / count).sqrt() * unit;
        let (decimals, length) = (self.decimals(), self.length());
        let mut text = format!(
            "After the best fit, tolerances included, the rms error of the marks is {} {length} per coordinate; their noise is {} {length}",
            decimals.format(rms),
            decimals.format(sigma)
        );
        if let (true, Row::Mark { case, reading, .. }) =
            (self.findings_matter(), self.outcome.subject.rows[worst.1])
        {
            let read = measurement.cases[case].marks[reading];
            let part = &measurement.parts[read.part];
            text += &format!(
                "; the largest error is that of mark {1} of {0} in {2}, {3} {length}",
                part.name,
                part.marks[read.mark].label,
                self.case_text(case),
                decimals.format(worst.0 * unit)
            );
        }
        Some(text + ".")
    }

    /// Returns sentences about the largest steer error and the largest camber error of the wheel, if above three standard deviations.
    fn worst_angle(&self) -> Vec<String> {
        let measurement = self.outcome.subject.problem.measurement;
        let Some(wheel) = &measurement.wheel else {
            return Vec::new();
        };
        let mut out = Vec::new();
        for (component, turn, more, less) in [
            (4, "steers the wheel", "too much", "too little"),
            (3, "cambers the wheel", "too much", "too little"),
        ] {
            let rows = self.outcome.subject.rows.iter().enumerate();
            let worst = rows
                .filter(
                    |(_, row)| matches!(row, Row::Wheel { component: of, .. } if *of == component),
                )
                .map(|(k, row)| (self.outcome.baseline.residual[k], row.case()))
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

    /// Returns a sentence about the part and the case with the largest rotation between the original and the extended model.
    fn turned_part(&self) -> Option<String> {
        if !self.findings_matter() || self.outcome.subject.problem.measurement.wheel.is_some() {
            return None;
        }
        let mut worst = (0.0, 0, 0);
        for (case, (before, after)) in self
            .outcome
            .baseline
            .states
            .iter()
            .zip(&self.outcome.extended.states)
            .enumerate()
        {
            for part in &self.outcome.subject.problem.measurement.parts {
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
            let header = &self.outcome.subject.problem.model.parts[part].header;
            let name = if header.name.is_empty() {
                format!("PART/{}", header.id)
            } else {
                header.name.clone()
            };
            format!(
                "The orientation of {name} differs by {angle:.3} deg between the identified and the extended model in {}.",
                self.case_text(case)
            )
        })
    }

    /// Returns sentences about the probability of each cause and of its rivals.
    fn probabilities(&self) -> Vec<String> {
        let findings = self.outcome.diagnosis.findings.iter();
        let acting = findings.filter(|f| !f.cause.is_told_by_marks());
        let mut out: Vec<String> = acting
            .map(|f| {
                let minor = if f.minor {
                    ", and its effect is small"
                } else {
                    ""
                };
                let side = match f.form.as_deref() {
                    Some("point") => " (moved on all parts that meet there)",
                    Some("part") => " (moved on one part only)",
                    _ => "",
                };
                let rivals = if f.indistinguishable_from.is_empty() {
                    String::new()
                } else {
                    let group = percent(f.group_probability);
                    format!("; with its alternatives, it is {group}")
                };
                format!(
                    "The probability of {} at {}{side} is {}{minor}{rivals}.",
                    f.cause,
                    f.address,
                    percent(f.probability)
                )
            })
            .collect();
        out.push(format!(
            "The probability that no cause of the catalogue acts is {}.",
            percent(self.outcome.diagnosis.none_of_these)
        ));
        out
    }

    /// Returns sentences about noise and tolerances as estimated from the readings.
    fn exactness(&self) -> Vec<String> {
        let mut out = Vec::new();
        let noise = &self.outcome.diagnosis.noise;
        if let (true, Some(declared), Some(estimated)) = (
            self.outcome.subject.declared_noise_rejected(),
            noise.declared,
            noise.estimated,
        ) {
            let (decimals, length) = (self.decimals().finer(), self.length());
            out.push(format!(
                "The study declares a noise of {} {length} for the marks, but marks on the same rigid part scatter by {} {length}; the scatter is used.",
                decimals.format(declared),
                decimals.format(estimated)
            ));
        }
        if let Some(dof) = noise.dof {
            out.push(format!(
                "The noise has heavy tails, like Student's t with {dof} degrees of freedom; outlying readings have less weight."
            ));
        }
        out.extend(self.misplaced_in_words());
        let count = self.outcome.subject.noise.outliers.len();
        if count > 0 {
            let readings = if count == 1 {
                "1 reading of a mark is an outlier and is left out".to_string()
            } else {
                format!("{count} readings of marks are outliers and are left out")
            };
            out.push(format!("{readings}."));
        }
        out.extend(self.tolerances_in_words());
        out
    }

    fn gained(&self) -> Option<String> {
        if self.outcome.diagnosis.findings.is_empty() {
            return None;
        }
        let unseen = self.outcome.unseen.as_ref()?;
        let [before, after] = &unseen.tests;
        let decimals = self.decimals().finer();
        let mut parts = Vec::new();
        if let (Some(a), Some(b)) = (before.marks_rms, after.marks_rms) {
            let by = match &self.outcome.diagnosis.hold_out {
                Some(found) => format!(
                    " ({})",
                    fallen_by(decimals, found.gain, found.gain_std_error)
                ),
                None => String::new(),
            };
            parts.push(format!(
                "the rms error of the marks goes from {} to {} {}{by}",
                decimals.format(a),
                decimals.format(b),
                self.length()
            ));
        }
        if let (Some([camber, steer]), Some([camber_after, steer_after])) =
            (before.wheel_deg_rms, after.wheel_deg_rms)
        {
            parts.push(format!(
                "the rms error of camber from {camber:.4} to {camber_after:.4} deg and of steer from {steer:.4} to {steer_after:.4} deg"
            ));
        }
        let held = match self.outcome.subject.cases_held_out().next() {
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
            "In the {held} held out, with {} {} without these {held}, {}.",
            chosen(&unseen.chosen.effects),
            if unseen.searched {
                "chosen and fitted"
            } else {
                "fitted (but not chosen)"
            },
            parts.join(", ")
        ))
    }

    /// Returns a sentence about the extra force that best describes the remaining structure.
    fn remains(&self) -> Option<String> {
        let found = self.outcome.diagnosis.unexplained.remainder.as_ref()?;
        let over = match (&found.load, found.over) {
            (Some(load), _) => format!("the load {load}"),
            (None, Over::Order) => "the order of the cases".to_string(),
            (None, _) => "the deflection there".to_string(),
        };
        let units = &self.outcome.subject.problem.model.units;
        let force = short_unit(units.force.word);
        let (what, measure, of_deck) = match found.address.split('.').nth(1) {
            Some("K") => ("force", format!(" {force}"), ""),
            Some("KT") => ("torque", format!(" {force} {}", units.length.word), ""),
            // The free axis of a joint is that of a translation or of a rotation.
            _ => ("force or torque", String::new(), ", in units of the deck"),
        };
        let by_force = |a: &&RemainderPoint, b: &&RemainderPoint| a.force.total_cmp(&b.force);
        let least = found.points.iter().min_by(by_force)?;
        let most = found.points.iter().max_by(by_force)?;
        let at = |point: &RemainderPoint| {
            format!(
                "{:.3} ± {:.3}{measure} in case {}",
                point.force, point.std_error, point.case
            )
        };
        let rival = match &found.next {
            Some((address, behind)) if *behind < RIVAL_PLACE_NATS => {
                format!("; one at {address} explains nearly as much")
            }
            _ => String::new(),
        };
        let decimals = self.compared_decimals();
        let unit = match self.outcome.subject.compared().0 {
            "mark" => format!(" {}", self.length()),
            _ => " sigmas".to_string(),
        };
        let predicts = found.held_out.as_ref().map_or_else(String::new, |held_out| {
            let place = if held_out.address == found.address {
                String::new()
            } else {
                format!(" (it is then at {})", held_out.address)
            };
            format!(
                " With the force found without the cases held out{place}, the rms error in these cases is {}{unit} ({}{unit} without the force); {:.0} % of the readings lie within their 95 % bands.",
                decimals.format(held_out.rms_after),
                decimals.format(held_out.rms_before),
                100.0 * held_out.within95
            )
        });
        Some(format!(
            "The remaining residuals look most like an extra {what} at {} that varies smoothly with {over}, from {} to {}{of_deck}: it explains {:.0} % of the unexplained chi-square{rival}.{predicts}",
            found.address,
            at(least),
            at(most),
            100.0 * found.share
        ))
    }

    /// Returns sentences about the prediction of groups of cases from the other groups.
    fn cross_validated(&self) -> Vec<String> {
        let Some(found) = &self.outcome.diagnosis.cross_validation else {
            return Vec::new();
        };
        let what = match found.of {
            "mark" => "the rms error of the marks goes",
            _ => "the rms error of the readings goes",
        };
        let unit = match found.of {
            "mark" => self.length(),
            _ => "sigmas",
        };
        let decimals = self.compared_decimals();
        let mut out = vec![format!(
            "In {} groups of cases, each predicted from the others with the causes {}, {what} from {} to {} {unit} ({}).",
            found.groups.len(),
            if found.searched {
                "searched for again in the others"
            } else {
                "chosen again in the others"
            },
            decimals.format(found.rms_before),
            decimals.format(found.rms_after),
            fallen_by(decimals, found.gain, found.gain_std_error)
        )];
        if let Some(groups) = found.spread() {
            let [least, most] = groups.map(|group| {
                format!(
                    "from {} to {} {unit} for {}",
                    decimals.format(group.rms_before),
                    decimals.format(group.rms_after),
                    labels(&group.cases)
                )
            });
            out.push(format!(
                "The gain depends on the group: the rms error goes {least} (least) and {most} (most)."
            ));
        }
        out
    }

    /// Returns, for each channel, a text with the change of its rms error in the held-out cases.
    fn channels_gained(&self) -> Vec<String> {
        let gains = self.channel_gains().into_iter();
        let told = |channel: ChannelGain| {
            let decimals = Decimals::of_error(channel.sigma);
            let [before, after] = channel.rms.map(|rms| decimals.format(rms));
            format!(
                "the rms error of {} from {before} to {after}{}",
                channel.name, channel.behind
            )
        };
        gains.map(told).collect()
    }

    /// Returns the rms errors of each channel that has readings held out.
    pub(super) fn channel_gains(&self) -> Vec<ChannelGain> {
        let Some(unseen) = &self.outcome.unseen else {
            return Vec::new();
        };
        let [before, after] = &unseen.predicted;
        let channels = self.outcome.subject.problem.measurement.channels.iter();
        channels
            .enumerate()
            .filter_map(|(channel, info)| {
                let rows = self
                    .outcome
                    .subject
                    .rows
                    .iter()
                    .enumerate()
                    .filter(|(_, row)| {
                        matches!(row, Row::Channel { channel: of, .. } if *of == channel)
                            && self.outcome.subject.is_held_out_row(row)
                    });
                let count = rows.clone().count();
                let rms = |blind: &HoldOutPrediction| {
                    let squares = rows.clone().map(|(k, _)| blind.misfit[k].powi(2));
                    (squares.sum::<f64>() / count as f64).sqrt() * info.sigma
                };
                (count > 0).then(|| ChannelGain {
                    name: info.name.clone(),
                    behind: info.behind(),
                    sigma: info.sigma,
                    rms: [rms(before), rms(after)],
                })
            })
            .collect()
    }

    /// Returns a sentence about the three largest significant biases of stiffnesses in the original model.
    fn biases(&self) -> Option<String> {
        let mut biased: Vec<_> = self
            .outcome
            .corrected
            .iter()
            .filter(|s| {
                s.is_identified()
                    && !s.is_change
                    && (s.before.0 - s.after.0).abs()
                        > NOTABLE_BIAS_SD * libm::hypot(s.before.1, s.after.1)
            })
            .collect();
        biased.sort_by(|a, b| b.bias().abs().total_cmp(&a.bias().abs()));
        let listed: Vec<String> = biased
            .iter()
            .take(3)
            .map(|s| {
                let word = if s.bias() > 0.0 { "stiff" } else { "soft" };
                format!("{} {:.0} % too {word}", s.address, 100.0 * s.bias().abs())
            })
            .collect();
        (!listed.is_empty())
            .then(|| format!("Without the causes, the fit had {}.", listed.join(", ")))
    }
}
