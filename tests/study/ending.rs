//! The final output of `identify` and `diagnose` on a terminal: a few lines, with the rest behind `-v`.

use super::run::{Said, admire, copied, corpus};

/// Largest number of lines that a fit prints.
const MAX_LINES: usize = 15;
/// Width of a terminal in columns.
const WIDTH: usize = 80;

/// Checks that the output of a fit is short, and that it contains the four items that a reader needs.
fn is_short(name: &str, said: &Said) {
    let text = format!("{}{}", said.err, said.out);
    assert!(text.lines().count() <= MAX_LINES, "{name}:\n{text}");
    let wide = said.out.lines().find(|line| line.chars().count() > WIDTH);
    assert!(wide.is_none(), "{name}: {wide:?}");
    for head in ["\nheld out: ", "\nnext: ", "\nreport: "] {
        assert!(said.out.contains(head), "{name}: {head:?}\n{text}");
    }
    let spelled = text.replace("gauss-newton", "");
    assert!(
        !spelled.contains("+-") && !spelled.contains("newton"),
        "{text}"
    );
}

/// Checks that the table of all parameters and the table of plausibility appear only with `-v`, and that the ending is the same.
#[test]
fn an_identification_of_a_shipped_study_ends_in_fifteen_lines() {
    for name in [
        "pseudo-mcpherson",
        "multilink",
        "kc-experiment",
        "fanuc-r2000ic",
    ] {
        let (folder, _study) = copied(name);
        let said = admire(folder.path(), &["identify", "study"]);
        is_short(name, &said);
        let report = folder.path().join("study/out-identify/report.html");
        assert!(report.is_file(), "{name}");
        assert!(said.out.contains(" ± "), "{name}: {}", said.out);
        let verbose = admire(folder.path(), &["identify", "study", "-v"]);
        assert!(verbose.out.ends_with(&said.out), "{name}: {}", verbose.out);
        assert!(verbose.out.contains("initial"), "{name}: {}", verbose.out);
        assert!(
            verbose.err.contains(" ok  units"),
            "{name}: {}",
            verbose.err
        );
        for text in ["initial", " ok  units"] {
            assert!(
                !format!("{}{}", said.out, said.err).contains(text),
                "{name}"
            );
        }
    }
    // The gain on cases that no fit used is stated in sigmas of their noise and in the unit of the deck.
    let (folder, _study) = copied("kc-experiment");
    let out = admire(folder.path(), &["identify", "study"]).out;
    let gain = out.split("\nheld out: ").nth(1).unwrap();
    assert!(gain.contains(" mm (") && gain.contains(" sigmas)"), "{out}");
}

#[test]
fn a_diagnosis_without_a_cause_says_so_and_all_with_v() {
    let (folder, _study) = copied("pseudo-mcpherson");
    let said = admire(folder.path(), &["diagnose", "study"]);
    is_short("pseudo-mcpherson", &said);
    assert!(said.out.starts_with("consistent: "), "{}", said.out);
    assert!(
        folder
            .path()
            .join("study/out-diagnose/report.html")
            .is_file()
    );
    let verbose = admire(folder.path(), &["diagnose", "study", "-v"]);
    assert!(verbose.out.ends_with(&said.out), "{}", verbose.out);
    for text in [
        "combinations of cause and place were tried",
        "no cause of the catalogue acts",
    ] {
        assert!(verbose.out.contains(text), "{}", verbose.out);
        assert!(!said.out.contains(text), "{}", said.out);
    }
}

/// Checks that the page `diagnosis` shows the final output of the shipped experiment: causes with sizes, gain, next step, report.
#[test]
fn the_guide_shows_what_the_diagnosis_of_the_experiment_prints() {
    let page = admire_guide::page("diagnosis").expect("the page");
    let shown = page.text.split("--out target/kc` says\n\n```text\n").nth(1);
    let shown = shown.unwrap().split("```").next().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let study = corpus("kc-experiment");
    let study = study.to_str().unwrap();
    let said = admire(folder.path(), &["diagnose", study, "-o", "target/kc"]);
    is_short("kc-experiment", &said);
    assert_eq!(said.out, shown);
}

/// Checks that the program of the system opens the report, and that the command continues with a message if there is none.
#[test]
#[cfg(target_os = "linux")]
fn the_report_is_opened_if_something_opens_it() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, _study) = copied("pseudo-mcpherson");
    let programs = folder.path().join("programs");
    std::fs::create_dir(&programs).unwrap();
    let run = || {
        let words = ["identify", "study", "-o", "answer", "--open"];
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(words)
            .current_dir(folder.path())
            .env("PATH", &programs)
            .output()
            .unwrap();
        assert_eq!(run.status.code(), Some(0));
        String::from_utf8_lossy(&run.stderr).into_owned()
    };
    assert!(run().contains("`xdg-open` could not open the page"));
    let opener = programs.join("xdg-open");
    let seen = folder.path().join("seen");
    let script = format!("#!/bin/sh\necho \"$1\" > '{}'\n", seen.display());
    std::fs::write(&opener, script).unwrap();
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).unwrap();
    assert!(!run().contains("could not open the page"));
    let report = folder.path().join("answer/report.html");
    let wanted = format!("{}\n", report.display());
    let started = std::time::Instant::now();
    // The opener continues after the command that started it.
    while !std::fs::read_to_string(&seen).is_ok_and(|text| text == wanted) {
        assert!(started.elapsed().as_secs() < 20, "nothing was opened");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// Checks that a command without `--out` writes beside its input.
#[test]
fn a_folder_that_is_not_named_is_beside_the_input() {
    let (folder, study) = copied("multilink");
    let kc = ["kc", "study/model.adm", "--config", "study/kc.toml"];
    let said = admire(folder.path(), &kc);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(study.join("out-kc/kc.json").is_file());
    let said = admire(folder.path(), &["rig", "study"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(study.join("out-rig/study.toml").is_file());
    // Files of the user in that folder are not replaced.
    std::fs::write(study.join("out-rig/study.toml"), "mine").unwrap();
    let said = admire(folder.path(), &["rig", "study", "--seed", "2"]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert_eq!(
        std::fs::read(study.join("out-rig/study.toml")).unwrap(),
        b"mine"
    );
}

/// Checks that a help text fits its command: only commands that fit a study mention fits.
#[test]
fn help_texts_fit_their_command() {
    let folder = tempfile::tempdir().unwrap();
    let help = |name: &str| admire(folder.path(), &[name, "--help"]).out;
    for name in [
        "kc",
        "new",
        "rebuild",
        "renumber",
        "reproduce",
        "rig",
        "solve",
    ] {
        let text = help(name);
        assert!(
            text.contains("--force") && !text.contains("implausible"),
            "{name}: {text}"
        );
    }
    for name in ["identify", "diagnose", "plan"] {
        assert!(help(name).contains("implausible study"), "{name}");
    }
    assert!(!help("results").contains("deck"), "{}", help("results"));
    for name in [
        "identify",
        "diagnose",
        "plan",
        "kc",
        "rebuild",
        "reproduce",
        "rig",
        "sweep",
    ] {
        assert!(help(name).contains("-o, --out"), "{name}");
    }
}
