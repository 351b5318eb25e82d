//! Behaviour of the loop of the paper, as stated in guide/paper.md.

use std::ops::ControlFlow;

use admire_identify::{Fit, Status, regression};
use admire_session::backend::NativeBackend;

use admire_study::deflection::DeflectionForm;
use admire_study::settings::{Slope, Weights};

use crate::setup::{Loaded, exact_mcpherson, load, measure};

fn run(loaded: &Loaded) -> Fit {
    let mut progress = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
    regression::identify(&loaded.problem(), &mut NativeBackend::new(), &mut progress).unwrap()
}

fn ratios(loaded: &Loaded, fit: &Fit) -> Vec<f64> {
    fit.values()
        .iter()
        .zip(&loaded.reference)
        .map(|(k, r)| k / r)
        .collect()
}

#[test]
fn noise_free_mcpherson_stops_where_the_notes_say() {
    let loaded = exact_mcpherson(|_| {});
    let start = std::time::Instant::now();
    let fit = run(&loaded);
    println!("{:?} for {} iterations", start.elapsed(), fit.iterations);
    let ratios = ratios(&loaded, &fit);
    println!("{ratios:.3?}");
    for remark in &fit.remarks {
        println!("{remark}");
    }
    assert!(fit.converged);
    assert!((35..=45).contains(&fit.iterations), "{}", fit.iterations);
    let expected = [
        0.997, 0.997, 0.980, 0.908, 0.908, 0.884, 1.00, 1.00, 1.02, 5.2, 5.1, 2.2,
    ];
    for (k, (ratio, expected)) in ratios.iter().zip(expected).enumerate() {
        assert!(
            (ratio / expected - 1.0).abs() < 0.02,
            "{k}: {ratio} against {expected}"
        );
    }
    // The step test is passed too early: the rotational stiffnesses of B still change, and the loop reports this.
    assert!(
        fit.remarks
            .iter()
            .any(|remark| remark.contains("BUSHING/2.KT.1")),
        "{:?}",
        fit.remarks
    );
    assert!(
        fit.parameters
            .iter()
            .all(|p| p.status == Status::Identified)
    );
}

/// Checks guide/paper.md: as printed, the noisy multilink (0.05 mm, epsilon 0.05) does not converge in 200 iterations. With the weights of
/// equation 16 inverted, it converges in 4 to 15.
#[test]
fn noisy_multilink_needs_the_corrected_weights() {
    let mut medians = Vec::new();
    for (weights, slope, expected) in [
        (Weights::Printed, Slope::Printed, 200..=200),
        (Weights::Corrected, Slope::Printed, 3..=25),
    ] {
        let mut loaded = load("multilink", |_| {});
        loaded.study.regression.weights = weights;
        loaded.study.regression.slope = slope;
        let fit = run(&loaded);
        let mut errors: Vec<f64> = ratios(&loaded, &fit).iter().map(|r| r.ln().abs()).collect();
        errors.sort_by(f64::total_cmp);
        let kept = fit
            .parameters
            .iter()
            .filter(|p| p.status == Status::Unidentifiable)
            .count();
        println!(
            "{weights:?} {slope:?}: {} iterations, median {:.3}, kept {kept}",
            fit.iterations, errors[24]
        );
        assert!(expected.contains(&fit.iterations), "{}", fit.iterations);
        medians.push(errors[24]);
    }
    assert!(medians[1] < 0.35, "{medians:?}");
}

/// Checks guide/paper.md 2, 4 and 5: the effect of each misreading of the printed equations.
#[test]
fn misread_equations_lose_stiffnesses() {
    let loaded = exact_mcpherson(|_| {});
    let lost = |reading| {
        let mut progress = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
        let mut native = NativeBackend::new();
        let fit = regression::identify_as(&loaded.problem(), &mut native, reading, &mut progress)
            .unwrap();
        let lost = fit
            .parameters
            .iter()
            .filter(|p| p.status == Status::Unidentifiable);
        lost.map(|p| p.address.clone()).collect::<Vec<_>>()
    };
    let reading = regression::EquationInterpretation::default();
    assert!(lost(reading).is_empty());
    // With the sign that ADAMS reports, no parameter is ever identified.
    assert_eq!(
        lost(regression::EquationInterpretation {
            force_on_i: true,
            ..reading
        })
        .len(),
        12
    );
    let printed = lost(regression::EquationInterpretation {
        deflection: DeflectionForm::Printed,
        ..reading
    });
    assert!(
        printed.contains(&"BUSHING/1.KT.2".to_string()),
        "{printed:?}"
    );
    assert!(
        printed.contains(&"BUSHING/2.KT.2".to_string()),
        "{printed:?}"
    );
    let at_j = lost(regression::EquationInterpretation {
        torque_at_j: true,
        ..reading
    });
    println!("torque at J loses {at_j:?}");
    assert!(at_j.len() >= 3, "{at_j:?}");
}

/// Checks guide/paper.md 7: with both corrections, the noisy multilink (0.05 mm, epsilon 0.05) ends after about ten iterations, with a median
/// log error of 0.17. In a single draw of the noise, a poorly determined stiffness may drift by just more than epsilon; in the shipped one it
/// does so for 75 iterations. The test therefore uses the median of several draws.
#[test]
fn inverse_regression_removes_the_bias_of_the_noise() {
    let mut loaded = load("multilink", |_| {});
    loaded.study.regression.weights = Weights::Corrected;
    let (mut iterations, mut printed, mut inverse) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 1..=5 {
        measure(&mut loaded, 0.05, seed);
        for (slope, medians) in [
            (Slope::Printed, &mut printed),
            (Slope::Inverse, &mut inverse),
        ] {
            loaded.study.regression.slope = slope;
            loaded.study.regression.max_iterations = 40;
            let fit = run(&loaded);
            let of_found = fit.parameters.iter().zip(&loaded.reference);
            let mut errors: Vec<f64> = of_found
                .filter(|(p, _)| p.status == Status::Identified)
                .map(|(p, truth)| (p.value / truth).ln().abs())
                .collect();
            errors.sort_by(f64::total_cmp);
            medians.push(errors[errors.len() / 2]);
            if slope == Slope::Inverse {
                iterations.push(fit.iterations);
            }
        }
    }
    iterations.sort_unstable();
    println!("{iterations:?} {printed:.3?} {inverse:.3?}");
    assert!((3..=15).contains(&iterations[2]), "{iterations:?}");
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!((0.10..0.20).contains(&mean(&inverse)), "{inverse:?}");
    assert!(mean(&inverse) < 0.75 * mean(&printed), "{printed:?}");
}
