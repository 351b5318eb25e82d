//! The commands LINEAR/EIGENSOL and LINEAR/STATEMAT: eigenvalues, mode shapes and state matrices at the current state of the model.

use std::fmt::Write as _;

use serde_json::json;

use super::loaded::CompiledModel;
use super::message::exponent;
use super::paths::native_spelling;
use super::run_state::{Flow, Locate, Place, Session};
use admire_solver::motion;
use admire_solver::motion::{Coordinates, Mode};
use admire_syntax::Statement;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Names of the six coordinates of a part in a mode shape.
const COORDINATES: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];

impl Session<'_> {
    /// Executes a LINEAR command.
    pub(super) fn linear(&mut self, command: &Statement, place: Option<Place<'_>>) -> Flow {
        if !command.has("EIGENSOL") && !command.has("STATEMAT") {
            let refusal = Diagnostic::error(
                Code::CommandNotSupported,
                "only EIGENSOL and STATEMAT of LINEAR are supported; this command is skipped",
            );
            return self.refused(refusal, place);
        }
        let Some(place) = place else {
            return Ok(());
        };
        if self.loaded.is_none() {
            let missing = Diagnostic::error(Code::NoModel, "no model was read before this command")
                .help("FILE/MODEL=name reads one");
            return self.misunderstood(missing, Some(place));
        }
        let errors = self.model().compiled().value.errors.clone();
        if !errors.is_empty() {
            self.report_once(errors);
            let refusal = Diagnostic::error(
                Code::NotSolvedNatively,
                "this command is not executed: its result would omit the elements named above",
            );
            return self.refused(refusal, Some(place));
        }
        if let Some(flow) = self.refuse_motion(place) {
            return flow;
        }
        let system = &self.model().compiled().value.system;
        if let Some(owner) = system.driven_by_states().cloned() {
            let message = format!("{owner} reads dynamic states and cannot be linearised");
            let refusal = Diagnostic::error(Code::NotSolvedNatively, message);
            return self.refused(refusal.about(owner.object()), Some(place));
        }
        if !self.model().stands()
            && let Err(error) = self.model().begin(1e-3, false)
        {
            self.motion_failed(&error, place);
            return self.simulation_failed();
        }
        let coordinates = match self.coordinates(command) {
            Ok(coordinates) => coordinates,
            Err(why) => {
                let diagnostic = Diagnostic::error(Code::UndefinedId, why);
                return self.misunderstood(diagnostic, Some(place));
            }
        };
        if command.has("STATEMAT") {
            return self.state_matrices(command, &coordinates, place);
        }
        let CompiledModel {
            system,
            parameters,
            state,
            ..
        } = self.model().compiled().value;
        let time = state.time;
        let damped = !command.has("NODAMPIN");
        let found = motion::modes_in(system, parameters, state, damped, &coordinates);
        let found = match found {
            Ok(found) => found,
            Err(reason) => return self.not_linearised(time, &reason, place),
        };
        let names: Vec<String> = self
            .model()
            .model
            .parts
            .iter()
            .map(|part| part.header.name.clone())
            .collect();
        let kept = shown(&found).cloned();
        self.model().outputs.keep_modes(kept);
        let text = table(&found, &names, time, !command.has("NOVECTOR"));
        self.messages.say(&text);
        let written = to_json(&found, &names, time);
        match self.model().outputs.write_beside("modes.json", &written) {
            Ok(()) => Ok(()),
            Err(diagnostic) => self.unwritable(&diagnostic),
        }
    }
}

