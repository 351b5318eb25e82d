use std::cell::OnceCell;
use std::collections::HashMap;

use super::options::Options;
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::ValueKind;
use crate::text::Span;
use crate::{Argument, Dataset, Fault, Reference, Statement};

/// What the rules look at: the dataset, its statements by id space and id, and every reference.
pub(super) struct Context<'a> {
    pub dataset: &'a Dataset,
    pub options: &'a Options,
    by_id: HashMap<(&'static str, u32), &'a Statement>,
    /// The bodies of markers that name none, by the ids of the markers.
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

    /// The statements of one kind (whole keyword in capitals).
    pub(crate) fn of_kind(&self, kind: &'static str) -> impl Iterator<Item = &'a Statement> {
        self.statements()
            .iter()
            .filter(move |statement| statement.kind() == Some(kind))
    }

    /// The statement that defines an id of a space.
    pub(crate) fn find(&self, space: &'static str, id: u32) -> Option<&'a Statement> {
        self.by_id.get(&(space, id)).copied()
    }

    /// The marker an argument names, if it names one that exists.
    pub(crate) fn marker(&self, statement: &Statement, argument: &str) -> Option<&'a Statement> {
        let number = statement.numbers(argument).first()?;
        self.find("marker", number.as_id()?)
    }

    /// The body a marker is on: id space and id.
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

    /// Every reference of a statement, those in functions included. Zeros stand for ground or for nothing and are left out.
    pub(crate) fn references(statement: &Statement) -> Vec<Reference> {
        statement
            .arguments
            .iter()
            .flat_map(Argument::references)
            .collect()
    }

    /// How a statement is called in a message.
    pub(crate) fn title(&self, statement: &Statement) -> String {
        statement.title(self.dataset.source())
    }

    /// What is wrong with the statements by the grammar alone.
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

    /// A complaint about a place.
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

/// Arguments the grammar knows, with their definitions.
pub(super) fn known(
    statement: &Statement,
) -> impl Iterator<Item = (&Argument, &'static crate::grammar::ArgumentDef)> {
    statement
        .arguments
        .iter()
        .filter_map(|argument| Some((argument, argument.def?)))
}
