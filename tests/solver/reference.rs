//! The two axles of ../shared/reference: an independent dense Newton solution (see the README there).

use admire_solver::mechanics::Vec3;
use admire_solver::model::{JointKind, Model};
use admire_solver::statics::{SolveError, Solver, StaticSettings};
use admire_solver::system::{Scratch, System};
use admire_syntax::Address;

use crate::common::shared;
use crate::deck;

/// Folders of the two axles.
pub const AXLES: [&str; 2] = [
    "reference/pseudo-mcpherson/mcph_ref",
    "reference/multilink/ocp_ref",
];

pub fn load(stem: &str) -> Option<(Model, serde_json::Value)> {
    let text = std::fs::read_to_string(shared(&format!("{stem}.adm"))?).ok()?;
    let expected = std::fs::read_to_string(shared(&format!("{stem}.expected.json"))?).ok()?;
    Some((deck::read(&text), serde_json::from_str(&expected).unwrap()))
}

pub fn address(kind: &str, id: u32) -> Address {
    Address {
        kind: kind.to_string(),
        id: Some(id),
        argument: None,
        index: None,
    }
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|v| match v.as_array() {
            Some(_) => numbers(v),
            None => vec![v.as_f64().unwrap()],
        })
        .collect()
}

fn compare(stem: &str) {
    let Some((model, expected)) = load(stem) else {
        return;
    };
    let checked = System::compile(&model);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    let system = checked.value;
    let mut parameters = system.parameters();
    let mut state = system.state();
    let mut solver = Solver::new(&system);
    let mut scratch = Scratch::new(&system);
    let settings = StaticSettings::tight();
    let mut worst = [0.0_f64; 3];
    let mut iterations = Vec::new();
    for case in expected["cases"].as_array().unwrap() {
        for (id, direction) in ["longitudinal", "lateral", "vertical"].iter().enumerate() {
            let slot = system.catalogue().slot(&address("SFORCE", id as u32 + 1));
            parameters.set(slot.unwrap(), case["load"][direction].as_f64().unwrap());
        }
        let report = solver
            .solve(&system, &parameters, &mut state, &settings)
            .unwrap_or_else(|e| panic!("{e}: {e:?}"));
        iterations.push(report.iterations);
        assert!(report.continuation.is_none());
        for (name, part) in case["parts"].as_object().unwrap() {
            let index = model.parts.iter().position(|p| p.header.name == *name);
            let pose = &state.poses[index.unwrap()];
            let p = numbers(&part["pos"]);
            worst[0] = worst[0].max((pose.p - Vec3::from_column_slice(&p)).amax());
            let A = numbers(&part["A"]);
            for (k, a) in A.iter().enumerate() {
                worst[1] = worst[1].max((pose.R[(k / 3, k % 3)] - a).abs());
            }
        }
        let mut here = system.evaluate(&parameters, &state, &mut scratch).unwrap();
        for (name, bushing) in case["bushings"].as_object().unwrap() {
            let b = model.bushings.iter().find(|b| b.header.name == *name);
            let element = system.element("BUSHING", b.unwrap().header.id).unwrap();
            let reading = here.read_element(element).unwrap();
            let f = numbers(&bushing["F_on_I_in_J"]);
            let g = numbers(&bushing["F_on_I_ground"]);
            for k in 0..3 {
                worst[2] = worst[2].max((reading.wrench_j[k] - f[k]).abs());
                worst[2] = worst[2].max((reading.force[k] - g[k]).abs());
            }
        }
    }
    println!(
        "{stem}: position {:.1e} mm, rotation {:.1e}, force {:.1e} N, iterations {iterations:?}",
        worst[0], worst[1], worst[2]
    );
    assert!(worst[0] < 1e-6, "position {} mm", worst[0]);
    assert!(worst[1] < 1e-8, "rotation {}", worst[1]);
    assert!(worst[2] < 1e-3, "bushing force {} N", worst[2]);
}

#[test]
fn pseudo_mcpherson() {
    compare("reference/pseudo-mcpherson/mcph_ref");
}

#[test]
fn multilink() {
    compare("reference/multilink/ocp_ref");
}

/// Checks a tie rod between two spherical joints, which spins freely. With mass, this is harmless; without mass, it is refused by name.
#[test]
fn spherical_tie_rod() {
    let Some((mut model, _)) = load("reference/pseudo-mcpherson/mcph_ref") else {
        return;
    };
    for joint in &mut model.joints {
        if joint.header.name == "TIE_INNER" {
            joint.kind = JointKind::Spherical;
        }
    }
    let system = System::compile(&model).value;
    let mut state = system.state();
    let parameters = system.parameters();
    let report = Solver::new(&system)
        .solve(&system, &parameters, &mut state, &StaticSettings::tight())
        .unwrap();
    assert_eq!(report.free_motions.len(), 1);
    assert_eq!(
        report.free_motions[0].to_string(),
        "PART/6 'TIE_ROD' spins freely about the line MARKER/13-MARKER/15"
    );
    let mut parameters = parameters;
    let mass = admire_syntax::Address {
        argument: Some("MASS".to_string()),
        ..address("PART", 6)
    };
    parameters.set(system.catalogue().slot(&mass).unwrap(), 0.0);
    let mut state = system.state();
    let error = Solver::new(&system)
        .solve(&system, &parameters, &mut state, &StaticSettings::tight())
        .unwrap_err();
    let SolveError::FreeMotion(motion) = &error else {
        panic!("{error}");
    };
    assert_eq!(motion.part.to_string(), "PART/6 'TIE_ROD'");
    assert!(motion.motion.contains("MARKER/13-MARKER/15"), "{motion}");
}
