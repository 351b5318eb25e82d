//! Gradients and widths of loops as readings of a K&C study, and held-out curves.

use std::path::{Path, PathBuf};

use admire_diagnosis::{
    Data, DiagnosisProblem, GainCheck, Outcome, Progress, diagnose, diagnose_watched, held_out,
};
use admire_identify::LoadedStudy;
use admire_identify::global::gauss_newton::LeastSquares;
use admire_identify::global::{
    Observations, Options, Prepared, Row, fit_study, fit_unknowns, global_problem,
};
use admire_rig::effect::EffectSpec;
use admire_rig::{RigOptions, RigRun, virtual_rig};
use admire_session::backend::{Backend, BackendError, Sweep, SweepRequest};
use admire_syntax::Address;

use crate::setup::replace;

/// Table of a laboratory, in addition to its curves. The lateral loop is cases 20 to 35, the bounce loop cases 1 to 19.
const TABLE: &str = "name,curve,kind,over,from,to,per,at,unit,value,sigma
toe bounce,toe,gradient,travel,1,13,100,,deg,,0.01
camber lateral,camber,gradient,Fy [N],21,27,1000,,min,,0.3
toe width,toe,width,Fy [N],20,35,,0,deg,,0.004
track width,track,width,Fz [N],1,19,,4500,mm,,0.1
";

/// Copies the shipped rig, with this table and further lines in its study.
fn folder(table: &str, more: &str) -> tempfile::TempDir {
    let rigs = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/rigs/kc-curves");
    let folder = tempfile::tempdir().unwrap();
    for name in ["model.adm", "kc.csv", "study.toml"] {
        std::fs::copy(rigs.join(name), folder.path().join(name)).unwrap();
    }
    let file = "[kc]\nfile = \"kc.csv\"\n";
    let with = format!("{file}summary = \"summary.csv\"\n");
    replace(folder.path(), "study.toml", file, &with);
    std::fs::write(folder.path().join("summary.csv"), table).unwrap();
    let toml = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    std::fs::write(folder.path().join("study.toml"), toml + more).unwrap();
    folder
}

fn rig(folder: &Path, effects: &[&str], sigma: Option<f64>) -> RigRun {
    let options = RigOptions {
        seed: 3,
        sigma,
        effects: effects
            .iter()
            .map(|e| EffectSpec::parse(e).unwrap())
            .collect(),
        ..RigOptions::default()
    };
    virtual_rig(folder, &options).unwrap_or_else(|why| panic!("{why:#?}"))
}

fn text(run: &RigRun, name: &str) -> String {
    let found = run.files.iter().find(|(path, _)| path == Path::new(name));
    String::from_utf8(found.unwrap_or_else(|| panic!("{name}")).1.clone()).unwrap()
}

/// Measures a study on the virtual rig, and reads the result.
fn measured(
    table: &str,
    more: &str,
    effects: &[&str],
    sigma: Option<f64>,
) -> (tempfile::TempDir, LoadedStudy) {
    let folder = folder(table, more);
    let run = rig(folder.path(), effects, sigma);
    for (name, bytes) in &run.files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let read = LoadedStudy::read(folder.path());
    let loaded = read
        .value
        .unwrap_or_else(|| panic!("{:?}", read.diagnostics));
    (folder, loaded)
}

/// Returns a column of a file, given by its index.
fn column(text: &str, at: usize) -> Vec<f64> {
    let cells = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(at).unwrap());
    cells.map(|cell| cell.parse().unwrap()).collect()
}

