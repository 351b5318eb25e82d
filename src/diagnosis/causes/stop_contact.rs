//! `stop-contact`: a one-sided spring engages past a clearance in the travel of a joint or spring.

use admire_solver::mechanics::Vec6;
use admire_solver::model::{JointKind, MarkerIx};
use admire_syntax::{Address, NewStatement};

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use crate::settings::START_CLEARANCES;

/// Names of the starting values of the clearance, as fractions of the displacement range: above its lower end, and below its upper end.
const FORMS: [(&str, &str); 4] = [
    ("above 0.25", "below 0.25"),
    ("above 0.50", "below 0.50"),
    ("above 0.70", "below 0.70"),
    ("above 0.85", "below 0.85"),
];

/// Adds candidates for stops at both ends of the travel of sliding joints, and of springs along their length.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    for joint in survey.model.joints.iter().filter(|j| j.header.active) {
        if !matches!(
            joint.kind,
            JointKind::Cylindrical | JointKind::Translational
        ) {
            continue;
        }
        let u: Vec<f64> = survey
            .constraint("JOINT", joint.header.id)
            .iter()
            .map(|reading| reading.motion.p_ij_j.z)
            .collect();
        let directions = vec![Vec6::ith(2, 1.0); u.len()];
        let measure = survey.deflection_function((joint.i, joint.j), 2);
        let address = format!("JOINT/{}", joint.header.id);
        let text = |body: &str| survey.vector_force((joint.i, joint.j), &[(2, body)]);
        let travel = Travel {
            address: &address,
            kind: "GFORCE",
            argument: "FZ",
            pair: (joint.i, joint.j),
            u: &u,
            directions: &directions,
            measure: &measure,
            statements: &text,
        };
        stops(survey, &travel, out);
    }
    for spring in survey
        .model
        .springdampers
        .iter()
        .filter(|s| s.header.active)
    {
        if spring.kind != admire_solver::model::SpringKind::Translational {
            continue;
        }
        let (mut u, mut directions) = (Vec::new(), Vec::new());
        for reading in survey.element("SPRINGDAMPER", spring.header.id) {
            let p = reading.motion.p_ij_j;
            let along = p.normalize();
            u.push(p.norm());
            directions.push(Vec6::new(along.x, along.y, along.z, 0.0, 0.0, 0.0));
        }
        let (i, j) = (survey.marker_id(spring.i), survey.marker_id(spring.j));
        let id = survey.free_id("SFORCE");
        let text = |body: &str| {
            let argument = |word: &str, value: String| (word.to_string(), Some(value));
            let statement = NewStatement {
                kind: "SFORCE".to_string(),
                id: Some(id),
                view_name: None,
                arguments: vec![
                    ("TRANSLATIONAL".to_string(), None),
                    argument("I", i.to_string()),
                    argument("J", j.to_string()),
                    argument("FUNCTION", body.to_string()),
                ],
            };
            (id, vec![statement])
        };
        let measure = format!("DM({i},{j})");
        let address = format!("SPRINGDAMPER/{}", spring.header.id);
        let travel = Travel {
            address: &address,
            kind: "SFORCE",
            argument: "FUNCTION",
            pair: (spring.i, spring.j),
            u: &u,
            directions: &directions,
            measure: &measure,
            statements: &text,
        };
        stops(survey, &travel, out);
    }
}

/// Travel of a sliding joint or a spring that a stop may limit.
struct Travel<'a> {
    /// Address of the joint or spring.
    address: &'a str,
    /// Kind of the statement of the added force.
    kind: &'a str,
    /// Argument of this statement that holds the function of the force.
    argument: &'a str,
    pair: (MarkerIx, MarkerIx),
    /// Displacement along the travel in each case.
    u: &'a [f64],
    /// Wrench of a unit force along the travel, in each case.
    directions: &'a [Vec6],
    /// ADAMS function that measures the displacement.
    measure: &'a str,
    /// Returns the id and the statements of the added force, given the function of the force.
    statements: &'a dyn Fn(&str) -> (u32, Vec<NewStatement>),
}

