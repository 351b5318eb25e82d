//! LINEAR/EIGENSOL: eigenvalues and mode shapes where the model stands.

use std::fmt::Write as _;

use serde_json::json;

use super::loaded::Compiled;
use super::message::exponent;
use super::run::{Flow, Locate, Place, Session};
use crate::diagnostic::{Code, Diagnostic};
use crate::motion::{Mode, modes};
use crate::syntax::Statement;

/// What the six numbers of a part are called.
const COORDINATES: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];

impl Session<'_> {
    /// Executes a LINEAR command.
    pub(super) fn linear(&mut self, command: &Statement, place: Option<Place<'_>>) -> Flow {
        if !command.has("EIGENSOL") {
            let refusal = Diagnostic::error(
                Code::CommandNotSupported,
                "of LINEAR only EIGENSOL is executed here; this command is left out",
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
        let mut errors = self.model().compiled().value.errors.clone();
        errors.retain(|error| error.code != Code::NotSolvedInStatics);
        if !errors.is_empty() {
            for diagnostic in &errors {
                self.complain(diagnostic);
            }
            let refusal = Diagnostic::error(
                Code::NotSolvedNatively,
                "this command is not executed: its answer would leave out what is named above",
            );
            return self.refused(refusal, Some(place));
        }
        if let Some(flow) = self.refuse_motion(place) {
            return flow;
        }
        if !self.model().stands()
            && let Err(error) = self.model().begin(1e-3, false)
        {
            self.motion_failed(&error, place);
            return self.simulation_failed();
        }
        let Compiled {
            system,
            parameters,
            state,
            ..
        } = self.model().compiled().value;
        let time = state.time;
        let found = modes(system, parameters, state, !command.has("NODAMPIN"));
        let found = match found {
            Ok(found) => found,
            Err(reason) => {
                let diagnostic = Diagnostic::error(
                    Code::NoMotion,
                    format!("the equations are not linearised at time {time}: {reason}"),
                );
                self.complain(&Some(place).label(diagnostic));
                return self.simulation_failed();
            }
        };
        let names: Vec<String> = self
            .model()
            .model
            .parts
            .iter()
            .map(|part| part.header.name.clone())
            .collect();
        let text = table(&found, &names, time, !command.has("NOVECTOR"));
        self.messages.say(&text);
        let written = to_json(&found, &names, time);
        match self.model().outputs.write_beside("modes.json", &written) {
            Ok(()) => Ok(()),
            Err(diagnostic) => self.unwritable(&diagnostic),
        }
    }
}

/// One of a pair, or a real eigenvalue.
fn shown(found: &[Mode]) -> impl Iterator<Item = &Mode> {
    found.iter().filter(|mode| mode.value.im >= 0.0)
}

/// Eigenvalues in cycles per time unit, then the shapes: size and phase of every coordinate that takes part.
fn table(found: &[Mode], names: &[String], time: f64, vectors: bool) -> String {
    let turn = std::f64::consts::TAU;
    let mut text = format!(
        "\n\n  E I G E N   V A L U E S   (time = {})\n\n  FREQUENCY UNITS: cycles per unit of time\n\n  MODE     UNDAMPED NATURAL   DAMPING\n  NUMBER   FREQUENCY          RATIO           REAL               IMAGINARY\n",
        exponent(time, 5)
    );
    for (number, mode) in shown(found).enumerate() {
        let sign = if mode.value.im > 0.0 { "+/-" } else { "   " };
        _ = writeln!(
            text,
            "  {:<8} {:>16}   {:>13}   {:>16}   {sign} {:>14}",
            number + 1,
            exponent(mode.frequency(), 8),
            exponent(mode.damping_ratio() + 0.0, 6),
            exponent(mode.value.re / turn + 0.0, 8),
            exponent(mode.value.im / turn, 8)
        );
    }
    if !vectors {
        return text;
    }
    for (number, mode) in shown(found).enumerate() {
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
