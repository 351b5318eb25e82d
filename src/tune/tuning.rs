use std::path::Path;

use crate::answers::Answers;
use crate::goal::Goal;
use crate::goal_names::GoalNames;
use crate::goal_reader::goals;
use crate::load_cases::{Asked, LoadCases};
use crate::tolerance::RigMarkers;
use crate::tune_error::{TuneError, has_errors};
use admire_identify::{DeckUnknown, Mirror, resolved, written_numbers};
use admire_kc::{Bench, BenchError, Config, TestKind, run};
use admire_session::{FilePolicy, folder_of, read_files};
use admire_solver::mechanics::Vec3;
use admire_solver::model::Model;
use admire_solver::statics::Probe;
use admire_study::{GoalPlace, GoalSettings, Study, TargetSettings};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::files::Files;
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::{Address, Dataset};

/// A study with a target, with all names resolved in its deck and in its tests.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Settings of the study.
    pub study: Study,
    /// Settings of section `[target]`.
    pub target: TargetSettings,
    /// Deck of the study.
    pub dataset: Dataset,
    /// Contents of the files to which the deck refers.
    pub files: Files,
    /// Model of the deck.
    pub model: Model,
    /// Tests of `kc.toml` that the goals need; `None` if every goal reads a load case.
    pub config: Option<Config>,
    /// Numbers of the deck that the search may change.
    pub unknowns: Vec<DeckUnknown>,
    /// Goals with their names resolved.
    pub goals: Vec<Goal>,
    /// Results of the tests and load cases on the deck of the study.
    pub before: Answers,
    /// Markers that `kc.toml` names for the wheels.
    pub(crate) rig: RigMarkers,
    /// Forces and positions that are read in the tests.
    pub(crate) probes: Vec<Probe>,
    /// Load cases that goals name.
    pub(crate) cases: LoadCases,
}

/// Reason why a study with a target cannot be tuned.
#[derive(Clone, Debug)]
pub enum Refused {
    /// The input is wrong, as the diagnostics state.
    Input,
    /// A test of the original deck has no equilibrium.
    Start(TuneError),
}

impl Tuning {
    /// Reads a study and resolves its target. The tests and load cases are run once on the deck of the study.
    ///
    /// # Errors
    /// [`Refused`] if an input is wrong or the deck has no equilibrium on the rig or in a load case. The diagnostics state the reason.
    pub fn read(folder: &Path) -> (Result<Self, Refused>, Vec<Diagnostic>) {
        let read = Study::read(folder);
        let mut out = read.diagnostics;
        let found = match read.value {
            Some(study) if !has_errors(&out) => Self::of(study, &mut out),
            _ => Err(Refused::Input),
        };
        (found, out)
    }

