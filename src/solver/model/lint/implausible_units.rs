use super::Design;
use crate::mechanics::Vec3;
use crate::model::{Model, PartKind};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Maximum plausible length of a mechanism, m.
const LONGEST: f64 = 1e3;
/// Length of a mechanism in m above which [`LIGHTEST`] is checked.
const LONG: f64 = 50.0;
/// Minimum plausible mass per length of a mechanism, kg/m; a rope of 10 mm diameter has 0.5 kg/m.
const LIGHTEST: f64 = 0.3;
/// Maximum plausible mass per cube of the mechanism's size, kg/m^3; iron has 8e3, osmium 2e4.
const DENSEST: f64 = 1e8;
/// Plausible range of gravity relative to standard gravity on Earth; the Moon has 0.17, Jupiter 2.5.
const GRAVITY: std::ops::Range<f64> = 0.1..10.0;
/// Maximum plausible stiffness of a bushing, N/m; a cube of steel of 1 m^3 has 2e11.
const STIFFEST: f64 = 1e14;
/// Maximum plausible total mass of all parts, kg; the largest ships have 7e8.
const HEAVIEST: f64 = 1e10;

/// Standard gravity of the Earth, m/s^2.
const G0: f64 = 9.80665;

/// Reports a mechanism whose quantities are implausible in its stated units: a warning for one quantity, an error for two or more. Decks
/// without UNITS are not checked.
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let model = design.model;
    let Some(stated) = design.dataset.statement("UNITS", None) else {
        return;
    };
    if !model.units.stated {
        return;
    }
    let reasons = reasons(design);
    let (Some(first), several) = (reasons.first(), reasons.len() > 1) else {
        return;
    };
    let units = &model.units;
    let message = format!(
        "with UNITS in {}, {}, {} and {}, {}",
        units.force.word,
        units.mass.word,
        units.length.word,
        units.time.word,
        if several {
            reasons.join(", and ")
        } else {
            first.clone()
        }
    );
    let diagnostic = if several {
        Diagnostic::error(Code::ImplausibleUnits, message)
    } else {
        Diagnostic::warning(Code::ImplausibleUnits, message)
    };
    found.push(
        diagnostic
            .label(design.dataset.source().name(), stated.keyword, "")
            .help("UNITS states the units of the numbers; it does not convert them"),
    );
}

fn reasons(design: &Design<'_>) -> Vec<String> {
    let model = design.model;
    let units = &model.units;
    let (metre, kilogram) = (units.length.si, units.mass.si);
    let mut reasons = Vec::new();
    let mass = kilogram * model.parts.iter().map(|part| part.mass).sum::<f64>();
    let length = metre * extent(design);
    if length > LONGEST || (length > LONG && mass > 0.0 && mass / length < LIGHTEST) {
        reasons.push(format!(
            "the mechanism has a length of {} m and a mass of {} kg",
            short(length),
            short(mass)
        ));
    }
    let size = length.max(2.0 * metre * widest(model));
    if size > 0.0 && mass / size.powi(3) > DENSEST {
        reasons.push(format!(
            "a mass of {} kg is concentrated within {} m",
            short(mass),
            short(size)
        ));
    }
    let gravity = model.gravity.norm() * metre / units.time.si.powi(2);
    if gravity > 0.0 && !GRAVITY.contains(&(gravity / G0)) {
        reasons.push(format!("gravity is {} m/s2, not 9.81", short(gravity)));
    }
    let stiffest = metre.recip() * units.force.si * stiffest(model);
    if stiffest > STIFFEST {
        reasons.push(format!("a stiffness is {} N/m", short(stiffest)));
    }
    if mass > HEAVIEST {
        reasons.push(format!("the total mass is {} kg", short(mass)));
    }
    reasons
}

/// Formats a value with three significant digits, with an exponent for very small and very large values.
fn short(value: f64) -> String {
    if (1e-3..1e6).contains(&value) {
        let places = (2 - libm::log10(value).floor() as i32).max(0) as usize;
        format!("{value:.places$}")
    } else {
        format!("{value:.2e}")
    }
}

/// Returns the diagonal of the bounding box of the markers of all moving parts, in the deck's units.
fn extent(design: &Design<'_>) -> f64 {
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for (at, marker) in design.model.markers.iter().enumerate() {
        let part = &design.model.parts[marker.part.0];
        if part.kind == PartKind::Ground {
            continue;
        }
        if let Some(pose) = design.pose(crate::model::MarkerIx(at)) {
            (low, high) = (low.inf(&pose.p), high.sup(&pose.p));
        }
    }
    let diagonal = (high - low).norm();
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

/// Returns the largest radius of gyration of all parts, in the deck's units.
fn widest(model: &Model) -> f64 {
    let radius = |part: &crate::model::Part| {
        let most = part.ip[..3].iter().copied().fold(0.0, f64::max);
        if part.mass > 0.0 {
            (most / part.mass).sqrt()
        } else {
            0.0
        }
    };
    model.parts.iter().map(radius).fold(0.0, f64::max)
}

/// Returns the largest translational stiffness of all bushings, in the deck's units.
fn stiffest(model: &Model) -> f64 {
    let bushings = model.bushings.iter().flat_map(|bushing| bushing.k);
    bushings.fold(0.0, f64::max)
}
