use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use admire_results::{
    GraphicsWriter, Header, NumberStyle, RequestEntry, RequestWriter, ResultsTable, ResultsWriter,
    StepKind, Style, Tabular, TabularRequest, Timestamp, XrfWriter, write_tabular,
};
use admire_solver::model::{Model, Request};
use admire_solver::motion::Mode;
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{LineEnds, patiently};

use super::columns::{Columns, places, usual_names};
use super::file_policy::FilePolicy;
use super::graphics::{Drawn, drawn};
use super::measures::Measures;
use super::record::{Record, Sink};

/// Extensions of the files that a run writes in addition to the message file.
const EXTENSIONS: [&str; 4] = ["res", "req", "gra", "out"];

/// Maximum number of request rows (output steps times requests) that are kept in memory for the tables of `.out` before they are written.
const KEPT: usize = 1 << 17;

/// The output files of one model.
///
/// Files with the same names from an earlier run are emptied when the model is read, so that a failed run never leaves old results behind.
/// The files are then written in place and flushed after every output step.
pub(super) struct Outputs {
    prefix: PathBuf,
    /// Files from an earlier run that this run has not written to yet.
    unused: Vec<PathBuf>,
    begun: bool,
    /// Outputs that are kept in memory; `None` if files are written.
    record: Option<Record>,
    results: Option<(Box<dyn ResultsWriter>, Columns)>,
    requests: Option<RequestWriter<Sink>>,
    graphics: Option<(GraphicsWriter<Sink>, Drawn)>,
    /// Ids of the requests when the files were started, with their indices in the current model; `None` if the model no longer has the
    /// request.
    requested: Vec<(u32, Option<usize>)>,
    tables: Option<Tables>,
    values: Vec<f64>,
    /// Time and kind of the output step that was written last; `None` if the model has changed since then.
    pub last: Option<(f64, StepKind)>,
    /// Time and kind of the step that was last written to `.req`.
    last_request: Option<(f64, StepKind)>,
    /// True if a simulation failed; the results are then not marked successful.
    pub failed: bool,
}

/// Tables of a `.out` file. They are written request by request, so the rows are collected first.
struct Tables {
    file: Sink,
    title: String,
    spelling: Tabular,
    /// True if each simulation has its own tables.
    separate: bool,
    requests: Vec<TabularRequest>,
    rows: Vec<(f64, Vec<[f64; 8]>)>,
}

impl Outputs {
    /// Creates the outputs for a prefix, and empties existing files that have the names of these outputs.
    ///
    /// # Errors
    /// Returns an error if a file lies outside of the allowed folders or cannot be written.
    pub(crate) fn prepare(prefix: PathBuf, policy: &FilePolicy) -> Result<Self, Diagnostic> {
        let mut unused = Vec::new();
        for extension in EXTENSIONS {
            let path = with_extension(&prefix, extension);
            policy.check(&path)?;
            if path.exists() {
                emptied(&path).map_err(|error| cannot_write(&path, &error))?;
                unused.push(path);
            }
        }
        policy.check(&with_extension(&prefix, "msg"))?;
        Ok(Self::to(prefix, unused, None))
    }

    /// Creates outputs that are kept in memory instead of being written to files.
    pub(crate) fn in_memory(prefix: PathBuf) -> Self {
        Self::to(prefix, Vec::new(), Some(Record::default()))
    }

    fn to(prefix: PathBuf, unused: Vec<PathBuf>, record: Option<Record>) -> Self {
        Self {
            prefix,
            unused,
            begun: false,
            record,
            results: None,
            requests: None,
            graphics: None,
            requested: Vec::new(),
            tables: None,
            values: Vec::new(),
            last: None,
            last_request: None,
            failed: false,
        }
    }

    /// Takes out the outputs that were kept in memory; `None` if files are written.
    pub(crate) fn take_record(&mut self) -> Option<Record> {
        self.record.take()
    }

    /// Returns true once a simulation was requested. From then on, the columns of the files are fixed.
    pub(crate) fn have_begun(&self) -> bool {
        self.begun
    }

    /// Returns the common beginning of the paths of all output files.
    pub(crate) fn prefix(&self) -> &Path {
        &self.prefix
    }

