use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use admire_solver::mechanics::{Mat3, Pose, Vec3};
use admire_solver::model::{Definitions, Model};
use admire_solver::system::{Driven, PartRates, State, StictionState};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::files::LARGEST;

/// Text at the start of a file written by SAVE; the version number of the file format follows.
const MAGIC: &str = "admire saved state ";
/// Version number of the current file format. Files of version 1 contain no model.
const FORM: &str = "2";

/// A state saved by SAVE for RELOAD, usually with the model and its redefinitions.
#[derive(Clone, Debug)]
pub(super) struct Saved {
    /// The saved model; `None` if only the state was saved.
    pub model: Option<Kind>,
    /// The saved state; `None` if it was saved before the first simulation.
    pub state: Option<Placed>,
}

/// A saved model, in one of two forms.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    /// A model that this run saved: the model itself, and its statements.
    Resolved(Box<(Model, Definitions)>),
    /// A model that was read from a saved file.
    Written(Written),
}

/// A model in the form in which a file stores it.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Written {
    /// Path of the dataset. It determines the names of the output files, and its folder is searched for other files.
    pub name: String,
    /// Content of the dataset.
    pub dataset: Vec<u8>,
    /// Commands that redefined statements of the model, one on each line.
    pub commands: Vec<u8>,
}

/// Everything that the SAVE commands of one run have saved.
#[derive(Default)]
pub(super) struct SavedStates {
    /// Saved models and states, by the path of their file.
    pub files: BTreeMap<PathBuf, Saved>,
    /// Saved states without models, by the name of their buffer. Buffers last until the end of the run (`com_reload`).
    pub buffers: BTreeMap<String, Saved>,
}

/// The part of a state that is saved; data that only the solver needs are left out.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Placed {
    time: f64,
    poses: Vec<Pose>,
    variables: Vec<f64>,
    states: Vec<f64>,
    /// Velocities of all parts; empty if the model is at rest.
    velocities: Vec<PartRates>,
    /// States of the MOTIONs that prescribe a velocity or acceleration.
    driven: Vec<Driven>,
    /// Reference values by which the full turns of angles are counted.
    turns: Vec<f64>,
    /// Stored values of the sensors, which the function SENVAL returns.
    sensors: Vec<f64>,
    /// Stiction states of the joint frictions.
    grips: Vec<StictionState>,
}

impl Saved {
    /// Saves a model, its statements and its current state.
    pub(crate) fn of(model: &Model, definitions: &Definitions, state: Option<&State>) -> Self {
        Self {
            model: Some(Kind::Resolved(Box::new((
                model.clone(),
                definitions.clone(),
            )))),
            state: state.map(|state| Placed {
                time: state.time,
                poses: state.poses.clone(),
                variables: state.variables.clone(),
                states: state.states.clone(),
                velocities: state.velocities.clone(),
                driven: state.driven.clone(),
                turns: state.turns(),
                sensors: state.sensors.clone(),
                grips: state.grips.clone(),
            }),
        }
    }

    /// Returns only the state, without the model.
    pub(crate) fn states(self) -> Self {
        Self {
            model: None,
            ..self
        }
    }

