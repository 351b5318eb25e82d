//! Tests of diffs, renumbering, JSON and summaries of decks.

use admire_solver::model::{Model, summary::summary};
use admire_syntax::diff::{DiffKind, DiffTolerance, diff};
use admire_syntax::renumber::{in_order, renumber};
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::{CommandFile, Dataset, json};

use super::lossless::real_files;
use super::lowering::dataset;

fn changes(before: &str, after: &str) -> Vec<String> {
    diff(
        &dataset(before).value,
        &dataset(after).value,
        DiffTolerance {
            absolute: 0.0,
            relative: 1e-9,
        },
    )
    .iter()
    .map(|difference| {
        let change = match &difference.change {
            DiffKind::Added => "added".to_string(),
            DiffKind::Removed => "removed".to_string(),
            DiffKind::Number { before, after, .. } => format!("{before} -> {after}"),
            DiffKind::Text { before, after } => format!(
                "{} -> {}",
                before.as_deref().unwrap_or("(none)"),
                after.as_deref().unwrap_or("(none)")
            ),
        };
        format!("{}: {change}", difference.address)
    })
    .collect()
}

#[test]
fn layout_spelling_order_and_defaults_are_no_differences() {
    let a = "t\nBUSHING/1, I=1, J=2, K=1.0E+03,2,3, FORCE=0,0,0\nSFORCE/1, I=1,J=2, ROT, FUNCTION=2*dx(1,2)\nEND\n";
    let b = "t\n! moved\nSFORCE/01\n, FUNCTION = 2.0 * DX( 1,\n, 2)\\\n, I=1,J=2, ROTATIONAL\nBUSHING/1\n, J=2\n, I=1\n, K = 1000\n, 2, 3.0\nEND\n";
    assert_eq!(changes(a, b), Vec::<String>::new());
    assert_eq!(changes(b, a), Vec::<String>::new());
}

/// Checks the comparison of functions with bytes that are not UTF-8. Decoded as Latin-1, such a byte becomes two bytes, so that the offset
/// of a blank may fall inside a character.
#[test]
fn latin_1_in_functions_is_compared() {
    let deck = |inside: &[u8]| {
        let text = [
            b"t\nVARIABLE/1, FUNCTION=USER(8:\x9b".as_slice(),
            inside,
            b", \xe42)\nEND\n",
        ]
        .concat();
        Dataset::parse(Source::new("latin.adm", text)).value
    };
    let exact = DiffTolerance {
        absolute: 0.0,
        relative: 0.0,
    };
    let (one, same, other) = (deck(b"31"), deck(b" 31.0"), deck(b"32"));
    assert_eq!(diff(&one, &same, exact).len(), 0);
    assert_eq!(diff(&one, &other, exact).len(), 1);
}

#[test]
fn differences_are_told_per_object() {
    let a = "t\n! adams_view_name='x'\nBUSHING/1, I=1, J=2, K=1,2,3\nSFORCE/1, I=1, J=2, ROT, FUNCTION=2*DX(1,2)\nMARKER/5, PART=1\nEND\n";
    let b = "u\n! adams_view_name='y'\nBUSHING/1, I=1, J=4, K=1,2.5,3, KT=1,0,0\nSFORCE/1, I=1, J=2, TRANS, FUNCTION=2*DY(1,2)\nMARKER/6, PART=1\nEND\n";
    assert_eq!(
        changes(a, b),
        [
            "TITLE: t -> u",
            "BUSHING/1: x -> y",
            "BUSHING/1.J.1: 2 -> 4",
            "BUSHING/1.K.2: 2 -> 2.5",
            "BUSHING/1.KT.1: 0 -> 1",
            "SFORCE/1.ROTATIONAL:  -> (none)",
            "SFORCE/1.FUNCTION: 2*DX(1,2) -> 2*DY(1,2)",
            "SFORCE/1.TRANSLATIONAL: (none) -> ",
            "MARKER/5: removed",
            "MARKER/6: added",
        ]
    );
}

/// Checks that a diff shows numbers as written in the files: degrees keep their suffix, and small numbers stay short.
#[test]
fn numbers_are_shown_as_they_are_written() {
    let a = dataset("t\nMARKER/5, PART=1, REULER=90D,0,0\nEND\n").value;
    let b = dataset("t\nMARKER/5, PART=1, QP=1.0E-14,0,0, REULER=45.0D,0,0\nEND\n").value;
    let found = diff(&a, &b, DiffTolerance::default());
    let shown: Vec<_> = found
        .iter()
        .map(|difference| match &difference.change {
            DiffKind::Number { written, after, .. } => {
                (written.each_ref().map(String::as_str), *after)
            }
            other => panic!("{other:?}"),
        })
        .collect();
    let half = std::f64::consts::FRAC_PI_4;
    assert_eq!(shown, [(["90D", "45.0D"], half), (["0", "1.0E-14"], 1e-14)]);
}

