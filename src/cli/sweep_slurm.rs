//! Submission of a sweep to SLURM: an array of jobs over its shards, and a job that joins them.

use std::path::Path;
use std::process::Command;

use admire_session::own_program;
use admire_sweep::SweepFolder;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::counted::counted;
use super::shell::{Exit, Shell};

/// Sweep to be submitted to SLURM.
pub(super) struct Submitted<'a> {
    /// Path of SWEEP.toml.
    pub(super) plan: &'a Path,
    /// Options for every `sbatch`.
    pub(super) options: &'a [String],
    /// True if the sweep starts an external program. The user has allowed it, and the jobs cannot ask again.
    pub(super) starts_program: bool,
}

/// Writes the scripts of the array and of the joining job, and submits both. Finished shards are left out.
pub(super) fn submit(submitted: &Submitted<'_>, folder: &SweepFolder, shell: &Shell) -> Outcome {
    let (plan, options) = (submitted.plan, submitted.options);
    let cannot = |what: &Path, error: &dyn std::fmt::Display| {
        shell.fail(Diagnostic::error(
            Code::CannotWrite,
            format!("`{}` cannot be used: {error}", what.display()),
        ))
    };
    let absolute = |path: &Path| std::path::absolute(path).map_err(|error| cannot(path, &error));
    let own = own_program().map_err(|error| cannot(Path::new("admire"), &error))?;
    let (out, plan) = (absolute(&folder.path)?, absolute(plan)?);
    let left: Vec<String> = folder
        .shards()
        .filter(|shard| !folder.part(*shard).is_file())
        .map(|shard| shard.number.to_string())
        .collect();
    let place = out.join("slurm");
    std::fs::create_dir_all(&place).map_err(|error| cannot(&place, &error))?;
    let of = folder.manifest.shards;
    // If no shard is finished, the array is written as one range.
    let tasks = if left.len() as u64 == of {
        format!("1-{of}")
    } else {
        left.join(",")
    };
    let array = format!(
        "#!/bin/sh\n#SBATCH --job-name=admire-sweep\n#SBATCH --requeue\n#SBATCH --open-mode=append\nexec {} sweep {} --out {} \
         --shard \"$SLURM_ARRAY_TASK_ID/{of}\" --jobs \"${{SLURM_CPUS_PER_TASK:-1}}\"{}\n",
        quoted(&own),
        quoted(&plan),
        quoted(&out),
        if submitted.starts_program {
            " --allow-command"
        } else {
            ""
        }
    );
    let merge = format!(
        "#!/bin/sh\n#SBATCH --job-name=admire-merge\n#SBATCH --open-mode=append\nexec {} merge {}\n",
        quoted(&own),
        quoted(&out)
    );
    let scripts = [
        (place.join("array.sh"), array),
        (place.join("merge.sh"), merge),
    ];
    for (path, text) in &scripts {
        shell.write(path, text.as_bytes())?;
    }
    let [(array, _), (merge, _)] = scripts;
    let mut joining = Vec::new();
    if !left.is_empty() {
        let log = place.join("shard-%a.log");
        let own = [
            format!("--array={tasks}"),
            format!("--output={}", log.display()),
        ];
        let job = sbatch(&own, options, &array, shell)?;
        let shards = counted(left.len(), "shard");
        shell.say(&format!("array job of {shards}: {job}\n"));
        joining.push(format!("--dependency=afterok:{job}"));
    }
    joining.push(format!("--output={}", place.join("merge.log").display()));
    let job = sbatch(&joining, options, &merge, shell)?;
    shell.say(&format!(
        "job that joins the shards: {job}; scripts and logs: `{}`\n",
        place.display()
    ));
    shell.print(&format!("{job}\n"));
    Ok(Exit::Fine)
}

/// Submits a script and returns the number of the job.
fn sbatch(
    own: &[String],
    options: &[String],
    script: &Path,
    shell: &Shell,
) -> Result<String, Exit> {
    let ran = Command::new("sbatch")
        .arg("--parsable")
        .args(own)
        .args(options)
        .arg(script)
        .output();
    let refuse = |why: String, help: String| {
        shell.fail(Diagnostic::error(Code::RunsProgram, why).help(help))
    };
    let by_hand = format!(
        "the scripts are written; submit this one by hand: sbatch {} {}",
        own.join(" "),
        script.display()
    );
    let output = ran.map_err(|error| {
        refuse(
            format!("`sbatch` of SLURM cannot be started: {error}"),
            by_hand.clone(),
        )
    })?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    // With several clusters, the name of the cluster follows the job number after a semicolon.
    let job = text
        .trim()
        .split(';')
        .next()
        .unwrap_or_default()
        .to_string();
    if !output.status.success() || job.is_empty() {
        let said = String::from_utf8_lossy(&output.stderr).trim().to_string();
        return Err(refuse(
            format!("`sbatch` did not submit the script: {said}"),
            by_hand,
        ));
    }
    Ok(job)
}

/// Quotes a path as one word of a POSIX shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_one_word_of_a_shell() {
        let path = Path::new("/a b/it's $HOME");
        assert_eq!(quoted(path), "'/a b/it'\\''s $HOME'");
        let path = Path::new("/a\n`b`$(c); 'd' \"&|\\");
        let words = Command::new("sh")
            .args(["-c", &format!("printf '%s|' x {} y", quoted(path))])
            .output();
        // The test is skipped if there is no `sh`.
        if let Ok(words) = words {
            let words = String::from_utf8_lossy(&words.stdout).into_owned();
            assert_eq!(words, format!("x|{}|y|", path.display()));
        }
    }
}
