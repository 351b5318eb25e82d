use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap_complete::ArgValueCompleter;

use admire_results::{MessageFile, ResultsError, ResultsReader, Selection, StepFilter, StepKind};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

use super::Outcome;
use super::addresses::complete_columns;
use super::counted::counted;
use super::format::Format;
use super::results_edits;
use super::results_file::{open, refused, selection};
use super::results_kc::{self, KcArguments};
use super::shell::{Exit, Shell, exit_of};
use super::target::Target;

/// Show the contents of a results file, extract columns, or change values; or summarise a run from its message file.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Results: XRF (.res), requests (.req), graphics (.gra), formatted results; or messages (.msg).
    file: PathBuf,
    /// Print the columns' names, units and ids (with `--format json` as JSON). This is the default without `--get`.
    #[arg(long)]
    list: bool,
    /// Print the values of the columns with these names: `arm_XFORM.X`, `*_XFORM.?`, `JOINT_1`, `arm.X`.
    #[arg(long, num_args = 1.., value_name = "PATTERN", add = ArgValueCompleter::new(complete_columns))]
    get: Vec<String>,
    /// Print values as CSV; this is the default.
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print values as JSON.
    #[arg(long)]
    json: bool,
    /// Print CSV with numbers only: no units in the column names, and no column for the kind of step.
    #[arg(long, conflicts_with = "json")]
    plain: bool,
    /// Only these steps, counted from 1: `3`, `2-5`, `7-`, `last`; several are separated by commas.
    #[arg(long, value_name = "STEPS")]
    steps: Option<String>,
    /// Only steps at this time or later.
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Only steps at this time or earlier.
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Only steps of this kind: static, quasiStatic, kinematic, dynamic, ...
    #[arg(long, value_name = "KIND")]
    kind: Vec<String>,
    /// Change values and write the whole file, such as `arm_XFORM.X=12.5` or `'*.FX*=1000'`. --steps, --from, --to and --kind select the steps.
    #[arg(long, num_args = 1.., value_name = "COLUMN=VALUE", conflicts_with_all = ["get", "list"])]
    set: Vec<String>,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    kc: KcArguments,
}

const EXAMPLES: &str = "Examples:
  admire results run.res
  admire results run.res --get time 'knuckle.?' --steps last
  admire results run.res --get 'BUSHING_*.F?' --kind quasiStatic --plain
  admire results run.res --set 'knuckle_XFORM.Z+=2.5' --steps 3- -o moved.res
  admire results run.res --kc --wheel left_wheel right_wheel --radius 317.25
  admire results run.gra --get PART_7.Z
  admire results run.msg";

/// Prints the list of columns or the values, or writes the changed file.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if let Some(summary) = messages(&arguments.file) {
        return Ok(describe_run(&summary, shell));
    }
    let filter = filter(arguments).map_err(|refused| shell.usage(refused))?;
    if !arguments.set.is_empty() {
        return results_edits::run(
            &arguments.file,
            &arguments.set,
            &filter,
            &arguments.target,
            shell,
        );
    }
    if arguments.kc.asked() {
        return results_kc::run(
            &arguments.file,
            &arguments.kc,
            &filter,
            arguments.plain,
            arguments.json,
            shell,
        );
    }
    let mut reader = open(&arguments.file, shell)?;
    if arguments.get.is_empty() || arguments.list {
        shell.print(&list(reader.as_mut(), shell).map_err(|error| refused(error, shell))?);
    } else {
        let selection = selection(reader.as_ref(), &arguments.get, shell)?;
        let mut output = BufWriter::new(std::io::stdout().lock());
        let written = if arguments.json || shell.format == Format::Json {
            selection.write_json_of(reader.as_mut(), &mut output, &filter)
        } else {
            selection.write_csv_of(reader.as_mut(), &mut output, &filter, arguments.plain)
        };
        shell.printed(output.flush());
        match written {
            Ok(_) => {}
            Err(ResultsError::Io(error)) => shell.printed(Err(error)),
            Err(error) => return Err(refused(error, shell)),
        }
    }
    shell.complain(reader.diagnostics());
    Ok(exit_of(reader.diagnostics()))
}

