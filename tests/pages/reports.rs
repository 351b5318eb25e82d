use std::path::Path;
use std::process::Command;

use super::browser::{chromium, sound};

/// The page of an identification: its view, its charts and its data, under a deck whose names try to break out.
#[test]
fn the_report_of_an_identification_is_whole() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    std::fs::create_dir(&study).unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    for entry in std::fs::read_dir(shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, study.join(path.file_name().unwrap())).unwrap();
    }
    let deck = study.join("model.adm");
    let text = std::fs::read_to_string(&deck).unwrap();
    let text = text.replacen(
        "adams_view_name='A_J'",
        "adams_view_name='</script><img src=x onerror=alert(1)>'",
        1,
    );
    std::fs::write(&deck, text).unwrap();
    let out = folder.path().join("out");
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["identify", "--method", "direct", "--out"])
        .args([&out, &study])
        .output()
        .unwrap();
    assert!(run.status.code().is_some_and(|code| code == 0 || code == 3));
    let seen = sound(&chromium, &out.join("report.html"));
    assert_eq!(seen.scenes.len(), 1);
    assert_eq!(
        (seen.scenes[0].slider, seen.scenes[0].step),
        (Some(true), Some(true))
    );
    // Two bushings of six directions, the cases, two maps and the convergence.
    assert!(seen.pictures.len() >= 12, "{}", seen.pictures.len());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("<img"));
    assert_eq!(
        page.matches("download=").count(),
        seen.pictures.len(),
        "every figure has its data"
    );
    assert!(page.contains("scope=\"col\"") && page.contains("scope=\"row\""));
}
