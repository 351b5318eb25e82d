//! Tables of detection limits.

use super::ranking::{is_rotation, unit};
use super::{Align, Scene, Table, number, short_unit};
use admire_diagnosis::{Cause, CauseLimit, Diagnosis, STIFFNESS_RISES};
use admire_identify::LoadedStudy;

/// Parameters of higher-order terms of force laws. Their limits are omitted, because the limit of the first term is more informative.
const HIGHER: [&str; 3] = ["quadratic", "hardening", "growth"];

/// Tabulates the detection limits of the hardpoints.
pub(crate) fn of_points(diagnosis: &Diagnosis, scene: &Scene) -> Table {
    let mut table = Table::new(&[
        ("hardpoint", Align::Left),
        ("x, mm", Align::Right),
        ("y, mm", Align::Right),
        ("z, mm", Align::Right),
    ]);
    for limit in &diagnosis.detection_limits {
        let [x, y, z] = limit
            .mm
            .map(|mm| mm.map_or_else(String::new, |mm| format!("{mm:.2}")));
        table.row([scene.named_all(&limit.members), x, y, z]);
    }
    table
}

/// Tabulates the detection limits of the causes other than displaced hardpoints, one line for each kind of parameter.
pub(crate) fn of_causes(diagnosis: &Diagnosis, loaded: &LoadedStudy, scene: &Scene) -> Table {
    let mut table = Table::new(&[
        ("cause", Align::Left),
        ("parameter", Align::Left),
        ("unit", Align::Left),
        ("smallest limit", Align::Right),
        ("place of smallest limit", Align::Left),
        ("largest limit", Align::Right),
        ("place of largest limit", Align::Left),
        ("places not detected", Align::Right),
    ]);
    let all = &diagnosis.cause_limits;
    // All limits in a line have the same unit. Torques of a bushing are therefore separate from its forces, and spring rates from spring
    // lengths.
    let of = |limit: &CauseLimit| {
        let own = limit.number.as_str();
        let argument = limit.address.split('.').nth(1).unwrap_or_default();
        let name = match limit.cause {
            Cause::ElementParameter => format!("{own} of {argument}"),
            _ if is_rotation(&limit.address) => format!("{own}, rotation"),
            _ => own.to_string(),
        };
        (limit.cause, name)
    };
    let mut known: Vec<(Cause, String)> = Vec::new();
    for limit in all {
        let own = limit.number.as_str();
        let is_higher = HIGHER.contains(&own) || STIFFNESS_RISES.contains(&own);
        let is_shown = limit.cause != Cause::BushingCoupling && !is_higher;
        if is_shown && !known.contains(&of(limit)) {
            known.push(of(limit));
        }
    }
    for kind in known {
        let places = || all.iter().filter(|limit| of(limit) == kind);
        let seen = places().filter_map(|l| Some((l.size?, l.address.as_str())));
        let mut seen: Vec<(f64, &str)> = seen.collect();
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (cause, name) = kind.clone();
        let (Some(best), Some(worst)) = (seen.first(), seen.last()) else {
            continue;
        };
        let size = |(size, _): &(f64, &str)| number(*size, Some(size.abs() * 0.1));
        let at = |(_, address): &(f64, &str)| scene.named(address);
        let one = places()
            .next()
            .map(|l| unit(l.cause, &l.address, &l.number, loaded));
        table.row([
            cause.as_str().to_string(),
            name,
            short_unit(&one.unwrap_or_default()),
            size(best),
            at(best),
            size(worst),
            at(worst),
            (places().count() - seen.len()).to_string(),
        ]);
    }
    table
}
