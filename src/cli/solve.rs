use std::fmt::Write as _;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::mechanics::psi_theta_phi;
use crate::model::{Model, PartKind};
use crate::session::Session;
use crate::statics::{Report, Settings, SolveError, solve};
use crate::syntax::Dataset;
use crate::system::{Scratch, State, System};
use crate::units::Dimension;

use super::Outcome;
use super::check::is_command_file;
use super::shell::{Exit, Format, Shell};

/// Find the static equilibrium of a dataset, or execute a command file.
///
/// For a dataset the answer is printed: where the parts are, and what the bushings carry. A command file is executed as `mdi`
/// does, in the working directory, with the exit codes of `admire`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// A dataset (.adm) or a command file (.acf).
    file: PathBuf,
    /// TIME at which the equilibrium is sought.
    #[arg(long, default_value_t = 0.0)]
    time: f64,
}

/// Solves and prints.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if is_command_file(&arguments.file) {
        let console = Box::new(BufWriter::new(std::io::stdout().lock()));
        let session = Session::new(console, Path::new(""));
        let ending = session.run_file(&arguments.file.to_string_lossy());
        return Ok(Exit::of_code(ending.exit_code(true)));
    }
    let source = shell.read(&arguments.file)?;
    let parsed = Dataset::parse(source);
    let files = shell.read_files(&parsed.value);
    let lowered = Model::lower_with(&parsed.value, &files.value);
    let compiled = System::compile(&lowered.value);
    let mut complaints = parsed.diagnostics;
    complaints.extend(files.diagnostics);
    complaints.extend(lowered.diagnostics);
    complaints.extend(compiled.diagnostics);
    shell.complain(&complaints);
    if complaints.iter().any(|d| d.severity == Severity::Error) {
        return Err(Exit::Findings);
    }
    let (model, system) = (lowered.value, compiled.value);
    let mut state = system.state();
    state.time = arguments.time;
    let settings = Settings::from(system.settings());
    match solve(&system, &system.parameters(), &mut state, &settings) {
        Ok(report) => {
            let answer = Answer {
                model: &model,
                system: &system,
                state: &state,
                report: &report,
            };
            shell.print(&match shell.format {
                Format::Json => answer.json(),
                Format::Text | Format::Plain => answer.text(),
            });
            Ok(Exit::Fine)
        }
        Err(error) => {
            shell.complain(&[no_equilibrium(&error)]);
            Err(Exit::NoAnswer)
        }
    }
}

fn no_equilibrium(error: &SolveError) -> Diagnostic {
    let diagnostic = Diagnostic::error(Code::NoEquilibrium, error.to_string());
    match error {
        SolveError::NotConverged { causes, .. } if !causes.is_empty() => {
            diagnostic.help(causes.join("\n"))
        }
        _ => diagnostic,
    }
}

struct Answer<'a> {
    model: &'a Model,
    system: &'a System,
    state: &'a State,
    report: &'a Report,
}

impl Answer<'_> {
    /// Name, position and 3-1-3 angles in degrees of every part that moves.
    fn parts(&self) -> Vec<(&str, [f64; 6])> {
        self.model
            .parts
            .iter()
            .zip(&self.state.poses)
            .filter(|(part, _)| part.kind != PartKind::Ground)
            .map(|(part, pose)| {
                let angles = psi_theta_phi(&pose.R).map(f64::to_degrees);
                let p = pose.p;
                let all = [p.x, p.y, p.z, angles[0], angles[1], angles[2]];
                (part.header.name.as_str(), all)
            })
            .collect()
    }

    /// Name of every bushing, with its deflection and the force and torque on I, in J axes.
    fn bushings(&self) -> Vec<(&str, [f64; 9])> {
        let parameters = self.system.parameters();
        let mut scratch = Scratch::new(self.system);
        let mut out = Vec::new();
        if self
            .system
            .look(&parameters, self.state, &mut scratch)
            .is_err()
        {
            return out;
        }
        for bushing in &self.model.bushings {
            let Some(element) = self.system.element("BUSHING", bushing.header.id) else {
                continue;
            };
            let reading = self
                .system
                .read_element(&parameters, self.state, &mut scratch, element);
            if let Ok(reading) = reading {
                let (d, w) = (reading.motion.p_ij_j, reading.wrench_j);
                let all = [d.x, d.y, d.z, w[0], w[1], w[2], w[3], w[4], w[5]];
                out.push((bushing.header.name.as_str(), all));
            }
        }
        out
    }

    fn text(&self) -> String {
        let units = &self.model.units;
        let (length, force) = (units.name(Dimension::LENGTH), units.name(Dimension::FORCE));
        let mut out = format!(
            "{}\nequilibrium at time {} after {} iterations, largest imbalance {:.1e}\n\n",
            self.model.title, self.state.time, self.report.iterations, self.report.imbalance
        );
        let unit = format!("({length}, deg)");
        out += &table(
            &format!("part {unit}"),
            &["X", "Y", "Z", "PSI", "THETA", "PHI"],
            &self.parts(),
        );
        let bushings = self.bushings();
        if !bushings.is_empty() {
            _ = write!(
                out,
                "\n{}",
                table(
                    &format!("bushing, J axes ({length}, {force}, {force}-{length})"),
                    &["dx", "dy", "dz", "FX", "FY", "FZ", "TX", "TY", "TZ"],
                    &bushings,
                )
            );
        }
        for redundant in &self.report.redundant {
            _ = write!(out, "\nredundant: {redundant}");
        }
        for free in &self.report.free_motions {
            _ = write!(out, "\nnothing resists: {free}");
        }
        out.trim_end().to_string() + "\n"
    }

    fn json(&self) -> String {
        let named =
            |rows: Vec<(&str, Vec<f64>)>, keys: &[(&str, std::ops::Range<usize>)]| -> Value {
                rows.iter()
                    .map(|(name, values)| {
                        let mut shown = json!({ "name": name });
                        for (key, range) in keys {
                            shown[*key] = json!(values[range.clone()]);
                        }
                        shown
                    })
                    .collect()
            };
        let parts = self.parts();
        let parts: Vec<(&str, Vec<f64>)> = parts.iter().map(|(n, v)| (*n, v.to_vec())).collect();
        let bushings = self.bushings();
        let bushings: Vec<(&str, Vec<f64>)> =
            bushings.iter().map(|(n, v)| (*n, v.to_vec())).collect();
        let all = json!({
            "title": self.model.title,
            "time": self.state.time,
            "iterations": self.report.iterations,
            "imbalance": self.report.imbalance,
            "parts": named(parts, &[("position", 0..3), ("psi_theta_phi_deg", 3..6)]),
            "bushings": named(bushings, &[("deflection_j", 0..3), ("force_on_i_j", 3..6), ("torque_on_i_j", 6..9)]),
            "redundant": self.report.redundant,
        });
        serde_json::to_string_pretty(&all).expect("JSON values print") + "\n"
    }
}

fn table<const N: usize>(first: &str, names: &[&str; N], rows: &[(&str, [f64; N])]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(std::iter::once(first).chain(names.iter().copied()));
    for (name, values) in rows {
        let cells = values.iter().map(|value| format!("{value:.4}"));
        table.add_row(std::iter::once((*name).to_string()).chain(cells));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let lines: Vec<String> = table
        .to_string()
        .lines()
        .map(|line| line.trim_end().to_string())
        .collect();
    lines.join("\n") + "\n"
}
