use super::diagnosis_phrases::percent;
use super::diagnosis_text::Text;
use super::load_run::LoadRun;
use super::number::{capitalised, change, number};
use super::ranking::{known_sizes, words};
use super::scene::Role;
use super::study_figures::load_axis;
use super::{Positions, Scene, Series, study_scene};
use admire_diagnosis::{Cause, Finding, FittedModel, Outcome, Verdict};
use admire_identify::LoadedStudy;
use admire_solver::model::Model;

/// Logarithm to base ten of the largest ratio of probabilities that is stated as a number.
const MAX_DECADES: f64 = 6.0;

/// Returns the positions of the identified and of the extended model in all cases.
pub(super) fn both_models(loaded: &LoadedStudy, outcome: &Outcome<'_>) -> [Positions; 2] {
    [
        (Role::Identified, &outcome.baseline),
        (Role::Extended, &outcome.extended),
    ]
    .map(|(role, fitted)| positions(role, &loaded.model, fitted))
}

/// Creates the scene of the mechanism with the findings highlighted, in the measured positions and in those of the models.
pub(super) fn diagnosis_scene(
    loaded: &LoadedStudy,
    outcome: &Outcome<'_>,
    models: &[Positions],
) -> Scene {
    let mut scene = study_scene(loaded, models);
    for finding in &outcome.diagnosis.findings {
        let label = words(finding.cause);
        for address in std::iter::once(&finding.address).chain(&finding.members) {
            scene.highlight(address, &label);
        }
    }
    scene
}

/// Returns the poses of a fitted model for the parts of the study's own deck. Parts added by an extension are omitted.
fn positions(role: Role, model: &Model, fitted: &FittedModel) -> Positions {
    let of = |part: &admire_solver::model::Part| {
        let mut others = fitted.deck.model.parts.iter();
        others.position(|other| other.header.id == part.header.id && other.kind == part.kind)
    };
    let places: Vec<Option<usize>> = model.parts.iter().map(of).collect();
    let cases = fitted.states.iter().map(|state| {
        let parts = model.parts.iter().zip(&places);
        let pose = parts.map(|(part, place)| {
            let found = place.and_then(|place| state.poses.get(place));
            found.copied().unwrap_or(part.pose)
        });
        Some(pose.collect::<Vec<_>>())
    });
    Positions {
        role,
        cases: cases.collect(),
    }
}

/// Returns wheel and sensor readings of a rig over each load, along the whole loop: as measured, and by the identified and the extended model.
pub(super) fn runs(loaded: &LoadedStudy, outcome: &Outcome<'_>) -> Vec<LoadRun> {
    let of = |run: admire_diagnosis::WheelRun| LoadRun {
        what: run.what,
        unit: run.unit.unwrap_or_default(),
        load: load_axis(loaded, &run.load),
        series: vec![
            Series::of(Role::Measured, run.read),
            Series::before(run.before),
            Series::of(Role::Extended, run.after),
        ],
        unseen: run.unseen,
    };
    outcome.wheel_runs().into_iter().map(of).collect()
}

/// Describes how well the model fits the readings, without and with causes.
pub fn fit_in_words(outcome: &Outcome<'_>) -> String {
    let [before, after] =
        [&outcome.baseline, &outcome.extended].map(|fitted| fitted.posterior.chi_square_per_dof());
    let tried = format!(
        "{} combinations of cause and place were tried.",
        outcome.places
    );
    let sizes = "noise and tolerances are estimated in the same fit, so a value near 1 does not prove the model";
    if outcome.extended.effects.is_empty() {
        return format!("Chi-square per degree of freedom is {before:.2}; {sizes}. {tried}");
    }
    let nats = outcome.extended.ln_posterior() - outcome.baseline.ln_posterior();
    let decades = nats / std::f64::consts::LN_10;
    // A larger ratio says nothing more, and is only as good as the assumed distribution of the noise.
    let probable = if decades > MAX_DECADES {
        "more than a million times as probable".to_string()
    } else {
        let ratio = libm::exp10(decades);
        format!("{} times as probable", number(ratio, Some(ratio)))
    };
    format!(
        "With these causes, the readings are {probable} as without them. Chi-square per degree of freedom is {before:.2} without them and \
         {after:.2} with them; {sizes}. {tried}"
    )
}

