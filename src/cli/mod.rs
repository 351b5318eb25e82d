//! The command `admire`, with one file for each subcommand.
//!
//! Only this module prints, uses colours and asks questions. It is independent of file formats and mechanics: every subcommand calls one
//! function of a lower layer and shows the result.

mod add;
mod addresses;
mod annotations;
mod assignment;
mod car_edits;
mod check;
mod check_settings;
mod command_edits;
mod commands;
mod compare;
mod completions;
mod convert_units;
mod counted;
mod diagnose;
mod diff;
mod doctor;
mod edited;
mod ending;
mod explain;
mod export;
mod extract;
mod fix;
mod format;
mod get;
mod graph;
mod guide;
mod identify;
mod import;
mod import_kc;
mod input;
mod inputs;
mod install;
mod install_shims;
mod interrupt;
mod kc;
mod lsp;
mod markdown;
mod merge;
mod new;
mod notices;
mod opening;
mod output_folder;
mod pager;
mod permission;
mod plan;
mod plausibility;
mod progress;
mod rebuild;
mod record;
mod remove;
mod render;
mod renumber;
mod reproduce;
mod results;
mod results_edits;
mod results_file;
mod results_kc;
mod rig;
mod sensitivity;
mod set;
mod shell;
mod solve;
mod solve_run;
mod summary;
mod sweep;
mod sweep_slurm;
mod target;
mod tolerance;
mod tune;
mod view;
mod width;

use std::ffi::OsString;

use clap::{CommandFactory, Parser, Subcommand};

use admire_report::VERSION;

use format::Format;
use shell::{ColorChoice, Exit, Shell, Verbosity};

const EXAMPLES: &str = "First steps:
  admire new my-axle --from front.adm        begin a study of a deck
  admire check my-axle                       missing entries, plausibility
  admire identify my-axle --out answer       stiffnesses with their uncertainty
  admire diagnose my-axle --out diagnosis    faults that remain in the model
  admire plan my-axle                        what to measure next
  admire guide tutorial                      fifteen minutes from a test to a diagnosed model
  admire doctor                              check of the installation";

/// Reads, checks, edits and solves ADAMS datasets, identifies bushing stiffnesses, and diagnoses the faults that remain in a model.
///
/// Exit codes: 0 success; 1 the input has errors, a file cannot be read or written, or a comparison found differences; 2 the command line
/// is wrong; 3 there is no equilibrium or no fit.
#[derive(Parser, Debug)]
#[command(name = "admire", version = VERSION, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Format in which messages are printed.
    #[arg(long, global = true, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// When to use colours; `auto` obeys NO_COLOR.
    #[arg(long, global = true, value_enum, default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
    /// Print only messages and the result; `check` prints only errors.
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print every stage, even if no terminal shows progress.
    #[arg(long, short, global = true)]
    verbose: bool,
}

#[derive(Subcommand, Debug)]
enum Command {
    New(new::Arguments),
    Check(check::Arguments),
    Fix(fix::Arguments),
    Get(get::Arguments),
    Set(set::Arguments),
    Add(add::Arguments),
    Remove(remove::Arguments),
    Extract(extract::Arguments),
    ConvertUnits(convert_units::Arguments),
    Diff(diff::Arguments),
    Summary(summary::Arguments),
    Graph(graph::Arguments),
    Renumber(renumber::Arguments),
    Export(export::Arguments),
    Import(import::Arguments),
    Solve(solve::Arguments),
    Sensitivity(sensitivity::Arguments),
    Identify(identify::Arguments),
    Diagnose(diagnose::Arguments),
    Plan(plan::Arguments),
    Tune(tune::Arguments),
    Record(record::Arguments),
    Rebuild(rebuild::Arguments),
    Rig(rig::Arguments),
    Kc(kc::Arguments),
    ImportKc(import_kc::Arguments),
    Sweep(sweep::Arguments),
    Merge(merge::Arguments),
    Reproduce(reproduce::Arguments),
    Results(results::Arguments),
    Compare(compare::Arguments),
    View(view::Arguments),
    Commands(commands::Arguments),
    Explain(explain::Arguments),
    Guide(guide::Arguments),
    Doctor(doctor::Arguments),
    Install(install::Arguments),
    InstallShims(install_shims::Arguments),
    Lsp(lsp::Arguments),
    Completions(completions::Arguments),
}

