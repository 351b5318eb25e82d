//! Meaning of function names: the operation, the measured displacement or angle, the force component or the rate that each name denotes.

use super::intrinsic::{Binary, Unary};
use super::program::Kind;
use super::step::Shape;
use super::{ForceComponent, MeasureKind, RateAxis, RateKind, RotationSequence};

/// Returns the step kind of a function whose arguments are all values.
pub(super) fn plain_kind(name: &'static str) -> Option<Kind> {
    if let Some(function) = Unary::named(name) {
        return Some(Kind::Unary(function, name));
    }
    if let Some(function) = Binary::named(name) {
        return Some(Kind::Binary(function, name));
    }
    Some(match name {
        "MAX" => Kind::Max,
        "MIN" => Kind::Min,
        "STEP" => Kind::Step(Shape::Cubic, name),
        "STEP5" => Kind::Step(Shape::Quintic, name),
        "HAVSIN" => Kind::Step(Shape::Haversine, name),
        "IMPACT" => Kind::Impact,
        "BISTOP" => Kind::Bistop,
        "POLY" => Kind::Poly,
        "SHF" => Kind::Shf,
        "FORCOS" => Kind::Forcos,
        "FORSIN" => Kind::Forsin,
        "CHEBY" => Kind::Cheby,
        "SWEEP" => Kind::Sweep,
        _ => return None,
    })
}

/// Returns the displacement or angle that a function measures.
pub(super) fn measure_kind(name: &str) -> Option<MeasureKind> {
    let angle = |sequence, which, minus| MeasureKind::Angle {
        sequence,
        which,
        minus,
    };
    Some(match name {
        "DX" => MeasureKind::Displacement(0),
        "DY" => MeasureKind::Displacement(1),
        "DZ" => MeasureKind::Displacement(2),
        "DM" => MeasureKind::Distance,
        "AX" => MeasureKind::ProjectedAngle(0),
        "AY" => MeasureKind::ProjectedAngle(1),
        "AZ" => MeasureKind::ProjectedAngle(2),
        "PSI" => angle(RotationSequence::BODY_313, 0, false),
        "THETA" => angle(RotationSequence::BODY_313, 1, false),
        "PHI" => angle(RotationSequence::BODY_313, 2, false),
        "YAW" => angle(RotationSequence::BODY_321, 0, false),
        "PITCH" => angle(RotationSequence::BODY_321, 1, true),
        "ROLL" => angle(RotationSequence::BODY_321, 2, false),
        "INCANG" => MeasureKind::IncludedAngle,
        _ => return None,
    })
}

/// Returns the component of the force between two markers that a function measures.
pub(super) fn between_component(name: &str) -> Option<ForceComponent> {
    let names = ["FM", "FX", "FY", "FZ", "TM", "TX", "TY", "TZ"];
    names
        .iter()
        .position(|known| *known == name)
        .map(|index| ForceComponent::ALL[index])
}

/// Returns the velocity or acceleration that a function measures.
pub(super) fn rate_of(name: &str) -> Option<(RateKind, RateAxis)> {
    if name == "VR" {
        return Some((RateKind::Velocity, RateAxis::Along));
    }
    let axis = match name.as_bytes().last()? {
        b'X' => RateAxis::Axis(0),
        b'Y' => RateAxis::Axis(1),
        b'Z' => RateAxis::Axis(2),
        b'M' => RateAxis::Magnitude,
        _ => return None,
    };
    let kind = match &name[..name.len() - 1] {
        "V" => RateKind::Velocity,
        "W" => RateKind::AngularVelocity,
        "ACC" => RateKind::Acceleration,
        "WDT" => RateKind::AngularAcceleration,
        _ => return None,
    };
    Some((kind, axis))
}

/// Returns the marker role (I, J, K, L) of each argument. A magnitude has no K, an angular velocity no L.
pub(super) fn rate_places(kind: RateKind, axis: RateAxis) -> &'static [usize] {
    match (kind, axis) {
        (RateKind::AngularVelocity, RateAxis::Axis(_)) => &[0, 1, 2],
        // VR is the same in every frame, so its L is ignored.
        (RateKind::AngularVelocity, _) | (_, RateAxis::Along) => &[0, 1],
        (_, RateAxis::Magnitude) => &[0, 1, 3],
        (_, RateAxis::Axis(_)) => &[0, 1, 2, 3],
    }
}
