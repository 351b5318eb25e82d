use std::fmt::Write as _;
use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

use admire_session::check::is_command_file;
use admire_solver::mechanics::psi_theta_phi;
use admire_solver::model::{Ignore, Model, PartIx, PartKind};
use admire_solver::statics::{
    Continuation, Report, Softest, SolveError, Solver, StabilisedEquilibrium, StaticSettings,
    history_table,
};
use admire_solver::system::{Scratch, State, System};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;

use super::Outcome;
use super::counted::counted;
use super::format::Format;
use super::input::{Solvable, solvable};
use super::shell::{Exit, Shell};
use super::solve_run::{self, Taken};
use super::width::table_text;

/// Find the static equilibrium of a dataset, or execute a command file.
///
/// For a dataset, the result is printed: the positions of the parts, and the forces of the bushings. A command file is executed as `mdi`
/// does, in the working directory, with the exit codes of `admire`. On a terminal, progress is shown. After Ctrl-C, the files contain
/// everything up to the last output.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire solve front.adm\n  admire solve run.acf")]
pub(super) struct Arguments {
    /// Dataset (.adm) or command file (.acf).
    file: PathBuf,
    /// Command file to execute on the dataset, whichever model the command file names.
    commands: Option<PathBuf>,
    /// TIME at which the equilibrium is solved.
    #[arg(long, default_value_t = 0.0)]
    time: f64,
    /// Also list every force on a part: `PART/4` or its name.
    #[arg(long, value_name = "PART")]
    free_body: Vec<String>,
    /// Further folders in which a command file may read and write; its own folder and the working directory are always allowed.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    /// Continue from an unstable equilibrium to a stable one: both directions along the unstable motion are followed, and the nearer
    /// equilibrium is taken.
    #[arg(long)]
    stable: bool,
    /// Leave out statements that the built-in solver cannot solve, such as CONTACT or FRICTION/3. Without this option, the dataset is refused.
    #[arg(long, value_name = "STATEMENTS", value_parser = ignored)]
    ignore: Vec<Ignored>,
    #[command(flatten)]
    taken: Taken,
}

/// Statements named by one `--ignore` option.
#[derive(Clone, Debug)]
struct Ignored(Vec<Ignore>);

fn ignored(list: &str) -> Result<Ignored, String> {
    Ignore::parse(list).map(Ignored)
}

