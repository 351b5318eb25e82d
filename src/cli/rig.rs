use std::path::PathBuf;

use crate::diagnostic::{Code, Diagnostic};
use crate::rig::effect::EffectSpec;
use crate::rig::{RigOptions, virtual_rig};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Measure a study's deck on the virtual test rig and write what a rig would hand over: a whole study folder.
///
/// Nothing in the folder tells what was planted; `--truth` writes that elsewhere.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// The study's folder; its own readings need not exist.
    study: PathBuf,
    /// The folder to write.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of the measuring noise.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Standard deviation of one mark coordinate instead of the study's.
    #[arg(long)]
    sigma: Option<f64>,
    /// An effect to plant: `cause@address:name=value,...`
    #[arg(long, value_name = "SPEC")]
    effect: Vec<String>,
    /// Where to write what was planted.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

/// Measures and writes.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut effects = Vec::new();
    for text in &arguments.effect {
        effects.push(EffectSpec::parse(text).map_err(|diagnostic| {
            shell.complain(&[diagnostic]);
            Exit::Failed
        })?);
    }
    let options = RigOptions {
        seed: arguments.seed,
        sigma: arguments.sigma,
        effects,
    };
    let run = virtual_rig(&arguments.study, &options).map_err(|diagnostics| {
        shell.complain(&diagnostics);
        Exit::Findings
    })?;
    for (name, bytes) in &run.files {
        let path = arguments.out.join(name);
        let folder = path.parent().unwrap_or(&arguments.out);
        std::fs::create_dir_all(folder).map_err(|error| {
            let message = format!("{}: {error}", folder.display());
            shell.fail(Diagnostic::error(Code::CannotWrite, message))
        })?;
        shell.write(&path, bytes)?;
    }
    if let Some(truth) = &arguments.truth {
        shell.write(truth, run.truth.as_bytes())?;
    }
    Ok(Exit::Fine)
}
