//! Benchmark of the language server during typing in a large deck: the delay of diagnostics after a keystroke.
//!
//! `cargo bench --bench editor -- [MEGABYTES]`. The goal is 50 ms after a keystroke, for 10 MB. Every keystroke is one message of the
//! protocol. The time ends when the diagnostics of the changed text have arrived.

#[path = "large_deck.rs"]
mod large_deck;

use std::time::{Duration, Instant};

use admire_lsp as lsp;
use large_deck::deck;
use lsp_server::{Connection, Message, Notification, Request};
use serde_json::{Value, json};

const URI: &str = "file:///large.adm";

fn main() {
    let megabytes = std::env::args()
        .skip(1)
        .find_map(|word| word.parse::<usize>().ok())
        .unwrap_or(10);
    let text = String::from_utf8(deck(megabytes << 20)).expect("text");
    let (server, editor) = Connection::memory();
    let thread = std::thread::spawn(move || lsp::serve(&server));
    let mut editor = Editor { editor, version: 1 };
    editor.send(Request::new(1.into(), "initialize".into(), json!({ "capabilities": {} })).into());
    editor.next(|message| matches!(message, Message::Response(_)));
    editor.note("initialized", json!({}));
    let start = Instant::now();
    editor.note(
        "textDocument/didOpen",
        json!({ "textDocument": { "uri": URI, "languageId": "adams", "version": 1, "text": text } }),
    );
    editor.complaints();
    println!(
        "{:.1} MB opened and shown in {:.0} ms",
        text.len() as f64 / 1e6,
        milliseconds(start)
    );
    // Lines that name the part of a marker; with one more digit, the part does not exist.
    let parts = text.matches("\nPART/").count();
    let too_large = |id: &str| id.parse::<usize>().is_ok_and(|id| id * 10 > parts + 1);
    let lines: Vec<(usize, usize)> = text
        .split('\n')
        .enumerate()
        .filter(|(_, line)| line.strip_prefix(", PART = ").is_some_and(too_large))
        .map(|(at, line)| (at, line.len()))
        .collect();
    // Keystrokes in the middle of the file, once the check of the whole file has finished.
    editor.wait_for_whole();
    for (name, pause) in [
        ("keys as fast as they are answered", 0),
        ("keys with pauses of 400 ms", 400),
    ] {
        let mut times: Vec<f64> = Vec::new();
        let count = if pause == 0 { 400 } else { 40 };
        for k in 0..count {
            let (line, end) = lines[(k * 7919 + lines.len() / 2) % lines.len()];
            for (range, new) in [((end, end), "7"), ((end, end + 1), "")] {
                std::thread::sleep(Duration::from_millis(pause));
                editor.drain();
                let start = Instant::now();
                editor.change(line, range, new);
                let found = editor.complaints();
                times.push(milliseconds(start));
                let undefined = found.iter().any(|found| found["code"] == "undefined-id");
                assert_eq!(undefined, !new.is_empty(), "the complaint follows the key");
            }
        }
        tell(name, times);
    }
    // The most expensive keystrokes: the id of the marker that every force refers to, and END typed in the middle, which ends the deck
    // there.
    let shared = text
        .lines()
        .position(|line| line.starts_with("MARKER/1,"))
        .expect("a marker");
    let middle = lines[lines.len() / 2].0 - 1;
    for (name, line, start, word) in [
        ("the id that all forces name", shared, 8, "7"),
        ("END in the middle, letter by letter", middle, 0, "END\n"),
    ] {
        let mut times: Vec<f64> = Vec::new();
        for _ in 0..20 {
            let mut keys: Vec<((usize, usize), (usize, usize), String)> = word
                .chars()
                .enumerate()
                .map(|(k, key)| ((line, start + k), (line, start + k), key.to_string()))
                .collect();
            let typed = word.trim_end().len();
            if word.ends_with('\n') {
                keys.push(((line, start + typed), (line + 1, 0), String::new()));
            }
            keys.extend(
                (0..typed)
                    .rev()
                    .map(|k| ((line, start + k), (line, start + k + 1), String::new())),
            );
            for (from, to, new) in keys {
                std::thread::sleep(Duration::from_millis(400));
                editor.drain();
                let start = Instant::now();
                editor.change_from_to(from, to, &new);
                editor.complaints();
                times.push(milliseconds(start));
            }
        }
        tell(name, times);
    }
    // A change that affects a rule for the whole file: a part loses its mass.
    let mass = text
        .lines()
        .position(|line| line.starts_with(", MASS"))
        .expect("a mass");
    let start = Instant::now();
    editor.change(mass, (0, 6), "! ");
    loop {
        let found = editor.complaints();
        if found
            .iter()
            .any(|found| found["code"] == "free-without-mass")
        {
            break;
        }
    }
    println!(
        "the check of the whole file in the background: {:.0} ms after a key",
        milliseconds(start)
    );
    editor.send(Request::new(2.into(), "shutdown".into(), Value::Null).into());
    editor.note("exit", Value::Null);
    thread
        .join()
        .expect("it ends")
        .expect("the protocol was kept");
}

struct Editor {
    editor: Connection,
    version: i32,
}

impl Editor {
    fn send(&self, message: Message) {
        self.editor.sender.send(message).expect("the server reads");
    }

    fn note(&self, method: &str, params: Value) {
        self.send(Notification::new(method.into(), params).into());
    }

    fn next(&self, wanted: impl Fn(&Message) -> bool) -> Message {
        loop {
            let message = self
                .editor
                .receiver
                .recv_timeout(Duration::from_secs(60))
                .expect("an answer");
            if wanted(&message) {
                return message;
            }
        }
    }

    /// Waits for the diagnostics of the current text and returns them.
    fn complaints(&self) -> Vec<Value> {
        let version = self.version;
        let message = self.next(|message| {
            matches!(message, Message::Notification(note)
                if note.method == "textDocument/publishDiagnostics" && note.params["version"] == version)
        });
        let Message::Notification(note) = message else {
            unreachable!("a notification")
        };
        note.params["diagnostics"]
            .as_array()
            .expect("a list")
            .clone()
    }

    fn drain(&self) {
        while self.editor.receiver.try_recv().is_ok() {}
    }

    /// Waits until the check of the whole file has finished, and asserts that it found nothing.
    ///
    /// Its diagnostics would otherwise displace those caused by the keystrokes.
    fn wait_for_whole(&self) {
        std::thread::sleep(Duration::from_secs(3));
        while let Ok(message) = self.editor.receiver.try_recv() {
            let Message::Notification(note) = message else {
                continue;
            };
            let found = note.params["diagnostics"].as_array();
            assert!(found.is_none_or(Vec::is_empty), "{found:?}");
        }
    }

    fn change(&mut self, line: usize, (start, end): (usize, usize), new: &str) {
        self.change_from_to((line, start), (line, end), new);
    }

    fn change_from_to(&mut self, from: (usize, usize), to: (usize, usize), new: &str) {
        self.version += 1;
        self.note(
            "textDocument/didChange",
            json!({
                "textDocument": { "uri": URI, "version": self.version },
                "contentChanges": [{
                    "range": { "start": { "line": from.0, "character": from.1 }, "end": { "line": to.0, "character": to.1 } },
                    "text": new,
                }],
            }),
        );
    }
}

fn tell(name: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!(
        "{name}: {} keys, complaints after {:.1} ms (median), {:.1} ms (99 of 100), {:.1} ms (all)",
        times.len(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
