//! Parts of a deck by their names in a study.

use admire_solver::model::{Model, PartIx};

/// Returns the part with this id (such as `4`), address (such as `PART/4`) or view name (such as `KNUCKLE`).
pub fn part(name: &str, model: &Model) -> Option<PartIx> {
    let name = name.trim();
    let number = match name.split_once('/') {
        Some((kind, id)) => ["PART", "POINT_MASS", "FLEX_BODY"]
            .contains(&kind.trim().to_uppercase().as_str())
            .then(|| id.trim().parse::<u32>().ok())
            .flatten(),
        None => name.parse::<u32>().ok(),
    };
    if let Some(id) = number {
        let found = model.parts.iter().position(|part| part.header.id == id);
        return found.map(PartIx);
    }
    if name.eq_ignore_ascii_case("ground") {
        return model.ground();
    }
    let exact = model.parts.iter().position(|part| part.header.name == name);
    // A view name with dots may also be given by its last component alone.
    let last = |part: &admire_solver::model::Part| {
        part.header
            .name
            .rsplit('.')
            .next()
            .is_some_and(|piece| piece.eq_ignore_ascii_case(name))
    };
    let loose = || {
        let mut found = (0..model.parts.len()).filter(|&at| last(&model.parts[at]));
        found.next().filter(|_| found.next().is_none())
    };
    exact.or_else(loose).map(PartIx)
}
