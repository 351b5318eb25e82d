//! Reader of the recorded outputs: `[[keep]]` of SWEEP.toml.

use admire_kc::TestKind;
use admire_syntax::diagnostic::Code;
use admire_syntax::text::Span;

use super::answer_path::{AnswerPath, ResultFile};
use super::complaints::CollectedDiagnostics;
use super::kept::{OutputSpec, Reduction};
use super::plan_file::{self, PlanFile};
use super::task::Task;

/// Reads all `[[keep]]` tables.
pub(super) fn keeps(
    file: &PlanFile,
    task: &Task,
    out: &mut CollectedDiagnostics,
) -> Vec<(OutputSpec, Option<String>, Span)> {
    if file.keep.is_empty() {
        let message = "nothing is kept: add a `[[keep]]` with a column, a mode, a characteristic or a result of a study";
        out.wrong(Code::MissingArgument, file.sampling.plan.span(), message);
    }
    let mut all = Vec::new();
    for keep in &file.keep {
        let span = keep.span();
        let Some(found) = one(keep.get_ref(), &span, out) else {
            continue;
        };
        let fits = matches!(
            (&found, task),
            (OutputSpec::Characteristic { .. }, Task::Tests(_))
                | (OutputSpec::Answer(_), Task::Study(..))
                | (
                    OutputSpec::Column { .. } | OutputSpec::Mode(_),
                    Task::Commands(_)
                )
        );
        if !fits {
            let message = match task {
                Task::Tests(_) => {
                    "K&C tests give only characteristics: `characteristic = \"toe_angle.left\"`"
                }
                Task::Study(..) => {
                    "from a study, numbers of its result are kept: `identification = \"parameters[*].value\"` or `diagnosis = \"baseline.chi2_per_dof\"`"
                }
                Task::Commands(_) => {
                    "a command file gives columns and modes; characteristics need `kc = \"kc.toml\"`, and identification and diagnosis need a `study`"
                }
            };
            out.wrong(Code::BadSetting, span, message);
            continue;
        }
        if file.solver.is_some() && matches!(found, OutputSpec::Mode(_)) {
            let message = "from the run of an external program, only columns can be kept";
            out.wrong(Code::BadSetting, span, message);
            continue;
        }
        let name = keep.get_ref().name.as_ref();
        all.push((found, name.map(|n| n.get_ref().clone()), Span::from(span)));
    }
    all
}

fn one(
    keep: &plan_file::Keep,
    span: &std::ops::Range<usize>,
    out: &mut CollectedDiagnostics,
) -> Option<OutputSpec> {
    let answers = [
        (ResultFile::Identification, &keep.identification),
        (ResultFile::Diagnosis, &keep.diagnosis),
    ];
    let plain = answers.iter().all(|(_, text)| text.is_none());
    let mut paths = answers
        .into_iter()
        .filter_map(|(answer, text)| Some((answer, text.as_ref()?)));
    if let (Some((answer, text)), None, None, None, None) = (
        paths.next(),
        paths.next(),
        &keep.column,
        &keep.mode,
        &keep.characteristic,
    ) {
        let path = AnswerPath::parse(answer, text.get_ref());
        if path.is_none() {
            let message = "a field of the result is written like `fit_test.chi2` or `parameters[BUSHING/1.K.1].value`";
            out.wrong(Code::BadSetting, text.span(), message);
        }
        return path.map(OutputSpec::Answer);
    }
    match (&keep.column, &keep.mode, &keep.characteristic) {
        (Some(pattern), None, None) if plain => {
            let at = match (&keep.at, &keep.step, &keep.time) {
                (None, None, None) => Reduction::Last,
                (Some(word), None, None) => {
                    let Some(at) = Reduction::of_word(word.get_ref()) else {
                        let message = "`at` must be last, first, max, min, mean, range or rms; a single step is given by `step = 2` or `time = 0.5`";
                        out.wrong(Code::BadSetting, word.span(), message);
                        return None;
                    };
                    at
                }
                (None, Some(step), None) if *step.get_ref() > 0 => Reduction::Step(*step.get_ref()),
                (None, Some(step), None) => {
                    out.wrong(Code::OutOfRange, step.span(), "steps are counted from 1");
                    return None;
                }
                (None, None, Some(time)) => Reduction::Time(*time.get_ref()),
                _ => {
                    let message = "give only one of `at`, `step` and `time`";
                    out.wrong(Code::BadSetting, span.clone(), message);
                    return None;
                }
            };
            Some(OutputSpec::Column {
                pattern: pattern.get_ref().clone(),
                at,
            })
        }
        (None, Some(mode), None) if plain => {
            if *mode.get_ref() == 0 {
                out.wrong(Code::OutOfRange, mode.span(), "modes are counted from 1");
                return None;
            }
            Some(OutputSpec::Mode(*mode.get_ref()))
        }
        (None, None, Some(path)) if plain => {
            let test = keep.test.as_ref();
            if let Some(test) = test
                && !TestKind::ALL
                    .iter()
                    .any(|kind| kind.name() == test.get_ref())
            {
                let names: Vec<&str> = TestKind::ALL.iter().map(|kind| kind.name()).collect();
                let message = format!(
                    "`{}` is not a test; the tests are {}",
                    test.get_ref(),
                    names.join(", ")
                );
                out.wrong(Code::BadSetting, test.span(), &message);
                return None;
            }
            Some(OutputSpec::Characteristic {
                path: path.get_ref().clone(),
                test: test.map(|t| t.get_ref().clone()),
            })
        }
        _ => {
            let message = "exactly one of `column`, `mode`, `characteristic`, `identification` and `diagnosis` must be given";
            out.wrong(Code::BadSetting, span.clone(), message);
            None
        }
    }
}
