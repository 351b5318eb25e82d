//! `progressive-stiffness`: the stiffness of a bushing component changes with the deflection.
//!
//! The added force is a sum of terms that begin at a deflection `a`, `-c sgn(u) max(0, |u| - a)^p`. A power law is one term that begins at zero. In
//! the spline, the stiffness changes linearly between knots at zero, one third, two thirds and all of the largest deflection.

use admire_solver::mechanics::Vec6;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use admire_syntax::{Address, Expression};

/// Names of the parameters of the spline: changes of the stiffness over each third of the largest deflection.
pub const STIFFNESS_RISES: [&str; 3] = ["rise_first_third", "rise_second_third", "rise_last_third"];
/// Name of the largest deflection among the parameters of a finding with a spline.
pub const LARGEST_DEFLECTION: &str = "largest_deflection";
/// Name of the form with the spline.
const SPLINE: &str = "spline";

/// Returns the terms of the spline with these changes of the stiffness over each third of the largest deflection. Each entry holds the deflection
/// `a` at which a term begins, and its coefficient `c`. The restoring force is `c sgn(u) max(0, |u| - a)^2`.
pub fn spline_terms(largest: f64, rises: [f64; 3]) -> [[f64; 2]; 3] {
    let third = largest / 3.0;
    // The slope of the stiffness is constant over a third. A term has half of the change of this slope at the knot where it begins.
    let before = [0.0, rises[0], rises[1]];
    std::array::from_fn(|k| [k as f64 * third, 0.5 * (rises[k] - before[k]) / third])
}

/// Returns the largest deflection of the spline of a candidate; `None` for another law.
pub(crate) fn largest_deflection(effect: &CandidateEffect) -> Option<f64> {
    let last = effect.numbers.last().filter(|_| effect.form == SPLINE)?;
    match &last.unknown {
        // The last rise has one term, whose coefficient is half of the reciprocal of a third.
        Parametrisation::Extended(pairs) => pairs.first().map(|(_, c)| 1.5 / c),
        _ => None,
    }
}

/// Term of an added force: it begins at a deflection `from` and grows with a power of the deflection beyond.
#[derive(Clone, Copy)]
struct LawTerm {
    from: f64,
    power: i32,
}

/// Parameter of an added force: name, prior standard deviation, and the coefficient of each term per unit of the parameter.
struct LawNumber {
    name: &'static str,
    sd: f64,
    coefficients: Vec<f64>,
}

/// Form of the law. Every added force is odd in the deflection.
struct LawForm {
    name: &'static str,
    terms: Vec<LawTerm>,
    numbers: Vec<LawNumber>,
}

impl LawTerm {
    /// Returns the force of the term for a unit coefficient.
    fn rise(&self, u: f64) -> f64 {
        (u.abs() - self.from).max(0.0).powi(self.power) * u.signum()
    }

    /// Returns the ADAMS function expression of the term with the coefficient zero, which is its first literal. `measure` is the expression of
    /// the deflection.
    fn text(&self, measure: &str) -> String {
        match (self.from, self.power) {
            (0.0, 2) => format!("-0.0*{measure}*ABS({measure})"),
            (0.0, power) => format!("-0.0*{measure}**{power}"),
            (from, power) => {
                format!("-0.0*SIGN(1.0,{measure})*MAX(0.0,ABS({measure})-{from:E})**{power}")
            }
        }
    }
}

/// Returns the forms of the law for a component with this stiffness and largest deflection. `usual` is the prior size of the added force at the
/// largest deflection, relative to the linear force.
fn forms(stiffness: f64, largest: f64, usual: f64) -> [LawForm; 3] {
    let power = |name, power: i32| LawForm {
        name,
        terms: vec![LawTerm { from: 0.0, power }],
        numbers: vec![LawNumber {
            name,
            sd: usual * stiffness * largest / largest.powi(power),
            coefficients: vec![1.0],
        }],
    };
    let rise = |k: usize| {
        let mut rises = [0.0; 3];
        rises[k] = 1.0;
        LawNumber {
            name: STIFFNESS_RISES[k],
            // Equal changes over all thirds, of one standard deviation of their sum, add the usual force at the largest deflection.
            sd: 2.0 * usual * stiffness / 3f64.sqrt(),
            coefficients: spline_terms(largest, rises).map(|[_, c]| c).to_vec(),
        }
    };
    let term = |[from, _]: [f64; 2]| LawTerm { from, power: 2 };
    let spline = LawForm {
        name: SPLINE,
        terms: spline_terms(largest, [0.0; 3]).map(term).to_vec(),
        numbers: (0..3).map(rise).collect(),
    };
    [power("cubic", 3), power("quadratic", 2), spline]
}