    /// Returns the path of the message file.
    pub(crate) fn message_file(&self) -> PathBuf {
        with_extension(&self.prefix, "msg")
    }

    /// Writes the head of each file that the model requests, and the model as it was read. A second call has no effect.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub(crate) fn begin(
        &mut self,
        model: &Model,
        dataset: &Dataset,
        system: &System,
    ) -> Result<(), Diagnostic> {
        if self.begun {
            return Ok(());
        }
        self.begun = true;
        let when = Timestamp::now();
        let all = model.requests.iter().enumerate();
        self.requested = all.map(|(at, r)| (r.header.id, Some(at))).collect();
        // Results in memory are kept even if the model requests no results file.
        if model.results.present || self.record.is_some() {
            self.begin_results(model, system, when)?;
        }
        if model.output.reqsave {
            let entries: Vec<RequestEntry> = model.requests.iter().map(entry).collect();
            self.requests = Some(self.create("req", |file| {
                RequestWriter::create(file, &model.title, &model.units, when, &entries)
            })?);
        }
        if model.output.grsave {
            self.begin_graphics((model, dataset), system, when)?;
        }
        if !model.output.noprint && !model.requests.is_empty() {
            let ypr = model.output.ypr;
            let requests = model.requests.iter().map(|r| tabular(r, ypr)).collect();
            self.tables = Some(Tables {
                file: self.create("out", Ok)?,
                title: model.title.clone(),
                spelling: Tabular {
                    fixed: model.output.fixed,
                    narrow: model.output.teletype,
                },
                separate: !model.output.noseparator,
                requests,
                rows: Vec::new(),
            });
        }
        Ok(())
    }

    /// Updates the indices of the objects whose values the results, graphics and request files contain. Must be called after the model was
    /// compiled again.
    pub(crate) fn locate(&mut self, model: &Model, system: &System) {
        if let Some((_, columns)) = &mut self.results {
            columns.locate(model, system);
        }
        if let Some((_, drawn)) = &mut self.graphics {
            drawn.locate(model, system);
        }
        let requests = places(model.requests.iter().map(|request| request.header.id));
        for (id, at) in &mut self.requested {
            *at = requests.get(id).copied();
        }
    }

    fn create<T>(
        &mut self,
        extension: &str,
        begin: impl FnOnce(Sink) -> io::Result<T>,
    ) -> Result<T, Diagnostic> {
        let path = with_extension(&self.prefix, extension);
        self.unused.retain(|unused| *unused != path);
        let sink = match &mut self.record {
            Some(record) => Ok(record.sink(extension)),
            None => emptied(&path).map(Sink::file),
        };
        sink.and_then(begin)
            .map_err(|error| cannot_write(&path, &error))
    }

    fn begin_results(
        &mut self,
        model: &Model,
        system: &System,
        when: Timestamp,
    ) -> Result<(), Diagnostic> {
        let path = with_extension(&self.prefix, "res");
        let shown = std::path::absolute(&path).unwrap_or(path);
        let shown = shown.display().to_string();
        let mut header = Header::new(&shown, &model.title, &model.units, when);
        header.comment.clone_from(&model.results.comment);
        let columns = Columns::of(model, system);
        let style = Style {
            numbers: NumberStyle::Decimals(model.results.decimal_places.min(40) as u8),
            ..Style::default()
        };
        columns.input(&system.state(), &mut self.values);
        let values = std::mem::take(&mut self.values);
        let catalogue = columns.catalogue.clone();
        let mut results: Box<dyn ResultsWriter> = if self.record.is_some() {
            Box::new(ResultsTable::new(header, catalogue, style.numbers))
        } else {
            Box::new(self.create("res", |file| {
                XrfWriter::create(file, &header, &catalogue, style)
            })?)
        };
        results
            .step(StepKind::Input, &values)
            .map_err(|error| cannot_write(&self.beside("res"), &error))?;
        self.results = Some((results, columns));
        Ok(())
    }

    fn begin_graphics(
        &mut self,
        (model, dataset): (&Model, &Dataset),
        system: &System,
        when: Timestamp,
    ) -> Result<(), Diagnostic> {
        let (head, mut drawn) = drawn(model, dataset);
        drawn.locate(model, system);
        let writer = self.create("gra", |file| GraphicsWriter::create(file, when, &head))?;
        self.graphics = Some((writer, drawn));
        Ok(())
    }

    /// Writes one output step to every file.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub(crate) fn step(
        &mut self,
        kind: StepKind,
        model: &Model,
        measures: &mut Measures<'_>,
    ) -> Result<(), Diagnostic> {
        let state = measures.state;
        self.last = Some((state.time, kind));
        let prefix = &self.prefix;
        let failed =
            |extension, error: io::Error| cannot_write(&with_extension(prefix, extension), &error);
        if let Some((writer, columns)) = &mut self.results {
            columns.step(model, measures, &mut self.values);
            writer
                .step(kind, &self.values)
                .map_err(|error| failed("res", error))?;
        }
        if model.output.grsave
            && let Some((writer, drawn)) = &mut self.graphics
        {
            let (poses, loads) = drawn.frame(measures);
            writer
                .frame(kind, state.time, &poses, &loads)
                .map_err(|error| failed("gra", error))?;
        }
        if self.requests.is_none() && self.tables.is_none() {
            return Ok(());
        }
        let mut row = |at: usize| measures.request(model, at);
        let rows: Vec<[f64; 8]> = self
            .requested
            .iter()
            .map(|(_, at)| at.map_or([0.0; 8], &mut row))
            .collect();
        let requested = Some((state.time, kind));
        if model.output.reqsave
            && !is_repeated(self.last_request, state.time, kind)
            && let Some(writer) = &mut self.requests
        {
            let six: Vec<[f64; 6]> = rows
                .iter()
                .map(|v| [v[1], v[2], v[3], v[5], v[6], v[7]])
                .collect();
            writer
                .step(state.time, &six)
                .map_err(|error| failed("req", error))?;
            self.last_request = requested;
        }
        if let Some(tables) = &mut self.tables {
            tables.rows.push((state.time, rows));
            if tables.rows.len() * tables.requests.len() > KEPT {
                tables.write().map_err(|error| failed("out", error))?;
            }
        }
        Ok(())
    }

    /// Returns true if a simulation over time must write its start: the last step had another kind or time, or the model has changed since
    /// then.
    pub(crate) fn begins_with(&self, time: f64, kind: StepKind) -> bool {
        self.last != Some((time, kind))
    }

    /// Returns the path of an output file with the given extension.
    pub(crate) fn beside(&self, extension: &str) -> std::path::PathBuf {
        with_extension(&self.prefix, extension)
    }

    /// Writes a complete file with the given extension beside the other output files.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub(crate) fn write_beside(&mut self, extension: &str, text: &str) -> Result<(), Diagnostic> {
        self.write_file(&self.beside(extension), text)
    }

    /// Writes a complete file, or keeps it under its name if outputs are kept in memory.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub(crate) fn write_file(&mut self, path: &Path, text: &str) -> Result<(), Diagnostic> {
        if let Some(record) = &mut self.record {
            record.add(path, text);
            return Ok(());
        }
        write_text(path, text).map_err(|error| cannot_write(path, &error))
    }

    /// Keeps the modes if outputs are kept in memory. Has no effect if files are written.
    pub(crate) fn keep_modes(&mut self, modes: impl Iterator<Item = Mode>) {
        if let Some(record) = &mut self.record {
            record.modes = modes.collect();
        }
    }

    /// Returns true if the outputs are kept in memory.
    pub(crate) fn is_in_memory(&self) -> bool {
        self.record.is_some()
    }

    /// Ends a simulation. The next simulation gets tables of its own, unless OUTPUT/NOSEPARATOR is given.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub(crate) fn simulation_ended(&mut self) -> Result<(), Diagnostic> {
        let path = with_extension(&self.prefix, "out");
        match &mut self.tables {
            Some(tables) if tables.separate => {
                tables.write().map_err(|error| cannot_write(&path, &error))
            }
            _ => Ok(()),
        }
    }

    /// Completes and closes the files at the end of a run.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub(crate) fn finish(&mut self) -> Result<(), Diagnostic> {
        // The word that ADAMS writes after a failed run is unknown; programs that read the file look for `Successful`.
        let status = if self.failed { "Failed" } else { "Successful" };
        if let Some((results, _)) = self.results.take() {
            let path = with_extension(&self.prefix, "res");
            let table = results
                .finish(status)
                .map_err(|error| cannot_write(&path, &error))?;
            if let Some(record) = &mut self.record {
                record.results = table;
            }
        }
        if let Some(mut tables) = self.tables.take() {
            let path = with_extension(&self.prefix, "out");
            tables
                .write()
                .map_err(|error| cannot_write(&path, &error))?;
        }
        Ok(())
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for path in &self.unused {
            // The file contains only a line end, so it does no harm if this call fails.
            let _ = File::create(path);
        }
    }
}

