use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use comfy_table::{CellAlignment, Table, presets};

use crate::front::car_files;
use crate::front::fit_view::{changed_lines, positions};
use admire_diagnosis::study_fit::{identify_with, not_repeatable, nothing_to_identify};
use admire_identify::{Fit, LoadedStudy, Repeated};
use admire_report::{
    IdentificationReport, Positions, VERSION, identification_summary, number, parameter_name,
    status,
};
use admire_study::settings::Method;
use admire_study::{permission::NamedProgram, solver};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::short_unit;

use admire_identify::global::Marginal;
use admire_sweep::uncertainty::{
    Kind, LEAST_DRAWS, LEAST_REPLICATES, MOST, RepeatOutput, Repeats, repeat,
};

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
use super::progress::{Count, Progress as Bar};
use super::shell::{Exit, Shell};
use super::width::table_text;

/// Identify the stiffnesses of a study from its measurements.
///
/// Writes `identified.adm`, `identification.json` and `report.html`. If the study names a subsystem of Adams/Car (`[car]`), a new subsystem file
/// with the scale factors and the list `changes.json` are written to the subfolder `adams_car`. The terminal shows the result in at most 15
/// lines; `-v` shows everything.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire identify corpus/pseudo-mcpherson --out target/first\n  admire identify my-axle --out answer --method direct\n  admire identify my-axle --out answer --bootstrap 1000 --posterior 1000"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for the output files; by default, `out-identify` in the folder of the study.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Method of identification, instead of the study's own.
    #[arg(long, value_enum)]
    method: Option<MethodChoice>,
    /// Keep the folder of every run of an external solver, below `runs` in the output folder. Without this option, only the folders of
    /// failed runs are kept.
    #[arg(long)]
    keep: bool,
    /// Repeat the fit N times with readings drawn from the fit and its residuals (bootstrap). The resulting intervals do not rely on the
    /// stated noise. Writes `bootstrap.parquet`.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(LEAST_REPLICATES..=MOST))]
    bootstrap: Option<u64>,
    /// Draw N times from the posterior of the identified parameters. The resulting intervals do not assume a linear model. Writes
    /// `posterior.parquet`.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(LEAST_DRAWS..=MOST))]
    posterior: Option<u64>,
    /// With --bootstrap or --posterior: seed of the random numbers; another seed gives other random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// With --bootstrap or --posterior: number of parallel threads; by default, one for each core.
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    forced: Forced,
    #[command(flatten)]
    permission: Permission,
}

impl Arguments {
    /// Returns the requested repetitions; `None` if there are none.
    fn repeats(&self) -> Option<Repeats> {
        let asked = self.bootstrap.is_some() || self.posterior.is_some();
        asked.then(|| Repeats {
            bootstrap: self.bootstrap,
            posterior: self.posterior,
            seed: self.seed,
            threads: self.jobs.map_or_else(
                || std::thread::available_parallelism().map_or(1, usize::from),
                usize::from,
            ),
        })
    }
}

/// Returns the file names of the tables that are written for the repetitions.
fn tables(arguments: &Arguments) -> Vec<&'static str> {
    let bootstrap = arguments.bootstrap.map(|_| Kind::Bootstrap.file());
    bootstrap
        .into_iter()
        .chain(arguments.posterior.map(|_| Kind::Posterior.file()))
        .collect()
}

/// Names of the output files.
const OUTPUTS: [&str; 3] = ["identified.adm", "identification.json", "report.html"];

/// Choice of the identification method on the command line.
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