/// Checks that the rig writes the slopes and the widths of its own curves, computed here in a simple independent way.
#[test]
fn a_rig_takes_gradients_and_widths_from_its_own_curves() {
    let folder = folder(TABLE, "");
    let friction = ["dry-friction@JOINT/3:force=120,stiffness=3000"];
    let run = rig(folder.path(), &friction, Some(0.0));
    let values = column(&text(&run, "summary.csv"), 9);
    let kc = text(&run, "kc.csv");
    let of = |at: usize| column(&kc, at);
    let slope = |x: &[f64], y: &[f64]| {
        let n = x.len() as f64;
        let (sx, sy) = (x.iter().sum::<f64>(), y.iter().sum::<f64>());
        let (sxx, sxy) = (
            x.iter().map(|x| x * x).sum::<f64>(),
            x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>(),
        );
        (n * sxy - sx * sy) / (n * sxx - sx * sx)
    };
    let (toe, camber, travel, lateral) = (of(4), of(5), of(7), of(2));
    let bounce = 100.0 * slope(&travel[..13], &toe[..13]);
    assert!(
        (values[0] - bounce).abs() < 1e-5 * bounce.abs(),
        "{values:?} {bounce}"
    );
    let steep = 60.0 * 1000.0 * slope(&lateral[20..27], &camber[20..27]);
    assert!(
        (values[1] - steep).abs() < 1e-5 * steep.abs(),
        "{values:?} {steep}"
    );
    // Width of a loop: mean reading where the load passes a value while falling, minus the mean where it passes while rising. The ends of a run
    // have only one neighbour.
    let width = |x: &[f64], y: &[f64], at: f64| {
        let mut ways = [Vec::new(), Vec::new()];
        for k in (0..x.len()).filter(|k| x[*k] == at) {
            let rise = x[(k + 1).min(x.len() - 1)] - x[k.max(1) - 1];
            ways[usize::from(rise > 0.0)].push(y[k]);
        }
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        mean(&ways[0]) - mean(&ways[1])
    };
    let toe_width = width(&lateral[19..35], &toe[19..35], 0.0);
    let track_width = width(&of(1)[..19], &of(9)[..19], 4500.0);
    assert!(
        (values[2] - toe_width).abs() < 1e-7,
        "{values:?} {toe_width}"
    );
    assert!(
        (values[3] - track_width).abs() < 1e-7,
        "{values:?} {track_width}"
    );
    assert!(track_width.abs() > 0.01, "friction shows: {track_width}");
    // Without friction, a loop has no width.
    let smooth = column(&text(&rig(folder.path(), &[], Some(0.0)), "summary.csv"), 9);
    assert!(
        smooth[2].abs() < 1e-7 && smooth[3].abs() < 1e-6,
        "{smooth:?}"
    );
}

