//! Main loop of the server: processes messages in order, cancels requests, and takes the results of background checks.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crossbeam_channel::{Receiver, Sender, select};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use lsp_types::notification::{self, Notification as _};
use lsp_types::{
    CancelParams, DidChangeTextDocumentParams, DidCloseTextDocumentParams,
    DidOpenTextDocumentParams, LogMessageParams, MessageType, NumberOrString,
    PublishDiagnosticsParams, ShowMessageParams, TextDocumentContentChangeEvent,
};
use serde_json::Value;

use super::convert::shown;
use super::document::Document;
use super::position::span;
use super::refused::Refused;
use super::requests::Routes;
use super::worker::{Answer, Job, work};
use super::workspace::{Workspace, path_of};
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::{Source, Span};

/// State of the server between messages.
pub(super) struct Server {
    out: Sender<Message>,
    jobs: Sender<Job>,
    workspace: Workspace,
    routes: Routes,
    queue: VecDeque<Message>,
    shut_down: bool,
}

/// How a session ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ended {
    /// Orderly end as the protocol requires: shutdown, then exit.
    Orderly,
    /// The editor disconnected, or sent exit without shutdown.
    Abruptly,
}

impl Server {
    /// Serves an initialised connection until it ends.
    pub(crate) fn run(connection: &Connection, folders: Vec<PathBuf>, routes: Routes) -> Ended {
        let (jobs, jobs_out) = crossbeam_channel::unbounded();
        let (answers_in, answers) = crossbeam_channel::unbounded();
        let worker = std::thread::spawn(move || work(&jobs_out, &answers_in));
        let mut server = Self {
            out: connection.sender.clone(),
            jobs,
            workspace: Workspace::of(folders),
            routes,
            queue: VecDeque::new(),
            shut_down: false,
        };
        // The connection passes on one message at a time. This thread collects the messages that arrive while the server processes an
        // earlier message.
        let (said, messages) = crossbeam_channel::unbounded();
        let receiver = connection.receiver.clone();
        std::thread::spawn(move || receiver.iter().try_for_each(|message| said.send(message)));
        let ended = server.serve(&messages, &answers);
        drop(server);
        // The server does not wait for a running check.
        drop(worker);
        ended
    }

    fn serve(&mut self, messages: &Receiver<Message>, answers: &Receiver<Answer>) -> Ended {
        loop {
            if self.queue.is_empty() {
                select! {
                    recv(messages) -> message => match message {
                        Ok(message) => self.queue.push_back(message),
                        Err(_) => return Ended::Abruptly,
                    },
                    recv(answers) -> answer => {
                        if let Ok(answer) = answer {
                            self.guarded("a check", |server| server.take(answer));
                        }
                        continue;
                    }
                }
            }
            // A queued message may cancel a request or make an edit outdated.
            self.queue.extend(messages.try_iter());
            match self.queue.pop_front() {
                Some(Message::Request(request)) => self.request(request),
                Some(Message::Notification(note)) if note.method == notification::Exit::METHOD => {
                    return if self.shut_down {
                        Ended::Orderly
                    } else {
                        Ended::Abruptly
                    };
                }
                Some(Message::Notification(note)) => {
                    let method = note.method.clone();
                    self.guarded(&method, |server| server.notification(note));
                }
                Some(Message::Response(_)) | None => {}
            }
        }
    }

    /// Runs an action. A panic in the action does not end the server.
    fn guarded(&mut self, what: &str, action: impl FnOnce(&mut Self)) {
        if catch_unwind(AssertUnwindSafe(|| action(self))).is_err() {
            self.log(&format!("{what} failed; the server continues"));
        }
    }

