//! Benchmark of the quality of estimates: `cargo bench --bench identification -- [seeds] [axle]` prints the tables of the guide.
//!
//! For each axle, noise and nuisance, the reference deck is solved and its marks are read with noise. With offsets, bushings are also
//! assembled askew by draws from the prior. The study is identified from these readings alone: by the global fit, and by the paper's loop
//! as printed, with at most 50 iterations. The Cramer-Rao bound is for the unknowns and priors of the fit at the true values. Wheel angles
//! are compared with the reference in every load case.

use std::ops::ControlFlow;
use std::time::Instant;

use admire_identify::global::confidence::covariance;
use admire_identify::global::gauss_newton::{Tolerances, minimise};
use admire_identify::global::{
    Observations, Options, Prepared, Start, StartValues, fit_study, fit_unknowns, global_problem,
    profile_interval,
};
use admire_identify::settings::POOR_NORMAL_LN_SD;
use admire_identify::{LoadedStudy, regression};
use admire_session::backend::{Backend, NativeBackend, Sweep, SweepRequest};
use admire_solver::mechanics::Pose;
use admire_solver::model::Model;
use admire_study::noise::Noise;
use admire_study::settings::{Amount, ShiftSd, SpinAxis};
use admire_study::wheel::SpinDirection;
use admire_syntax::Address;
use rayon::prelude::*;

/// Upper limit of the Cramer-Rao bound on ln K for a stiffness to be included in the tables.
const KNOWN: f64 = 0.3;
/// Prior standard deviation of the assembly offsets that are drawn and fitted, in mm and degrees.
const OFFSET: f64 = 0.5;
/// Maximum number of iterations of the paper's loop.
const LOOP: usize = 50;
/// Interval of seeds that are also fitted from the direct solution.
const DIRECT_EVERY: usize = 20;
/// Interval of seeds on which the paper's loop runs for the multilink, where it does not converge and takes longer than everything else.
const LOOP_EVERY: u64 = 4;

/// An axle with a noise level and a choice of nuisances.
#[derive(Clone, Copy)]
struct Setting {
    axle: &'static str,
    sigma: f64,
    offsets: bool,
}

/// Result of one fit.
struct Trial {
    /// Errors of ln K: estimate minus true value.
    errors: Vec<f64>,
    /// Reported standard deviations of ln K.
    sds: Vec<f64>,
    /// Whether each 95 percent interval contains the true value.
    covered: Vec<bool>,
    converged: bool,
    sweeps: usize,
    seconds: f64,
    /// Rms errors of camber and steer in degrees, of the fit and of the initial model.
    wheel: [[f64; 2]; 2],
    /// Result of the paper's loop, if it was run.
    paper: Option<Paper>,
    /// Duration of one plain sweep over the load cases, in seconds.
    sweep_seconds: f64,
}

/// Result of the paper's loop on the same readings.
struct Paper {
    /// Rms errors of camber and steer in degrees.
    wheel: [f64; 2],
    iterations: usize,
    seconds: f64,
}

fn loaded(name: &str) -> LoadedStudy {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    LoadedStudy::read(&folder).value.expect("a shipped study")
}

/// Returns a study whose marks come from the reference deck, with noise and assembly offsets drawn from `seed`, and the true sweep.
fn measured(setting: Setting, seed: u64) -> Option<(LoadedStudy, Sweep)> {
    let mut study = loaded(setting.axle);
    let truth = study.reference.clone().expect("shipped with a reference");
    let model = Model::lower(&truth).value;
    let mut draw = Noise::new(seed, "offsets");
    let mut theta = Vec::new();
    let bushings = if setting.offsets {
        study.problem().bushings()
    } else {
        Vec::new()
    };
    for bushing in bushings {
        let law = &model.bushings[bushing];
        // Round bushings are identified with one stiffness, but each side may be askew along every axis.
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
            theta.push((address, k * draw.normal() * OFFSET * scale));
        }
    }
    let request = SweepRequest {
        dataset: &truth,
        model: &model,
        theta: &theta,
        programme: &study.programme,
    };
    let sweep = NativeBackend::new().sweep(&request).ok()?;
    let mut noise = Noise::new(seed, "marks");
    for (case, outcome) in study.measurement.cases.iter_mut().zip(&sweep.cases) {
        let poses = &outcome.as_ref().ok()?.poses;
        for reading in &mut case.marks {
            let part = &study.measurement.parts[reading.part];
            reading.x =
                poses[part.part.0].point(&part.marks[reading.mark].p) + noise.vector(setting.sigma);
        }
    }
    study.measurement.sigma = setting.sigma;
    let sd = if setting.offsets { OFFSET } else { 0.0 };
    study.study.identify.offset_sd = ShiftSd {
        length: Amount::Stated(sd),
        angle_deg: sd,
    };
    study.study.regression.max_iterations = LOOP;
    Some((study, sweep))
}

