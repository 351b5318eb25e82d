//! Answers of the server to requests.

use serde_json::{Value, json};

use crate::client::{Editor, codes, edited, edits_of, shipped};

/// Deck of these tests. Lines are counted from 0.
const DECK: &str = "\
front axle
UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND
PART/1, GROUND
MARKER/10, PART = 1, QP = 0, 0, 100
!                           adams_view_name='arm'
PART/2, MASS = 2, CM = 20, IP = 1E4, 1E4, 1E4, QG = 10, 0, 0
MARKER/20, PART = 2, QP = 5, 0, 100, REULER = 90D, 0, 0
!                       adams_view_name='arm_bush'
BUSHING/3
, I = 20
, J = 10
, K = 1000, 2000, 3000
, KT = 1E5, 1E5, 1E5
VARIABLE/7, FUNCTION = DX(20, 10) + BUSH(3, 0, 2, 10)
SFORCE/4, TRANSLATIONAL, I = 20, J = 10, FUNCTION = 2*VARVAL(7)
REQUEST/5, FORCE, I = 20, J = 10
END
";
const COMMANDS: &str = "axle\nrun\nBUSHING/3, K = 1, 2, 3\nVARIABLE/7, FUNCTION = DZ(20, 10)\nDEACTIVATE/SFORCE, RANGE = 4, 4\n\
                        DEACTIVATE/BUSHING, ID = 3\nSIMULATE/STATICS\nSTOP\n";

fn editor() -> Editor {
    let mut editor = Editor::start(&[
        ("axle.adm", DECK.as_bytes()),
        ("run.acf", COMMANDS.as_bytes()),
    ]);
    editor.open("axle.adm", DECK);
    editor
}

fn hover(editor: &mut Editor, name: &str, line: usize, character: usize) -> String {
    let at = editor.at(name, line, character);
    let answer = editor.request("textDocument/hover", at);
    answer["contents"]["value"]
        .as_str()
        .unwrap_or_default()
        .to_string()
}

/// Returns file names with the first line and character of each location.
fn locations(answer: &Value) -> Vec<(String, u64, u64)> {
    let mut all: Vec<_> = answer
        .as_array()
        .expect("a list")
        .iter()
        .map(|found| {
            let uri = found["uri"].as_str().expect("a name");
            let start = &found["range"]["start"];
            let number = |key: &str| start[key].as_u64().expect("a place");
            (
                uri.rsplit('/').next().expect("a name").to_string(),
                number("line"),
                number("character"),
            )
        })
        .collect();
    all.sort();
    all
}

fn place(name: &str, line: u64, character: u64) -> (String, u64, u64) {
    (name.to_string(), line, character)
}

