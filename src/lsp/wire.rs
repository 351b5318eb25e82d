//! Protocol messages on standard input and output. Malformed input is answered with an error, and reading continues with the next message.

use std::io::{self, BufRead, Read, Write};
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, bounded};
use lsp_server::{Connection, ErrorCode, Message};
use serde_json::{Value, json};

use admire_syntax::text::Source;

/// Largest accepted size of a message in bytes. It admits the largest readable file with each byte escaped as two.
const LARGEST: u64 = 2 * Source::LARGEST;

/// Length in bytes beyond which a line is not a header. Only the end of such a line is kept.
const LONGEST_LINE: u64 = 1 << 16;

/// Number of bytes kept from the end of an overlong line, because a header may start within them.
const KEPT: usize = 64;

const LENGTH: &[u8] = b"content-length:";

/// Threads that read and write the messages.
pub(super) struct Wire {
    reader: JoinHandle<()>,
    writer: JoinHandle<io::Result<()>>,
}

/// Connects to the editor that started this process.
pub(super) fn stdio() -> (Connection, Wire) {
    // The channels have no buffer, so a sender waits for the receiver.
    let (sender, messages) = bounded(0);
    let (said, receiver) = bounded(0);
    let writer = std::thread::spawn(move || write(&messages));
    let reader = std::thread::spawn(move || read(&said));
    (Connection { sender, receiver }, Wire { reader, writer })
}

impl Wire {
    /// Waits until the threads have ended and the last message is written.
    ///
    /// # Errors
    /// When a message cannot be written, or a thread has panicked.
    pub(super) fn join(self) -> io::Result<()> {
        let crashed = |_| io::Error::other("a thread of the connection crashed");
        self.reader.join().map_err(crashed)?;
        self.writer.join().map_err(crashed)?
    }
}

fn write(messages: &Receiver<Message>) -> io::Result<()> {
    messages
        .iter()
        .try_for_each(|message| message.write(&mut io::stdout().lock()))
}

fn read(said: &Sender<Message>) {
    let mut messages = Messages {
        input: io::stdin().lock(),
        lost: false,
    };
    // Unreadable input counts as the end of the input.
    while let Ok(Some(next)) = messages.next() {
        match next {
            Ok(message) => {
                let exits = matches!(&message, Message::Notification(n) if n.method == "exit");
                if said.send(message).is_err() || exits {
                    return;
                }
            }
            Err(refused) => {
                if refused.write().is_err() {
                    return;
                }
            }
        }
    }
}

/// Reason why input is not a valid message.
#[derive(Debug)]
struct MalformedMessage {
    id: Value,
    code: ErrorCode,
    why: String,
}

impl MalformedMessage {
    fn new(code: ErrorCode, why: impl Into<String>) -> Self {
        Self {
            id: Value::Null,
            code,
            why: why.into(),
        }
    }

    /// Sends the error response. Standard output is locked for each message, so that the response does not mix with messages of the writer
    /// thread.
    fn write(&self) -> io::Result<()> {
        let error = json!({ "code": self.code as i32, "message": self.why });
        let text = json!({ "jsonrpc": "2.0", "id": self.id, "error": error }).to_string();
        let mut out = io::stdout().lock();
        write!(out, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        out.flush()
    }
}

/// Reader of incoming messages, one at a time.
struct Messages<R> {
    input: R,
    /// True after a malformed header, when the start of the next message is unknown. Input is then skipped up to the next header.
    lost: bool,
}

impl<R: BufRead> Messages<R> {
    /// Reads the next message, or the reason why it is invalid; `None` at the end of the input.
    fn next(&mut self) -> io::Result<Option<Result<Message, MalformedMessage>>> {
        let size = match self.header()? {
            None => return Ok(None),
            Some(Err(why)) => {
                self.lost = true;
                return Ok(Some(Err(MalformedMessage::new(ErrorCode::ParseError, why))));
            }
            Some(Ok(size)) => size,
        };
        self.lost = false;
        let mut body = Vec::new();
        // The buffer grows with the bytes received; the announced length is not trusted.
        self.input.by_ref().take(size).read_to_end(&mut body)?;
        if (body.len() as u64) < size {
            return Ok(None);
        }
        Ok(Some(message(&body)))
    }

