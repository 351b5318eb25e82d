use std::ops::ControlFlow;
use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};

use crate::backend::Backend;
use crate::diagnostic::{Code, Diagnostic};
use crate::discrepancy::tolerant;
use crate::identify::global::{Options, Prepared, Start, fit_study};
use crate::identify::{Fit, IdentifyError, LoadedStudy, direct, estimate_noise, regression};
use crate::report::scene::Role;
use crate::report::{IdentificationReport, Positions, lead, number, status};
use crate::rig::settings::{BackendChoice, Method};

use super::Outcome;
use super::input::study;
use super::interrupt;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::plausibility::before_a_fit;
use super::progress::Progress;
use super::render::table_text;
use super::shell::{Exit, Format, Shell};
use super::solver;

/// Identify the stiffnesses of a study from what was measured.
///
/// Writes `identified.adm`, `identification.json` and `report.html`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire identify corpus/pseudo-mcpherson --out target/first\n  admire identify my-axle --out answer --method direct"
)]
pub(super) struct Arguments {
    /// The study's folder.
    study: PathBuf,
    /// Where the answers go.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The method, instead of the study's own.
    #[arg(long, value_enum)]
    method: Option<MethodChoice>,
    /// Keep the folder of every run of an external solver, below `runs` of the output folder; without it only those of failed runs
    /// stay.
    #[arg(long)]
    keep: bool,
    #[command(flatten)]
    replacing: Replacing,
}

/// What is written.
const OUTPUTS: [&str; 3] = ["identified.adm", "identification.json", "report.html"];

/// `--method`.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(super) enum MethodChoice {
    GaussNewton,
    Regression,
    Direct,
}

impl From<MethodChoice> for Method {
    fn from(choice: MethodChoice) -> Self {
        match choice {
            MethodChoice::GaussNewton => Self::GaussNewton,
            MethodChoice::Regression => Self::Regression,
            MethodChoice::Direct => Self::Direct,
        }
    }
}

/// Identifies, writes and prints.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    refuse_replacing(&arguments.out, &OUTPUTS, arguments.replacing, shell)?;
    let mut loaded = study(&arguments.study, shell)?;
    if let Some(method) = arguments.method {
        loaded.study.identify.method = method.into();
    }
    if loaded.unknowns.is_empty() {
        return Err(shell.fail(nothing_to_identify(&loaded)));
    }
    before_a_fit(&loaded, arguments.replacing.force, shell)?;
    let keep = arguments.keep.then(|| arguments.out.join("runs"));
    let mut backend = solver::backend(&loaded.study, keep, shell);
    let sensors = Progress::new("noise of the sensors", shell, || None);
    let found = noise(&mut loaded, backend.as_mut());
    drop(sensors);
    let outcome = found.and_then(|()| among_tolerances(&loaded, backend.as_mut(), shell));
    let positions = outcome.as_ref().map_or_else(
        |_| Vec::new(),
        |fit| positions(&loaded, fit, backend.as_mut()),
    );
    for remark in backend.remarks() {
        shell.say(&format!("{remark}\n"));
    }
    let fit = outcome.map_err(|error| {
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        Exit::NoAnswer
    })?;
    write(&loaded, &fit, &positions, arguments, shell)?;
    if shell.format == Format::Json {
        shell.print(&fit.to_json());
    } else {
        let report = arguments.out.join("report.html");
        shell.print(&format!(
            "{}\n{}\nreport: {}\n",
            table(&loaded, &fit),
            lead(&fit),
            report.display()
        ));
    }
    Ok(if fit.interrupted {
        Exit::Interrupted
    } else if fit.converged {
        Exit::Fine
    } else {
        Exit::NoAnswer
    })
}

/// What a study asks for that names no number, at its place.
fn nothing_to_identify(loaded: &LoadedStudy) -> Diagnostic {
    let study = &loaded.study;
    let message = "the study names nothing to identify";
    let help = if loaded.model.bushings.is_empty() {
        "the deck has no BUSHING; name numbers: stiffnesses = [\"SPRINGDAMPER/1.K\"]".to_string()
    } else {
        let names: Vec<String> = loaded
            .model
            .bushings
            .iter()
            .take(3)
            .map(|bushing| format!("\"BUSHING/{}\"", bushing.header.id))
            .collect();
        format!(
            "bushings = [{}]; without the key every BUSHING is sought",
            names.join(", ")
        )
    };
    let error = Diagnostic::error(Code::MissingSetting, message).help(help);
    error.label(
        study.source.name(),
        study.place(&["identify", "bushings"]),
        "",
    )
}

/// Estimates what the study does not state of its sensors' noise, with whoever solves it.
pub(super) fn noise(
    loaded: &mut LoadedStudy,
    backend: &mut dyn Backend,
) -> Result<(), IdentifyError> {
    let external = loaded.study.solver.backend != BackendChoice::Native;
    estimate_noise(loaded, external.then_some(backend))
}

/// The fit with tolerances beside the stiffnesses, where they can be had: the intervals are those, and profiles would be for nothing.
fn among_tolerances(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    shell: &Shell,
) -> Result<Fit, IdentifyError> {
    if !allows_for_tolerances(loaded) {
        return identified(loaded, backend, shell, true);
    }
    let mut fit = identified(loaded, backend, shell, false)?;
    if fit.interrupted {
        return Ok(fit);
    }
    let problem = loaded.problem();
    let bar = Progress::new("allowing for tolerances", shell, || None);
    let found = fit.fit_test.as_ref().and_then(|_| tolerant(&problem));
    drop(bar);
    match found {
        Some(found) => found.apply(&mut fit),
        None => fit = identified(loaded, backend, shell, true)?,
    }
    Ok(fit)
}

