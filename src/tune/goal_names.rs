//! Names of load cases and readings in the goals of a target. They are resolved before anything is solved.

use std::collections::BTreeMap;

use crate::load_cases::LoadCases;
use crate::reading_name::{Named, Names};
use crate::tune_error::has_errors;
use admire_session::backend::LoadProgramme;
use admire_solver::model::Model;
use admire_solver::statics::Probe;
use admire_study::section::SpannedText;
use admire_study::{GoalPlace, GoalSettings, Measurement, Study, did_you_mean, programme, resolve};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Goal that reads a load case.
#[derive(Clone, Debug)]
pub(crate) struct CaseGoal {
    /// Index of the load case among the load cases that goals name.
    pub case: usize,
    /// Index of the load case whose value is subtracted; `None` if none is.
    pub relative_to: Option<usize>,
    /// Index of the probe among the probes of the load cases.
    pub probe: usize,
    pub named: Named,
}

/// Resolved names of all goals.
#[derive(Clone, Debug, Default)]
pub(crate) struct GoalNames {
    /// Goals that read load cases, by goal index.
    pub of_cases: BTreeMap<usize, CaseGoal>,
    /// Goals that read a probe in a test, by goal index. The value is the index of the probe and the quantity that it reads.
    pub of_tests: BTreeMap<usize, (usize, Named)>,
    /// Probes of the tests.
    pub probes: Vec<Probe>,
    /// Load cases that goals name, with their probes.
    pub cases: LoadCases,
}

/// Load cases and readings of a study.
struct OfStudy {
    measurement: Measurement,
    programme: LoadProgramme,
}

impl GoalNames {
    /// Resolves the load cases, forces, positions and readings that goals name. Names that cannot be resolved are reported in `out`.
    pub(crate) fn new(
        goals: &[GoalSettings],
        study: &Study,
        (dataset, model): (&Dataset, &Model),
        out: &mut Vec<Diagnostic>,
    ) -> Self {
        let mut new = Self::default();
        let has_cases = goals
            .iter()
            .any(|goal| matches!(goal.place, GoalPlace::Case { .. }));
        let of_study = has_cases
            .then(|| of_study(study, dataset, model, out))
            .flatten();
        let of_deck = Names::new(dataset, model, None);
        let of_cases = of_study
            .as_ref()
            .map(|own| (own, Names::new(dataset, model, Some(&own.measurement))));
        let mut found: BTreeMap<usize, CaseGoal> = BTreeMap::new();
        for (k, goal) in goals.iter().enumerate() {
            let located = |mut why: Box<Diagnostic>| {
                why.labels.clear();
                why.label(study.source.name(), goal.of.span, "")
            };
            match (&goal.place, &of_cases) {
                (GoalPlace::Test(_), _) => match of_deck.named(&goal.of.text) {
                    Some(Ok(named)) => {
                        let at = index_of(&named.probe, &mut new.probes);
                        new.of_tests.insert(k, (at, named));
                    }
                    Some(Err(why)) => out.push(located(why)),
                    None => {}
                },
                (GoalPlace::Case { label, relative_to }, Some((own, names))) => {
                    let named = names.named(&goal.of.text);
                    let named = named.unwrap_or_else(|| Err(names.unknown(&goal.of.text)));
                    let case = own.case(label, study, out);
                    let zero = relative_to.as_ref();
                    let zero = zero.map(|label| own.case(label, study, out));
                    match (named, case, zero) {
                        (Err(why), ..) => out.push(located(why)),
                        (Ok(named), Some(case), zero) if zero != Some(None) => {
                            let zero = zero.flatten();
                            match own.relative_to(goal, &named, (case, zero), study) {
                                Ok(relative_to) => {
                                    let probe = index_of(&named.probe, &mut new.cases.probes);
                                    found.insert(
                                        k,
                                        CaseGoal {
                                            case,
                                            relative_to,
                                            probe,
                                            named,
                                        },
                                    );
                                }
                                Err(why) => out.push(*why),
                            }
                        }
                        _ => {}
                    }
                }
                (GoalPlace::Case { .. }, None) => {}
            }
        }
        if let Some(own) = of_study {
            new.take(found, own);
        }
        new
    }

