use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};

use admire_sweep::{Summary, SweepFolder, merge, page, six_digits};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::format::Format;
use super::shell::{Exit, Shell};
use super::width::table_text;

/// Join the shards of a sweep into one table.
///
/// If a shard is missing or unfinished, or if shards are of different versions or inputs, all reasons are reported and nothing is joined. Writes
/// `results.parquet`, `summary.json` and `report.html`.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire merge tolerance")]
pub(super) struct Arguments {
    /// Folder of the sweep.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Joins the shards in the sweep folder named on the command line.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let folder = SweepFolder::open(&arguments.folder).map_err(|wrong| shell.fail(wrong))?;
    whole(&folder, shell)
}

/// Joins the shards of a sweep folder and reports the result.
pub(super) fn whole(folder: &SweepFolder, shell: &Shell) -> Outcome {
    merge(folder).map_err(|wrong| {
        shell.complain(&wrong);
        Exit::Findings
    })?;
    let summary = Summary::of(folder).map_err(|error| {
        let message = format!("`{}` cannot be read: {error}", folder.results().display());
        shell.fail(Diagnostic::error(Code::CannotRead, message))
    })?;
    let json = serde_json::to_string_pretty(&summary).expect("numbers print") + "\n";
    let page = page(folder, &summary)
        .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    shell.write(&folder.path.join("summary.json"), json.as_bytes())?;
    let report = folder.path.join("report.html");
    shell.write(&report, page.as_bytes())?;
    if shell.format == Format::Json {
        shell.print(&json);
    } else {
        shell.print(&text(&summary));
        shell.say(&format!(
            "table: {}\nreport: {}\n",
            folder.results().display(),
            report.display()
        ));
    }
    let answered = summary.statuses.get("ok").copied().unwrap_or_default();
    Ok(if answered > 0 {
        Exit::Fine
    } else {
        Exit::NoAnswer
    })
}

fn text(summary: &Summary) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "",
        "unit",
        "nominal deck",
        "mean",
        "sd",
        "5 %",
        "median",
        "95 %",
        "largest effect",
    ]);
    for output in &summary.outputs {
        let spread = &output.spread;
        let values = [
            spread.mean,
            spread.sd,
            spread.quantile(0.05),
            spread.quantile(0.5),
            spread.quantile(0.95),
        ];
        let mut row = vec![
            spread.name.clone(),
            spread.unit.clone().unwrap_or_default(),
            output.nominal.map_or_else(String::new, six_digits),
        ];
        row.extend(values.map(six_digits));
        row.push(most(output));
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(2).take(6) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut out = table_text(&table);
    let ok = summary.statuses.get("ok").copied().unwrap_or_default();
    out += &format!("cases with a result: {ok} of {}\n", summary.cases);
    for (reason, count) in summary.reasons.iter().take(5) {
        out += &format!(
            "  {count} without a result: {}\n",
            reason.lines().next().unwrap_or_default()
        );
    }
    out
}

/// Returns the parameter with the largest effect on an output, with the size of this effect.
fn most(output: &admire_sweep::OutputSummary) -> String {
    let by_total = output
        .indices
        .iter()
        .max_by(|a, b| a.total[0].total_cmp(&b.total[0]));
    if let Some(index) = by_total {
        return format!("{} (total Sobol index {:.2})", index.name, index.total[0]);
    }
    let by_size = output
        .effects
        .iter()
        .max_by(|a, b| a.size[0].total_cmp(&b.size[0]));
    if let Some(effect) = by_size {
        return format!(
            "{} (elementary effect {})",
            effect.name,
            six_digits(effect.size[0])
        );
    }
    output.swings.first().map_or_else(String::new, |swing| {
        format!(
            "{} ({})",
            swing.name,
            six_digits((swing.high - swing.low).abs())
        )
    })
}
