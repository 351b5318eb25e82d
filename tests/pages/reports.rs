use std::path::Path;
use std::process::Command;

use admire_report::{Comparison, Curve, ReproducedCurves, ReproducedSection, ReproductionReport};

use super::browser::{Seen, chromium, sound};

fn admire(arguments: &[&str], folder: &Path) {
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{arguments:?}: {said}");
}

/// Checks that every figure has its data, and every table its headings.
fn accessible(page: &Path, seen: &Seen) {
    let page = std::fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("download=").count(), seen.pictures.len());
    assert!(page.contains("scope=\"col\"") && page.contains("scope=\"row\""));
    assert_eq!(
        page.matches("<svg").count(),
        page.matches("role=\"img\" aria-label=").count()
    );
}

/// Checks a report about a compliant tie rod: the page names the tie rod in its first sentences, and marks it in the picture.
#[test]
fn the_report_of_a_diagnosis_is_whole() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let effect = "link-compliance@PART/6:stiffness=6000";
    let rig = [
        "rig",
        shipped.to_str().unwrap(),
        "--out",
        "measured",
        "--programme",
        "up-and-down",
        "--effect",
        effect,
    ];
    admire(&rig, folder.path());
    admire(&["diagnose", "measured", "--out", "out"], folder.path());
    let path = folder.path().join("out/report.html");
    let seen = sound(&chromium, &path);
    assert_eq!(seen.scenes.len(), 1);
    assert_eq!(
        (seen.scenes[0].slider, seen.scenes[0].step),
        (Some(true), Some(true))
    );
    accessible(&path, &seen);
    let page = std::fs::read_to_string(&path).unwrap();
    let lead = page
        .split("<p class=\"lead\">")
        .nth(1)
        .unwrap()
        .split("</p>")
        .next()
        .unwrap();
    assert!(
        lead.contains("link compliance at TIE_ROD (PART/6)"),
        "{lead}"
    );
    assert!(
        lead.contains(
            "These readings do not distinguish it from body compliance at TIE_INNER (JOINT/5)"
        ),
        "{lead}"
    );
    assert!(
        page.contains("PART/6\",\"label\":\"link compliance\"")
            || page.contains("\"label\":\"link compliance\"")
    );
}

/// Checks a page as wide as that of the paper's validations: tables with many columns and long words, and curves.
#[test]
fn the_page_of_the_papers_validations_is_whole() {
    let Some(chromium) = chromium() else { return };
    let texts = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
    let section = ReproducedSection {
        title: "4.3 multilink, all stiffnesses".to_string(),
        tables: vec![Comparison {
            title: "identification of all stiffnesses".to_string(),
            head: texts(&[
                "by",
                "noise mm",
                "iterations",
                "unidentifiable",
                "range of Ki/Kr, identified",
                "median |ln Ki/Kr|",
            ]),
            rows: vec![
                texts(&[
                    "our loop, weights of (16) turned round",
                    "0.05",
                    "200, not converged",
                    "7 of 48",
                    "0.00 to 152.48",
                    "0.587",
                ]),
                texts(&[
                    "our fit",
                    "0.05",
                    "15 sweeps",
                    "19 of 48",
                    "0.76 to 1.73",
                    "0.026",
                ]),
            ],
        }],
        figures: vec![ReproducedCurves {
            title: "figure 9, steer".to_string(),
            x: "lateral force, newton".to_string(),
            y: "steer, degrees".to_string(),
            curves: vec![Curve {
                name: "loop without noise".to_string(),
                points: (-4..=4)
                    .map(|k| (1000.0 * f64::from(k), 0.1 * f64::from(k)))
                    .collect(),
            }],
        }],
        findings: texts(&[
            "The step test of equation 17 was met while BUSHING/1.KT.3 still changes.",
        ]),
        limits: texts(&["Figure 9 has no numbers."]),
    };
    let report = ReproductionReport {
        sections: &[section],
    };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("report.html");
    std::fs::write(&page, report.html().unwrap()).unwrap();
    let seen = sound(&chromium, &page);
    assert_eq!(seen.pictures.len(), 1);
    accessible(&page, &seen);
}

/// Checks the report of the standard tests of an axle.
#[test]
fn the_report_of_the_standard_tests_is_whole() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/multilink");
    let (deck, config) = (shipped.join("model.adm"), shipped.join("kc.toml"));
    admire(
        &[
            "kc",
            deck.to_str().unwrap(),
            "--config",
            config.to_str().unwrap(),
            "--out",
            "out",
        ],
        folder.path(),
    );
    let path = folder.path().join("out/report.html");
    let seen = sound(&chromium, &path);
    assert!(seen.pictures.len() > 20, "{}", seen.pictures.len());
    accessible(&path, &seen);
}

/// Checks the page of an identification: its view, its charts and its data, for a deck with names that contain HTML.
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
    // Two bushings with six directions, the cases, two maps and the convergence.
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

/// Checks the page of a proposed measurement: bars show its gain, and the least known parameter is marked in the picture.
#[test]
fn the_page_of_a_plan_is_whole() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let study = study.to_str().unwrap();
    admire(
        &["plan", study, "--for", "stiffnesses", "--out", "next"],
        folder.path(),
    );
    let path = folder.path().join("next/report.html");
    let seen = sound(&chromium, &path);
    assert!(!seen.pictures.is_empty() && seen.scenes.len() == 1);
    accessible(&path, &seen);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.contains("<p class=\"lead\">Measure next: "));
    assert!(page.contains("\"label\":\"worst determined\""));
}

/// Checks the page for a deck with a fault: it states file, line, code and remedy.
#[test]
fn the_page_of_a_check_names_the_place() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let deck = "a deck\nPART/1,GROUND\nPART/2,MASS=1,CM=99,IP=1,1,1\nMARKER/1,PART=1\nEND\n";
    std::fs::write(folder.path().join("bad.adm"), deck).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["check", "bad.adm", "--out", "pages"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let path = folder.path().join("pages/report.html");
    sound(&chromium, &path);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(
        page.contains("bad.adm:3") && page.contains("undefined-id"),
        "{page}"
    );
    assert!(page.contains("Found: 1 error"), "{page}");
}

/// Checks two runs that differ in one load: the page draws the worst columns of both files, and the differences below.
#[test]
fn the_page_of_a_comparison_shows_the_difference() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let commands = std::fs::read_to_string(shipped.join("lateral.acf")).unwrap();
    for (name, deck) in [("before", "model.adm"), ("after", "reference.adm")] {
        std::fs::copy(shipped.join(deck), folder.path().join("model.adm")).unwrap();
        let own = format!("file/model=model, output_prefix={name}");
        let own = commands.replacen("file/model=model", &own, 1);
        std::fs::write(folder.path().join("run.acf"), own).unwrap();
        admire(&["solve", "run.acf", "--force"], folder.path());
    }
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["compare", "before.res", "after.res", "--out", "pages"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let path = folder.path().join("pages/report.html");
    let seen = sound(&chromium, &path);
    // Four columns and their differences.
    assert_eq!(seen.pictures.len(), 8);
    accessible(&path, &seen);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(
        page.contains("The largest relative difference is in ")
            && page.contains(" in before.res, ")
            && page.contains("Difference: ")
    );
}