/// Identifies the study, writes the outputs and prints the result.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut outputs = OUTPUTS.to_vec();
    outputs.extend(tables(arguments));
    let out = output_folder(arguments.out.as_deref(), &arguments.study, "identify");
    let replacing = arguments.forced.replacing();
    refuse_replacing(&out, &outputs, replacing, shell)?;
    let mut loaded = study_in_brief(&arguments.study, shell)?;
    refuse_car_files(&loaded, &out, replacing, shell)?;
    if let Some(method) = arguments.method {
        loaded.study.identify.method = method.into();
    }
    if loaded.unknowns.is_empty() {
        return Err(shell.fail(nothing_to_identify(&loaded)));
    }
    let repeats = arguments.repeats();
    if repeats.is_some()
        && let Some(refused) = not_repeatable(&loaded)
    {
        return Err(shell.fail(refused));
    }
    before_a_fit(&loaded, arguments.forced.force, shell)?;
    let program = NamedProgram::of_study(&loaded.study);
    arguments.permission.ask(program.as_ref(), shell)?;
    let keep = arguments.keep.then(|| out.join("runs"));
    let told = |note: &Diagnostic| shell.complain(std::slice::from_ref(note));
    let mut backend = solver::backend(&loaded.study, keep, &told);
    interrupt::listen();
    let bar = Bar::new("reading", shell, || None);
    let outcome = identify_with(&mut loaded, backend.as_mut(), &bar, repeats.is_some());
    drop(bar);
    let positions = outcome.as_ref().map_or_else(
        |_| Vec::new(),
        |(fit, _)| positions(&loaded, fit, backend.as_mut()),
    );
    for remark in backend.remarks() {
        shell.detail(&format!("{remark}\n"));
    }
    let (mut fit, marginal) = outcome.map_err(|error| {
        deck_warnings(&loaded, shell);
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        Exit::NoAnswer
    })?;
    if !fit.converged && !fit.interrupted {
        deck_warnings(&loaded, shell);
    }
    let mut more = Vec::new();
    if let Some(repeats) = repeats.filter(|_| !fit.interrupted) {
        if !fit.converged {
            let message = "the fit did not converge, so bootstrap and posterior were not computed";
            shell.fail(Diagnostic::error(Code::NoFit, message));
            return Err(Exit::NoAnswer);
        }
        more = repeated(
            (&loaded, marginal.as_ref()),
            &mut fit,
            &repeats,
            &out,
            shell,
        )?;
    }
    let of_fit = (&loaded, &fit, positions.as_slice());
    let for_car = write(of_fit, more, (&out, replacing), shell)?;
    let _ = std::fs::remove_dir_all(out.join(UNFINISHED));
    let report = out.join("report.html");
    if shell.format == Format::Json {
        shell.print(&fit.to_json());
    } else {
        if shell.is_verbose() {
            shell.print(&details(&loaded, &fit));
        }
        let study = arguments.study.display().to_string();
        let summary = identification_summary(&loaded, &fit, &study);
        shell.print(&ending(&summary, &written(&report, for_car.as_deref())));
    }
    arguments.opening.open(&report, shell);
    Ok(if fit.interrupted {
        Exit::Interrupted
    } else if fit.converged {
        Exit::Fine
    } else {
        Exit::NoAnswer
    })
}

/// Formats the whole result as text.
fn details(loaded: &LoadedStudy, fit: &Fit) -> String {
    let mut remarks = fit.remarks.clone();
    remarks.push(String::new());
    let remarks = remarks.join("\n");
    format!("{}\n{}{remarks}\n", table(loaded, fit), repeats_table(fit))
}

/// Writes the output files and the tables `more`. Returns the folder of the files for Adams/Car, if there are any.
fn write(
    (loaded, fit, positions): (&LoadedStudy, &Fit, &[Positions]),
    more: Vec<(PathBuf, Vec<u8>)>,
    (out, replacing): (&Path, Replacing),
    shell: &mut Shell,
) -> Result<Option<PathBuf>, Exit> {
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
    let car = car_files::identified(loaded, fit, &deck).unwrap_or_default();
    let texts = [deck, fit.to_json().into_bytes(), html.into_bytes()];
    let mut files: Vec<(PathBuf, Vec<u8>)> =
        OUTPUTS.map(PathBuf::from).into_iter().zip(texts).collect();
    files.extend(more);
    files.extend(car.files);
    write_folder(out, &files, replacing, shell)?;
    for sentence in car.sentences {
        shell.detail(&format!("{sentence}\n"));
    }
    Ok(folder_for_car(out, &files))
}

/// Subfolder for the journals and tables of repetitions that are in progress.
const UNFINISHED: &str = "unfinished";

