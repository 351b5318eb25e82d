//! The load acts elsewhere than at its marker.

use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// `x, y, z` in the axes of the marker's part. Only loads move; what else sits at the marker stays.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let marker = reality.object(spec, &["MARKER"])?;
    let shift = spec.shift()?;
    let (_, _, frame) = reality.marker(spec, marker.id.unwrap_or(0))?;
    // Rehanging shifts in the marker's own axes.
    let own = frame.R.transpose() * shift;
    let mut found = false;
    for load in reality.programme.loads.clone() {
        let at_marker = reality
            .dataset
            .find(&load.target)
            .and_then(|statement| statement.first("I"))
            .is_some_and(|i| Some(i as u32) == marker.id);
        if at_marker {
            found = true;
            let object = crate::syntax::Address {
                argument: None,
                index: None,
                ..load.target
            };
            let still = crate::mechanics::Mat3::identity();
            reality.rehang(spec, (&object, "I"), None, (&own, &still))?;
        }
    }
    if found {
        Ok(())
    } else {
        Err(spec.refuse("no load of the study acts at that marker"))
    }
}
