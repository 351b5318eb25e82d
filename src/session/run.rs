use std::path::{Path, PathBuf};

use admire_solver::model;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::text::{Source, read_at_most};
use admire_syntax::{CommandFile, Dataset, Statement, Wrong};

use super::ending::{Ending, Stop};
use super::files::LARGEST;
use super::harmless::{is_in, is_output_only, place_in_file};
use super::launcher::is_dataset;
use super::loaded::Loaded;
use super::outputs::{Outputs, with_extension};
use super::paths::{find_file, native_spelling};
use super::record::Record;
use super::run_state::{Flow, Locate, Place, Session};

/// Maximum nesting depth of command files that execute other command files.
const DEEPEST: usize = 16;

impl<'a> Session<'a> {
    /// Ends a run whose command line was rejected. Its message file gets the final lines that every run writes.
    pub(crate) fn refuse(self, stem: &str) {
        let start = std::time::Instant::now();
        self.named(stem).finish(Err(Stop::File), start);
    }

    /// Opens the message file of a run that has not read a model.
    fn open_messages(&mut self) {
        let Some(stem) = self.stem.take().filter(|_| !self.messages.is_open()) else {
            return;
        };
        let path = self.directory.join(format!("{stem}.msg"));
        if self.policy.check(&path).is_ok() {
            // If the file cannot be opened, the messages are still on the console.
            let _ = self.messages.open(&path);
        }
    }

    /// Executes a command file whose name is written as on a command line.
    pub fn run_file(mut self, written: &str) -> Ending {
        let start = std::time::Instant::now();
        self.messages.command(&format!("FILE/COMMAND={written}"));
        let flow = self.command_file(written, None, 0);
        self.finish(flow, start)
    }

    /// Executes commands that are not in a file, for example commands from standard input.
    pub fn run_commands(mut self, commands: &Source) -> Ending {
        let start = std::time::Instant::now();
        let flow = self.execute(commands, 0);
        self.finish(flow, start)
    }

    /// Executes commands on a dataset that was read before, and keeps all outputs in memory.
    ///
    /// The dataset replaces every model that the commands name. Files that the dataset names are looked up in the folder given by its own
    /// name.
    pub fn run_on(
        mut self,
        deck: &'a Checked<Dataset>,
        commands: &Checked<CommandFile>,
    ) -> (Ending, Record) {
        let start = std::time::Instant::now();
        self.given = Some(deck);
        self.record = Some(Record::default());
        self.messages.record();
        self.sources.add(deck.value.source().clone());
        let file = &commands.value;
        let names_a_model = file.head().is_some()
            || file
                .commands()
                .iter()
                .any(|c| c.kind() == Some("FILE") && c.argument("MODEL").is_some());
        let mut flow = Ok(());
        if !names_a_model {
            flow = self.model_file(deck.value.source().name(), None, None);
        }
        let flow = flow.and_then(|()| self.execute_file(commands, 0));
        self.end(flow, start);
        let mut record = self.record.take().unwrap_or_default();
        (record.messages, record.diagnostics) = self.messages.take();
        record.sources = self.sources;
        record.balance = self.worst_balance;
        (self.ending, record)
    }

    fn finish(mut self, flow: Flow, start: std::time::Instant) -> Ending {
        self.end(flow, start);
        self.ending
    }

    fn end(&mut self, flow: Flow, start: std::time::Instant) {
        if let Err(stop) = flow {
            self.ending.stop = stop;
        }
        if let Err(stop) = self.close_model() {
            self.ending.stop = stop;
        }
        self.open_messages();
        self.messages.finished(start.elapsed());
        if let Some(error) = self.messages.unwritten() {
            self.ending.stop = Stop::File;
            self.unwritten.get_or_insert(error);
        }
        if let Some(why) = &self.unwritten {
            // A script that looks only at the last line must be able to tell that the files are incomplete.
            self.messages
                .last(&format!("The run is not complete: {why}"));
        }
    }

    fn close_model(&mut self) -> Flow {
        match self.loaded.take() {
            Some(loaded) => self.close_outputs(loaded.outputs),
            None => Ok(()),
        }
    }

    /// Closes the output files of a model, or stores the outputs that were kept in memory.
    fn close_outputs(&mut self, mut outputs: Outputs) -> Flow {
        let results = outputs.beside("res");
        if let Err(diagnostic) = outputs.finish() {
            return self.unwritable(&diagnostic);
        }
        if let Some(record) = outputs.take_record() {
            self.record = Some(record);
        } else if results.is_file() {
            self.ending.results = Some(results);
        }
        Ok(())
    }

