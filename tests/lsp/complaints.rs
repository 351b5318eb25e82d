//! Diagnostics while typing.

use std::process::Command;

use serde_json::Value;

use crate::client::{Editor, codes, shipped};

const DECK: &str = "t\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1, CM=20\nMARKER/20, PART=2\nJOINT/1, SPHERICAL, I=20, J=1\nEND\n";

/// Returns the diagnostics of `admire check` for a file, as line, column and code.
fn checked(editor: &Editor, name: &str) -> Vec<(u64, u64, String)> {
    let out = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["check", "--format", "json", name])
        .current_dir(editor.folder.path())
        .output()
        .expect("it runs");
    let found: Vec<Value> = serde_json::from_slice(&out.stdout).expect("JSON");
    let mut all: Vec<_> = found
        .iter()
        .map(|found| {
            let place = &found["labels"][0];
            let number = |key: &str| place[key].as_u64().expect("a place");
            (
                number("line") - 1,
                number("column") - 1,
                found["code"].as_str().expect("a code").to_string(),
            )
        })
        .collect();
    all.sort();
    all
}

fn told(found: &[Value]) -> Vec<(u64, u64, String)> {
    let mut all: Vec<_> = found
        .iter()
        .map(|found| {
            let start = &found["range"]["start"];
            let number = |key: &str| start[key].as_u64().expect("a place");
            (
                number("line"),
                number("character"),
                found["code"].as_str().expect("a code").to_string(),
            )
        })
        .collect();
    all.sort();
    all
}

#[test]
fn the_editor_is_told_what_check_says() {
    for name in [
        "kc-experiment/model.adm",
        "multilink/model.adm",
        "lint/kt-per-degree.adm",
        "statements/beam.adm",
    ] {
        let text = shipped(name)
            .replace("PART = 2", "PART = 2222")
            .replacen("QP", "QPP", 1);
        let mut editor = Editor::start(&[("a.adm", text.as_bytes())]);
        let wanted = checked(&editor, "a.adm");
        assert!(!wanted.is_empty());
        editor.open("a.adm", &text);
        let found = editor.complaints("a.adm", |found| told(found) == wanted);
        assert_eq!(told(&found), wanted);
        assert_eq!(editor.end(), Some(0));
    }
}

#[test]
fn a_keystroke_makes_a_complaint_and_the_next_one_ends_it() {
    let mut editor = Editor::start(&[]);
    editor.open("a.adm", DECK);
    editor.complaints("a.adm", <[Value]>::is_empty);
    editor.change("a.adm", 2, [5, 22, 5, 24], "21");
    let found = editor.complaints("a.adm", |found| !found.is_empty());
    assert_eq!(codes(&found), ["undefined-id"]);
    assert_eq!(found[0]["range"]["start"]["character"], 22);
    assert_eq!(found[0]["source"], "admire");
    // The marker itself is edited, so that statements which refer to it must be checked again.
    editor.change("a.adm", 3, [5, 22, 5, 24], "20");
    editor.complaints("a.adm", <[Value]>::is_empty);
    editor.change("a.adm", 4, [4, 7, 4, 9], "30");
    let found = editor.complaints("a.adm", |found| codes(found).contains(&"undefined-id"));
    let lines: Vec<_> = found
        .iter()
        .map(|found| found["range"]["start"]["line"].as_u64())
        .collect();
    assert_eq!(lines[..2], [Some(3), Some(5)], "{found:#?}");
    // The whole text is sent at once, as by simple editors.
    let uri = editor.uri("a.adm");
    editor.notify(
        "textDocument/didChange",
        serde_json::json!({ "textDocument": { "uri": uri, "version": 5 }, "contentChanges": [{ "text": DECK }] }),
    );
    editor.complaints("a.adm", <[Value]>::is_empty);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn commands_are_checked_against_their_deck_as_it_is_in_the_editor() {
    let commands = "a.adm\nrun\nDEACTIVATE/JOINT, ID=1\nSIMULATE/STATICS\nSTOP\n";
    let mut editor = Editor::start(&[("a.adm", DECK.as_bytes()), ("run.acf", commands.as_bytes())]);
    editor.open("run.acf", commands);
    editor.open("a.adm", DECK);
    editor.complaints("a.adm", <[Value]>::is_empty);
    // The joint gets another id, without saving.
    editor.change("a.adm", 2, [5, 6, 5, 7], "7");
    let found = editor.complaints("run.acf", |found| !found.is_empty());
    assert_eq!(codes(&found), ["undefined-id"]);
    assert_eq!(found[0]["range"]["start"]["line"], 2);
    editor.change("a.adm", 3, [5, 6, 5, 7], "1");
    editor.complaints("run.acf", <[Value]>::is_empty);
    // The file is closed without saving, so the file on disk counts.
    editor.change("a.adm", 4, [5, 6, 5, 7], "7");
    editor.complaints("run.acf", |found| !found.is_empty());
    let uri = editor.uri("a.adm");
    editor.notify(
        "textDocument/didClose",
        serde_json::json!({ "textDocument": { "uri": uri } }),
    );
    editor.complaints("run.acf", <[Value]>::is_empty);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn settings_and_comments_silence_complaints() {
    let settings = b"[check]\nignore = [\"free-without-mass\"]\n";
    let mut editor = Editor::start(&[("admire.toml", settings)]);
    let text = "t\nPART/1, GROUND\nPART/2\nMARKER/1, PART=9 ! admire: ignore[undefined-id]\nMARKER/2, PART=8\nEND\n";
    editor.open("a.adm", text);
    let found = editor.complaints("a.adm", |found| !found.is_empty());
    assert_eq!(codes(&found), ["undefined-id"]);
    assert_eq!(found[0]["range"]["start"]["line"], 4);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn places_are_counted_in_utf_16_whatever_ends_the_lines() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!(
            "t{end}PART/1, GROUND{end}! \u{1f697}\u{e9}{end}\tMARKER/1,\tPART=1 ! \u{1f697}{end}END{end}"
        );
        let mut editor = Editor::start(&[]);
        editor.open("a.adm", &text);
        // The edit follows a character of two UTF-16 units.
        editor.change("a.adm", 2, [2, 4, 2, 5], "x");
        editor.change("a.adm", 3, [3, 16, 3, 17], "9");
        let found = editor.complaints("a.adm", |found| codes(found).contains(&"undefined-id"));
        let wrong = found
            .iter()
            .find(|found| found["code"] == "undefined-id")
            .expect("there");
        assert_eq!(
            wrong["range"]["start"],
            serde_json::json!({ "line": 3, "character": 16 })
        );
        assert_eq!(editor.end(), Some(0));
    }
}
