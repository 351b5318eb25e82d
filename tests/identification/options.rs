//! Options of a fit besides marks: nuisances, losses, wheel, sensors and other deck parameters; and the validity of its intervals.

use std::path::Path;

use admire_identify::global::gauss_newton::{LeastSquares, Tolerances, minimise};
use admire_identify::global::{
    FrameMotions, GlobalFit, Observations, Options, Prepared, Row, fit_study, fit_unknowns,
    global_problem,
};
use admire_identify::{LoadedStudy, Status};
use admire_rig::{RigOptions, virtual_rig};
use admire_solver::mechanics::Vec3;
use admire_study::settings::{Amount, Loss, ShiftSd};

use crate::setup::{copy, replace};

/// Reads a shipped study after its folder was changed.
fn study(name: &str, change: impl Fn(&Path)) -> LoadedStudy {
    let (_folder, path) = copy(name);
    change(&path);
    let read = LoadedStudy::read(&path);
    read.value
        .unwrap_or_else(|| panic!("{:?}", read.diagnostics))
}

/// Reads the McPherson study, without offsets among its unknowns.
fn plain(change: impl Fn(&Path)) -> LoadedStudy {
    let mut loaded = study("pseudo-mcpherson", change);
    loaded.study.identify.offset_sd = ShiftSd {
        length: Amount::Stated(0.0),
        angle_deg: 0.0,
    };
    loaded
}