/// Whether tolerances may be fitted beside the stiffnesses: by the built-in solver and the method that knows how exact it is.
fn allows_for_tolerances(loaded: &LoadedStudy) -> bool {
    let settings = &loaded.study.identify;
    let frames = settings.frame_sd.length > 0.0 || settings.frame_sd.angle_deg > 0.0;
    settings.method == Method::GaussNewton
        && loaded.study.solver.backend == BackendChoice::Native
        && !frames
}

/// Runs the study's method on a backend, showing how it goes; with `profile`, poorly known numbers get intervals by profile likelihood
/// if the built-in solver is behind it.
pub(super) fn identified(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    shell: &Shell,
    profile: bool,
) -> Result<Fit, IdentifyError> {
    let problem = loaded.problem();
    interrupt::listen();
    let cases = loaded.programme.cases.len();
    let bar = Progress::new("identifying", shell, || None);
    let mut fit = match loaded.study.identify.method {
        Method::Regression => {
            let most = loaded.study.regression.max_iterations;
            let mut watch = |iteration: usize, _: &[f64], moves: f64| {
                bar.detail(format!("largest change {:.2} %", 100.0 * moves));
                bar.count(iteration, Some(most), "iterations");
                goes_on()
            };
            regression::identify(&problem, backend, &mut watch)?
        }
        Method::Direct => {
            let mut watch = |round: usize, _: &[f64], moves: f64| {
                bar.detail(format!("round {round}, largest change of ln K {moves:.1e}"));
                goes_on()
            };
            direct::identify(&problem, backend, &mut watch)?
        }
        Method::GaussNewton => {
            let external = loaded.study.solver.backend != BackendChoice::Native;
            let prepared = if external {
                Prepared::external(&problem)?
            } else {
                Prepared::new(&problem)?
            };
            let watch = |iteration: usize, sweeps: usize, objective: f64| {
                bar.detail(if sweeps == 0 {
                    "a start from the direct solution".to_string()
                } else {
                    format!("step {iteration}, half chi-square {objective:.4e}")
                });
                bar.count(sweeps * cases, None, "equilibria");
                !interrupt::asked()
            };
            let options = Options {
                start: Start::Auto,
                // Profile likelihood over an external program would take hundreds of runs.
                profile: profile && !external,
                watch: Some(Box::new(watch)),
            };
            let other: Option<&mut dyn Backend> = if external { Some(backend) } else { None };
            fit_study(&problem, &prepared, other, options)?.fit
        }
    };
    drop(bar);
    fit.inputs_sha256 = loaded.study.inputs_sha256();
    Ok(fit)
}

/// Breaks a run that was asked to stop.
fn goes_on() -> ControlFlow<()> {
    if interrupt::asked() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// Where the solver puts the parts with the initial and with the identified numbers; without those it does not tell, as a recording
/// that lacks them.
fn positions(loaded: &LoadedStudy, fit: &Fit, backend: &mut dyn Backend) -> Vec<Positions> {
    // Pictures are not worth the licences of another solver.
    if loaded.study.solver.backend != BackendChoice::Native {
        return Vec::new();
    }
    let problem = loaded.problem();
    let wanted = [
        ("initial", Role::Initial, problem.initial()),
        ("identified", Role::Fitted, fit.values()),
    ];
    let solved = wanted.into_iter().filter_map(|(name, role, values)| {
        let sweep = problem.sweep(backend, &values).ok()?;
        Some(Positions::of(name, role, &sweep))
    });
    solved.collect()
}

fn write(
    loaded: &LoadedStudy,
    fit: &Fit,
    positions: &[Positions],
    arguments: &Arguments,
    shell: &mut Shell,
) -> Result<(), Exit> {
    let deck = loaded
        .identified_deck(&fit.values())
        .map_err(|diagnostic| shell.fail(diagnostic))?;
    let diff = changed_lines(loaded.dataset.bytes(), &deck);
    let report = IdentificationReport {
        loaded,
        fit,
        diff: &diff,
        positions,
    };
    let html = report
        .html()
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    let texts = [deck, fit.to_json().into_bytes(), html.into_bytes()];
    let files: Vec<(PathBuf, Vec<u8>)> =
        OUTPUTS.map(PathBuf::from).into_iter().zip(texts).collect();
    write_folder(&arguments.out, &files, arguments.replacing, shell)
}

/// The lines that differ, with the three lines before and behind them that tell whose they are.
pub(super) fn changed_lines(before: &[u8], after: &[u8]) -> String {
    let (before, after) = (
        String::from_utf8_lossy(before),
        String::from_utf8_lossy(after),
    );
    let diff = similar::TextDiff::from_lines(before.as_ref(), after.as_ref());
    let text = diff.unified_diff().context_radius(3).to_string();
    text.replace('\r', "")
}

/// Initial, identified and reference values.
fn table(loaded: &LoadedStudy, fit: &Fit) -> String {
    let reference = loaded.reference_values();
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "number",
        "initial",
        "identified",
        "std error",
        "reference",
        "ratio",
        "",
    ]);
    for (parameter, reference) in fit.parameters.iter().zip(reference) {
        table.add_row([
            std::iter::once(&parameter.address)
                .chain(&parameter.tied)
                .cloned()
                .collect::<Vec<_>>()
                .join(" = "),
            number(parameter.initial, None),
            number(parameter.value, parameter.std_error),
            parameter
                .std_error
                .map_or_else(String::new, |error| number(error, Some(error))),
            reference.map_or_else(String::new, |value| number(value, None)),
            reference.map_or_else(String::new, |value| {
                format!("{:.3}", parameter.value / value)
            }),
            status(parameter.status).to_string(),
        ]);
    }
    for column in table.column_iter_mut().skip(1).take(5) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table_text(&table)
}