    /// Keeps only the load cases that goals name, in the order of the study, and renumbers them in the goals.
    fn take(&mut self, found: BTreeMap<usize, CaseGoal>, own: OfStudy) {
        let mut used: Vec<usize> = found
            .values()
            .flat_map(|goal| [Some(goal.case), goal.relative_to])
            .flatten()
            .collect();
        used.sort_unstable();
        used.dedup();
        let place = |case: usize| used.binary_search(&case).unwrap_or_default();
        let renumbered = found.into_iter().map(|(k, goal)| {
            let goal = CaseGoal {
                case: place(goal.case),
                relative_to: goal.relative_to.map(place),
                ..goal
            };
            (k, goal)
        });
        self.of_cases = renumbered.collect();
        let all = own.programme.cases;
        self.cases.programme = LoadProgramme {
            loads: own.programme.loads,
            cases: used.iter().map(|case| all[*case].clone()).collect(),
        };
    }
}

/// Reads the load cases and readings of a study. Returns `None` after an error.
fn of_study(
    study: &Study,
    dataset: &Dataset,
    model: &Model,
    out: &mut Vec<Diagnostic>,
) -> Option<OfStudy> {
    if study.columns.is_empty() {
        let message = "the study has no load cases";
        out.push(
            Diagnostic::error(Code::MissingSetting, message)
                .label(study.source.name(), study.place(&["target"]), "")
                .help("a goal with `case` needs the section [loads] with a table of load cases; see `admire guide study`"),
        );
        return None;
    }
    let mut own = Vec::new();
    let measurement = if study.is_measured() {
        let read = Measurement::resolve(study, model);
        own.extend(read.diagnostics);
        read.value
    } else {
        resolve::measurement(study, model, &mut own)
    };
    let programme = programme(study, dataset, &measurement, &mut own);
    let is_right = !has_errors(&own);
    // Remarks about the readings are those of `admire check` and `admire identify`.
    out.extend(own.into_iter().filter(|_| !is_right));
    is_right.then_some(OfStudy {
        measurement,
        programme,
    })
}

impl OfStudy {
    fn case(&self, label: &SpannedText, study: &Study, out: &mut Vec<Diagnostic>) -> Option<usize> {
        let found = self.measurement.case(&label.text);
        if found.is_none() {
            let cases = self.measurement.cases.iter();
            let labels: Vec<String> = cases.map(|case| case.label.clone()).collect();
            let message = format!("there is no load case `{}`", label.text);
            let help = did_you_mean(&label.text, "the file of load cases", &labels);
            out.push(
                Diagnostic::error(Code::UnknownCase, message)
                    .label(study.source.name(), label.span, "")
                    .help(help),
            );
        }
        found
    }

    /// Returns the load case whose value is subtracted. The goal may state it; otherwise its channel does.
    fn relative_to(
        &self,
        goal: &GoalSettings,
        named: &Named,
        (case, zero): (usize, Option<usize>),
        study: &Study,
    ) -> Result<Option<usize>, Box<Diagnostic>> {
        let Some(channel) = named.channel.map(|k| &self.measurement.channels[k]) else {
            return Ok(zero);
        };
        let complain = |message: String, help: &str| {
            let error = Diagnostic::error(Code::BadSetting, message);
            Box::new(
                error
                    .label(study.source.name(), goal.of.span, "")
                    .help(help),
            )
        };
        if channel.summary.is_some() {
            let message = format!("`{}` is read over several load cases", goal.of.text);
            return Err(complain(message, "name a reading of a single load case"));
        }
        if zero.is_some() && channel.relative_to.is_some() {
            let message = format!("`{}` is already relative to a load case", goal.of.text);
            return Err(complain(message, "remove `relative_to` from the goal"));
        }
        Ok(zero.or(channel.reference(case)))
    }
}

/// Returns the index of a probe in a list. A new probe is added to the list.
fn index_of(probe: &Probe, all: &mut Vec<Probe>) -> usize {
    if let Some(k) = all.iter().position(|own| own == probe) {
        return k;
    }
    all.push(probe.clone());
    all.len() - 1
}
