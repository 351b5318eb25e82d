use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};

use crate::diagnostic::{Code, Diagnostic};
use crate::front::fit::{changed_lines, identify, nothing_to_identify, positions};
use crate::front::solver;
use crate::identify::{Fit, LoadedStudy};
use crate::report::{IdentificationReport, Positions, lead, number, status};
use crate::rig::settings::Method;

use super::Outcome;
use super::input::study;
use super::interrupt;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::plausibility::before_a_fit;
use super::progress::Progress;
use super::render::{hanging, table_text};
use super::shell::{Exit, Format, Shell};

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
    let told = |note: &Diagnostic| shell.complain(std::slice::from_ref(note));
    let mut backend = solver::backend(&loaded.study, keep, &told);
    interrupt::listen();
    let bar = Progress::new("reading", shell, || None);
    let outcome = identify(&mut loaded, backend.as_mut(), &bar);
    drop(bar);
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
            "{}\n{}report: {}\n",
            table(&loaded, &fit),
            hanging("", &lead(&fit)),
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

/// Initial and identified values, and those of a reference where the study has one.
fn table(loaded: &LoadedStudy, fit: &Fit) -> String {
    let reference = loaded.reference_values();
    let compares = reference.iter().any(Option::is_some);
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut head = vec!["number", "initial", "identified", "std error"];
    if compares {
        head.extend(["reference", "ratio"]);
    }
    head.push("");
    table.set_header(&head);
    for (parameter, reference) in fit.parameters.iter().zip(reference) {
        let addresses = std::iter::once(&parameter.address).chain(&parameter.tied);
        let mut row = vec![
            addresses.cloned().collect::<Vec<_>>().join(" = "),
            number(parameter.initial, None),
            number(parameter.value, parameter.std_error),
            parameter
                .std_error
                .map_or_else(String::new, |error| number(error, Some(error))),
        ];
        if compares {
            let ratio = |value: f64| format!("{:.3}", parameter.value / value);
            row.push(reference.map_or_else(String::new, |value| number(value, None)));
            row.push(reference.map_or_else(String::new, ratio));
        }
        row.push(status(parameter.status).to_string());
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1).take(head.len() - 2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table_text(&table)
}
