//! End of a run: the exit code, the status in the results, and the last line.

use crate::run::{Results, SLIDER, folder, mdi, mdi_with, text};

const CONTACT: &str = "GRAPHICS/1, CYLINDER, CM=20, LENGTH=5, RADIUS=5\nGRAPHICS/2, CYLINDER, CM=1, LENGTH=5, RADIUS=5\n\
    ! adams_view_name='stop'\nCONTACT/7, IGEOM=1, JGEOM=2, IMPACT, STIFFNESS=1E5, DAMPING=1, DMAX=0.1, EXPONENT=2\n";

fn with(statements: &str) -> String {
    SLIDER.replace("EQUILIBRIUM/", &format!("{statements}EQUILIBRIUM/"))
}

fn status(folder: &std::path::Path) -> String {
    let results = text(folder, "slider.res");
    let (_, rest) = results.split_once("runStatus=\"").unwrap_or_default();
    rest.split('"').next().unwrap_or_default().to_string()
}

/// Checks that an unsupported element with load ends the simulation by name: no step, code 1 in both modes, no success in the results.
#[test]
fn what_is_not_solved_ends_the_simulation_by_name() {
    let tyre = "TIRE/3, I=20, J=1\n";
    let user = "SFORCE/7, TRANSLATIONAL, I=21, J=11, FUNCTION=USER(1)\n";
    for (statements, names, effect) in [
        (
            CONTACT,
            "CONTACT/7 'stop'",
            "the contact forces are missing",
        ),
        (tyre, "TIRE/3", "the tyre force is missing"),
        (user, "SFORCE/7", "a force is missing"),
    ] {
        let acf =
            "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSIM/STAT\nSIM/STAT, END=1, STEPS=2\nSTOP\n";
        let folder = folder(&[("slider.adm", &with(statements)), ("run.acf", acf)]);
        for strict in ["0", "1"] {
            let ran = mdi_with(
                folder.path(),
                &["ru-s", "run"],
                "",
                &[("MDI_STRICT", strict)],
            );
            assert_eq!(ran.code, 1, "{}", ran.stdout);
            // The element is named once, and neither of the two simulations is executed.
            assert_eq!(
                ran.stdout.matches(&format!("{names} ")).count(),
                1,
                "{}",
                ran.stdout
            );
            let refused = ran.stdout.matches("this simulation is not executed");
            assert_eq!(refused.count(), 2, "{}", ran.stdout);
            assert!(ran.stdout.contains(effect), "{}", ran.stdout);
            assert!(Results::read(folder.path(), "slider.res").steps.is_empty());
            assert!(text(folder.path(), "slider.res").contains("block_XFORM"));
            assert_eq!(status(folder.path()), "Failed");
        }
        let kind = names.split('/').next().unwrap();
        let ran = mdi_with(
            folder.path(),
            &["ru-s", "run"],
            "",
            &[("ADMIRE_IGNORE", kind)],
        );
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let said = ran.stdout.matches("is left out as requested").count();
        assert_eq!(said, 1, "{}", ran.stdout);
        assert_eq!(ran.stdout, text(folder.path(), "slider.msg"));
        let z = Results::read(folder.path(), "slider.res").column("block_XFORM", "Z");
        assert!(z.len() == 4 && (z[0] - 0.5).abs() < 1e-9, "{z:?}");
        assert_eq!(status(folder.path()), "Successful");

        // A deactivated element does not end the simulation; a reactivated one does.
        let acf = acf.replacen(
            "SIM/STAT",
            &format!("DEACTIVATE/{kind}, ID=3, 7\nSIM/STAT"),
            1,
        );
        if kind != "TIRE" {
            std::fs::write(folder.path().join("run.acf"), &acf).unwrap();
            let ran = mdi(folder.path(), &["ru-s", "run"]);
            assert_eq!(ran.code, 0, "{acf} {}", ran.stdout);
            let acf = acf.replacen("STOP", &format!("ACTIVATE/{kind}, ID=7\nSIM/STAT\nSTOP"), 1);
            std::fs::write(folder.path().join("run.acf"), &acf).unwrap();
            assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 1);
        }
    }
    let empty = folder(&[]);
    let ran = mdi_with(
        empty.path(),
        &["ru-s", "x"],
        "",
        &[("ADMIRE_IGNORE", "PART")],
    );
    assert!(
        ran.code == 2 && ran.stdout.contains("`PART` cannot be left out"),
        "{}",
        ran.stdout
    );
}