/// Checks the derivatives of every summary against central differences of whole equilibria. One summary is a gradient over another curve.
#[test]
fn gradients_and_widths_are_differentiated_exactly() {
    let (_folder, loaded) = measured(TABLE, "", &[], None);
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
    let observations = Observations::fitted(problem.measurement, problem.model, &cases);
    let summaries: Vec<usize> = observations
        .rows
        .iter()
        .enumerate()
        .filter(|(_, row)| {
            matches!(**row, Row::Channel { channel, .. } if problem.measurement.channels[channel].summary.is_some())
        })
        .map(|(at, _)| at)
        .collect();
    assert_eq!(summaries.len(), 4);
    let unknowns = fit_unknowns(&problem, &prepared.system, None);
    let predictor = prepared
        .native(&problem, observations.observed.clone())
        .unwrap();
    let mut global = global_problem(&problem, observations, unknowns, Box::new(predictor));
    let x = global.start();
    let exact = global.evaluate(&x, true).unwrap().jacobian;
    let mut sizes = [0.0_f64; 4];
    for k in 0..x.len() {
        let h = 1e-4;
        let mut at = |step: f64| {
            let mut near = x.clone();
            near[k] += step;
            global.evaluate(&near, false).unwrap().residual
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        for (row, size) in summaries.iter().zip(&mut sizes) {
            let (found, expected) = (exact[(*row, k)], slope[*row]);
            *size = size.max(expected.abs());
            assert!(
                (found - expected).abs() < 1e-5 * expected.abs().max(1.0),
                "row {row} unknown {k}: {found} {expected}"
            );
        }
    }
    // Gradients depend on the stiffnesses; widths without friction do not. The order is that of the last cases of the summaries.
    assert!(sizes[0] > 0.1 && sizes[2] > 0.1, "{sizes:?}");
    assert!(sizes[1] < 1e-4 && sizes[3] < 1e-4, "{sizes:?}");
}

/// Checks that a table of summaries alone reduces the standard errors, and that a summary which contradicts the curves is detected.
#[test]
fn gradients_are_readings_of_a_fit() {
    let sharp = TABLE.replace(",0.01\n", ",0.0005\n");
    let (_folder, mut with) = measured(&sharp, "", &[], None);
    let single: Vec<usize> = (0..with.measurement.channels.len())
        .filter(|k| with.measurement.channels[*k].summary.is_none())
        .collect();
    for case in &mut with.measurement.cases {
        for k in &single {
            case.channels[*k] = None;
        }
    }
    let found = |loaded: &LoadedStudy| {
        let problem = loaded.problem();
        let prepared = Prepared::new(&problem).unwrap();
        let found = fit_study(&problem, &prepared, None, Options::default()).unwrap();
        let sds: Vec<f64> = (0..12).map(|k| found.covariance[(k, k)].sqrt()).collect();
        (sds, found.fit.values())
    };
    let (sds, values) = found(&with);
    // The prior standard deviation in this study is 0.5 in ln K.
    assert!(sds.iter().all(|sd| *sd < 0.5 + 1e-9), "{sds:?}");
    assert!(sds.iter().any(|sd| *sd < 0.4), "{sds:?}");
    // With another gradient, the stiffnesses differ.
    let channels = &with.measurement.channels;
    let at = channels
        .iter()
        .position(|c| c.name == "toe bounce")
        .unwrap();
    for case in &mut with.measurement.cases {
        case.channels[at] = case.channels[at].map(|value| value + 0.05);
    }
    let (_, others) = found(&with);
    let most = values.iter().zip(&others).map(|(a, b)| (a / b).ln().abs());
    assert!(most.fold(0.0, f64::max) > 0.05, "{values:?} {others:?}");
}

/// Checks that a held-out curve does not affect the fit, whatever its readings, and that its prediction error is reported.
#[test]
fn a_curve_is_held_out() {
    let hold = "\n[validate]\nhold_out = [\"toe\", \"toe width\"]\n";
    let stiff = [
        "element-parameter@BUSHING/1.K.1:factor=0.5",
        "element-parameter@BUSHING/2.K.1:factor=0.5",
    ];
    let (folder, loaded) = measured(TABLE, hold, &stiff, None);
    let fit = |loaded: &LoadedStudy| {
        let problem = loaded.problem();
        let prepared = Prepared::new(&problem).unwrap();
        fit_study(&problem, &prepared, None, Options::default())
            .unwrap()
            .fit
    };
    let found = fit(&loaded);
    let held = &found.held_out.curves;
    assert_eq!(
        held.iter()
            .map(|c| (c.name.as_str(), c.count))
            .collect::<Vec<_>>(),
        [("toe", 47), ("toe width", 1)]
    );
    let toe = &held[0];
    assert!(
        toe.rms_after < toe.rms_before && toe.rms_before > 0.006,
        "{toe:?}"
    );
    let mut other = loaded.clone();
    for case in &mut other.measurement.cases {
        case.channels[0] = case.channels[0].map(|toe| 3.0 * toe + 0.2);
    }
    let again = fit(&other);
    assert_eq!(found.values(), again.values());
    assert!(again.held_out.curves[0].rms_after > 0.1, "{again:?}");
    // A summary over cases of which some are held out does not affect the fit either.
    let mut subject_cases = vec![false; 47];
    subject_cases[30] = true;
    let problem = loaded.problem();
    let subject = DiagnosisProblem::new(&problem, subject_cases);
    let seen = subject.whitening(Data::Fitted);
    let name = |row: &Row| match *row {
        Row::Channel { channel, .. } => problem.measurement.channels[channel].name.clone(),
        _ => String::new(),
    };
    let used = |of: &str| {
        let rows = subject.rows.iter().zip(&seen.class_of);
        rows.filter(|(row, class)| name(row) == of && class.is_some())
            .count()
    };
    assert_eq!((used("toe"), used("toe width")), (0, 0));
    assert_eq!(
        (used("camber"), used("camber lateral"), used("track width")),
        (46, 1, 1)
    );
    drop(folder);
    let unknown = folder_with_hold_out("nothing");
    let read = LoadedStudy::read(unknown.path());
    let said = read
        .diagnostics
        .iter()
        .find(|d| d.message.contains("nothing"))
        .unwrap();
    assert!(said.message.contains("neither a load case nor a channel"));
}

fn folder_with_hold_out(name: &str) -> tempfile::TempDir {
    folder(TABLE, &format!("\n[validate]\nhold_out = [\"{name}\"]\n"))
}

#[test]
fn a_wrong_table_is_told_where() {
    let change = |from: &str, to: &str| {
        let table = TABLE.replacen(from, to, 1);
        assert_ne!(table, TABLE);
        let folder = folder(&table, "");
        let read = LoadedStudy::read(folder.path());
        let file = PathBuf::from("summary.csv");
        let found = read.diagnostics.iter().filter(|d| {
            d.labels
                .iter()
                .any(|label| Path::new(&*label.file).file_name() == file.file_name())
        });
        let words: Vec<String> = found.map(|d| d.message.clone()).collect();
        words.join("; ")
    };
    for (from, to, told) in [
        ("toe bounce,toe", "toe bounce,tow", "`tow` is not a curve"),
        (
            "gradient,travel",
            "slope,travel",
            "neither `gradient` nor `width`",
        ),
        (
            "gradient,travel",
            "gradient,travels",
            "neither a load nor a curve",
        ),
        (",1,13,", ",1,99,", "no load case `99`"),
        (
            "width,Fy [N],20,35",
            "width,Fy [N],1,19",
            "in both directions",
        ),
        ("width,Fy [N],20,35", "width,travel,20,35", "is not a load"),
        (",,0.01", ",,0", "more than 0"),
        ("deg,,0.01", "mm,,0.01", "not a unit"),
        ("track width,track", "toe width,track", "is already used"),
        ("name,curve", "name,kurve", "no column `curve`"),
    ] {
        let found = change(from, to);
        assert!(found.contains(told), "{to}: {found}");
    }
}

/// Checks curves, gradients and a held-out curve with another solver. The solver returns poses, from which all of them are computed.
#[test]
fn another_solver_is_fitted_to_curves_and_gradients() {
    let hold = "\n[validate]\nhold_out = [\"toe\"]\n";
    let stiff = ["element-parameter@BUSHING/2.K.1:factor=0.8"];
    let (_folder, loaded) = measured(TABLE, hold, &stiff, None);
    let problem = loaded.problem();
    let own = Prepared::new(&problem).unwrap();
    let native = fit_study(&problem, &own, None, Options::default())
        .unwrap()
        .fit;
    let prepared = Prepared::external(&problem).unwrap();
    // The built-in solver is used through the interface of an external solver, and returns the poses of every case.
    let mut backend = admire_session::backend::NativeBackend::new();
    let other = fit_study(&problem, &prepared, Some(&mut backend), Options::default())
        .unwrap()
        .fit;
    assert!(other.converged);
    for (a, b) in native.parameters.iter().zip(&other.parameters) {
        let error = a.std_error.unwrap_or(a.value);
        assert!(
            (a.value - b.value).abs() < 0.05 * error,
            "{}: {} {}",
            a.address,
            a.value,
            b.value
        );
    }
    let (a, b) = (&native.held_out.curves[0], &other.held_out.curves[0]);
    assert_eq!((&a.name, a.count), (&b.name, b.count));
    assert!(
        (a.rms_after / b.rms_after - 1.0).abs() < 1e-2,
        "{a:?} {b:?}"
    );
}

/// Solver in which one bushing is softer than in the deck.
struct Softer(admire_session::backend::NativeBackend);

const SOFTER: f64 = 0.9;
/// Stiffness BUSHING/2.K.1 in the deck.
const IN_THE_DECK: f64 = 310.0;

impl Backend for Softer {
    fn name(&self) -> &'static str {
        "softer"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let rubber = Address::parse("BUSHING/2.K.1", request.dataset).unwrap();
        let mut theta = request.theta.to_vec();
        match theta.iter_mut().find(|(address, _)| *address == rubber) {
            Some((_, value)) => *value *= SOFTER,
            None => theta.push((rubber, SOFTER * IN_THE_DECK)),
        }
        self.0.sweep(&SweepRequest {
            theta: &theta,
            ..*request
        })
    }
}

