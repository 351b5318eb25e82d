//! Channel fault: a channel (scalar sensor) with a wrong gain, a wrong zero, or a single wrong value.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a channel fault. Values of the effect: `gain=...`, `offset=...` or both. With `case=...`, only the reading in that case is wrong.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let found = reality
        .channels
        .iter()
        .position(|name| *name == spec.address);
    let Some(channel) = found else {
        return Err(spec.refuse(format!("the study has no channel `{}`", spec.address)));
    };
    let (gain, offset) = (spec.optional("gain")?, spec.optional("offset")?);
    if gain.is_none() && offset.is_none() {
        return Err(spec.refuse("needs gain=... or offset=..."));
    }
    let case = match spec.label("case") {
        Some(label) => Some(reality.case(spec, &label)?),
        None => None,
    };
    reality.faults.push(ReadingFault::Channel {
        channel,
        gain: gain.unwrap_or(1.0),
        offset: offset.unwrap_or(0.0),
        case,
    });
    Ok(())
}
