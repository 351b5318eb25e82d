use std::path::{Path, PathBuf};

use comfy_table::{CellAlignment, Table, presets};

use crate::front::{KcDeck, kc_page, measured};
use admire_diagnosis::ProgressObserver as _;
use admire_kc::{
    Bench, BenchError, Config, Convention, KcRun, Unit, deck_files, output, run_watched, shown,
    slope,
};
use admire_report::number;
use admire_solver::model::Model;
use admire_solver::statics::{SolveError, history_table};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::files::Files;

use super::Outcome;
use super::format::Format;
use super::opening::Opening;
use super::output_folder::{
    Replacing, folder_beside, output_folder, refuse_replacing, write_folder,
};
use super::progress::Progress;
use super::results_kc::Axes;
use super::shell::{Exit, Shell};
use super::width::table_text;

/// Run the standard K&C tests on an axle: bounce, roll, steering, lateral, longitudinal, aligning torque.
///
/// The rig's markers, loads and motions are added to a copy of the deck; `kc.toml` names the wheels. Characteristics are computed from the
/// positions of the wheels and from the exact compliance matrix. Definitions, signs and every key are in `admire guide kc`. Writes
/// `curves.csv`, `gradients.csv`, `kc.json`, `report.html` and a results file for each test with the request names of Adams/Car.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire kc corpus/multilink/model.adm --config corpus/multilink/kc.toml --out target/kc-tests"
)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Configuration of the wheels, the tyre and the tests.
    #[arg(long, value_name = "FILE", default_value = "kc.toml")]
    config: PathBuf,
    /// Folder for the output files; by default, `out-kc` beside the dataset.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Axes in which the results are given.
    #[arg(long, value_enum, default_value_t = Axes::AdamsCar)]
    convention: Axes,
    /// Also write the decks with the rig and a command file per test, to run on any ADAMS.
    #[arg(long)]
    write_deck: bool,
    /// Other datasets that run the same tests; the report shows them for comparison.
    #[arg(long, value_name = "DECK", num_args = 1..)]
    compare: Vec<PathBuf>,
    /// Measured curves, shown in the report for comparison: CSV with the columns test, value and characteristics such as
    /// `toe_angle.left [deg]`.
    #[arg(long, value_name = "CSV")]
    measured: Option<PathBuf>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    replacing: Replacing,
}

/// Deck as read from its file, with its files and its model.
struct Deck {
    dataset: Dataset,
    files: Files,
    model: Model,
}