/// Checks that the final fit of a diagnosis uses the solver of the study, if all readings are channels. In this solver, the bushing is softer
/// than its value in the deck. A fit to the built-in solver would give another value.
#[test]
fn the_last_fit_of_a_diagnosis_takes_channels_of_another_solver() {
    let rubber = format!("element-parameter@BUSHING/2.K.1:factor={SOFTER}");
    let (_folder, loaded) = measured(TABLE, "", &[rubber.as_str()], None);
    let problem = loaded.problem();
    let cases = held_out(&loaded.study, problem.measurement);
    let progress = Progress::default();
    let mut outcome = diagnose_watched(&problem, cases, GainCheck::Quick, &progress).unwrap();
    let found = |outcome: &Outcome<'_>| {
        let mut all = outcome.diagnosis.parameters.iter();
        let of = all.find(|p| p.address == "BUSHING/2.K.1").unwrap();
        assert_eq!(of.initial, IN_THE_DECK);
        (of.value, of.std_error)
    };
    let (native, error) = found(&outcome);
    assert!(
        (native - SOFTER * IN_THE_DECK).abs() < 3.0 * error,
        "{native}"
    );
    let mut other = Softer(admire_session::backend::NativeBackend::new());
    assert_eq!(outcome.by_the_study(&mut other), None);
    // Ten percent is more than ten standard errors.
    let (foreign, error) = found(&outcome);
    assert!((foreign - IN_THE_DECK).abs() < 3.0 * error, "{foreign}");
    assert!((foreign - native) > 10.0 * error, "{foreign} {native}");
}

