use super::number::change;
use super::ranking::words;
use super::scene::Role;
use super::study_figures::load_axis;
use super::{Chart, DrawingError, Figure, Positions, Scene, Series, SeriesStyle, study_scene};
use admire_diagnosis::{FittedModel, Outcome, Verdict};
use admire_identify::LoadedStudy;
use admire_solver::model::Model;

/// Creates the scene of the mechanism with the findings highlighted. It shows the measured positions, the original model and the extended
/// model.
pub(super) fn diagnosis_scene(loaded: &LoadedStudy, outcome: &Outcome<'_>) -> Scene {
    let before = positions(
        "as the model was",
        Role::Initial,
        &loaded.model,
        &outcome.baseline,
    );
    let after = positions(
        "as it is extended",
        Role::Extended,
        &loaded.model,
        &outcome.extended,
    );
    let mut scene = study_scene(loaded, &[before, after]);
    for finding in &outcome.diagnosis.findings {
        let label = words(finding.cause);
        for address in std::iter::once(&finding.address).chain(&finding.members) {
            scene.highlight(address, &label);
        }
    }
    scene
}

/// Returns the poses of a fitted model for the parts of the study's own deck. Parts added by an extension are omitted.
fn positions(name: &str, role: Role, model: &Model, fitted: &FittedModel) -> Positions {
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
        name: name.to_string(),
        role,
        cases: cases.collect(),
    }
}

/// Draws wheel and sensor readings of a rig over each load, along the whole loop: by measurement, original model and extended model.
pub(super) fn curves(
    loaded: &LoadedStudy,
    outcome: &Outcome<'_>,
) -> Result<Vec<Figure>, DrawingError> {
    let series = |name: &str, points: Vec<(f64, f64)>, mark| Series {
        name: name.to_string(),
        points,
        mark,
    };
    let mut out = Vec::new();
    for run in outcome.wheel_runs() {
        let chart = Chart {
            title: format!("{} against {}", run.what, run.load),
            x: load_axis(loaded, &run.load),
            y: match &run.unit {
                Some(unit) => format!("{}, {unit}", run.what),
                None => run.what,
            },
            series: vec![
                series("as read", run.read, SeriesStyle::Points),
                series("as the model was", run.before, SeriesStyle::Dashed),
                series("as it is extended", run.after, SeriesStyle::Line),
            ],
            log_y: false,
            level: None,
        };
        let seen = if run.unseen {
            "Neither fit has seen these readings."
        } else {
            "The fits have seen these readings."
        };
        let roles = [Role::Measured, Role::Initial, Role::Extended];
        out.push(Figure::of_roles(&chart, &roles, seen)?);
    }
    Ok(out)
}

/// Describes in words how well the model fits, without and with causes.
pub fn fit_in_words(outcome: &Outcome<'_>) -> String {
    let [before, after] =
        [&outcome.baseline, &outcome.extended].map(|fitted| fitted.posterior.chi_square_per_dof());
    let tried = format!("{} hypotheses were tried.", outcome.places);
    let sizes =
        "noise and tolerances are fitted with it, which brings it near 1 for wrong models too";
    if outcome.extended.effects.is_empty() {
        return format!("Chi-square per degree of freedom is {before:.2}; {sizes}. {tried}");
    }
    let nats = outcome.extended.ln_posterior() - outcome.baseline.ln_posterior();
    format!(
        "With the causes found the readings are 10^{:.1} times as probable. Chi-square per degree of freedom is {before:.2} without them and \
         {after:.2} with them; {sizes}. {tried}",
        nats / std::f64::consts::LN_10
    )
}

/// Returns the result for decision makers in a few sentences: problem, cause, site and gain.
pub(super) fn headline(loaded: &LoadedStudy, outcome: &Outcome<'_>, scene: &Scene) -> String {
    let diagnosis = &outcome.diagnosis;
    let length = loaded.model.units.length.word;
    let stopped = if outcome.is_stopped() {
        "Interrupted; this is what was found so far. "
    } else {
        ""
    };
    let Some(finding) = diagnosis.findings.iter().find(|finding| !finding.minor) else {
        let answer = match diagnosis.verdict {
            Verdict::Unexplained => {
                "The measurement holds something that the model does not have and that no known cause explains."
            }
            Verdict::Consistent | Verdict::Discrepancy => {
                "The model explains what was measured; nothing in it needs to be changed."
            }
        };
        return format!("{stopped}{answer}");
    };
    let rivals: Vec<String> = finding
        .indistinguishable_from
        .iter()
        .map(|rival| format!("{} at {}", words(rival.cause), scene.named(&rival.address)))
        .collect();
    let mut text = format!(
        "{stopped}The model does not behave like the car: the cause is {} at {}, with a probability of {:.0} %.",
        words(finding.cause),
        scene.named(&finding.address),
        (100.0 * finding.probability).min(99.0)
    );
    if !rivals.is_empty() {
        text += &format!(
            " These readings do not tell it from {}; the probability that one of them acts is {:.0} %.",
            rivals.join(", or from "),
            (100.0 * finding.group_probability).min(99.0)
        );
    }
    if let (Some(before), Some(after)) = (
        finding.gain.held_out_rms_before,
        finding.gain.held_out_rms_after,
    ) {
        text += &format!(
            " With it the error on load cases that the fit did not see {} {length}.",
            change(before, after)
        );
    }
    let of_marks = finding.gain.held_out_rms_before.is_some();
    if let Some(found) = diagnosis.hold_out.as_ref().filter(|_| !of_marks) {
        let what = match (found.cases.is_empty(), found.searched) {
            (false, true) => "load cases that no fit saw",
            (false, false) => "load cases that the fit did not see",
            (true, _) => "curves that no fit saw",
        };
        text += &format!(
            " With what was found the error on {what} {} times the noise of the readings.",
            change(found.rms_before, found.rms_after)
        );
    }
    let others: Vec<String> = diagnosis
        .findings
        .iter()
        .filter(|finding| !finding.minor)
        .skip(1)
        .map(|finding| {
            format!(
                "{} at {}",
                words(finding.cause),
                scene.named(&finding.address)
            )
        })
        .collect();
    match &others[..] {
        [] => {}
        [one] => text += &format!(" Found beside it: {one}."),
        [one, more @ ..] => {
            text += &format!(" Found beside it: {one}, and {} more below.", more.len());
        }
    }
    if diagnosis.verdict == Verdict::Unexplained {
        text += " Something remains that no known cause explains.";
    }
    text
}