/// Solves the equilibrium and prints the result, or executes the command file.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let ignored: Vec<Ignore> = arguments.ignore.iter().flat_map(|i| i.0.clone()).collect();
    let conflict = |shell: &Shell, message: &str| {
        shell.complain(&[Diagnostic::error(Code::ConflictingArguments, message)]);
        Err(Exit::Usage)
    };
    let files = match &arguments.commands {
        None if is_command_file(&arguments.file) => Some((None, arguments.file.as_path())),
        None => None,
        Some(_) if is_command_file(&arguments.file) => {
            return conflict(
                shell,
                "two command files are named: name a dataset first, and the command file second",
            );
        }
        Some(commands) => Some((Some(arguments.file.as_path()), commands.as_path())),
    };
    if let Some((deck, commands)) = files {
        if arguments.stable {
            return conflict(
                shell,
                "--stable applies only to a dataset, because a command file is executed exactly as by `mdi`",
            );
        }
        let allowed = arguments.allow_path.as_slice();
        return solve_run::run(deck, commands, allowed, ignored, &arguments.taken, shell);
    }
    if arguments.taken.is_asked() {
        return conflict(
            shell,
            "--csv and --plot apply only to a command file, because a dataset alone gives no results file",
        );
    }
    let Solvable {
        model,
        system,
        left_out,
        ..
    } = solvable(&arguments.file, &ignored, shell)?;
    let mut bodies = Vec::new();
    for text in &arguments.free_body {
        bodies.push(part(text, &model, shell)?);
    }
    let mut state = system.state();
    state.time = arguments.time;
    let settings = StaticSettings::from(system.settings());
    shell.complain(StaticSettings::limited(system.settings()).as_slice());
    let parameters = system.parameters();
    let mut solver = Solver::new(&system);
    match solver.solve(&system, &parameters, &mut state, &settings) {
        Ok(mut report) => {
            let far: Vec<String> = report
                .far
                .iter()
                .map(|f| f.described(&model.units))
                .collect();
            for part in &far {
                shell.complain(&[went_far(part)]);
            }
            let softest = Softest::at_equilibrium(&system, &parameters, &state, solver.scratch());
            let mut softest = softest.ok().flatten();
            let unstable = softest.clone().filter(Softest::is_unstable);
            // The motion is described at the unstable state, because the description names markers at their positions there.
            let motion = unstable
                .as_ref()
                .and_then(|softest| softest.described(&system, &parameters, &state));
            let mut settled = None;
            if let Some(unstable) = unstable {
                if arguments.stable {
                    match solver.settle(&system, &parameters, &mut state, &settings, &unstable) {
                        Ok(found) => {
                            (report, softest) = (found.report.clone(), found.softest.clone());
                            settled = Some(found);
                        }
                        Err(error) => {
                            let diagnostic =
                                Diagnostic::error(Code::NoEquilibrium, error.to_string());
                            shell.complain(&[diagnostic.help(moves(motion.as_deref()))]);
                            return Err(Exit::NoAnswer);
                        }
                    }
                } else {
                    shell.complain(&[does_not_last(motion.as_deref())]);
                }
            }
            let answer = Answer {
                model: &model,
                system: &system,
                state: &state,
                report: &report,
                softest: softest.as_ref(),
                motion: motion.as_deref(),
                settled: settled.as_ref(),
                far: &far,
                bodies: &bodies,
                left_out: &left_out,
            };
            shell.print(&match shell.format {
                Format::Json => answer.json(),
                _ => answer.text(),
            });
            Ok(Exit::Fine)
        }
        Err(error) => {
            shell.complain(&[no_equilibrium(&error)]);
            Err(Exit::NoAnswer)
        }
    }
}

/// Creates the warning that a part moved far.
fn went_far(part: &str) -> Diagnostic {
    Diagnostic::warning(Code::LargeMotion, format!("in this static solution, {part}"))
        .help("check that this is the intended equilibrium; to reach the nearest one, apply the loads in steps")
}

/// Creates the warning that an equilibrium is unstable.
fn does_not_last(motion: Option<&str>) -> Diagnostic {
    Diagnostic::warning(
        Code::UnstableEquilibrium,
        format!("this equilibrium is UNSTABLE: {}", moves(motion)),
    )
    .help("--stable searches for a stable equilibrium from here")
}

fn moves(motion: Option<&str>) -> String {
    format!(
        "after the slightest disturbance {}",
        motion.unwrap_or("the parts move away from it")
    )
}

fn no_equilibrium(error: &SolveError) -> Diagnostic {
    let diagnostic = Diagnostic::error(Code::NoEquilibrium, error.to_string());
    let SolveError::NotConverged {
        causes, history, ..
    } = error
    else {
        return diagnostic;
    };
    let mut lines = causes.clone();
    lines.extend(history_table(history));
    diagnostic.help(lines.join("\n"))
}

/// Finds the part with an address such as `PART/4`, or with a name.
fn part(text: &str, model: &Model, shell: &Shell) -> Result<PartIx, Exit> {
    let wanted = text.to_ascii_uppercase();
    let found = model.parts.iter().position(|part| {
        let kind = match part.kind {
            PartKind::PointMass => "POINT_MASS",
            _ => "PART",
        };
        part.header.name == text || format!("{kind}/{}", part.header.id) == wanted
    });
    found.map(PartIx).ok_or_else(|| {
        let message = format!("`{text}` is not a part of this dataset");
        shell.complain(&[Diagnostic::error(Code::UndefinedId, message)]);
        Exit::Findings
    })
}

struct Answer<'a> {
    model: &'a Model,
    system: &'a System,
    state: &'a State,
    report: &'a Report,
    /// Motion with the smallest stiffness, which is in force per length.
    softest: Option<&'a Softest>,
    /// Description of the motion of negative stiffness at the first equilibrium.
    motion: Option<&'a str>,
    /// Stable equilibrium that replaced an unstable one.
    settled: Option<&'a StabilisedEquilibrium>,
    /// Names of the parts that moved far.
    far: &'a [String],
    /// Parts whose loads are listed.
    bodies: &'a [PartIx],
    /// Diagnostics of the statements that were left out because the user requested it.
    left_out: &'a [Diagnostic],
}

