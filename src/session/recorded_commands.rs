//! Extraction of the commands recorded in a message file, as a command file.
//!
//! A run that another program controlled, as in a co-simulation, can then be repeated without that program.

use admire_results::{Analysis, MessageFile};
use admire_syntax::text::{Source, Span};

/// A command file that repeats a recorded run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RecordedCommands {
    /// Text of the command file.
    pub text: String,
    /// Number of simulations in the command file, including LINEAR but not initial-conditions analyses.
    pub simulations: usize,
    /// Number of SIMULATE commands that the message file does not echo. They are rebuilt from its reports of the simulations.
    pub rebuilt: usize,
}

/// Extracts the commands in a message file (`.msg`), in their order; `None` if it records no commands.
///
/// A line ` command: ...` contains one line of commands, and continuation with `&` is preserved. `FILE/COMMAND=...` is omitted, because the
/// lines of that file follow. If no FILE/MODEL is recorded, as in co-simulations, a command that reads `model` is put first.
///
/// In a co-simulation, the simulations between two exchanges of data are not echoed. Each of them appears as a block `Begin Simulation`
/// without a command before it. The rebuilt SIMULATE command ends at the last time in the table of this block; the number of its steps is
/// one less than the number of rows.
///
/// If an input was set several times (predictor, corrector), the last value applies.
pub fn recorded_commands(messages: &Source, model: &str) -> Option<RecordedCommands> {
    let text = messages.text(Span::new(0, messages.bytes().len()));
    let analyses = MessageFile::parse(messages).analyses;
    let mut analyses = analyses.iter().peekable();
    let mut out = Vec::new();
    let (mut echoed, mut rebuilt) = (0, 0);
    // Number of simulations in the last command line whose reports have not been read yet.
    let (mut waiting, mut continues) = (0, false);
    let mut now = f64::NEG_INFINITY;
    for (at, line) in text.lines().enumerate() {
        if let Some(analysis) = analyses.next_if(|analysis| analysis.line == at + 1) {
            let Some(command) = simulate(analysis, now) else {
                continue;
            };
            now = analysis.times.map_or(now, |(_, end)| end);
            if waiting > 0 {
                waiting -= 1;
            } else {
                rebuilt += 1;
                out.push(command);
            }
            continue;
        }
        let Some(command) = line.trim_start().strip_prefix("command:").map(str::trim) else {
            continue;
        };
        if !std::mem::replace(&mut continues, command.ends_with('&')) {
            waiting = 0;
        }
        if is_command_file(command) || command.is_empty() {
            continue;
        }
        let simulations = command.split(';').filter(|part| simulates(part)).count();
        let others = command.split(';').filter(|part| is(part, "lin")).count();
        waiting += simulations;
        echoed += simulations + others;
        out.push(command.to_string());
    }
    if out.iter().all(|line| line.starts_with('!')) {
        return None;
    }
    // The first line of a command file names a dataset, unless the line is empty.
    let mut text = String::from("\n");
    if !out.iter().any(|line| compact(line).starts_with("file/mod")) {
        text.push_str(&format!("file/model={model}\n"));
    }
    for line in &out {
        text.push_str(line);
        text.push('\n');
    }
    if !out.last().is_some_and(|line| is(line, "stop")) {
        text.push_str("stop\n");
    }
    Some(RecordedCommands {
        text,
        simulations: echoed + rebuilt,
        rebuilt,
    })
}

/// Returns the command that repeats a simulation.
///
/// Returns `None` for an initial-conditions analysis, because the next simulation includes it. Returns `None` for a simulation whose
/// printed end time is not later than `now`.
fn simulate(analysis: &Analysis, now: f64) -> Option<String> {
    let word = match analysis.kind.to_ascii_lowercase().as_str() {
        "static" if analysis.times.is_none() => return Some("simulate/static".to_string()),
        "static" | "quasi-static" => "static",
        "dynamic" => "dynamic",
        "kinematic" => "kinematic",
        _ => return None,
    };
    let (start, end) = analysis.times?;
    let steps = analysis.steps.saturating_sub(1).max(1);
    (end > start.max(now)).then(|| format!("simulate/{word}, end={end}, steps={steps}"))
}

