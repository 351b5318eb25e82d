//! `progressive-stiffness`: the stiffness of a bushing component changes with the deflection.
//!
//! The added force is a sum of terms that begin at a deflection `a`, `-c sgn(u) max(0, |u| - a)^p`. A power law is one term that begins at zero. In
//! the spline, the stiffness changes linearly between knots at zero, one third, two thirds and all of the largest deflection.
//!
//! The x and y components of a bushing of Adams/Car depend on the radial deflection `r = sqrt(x^2 + y^2)`. There a term is
//! `-c (x/r) max(0, r - a)^p`.

use admire_solver::mechanics::Vec6;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, FORCES, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::elastic_element::ElasticElement;
use super::super::operating_points::OperatingPoints;
use crate::settings::ROUND_OFF_DEFLECTION;
use admire_syntax::{Address, Expression};

/// Names of the parameters of the spline: changes of the stiffness over each third of the largest deflection.
pub const STIFFNESS_RISES: [&str; 3] = ["rise_first_third", "rise_second_third", "rise_last_third"];
/// Name of the largest deflection among the parameters of a finding with a spline.
pub const LARGEST_DEFLECTION: &str = "largest_deflection";
/// Name of the largest radial deflection among the parameters of a finding with a spline over the radial deflection.
pub const LARGEST_RADIAL_DEFLECTION: &str = "largest_radial_deflection";
/// Name of the form with a spline over the deflection of the component.
const SPLINE: &str = "spline";
/// Name of the form with a spline over the radial deflection.
const RADIAL_SPLINE: &str = "radial spline";

/// Returns the terms of the spline with these changes of the stiffness over each third of the largest deflection. Each entry holds the deflection
/// `a` at which a term begins, and its coefficient `c`. The restoring force is `c sgn(u) max(0, |u| - a)^2`.
pub fn spline_terms(largest: f64, rises: [f64; 3]) -> [[f64; 2]; 3] {
    let third = largest / 3.0;
    // The slope of the stiffness is constant over a third. A term has half of the change of this slope at the knot where it begins.
    let before = [0.0, rises[0], rises[1]];
    std::array::from_fn(|k| [k as f64 * third, 0.5 * (rises[k] - before[k]) / third])
}

/// Returns the largest deflection of the spline of a candidate, with its name among the parameters of a finding; `None` for another law.
pub(crate) fn largest_deflection(effect: &CandidateEffect) -> Option<(&'static str, f64)> {
    let name = match effect.form {
        SPLINE => LARGEST_DEFLECTION,
        RADIAL_SPLINE => LARGEST_RADIAL_DEFLECTION,
        _ => return None,
    };
    match &effect.numbers.last()?.unknown {
        // The last rise has one term, whose coefficient is half of the reciprocal of a third.
        Parametrisation::Extended(pairs) => pairs.first().map(|(_, c)| (name, 1.5 / c)),
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
    /// Returns the force of the term for a unit coefficient, at a deflection of the component.
    fn rise(&self, at: LawDeflection) -> f64 {
        (at.size - self.from).max(0.0).powi(self.power) * at.direction
    }

    /// Returns the ADAMS function expression of the term with the coefficient zero, which is its first literal.
    fn text(&self, measure: &LawMeasure) -> String {
        let u = &measure.component;
        match (self.from, self.power, &measure.radial) {
            (0.0, 2, None) => format!("-0.0*{u}*ABS({u})"),
            (0.0, power, None) => format!("-0.0*{u}**{power}"),
            (0.0, 2, Some(r)) => format!("-0.0*{u}*{r}"),
            (0.0, power, Some(r)) => format!("-0.0*{u}*{r}**{}", power - 1),
            (from, power, None) => {
                format!("-0.0*SIGN(1.0,{u})*MAX(0.0,ABS({u})-{from:E})**{power}")
            }
            (from, power, Some(r)) => format!("-0.0*{u}/{r}*MAX(0.0,{r}-{from:E})**{power}"),
        }
    }
}

/// Deflection on which the law of a component depends.
#[derive(Clone, Copy)]
struct LawDeflection {
    /// Magnitude: the absolute deflection of the component, or the radial deflection.
    size: f64,
    /// Share of the force that acts along the component: a sign, or the direction cosine of the radial deflection.
    direction: f64,
}

impl LawDeflection {
    /// Returns the deflection of a component; `partner` is the deflection of the other component with which it shares its radial deflection.
    fn new(u: f64, partner: Option<f64>) -> Self {
        let size = libm::hypot(u, partner.unwrap_or(0.0));
        let direction = if size > 0.0 { u / size } else { 0.0 };
        Self { size, direction }
    }
}

/// ADAMS function expressions of a [`LawDeflection`].
struct LawMeasure {
    /// Deflection of the component.
    component: String,
    /// Radial deflection; `None` if the law depends on the component alone.
    radial: Option<String>,
}

/// Component of an elastic element, with the deflection on which a law of it depends.
struct LawSite<'a> {
    element: &'a ElasticElement,
    axis: usize,
    measure: LawMeasure,
    /// Deflection in each case.
    deflections: Vec<LawDeflection>,
    /// Largest deflection in all cases.
    largest: f64,
}