/// Fits a study, and evaluates the result with `look`.
fn fitted<T>(loaded: &LoadedStudy, profile: bool, look: impl FnOnce(&GlobalFit<'_>) -> T) -> T {
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let options = Options {
        profile,
        ..Options::default()
    };
    look(&fit_study(&problem, &prepared, None, options).unwrap())
}

/// Returns the error of ln K and the stated standard deviation of every parameter with a reference value.
fn errors(loaded: &LoadedStudy, found: &GlobalFit<'_>) -> Vec<(f64, f64)> {
    let truth = loaded.reference_values();
    let of = |(k, truth): (usize, &Option<f64>)| {
        let error = (found.fit.parameters[k].value / truth.unwrap()).ln();
        (error, found.covariance[(k, k)].sqrt())
    };
    truth.iter().enumerate().map(of).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = values.collect();
    (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt()
}

/// Checks 30 seeds with noise of 0.05 mm on the McPherson: about 330 parameters whose ln K has a standard deviation below 0.3. The standardised
/// errors of as many normal draws have an rms of 1 +- 0.04, and 95 percent intervals miss 5 +- 1.2 percent of them. Four standard deviations are
/// allowed, and a little more because the parameters of one seed are not independent.
#[test]
fn claimed_uncertainty_is_real_over_seeds() {
    let mut loaded = crate::setup::load("pseudo-mcpherson", |_| {});
    loaded.study.identify.offset_sd = ShiftSd {
        length: Amount::Stated(0.0),
        angle_deg: 0.0,
    };
    let (mut z, mut missed, mut chi2) = (Vec::new(), 0, Vec::new());
    for seed in 0..30 {
        crate::setup::measure(&mut loaded, 0.05, seed);
        let problem = loaded.problem();
        let prepared = Prepared::new(&problem).unwrap();
        let found = fit_study(&problem, &prepared, None, Options::default()).unwrap();
        assert!(found.fit.converged, "seed {seed}");
        chi2.push(found.fit.marks.unwrap().chi2_per_dof.unwrap());
        for (k, (parameter, truth)) in found
            .fit
            .parameters
            .iter()
            .zip(&loaded.reference)
            .enumerate()
        {
            let sd = found.covariance[(k, k)].sqrt();
            if sd < 0.3 {
                z.push((parameter.value / truth).ln() / sd);
                let [low, high] = parameter.interval95.map(Option::unwrap);
                missed += usize::from(!(low..=high).contains(truth));
            }
        }
    }
    let share = missed as f64 / z.len() as f64;
    let spread = rms(z.iter().copied());
    let mean = chi2.iter().sum::<f64>() / 30.0;
    println!(
        "{} numbers, rms {spread:.3}, missed {share:.3}, chi2 {mean:.3}",
        z.len()
    );
    assert!(z.len() > 250);
    assert!((0.83..1.17).contains(&spread), "{spread}");
    assert!((0.005..0.11).contains(&share), "{share}");
    // Each of 30 seeds has 780 coordinates and 12 parameters, so the mean is 1 +- 0.01.
    assert!((mean - 1.0).abs() < 0.04, "{mean}");
}

#[test]
fn a_frame_that_moved_in_one_case_is_a_nuisance_if_asked_for() {
    let mut loaded = plain(|_| {});
    for reading in &mut loaded.measurement.cases[6].marks {
        let turned = Vec3::new(0.0, 0.0, 2e-4).cross(&reading.x);
        reading.x += Vec3::new(0.5, -0.4, 0.3) + turned;
    }
    let (blind, wrong) = fitted(&loaded, false, |found| {
        (
            found.fit.marks.unwrap().chi2_per_dof.unwrap(),
            rms(errors(&loaded, found).iter().map(|(e, sd)| e / sd)),
        )
    });
    loaded.study.identify.frame_sd = ShiftSd {
        length: Amount::Stated(1.0),
        angle_deg: 0.1,
    };
    let (chi2, right) = fitted(&loaded, false, |found| {
        (
            found.fit.marks.unwrap().chi2_per_dof.unwrap(),
            rms(errors(&loaded, found).iter().map(|(e, sd)| e / sd)),
        )
    });
    println!("chi2 {blind:.2} -> {chi2:.2}, standardised errors {wrong:.2} -> {right:.2}");
    assert!(blind > 1.5 && (0.8..1.2).contains(&chi2), "{blind} {chi2}");
    // An rms above 1.75 of twelve standardised errors has a probability of 1e-4.
    assert!(right < 1.75 && right < wrong, "{right} {wrong}");
}

#[test]
fn a_robust_loss_bears_a_wrong_mark() {
    let mut loaded = plain(|_| {});
    loaded.measurement.cases[8].marks[6].x += Vec3::new(4.0, -6.0, 5.0);
    let spread = |loaded: &LoadedStudy| {
        fitted(loaded, false, |found| {
            rms(errors(loaded, found).iter().map(|(e, sd)| e / sd))
        })
    };
    let gaussian = spread(&loaded);
    loaded.study.identify.loss = Loss::Huber;
    let huber = spread(&loaded);
    println!("standardised errors: gaussian {gaussian:.2}, huber {huber:.2}");
    assert!(huber < 2.0 && huber < 0.5 * gaussian, "{huber} {gaussian}");
}

/// Checks that the stiffness of a spring, wrong in the deck, is identified together with twelve bushing stiffnesses.
#[test]
fn other_numbers_of_the_deck_are_identified_beside_stiffnesses() {
    let loaded = study("pseudo-mcpherson", |folder| {
        replace(folder, "model.adm", ", K = 60.0\n", ", K = 75.0\n");
        let bushings = "bushings = [\"BUSHING/1\", \"BUSHING/2\"]\n";
        let more = format!("{bushings}stiffnesses = [\"SPRINGDAMPER/1.K\"]\n");
        replace(folder, "study.toml", bushings, &more);
    });
    fitted(&loaded, false, |found| {
        let spring = found.fit.parameters.last().unwrap();
        assert_eq!(spring.address, "SPRINGDAMPER/1.K");
        assert_eq!(spring.initial, 75.0);
        assert_eq!(spring.status, Status::Identified);
        let error = spring.std_error.unwrap();
        println!("{} +- {error}", spring.value);
        assert!(error < 0.5 && (spring.value - 60.0).abs() < 4.0 * error);
    });
    let deck = loaded.identified_deck(&loaded.problem().initial()).unwrap();
    assert_ne!(deck, loaded.dataset.bytes());
}

/// Returns a study with marks, wheel and two sensors, measured by the virtual rig.
pub fn with_sensors() -> (tempfile::TempDir, LoadedStudy) {
    let (_folder, path) = copy("pseudo-mcpherson");
    std::fs::rename(path.join("reference.adm"), path.join("model.adm")).unwrap();
    replace(
        &path,
        "study.toml",
        "[reference]\ndeck = \"reference.adm\"\n",
        "",
    );
    let toml = std::fs::read_to_string(path.join("study.toml")).unwrap();
    let more = "[wheel]\nmarker = \"MARKER/20\"\naxis = \"y\"\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\n\
                height = { function = \"DZ(11,1)\", sigma = 1.0 }\ntravel = { function = \"DM(18,17)\", sigma = 0.1, relative_to = \"3\" }\n\
                load = { function = \"BUSH(2,0,1,0)\", sigma = 5.0 }\n";
    std::fs::write(path.join("study.toml"), toml + more).unwrap();
    let options = RigOptions {
        seed: 5,
        sigma: Some(0.05),
        ..RigOptions::default()
    };
    let run = virtual_rig(&path, &options).unwrap_or_else(|why| panic!("{why:#?}"));
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &run.files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let read = LoadedStudy::read(folder.path());
    let loaded = read
        .value
        .unwrap_or_else(|| panic!("{:?}", read.diagnostics));
    (folder, loaded)
}

/// Checks the derivatives of every kind of row against central differences of whole equilibria.
#[test]
fn marks_wheel_and_sensors_are_differentiated_exactly() {
    let (_folder, loaded) = with_sensors();
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
    let observations = Observations::new(problem.measurement, problem.model, &cases);
    let rows = observations.rows.clone();
    let kinds = |of: fn(&Row) -> bool| rows.iter().filter(|row| of(row)).count();
    assert_eq!(kinds(|row| matches!(row, Row::Wheel { .. })), 13 * 5);
    assert_eq!(kinds(|row| matches!(row, Row::Channel { .. })), 13 * 3);
    let unknowns = fit_unknowns(&problem, &prepared.system, None);
    let predictor = prepared
        .native(&problem, observations.observed.clone())
        .unwrap();
    let mut global = global_problem(&problem, observations, unknowns, Box::new(predictor));
    // One frame is displaced, and another one drifts from case to case.
    let count = problem.measurement.cases.len();
    global.layout.motions = Some(FrameMotions {
        first: global.start().len(),
        centre: Vec3::new(0.0, -500.0, 200.0),
        turn: 1.0,
        factors: vec![
            vec![1.0; count],
            (0..count).map(|case| case as f64 / 12.0).collect(),
        ],
    });
    global.layout.sd.extend([1e-3; 12]);
    let mut x = global.start();
    for (k, value) in x.iter_mut().enumerate().skip(12) {
        *value += 1e-3 * (k as f64).sin();
    }
    let exact = global.evaluate(&x, true).unwrap().jacobian;
    for k in 0..x.len() {
        let h = 1e-4;
        let mut at = |step: f64| {
            let mut near = x.clone();
            near[k] += step;
            global.evaluate(&near, false).unwrap().residual
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        let size = slope.amax().max(1e-3);
        let worst = (&slope - exact.column(k)).amax();
        assert!(worst < 2e-5 * size, "unknown {k}: {worst} of {size}");
    }
}

#[test]
fn wheel_and_sensors_lower_the_uncertainty_and_are_explained() {
    let (_folder, mut loaded) = with_sensors();
    let with = fitted(&loaded, false, |found| {
        let wheel = found.fit.wheel.unwrap();
        // A hundredth of a degree is the noise of the rig.
        assert!(wheel.camber_deg_rms_before > 0.05, "{wheel:?}");
        assert!(
            wheel.camber_deg_rms_after < 0.02 && wheel.steer_deg_rms_after < 0.02,
            "{wheel:?}"
        );
        (0..12)
            .map(|k| found.covariance[(k, k)].sqrt())
            .collect::<Vec<_>>()
    });
    for case in &mut loaded.measurement.cases {
        case.wheel = None;
        case.channels.fill(None);
    }
    let without = fitted(&loaded, false, |found| {
        (0..12)
            .map(|k| found.covariance[(k, k)].sqrt())
            .collect::<Vec<_>>()
    });
    // The estimates differ slightly, and so do the sensitivities there.
    assert!(
        with.iter().zip(&without).all(|(a, b)| *a < 1.1 * b),
        "{with:?} {without:?}"
    );
    assert!(
        with.iter().zip(&without).any(|(a, b)| *a < 0.7 * b),
        "{with:?} {without:?}"
    );
}

/// Checks the intervals by profile likelihood of poorly determined stiffnesses, at ten times the noise of a good CMM. At their ends, the
/// objective, minimised again over all other unknowns, must have risen by 1.92. The intervals must contain the true values.
#[test]
fn profile_intervals_end_where_the_likelihood_says() {
    let (mut held_truth, mut count) = (0, 0);
    for seed in 0..4 {
        let mut loaded = crate::setup::load("pseudo-mcpherson", |_| {});
        loaded.study.identify.offset_sd = ShiftSd {
            length: Amount::Stated(0.0),
            angle_deg: 0.0,
        };
        crate::setup::measure(&mut loaded, 0.5, seed);
        let problem = loaded.problem();
        let prepared = Prepared::new(&problem).unwrap();
        let options = Options {
            profile: true,
            ..Options::default()
        };
        let mut found = fit_study(&problem, &prepared, None, options).unwrap();
        let (priors, scale) = (found.problem.priors(), found.problem.scale());
        for k in 0..12 {
            if found.covariance[(k, k)].sqrt() < 0.3 {
                continue;
            }
            let [low, high] = found.fit.parameters[k].interval95;
            let truth = loaded.reference[k];
            count += 1;
            held_truth += usize::from(
                low.is_none_or(|low| low <= truth) && high.is_none_or(|high| truth <= high),
            );
            if seed > 0 {
                continue;
            }
            let mut free = priors.clone();
            free[k].sd = f64::INFINITY;
            let mut held = found.problem.held();
            held[k] = true;
            let base = found.minimum.objective - priors[k].cost(found.minimum.x[k]);
            for end in [low, high].into_iter().flatten() {
                let mut x = found.minimum.x.clone();
                x[k] = end.ln();
                let tolerances = Tolerances::default();
                let there =
                    minimise(&mut found.problem, &x, &free, &scale, &held, tolerances).unwrap();
                let rise = there.objective - base;
                println!(
                    "{}: {end:.0} rise {rise:.2}",
                    found.fit.parameters[k].address
                );
                // The ends are interpolated between a few points, to a seventh of their distance.
                assert!((1.6..2.25).contains(&rise), "{rise}");
            }
        }
        for direction in &found.fit.unidentifiable_directions {
            assert!(direction.sd_log > 0.5);
            let squares: f64 = direction.combination.values().map(|w| w * w).sum();
            assert!((0.6..=1.001).contains(&squares), "{direction:?}");
        }
    }
    println!("{held_truth} of {count} hold");
    // For 15 or more intervals of 95 percent, coverage below four in five has a probability of one percent.
    assert!(count >= 15, "{count}");
    assert!(held_truth * 5 >= count * 4, "{held_truth} of {count}");
}
