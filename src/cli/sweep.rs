use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use admire_report::VERSION;
use admire_study::settings::BackendChoice;
use admire_study::solver;
use admire_sweep::{
    MOST_SHARDS, Manifest, Progress as Done, Runner, Shard, ShardError, SweepFolder, SweepPlan,
    Task, run_shard,
};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::interrupt;
use super::output_folder::{folder_beside, output_folder};
use super::permission::Permission;
use super::progress::{Count, Progress};
use super::shell::{Exit, Shell};
use super::sweep_slurm::{self, Submitted};

/// Run thousands of variants of a deck and collect the results in one table.
///
/// SWEEP.toml states what varies (addresses with distributions, or a table of cases), what is run (a command file, K&C tests, or the identification
/// or diagnosis of a study) and what is recorded. Every case is solved from scratch from its own deck, so that order, threads and shards change no
/// bit of the results. An interrupted run continues if the same command is given again. The results are in DIR/results.parquet, one row for each
/// case.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Plan of the sweep: what varies, what is run, what is recorded; `admire guide sweep` describes every key.
    #[arg(value_name = "SWEEP.toml")]
    plan: PathBuf,
    /// Folder of the sweep: a new folder, or the folder of an earlier run of this sweep; by default, `out-sweep` beside the plan.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run one of several shards, here or on another computer with access to DIR; `admire merge DIR` joins them.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<Shard>,
    /// Submit the shards as an array of SLURM jobs, and a job that joins them when all are finished. Finished shards are left out. Prints
    /// the number of the joining job.
    #[arg(long, requires = "shards", conflicts_with = "shard")]
    slurm: bool,
    /// With --slurm: number of shards.
    #[arg(long, value_name = "N", requires = "slurm", value_parser = clap::value_parser!(u64).range(1..=MOST_SHARDS))]
    shards: Option<u64>,
    /// With --slurm: option for every `sbatch`, such as --sbatch=--partition=short; may be repeated.
    #[arg(
        long,
        value_name = "OPTION",
        requires = "slurm",
        allow_hyphen_values = true
    )]
    sbatch: Vec<String>,
    /// Number of cases run in parallel; by default, one for each core.
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    #[command(flatten)]
    permission: Permission,
}

const EXAMPLES: &str = "Examples:
  admire sweep SWEEP.toml --out tolerance
  admire sweep SWEEP.toml --out tolerance --shard 3/8
  admire sweep SWEEP.toml --out tolerance --slurm --shards 8 --sbatch=--time=10:00
  admire merge tolerance";

fn parse_shard(text: &str) -> Result<Shard, ShardError> {
    text.parse()
}

/// Runs the unfinished cases, and joins the shards when all are finished.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let read = SweepPlan::read(&arguments.plan);
    shell.complain(&read.diagnostics);
    let Some(plan) = read.value else {
        return Err(Exit::Findings);
    };
    let program = plan.named_program();
    arguments.permission.ask(program.as_ref(), shell)?;
    if let Some(command) = plan.program.as_ref().and_then(|p| p.command.as_ref()) {
        shell.complain(&[Diagnostic::note(
            Code::RunsProgram,
            format!(
                "every case is solved by an external program, which `{}` names: {}",
                arguments.plan.display(),
                command.join(" ")
            ),
        )]);
    }
    if let Task::Study(loaded, _) = &plan.task
        && loaded.study.solver.backend == BackendChoice::Command
    {
        solver::command(&loaded.study, None, &|note| {
            shell.complain(std::slice::from_ref(note));
        });
    }
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let manifest = Manifest::of(&plan, arguments.shards.unwrap_or(shard.of), VERSION);
    let out = output_folder(
        arguments.out.as_deref(),
        &folder_beside(&arguments.plan),
        "sweep",
    );
    SweepFolder::look(&out, manifest.clone()).map_err(|wrong| shell.fail(wrong))?;
    let runner = Runner::prepare(&plan).map_err(|found| {
        shell.complain(&found);
        Exit::Findings
    })?;
    let folder = SweepFolder::begin(&out, manifest).map_err(|wrong| shell.fail(wrong))?;
    if arguments.slurm {
        let submitted = Submitted {
            plan: &arguments.plan,
            options: &arguments.sbatch,
            starts_program: program.is_some(),
        };
        return sweep_slurm::submit(&submitted, &folder, shell);
    }
    let threads = arguments.jobs.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    );
    if shard != Shard::WHOLE || !folder.results().is_file() {
        let done = cases(&runner, &plan, (&folder, shard), threads, shell)?;
        if !done.is_complete() {
            return Ok(Exit::Interrupted);
        }
    }
    if shard != Shard::WHOLE {
        shell.say(&format!(
            "shard {shard} is finished; `admire merge {}` joins all shards\n",
            out.display()
        ));
        return Ok(Exit::Fine);
    }
    super::merge::whole(&folder, shell)
}

/// Runs the unfinished cases of a shard and shows progress.
fn cases(
    runner: &Runner<'_>,
    plan: &SweepPlan,
    (folder, shard): (&SweepFolder, Shard),
    threads: usize,
    shell: &Shell,
) -> Result<Done, Exit> {
    interrupt::listen();
    let all = {
        let cases = shard.cases(plan.cases());
        cases.end - cases.start
    };
    let done = Arc::new(AtomicU64::new(0));
    let most = Arc::new(AtomicU64::new(all));
    let shown = (Arc::clone(&done), Arc::clone(&most));
    let bar = Progress::new("sweep", shell, move || {
        let (done, most) = (
            shown.0.load(Ordering::Relaxed),
            shown.1.load(Ordering::Relaxed),
        );
        let count = Count {
            done: done as usize,
            of: Some(most as usize),
            what: "cases",
        };
        Some(("sweep", count))
    });
    let ran = run_shard(runner, plan, folder, shard, threads, |progress| {
        done.store(progress.done, Ordering::Relaxed);
        most.store(progress.all - progress.before, Ordering::Relaxed);
        !interrupt::asked()
    });
    drop(bar);
    let ran =
        ran.map_err(|error| shell.fail(Diagnostic::error(Code::CannotWrite, error.to_string())))?;
    if ran.before > 0 {
        shell.say(&format!(
            "cases finished by an earlier run: {} of {}\n",
            ran.before, ran.all
        ));
    }
    Ok(ran)
}
