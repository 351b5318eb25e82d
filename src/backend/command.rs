use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::run_folder::{PrepareError, STEM, prepare};
use super::{Backend, BackendError, CaseFailure, CaseOutcome, RunError, Sweep, SweepRequest};
use crate::mechanics::{Mat3, Pose, RelativeMotion, Vec3, Vec6, euler313};
use crate::model::{Bushing, Model, PartKind};
use crate::results::{Entity, StepKind, XrfReader};
use crate::system::Equilibrium;

/// Any program with ADAMS' command line. Each sweep runs in a fresh temporary folder, so that no older file can be taken for its
/// answer; the folder of a failed run is kept.
#[derive(Clone, Debug)]
pub struct CommandBackend {
    /// Program and arguments; `{acf}` stands for the command file.
    pub command: Vec<String>,
    /// After which a run is killed.
    pub timeout: Duration,
    /// Keep the folders of good runs too.
    pub keep: bool,
}

impl CommandBackend {
    /// A backend for a command line.
    pub fn new(command: Vec<String>, timeout: Duration) -> Self {
        Self {
            command,
            timeout,
            keep: false,
        }
    }

    fn run(&self, folder: &Path, request: &SweepRequest<'_>) -> Result<Sweep, RunError> {
        prepare(folder, request).map_err(|error| match error {
            PrepareError::Edit(diagnostic) => RunError::Deck(diagnostic.message.clone()),
            PrepareError::Write(error) => RunError::Files(error.to_string()),
        })?;
        let status = self.execute(folder)?;
        let messages = messages(folder);
        // Callers of ADAMS rely on its messages as much as on its exit code; a run is good only if both are.
        if let Some(line) = messages.iter().find(|line| is_licence_failure(line)) {
            return Err(RunError::Licence(line.trim().to_string()));
        }
        if !status.success() {
            return Err(RunError::Exit {
                code: status.code(),
                tail: tail(folder, &messages),
            });
        }
        let steps = read_steps(folder, request)?;
        let fates = fates(&messages);
        assign(steps, &fates, request.programme.cases.len(), || {
            tail(folder, &messages)
        })
    }

    fn execute(&self, folder: &Path) -> Result<ExitStatus, RunError> {
        let acf = format!("{STEM}.acf");
        let words: Vec<String> = self
            .command
            .iter()
            .map(|word| word.replace("{acf}", &acf))
            .collect();
        let Some((program, arguments)) = words.split_first() else {
            return Err(RunError::Start {
                program: String::new(),
                reason: "no program is given".to_string(),
            });
        };
        let start = |error: std::io::Error| RunError::Start {
            program: program.clone(),
            reason: error.to_string(),
        };
        // Into a file: a pipe that nobody empties would hang the run.
        let log = File::create(folder.join("console.log")).map_err(start)?;
        let also = log.try_clone().map_err(start)?;
        let mut child = Command::new(program)
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(also)
            .spawn()
            .map_err(start)?;
        let begin = Instant::now();
        let mut pause = Duration::from_micros(200);
        loop {
            match child.try_wait().map_err(start)? {
                Some(status) => return Ok(status),
                None if begin.elapsed() > self.timeout => {
                    // The answer is no longer wanted; that it has just ended is no error.
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(RunError::Timeout {
                        seconds: self.timeout.as_secs_f64(),
                        tail: tail(folder, &[]),
                    });
                }
                None => std::thread::sleep(pause),
            }
            pause = (pause * 2).min(Duration::from_millis(50));
        }
    }
}

impl Backend for CommandBackend {
    fn name(&self) -> &'static str {
        "command"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let made = tempfile::Builder::new().prefix("admire-run-").tempdir();
        let folder = made.map_err(|error| BackendError::Run {
            reason: Box::new(RunError::Files(error.to_string())),
            folder: PathBuf::new(),
        })?;
        match self.run(folder.path(), request) {
            Ok(sweep) => {
                if self.keep {
                    let _ = folder.keep();
                }
                Ok(sweep)
            }
            Err(reason) => Err(BackendError::Run {
                reason: Box::new(reason),
                folder: folder.keep(),
            }),
        }
    }
}

/// Lines of the message file; none if there is none.
fn messages(folder: &Path) -> Vec<String> {
    let bytes = std::fs::read(folder.join(format!("{STEM}.msg"))).unwrap_or_default();
    String::from_utf8_lossy(&bytes)
        .lines()
        .map(str::to_string)
        .collect()
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
            "checkout",
        ]
        .iter()
        .any(|word| line.contains(word))
}

