//! Tells the programs which commit they were built from. Builds for development do not ask: they would be built anew after every commit.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let commit = if std::env::var("PROFILE").as_deref() == Ok("release") {
        // A worktree has them elsewhere. What is not there would have everything built anew each time.
        for file in ["HEAD", "logs/HEAD"] {
            if let Some(path) =
                git(&["rev-parse", "--git-path", file]).filter(|p| Path::new(p).exists())
            {
                println!("cargo:rerun-if-changed={path}");
            }
        }
        commit().unwrap_or_else(|| "unknown commit".to_string())
    } else {
        "development build".to_string()
    };
    println!("cargo:rustc-env=ADMIRE_COMMIT={commit}");
}

/// The commit of this folder, short, with a mark if files were changed since; `None` outside of a clone.
fn commit() -> Option<String> {
    let text = git(&[
        "describe",
        "--always",
        "--dirty",
        "--abbrev=10",
        "--exclude=*",
    ])?;
    Some(format!("commit {text}"))
}

/// What git answers; `None` outside of a clone.
fn git(words: &[&str]) -> Option<String> {
    let run = Command::new("git").args(words).output().ok()?;
    let text = String::from_utf8(run.stdout).ok()?.trim().to_string();
    (run.status.success() && !text.is_empty()).then_some(text)
}