    fn request(&mut self, request: Request) {
        let id = request.id.clone();
        let error = |code: ErrorCode, text: &str| {
            Response::new_err(id.clone(), code as i32, text.to_string())
        };
        let response = if self.is_cancelled(&request.id) {
            error(ErrorCode::RequestCanceled, "cancelled")
        } else if request.method == "shutdown" {
            self.shut_down = true;
            Response::new_ok(id, Value::Null)
        } else if self.shut_down {
            error(ErrorCode::InvalidRequest, "the server is shut down")
        } else {
            let (routes, workspace) = (&self.routes, &mut self.workspace);
            let answer = catch_unwind(AssertUnwindSafe(|| {
                routes.answer(workspace, &request.method, request.params)
            }));
            match answer {
                Ok(Ok(value)) => Response::new_ok(id, value),
                Ok(Err(Refused::Unknown)) => error(ErrorCode::MethodNotFound, &request.method),
                Ok(Err(Refused::Parameters(why))) => error(ErrorCode::InvalidParams, &why),
                Ok(Err(Refused::Request(why))) => error(ErrorCode::RequestFailed, &why),
                Err(_) => {
                    let text = format!("{} failed; the server continues", request.method);
                    self.log(&text);
                    error(ErrorCode::InternalError, &text)
                }
            }
        };
        self.send(response.into());
    }

    /// Returns true if a message in the queue cancels the request.
    fn is_cancelled(&self, id: &RequestId) -> bool {
        self.queue.iter().any(|message| {
            let Message::Notification(note) = message else {
                return false;
            };
            note.method == notification::Cancel::METHOD
                && serde_json::from_value::<CancelParams>(note.params.clone()).is_ok_and(|params| {
                    *id == match params.id {
                        NumberOrString::Number(number) => RequestId::from(number),
                        NumberOrString::String(text) => RequestId::from(text),
                    }
                })
        })
    }

    fn notification(&mut self, note: Notification) {
        match note.method.as_str() {
            notification::DidOpenTextDocument::METHOD => {
                let Some(params) = self.parameters::<DidOpenTextDocumentParams>(note) else {
                    return;
                };
                let opened = params.text_document;
                let commands = opened.language_id.to_lowercase().contains("acf");
                let path = path_of(&opened.uri);
                let wrong = self
                    .workspace
                    .open(opened.uri, opened.version, &opened.text, commands);
                self.complain(&wrong);
                self.renewed(&path);
            }
            notification::DidChangeTextDocument::METHOD => {
                if let Some(params) = self.parameters::<DidChangeTextDocumentParams>(note) {
                    self.changed(params);
                }
            }
            notification::DidCloseTextDocument::METHOD => {
                let Some(params) = self.parameters::<DidCloseTextDocumentParams>(note) else {
                    return;
                };
                let uri = params.text_document.uri;
                self.workspace.close(&uri);
                self.ask_commands(&path_of(&uri));
                self.publish(PublishDiagnosticsParams::new(uri, Vec::new(), None));
            }
            notification::DidSaveTextDocument::METHOD
            | notification::DidChangeWatchedFiles::METHOD => {
                // The saved file may be a settings file, or a file on which the diagnostics of an open file depend.
                let wrong = self.workspace.renew_settings();
                self.complain(&wrong);
                let open: Vec<PathBuf> = self
                    .workspace
                    .open_files()
                    .map(|(path, _)| path.clone())
                    .collect();
                for path in open {
                    self.show(&path);
                    self.ask(&path);
                }
            }
            _ => {}
        }
    }

    fn changed(&mut self, params: DidChangeTextDocumentParams) {
        let uri = params.text_document.uri;
        let path = path_of(&uri);
        let Some(file) = self
            .workspace
            .file_mut(&path)
            .filter(|file| file.version.is_some())
        else {
            self.log(&format!(
                "the changes of {} are ignored, because the file is not open",
                uri.as_str()
            ));
            return;
        };
        file.version = Some(params.text_document.version);
        file.edits.fetch_add(1, Ordering::Relaxed);
        for change in params.content_changes {
            let (place, new) = edit_of(&file.document, &change);
            let before = file.document.pieces().clone();
            let edit = || file.document.edit(place, new);
            if catch_unwind(AssertUnwindSafe(edit)).is_err() {
                // After a panic the document may be half edited, so the whole text is parsed again.
                let mut bytes = before.bytes();
                bytes.splice(place.range(), new.iter().copied());
                let source = Source::new(before.name(), bytes);
                file.document = Document::open(&source, before.is_command_file());
            }
        }
        // Diagnostics are not published if the next queued edit makes them outdated.
        let overtaken = self.queue.iter().any(|message| match message {
            Message::Notification(note) => {
                note.method == notification::DidChangeTextDocument::METHOD
                    && note.params["textDocument"]["uri"] == uri.as_str()
            }
            _ => false,
        });
        if !overtaken {
            self.renewed(&path);
        }
    }