/// Adds candidates for a law that is not linear in every component of every elastic element.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let usual = survey.priors().progressive_stiffness;
    for element in ElasticElement::all(survey) {
        let (pair, stiffness) = (element.pair, element.stiffness);
        for axis in 0..6 {
            let u: Vec<f64> = element.deflections.iter().map(|d| d[axis]).collect();
            let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            if largest < 1e-9 || stiffness[axis] <= 0.0 {
                continue;
            }
            let measure = survey.deflection_function(pair, axis);
            for form in forms(stiffness[axis], largest, usual) {
                let texts: Vec<String> =
                    form.terms.iter().map(|term| term.text(&measure)).collect();
                let (gforce, changes) = survey.vector_force(pair, &[(axis, &texts.concat())]);
                // The coefficient is the first literal of its term. The other literals of a term are marker ids and constants.
                let mut first = 1;
                let coefficients: Vec<Address> = texts
                    .iter()
                    .map(|text| {
                        let own = first;
                        first += Expression::parse_str(text).map_or(0, |text| text.literals.len());
                        Address::of_argument("GFORCE", gforce, FORCES[axis], Some(own))
                    })
                    .collect();
                let is_power = form.numbers.len() == 1;
                let numbers = form.numbers.iter().map(|number| {
                    let force = |u: f64| {
                        let each = form.terms.iter().zip(&number.coefficients);
                        each.map(|(term, factor)| factor * term.rise(u))
                            .sum::<f64>()
                    };
                    let wrench = u.iter().map(|u| Vec6::ith(axis, -force(*u))).collect();
                    let each = coefficients
                        .iter()
                        .cloned()
                        .zip(number.coefficients.iter().copied());
                    let acting = each.filter(|(_, factor)| *factor != 0.0).collect();
                    EffectParameter {
                        column: Sensitivity::Wrench(pair, wrench),
                        ..EffectParameter::new(
                            number.name,
                            number.sd,
                            Parametrisation::Extended(acting),
                        )
                    }
                });
                out.push(CandidateEffect {
                    cause: Cause::ProgressiveStiffness,
                    address: element.address(axis),
                    members: Vec::new(),
                    side: "",
                    form: form.name,
                    numbers: numbers.collect(),
                    ln_prior: 0.0,
                    one_sided: is_power,
                    changes: changes.into_iter().map(Change::Add).collect(),
                    memory: None,
                    term: Term::Main,
                    joint_with: None,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stiffness of the spline rises by the stated values over each third, and its force is the same in every third as the integral of the
    /// stiffness.
    #[test]
    fn a_spline_has_the_stated_rises() {
        let (largest, rises) = (1.8, [30.0, -50.0, 10.0]);
        let terms = spline_terms(largest, rises);
        let stiffness = |u: f64| -> f64 {
            let each = terms.iter();
            each.map(|[a, c]| 2.0 * c * (u - a).max(0.0)).sum()
        };
        for (u, expected) in [
            (0.0, 0.0),
            (0.6, 30.0),
            (0.9, 5.0),
            (1.2, -20.0),
            (1.8, -10.0),
        ] {
            assert!((stiffness(u) - expected).abs() < 1e-9, "{u}");
        }
        for form in forms(1000.0, largest, 0.5) {
            // The prior allows the same force at the largest deflection, whatever the form.
            let force = |number: &LawNumber| -> f64 {
                let each = form.terms.iter().zip(&number.coefficients);
                let sum: f64 = each.map(|(term, c)| c * term.rise(largest)).sum();
                sum * number.sd
            };
            let all: f64 = form.numbers.iter().map(|n| force(n).powi(2)).sum();
            let ratio = all.sqrt() / (0.5 * 1000.0 * largest);
            assert!((0.9..=1.2).contains(&ratio), "{}: {ratio}", form.name);
            let odd = |term: &LawTerm| (term.rise(-1.5) + term.rise(1.5)).abs() < 1e-12;
            assert!(form.terms.iter().all(odd));
        }
    }
}
