//! Tests of every toolkit command on every real deck, as a user would call it, and of the loss list in the guide.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use admire_solver::model::Model;
use admire_solver::system::{Scratch, System};
use admire_syntax::property::PropertyFile;
use admire_syntax::renumber::{Renumbering, in_order, renumber};
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::{Address, CommandFile, Dataset, Value, json};
use rayon::prelude::*;

use super::lossless::real_files;
use crate::common::{files_below, shared};

fn admire(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(words)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program runs")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("no signal")
}

fn dataset(name: &str, bytes: &[u8]) -> Dataset {
    Dataset::parse(Source::new(name, bytes)).value
}

/// Returns the bit patterns of all numbers of a deck, in order.
fn numbers(dataset: &Dataset) -> Vec<u64> {
    dataset
        .statements()
        .iter()
        .flat_map(|statement| &statement.arguments)
        .flat_map(|argument| match &argument.value {
            Value::Function(expression) => expression.literals.clone(),
            _ => argument.numbers().to_vec(),
        })
        .map(|number| number.value.to_bits())
        .collect()
}

/// Returns the real decks, each with a temporary folder for the files that the commands write.
fn decks() -> Vec<(PathBuf, Vec<u8>, tempfile::TempDir)> {
    real_files("adm")
        .into_iter()
        .map(|(name, bytes)| {
            let folder = tempfile::tempdir().expect("a folder");
            (PathBuf::from(name), bytes, folder)
        })
        .collect()
}

#[test]
fn every_command_works_on_every_real_deck() {
    decks().par_iter().for_each(|(path, bytes, folder)| {
        let deck = path.to_str().expect("a name");
        let at = |name: &str| folder.path().join(name).display().to_string();
        // Adding a marker and removing it again restores the original bytes.
        let marker = "MARKER/987654, PART=1, QP=1, 2, 3";
        let added = admire(&["add", deck, marker, "--name", "new", "-o", &at("added.adm")]);
        assert_eq!(code(&added), 0, "{deck}: {}", text(&added));
        let place = admire(&["get", &at("added.adm"), "MARKER/987654.QP.3"]);
        assert_eq!(text(&place).trim(), "3.0", "{deck}");
        let gone = ["remove", &at("added.adm"), "new", "-o", &at("gone.adm")];
        assert_eq!(code(&admire(&gone)), 0, "{deck}");
        assert!(
            std::fs::read(at("gone.adm")).expect("written") == *bytes,
            "{deck}"
        );
        let original = dataset(deck, bytes);

        let checked = admire(&["check", deck, "--format", "json"]);
        assert!(code(&checked) <= 1, "{deck}: {checked:?}");
        let complaints: serde_json::Value =
            serde_json::from_str(&text(&checked)).expect("complaints as JSON");
        for complaint in complaints.as_array().expect("a list") {
            for label in complaint["labels"].as_array().expect("labels") {
                let end = label["end"].as_u64().expect("a place") as usize;
                assert!(end <= bytes.len(), "{deck}: {complaint}");
            }
        }

        let shown = admire(&["fix", deck]);
        assert_eq!(code(&shown), 0, "{deck}");
        std::fs::write(at("fixed.adm"), bytes).expect("writable");
        assert_eq!(code(&admire(&["fix", "--write", &at("fixed.adm")])), 0);
        let fixed = std::fs::read(at("fixed.adm")).expect("readable");
        assert_eq!(fixed != *bytes, !shown.stdout.is_empty(), "{deck}");
        let parsed = Dataset::parse(Source::new("fixed", fixed.clone()));
        assert_eq!(parsed.diagnostics, [], "{deck}");
        assert_eq!(numbers(&parsed.value), numbers(&original), "{deck}");
        assert_eq!(code(&admire(&["diff", deck, &at("fixed.adm")])), 0);

        let objects: Vec<String> = original
            .statements()
            .iter()
            .filter_map(Address::of)
            .map(|address| address.to_string())
            .take(100)
            .collect();
        let mut words = vec!["get", deck];
        words.extend(objects.iter().map(String::as_str));
        let got = admire(&words);
        assert_eq!(code(&got), 0, "{deck}: {got:?}");
        assert!(text(&got).lines().count() >= objects.len());

        assert_eq!(admire(&["set", deck]).stdout, *bytes, "{deck}");
        let number = original.statements().iter().find_map(|statement| {
            let argument = statement.argument("QP").or(statement.argument("QG"))?;
            let address = format!("{}.{}.1", Address::of(statement)?, argument.kind()?);
            Some((address, argument.numbers().first()?.value))
        });
        let same = admire(&["diff", deck, deck]);
        assert_eq!((code(&same), text(&same).as_str()), (0, ""));
        if let Some((address, value)) = number {
            let assignment = format!("{address}={}", value + 0.5);
            let set = admire(&["set", deck, &assignment, "-o", &at("set.adm")]);
            assert_eq!(code(&set), 0, "{deck}: {set:?}");
            let changed = admire(&["diff", deck, &at("set.adm")]);
            assert_eq!(code(&changed), 1);
            let lines = text(&changed);
            assert!(
                lines.lines().count() == 1 && lines.starts_with(&address),
                "{lines}"
            );
        }

        let summary = admire(&["summary", deck, "--format", "json"]);
        assert!(code(&summary) <= 1, "{deck}: {summary:?}");
        let summary: serde_json::Value = serde_json::from_str(&text(&summary)).expect("JSON");
        let counted: u64 = summary["statements"]
            .as_object()
            .expect("statements")
            .values()
            .map(|count| count.as_u64().expect("a count"))
            .sum();
        assert_eq!(counted as usize, original.statements().len());

        let moved = admire(&[
            "renumber",
            deck,
            "MARKER=500001",
            "PART=90001,3",
            "-o",
            &at(""),
        ]);
        assert_eq!(code(&moved), 0, "{deck}: {moved:?}");
        let moved = Path::new(&at("")).join(path.file_name().expect("a name"));
        let moved = std::fs::read(moved).expect("in the folder");
        let one = admire(&[
            "renumber",
            deck,
            "MARKER=500001",
            "PART=90001,3",
            "-o",
            &at("one.adm"),
        ]);
        assert_eq!(code(&one), 0, "{deck}: {one:?}");
        assert!(std::fs::read(at("one.adm")).is_ok_and(|bytes| bytes == moved));

        assert_eq!(
            code(&admire(&["export", deck, "--json", "-o", &at("deck.json")])),
            0
        );
        let back = admire(&["import", deck, &at("deck.json")]);
        assert_eq!(back.stdout, *bytes, "{deck}");
    });
}

