//! `free-play`: a joint of a part with two joints has play along the line through them.
//!
//! The part is split at one of its ends. Within the play a weak spring holds it, beyond the play a stiff contact.

use super::super::cause::Cause;
use super::super::hypothesis::{
    Change, EffectParameter, Hypothesis, Parametrisation, Sensitivity, number,
};
use super::super::survey::Survey;
use super::link_compliance::link_ends;

/// Prior standard deviation of the play of a worn joint, in mm.
const SD: f64 = 0.2;
/// Fraction of the largest force that closes a play of one standard deviation. It represents grease and friction, without which the part
/// could rest anywhere in the play.
const HELD: f64 = 0.02;
/// Prior standard deviation of the logarithm of the stiffness within the play.
const SPREAD: f64 = 1.5;
/// Prior of the contact stiffness of a ball joint: median in N/mm, and standard deviation of its logarithm.
const CONTACT: (f64, f64) = (1e5, 1.0);

/// Adds free play at both ends of every movable part with exactly two attachments.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let per_length = survey.newton() / survey.millimetre();
    let sd = SD * survey.millimetre();
    for end in link_ends(survey) {
        let most = end.tension.iter().fold(0.0_f64, |m, n| m.max(n.abs()));
        let held = HELD * most;
        if !(held > 0.0) {
            continue;
        }
        let floating = survey.free_id("MARKER") + 2;
        let within = held / (0.5 * sd);
        let (bushing, pair, mut changes) = end.split(survey, within);
        let measure = format!("DZ({},{},{})", pair[0], pair[1], pair[1]);
        let contact = CONTACT.0 * per_length;
        let half = format!("{contact:E}*(MAX(0.0,{measure}-0.0)");
        let text = format!("-{half}-MAX(0.0,-{measure}-0.0))");
        let (force, added) = survey.force_between(pair, (end.part, floating), &[(2, &text)]);
        changes.extend(added.into_iter().map(Change::Add));
        // The first literal is the contact stiffness. The last literal of each of the two terms is half of the play.
        let first = admire_syntax::Expression::parse_str(&format!("{half})"));
        let first = first.map_or(0, |e| e.literals.len());
        let slot = |k: usize| (number("GFORCE", force, "FZ", Some(k)), 0.5);
        let halves = vec![slot(first), slot(2 * first - 1)];
        out.push(Hypothesis {
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
                    SPREAD,
                    Parametrisation::Rate {
                        address: number("BUSHING", bushing, "K", Some(3)),
                        usual: within,
                    },
                ),
                EffectParameter::new(
                    "contact",
                    CONTACT.1,
                    Parametrisation::Rate {
                        address: number("GFORCE", force, "FZ", Some(1)),
                        usual: contact,
                    },
                ),
            ],
            ln_prior: 0.0,
            one_sided: true,
            changes,
            memory: None,
            part: 0,
            joint_with: None,
        });
    }
}
