use std::path::Path;
use std::process::Command;

use admire_guide as guide;

/// Returns the words of a text, whatever its line ends.
fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Checks that the first command of the README prints what the README shows.
#[test]
fn the_readme_shows_what_the_first_command_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("README.md")).unwrap();
    let (_, rest) = page
        .split_once("```console\n$ cargo run --release -- ")
        .unwrap();
    let (command, rest) = rest.split_once('\n').unwrap();
    let (shown, _) = rest.split_once("\n$ ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("first").display().to_string();
    let arguments = command.replace("target/first", &out);
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(arguments.split(' '))
        .current_dir(root)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout).replace(&out, "target/first");
    let said = words(&said);
    assert!(run.status.success(), "{said}");
    for line in shown.lines().filter(|line| line.trim() != "...") {
        assert!(said.contains(&words(line)), "says no `{line}`:\n{said}");
    }
}

/// Runs the commands of the tutorial in order, as printed, and checks that they print what the page shows.
#[test]
#[cfg(unix)]
fn the_tutorial_runs_as_it_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::os::unix::fs::symlink(root.join("corpus"), folder.path().join("corpus")).unwrap();
    let programs = Path::new(env!("CARGO_BIN_EXE_admire")).parent().unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    let page = guide::page("tutorial").expect("the page");
    let mut commands = 0;
    for block in page.text.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap();
        for piece in block.split("$ ").skip(1) {
            let (command, expected) = piece.split_once('\n').unwrap();
            let run = Command::new("sh")
                .args(["-c", &format!("{{ {command}; }} 2>&1")])
                .current_dir(folder.path())
                .env("PATH", format!("{}:{path}", programs.display()))
                .stdin(std::process::Stdio::null())
                .output()
                .unwrap();
            let said = words(&String::from_utf8_lossy(&run.stdout));
            assert!(run.status.success(), "{command}: {said}");
            for line in expected.lines() {
                assert!(
                    said.contains(&words(line)),
                    "{command}\nsays no `{line}`:\n{said}"
                );
            }
            commands += 1;
        }
    }
    assert!(commands >= 10, "{commands}");
    let diagnosis = folder.path().join("target/lesson/diagnosed/diagnosis.json");
    let text = std::fs::read_to_string(diagnosis).unwrap();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    let first = &found["findings"][0];
    assert_eq!(
        (first["cause"].as_str(), first["address"].as_str()),
        (Some("link-compliance"), Some("PART/6"))
    );
    // Planted stiffness: 6000 N/mm.
    let compliance = first["parameters"]["compliance"].as_f64().unwrap();
    let error = first["std_error"]["compliance"].as_f64().unwrap();
    assert!(
        (compliance - 1.0 / 6000.0).abs() < 3.0 * error,
        "{compliance} +- {error}"
    );
}