/// Converts a line to lower case and removes all blanks.
fn compact(line: &str) -> String {
    line.to_ascii_lowercase().replace(' ', "")
}

fn is(command: &str, keyword: &str) -> bool {
    compact(command).starts_with(keyword)
}

fn is_command_file(command: &str) -> bool {
    is(command, "file/com")
}

/// Returns true for SIMULATE commands other than initial-conditions analyses.
fn simulates(command: &str) -> bool {
    let command = compact(command);
    let of_initial = command
        .split_once('/')
        .is_some_and(|(_, rest)| rest.starts_with("ini"));
    command.starts_with("sim") && !of_initial
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(messages: &str, model: &str) -> Option<RecordedCommands> {
        recorded_commands(&Source::new("a.msg", messages.as_bytes()), model)
    }

    /// Returns a block of a message file in the form that ADAMS 2014 writes.
    fn block(start: &str, end: &str) -> String {
        format!(
            "\n\n  Begin Simulation\n\n  ****** Performing Dynamic Simulation using Gstiff I3 Integrator ******\n   The integrator is GSTIFF\n\n   \
             Simulation      Step        Function    Cumulative   Integration     CPU\n   ___________  ___________\n   \
             {start}  2.50000E-04            0            0       1            2.33 \n   {end}  2.12500E-03            5            5       2            2.33 \n\n  End Simulation\n"
        )
    }

    #[test]
    fn a_co_simulation_becomes_a_command_file() {
        let messages = [
            "\n command: simulate/initial_conditions\n\n  Begin Displacement Initial Conditions\n\n  End Displacement Initial Conditions\n",
            " command: var/11, fun=1.5\n command: var/11, fun=1.6\n",
            &block("0.00000E+00", "5.00000E-03"),
            " command: var/11, fun=1.7\n",
            &block("5.00000E-03", "1.00000E-02"),
        ];
        let found = recorded(&messages.concat(), "plant").unwrap();
        assert_eq!(
            found.text,
            "\nfile/model=plant\nsimulate/initial_conditions\nvar/11, fun=1.5\nvar/11, fun=1.6\n\
             simulate/dynamic, end=0.005, steps=1\nvar/11, fun=1.7\nsimulate/dynamic, end=0.01, steps=1\nstop\n"
        );
        assert_eq!((found.simulations, found.rebuilt), (2, 2));
    }

    #[test]
    fn what_is_echoed_is_not_rebuilt() {
        let messages = [
            " command: file/model=a\n command: sim/dyn, &\n command: , end=0.01, steps=2\n",
            &block("0.00000E+00", "1.00000E-02"),
            &block("1.00000E-02", "2.00000E-02"),
            " command: sim/stat; sim/stat\n\n  Begin Static Solution\n\n  End Static Solution\n\n  Begin Static Solution\n\n  End Static Solution\n",
            "\n  Begin Static Solution\n\n  End Static Solution\n",
        ];
        let found = recorded(&messages.concat(), "a").unwrap();
        assert_eq!(
            found.text,
            "\nfile/model=a\nsim/dyn, &\n, end=0.01, steps=2\nsimulate/dynamic, end=0.02, steps=1\nsim/stat; sim/stat\nsimulate/static\nstop\n"
        );
        assert_eq!((found.simulations, found.rebuilt), (5, 2));
    }

    #[test]
    fn a_command_file_comes_back() {
        let messages = " command: FILE/COMMAND=a.acf\n command: \n command: file/model=a\n command: ! note\n command: INTEGRATOR/ &\n \
                        command: , HHT\n command: sim/stat\n command: STOP\nFinished -----\n";
        let found = recorded(messages, "b").unwrap();
        assert_eq!(
            found.text,
            "\nfile/model=a\n! note\nINTEGRATOR/ &\n, HHT\nsim/stat\nSTOP\n"
        );
        assert_eq!(found.simulations, 1);
        assert_eq!(recorded("nothing\n command: \n", "b"), None);
        // An initial-conditions analysis alone is not counted as a simulation.
        let alone = recorded(" command: simulate/initial_conditions\n", "b").unwrap();
        assert_eq!(alone.simulations, 0);
    }
}
