//! The command `admire` as a process.

use std::path::Path;
use std::process::{Command, Output};

use crate::run::{SLIDER, folder, text};

fn admire(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(words)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn values_are_read_and_set_without_touching_anything_else() {
    let folder = folder(&[("slider.adm", SLIDER)]);
    let run = |words: &[&str]| admire(folder.path(), words);
    let got = run(&[
        "get",
        "slider.adm",
        "SPRINGDAMPER/1.K",
        "guide",
        "MARKER/21.QP",
        "block.MASS",
    ]);
    assert_eq!(
        said(&got),
        "10\nJOINT/1, TRANSLATIONAL, I=20, J=1\n0, 0, 50\n2\n"
            .replace("10\n", "10.0\n")
            .replace("2\n", "2.0\n")
            .replace("0, 0, 50", "0.0, 0.0, 50.0")
    );
    assert_eq!(run(&["set", "slider.adm"]).stdout, SLIDER.as_bytes());
    let set = run(&[
        "set",
        "slider.adm",
        "SPRINGDAMPER/1.K=12.5",
        "SFORCE/1.FUNCTION=20*TIME",
        "-o",
        "new.adm",
    ]);
    assert!(set.status.success(), "{set:?}");
    let expected = SLIDER
        .replace("K=10", "K=12.5")
        .replace("10*TIME", "20*TIME");
    assert_eq!(text(folder.path(), "new.adm"), expected);
    let changed = run(&["diff", "slider.adm", "new.adm"]);
    assert_eq!(changed.status.code(), Some(1));
    assert_eq!(
        said(&changed),
        "SPRINGDAMPER/1.K.1: 10 -> 12.5\nSFORCE/1.FUNCTION: 10*TIME -> 20*TIME\n"
    );
    for (assignment, code) in [
        ("SPRINGDAMPER/1.K=stiff", "wrong-type"),
        ("SFORCE/1.FUNCTION=STPE(TIME,0,0,1,1)", "bad-expression"),
    ] {
        let refused = run(&["set", "slider.adm", assignment, "-o", "bad.adm"]);
        assert_eq!(refused.status.code(), Some(1), "{refused:?}");
        let why = String::from_utf8_lossy(&refused.stderr);
        assert!(why.contains(code), "{why}");
        assert!(!folder.path().join("bad.adm").exists());
    }
    let wrong = run(&["set", "slider.adm", "SPRINGDAMPER/2.K=1", "--in-place"]);
    assert_eq!(wrong.status.code(), Some(1));
    assert_eq!(text(folder.path(), "slider.adm"), SLIDER);
}

#[test]
fn exit_codes_tell_what_happened() {
    let broken = SLIDER.replace("I=21, J=11", "I=99, J=11");
    let free = SLIDER.replace("K=10", "K=0").replace("10*TIME", "5");
    let folder = folder(&[
        ("slider.adm", SLIDER),
        ("broken.adm", &broken),
        ("free.adm", &free),
    ]);
    let code = |words: &[&str]| admire(folder.path(), words).status.code();
    std::fs::write(
        folder.path().join("bare.adm"),
        "t\nPART/1, GROUND\nSFORCE/1\nEND\n",
    )
    .unwrap();
    let bare = said(&admire(
        folder.path(),
        &["check", "--format", "plain", "bare.adm"],
    ));
    assert_eq!(bare.matches("needs I").count(), 1, "{bare}");
    assert_eq!(code(&["check", "slider.adm"]), Some(0));
    assert_eq!(code(&["check", "broken.adm"]), Some(1));
    assert_eq!(code(&["check", "missing.adm"]), Some(1));
    assert_eq!(code(&["chekc", "slider.adm"]), Some(2));
    assert_eq!(code(&["solve", "slider.adm"]), Some(0));
    assert_eq!(code(&["solve", "broken.adm"]), Some(1));
    assert_eq!(code(&["solve", "free.adm"]), Some(3));
    assert_eq!(code(&["explain", "BUSHING"]), Some(0));
    assert_eq!(code(&["explain", "BUSHNIG"]), Some(1));
}

#[test]
fn results_are_listed_taken_out_and_compared() {
    let acf = |k: &str| {
        format!(
            "\nfile/model=slider, output_prefix=r{k}\nSPRINGDAMPER/1, K={k}\nSIM/STAT, END=1, STEPS=2\n"
        )
    };
    let folder = folder(&[
        ("slider.adm", SLIDER),
        ("first.acf", &acf("10")),
        ("second.acf", &acf("20")),
    ]);
    for name in ["first", "second"] {
        assert_eq!(crate::run::mdi(folder.path(), &["ru-s", name]).code, 0);
    }
    let run = |words: &[&str]| admire(folder.path(), words);
    assert!(said(&run(&["results", "r10.res"])).contains("quasiStatic_001: 3 steps"));
    let csv = said(&run(&[
        "results",
        "r10.res",
        "--get",
        "time.TIME",
        "travel.dz",
    ]));
    assert_eq!(csv.lines().next(), Some("step,time.TIME [sec],travel.dz"));
    assert_eq!(csv.lines().count(), 1 + 4, "{csv}");
    assert_eq!(
        run(&["results", "r10.res", "--get", "nothing"])
            .status
            .code(),
        Some(1)
    );
    assert_eq!(
        run(&["compare", "r10.res", "r10.res"]).status.code(),
        Some(0)
    );
    let differs = run(&["compare", "r10.res", "r20.res", "--abs", "1e-9"]);
    assert_eq!(differs.status.code(), Some(1));
    assert!(
        said(&differs).contains("block_XFORM.Z"),
        "{}",
        said(&differs)
    );
    assert_eq!(
        run(&["compare", "r10.res", "r20.res", "--abs", "10"])
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn a_study_is_identified_into_a_deck_numbers_and_a_report() {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let folder = folder(&[]);
    let run = admire(
        folder.path(),
        &["identify", study.to_str().unwrap(), "--out", "here"],
    );
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let out = folder.path().join("here");
    let json: serde_json::Value = serde_json::from_str(&text(&out, "identification.json")).unwrap();
    let parameters = json["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 12);
    // The best-determined stiffness of the study: Kx of B is known to 0.2 percent, with the reference value 310 N/mm.
    let kx = parameters
        .iter()
        .find(|p| p["address"] == "BUSHING/2.K.1")
        .unwrap();
    assert!(
        (kx["value"].as_f64().unwrap() / 310.0 - 1.0).abs() < 0.01,
        "{kx}"
    );
    let deck = std::fs::read_to_string(study.join("model.adm")).unwrap();
    let identified = text(&out, "identified.adm");
    let changed = deck.lines().zip(identified.lines()).filter(|(a, b)| a != b);
    assert!(changed.clone().count() == 4 && changed.clone().all(|(_, b)| b.contains('K')));
    assert_eq!(deck.lines().count(), identified.lines().count());
    let report = text(&out, "report.html");
    // The links of a page contain its data or lead to its parts; none leads out of it.
    let links = report.matches("href=").count();
    let inside = ["href=\"data:text/csv", "href=\"#"].map(|link| report.matches(link).count());
    assert_eq!(links, inside.iter().sum::<usize>());
    assert!(report.contains("B (BUSHING/2.K.1)") && !report.contains("src="));
}
