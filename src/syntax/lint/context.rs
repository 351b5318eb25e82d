use std::cell::OnceCell;
use std::collections::HashMap;

use super::options::Options;
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::ValueKind;
use crate::text::Span;
use crate::{Argument, Dataset, Fault, Reference, Statement};

/// Common input of the lint rules: the dataset, the options, and lookup of statements by id space and id.
pub(super) struct Context<'a> {
    pub dataset: &'a Dataset,
    pub options: &'a Options,
    by_id: HashMap<(&'static str, u32), &'a Statement>,
    /// Body of each marker that names no body itself; the key is the id of the marker.
    before: HashMap<u32, (&'static str, u32)>,
    faults: OnceCell<Vec<Fault<'a>>>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(dataset: &'a Dataset, options: &'a Options) -> Self {
        let mut by_id = HashMap::new();
        let (mut before, mut body) = (HashMap::new(), None);
        for statement in dataset.statements() {
            let space = statement.def.and_then(|def| def.id);
            if let (Some(space), Some(id)) = (space, statement.number()) {
                by_id.entry((space, id)).or_insert(statement);
                if statement.carries_markers() {
                    body = Some((space, id));
                } else if let Some(body) = body.filter(|_| statement.follows_body()) {
                    before.entry(id).or_insert(body);
                }
            }
        }
        Self {
            dataset,
            options,
            by_id,
            before,
            faults: OnceCell::new(),
        }
    }

    pub(crate) fn statements(&self) -> &'a [Statement] {
        self.dataset.statements()
    }

    /// Iterates over the statements of one kind (full keyword in capitals).
    pub(crate) fn of_kind(&self, kind: &'static str) -> impl Iterator<Item = &'a Statement> {
        self.statements()
            .iter()
            .filter(move |statement| statement.kind() == Some(kind))
    }

    /// Returns the first statement that defines this id in this id space.
    pub(crate) fn find(&self, space: &'static str, id: u32) -> Option<&'a Statement> {
        self.by_id.get(&(space, id)).copied()
    }

    /// Returns the marker that an argument refers to, if it exists.
    pub(crate) fn marker(&self, statement: &Statement, argument: &str) -> Option<&'a Statement> {
        let number = statement.numbers(argument).first()?;
        self.find("marker", number.as_id()?)
    }

    /// Returns the body that carries a marker, as id space and id.
    pub(crate) fn body(&self, marker: &Statement) -> Option<(&'static str, u32)> {
        if marker.follows_body() {
            return self.before.get(&marker.number()?).copied();
        }
        ["PART", "POINT_MASS", "FLEX_BODY", "FE_PART"]
            .iter()
            .find_map(|owner| {
                let argument = marker.argument(owner)?;
                let Some(ValueKind::Reference(space)) = argument.def.map(|def| def.kind) else {
                    return None;
                };
                Some((space, argument.numbers().first()?.as_id()?))
            })
    }

    /// Returns all references of a statement to other objects, including references inside functions. An id of zero means ground or no
    /// object and is left out.
    pub(crate) fn references(statement: &Statement) -> Vec<Reference> {
        statement
            .arguments
            .iter()
            .flat_map(Argument::references)
            .collect()
    }

    /// Returns the name of a statement as used in messages.
    pub(crate) fn title(&self, statement: &Statement) -> String {
        statement.title(self.dataset.source())
    }

    /// Returns the faults of all statements with respect to the grammar; findings of lint rules are not included.
    pub(crate) fn faults(&self) -> &[Fault<'a>] {
        self.faults.get_or_init(|| {
            let mut faults = Vec::new();
            for statement in self.statements() {
                let defines = |space, id| self.find(space, id).is_some();
                statement.faults(defines, |fault| faults.push(fault));
            }
            faults
        })
    }

    /// Creates a diagnostic at a span of the dataset.
    pub(crate) fn complain(
        &self,
        severity: Severity,
        code: Code,
        span: Span,
        message: String,
    ) -> Diagnostic {
        let diagnostic = match severity {
            Severity::Error => Diagnostic::error(code, message),
            Severity::Warning => Diagnostic::warning(code, message),
            Severity::Note => Diagnostic::note(code, message),
        };
        diagnostic.label(self.dataset.source().name(), span, "")
    }

    pub(crate) fn error(&self, code: Code, span: Span, message: String) -> Diagnostic {
        self.complain(Severity::Error, code, span, message)
    }

    pub(crate) fn warning(&self, code: Code, span: Span, message: String) -> Diagnostic {
        self.complain(Severity::Warning, code, span, message)
    }

    pub(crate) fn note(&self, code: Code, span: Span, message: String) -> Diagnostic {
        self.complain(Severity::Note, code, span, message)
    }
}

/// Iterates over the arguments of a statement that are in the grammar, with their definitions.
pub(super) fn known(
    statement: &Statement,
) -> impl Iterator<Item = (&Argument, &'static crate::grammar::ArgumentDef)> {
    statement
        .arguments
        .iter()
        .filter_map(|argument| Some((argument, argument.def?)))
}