/// Makes the C library keep large freed blocks in the process. By default, the C library of Linux returns a large freed block to the system
/// and maps the next block anew, page by page. Once a block of nearly 32 MB has been freed, it keeps blocks up to that size. Source:
/// mallopt(3), `M_MMAP_THRESHOLD`, "dynamic mmap threshold". On other systems, the call has no effect.
fn keep_freed_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
}

/// Runs `admire` with a command line, whose first word is the program, and returns its exit code.
pub fn run(words: Vec<OsString>) -> u8 {
    keep_freed_memory();
    let completion = clap_complete::CompleteEnv::with_factory(Cli::command);
    let folder = std::env::current_dir().ok();
    match completion.try_complete(&words, folder.as_deref()) {
        Ok(false) => {}
        Ok(true) => return Exit::Fine as u8,
        Err(error) => error.exit(),
    }
    let cli = Cli::parse_from(words);
    let verbosity = match (cli.quiet, cli.verbose) {
        (true, _) => Verbosity::Quiet,
        (_, true) => Verbosity::Verbose,
        _ => Verbosity::Usual,
    };
    notices::show();
    let mut shell = Shell::new(cli.format, cli.color, verbosity);
    if let Err(exit) = shell.obey_code_page() {
        return exit as u8;
    }
    let exit = match cli.command {
        Command::New(arguments) => new::run(&arguments, &mut shell),
        Command::Check(arguments) => check::run(&arguments, &mut shell),
        Command::Fix(arguments) => fix::run(&arguments, &mut shell),
        Command::Get(arguments) => get::run(&arguments, &mut shell),
        Command::Set(arguments) => set::run(&arguments, &mut shell),
        Command::Add(arguments) => add::run(&arguments, &mut shell),
        Command::Remove(arguments) => remove::run(&arguments, &mut shell),
        Command::Extract(arguments) => extract::run(&arguments, &mut shell),
        Command::ConvertUnits(arguments) => convert_units::run(&arguments, &mut shell),
        Command::Diff(arguments) => diff::run(&arguments, &mut shell),
        Command::Summary(arguments) => summary::run(&arguments, &mut shell),
        Command::Graph(arguments) => graph::run(&arguments, &mut shell),
        Command::Renumber(arguments) => renumber::run(&arguments, &mut shell),
        Command::Export(arguments) => export::run(&arguments, &mut shell),
        Command::Import(arguments) => import::run(&arguments, &mut shell),
        Command::Solve(arguments) => solve::run(&arguments, &mut shell),
        Command::Sensitivity(arguments) => sensitivity::run(&arguments, &mut shell),
        Command::Identify(arguments) => identify::run(&arguments, &mut shell),
        Command::Diagnose(arguments) => diagnose::run(&arguments, &mut shell),
        Command::Plan(arguments) => plan::run(&arguments, &mut shell),
        Command::Tune(arguments) => tune::run(&arguments, &mut shell),
        Command::Rebuild(arguments) => rebuild::run(&arguments, &mut shell),
        Command::Record(arguments) => record::run(&arguments, &mut shell),
        Command::Kc(arguments) => kc::run(&arguments, &mut shell),
        Command::ImportKc(arguments) => import_kc::run(&arguments, &mut shell),
        Command::Sweep(arguments) => sweep::run(&arguments, &mut shell),
        Command::Merge(arguments) => merge::run(&arguments, &mut shell),
        Command::Rig(arguments) => rig::run(&arguments, &mut shell),
        Command::Reproduce(arguments) => reproduce::run(&arguments, &mut shell),
        Command::Results(arguments) => results::run(&arguments, &mut shell),
        Command::Compare(arguments) => compare::run(&arguments, &mut shell),
        Command::View(arguments) => view::run(&arguments, &mut shell),
        Command::Commands(arguments) => commands::run(&arguments, &mut shell),
        Command::Explain(arguments) => explain::run(&arguments, &mut shell),
        Command::Guide(arguments) => guide::run(&arguments, &mut shell),
        Command::Doctor(arguments) => doctor::run(&arguments, &mut shell),
        Command::Install(arguments) => install::run(&arguments, &mut shell),
        Command::InstallShims(arguments) => install_shims::run(&arguments, &mut shell),
        Command::Lsp(arguments) => lsp::run(&arguments, &mut shell),
        Command::Completions(arguments) => completions::run(&arguments),
    };
    shell.exit(exit.unwrap_or_else(|exit| exit)) as u8
}

/// Exit code of a subcommand. `Err` means that the subcommand stopped early and has reported the reason.
type Outcome = Result<Exit, Exit>;