    fn of(study: Study, out: &mut Vec<Diagnostic>) -> Result<Self, Refused> {
        let Some(target) = study.target.clone() else {
            let message = "the study has no section [target] with goals and unknowns";
            out.push(
                Diagnostic::error(Code::MissingSetting, message)
                    .label(study.source.name(), study.place(&[]), "")
                    .help("`admire guide tune` shows one"),
            );
            return Err(Refused::Input);
        };
        let parsed = Dataset::parse(study.deck.clone());
        let mut policy = FilePolicy::new(&study.folder);
        policy.confine();
        let files = read_files(&parsed.value, &folder_of(parsed.value.source()), &policy);
        let lowered = Model::lower_with(&parsed.value, &files.value);
        out.extend(parsed.diagnostics);
        out.extend(files.diagnostics);
        out.extend(lowered.diagnostics);
        let (dataset, files, model) = (parsed.value, files.value, lowered.value);
        let units = model.units;
        let mut config = None;
        if let Some(kc) = &target.kc {
            let Checked { value, diagnostics } =
                Config::read(kc, 1e-3 / units.length.si, 1.0 / units.force.si);
            out.extend(diagnostics);
            config = value;
        }
        if has_errors(out) {
            return Err(Refused::Input);
        }
        let mirror = config
            .as_ref()
            .map_or_else(Mirror::default, |config| Mirror {
                lateral: config.frame.to_deck(&Vec3::y()),
            });
        let rig = config
            .as_ref()
            .map(|config| rig_markers(config, &dataset, &model))
            .unwrap_or_default();
        let config = config
            .filter(|_| target.goals.is_empty() || target.goals.iter().any(is_of_test))
            .map(|config| config.with_tests(&tests(&target), model.frictions.is_empty()));
        let unknowns = resolved(
            &target.unknowns,
            (&dataset, &model),
            &study.source,
            (mirror, &rig.named),
            out,
        );
        for unknown in &unknowns {
            if unknown.bounds.iter().any(|bound| bound.is_infinite()) {
                let message = format!("{} needs `bounds` within which it may change", unknown.name);
                out.push(
                    Diagnostic::error(Code::MissingSetting, message)
                        .label(study.source.name(), unknown.span, "")
                        .help("bounds = [\"-10 mm\", \"10 mm\"] are bounds of the change"),
                );
            }
        }
        for (key, missing) in [
            ("unknown", target.unknowns.is_empty()),
            ("goal", target.goals.is_empty()),
        ] {
            if missing {
                let message = format!("a target needs at least one [[target.{key}]]");
                let place = study.place(&["target"]);
                let error = Diagnostic::error(Code::MissingSetting, message);
                out.push(
                    error
                        .label(study.source.name(), place, "")
                        .help("see `admire guide tune`"),
                );
            }
        }
        if target.robust && !study.tolerances.is_stated {
            let message = "a robust target needs the section [tolerances], which states how much axles differ";
            out.push(
                Diagnostic::error(Code::MissingSetting, message)
                    .label(study.source.name(), study.place(&["target", "robust"]), "")
                    .help("`hardpoints = 0.3` there is a standard deviation in mm; `admire guide tune` shows one"),
            );
        }
        let names = GoalNames::new(&target.goals, &study, (&dataset, &model), out);
        let mut new = Self {
            study,
            target,
            dataset,
            files,
            model,
            config,
            unknowns,
            goals: Vec::new(),
            before: Answers {
                run: None,
                cases: Vec::new(),
            },
            rig,
            probes: names.probes.clone(),
            cases: names.cases.clone(),
        };
        if let Err(wrong) = new.bench(&new.dataset, &new.model) {
            out.extend(wrong);
        }
        if has_errors(out) {
            return Err(Refused::Input);
        }
        let refused = |why| {
            Refused::Start(TuneError {
                unknowns: Vec::new(),
                why,
            })
        };
        new.before = new.answers().map_err(refused)?;
        let source = &new.study.source;
        let undetermined = new.cases.undetermined(&new.model).map_err(refused)?;
        for (k, own) in &names.of_cases {
            let goal = &new.target.goals[*k];
            let of = [Some(own.case), own.relative_to];
            if undetermined
                .iter()
                .any(|(case, probe)| of.contains(&Some(*case)) && *probe == own.probe)
            {
                let message = format!("`{}` is not determined in this load case", goal.of.text);
                out.push(
                    Diagnostic::error(Code::BadSetting, message)
                        .label(source.name(), goal.of.span, "")
                        .help("the reading changes along a motion of the deck that nothing resists; `admire check` names the free motions"),
                );
            }
        }
        let answers = (&new.before, new.config.as_ref());
        new.goals = goals(&new.target.goals, source, &names, answers, &units, out);
        if has_errors(out) {
            return Err(Refused::Input);
        }
        Ok(new)
    }

    /// Mounts a deck on the rig. Returns `None` if no goal reads a test.
    ///
    /// # Errors
    /// The errors of [`Bench::new`].
    pub(crate) fn bench<'a>(
        &'a self,
        dataset: &'a Dataset,
        model: &'a Model,
    ) -> Result<Option<Bench<'a>>, Vec<Diagnostic>> {
        let Some(config) = &self.config else {
            return Ok(None);
        };
        let mut bench = Bench::new(config, dataset, &self.files, model)?;
        bench.probe(self.probes.clone());
        Ok(Some(bench))
    }

    /// Runs the tests and load cases on the deck of the study.
    fn answers(&self) -> Result<Answers, BenchError> {
        let asked = Asked {
            directions: &[],
            turned: &[],
        };
        let cases = self.cases.solve(&self.model, &asked)?;
        let bench = self.bench(&self.dataset, &self.model);
        let run = match bench.map_err(BenchError::Deck)? {
            Some(mut bench) => Some(run(&mut bench, &self.model.units)?),
            None => None,
        };
        Ok(Answers { run, cases })
    }

    /// Returns the coordinates of the unknowns at the start of the study.
    pub fn start(&self) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| unknown.start).collect()
    }

    /// Returns the index of a goal, given by its name as printed in the output, or by its number (from 1).
    ///
    /// # Errors
    /// Returns a diagnostic that lists all names if no goal or more than one goal has this name.
    pub fn goal_named(&self, word: &str) -> Result<usize, Box<Diagnostic>> {
        let number = word.parse::<usize>().ok();
        if let Some(k) = number.filter(|k| (1..=self.goals.len()).contains(k)) {
            return Ok(k - 1);
        }
        let names: Vec<String> = self.goals.iter().map(Goal::name).collect();
        let mut found = (0..names.len()).filter(|k| names[*k] == word);
        if let (Some(k), None) = (found.next(), found.next()) {
            return Ok(k);
        }
        let message = if names.iter().any(|name| name == word) {
            format!("several goals are called `{word}`")
        } else {
            format!("`{word}` is not a goal of this target")
        };
        let each = names.iter().enumerate();
        let all: Vec<String> = each
            .map(|(k, name)| format!("{} \"{name}\"", k + 1))
            .collect();
        let help = format!("name a goal or give its number: {}", all.join(", "));
        Err(Box::new(
            Diagnostic::error(Code::BadSetting, message).help(help),
        ))
    }

    /// Returns the indices of the two goals of a Pareto front.
    ///
    /// # Errors
    /// The errors of [`Self::goal_named`], and a diagnostic if both goals are the same.
    pub fn pair_named(&self, words: [&str; 2]) -> Result<[usize; 2], Box<Diagnostic>> {
        let [first, second] = words;
        let pair = [self.goal_named(first)?, self.goal_named(second)?];
        if pair[0] == pair[1] {
            let message = format!("`{first}` and `{second}` are the same goal");
            let help = "a Pareto front needs two different goals".to_string();
            return Err(Box::new(
                Diagnostic::error(Code::BadSetting, message).help(help),
            ));
        }
        Ok(pair)
    }

    /// Returns the natural size of each coordinate: half the distance between its bounds, or the standard deviation of its prior if that is
    /// smaller.
    pub(crate) fn scale(&self) -> Vec<f64> {
        let of = |unknown: &DeckUnknown| {
            let [least, most] = unknown.bounds;
            (0.5 * (most - least)).min(unknown.sd)
        };
        self.unknowns.iter().map(of).collect()
    }

    /// Returns the deck with the unknowns at these coordinates, as edits of the user's own file. All other text is unchanged. Numbers are
    /// written with twelve significant digits, which exceeds any manufacturing precision.
    ///
    /// # Errors
    /// Returns a diagnostic if a number cannot be written into the deck, such as a negative stiffness.
    pub fn deck(&self, x: &[f64]) -> Result<Source, Box<Diagnostic>> {
        rewritten(&self.dataset, &written_numbers(&self.unknowns, x))
    }
}