/// Runs the tests, writes the outputs and prints the summary.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let names = ["curves.csv", "gradients.csv", "kc.json", "report.html"];
    let out = output_folder(
        arguments.out.as_deref(),
        &folder_beside(&arguments.deck),
        "kc",
    );
    refuse_replacing(&out, &names, arguments.replacing, shell)?;
    let deck = read(&arguments.deck, shell)?;
    let units = deck.model.units;
    let source = shell.read(&arguments.config)?;
    let config = Config::read(&source, 1e-3 / units.length.si, 1.0 / units.force.si);
    shell.complain(&config.diagnostics);
    let Some(config) = config.value else {
        return Err(Exit::Findings);
    };
    let curves = match &arguments.measured {
        Some(path) => {
            let source = shell.read(path)?;
            let found = measured(&source, &config, &units).map_err(|wrong| shell.fail(wrong))?;
            shell.complain(&found.diagnostics);
            found.value
        }
        None => Vec::new(),
    };
    let tests = |deck: &Deck, path: &Path, shell: &Shell| -> Result<KcRun, Exit> {
        let mut bench = bench(&config, deck, shell)?;
        let bar = Progress::new("running the K&C tests", shell, || None);
        let mut each = |done, of| bar.count(done, Some(of), "states");
        run_watched(&mut bench, &deck.model.units, &mut each)
            .map_err(|why| refuse(&why, path, shell))
    };
    let found = tests(&deck, &arguments.deck, shell)?;
    let mut others = Vec::new();
    for path in &arguments.compare {
        let other = read(path, shell)?;
        if other.model.units != units {
            let message = format!(
                "the units of `{}` differ from those of `{}`",
                path.display(),
                arguments.deck.display()
            );
            return Err(shell.fail(
                Diagnostic::error(Code::BadSetting, message)
                    .help("convert one of the decks with `admire convert-units`"),
            ));
        }
        let name = path
            .file_stem()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        others.push((name, tests(&other, path, shell)?));
    }
    let convention = Convention::from(arguments.convention);
    let mut files = vec![
        (
            "curves.csv".into(),
            output::curves_csv(&found, &config, &units, convention),
        ),
        (
            "gradients.csv".into(),
            output::gradients_csv(&found, &config, &units, convention),
        ),
    ];
    let value = output::json(&found, &config, &units, convention);
    let text = serde_json::to_string_pretty(&value).expect("JSON values print") + "\n";
    files.push(("kc.json".into(), text.clone().into_bytes()));
    for test in &found.tests {
        let results = output::results(test, &deck.model.title, &units, convention);
        let (bytes, lost) = results.expect("writing to memory does not fail");
        let name = format!("{}.res", test.kind.name());
        if !lost.is_empty() {
            shell.complain(&[Diagnostic::note(
                Code::OutOfRange,
                format!(
                    "`{name}` does not contain {}, because some states have no value",
                    lost.join(", ")
                ),
            )]);
        }
        files.push((name.into(), bytes));
    }
    if arguments.write_deck {
        let mut bench = bench(&config, &deck, shell)?;
        let decks =
            deck_files(&mut bench, &found).map_err(|why| refuse(&why, &arguments.deck, shell))?;
        files.extend(decks.into_iter().map(|(name, bytes)| (name.into(), bytes)));
    }
    files.push((
        "report.html".into(),
        kc_page(
            &KcDeck {
                path: &arguments.deck,
                dataset: &deck.dataset,
                files: &deck.files,
                model: &deck.model,
            },
            &config,
            &found,
            &others,
            &curves,
            convention,
        )
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?
        .into_bytes(),
    ));
    write_folder(&out, &files, arguments.replacing, shell)?;
    if shell.format == Format::Json {
        shell.print(&text);
    } else {
        shell.print(&summary(&found, &units, convention));
        shell.say(&format!("report: {}\n", out.join("report.html").display()));
    }
    arguments.opening.open(&out.join("report.html"), shell);
    Ok(Exit::Fine)
}

fn read(path: &Path, shell: &mut Shell) -> Result<Deck, Exit> {
    let source = shell.read(path)?;
    let parsed = Dataset::parse(source);
    let files = shell.read_files(&parsed.value);
    let lowered = Model::lower_with(&parsed.value, &files.value);
    let mut complaints = parsed.diagnostics;
    complaints.extend(files.diagnostics);
    complaints.extend(lowered.diagnostics);
    shell.complain(&complaints);
    if complaints.iter().any(|d| d.severity == Severity::Error) {
        return Err(Exit::Findings);
    }
    Ok(Deck {
        dataset: parsed.value,
        files: files.value,
        model: lowered.value,
    })
}

fn bench<'a>(config: &'a Config, deck: &'a Deck, shell: &Shell) -> Result<Bench<'a>, Exit> {
    let bench = Bench::new(config, &deck.dataset, &deck.files, &deck.model);
    let bench = bench.map_err(|found| {
        shell.complain(&found);
        Exit::Findings
    })?;
    shell.complain(&bench.implausible());
    Ok(bench)
}

