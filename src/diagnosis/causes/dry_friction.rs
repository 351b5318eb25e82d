//! `dry-friction`: rate-independent hysteresis. The response depends on the order of the loads.
//!
//! Elasto-slip law: a spring in series with a slider, which moves once the spring is stretched by more than its slip length `F / k`. The
//! position of the slider before the first case is unknown. Each case then passes its slider position on to the next.

use admire_identify::global::Evolution;
use admire_solver::model::{JointKind, MarkerIx};

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, MemoryPlan, Parametrisation, Sensitivity,
    Term, component, number,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use crate::priors::FORCE_LEVER_MM;
use crate::settings::{START_FRICTION_FORCES, START_SLIP_LENGTHS};

use super::super::operating_points::statement;

/// Forms of the law with different first guesses: index in `START_SLIP_LENGTHS`, index in `START_FRICTION_FORCES`, and name.
const FORMS: [(usize, usize, &str); 9] = [
    (0, 0, "short, free at first"),
    (0, 1, "short, pushed at first"),
    (0, 2, "short, pulled at first"),
    (1, 0, "middle, free at first"),
    (1, 1, "middle, pushed at first"),
    (1, 2, "middle, pulled at first"),
    (2, 0, "long, free at first"),
    (2, 1, "long, pushed at first"),
    (2, 2, "long, pulled at first"),
];

/// Turns the candidate `h`, a slider, into the further term `index` of an existing friction law. Parallel sliders that slip one after the
/// other form a law with a gradual limit. Source: Iwan, Journal of Applied Mechanics 33 (1966) 893.
pub(crate) fn further_slider(survey: &OperatingPoints<'_>, h: &mut CandidateEffect, index: usize) {
    h.term = Term::Further(index);
    h.ln_prior = libm::log(survey.priors().gradual_friction / FORMS.len() as f64);
}

/// Returns, for each friction in the model, a term that makes the friction limit larger in one direction and smaller in the other. The term is a
/// constant force parallel to the slider. The force shifts both limits of the friction, and it shifts the displacement at which the friction
/// force is zero (the anchor).
pub(crate) fn by_direction(survey: &OperatingPoints<'_>) -> Vec<CandidateEffect> {
    let chosen = &survey.fitted.effects;
    let of = |(at, h): (usize, &CandidateEffect)| {
        let differs = |other: &CandidateEffect| other.term == Term::Asymmetry && other.same_site(h);
        if h.cause != Cause::DryFriction || h.term > Term::Main || chosen.iter().any(differs) {
            return None;
        }
        let force = survey.fitted.estimates(at).first()?.value.abs();
        let Sensitivity::Wrench(pair, wrench) = &h.numbers[0].column else {
            return None;
        };
        let axis = wrench
            .iter()
            .find_map(|w| w.iter().position(|f| *f != 0.0))?;
        let (gforce, changes) = survey.vector_force(*pair, &[(axis, "-0.0*1.0")]);
        let against = vec![admire_solver::mechanics::Vec6::ith(axis, -1.0); survey.cases()];
        let numbers = vec![EffectParameter {
            column: Sensitivity::Wrench(*pair, against),
            ..EffectParameter::new(
                "asymmetry",
                survey.priors().friction_asymmetry_size * force,
                Parametrisation::Extended(vec![(
                    number("GFORCE", gforce, FORCES[axis], Some(1)),
                    1.0,
                )]),
            )
        }];
        let mut out = CandidateEffect::plain(h.cause, h.address.clone(), h.form, numbers);
        out.changes = changes.into_iter().map(Change::Add).collect();
        out.term = Term::Asymmetry;
        out.ln_prior = libm::log(survey.priors().friction_asymmetry);
        (force > 0.0).then_some(out)
    };
    chosen.iter().enumerate().filter_map(of).collect()
}

/// Returns the friction force in each case as a fraction of its limit, for the displacements `u`. The spring has the slip length `length`.
/// `anchor` is the displacement at which the spring is unstretched before the first case.
fn pattern(u: &[f64], length: f64, mut anchor: f64) -> Vec<f64> {
    u.iter()
        .map(|&u| {
            let slip = admire_solver::element::Slip::at(u, &[1.0 / length, 1.0, anchor]);
            anchor = slip.anchor_after;
            -slip.force
        })
        .collect()
}