#[test]
fn every_real_command_file_and_result_is_read_by_its_commands() {
    for (name, _) in real_files("acf") {
        assert!(code(&admire(&["check", &name])) <= 1, "{name}");
    }
    let Some(folder) = shared("real-decks") else {
        return;
    };
    for ending in ["res", "req"] {
        for path in files_below(&folder, ending) {
            let file = path.to_str().expect("a name");
            let listed = admire(&["results", file, "--list"]);
            assert_eq!(code(&listed), 0, "{listed:?}");
            let compared = admire(&["compare", file, file]);
            assert_eq!(code(&compared), 0, "{compared:?}");
            let all = admire(&["results", file, "--get", "*", "--json"]);
            // `--get` may fail for a request file, because such a file may contain no request.
            assert!(code(&all) == 0 || ending == "req", "{file}: {all:?}");
            if code(&all) == 0 {
                let columns: serde_json::Value = serde_json::from_str(&text(&all)).expect("JSON");
                assert!(columns.is_object() || columns.is_array());
            }
        }
    }
}

/// Returns new ids for all objects, from 100003 on for parts and from a slightly different start for each other kind.
fn everything_anew(dataset: &Dataset) -> Renumbering {
    let kinds = [
        "PART",
        "MARKER",
        "JOINT",
        "JPRIM",
        "MOTION",
        "BUSHING",
        "FIELD",
        "BEAM",
        "SFORCE",
        "VFORCE",
        "VTORQUE",
        "GFORCE",
        "SPRINGDAMPER",
        "VARIABLE",
        "SPLINE",
        "ARRAY",
        "DIFF",
        "REQUEST",
        "MATRIX",
        "COUPLER",
        "SENSOR",
        "STRING",
        "CONTACT",
        "GRAPHICS",
    ];
    let mut all = Renumbering::new();
    for (k, kind) in kinds.iter().enumerate() {
        all.extend(in_order(dataset, kind, 100_003 + 7 * k as u32, 2));
    }
    all
}

/// Returns the residual of the equilibrium at the design position, or `None` if the model cannot be compiled.
fn residual(dataset: &Dataset) -> Option<Vec<f64>> {
    let model = Model::lower(dataset);
    if model.has_errors() {
        return None;
    }
    let compiled = System::compile(&model.value);
    if compiled.has_errors() {
        return None;
    }
    let system = compiled.value;
    let mut g = vec![0.0; system.unknowns()];
    let mut scratch = Scratch::new(&system);
    system
        .residual(&system.parameters(), &system.state(), &mut scratch, &mut g)
        .ok()?;
    Some(g)
}