/// Returns camber and steer of the wheel carrier's marker `WC` in degrees.
fn wheel(model: &Model, poses: &[Pose]) -> [f64; 2] {
    let marker = model.markers.iter().find(|m| m.header.name == "WC");
    let marker = marker.expect("the shipped axles have a wheel centre");
    let local = Pose {
        p: marker.qp,
        R: marker.R,
    };
    let axis = SpinAxis {
        axis: 1,
        sign: None,
    };
    let design = model.parts[marker.part.0].pose.compose(&local);
    let reading =
        SpinDirection::at_design(&design, axis).reading(&poses[marker.part.0].compose(&local));
    [reading.camber_deg, reading.steer_deg]
}

/// Returns the rms differences of camber and steer over the load cases that both sweeps solve.
fn wheel_error<'a>(
    model: &Model,
    truth: &Sweep,
    of: impl Iterator<Item = Option<&'a [Pose]>>,
) -> [f64; 2] {
    let (mut sum, mut count) = ([0.0; 2], 0);
    for (case, poses) in of.enumerate() {
        let (Some(truth), Some(poses)) = (truth.equilibrium(case), poses) else {
            continue;
        };
        let (a, b) = (wheel(model, &truth.poses), wheel(model, poses));
        for k in 0..2 {
            sum[k] += (a[k] - b[k]).powi(2);
        }
        count += 1;
    }
    sum.map(|s| (s / f64::from(count.max(1))).sqrt())
}

fn sweep_error(model: &Model, truth: &Sweep, sweep: &Sweep) -> [f64; 2] {
    let cases = 0..sweep.cases.len();
    wheel_error(
        model,
        truth,
        cases.map(|case| sweep.equilibrium(case).map(|e| e.poses.as_slice())),
    )
}

fn truth_of(study: &LoadedStudy) -> Vec<f64> {
    let values = study.reference_values().into_iter();
    values.map(|value| value.expect("known")).collect()
}

/// Returns the Cramer-Rao bound of each ln K at the true values.
fn bounds(setting: Setting) -> Vec<f64> {
    let plain = Setting {
        offsets: false,
        ..setting
    };
    let (mut study, _) = measured(plain, 0).expect("the reference deck solves");
    let sd = if setting.offsets { OFFSET } else { 0.0 };
    study.study.identify.offset_sd = ShiftSd {
        length: Amount::Stated(sd),
        angle_deg: sd,
    };
    let problem = study.problem();
    let prepared = Prepared::new(&problem).expect("compiles");
    let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
    let observations = Observations::new(problem.measurement, problem.model, &cases);
    let start = StartValues {
        values: truth_of(&study),
        offsets: Vec::new(),
    };
    let unknowns = fit_unknowns(&problem, &prepared.system, Some(&start));
    let predictor = prepared
        .native(&problem, observations.observed.clone())
        .expect("native");
    let mut global = global_problem(&problem, observations, unknowns, Box::new(predictor));
    let (priors, scale, held) = (global.priors(), global.scale(), global.held());
    let x = global.start();
    let here = Tolerances {
        max_iterations: 0,
        ..Tolerances::default()
    };
    let minimum =
        minimise(&mut global, &x, &priors, &scale, &held, here).expect("the true values solve");
    let covariance = covariance(&minimum, &held);
    (0..problem.unknowns.len())
        .map(|k| covariance[(k, k)].sqrt())
        .collect()
}

