//! Runner of single cases. Each case is solved from scratch from its own deck, so that cases are independent.

use std::time::Instant;

use admire_kc as kc;
use admire_kc::{Bench, BenchError, Config, Convention, KcRun};
use admire_results::{Catalogue, Selection};
use admire_session::backend::{DeckRun, ProgramRun, Recording, RunError};
use admire_session::{InMemoryRun, Stop, TrialInput};
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::{Source, Span};
use admire_syntax::units::Units;

use super::answers::StudyResults;
use super::kept::{Output, OutputSource, OutputSpec};
use super::plan::SweepPlan;
use super::row::{Row, Status};
use super::table_writer::OTHER_COLUMNS;
use super::task::Task;

/// Plan that is ready to run. The output columns of its table are known from a run of the nominal deck.
#[derive(Debug)]
pub struct Runner<'p> {
    plan: &'p SweepPlan,
    /// Output columns of the table.
    pub outputs: Vec<Output>,
    /// Row of the nominal deck.
    pub nominal: Row,
    program: Option<ProgramRun>,
    /// Ids of the results-file columns that are recorded.
    ids: Vec<usize>,
    /// All result columns of the nominal deck.
    catalogue: Catalogue,
}

/// Output of a run, before it is reduced to one value per column.
enum Seen {
    Steps(Option<Catalogue>, Vec<(f64, Vec<f64>)>, Vec<[f64; 2]>),
    Tests(Box<KcRun>),
    Answers(Box<StudyResults>),
}