/// Checks that renumbering all objects leaves the residual of the equilibrium unchanged.
#[test]
fn a_renumbered_deck_has_the_same_equations() {
    let mut compared = 0;
    for (name, bytes) in real_files("adm") {
        let before = dataset(&name, &bytes);
        let edits = renumber(&before, &[], &everything_anew(&before)).expect("no duplicates");
        let after = before
            .edited(&edits.value.dataset)
            .expect("no conflict")
            .value;
        if let Some(g) = residual(&before) {
            assert_eq!(Some(g), residual(&after), "{name}");
            compared += 1;
        }
    }
    println!("{compared} decks compared");
}

/// Tries every operation that should preserve a file. Returns one line for each loss, or `None` without real decks.
fn losses() -> Option<Vec<String>> {
    let decks = real_files("adm");
    if decks.is_empty() {
        return None;
    }
    let mut lost = Vec::new();
    let mut check = |name: &str, what: &str, kept: bool| {
        if !kept {
            let file = Path::new(name)
                .file_name()
                .expect("a name")
                .to_string_lossy();
            lost.push(format!("{file}: {what}"));
        }
    };
    for (name, bytes) in &decks {
        let before = dataset(name, bytes);
        let tiled: usize = before.tokens().map(|token| token.span.len()).sum();
        check(
            name,
            "bytes, reading",
            before.bytes() == *bytes && tiled == bytes.len(),
        );
        let known = |dataset: &Dataset| {
            dataset
                .statements()
                .iter()
                .all(|s| s.kind().is_some() && s.arguments.iter().all(|a| a.kind().is_some()))
        };
        check(
            name,
            "statements or arguments the grammar does not know",
            known(&before),
        );
        let exported = json::export(&before);
        let back = json::import(&before, &exported).is_ok_and(|edits| edits.is_empty());
        check(name, "bytes, through JSON", back);
        let new = everything_anew(&before);
        let there = renumber(&before, &[], &new)
            .expect("no duplicates")
            .value
            .dataset;
        let moved = before.edited(&there).expect("no conflict").value;
        let home: Renumbering = new
            .iter()
            .map(|((space, old), new)| ((*space, *new), *old))
            .collect();
        let edits = renumber(&moved, &[], &home)
            .expect("no duplicates")
            .value
            .dataset;
        let home = apply_edits(moved.bytes(), &edits).expect("no conflict");
        // Only numbers are compared here, because renumbering drops leading zeros of ids.
        let same = numbers(&dataset(name, &home)) == numbers(&before);
        check(name, "numbers, renumbered and back", same);
    }
    for (name, bytes) in real_files("acf") {
        let read = CommandFile::parse(Source::new(name.as_str(), bytes.clone())).value;
        check(&name, "bytes, reading", read.bytes() == bytes);
    }
    Some(lost)
}

#[test]
fn the_loss_list_of_the_guide_is_what_the_real_decks_give() {
    let Some(lost) = losses() else {
        return;
    };
    let page = include_str!("../../src/guide/coverage.md");
    let begin = page.find("<!-- losses -->\n").expect("the list") + "<!-- losses -->\n".len();
    let end = begin
        + page[begin..]
            .find("<!-- end of losses -->")
            .expect("its end");
    let list = if lost.is_empty() {
        "none\n".to_string()
    } else {
        lost.join("\n") + "\n"
    };
    assert_eq!(page[begin..end].replace("\r\n", "\n"), list);
}

/// Checks that a spline from a property file gives the same solution as the same points written in the deck.
#[test]
fn a_spline_of_a_property_file_is_the_spline_of_the_deck() {
    let folder = tempfile::tempdir().expect("a folder");
    let property = "[MDI_HEADER]\nFILE_TYPE = 'spr'\n[UNITS]\nLENGTH = 'meter'\nFORCE = 'newton'\n[CURVE]\n{disp force}\n-0.1 -1000\n-0.05 -600\n0 0\n0.1 1500\n";
    std::fs::write(folder.path().join("soft.spr"), property).expect("writable");
    assert!(PropertyFile::is_one(property.as_bytes()));
    let deck = |spline: &str| {
        format!(
            "t\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=-AKISPL(DZ(20,1,1),0,7)\nSPLINE/7, {spline}\nACCGRAV/KGRAV=-9806.65\nEND\n"
        )
    };
    let solve = |name: &str, spline: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, deck(spline)).expect("writable");
        let solved = admire(&["solve", path.to_str().expect("a name"), "--format", "json"]);
        assert_eq!(code(&solved), 0, "{solved:?}");
        text(&solved)
    };
    let inside = solve("a.adm", "X=-100,-50,0,100, Y=-1000,-600,0,1500");
    let outside = solve("b.adm", "FILE=soft.spr, BLOCK=CURVE");
    assert_eq!(inside, outside);
    // A missing property file is reported.
    let missing = folder.path().join("c.adm");
    std::fs::write(&missing, deck("FILE=hard.spr")).expect("writable");
    let refused = admire(&[
        "check",
        missing.to_str().expect("a name"),
        "--format",
        "plain",
    ]);
    assert!(
        text(&refused).contains("the file `hard.spr` does not exist"),
        "{refused:?}"
    );
}

