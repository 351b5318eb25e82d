use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap_complete::ArgValueCompleter;

use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::nearest;
use crate::results::{AnyResults, ResultsError, Selection, open_any};

use super::Outcome;
use super::addresses::complete_columns;
use super::shell::{Exit, Format, Shell, exit_of};

/// Show what a results file holds, or take columns out of it.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Results: XRF (.res), requests (.req) or formatted results.
    file: PathBuf,
    /// Print the columns' names, units and ids (with `--format json` as JSON). This is what happens without `--get`.
    #[arg(long)]
    list: bool,
    /// Print the values of the columns with these names: `arm_XFORM.X`, `*_XFORM.?`, `JOINT_1`.
    #[arg(long, num_args = 1.., value_name = "PATTERN", add = ArgValueCompleter::new(complete_columns))]
    get: Vec<String>,
    /// Print values as CSV; this is the default.
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print values as JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the list or the values.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut reader = open(&arguments.file, shell)?;
    if arguments.get.is_empty() || arguments.list {
        shell.print(&list(&mut reader, shell).map_err(|error| refused(error, shell))?);
    } else {
        let patterns: Vec<&str> = arguments.get.iter().map(String::as_str).collect();
        let (selection, unused) = Selection::matching(reader.catalogue(), &patterns);
        if let Some(pattern) = unused.first() {
            let paths: Vec<String> = Selection::all(reader.catalogue())
                .columns
                .into_iter()
                .map(|column| column.path)
                .collect();
            let capitals: Vec<String> = paths.iter().map(|path| path.to_uppercase()).collect();
            let near = nearest(pattern, capitals.iter().map(String::as_str))
                .and_then(|near| capitals.iter().position(|path| path == near));
            return Err(shell.fail(
                Diagnostic::error(
                    Code::UndefinedId,
                    format!("no column of the file is called `{pattern}`"),
                )
                .help(match near {
                    Some(at) => format!("did you mean `{}`?", paths[at]),
                    None => "`admire results FILE --list` shows what there is".to_string(),
                }),
            ));
        }
        let mut output = BufWriter::new(std::io::stdout().lock());
        let written = if arguments.json || shell.format == Format::Json {
            selection.write_json(&mut reader, &mut output)
        } else {
            selection.write_csv(&mut reader, &mut output)
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

/// Opens a results file of any kind that can be read, and prints the complaints about it.
pub(super) fn open(path: &Path, shell: &Shell) -> Result<AnyResults, Exit> {
    let opened = open_any(path).map_err(|error| match error {
        ResultsError::Io(error) => shell.fail(Diagnostic::error(
            Code::CannotRead,
            format!("`{}` cannot be read: {error}", path.display()),
        )),
        refusal @ ResultsError::Refused(_) => refused(refusal, shell),
    })?;
    shell.complain(&opened.diagnostics);
    Ok(opened.value)
}

/// Says why a file is not read further.
pub(super) fn refused(error: ResultsError, shell: &Shell) -> Exit {
    shell.fail(error.into_diagnostic())
}

fn list(reader: &mut AnyResults, shell: &Shell) -> Result<String, ResultsError> {
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
