//! The commands SAVE and RELOAD.

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset, Statement};

use super::ending::Stop;
use super::paths::native_spelling;
use super::run_state::{Flow, Place, Session};
use super::saved::{Kind, Saved, Written};

impl Session<'_> {
    pub(super) fn save(
        &mut self,
        command: &Statement,
        source: &Source,
        place: Option<Place<'_>>,
    ) -> Flow {
        let Some(loaded) = &self.loaded else {
            return self.no_model(command, source);
        };
        let saved = Saved::of(&loaded.model, &loaded.definitions, loaded.state());
        if let Some(name) = command.text("BUFFER", source) {
            self.kept.buffers.insert(name.into_owned(), saved.states());
            return Ok(());
        }
        let Some(name) = command.text("FILE", source) else {
            let nameless =
                Diagnostic::error(Code::MissingArgument, "SAVE has neither FILE nor BUFFER");
            return self.misunderstood(nameless, place);
        };
        if let Some(diagnostic) = with_a_comma("SAVE", &name) {
            return self.misunderstood(diagnostic, place);
        }
        let saved = if command.has("STATES") {
            saved.states()
        } else {
            saved
        };
        let path = self.directory.join(native_spelling(&name));
        let written = if loaded.outputs.is_in_memory() {
            Ok(())
        } else {
            self.policy.check(&path).and_then(|()| saved.write(&path))
        };
        self.kept.files.insert(path, saved);
        match written {
            Ok(()) => Ok(()),
            Err(diagnostic) => self.refused(diagnostic, place),
        }
    }

    pub(super) fn reload(
        &mut self,
        command: &Statement,
        source: &Source,
        place: Option<Place<'_>>,
    ) -> Flow {
        let of_states = command.has("STATES") || command.has("BUFFER");
        if self.loaded.is_none() && of_states {
            return self.no_model(command, source);
        }
        let mut saved = match self.saved(command, source) {
            Ok(saved) => saved,
            Err(diagnostic) => return self.misunderstood(diagnostic, place),
        };
        if of_states {
            // With STATES or BUFFER, only the state is reloaded; the model stays.
            saved = saved.states();
        }
        let prefix = command.text("OUTPUT_PREFIX", source);
        if let Some(prefix) = &prefix {
            self.rename_outputs(prefix, place)?;
        }
        match saved.model.take() {
            Some(Kind::Written(written)) => {
                if !self.take_in(&written, prefix, place)? {
                    return Ok(());
                }
            }
            resolved => saved.model = resolved,
        }
        let Some(loaded) = &mut self.loaded else {
            return self.no_model(command, source);
        };
        if let Err(diagnostic) = loaded.restore(saved) {
            return self.misunderstood(diagnostic, place);
        }
        if let Some(argument) = command.argument("TITLE") {
            let warning = Diagnostic::warning(
                Code::OutputNotWritten,
                "RELOAD/TITLE is ignored; output has the title of the model",
            )
            .label(source.name(), argument.span, "");
            self.complain(&warning);
        }
        Ok(())
    }

    /// Returns the saved model and state that a RELOAD command names.
    fn saved(&self, command: &Statement, source: &Source) -> Result<Saved, Diagnostic> {
        if let Some(name) = command.text("BUFFER", source) {
            return self.kept.buffers.get(&*name).cloned().ok_or_else(|| {
                Diagnostic::error(
                    Code::CannotRead,
                    format!("no SAVE of this run filled the buffer `{name}`"),
                )
            });
        }
        let Some(name) = command.text("FILE", source) else {
            return Err(Diagnostic::error(
                Code::MissingArgument,
                "RELOAD has neither FILE nor BUFFER",
            ));
        };
        if let Some(diagnostic) = with_a_comma("RELOAD", &name) {
            return Err(diagnostic);
        }
        let path = self.directory.join(native_spelling(&name));
        if let Some(saved) = self.kept.files.get(&path) {
            return Ok(saved.clone());
        }
        self.policy.check_read(&path)?;
        Saved::read(&path)
    }

    /// Replaces the model of this run, if there is one, by the model in a saved file.
    ///
    /// Returns false and changes nothing if the output files already contain results of another model.
    fn take_in(
        &mut self,
        written: &Written,
        prefix: Option<std::borrow::Cow<'_, str>>,
        place: Option<Place<'_>>,
    ) -> Result<bool, Stop> {
        let (outputs, begun) = match self.loaded.take() {
            Some(loaded) => {
                let other = loaded.definitions.dataset().source().bytes() != written.dataset;
                if other && loaded.outputs.have_begun() {
                    self.loaded = Some(loaded);
                    let other = Diagnostic::error(
                        Code::CannotRead,
                        "the file contains another model, but output files of the current model are already being written",
                    )
                    .help("OUTPUT_PREFIX gives the model in the file its own output files; RELOAD/STATES keeps the current model");
                    self.misunderstood(other, place)?;
                    return Ok(false);
                }
                (loaded.outputs, loaded.begun)
            }
            None => (
                self.outputs_for(&written.name, prefix.as_deref(), place)?,
                false,
            ),
        };
        let dataset = Source::new(written.name.clone(), written.dataset.clone());
        self.sources.add(dataset.clone());
        self.load(&Dataset::parse(dataset), outputs)?;
        let commands = [b"\n", written.commands.as_slice()].concat();
        let commands = CommandFile::parse(Source::new("commands of the saved model", commands));
        let file = &commands.value;
        self.sources.add(file.source().clone());
        for command in file.commands() {
            self.redefine(command, file.source())?;
        }
        if let Some(loaded) = &mut self.loaded {
            loaded.begun = begun;
        }
        Ok(true)
    }
}

/// Returns an error if a file name contains a comma. ADAMS allows no commas in file names; a comma means that an unknown argument was read
/// as part of the name.
fn with_a_comma(command: &str, name: &str) -> Option<Diagnostic> {
    let (_, rest) = name.split_once(',')?;
    let message = format!(
        "`{}` is not an argument of {command}, and a file name cannot contain a comma",
        rest.trim()
    );
    Some(Diagnostic::error(Code::UnknownArgument, message))
}