#[test]
fn every_reference_follows_a_new_id() {
    let text = "t\nPART/01, GROUND\nMARKER/07, PART=01\nMARKER/9, PART=1\nJOINT/3, FIXED, I=07, J=9\nJOINT/4, FIXED, I=7, J=9\nJOINT/9, FIXED, I=7, J=9\nSFORCE/1, I=7, J=9, ROT, FUNCTION=7*DX(7,9)+JOINT(3,0,2,9)\nVARIABLE/1, FUNCTION=USER(7)\nEND\n";
    let deck = dataset(text).value;
    let commands = "\nDEACTIVATE/JOINT, ID=3\nDEACTIVATE/JOINT, RANGE=3,4\nSFORCE/1, FUNCTION=DM(7,9)\nMARKER/7, QP=7,0,0\n";
    let file = CommandFile::parse(Source::new("c.acf", commands.as_bytes())).value;
    let mut map = in_order(&deck, "MARKER", 101, 1);
    map.insert(("joint", 3), 10);
    map.insert(("joint", 4), 8);
    let done = renumber(&deck, &[&file], &map).unwrap();
    assert_eq!(done.diagnostics.len(), 1, "the numbers of USER");
    let after = apply_edits(text.as_bytes(), &done.value.dataset).unwrap();
    assert_eq!(
        String::from_utf8(after).unwrap(),
        "t\nPART/01, GROUND\nMARKER/101, PART=01\nMARKER/102, PART=1\nJOINT/10, FIXED, I=101, J=102\nJOINT/8, FIXED, I=101, J=102\nJOINT/9, FIXED, I=101, J=102\nSFORCE/1, I=101, J=102, ROT, FUNCTION=7*DX(101,102)+JOINT(10,0,2,102)\nVARIABLE/1, FUNCTION=USER(7)\nEND\n"
    );
    let after = apply_edits(commands.as_bytes(), &done.value.commands[0]).unwrap();
    assert_eq!(
        String::from_utf8(after).unwrap(),
        "\nDEACTIVATE/JOINT, ID=10\nDEACTIVATE/JOINT, ID=8,10\nSFORCE/1, FUNCTION=DM(101,102)\nMARKER/101, QP=7,0,0\n"
    );
    map.insert(("joint", 3), 9);
    assert!(renumber(&deck, &[], &map).is_err());
}

#[test]
fn json_of_real_decks_comes_back_without_an_edit() {
    for (name, bytes) in real_files("adm") {
        let deck = Dataset::parse(Source::new(name.as_str(), bytes)).value;
        let text = serde_json::to_string(&json::export(&deck)).unwrap();
        let back: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(json::import(&deck, &back), Ok(vec![]), "{name}");
    }
}

#[test]
fn changed_json_edits_the_original_text() {
    let text = "t\r\n! keep\r\nBUSHING/1, I=1, J=2, K=1,2,3 ! here\r\nSFORCE/1\r\n, I=1, J=2\r\n, ROTATIONAL\r\n, FUNCTION = 2\\\r\n, ROUTINE = a::b\r\nMARKER/5, PART=1\r\nEND\r\n";
    let deck = dataset(text).value;
    let mut json = json::export(&deck);
    let statements = json["statements"].as_array_mut().unwrap();
    statements[0]["arguments"]["K"][1] = 2.5.into();
    statements[0]["arguments"]["KT"] = serde_json::json!([1, 0, 0]);
    let sforce = statements[1]["arguments"].as_object_mut().unwrap();
    sforce.shift_remove("ROUTINE");
    sforce["FUNCTION"] = "DX(1,2)".into();
    statements.pop();
    statements.push(serde_json::json!({"kind": "PART", "id": 7, "arguments": {"MASS": [2]}}));
    let edits = json::import(&deck, &json).unwrap();
    assert_eq!(
        String::from_utf8(apply_edits(text.as_bytes(), &edits).unwrap()).unwrap(),
        "t\r\n! keep\r\nBUSHING/1, I=1, J=2, K=1,2.5,3, KT=1, 0, 0 ! here\r\nSFORCE/1\r\n, I=1, J=2\r\n, ROTATIONAL\r\n, FUNCTION = DX(1,2)\r\nPART/7, MASS=2\r\nEND\r\n"
    );
}

#[test]
fn the_reference_deck_in_numbers() {
    let Some((_, bytes)) = real_files("adm")
        .into_iter()
        .find(|(name, _)| name.contains("mcph_ref"))
    else {
        return;
    };
    let deck = Dataset::parse(Source::new("mcph_ref.adm", bytes)).value;
    let model = Model::lower(&deck).value;
    let summary = summary(&deck, &model);
    assert_eq!(summary.units, ["newton", "kg", "mm", "sec"]);
    assert_eq!(summary.statements["PART"], model.parts.len());
    let mass: f64 = model.parts.iter().map(|part| part.mass).sum();
    assert_eq!(summary.mass, mass);
    let cm = summary.centre_of_mass.unwrap();
    // The left front wheel is at negative y, about half a metre from the centre plane.
    assert!(cm[1] < -300.0 && cm[1] > -800.0, "{cm:?}");
    assert!(!summary.calls_subroutines && summary.unsolved.is_empty());
}
