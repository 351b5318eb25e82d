use std::io::Read;
use std::sync::Arc;

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

use super::step::count_tokens;
use super::xml::{Found, LIMIT, Refusal, Scanner, Tag, attributes, decode};
use super::{
    Catalogue, Component, Entity, Header, LineEnd, ResultsError, ResultsReader, Step, StepKind,
    Values,
};

/// Maximum nesting depth of elements; real files have a depth of five.
const DEEPEST: usize = 16;
/// Maximum number of columns in a file.
const MOST_COLUMNS: usize = 1 << 22;
/// Maximum number of bytes for a value and the blank after it; values in real files need at most 27 bytes.
const BYTES_PER_VALUE: usize = 64;

/// Step-by-step reader of an XRF file. Its memory depends on the number of columns but not on the number of output steps.
///
/// The number of values in each step is checked against the file's map of columns. A step with more or fewer values is an error that ends
/// the reading, so that no value is ever assigned to the wrong column.
///
/// If a run was killed and its file is incomplete, all complete steps are returned, and the reader reports a warning.
#[derive(Debug)]
pub struct XrfReader<R> {
    scanner: Scanner<R>,
    file: Arc<str>,
    header: Header,
    catalogue: Catalogue,
    columns: usize,
    line_end: LineEnd,
    block: String,
    steps: usize,
    depth: usize,
    status: Option<String>,
    done: bool,
    diagnostics: Vec<Diagnostic>,
    /// Tag that ended the header and that the next call must process.
    pending: Option<Event>,
}

/// A tag, with its attributes parsed.
#[derive(Debug)]
enum Event {
    Open {
        name: String,
        attributes: Vec<(String, String)>,
        empty: bool,
    },
    Close(String),
    EndOfFile,
}

impl<R: Read> XrfReader<R> {
    /// Reads the header and the map of columns. `file` is the name used in messages.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read, is not an XRF file, or ends before the first step.
    pub fn open(file: impl Into<Arc<str>>, input: R) -> Result<Self, ResultsError> {
        let mut reader = Self {
            scanner: Scanner::new(input),
            file: file.into(),
            header: Header::default(),
            catalogue: Catalogue::default(),
            columns: 0,
            line_end: LineEnd::Lf,
            block: String::new(),
            steps: 0,
            depth: 0,
            status: None,
            done: false,
            diagnostics: Vec::new(),
            pending: None,
        };
        reader.begin()?;
        reader.read_header()?;
        reader.check_columns()?;
        Ok(reader)
    }

    /// Returns the header of the file.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Returns the catalogue, which names the columns.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Returns the number of values in every output step.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the kind of line end that the first line of the file has.
    pub fn line_end(&self) -> LineEnd {
        self.line_end
    }

    /// Returns the status of the run (such as `Successful`) once the end of the file has been read.
    pub fn run_status(&self) -> Option<&str> {
        self.status.as_deref()
    }

    /// Returns the diagnostics that the reader has collected so far.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Returns the next complete output step, or `None` at the end of the file.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read, or if the file is malformed at this step. The steps returned before are valid.
    pub fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError> {
        while !self.done {
            let event = match self.pending.take() {
                Some(event) => event,
                None => self.event()?,
            };
            match event {
                Event::EndOfFile => self.cut_off(),
                Event::Close(name) => self.done = name == "Results",
                Event::Open {
                    empty: true,
                    name,
                    attributes,
                } if name == "TerminationStatus" => {
                    self.status = take(&attributes, "runStatus");
                }
                Event::Open {
                    name, attributes, ..
                } => match name.as_str() {
                    "Step" => {
                        let kind = take(&attributes, "type").unwrap_or_default();
                        let kind = self.step_kind(&kind);
                        let Some((offset, text)) = self.step_text()? else {
                            self.cut_off();
                            continue;
                        };
                        self.steps += 1;
                        return Ok(Some(Step {
                            file: &self.file,
                            index: self.steps - 1,
                            kind,
                            block: &self.block,
                            values: Values::Text {
                                offset,
                                text: self.scanner.bytes(text),
                            },
                        }));
                    }
                    "Data" => self.block = take(&attributes, "name").unwrap_or_default(),
                    "StepMap" | "Entity" | "Component" => {
                        return Err(self.refuse(
                            Code::UnsupportedResults,
                            "this is a second StepMap; only results files with one StepMap are supported",
                        ));
                    }
                    _ => {}
                },
            }
        }
        Ok(None)
    }

