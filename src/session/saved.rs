use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic};
use crate::mechanics::{Mat3, Pose, Vec3};
use crate::model::{Definitions, Model};
use crate::system::{Driven, Grip, Rates, State};

use super::files::LARGEST;

/// The first line of a file that SAVE writes.
const MAGIC: &str = "admire saved state 1";

/// What SAVE keeps and RELOAD goes back to: where the model stands, and in the same run the model with its redefinitions too.
#[derive(Clone, Debug)]
pub(super) struct Saved {
    /// The model and the statements it stands for; a file does not hold them.
    pub model: Option<(Model, Definitions)>,
    /// Where it stands; absent before the first simulation.
    pub state: Option<Placed>,
}

/// What the SAVE commands of one run kept.
#[derive(Default)]
pub(super) struct Kept {
    /// With the model, by file.
    pub files: BTreeMap<PathBuf, Saved>,
    /// States alone, by the name of their buffer; they end with the run (`com_reload`).
    pub buffers: BTreeMap<String, Saved>,
}

/// A state without what only the solver needs.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Placed {
    time: f64,
    poses: Vec<Pose>,
    variables: Vec<f64>,
    states: Vec<f64>,
    /// Of a motion; empty at rest.
    velocities: Vec<Rates>,
    /// MOTIONs that prescribe a rate.
    driven: Vec<Driven>,
    /// Where angles are counted from.
    turns: Vec<f64>,
    /// SENVAL.
    sensors: Vec<f64>,
    /// Frictions of joints.
    grips: Vec<Grip>,
}

impl Saved {
    /// What there is to keep.
    pub(crate) fn of(model: &Model, definitions: &Definitions, state: Option<&State>) -> Self {
        Self {
            model: Some((model.clone(), definitions.clone())),
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

    /// Where the model stands, without the model.
    pub(crate) fn states(self) -> Self {
        Self {
            model: None,
            ..self
        }
    }

    /// Writes the state. A file that is there already is replaced only if SAVE wrote it.
    ///
    /// # Errors
    /// When it is another file or cannot be written.
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
            return Err(cannot("it is there already and no saved state"));
        }
        let mut text = format!("{MAGIC}\n");
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
        std::fs::write(path, text).map_err(|error| cannot(&error.to_string()))
    }

    /// Reads the state of a model that was read before.
    ///
    /// # Errors
    /// When the file cannot be read or is the state of another model.
    pub(crate) fn read(path: &Path, model: &Model) -> Result<Self, Diagnostic> {
        let cannot = |why: &str| {
            Diagnostic::error(
                Code::CannotRead,
                format!("`{}` cannot be read: {why}", path.display()),
            )
        };
        let there = std::fs::metadata(path).map_err(|error| cannot(&error.to_string()))?;
        if !there.is_file() || there.len() > LARGEST {
            // A device never ends.
            return Err(cannot("it is no saved state of this program"));
        }
        let text = std::fs::read_to_string(path).map_err(|error| cannot(&error.to_string()))?;
        let mut lines = text.lines();
        if lines.next() != Some(MAGIC) {
            return Err(cannot("it is no saved state of this program"));
        }
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
        for line in lines {
            let mut words = line.split(' ');
            let word = words.next().unwrap_or_default();
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
                ("velocity", all) if all.len() == 6 => placed.velocities.push(Rates {
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
                ("grip", all) if (14..=15).contains(&all.len()) => placed.grips.push(Grip {
                    sticking: all[0] != 0.0,
                    place: all[1],
                    creep: Vec3::from_column_slice(&all[2..5]),
                    turn: Mat3::from_column_slice(&all[5..14]),
                    first: all.get(14).copied(),
                }),
                _ => return Err(cannot("a line is damaged")),
            }
        }
        if any && placed.poses.len() != model.parts.len() {
            return Err(cannot("it is the state of another model"));
        }
        Ok(Self {
            model: None,
            state: any.then_some(placed),
        })
    }
}

impl Placed {
    /// Places a model.
    ///
    /// # Errors
    /// When it is the state of another model.
    pub(crate) fn put_into(self, state: &mut State) -> Result<(), Diagnostic> {
        if self.poses.len() != state.poses.len() {
            return Err(Diagnostic::error(
                Code::CannotRead,
                "the saved state is that of another model",
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
