//! Verdict on a fit: the chi-square test, structure in the residuals, and interrupted runs.

use admire_diagnosis::fit_with_random_effects;
use admire_identify::global::{Options, Prepared, fit_study};
use admire_identify::{Fit, FitVerdict, NOT_CONVERGED, Problem, lack_of_fit};
use admire_report::lead;

use crate::options::with_sensors;
use crate::setup::{Loaded, exact_mcpherson, load, measure};

fn fitted(loaded: &Loaded) -> Fit {
    fit_of(&loaded.problem())
}

fn fit_of(problem: &Problem<'_>) -> Fit {
    let prepared = Prepared::new(problem).unwrap();
    fit_study(problem, &prepared, None, Options::default())
        .unwrap()
        .fit
}

fn verdict(fit: &Fit) -> FitVerdict {
    fit.fit_test.as_ref().unwrap().verdict
}

#[test]
fn the_exact_test_decides_at_any_number_of_readings() {
    let mut loaded = exact_mcpherson(|_| {});
    for seed in 0..4 {
        measure(&mut loaded, 0.02, seed);
        let fit = fitted(&loaded);
        assert_eq!(verdict(&fit), FitVerdict::Noise, "{:?}", fit.fit_test);
        assert!(
            !lack_of_fit::is_structured(&fit.structure),
            "{:?}",
            fit.structure
        );
        assert!(lead(&fit).contains("as well as their noise allows"));
    }
    // Chi-square per degree of freedom is then 1.23, which is 3.7 standard deviations above one. A fixed limit of 1.3 would not detect this.
    loaded.measurement.sigma = 0.02 * 0.9;
    let fit = fitted(&loaded);
    assert_eq!(verdict(&fit), FitVerdict::Misfit, "{:?}", fit.fit_test);
    assert!(
        lead(&fit).starts_with("The model does not explain"),
        "{}",
        lead(&fit)
    );
    assert!(lead(&fit).contains("admire diagnose"));
    loaded.measurement.sigma = 0.02 * 2.0;
    assert_eq!(verdict(&fitted(&loaded)), FitVerdict::NoiseOverstated);
}

/// Checks a part whose marks are all displaced by less than one sigma in all cases.
#[test]
fn structure_shows_where_the_sum_of_squares_does_not() {
    let mut loaded = exact_mcpherson(|_| {});
    measure(&mut loaded, 0.02, 1);
    for case in &mut loaded.measurement.cases {
        for reading in case.marks.iter_mut().filter(|reading| reading.part == 0) {
            reading.x.x += 0.015;
            reading.x.y -= 0.015;
        }
    }
    let fit = fitted(&loaded);
    assert!(
        lack_of_fit::is_structured(&fit.structure),
        "{:?}",
        fit.structure
    );
    let name = &loaded.measurement.parts[0].name;
    let first = lack_of_fit::worst(&fit.structure).unwrap();
    assert!(first.what.starts_with(name.as_str()), "{first:?}");
    assert!(lead(&fit).contains("have structure"), "{}", lead(&fit));
}

/// Checks a study with wheel and sensors only.
#[test]
fn readings_without_marks_are_tested_too() {
    let (_folder, mut loaded) = with_sensors();
    for case in &mut loaded.measurement.cases {
        case.marks.clear();
    }
    loaded.measurement.parts.clear();
    let fit = fit_of(&loaded.problem());
    let test = fit.fit_test.clone().unwrap();
    assert_eq!(test.verdict, FitVerdict::Noise, "{test:?}");
    let kinds: Vec<&str> = test.readings.iter().map(|k| k.kind.as_str()).collect();
    assert_eq!(kinds[..2], ["wheel position", "wheel angles"]);
    assert_eq!(kinds.len(), 5, "three sensors beside: {kinds:?}");
    assert!(lead(&fit).contains("degree of freedom"), "{}", lead(&fit));
    // An alternating camber error of a tenth of a degree cannot be noise of a hundredth.
    for (k, case) in loaded.measurement.cases.iter_mut().enumerate() {
        if let Some(wheel) = &mut case.wheel {
            wheel.camber_deg += if k % 2 == 0 { 0.1 } else { -0.1 };
        }
    }
    let fit = fit_of(&loaded.problem());
    assert_eq!(verdict(&fit), FitVerdict::Misfit, "{:?}", fit.fit_test);
}

#[test]
fn a_run_that_is_ended_early_names_what_it_left() {
    let mut loaded = load("multilink", |_| {});
    measure(&mut loaded, 0.05, 0);
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let ended = |after_steps: bool| {
        // The run is stopped in the third step of the fit, or after convergence during the refinement of the intervals.
        let (mut steps, mut asked_at_the_end) = (0, 0);
        let mut last = usize::MAX;
        let watch = move |iteration: usize, _: usize, _: f64| {
            steps += 1;
            if iteration == last {
                asked_at_the_end += 1;
            }
            last = iteration;
            if after_steps {
                steps < 3
            } else {
                asked_at_the_end == 0
            }
        };
        let options = Options {
            profile: true,
            watch: Some(Box::new(watch)),
            ..Options::default()
        };
        fit_study(&problem, &prepared, None, options).unwrap().fit
    };
    let fit = ended(true);
    assert!(fit.interrupted && !fit.converged);
    assert_eq!(fit.affected.len(), fit.parameters.len());
    assert!(lead(&fit).starts_with("The fit was interrupted"));
    let fit = ended(false);
    assert!(fit.interrupted && fit.converged);
    assert!(!fit.affected.is_empty() && fit.affected.len() < fit.parameters.len());
    assert!(fit.to_json().contains("\"interrupted\": true"));
}

/// Checks that the convergence of the fit with tolerances counts, because the reported values come from it. The stiffness-only fit need not
/// converge.
#[test]
fn the_fit_with_tolerances_says_whether_its_numbers_can_be_used() {
    let mut loaded = exact_mcpherson(|_| {});
    measure(&mut loaded, 0.02, 3);
    let problem = loaded.problem();
    for interrupted in [false, true] {
        let mut fit = fit_of(&problem);
        (fit.converged, fit.interrupted) = (false, interrupted);
        fit.remarks.push(NOT_CONVERGED.to_string());
        fit_with_random_effects(&problem).unwrap().apply(&mut fit);
        assert_eq!(fit.converged, !interrupted);
        let told = fit.remarks.iter().any(|remark| remark == NOT_CONVERGED);
        assert_eq!(told, interrupted, "{:?}", fit.remarks);
        assert!(!lead(&fit).contains("Do not use them"));
    }
}