/// Returns the answer of a diagnosis in a few sentences: the cause and its place, its rivals, and its gain.
pub(super) fn answer(loaded: &LoadedStudy, outcome: &Outcome<'_>, scene: &Scene) -> String {
    let diagnosis = &outcome.diagnosis;
    let stopped = if outcome.is_stopped() {
        "The diagnosis was interrupted; the result is preliminary. "
    } else if outcome.is_late {
        "The diagnosis reached its time limit; the result is preliminary. "
    } else {
        ""
    };
    let main: Vec<&Finding> = diagnosis.findings.iter().filter(|f| !f.minor).collect();
    let place = |finding: &&Finding| at_place(finding.cause, &finding.address, scene);
    let places: Vec<String> = main.iter().map(place).collect();
    let causes = match &places[..] {
        [] => {
            let answer = match diagnosis.verdict {
                Verdict::Unexplained => {
                    "The measurement shows an effect that is not in the model and that no known cause explains."
                }
                Verdict::Consistent | Verdict::Discrepancy => {
                    "The model explains the measurement within its noise and tolerances; nothing needs to be changed."
                }
            };
            return format!("{stopped}{answer}");
        }
        [one] => format!("the cause is {one}"),
        [few @ .., last] if few.len() < 3 => {
            format!("the causes are {} and {last}", few.join(", "))
        }
        [first, second, more @ ..] => format!(
            "the causes are {first}, {second} and {} more, listed below",
            more.len()
        ),
    };
    let mut text = format!("{stopped}The model does not behave like the axle: {causes}.");
    let unsure = main.iter().enumerate();
    let mut unsure = unsure.filter(|(_, finding)| !finding.indistinguishable_from.is_empty());
    if let Some((k, finding)) = unsure.next() {
        let what = match k {
            0 => "it".to_string(),
            _ => format!("the {}", words(finding.cause)),
        };
        let rivals = finding.indistinguishable_from.iter();
        let rivals = rivals.map(|rival| at_place(rival.cause, &rival.address, scene));
        text += &format!(
            " These readings do not distinguish {what} from {}.",
            rivals.collect::<Vec<_>>().join(", or from ")
        );
    }
    // The sentence states the gain of all causes together. The gain of a finding is the gain of one cause, given the others.
    let after = main
        .first()
        .and_then(|finding| finding.gain.held_out_rms_after);
    let of_marks = diagnosis.baseline.held_out_rms.zip(after);
    if let Some((before, after)) = of_marks {
        let what = if main.len() == 1 { "it" } else { "them" };
        text += &format!(
            " With {what} in the model, the rms error of the marks in the load cases held out {} {}.",
            change(before, after),
            loaded.model.units.length.word
        );
    } else if let Some(found) = &diagnosis.hold_out {
        let what = if found.cases.is_empty() {
            "curves"
        } else {
            "load cases"
        };
        text += &format!(
            " With these causes, the rms error in the {what} held out {} times the noise of the readings.",
            change(found.rms_before, found.rms_after)
        );
    }
    if diagnosis.verdict == Verdict::Unexplained {
        text += " Part of the residuals is not explained by any known cause.";
    }
    text
}

/// Removes the chi-squares from the text of a step. The details of the page contain them.
fn without_statistics(text: &str) -> String {
    let mut out = text.to_string();
    for (start, end) in [(" (chi-square ", ")"), (": the chi-square is ", " at most")] {
        while let Some(from) = out.find(start) {
            let Some(length) = out[from..].find(end) else {
                break;
            };
            out.replace_range(from..from + length + end.len(), "");
        }
    }
    out
}

/// Returns a cause with its place, such as `link compliance at TIE_ROD (PART/6)`.
pub(super) fn at_place(cause: Cause, address: &str, scene: &Scene) -> String {
    format!("{} at {}", words(cause), scene.named(address))
}

/// Returns the lines of the findings: the causes, their probabilities, their gain and the next step.
pub(super) fn found_lines(
    loaded: &LoadedStudy,
    outcome: &Outcome<'_>,
    scene: &Scene,
) -> Vec<(&'static str, Vec<String>)> {
    let text = Text { outcome };
    let findings = &outcome.diagnosis.findings;
    let found = findings.iter().map(|finding| {
        let minor = if finding.minor { " (minor)" } else { "" };
        let place = capitalised(&at_place(finding.cause, &finding.address, scene));
        match known_sizes(finding, loaded) {
            sizes if sizes.is_empty() => format!("{place}{minor}"),
            sizes => format!("{place}{minor}: {sizes}"),
        }
    });
    let sure = findings
        .iter()
        .filter(|finding| !finding.minor)
        .map(|finding| {
            let own = percent(finding.probability);
            if finding.indistinguishable_from.is_empty() {
                format!("{}: {own}", scene.named(&finding.address))
            } else {
                let rivals = finding.indistinguishable_from.len();
                let word = if rivals == 1 {
                    "alternative"
                } else {
                    "alternatives"
                };
                format!(
                    "{}: {own}; together with its {word}: {}",
                    scene.named(&finding.address),
                    percent(finding.group_probability)
                )
            }
        });
    let study = loaded.study.folder.display().to_string();
    let mut next = text.next_steps(&study);
    let rivals = findings.iter().flat_map(|f| &f.indistinguishable_from);
    let causes: Vec<Cause> = findings
        .iter()
        .map(|finding| finding.cause)
        .chain(rivals.map(|rival| rival.cause))
        .collect();
    for step in &mut next {
        let mut text = without_statistics(step);
        for cause in &causes {
            text = text.replace(&format!("{cause} "), &format!("{} at ", words(*cause)));
        }
        *step = capitalised(&scene.naming(&text));
    }
    let gains = text.gains().iter().map(|gain| capitalised(gain)).collect();
    vec![
        ("Found", found.collect()),
        ("Confidence", sure.collect()),
        ("Improvement", gains),
        ("To do next", next),
    ]
}

#[cfg(test)]
mod tests {
    use super::without_statistics;

    #[test]
    fn a_step_is_said_without_chi_squares() {
        let step = "measure mark on TIE_ROD near MARKER/13 (chi-square 504.4); no load in the range separates A from B: the chi-square is 0.3 at most";
        assert_eq!(
            without_statistics(step),
            "measure mark on TIE_ROD near MARKER/13; no load in the range separates A from B"
        );
    }
}