/// Checks that kinds, single objects and named objects are renumbered, and that the references of a command file follow.
#[test]
fn renumber_follows_references_into_functions_and_commands() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let deck = "t\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\n! adams_view_name='front'\nBUSHING/12, I=20, J=1, K=1,1,1\nSFORCE/3, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=2*DZ(20,1)\nEND\n";
    let commands =
        "\nfile/model=d\nSFORCE/3, FUNCTION=3*DZ(20,1,1)\nDEACTIVATE/BUSHING, ID=12\nsim/stat\n";
    std::fs::write(at("d.adm"), deck).expect("writable");
    std::fs::write(at("d.acf"), commands).expect("writable");
    let (adm, acf, out) = (at("d.adm"), at("d.acf"), at("new"));
    std::fs::create_dir(&out).expect("a folder");
    let words = [
        "renumber",
        &adm,
        "PART=10",
        "MARKER/20=99",
        "front=7",
        "--commands",
        &acf,
        "-o",
        &out,
    ];
    let done = admire(&words);
    assert_eq!(code(&done), 0, "{done:?}");
    let read = |name: &str| std::fs::read_to_string(at(name)).expect("readable");
    let moved = deck
        .replace("PART/1,", "PART/10,")
        .replace("PART=1\n", "PART=10\n")
        .replace("PART/2,", "PART/11,")
        .replace("PART=2\n", "PART=11\n")
        .replace("20", "99")
        .replace("BUSHING/12", "BUSHING/7");
    assert_eq!(read("new/d.adm"), moved);
    let followed = commands.replace("20", "99").replace("ID=12", "ID=7");
    assert_eq!(read("new/d.acf"), followed);
    assert_eq!(read("d.adm"), deck, "the original stays");
    let clash = admire(&["renumber", &adm, "MARKER/20=1", "--in-place"]);
    assert_eq!(code(&clash), 1);
    assert_eq!(read("d.adm"), deck);
    assert_eq!(code(&admire(&["renumber", &adm, "MARKER"])), 2);
}

/// Checks the degrees of freedom of a four-bar linkage with revolute joints: -2 by the Gruebler count, 1 by rank.
#[test]
fn a_planar_linkage_is_overconstrained_and_moves() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("linkage.adm");
    let mut deck =
        String::from("linkage\nPART/1, GROUND\nMARKER/1, PART=1\nMARKER/4, PART=1, QP=40,0,0\n");
    let ends = [[0, 0, 0, 10], [0, 10, 40, 20], [40, 20, 40, 0]];
    for (k, [ax, ay, bx, by]) in ends.iter().enumerate() {
        let (part, cm, a, b) = (k + 2, 100 + k, 10 * k + 11, 10 * k + 12);
        deck += &format!(
            "PART/{part}, MASS=1, CM={cm}, IP=1,1,1\nMARKER/{cm}, PART={part}\nMARKER/{a}, PART={part}, QP={ax},{ay},0\nMARKER/{b}, PART={part}, QP={bx},{by},0\n"
        );
    }
    for (k, (i, j)) in [(11, 1), (21, 12), (31, 22), (32, 4)].iter().enumerate() {
        deck += &format!("JOINT/{}, REVOLUTE, I={i}, J={j}\n", k + 1);
    }
    deck += "END\n";
    std::fs::write(&path, deck).expect("writable");
    let summary = admire(&[
        "summary",
        path.to_str().expect("a name"),
        "--format",
        "json",
    ]);
    let summary: serde_json::Value = serde_json::from_str(&text(&summary)).expect("JSON");
    let found = &summary["degrees_of_freedom"];
    assert_eq!(
        (found["gruebler"].as_i64(), found["actual"].as_i64()),
        (Some(-2), Some(1))
    );
    assert_eq!(found["redundant"].as_array().map(Vec::len), Some(3));
    assert_eq!(summary["mass"], 3.0);
    assert_eq!(summary["unused_markers"].as_array().map(Vec::len), Some(0));
}
