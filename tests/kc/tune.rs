//! `admire tune` as a process.

use std::path::Path;
use std::process::Output;

use crate::run;

/// Runs `admire` in the folder of the corpus.
fn admire(arguments: &[&str]) -> Output {
    run::admire(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Returns the text of a stream with one kind of line end.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).replace("\r\n", "\n")
}

/// Checks that the page of the guide shows the output of the command. The deck of the study is unchanged, and the tuned deck differs only in
/// markers.
#[test]
fn the_page_shows_what_the_command_prints() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tuned");
    let shown = out.display().to_string();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/double-wishbone");
    let before = std::fs::read(study.join("model.adm")).unwrap();
    let ran = admire(&["tune", "corpus/double-wishbone", "--out", &shown]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let said = text(&ran.stdout).replace('\\', "/");
    let said = said.replace(&shown.replace('\\', "/"), "target/tuned");
    let page = include_str!("../../src/guide/tune.md");
    let command = "$ admire tune corpus/double-wishbone --out target/tuned\n";
    let (_, rest) = page.split_once(command).expect("the command");
    let (block, _) = rest.split_once("```").expect("a block");
    // A line that ends in three points is compared up to these points; a line of three points stands for any number of lines.
    let mut lines = said.lines();
    for shown in block.lines().filter(|line| *line != "...") {
        let found = match shown.strip_suffix("...") {
            Some(begin) => lines.any(|line| line.starts_with(begin)),
            None => lines.any(|line| line == shown),
        };
        assert!(found, "{shown} in\n{said}");
    }

    assert_eq!(std::fs::read(study.join("model.adm")).unwrap(), before);
    let tuned = std::fs::read(out.join("tuned.adm")).unwrap();
    let (old, new) = (text(&before), text(&tuned));
    let changed: Vec<(&str, &str)> = old
        .lines()
        .zip(new.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(old.lines().count(), new.lines().count());
    assert!(!changed.is_empty());
    for (old, new) in changed {
        let number =
            old.starts_with("MARKER/") || old.starts_with(", ZP") || old.starts_with(", XP");
        assert!(number, "{old} | {new}");
    }
    // The tests of the tuned deck give the values that the search reports.
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("tuning.json")).unwrap()).unwrap();
    let kc = folder.path().join("kc");
    let config = study.join("kc.toml").display().to_string();
    let deck = out.join("tuned.adm").display().to_string();
    let ran = admire(&[
        "kc",
        &deck,
        "--config",
        &config,
        "--out",
        &kc.display().to_string(),
    ]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let curves = std::fs::read_to_string(kc.join("curves.csv")).unwrap();
    let lines: Vec<Vec<&str>> = curves
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
        .collect();
    let column = |name: &str| lines[0].iter().position(|head| *head == name).expect(name);
    let (test, branch) = (column("test"), column("branch"));
    let own = column("toe_angle.left [deg]");
    let toe: Vec<f64> = lines[1..]
        .iter()
        .filter(|row| row[test] == "bounce" && row[branch] == "up")
        .map(|row| row[own].parse().unwrap())
        .collect();
    let rows = json["goals"][0]["rows"].as_array().unwrap();
    assert_eq!(toe.len(), rows.len());
    for (toe, row) in toe.iter().zip(rows) {
        assert!((toe - row["after"].as_f64().unwrap()).abs() < 1e-6);
    }
}

/// Checks the exit codes: 1 for a fault of the study, 2 for the command line. A file of the user is not replaced.
#[test]
fn faults_have_their_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().display().to_string();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("study.toml", "[model]\ndeck = \"model.adm\"\n[target]\n");
    write("model.adm", "title\nEND\n");
    let ran = admire(&["tune", &study]);
    assert_eq!(ran.status.code(), Some(1));
    assert!(
        text(&ran.stderr).contains("kc.toml"),
        "{}",
        text(&ran.stderr)
    );
    let ran = admire(&["tune"]);
    assert_eq!(ran.status.code(), Some(2));
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("tuned.adm"), "mine").unwrap();
    let shown = out.display().to_string();
    let ran = admire(&[
        "tune",
        "corpus/double-wishbone",
        "--out",
        &shown,
        "--restarts",
        "0",
    ]);
    assert_eq!(ran.status.code(), Some(1));
    assert_eq!(
        std::fs::read_to_string(out.join("tuned.adm")).unwrap(),
        "mine"
    );
}

/// Checks that `admire check` accepts a study with only a target as complete, and that it finds faults of the target.
#[test]
fn a_study_with_a_target_alone_is_checked() {
    let ran = admire(&["check", "corpus/double-wishbone"]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stdout));
    let folder = tempfile::tempdir().unwrap();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/double-wishbone");
    for name in ["model.adm", "kc.toml", "wanted.csv", "study.toml"] {
        std::fs::copy(study.join(name), folder.path().join(name)).unwrap();
    }
    let toml = std::fs::read_to_string(study.join("study.toml")).unwrap();
    let wrong = toml.replace("MARKER/141.QP", "MARKER/941.QP");
    std::fs::write(folder.path().join("study.toml"), wrong).unwrap();
    let ran = admire(&["check", &folder.path().display().to_string()]);
    assert_eq!(ran.status.code(), Some(1));
    let said = text(&ran.stdout);
    assert!(said.contains("MARKER/941 is not in this dataset"), "{said}");
    assert!(said.contains("did you mean MARKER/141?"), "{said}");
}