impl<'a> LawSite<'a> {
    /// Returns the site of a law that depends on the component alone, or on the radial deflection of the component and its `partner`. Returns `None`
    /// if that deflection is zero.
    fn new(
        survey: &OperatingPoints<'_>,
        element: &'a ElasticElement,
        axis: usize,
        partner: Option<usize>,
    ) -> Option<Self> {
        let of = |axis| survey.deflection_function(element.pair, axis);
        // A square root has no derivative at zero. The added length of one nanometre does not change the law.
        let nanometre = 1e-6 * survey.millimetre();
        let square = nanometre * nanometre;
        let radial = |partner| format!("SQRT({}**2+{}**2+{square:E})", of(axis), of(partner));
        let measure = LawMeasure {
            component: of(axis),
            radial: partner.map(radial),
        };
        let deflection =
            |d: &[f64; 6]| LawDeflection::new(d[axis], partner.map(|partner| d[partner]));
        let deflections: Vec<LawDeflection> = element.deflections.iter().map(deflection).collect();
        let largest = deflections.iter().fold(0.0_f64, |m, u| m.max(u.size));
        (largest > ROUND_OFF_DEFLECTION).then_some(Self {
            element,
            axis,
            measure,
            deflections,
            largest,
        })
    }

    /// Returns the candidate with one form of the law.
    fn candidate(&self, survey: &OperatingPoints<'_>, form: &LawForm) -> CandidateEffect {
        let (pair, axis) = (self.element.pair, self.axis);
        let texts: Vec<String> = form
            .terms
            .iter()
            .map(|term| term.text(&self.measure))
            .collect();
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
        let numbers = form.numbers.iter().map(|number| {
            let force = |u: LawDeflection| {
                let each = form.terms.iter().zip(&number.coefficients);
                each.map(|(term, factor)| factor * term.rise(u))
                    .sum::<f64>()
            };
            let each = self.deflections.iter();
            let wrench = each.map(|u| Vec6::ith(axis, -force(*u))).collect();
            let each = coefficients
                .iter()
                .cloned()
                .zip(number.coefficients.iter().copied());
            let acting = each.filter(|(_, factor)| *factor != 0.0).collect();
            EffectParameter {
                column: Sensitivity::Wrench(pair, wrench),
                ..EffectParameter::new(number.name, number.sd, Parametrisation::Extended(acting))
            }
        });
        CandidateEffect {
            cause: Cause::ProgressiveStiffness,
            address: self.element.address(axis),
            members: Vec::new(),
            side: "",
            form: match &self.measure.radial {
                Some(_) if form.name == SPLINE => RADIAL_SPLINE,
                _ => form.name,
            },
            numbers: numbers.collect(),
            ln_prior: 0.0,
            one_sided: form.numbers.len() == 1,
            changes: changes.into_iter().map(Change::Add).collect(),
            memory: None,
            term: Term::Main,
            joint_with: None,
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

/// Adds candidates for a nonlinear law in each component of each elastic element. The x and y components of a round bushing depend on their
/// common radial deflection, so a spline over this deflection is a further form of their laws.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let usual = survey.priors().progressive_stiffness;
    for element in ElasticElement::all(survey) {
        let stiff = (0..6).filter(|axis| element.stiffness[*axis] > 0.0);
        for axis in stiff {
            let partner = (axis < 2).then(|| 1 - axis);
            let is_radial = partner.is_some() && element.is_radial;
            let own = (!is_radial).then(|| LawSite::new(survey, &element, axis, None));
            let radial = partner
                .filter(|partner| is_radial || element.moves(*partner))
                .map(|partner| LawSite::new(survey, &element, axis, Some(partner)));
            for site in [own, radial].into_iter().flatten().flatten() {
                let is_further = site.measure.radial.is_some() && !is_radial;
                let forms = forms(element.stiffness[axis], site.largest, usual);
                let own = forms
                    .iter()
                    .filter(|form| !is_further || form.name == SPLINE);
                out.extend(own.map(|form| site.candidate(survey, form)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the stiffness of the spline rises by the stated values over each third. All forms must have about the same prior force at the
    /// largest deflection, and every term must be an odd function of the deflection.
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
                let end = LawDeflection::new(largest, None);
                let sum: f64 = each.map(|(term, c)| c * term.rise(end)).sum();
                sum * number.sd
            };
            let all: f64 = form.numbers.iter().map(|n| force(n).powi(2)).sum();
            let ratio = all.sqrt() / (0.5 * 1000.0 * largest);
            assert!((0.9..=1.2).contains(&ratio), "{}: {ratio}", form.name);
            let rise = |term: &LawTerm, u| term.rise(LawDeflection::new(u, None));
            let odd = |term: &LawTerm| (rise(term, -1.5) + rise(term, 1.5)).abs() < 1e-12;
            assert!(form.terms.iter().all(odd));
        }
    }
}
