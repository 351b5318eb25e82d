//! Mark place: a mark is not at its listed position on its part. The address names the part and the mark, such as `KNUCKLE 3`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a wrong mark place. Values of the effect: the displacement `x, y, z` in the frame of the part, and optionally `from=...`, the label
/// of the case in which the mark came loose.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let words: Vec<&str> = spec.address.split_whitespace().collect();
    let [part, mark] = words.as_slice() else {
        return Err(spec.refuse("the address must name a mark, for example `KNUCKLE 3`"));
    };
    let part = reality.marked(spec, part)?;
    let labels = &reality.marks[part].labels;
    let Some(mark) = labels.iter().position(|own| own == mark) else {
        return Err(spec.refuse(format!("the part has no mark `{mark}`")));
    };
    let first = match spec.label("from") {
        Some(label) => reality.case(spec, &label)?,
        None => 0,
    };
    let shift = spec.shift()?;
    reality.faults.push(ReadingFault::Place {
        first,
        part,
        mark,
        shift,
    });
    Ok(())
}