/// The last lines of the console and the message file, for a person.
fn tail(folder: &Path, messages: &[String]) -> String {
    let console = std::fs::read(folder.join("console.log")).unwrap_or_default();
    let console = String::from_utf8_lossy(&console);
    let mut lines: Vec<&str> = console
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    if lines.is_empty() {
        lines = messages
            .iter()
            .map(String::as_str)
            .filter(|line| !line.trim().is_empty())
            .collect();
    }
    lines[lines.len().saturating_sub(12)..].join("\n")
}

/// Whether each static solution that was begun also converged, in the order of the message file.
fn fates(messages: &[String]) -> Vec<bool> {
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

/// Gives every step to its case. A failed case has no step; which one it was, the messages must say.
fn assign(
    steps: Vec<Equilibrium>,
    fates: &[bool],
    cases: usize,
    tail: impl Fn() -> String,
) -> Result<Sweep, RunError> {
    if steps.len() == cases {
        return Ok(Sweep {
            cases: steps.into_iter().map(Ok).collect(),
        });
    }
    let converged = fates.iter().filter(|fate| **fate).count();
    if fates.len() != cases || converged != steps.len() {
        return Err(RunError::Steps {
            steps: steps.len(),
            cases,
            tail: tail(),
        });
    }
    let mut steps = steps.into_iter();
    let of = |fate: &bool| -> CaseOutcome {
        match steps.next_if(*fate) {
            Some(step) => Ok(step),
            None => Err(CaseFailure::NoStep { message: None }),
        }
    };
    Ok(Sweep {
        cases: fates.iter().map(of).collect(),
    })
}

/// `next` only when wanted.
trait NextIf: Iterator {
    fn next_if(&mut self, wanted: bool) -> Option<Self::Item> {
        if wanted { self.next() } else { None }
    }
}

impl<I: Iterator> NextIf for I {}

/// Poses of every static step, from the `_XFORM` entities only; the bushings of each are checked.
fn read_steps(folder: &Path, request: &SweepRequest<'_>) -> Result<Vec<Equilibrium>, RunError> {
    let model = request.model;
    let path = folder.join(format!("{STEM}.res"));
    let broken = |reason: String| RunError::Results(reason);
    let file =
        File::open(&path).map_err(|error| broken(format!("there is no results file: {error}")))?;
    let mut reader = XrfReader::open(path.display().to_string(), BufReader::new(file))
        .map_err(|error| broken(error.into_diagnostic().message))?;
    let degrees = reader.header().units.angle == "deg";
    let places = places(model, &reader)?;
    let (checks, numbers) = (bushing_columns(model, &reader), stiffnesses(request));
    let mut frame = None;
    let mut out = Vec::new();
    let mut values = Vec::new();
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
        step.values(&mut values)
            .map_err(|error| broken(error.into_diagnostic().message))?;
        let angle = if degrees { 1f64.to_radians() } else { 1.0 };
        let poses: Vec<Pose> = places
            .iter()
            .map(|place| {
                place.map_or_else(Pose::identity, |ids| {
                    let v = ids.map(|id| values[id - 1]);
                    Pose {
                        p: Vec3::new(v[0], v[1], v[2]),
                        R: euler313(v[3] * angle, v[4] * angle, v[5] * angle),
                    }
                })
            })
            .collect();
        check_bushings(model, (&checks, &numbers), &values, &poses, &mut frame)?;
        out.push(Equilibrium {
            time: values[0],
            poses,
        });
    }
    if reader.run_status().is_none() {
        return Err(broken(
            "the results file ends before the run did".to_string(),
        ));
    }
    Ok(out)
}

/// Ids of X, Y, Z, PSI, THETA, PHI of each part of the model; `None` for ground.
fn places<R: std::io::Read>(
    model: &Model,
    reader: &XrfReader<R>,
) -> Result<Vec<Option<[usize; 6]>>, RunError> {
    let six = |entity: &Entity| {
        let mut ids = [0; 6];
        for (id, name) in ids.iter_mut().zip(["X", "Y", "Z", "PSI", "THETA", "PHI"]) {
            *id = entity.component(name)?.id;
        }
        Some(ids)
    };
    let of = |part: &crate::model::Part| {
        if part.kind == PartKind::Ground {
            return Ok(None);
        }
        let ids = reader
            .catalogue()
            .entities
            .iter()
            .find(|entity| {
                let is_body = entity
                    .ent_type
                    .as_deref()
                    .is_some_and(|kind| kind == "Part" || kind == "Point_Mass");
                is_body && entity.object_id == Some(i64::from(part.header.id))
            })
            .and_then(six);
        match ids {
            Some(ids) => Ok(Some(ids)),
            None => Err(RunError::Results(format!(
                "the results hold no pose of PART/{}",
                part.header.id
            ))),
        }
    };
    model.parts.iter().map(of).collect()
}

