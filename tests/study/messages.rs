use super::run::{admire, change, copied, corpus};

/// Returns the output of `admire identify` for a changed study.toml, and its exit code.
fn said(from: &str, to: &str) -> (String, i32) {
    let (folder, study) = copied("pseudo-mcpherson");
    change(&study.join("study.toml"), from, to);
    let said = admire(folder.path(), &["identify", "study", "--out", "out"]);
    (said.err, said.code)
}

#[test]
fn a_bound_that_keeps_zero_out_is_said_in_words() {
    let (text, code) = said("sigma = 0.05", "sigma = -1");
    assert_eq!(code, 1);
    assert!(
        text.contains("`marks.sigma` must be a number more than 0"),
        "{text}"
    );
}

#[test]
fn slips_of_the_pen_are_recognised() {
    for (from, to, help) in [
        (
            "\"BUSHING/1\", ",
            "\"BUSING/1\", ",
            "did you mean `BUSHING/1`?",
        ),
        (
            "\"BUSHING/1\", ",
            "\"BUSHING/7\", ",
            "the deck has BUSHING/1, BUSHING/2, BUSHING/3",
        ),
        ("lateral = ", "latral = ", "did you mean `lateral`?"),
        ("\"SFORCE/2\"", "\"SFRCE/2\"", "did you mean `SFORCE/2`?"),
    ] {
        let (text, code) = said(from, to);
        assert_eq!(code, 1);
        assert!(text.contains(help), "{to}: {text}");
    }
}

#[test]
fn nothing_to_identify_is_a_fault_of_the_study_at_its_place() {
    let (text, code) = said("bushings = [\"BUSHING/1\", \"BUSHING/2\"]", "bushings = []");
    assert_eq!(code, 1);
    assert!(
        text.contains("× the study names no parameters to identify"),
        "{text}"
    );
}

#[test]
fn a_deck_is_not_a_study() {
    let folder = tempfile::tempdir().unwrap();
    let deck = corpus("pseudo-mcpherson/model.adm");
    for command in ["identify", "diagnose"] {
        let said = admire(
            folder.path(),
            &[command, deck.to_str().unwrap(), "--out", "out"],
        );
        assert_eq!(said.code, 1);
        let text = said.err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            text.contains("is a deck, not the folder of a study"),
            "{text}"
        );
        assert!(text.contains("admire new STUDY --from"), "{text}");
    }
}

/// Checks that no shims are installed if the solver they would run is missing.
#[test]
fn shims_need_a_solver_to_run() {
    let folder = tempfile::tempdir().unwrap();
    let alone = folder
        .path()
        .join(format!("admire{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_admire"), &alone).unwrap();
    let run = std::process::Command::new(&alone)
        .args(["install-shims", "bin"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&run.stderr).contains("cargo install"));
    assert!(!folder.path().join("bin").exists());
}
