//! Mark outlier: a wrong reading of one mark. The address names the case, the part and the mark, such as `case 7 KNUCKLE 3`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a mark outlier. Values of the effect: the error `x, y, z` of the reading in ground axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let words: Vec<&str> = spec.address.split_whitespace().collect();
    let ["case", label, part, mark] = words.as_slice() else {
        return Err(spec.refuse("the address must name a reading, for example `case 7 KNUCKLE 3`"));
    };
    let case = reality.case(spec, label)?;
    let part = reality.marked(spec, part)?;
    let labels = &reality.marks[part].labels;
    let Some(mark) = labels.iter().position(|own| own == mark) else {
        return Err(spec.refuse(format!("the part has no mark `{mark}`")));
    };
    let shift = spec.shift()?;
    reality.faults.push(ReadingFault::Mark {
        case,
        part,
        mark,
        shift,
    });
    Ok(())
}
