//! Editor for tests: it starts the built program and communicates with it over standard input and output.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::{Value, json};

/// Longer than any answer takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Session with the server.
pub struct Editor {
    process: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    /// Notifications that no call has consumed yet.
    pub notes: VecDeque<Value>,
    next: i64,
    /// Messages that are collected, to be sent at once.
    held: Option<Vec<u8>>,
    pub folder: tempfile::TempDir,
}

impl Editor {
    /// Starts the server in a folder with these files.
    pub fn start(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).expect("writable");
        }
        let mut process = Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(["lsp", "--stdio"])
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let mut output = BufReader::new(process.stdout.take().expect("piped"));
        let (send, messages) = channel();
        std::thread::spawn(move || {
            while let Some(message) = read(&mut output) {
                if send.send(message).is_err() {
                    return;
                }
            }
        });
        let input = process.stdin.take();
        let mut editor = Self {
            process,
            input,
            messages,
            notes: VecDeque::new(),
            next: 0,
            held: None,
            folder,
        };
        let root = editor.uri("");
        let answer = editor.request(
            "initialize",
            json!({ "processId": null, "capabilities": {}, "workspaceFolders": [{ "uri": root, "name": "test" }] }),
        );
        assert_eq!(answer["serverInfo"]["name"], "admire", "{answer}");
        editor.notify("initialized", json!({}));
        editor
    }

    pub fn path(&self, name: &str) -> PathBuf {
        std::fs::canonicalize(self.folder.path())
            .expect("there")
            .join(name)
    }

    pub fn uri(&self, name: &str) -> String {
        format!("file://{}", self.path(name).display())
    }

    /// Returns the parameters for a position in a file.
    pub fn at(&self, name: &str, line: usize, character: usize) -> Value {
        json!({ "textDocument": { "uri": self.uri(name) }, "position": { "line": line, "character": character } })
    }

    pub fn open(&mut self, name: &str, text: &str) {
        let uri = self.uri(name);
        self.notify(
            "textDocument/didOpen",
            json!({ "textDocument": { "uri": uri, "languageId": "adams", "version": 1, "text": text } }),
        );
    }

    /// Replaces a range, given by first line and character, then last line and character.
    pub fn change(&mut self, name: &str, version: i64, range: [usize; 4], text: &str) {
        let uri = self.uri(name);
        let [line, character, last, end] = range;
        self.notify(
            "textDocument/didChange",
            json!({
                "textDocument": { "uri": uri, "version": version },
                "contentChanges": [{
                    "range": { "start": { "line": line, "character": character }, "end": { "line": last, "character": end } },
                    "text": text,
                }],
            }),
        );
    }

    pub fn notify(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Sends a request without waiting for the answer; returns its id.
    pub fn ask(&mut self, method: &str, params: Value) -> i64 {
        self.next += 1;
        self.send(
            &json!({ "jsonrpc": "2.0", "id": self.next, "method": method, "params": params }),
        );
        self.next
    }

    /// Sends all messages of `say` in one write, so that the server has the last message as soon as the first.
    pub fn at_once<T>(&mut self, say: impl FnOnce(&mut Self) -> T) -> T {
        self.held = Some(Vec::new());
        let said = say(self);
        if let Some(all) = self.held.take() {
            self.write(&all);
        }
        said
    }

    /// Waits for the answer to a request, and returns it whole.
    pub fn answer(&mut self, id: i64) -> Value {
        loop {
            let message = self.next_message();
            if message["id"] == id && message.get("method").is_none() {
                return message;
            }
            self.notes.push_back(message);
        }
    }

    /// Sends a request that must succeed, and returns its result.
    pub fn request(&mut self, method: &str, params: Value) -> Value {
        let id = self.ask(method, params);
        let answer = self.answer(id);
        assert!(answer.get("error").is_none(), "{method}: {answer}");
        answer["result"].clone()
    }

    /// Waits for the next diagnostics of a file that `wanted` accepts.
    pub fn complaints(&mut self, name: &str, wanted: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        let uri = self.uri(name);
        loop {
            let message = match self.notes.pop_front() {
                Some(message) => message,
                None => self.next_message(),
            };
            if message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == uri.as_str()
            {
                let found = message["params"]["diagnostics"]
                    .as_array()
                    .expect("a list")
                    .clone();
                if wanted(&found) {
                    return found;
                }
            }
        }
    }

    /// Ends the session as an editor does; returns the exit code.
    pub fn end(mut self) -> Option<i32> {
        self.request("shutdown", Value::Null);
        self.notify("exit", Value::Null);
        self.process.wait().expect("it ends").code()
    }

    /// Closes the connection without the shutdown messages; returns the exit code of the server.
    pub fn leave(mut self) -> Option<i32> {
        drop(self.input.take());
        self.process.wait().expect("it ends").code()
    }

    /// Sends bytes unchanged.
    pub fn say_bytes(&mut self, bytes: &[u8]) {
        self.write(bytes);
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let message = format!("Content-Length: {}\r\n\r\n{text}", text.len());
        match &mut self.held {
            Some(held) => held.extend_from_slice(message.as_bytes()),
            None => self.write(message.as_bytes()),
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().expect("open");
        input.write_all(bytes).expect("the server reads");
        input.flush().expect("the server reads");
    }

    fn next_message(&self) -> Value {
        self.messages
            .recv_timeout(PATIENCE)
            .expect("the server answers")
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        // A failed test must not leave a process behind.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn read(output: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if output.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim().strip_prefix("Content-Length:") {
            Some(number) => length = number.trim().parse().ok()?,
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    let mut bytes = vec![0; length];
    output.read_exact(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Returns the codes of diagnostics.
pub fn codes(found: &[Value]) -> Vec<&str> {
    found
        .iter()
        .filter_map(|found| found["code"].as_str())
        .collect()
}

/// Returns the text of a shipped file.
pub fn shipped(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(path);
    std::fs::read_to_string(path).expect("a shipped file")
}

/// Returns a text after edits of the protocol, whose positions refer to the original text.
pub fn edited(text: &str, edits: &Value) -> String {
    let offset = |place: &Value| {
        let line = place["line"].as_u64().expect("a line") as usize;
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        let wanted = place["character"].as_u64().expect("a character") as usize;
        let mut units = 0;
        let rest = text[start..].char_indices();
        let passed = rest.take_while(|(_, c)| {
            let before = units;
            units += c.len_utf16();
            before < wanted
        });
        start + passed.map(|(_, c)| c.len_utf8()).sum::<usize>()
    };
    let mut all: Vec<(usize, usize, &str)> = edits
        .as_array()
        .expect("a list of edits")
        .iter()
        .map(|edit| {
            let range = &edit["range"];
            (
                offset(&range["start"]),
                offset(&range["end"]),
                edit["newText"].as_str().expect("a text"),
            )
        })
        .collect();
    all.sort_unstable();
    let mut out = text.to_string();
    for (start, end, new) in all.into_iter().rev() {
        out.replace_range(start..end, new);
    }
    out
}

/// Returns the edits of one file in a workspace edit; `None` if it does not change the file.
pub fn edits_of<'e>(edit: &'e Value, uri: &str) -> Option<&'e Value> {
    let changes = edit["documentChanges"].as_array().expect("changes");
    let own = changes
        .iter()
        .find(|change| change["textDocument"]["uri"] == uri)?;
    Some(&own["edits"])
}
