//! Errors of a usual axle and rig, as changes of the readings. An effect that these errors explain as well is not detectable.

use admire_solver::model::Model;
use nalgebra::DVector;

use super::detect::Span;

/// Usual error of a hardpoint, in mm.
const HARDPOINT: f64 = 0.2;
/// Usual displacement of the two sides of a bushing, in mm.
const ASSEMBLY_OFFSET: f64 = 0.05;
/// Usual rotation of a bushing, in degrees.
const ORIENTATION_DEG: f64 = 0.1;
/// Usual error of the point where a load acts, in mm.
const LOAD_POINT: f64 = 0.5;
/// Usual relative error of all values of a load.
const LOAD_GAIN: f64 = 0.003;
/// Usual error of a load in one case, relative to its largest value.
const LOAD_REPEATABILITY: f64 = 0.001;
/// Usual fraction of a load that also acts along another load.
const LOAD_CROSSTALK: f64 = 0.001;
/// Usual relative error of a spring rate.
const SPRING_RATE: f64 = 0.015;
/// Usual relative error of a preload.
const PRELOAD: f64 = 0.003;
/// Relative step by which the readings are differentiated by a load.
const LOAD_STEP: f64 = 0.01;

/// Returns the whitened change of all readings by one standard deviation of each usual error. `loads` holds the address of each load with its
/// value in every case. `shift` returns the whitened change by an effect, or `None` if there is no equilibrium with it.
pub fn usual_errors(
    model: &Model,
    loads: &[(String, Vec<f64>)],
    span: &Span,
    shift: &dyn Fn(&str) -> Option<DVector<f64>>,
) -> Vec<DVector<f64>> {
    let mut specs: Vec<String> = Vec::new();
    let mut moved = |effect: String, by: f64| {
        for axis in ["x", "y", "z"] {
            specs.push(format!("{effect}:{axis}={by}"));
        }
    };
    // The two markers of a joint are at one point, and move together.
    let joints = model.joints.iter().map(|joint| joint.i);
    let springs = model.springdampers.iter().flat_map(|s| [s.i, s.j]);
    for marker in joints.chain(springs) {
        let id = model.markers[marker.0].header.id;
        moved(format!("hardpoint-error@MARKER/{id}"), HARDPOINT);
    }
    for bushing in &model.bushings {
        moved(
            format!("assembly-offset@BUSHING/{}", bushing.header.id),
            ASSEMBLY_OFFSET,
        );
    }
    if let Some(load) = model.sforces.first() {
        let id = model.markers[load.i.0].header.id;
        moved(format!("load-point-error@MARKER/{id}"), LOAD_POINT);
    }
    for bushing in &model.bushings {
        for axis in ["ax", "ay", "az"] {
            let id = bushing.header.id;
            specs.push(format!(
                "bushing-orientation@BUSHING/{id}:{axis}_deg={ORIENTATION_DEG}"
            ));
        }
    }
    for spring in &model.springdampers {
        let id = spring.header.id;
        for (number, error) in [("K", SPRING_RATE), ("FORCE", PRELOAD)] {
            let factor = 1.0 + error;
            specs.push(format!(
                "element-parameter@SPRINGDAMPER/{id}.{number}:factor={factor}"
            ));
        }
    }
    for (to, _) in loads {
        specs.push(format!("load-gain@{to}:gain={}", 1.0 + LOAD_GAIN));
        for (from, _) in loads.iter().filter(|(from, _)| from != to) {
            specs.push(format!(
                "load-crosstalk@{to}<-{from}:fraction={LOAD_CROSSTALK}"
            ));
        }
    }
    let mut errors: Vec<DVector<f64>> = specs.iter().filter_map(|spec| shift(spec)).collect();
    for (load, values) in loads {
        let largest = values
            .iter()
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let Some(change) = shift(&format!("load-gain@{load}:gain={}", 1.0 + LOAD_STEP)) else {
            continue;
        };
        for (own, value) in span.case_by_case(&change).into_iter().zip(values) {
            // A load of zero has no gain. Its scatter is smaller than that of a load that acts.
            if *value != 0.0 {
                errors.push(own * (LOAD_REPEATABILITY * largest / (LOAD_STEP * value)));
            }
        }
    }
    errors
}
