//! Catalogue of causes, with one file per cause. Each file defines the possible sites of its cause in the deck, its first-order effect, and
//! its extension of the deck.
//!
//! The files depend on the deck, the measurement, and the state of every load case at a fit. They are independent of the comparison of
//! candidates.

mod assembly_offset;
mod body_compliance;
pub(super) mod bushing_coupling;
mod bushing_orientation;
mod channel_fault;
mod creep;
pub(super) mod dry_friction;
mod element_parameter;
mod frame_drift;
pub(super) mod free_play;
mod hardpoint_error;
mod link_compliance;
mod load_crosstalk;
mod load_gain;
mod load_point_error;
pub(super) mod progressive_stiffness;
mod stop_contact;

use super::candidate_effect::CandidateEffect;
use super::candidate_effect::Term;
use super::cause::Cause;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;

/// Returns all candidate effects at all sites of the deck, in a fixed order.
pub(super) fn all(survey: &OperatingPoints<'_>) -> Vec<CandidateEffect> {
    let mut out = Vec::new();
    progressive_stiffness::hypotheses(survey, &mut out);
    creep::hypotheses(survey, &mut out);
    link_compliance::hypotheses(survey, &mut out);
    free_play::hypotheses(survey, &mut out);
    body_compliance::hypotheses(survey, &mut out);
    assembly_offset::hypotheses(survey, &mut out);
    hardpoint_error::hypotheses(survey, &mut out);
    bushing_orientation::hypotheses(survey, &mut out);
    bushing_coupling::hypotheses(survey, &mut out);
    element_parameter::hypotheses(survey, &mut out);
    stop_contact::hypotheses(survey, &mut out);
    load_gain::hypotheses(survey, &mut out);
    load_crosstalk::hypotheses(survey, &mut out);
    load_point_error::hypotheses(survey, &mut out);
    frame_drift::hypotheses(survey, &mut out);
    channel_fault::hypotheses(survey, &mut out);
    let class = |h: &CandidateEffect| match h.cause {
        // A compliant link and its compliant attachments share one prior probability, because the readings often cannot distinguish them.
        Cause::BodyCompliance => (Cause::LinkCompliance, ""),
        cause => (cause, h.side),
    };
    // Forms of a law with memory differ in their first guesses only, and count once.
    let forms = |h: &CandidateEffect| out.iter().filter(|other| other.same_law(h)).count();
    let mut counts: Vec<((Cause, &'static str), f64)> = Vec::new();
    for h in &out {
        let share = 1.0 / forms(h) as f64;
        match counts.iter_mut().find(|(of, _)| *of == class(h)) {
            Some((_, count)) => *count += share,
            None => counts.push((class(h), share)),
        }
    }
    for h in &mut out {
        let count = counts.iter().find(|(of, _)| *of == class(h));
        h.ln_prior =
            libm::log(survey.priors().class_probability / count.map_or(1.0, |(_, count)| *count));
        if h.form == body_compliance::IN_LINE {
            h.ln_prior += libm::log(survey.priors().in_line_odds);
        }
        if h.cause == Cause::Creep {
            h.ln_prior += libm::log(survey.priors().creep_odds);
        }
    }
    out
}

/// Returns all candidates that the fit does not contain yet, and further terms of the force laws that it contains.
pub(super) fn candidates(
    survey: &OperatingPoints<'_>,
    fitted: &FittedModel,
) -> Vec<CandidateEffect> {
    let mut hypotheses = all(survey);
    hypotheses.retain(|h| {
        let there =
            |chosen: &&CandidateEffect| chosen.same_site(h) && chosen.term != Term::Asymmetry;
        let mut there = fitted.effects.iter().filter(there);
        there.all(|chosen| chosen.is_alternative(h) && !chosen.same_form(h))
    });
    let own = |h: &CandidateEffect| bushing_coupling::growth(survey, h);
    let growing = hypotheses
        .iter()
        .filter_map(|h| Some(h.clone().joined(own(h)?)));
    let growing: Vec<CandidateEffect> = growing.collect();
    hypotheses.extend(growing);
    let coupled =
        CandidateEffect::causes(&fitted.effects).filter(|h| !h.is_refined(&fitted.effects));
    hypotheses.extend(coupled.filter_map(own));
    hypotheses.extend(dry_friction::by_direction(survey));
    hypotheses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base_fit::tests::axle_problem;
    use admire_identify::LoadedStudy;

    /// Returns the candidates of the shipped axle with a section `[priors]` in its study.
    fn candidates_with(priors: &str) -> Vec<CandidateEffect> {
        let shipped =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpus/pseudo-mcpherson");
        let folder = tempfile::tempdir().expect("a folder");
        for entry in std::fs::read_dir(shipped).expect("the shipped study") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name");
            std::fs::copy(&path, folder.path().join(name)).expect("a copy");
        }
        let file = folder.path().join("study.toml");
        let text = std::fs::read_to_string(&file).expect("study.toml");
        std::fs::write(&file, format!("{text}\n[priors]\n{priors}\n")).expect("study.toml");
        let loaded = LoadedStudy::read(folder.path()).value.expect("a study");
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let survey = OperatingPoints::new(&subject, &none);
        all(&survey)
    }

    #[test]
    fn priors_of_the_study_are_those_of_the_candidates() {
        let usual = candidates_with("");
        let other = candidates_with("load_gain = 0.5\nclass_probability = 0.1\nhardpoint_mm = 1.5");
        assert_eq!(usual.len(), other.len());
        let mut seen = 0;
        for (usual, other) in usual.iter().zip(&other) {
            let change = other.ln_prior - usual.ln_prior;
            assert!((change - std::f64::consts::LN_2).abs() < 1e-12, "{usual}");
            let factor = match (usual.cause, usual.side, usual.numbers[0].name.as_str()) {
                (Cause::LoadGain, ..) => 0.5 / 0.03,
                (Cause::HardpointError, "point", _) => 0.5,
                (Cause::DryFriction | Cause::LinkCompliance, ..) => 1.0,
                _ => continue,
            };
            let sd = usual.numbers[0].sd;
            assert!(
                (other.numbers[0].sd - factor * sd).abs() < 1e-12 * sd,
                "{usual}"
            );
            seen += 1;
        }
        assert!(seen > 10, "{seen}");
    }
}
