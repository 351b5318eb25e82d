//! Passes the git commit to the compiler for release builds. Development builds omit the commit, because it would trigger a rebuild after
//! every commit.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let commit = if std::env::var("PROFILE").as_deref() == Ok("release") {
        // In a git worktree, these files are elsewhere. A missing file would trigger a rebuild every time, so it is not listed.
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

/// Returns the abbreviated commit of this folder, with a mark if files have changed since this commit. Returns `None` outside a clone.
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

/// Runs git and returns its output. Returns `None` if git fails, for example outside a clone.
fn git(words: &[&str]) -> Option<String> {
    let run = Command::new("git").args(words).output().ok()?;
    let text = String::from_utf8(run.stdout).ok()?.trim().to_string();
    (run.status.success() && !text.is_empty()).then_some(text)
}
