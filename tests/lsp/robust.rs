//! Errors of an editor, and events that a session must survive.

use serde_json::{Value, json};

use crate::client::{Editor, codes};

const DECK: &str = "t\nPART/1, GROUND\nMARKER/1, PART=9\nEND\n";

#[test]
fn wrong_messages_are_answered_and_the_server_goes_on() {
    let mut editor = Editor::start(&[]);
    editor.open("a.adm", DECK);
    let id = editor.ask("textDocument/nothing", Value::Null);
    assert_eq!(editor.answer(id)["error"]["code"], -32601);
    for method in [
        "hover",
        "definition",
        "references",
        "rename",
        "completion",
        "codeAction",
        "rangeFormatting",
        "foldingRange",
    ] {
        for params in [
            Value::Null,
            json!({}),
            json!([1]),
            json!({ "textDocument": 5 }),
        ] {
            let id = editor.ask(&format!("textDocument/{method}"), params);
            assert_eq!(editor.answer(id)["error"]["code"], -32602, "{method}");
        }
        // A file that is not open, and positions that no file has.
        let range = json!({ "start": { "line": 4_000_000_000_u32, "character": 9 }, "end": { "line": 0, "character": 4_000_000_000_u32 } });
        for name in ["a.adm", "other.adm"] {
            let mut asked = editor.at(name, 4_000_000_000, 4_000_000_000);
            asked["range"] = range.clone();
            asked["newName"] = json!("7");
            asked["context"] = json!({ "diagnostics": [], "includeDeclaration": true });
            asked["options"] = json!({ "tabSize": 4, "insertSpaces": true });
            let id = editor.ask(&format!("textDocument/{method}"), asked);
            assert_ne!(editor.answer(id)["error"]["code"], -32603, "{method}");
        }
    }
    let uri = editor.uri("a.adm");
    for params in [
        Value::Null,
        json!({ "textDocument": { "uri": "file:///nowhere.adm", "version": 2 }, "contentChanges": [{ "text": "x" }] }),
        // A range that ends before its start, and positions beyond the end of a line.
        json!({ "textDocument": { "uri": uri, "version": 2 }, "contentChanges": [
            { "range": { "start": { "line": 99, "character": 99 }, "end": { "line": 0, "character": 0 } }, "text": "! x\n" },
        ] }),
    ] {
        editor.notify("textDocument/didChange", params);
    }
    editor.notify(
        "textDocument/didClose",
        json!({ "textDocument": { "uri": "untitled:1" } }),
    );
    editor.notify("$/unknown", json!({}));
    let found = editor.complaints("a.adm", |found| codes(found).contains(&"undefined-id"));
    assert_eq!(found.len(), 1);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn what_is_no_file_can_be_edited_too() {
    let mut editor = Editor::start(&[]);
    let uri = "untitled:Untitled-1";
    editor.notify(
        "textDocument/didOpen",
        json!({ "textDocument": { "uri": uri, "languageId": "adams", "version": 1, "text": DECK } }),
    );
    let range = json!({ "line": 2, "character": 15 });
    let answer = editor.request(
        "textDocument/hover",
        json!({ "textDocument": { "uri": uri }, "position": range }),
    );
    assert!(
        answer["contents"]["value"]
            .as_str()
            .is_some_and(|text| text.contains("PART/9 is not defined")),
        "{answer}"
    );
    // A command file that is recognised only by its language id.
    editor.notify(
        "textDocument/didOpen",
        json!({ "textDocument": { "uri": "untitled:2", "languageId": "adams-acf", "version": 1, "text": "SIMULATE/STATCS\n" } }),
    );
    let asked = json!({ "textDocument": { "uri": "untitled:2" }, "position": { "line": 0, "character": 2 } });
    let answer = editor.request("textDocument/hover", asked);
    assert!(
        answer["contents"]["value"]
            .as_str()
            .is_some_and(|text| text.contains("command file")),
        "{answer}"
    );
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn a_request_that_was_taken_back_is_not_answered() {
    let mut editor = Editor::start(&[]);
    // The server takes some time to read this text. Meanwhile, a request waits and is cancelled.
    let large: String = std::iter::once("t\n".to_string())
        .chain(
            (1..60_000).map(|id| format!("VARIABLE/{id}, FUNCTION = VARVAL({id}) + 2*SIN(TIME)\n")),
        )
        .chain(["END\n".to_string()])
        .collect();
    let mut asked = editor.at("a.adm", 2, 10);
    asked["context"] = json!({ "includeDeclaration": true });
    // The messages are sent at once. Even on a busy machine, the request is not answered before it is cancelled.
    let (id, answered) = editor.at_once(|editor| {
        editor.open("a.adm", &large);
        let id = editor.ask("textDocument/references", asked.clone());
        editor.notify("$/cancelRequest", json!({ "id": id }));
        (id, editor.ask("textDocument/references", asked))
    });
    assert_eq!(editor.answer(id)["error"]["code"], -32800);
    assert_eq!(
        editor.answer(answered)["result"].as_array().map(Vec::len),
        Some(2)
    );
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn complaints_are_those_of_the_last_of_many_edits() {
    let mut editor = Editor::start(&[]);
    editor.open("a.adm", DECK);
    for version in 2..300 {
        let digit = ["1", "9"][version % 2];
        editor.change("a.adm", version as i64, [2, 15, 2, 16], digit);
    }
    editor.change("a.adm", 300, [2, 15, 2, 16], "1");
    editor.complaints("a.adm", <[Value]>::is_empty);
    // No outdated diagnostics follow.
    let at = editor.at("a.adm", 2, 15);
    editor.request("textDocument/hover", at);
    std::thread::sleep(std::time::Duration::from_millis(300));
    let at = editor.at("a.adm", 2, 15);
    editor.request("textDocument/hover", at);
    let late = editor
        .notes
        .iter()
        .filter(|note| note["method"] == "textDocument/publishDiagnostics");
    let last = late
        .filter_map(|note| note["params"]["diagnostics"].as_array())
        .next_back();
    assert!(last.is_none_or(Vec::is_empty), "{last:?}");
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn an_editor_that_goes_away_leaves_no_server() {
    let editor = Editor::start(&[]);
    assert_eq!(editor.leave(), Some(1));
    let mut editor = Editor::start(&[]);
    editor.notify("exit", Value::Null);
    assert_eq!(editor.leave(), Some(1));
}

#[test]
fn files_in_latin_1_are_read_beside_open_ones() {
    let deck = b"t\xe9st\nPART/1, GROUND ! gr\xfcn\n!          adams_view_name='B\xfcchse'\nMARKER/1, PART=1\nEND\n";
    let mut editor = Editor::start(&[("deck.adm", deck)]);
    let commands = "deck\nrun\nMARKER/1, QP = 1, 2, 3\nSIMULATE/STATICS\nSTOP\n";
    editor.open("run.acf", commands);
    let at = editor.at("run.acf", 2, 8);
    let answer = editor.request("textDocument/hover", at);
    assert!(
        answer["contents"]["value"]
            .as_str()
            .is_some_and(|text| text.contains("B\u{fc}chse")),
        "{answer}"
    );
    // A character is one unit, whatever its number of bytes on disk.
    let mut asked = editor.at("run.acf", 2, 8);
    asked["newName"] = json!("12");
    let edit = editor.request("textDocument/rename", asked);
    let uri = editor.uri("deck.adm");
    let edits = crate::client::edits_of(&edit, &uri).expect("the deck changes");
    assert_eq!(
        edits[0]["range"]["start"],
        json!({ "line": 3, "character": 7 })
    );
    assert_eq!(editor.end(), Some(0));
}

/// Checks that invalid messages are answered with -32700, and that the next message is handled as usual.
#[test]
fn what_is_no_message_is_refused_and_the_server_goes_on() {
    let mut editor = Editor::start(&[]);
    editor.open("a.adm", DECK);
    let framed = |body: &[u8]| {
        [
            format!("Content-Length: {}\r\n\r\n", body.len()).as_bytes(),
            body,
        ]
        .concat()
    };
    for bad in [
        b"Content-Length: 100000000000\r\n\r\n".to_vec(),
        b"Content-Length: 100000000000\r\n\r\n{\"jsonrpc\":\"2.0\"}".to_vec(),
        framed(b"{\"jsonrpc\":\"2.0\",\"id\":"),
        framed(b"{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"\xff\xfe\"}"),
        framed(&vec![b'['; 100_000]),
    ] {
        editor.say_bytes(&bad);
        let at = editor.at("a.adm", 2, 15);
        let id = editor.ask("textDocument/hover", at);
        let answer = editor.answer(id);
        assert!(
            answer["result"]["contents"]["value"].is_string(),
            "{answer}"
        );
        let refused = editor
            .notes
            .iter()
            .filter(|note| note["error"]["code"] == -32700);
        assert_eq!(refused.count(), 1, "{:?}", editor.notes);
        editor.notes.retain(|note| note.get("error").is_none());
    }
    assert_eq!(editor.end(), Some(0));
}
