use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use admire_report::{Chart, DrawingError, Figure, Page, Series, SeriesStyle};
use admire_results::{ResultsError, Selection, StepFilter, StepKind};
use admire_session::{Moment, Session, commands_for_other_model};
use admire_solver::model::Ignore;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::counted::counted;
use super::interrupt;
use super::output_folder::{Replacing, refuse_replacing};
use super::results_file::{open, refused, selection};
use super::shell::{Exit, Shell};

/// Largest number of curves in one chart.
const CURVES: usize = 8;

/// Outputs of a run besides the files that ADAMS writes.
#[derive(clap::Args, Debug)]
pub(super) struct Taken {
    /// For a command file: columns of its results for --csv and --plot, named as for `admire results --get`; by default, all.
    #[arg(long, num_args = 1.., value_name = "PATTERN")]
    columns: Vec<String>,
    /// For a command file: write these columns as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// For a command file: draw these columns over time, one picture for each unit, in an HTML page.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    replacing: Replacing,
}

impl Taken {
    /// Returns true if any output is requested.
    pub(crate) fn is_asked(&self) -> bool {
        self.csv.is_some() || self.plot.is_some()
    }
}

/// Runs a command file and writes the requested columns of its results. If a dataset is given, the commands are executed on it.
pub(super) fn run(
    deck: Option<&Path>,
    commands: &Path,
    allowed: &[PathBuf],
    ignored: Vec<Ignore>,
    taken: &Taken,
    shell: &mut Shell,
) -> Outcome {
    for path in [&taken.csv, &taken.plot].into_iter().flatten() {
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        refuse_replacing(folder, &[&*name], taken.replacing, shell)?;
    }
    let given = match deck {
        Some(deck) => Some(commands_for_other_model(
            &deck.to_string_lossy(),
            &shell.read(commands)?,
        )),
        None => None,
    };
    let mut folders = allowed.to_vec();
    if given.is_some() {
        let all = [Some(commands), deck].into_iter().flatten();
        folders.extend(all.filter_map(Path::parent).map(Path::to_path_buf));
    }
    interrupt::listen();
    let bar = ProgressBar::new_spinner().with_style(
        ProgressStyle::with_template("{spinner} {msg}").expect("the template is valid"),
    );
    if !shell.shows_progress() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
    }
    let began = Instant::now();
    let console = Box::new(BufWriter::new(std::io::stdout().lock()));
    let session = Session::new(console, Path::new(""))
        .confined(&folders)
        .ignoring(ignored)
        .watched(|moment| {
            bar.set_message(progress_line(&moment, began.elapsed()));
            bar.tick();
            !interrupt::asked()
        });
    let ending = match given {
        Some(source) => session.run_commands(&source),
        None => session.run_file(&commands.to_string_lossy()),
    };
    bar.finish_and_clear();
    if taken.is_asked() {
        let Some(results) = &ending.results else {
            let message = "the run wrote no results file, so --csv and --plot have no columns";
            return Err(shell.fail(Diagnostic::error(Code::CannotRead, message)));
        };
        take(results, taken, shell)?;
    }
    if interrupt::asked() {
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::of_code(ending.exit_code(true)))
}

/// Formats the progress line: time, end time, step size, remaining time.
fn progress_line(moment: &Moment, elapsed: Duration) -> String {
    let share = moment.share();
    let left = if share > 0.0 {
        elapsed.mul_f64((1.0 - share) / share)
    } else {
        Duration::ZERO
    };
    format!(
        "time {:.4} of {}, step {:.1e}, {:.0} %, {} left",
        moment.time,
        moment.end,
        moment.step,
        100.0 * share,
        indicatif::HumanDuration(left)
    )
}

/// Writes the requested columns of a results file as CSV and as a page.
fn take(results: &Path, taken: &Taken, shell: &Shell) -> Result<(), Exit> {
    let read = || -> Result<_, Exit> {
        let reader = open(results, shell)?;
        let selection = if taken.columns.is_empty() {
            Selection::all(reader.catalogue())
        } else {
            let mut patterns = vec!["TIME".to_string()];
            patterns.extend(taken.columns.iter().cloned());
            selection(reader.as_ref(), &patterns, shell)?
        };
        Ok((reader, selection))
    };
    let filter = StepFilter::default();
    let wrong = |error: ResultsError| match error {
        ResultsError::Io(error) => shell.fail(Diagnostic::error(
            Code::CannotRead,
            format!("`{}` cannot be read: {error}", results.display()),
        )),
        error @ ResultsError::Refused(_) => refused(error, shell),
    };
    if let Some(path) = &taken.csv {
        let (mut reader, selection) = read()?;
        let mut bytes = Vec::new();
        let written = selection.write_csv_of(reader.as_mut(), &mut bytes, &filter, false);
        written.map_err(wrong)?;
        shell.write(path, &bytes)?;
    }
    if let Some(path) = &taken.plot {
        let (mut reader, selection) = read()?;
        // The step of kind `input` is the dataset before any computation.
        let filter = StepFilter {
            kinds: StepKind::NAMED
                .into_iter()
                .filter(|kind| *kind != StepKind::Input)
                .collect(),
            ..filter
        };
        let rows = selection
            .values_of(reader.as_mut(), &filter)
            .map_err(wrong)?;
        let page = page(results, &selection, &rows)
            .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
        shell.write(path, page.as_bytes())?;
    }
    Ok(())
}

/// Creates an HTML page that shows the columns over time.
fn page(results: &Path, selection: &Selection, rows: &[Vec<f64>]) -> Result<String, DrawingError> {
    let is_time = |path: &str| {
        path.rsplit('.')
            .next()
            .is_some_and(|n| n.eq_ignore_ascii_case("TIME"))
    };
    let columns = &selection.columns;
    let time = columns.iter().position(|column| is_time(&column.path));
    let x = match time.and_then(|at| columns[at].units.as_ref()) {
        Some(unit) => format!("time [{unit}]"),
        None => "time".to_string(),
    };
    // Columns with the same unit share a chart, in the order of the file.
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for (at, column) in columns.iter().enumerate() {
        if Some(at) == time {
            continue;
        }
        let unit = column.units.clone().unwrap_or_default();
        let room = groups
            .iter_mut()
            .find(|(known, all)| *known == unit && all.len() < CURVES);
        match room {
            Some((_, all)) => all.push(at),
            None => groups.push((unit, vec![at])),
        }
    }
    let name = results.file_name().unwrap_or_default().to_string_lossy();
    let lead = format!(
        "{} over {}",
        counted(columns.len() - usize::from(time.is_some()), "column"),
        counted(rows.len(), "step")
    );
    let mut page = Page::new("Results", &name, &lead);
    let mut figures = Vec::new();
    for (unit, all) in groups {
        let series = all.iter().map(|&at| {
            let points = rows
                .iter()
                .enumerate()
                .map(|(k, row)| (time.map_or(k as f64, |time| row[time]), row[at]))
                .collect();
            Series::new(&columns[at].path, SeriesStyle::Line, points)
        });
        let series: Vec<Series> = series.collect();
        let title = match series.as_slice() {
            [one] => one.name.clone(),
            [first, ..] => format!("{} and {} more", first.name, series.len() - 1),
            [] => String::new(),
        };
        let chart = Chart {
            title,
            x: x.clone(),
            y: unit,
            series,
            ..Chart::default()
        };
        figures.push(Figure::chart(&chart, "")?);
    }
    page.figures(&figures);
    Ok(page.finish(&format!("admire {}", env!("CARGO_PKG_VERSION"))))
}
