use std::collections::BTreeSet;

use serde_json::Value;

use super::run::{admire, copied};

/// Fields whose own fields are names from the study: addresses, loads, parameters of a cause, tolerance groups.
const OWN_NAMES: [&str; 4] = ["combination", "parameters", "std_error", "case"];

fn fields(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let last = path.rsplit('.').next().unwrap_or_default();
                if path == "tolerances" {
                    fields(value, path, found);
                    continue;
                }
                if !path.is_empty()
                    && OWN_NAMES.contains(&last)
                    && !value.is_array()
                    && !value.is_object()
                    && (last != "parameters" || path.contains("findings"))
                    && path.contains('.')
                {
                    continue;
                }
                let whole = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}.{key}")
                };
                found.insert(whole.clone());
                fields(value, &whole, found);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| fields(item, path, found)),
        _ => {}
    }
}

/// Checks that `admire explain` explains every field of the results.
#[test]
fn every_field_of_the_answers_is_explained() {
    // One axle has a wheel and held-out cases; the other has a compliant tie rod.
    let (folder, _study) = copied("kc-experiment");
    let identified = admire(folder.path(), &["identify", "study", "--out", "out"]);
    assert_eq!(identified.code, 0, "{}", identified.err);
    let (other, _study) = copied("pseudo-mcpherson");
    let effect = "link-compliance@PART/6:stiffness=6000";
    let measured = admire(
        other.path(),
        &[
            "rig",
            "study",
            "--out",
            "measured",
            "--programme",
            "up-and-down",
            "--effect",
            effect,
        ],
    );
    assert_eq!(measured.code, 0, "{}", measured.err);
    let diagnosed = admire(other.path(), &["diagnose", "measured", "--out", "out"]);
    assert_eq!(diagnosed.code, 0, "{}", diagnosed.err);
    let mut found = BTreeSet::new();
    for path in [
        folder.path().join("out/identification.json"),
        other.path().join("out/diagnosis.json"),
    ] {
        let text = std::fs::read_to_string(path).unwrap();
        fields(&serde_json::from_str(&text).unwrap(), "", &mut found);
    }
    assert!(found.len() > 60, "{found:?}");
    let lacking: Vec<&String> = found
        .iter()
        .filter(|field| !admire_guide::glossary::entries().any(|entry| entry.term == **field))
        .collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    let said = admire(
        folder.path(),
        &["explain", "findings.gain.held_out_rms_after"],
    );
    assert_eq!(said.code, 0, "{}", said.err);
}