impl Tables {
    fn write(&mut self) -> io::Result<()> {
        let when = Timestamp::now();
        write_tabular(
            &mut self.file,
            &self.title,
            when,
            self.spelling,
            &self.requests,
            &self.rows,
        )?;
        self.rows.clear();
        Ok(())
    }
}

/// Returns true if a simulation over time starts at the time of an equilibrium that was just written; this time is not repeated in `.req`.
///
/// After an initial-conditions analysis, the time is repeated, as in real files (guide/formats.md 6.3).
fn is_repeated(last: Option<(f64, StepKind)>, time: f64, kind: StepKind) -> bool {
    let same = last.is_some_and(|(at, before)| at == time && before.is_equilibrium());
    same && kind != StepKind::Static
}

/// Returns the title under which a request is written: its comment or, if it has none, its name.
fn called(request: &Request) -> &str {
    if !request.comment.is_empty() {
        return &request.comment;
    }
    request
        .results_name
        .as_deref()
        .unwrap_or(&request.header.name)
}

fn entry(request: &Request) -> RequestEntry {
    RequestEntry {
        id: i64::from(request.header.id),
        name: called(request).to_string(),
        numbers: Vec::new(),
    }
}

fn tabular(request: &Request, ypr: bool) -> TabularRequest {
    let given = request.component_names.as_deref().unwrap_or_default();
    let usual = usual_names(&request.kind, ypr);
    TabularRequest {
        id: i64::from(request.header.id),
        name: called(request).to_string(),
        headings: std::array::from_fn(|k| {
            given
                .get(k)
                .filter(|name| !name.is_empty())
                .map_or_else(|| usual[k].to_string(), Clone::clone)
        }),
    }
}

