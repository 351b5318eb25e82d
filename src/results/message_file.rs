use serde::Serialize;

use admire_syntax::text::{Source, Span};

/// Content of a message file `.msg`, which contains the messages of a run of ADAMS or of this program.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct MessageFile {
    /// Name and version of the solver, for example `Adams 2019.2, C++`, as given by the banner; empty if there is no banner.
    pub solver: String,
    /// Titles of the models, in the order in which they were read.
    pub titles: Vec<String>,
    /// Number of commands echoed as `command:` lines.
    pub commands: usize,
    /// Simulations and static solutions, in the order of the run.
    pub analyses: Vec<Analysis>,
    /// Framed error messages and warnings, in the order of the run.
    pub frames: Vec<Frame>,
    /// Names of the redundant constraint equations; each name occurs once.
    pub redundant: Vec<String>,
    /// Elapsed time of the whole run, in seconds.
    pub elapsed: Option<f64>,
    /// Processor time of the whole run, in seconds.
    pub cpu: Option<f64>,
    /// True if the run ended normally. The file then contains the line `Finished`; scripts that poll the file wait for this line.
    pub finished: bool,
}

/// One simulation or static solution.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Analysis {
    /// Kind of the analysis: `Static`, `Dynamic`, `Quasi-static` or `Displacement Initial Conditions`.
    pub kind: String,
    /// Number (from 1) of the line at which the analysis begins.
    pub line: usize,
    /// Number of iterations, for a static solution that is not part of a simulation.
    pub iterations: Option<usize>,
    /// Times of the first and of the last step in the listed table of steps.
    pub times: Option<(f64, f64)>,
    /// Number of steps in the listed table of steps.
    pub steps: usize,
    /// True if the file reports the end of the analysis.
    pub ended: bool,
}

/// A message framed by a `START` line and an `END` line.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Frame {
    /// Kind of the message: `ERROR` or `WARNING`.
    pub kind: String,
    /// Number (from 1) of the line at which the text of the message begins.
    pub line: usize,
    /// Text of the message.
    pub text: String,
}

impl MessageFile {
    /// Returns true if the text begins as a message file does: with the banner or with a command.
    pub fn is_one(source: &Source) -> bool {
        let head = source.text(Span::new(0, source.bytes().len().min(4000)));
        let lines = || head.lines().map(str::trim_start);
        lines().any(|line| line.starts_with("command:"))
            || lines().take(4).any(|line| line.starts_with("-----"))
                && lines().any(|line| line.starts_with('|'))
    }

    /// Reads a message file; lines that are not recognised are ignored.
    pub fn parse(source: &Source) -> Self {
        let text = source.text(Span::new(0, source.bytes().len()));
        let mut file = Self::default();
        let mut frame: Option<Frame> = None;
        let mut after_title = 0;
        let mut in_redundant = false;
        for (number, line) in text.lines().enumerate() {
            let (number, trimmed) = (number + 1, line.trim());
            if let Some(open) = &mut frame {
                if trimmed.starts_with("---- END:") {
                    open.text.truncate(open.text.trim_end().len());
                    file.frames.extend(frame.take());
                } else {
                    open.text.push_str(line.trim_end());
                    open.text.push('\n');
                }
                continue;
            }
            if let Some(kind) = trimmed.strip_prefix("---- START:") {
                frame = Some(Frame {
                    kind: kind.trim_end_matches(['-', ' ']).trim().to_string(),
                    line: number + 1,
                    text: String::new(),
                });
                continue;
            }
            if trimmed.starts_with("command:") {
                file.commands += 1;
                in_redundant = false;
                continue;
            }
            file.banner(trimmed, &mut after_title);
            let equation = trimmed
                .strip_prefix('-')
                .map_or("", |rest| {
                    rest.trim_start()
                        .trim_start_matches("deactivating constraint equation")
                })
                .trim();
            if trimmed.contains("redundant constraints") && trimmed.ends_with(':') {
                in_redundant = true;
            } else if in_redundant && trimmed.is_empty() {
                in_redundant = false;
            } else if in_redundant
                && !equation.trim_start_matches('-').is_empty()
                && !file.redundant.iter().any(|known| known == equation)
            {
                file.redundant.push(equation.to_string());
            }
            file.analysis(trimmed, number);
            file.last_lines(trimmed);
        }
        file
    }