    fn cut_off(&mut self) {
        self.done = true;
        let at = self.scanner.offset() as usize;
        let message = format!(
            "the file ends too early; the number of complete steps is {}",
            self.steps
        );
        self.diagnostics.push(
            Diagnostic::warning(Code::TruncatedResults, message)
                .label(self.file.clone(), Span::at(at), "")
                .help("the run was killed or is still running"),
        );
    }

    fn step_kind(&mut self, text: &str) -> StepKind {
        let kind = StepKind::from_step_type(text);
        if kind == StepKind::Unlisted
            && text != StepKind::Unlisted.step_type()
            && !self
                .diagnostics
                .iter()
                .any(|d| d.code == Code::UnsupportedResults)
        {
            let at = Span::at(self.scanner.offset() as usize);
            let message = format!(
                "steps of the unknown type `{}` are read",
                text.escape_debug()
            );
            self.diagnostics.push(
                Diagnostic::warning(Code::UnsupportedResults, message).label(
                    self.file.clone(),
                    at,
                    "",
                ),
            );
        }
        kind
    }

    /// Reads an output step up to and including its closing tag. Returns the offset and the range of its text, or `None` if the file ends
    /// first.
    fn step_text(&mut self) -> Result<Option<(u64, std::ops::Range<usize>)>, ResultsError> {
        // The closing tag is read before the text is used, because reading may move the text inside the window.
        let limit = self.columns * BYTES_PER_VALUE + 4096;
        let text = match self.scanner.text(limit)? {
            Found::Yes(text) => text,
            Found::EndOfFile => return Ok(None),
            Found::Refused(_) => {
                return Err(self.refuse(
                    Code::WrongCount,
                    "this step is too long for the number of columns of the file",
                ));
            }
        };
        let offset = self.scanner.offset_of(text.start);
        let count = count_tokens(self.scanner.bytes(text.clone()));
        match self.scanner.closing(text, b"Step")? {
            Found::Yes(text) => {
                if count != self.columns {
                    let message = format!(
                        "step {} has {count} values, but the file has {} columns",
                        self.steps + 1,
                        self.columns
                    );
                    let end = offset + text.len() as u64;
                    let error =
                        ResultsError::refused(Code::WrongCount, &self.file, offset, end, message);
                    self.done = true;
                    return Err(error);
                }
                self.depth = self.depth.saturating_sub(1);
                Ok(Some((offset, text)))
            }
            Found::EndOfFile => Ok(None),
            Found::Refused(_) => Err(self.refuse(
                Code::MalformedResults,
                "this step contains a value that is not a number",
            )),
        }
    }

    /// Ends the reading and returns an error located at the current position in the file.
    fn refuse(&mut self, code: Code, message: impl Into<String>) -> ResultsError {
        self.done = true;
        let at = self.scanner.offset();
        ResultsError::refused(code, &self.file, at, at, message)
    }

    fn refuse_xml(&mut self, refusal: Refusal) -> ResultsError {
        self.refuse(Code::MalformedResults, refusal.to_string())
    }

    fn begin(&mut self) -> Result<(), ResultsError> {
        let head = self.scanner.peek(512)?;
        let bom = if head.starts_with(b"\xef\xbb\xbf") {
            3
        } else {
            0
        };
        let shown = head[bom..].trim_ascii_start();
        let xml = shown.starts_with(b"<");
        let formatted = shown.starts_with(b"FILE TYPE AND SOURCE");
        let crlf = memchr::memchr(b'\n', head).is_some_and(|at| at > 0 && head[at - 1] == b'\r');
        self.scanner.skip(bom);
        if crlf {
            self.line_end = LineEnd::CrLf;
        }
        if xml {
            return Ok(());
        }
        let message = if formatted {
            "this is a formatted (ASCII) results file, not an XRF file"
        } else {
            "this is not an XRF results file: it does not begin with XML"
        };
        Err(self.refuse(Code::UnsupportedResults, message))
    }

