use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};

use crate::backend::Backend;
use crate::diagnostic::{Code, Diagnostic};
use crate::identify::global::{Options, Prepared, Start, fit_study};
use crate::identify::{Fit, IdentifyError, LoadedStudy, direct, regression};
use crate::report::{IdentificationReport, lead, number, status};
use crate::rig::settings::{BackendChoice, Method};

use super::Outcome;
use super::input::study;
use super::interrupt;
use super::render::table_text;
use super::shell::{Exit, Format, Shell};
use super::solver;

/// Identify the stiffnesses of a study from what was measured.
///
/// Writes `identified.adm`, `identification.json` and `report.html`.
#[derive(clap::Args, Debug)]
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
}

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
    let mut loaded = study(&arguments.study, shell)?;
    if let Some(method) = arguments.method {
        loaded.study.identify.method = method.into();
    }
    let keep = arguments.keep.then(|| arguments.out.join("runs"));
    let mut backend = solver::backend(&loaded.study, keep, shell);
    let outcome = identified(&loaded, backend.as_mut(), shell);
    for remark in backend.remarks() {
        shell.say(&format!("{remark}\n"));
    }
    let fit = outcome.map_err(|error| {
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        Exit::NoAnswer
    })?;
    write(&loaded, &fit, &arguments.out, shell)?;
    match shell.format {
        Format::Json => shell.print(&fit.to_json()),
        Format::Text | Format::Plain => {
            let report = arguments.out.join("report.html");
            shell.print(&format!(
                "{}\n{}\nreport: {}\n",
                table(&loaded, &fit),
                lead(&fit),
                report.display()
            ));
        }
    }
    Ok(if fit.converged {
        Exit::Fine
    } else {
        Exit::NoAnswer
    })
}

/// Runs the study's method on a backend, showing how it goes.
pub(super) fn identified(
    loaded: &LoadedStudy,
    backend: &mut dyn Backend,
    shell: &Shell,
) -> Result<Fit, IdentifyError> {
    let problem = loaded.problem();
    interrupt::listen();
    let bar = ProgressBar::new_spinner().with_style(
        ProgressStyle::with_template("{spinner} {msg}").expect("the template is valid"),
    );
    if !shell.shows_progress() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
    }
    let mut fit = match loaded.study.identify.method {
        Method::Regression => {
            let mut watch = |iteration: usize, _: &[f64], moves: f64| {
                bar.set_message(format!(
                    "iteration {iteration}: largest change {:.2} %",
                    100.0 * moves
                ));
                bar.tick();
                goes_on()
            };
            regression::identify(&problem, backend, &mut watch)?
        }
        Method::Direct => {
            let mut watch = |round: usize, _: &[f64], moves: f64| {
                bar.set_message(format!("round {round}: largest change of ln K {moves:.1e}"));
                bar.tick();
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
                bar.set_message(if sweeps == 0 {
                    "a start from the direct solution".to_string()
                } else {
                    format!("step {iteration}: {sweeps} sweeps, half chi-square {objective:.4e}")
                });
                bar.tick();
                !interrupt::asked()
            };
            let options = Options {
                start: Start::Auto,
                profile: true,
                watch: Some(Box::new(watch)),
            };
            // Profile likelihood over an external program would take hundreds of runs.
            let options = Options {
                profile: !external,
                ..options
            };
            let other: Option<&mut dyn Backend> = if external { Some(backend) } else { None };
            fit_study(&problem, &prepared, other, options)?.fit
        }
    };
    bar.finish_and_clear();
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

fn write(loaded: &LoadedStudy, fit: &Fit, out: &Path, shell: &mut Shell) -> Result<(), Exit> {
    std::fs::create_dir_all(out).map_err(|error| {
        shell.fail(Diagnostic::error(
            Code::CannotWrite,
            format!("{}: {error}", out.display()),
        ))
    })?;
    let deck = loaded
        .identified_deck(&fit.values())
        .map_err(|diagnostic| shell.fail(diagnostic))?;
    let diff = changed_lines(loaded.dataset.bytes(), &deck);
    let report = IdentificationReport {
        loaded,
        fit,
        diff: &diff,
    };
    let html = report
        .html()
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    shell.write(&out.join("identified.adm"), &deck)?;
    shell.write(&out.join("identification.json"), fit.to_json().as_bytes())?;
    shell.write(&out.join("report.html"), html.as_bytes())
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
