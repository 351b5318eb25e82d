//! The commands `check`, `get`, `set`, `diff` and `explain` on files of Adams/Car.

use std::path::{Path, PathBuf};
use std::process::Command;

pub fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name)
}

/// Returns exit code, standard output and standard error.
pub fn admire(folder: &Path, words: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(words)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code().expect("no signal"),
        text(&output.stdout),
        text(&output.stderr),
    )
}

#[test]
fn values_are_printed_changed_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let original = std::fs::read(corpus("adams-car/front.sub")).unwrap();
    std::fs::write(here.join("front.sub"), &original).unwrap();
    let (code, out, _) = admire(
        here,
        &[
            "get",
            "front.sub",
            "HARDPOINT/arm_front.z_value",
            "units.length",
        ],
    );
    assert_eq!((code, out.as_str()), (0, "215.0\nmm\n"));
    let (code, out, _) = admire(
        here,
        &[
            "get",
            "front.sub",
            "BUSHING_ASSEMBLY/*.SYMMETRY",
            "--format",
            "json",
        ],
    );
    let found: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(code, 0);
    assert_eq!(found["BUSHING_ASSEMBLY/top_mount.SYMMETRY"], "left/right");
    let (code, _, _) = admire(
        here,
        &[
            "set",
            "front.sub",
            "HARDPOINT/arm_front.z_value+=2.5",
            "-o",
            "new.sub",
        ],
    );
    assert_eq!(code, 0);
    let new = std::fs::read(here.join("new.sub")).unwrap();
    let text = String::from_utf8(original.clone()).unwrap();
    let expected = text.replace("-400.0       215.0", "-400.0       217.5");
    assert_eq!(String::from_utf8(new).unwrap(), expected);
    let (code, out, _) = admire(here, &["diff", "front.sub", "new.sub"]);
    assert_eq!(
        (code, out.as_str()),
        (1, "HARDPOINT/arm_front.z_value: 215.0 -> 217.5\n")
    );
    assert_eq!(admire(here, &["diff", "front.sub", "front.sub"]).0, 0);
    // Without an assignment the copy is identical.
    assert_eq!(admire(here, &["set", "front.sub", "-o", "copy.sub"]).0, 0);
    assert!(std::fs::read(here.join("copy.sub")).unwrap() == original);
    // Several values at once.
    let pattern = "HARDPOINT/arm_*.y_value*=2";
    assert_eq!(
        admire(here, &["set", "front.sub", pattern, "-o", "wide.sub"]).0,
        0
    );
    let (_, out, _) = admire(here, &["diff", "front.sub", "wide.sub"]);
    assert_eq!(out.lines().count(), 2, "{out}");
}

#[test]
fn what_cannot_be_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::copy(corpus("adams-car/front.sub"), here.join("front.sub")).unwrap();
    std::fs::copy(corpus("adams-car/soft.bus"), here.join("soft.bus")).unwrap();
    let deck = corpus("pseudo-mcpherson/model.adm");
    std::fs::copy(deck, here.join("model.adm")).unwrap();
    for (words, code, says) in [
        (
            vec!["get", "front.sub", "HARDPOINT/arm_frnt.z_value"],
            1,
            "did you mean",
        ),
        (vec!["get", "front.sub", "X"], 1, "BLOCK.KEY"),
        (
            vec!["set", "front.sub", "HARDPOINT/arm_front.z_value=up"],
            1,
            "is a number",
        ),
        (
            vec!["set", "front.sub", "HARDPOINT/arm_front=1"],
            1,
            "name one of them",
        ),
        (
            vec!["set", "front.sub", "UNITS.LENGTH='mm"],
            1,
            "cannot contain a quote",
        ),
        (vec!["set", "front.sub", "UNITS.LENGTH"], 2, "has no `=`"),
        (
            vec!["set", "front.sub", "UNITS.LENGTH*=2"],
            1,
            "is not a number",
        ),
        (
            vec!["set", "front.sub", "HARDPOINT/arm_front.symmetry=both"],
            1,
            "would have a new error",
        ),
        (
            vec!["set", "soft.bus", "FX_CURVE/2.x=7"],
            1,
            "would have a new error",
        ),
        (
            vec!["diff", "front.sub", "model.adm"],
            1,
            "is a file of Adams/Car",
        ),
    ] {
        let (found, out, errors) = admire(here, &words);
        assert_eq!(found, code, "{words:?}: {errors}");
        assert!(errors.contains(says), "{words:?}: {errors}");
        assert_eq!(out, "", "{words:?}");
    }
    let forced = ["set", "soft.bus", "FX_CURVE/2.x=7", "--force"];
    assert_eq!(admire(here, &forced).0, 0);
}

#[test]
fn check_reads_every_file_of_the_corpus() {
    let folder = corpus("adams-car");
    let (code, _, errors) = admire(&folder, &["check", "front.sub", "soft.bus", "coil.spr"]);
    assert_eq!(code, 0, "{errors}");
    let other = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(folder.join("front.sub")).unwrap();
    let bad = text.replace(
        "'arm_front                   '  'left/right'",
        "'arm_rear'  'both'",
    );
    std::fs::write(other.path().join("bad.sub"), bad).unwrap();
    let (code, out, errors) = admire(other.path(), &["check", "bad.sub", "--format", "plain"]);
    let said = out + &errors;
    assert_eq!(code, 1, "{said}");
    assert!(
        said.contains("`both` is not a symmetry") && said.contains("bad.sub:23"),
        "{said}"
    );
}

#[test]
fn words_of_adams_car_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    for word in [
        "hardpoint",
        "subsystem",
        "property file",
        "TeimOrbit",
        "fx_scaling_factor",
        "t_preload_x",
        "hpl_",
        "assembly",
        "template",
        "car.subsystem",
        "car-subsystem",
    ] {
        let (code, out, errors) = admire(folder.path(), &["explain", word]);
        assert_eq!(code, 0, "{word}: {errors}");
        assert!(out.len() > 40, "{word}: {out}");
    }
}