/// Returns the filter of steps that the command line requests.
fn filter(arguments: &Arguments) -> Result<StepFilter, Diagnostic> {
    let mut filter = StepFilter::default();
    if let Some(text) = &arguments.steps {
        filter.positions(text).map_err(|word| {
            let message = format!("`{word}` is not a step");
            Diagnostic::error(Code::BadNumber, message)
                .help("steps are counted from 1: 3, 2-5, 7-, last")
        })?;
    }
    filter.from = arguments.from.unwrap_or(filter.from);
    filter.to = arguments.to.unwrap_or(filter.to);
    for word in &arguments.kind {
        let kind = StepKind::NAMED
            .into_iter()
            .find(|kind| kind.step_type().eq_ignore_ascii_case(word));
        filter.kinds.push(kind.ok_or_else(|| {
            let all: Vec<&str> = StepKind::NAMED
                .iter()
                .map(|kind| kind.step_type())
                .collect();
            let message = format!("`{word}` is not a kind of step");
            Diagnostic::error(Code::BadSetting, message)
                .help(format!("write one of {}", all.join(", ")))
        })?);
    }
    Ok(filter)
}

/// Parses a message file; `None` if the file is not a message file.
fn messages(path: &Path) -> Option<MessageFile> {
    let named = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("msg"));
    let source = named.then(|| Source::read(path).ok()).flatten()?;
    MessageFile::is_one(&source).then(|| MessageFile::parse(&source))
}

/// Describes a run from its messages. The exit code is 1 if there were errors or the run did not finish.
fn describe_run(file: &MessageFile, shell: &Shell) -> Exit {
    let bad = !file.finished || file.frames.iter().any(|frame| frame.kind == "ERROR");
    let exit = if bad { Exit::Findings } else { Exit::Fine };
    if shell.format == Format::Json {
        shell.print(&(serde_json::to_string_pretty(file).expect("JSON values print") + "\n"));
        return exit;
    }
    let mut out = String::new();
    for title in &file.titles {
        _ = writeln!(out, "{title}");
    }
    let solver = if file.solver.is_empty() {
        "unknown solver"
    } else {
        &file.solver
    };
    _ = writeln!(out, "{solver}, {}", counted(file.commands, "command line"));
    for analysis in &file.analyses {
        _ = write!(out, "{:>6}  {}", analysis.line, analysis.kind);
        if let Some(iterations) = analysis.iterations {
            _ = write!(out, ": converged in {}", counted(iterations, "iteration"));
        }
        if let Some((first, last)) = analysis.times {
            _ = write!(
                out,
                ": {} from time {first} to {last}",
                counted(analysis.steps, "printed step")
            );
        }
        out.push_str(if analysis.ended {
            "\n"
        } else {
            ", DID NOT END\n"
        });
    }
    for frame in &file.frames {
        let first = frame
            .text
            .lines()
            .map(str::trim)
            .find(|line| !line.is_empty());
        _ = writeln!(
            out,
            "{:>6}  {}: {}",
            frame.line,
            frame.kind,
            first.unwrap_or("")
        );
    }
    for name in &file.redundant {
        _ = writeln!(out, "        redundant constraint: {name}");
    }
    let errors = file
        .frames
        .iter()
        .filter(|frame| frame.kind == "ERROR")
        .count();
    let warnings = file.frames.len() - errors;
    _ = write!(
        out,
        "{}, {}",
        counted(errors, "error"),
        counted(warnings, "warning")
    );
    if let Some(elapsed) = file.elapsed {
        _ = write!(out, ", elapsed {elapsed} s");
    }
    if let Some(cpu) = file.cpu {
        _ = write!(out, ", CPU {cpu} s");
    }
    out.push_str(if file.finished {
        ", run finished\n"
    } else {
        ", RUN DID NOT FINISH\n"
    });
    shell.print(&out);
    exit
}

fn list(reader: &mut dyn ResultsReader, shell: &Shell) -> Result<String, ResultsError> {
    let selection = Selection::all(reader.catalogue());
    if shell.format == Format::Json {
        let text = serde_json::to_string_pretty(&selection).expect("JSON values print");
        return Ok(text + "\n");
    }
    let mut steps = Vec::<(String, usize)>::new();
    while let Some(step) = reader.next_step()? {
        match steps.last_mut() {
            Some((block, count)) if block == step.block => *count += 1,
            _ => steps.push((step.block.to_string(), 1)),
        }
    }
    let header = reader.header();
    let made: Vec<&str> = [header.solver.trim(), header.execution_date.trim()]
        .into_iter()
        .filter(|said| !said.is_empty())
        .collect();
    let mut out = format!("{}\n{}\n", header.title.trim_end(), made.join(", "));
    for (block, count) in steps {
        let what = if count == 1 { "step" } else { "steps" };
        _ = writeln!(out, "{block}: {count} {what}");
    }
    for column in &selection.columns {
        let unit = column.units.as_deref().unwrap_or("");
        out += format!("{:>6}  {:48} {unit}", column.id, column.path).trim_end();
        out.push('\n');
    }
    Ok(out)
}