/// Reports why the rig gives no result, and returns the exit code.
fn refuse(why: &BenchError, path: &Path, shell: &Shell) -> Exit {
    let file = path.display();
    match why {
        BenchError::Deck(found) => {
            shell.complain(found);
            Exit::Findings
        }
        BenchError::Free { at, motion } => {
            let message = format!(
                "`{file}`, {at}: the wheel has a free motion, so its compliance is not defined: {motion}"
            );
            let help = "in kc.toml, name the part that does not spin as the wheel carrier; in the deck, lock the free motion, such as the steering. A deck \
                        without springs has only kinematics: leave out its load tests by `run = false`, or set `hold = \"height\"`";
            shell.complain(&[Diagnostic::error(Code::NoEquilibrium, message).help(help)]);
            Exit::NoAnswer
        }
        BenchError::NoAxleLoad { .. } => {
            let message = format!("`{file}`, {why}");
            let help = "a deck without springs carries no load; `hold = \"height\"` prescribes the wheel heights instead";
            shell.complain(&[Diagnostic::error(Code::NoEquilibrium, message).help(help)]);
            Exit::NoAnswer
        }
        BenchError::NoEquilibrium { at, why } => {
            let diagnostic =
                Diagnostic::error(Code::NoEquilibrium, format!("`{file}`, {at}: {why}"));
            let diagnostic = match &**why {
                SolveError::NotConverged {
                    causes, history, ..
                } => {
                    let mut lines = causes.clone();
                    lines.extend(history_table(history));
                    lines.push("try a smaller range of the test".to_string());
                    diagnostic.help(lines.join("\n"))
                }
                _ => diagnostic,
            };
            shell.complain(&[diagnostic]);
            Exit::NoAnswer
        }
    }
}

/// Formats a summary of the values at ride height and the gradients of every test.
fn summary(run: &KcRun, units: &admire_syntax::units::Units, convention: Convention) -> String {
    let mut out = String::from("characteristics at ride height\n");
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["characteristic", "left", "right", "unit"]);
    let names = [
        "toe_angle",
        "camber_angle",
        "wheel_load_vertical_force",
        "wheel_rate",
        "ride_steer",
        "caster_angle",
        "kingpin_incl_angle",
        "lat_force_steer_compliance",
        "alt_steer_compliance",
    ];
    let cell = |value: f64| {
        if value.is_finite() {
            number(value, None)
        } else {
            String::new()
        }
    };
    for name in names {
        let of = |side: &str| {
            let mut all = run.ride.readings.iter();
            all.find(|r| r.entity == name && r.component.contains(side))
        };
        let Some(any) = of("left").or_else(|| of("right")) else {
            continue;
        };
        let value = |side: &str| {
            of(side).map_or_else(String::new, |r| {
                cell(shown(r.value_in(convention), r.unit, units).0)
            })
        };
        table.add_row([
            name.to_string(),
            value("left"),
            value("right"),
            shown(0.0, any.unit, units).1,
        ]);
    }
    for column in table.column_iter_mut().skip(1).take(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    out += &table_text(&table);
    out += "\ngradients at ride height\n";
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "test",
        "toe left",
        "toe right",
        "camber left",
        "camber right",
        "unit",
        "states",
    ]);
    for test in &run.tests {
        let of = |name: &str, side: &str| {
            let mut all = test.gradients.iter();
            let found = all.find(|g| g.entity == name && g.component == side);
            found.map_or_else(String::new, |g| {
                let tangent = convention.factor(g.sense) * g.tangent;
                cell(slope(tangent, g.unit, test.kind.driven(), units).0)
            })
        };
        table.add_row([
            test.kind.name().to_string(),
            of("toe_angle", "left"),
            of("toe_angle", "right"),
            of("camber_angle", "left"),
            of("camber_angle", "right"),
            slope(0.0, Unit::Angle, test.kind.driven(), units).1,
            test.samples.len().to_string(),
        ]);
    }
    for column in table.column_iter_mut().skip(1).take(4) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    out += &table_text(&table);
    let told = run.balance.describe(units);
    if !told.is_empty() {
        out +=
            &format!("\nlargest imbalance in the recomputed sums of forces and torques: {told}\n");
    }
    out
}
