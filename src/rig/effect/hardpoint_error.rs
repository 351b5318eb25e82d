//! The connection point of a joint or spring is not where the deck puts it.

use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// `x, y, z` in the axes of the marker's part.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let marker = reality.object(spec, &["MARKER"])?;
    let shift = spec.shift()?;
    reality.shift_marker(spec, &marker, &shift)
}