impl<'p> Runner<'p> {
    /// Runs the nominal deck and determines the output columns.
    ///
    /// # Errors
    /// Diagnostics if the deck cannot be run or a requested output does not exist.
    pub fn prepare(plan: &'p SweepPlan) -> Result<Self, Vec<Diagnostic>> {
        let mut runner = Self {
            plan,
            outputs: Vec::new(),
            nominal: Row {
                case: 0,
                status: Status::Ok,
                reason: String::new(),
                seconds: 0.0,
                outputs: Vec::new(),
            },
            program: plan.program.as_ref().map(|program| {
                let recording = program.recordings.clone().map(Recording::new);
                ProgramRun::new(
                    program.command.clone(),
                    recording,
                    program.timeout_s,
                    program.licence_wait_s,
                )
            }),
            ids: Vec::new(),
            catalogue: Catalogue::default(),
        };
        let seen = runner.seen(plan.deck.source());
        let mut wrong = Vec::new();
        match seen {
            Ok(Seen::Steps(Some(catalogue), _, modes)) => {
                runner.find_columns(&catalogue, &modes, &mut wrong);
                runner.catalogue = catalogue;
            }
            Ok(Seen::Steps(None, ..)) => {
                wrong.push(runner.unusable("the command file runs no simulation"));
            }
            Ok(Seen::Tests(run)) => runner.find_characteristics(&run, &mut wrong),
            Ok(Seen::Answers(answers)) => runner.find_answers(&answers, &mut wrong),
            Err((_, why)) => wrong.push(runner.unusable(&why)),
        }
        let span = plan.keeps.first().map_or(Span::at(0), |keep| keep.2);
        let mut names: Vec<&str> = plan.variations.iter().map(|v| v.name.as_str()).collect();
        names.extend(OTHER_COLUMNS);
        for output in &runner.outputs {
            if names.contains(&output.name.as_str()) {
                let message = format!("the results would have two columns `{}`", output.name);
                let found = Diagnostic::error(Code::DuplicateId, message)
                    .label(plan.source.name(), span, "")
                    .help("give one of them another name: `name = \"...\"` in its [[keep]] or [[vary]]");
                wrong.push(found);
            }
            names.push(&output.name);
        }
        if let Some(taken) = plan
            .variations
            .iter()
            .find(|v| OTHER_COLUMNS.contains(&v.name.as_str()))
        {
            let message = format!(
                "a variation cannot be called `{}`, which is a column of every results table",
                taken.name
            );
            wrong.push(Diagnostic::error(Code::DuplicateId, message).label(
                plan.source.name(),
                span,
                "",
            ));
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        runner.nominal = runner.row(0, plan.deck.source());
        if runner.nominal.status != Status::Ok {
            return Err(vec![runner.unusable(&runner.nominal.reason)]);
        }
        Ok(runner)
    }

    fn unusable(&self, why: &str) -> Diagnostic {
        let message = format!("the unchanged deck does not run: {why}");
        Diagnostic::error(Code::NoEquilibrium, message)
            .label(self.plan.deck.source().name(), Span::at(0), "")
            .help("a sweep needs a deck that runs: try `admire solve` or `admire kc` on it")
    }

    fn find_columns(
        &mut self,
        catalogue: &Catalogue,
        modes: &[[f64; 2]],
        wrong: &mut Vec<Diagnostic>,
    ) {
        let plan = self.plan;
        let mut refuse = |span: Span, message: String, help: &str| {
            wrong.push(
                Diagnostic::error(Code::UndefinedId, message)
                    .label(plan.source.name(), span, "")
                    .help(help),
            );
        };
        for (keep, name, span) in &plan.keeps {
            match keep {
                OutputSpec::Column { pattern, at } => {
                    let (found, _) = Selection::matching(catalogue, &[pattern.as_str()]);
                    if found.columns.is_empty() {
                        refuse(
                            *span,
                            format!("no column of the results matches `{pattern}`"),
                            "`admire results run.res --list` shows the columns of a run",
                        );
                    }
                    let many = found.columns.len() > 1;
                    for column in found.columns {
                        let place = self.ids.iter().position(|id| *id == column.id);
                        let place = place.unwrap_or_else(|| {
                            self.ids.push(column.id);
                            self.ids.len() - 1
                        });
                        let given = name.as_ref().map(|name| {
                            if many {
                                format!("{name}.{}", column.path)
                            } else {
                                name.clone()
                            }
                        });
                        self.outputs.push(Output {
                            name: given
                                .unwrap_or_else(|| format!("{}{}", column.path, at.suffix())),
                            unit: column.units,
                            origin: OutputSource::Column(place, *at),
                        });
                    }
                }
                OutputSpec::Mode(number) => {
                    if modes.len() < *number {
                        refuse(
                            *span,
                            format!(
                                "there is no mode {number}; the number of modes found is {}",
                                modes.len()
                            ),
                            "LINEAR/EIGENSOL in the command file computes eigenvalues",
                        );
                    }
                    let name = name.clone().unwrap_or_else(|| format!("mode_{number}"));
                    let per_time = format!("1/{}", self.units().time.word);
                    for (what, unit, origin) in [
                        (
                            "frequency",
                            Some(per_time),
                            OutputSource::Frequency(number - 1),
                        ),
                        ("damping_ratio", None, OutputSource::Damping(number - 1)),
                    ] {
                        self.outputs.push(Output {
                            name: format!("{name}.{what}"),
                            unit,
                            origin,
                        });
                    }
                }
                OutputSpec::Characteristic { .. } | OutputSpec::Answer(_) => {}
            }
        }
    }

    fn find_characteristics(&mut self, run: &KcRun, wrong: &mut Vec<Diagnostic>) {
        let units = self.units();
        for (keep, name, span) in &self.plan.keeps {
            let OutputSpec::Characteristic { path, test } = keep else {
                continue;
            };
            let unit = match test {
                None => {
                    let mut all = run.ride.readings.iter();
                    let found = all.find(|r| r.path() == *path);
                    found.map(|r| r.unit.word(&units))
                }
                Some(test) => run
                    .tests
                    .iter()
                    .filter(|run| run.kind.name() == test)
                    .flat_map(|run| run.gradients.iter().map(|g| (g, run.kind)))
                    .find(|(g, _)| format!("{}.{}", g.entity, g.component) == *path)
                    .map(|(g, kind)| format!("{} per {}", g.unit.word(&units), kind.unit(&units))),
            };
            let Some(unit) = unit else {
                let place = test
                    .as_ref()
                    .map_or("at ride height".to_string(), |t| format!("in the test {t}"));
                wrong.push(
                    Diagnostic::error(
                        Code::UndefinedId,
                        format!("there is no characteristic `{path}` {place}"),
                    )
                    .label(self.plan.source.name(), *span, "")
                    .help(
                        "`curves.csv` and `gradients.csv` of `admire kc` list the characteristics",
                    ),
                );
                continue;
            };
            let own = match test {
                None => path.clone(),
                Some(test) => format!("{path}:{test}"),
            };
            self.outputs.push(Output {
                name: name.clone().unwrap_or(own),
                unit: (!unit.is_empty()).then_some(unit),
                origin: OutputSource::Characteristic(path.clone(), test.clone()),
            });
        }
    }

    fn find_answers(&mut self, answers: &StudyResults, wrong: &mut Vec<Diagnostic>) {
        for (keep, name, span) in &self.plan.keeps {
            let OutputSpec::Answer(path) = keep else {
                continue;
            };
            let found = answers.matching(path).unwrap_or_else(|why| {
                wrong.push(
                    Diagnostic::error(Code::UndefinedId, why)
                        .label(self.plan.source.name(), *span, "")
                        .help("`admire guide study` and `admire guide diagnosis` list the fields"),
                );
                Vec::new()
            });
            for (path, element) in found {
                let own = name.clone().unwrap_or_else(|| path.to_string());
                let name = if name.is_some() && !element.is_empty() {
                    format!("{own}.{element}")
                } else {
                    own
                };
                self.outputs.push(Output {
                    name,
                    unit: None,
                    origin: OutputSource::Answer(path),
                });
            }
        }
    }

    /// Returns the units of the deck.
    pub(crate) fn units(&self) -> Units {
        self.model()
            .map_or_else(|_| Units::default(), |model| model.units)
    }

    fn model(&self) -> Result<Model, String> {
        let lowered = Model::lower_with(&self.plan.deck, &self.plan.files);
        Ok(lowered.value)
    }

    /// Runs a case and returns its row.
    pub(crate) fn run(&self, case: u64) -> Row {
        match self.plan.deck_with(&self.plan.numbers(case)) {
            Ok(deck) => self.row(case, &deck),
            Err(why) => Row {
                case,
                status: Status::Invalid,
                reason: why.message.clone(),
                seconds: 0.0,
                outputs: Vec::new(),
            },
        }
    }

    fn row(&self, case: u64, deck: &Source) -> Row {
        let start = Instant::now();
        let seen = self.seen(deck).and_then(|seen| self.values(&seen));
        Row::ended(case, start, seen)
    }

    fn seen(&self, deck: &Source) -> Result<Seen, (Status, String)> {
        match (&self.plan.task, &self.program) {
            (Task::Commands(commands), None) => self.trial(deck, commands),
            (Task::Commands(commands), Some(program)) => self.external(deck, commands, program),
            (Task::Tests(config), _) => self.tests(deck, config),
            (Task::Study(study, check), _) => {
                StudyResults::of(study, deck, &self.plan.keeps, *check)
                    .map(|answers| Seen::Answers(Box::new(answers)))
            }
        }
    }

    fn trial(&self, deck: &Source, commands: &Source) -> Result<Seen, (Status, String)> {
        let trial = InMemoryRun::run(TrialInput {
            deck,
            commands,
            columns: &self.ids,
            ignored: &self.plan.ignored,
        });
        let ending = &trial.ending;
        let why = |what: &str| trial.error.clone().unwrap_or_else(|| what.to_string());
        match ending.stop {
            Stop::Model => return Err((Status::Invalid, why("the deck has errors"))),
            Stop::File => return Err((Status::Refused, why("a file cannot be read"))),
            _ if ending.failed > 0 => {
                return Err((Status::NoAnswer, why("a simulation has no result")));
            }
            _ if ending.exit_code(true) != 0 => {
                return Err((Status::Refused, why("a command was not executed")));
            }
            _ => {}
        }
        let modes = trial.modes.iter();
        let modes = modes.map(|m| [m.frequency(), m.damping_ratio()]).collect();
        Ok(Seen::Steps(trial.catalogue, trial.steps, modes))
    }

    fn external(
        &self,
        deck: &Source,
        commands: &Source,
        program: &ProgramRun,
    ) -> Result<Seen, (Status, String)> {
        let run = DeckRun {
            deck,
            commands,
            original: &self.plan.deck,
            columns: &self.ids,
        };
        match program.run(&run) {
            Ok(answer) if answer.successful => Ok(Seen::Steps(
                Some(answer.catalogue),
                answer.steps,
                Vec::new(),
            )),
            Ok(answer) => Err((Status::NoAnswer, answer.complaint)),
            Err(error @ (RunError::Deck(_) | RunError::Files(_))) => {
                Err((Status::Invalid, error.to_string()))
            }
            Err(error) => Err((Status::RunFailed, error.to_string())),
        }
    }

    fn tests(&self, deck: &Source, config: &Config) -> Result<Seen, (Status, String)> {
        let invalid = |all: &[Diagnostic]| {
            let mut errors = all.iter().filter(|d| d.severity == Severity::Error);
            errors.next().map(|d| (Status::Invalid, d.message.clone()))
        };
        let parsed = Dataset::parse(deck.clone());
        let lowered = Model::lower_with(&parsed.value, &self.plan.files);
        for all in [&parsed.diagnostics, &lowered.diagnostics] {
            if let Some(why) = invalid(all) {
                return Err(why);
            }
        }
        let (deck, model) = (&parsed.value, &lowered.value);
        let failed = || (Status::Invalid, "the rig does not fit the deck".to_string());
        let mut bench = Bench::new(config, deck, &self.plan.files, model)
            .map_err(|all| invalid(&all).unwrap_or_else(failed))?;
        let run = kc::run(&mut bench, &model.units);
        run.map(|run| Seen::Tests(Box::new(run)))
            .map_err(|error| match error {
                BenchError::Deck(all) => invalid(&all).unwrap_or_else(failed),
                BenchError::Free { at, motion } => (Status::NoAnswer, format!("{at}: {motion}")),
                why @ BenchError::NoAxleLoad { .. } => (Status::NoAnswer, why.to_string()),
                BenchError::NoEquilibrium { at, why } => (Status::NoAnswer, format!("{at}: {why}")),
            })
    }

    /// Reduces the output of a run to one value per output column.
    fn values(&self, seen: &Seen) -> Result<Vec<f64>, (Status, String)> {
        match seen {
            Seen::Steps(catalogue, steps, modes) => {
                if catalogue.as_ref() != Some(&self.catalogue) {
                    let message =
                        "its results have different columns from those of the unchanged deck";
                    return Err((Status::Invalid, message.to_string()));
                }
                let value = |output: &Output| match output.origin {
                    OutputSource::Column(place, at) => at.of(steps, place).unwrap_or(f64::NAN),
                    OutputSource::Frequency(k) => modes.get(k).map_or(f64::NAN, |mode| mode[0]),
                    OutputSource::Damping(k) => modes.get(k).map_or(f64::NAN, |mode| mode[1]),
                    OutputSource::Characteristic(..) | OutputSource::Answer(_) => f64::NAN,
                };
                Ok(self.outputs.iter().map(value).collect())
            }
            Seen::Answers(answers) => Ok(answers.numbers(&self.outputs)),
            Seen::Tests(run) => Ok(self
                .outputs
                .iter()
                .map(|output| characteristic(output, run))
                .collect()),
        }
    }
}

/// Returns the value of a K&C characteristic in the axes of Adams/Car.
fn characteristic(output: &Output, run: &KcRun) -> f64 {
    let OutputSource::Characteristic(path, test) = &output.origin else {
        return f64::NAN;
    };
    let convention = Convention::default();
    match test {
        None => {
            let mut all = run.ride.readings.iter();
            all.find(|reading| reading.path() == *path)
                .map_or(f64::NAN, |reading| reading.value_in(convention))
        }
        Some(test) => run
            .tests
            .iter()
            .filter(|run| run.kind.name() == test)
            .flat_map(|run| &run.gradients)
            .find(|g| format!("{}.{}", g.entity, g.component) == *path)
            .map_or(f64::NAN, |g| convention.factor(g.sense) * g.tangent + 0.0),
    }
}
