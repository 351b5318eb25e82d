//! The global fit on the two reference axles.

use admire::identify::global::{Options, Prepared, fit_study};

use crate::setup::{Loaded, exact_mcpherson, load, replace};

fn options<'a>() -> Options<'a> {
    Options {
        start: None,
        profile: false,
        watch: None,
    }
}

fn errors(loaded: &Loaded, name: &str) -> (Vec<f64>, usize) {
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let begin = std::time::Instant::now();
    let found = fit_study(&problem, &prepared, None, options()).unwrap();
    let sweeps = found.problem.predictor.sweeps();
    println!(
        "{name}: {:?}, {} sweeps, {} steps, {:?}, {:?}",
        begin.elapsed(),
        sweeps,
        found.minimum.iterations,
        found.minimum.ending,
        found.fit.marks
    );
    let errors: Vec<f64> = found
        .fit
        .values()
        .iter()
        .zip(&loaded.reference)
        .map(|(k, r)| (k / r).ln())
        .collect();
    let sds: Vec<f64> = (0..errors.len())
        .map(|k| found.covariance[(k, k)].sqrt())
        .collect();
    let show = |v: &[f64]| {
        v.iter()
            .map(|x| format!("{x:.1e}"))
            .collect::<Vec<_>>()
            .join(" ")
    };
    println!("ln errors {}\nsds {}", show(&errors), show(&sds));
    (errors, sweeps)
}

#[test]
fn noise_free_mcpherson_is_exact_from_the_papers_start() {
    let (errors, sweeps) = errors(&exact_mcpherson(|_| {}), "exact");
    assert!(errors.iter().all(|e| e.abs() < 1e-4));
    assert!(sweeps <= 15, "{sweeps}");
}

#[test]
fn noisy() {
    errors(&load("pseudo-mcpherson", |_| {}), "noisy");
    errors(
        &load("pseudo-mcpherson", |f| {
            replace(
                f,
                "study.toml",
                "offset_sd = { length = 0.5, angle_deg = 0.5 }",
                "offset_sd = { length = 0.0, angle_deg = 0.0 }",
            );
        }),
        "noisy no offsets",
    );
    errors(&load("multilink", |_| {}), "multilink");
}