    /// Skips the text before the next tag and returns this tag.
    fn event(&mut self) -> Result<Event, ResultsError> {
        if matches!(self.scanner.skip_text()?, Found::EndOfFile) {
            return Ok(Event::EndOfFile);
        }
        let tag = match self.scanner.tag()? {
            Found::Yes(tag) => tag,
            Found::EndOfFile => return Ok(Event::EndOfFile),
            Found::Refused(refusal) => return Err(self.refuse_xml(refusal)),
        };
        match tag {
            Tag::Close { name } => {
                let name = String::from_utf8_lossy(self.scanner.bytes(name)).into_owned();
                if self.depth == 0 {
                    let message = format!("`</{}>` has no opening tag", name.escape_debug());
                    return Err(self.refuse(Code::MalformedResults, message));
                }
                self.depth -= 1;
                Ok(Event::Close(name))
            }
            Tag::Open {
                name,
                attributes: text,
                empty,
            } => {
                let name = String::from_utf8_lossy(self.scanner.bytes(name)).into_owned();
                let attributes = attributes(self.scanner.bytes(text))
                    .map_err(|refusal| self.refuse_xml(refusal))?;
                self.depth += usize::from(!empty);
                if self.depth > DEEPEST {
                    let message = format!("elements are nested more than {DEEPEST} levels deep");
                    return Err(self.refuse(Code::MalformedResults, message));
                }
                Ok(Event::Open {
                    name,
                    attributes,
                    empty,
                })
            }
        }
    }

    fn read_header(&mut self) -> Result<(), ResultsError> {
        let mut in_model = false;
        let mut root = false;
        loop {
            let event = self.event()?;
            let (name, attributes, empty) = match event {
                Event::EndOfFile => {
                    return Err(self.refuse(
                        Code::TruncatedResults,
                        "the file ends inside its header: no step was written",
                    ));
                }
                Event::Close(name) => {
                    in_model &= name != "ModelInfo";
                    if name == "Results" {
                        self.done = true;
                        return Ok(());
                    }
                    continue;
                }
                Event::Open {
                    name,
                    attributes,
                    empty,
                } => (name, attributes, empty),
            };
            if !root && name != "Results" {
                let message = format!(
                    "the root element is `{}`, not `Results`",
                    name.escape_debug()
                );
                return Err(self.refuse(Code::UnsupportedResults, message));
            }
            root = true;
            let set = |key: &str, field: &mut String| {
                if let Some(value) = take(&attributes, key) {
                    *field = value;
                }
            };
            let h = &mut self.header;
            match name.as_str() {
                "File" => {
                    set("URI", &mut h.uri);
                    set("schema", &mut h.schema);
                    set("version", &mut h.version);
                    set("publicationDate", &mut h.publication_date);
                }
                "Corporation" => {
                    set("author", &mut h.corporation);
                    set("URI", &mut h.corporation_uri);
                }
                "Author" => {
                    set("user", &mut h.user);
                    set("name", &mut h.user_name);
                }
                "Revision" => {
                    set("version", &mut h.revision);
                    set("derivedFrom", &mut h.derived_from);
                }
                "Analysis" => {
                    set("name", &mut h.analysis);
                    set("executionDate", &mut h.execution_date);
                    set("Solver", &mut h.solver);
                    set("script", &mut h.script);
                }
                "Environment" => {
                    set("operatingSystem", &mut h.operating_system);
                    set("hostname", &mut h.hostname);
                }
                "Application" => {
                    set("name", &mut h.application);
                    set("version", &mut h.application_version);
                }
                "ModelInfo" => {
                    set("title", &mut h.title);
                    set("creationDate", &mut h.creation_date);
                    set("checksum", &mut h.checksum);
                    in_model = !empty;
                }
                "Units" => {
                    set("angle", &mut h.units.angle);
                    set("length", &mut h.units.length);
                    set("mass", &mut h.units.mass);
                    set("time", &mut h.units.time);
                }
                "Comment" if !empty => {
                    let text = self.comment()?;
                    if in_model {
                        self.header.model_comment = Some(text);
                    } else {
                        self.header.comment = text;
                    }
                }
                "StepMap" => set("name", &mut self.catalogue.name),
                "Entity" => self.entity(&attributes),
                "Component" => self.component(&attributes)?,
                "Data" | "Step" | "TerminationStatus" => {
                    self.pending = Some(Event::Open {
                        name,
                        attributes,
                        empty,
                    });
                    return Ok(());
                }
                _ => {}
            }
        }
    }

