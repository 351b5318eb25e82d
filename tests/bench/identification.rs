//! How good the estimates are: `cargo bench --bench identification -- [seeds]` prints the tables of the README.
//!
//! For each axle, noise and nuisance the reference deck is solved, its marks are read with noise (and, with offsets, through
//! bushings that are assembled askew by draws from the prior), and the study is identified from what was read alone.

use std::time::Instant;

use admire::backend::{Backend, NativeBackend, SweepRequest};
use admire::identify::global::{Options, Prepared, fit_study};
use admire::identify::{LoadedStudy, Status};
use admire::model::Model;
use admire::rig::noise::Noise;
use admire::rig::settings::ShiftSd;
use admire::syntax::Address;
use rayon::prelude::*;

/// One fit: ln error and claimed sd of each unknown, whether the 95 percent interval holds the truth.
struct Trial {
    errors: Vec<f64>,
    sds: Vec<f64>,
    covered: Vec<bool>,
    identified: usize,
    sweeps: usize,
    seconds: f64,
    converged: bool,
}

fn loaded(name: &str) -> LoadedStudy {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    LoadedStudy::read(&folder).value.expect("a shipped study")
}

/// Readings of the reference deck with noise and assembly offsets drawn from `seed`.
fn measured(name: &str, sigma: f64, offset: f64, seed: u64) -> LoadedStudy {
    let mut study = loaded(name);
    let truth = study.reference.clone().expect("shipped with a reference");
    let model = Model::lower(&truth).value;
    let mut draw = Noise::new(seed, "offsets");
    let mut theta = Vec::new();
    for bushing in study.problem().bushings() {
        let law = &model.bushings[bushing];
        for axis in 0..6 {
            let (word, k, scale) = if axis < 3 {
                ("FORCE", law.k[axis], 1.0)
            } else {
                ("TORQUE", law.kt[axis - 3], 1f64.to_radians())
            };
            let address = Address {
                kind: "BUSHING".to_string(),
                id: Some(law.header.id),
                argument: Some(word.to_string()),
                index: Some(axis % 3 + 1),
            };
            theta.push((address, k * draw.normal() * offset * scale));
        }
    }
    let request = SweepRequest {
        dataset: &truth,
        model: &model,
        theta: &theta,
        programme: &study.programme,
    };
    let sweep = NativeBackend::new()
        .sweep(&request)
        .expect("the reference deck solves");
    let mut noise = Noise::new(seed, "marks");
    for (case, outcome) in study.measurement.cases.iter_mut().zip(&sweep.cases) {
        let poses = &outcome
            .as_ref()
            .expect("every case of the reference deck solves")
            .poses;
        for reading in &mut case.marks {
            let part = &study.measurement.parts[reading.part];
            reading.x = poses[part.part.0].point(&part.marks[reading.mark].p) + noise.vector(sigma);
        }
    }
    study.measurement.sigma = sigma;
    let sd = if offset > 0.0 { 0.5 } else { 0.0 };
    study.study.identify.offset_sd = ShiftSd {
        length: sd,
        angle_deg: sd,
    };
    study
}

fn trial(name: &str, sigma: f64, offset: f64, seed: u64) -> Trial {
    let study = measured(name, sigma, offset, seed);
    let problem = study.problem();
    let begin = Instant::now();
    let prepared = Prepared::new(&problem).expect("compiles");
    let options = Options {
        start: None,
        profile: false,
        watch: None,
    };
    let found = fit_study(&problem, &prepared, None, options).expect("a fit");
    let seconds = begin.elapsed().as_secs_f64();
    let truth: Vec<f64> = study
        .reference_values()
        .into_iter()
        .map(|value| value.expect("known"))
        .collect();
    let fit = &found.fit;
    Trial {
        errors: fit
            .parameters
            .iter()
            .zip(&truth)
            .map(|(p, k)| (p.value / k).ln())
            .collect(),
        sds: (0..truth.len())
            .map(|k| found.covariance[(k, k)].sqrt())
            .collect(),
        covered: fit
            .parameters
            .iter()
            .zip(&truth)
            .map(|(p, k)| {
                p.interval95[0].is_none_or(|low| low <= *k)
                    && p.interval95[1].is_none_or(|high| *k <= high)
            })
            .collect(),
        identified: fit
            .parameters
            .iter()
            .filter(|p| p.status == Status::Identified)
            .count(),
        sweeps: found.problem.predictor.sweeps(),
        seconds,
        converged: fit.converged,
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let seeds: u64 = std::env::args()
        .skip(1)
        .find_map(|word| word.parse().ok())
        .unwrap_or(200);
    println!(
        "{seeds} seeds; unknowns with a claimed sd of ln K below 0.3 in the four columns before the last three"
    );
    println!(
        "| axle | noise mm | offsets | median ln error | rms error / rms claimed sd | rms standardised error | 95 % intervals hold | each alone | sweeps | ms | converged |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for name in ["pseudo-mcpherson", "multilink"] {
        for sigma in [0.0, 0.01, 0.02, 0.05] {
            for offset in [0.0, 0.2] {
                let count = if sigma == 0.0 { 1 } else { seeds };
                let trials: Vec<Trial> = (0..count)
                    .into_par_iter()
                    .map(|seed| trial(name, sigma, offset, seed))
                    .collect();
                let known = |t: &Trial, k: usize| t.sds[k] < 0.3;
                let pick = |f: &dyn Fn(&Trial, usize) -> f64| -> Vec<f64> {
                    trials
                        .iter()
                        .flat_map(|t| {
                            (0..t.sds.len())
                                .filter(|&k| known(t, k))
                                .map(|k| f(t, k))
                                .collect::<Vec<_>>()
                        })
                        .collect()
                };
                let rms =
                    |v: Vec<f64>| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
                let share = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
                let each: Vec<f64> = (0..trials[0].sds.len())
                    .filter_map(|k| {
                        let own: Vec<f64> = trials
                            .iter()
                            .filter(|t| known(t, k))
                            .map(|t| f64::from(u8::from(t.covered[k])))
                            .collect();
                        (own.len() * 2 > trials.len()).then(|| share(&own))
                    })
                    .collect();
                let covered = pick(&|t, k| f64::from(u8::from(t.covered[k])));
                println!(
                    "| {name} | {sigma} | {} | {:.2e} | {:.2} | {:.2} | {:.1} % | {:.0} to {:.0} % | {:.0} | {:.1} | {}/{} |",
                    if offset > 0.0 { "on" } else { "off" },
                    median(pick(&|t, k| t.errors[k].abs())),
                    rms(pick(&|t, k| t.errors[k])) / rms(pick(&|t, k| t.sds[k])),
                    rms(pick(&|t, k| t.errors[k] / t.sds[k])),
                    100.0 * share(&covered),
                    100.0 * each.iter().copied().fold(1.0, f64::min),
                    100.0 * each.iter().copied().fold(0.0, f64::max),
                    median(trials.iter().map(|t| t.sweeps as f64).collect()),
                    1e3 * median(trials.iter().map(|t| t.seconds).collect()),
                    trials.iter().filter(|t| t.converged).count(),
                    trials.len(),
                );
                let identified =
                    trials.iter().map(|t| t.identified as f64).sum::<f64>() / trials.len() as f64;
                eprintln!(
                    "   {identified:.1} of {} count as identified",
                    trials[0].sds.len()
                );
            }
        }
    }
}
