//! SAVE and RELOAD of states and whole systems, in the same run and in another one.

use crate::run::{Results, SLIDER, folder, mdi};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
    }
}

fn run(commands: &str) -> (tempfile::TempDir, crate::run::Ran) {
    let acf = format!("\nfile/model=slider\n{commands}\n");
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (folder, ran)
}

/// Checks that a buffer holds only states and ends with the run (`com_reload`): redefinitions of the model in between remain.
#[test]
fn buffers_hold_states_without_the_model() {
    let (folder, ran) = run(
        "SIM/STAT, END=1, STEPS=1\nSAVE/STATES, BUFFER=early\nSFORCE/1, FUNCTION=5\nSIM/STAT, END=2, STEPS=1\n\
         RELOAD/STATES, BUFFER=early\nSIM/STAT",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "slider.res");
    // The redefined model starts with its own output, and it stays redefined at the restored time: z = F / K.
    near(&results.column("time", "TIME"), &[0.0, 1.0, 1.0, 2.0, 1.0]);
    near(
        &results.column("block_XFORM", "Z"),
        &[0.0, 1.0, 0.5, 0.5, 0.5],
    );
    let (_folder, ran) = run("SIM/STAT\nRELOAD/STATES, BUFFER=never");
    assert!(ran.stdout.contains("buffer `never`"), "{}", ran.stdout);
}

