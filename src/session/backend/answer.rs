//! Reading and checking the files that an external run leaves behind. They are accepted as its result only if they pass all checks.

use std::io::BufReader;
use std::path::Path;
use std::time::Duration;

use super::bushing_check::{BushingCheck, ForceFrame};
use super::case_check::CaseCheck;
use super::process::{CONSOLE, beginning, execute, tail};
use super::run_folder::STEM;
use super::{CaseFailure, CaseOutcome, RunError, Sweep, SweepRequest};
use admire_results::{Entity, StepKind, XrfReader};
use admire_solver::mechanics::{Pose, Vec3, euler313};
use admire_solver::model::{Model, PartKind};
use admire_solver::system::Equilibrium;
use admire_syntax::text::open_to_read;
use admire_syntax::units::LENGTH_UNITS;

/// Result of an external run.
#[derive(Debug)]
pub(super) struct Answer {
    pub sweep: Sweep,
    /// Axes in which the results file gives bushing forces, if they could be determined.
    pub frame: Option<ForceFrame>,
}

/// Returns the lines of the message file of a run; empty if there is no such file.
pub(super) fn messages(folder: &Path) -> Vec<String> {
    lines(&folder.join(format!("{STEM}.msg")))
}

fn lines(path: &Path) -> Vec<String> {
    beginning(path).lines().map(str::to_string).collect()
}

/// Runs a command line in a run folder, with the name of the command file in place of `{acf}`.
///
/// The run counts as successful only if its exit code is 0 and neither its messages nor its console output report a missing licence.
pub(super) fn run_command(
    command: &[String],
    folder: &Path,
    timeout: Duration,
) -> Result<(), RunError> {
    let acf = format!("{STEM}.acf");
    let words: Vec<String> = command
        .iter()
        .map(|word| word.replace("{acf}", &acf))
        .collect();
    let status = execute(&words, folder, timeout)?;
    if let Some(line) = licence_failure(folder) {
        return Err(RunError::Licence { line, waited: 0.0 });
    }
    if !status.success() {
        return Err(RunError::Exit {
            code: status.code(),
            tail: tail(folder),
        });
    }
    Ok(())
}

/// Returns the line with which a run reports a missing licence, in its message file or in its console output.
fn licence_failure(folder: &Path) -> Option<String> {
    messages(folder)
        .into_iter()
        .chain(lines(&folder.join(CONSOLE)))
        .find(|line| is_licence_failure(line))
        .map(|line| line.trim().to_string())
}

fn is_licence_failure(line: &str) -> bool {
    let line = line.to_ascii_lowercase();
    let names = line.contains("license") || line.contains("licence");
    names
        && [
            "fail",
            "error",
            "denied",
            "could not",
            "cannot",
            "unable",
            "no licen",
            "not available",
            "expired",
            "exceeded",
        ]
        .iter()
        .any(|word| line.contains(word))
}

/// Returns one flag for each static solution in the message file, in the order of the file: true if the solution converged.
fn convergence_flags(messages: &[String]) -> Vec<bool> {
    let mut fates = Vec::new();
    for line in messages {
        if line.contains("Begin Static Solution") {
            fates.push(false);
        } else if line.contains("Static Solution converged")
            && let Some(last) = fates.last_mut()
        {
            *last = true;
        }
    }
    fates
}

/// Assigns the output steps of a run to load cases; `fates` are the convergence flags from the messages.
///
/// The result has one entry for each step: the index of its load case, or `None` if the messages say that its solution did not converge. If
/// a failed case has no step, the messages must show which case failed. Returns `None` if steps and cases cannot be matched.
fn cases_of(steps: usize, fates: &[bool], cases: usize) -> Option<Vec<Option<usize>>> {
    let solved: Vec<usize> = (0..fates.len()).filter(|case| fates[*case]).collect();
    if steps == cases {
        let each = fates.len() == cases;
        let of = |case: usize| (!each || fates[case]).then_some(case);
        // If the messages contain no convergence flags, the program is trusted. If it solved some cases several times, it must have
        // converged as often as there are cases.
        let believed = fates.is_empty() || each || solved.len() >= cases;
        return believed.then(|| (0..cases).map(of).collect());
    }
    let told = fates.len() == cases && solved.len() == steps;
    told.then(|| solved.into_iter().map(Some).collect())
}