/// Checks that every column and field of the K&C tests and of a sweep is explained, with component and unit as spelled in the file.
#[test]
fn every_column_of_the_tables_is_explained() {
    let (folder, _study) = copied("multilink");
    let said = admire(
        folder.path(),
        &[
            "kc",
            "study/model.adm",
            "--config",
            "study/kc.toml",
            "--out",
            "kc",
        ],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    let (other, study) = copied("pseudo-mcpherson");
    super::run::change(&study.join("sweep.toml"), "cases = 1000", "cases = 6");
    let swept = admire(
        other.path(),
        &["sweep", "study/sweep.toml", "--out", "sweep"],
    );
    assert_eq!(swept.code, 0, "{}", swept.err);
    let mut found = BTreeSet::new();
    for path in [
        folder.path().join("kc/kc.json"),
        other.path().join("sweep/summary.json"),
    ] {
        let text = std::fs::read_to_string(path).unwrap();
        fields(&serde_json::from_str(&text).unwrap(), "", &mut found);
    }
    for name in ["curves.csv", "gradients.csv"] {
        let text = std::fs::read_to_string(folder.path().join("kc").join(name)).unwrap();
        let head = text.lines().find(|line| !line.starts_with('#')).unwrap();
        found.extend(head.split(',').map(ToString::to_string));
    }
    assert!(found.len() > 200, "{}", found.len());
    let lacking: Vec<&String> = found
        .iter()
        .filter(|word| admire_guide::glossary::find(word).is_empty())
        .collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    let said = admire(folder.path(), &["explain", "toe_angle.left [rad]"]);
    assert!(
        said.code == 0 && said.out.contains("toe-in"),
        "{}",
        said.out
    );
}

/// Checks that the explained causes are those that the code names in `diagnosis.json`.
#[test]
fn every_cause_is_explained() {
    let code = include_str!("../../src/diagnosis/cause.rs");
    let causes: Vec<&str> = code
        .lines()
        .filter_map(|line| {
            line.trim()
                .strip_prefix("Self::")?
                .split_once("=> \"")?
                .1
                .strip_suffix("\",")
        })
        .collect();
    assert!(causes.len() >= 18, "{causes:?}");
    let folder = tempfile::tempdir().unwrap();
    for cause in causes {
        let said = admire(folder.path(), &["explain", cause]);
        assert_eq!(said.code, 0, "{cause}");
        assert!(
            said.out.contains("address:") && said.out.contains("meaning:"),
            "{}",
            said.out
        );
    }
}

/// Returns the words that a message lists as allowed: the words in backticks after "expected".
fn expected(complaint: &str) -> Vec<String> {
    let (_, rest) = complaint
        .split_once("expected")
        .unwrap_or_else(|| panic!("{complaint}"));
    let line = rest.lines().next().unwrap_or_default();
    let words = line.split('`').skip(1).step_by(2);
    words.map(str::to_string).collect()
}

/// Checks that every key of `kc.toml` and of SWEEP.toml is explained. The messages of the readers list the allowed keys.
#[test]
fn every_key_of_the_other_settings_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let deck = "A DECK\nPART/1, GROUND\nEND\n";
    std::fs::write(folder.path().join("model.adm"), deck).unwrap();
    let wheel = "wheels.left = { centre = 'A', spin = 'y' }\n";
    let mut keys = std::collections::BTreeSet::new();
    let mut ask = |command: &[&str], file: &str, text: &str, table: &str| {
        std::fs::write(folder.path().join(file), text).unwrap();
        let said = admire(folder.path(), command);
        assert_eq!(said.code, 1, "{text}: {}", said.err);
        for key in expected(&said.err) {
            keys.insert(if table.is_empty() {
                key
            } else {
                format!("{table}.{key}")
            });
        }
    };
    let kc = ["kc", "model.adm", "--out", "out", "--format", "plain"];
    for (text, table) in [
        ("zz = 1\n".to_string(), ""),
        (format!("{wheel}[deck]\nzz = 1\n"), "deck"),
        ("[wheels]\nzz = 1\n".to_string(), "wheels"),
        ("[wheels.left]\nzz = 1\n".to_string(), "wheels.SIDE"),
        (format!("{wheel}[tyre]\nzz = 1\n"), "tyre"),
        (format!("{wheel}[vehicle]\nzz = 1\n"), "vehicle"),
        (format!("{wheel}[ride]\nzz = 1\n"), "ride"),
        (format!("{wheel}[steering]\nzz = 1\n"), "steering"),
        (format!("{wheel}[choices]\nzz = 1\n"), "choices"),
        (format!("{wheel}[tests.bounce]\nzz = 1\n"), "tests.TEST"),
    ] {
        ask(&kc, "kc.toml", &text, table);
    }
    let sweep = ["sweep", "sweep.toml", "--out", "out", "--format", "plain"];
    for (text, table) in [
        ("zz = 1\n", ""),
        ("[sampling]\nzz = 1\n", "sampling"),
        ("sampling.plan = 'random'\n[[vary]]\nzz = 1\n", "vary"),
        (
            "sampling.plan = 'random'\n[[correlate]]\nzz = 1\n",
            "correlate",
        ),
        ("sampling.plan = 'random'\n[[keep]]\nzz = 1\n", "keep"),
        ("sampling.plan = 'random'\n[solver]\nzz = 1\n", "solver"),
    ] {
        ask(&sweep, "sweep.toml", text, table);
    }
    assert!(keys.len() > 70, "{keys:?}");
    let terms: Vec<String> = admire_guide::glossary::entries()
        .filter(|entry| entry.section == "kc.toml" || entry.section == "SWEEP.toml")
        .map(|entry| entry.term)
        .collect();
    // A table is explained by its keys, `left` and `right` by SIDE, a test by TEST.
    let known = |key: &String| {
        let within = format!("{key}.");
        let side = ["wheels.left", "wheels.right"].contains(&key.as_str());
        side || terms
            .iter()
            .any(|term| term == key || term.starts_with(&within))
    };
    let lacking: Vec<&String> = keys.iter().filter(|key| !known(key)).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    let said = admire(folder.path(), &["explain", "tests.bounce.hold"]);
    assert!(
        said.code == 0 && said.out.contains("of the axle"),
        "{}",
        said.out
    );
}

/// Checks that every effect of the virtual rig is in the guide with a picture, and that it can be planted as printed there.
#[test]
fn every_effect_of_the_guide_can_be_planted() {
    let (folder, study) = copied("pseudo-mcpherson");
    let channel = "[readings]\nfile = 'readings.csv'\n[readings.channels]\nheight = { function = 'DZ(20)', sigma = 0.05 }\n\n[identify]";
    super::run::change(&study.join("study.toml"), "[identify]", channel);
    let mut planted = BTreeSet::new();
    for entry in admire_guide::glossary::entries().filter(|entry| entry.page == "rig") {
        let effect = entry.cells[0].1.trim_matches('`');
        let said = admire(folder.path(), &["explain", &entry.term]);
        assert!(
            said.out.contains("readings, `.` model"),
            "{}: {}",
            entry.term,
            said.out
        );
        for row in &entry.picture {
            assert!(
                row.len() < 76 && said.out.contains(row),
                "{}: {row}",
                entry.term
            );
        }
        if effect == "none" {
            continue;
        }
        let arguments = ["rig", "study", "--out", &entry.term, "--effect", effect];
        let said = admire(folder.path(), &arguments);
        assert_eq!(said.code, 0, "{effect}: {}", said.err);
        planted.insert(entry.term);
    }
    let known = admire_rig::effect::causes().chain(admire_rig::effect::outside_causes());
    let lacking: Vec<&str> = known.filter(|name| !planted.contains(*name)).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
}

/// Checks that a word of the field can be entered without quotes, and that its explanation has unit, sign and a page for further reading.
#[test]
fn words_of_the_field_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    for (words, parts) in [
        (
            &["explain", "camber"][..],
            &["unit: deg", "positive: top outboard"][..],
        ),
        (
            &["explain", "Bump", "Steer"],
            &["unit: deg/m", "to the right"],
        ),
        (
            &["explain", "roll-center"],
            &["unit: mm", "roll_center_location"],
        ),
        (
            &["explain", "hardpoint-error"],
            &["hardpoint-error@MARKER/15:form=point", "fingerprint"],
        ),
    ] {
        let said = admire(folder.path(), words);
        assert_eq!(said.code, 0, "{words:?}: {}", said.err);
        assert!(said.out.contains("more: admire guide "), "{}", said.out);
        for part in parts {
            assert!(said.out.contains(part), "{words:?}: {part}: {}", said.out);
        }
    }
}
