//! Checks that every byte of a result is independent of the number of threads.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Returns the output of a command and all files that it writes, by name.
fn answer(command: &str, options: &[&str], threads: &str) -> BTreeMap<String, Vec<u8>> {
    let place = tempfile::tempdir().unwrap();
    let study = place.path().join("study");
    std::fs::create_dir(&study).unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    for entry in std::fs::read_dir(shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, study.join(path.file_name().unwrap())).unwrap();
    }
    let ran = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(place.path())
        .arg(command)
        .args(options)
        .args(["--out", "out", "study"])
        .env("RAYON_NUM_THREADS", threads)
        .env("SOURCE_DATE_EPOCH", "951827696")
        .output()
        .unwrap();
    assert!(
        matches!(ran.status.code(), Some(0 | 3)),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let mut all = BTreeMap::from([("standard output".to_string(), ran.stdout)]);
    let mut open = vec![place.path().join("out")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(place.path()).unwrap();
                all.insert(name.display().to_string(), std::fs::read(&path).unwrap());
            }
        }
    }
    all
}

fn assert_same(command: &str, options: &[&str]) {
    let (one, four) = (answer(command, options, "1"), answer(command, options, "4"));
    assert!(one.len() >= 3, "{:?}", one.keys());
    let report = String::from_utf8_lossy(&one["out/report.html"]);
    assert!(report.contains("<dd>2000-02-29 12:34:56 UTC</dd>"));
    assert!(one.keys().eq(four.keys()), "{:?}", four.keys());
    for (name, bytes) in &one {
        assert!(*bytes == four[name], "{command}: {name} differs");
    }
}

#[test]
fn an_identification_has_the_same_bytes_on_any_number_of_threads() {
    assert_same("identify", &[]);
}

#[test]
fn a_diagnosis_has_the_same_bytes_on_any_number_of_threads() {
    assert_same("diagnose", &[]);
}
