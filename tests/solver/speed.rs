//! Times, printed by `cargo test --test solver speed -- --ignored --nocapture`.

use std::time::Instant;

/// Seconds this thread has had of a processor: other work on the machine does not count.
fn cpu() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split(' ').next()?.parse::<f64>().ok())
        .map_or(0.0, |ns| ns * 1e-9)
}

use admire::statics::{Settings, Solver};
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
        let (mut iterations, mut factorisations) = (0, 0);
        let mut state = system.state();
        let sweeps = 2000;
        let start = cpu();
        for _ in 0..sweeps {
            (iterations, factorisations) = (0, 0);
            for case in &loads {
                for (slot, value) in slots.iter().zip(case) {
                    parameters.set(*slot, *value);
                }
                let report = solver
                    .solve(&system, &parameters, &mut state, &settings)
                    .unwrap();
                iterations += report.iterations;
                factorisations += report.factorisations;
            }
        }
        let mean = (cpu() - start) * 1e6 / f64::from(13 * sweeps);
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
            std::hint::black_box(solver.tangent(&system, &parameters, &state).unwrap());
        });
        println!(
            "{stem}: {} unknowns, {mean:.1} us per case, {iterations} iterations ({factorisations} factored) in 13 cases, residual {residual:.2} us, tangent {tangent:.1} us",
            system.unknowns(),
        );
    }
}

/// A chain of parts on bushings, clamped at one end, with a small force at the other and gravity off.
fn chain(n: usize) -> admire::model::Model {
    use std::fmt::Write;
    let mut text = String::from(
        "chain\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n",
    );
    for k in 0..n {
        let id = k + 2;
        writeln!(
            text,
            "PART/{id}, QG={},0,0, MASS=1, CM={cm}, IP=100,100,100\nMARKER/{cm}, PART={id}, QP=50,0,0\nMARKER/{i}, PART={id}\nMARKER/{j}, PART={id}, QP=100,0,0",
            100 * k,
            cm = 10 * id,
            i = 10 * id + 1,
            j = 10 * id + 2
        )
        .unwrap();
        let j = if k == 0 { 1 } else { 10 * (id - 1) + 2 };
        writeln!(
            text,
            "BUSHING/{id}, I={}, J={j}, K=1e4,1e4,1e4, KT=1e8,1e8,1e8",
            10 * id + 1
        )
        .unwrap();
    }
    // The force shrinks with the length so that the tip moves alike.
    let force = 2e3 / (n as f64).powi(2);
    writeln!(
        text,
        "SFORCE/1, I={}, J=1, TRANSLATIONAL, ACTIONONLY, FUNCTION={force}\nEND",
        10 * (n + 1) + 2
    )
    .unwrap();
    crate::deck::read(&text)
}

#[test]
#[ignore = "prints times"]
fn chains() {
    for n in [10, 100, 1000, 10_000, 100_000] {
        let start = Instant::now();
        let model = chain(n);
        let read = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let system = System::compile(&model).value;
        let compile = start.elapsed().as_secs_f64();
        let parameters = system.parameters();
        let mut solver = Solver::new(&system);
        let settings = Settings {
            tlimit: 1e6,
            ..Settings::tight()
        };
        let mut state = system.state();
        let start = Instant::now();
        let first = solver.solve(&system, &parameters, &mut state, &settings);
        let cold = start.elapsed().as_secs_f64();
        let mut best = f64::INFINITY;
        let (mut iterations, mut factored) = (0, 0);
        for _ in 0..3 {
            let mut state = system.state();
            let start = cpu();
            if let Ok(report) = solver.solve(&system, &parameters, &mut state, &settings) {
                (iterations, factored) = (report.iterations, report.factorisations);
                best = best.min(cpu() - start);
            }
        }
        println!(
            "{n} parts: read {read:.2} s, compile {compile:.2} s, first solve {cold:.3} s, again {:.2} ms, {iterations} iterations ({factored} factored), {:.2} us per part and iteration; {}",
            best * 1e3,
            best * 1e6 / (n * iterations.max(1)) as f64,
            first.map_or_else(
                |e| e.to_string(),
                |r| format!(
                    "{:.1e} {:?} roundoff {}",
                    r.imbalance, r.continuation, r.at_roundoff
                )
            )
        );
    }
}
