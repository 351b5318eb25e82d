//! Tells the programs which commit they were built from. Builds for development do not ask: they would be built anew after every commit.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=src/build.rs");
    let commit = if std::env::var("PROFILE").as_deref() == Ok("release") {
        println!("cargo:rerun-if-changed=.git/HEAD");
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
        commit().unwrap_or_else(|| "unknown commit".to_string())
    } else {
        "development build".to_string()
    };
    println!("cargo:rustc-env=ADMIRE_COMMIT={commit}");
}

/// The commit of this folder, short, with a mark if files were changed since; `None` outside of a clone.
fn commit() -> Option<String> {
    let run = Command::new("git")
        .args([
            "describe",
            "--always",
            "--dirty",
            "--abbrev=10",
            "--exclude=*",
        ])
        .output()
        .ok()?;
    let text = String::from_utf8(run.stdout).ok()?;
    let text = text.trim();
    (run.status.success() && !text.is_empty()).then(|| format!("commit {text}"))
}
