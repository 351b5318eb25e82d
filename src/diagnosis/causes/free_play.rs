//! `free-play`: a joint of a part with two joints has play along the line through them.
//!
//! The part is split at one of its ends. A weak spring holds the end within the play, and a stiff contact holds it beyond the play.

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use super::link_compliance::link_ends;
use crate::settings::START_PLAY_STIFFNESSES;
use admire_syntax::Address;

/// Adds candidates for free play at both ends of every movable part with exactly two attachments.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let per_length = survey.newton() / survey.millimetre();
    let sd = survey.priors().free_play_mm * survey.millimetre();
    for end in link_ends(survey) {
        let most = end.tension.iter().fold(0.0_f64, |m, n| m.max(n.abs()));
        let held = survey.priors().free_play_held * most;
        if !(held > 0.0) {
            continue;
        }
        let floating = survey.free_id("MARKER") + 2;
        let within = held / (0.5 * sd);
        let (bushing, pair, mut changes) = end.split(survey, within);
        let measure = format!("DZ({},{},{})", pair[0], pair[1], pair[1]);
        let contact = survey.priors().contact_stiffness_n_per_mm * per_length;
        let half = format!("{contact:E}*(MAX(0.0,{measure}-0.0)");
        let text = format!("-{half}-MAX(0.0,-{measure}-0.0))");
        let (force, added) = survey.force_between(pair, end.part, floating, &[(2, &text)]);
        changes.extend(added.into_iter().map(Change::Add));
        // The first literal is the contact stiffness. Each of the two terms ends with half of the play as its last literal.
        let first = admire_syntax::Expression::parse_str(&format!("{half})"));
        let first = first.map_or(0, |e| e.literals.len());
        let slot = |k: usize| (Address::of_argument("GFORCE", force, "FZ", Some(k)), 0.5);
        let halves = vec![slot(first), slot(2 * first - 1)];
        out.push(CandidateEffect {
            cause: Cause::FreePlay,
            address: format!("PART/{}", end.part),
            members: Vec::new(),
            side: "",
            form: end.form,
            numbers: vec![
                EffectParameter {
                    column: Sensitivity::PerCase(end.moved(|n| 0.5 * libm::tanh(n / held))),
                    ..EffectParameter::new("play", sd, Parametrisation::Extended(halves))
                },
                EffectParameter::new(
                    "stiffness",
                    survey.priors().free_play_stiffness_ln_sd,
                    Parametrisation::Rate {
                        address: Address::of_argument("BUSHING", bushing, "K", Some(3)),
                        usual: within,
                    },
                ),
                EffectParameter::new(
                    "contact",
                    survey.priors().contact_stiffness_ln_sd,
                    Parametrisation::Rate {
                        address: Address::of_argument("GFORCE", force, "FZ", Some(1)),
                        usual: contact,
                    },
                ),
            ],
            ln_prior: 0.0,
            one_sided: true,
            changes,
            memory: None,
            term: Term::Main,
            joint_with: None,
        });
    }
}

/// Returns the starts of a fit with free play, given the first guesses of its parameters.
pub(crate) fn starts(
    effect: &CandidateEffect,
    guesses: &[f64],
) -> Vec<(CandidateEffect, Vec<f64>)> {
    let start = |stiffness: f64| {
        let mut guesses = guesses.to_vec();
        guesses[1] = stiffness;
        (effect.clone(), guesses)
    };
    START_PLAY_STIFFNESSES.map(start).to_vec()
}
