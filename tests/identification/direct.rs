//! The direct solution on both axles: exact without noise; a start and a check of the fit with noise.

use std::ops::ControlFlow;

use admire_identify::direct::{DirectSettings, DirectSolution, solve};

use crate::setup::{Loaded, exact_mcpherson, load, measure};

fn run(loaded: &Loaded) -> DirectSolution {
    let mut progress = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
    let start = std::time::Instant::now();
    let solution = solve(&loaded.problem(), &DirectSettings::default(), &mut progress).unwrap();
    println!(
        "{:?}, {} rounds, settled {}, chi2 {:.1}/{}",
        start.elapsed(),
        solution.rounds,
        solution.settled,
        solution.chi_square,
        solution.dof
    );
    solution
}

fn log_errors(values: &[f64], reference: &[f64]) -> Vec<f64> {
    values
        .iter()
        .zip(reference)
        .map(|(k, r)| (k / r).ln())
        .collect()
}

fn median(errors: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes[sizes.len() / 2]
}

#[test]
fn exact_on_the_mcpherson() {
    let loaded = exact_mcpherson(|_| {});
    let solution = run(&loaded);
    let errors = log_errors(&solution.values, &loaded.reference);
    println!(
        "{:?}",
        errors
            .iter()
            .map(|e| format!("{e:.1e}"))
            .collect::<Vec<_>>()
    );
    // The marks are written to 1e-9 mm.
    assert_eq!(errors.len(), 12);
    assert!(errors.iter().all(|e| e.abs() < 1e-4), "{errors:?}");
}

#[test]
fn exact_on_the_multilink() {
    let mut loaded = load("multilink", |_| {});
    measure(&mut loaded, 0.0, 0);
    let solution = run(&loaded);
    let errors = log_errors(&solution.values, &loaded.reference);
    println!(
        "{:?}",
        errors
            .iter()
            .map(|e| format!("{e:.1e}"))
            .collect::<Vec<_>>()
    );
    assert_eq!(errors.len(), 48);
    assert!(errors.iter().all(|e| e.abs() < 1e-4), "{errors:?}");
}

/// guide/paper.md: with noise of 0.02 and 0.05 mm the Cramer-Rao bound leaves a median log error of 0.02 and 0.054 on the
/// McPherson; plain least squares is biased.
#[test]
fn near_the_bound_on_the_noisy_mcpherson() {
    for (sigma, bound) in [(0.02, 0.02), (0.05, 0.054)] {
        let mut loaded = load("pseudo-mcpherson", |_| {});
        let (mut plain, mut corrected, mut standardised) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..10 {
            measure(&mut loaded, sigma, seed);
            let solution = run(&loaded);
            plain.extend(log_errors(&solution.uncorrected, &loaded.reference));
            let errors = log_errors(&solution.values, &loaded.reference);
            for (k, error) in errors.iter().enumerate() {
                standardised.push(error / solution.covariance[(k, k)].sqrt());
            }
            corrected.extend(errors);
        }
        let rms =
            (standardised.iter().map(|z| z * z).sum::<f64>() / standardised.len() as f64).sqrt();
        println!(
            "{sigma}: plain {:.3} corrected {:.3} z {rms:.2}",
            median(&plain),
            median(&corrected)
        );
        assert!(median(&corrected) < 1.4 * bound);
        assert!((0.7..1.4).contains(&rms), "{rms}");
        assert!(median(&plain) > 1.3 * median(&corrected));
    }
}

#[test]
fn noisy_multilink_knows_what_it_knows() {
    let mut loaded = load("multilink", |_| {});
    for seed in 0..2 {
        measure(&mut loaded, 0.05, seed);
        let solution = run(&loaded);
        let errors = log_errors(&solution.values, &loaded.reference);
        let mut known = 0;
        for (k, error) in errors.iter().enumerate() {
            let sd = solution.covariance[(k, k)].sqrt();
            if sd < 0.3 {
                known += 1;
                assert!(error.abs() < 4.5 * sd, "{k}: {error} against {sd}");
            }
        }
        println!("{known} of 48 known, median {:.3}", median(&errors));
        assert!(known >= 18);
    }
}
