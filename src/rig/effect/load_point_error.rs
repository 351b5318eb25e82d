//! Load point error: a load that does not act at its marker but at a displaced point.

use super::{EffectSpec, GroundTruth};
use admire_session::backend::Load;
use admire_solver::mechanics::{Mat3, Pose};
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a load point error. Values of the effect: the displacement `x, y, z` in the axes of the marker's part. Only the loads at the marker
/// are displaced; other elements at the marker stay. With `law=growing`, which represents a wandering contact patch, the displacement grows
/// with the largest load at the marker. It is half the stated value if that load is zero.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let marker = reality.object(spec, &["MARKER"])?;
    let shift = spec.shift()?;
    let (_, _, frame) = reality.marker(spec, marker.id.unwrap_or(0))?;
    // `rehang` expects the shift in the marker's own axes.
    let own = frame.R.transpose() * shift;
    let at_marker = |load: &Load, reality: &GroundTruth| {
        let statement = reality.dataset.find(&load.target);
        statement
            .and_then(|statement| statement.first("I"))
            .is_some_and(|i| Some(i as u32) == marker.id)
    };
    let loads = reality.programme.loads.clone();
    let size = |k: usize| {
        let cases = reality.programme.cases.iter();
        cases.map(|case| case.values[k].abs()).fold(0.0, f64::max)
    };
    let largest = (0..loads.len())
        .filter(|k| at_marker(&loads[*k], reality))
        .max_by(|a, b| size(*a).total_cmp(&size(*b)));
    let Some(largest) = largest else {
        return Err(spec.refuse("no load of the study acts at this marker"));
    };
    let course = reality.course(spec, largest)?;
    for load in loads {
        if !at_marker(&load, reality) {
            continue;
        }
        let object = Address {
            argument: None,
            index: None,
            ..load.target
        };
        let displacement = Pose {
            p: own,
            R: Mat3::identity(),
        };
        let new = reality.rehang(spec, &object, "I", None, &displacement)?;
        if course.iter().all(|share| *share == 1.0) {
            continue;
        }
        for k in 0..3 {
            let target = Address {
                kind: "MARKER".to_string(),
                id: Some(new),
                argument: Some("QP".to_string()),
                index: Some(k + 1),
            };
            reality.programme.loads.push(Load {
                name: target.to_string(),
                target,
            });
            for (case, share) in reality.programme.cases.iter_mut().zip(&course) {
                case.values.push(frame.p[k] + share * shift[k]);
            }
        }
    }
    Ok(())
}
