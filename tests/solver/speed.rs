//! Times, printed by `cargo test --test solver speed -- --ignored --nocapture`.

use std::time::Instant;

use admire::statics::{Settings, Solver, Tangent};
use admire::system::{Scratch, System};

use crate::reference::{address, load};

#[test]
#[ignore = "prints times"]
fn sweep_of_13_cases() {
    for stem in [
        "reference/pseudo-mcpherson/mcph_ref",
        "reference/multilink/ocp_ref",
    ] {
        let Some((model, expected)) = load(stem) else {
            return;
        };
        let system = System::compile(&model).value;
        let mut parameters = system.parameters();
        let slots: Vec<_> = (1..4)
            .map(|id| system.catalogue().slot(&address("SFORCE", id)).unwrap())
            .collect();
        let loads: Vec<[f64; 3]> = expected["cases"]
            .as_array()
            .unwrap()
            .iter()
            .map(|case| {
                ["longitudinal", "lateral", "vertical"].map(|d| case["load"][d].as_f64().unwrap())
            })
            .collect();
        let mut solver = Solver::new(&system);
        let settings = Settings::tight();
        let mut times = Vec::new();
        let mut iterations = 0;
        let mut state = system.state();
        for _ in 0..200 {
            let start = Instant::now();
            iterations = 0;
            for case in &loads {
                for (slot, value) in slots.iter().zip(case) {
                    parameters.set(*slot, *value);
                }
                iterations += solver
                    .solve(&system, &parameters, &mut state, &settings)
                    .unwrap()
                    .iterations;
            }
            times.push(start.elapsed().as_secs_f64() * 1e6 / 13.0);
        }
        times.sort_by(f64::total_cmp);
        let mut scratch = Scratch::new(&system);
        let mut g = vec![0.0; system.unknowns()];
        let least = |work: &mut dyn FnMut()| {
            (0..500)
                .map(|_| {
                    let start = Instant::now();
                    work();
                    start.elapsed().as_secs_f64() * 1e6
                })
                .fold(f64::INFINITY, f64::min)
        };
        let residual = least(&mut || {
            system
                .residual(&parameters, &state, &mut scratch, &mut g)
                .unwrap();
        });
        let tangent = least(&mut || {
            std::hint::black_box(Tangent::new(&system, &parameters, &state).unwrap());
        });
        println!(
            "{stem}: {} unknowns, {:.1} us per case (least {:.1}), {iterations} iterations in 13 cases, residual {residual:.2} us, tangent {tangent:.1} us",
            system.unknowns(),
            times[times.len() / 2],
            times[0],
        );
    }
}
