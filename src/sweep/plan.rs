use std::path::{Path, PathBuf};

use admire_identify::LoadedStudy;
use admire_kc::Config;
use admire_session::{FilePolicy, commands_for_other_model, find_file, folder_of, read_files};
use admire_solver::model::{Ignore, Model};
use admire_study::permission::{NamedProgram, beside};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::text::{Source, Span};
use admire_syntax::{CommandFile, Dataset};

use super::complaints::CollectedDiagnostics;
use super::correlation::Correlation;
use super::design::{Design, Point};
use super::kept::OutputSpec;
use super::plan_file::PlanFile;
use super::plan_numbers::{Numbers, numbers};
use super::plan_outputs::keeps;
use super::task::Task;
use super::variation::{Variation, varied};

/// External program that solves in place of the built-in solver.
#[derive(Clone, PartialEq, Debug)]
pub struct Program {
    /// Program and its arguments; `{acf}` is replaced by the command file. If `None`, only recorded runs are used.
    pub command: Option<Vec<String>>,
    /// Folder in which runs are recorded and looked up.
    pub recordings: Option<PathBuf>,
    /// Time limit in seconds, after which a run is killed.
    pub timeout_s: f64,
    /// Time in seconds during which a refused licence is requested again.
    pub licence_wait_s: f64,
}

/// Checked plan of a sweep: varied parameters, task and outputs.
#[derive(Clone, Debug)]
pub struct SweepPlan {
    /// Source text of SWEEP.toml.
    pub source: Source,
    /// Nominal deck.
    pub deck: Dataset,
    /// Property files named by the deck.
    pub files: Files,
    /// Task run for every case.
    pub task: Task,
    /// Varied parameters.
    pub variations: Vec<Variation>,
    /// Groups of correlated parameters.
    pub correlations: Vec<Correlation>,
    /// Design of the cases.
    pub design: Design,
    /// Outputs to be recorded, each with its optional name and its place in SWEEP.toml.
    pub keeps: Vec<(OutputSpec, Option<String>, Span)>,
    /// Model elements that may be ignored.
    pub ignored: Vec<Ignore>,
    /// External solver; `None` means the built-in solver.
    pub program: Option<Program>,
    /// Every file that affects the results.
    pub inputs: Vec<Source>,
}

impl SweepPlan {
    /// Returns the external program that the plan or its study names for the cases. `None` if there is no such program, or if it is ADAMS
    /// itself.
    pub fn named_program(&self) -> Option<NamedProgram> {
        match (&self.program, &self.task) {
            (Some(program), _) => {
                NamedProgram::named_in(Path::new(self.source.name()), program.command.as_ref()?)
            }
            (None, Task::Study(loaded, _)) => NamedProgram::of_study(&loaded.study),
            _ => None,
        }
    }

    /// Returns the command line (program and arguments) that is started for every case; `None` if neither the plan nor its study names a
    /// program.
    pub fn starts_program(&self) -> Option<&[String]> {
        let own = self.program.as_ref().and_then(|p| p.command.as_deref());
        let of_study = match &self.task {
            Task::Study(loaded, _)
                if loaded.study.solver.backend
                    == admire_study::settings::BackendChoice::Command =>
            {
                Some(loaded.study.solver.command.as_slice())
            }
            _ => None,
        };
        own.or(of_study)
    }

    /// Reads a SWEEP.toml and all files named there. The value is `None` if there is an error.
    pub fn read(path: &Path) -> Checked<Option<Self>> {
        let mut out = CollectedDiagnostics::default();
        let value = Self::read_with(path, &mut out);
        let failed = out.all.iter().any(|d| d.severity == Severity::Error);
        Checked {
            value: value.filter(|_| !failed),
            diagnostics: out.all,
        }
    }