#[test]
fn hover_tells_the_grammar_and_the_model() {
    let mut editor = editor();
    let keyword = hover(&mut editor, "axle.adm", 8, 2);
    assert!(
        keyword.contains("BUshing/id")
            && keyword.contains("Source: ")
            && keyword.contains("built-in solver"),
        "{keyword}"
    );
    let argument = hover(&mut editor, "axle.adm", 12, 2);
    assert!(
        argument.contains("**KT** = real[3]")
            && argument.contains("in newton-mm/rad")
            && argument.contains("default 0"),
        "{argument}"
    );
    // The part is at 10, 0, 0, and the marker on it at 5, 0, 100.
    let marker = hover(&mut editor, "axle.adm", 9, 7);
    assert!(
        marker.contains("Position in ground: 15, 0, 100 mm")
            && marker.contains("REULER = 90D, 0D, 0D"),
        "{marker}"
    );
    assert!(marker.contains("On part 2 arm"), "{marker}");
    let bushing = hover(&mut editor, "axle.adm", 8, 9);
    assert!(
        bushing.contains("arm_bush") && bushing.contains("K = 1000, 2000, 3000 newton/mm"),
        "{bushing}"
    );
    assert!(
        bushing.contains("Between PART/2 arm and PART/1"),
        "{bushing}"
    );
    let function = hover(&mut editor, "axle.adm", 13, 25);
    assert!(function.contains("DX("), "{function}");
    // A hover in the command file shows definitions from the deck.
    editor.open("run.acf", COMMANDS);
    let redefined = hover(&mut editor, "run.acf", 2, 9);
    assert!(redefined.contains("arm_bush"), "{redefined}");
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn definitions_and_references_cross_functions_and_files() {
    let mut editor = editor();
    editor.open("run.acf", COMMANDS);
    let at = editor.at("axle.adm", 13, 27);
    let found = editor.request("textDocument/definition", at);
    assert_eq!(locations(&found), [place("axle.adm", 6, 0)]);
    let at = editor.at("run.acf", 5, 25);
    let found = editor.request("textDocument/definition", at);
    assert_eq!(locations(&found), [place("axle.adm", 8, 0)]);
    // The name of the deck.
    let at = editor.at("run.acf", 0, 1);
    let found = editor.request("textDocument/definition", at);
    assert_eq!(locations(&found), [place("axle.adm", 0, 0)]);
    let mut asked = editor.at("axle.adm", 6, 8);
    asked["context"] = json!({ "includeDeclaration": true });
    let found = editor.request("textDocument/references", asked);
    assert_eq!(
        locations(&found),
        [
            place("axle.adm", 5, 23),
            place("axle.adm", 6, 7),
            place("axle.adm", 9, 6),
            place("axle.adm", 13, 26),
            place("axle.adm", 14, 29),
            place("axle.adm", 15, 22),
            place("run.acf", 3, 26),
        ]
    );
    let at = editor.at("axle.adm", 8, 8);
    let found = editor.request("textDocument/documentHighlight", at);
    let kinds: Vec<u64> = found
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|found| found["kind"].as_u64())
        .collect();
    // The name and the id are written; the BUSH function reads.
    assert_eq!(kinds, [3, 3, 2]);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn symbols_and_folds() {
    let mut editor = editor();
    let uri = editor.uri("axle.adm");
    let found = editor.request(
        "textDocument/documentSymbol",
        json!({ "textDocument": { "uri": uri } }),
    );
    let names: Vec<&str> = found
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|found| found["name"].as_str())
        .collect();
    assert_eq!(names.len(), 10, "{names:?}");
    assert!(
        names.contains(&"BUSHING/3 arm_bush") && names.contains(&"UNITS"),
        "{names:?}"
    );
    let found = editor.request("workspace/symbol", json!({ "query": "ARM_b" }));
    assert_eq!(found[0]["name"], "BUSHING/3 arm_bush");
    assert_eq!(
        found[0]["location"]["range"]["start"],
        json!({ "line": 8, "character": 0 })
    );
    // Files of the folder that are not open are searched as well.
    let found = editor.request("workspace/symbol", json!({ "query": "variable/7" }));
    assert_eq!(found.as_array().map(Vec::len), Some(2), "{found}");
    let found = editor.request(
        "textDocument/foldingRange",
        json!({ "textDocument": { "uri": uri } }),
    );
    assert_eq!(found[0]["startLine"], 8);
    assert_eq!(found[0]["endLine"], 12);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn a_new_id_goes_through_functions_and_command_files() {
    let mut editor = editor();
    let mut asked = editor.at("axle.adm", 8, 8);
    let prepared = editor.request("textDocument/prepareRename", asked.clone());
    assert_eq!(prepared["start"], json!({ "line": 8, "character": 8 }));
    asked["newName"] = json!("33");
    let edit = editor.request("textDocument/rename", asked.clone());
    let deck = edited(
        DECK,
        edits_of(&edit, &editor.uri("axle.adm")).expect("the deck changes"),
    );
    assert_eq!(
        deck,
        DECK.replace("BUSHING/3", "BUSHING/33")
            .replace("BUSH(3,", "BUSH(33,")
    );
    // The command file is changed although it is not open.
    let commands = edited(
        COMMANDS,
        edits_of(&edit, &editor.uri("run.acf")).expect("the commands change"),
    );
    assert_eq!(
        commands,
        COMMANDS
            .replace("BUSHING/3", "BUSHING/33")
            .replace("ID = 3", "ID = 33")
    );
    // Requests from the command file, and for a range of ids.
    editor.open("run.acf", COMMANDS);
    let mut force = editor.at("axle.adm", 14, 7);
    force["newName"] = json!("40");
    let edit = editor.request("textDocument/rename", force);
    let commands = edited(
        COMMANDS,
        edits_of(&edit, &editor.uri("run.acf")).expect("the commands change"),
    );
    assert_eq!(commands, COMMANDS.replace("RANGE = 4, 4", "RANGE=40,40"));
    let mut marker = editor.at("run.acf", 3, 27);
    marker["newName"] = json!("21");
    let edit = editor.request("textDocument/rename", marker.clone());
    let deck = edited(
        DECK,
        edits_of(&edit, &editor.uri("axle.adm")).expect("the deck changes"),
    );
    assert_eq!(deck.matches("21").count(), 6, "{deck}");
    assert!(!deck.contains("= 20") && !deck.contains("(20"), "{deck}");
    // An id that is in use, and text that is no id.
    for (new, why) in [
        ("10", "MARKER/20 and MARKER/10 would both be MARKER/10"),
        ("0", "greater than zero"),
        ("99999999999", "whole number"),
    ] {
        marker["newName"] = json!(new);
        let id = editor.ask("textDocument/rename", marker.clone());
        let refused = editor.answer(id);
        let message = refused["error"]["message"].as_str().unwrap_or_default();
        assert!(
            message.contains(why) || new == "10" && message.contains("would both be"),
            "{refused}"
        );
    }
    // A view name, at its definition and at the id.
    for (line, character) in [(7, 45), (8, 8)] {
        let mut name = editor.at("axle.adm", line, character);
        name["newName"] = json!("rear bush");
        let edit = editor.request("textDocument/rename", name);
        let deck = edited(
            DECK,
            edits_of(&edit, &editor.uri("axle.adm")).expect("the deck changes"),
        );
        assert_eq!(deck, DECK.replace("arm_bush", "rear bush"));
    }
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn quick_fixes_mend_what_they_say() {
    let text = DECK
        .replace("BUSHING/3\n", "BUSHIMG/3\n")
        .replace("PART/1, GROUND", "PART/1,\tGROUND");
    let mut editor = Editor::start(&[]);
    editor.open("axle.adm", &text);
    editor.complaints("axle.adm", |found| {
        codes(found).contains(&"tab") && codes(found).contains(&"unknown-statement")
    });
    let uri = editor.uri("axle.adm");
    let mut actions = |line: u64, only: Value| {
        let range = json!({ "start": { "line": line, "character": 0 }, "end": { "line": line, "character": 99 } });
        let asked = json!({ "textDocument": { "uri": uri }, "range": range, "context": { "diagnostics": [], "only": only } });
        editor
            .request("textDocument/codeAction", asked)
            .as_array()
            .expect("a list")
            .clone()
    };
    let spelled = actions(8, json!(["quickfix"]));
    assert_eq!(spelled[0]["title"], "write BUSHING");
    assert_eq!(spelled[0]["diagnostics"][0]["code"], "unknown-statement");
    let fixed = edited(
        &text,
        edits_of(&spelled[0]["edit"], &uri).expect("it changes"),
    );
    assert_eq!(fixed, text.replace("BUSHIMG", "BUSHING"));
    let tab = actions(2, json!(["quickfix"]));
    assert_eq!(
        (&tab[0]["title"], &tab[0]["isPreferred"]),
        (&json!("replace each tab with a blank"), &json!(true))
    );
    let silenced = edited(&text, edits_of(&tab[1]["edit"], &uri).expect("it changes"));
    assert_eq!(
        silenced,
        text.replace("PART/1,\t", "! admire: ignore[tab]\nPART/1,\t")
    );
    // All safe fixes at once. The spelling fix is a guess, so it is not included.
    let all = actions(2, json!(["source.fixAll"]));
    let fixed = edited(&text, edits_of(&all[0]["edit"], &uri).expect("it changes"));
    assert_eq!(fixed, text.replace('\t', " "));
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn layout_changes_nothing_else() {
    for name in [
        "multilink/model.adm",
        "kc-experiment/model.adm",
        "statements/sforce.adm",
        "statements/spline.adm",
    ] {
        let text = shipped(name);
        let messy = text
            .replace(" = ", "=")
            .replace(", ", " ,  ")
            .replace("\n,", "\n   ,");
        let mut editor = Editor::start(&[("messy.adm", messy.as_bytes())]);
        editor.open("messy.adm", &messy);
        let uri = editor.uri("messy.adm");
        let asked = json!({ "textDocument": { "uri": uri }, "options": { "tabSize": 4, "insertSpaces": true } });
        let edits = editor.request("textDocument/formatting", asked);
        let tidy = edited(&messy, &edits);
        assert_ne!(tidy, messy);
        std::fs::write(editor.path("tidy.adm"), &tidy).expect("writable");
        let out = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(["diff", "messy.adm", "tidy.adm"])
            .current_dir(editor.folder.path())
            .output()
            .expect("it runs");
        assert!(
            out.status.success() && out.stdout.is_empty(),
            "{name}: {}",
            String::from_utf8_lossy(&out.stdout)
        );
        assert_eq!(editor.end(), Some(0));
    }
    // Only fixes that overlap the range.
    let mut editor = Editor::start(&[]);
    let text = DECK
        .replace("PART = 1, QP", "PART=1 ,QP")
        .replace("PART = 2, QP", "PART=2 ,QP");
    editor.open("axle.adm", &text);
    let uri = editor.uri("axle.adm");
    let range =
        json!({ "start": { "line": 6, "character": 3 }, "end": { "line": 6, "character": 9 } });
    let asked = json!({ "textDocument": { "uri": uri }, "range": range, "options": { "tabSize": 4, "insertSpaces": true } });
    let edits = editor.request("textDocument/rangeFormatting", asked);
    assert_eq!(
        edited(&text, &edits),
        text.replace("PART=2 ,QP", "PART = 2, QP")
    );
    assert_eq!(editor.end(), Some(0));
}

/// Types a text at the end of a line, and returns the completion items by label.
fn completions(editor: &mut Editor, name: &str, text: &str, typed: &str) -> Vec<Value> {
    let line = text.lines().count() - 1;
    let uri = editor.uri(name);
    let whole = format!("{}{typed}\nEND\n", text.trim_end().trim_end_matches("END"));
    editor.notify(
        "textDocument/didChange",
        json!({ "textDocument": { "uri": uri, "version": 2 }, "contentChanges": [{ "text": whole }] }),
    );
    let last = typed.lines().count() - 1;
    let at = editor.at(
        name,
        line + last,
        typed.lines().last().expect("a line").encode_utf16().count(),
    );
    editor.request("textDocument/completion", at)["items"]
        .as_array()
        .expect("a list")
        .clone()
}

fn labels(items: &[Value]) -> Vec<&str> {
    items
        .iter()
        .filter_map(|item| item["label"].as_str())
        .collect()
}

#[test]
fn completion_knows_what_may_come() {
    let mut editor = editor();
    let statements = completions(&mut editor, "axle.adm", DECK, "BU");
    let bushing = statements
        .iter()
        .find(|item| item["label"] == "BUSHING")
        .expect("there");
    // The shipped example, with the next free id.
    let snippet = bushing["textEdit"]["newText"].as_str().expect("a text");
    assert!(
        snippet.starts_with("BUSHING/${1:4}\n, I = ${2:20}\n, J = ${3:10}"),
        "{snippet}"
    );
    assert_eq!(bushing["insertTextFormat"], 2);
    assert!(!labels(&statements).contains(&"SIMULATE"));
    let arguments = completions(
        &mut editor,
        "axle.adm",
        DECK,
        "BUSHING/8, I = 20\n, J = 10, K",
    );
    assert!(
        labels(&arguments).contains(&"KT") && !labels(&arguments).contains(&"I"),
        "{:?}",
        labels(&arguments)
    );
    let ids = completions(&mut editor, "axle.adm", DECK, "BUSHING/8, I = 2");
    assert_eq!(labels(&ids), ["20"]);
    let bodies = completions(&mut editor, "axle.adm", DECK, "MARKER/8, PART = ");
    assert_eq!(labels(&bodies), ["1", "2 arm"]);
    // By a part of the object's name.
    let by_name = completions(&mut editor, "axle.adm", DECK, "MARKER/8, PART = ar");
    assert_eq!(by_name[0]["textEdit"]["newText"], "2");
    let values = completions(&mut editor, "axle.adm", DECK, "UNITS/LENGTH = MIL");
    assert!(
        labels(&values).contains(&"MILLIMETER"),
        "{:?}",
        labels(&values)
    );
    let functions = completions(&mut editor, "axle.adm", DECK, "VARIABLE/8, FUNCTION = 2*A");
    let az = functions
        .iter()
        .find(|item| item["label"] == "AZ")
        .expect("there");
    assert_eq!(az["detail"], "AZ(i[,j])");
    let markers = completions(
        &mut editor,
        "axle.adm",
        DECK,
        "VARIABLE/8, FUNCTION = AZ(20, 1",
    );
    assert_eq!(labels(&markers), ["10"]);
    assert_eq!(
        labels(&completions(&mut editor, "axle.adm", DECK, "MARKER/")),
        ["21"]
    );
    let nothing = completions(
        &mut editor,
        "axle.adm",
        DECK,
        "BUSHING/9\n, I = 20\n, J = 10, CT = 1, 2, 3, ",
    );
    assert!(labels(&nothing).contains(&"KT"));
    // In commands: ids of the deck.
    editor.open("axle.adm", DECK);
    editor.open("run.acf", COMMANDS);
    let asked =
        |text: &str, editor: &mut Editor| completions(editor, "run.acf", "axle\nrun\nEND", text);
    assert_eq!(
        labels(&asked("DEACTIVATE/BUSHING, ID = ", &mut editor)),
        ["3 arm_bush"]
    );
    assert_eq!(labels(&asked("BUSHING/", &mut editor)), ["3 arm_bush"]);
    let commands = asked("SIM", &mut editor);
    assert!(
        labels(&commands).contains(&"SIMULATE") && !labels(&commands).contains(&"UNITS"),
        "{:?}",
        labels(&commands)
    );
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn signatures_follow_the_argument() {
    let mut editor = editor();
    let at = editor.at("axle.adm", 13, 31);
    let help = editor.request("textDocument/signatureHelp", at);
    assert!(
        help["signatures"][0]["label"]
            .as_str()
            .is_some_and(|label| label.starts_with("DX(")),
        "{help}"
    );
    assert_eq!(help["activeParameter"], 1);
    assert_eq!(editor.end(), Some(0));
}