/// Opens a text file for writing and discards its content.
///
/// On Windows, lines end with CR LF, as in files that ADAMS writes there (grammar/NOTES.md, "Files of a run on Windows").
///
/// The file keeps one line end, which the first write overwrites. Some file systems (ext4 with `auto_da_alloc`) treat a file that was
/// truncated to zero as replaced. They write such a file to disk as soon as it is closed, which delays the next run.
pub(super) fn emptied(path: &Path) -> io::Result<LineEnds<File>> {
    let mut options = File::options();
    options.write(true).create(true).truncate(false);
    let mut file = patiently(|| options.open(path))?;
    if file.metadata()?.len() > 0 {
        file.write_all(b"\n")?;
        file.set_len(1)?;
        file.rewind()?;
    }
    Ok(LineEnds::of_system(file))
}

/// Writes a text file that is complete, with the line ends of the operating system.
pub(super) fn write_text(path: &Path, text: &str) -> io::Result<()> {
    let file = patiently(|| File::create(path))?;
    LineEnds::of_system(file).write_all(text.as_bytes())
}

/// Appends a dot and an extension to the prefix. The prefix may contain dots, which stay.
pub(super) fn with_extension(prefix: &Path, extension: &str) -> PathBuf {
    let mut path = prefix.as_os_str().to_owned();
    path.push(".");
    path.push(extension);
    PathBuf::from(path)
}

fn cannot_write(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::error(
        Code::CannotWrite,
        format!("`{}` cannot be written: {error}", path.display()),
    )
}