    fn read_with(path: &Path, out: &mut CollectedDiagnostics) -> Option<Self> {
        let source = out.source(path, None)?;
        out.file = source.name().to_string();
        let text = source.text(Span::new(0, source.bytes().len()));
        let file: PlanFile = match toml::from_str(&text) {
            Ok(file) => file,
            Err(error) => {
                let span = error.span().unwrap_or(0..0);
                out.wrong(Code::BadSetting, span, error.message());
                out.help("`admire guide sweep` shows every key");
                return None;
            }
        };
        let folder = folder_of(&source);
        let study = match &file.study {
            Some(name) => Some(study(name, &file, &folder, out)?),
            None => None,
        };
        let deck_source = match (&study, &file.deck) {
            (Some(study), _) => study.study.deck.clone(),
            (None, Some(deck)) => out.file(&folder, deck)?,
            (None, None) => {
                let message = "a sweep needs `deck = \"model.adm\"` or `study = \"folder\"`";
                out.wrong(Code::MissingSetting, file.sampling.plan.span(), message);
                return None;
            }
        };
        let mut inputs = vec![source.clone(), deck_source.clone()];
        if let Some(study) = &study {
            let others = study.study.sources().into_iter();
            inputs.extend(others.filter(|s| s.name() != deck_source.name()).cloned());
        }
        let parsed = Dataset::parse(deck_source);
        let mut policy = FilePolicy::new(Path::new(""));
        policy.allow(&folder_of(parsed.value.source()));
        policy.confine();
        let files = read_files(&parsed.value, &folder_of(parsed.value.source()), &policy);
        inputs.extend(files.value.sources().cloned());
        let lowered = Model::lower_with(&parsed.value, &files.value);
        for diagnostic in [parsed.diagnostics, files.diagnostics, lowered.diagnostics]
            .into_iter()
            .flatten()
        {
            if diagnostic.severity == Severity::Error {
                out.all.push(diagnostic);
            }
        }
        let task = match study {
            Some(study) => {
                let check = file.check_gain.as_ref().map(|check| *check.get_ref());
                Task::Study(study, check.unwrap_or_default())
            }
            None => task(&file, (&folder, &lowered.value), &mut inputs, out)?,
        };
        if let (Some(check), Task::Commands(_) | Task::Tests(_)) = (&file.check_gain, &task) {
            let message = "`check_gain` applies only to the diagnosis of a study";
            out.wrong(Code::BadSetting, check.span(), message);
        }
        let mut ignored = Vec::new();
        for word in &file.ignore {
            match Ignore::parse(word.get_ref()) {
                Ok(some) => ignored.extend(some),
                Err(why) => out.wrong(Code::BadSetting, word.span(), &why),
            }
        }
        let program = file
            .solver
            .as_ref()
            .and_then(|solver| program(solver, &folder, out));
        if let (Some(_), Task::Tests(_)) = (&program, &task) {
            out.wrong(
                Code::BadSetting,
                file.solver.as_ref().map_or(0..0, toml::Spanned::span),
                "K&C tests of a sweep always use the built-in solver: remove [solver]",
            );
        }
        let keeps = keeps(&file, &task, out);
        let Numbers {
            variations,
            correlations,
            design,
            table,
        } = numbers(&file, &parsed.value, &folder, out)?;
        inputs.extend(table);
        Some(Self {
            source,
            deck: parsed.value,
            files: files.value,
            task,
            variations,
            correlations,
            design,
            keeps,
            ignored,
            program,
            inputs,
        })
    }

    /// Returns the number of cases.
    pub fn cases(&self) -> u64 {
        self.design.cases()
    }

    /// Returns the parameter values of a case, one for every variation.
    pub fn numbers(&self, case: u64) -> Vec<f64> {
        let all = self.variations.iter();
        match self.design.point(case) {
            Point::Unit(mut unit) => {
                for group in &self.correlations {
                    group.apply(&mut unit);
                }
                all.zip(unit)
                    .map(|(variation, u)| variation.distribution.quantile(u))
                    .collect()
            }
            Point::Levels(levels) => all
                .zip(levels)
                .map(|(variation, (k, count))| variation.distribution.level(k, count))
                .collect(),
            Point::Values(values) => values,
        }
    }

    /// Returns the deck with the given parameter values, one for every variation.
    ///
    /// # Errors
    /// A diagnostic if a value cannot be written at its address.
    pub fn deck_with(&self, numbers: &[f64]) -> Result<Source, Box<Diagnostic>> {
        varied(&self.deck, &self.variations, numbers)
    }
}

/// Reads the study whose deck is varied. The study has its own deck, loads and solver. `None` if the study cannot be read.
fn study(
    name: &toml::Spanned<String>,
    file: &PlanFile,
    folder: &Path,
    out: &mut CollectedDiagnostics,
) -> Option<Box<LoadedStudy>> {
    let others = [
        file.deck.as_ref().map(toml::Spanned::span),
        file.commands.as_ref().map(toml::Spanned::span),
        file.kc.as_ref().map(toml::Spanned::span),
        file.solver.as_ref().map(toml::Spanned::span),
    ];
    for span in others.into_iter().flatten() {
        let message = "a sweep of a `study` takes the deck, the load cases and the solver from the study: remove this key";
        out.wrong(Code::BadSetting, span, message);
    }
    let read = LoadedStudy::read(&out.below(folder, name)?);
    let errors = read.diagnostics.into_iter();
    out.all
        .extend(errors.filter(|d| d.severity == Severity::Error));
    let loaded = Box::new(read.value?);
    if loaded.unknowns.is_empty() {
        let message = "the study names no parameters to identify";
        out.wrong(Code::MissingSetting, name.span(), message);
    }
    Some(loaded)
}

