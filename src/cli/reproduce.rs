use std::path::PathBuf;

use comfy_table::{Table, presets};

use admire_diagnosis::ProgressObserver;
use admire_report::{Comparison, ReproducedSection as Section, ReproductionReport};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::format::Format;
use super::opening::Opening;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::progress::Progress;
use super::shell::{Exit, Shell};
use super::width::{hanging, table_text};
use reproduction::{ReproductionError, STAGES, reproduce};

#[path = "../../corpus/rust/reproduce_paper/mod.rs"]
mod reproduction;

/// Repeat the paper's three validations, and print its tables next to the new results.
///
/// For `pseudo-mcpherson` (section 4.2), `multilink` (4.3) and `kc-experiment` (4.4) in a corpus folder: ratio of identified to true
/// stiffnesses, iterations, unidentified stiffnesses, the order of the wheel curves, and what cannot be compared.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire reproduce\n  admire reproduce corpus --out target/paper"
)]
pub(super) struct Arguments {
    /// Folder that contains the three studies.
    #[arg(default_value = "corpus")]
    corpus: PathBuf,
    /// Also write `report.html` with the curves into this folder.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    replacing: Replacing,
}

/// Name of the output file.
const OUTPUT: &str = "report.html";

/// Repeats the validations and prints the tables.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if let Some(out) = &arguments.out {
        refuse_replacing(out, &[OUTPUT], arguments.replacing, shell)?;
    }
    let bar = Progress::new("reproducing the paper", shell, || None);
    let mut begun = 0;
    let mut progress = |what: &str| {
        bar.detail(what.to_string());
        bar.count(begun, Some(STAGES), "stages");
        begun += 1;
    };
    let made = reproduce(&arguments.corpus, &mut progress);
    drop(bar);
    let sections = made.map_err(|error| {
        if let ReproductionError::Study { diagnostics, .. } = &error {
            shell.complain(diagnostics);
        }
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        match error {
            ReproductionError::Identify(_) => Exit::NoAnswer,
            ReproductionError::Study { .. } | ReproductionError::Lacks { .. } => Exit::Findings,
        }
    })?;
    if shell.format == Format::Json {
        let text = serde_json::to_string_pretty(&sections);
        shell.print(&(text.expect("sections hold only names and numbers") + "\n"));
    } else {
        let texts: Vec<String> = sections.iter().map(section).collect();
        shell.print(&texts.join("\n"));
    }
    if let Some(out) = &arguments.out {
        let html = ReproductionReport {
            sections: &sections,
        }
        .html();
        let html = html
            .map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
        let files = [(PathBuf::from(OUTPUT), html.into_bytes())];
        write_folder(out, &files, arguments.replacing, shell)?;
        shell.say(&format!("report: {}\n", out.join(OUTPUT).display()));
        arguments.opening.open(&out.join(OUTPUT), shell);
    }
    Ok(Exit::Fine)
}

fn section(section: &Section) -> String {
    let mut text = format!("{}\n{}\n", section.title, "=".repeat(section.title.len()));
    for comparison in &section.tables {
        text.push_str(&format!("\n{}\n{}", comparison.title, table(comparison)));
    }
    for (head, lines) in [
        ("Findings", &section.findings),
        ("Results that cannot be compared", &section.limits),
    ] {
        if !lines.is_empty() {
            text.push_str(&format!("\n{head}\n"));
        }
        for line in lines {
            text.push_str(&hanging("- ", line));
        }
    }
    text
}

fn table(comparison: &Comparison) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(&comparison.head);
    for row in &comparison.rows {
        table.add_row(row);
    }
    table_text(&table)
}
