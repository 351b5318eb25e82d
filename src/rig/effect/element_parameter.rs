//! Element parameter: wrong value of a deck parameter that is assumed to be known.

use super::{EffectSpec, GroundTruth};
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a wrong element parameter. Value of the effect: exactly one of `value=...` (the new value), `factor=...` (a factor on the deck's
/// value) and `delta=...` (a change of the deck's value).
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address =
        Address::parse(&spec.address, &reality.dataset).map_err(|why| spec.refuse(why.message))?;
    let Some(deck) = reality.dataset.value_at(&address) else {
        return Err(spec.refuse("the address must name a number of the deck"));
    };
    let (value, factor, delta) = (
        spec.optional("value")?,
        spec.optional("factor")?,
        spec.optional("delta")?,
    );
    let value = match (value, factor, delta) {
        (Some(value), None, None) => value,
        (None, Some(factor), None) => deck * factor,
        (None, None, Some(delta)) => deck + delta,
        _ => return Err(spec.refuse("needs exactly one of value=..., factor=... and delta=...")),
    };
    reality.set(&address, value)
}