/// Reads the settings of the external program that solves in place of the built-in solver.
fn program(
    solver: &toml::Spanned<super::plan_file::Solver>,
    folder: &Path,
    out: &mut CollectedDiagnostics,
) -> Option<Program> {
    let (span, solver) = (solver.span(), solver.get_ref());
    if !(solver.timeout_s > 0.0) {
        out.wrong(
            Code::OutOfRange,
            span.clone(),
            "`timeout_s` must be above zero",
        );
    }
    if !(solver.licence_wait_s >= 0.0) {
        let rule = "`licence_wait_s` must not be negative";
        out.wrong(Code::OutOfRange, span.clone(), rule);
    }
    let recordings = match &solver.recordings {
        Some(name) => {
            let path = out.below(folder, name)?;
            Some(std::path::absolute(&path).unwrap_or(path))
        }
        None => None,
    };
    if solver.command.is_none() && recordings.is_none() {
        let message = "a solver needs `command`, or `recordings` of its runs, or both";
        out.wrong(Code::MissingSetting, span, message);
        return None;
    }
    let command = match &solver.command {
        None => None,
        Some(words) => {
            let (span, words) = (words.span(), words.get_ref());
            if words.is_empty() || words.iter().all(|word| !word.contains("{acf}")) {
                out.wrong(
                    Code::BadSetting,
                    span,
                    "the command of a solver must have `{acf}` where the command file goes: [\"mdi\", \"-c\", \"ru-s\", \"i\", \"{acf}\", \"exit\"]",
                );
                return None;
            }
            // Paths become absolute because every run has its own working folder.
            Some(beside(folder, words))
        }
    };
    Some(Program {
        command,
        recordings,
        timeout_s: solver.timeout_s,
        licence_wait_s: solver.licence_wait_s,
    })
}

/// Reads the task run for every case.
fn task(
    file: &PlanFile,
    (folder, model): (&Path, &Model),
    inputs: &mut Vec<Source>,
    out: &mut CollectedDiagnostics,
) -> Option<Task> {
    let deck = file.deck.as_ref()?;
    match (&file.commands, &file.kc) {
        (Some(name), None) => {
            let source = out.file(folder, name)?;
            inputs.push(source.clone());
            inputs.extend(included(&source, folder));
            Some(Task::Commands(commands_for_other_model(
                deck.get_ref(),
                &source,
            )))
        }
        (None, Some(name)) => {
            let source = out.file(folder, name)?;
            inputs.push(source.clone());
            let units = model.units;
            let config = Config::read(&source, 1e-3 / units.length.si, 1.0 / units.force.si);
            out.all.extend(config.diagnostics);
            Some(Task::Tests(Box::new(config.value?)))
        }
        _ => {
            let message =
                "a sweep of a deck needs either `commands = \"run.acf\"` or `kc = \"kc.toml\"`";
            out.wrong(Code::BadSetting, deck.span(), message);
            None
        }
    }
}

/// Returns the command files included by a command file, directly or indirectly.
fn included(source: &Source, folder: &Path) -> Vec<Source> {
    let mut found: Vec<Source> = Vec::new();
    let mut policy = FilePolicy::new(Path::new(""));
    policy.allow(folder);
    policy.confine();
    let mut next = vec![source.clone()];
    while let Some(source) = next.pop() {
        let file = CommandFile::parse(source.clone()).value;
        for command in file.commands().iter().filter(|c| c.kind() == Some("FILE")) {
            let Some(name) = command.text("COMMAND", &source) else {
                continue;
            };
            // Unreadable files are reported when the nominal deck is run.
            let path = find_file(&name, "acf", &[folder]).value;
            let path = path.filter(|path| policy.check_read(path).is_ok());
            if let Some(read) = path.and_then(|path| Source::read(&path).ok())
                && found.iter().all(|known| known.name() != read.name())
            {
                found.push(read.clone());
                next.push(read);
            }
        }
    }
    found
}
