//! What NOTES.md of the paper says its loop does, found again.

use std::ops::ControlFlow;

use admire::backend::NativeBackend;
use admire::identify::regression;
use admire::identify::{Fit, Status};

use crate::setup::{Loaded, exact_mcpherson};

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
    // The step test fires early: the rotational stiffnesses of B still move, and the loop says so.
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
