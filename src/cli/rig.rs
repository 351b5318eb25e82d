use std::path::PathBuf;

use admire_diagnosis::ProgressObserver as _;
use admire_rig::effect::EffectSpec;
use admire_rig::{LoadTable, RigOptions, Scatter, Tolerances, virtual_rig_watched};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::output_folder::{Replacing, output_folder, write_folder};
use super::progress::Progress;
use super::shell::{Exit, Shell};

/// Measure a study's deck on the virtual test rig, and write a complete study folder, as a rig would deliver it.
///
/// Nothing in the folder reveals the planted effects; `--truth` writes them to a separate file.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire rig my-axle --out measured --seed 3\n  admire rig my-axle --out measured --effect link-compliance@PART/6:stiffness=6000 --truth truth.txt"
)]
pub(super) struct Arguments {
    /// Folder of the study; its own readings need not exist.
    study: PathBuf,
    /// Folder to write; by default, `out-rig` in the folder of the study.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed of the measurement noise.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Standard deviation of one mark coordinate in the deck's length unit, instead of the study's value.
    #[arg(long)]
    sigma: Option<f64>,
    /// Effect to plant: `cause@address:name=value,...`. `admire guide rig` lists the effects.
    #[arg(long, value_name = "SPEC")]
    effect: Vec<String>,
    /// File of effects to plant, one per line; `#` begins a comment.
    #[arg(long, value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Standard deviation of one coordinate in the first session, which measures the marks on their parts, in the deck's length unit, instead
    /// of the study's value.
    #[arg(long, value_name = "SIGMA")]
    sigma_on_parts: Option<f64>,
    /// Additional small errors in many places, as standard deviations: `hardpoints=0.3,load_gain=0.005,pose=0.02`. The names are the keys
    /// of `[tolerances]`, and `parts`, `assembly_offset`, `bushing_axis_deg`, `preload`, `pose_deg`.
    #[arg(long, value_name = "LIST")]
    tolerances: Option<String>,
    /// Noise that differs from the noise stated in the study: `tails=3,outliers=6,outlier_size=2,declared=0.5`. `admire guide rig` describes
    /// the names.
    #[arg(long, value_name = "LIST")]
    scatter: Option<String>,
    /// Load programme instead of the study's load cases: table 1 or 2 of the paper, or each load increased and decreased in turn.
    #[arg(long, value_enum)]
    programme: Option<Programme>,
    /// File in which the planted effects are written.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    replacing: Replacing,
}

/// Built-in load programmes.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum Programme {
    #[value(name = "table-1")]
    Table1,
    #[value(name = "table-2")]
    Table2,
    UpAndDown,
}

impl From<Programme> for LoadTable {
    fn from(programme: Programme) -> Self {
        match programme {
            Programme::Table1 => Self::Table1,
            Programme::Table2 => Self::Table2,
            Programme::UpAndDown => Self::UpAndDown,
        }
    }
}

/// Runs the virtual measurement and writes the study folder.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut effects = Vec::new();
    for file in &arguments.effects {
        let source = shell.read(file)?;
        let text = source.utf8().map_err(|_| {
            let message = format!("`{}` is not UTF-8 text", file.display());
            shell.fail(Diagnostic::error(Code::CannotRead, message))
        })?;
        effects.extend(EffectSpec::parse_list(text).map_err(|why| shell.fail(why))?);
    }
    for text in &arguments.effect {
        effects.push(EffectSpec::parse(text).map_err(|why| shell.usage(why))?);
    }
    let tolerances = arguments.tolerances.as_deref().map(Tolerances::parse);
    let tolerances = tolerances.transpose().map_err(|why| shell.usage(why))?;
    let scatter = arguments.scatter.as_deref().map(Scatter::parse);
    let scatter = scatter.transpose().map_err(|why| shell.usage(why))?;
    let options = RigOptions {
        seed: arguments.seed,
        sigma: arguments.sigma,
        effects,
        sigma_on_parts: arguments.sigma_on_parts,
        tolerances: tolerances.unwrap_or_default(),
        scatter: scatter.unwrap_or_default(),
        programme: arguments.programme.map(LoadTable::from),
    };
    let bar = Progress::new("measuring on the virtual rig", shell, || None);
    let measured = virtual_rig_watched(&arguments.study, &options, &mut |done, of| {
        bar.count(done, Some(of), "load cases");
    });
    drop(bar);
    let run = measured.map_err(|diagnostics| {
        shell.complain(&diagnostics);
        Exit::Findings
    })?;
    let out = output_folder(arguments.out.as_deref(), &arguments.study, "rig");
    write_folder(&out, &run.files, arguments.replacing, shell)?;
    if let Some(truth) = &arguments.truth {
        shell.write(truth, run.truth.as_bytes())?;
    }
    Ok(Exit::Fine)
}
