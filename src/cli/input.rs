use std::path::Path;

use admire_identify::LoadedStudy;
use admire_solver::model::lint::implausible_units;
use admire_solver::model::{Ignore, Model, left_out_warning};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Diagnostic, Severity};

use super::format::Format;
use super::shell::{Exit, Shell};

/// Dataset with its model and its compiled equations.
pub(super) struct Solvable {
    pub(super) dataset: Dataset,
    pub(super) model: Model,
    pub(super) system: System,
    /// Diagnostics of the statements that were left out because the user requested it.
    pub(super) left_out: Vec<Diagnostic>,
}

/// Reads a dataset with the files that it names, and compiles it. Diagnostics are printed. An error ends the command.
///
/// Statements listed in `ignored` are left out if the built-in solver cannot solve them.
pub(super) fn solvable(
    path: &Path,
    ignored: &[Ignore],
    shell: &mut Shell,
) -> Result<Solvable, Exit> {
    let source = shell.read(path)?;
    let parsed = Dataset::parse(source);
    let files = shell.read_files(&parsed.value);
    let mut lowered = Model::lower_with(&parsed.value, &files.value);
    let left_out: Vec<Diagnostic> = lowered
        .value
        .leave_out(ignored)
        .iter()
        .map(|(kind, header)| left_out_warning(kind, header))
        .collect();
    let compiled = System::compile(&lowered.value);
    let mut complaints = parsed.diagnostics;
    complaints.extend(files.diagnostics);
    complaints.extend(lowered.diagnostics);
    complaints.extend(implausible_units(&parsed.value, &lowered.value));
    complaints.extend(left_out.iter().cloned());
    complaints.extend(compiled.diagnostics);
    parsed.value.locate(&mut complaints);
    shell.complain(&complaints);
    if complaints.iter().any(|d| d.severity == Severity::Error) {
        return Err(Exit::Findings);
    }
    Ok(Solvable {
        dataset: parsed.value,
        model: lowered.value,
        system: compiled.value,
        left_out,
    })
}

/// Reads a study folder and prints the diagnostics. An unusable study ends the command.
pub(super) fn study(folder: &Path, shell: &mut Shell) -> Result<LoadedStudy, Exit> {
    let checked = read_study(folder, shell);
    shell.complain(&checked.diagnostics);
    if checked.value.is_none() && folder.join("study.toml").is_file() {
        let shown = folder.display();
        shell.say(&format!(
            "`admire check {shown}` lists what is missing, in order\n"
        ));
    }
    checked.value.ok_or(Exit::Findings)
}

/// Reads a study folder as [`study`] does. In text output, the notes are replaced by their number, unless the command is verbose.
pub(super) fn study_in_brief(folder: &Path, shell: &mut Shell) -> Result<LoadedStudy, Exit> {
    if shell.is_verbose() || shell.format != Format::Text {
        return study(folder, shell);
    }
    let mut checked = read_study(folder, shell);
    if checked.value.is_none() {
        return study(folder, shell);
    }
    let all = checked.diagnostics.len();
    checked
        .diagnostics
        .retain(|found| found.severity > Severity::Note);
    shell.complain(&checked.diagnostics);
    let notes = all - checked.diagnostics.len();
    if notes > 0 {
        let end = if notes == 1 { "" } else { "s" };
        shell.say(&format!(
            "{notes} note{end} on the study: see `admire check {}`\n",
            folder.display()
        ));
    }
    checked.value.ok_or(Exit::Findings)
}

/// Reads a study folder. Its settings file and its deck are stored, so that diagnostics can show places in them.
pub(super) fn read_study(folder: &Path, shell: &mut Shell) -> Checked<Option<LoadedStudy>> {
    let checked = LoadedStudy::read(folder);
    if let Some(loaded) = &checked.value {
        shell.sources.add(loaded.study.source.clone());
        shell.sources.add(loaded.study.deck.clone());
        if let Some(car) = &loaded.study.car {
            shell.sources.add(car.subsystem.file.source().clone());
        }
    }
    checked
}
