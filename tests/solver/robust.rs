//! Equilibria from poor starts.

use admire_solver::mechanics::{Vec3, exp};
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::System;
use admire_syntax::Address;

use crate::reference::load;

fn spread(seed: u64, k: usize) -> f64 {
    let x = (seed * 7919 + k as u64 * 104_729 + 12345) % 1000;
    x as f64 / 500.0 - 1.0
}

/// Checks that parts displaced by centimetres and rotated by tens of degrees return to the equilibrium nearest to the design position.
#[test]
fn displaced_parts() {
    for stem in [
        "reference/pseudo-mcpherson/mcph_ref",
        "reference/multilink/ocp_ref",
    ] {
        let Some((model, _)) = load(stem) else { return };
        let system = System::compile(&model).value;
        let parameters = system.parameters();
        let mut solver = Solver::new(&system);
        let settings = StaticSettings::tight();
        let mut reference = system.state();
        solver
            .solve(&system, &parameters, &mut reference, &settings)
            .unwrap();
        for (size, angle) in [(10.0, 10.0), (30.0, 20.0), (50.0, 30.0)] {
            let mut found = 0;
            let mut told = Vec::new();
            for seed in 0..20 {
                let mut state = system.state();
                for (k, pose) in state.poses.iter_mut().enumerate().skip(1) {
                    let d = Vec3::from_fn(|i, _| spread(seed, 6 * k + i));
                    let r = Vec3::from_fn(|i, _| spread(seed, 6 * k + 3 + i));
                    pose.p += d * size;
                    pose.R = exp(&(r.normalize() * f64::to_radians(angle))) * pose.R;
                }
                let result = solver.solve(&system, &parameters, &mut state, &settings);
                if let Ok(report) = &result {
                    let apart = state
                        .poses
                        .iter()
                        .zip(&reference.poses)
                        .map(|(a, b)| (a.p - b.p).amax())
                        .fold(0.0, f64::max);
                    told.push((report.iterations, report.continuation, apart));
                    if apart < 1e-6 {
                        found += 1;
                    }
                } else {
                    told.push((0, None, f64::NAN));
                }
            }
            println!("{stem} {size} mm {angle} deg: {found}/20 {told:?}");
            assert_eq!(found, 20, "{stem} {size} mm {angle} deg");
        }
    }
}

/// Checks the start of the paper's identification: all bushings have 1e4 N/mm and 1e4 N mm per degree.
#[test]
fn stiffness_of_1e4_everywhere() {
    for stem in [
        "reference/pseudo-mcpherson/mcph_ref",
        "reference/multilink/ocp_ref",
    ] {
        let Some((model, expected)) = load(stem) else {
            return;
        };
        let system = System::compile(&model).value;
        let mut parameters = system.parameters();
        for b in &model.bushings {
            for (argument, value) in [("K", 1e4), ("KT", 1e4_f64.to_degrees())] {
                for k in 1..4 {
                    let address = Address {
                        kind: "BUSHING".to_string(),
                        id: Some(b.header.id),
                        argument: Some(argument.to_string()),
                        index: Some(k),
                    };
                    parameters.set(system.catalogue().slot(&address).unwrap(), value);
                }
            }
        }
        let mut solver = Solver::new(&system);
        let mut told = Vec::new();
        let mut state = system.state();
        for case in expected["cases"].as_array().unwrap() {
            for (id, direction) in ["longitudinal", "lateral", "vertical"].iter().enumerate() {
                let slot = system
                    .catalogue()
                    .slot(&crate::reference::address("SFORCE", id as u32 + 1));
                parameters.set(slot.unwrap(), case["load"][direction].as_f64().unwrap());
            }
            match solver.solve(&system, &parameters, &mut state, &StaticSettings::tight()) {
                Ok(report) => told.push((report.iterations, report.continuation)),
                Err(error) => panic!("{stem}: {error} {error:?}"),
            }
        }
        println!("{stem} {told:?}");
        assert!(told.iter().all(|t| t.1.is_none()), "{stem} {told:?}");
    }
}