    /// Publishes the current diagnostics of a file, and requests a check of the file and of the open command files that name it.
    fn renewed(&mut self, path: &Path) {
        self.show(path);
        self.ask(path);
        self.ask_commands(path);
    }

    /// Requests a check of the open command files that name this deck.
    fn ask_commands(&mut self, deck: &Path) {
        let open = self.workspace.open_files();
        let commands = open.filter(|(_, file)| file.document.is_command_file());
        let others: Vec<PathBuf> = commands
            .map(|(other, _)| other.clone())
            .filter(|other| {
                let named = self.workspace.decks_of(other);
                other != deck && named.iter().any(|named| named == deck)
            })
            .collect();
        for other in others {
            if let Some(file) = self.workspace.file(&other) {
                file.edits.fetch_add(1, Ordering::Relaxed);
            }
            self.ask(&other);
        }
    }

    /// Requests a check of a whole file in the background.
    fn ask(&mut self, path: &Path) {
        let Some(file) = self.workspace.file(path) else {
            return;
        };
        let named = if file.document.is_command_file() {
            self.workspace.decks_of(path)
        } else {
            Vec::new()
        };
        let open = |deck: &PathBuf| {
            self.workspace
                .file(deck)
                .filter(|file| file.version.is_some())
        };
        let decks = named
            .iter()
            .filter_map(|deck| Some((deck.clone(), open(deck)?.document.pieces().clone())));
        let job = Job {
            path: path.to_path_buf(),
            text: file.document.pieces().clone(),
            decks: decks.collect(),
            fortran: file.settings.fortran,
            edits: (file.edits.clone(), file.edits.load(Ordering::Relaxed)),
        };
        // The worker ends only with the server.
        let _ = self.jobs.send(job);
    }

    /// Stores and publishes the findings of a check, unless the file has been edited since the check was requested.
    fn take(&mut self, answer: Answer) {
        let Some(file) = self.workspace.file_mut(&answer.path) else {
            return;
        };
        if file.edits.load(Ordering::Relaxed) == answer.edits && file.version.is_some() {
            file.document.store_findings(answer.found);
            self.show(&answer.path);
        }
    }

    /// Publishes the diagnostics of a file if they differ from the diagnostics published before.
    fn show(&mut self, path: &Path) {
        let Some(file) = self
            .workspace
            .file_mut(path)
            .filter(|file| file.version.is_some())
        else {
            return;
        };
        let included = file.settings.includes(path);
        let new = if included { shown(file) } else { Vec::new() };
        if file.shown.as_ref() == Some(&new) {
            return;
        }
        file.shown = Some(new.clone());
        let (uri, version) = (file.uri.clone(), file.version);
        self.publish(PublishDiagnosticsParams::new(uri, new, version));
    }

    fn publish(&self, params: PublishDiagnosticsParams) {
        self.notify::<notification::PublishDiagnostics>(params);
    }

    /// Shows the errors in settings files to the user.
    fn complain(&self, wrong: &[Diagnostic]) {
        for found in wrong {
            let place = found.labels.first().map_or("", |label| &label.file);
            self.notify::<notification::ShowMessage>(ShowMessageParams {
                typ: MessageType::ERROR,
                message: format!("{place}: {}", found.message),
            });
        }
    }