/// Returns the text of a deck with these numbers. Unchanged numbers keep their digits; changed numbers have twelve significant digits.
///
/// # Errors
/// The errors of [`Tuning::deck`].
pub(crate) fn rewritten(
    dataset: &Dataset,
    numbers: &[(Address, f64)],
) -> Result<Source, Box<Diagnostic>> {
    let beside = numbers.iter().map(|(address, _)| address).collect();
    let old = |address: &Address| dataset.value_at(address);
    let mut edits = Vec::new();
    for (address, value) in numbers {
        let value = significant(*value);
        // The digits of a number that stays are those of the user.
        if old(address).is_none_or(|old| significant(old) != value) {
            edits.extend(dataset.set_beside(address, value, &beside)?);
        }
    }
    let name = dataset.source().name();
    if let Ok(bytes) = apply_edits(dataset.bytes(), &edits) {
        return Ok(Source::new(name, bytes));
    }
    // Missing arguments would all be inserted at the same place, so they are written one after the other.
    let mut dataset = dataset.clone();
    for (address, value) in numbers {
        let edits = dataset.set_beside(address, significant(*value), &beside)?;
        dataset = dataset
            .edited(&edits)
            .map_err(|conflict| {
                Box::new(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
            })?
            .value;
    }
    Ok(dataset.source().clone())
}

/// Returns the tests that the goals name.
fn tests(target: &TargetSettings) -> Vec<TestKind> {
    let is_named = |kind: &TestKind| {
        target
            .goals
            .iter()
            .any(|goal| matches!(&goal.place, GoalPlace::Test(name) if name.text == kind.name()))
    };
    TestKind::ALL.into_iter().filter(is_named).collect()
}

fn is_of_test(goal: &GoalSettings) -> bool {
    matches!(goal.place, GoalPlace::Test(_))
}

/// Returns the markers that `kc.toml` names for the wheels.
fn rig_markers(config: &Config, dataset: &Dataset, model: &Model) -> RigMarkers {
    let (mut wheels, mut named) = (Vec::new(), Vec::new());
    for wheel in config.wheels.iter().flatten() {
        let marker = |name: &str| {
            let address = Address::parse(name, dataset).ok();
            let address = address.filter(|address| address.kind == "MARKER");
            address.and_then(|address| model.marker(address.id?))
        };
        let both = [&wheel.centre, &wheel.spin].into_iter();
        wheels.extend(both.filter_map(|name| marker(&name.text)));
        let others = wheel.travel_lock.iter();
        let others = others.chain(wheel.steer_axis.iter().flatten());
        named.extend(others.filter_map(|name| marker(&name.text)));
    }
    named.extend(&wheels);
    RigMarkers { wheels, named }
}

/// Rounds a value to twelve significant digits.
fn significant(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