/// Checks that a reaction, which only the other solver could provide, is refused by name.
#[test]
fn a_reaction_is_no_channel_of_another_solver() {
    let more = "\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\n\
                rod = { function = \"JOINT(5,0,2,0)\", sigma = 10.0 }\n";
    let folder = folder(TABLE, more);
    std::fs::write(folder.path().join("readings.csv"), "case,rod\n").unwrap();
    let run = rig(folder.path(), &[], Some(0.0));
    for (name, bytes) in &run.files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let problem = loaded.problem();
    assert!(Prepared::new(&problem).is_ok());
    let said = Prepared::external(&problem).unwrap_err().to_string();
    assert!(
        said.contains("`rod`") && said.contains("JOINT(5,0,2,0)"),
        "{said}"
    );
}

/// Checks that a search without a held-out curve predicts this curve and confirms the findings of the full search.
#[test]
fn a_diagnosis_predicts_a_curve_that_it_has_not_seen() {
    // Without this setting, load errors of single cases would predict the camber as well, even without the cause, from the other curves.
    let hold = "\n[validate]\nhold_out = [\"camber\"]\n[tolerances]\nload_repeatability = 0\n";
    let friction = ["dry-friction@JOINT/3:force=120,stiffness=3000"];
    let (_folder, loaded) = measured(TABLE, hold, &friction, None);
    let problem = loaded.problem();
    let cases = held_out(&loaded.study, problem.measurement);
    assert!(cases.iter().all(|held| !held), "curves alone are held out");
    let outcome = diagnose(&problem, cases).unwrap();
    let found = outcome.diagnosis.hold_out.unwrap();
    assert!(found.searched && found.cases.is_empty(), "{found:?}");
    assert_eq!(found.curves, ["camber"]);
    assert!(
        found
            .causes
            .iter()
            .any(|cause| cause == "dry-friction JOINT/3"),
        "{found:?}"
    );
    assert!(found.rms_after < 0.5 * found.rms_before, "{found:?}");
}
