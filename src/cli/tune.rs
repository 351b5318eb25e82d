use std::path::PathBuf;

use crate::front::fit_view::changed_lines;
use crate::front::tune_page;
use admire_diagnosis::ProgressObserver as _;
use admire_kc::BenchError;
use admire_report::tune_summary;
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
/// The section `[target]` of study.toml states the goals, the numbers that may change, their bounds and the cost of changing them; `admire guide
/// tune` describes every key. The search is a trust-region Gauss-Newton method, with exact derivatives if the solver provides them. It starts from
/// the study and from points spread over the bounds. Writes `tuned.adm` (the deck with new numbers and otherwise unchanged text), `tuning.json` and
/// `report.html`; the deck of the study is not changed.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire tune corpus/double-wishbone --out target/tuned\n  admire tune my-axle --restarts 0"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the output files; `out-tune` in the folder of the study if absent.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of further starts within the bounds, instead of the study's own.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    restarts: Option<u16>,
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
    if let Some(restarts) = arguments.restarts {
        tuning.target.restarts = restarts.into();
    }
    interrupt::listen();
    let bar = Progress::new("searching for the target", shell, || None);
    let all = (1 + tuning.target.restarts) * tuning.target.evaluations;
    let mut before = 0;
    let mut last = (0, 0);
    let outcome = tuning.search(&mut |start, evaluations| {
        if start != last.0 {
            before += last.1;
        }
        last = (start, evaluations);
        bar.count(before + evaluations, Some(all), "evaluations");
        !interrupt::asked()
    });
    drop(bar);
    let outcome = outcome.map_err(|error| refuse(&error, shell))?;
    let value = serde_json::to_string_pretty(&outcome).expect("JSON values print") + "\n";
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
        shell.print(&ending(&tune_summary(&outcome), &written(&report, None)));
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
    if let BenchError::Deck(found) = &error.why
        && !found.is_empty()
    {
        shell.complain(found);
        return Exit::Findings;
    }
    let message = match &error.why {
        BenchError::Deck(_) => "the axle has no equilibrium at any start".to_string(),
        why => why.to_string(),
    };
    let help = "`admire kc` with the kc.toml of the study shows which test fails; a smaller range may have equilibria";
    shell.complain(&[Diagnostic::error(Code::NoEquilibrium, message).help(help)]);
    Exit::NoAnswer
}