impl Session<'_> {
    fn not_linearised(
        &mut self,
        time: f64,
        reason: &motion::MotionFailure,
        place: Place<'_>,
    ) -> Flow {
        let diagnostic = Diagnostic::error(
            Code::NoMotion,
            format!("the equations cannot be linearised at time {time}: {reason}"),
        );
        self.complain(&Some(place).label(diagnostic));
        self.simulation_failed()
    }

    /// Returns the indices in the model of the VARIABLEs of the PINPUT, POUTPUT or PSTATE that a command names; empty if it names none.
    fn port(&mut self, command: &Statement, kind: &'static str) -> Result<Vec<usize>, String> {
        let Some(id) = command.first(kind) else {
            return Ok(Vec::new());
        };
        let model = &self.model().model;
        let mut ports = model.plant_ports.iter();
        let port = ports.find(|p| p.kind == kind && f64::from(p.header.id) == id);
        let Some(port) = port else {
            return Err(format!("there is no {kind}/{id}"));
        };
        let variable = |id: &u32| {
            let mut all = model.variables.iter();
            let found = all.position(|v| v.header.id == *id);
            found.ok_or_else(|| {
                format!(
                    "{kind}/{} names VARIABLE/{id}, which does not exist",
                    port.header.id
                )
            })
        };
        port.variables.iter().map(variable).collect()
    }

    /// Reads the arguments PSTATE and RM of a LINEAR command, which define the states.
    fn coordinates(&mut self, command: &Statement) -> Result<Coordinates, String> {
        let variables = self.port(command, "PSTATE")?;
        let seen_from = command.first("RM").filter(|id| *id != 0.0);
        let seen_from = seen_from.map(|id| {
            let mut markers = self.model().model.markers.iter();
            let found = markers.position(|marker| f64::from(marker.header.id) == id);
            found.ok_or_else(|| format!("there is no MARKER/{id}"))
        });
        Ok(Coordinates {
            variables,
            seen_from: seen_from.transpose()?,
        })
    }

    /// Executes LINEAR/STATEMAT: writes the state matrices in the text format of MATLAB, and a list of the states.
    fn state_matrices(
        &mut self,
        command: &Statement,
        coordinates: &Coordinates,
        place: Place<'_>,
    ) -> Flow {
        let ports = (self.port(command, "PINPUT"), self.port(command, "POUTPUT"));
        let (inputs, outputs) = match ports {
            (Ok(inputs), Ok(outputs)) => (inputs, outputs),
            (Err(why), _) | (_, Err(why)) => {
                let diagnostic = Diagnostic::error(Code::UndefinedId, why);
                return self.misunderstood(diagnostic, Some(place));
            }
        };
        let system = &self.model().compiled().value.system;
        if let Some(&input) = inputs.iter().find(|&&input| system.constrains(input)) {
            let owner = system.variables[input].name.clone();
            let message =
                format!("a constraint reads the input {owner}, so the model cannot be linearised");
            let refusal = Diagnostic::error(Code::NotSolvedNatively, message);
            return self.refused(refusal.about(owner.object()), Some(place));
        }
        let asked = command.argument("FORMAT");
        let asked = asked.map_or("MATRIXX", |a| {
            a.choices(place.source)
                .first()
                .copied()
                .unwrap_or("MATRIXX")
        });
        if asked != "MATLAB" {
            let warning = Diagnostic::warning(
                Code::OutputNotWritten,
                "the state matrices are written for MATLAB: the MATRIXX format is not supported",
            )
            .help("write FORMAT=MATLAB to request the MATLAB format");
            self.complain(&Some(place).label(warning));
        }
        let CompiledModel {
            system,
            parameters,
            state,
            ..
        } = self.model().compiled().value;
        let time = state.time;
        let found =
            motion::state_matrices(system, parameters, state, &inputs, &outputs, coordinates);
        let found = match found {
            Ok(found) => found,
            Err(reason) => return self.not_linearised(time, &reason, place),
        };
        let name = command
            .text("FILE", place.source)
            .map(std::borrow::Cow::into_owned);
        let mut files = vec![("a", numbers(&found.A)), ("st", listed(&found.states))];
        if !inputs.is_empty() {
            files.push(("b", numbers(&found.B)));
        }
        if !outputs.is_empty() {
            files.push(("c", numbers(&found.C)));
        }
        if !inputs.is_empty() && !outputs.is_empty() {
            files.push(("d", numbers(&found.D)));
        }
        let mut written = Vec::new();
        for (suffix, text) in files {
            let path = match &name {
                Some(name) => self
                    .directory
                    .join(native_spelling(&format!("{name}{suffix}"))),
                None => self.model().outputs.beside(suffix),
            };
            let outputs = &mut self.model().outputs;
            let done = if outputs.is_in_memory() {
                outputs.write_file(&path, &text)
            } else {
                let allowed = self.policy.check(&path);
                allowed.and_then(|()| self.model().outputs.write_file(&path, &text))
            };
            if let Err(diagnostic) = done {
                return self.refused(diagnostic, Some(place));
            }
            written.push(
                path.file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
            );
        }
        self.messages.say(&format!(
            "\n  State matrices at time {}: {} states, {} inputs, {} outputs, in {}\n",
            exponent(time, 5),
            found.states.len(),
            inputs.len(),
            outputs.len(),
            written.join(", ")
        ));
        Ok(())
    }
}