    fn log(&self, message: &str) {
        self.notify::<notification::LogMessage>(LogMessageParams {
            typ: MessageType::ERROR,
            message: message.to_string(),
        });
    }

    fn notify<N: notification::Notification>(&self, params: N::Params) {
        self.send(Notification::new(N::METHOD.to_string(), params).into());
    }

    fn send(&self, message: Message) {
        // A disconnected editor reads nothing. The main loop ends when its incoming messages end.
        let _ = self.out.send(message);
    }

    fn parameters<P: serde::de::DeserializeOwned>(&self, note: Notification) -> Option<P> {
        match serde_json::from_value(note.params) {
            Ok(params) => Some(params),
            Err(error) => {
                self.log(&format!("{}: {error}", note.method));
                None
            }
        }
    }
}

/// Returns the span that a change replaces, and the new text. If the change contains the whole new text of the file, only the differing
/// part is returned.
fn edit_of<'c>(
    document: &Document,
    change: &'c TextDocumentContentChangeEvent,
) -> (Span, &'c [u8]) {
    let new = change.text.as_bytes();
    if let Some(range) = change.range {
        return (span(document.pieces(), range), new);
    }
    let old = document.pieces().bytes();
    let same =
        |pairs: &mut dyn Iterator<Item = (&u8, &u8)>| pairs.take_while(|(a, b)| a == b).count();
    let is_start = |text: &[u8], at: usize| text.get(at).is_none_or(|byte| byte & 0xc0 != 0x80);
    let mut front = same(&mut old.iter().zip(new));
    while !is_start(&old, front) || !is_start(new, front) {
        front -= 1;
    }
    let most = old.len().min(new.len()) - front;
    let mut back = same(&mut old.iter().rev().zip(new.iter().rev())).min(most);
    while !is_start(&old, old.len() - back) || !is_start(new, new.len() - back) {
        back -= 1;
    }
    (
        Span::new(front, old.len() - back),
        &new[front..new.len() - back],
    )
}

#[cfg(test)]
mod tests {
    use lsp_types::request;
    use serde_json::json;

    use super::*;

    #[test]
    fn a_crash_of_one_request_is_an_error_of_that_request() {
        let (server, editor) = Connection::memory();
        let mut routes = Routes::all();
        routes.add::<request::HoverRequest>(|_, _| panic!("a fault of a handler"));
        let thread = std::thread::spawn(move || Server::run(&server, Vec::new(), routes));
        let ask = |id: i32, method: &str, params: Value| {
            let request = Request::new(id.into(), method.to_string(), params);
            editor.sender.send(request.into()).expect("it reads");
            loop {
                match editor.receiver.recv().expect("it answers") {
                    Message::Response(answer) => return answer,
                    Message::Notification(_) | Message::Request(_) => {}
                }
            }
        };
        let note = |method: &str, params: Value| {
            let note = Notification::new(method.to_string(), params);
            editor.sender.send(note.into()).expect("it reads");
        };
        let file = json!({ "uri": "untitled:1", "languageId": "adams", "version": 1, "text": "t\nPART/1, GROUND\nEND\n" });
        note("textDocument/didOpen", json!({ "textDocument": file }));
        let place = json!({ "textDocument": { "uri": "untitled:1" }, "position": { "line": 1, "character": 1 } });
        let crashed = ask(1, "textDocument/hover", place);
        let code = crashed.response_result.err().map(|error| error.code);
        assert_eq!(code, Some(ErrorCode::InternalError as i32));
        let symbols = ask(
            2,
            "textDocument/documentSymbol",
            json!({ "textDocument": { "uri": "untitled:1" } }),
        );
        assert_eq!(
            symbols
                .response_result
                .expect("an answer")
                .as_array()
                .map(Vec::len),
            Some(2)
        );
        ask(3, "shutdown", Value::Null);
        note("exit", Value::Null);
        assert_eq!(
            thread.join().expect("no crash of the server"),
            Ended::Orderly
        );
    }
}