fn trial(setting: Setting, seed: u64, bounds: &[f64], start: Start, beside: bool) -> Option<Trial> {
    let (study, true_sweep) = measured(setting, seed)?;
    let problem = study.problem();
    let truth = truth_of(&study);
    let mut backend = NativeBackend::new();
    let mut quiet = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
    let paper = if beside {
        let begin = Instant::now();
        let paper = regression::identify(&problem, &mut NativeBackend::new(), &mut quiet).ok()?;
        let seconds = begin.elapsed().as_secs_f64();
        let swept = problem.sweep(&mut backend, &paper.values()).ok()?;
        Some(Paper {
            wheel: sweep_error(&study.model, &true_sweep, &swept),
            iterations: paper.iterations,
            seconds,
        })
    } else {
        None
    };
    let initial = problem.sweep(&mut backend, &problem.initial()).ok()?;
    let begin = Instant::now();
    problem.sweep(&mut backend, &truth).ok()?;
    let sweep_seconds = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    let prepared = Prepared::new(&problem).expect("compiles");
    let options = Options {
        start,
        ..Options::default()
    };
    let mut found = fit_study(&problem, &prepared, None, options).ok()?;
    let seconds = begin.elapsed().as_secs_f64();
    let sweeps = found.problem.predictor.sweeps() - 2;
    let sds: Vec<f64> = (0..truth.len())
        .map(|k| found.covariance[(k, k)].sqrt())
        .collect();
    let (priors, scale, held) = (
        found.problem.priors(),
        found.problem.scale(),
        found.problem.held(),
    );
    let mut covered = Vec::new();
    for (k, parameter) in found.fit.parameters.iter().enumerate() {
        // Intervals use the profile likelihood wherever the command would use it.
        let interval = if bounds[k] < KNOWN && sds[k] > POOR_NORMAL_LN_SD {
            profile_interval(
                &mut found.problem,
                &found.minimum,
                k,
                &found.covariance,
                &priors,
                &scale,
                &held,
            )
            .map(|side| side.map(f64::exp))
        } else {
            parameter.interval95
        };
        covered.push(
            interval[0].is_none_or(|low| low <= truth[k])
                && interval[1].is_none_or(|high| truth[k] <= high),
        );
    }
    let numbers = found
        .problem
        .unknowns
        .numbers(&found.problem.deck, &found.minimum.x);
    let fitted = found.problem.predictor.predict(&numbers, None);
    let fitted = fitted
        .iter()
        .map(|case| case.as_ref().map(|case| case.poses.as_slice()));
    let errors = found.fit.parameters.iter().zip(&truth);
    Some(Trial {
        errors: errors.map(|(p, k)| (p.value / k).ln()).collect(),
        covered,
        converged: found.fit.converged,
        sweeps,
        seconds,
        wheel: [
            wheel_error(&study.model, &true_sweep, fitted),
            sweep_error(&study.model, &true_sweep, &initial),
        ],
        paper,
        sweep_seconds,
        sds,
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

fn range(values: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    values
        .iter()
        .fold(start, |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Returns one row for each table: estimates, wheel angles, time.
fn rows(setting: Setting, seeds: u64) -> [String; 3] {
    let bounds = bounds(setting);
    let exact = setting.sigma == 0.0;
    let count = match (exact, setting.offsets) {
        (true, false) => 1,
        (true, true) => seeds.min(10),
        _ => seeds,
    };
    let beside = |seed: u64| setting.axle != "multilink" || seed.is_multiple_of(LOOP_EVERY);
    let trials: Vec<Trial> = (0..count)
        .into_par_iter()
        .filter_map(|seed| trial(setting, seed, &bounds, Start::Auto, beside(seed)))
        .collect();
    // Fits from the direct solution show what this start saves and costs.
    let some: Vec<u64> = (0..count).step_by(DIRECT_EVERY).collect();
    let direct: Vec<Trial> = some
        .into_par_iter()
        .filter_map(|seed| trial(setting, seed, &bounds, Start::Direct, false))
        .collect();
    let known: Vec<usize> = (0..bounds.len()).filter(|&k| bounds[k] < KNOWN).collect();
    let of = |k: usize, f: &dyn Fn(&Trial, usize) -> f64| -> Vec<f64> {
        trials.iter().map(|t| f(t, k)).collect()
    };
    let pooled = |f: &dyn Fn(&Trial, usize) -> f64| -> Vec<f64> {
        known.iter().flat_map(|&k| of(k, f)).collect()
    };
    let covers = |t: &Trial, k: usize| 100.0 * f64::from(u8::from(t.covered[k]));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let each_cover: Vec<f64> = known.iter().map(|&k| mean(&of(k, &covers))).collect();
    let each_ratio: Vec<f64> = known
        .iter()
        .map(|&k| rms(&of(k, &|t, k| t.errors[k] / bounds[k])))
        .collect();
    let offsets = if setting.offsets { "on" } else { "off" };
    let head = format!("| {} | {} | {offsets} |", setting.axle, setting.sigma);
    let estimates = if exact {
        let worst = pooled(&|t, k| t.errors[k].abs())
            .into_iter()
            .fold(0.0, f64::max);
        format!(
            "{head} {} of {} | {worst:.1e} (largest) | | | | | {}/{} |",
            known.len(),
            bounds.len(),
            trials.iter().filter(|t| t.converged).count(),
            count,
        )
    } else {
        let (low, high) = range(&each_ratio);
        let (cover_low, cover_high) = range(&each_cover);
        format!(
            "{head} {} of {} | {:.3} | {:.2} ({low:.2} to {high:.2}) | {:.2} | {:.1} | {cover_low:.0} to {cover_high:.0} | {}/{} |",
            known.len(),
            bounds.len(),
            median(pooled(&|t, k| t.errors[k].abs())),
            rms(&each_ratio),
            rms(&pooled(&|t, k| t.errors[k] / t.sds[k])),
            mean(&pooled(&covers)),
            trials.iter().filter(|t| t.converged).count(),
            count,
        )
    };
    let angle =
        |who: usize, k: usize| rms(&trials.iter().map(|t| t.wheel[who][k]).collect::<Vec<_>>());
    let papers: Vec<(&Trial, &Paper)> = trials
        .iter()
        .filter_map(|t| Some((t, t.paper.as_ref()?)))
        .collect();
    let by_loop = |k: usize| rms(&papers.iter().map(|(_, p)| p.wheel[k]).collect::<Vec<_>>());
    // Number of fits with a larger error than the loop, and the largest excess.
    let beaten = |k: usize| {
        let behind = papers.iter().map(|(t, p)| t.wheel[0][k] - p.wheel[k]);
        let worse: Vec<f64> = behind.filter(|by| *by > 0.0).collect();
        let most = worse.iter().copied().fold(0.0, f64::max);
        format!("{} of {} (by {most:.4})", worse.len(), papers.len())
    };
    let share = |k: usize| {
        trials
            .iter()
            .map(|t| t.wheel[0][k] / t.wheel[1][k])
            .fold(0.0, f64::max)
    };
    let wheel = format!(
        "{head} {:.4} / {:.4} / {:.3} | {} | {:.3} | {:.4} / {:.4} / {:.3} | {} | {:.3} |",
        angle(0, 0),
        by_loop(0),
        angle(1, 0),
        beaten(0),
        share(0),
        angle(0, 1),
        by_loop(1),
        angle(1, 1),
        beaten(1),
        share(1),
    );
    let middle = |of: &[Trial], f: &dyn Fn(&Trial) -> f64| median(of.iter().map(f).collect());
    let of_start = |of: &[Trial]| {
        format!(
            "{:.0} (most {}) | {:.1} | {:.0} |",
            middle(of, &|t| t.sweeps as f64),
            of.iter().map(|t| t.sweeps).max().unwrap_or(0),
            1e3 * middle(of, &|t| t.seconds),
            middle(of, &|t| t.seconds / t.sweep_seconds),
        )
    };
    let of_loop =
        |f: &dyn Fn(&Trial, &Paper) -> f64| median(papers.iter().map(|(t, p)| f(t, p)).collect());
    let time = format!(
        "{head} {} {} {:.0} | {:.1} | {:.0} |",
        of_start(&trials),
        of_start(&direct),
        of_loop(&|_, p| p.iterations as f64),
        1e3 * of_loop(&|_, p| p.seconds),
        of_loop(&|t, p| p.seconds / t.sweep_seconds),
    );
    [estimates, wheel, time]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let seeds: u64 = words
        .iter()
        .find_map(|word| word.parse().ok())
        .unwrap_or(200);
    let axles = ["pseudo-mcpherson", "multilink"];
    let chosen = |axle: &str| {
        !words.iter().any(|word| axles.contains(&word.as_str())) || words.iter().any(|w| w == axle)
    };
    let mut tables: [Vec<String>; 3] = Default::default();
    for axle in axles.into_iter().filter(|axle| chosen(axle)) {
        for sigma in [0.0, 0.01, 0.02, 0.05] {
            for offsets in [false, true] {
                let setting = Setting {
                    axle,
                    sigma,
                    offsets,
                };
                let begin = Instant::now();
                let rows = rows(setting, seeds);
                eprintln!("{:.0} s", begin.elapsed().as_secs_f64());
                for (table, row) in tables.iter_mut().zip(rows) {
                    eprintln!("{row}");
                    table.push(row);
                }
            }
        }
    }
    let [estimates, wheel, time] = tables.map(|rows| rows.join("\n"));
    println!("`cargo bench --bench identification -- {seeds}`\n");
    println!(
        "Estimates, {seeds} seeds, numbers whose Cramer-Rao bound on ln K is below {KNOWN}:\n"
    );
    println!(
        "| axle | noise mm | offsets | judged | median ln error | rms error over bound, pooled (each) | rms standardised error | 95 % intervals hold, % | each alone, % | converged |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|\n{estimates}\n");
    println!(
        "Wheel, rms error in degrees over seeds and load cases of the fit / the paper's loop (at most {LOOP} iterations; on the multilink every {LOOP_EVERY}th seed) / the initial model; in brackets by how many degrees the fit is further off at most:\n"
    );
    println!(
        "| axle | noise mm | offsets | camber | fit worse than loop | largest share of the initial error | steer | fit worse than loop | largest share of the initial error |"
    );
    println!("|---|---|---|---|---|---|---|---|---|\n{wheel}\n");
    println!(
        "Time of a whole identification, one core each, medians (from the direct solution: every {DIRECT_EVERY}th seed); a sweep-equivalent is the time of one plain solve of all load cases:\n"
    );
    println!(
        "| axle | noise mm | offsets | sweeps from 1e4 | ms | sweep-equivalents | sweeps from the direct solution | ms with it | sweep-equivalents | loop iterations | loop ms | sweep-equivalents |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|\n{time}");
}