    /// Reads the version of the solver from a line of the banner, or the title of a model from a line of the box that shows it.
    ///
    /// The title is the first line after "Model Title" that is neither empty nor a rule of `=`.
    fn banner(&mut self, line: &str, after_title: &mut usize) {
        let inner = line.trim_matches('|').trim();
        if inner.ends_with("Model Title") || inner == "Model Title" {
            *after_title = 1;
        } else if *after_title > 0 && line.starts_with('|') {
            if !inner.is_empty() && !inner.starts_with('=') {
                self.titles.push(inner.to_string());
                *after_title = 0;
            }
        } else if *after_title > 0 && line.starts_with("--") {
            *after_title = 0;
        }
        if !line.starts_with('|') {
            return;
        }
        let mut add = |text: &str| {
            if !self.solver.is_empty() {
                self.solver.push_str(", ");
            }
            self.solver.push_str(text);
        };
        if let Some((_, version)) = inner.split_once("Version:") {
            add(version.trim());
        } else if inner.contains("A d a m s   C++   S o l v e r") && !inner.contains("form") {
            add("C++ solver");
        } else if inner.contains("A d a m s   F O R T R A N")
            || inner.contains("F O R T R A N   S o l v e r")
        {
            add("FORTRAN solver");
        } else if inner.starts_with("admire ") {
            add(inner);
        }
    }

    fn analysis(&mut self, line: &str, number: usize) {
        if let Some(kind) = line.strip_prefix("Begin ") {
            let kind = match kind {
                "Static Solution" => "Static",
                "Simulation" => "",
                other => other,
            };
            self.analyses.push(Analysis {
                kind: kind.to_string(),
                line: number,
                iterations: None,
                times: None,
                steps: 0,
                ended: false,
            });
            return;
        }
        let Some(last) = self.analyses.last_mut().filter(|last| !last.ended) else {
            return;
        };
        if line.starts_with("End ") {
            last.ended = true;
        } else if let Some((_, what)) = line.split_once("****** Performing ") {
            let kind = what.split(" Simulation").next().unwrap_or(what);
            last.kind = kind.to_string();
        } else if let Some((_, count)) = line.split_once("converged in ") {
            last.iterations = count
                .split_whitespace()
                .next()
                .and_then(|word| word.parse().ok());
        } else if let Some(time) = step_time(line) {
            last.steps += 1;
            last.times = Some((last.times.map_or(time, |(first, _)| first), time));
        }
    }

    fn last_lines(&mut self, line: &str) {
        if line.starts_with("Finished") {
            self.finished = true;
        }
        let seconds = |word: &str| {
            let (_, rest) = line.split_once(word)?;
            rest.trim_start()
                .trim_start_matches('=')
                .trim()
                .split('s')
                .next()?
                .trim()
                .parse()
                .ok()
        };
        if line.starts_with("Elapsed time") {
            self.elapsed = seconds("Elapsed time");
            self.cpu = seconds("CPU time");
        }
    }
}

/// Returns the time at the start of a line, if the line belongs to a table of steps.
///
/// Such a line has at least three numbers, of which the first has an exponent.
fn step_time(line: &str) -> Option<f64> {
    let mut words = line.split_whitespace();
    let first = words.next().filter(|word| word.contains(['E', 'e']))?;
    let rest: Vec<&str> = words.collect();
    // The last word is an elapsed time, which is written as `1:05` once it exceeds one minute.
    let digits = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    let numbers = rest
        .iter()
        .all(|word| word.parse::<f64>().is_ok() || word.split(':').all(digits));
    (rest.len() >= 2 && numbers)
        .then(|| first.parse().ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_in_a_few_numbers() {
        let text = "\n-----\n|   A d a m s   C++   S o l v e r   |\n|  Version: Adams 2019.2  |\n-----\n command: file/model=a\n---\n|   Model Title  |\n\
                    |====|\n|    |\n|  the car  |\n|    |\n---\n---- START: WARNING ----\nfirst\n second\n---- END: WARNING ----\n  Begin Static Solution\n\
                    \n  Static Solution converged in 41 iterations\n  End Static Solution\n  Begin Simulation\n\n  ****** Performing Dynamic Simulation using HHT I3 Integrator ******\n\
                    Degree-of-freedom analysis identified redundant constraints in the model:\n  ------\n   -  deactivating constraint equation  Zi.Xj in model.JOINT_1\n\n   0.00000E+00  1.0E-02  3  4\n   2.50000E-01  1.0E-02  3  4\n  End Simulation\n\
                    Finished -----\nElapsed time = 1.18s,  CPU time = 0.89s,  75.30%\n";
        let source = Source::new("a.msg", text.as_bytes());
        assert!(MessageFile::is_one(&source));
        let file = MessageFile::parse(&source);
        assert_eq!(file.solver, "C++ solver, Adams 2019.2");
        assert_eq!(file.titles, ["the car"]);
        assert_eq!(file.frames.len(), 1);
        assert_eq!(
            (file.frames[0].text.as_str(), file.frames[0].line),
            ("first\n second", 15)
        );
        assert_eq!(file.analyses[0].iterations, Some(41));
        assert_eq!(file.analyses[1].kind, "Dynamic");
        assert_eq!(
            (file.analyses[1].steps, file.analyses[1].times),
            (2, Some((0.0, 0.25)))
        );
        assert_eq!(file.redundant, ["Zi.Xj in model.JOINT_1"]);
        assert_eq!(
            (file.elapsed, file.cpu, file.finished),
            (Some(1.18), Some(0.89), true)
        );
    }
}
