use admire_design::propose;
use std::path::PathBuf;

use crate::front::car_files;
use crate::front::fit_view::changed_lines;
use crate::front::foreign_parts;
use admire_diagnosis::{
    Finding, GainCheck, Outcome as Diagnosed, Progress as Watched, Verdict, diagnose_watched,
    held_out,
};
use admire_identify::{LoadedStudy, estimate_noise};
use admire_report::{DiagnosisReport, diagnosis_sentences, fit_in_words, sizes};
use admire_study::settings::BackendChoice;
use admire_study::{permission::NamedProgram, solver};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::format::Format;
use super::input::study;
use super::interrupt;
use super::output_folder::{Replacing, refuse_car_files, refuse_replacing, write_folder};
use super::permission::Permission;
use super::plausibility::{before_a_fit, deck_warnings};
use super::progress::{Count, Progress};
use super::shell::{Exit, Shell};

/// Find what a model still gets wrong after its best fit, name the cause, and extend the model by it.
///
/// Writes `diagnosis.json`, `extended.adm`, `extended.acf` and `report.html`. If the study names a subsystem of Adams/Car (`[car]`), a new
/// subsystem file, property files with learned curves and the list `changes.json` are written to the subfolder `adams_car`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire diagnose corpus/kc-experiment --out target/kc\n  admire diagnose my-axle --out answer --format json | jq .findings"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the output files.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Effort to measure what the causes gain in load cases that were not used.
    #[arg(long, value_enum, default_value_t = CheckChoice::HeldOut)]
    check_gain: CheckChoice,
    #[command(flatten)]
    replacing: Replacing,
    #[command(flatten)]
    permission: Permission,
}

/// Choice of a [`GainCheck`] on the command line.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
enum CheckChoice {
    /// Refit without the held-out cases; the causes were chosen with them.
    Quick,
    /// Also search a second time without the held-out cases.
    HeldOut,
    /// Also search without each group of the cross-validation; takes up to seven times as long.
    Folds,
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
    refuse_replacing(&arguments.out, &OUTPUTS, arguments.replacing, shell)?;
    let mut loaded = study(&arguments.study, shell)?;
    refuse_car_files(&loaded, &arguments.out, arguments.replacing, shell)?;
    let foreign = foreign_parts(&loaded);
    if !foreign.is_empty() {
        // If the readings belong to other parts, a diagnosis of the model is meaningless.
        shell.complain(&foreign);
        return Err(Exit::Findings);
    }
    let program = NamedProgram::of_study(&loaded.study);
    arguments.permission.ask(program.as_ref(), shell)?;
    before_a_fit(&loaded, arguments.replacing.force, shell)?;
    if let Err(error) = estimate_noise(&mut loaded, None) {
        deck_warnings(&loaded, shell);
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        return Err(Exit::NoAnswer);
    }
    let problem = loaded.problem();
    let held_out = held_out(&loaded.study, &loaded.measurement);
    let watched = Watched::default();
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
    write(&loaded, &outcome, arguments, shell)?;
    if shell.format == Format::Json {
        shell.print(&outcome.diagnosis.to_json());
    } else {
        let report = arguments.out.join("report.html");
        shell.tell(&format!(
            "{}report: {}\n",
            words(&loaded, &outcome),
            report.display()
        ));
    }
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
        shell.say(&format!("{remark}\n"));
    }
}

fn write(
    loaded: &LoadedStudy,
    outcome: &Diagnosed<'_>,
    arguments: &Arguments,
    shell: &mut Shell,
) -> Result<(), Exit> {
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
    write_folder(&arguments.out, &files, arguments.replacing, shell)?;
    for sentence in car.sentences {
        shell.say(&format!("{sentence}\n"));
    }
    Ok(())
}

/// Formats the result as text.
fn words(loaded: &LoadedStudy, outcome: &Diagnosed<'_>) -> String {
    let diagnosis = &outcome.diagnosis;
    let verdict = match diagnosis.verdict {
        Verdict::Consistent => {
            "consistent: the model explains the data to their noise and tolerances"
        }
        Verdict::Discrepancy => "discrepancy",
        Verdict::Unexplained => "unexplained: structure remains that no known cause explains",
    };
    let stopped = if outcome.is_stopped() {
        "interrupted, so far "
    } else {
        ""
    };
    let mut text = format!("{stopped}{verdict}\n{}\n", fit_in_words(outcome));
    for finding in &diagnosis.findings {
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
