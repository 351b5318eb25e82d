//! `dry-friction`: rate-independent hysteresis. The response depends on the order of the loads.
//!
//! Elasto-slip law: a spring in series with a slider, which moves once the spring is stretched by more than its slip length `F / k`. The
//! position of the slider before the first case is unknown. Each case then passes its slider position on to the next.

use admire_identify::global::Evolution;
use rayon::prelude::*;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, MemoryPlan, Parametrisation, Sensitivity,
    Term,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use crate::priors::FORCE_LEVER_MM;
use crate::settings::MAX_SLIDERS;
use crate::site::{Reduced, Site, SiteModel, Sites};
use crate::site_law::{Scanned, SiteMotion, SliderPriors, SliderStart};

use super::super::operating_points::statement;
use admire_syntax::Address;

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
                    Address::of_argument("GFORCE", gforce, FORCES[axis], Some(1)),
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

fn range(u: &[f64]) -> f64 {
    let high = u.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - u.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Returns the factor that converts the size of a force to the size of the generalised force at a site: 1 for a translation, a lever arm for a
/// rotation.
fn lever(survey: &OperatingPoints<'_>, site: &Site) -> f64 {
    if site.axis < 3 {
        1.0
    } else {
        FORCE_LEVER_MM * survey.millimetre()
    }
}

/// Returns the priors of a friction law at a site.
pub(crate) fn priors(survey: &OperatingPoints<'_>, site: &Site) -> SliderPriors {
    let priors = survey.priors();
    SliderPriors {
        limit: priors.friction_n * survey.newton() * lever(survey, site),
        slip_length: priors.slip_length * range(&site.displacement),
        slip_length_ln_sd: priors.slip_length_ln_sd,
    }
}

/// Returns a friction candidate for every site, with the result of the scan of its law. If the fit already has friction at a site, the candidate
/// is a further slider, which makes the friction limit gradual.
pub(crate) fn scanned(
    survey: &OperatingPoints<'_>,
    sites: &Sites,
) -> Vec<(CandidateEffect, Scanned)> {
    let fitted = survey.fitted;
    let whole = Reduced::without(fitted, |_| false);
    let count = sites.all.len() as f64;
    let one = |at: usize| {
        let site = &sites.all[at];
        let is_there = |h: &&CandidateEffect| {
            h.cause == Cause::DryFriction && h.address == site.address && h.term != Term::Asymmetry
        };
        let there: Vec<_> = fitted.effects.iter().filter(is_there).collect();
        if there.len() >= MAX_SLIDERS || there.iter().any(|h| h.is_left_by_law()) {
            return None;
        }
        // A force of unknown law at the same site absorbs the effect of friction, so the scan removes it from the linear model.
        let is_rival = |h: &CandidateEffect| !h.is_in_catalogue() && h.address == site.address;
        let own = fitted.effects.iter().any(is_rival);
        let own = own.then(|| Reduced::without(fitted, is_rival));
        let Reduced {
            posterior,
            whitened,
        } = own.as_ref().unwrap_or(&whole).as_ref()?;
        let effect = &sites.effects[at];
        let model = SiteModel::new(fitted, effect, &fitted.sizes, posterior, whitened);
        let motion = SiteMotion {
            displacement: &site.displacement,
            compliance: &sites.compliance[at],
        };
        let scan = motion.scanned(&model, &priors(survey, site))?;
        let mut candidate = slider(
            survey,
            site,
            scan.starts[0].slider.slip_length,
            &scan.pattern,
        );
        candidate.ln_prior = libm::log(survey.priors().class_probability / count);
        if !there.is_empty() {
            candidate.term = Term::Further(there.len());
            candidate.ln_prior = libm::log(survey.priors().gradual_friction);
        }
        Some((candidate, scan))
    };
    (0..sites.all.len())
        .into_par_iter()
        .filter_map(one)
        .collect()
}

/// Returns a scanned slider with the slip length of a start. Also returns first guesses of its parameters, in units of their priors.
pub(crate) fn started(slider: &CandidateEffect, at: &SliderStart) -> (CandidateEffect, Vec<f64>) {
    let mut slider = slider.clone();
    if let Parametrisation::SlipLength { start, .. } = &mut slider.numbers[1].unknown {
        *start = at.slider.slip_length;
    }
    let [force, _, anchor] = [0, 1, 2].map(|k| &slider.numbers[k]);
    let guesses = vec![
        at.slider.limit / force.sd,
        0.0,
        (at.anchor - anchor.mean) / anchor.sd,
    ];
    (slider, guesses)
}

/// Returns the candidate for friction at one site. The law is the GFORCE `F max(-1, min(1, (anchor - u) / L))` with limit `F` and slip length
/// `L`. The anchor is the displacement at which the force is zero. It is stored in a VARIABLE, whose value passes from each case to the next.
/// `length` is the slip length with which a fit starts. `pattern` is the force in each case per unit of the limit.
pub(crate) fn slider(
    survey: &OperatingPoints<'_>,
    site: &Site,
    length: f64,
    pattern: &[f64],
) -> CandidateEffect {
    let Site { pair, axis, .. } = *site;
    let range = range(&site.displacement);
    let priors = priors(survey, site);
    let measure = survey.deflection_function(pair, axis);
    let anchor = survey.free_id("VARIABLE");
    let law = format!("0.0*MAX(-1.0,MIN(1.0,(VARVAL({anchor})-{measure})/1.0))");
    let (force, added) = survey.vector_force(pair, &[(axis, &law)]);
    let variable = statement("VARIABLE", anchor, &[("FUNCTION", "0.0".to_string())]);
    let changes: Vec<Change> = std::iter::once(variable)
        .chain(added)
        .map(Change::Add)
        .collect();
    let literal = |k: usize| Address::of_argument("GFORCE", force, FORCES[axis], Some(k));
    // Marker ids are literals too; the slip length is the last literal.
    let last = admire_syntax::Expression::parse_str(&law).map_or(0, |law| law.literals.len());
    let at_start = Address::of_argument("VARIABLE", anchor, "FUNCTION", Some(1));
    let wrench = pattern
        .iter()
        .map(|p| admire_solver::mechanics::Vec6::ith(axis, *p))
        .collect();
    CandidateEffect {
        cause: Cause::DryFriction,
        address: site.address.clone(),
        members: Vec::new(),
        side: "",
        form: "slider",
        numbers: vec![
            EffectParameter {
                column: Sensitivity::Wrench(pair, wrench),
                ..EffectParameter::new(
                    "force",
                    priors.limit,
                    Parametrisation::Extended(vec![(literal(1), 1.0)]),
                )
            },
            EffectParameter::new(
                "stiffness",
                priors.slip_length_ln_sd,
                Parametrisation::SlipLength {
                    address: literal(last),
                    start: length,
                    usual: priors.slip_length,
                },
            ),
            EffectParameter {
                mean: site.displacement[0],
                ..EffectParameter::new(
                    "anchor",
                    range,
                    Parametrisation::Extended(vec![(at_start.clone(), 1.0)]),
                )
            },
        ],
        ln_prior: 0.0,
        one_sided: true,
        changes,
        term: Term::Main,
        joint_with: None,
        memory: Some(MemoryPlan {
            anchor: at_start,
            carries: Evolution::Slider,
            by: literal(last),
            measure,
        }),
    }
}