/// Formats a matrix for the MATLAB command `load`, with one line for each row.
fn numbers(matrix: &nalgebra::DMatrix<f64>) -> String {
    let mut text = String::new();
    for row in matrix.row_iter() {
        let cells: Vec<String> = row.iter().map(|x| format!("{:>24.16e}", x + 0.0)).collect();
        text += &(cells.join(" ") + "\n");
    }
    text
}

/// Formats a numbered list of the states.
fn listed(states: &[String]) -> String {
    let mut text = String::new();
    for (k, state) in states.iter().enumerate() {
        _ = writeln!(text, "{:>5}  {state}", k + 1);
    }
    text
}

/// Iterates over the real modes and over one mode of each complex conjugate pair.
fn shown(found: &[Mode]) -> impl Iterator<Item = &Mode> {
    found.iter().filter(|mode| mode.value.im >= 0.0)
}

/// Formats the table of eigenvalues that ADAMS prints, in cycles per unit of time.
///
/// Real eigenvalues come first, then conjugate pairs, each sorted by magnitude (grammar/NOTES.md). Natural frequencies and damping ratios
/// follow. If `vectors` is true, the mode shapes follow: magnitude and phase of the coordinates of every moving part.
fn table(found: &[Mode], names: &[String], time: f64, vectors: bool) -> String {
    let turn = std::f64::consts::TAU;
    let mut listed: Vec<&Mode> = shown(found).collect();
    let place = |mode: &Mode| match mode.value.im {
        im if im > 0.0 => (true, im),
        _ => (false, mode.value.re.abs()),
    };
    listed.sort_by(|a, b| {
        let ((pair, size), (other, least)) = (place(a), place(b));
        pair.cmp(&other).then(size.total_cmp(&least))
    });
    let mut text = format!(
        "\n{:17}E I G E N V A L U E S  at time = {}\n      Number    Real(cycles/second)      Imag.(cycles/second) \n",
        "",
        exponent(time, 5)
    );
    for (number, mode) in listed.iter().enumerate() {
        _ = write!(
            text,
            "{:>10}{:>25}",
            number + 1,
            exponent(mode.value.re / turn + 0.0, 5)
        );
        if mode.value.im > 0.0 {
            let imaginary = exponent(mode.value.im / turn, 5);
            _ = write!(text, "    +/-{imaginary:>19}");
        }
        text.push('\n');
    }
    text += "\n\n  FREQUENCY UNITS: cycles per unit of time\n\n  MODE     UNDAMPED NATURAL   DAMPING\n  NUMBER   FREQUENCY          RATIO\n";
    for (number, mode) in listed.iter().enumerate() {
        _ = writeln!(
            text,
            "  {:<8} {:>16}   {:>13}",
            number + 1,
            exponent(mode.frequency(), 8),
            exponent(mode.damping_ratio() + 0.0, 6)
        );
    }
    if !vectors {
        return text;
    }
    for (number, mode) in listed.iter().enumerate() {
        _ = writeln!(
            text,
            "\n  MODE SHAPE {}: size and phase (degrees), rotations in radians\n",
            number + 1
        );
        for (part, shape) in mode.shape.iter().enumerate() {
            let moves = shape.iter().any(|x| x.norm() > 1e-9);
            if !moves {
                continue;
            }
            _ = writeln!(text, "  {}", names[part]);
            for (name, x) in COORDINATES.iter().zip(shape) {
                _ = writeln!(
                    text,
                    "    {name:<4} {:>14} {:>9.3}",
                    exponent(x.norm(), 6),
                    x.arg().to_degrees()
                );
            }
        }
    }
    text
}

fn to_json(found: &[Mode], names: &[String], time: f64) -> String {
    let all: Vec<serde_json::Value> = shown(found)
        .map(|mode| {
            let shape: Vec<serde_json::Value> = mode
                .shape
                .iter()
                .zip(names)
                .filter(|(shape, _)| shape.iter().any(|x| x.norm() > 1e-9))
                .map(|(shape, name)| {
                    let re: Vec<f64> = shape.iter().map(|x| x.re).collect();
                    let im: Vec<f64> = shape.iter().map(|x| x.im).collect();
                    json!({"part": name, "real": re, "imaginary": im})
                })
                .collect();
            json!({
                "real": mode.value.re,
                "imaginary": mode.value.im,
                "frequency": mode.frequency(),
                "damping_ratio": mode.damping_ratio(),
                "shape": shape,
            })
        })
        .collect();
    let value = json!({"time": time, "modes": all});
    serde_json::to_string_pretty(&value).expect("JSON values print") + "\n"
}
