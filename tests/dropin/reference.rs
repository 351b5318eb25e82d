use serde_json::Value;

use crate::common::shared;
use crate::run::{Results, mdi};

/// Compares positions and 3-1-3 angles of every part in every case with the independent implementation of ../shared/reference.
fn agrees(folder: &str, stem: &str) {
    let source = shared(&format!("reference/{folder}"));
    let Some(source) = source else { return };
    let work = tempfile::tempdir().unwrap();
    for extension in ["adm", "acf"] {
        let name = format!("{stem}.{extension}");
        std::fs::copy(source.join(&name), work.path().join(&name)).unwrap();
    }
    let ran = mdi(
        work.path(),
        &["-c", "ru-standard", "i", &format!("{stem}.acf"), "exit"],
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let expected = std::fs::read(source.join(format!("{stem}.expected.json"))).unwrap();
    let expected: Value = serde_json::from_slice(&expected).unwrap();
    let cases = expected["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 13);
    let results = Results::read(work.path(), &format!("{stem}.res"));
    assert_eq!(results.steps.len(), 13);
    for (k, case) in cases.iter().enumerate() {
        for (part, pose) in case["parts"].as_object().unwrap() {
            let entity = format!("{part}_XFORM");
            let values = |names: [&str; 3]| names.map(|name| results.column(&entity, name)[k]);
            for (axis, found) in values(["X", "Y", "Z"]).into_iter().enumerate() {
                let position = pose["pos"][axis].as_f64().unwrap();
                assert!(
                    (found - position).abs() < 1e-6,
                    "case {k} {part}: {found} {position}"
                );
            }
            let [psi, theta, phi] = values(["PSI", "THETA", "PHI"]);
            let found = admire_solver::mechanics::euler313(psi, theta, phi);
            for row in 0..3 {
                for column in 0..3 {
                    let entry = pose["A"][row][column].as_f64().unwrap();
                    let difference = (found[(row, column)] - entry).abs();
                    assert!(difference < 1e-8, "case {k} {part}: {difference:e}");
                }
            }
        }
        for (bushing, forces) in case["bushings"].as_object().unwrap() {
            for (axis, name) in ["FX", "FY", "FZ"].into_iter().enumerate() {
                let found = results.column(bushing, name)[k];
                let force = forces["F_on_I_ground"][axis].as_f64().unwrap();
                assert!(
                    (found - force).abs() < 1e-3,
                    "case {k} {bushing}: {found} {force}"
                );
            }
        }
    }
}

#[test]
fn the_pseudo_mcpherson_is_solved_in_all_cases() {
    agrees("pseudo-mcpherson", "mcph_ref");
}

#[test]
fn the_multilink_axle_is_solved_in_all_cases() {
    agrees("multilink", "ocp_ref");
}

/// Returns the lines that name columns, with angles in radians; runs driven by SolidWorks have degrees.
fn columns(results: &std::path::Path) -> Vec<String> {
    let bytes = std::fs::read(results).unwrap();
    String::from_utf8_lossy(&bytes)
        .lines()
        .filter(|line| {
            ["<Units", "<Entity", "<Component"]
                .iter()
                .any(|tag| line.starts_with(tag))
        })
        .map(|line| line.replace("\"deg", "\"rad"))
        .collect()
}

/// Compares our results with real ADAMS results of the same decks.
///
/// Entities and columns must have the same numbers, units and order, line for line.
#[test]
fn columns_are_those_of_adams() {
    let Some(decks) = shared("real-decks") else {
        return;
    };
    let mut compared = 0;
    for deck in crate::common::files_below(&decks, "adm") {
        let results = deck.with_extension("res");
        if !results.exists() {
            continue;
        }
        let work = tempfile::tempdir().unwrap();
        std::fs::copy(&deck, work.path().join("deck.adm")).unwrap();
        std::fs::write(
            work.path().join("run.acf"),
            "\nfile/model=deck\nSIM/STAT\nSTOP\n",
        )
        .unwrap();
        let ran = mdi(work.path(), &["ru-s", "run"]);
        if ran.code != 0 {
            // Decks that only ADAMS can solve are refused and have no results.
            continue;
        }
        let (ours, theirs) = (columns(&work.path().join("deck.res")), columns(&results));
        for (a, b) in ours.iter().zip(&theirs) {
            assert_eq!(a, b, "{}", deck.display());
        }
        assert_eq!(ours.len(), theirs.len(), "{}", deck.display());
        compared += 1;
    }
    assert!(compared >= 3, "only {compared} pairs were compared");
}
