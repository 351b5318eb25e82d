//! Simultaneous runs that write the same files.

use std::fs::File;

use crate::run::{Results, SLIDER, folder, mdi, text};

/// Checks that runs with one prefix are serialised: every file is complete, and all belong to the last run.
#[test]
fn runs_in_one_folder_do_not_mix_their_files() {
    // On Windows files are not locked, because a locked file could not be polled.
    if cfg!(windows) {
        return;
    }
    let place = folder(&[("slider.adm", SLIDER)]);
    let runs = 1..=6_u32;
    for run in runs.clone() {
        // More steps give longer files.
        let acf = format!(
            "\nfile/model=slider\nSFORCE/1, FUNCTION={run}\nSIM/STAT, END=1, STEPS={}\nSTOP\n",
            300 * run
        );
        std::fs::write(place.path().join(format!("run{run}.acf")), acf).unwrap();
    }
    std::thread::scope(|scope| {
        let started: Vec<_> = runs
            .map(|run| {
                let path = place.path();
                scope.spawn(move || mdi(path, &["ru-s", &format!("run{run}")]))
            })
            .collect();
        for run in started {
            let ran = run.join().unwrap();
            assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
        }
    });
    let told = text(place.path(), "slider.msg");
    assert_eq!(told.matches("SFORCE/1, FUNCTION=").count(), 1, "{told}");
    assert_eq!(told.matches("Finished").count(), 1, "{told}");
    let z = Results::read(place.path(), "slider.res").column("block_XFORM", "Z");
    let run = (10.0 * z[0]).round();
    assert!(
        told.contains(&format!("SFORCE/1, FUNCTION={run}\n")),
        "{run}"
    );
    assert_eq!(z.len() as f64, 300.0 * run + 1.0);
    assert!(z.iter().all(|at| (at - z[0]).abs() < 1e-9), "{z:?}");
    let written = text(place.path(), "slider.res");
    assert!(written.trim_end().ends_with("</Results>"));
    assert_eq!(written.matches("<TerminationStatus").count(), 1);
}

/// Checks that a run in progress keeps its files: the other one reports it and changes nothing.
#[test]
fn files_of_a_run_that_goes_on_are_left_alone() {
    // On Windows files are not locked, because a locked file could not be polled.
    if cfg!(windows) {
        return;
    }
    let place = folder(&[
        ("slider.adm", SLIDER),
        ("run.acf", "\nfile/model=slider\nSIM/STAT\nSTOP\n"),
        ("slider.msg", "mine"),
        ("slider.res", "mine"),
    ]);
    let going_on = File::options()
        .append(true)
        .open(place.path().join("slider.msg"))
        .unwrap();
    going_on.lock().unwrap();
    let ran = mdi(place.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("another run is writing"),
        "{}",
        ran.stdout
    );
    for name in ["slider.msg", "slider.res"] {
        assert_eq!(text(place.path(), name), "mine", "{name}");
    }
    drop(going_on);
    let ran = mdi(place.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
}
