//! SAVE and RELOAD.

use crate::diagnostic::{Code, Diagnostic};
use crate::syntax::Statement;
use crate::text::Source;

use super::paths::native_spelling;
use super::run_state::{Flow, Place, Session};
use super::saved::Saved;

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
                Diagnostic::error(Code::MissingArgument, "SAVE names no FILE and no BUFFER");
            return self.misunderstood(nameless, place);
        };
        if let Some(diagnostic) = with_a_comma("SAVE", &name) {
            return self.misunderstood(diagnostic, place);
        }
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
        let Some(loaded) = &mut self.loaded else {
            return self.no_model(command, source);
        };
        let restored = if let Some(name) = command.text("BUFFER", source) {
            self.kept.buffers.get(&*name).cloned().ok_or_else(|| {
                Diagnostic::error(
                    Code::CannotRead,
                    format!("no SAVE of this run filled the buffer `{name}`"),
                )
            })
        } else if let Some(name) = command.text("FILE", source) {
            let path = self.directory.join(native_spelling(&name));
            match (with_a_comma("RELOAD", &name), self.kept.files.get(&path)) {
                (Some(diagnostic), _) => Err(diagnostic),
                (None, Some(saved)) => Ok(saved.clone()),
                (None, None) => self
                    .policy
                    .check_read(&path)
                    .and_then(|()| Saved::read(&path, &loaded.model)),
            }
        } else {
            Err(Diagnostic::error(
                Code::MissingArgument,
                "RELOAD names no FILE and no BUFFER",
            ))
        };
        let restored = restored.and_then(|saved| {
            // STATES leaves the model as it is now.
            let states = command.has("STATES");
            loaded.restore(if states { saved.states() } else { saved })
        });
        if let Err(diagnostic) = restored {
            return self.misunderstood(diagnostic, place);
        }
        for name in ["OUTPUT_PREFIX", "TITLE"] {
            if let Some(argument) = command.argument(name) {
                let warning = Diagnostic::warning(
                    Code::OutputNotWritten,
                    format!("RELOAD/{name} is not followed; output goes on in the files of the model under its title"),
                )
                .label(source.name(), argument.span, "");
                self.complain(&warning);
            }
        }
        Ok(())
    }
}

/// What stands behind the name of a file and is no argument belongs to the name as it is read; the names of ADAMS have no commas.
fn with_a_comma(command: &str, name: &str) -> Option<Diagnostic> {
    let (_, rest) = name.split_once(',')?;
    let message = format!(
        "the name of a file has no comma, and `{}` is no argument of {command}",
        rest.trim()
    );
    Some(Diagnostic::error(Code::UnknownArgument, message))
}