/// Checks that RELOAD or FILE with OUTPUT_PREFIX redirects later output to new files (`com_reload`, `com_file`); earlier files remain.
#[test]
fn output_goes_to_a_new_name_from_a_command_on() {
    let z = |folder: &tempfile::TempDir, name: &str| {
        Results::read(folder.path(), name).column("block_XFORM", "Z")
    };
    for command in [
        "RELOAD/SYSTEM, FILE=here.sav, OUTPUT_PREFIX=second",
        "RELOAD/SYSTEM, FILE=here.sav, OUTPUT_PREFIX=second, TITLE=other",
        "FILE/OUTPUT_PREFIX=second",
        "FILE/MODEL=slider, OUTPUT_PREFIX=second",
    ] {
        let (folder, ran) = run(&format!(
            "SAVE/SYSTEM, FILE=here.sav\nSFORCE/1, FUNCTION=5\nSIM/STAT\n{command}\nSFORCE/1, FUNCTION=7\nSIM/STAT\nSIM/STAT, END=1, STEPS=2"
        ));
        assert_eq!(ran.code, 0, "{command}: {}", ran.stdout);
        near(&z(&folder, "slider.res"), &[0.5]);
        near(&z(&folder, "second.res"), &[0.7, 0.7, 0.7, 0.7]);
        let first = std::fs::read_to_string(folder.path().join("slider.res")).unwrap();
        assert!(first.contains("Successful"), "{command}: {first}");
        for name in ["second.req", "second.msg"] {
            assert!(folder.path().join(name).is_file(), "{command}: {name}");
        }
    }
    // A prefix equal to the current name changes nothing.
    let (folder, ran) = run(
        "SAVE/SYSTEM, FILE=here.sav\nSIM/STAT\nRELOAD/SYSTEM, FILE=here.sav, OUTPUT_PREFIX=slider\nSFORCE/1, FUNCTION=5\nSIM/STAT",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    near(&z(&folder, "slider.res"), &[0.0, 0.5]);
}

/// Checks that characters at which ADAMS ends a file name do not become part of the name.
#[test]
fn no_comma_in_the_name_of_a_saved_state() {
    let (folder, ran) = run("SAVE/SYSTEM, FILE=here.sav, FORMATTED\nSIM/STAT");
    assert!(
        ran.stdout
            .contains("`FORMATTED` is not an argument of SAVE")
    );
    assert_ne!(ran.code, 0);
    assert!(!folder.path().join("here.sav, FORMATTED").exists());
    let (_folder, ran) =
        run("SAVE/SYSTEM, FILE=here.sav\nRELOAD/SYSTEM, FILE=here.sav, FORMATTED\nSIM/STAT");
    assert!(
        ran.stdout
            .contains("`FORMATTED` is not an argument of RELOAD")
    );
    assert_eq!(ran.code, 1);
}

#[test]
fn saved_states_come_back() {
    let (folder, ran) = run(
        "SIM/STAT, END=1, STEPS=1\nSAVE/FILE=here.sav\nSIM/STAT, END=2, STEPS=1\nRELOAD/FILE=here.sav\nSIM/STAT",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "slider.res");
    near(&results.column("time", "TIME"), &[0.0, 1.0, 2.0, 1.0]);
    std::fs::write(
        folder.path().join("run.acf"),
        "\nfile/model=slider\nRELOAD/FILE=here.sav\nSIM/STAT\n",
    )
    .unwrap();
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    near(
        &Results::read(folder.path(), "slider.res").column("block_XFORM", "Z"),
        &[1.0],
    );
}

/// Checks that a saved system brings its model with all redefinitions into a run without a dataset (`com_reload`).
#[test]
fn a_saved_system_brings_its_model() {
    let (folder, ran) = run(
        "SFORCE/1, &\n, FUNCTION=5+0*TIME\nSIM/STAT, END=1, STEPS=1\nSPRINGDAMPER/1, K=20\nACTIVATE/JOINT, ID=1\n\
         SAVE/SYSTEM, FILE=here.sav\nSPRINGDAMPER/1, K=40\nSAVE/STATES, FILE=place.sav",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    std::fs::remove_file(folder.path().join("slider.adm")).unwrap();
    let again = |commands: &str| {
        std::fs::write(folder.path().join("run.acf"), format!("\n{commands}\n")).unwrap();
        mdi(folder.path(), &["ru-s", "run"])
    };
    let ran = again(
        "RELOAD/SYSTEM, FILE=here.sav, OUTPUT_PREFIX=second\nSIM/STAT\nSIM/STAT, END=2, STEPS=1",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "second.res");
    // The single solution, then the sequence with its start.
    near(&results.column("block_XFORM", "Z"), &[0.25, 0.25, 0.25]);
    near(&results.column("time", "TIME"), &[1.0, 1.0, 2.0]);
    assert!(folder.path().join("second.msg").exists());
    // Without a prefix the output files have the name of the dataset.
    let ran = again("RELOAD/FILE=here.sav\nSIM/STAT");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    near(
        &Results::read(folder.path(), "slider.res").column("block_XFORM", "Z"),
        &[0.25],
    );
    // Saved states contain no model, and a truncated file is reported.
    let ran = again("RELOAD/FILE=place.sav\nSIM/STAT");
    assert!(
        ran.code == 1 && ran.stdout.contains("no model was read"),
        "{}",
        ran.stdout
    );
    let ran = again("RELOAD/STATES, FILE=here.sav\nSIM/STAT");
    assert!(
        ran.code == 1 && ran.stdout.contains("no model was read"),
        "{}",
        ran.stdout
    );
    let whole = std::fs::read(folder.path().join("here.sav")).unwrap();
    std::fs::write(folder.path().join("here.sav"), &whole[..whole.len() - 9]).unwrap();
    let ran = again("RELOAD/FILE=here.sav\nSIM/STAT");
    assert!(
        ran.code == 1 && ran.stdout.contains("damaged"),
        "{}",
        ran.stdout
    );
}

/// Checks that the model of a saved system replaces another one only until the output files have columns of the other model.
#[test]
fn a_saved_system_replaces_another_model() {
    let (folder, ran) = run("SFORCE/1, FUNCTION=5\nSAVE/SYSTEM, FILE=here.sav");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let stiffer = SLIDER.replace("K=10", "K=50");
    assert_ne!(stiffer, SLIDER);
    std::fs::write(folder.path().join("slider.adm"), stiffer).unwrap();
    let again = |commands: &str| {
        let acf = format!("\nfile/model=slider\n{commands}\n");
        std::fs::write(folder.path().join("run.acf"), acf).unwrap();
        mdi(folder.path(), &["ru-s", "run"])
    };
    let ran = again("RELOAD/SYSTEM, FILE=here.sav\nSIM/STAT");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let z = || Results::read(folder.path(), "slider.res").column("block_XFORM", "Z");
    near(&z(), &[0.5]);
    let ran = again("SFORCE/1, FUNCTION=5\nSIM/STAT\nRELOAD/SYSTEM, FILE=here.sav\nSIM/STAT");
    assert!(
        ran.code == 1 && ran.stdout.contains("contains another model"),
        "{}",
        ran.stdout
    );
    near(&z(), &[0.1, 0.1]);
}