    /// Returns the lines of a comment. The line end directly after the opening tag is left out.
    fn comment(&mut self) -> Result<String, ResultsError> {
        match self.scanner.text(LIMIT)? {
            Found::Yes(text) => {
                let decoded = decode(self.scanner.bytes(text));
                let text = decoded.map_err(|refusal| self.refuse_xml(refusal))?;
                let text = text.replace("\r\n", "\n");
                Ok(text.strip_prefix('\n').unwrap_or(&text).to_string())
            }
            Found::EndOfFile => Ok(String::new()),
            Found::Refused(refusal) => Err(self.refuse_xml(refusal)),
        }
    }

    fn entity(&mut self, attributes: &[(String, String)]) {
        self.catalogue.entities.push(Entity {
            name: take(attributes, "name").unwrap_or_default(),
            entity: take(attributes, "entity"),
            ent_type: take(attributes, "entType"),
            object_id: take(attributes, "objectId").and_then(|id| id.parse().ok()),
            comment: take(attributes, "comment"),
            components: Vec::new(),
        });
    }

    fn component(&mut self, attributes: &[(String, String)]) -> Result<(), ResultsError> {
        let id = take(attributes, "id")
            .and_then(|id| id.parse().ok())
            .filter(|id| (1..=MOST_COLUMNS).contains(id));
        let Some(id) = id else {
            return Err(self.refuse(
                Code::MalformedResults,
                "this component has no id that can be the position of a value",
            ));
        };
        let component = Component {
            name: take(attributes, "name").unwrap_or_default(),
            units: take(attributes, "unitsValue"),
            plot_label: take(attributes, "plotLabel"),
            id,
        };
        match self.catalogue.entities.last_mut() {
            Some(entity) => entity.components.push(component),
            None => {
                return Err(self.refuse(
                    Code::MalformedResults,
                    "this component does not belong to an entity",
                ));
            }
        }
        Ok(())
    }

    /// Checks the ids of the columns. Two columns with the same id are an error; a position without a column gives a warning.
    fn check_columns(&mut self) -> Result<(), ResultsError> {
        self.columns = self.catalogue.len();
        let mut named = vec![false; self.columns];
        let ids: Vec<usize> = self.catalogue.columns().map(|c| c.component.id).collect();
        for id in ids {
            if std::mem::replace(&mut named[id - 1], true) {
                let message = format!("two components have the id {id}");
                return Err(self.refuse(Code::DuplicateId, message));
            }
        }
        let nameless = named.iter().filter(|&&named| !named).count();
        if nameless > 0 {
            let at = Span::at(self.scanner.offset() as usize);
            let message = format!(
                "the number of columns without a name is {nameless} of {}",
                self.columns
            );
            self.diagnostics
                .push(Diagnostic::warning(Code::MalformedResults, message).label(
                    self.file.clone(),
                    at,
                    "",
                ));
        }
        Ok(())
    }
}

impl<R: Read> ResultsReader for XrfReader<R> {
    fn header(&self) -> &Header {
        self.header()
    }

    fn catalogue(&self) -> &Catalogue {
        self.catalogue()
    }

    fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError> {
        self.next_step()
    }

    fn diagnostics(&self) -> &[Diagnostic] {
        self.diagnostics()
    }
}

fn take(attributes: &[(String, String)], name: &str) -> Option<String> {
    attributes
        .iter()
        .find(|(key, _)| key == name)
        .map(|(_, value)| value.clone())
}
