use admire_design::propose;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::front::car_files;
use crate::front::fit_view::changed_lines;
use crate::front::foreign_parts;
use admire_diagnosis::{
    Finding, GainCheck, Outcome as Diagnosed, Progress as Watched, diagnose_watched, held_out,
};
use admire_identify::{LoadedStudy, estimate_noise};
use admire_report::{DiagnosisReport, diagnosis_sentences, diagnosis_summary, fit_in_words, sizes};
use admire_study::settings::BackendChoice;
use admire_study::{permission::NamedProgram, solver};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::ending::{ending, written};
use super::format::Format;
use super::input::study_in_brief;
use super::interrupt;
use super::opening::Opening;
use super::output_folder::{
    Forced, Replacing, folder_for_car, output_folder, refuse_car_files, refuse_replacing,
    write_folder,
};
use super::permission::Permission;
use super::plausibility::{before_a_fit, deck_warnings};
use super::progress::{Count, Progress};
use super::shell::{Exit, Shell};

/// Find the faults that remain in a model after its best fit, name their causes, and extend the model by them.
///
/// Writes `diagnosis.json`, `extended.adm`, `extended.acf` and `report.html`. If the study names a subsystem of Adams/Car (`[car]`), a new
/// subsystem file, property files with learned curves and the list `changes.json` are written to the subfolder `adams_car`. The terminal
/// shows the result in at most 15 lines; `-v` shows everything.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire diagnose corpus/kc-experiment --out target/kc\n  admire diagnose my-axle --open\n  admire diagnose my-axle --out answer --format json | jq .findings"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the output files; by default, `out-diagnose` in the folder of the study.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Method for measuring the gain of the causes in load cases that were held out.
    #[arg(long, value_enum, default_value_t = CheckChoice::HeldOut)]
    check_gain: CheckChoice,
    /// Maximum time for the search, in seconds. After this time, the search ends with the causes found so far.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    budget: Option<Duration>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    forced: Forced,
    #[command(flatten)]
    permission: Permission,
}

/// Choice of a [`GainCheck`] on the command line.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
enum CheckChoice {
    /// Refit without the held-out cases, although the causes were chosen with them.
    Quick,
    /// Also search a second time without the held-out cases.
    HeldOut,
    /// Also search without each group of the cross-validation; takes up to seven times as long.
    Folds,
}

/// Parses a duration in seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let wrong = || "the time is a number of seconds, zero or larger".to_string();
    let seconds: f64 = text.parse().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(seconds).map_err(|_| wrong())
}

/// Names of the output files.
const OUTPUTS: [&str; 4] = [
    "extended.adm",
    "extended.acf",
    "diagnosis.json",
    "report.html",
];

/// Diagnoses the study, writes the outputs and prints the result.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let out = output_folder(arguments.out.as_deref(), &arguments.study, "diagnose");
    let replacing = arguments.forced.replacing();
    refuse_replacing(&out, &OUTPUTS, replacing, shell)?;
    let mut loaded = study_in_brief(&arguments.study, shell)?;
    refuse_car_files(&loaded, &out, replacing, shell)?;
    let foreign = foreign_parts(&loaded);
    if !foreign.is_empty() {
        // If the readings belong to other parts, a diagnosis of the model is meaningless.
        shell.complain(&foreign);
        return Err(Exit::Findings);
    }
    let program = NamedProgram::of_study(&loaded.study);
    arguments.permission.ask(program.as_ref(), shell)?;
    before_a_fit(&loaded, arguments.forced.force, shell)?;
    if let Err(error) = estimate_noise(&mut loaded, None) {
        deck_warnings(&loaded, shell);
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        return Err(Exit::NoAnswer);
    }
    let problem = loaded.problem();
    let held_out = held_out(&loaded.study, &loaded.measurement);
    let mut watched = Watched::default();
    if let Some(time) = arguments.budget {
        watched = watched.within(time);
    }
    let seen = watched.clone();
    interrupt::listen();
    let bar = Progress::new("diagnosing", shell, move || {
        if interrupt::asked() {
            seen.stop();
        }
        let budget = seen.budget();
        let count = Count {
            done: seen.sweeps(),
            of: (budget > 0).then_some(budget),
            what: "sweeps",
        };
        Some((seen.stage(), count))
    });
    let check = match arguments.check_gain {
        CheckChoice::Quick => GainCheck::Quick,
        CheckChoice::HeldOut => GainCheck::HeldOut,
        CheckChoice::Folds => GainCheck::Folds,
    };
    let found = diagnose_watched(&problem, held_out, check, &watched);
    drop(bar);
    let mut outcome = found.map_err(|error| {
        deck_warnings(&loaded, shell);
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        Exit::NoAnswer
    })?;
    propose(&mut outcome);
    if loaded.study.solver.backend != BackendChoice::Native && !outcome.is_stopped() {
        compare(&loaded, &mut outcome, shell);
    }
    let for_car = write(&loaded, &outcome, &out, replacing, shell)?;
    let report = out.join("report.html");
    if shell.format == Format::Json {
        shell.print(&outcome.diagnosis.to_json());
    } else {
        if shell.is_verbose() {
            shell.tell(&(details(&loaded, &outcome) + "\n"));
        }
        let study = arguments.study.display().to_string();
        let summary = diagnosis_summary(&loaded, &outcome, &study);
        shell.print(&ending(&summary, &written(&report, for_car.as_deref())));
    }
    arguments.opening.open(&report, shell);
    Ok(if outcome.is_stopped() {
        Exit::Interrupted
    } else {
        Exit::Fine
    })
}