    /// Writes the saved model and state to a file. An existing file is replaced only if SAVE wrote it.
    ///
    /// # Errors
    /// Returns an error if an existing file was not written by SAVE, or if the file cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), Diagnostic> {
        let cannot = |why: &str| {
            Diagnostic::error(
                Code::CannotWrite,
                format!("`{}` cannot be written: {why}", path.display()),
            )
        };
        if let Ok(there) = std::fs::read(path)
            && !there.starts_with(MAGIC.as_bytes())
        {
            return Err(cannot("it already exists and is not a saved state"));
        }
        let mut text = format!("{MAGIC}{FORM}\n");
        if let Some(placed) = &self.state {
            let mut line = |word: &str, values: &mut dyn Iterator<Item = f64>| {
                text.push_str(word);
                for value in values {
                    write!(text, " {value:e}").expect("writing to a String does not fail");
                }
                text.push('\n');
            };
            line("time", &mut [placed.time].into_iter());
            for pose in &placed.poses {
                line("pose", &mut pose.p.iter().chain(pose.R.iter()).copied());
            }
            line("variables", &mut placed.variables.iter().copied());
            line("states", &mut placed.states.iter().copied());
            for rates in &placed.velocities {
                let both = rates.linear.iter().chain(rates.angular.iter());
                line("velocity", &mut both.copied());
            }
            for driven in &placed.driven {
                let numbers = [driven.time, driven.value, driven.rate];
                line("driven", &mut numbers.into_iter());
            }
            line("turns", &mut placed.turns.iter().copied());
            line("sensors", &mut placed.sensors.iter().copied());
            for grip in &placed.grips {
                let sticking = f64::from(u8::from(grip.sticking));
                let before = [sticking, grip.place].into_iter();
                let vectors = grip.creep.iter().chain(grip.turn.iter()).copied();
                line("grip", &mut before.chain(vectors).chain(grip.first));
            }
        }
        let mut bytes = text.into_bytes();
        if let Some(Kind::Resolved(model)) = &self.model {
            let definitions = &model.1;
            let source = definitions.dataset().source();
            let name = std::path::absolute(source.name());
            let name = name.map_or(source.name().to_string(), |path| path.display().to_string());
            let commands = definitions.commands();
            bytes.extend_from_slice(format!("commands {}\n", commands.len()).as_bytes());
            bytes.extend_from_slice(commands);
            let head = format!("dataset {} {name}\n", source.bytes().len());
            bytes.extend_from_slice(head.as_bytes());
            bytes.extend_from_slice(source.bytes());
        }
        std::fs::write(path, bytes).map_err(|error| cannot(&error.to_string()))
    }

    /// Reads a file written by SAVE.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is damaged.
    pub(crate) fn read(path: &Path) -> Result<Self, Diagnostic> {
        let cannot = |why: &str| {
            Diagnostic::error(
                Code::CannotRead,
                format!("`{}` cannot be read: {why}", path.display()),
            )
        };
        let there = std::fs::metadata(path).map_err(|error| cannot(&error.to_string()))?;
        if !there.is_file() || there.len() > LARGEST {
            // Only plain files are read, because reading a device might never end.
            return Err(cannot("it is not a saved state of this program"));
        }
        let bytes = std::fs::read(path).map_err(|error| cannot(&error.to_string()))?;
        let mut rest = bytes.as_slice();
        let form = next_line(&mut rest).and_then(|line| line.strip_prefix(MAGIC));
        if !matches!(form, Some("1" | FORM)) {
            return Err(cannot("it is not a saved state of this program"));
        }
        let mut commands = None;
        let mut model = None;
        let mut placed = Placed {
            time: 0.0,
            poses: Vec::new(),
            variables: Vec::new(),
            states: Vec::new(),
            velocities: Vec::new(),
            driven: Vec::new(),
            turns: Vec::new(),
            sensors: Vec::new(),
            grips: Vec::new(),
        };
        let mut any = false;
        while !rest.is_empty() {
            let line = next_line(&mut rest).ok_or_else(|| cannot("a line is damaged"))?;
            let (word, behind) = line.split_once(' ').unwrap_or((line, ""));
            if matches!(word, "commands" | "dataset") {
                let (length, name) = behind.split_once(' ').unwrap_or((behind, ""));
                let length = length.parse().ok().filter(|n: &usize| *n <= rest.len());
                let length = length.ok_or_else(|| cannot("a line is damaged"))?;
                let held = rest[..length].to_vec();
                rest = &rest[length..];
                if word == "commands" {
                    commands = Some(held);
                } else {
                    model = Some(Kind::Written(Written {
                        name: name.to_string(),
                        dataset: held,
                        commands: commands.take().unwrap_or_default(),
                    }));
                }
                continue;
            }
            let words = behind.split(' ').filter(|word| !word.is_empty());
            let values: Vec<f64> = words
                .map(str::parse)
                .collect::<Result<_, _>>()
                .map_err(|_| cannot("a number is damaged"))?;
            any = true;
            match (word, values.as_slice()) {
                ("time", [time]) => placed.time = *time,
                ("pose", all) if all.len() == 12 => placed.poses.push(Pose {
                    p: Vec3::from_column_slice(&all[..3]),
                    R: Mat3::from_column_slice(&all[3..]),
                }),
                ("variables", _) => placed.variables = values,
                ("states", _) => placed.states = values,
                ("velocity", all) if all.len() == 6 => placed.velocities.push(PartRates {
                    linear: Vec3::from_column_slice(&all[..3]),
                    angular: Vec3::from_column_slice(&all[3..]),
                }),
                ("driven", [time, value, rate]) => placed.driven.push(Driven {
                    time: *time,
                    value: *value,
                    rate: *rate,
                }),
                ("turns", _) => placed.turns = values,
                ("sensors", _) => placed.sensors = values,
                ("grip", all) if (14..=15).contains(&all.len()) => {
                    placed.grips.push(StictionState {
                        sticking: all[0] != 0.0,
                        place: all[1],
                        creep: Vec3::from_column_slice(&all[2..5]),
                        turn: Mat3::from_column_slice(&all[5..14]),
                        first: all.get(14).copied(),
                    });
                }
                _ => return Err(cannot("a line is damaged")),
            }
        }
        Ok(Self {
            model,
            state: any.then_some(placed),
        })
    }
}

/// Takes the next line from the remaining bytes. Returns `None` if there is no complete line or the line is not UTF-8.
fn next_line<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let end = rest.iter().position(|b| *b == b'\n')?;
    let line = std::str::from_utf8(&rest[..end]).ok()?;
    *rest = &rest[end + 1..];
    Some(line)
}

impl Placed {
    /// Transfers the saved state to a state of the current model.
    ///
    /// # Errors
    /// Returns an error if the saved state belongs to another model.
    pub(crate) fn put_into(self, state: &mut State) -> Result<(), Diagnostic> {
        if self.poses.len() != state.poses.len() {
            return Err(Diagnostic::error(
                Code::CannotRead,
                "the saved state belongs to another model",
            ));
        }
        state.time = self.time;
        state.poses = self.poses;
        if self.variables.len() == state.variables.len() {
            state.variables = self.variables;
        }
        if self.states.len() == state.states.len() {
            state.states = self.states;
        }
        if self.velocities.len() == state.poses.len() {
            state.velocities = self.velocities;
            state.set_moving();
        }
        if self.driven.len() == state.driven.len() {
            state.driven = self.driven;
        }
        if self.sensors.len() == state.sensors.len() {
            state.sensors = self.sensors;
        }
        if self.grips.len() == state.grips.len() {
            state.grips = self.grips;
        }
        state.set_turns(&self.turns);
        Ok(())
    }
}