    /// Closes the output files of the model and opens files with a new prefix (OUTPUT_PREFIX of FILE and RELOAD). If the prefix is the
    /// current one, nothing changes.
    pub(super) fn rename_outputs(&mut self, prefix: &str, place: Option<Place<'_>>) -> Flow {
        let Some(loaded) = &self.loaded else {
            return Ok(());
        };
        let written = loaded.definitions.dataset().source().name().to_string();
        if loaded.outputs.prefix() == self.prefix_of(&written, Some(prefix)) {
            return Ok(());
        }
        let new = self.outputs_for(&written, Some(prefix), place)?;
        let Some(loaded) = &mut self.loaded else {
            return Ok(());
        };
        loaded.begun = false;
        let old = std::mem::replace(&mut loaded.outputs, new);
        self.close_outputs(old)
    }

    /// Finds and reads a file. Reports warnings about its name, or the reason why it cannot be read.
    fn read(
        &mut self,
        written: &str,
        extension: &str,
        place: Option<Place<'_>>,
    ) -> Result<(Source, PathBuf), Stop> {
        let found = find_file(written, extension, &self.folders);
        let refused = found.has_errors();
        for diagnostic in found.diagnostics {
            self.complain(&place.label(diagnostic));
        }
        let Some(path) = found.value else {
            if refused {
                return Err(Stop::File);
            }
            let missing = Diagnostic::error(
                Code::CannotRead,
                format!("there is no file `{written}`, with or without `.{extension}`"),
            )
            .help(format!(
                "it was looked for in {}",
                std::path::absolute(Path::new(".").join(&self.directory))
                    .unwrap_or_else(|_| self.directory.clone())
                    .display()
            ));
            self.complain(&place.label(missing));
            return Err(Stop::File);
        };
        if let Err(outside) = self.policy.check_read(&path) {
            self.complain(&place.label(outside));
            return Err(Stop::File);
        }
        match read_at_most(&path, LARGEST) {
            Ok(mut bytes) => {
                // Files from DOS may end with the end-of-file mark ^Z.
                while bytes.last() == Some(&0x1a) {
                    bytes.pop();
                }
                let source = Source::new(path.display().to_string(), bytes);
                self.sources.add(source.clone());
                Ok((source, path))
            }
            Err(error) => {
                let unreadable = Diagnostic::error(
                    Code::CannotRead,
                    format!("`{}` cannot be read: {error}", path.display()),
                );
                self.complain(&place.label(unreadable));
                Err(Stop::File)
            }
        }
    }