/// Checks the same options of `admire solve`, whose JSON lists the elements left out.
#[test]
fn admire_solve_leaves_out_what_it_is_told_to() {
    let folder = folder(&[
        ("slider.adm", &with(CONTACT)),
        ("run.acf", "\nfile/model=slider\nSIM/STAT\n"),
    ]);
    let solve = |words: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .arg("solve")
            .args(words)
            .output()
            .unwrap()
    };
    assert_eq!(solve(&["slider.adm"]).status.code(), Some(1));
    assert_eq!(solve(&["run.acf"]).status.code(), Some(1));
    assert_eq!(
        solve(&["run.acf", "--ignore", "CONTACT"]).status.code(),
        Some(0)
    );
    assert_eq!(
        solve(&["slider.adm", "--ignore", "MARKER"]).status.code(),
        Some(2)
    );
    let found = solve(&["slider.adm", "--ignore", "CONTACT/7", "--format", "json"]);
    let found: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    let said = found["left_out"][0].as_str().unwrap();
    assert!(
        said.starts_with("CONTACT/7 'stop' is left out as requested"),
        "{said}"
    );
}

/// Checks every row of the table in the documentation.
#[test]
fn codes_and_statuses_are_those_of_the_table() {
    for (commands, usual, strict, run_status) in [
        ("SIM/STAT", 0, 0, "Successful"),
        (
            "SHOW/NOTHING=5\nSIM/STAT\nexit\nthis is not read",
            0,
            0,
            "Successful",
        ),
        ("RESULTS/XRF\nSIM/STAT", 0, 0, "Successful"),
        ("SFORCE/99, FUNCTION=5\nSIM/STAT", 0, 0, "Successful"),
        ("SIM/INITIAL_CONDITIONS\nSIM/STAT", 0, 0, "Successful"),
        (
            "SFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, K=0\nSIM/STAT",
            0,
            3,
            "Failed",
        ),
        ("SIM/STAT\nSIM/DYNAMIC, END=1, STEPS=5", 0, 0, "Successful"),
        ("SIM/STAT\nLINEAR/EIGENSOL", 0, 0, "Successful"),
        ("SIM/STAT\nLINEAR/MKB", 1, 1, "Failed"),
        ("SIM/STAT\nSFORSE/1, FUNCTION=5", 1, 1, "Successful"),
    ] {
        let acf = format!("\nfile/model=slider\n{commands}\n");
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
        for (mode, code) in [("0", usual), ("1", strict)] {
            let ran = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", mode)]);
            assert_eq!(ran.code, code, "{commands}: {}", ran.stdout);
            assert_eq!(status(folder.path()), run_status, "{commands}");
        }
        if commands.contains("SFORCE/99") {
            let said = text(folder.path(), "slider.msg");
            assert!(
                said.contains("SFORCE/99 is not defined in the data set. Command ignored."),
                "{said}"
            );
        }
    }
    let page = include_str!("../../src/guide/drop_in.md");
    let help = mdi(std::path::Path::new("."), &["--help"]).stdout;
    for row in help
        .lines()
        .filter(|line| line.ends_with("Failed") || line.ends_with("Successful"))
    {
        let numbers: Vec<&str> = row
            .split_whitespace()
            .filter(|w| w.len() == 1 && w.parse::<u8>().is_ok())
            .collect();
        let status = row.split_whitespace().last().unwrap();
        let cells = format!("| {} | {} | {status} |", numbers[0], numbers[1]);
        assert!(page.contains(&cells), "{row}: {cells}");
    }
}

/// Checks that a full disk is reported in the last line.
#[cfg(unix)]
#[test]
fn a_full_disk_is_said_in_the_last_line() {
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=500\nSTOP\n";
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
    // No file may exceed 8 blocks; the signal of this limit is ignored, because a full disk sends none.
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{}' ru-s run",
        env!("CARGO_BIN_EXE_mdi")
    );
    let output = std::process::Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", &script])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let last = said.trim_end().lines().last().unwrap();
    assert!(
        last.starts_with("The run is not complete: ") && last.contains("cannot be written"),
        "{last}"
    );
}

/// Checks that a model of the same name elsewhere is mentioned, and that several candidates are refused.
#[test]
fn a_wrong_path_is_told_and_never_guessed() {
    let folder = folder(&[("slider.adm", SLIDER)]);
    let sub = folder.path().join("runs");
    std::fs::create_dir(&sub).unwrap();
    std::fs::write(
        sub.join("run.acf"),
        "\nfile/model=C:\\wrong\\slider.adm\nSIM/STAT\nSTOP\n",
    )
    .unwrap();
    let ran = mdi(folder.path(), &["ru-s", "runs/run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let here = dunce::canonicalize(folder.path().join("slider.adm")).unwrap();
    let line = format!(
        "`{}` is read in place of `C:\\wrong\\slider.adm`, which does not exist",
        here.display()
    );
    assert!(ran.stdout.contains(&line), "{}", ran.stdout);
    std::fs::write(sub.join("slider.adm"), SLIDER.replace("K=10", "K=20")).unwrap();
    let ran = mdi(folder.path(), &["ru-s", "runs/run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("several files could be meant"),
        "{}",
        ran.stdout
    );
}
