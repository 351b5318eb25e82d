//! Tests of inputs from outside: named pipes in place of files, and message files of real runs.

use std::process::Command;

use super::commands::Folder;

/// Checks that a named pipe as deck, results file or study table is refused at once, while a process substitution of the shell is accepted.
#[cfg(target_os = "linux")]
#[test]
fn a_named_pipe_is_refused_and_not_waited_for() {
    let folder = Folder::new();
    let pipe = |name: &str| {
        let made = Command::new("mkfifo")
            .arg(folder.path().join(name))
            .status();
        assert!(made.expect("mkfifo runs").success());
    };
    pipe("deck.adm");
    pipe("run.res");
    for words in [
        &["check", "deck.adm"][..],
        &["check", "."],
        &["get", "deck.adm", "TITLE"],
        &["results", "run.res"],
        &["set", "deck.adm", "PART/2.MASS=2"],
    ] {
        let (code, _, err) = folder.said(words);
        assert_eq!(code, 1, "{words:?}: {err}");
        assert!(err.contains("named pipe"), "{words:?}: {err}");
    }
    // The last named pipe replaces a table of a study.
    let corpus = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    std::fs::create_dir(folder.path().join("study")).expect("created");
    for name in [
        "study.toml",
        "model.adm",
        "reference.adm",
        "marks_on_parts.csv",
        "marks_measured.csv",
    ] {
        let to = folder.path().join("study").join(name);
        std::fs::copy(corpus.join(name), to).expect("copied");
    }
    pipe("study/load_cases.csv");
    let (code, out, err) = folder.said(&["check", "study"]);
    assert_eq!(code, 1, "{err}");
    assert!(format!("{out}{err}").contains("named pipe"), "{out}{err}");
    let shell = format!("{} check <(cat a.adm)", env!("CARGO_BIN_EXE_admire"));
    let output = Command::new("bash")
        .args(["-c", &shell])
        .current_dir(folder.path())
        .output()
        .expect("bash runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!said.contains("cannot be read"), "{said}");
}

/// Checks the commands recovered from a real co-simulation (Adams 2014 with Simulink): 28 simulations of 5 ms, none of them echoed in the
/// message file.
#[test]
fn commands_of_a_real_co_simulation_have_its_simulations() {
    let folder = Folder::new();
    let shared = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real-car-files/handspring-cosimulation.msg");
    if !shared.is_file() {
        println!("skipped: {} is not here", shared.display());
        return;
    }
    let path = shared.to_str().expect("a name");
    let (code, out, err) = folder.said(&["commands", path, "--model", "plant"]);
    assert_eq!(code, 0, "{err}");
    let simulated: Vec<&str> = out
        .lines()
        .filter(|line| line.starts_with("simulate/dynamic"))
        .collect();
    assert_eq!(simulated.len(), 28, "{out}");
    assert_eq!(simulated[0], "simulate/dynamic, end=0.005, steps=1");
    assert_eq!(simulated[27], "simulate/dynamic, end=0.14, steps=1");
    assert_eq!(
        out.lines().filter(|line| line.starts_with("var/7")).count(),
        29
    );
    assert!(err.contains("28 of 28"), "{err}");
    // The inputs of each exchange are set before its simulation.
    let at = |text: &str| out.lines().position(|line| line == text).expect("there");
    assert!(at("simulate/initial_conditions") < at(simulated[0]));
    assert!(
        out.lines()
            .nth(at(simulated[0]) + 1)
            .expect("more")
            .starts_with("var/7")
    );
    // A message file without simulations gives no command file, which is an error.
    folder.write(
        "ic.msg",
        b" command: simulate/initial_conditions\n\n  Begin Displacement Initial Conditions\n",
    );
    let (code, out, err) = folder.said(&["commands", "ic.msg"]);
    assert_eq!((code, out.as_str()), (1, ""), "{err}");
    assert!(err.contains("records no simulation"), "{err}");
}