/// Reads and checks the result of a run from its folder. `known` is the frame of bushing forces found in earlier runs of the same program.
///
/// # Errors
/// Returns [`RunError::Results`] or [`RunError::Steps`] with the reason why the files are not a valid result.
pub(super) fn read(
    folder: &Path,
    request: &SweepRequest<'_>,
    known: Option<ForceFrame>,
) -> Result<Answer, RunError> {
    let broken = |reason: String| RunError::Results {
        reason,
        tail: tail(folder),
    };
    let model = request.model;
    let path = folder.join(format!("{STEM}.res"));
    let file = open_to_read(&path)
        .map_err(|error| broken(format!("there is no results file: {error}")))?;
    let mut reader = XrfReader::open(path.display().to_string(), BufReader::new(file))
        .map_err(|error| broken(error.into_diagnostic().message))?;
    same_model(model, &reader).map_err(broken)?;
    let places = places(model, &reader).map_err(broken)?;
    let degrees = reader.header().units.angle == "deg";
    let angle = if degrees { 1f64.to_radians() } else { 1.0 };
    let mut check = BushingCheck::new(request, reader.catalogue(), angle);
    check.frame = known;
    let mut order = CaseCheck::new(request, reader.catalogue());
    let mut steps: Vec<(Equilibrium, Vec<f64>)> = Vec::new();
    while let Some(step) = reader
        .next_step()
        .map_err(|error| broken(error.into_diagnostic().message))?
    {
        if !matches!(
            step.kind,
            StepKind::Static | StepKind::QuasiStatic | StepKind::Equilibrium
        ) {
            continue;
        }
        let mut values = Vec::new();
        step.values(&mut values)
            .map_err(|error| broken(error.into_diagnostic().message))?;
        if values.iter().any(|value| !value.is_finite()) {
            return Err(broken(format!(
                "step {} contains values that are not finite",
                steps.len() + 1
            )));
        }
        let pose = |place: &Option<[usize; 6]>| {
            place.map_or_else(Pose::identity, |ids| {
                let v = ids.map(|id| values[id - 1]);
                Pose {
                    p: Vec3::new(v[0], v[1], v[2]),
                    R: euler313(v[3] * angle, v[4] * angle, v[5] * angle),
                }
            })
        };
        let equilibrium = Equilibrium {
            time: values[0],
            poses: places.iter().map(pose).collect(),
        };
        steps.push((equilibrium, values));
    }
    if reader.run_status().is_none() {
        return Err(broken(
            "the results file is incomplete: it has no run status".to_string(),
        ));
    }
    let cases = request.programme.cases.len();
    let Some(of) = cases_of(steps.len(), &convergence_flags(&messages(folder)), cases) else {
        return Err(RunError::Steps {
            steps: steps.len(),
            cases,
            tail: tail(folder),
        });
    };
    let mut outcomes: Vec<CaseOutcome> = vec![Err(CaseFailure::NoStep { message: None }); cases];
    for (case, (equilibrium, values)) in of.into_iter().zip(steps) {
        let Some(case) = case else {
            continue;
        };
        order.step(case, &values).map_err(broken)?;
        check
            .step(case, &values, &equilibrium.poses)
            .map_err(broken)?;
        outcomes[case] = Ok(equilibrium);
    }
    Ok(Answer {
        sweep: Sweep { cases: outcomes },
        frame: check.frame,
    })
}

/// Checks that the results belong to this model: their title and length unit must be the same as in the deck.
fn same_model<R: std::io::Read>(model: &Model, reader: &XrfReader<R>) -> Result<(), String> {
    // Only the first 60 letters and digits are compared, because a results file may truncate, pad or re-encode the title.
    let plain = |title: &str| -> String {
        title
            .chars()
            .filter(char::is_ascii_alphanumeric)
            .take(60)
            .collect()
    };
    let (title, deck) = (&reader.header().title, &model.title);
    if !title.is_empty() && plain(title) != plain(deck) {
        return Err(format!(
            "the results are those of another model, `{}` instead of `{}`",
            title.trim(),
            deck.trim()
        ));
    }
    let (length, own) = (&reader.header().units.length, model.units.length.word);
    let known = |word: &str| LENGTH_UNITS.iter().any(|unit| unit.word == word);
    if length != own && known(length) && known(own) {
        return Err(format!(
            "the length unit of the results is {length}, but that of the deck is {own}"
        ));
    }
    Ok(())
}

/// Returns the column ids of X, Y, Z, PSI, THETA, PHI for each part of the model, and `None` for ground. Returns an error that names the
/// part if these columns are missing.
fn places<R: std::io::Read>(
    model: &Model,
    reader: &XrfReader<R>,
) -> Result<Vec<Option<[usize; 6]>>, String> {
    let six = |entity: &Entity| {
        let mut ids = [0; 6];
        for (id, name) in ids.iter_mut().zip(["X", "Y", "Z", "PSI", "THETA", "PHI"]) {
            *id = entity.component(name)?.id;
        }
        Some(ids)
    };
    let of = |part: &admire_solver::model::Part| {
        if part.kind == PartKind::Ground {
            return Ok(None);
        }
        let is_it = |entity: &&Entity| {
            let is_body = entity
                .ent_type
                .as_deref()
                .is_some_and(|kind| kind == "Part" || kind == "Point_Mass");
            is_body && entity.object_id == Some(i64::from(part.header.id))
        };
        let entities = &reader.catalogue().entities;
        match entities.iter().find(is_it).and_then(six) {
            Some(ids) => Ok(Some(ids)),
            None => Err(format!(
                "the results hold no pose of PART/{}",
                part.header.id
            )),
        }
    };
    model.parts.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_licence_that_was_had_is_no_failure() {
        for line in [
            "License checkout: ADAMS_Solver succeeded",
            "Checked out license for Adams Solver",
            "no failure here",
        ] {
            assert!(!is_licence_failure(line), "{line}");
        }
        for line in [
            "ERROR: could not checkout license",
            "Adams Solver: License request denied",
            "No license available for ADAMS_Solver",
            "Unable to obtain a licence",
        ] {
            assert!(is_licence_failure(line), "{line}");
        }
    }

    #[test]
    fn a_missing_step_is_given_to_the_case_that_failed() {
        let some = |cases: &[usize]| Some(cases.iter().copied().map(Some).collect::<Vec<_>>());
        assert_eq!(cases_of(2, &[true, false, true], 3), some(&[0, 2]));
        assert_eq!(cases_of(3, &[], 3), some(&[0, 1, 2]));
        assert_eq!(cases_of(3, &[true, false, true, true], 3), some(&[0, 1, 2]));
        // The output step of a solution that did not converge is discarded.
        assert_eq!(
            cases_of(3, &[true, false, true], 3),
            Some(vec![Some(0), None, Some(2)])
        );
        // If the number of converged solutions differs from the number of steps, the load cases of the steps cannot be identified.
        assert_eq!(cases_of(3, &[true, false, false, true], 3), None);
        assert_eq!(cases_of(2, &[true, true, true], 3), None);
        assert_eq!(cases_of(4, &[true, true, true], 3), None);
        assert_eq!(cases_of(2, &[true, false], 3), None);
    }
}