    /// Reads the header of the next message and returns the announced length, or an error text. `None` at the end of the input.
    fn header(&mut self) -> io::Result<Option<Result<u64, String>>> {
        let mut found: Option<Result<u64, String>> = None;
        let mut line = Vec::new();
        let mut said = false;
        loop {
            let room = LONGEST_LINE - line.len() as u64;
            if self
                .input
                .by_ref()
                .take(room)
                .read_until(b'\n', &mut line)?
                == 0
            {
                return Ok(None);
            }
            if !line.ends_with(b"\n") {
                line.drain(..line.len().saturating_sub(KEPT));
                said = true;
                continue;
            }
            let text = line.trim_ascii().to_ascii_lowercase();
            if let Some(start) = memchr::memmem::find(&text, LENGTH) {
                found = Some(length(&text[start + LENGTH.len()..]));
            }
            let blank = text.is_empty();
            line.clear();
            if !blank {
                said = true;
                continue;
            }
            match found {
                Some(found) => return Ok(Some(found)),
                None if said && !self.lost => {
                    return Ok(Some(Err(
                        "the message has no Content-Length header".to_string()
                    )));
                }
                None => {}
            }
        }
    }
}

fn length(digits: &[u8]) -> Result<u64, String> {
    let shown = String::from_utf8_lossy(digits.trim_ascii()).into_owned();
    match shown.parse() {
        Ok(size) if size <= LARGEST => Ok(size),
        Ok(size) => Err(format!(
            "the message has {size} bytes; the limit is {LARGEST} bytes"
        )),
        Err(_) => Err(format!(
            "the Content-Length `{shown}` is not a number of bytes"
        )),
    }
}

/// Parses the body of a message.
fn message(body: &[u8]) -> Result<Message, MalformedMessage> {
    let error = match serde_json::from_slice(body) {
        Ok(message) => return Ok(message),
        Err(error) => error,
    };
    match serde_json::from_slice::<Value>(body) {
        Err(error) => Err(MalformedMessage::new(
            ErrorCode::ParseError,
            error.to_string(),
        )),
        Ok(mut value) => {
            let mut refused = MalformedMessage::new(ErrorCode::InvalidRequest, error.to_string());
            if let Some(id) = value
                .get_mut("id")
                .filter(|id| id.is_number() || id.is_string())
            {
                refused.id = id.take();
            }
            Err(refused)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns, in order of input, the method of each message and the error code of each malformed input.
    fn read_all(input: &[u8]) -> Vec<String> {
        let mut messages = Messages { input, lost: false };
        let mut out = Vec::new();
        while let Some(next) = messages.next().unwrap() {
            out.push(match next {
                Ok(Message::Request(request)) => request.method,
                Ok(Message::Notification(note)) => note.method,
                Ok(Message::Response(_)) => "response".to_string(),
                Err(refused) => (refused.code as i32).to_string(),
            });
        }
        out
    }

    fn framed(body: &[u8]) -> Vec<u8> {
        [
            format!("Content-Length: {}\r\n\r\n", body.len()).as_bytes(),
            body,
        ]
        .concat()
    }

    #[test]
    fn after_what_is_no_message_the_next_one_is_read() {
        let good = framed(br#"{"jsonrpc":"2.0","method":"a"}"#);
        let long = framed(&vec![b'{'; 300_000]);
        let unframed = [
            &b"Content-Length: 100000000000\r\n\r\n"[..],
            &vec![b'x'; 200_000],
        ]
        .concat();
        for (bad, code) in [
            (framed(b"{\"method\":"), "-32700"),
            (framed(b"{\"method\":\"\xff\"}"), "-32700"),
            (framed(b"\xff"), "-32700"),
            (framed(b""), "-32700"),
            (long, "-32700"),
            (framed(b"[1]"), "-32600"),
            (framed(b"{}"), "-32600"),
            (b"Content-Length: 100000000000\r\n\r\n{}".to_vec(), "-32700"),
            (
                b"Content-Length: 99999999999999999999999\r\n\r\n".to_vec(),
                "-32700",
            ),
            (b"Content-Length: -1\r\n\r\n".to_vec(), "-32700"),
            (b"Content-Type: x\r\n\r\n{}".to_vec(), "-32700"),
            (unframed, "-32700"),
        ] {
            let input = [good.as_slice(), &bad, &good].concat();
            let shown = String::from_utf8_lossy(&bad[..bad.len().min(60)]).into_owned();
            assert_eq!(read_all(&input), ["a", code, "a"], "{shown}");
        }
        assert_eq!(read_all(b"Content-Length: 5\r\n\r\n{}"), [""; 0]);
        let id = message(br#"{"id":7}"#).unwrap_err().id;
        assert_eq!(id, 7);
    }
}