/// Adds candidates for friction in every component of every bushing, and in the free motions of joints.
pub(crate) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let deflections = survey.bushing_deflections(k);
        for axis in 0..6 {
            let u: Vec<f64> = deflections.iter().map(|d| d[axis]).collect();
            let address = format!("BUSHING/{}.{}", bushing.header.id, component(axis));
            put(survey, &address, ((bushing.i, bushing.j), axis), &u, out);
        }
    }
    for joint in survey.model.joints.iter().filter(|j| j.header.active) {
        let axes: &[usize] = match joint.kind {
            JointKind::Translational => &[2],
            JointKind::Cylindrical => &[2, 5],
            JointKind::Revolute => &[5],
            _ => continue,
        };
        let readings = survey.constraint("JOINT", joint.header.id);
        for &axis in axes {
            let u: Vec<f64> = readings
                .iter()
                .map(|r| {
                    if axis < 3 {
                        r.motion.p_ij_j[axis]
                    } else {
                        r.motion.angles[axis - 3]
                    }
                })
                .collect();
            let address = format!("JOINT/{}", joint.header.id);
            put(survey, &address, ((joint.i, joint.j), axis), &u, out);
        }
    }
}

/// Adds candidates for friction at one site. The law is the GFORCE `F max(-1, min(1, (anchor - u) / L))` with limit `F` and slip length `L`. The
/// anchor is the displacement at which the force is zero. It is stored in a VARIABLE, whose value passes from each case to the next.
fn put(
    survey: &OperatingPoints<'_>,
    address: &str,
    (pair, axis): ((MarkerIx, MarkerIx), usize),
    u: &[f64],
    out: &mut Vec<CandidateEffect>,
) {
    let (low, high) = u
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| {
            (low.min(*u), high.max(*u))
        });
    let range = high - low;
    if !range.is_finite() || range < 1e-9 {
        return;
    }
    let lever = if axis < 3 {
        1.0
    } else {
        FORCE_LEVER_MM * survey.millimetre()
    };
    let measure = survey.deflection_function(pair, axis);
    let anchor = survey.free_id("VARIABLE");
    let law = format!("0.0*MAX(-1.0,MIN(1.0,(VARVAL({anchor})-{measure})/1.0))");
    let (force, added) = survey.vector_force(pair, &[(axis, &law)]);
    let variable = statement("VARIABLE", anchor, &[("FUNCTION", "0.0".to_string())]);
    let changes: Vec<Change> = std::iter::once(variable)
        .chain(added)
        .map(Change::Add)
        .collect();
    let literal = |k: usize| number("GFORCE", force, FORCES[axis], Some(k));
    // Marker ids are literals too; the slip length is the last literal.
    let last = admire_syntax::Expression::parse_str(&law).map_or(0, |law| law.literals.len());
    let at_start = number("VARIABLE", anchor, "FUNCTION", Some(1));
    for (share, first, form) in FORMS {
        let (share, first) = (START_SLIP_LENGTHS[share], START_FRICTION_FORCES[first]);
        let length = share * range;
        // The force on marker I opposes the stretch.
        let start = u[0] - first * length;
        let wrench = pattern(u, length, start)
            .into_iter()
            .map(|p| admire_solver::mechanics::Vec6::ith(axis, p))
            .collect();
        let unfelt = Sensitivity::None;
        out.push(CandidateEffect {
            cause: Cause::DryFriction,
            address: address.to_string(),
            members: Vec::new(),
            side: "",
            form,
            numbers: vec![
                EffectParameter {
                    column: Sensitivity::Wrench(pair, wrench),
                    ..EffectParameter::new(
                        "force",
                        survey.priors().friction_n * survey.newton() * lever,
                        Parametrisation::Extended(vec![(literal(1), 1.0)]),
                    )
                },
                EffectParameter {
                    column: unfelt.clone(),
                    ..EffectParameter::new(
                        "stiffness",
                        survey.priors().slip_length_ln_sd,
                        Parametrisation::SlipLength {
                            address: literal(last),
                            start: length,
                            usual: survey.priors().slip_length * range,
                        },
                    )
                },
                EffectParameter {
                    mean: start,
                    ..EffectParameter::new(
                        "anchor",
                        range,
                        Parametrisation::Extended(vec![(at_start.clone(), 1.0)]),
                    )
                },
            ],
            ln_prior: 0.0,
            one_sided: true,
            changes: changes.clone(),
            term: Term::Main,
            joint_with: None,
            memory: Some(MemoryPlan {
                anchor: at_start.clone(),
                carries: Evolution::Slider,
                by: literal(last),
                measure: measure.clone(),
            }),
        });
    }
}
