use std::path::PathBuf;

use crate::front::fit_view::changed_lines;
use crate::front::tuning::{apply, is_input, json, pair, refusal, tuned};
use crate::front::{TuningOptions, tune_page};
use admire_report::{front_table, tune_summary};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_tune::{Refused, TuneError, Tuning};

use super::Outcome;
use super::ending::{ending, written};
use super::format::Format;
use super::interrupt;
use super::opening::Opening;
use super::output_folder::{Replacing, output_folder, refuse_replacing, write_folder};
use super::progress::Progress;
use super::shell::{Exit, Shell};

/// Change hardpoints, stiffnesses and other numbers of a deck until its K&C characteristics meet their targets.
///
/// The section `[target]` of study.toml names the goals, the numbers that may change, their bounds and the cost of changing them;
/// `admire guide tune` lists every key. The search is a trust-region Gauss-Newton method with exact derivatives where the solver has them.
/// It starts from the study and from points spread over the bounds. If the study states tolerances, the output states the share of axles
/// that meet the goals.
///
/// Writes `tuned.adm` (the deck with new numbers and otherwise unchanged text), `tuning.json` and `report.html`. The deck of the study is
/// not changed.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire tune corpus/double-wishbone --out target/tuned\n  admire tune my-axle --restarts 0\n  admire tune my-axle --pareto 1 \"bounce camber_angle.left, gradient\""
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the output files; by default, `out-tune` in the folder of the study.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of further start points within the bounds, instead of the study's own number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    restarts: Option<u16>,
    /// Compute the Pareto front of two goals, given by their names in the output or by their numbers (from 1).
    #[arg(long, num_args = 2, value_names = ["GOAL", "GOAL"])]
    pareto: Option<Vec<String>>,
    /// Number of axles to solve with drawn tolerances, instead of the study's own number; 0 solves none.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    draws: Option<u32>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    replacing: Replacing,
}

/// Names of the output files.
const OUTPUTS: [&str; 3] = ["tuned.adm", "tuning.json", "report.html"];

/// Runs the search, writes the outputs and prints the result.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let out = output_folder(arguments.out.as_deref(), &arguments.study, "tune");
    refuse_replacing(&out, &OUTPUTS, arguments.replacing, shell)?;
    let (read, said) = Tuning::read(&arguments.study);
    shell.complain(&said);
    let mut tuning = read.map_err(|refused| match refused {
        Refused::Input => Exit::Findings,
        Refused::Start(error) => refuse(&error, shell),
    })?;
    shell.sources.add(tuning.study.source.clone());
    shell.sources.add(tuning.study.deck.clone());
    let options = TuningOptions {
        restarts: arguments.restarts.map(usize::from),
        draws: arguments.draws.map(|draws| draws as usize),
        pareto: match arguments.pareto.as_deref() {
            Some([first, second]) => Some([first.clone(), second.clone()]),
            _ => None,
        },
    };
    apply(&options, &mut tuning);
    let pair = pair(&options, &tuning).map_err(|wrong| shell.usage(*wrong))?;
    interrupt::listen();
    let bar = Progress::new("tuning", shell, || None);
    let outcome = tuned(&tuning, pair, &bar);
    drop(bar);
    let outcome = outcome.map_err(|error| refuse(&error, shell))?;
    let value = json(&outcome);
    let changes = changed_lines(tuning.dataset.bytes(), &outcome.deck);
    let page = tune_page(&arguments.study, &tuning, &outcome, &changes)
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    let files = vec![
        ("tuned.adm".into(), outcome.deck.clone()),
        ("tuning.json".into(), value.clone().into_bytes()),
        ("report.html".into(), page.into_bytes()),
    ];
    write_folder(&out, &files, arguments.replacing, shell)?;
    let report = out.join("report.html");
    if shell.format == Format::Json {
        shell.print(&value);
    } else {
        let front = outcome
            .pareto
            .as_ref()
            .map_or_else(String::new, front_table);
        let end = ending(&tune_summary(&outcome), &written(&report, None));
        shell.print(&(front + &end));
    }
    arguments.opening.open(&report, shell);
    if interrupt::asked() {
        return Ok(Exit::Interrupted);
    }
    Ok(if outcome.converged {
        Exit::Fine
    } else {
        Exit::NoAnswer
    })
}

/// Reports why there is no result, and returns the exit code.
fn refuse(error: &TuneError, shell: &Shell) -> Exit {
    shell.complain(&refusal(error));
    if is_input(error) {
        Exit::Findings
    } else {
        Exit::NoAnswer
    }
}
