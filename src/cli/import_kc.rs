use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};

use comfy_table::{Table, presets};

use admire_kc::{Side, TestKind};
use admire_lab::{Block, CurveTable, FileOptions, Mapping, Sheet, blocks, complaints, sheets};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::Source;

use super::Outcome;
use super::shell::{Exit, Shell};
use super::width::table_text;

/// Import the table of a K&C laboratory: curves for `admire kc --measured` and for a study, and load cases.
///
/// Reads CSV with any separator, decimal mark and encoding, and Excel workbooks. A mapping describes each column: characteristic, unit, sign and
/// side. On a terminal, you are asked about missing entries, and the mapping is stored for the next file. Otherwise, the proposed mapping goes to
/// standard output, with a `?` for each missing entry. Units and signs are never guessed. `admire guide kc` describes signs, units and all keys.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Tables of one laboratory; those of the left and of the right wheel may be separate files.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Mapping of the columns; by default, `import-kc.toml` beside the first file. On a terminal it is written if it does not exist.
    #[arg(long, value_name = "TOML")]
    map: Option<PathBuf>,
    /// Table to write; by default, a file beside the first file with the ending `-kc.csv`.
    #[arg(long, short, value_name = "CSV")]
    out: Option<PathBuf>,
    /// Test of the files, if the files do not name it: one for all files, or one for each.
    #[arg(long, value_name = "TEST", value_delimiter = ',', value_parser = test)]
    test: Vec<TestKind>,
    /// Side of the files, if their columns do not name it: one for all files, or one for each.
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = side)]
    side: Vec<Side>,
    /// Replace the table if it exists.
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = "Examples:
  admire import-kc rig.csv > import-kc.toml        # a proposal from the headings; fill in each `?`
  admire import-kc rig.csv --map import-kc.toml    # writes rig-kc.csv
  admire import-kc left.xlsx right.xlsx --side left,right --test bounce
  admire kc front.adm --measured rig-kc.csv        # curves of the deck and of the rig in one report";

fn test(word: &str) -> Result<TestKind, String> {
    let found = TestKind::ALL.into_iter().find(|kind| kind.name() == word);
    found.ok_or_else(|| {
        format!(
            "the tests are {}",
            TestKind::ALL.map(TestKind::name).join(", ")
        )
    })
}

fn side(word: &str) -> Result<Side, String> {
    let found = Side::BOTH.into_iter().find(|side| side.word() == word);
    found.ok_or_else(|| "the side is left or right".to_string())
}

/// Reads the files, completes the mapping, converts the rows and writes the table.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let first = &arguments.files[0];
    for (option, count) in [
        ("--test", arguments.test.len()),
        ("--side", arguments.side.len()),
    ] {
        if count > 1 && count != arguments.files.len() {
            let message = format!(
                "{option} has {count} values for {} files",
                arguments.files.len()
            );
            let wrong = Diagnostic::error(Code::BadSetting, message);
            return Err(
                shell.usage(wrong.help("give one value for all files, or one for each file"))
            );
        }
    }
    let out = arguments.out.clone().unwrap_or_else(|| beside(first));
    let usual = first.with_file_name("import-kc.toml");
    let target = arguments.map.clone().unwrap_or(usual);
    let is_terminal = std::io::stdin().is_terminal()
        && std::io::stdout().is_terminal()
        && std::io::stderr().is_terminal();
    // A mapping named on the command line must exist, unless it can be created by questions on a terminal.
    let is_named = arguments.map.is_some() && !is_terminal;
    let map = (is_named || target.is_file()).then(|| target.clone());
    let place = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let mut read = arguments.files.iter().chain(&map);
    if read.any(|path| place(path) == place(&out)) {
        let message = format!(
            "`{}` is an input file: choose another name for the table",
            out.display()
        );
        return Err(shell.usage(Diagnostic::error(Code::CannotWrite, message)));
    }
    if !arguments.force && out.symlink_metadata().is_ok() {
        let message = format!("nothing is written: `{}` exists already", out.display());
        let wrong = Diagnostic::error(Code::CannotWrite, message);
        return Err(
            shell.fail(wrong.help("name another table by --out, or replace it with --force"))
        );
    }
    let (mapping, source) = match &map {
        Some(path) => {
            let source = shell.read(path)?;
            let read = Mapping::read(&source);
            shell.complain(&read.diagnostics);
            let Some(mapping) = read.value else {
                return Err(Exit::Findings);
            };
            shell.say(&format!("mapping: {}\n", path.display()));
            (Some(mapping), Some(source))
        }
        None => (None, None),
    };
    let options = mapping
        .as_ref()
        .map_or_else(FileOptions::default, |map| map.file.clone());
    let (sheets, found) = tables(arguments, &options, shell)?;
    // For `admire import-kc FILE > import-kc.toml`, the shell creates an empty file before this program starts.
    let mapping = mapping.filter(|mapping| !mapping.columns.is_empty());
    let is_asked = mapping.is_none();
    let mut mapping = mapping.unwrap_or_else(|| Mapping::proposed(&found, options));
    let open = mapping.open(&found, &sheets);
    if is_asked && !open.is_empty() && is_terminal {
        let mut ask = |question: &str| reply(question, shell);
        if !mapping.complete(&found, &sheets, &mut ask) {
            let message = "nothing is imported, because a question was left without a reply";
            return Err(shell.fail(Diagnostic::error(Code::UnclearColumn, message)));
        }
        shell.write(&target, mapping.text(&[]).as_bytes())?;
        shell.say(&format!(
            "mapping saved for the next file: {}\n",
            target.display()
        ));
    } else if !open.is_empty() || mapping.columns.is_empty() {
        shell.complain(&complaints(&open, &mapping, &found, &sheets));
        if mapping.columns.is_empty() {
            shell.complain(&[nothing_known(&found, &sheets)]);
        }
        if is_asked {
            shell.print(&mapping.text(&open));
            shell.say("fill in every ? of the mapping above, save the mapping in a file, and name the file by --map\n");
        }
        return Err(Exit::Findings);
    }
    let mut complaints = Vec::new();
    let table = CurveTable::new(&mapping, source.as_ref(), &found, &sheets, &mut complaints);
    shell.complain(&complaints);
    let Some(table) = table else {
        return Err(Exit::Findings);
    };
    shell.write(&out, table.text.as_bytes())?;
    shell.print(&summary(&table, &out));
    Ok(Exit::Fine)
}