/// Adds candidates for stops at both ends of a travel. A positive force acts along the directions of the travel.
fn stops(survey: &OperatingPoints<'_>, travel: &Travel<'_>, out: &mut Vec<CandidateEffect>) {
    let Travel {
        address,
        kind,
        argument,
        pair,
        u,
        directions,
        measure,
        statements,
    } = *travel;
    let per_length = survey.newton() / survey.millimetre();
    let (low, high) = u
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| {
            (a.min(*u), b.max(*u))
        });
    let range = high - low;
    if !range.is_finite() || range < 1e-6 {
        return;
    }
    let mut ascending = u.to_vec();
    ascending.sort_by(f64::total_cmp);
    // A stop that only one case reaches may engage anywhere between that case and the next.
    let last = |next: usize, end: usize| 0.5 * (ascending[next] + ascending[end]);
    let ends = (u.len() > 2).then(|| {
        let count = u.len();
        [
            (last(count - 2, count - 1), "in the highest case", true),
            (last(1, 0), "in the lowest case", false),
        ]
    });
    let shares = START_CLEARANCES.into_iter().zip(FORMS);
    let grid = shares.flat_map(|(share, (above, below))| {
        [
            (low + share * range, above, true),
            (high - share * range, below, false),
        ]
    });
    for (clearance, form, up) in grid.chain(ends.into_iter().flatten()) {
        let past = |u: f64| {
            if up {
                -(u - clearance).max(0.0)
            } else {
                (clearance - u).max(0.0)
            }
        };
        let wrench = |power: i32| {
            let along = |(u, d): (&f64, &Vec6)| d * past(*u).signum() * past(*u).abs().powi(power);
            Sensitivity::Wrench(pair, u.iter().zip(directions).map(along).collect())
        };
        // Literals have no sign: a negative clearance is subtracted by adding its magnitude.
        let (sign, size) = if clearance < 0.0 {
            ('+', -clearance)
        } else {
            ('-', clearance)
        };
        let past_it = format!("{measure}{sign}{size:.6}");
        let linear = if up {
            format!("-0.0*MAX(0.0,{past_it})")
        } else {
            format!("+0.0*MAX(0.0,-({past_it}))")
        };
        // The cubic term makes the stop progressively stiffer.
        let body = format!("{}{linear}**3", linear.trim_start_matches('+'));
        let toward = if clearance < 0.0 { -1.0 } else { 1.0 };
        let (id, added) = statements(&body);
        let literals = admire_syntax::Expression::parse_str(linear.trim_start_matches('+'))
            .map(|expression| expression.literals)
            .unwrap_or_default();
        let at = literals
            .iter()
            .rposition(|literal| (literal.value - size).abs() < 1e-5)
            .map_or(3, |k| k + 1);
        let second = literals.len();
        let slot = |k: usize| Address::of_argument(kind, id, argument, Some(k));
        let clearances = vec![(slot(at), toward), (slot(second + at), toward)];
        out.push(CandidateEffect {
            cause: Cause::StopContact,
            address: address.to_string(),
            members: Vec::new(),
            side: "",
            form,
            numbers: vec![
                EffectParameter {
                    column: wrench(1),
                    ..EffectParameter::new(
                        "stiffness",
                        survey.priors().stop_stiffness_n_per_mm * per_length,
                        Parametrisation::Extended(vec![(slot(1), 1.0)]),
                    )
                },
                EffectParameter {
                    column: wrench(3),
                    ..EffectParameter::new(
                        "hardening",
                        survey.priors().stop_stiffness_n_per_mm * per_length
                            / (survey.priors().stop_hardening * range).powi(2),
                        Parametrisation::Extended(vec![(slot(second + 1), 1.0)]),
                    )
                },
                EffectParameter::new(
                    "clearance_shift",
                    survey.priors().stop_clearance * range,
                    Parametrisation::Extended(clearances),
                ),
            ],
            ln_prior: 0.0,
            one_sided: true,
            changes: added.into_iter().map(Change::Add).collect(),
            memory: None,
            term: Term::Main,
            joint_with: None,
        });
    }
}