/// Columns FX to TZ of each bushing that the file reports.
fn bushing_columns<R: std::io::Read>(
    model: &Model,
    reader: &XrfReader<R>,
) -> Vec<(usize, [usize; 6])> {
    let of = |(at, bushing): (usize, &Bushing)| {
        let entity = reader
            .catalogue()
            .entity_of("Bushing", i64::from(bushing.header.id))?;
        let mut ids = [0; 6];
        for (id, name) in ids.iter_mut().zip(["FX", "FY", "FZ", "TX", "TY", "TZ"]) {
            *id = entity.component(name)?.id;
        }
        Some((at, ids))
    };
    model.bushings.iter().enumerate().filter_map(of).collect()
}

/// The axes in which a file states bushing forces; no public source settles it, so the numbers themselves decide.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ForceFrame {
    Ground,
    J,
}

/// Numbers of the bushings of this run: K, KT, FORCE, TORQUE as the deck has them, with the request's changes.
fn stiffnesses(request: &SweepRequest<'_>) -> Vec<[[f64; 3]; 4]> {
    let of = |bushing: &Bushing| {
        let mut numbers = [bushing.k, bushing.kt, bushing.force, bushing.torque];
        for (address, value) in request.theta {
            let own = address.kind == "BUSHING" && address.id == Some(bushing.header.id);
            let words = ["K", "KT", "FORCE", "TORQUE"];
            let word = words
                .iter()
                .position(|word| address.argument.as_deref() == Some(word));
            if let (true, Some(word), Some(index @ 1..=3)) = (own, word, address.index) {
                numbers[word][index - 1] = *value;
            }
        }
        numbers
    };
    request.model.bushings.iter().map(of).collect()
}

/// Recomputes the force of every bushing by its law from the poses, and finds the frame in which the file's forces agree.
fn check_bushings(
    model: &Model,
    (columns, numbers): (&[(usize, [usize; 6])], &[[[f64; 3]; 4]]),
    values: &[f64],
    poses: &[Pose],
    frame: &mut Option<ForceFrame>,
) -> Result<(), RunError> {
    for (at, ids) in columns {
        let bushing = &model.bushings[*at];
        let [i, j] = [bushing.i, bushing.j].map(|marker| {
            let marker = &model.markers[marker.0];
            poses[marker.part.0].compose(&Pose {
                p: marker.qp,
                R: marker.R,
            })
        });
        let motion = RelativeMotion::between(&i, &j, &Vec3::zeros());
        let [k, kt, force, torque] = numbers[*at].map(Vec3::from);
        // F = -K delta + FORCE, T = -KT (a, b, c) + TORQUE, in J axes (ADAMS-FORMATS 2.7).
        let f = force - k.component_mul(&motion.p_ij_j);
        let t = torque - kt.component_mul(&motion.angles);
        let read = Vec6::from_iterator(ids.iter().map(|id| values[id - 1]));
        let fits = |R: &Mat3| {
            let near = |a: Vec3, b: Vec3| (a - b).norm() <= AGREES * (1.0 + b.norm());
            near(read.fixed_rows::<3>(0).into(), R * f)
                && near(read.fixed_rows::<3>(3).into(), R * t)
        };
        let in_frames = [
            (ForceFrame::Ground, fits(&j.R)),
            (ForceFrame::J, fits(&Mat3::identity())),
        ];
        let allowed: Vec<ForceFrame> = in_frames
            .into_iter()
            .filter(|(which, fits)| *fits && frame.is_none_or(|known| known == *which))
            .map(|(which, _)| which)
            .collect();
        match allowed.as_slice() {
            [] => {
                return Err(RunError::Results(format!(
                    "the force of BUSHING/{} fits its deflection {}",
                    bushing.header.id,
                    match frame {
                        None => "neither in ground axes nor in those of its J marker",
                        Some(ForceFrame::Ground) =>
                            "no longer in ground axes, in which the steps before do",
                        Some(ForceFrame::J) =>
                            "no longer in the axes of its J marker, in which the steps before do",
                    }
                )));
            }
            [only] => *frame = Some(*only),
            _ => {}
        }
    }
    Ok(())
}

/// Relative agreement of recomputed bushing forces: a stiff bushing turns the last digits of a pose into so much force.
const AGREES: f64 = 1e-5;
