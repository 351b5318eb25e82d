//! Permitted contents of a study folder, and files in it that `admire` may replace.

use std::path::Path;
use std::process::Command;

use crate::setup::{copy, replace};

/// Returns exit code and standard error of `admire` in a folder.
fn said(folder: &Path, words: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(["--format", "plain"])
        .args(words)
        .output()
        .expect("admire runs");
    let code = output.status.code().expect("an exit code");
    (code, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_study_that_does_not_mean_what_it_says_is_refused() {
    for (change, says) in [
        ("sigmma = 0.05", "`marks.sigmma` is not a key"),
        ("sigma = 0.0", "`marks.sigma` must be more than 0"),
        ("sigma = 0", "`marks.sigma` must be more than 0"),
    ] {
        let (_folder, path) = copy("pseudo-mcpherson");
        replace(&path, "study.toml", "sigma = 0.05", change);
        let (code, errors) = said(&path, &["identify", ".", "--out", "out"]);
        assert_eq!(code, 1, "{change}: {errors}");
        assert!(errors.contains(says), "{errors}");
        assert!(!path.join("out").exists());
    }
}

/// Checks that the same readings in the format of a German spreadsheet give the same stiffnesses, and that the assumed format is reported.
#[test]
fn readings_with_semicolons_and_decimal_commas_are_the_same_readings() {
    let answer = |folder: &Path| {
        let (code, errors) = said(
            folder,
            &["identify", ".", "--method", "direct", "--out", "out"],
        );
        assert_eq!(code, 0, "{errors}");
        let text = std::fs::read_to_string(folder.join("out/identified.adm")).expect("written");
        (text, errors)
    };
    let (_folder, points) = copy("pseudo-mcpherson");
    let (_other, commas) = copy("pseudo-mcpherson");
    for name in ["load_cases.csv", "marks_measured.csv", "marks_on_parts.csv"] {
        let text = std::fs::read_to_string(commas.join(name)).expect("readable");
        let text: String = text
            .lines()
            .map(|line| {
                if line.starts_with('#') {
                    format!("{line}\n")
                } else {
                    line.replace(',', ";").replace('.', ",") + "\n"
                }
            })
            .collect();
        std::fs::write(commas.join(name), text).expect("written");
    }
    let ((points, _), (commas, errors)) = (answer(&points), answer(&commas));
    assert_eq!(points, commas);
    assert_eq!(errors.matches("csv-dialect").count(), 3, "{errors}");
    assert!(
        errors.contains("semicolons between the cells, numbers with decimal commas"),
        "{errors}"
    );
}

/// Checks that outputs of an earlier run are replaced. A file that the user wrote or changed is named, and replaced only on request.
#[test]
fn only_outputs_of_an_earlier_run_are_replaced_unasked() {
    let (_folder, path) = copy("pseudo-mcpherson");
    let read = |name: &str| std::fs::read_to_string(path.join(name)).expect("readable");
    let (toml, marks) = (read("study.toml"), read("marks_measured.csv"));
    let rig = ["rig", ".", "--out", ".", "--sigma", "0.01"];
    let (code, errors) = said(&path, &rig);
    assert_eq!(code, 1, "{errors}");
    assert!(
        errors.contains("study.toml") && errors.contains("marks_measured.csv"),
        "{errors}"
    );
    // The deck is not named, because its content would be the same.
    assert!(!errors.contains("model.adm"), "{errors}");
    assert_eq!(
        (read("study.toml"), read("marks_measured.csv")),
        (toml, marks)
    );
    // The same command is run twice.
    for seed in ["1", "2"] {
        let (code, errors) = said(&path, &["rig", ".", "--out", "new", "--seed", seed]);
        assert_eq!((code, errors.as_str()), (0, ""));
    }
    let identify = ["identify", "new", "--method", "direct", "--out", "new"];
    for _ in 0..2 {
        assert_eq!(said(&path, &identify).0, 0);
    }
    let report = path.join("new/report.html");
    std::fs::write(&report, "notes of mine").expect("written");
    let (code, errors) = said(&path, &identify);
    assert_eq!(code, 1);
    assert!(
        errors.contains("report.html") && !errors.contains("identified.adm"),
        "{errors}"
    );
    assert_eq!(read("new/report.html"), "notes of mine");
    let (code, errors) = said(&path, &[&identify[..], &["--force"]].concat());
    assert!(code == 0 && errors.contains("report.html"), "{errors}");
    assert_ne!(read("new/report.html"), "notes of mine");
}

#[test]
fn an_exact_rig_states_a_small_deviation() {
    let (_folder, path) = copy("pseudo-mcpherson");
    let (code, errors) = said(&path, &["rig", ".", "--out", "exact", "--sigma", "0"]);
    assert_eq!(code, 0, "{errors}");
    let toml = std::fs::read_to_string(path.join("exact/study.toml")).expect("written");
    assert!(toml.contains("\nsigma = 0.0001"), "{toml}");
    let (code, errors) = said(
        &path,
        &["identify", "exact", "--method", "direct", "--out", "out"],
    );
    assert_eq!(code, 0, "{errors}");
}