    fn command_file(&mut self, written: &str, place: Option<Place<'_>>, depth: usize) -> Flow {
        if depth >= DEEPEST {
            let deep = Diagnostic::error(
                Code::LimitExceeded,
                format!("command files are nested more than {DEEPEST} levels deep"),
            );
            self.complain(&place.label(deep));
            return Err(Stop::File);
        }
        if depth == 0
            && let Some(folder) = find_file(written, "acf", &self.folders)
                .value
                .as_deref()
                .and_then(Path::parent)
        {
            // Writing is allowed in the folder of the command file on the command line, but not in folders of command files that it
            // executes.
            self.policy.allow(folder);
        }
        let (source, path) = self.read(written, "acf", place)?;
        if is_dataset(&path.to_string_lossy()) {
            // As a command file, a dataset would be misread: its title as the name of a model, and its second line as the prefix of the
            // output files.
            let dataset = Diagnostic::error(
                Code::CannotRead,
                format!("`{}` is a dataset, not a command file", path.display()),
            )
            .help("a command file (.acf) names the dataset: FILE/MODEL=name");
            self.complain(&place.label(dataset));
            return Err(Stop::File);
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        if !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
        self.execute(&source, depth)
    }

    /// Executes commands line by line. Each line is echoed before it is executed.
    fn execute(&mut self, source: &Source, depth: usize) -> Flow {
        self.execute_file(&CommandFile::parse(source.clone()), depth)
    }

    fn execute_file(&mut self, parsed: &Checked<CommandFile>, depth: usize) -> Flow {
        let file = &parsed.value;
        let source = file.source();
        self.sources.add(source.clone());
        let mut complaints = parsed.diagnostics.clone();
        complaints.sort_by_key(place_in_file);
        let mut complaints = complaints.into_iter().peekable();
        if let Some(head) = file.head() {
            let model = source.text(head.model);
            let prefix = head.prefix.map(|span| source.text(span));
            let shown = prefix.as_deref().unwrap_or(&model);
            self.messages
                .command(&format!("FILE/MODEL={model}, OUTPUT_PREFIX={shown}"));
            let place = Some(Place {
                source,
                span: head.model,
            });
            self.model_file(&model, prefix.as_deref(), place)?;
        }
        for line in file.lines() {
            let text = source.text(line.echo);
            self.messages.command(&text);
            // `exit` is a word on the command line of `mdi`; some scripts also write it into the command file.
            if ["exit", "quit"]
                .iter()
                .any(|word| text.trim().eq_ignore_ascii_case(word))
            {
                return Ok(());
            }
            let mut broken: Vec<usize> = Vec::new();
            while let Some(mut complaint) =
                complaints.next_if(|complaint| place_in_file(complaint) <= line.echo.end())
            {
                let commands = &file.commands()[line.commands.clone()];
                if let Some(command) = commands.iter().find(|command| is_in(command, &complaint))
                    && is_output_only(command.kind())
                {
                    // Errors in commands that only print do not affect results.
                    complaint.severity = complaint.severity.min(Severity::Warning);
                }
                self.complain(&complaint);
                if complaint.severity == Severity::Error {
                    broken.push(place_in_file(&complaint));
                }
            }
            for command in &file.commands()[line.commands.clone()] {
                let in_command =
                    |at: &usize| (command.span.start()..=command.span.end()).contains(at);
                if broken.iter().any(in_command) {
                    self.ending.misunderstood += 1;
                    continue;
                }
                if command.kind() == Some("STOP") {
                    return Ok(());
                }
                self.command(command, source, depth)?;
            }
            self.messages.flush();
        }
        Ok(())
    }

    fn command(&mut self, command: &Statement, source: &Source, depth: usize) -> Flow {
        let place = Some(Place {
            source,
            span: command.span,
        });
        if !is_output_only(command.kind()) {
            let mut fractions = Vec::new();
            command.faults(
                |_, _| true,
                |fault| {
                    if matches!(fault.wrong, Wrong::NotWhole(_)) {
                        fractions.push(fault.diagnostic(source, ""));
                    }
                },
            );
            if let Some(first) = fractions.into_iter().next() {
                return self.misunderstood(first, place);
            }
        }
        match command.kind().unwrap_or_default() {
            "FILE" => {
                if let Some(argument) = command.argument("COMMAND") {
                    let name = argument.text(source).unwrap_or_default();
                    let place = Some(Place {
                        source,
                        span: argument.value_span(),
                    });
                    return self.command_file(&name, place, depth + 1);
                }
                let prefix = command.text("OUTPUT_PREFIX", source);
                let Some(argument) = command.argument("MODEL") else {
                    if let (Some(prefix), true) = (&prefix, self.loaded.is_some()) {
                        return self.rename_outputs(prefix, place);
                    }
                    return self.misunderstood(
                        Diagnostic::error(
                            Code::MissingArgument,
                            "FILE has neither MODEL nor COMMAND",
                        ),
                        place,
                    );
                };
                let name = argument.text(source).unwrap_or_default();
                let place = Some(Place {
                    source,
                    span: argument.value_span(),
                });
                self.model_file(&name, prefix.as_deref(), place)
            }
            "SIMULATE" => self.simulate(command, source),
            "SAVE" => self.save(command, source, place),
            "RELOAD" => self.reload(command, source, place),
            "PREFERENCES" => {
                if let Some(argument) = command.argument("SIMFAIL") {
                    self.stop_on_failure = argument.choices(source).contains(&"STOPCF");
                }
                Ok(())
            }
            "LINEAR" => self.linear(command, place),
            "CONTROL" => self.refused(
                Diagnostic::error(
                    Code::CommandNotSupported,
                    "this command is not supported and is skipped; only ADAMS itself executes it",
                ),
                place,
            ),
            "TIME" => self.print_time(),
            "INFO" => self.info(command, source),
            kind if is_output_only(Some(kind)) => self.list(command),
            _ => self.redefine(command, source),
        }
    }

    /// Reads a model, after emptying the output files with its prefix.
    fn model_file(
        &mut self,
        written: &str,
        prefix: Option<&str>,
        place: Option<Place<'_>>,
    ) -> Flow {
        self.close_model()?;
        if let Some(deck) = self.given {
            let outputs = self.outputs_for(deck.value.source().name(), None, place)?;
            return self.load(deck, outputs);
        }
        let found = find_file(written, "adm", &self.folders).value;
        if let Some(model) = &found {
            self.policy.allow_beside(model);
        }
        let outputs = self.outputs_for(written, prefix, place)?;
        let (source, _) = self.read(written, "adm", place)?;
        self.load(&Dataset::parse(source), outputs)
    }

    /// Empties the output files for a model, and opens its message file.
    pub(super) fn outputs_for(
        &mut self,
        written: &str,
        prefix: Option<&str>,
        place: Option<Place<'_>>,
    ) -> Result<Outputs, Stop> {
        if self.given.is_some() {
            let prefix = default_prefix(written);
            return Ok(Outputs::in_memory(self.directory.join(prefix)));
        }
        let prefix = self.prefix_of(written, prefix);
        let messages = with_extension(&prefix, "msg");
        let owned = self.policy.check(&messages);
        let owned = owned.and_then(|()| self.messages.own(&messages));
        let outputs = match owned.and_then(|()| Outputs::prepare(prefix, &self.policy)) {
            Ok(outputs) => outputs,
            Err(diagnostic) => {
                self.unwritable(&place.label(diagnostic))?;
                return Err(Stop::File);
            }
        };
        let path = outputs.message_file();
        if let Err(error) = self.messages.open(&path) {
            let unwritable = Diagnostic::warning(
                Code::CannotWrite,
                format!("`{}` cannot be written: {error}", path.display()),
            );
            self.complain(&unwritable);
        }
        Ok(outputs)
    }

    /// Returns the prefix of the paths of the output files: `prefix` if given, otherwise the base name of the model.
    fn prefix_of(&self, written: &str, prefix: Option<&str>) -> PathBuf {
        self.directory.join(match prefix.map(str::trim) {
            Some(prefix) if !prefix.is_empty() => native_spelling(prefix),
            _ => default_prefix(written),
        })
    }

    /// Loads the model of a dataset and reports all problems in it.
    pub(super) fn load(&mut self, deck: &Checked<Dataset>, outputs: Outputs) -> Flow {
        let loaded = Loaded::read(deck, outputs, &self.policy, &self.ignored);
        let mut errors = 0;
        if !loaded.diagnostics.is_empty() {
            self.sources.name_objects(&deck.value);
        }
        for diagnostic in &loaded.diagnostics {
            errors += usize::from(diagnostic.severity == Severity::Error);
            self.messages.diagnostic(diagnostic, &self.sources);
        }
        if errors > 0 {
            self.messages.frame(
                "ERROR",
                &match errors {
                    1 => "The model has an error and cannot be simulated.".to_string(),
                    _ => format!("The model has {errors} errors and cannot be simulated."),
                },
            );
            return Err(Stop::Model);
        }
        for apart in model::lint::apart(&loaded.value.model) {
            self.messages.apart(&apart);
        }
        for lost in model::lint::lost_torques(&deck.value, &loaded.value.model) {
            self.messages.diagnostic(&lost, &self.sources);
        }
        self.messages.title(&loaded.value.model.title);
        self.loaded = Some(loaded.value);
        Ok(())
    }

    pub(super) fn redefine(&mut self, command: &Statement, source: &Source) -> Flow {
        let Some(loaded) = &mut self.loaded else {
            return self.no_model(command, source);
        };
        let complaints = loaded.redefine(command, source);
        let errors = complaints.iter().any(|d| d.severity == Severity::Error);
        for diagnostic in &complaints {
            self.messages.diagnostic(diagnostic, &self.sources);
        }
        self.ending.misunderstood += usize::from(errors);
        if errors { Ok(()) } else { self.list(command) }
    }
}

/// Returns the base name of a model, which is the default prefix of the output files.
fn default_prefix(model: &str) -> PathBuf {
    let path = native_spelling(model);
    let is_adm = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("adm"));
    let base = if is_adm {
        path.file_stem()
    } else {
        path.file_name()
    };
    PathBuf::from(base.unwrap_or_default())
}