/// Repeats a fit and returns the tables of the repetitions, each with its file name and bytes.
fn repeated(
    (loaded, marginal): (&LoadedStudy, Option<&Marginal>),
    fit: &mut Fit,
    repeats: &Repeats,
    out: &Path,
    shell: &Shell,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Exit> {
    let Some(marginal) = marginal else {
        return Err(shell.fail(Diagnostic::error(
            Code::NoFit,
            "bootstrap and posterior were not computed: they need a fit by Gauss-Newton with the built-in solver",
        )));
    };
    let folder = out.join(UNFINISHED);
    let io = |path: &Path, error: &dyn std::fmt::Display| {
        let message = format!("`{}` cannot be read or written: {error}", path.display());
        shell.fail(Diagnostic::error(Code::CannotWrite, message))
    };
    std::fs::create_dir_all(&folder).map_err(|error| io(&folder, &error))?;
    let shown = Arc::new(Mutex::new(None));
    let seen = Arc::clone(&shown);
    let bar = Bar::new("repeating the fit", shell, move || *seen.lock().ok()?);
    let problem = loaded.problem();
    let made = repeat(
        &problem,
        marginal,
        fit,
        repeats,
        Some(&folder),
        VERSION,
        &mut |kind, progress| {
            if let Ok(mut shown) = shown.lock() {
                let most = (progress.all - progress.before) as usize;
                let unit = match kind {
                    Kind::Bootstrap => "fits",
                    Kind::Posterior => "draws",
                };
                let count = Count {
                    done: progress.done as usize,
                    of: Some(most),
                    what: unit,
                };
                *shown = Some((kind.word(), count));
            }
            !interrupt::asked()
        },
    );
    drop(bar);
    let made = made.map_err(|error| {
        let message = format!(
            "the repetitions of the fit in `{}` failed: {error}",
            folder.display()
        );
        shell.fail(Diagnostic::error(Code::NoFit, message));
        Exit::NoAnswer
    })?;
    let Some(made) = made else {
        shell.say("interrupted; the same command continues where it stopped\n");
        return Err(Exit::Interrupted);
    };
    let mut tables = Vec::new();
    for (kind, made) in made {
        let RepeatOutput::Table(path) = made else {
            continue;
        };
        let bytes = std::fs::read(&path).map_err(|error| io(&path, &error))?;
        tables.push((PathBuf::from(kind.file()), bytes));
    }
    Ok(tables)
}

/// Formats an interval; a missing end becomes a dash.
fn ends(sides: [Option<f64>; 2], error: Option<f64>) -> String {
    let side = |side: Option<f64>| side.map_or_else(|| "-".to_string(), |v| number(v, error));
    sides.map(side).join(" to ")
}

/// Formats a table of the bootstrap and posterior intervals beside the profile-likelihood intervals. The text is empty if neither was
/// computed.
fn repeats_table(fit: &Fit) -> String {
    if fit.bootstrap.is_none() && fit.posterior.is_none() {
        return String::new();
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut heads = vec!["95 % interval", "unit", "profile likelihood"];
    if fit.bootstrap.is_some() {
        heads.extend(["bootstrap", "width ratio"]);
    }
    if fit.posterior.is_some() {
        heads.extend(["posterior", "width ratio", "effective draws", "R-hat"]);
    }
    let columns = heads.len();
    table.set_header(heads);
    let ratio = |found: &Repeated| {
        found
            .width_ratio
            .map_or_else(|| "-".to_string(), |r| format!("{r:.2}"))
    };
    for parameter in &fit.parameters {
        let error = parameter.std_error;
        let mut cells = vec![
            parameter_name(parameter),
            short_unit(&parameter.unit),
            ends(parameter.profile95.unwrap_or_default(), error),
        ];
        if let Some(found) = &parameter.bootstrap {
            cells.extend([ends(found.interval95.map(Some), error), ratio(found)]);
        }
        if let Some(found) = &parameter.posterior {
            let worth = found.effective_draws.unwrap_or(f64::NAN);
            let r_hat = found.r_hat.unwrap_or(f64::NAN);
            cells.extend([
                ends(found.interval95.map(Some), error),
                ratio(found),
                format!("{worth:.0}"),
                format!("{r_hat:.3}"),
            ]);
        }
        table.add_row(cells);
    }
    for column in table.column_iter_mut().skip(2).take(columns - 2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n", table_text(&table))
}

/// Formats a table of initial and identified values, with reference values if the study has any.
fn table(loaded: &LoadedStudy, fit: &Fit) -> String {
    let reference = loaded.reference_values();
    let compares = reference.iter().any(Option::is_some);
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut head = vec!["parameter", "unit", "initial", "identified", "std error"];
    if compares {
        head.extend(["reference", "identified/ref."]);
    }
    head.push("");
    table.set_header(&head);
    for (parameter, reference) in fit.parameters.iter().zip(reference) {
        let mut row = vec![
            parameter_name(parameter),
            short_unit(&parameter.unit),
            number(parameter.initial, None),
            number(parameter.value, parameter.std_error),
            parameter
                .std_error
                .map_or_else(String::new, |error| number(error, Some(error))),
        ];
        if compares {
            let ratio = |value: f64| format!("{:.3}", parameter.value / value);
            row.push(reference.map_or_else(String::new, |value| number(value, None)));
            let is_ratio = parameter.form != Some("change");
            let ratio = reference.filter(|_| is_ratio).map(ratio);
            row.push(ratio.unwrap_or_default());
        }
        row.push(status(parameter.status).to_string());
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(2).take(head.len() - 3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table_text(&table)
}