/// Returns the path of the table beside the first file.
fn beside(file: &Path) -> PathBuf {
    let stem = file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    file.with_file_name(format!("{stem}-kc.csv"))
}

/// Reads the sheets of all files and finds their blocks.
fn tables(
    arguments: &Arguments,
    options: &FileOptions,
    shell: &mut Shell,
) -> Result<(Vec<Sheet>, Vec<Block>), Exit> {
    let (mut all, mut found, mut out) = (Vec::new(), Vec::new(), Vec::new());
    for (number, path) in arguments.files.iter().enumerate() {
        let source: Source = shell.read(path)?;
        let read = sheets(&source, options, &mut out).map_err(|wrong| shell.fail(wrong))?;
        let of = |count: usize| if count > 1 { number } else { 0 };
        for sheet in read {
            shell.sources.add(sheet.source.clone());
            for mut block in blocks(&sheet, all.len(), options, &mut out) {
                block.test = arguments.test.get(of(arguments.test.len())).copied();
                block.side = arguments.side.get(of(arguments.side.len())).copied();
                found.push(block);
            }
            all.push(sheet);
        }
    }
    shell.complain(&out);
    if out.iter().any(|found| found.severity == Severity::Error) {
        return Err(Exit::Findings);
    }
    if found.is_empty() {
        let message = format!("`{}` has no table of numbers", arguments.files[0].display());
        let wrong = Diagnostic::error(Code::MissingColumn, message);
        let help = "a table is a line of headings with at least two rows of numbers below; the section `[file]` of a mapping sets its lines and separator";
        return Err(shell.fail(wrong.help(help)));
    }
    Ok((all, found))
}

/// Returns the diagnostic for files in which no heading names a known characteristic.
fn nothing_known(found: &[Block], sheets: &[Sheet]) -> Diagnostic {
    let names: Vec<String> = found[0]
        .headings
        .iter()
        .map(|heading| heading.written.clone())
        .collect();
    let wrong = Diagnostic::error(
        Code::UnclearColumn,
        "no heading names a known characteristic",
    );
    let wrong = match found[0].headings.first() {
        Some(first) => wrong.label(sheets[found[0].sheet].source.name(), first.span, ""),
        None => wrong,
    };
    let line = |name: &String| {
        format!(
            "\"{}\" = {{ is = \"toe_angle\", side = \"left\", unit = \"deg\", positive = \"in\" }}",
            name.replace('"', "\\\"")
        )
    };
    let lines: Vec<String> = names.iter().take(1).map(line).collect();
    wrong.help(format!(
        "name the columns in a mapping, for example:\n[columns]\n{}",
        lines.join("\n")
    ))
}

/// Asks a question on a line of its own and returns the reply; `None` at the end of input.
fn reply(question: &str, shell: &Shell) -> Option<String> {
    shell.say(&format!("{}\n", question.trim_end()));
    let mut line = String::new();
    match std::io::stdin().lock().read_line(&mut line) {
        Ok(count) if count > 0 => Some(line.trim().to_string()),
        _ => None,
    }
}

/// Formats the interpretation of each column, the columns left out, and the next step.
fn summary(table: &CurveTable, out: &Path) -> String {
    let mut shown = Table::new();
    shown.load_style(presets::NOTHING);
    shown.set_header([
        "column",
        "characteristic",
        "unit",
        "positive direction",
        "side",
    ]);
    for row in &table.assumed {
        shown.add_row([&row.column, &row.holds, &row.unit, &row.sign, &row.side]);
    }
    let mut text = table_text(&shown);
    if !table.left_out.is_empty() {
        text += &format!("columns left out: {}\n", table.left_out.join(", "));
    }
    let counts: Vec<String> = table
        .counts
        .iter()
        .map(|(test, count)| format!("{} {count}", test.name()))
        .collect();
    let file = out.display();
    text += &format!("rows of each test: {}\ntable: {file}\n", counts.join(", "));
    text += &format!("next: `admire kc DECK --measured {file}`, or in study.toml:\n");
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    text + &table.study_lines.replace("FILE\"", &format!("{name}\""))
}
