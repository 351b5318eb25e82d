//! Exchanged marks (outside the catalogue): from some case on, the marks of two parts are confused. The address names the two parts, such as
//! `KNUCKLE<->ROD`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants an exchange of marks. Values of the effect: `from=...`, the label of the first case with exchanged marks, and optionally `mark=...`,
/// the label of the only mark that is exchanged.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let Some((a, b)) = spec.address.split_once("<->") else {
        return Err(spec.refuse("the address must name two parts, for example KNUCKLE<->ROD"));
    };
    let (a, b) = (reality.marked(spec, a)?, reality.marked(spec, b)?);
    let Some(label) = spec.label("from") else {
        return Err(spec.refuse("needs from=..., the label of the first case with exchanged marks"));
    };
    let first = reality.case(spec, &label)?;
    let only = spec.label("mark");
    let mut pairs = Vec::new();
    for (i, label) in reality.marks[a].labels.iter().enumerate() {
        let wanted = only.as_ref().is_none_or(|only| only == label);
        let j = reality.marks[b].labels.iter().position(|own| own == label);
        if let Some(j) = j.filter(|_| wanted) {
            pairs.push((i, j));
        }
    }
    if pairs.is_empty() {
        return Err(spec.refuse(if only.is_some() {
            "the two parts have no mark of this name in common"
        } else {
            "the two parts have no mark in common"
        }));
    }
    reality.faults.push(ReadingFault::Exchanged {
        first,
        parts: [a, b],
        pairs,
    });
    Ok(())
}