impl Answer<'_> {
    /// Returns the name of every moving part, with its position and its 3-1-3 angles in degrees.
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

    /// Returns the name of every bushing and FIELD, with its deflection and with the force and torque on I, in J axes.
    fn bushings(&self) -> Vec<(&str, [f64; 9])> {
        let parameters = self.system.parameters();
        let mut scratch = Scratch::new(self.system);
        let mut out = Vec::new();
        let Ok(mut here) = self.system.evaluate(&parameters, self.state, &mut scratch) else {
            return out;
        };
        for bushing in self.model.elastic_pairs() {
            let Some(element) = self.system.element(bushing.kind, bushing.header.id) else {
                continue;
            };
            if let Ok(reading) = here.read_element(element) {
                let (d, w) = (reading.motion.p_ij_j, reading.wrench_j);
                let all = [d.x, d.y, d.z, w[0], w[1], w[2], w[3], w[4], w[5]];
                out.push((bushing.header.name.as_str(), all));
            }
        }
        out
    }

    /// Returns the loads on a part, each as its source, its force (ground axes) and its torque about the part origin. The sum of all loads
    /// comes last.
    fn loads(&self, part: PartIx) -> Vec<(String, [f64; 6])> {
        let parameters = self.system.parameters();
        let mut scratch = Scratch::new(self.system);
        let looked = self.system.evaluate(&parameters, self.state, &mut scratch);
        let loads = looked.and_then(|mut here| here.loads());
        let origin = self.state.poses[part.0].p;
        let mut out = Vec::new();
        let mut sum = [0.0; 6];
        for load in loads.unwrap_or_default() {
            if load.part != part {
                continue;
            }
            let (F, T) = (load.force, load.torque_about(&origin));
            let all = [F.x, F.y, F.z, T.x, T.y, T.z];
            for (sum, value) in sum.iter_mut().zip(all) {
                *sum += value;
            }
            let by = load.by.map_or_else(|| "weight".into(), ToString::to_string);
            out.push((by, all));
        }
        out.push(("sum".into(), sum));
        out
    }

    /// Describes the stability of the equilibrium by the smallest eigenvalue of the tangent stiffness.
    fn stability(&self) -> Option<String> {
        let units = &self.model.units;
        let Softest {
            stiffness, error, ..
        } = *self.softest?;
        let word = match self.verdict()? {
            "unstable" => "UNSTABLE",
            word => word,
        };
        let mut out = format!(
            "{word}: smallest stiffness {stiffness:.4e} {}/{}",
            units.name(Dimension::FORCE),
            units.name(Dimension::LENGTH)
        );
        if word == "neutral" && stiffness != 0.0 {
            _ = write!(out, " with an error of up to {error:.1e}");
        }
        if let (Some(motion), "UNSTABLE") = (self.motion, word) {
            _ = write!(out, "; {}", moves(Some(motion)));
        }
        Some(out)
    }

    fn verdict(&self) -> Option<&'static str> {
        Some(match self.softest? {
            softest if softest.is_unstable() => "unstable",
            softest if softest.is_neutral() => "neutral",
            _ => "stable",
        })
    }

    /// Describes how the solver left an unstable equilibrium.
    fn left(&self) -> Option<String> {
        let settled = self.settled?;
        let length = self.model.units.name(Dimension::LENGTH);
        let other = match settled.other {
            Some(moved) => {
                format!("the equilibrium in the other direction is {moved:.4} {length} away")
            }
            None => "no equilibrium was found in the other direction".to_string(),
        };
        Some(format!(
            "the first equilibrium was unstable: {}\nthe stable equilibrium is {:.4} {length} away from it; {other}",
            moves(self.motion),
            settled.moved
        ))
    }

    /// Describes the imbalance that remains when forces and torques are summed independently of the solver.
    fn left_over(&self) -> Option<String> {
        let told = self.report.balance.describe(&self.model.units);
        (!told.is_empty()).then(|| {
            format!("largest imbalance in the recomputed sums of forces and torques: {told}")
        })
    }

    /// Describes the continuation method that was used; `None` if plain iteration converged.
    fn help_needed(&self) -> Option<String> {
        Some(match self.report.continuation? {
            Continuation::Damped => {
                "equilibrium reached with damping that was gradually reduced".to_string()
            }
            Continuation::Load { steps } => {
                format!(
                    "equilibrium reached by removing the initial imbalance in {}",
                    counted(steps, "step")
                )
            }
        })
    }

    fn text(&self) -> String {
        let units = &self.model.units;
        let (length, force) = (units.name(Dimension::LENGTH), units.name(Dimension::FORCE));
        let mut out = format!(
            "{}\n{}equilibrium at time {} {} after {}\nlargest residual of any equation: {:.1e} ({force}, {force}-{length} or {length})\n\n",
            self.model.title,
            if self.verdict() == Some("unstable") {
                "UNSTABLE "
            } else {
                ""
            },
            self.state.time,
            units.name(Dimension::TIME),
            counted(self.report.iterations, "iteration"),
            self.report.imbalance
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
                    &format!(
                        "bushing: deflection, force and torque on I, J axes ({length}, {force}, {force}-{length})"
                    ),
                    &["dx", "dy", "dz", "FX", "FY", "FZ", "TX", "TY", "TZ"],
                    &bushings,
                )
            );
        }
        for &part in self.bodies {
            let rows = self.loads(part);
            let rows: Vec<(&str, [f64; 6])> = rows.iter().map(|(n, v)| (n.as_str(), *v)).collect();
            let head = format!(
                "loads on {}, ground axes, torque about the part origin ({force}, {force}-{length})",
                self.system.part_name(part)
            );
            let names = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
            _ = write!(out, "\n{}", table(&head, &names, &rows));
        }
        let lines = [
            self.left_over(),
            self.help_needed(),
            self.left(),
            self.stability(),
        ];
        for line in lines.into_iter().flatten() {
            _ = write!(out, "\n{line}");
        }
        for redundant in &self.report.redundant {
            _ = write!(out, "\nredundant constraint equation, removed: {redundant}");
        }
        for free in &self.report.free_motions {
            _ = write!(
                out,
                "\n{free}: harmless, because no force drives this motion"
            );
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
            "balance": self.report.balance,
            "parts": named(parts, &[("position", 0..3), ("psi_theta_phi_deg", 3..6)]),
            "bushings": named(bushings, &[("deflection_j", 0..3), ("force_on_i_j", 3..6), ("torque_on_i_j", 6..9)]),
            "left_out": self.left_out.iter().map(|d| &d.message).collect::<Vec<_>>(),
            "redundant": self.report.redundant.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "free_motions": self.report.free_motions.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "continuation": self.help_needed(),
            "stability": self.verdict(),
            "smallest_stiffness": self.softest.map(|softest| softest.stiffness),
            "smallest_stiffness_error": self.softest.map(|softest| softest.error),
            "went_far": self.far,
            "unstable_motion": self.motion,
            "left_unstable": self.settled.map(|settled| json!({
                "moved": settled.moved,
                "other_way": settled.other,
            })),
            "free_bodies": self.bodies.iter().map(|&part| {
                let rows = self.loads(part);
                let rows = rows.iter().map(|(n, v)| (n.as_str(), v.to_vec())).collect();
                let loads = named(rows, &[("force", 0..3), ("torque", 3..6)]);
                json!({ "part": self.system.part_name(part).to_string(), "loads": loads })
            }).collect::<Vec<_>>(),
        });
        serde_json::to_string_pretty(&all).expect("JSON values print") + "\n"
    }
}

fn table<const N: usize>(first: &str, names: &[&str; N], rows: &[(&str, [f64; N])]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(std::iter::once("").chain(names.iter().copied()));
    for (name, values) in rows {
        let cells = values.iter().map(|value| format!("{value:.4}"));
        table.add_row(std::iter::once((*name).to_string()).chain(cells));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{first}\n{}", table_text(&table))
}
