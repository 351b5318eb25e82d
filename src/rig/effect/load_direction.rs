//! Load direction (outside the catalogue): the rig applies a load in a direction that differs from the direction in the deck.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a wrong load direction. Values of the effect: the rotation vector `ax_deg, ay_deg, az_deg` in the axes of the marker that defines the
/// direction. That marker is J for an action-only SFORCE, and RM for a GFORCE or VFORCE.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let load = reality.load(spec, &spec.address)?;
    let turn = spec.turn()?;
    let target = reality.programme.loads[load].target.clone();
    let Some(argument) = direction_of(reality, &target) else {
        return Err(spec.refuse(format!("{target} has no direction that can be turned")));
    };
    let object = Address {
        argument: None,
        index: None,
        ..target
    };
    let rotation = Pose {
        p: Vec3::zeros(),
        R: turn,
    };
    reality
        .rehang(spec, &object, argument, None, &rotation)
        .map(drop)
}

/// Returns the name of the argument whose marker defines the direction of a load; `None` if no marker alone defines it.
pub(crate) fn direction_of(reality: &GroundTruth, target: &Address) -> Option<&'static str> {
    let object = Address {
        argument: None,
        index: None,
        ..target.clone()
    };
    let statement = reality.dataset.find(&object)?;
    match target.kind.as_str() {
        "SFORCE" if statement.has("ACTIONONLY") => Some("J"),
        "GFORCE" | "VFORCE" if statement.first("RM").is_some() => Some("RM"),
        _ => None,
    }
}