/// Compares the study's own solver with the built-in solver, which does the search, and refits the parameters to the study's solver. If the
/// comparison fails, the diagnosis remains valid, with a remark.
fn compare(loaded: &LoadedStudy, outcome: &mut Diagnosed<'_>, shell: &mut Shell) {
    let mut backend = solver::backend(&loaded.study, None, &|note| {
        shell.complain(std::slice::from_ref(note));
    });
    if let Some(remark) = outcome.by_the_study(backend.as_mut()) {
        shell.complain(&[Diagnostic::warning(Code::NoFit, remark)]);
    }
    for remark in backend.remarks() {
        shell.detail(&format!("{remark}\n"));
    }
}

/// Writes the output files. Returns the folder of the files for Adams/Car, if there are any.
fn write(
    loaded: &LoadedStudy,
    outcome: &Diagnosed<'_>,
    out: &Path,
    replacing: Replacing,
    shell: &mut Shell,
) -> Result<Option<PathBuf>, Exit> {
    let (deck, commands) = (outcome.extended_deck(), outcome.extended_commands());
    let diff = changed_lines(loaded.dataset.bytes(), &deck);
    let report = DiagnosisReport {
        loaded,
        outcome,
        diff: &diff,
    };
    let html = report
        .html()
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    let car = car_files::diagnosed(loaded, outcome, &deck).unwrap_or_default();
    let texts = [
        deck,
        commands.into_bytes(),
        outcome.diagnosis.to_json().into_bytes(),
        html.into_bytes(),
    ];
    let mut files: Vec<(PathBuf, Vec<u8>)> =
        OUTPUTS.map(PathBuf::from).into_iter().zip(texts).collect();
    files.extend(car.files);
    write_folder(out, &files, replacing, shell)?;
    for sentence in car.sentences {
        shell.detail(&format!("{sentence}\n"));
    }
    Ok(folder_for_car(out, &files))
}

/// Formats the whole result as text.
fn details(loaded: &LoadedStudy, outcome: &Diagnosed<'_>) -> String {
    let mut text = format!("{}\n", fit_in_words(outcome));
    for finding in &outcome.diagnosis.findings {
        text += &line(finding, loaded);
    }
    for sentence in diagnosis_sentences(outcome) {
        text += &format!("{sentence}\n");
    }
    text
}

fn line(finding: &Finding, loaded: &LoadedStudy) -> String {
    let minor = if finding.minor { " (minor)" } else { "" };
    let mut text = format!(
        "  {} {}{minor}, probability {:.2}: {}\n",
        finding.cause,
        finding.address,
        finding.probability,
        sizes(finding, loaded)
    );
    for rival in &finding.indistinguishable_from {
        text += &format!(
            "    or {} {}, probability {:.2}\n",
            rival.cause, rival.address, rival.probability
        );
    }
    text
}
