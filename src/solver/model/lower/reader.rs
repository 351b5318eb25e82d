use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use super::ids::Ids;
use crate::mechanics::Vec3;
use crate::model::{Function, Header, Joint, MarkerIx, PartIx};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::StatementDef;
use admire_syntax::text::{Source, Span};
use admire_syntax::{Dataset, Number, Overlay, Stated, Value, as_id};

/// Statements that others were put over, by keyword and id.
pub(super) type Overlays = BTreeMap<(&'static str, Option<u32>), Overlay>;

/// The statements of a dataset as they stand, and where what they define is in the model.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub dataset: &'a Dataset,
    pub over: &'a Overlays,
    pub ids: &'a Ids,
    /// The joints of the model, already lowered.
    pub joints: &'a [Joint],
}

impl<'a> Context<'a> {
    /// A statement as it stands.
    pub(crate) fn stated(&self, kind: &'static str, id: u32) -> Option<Stated<'a>> {
        match self.over.get(&(kind, Some(id))) {
            Some(overlay) => Some(overlay.stated()),
            None => Some(Stated::plain(
                self.dataset.statement(kind, Some(id))?,
                self.dataset.source(),
            )),
        }
    }
}

/// One statement as typed values: those it states, and the defaults of the grammar.
pub(super) struct Reader<'a> {
    context: Context<'a>,
    stated: Stated<'a>,
    pub def: &'static StatementDef,
    pub diagnostics: &'a mut Vec<Diagnostic>,
    /// Index of the statement in its dataset.
    origin: usize,
}

impl<'a> Deref for Reader<'a> {
    type Target = Stated<'a>;

    fn deref(&self) -> &Stated<'a> {
        &self.stated
    }
}

impl<'a> Reader<'a> {
    /// Reads a statement that stands at `origin` in its dataset.
    pub(crate) fn new(
        context: Context<'a>,
        stated: Stated<'a>,
        def: &'static StatementDef,
        origin: usize,
        diagnostics: &'a mut Vec<Diagnostic>,
    ) -> Self {
        Self {
            context,
            stated,
            def,
            diagnostics,
            origin,
        }
    }

    /// The header of the object.
    pub(crate) fn header(&self) -> Header {
        let statement = &self.context.dataset.statements()[self.origin];
        Header {
            id: self.number().unwrap_or(0),
            name: self.context.dataset.name(statement).into_owned(),
            origin: self.origin,
            active: true,
        }
    }

    /// Default values of an argument as the grammar states them.
    fn default(&self, name: &str) -> &'static [f64] {
        self.def
            .arguments
            .iter()
            .find(|argument| argument.name == name)
            .map_or(&[], |argument| argument.default)
    }

    pub(crate) fn real(&self, name: &str) -> f64 {
        self.first(name)
            .or_else(|| self.default(name).first().copied())
            .unwrap_or(0.0)
    }

    /// The first `N` numbers.
    pub(crate) fn array<const N: usize>(&self, name: &str) -> [f64; N] {
        std::array::from_fn(self.row(name))
    }

    /// The numbers of an argument by their places, and the defaults behind them.
    pub(crate) fn row(&self, name: &str) -> impl Fn(usize) -> f64 + use<'a> {
        let (stated, default) = (self.numbers(name), self.default(name));
        move |k| {
            let stated = stated.get(k).map(|number| number.value);
            stated.or(default.get(k).copied()).unwrap_or(0.0)
        }
    }

    pub(crate) fn vector(&self, name: &str) -> Vec3 {
        Vec3::from(self.array(name))
    }

    /// A point that has no default.
    pub(crate) fn point(&self, name: &str) -> Option<Vec3> {
        self.has(name).then(|| self.vector(name))
    }

    pub(crate) fn reals(&self, name: &str) -> Option<Vec<f64>> {
        let numbers = self.argument(name)?.numbers();
        Some(numbers.iter().map(|number| number.value).collect())
    }

    /// Ids as written; numbers that are no ids are left out (the grammar rules complain about them).
    pub(crate) fn written_ids(&self, name: &str) -> Option<Vec<u32>> {
        let numbers = self.argument(name)?.numbers();
        Some(numbers.iter().filter_map(Number::as_id).collect())
    }

    pub(crate) fn written_id(&self, name: &str) -> Option<u32> {
        self.first(name).and_then(as_id)
    }

    /// The marker an argument names.
    pub(crate) fn marker(&self, name: &str) -> Option<MarkerIx> {
        self.context.ids.marker(self.written_id(name)?)
    }

    /// The markers an argument names.
    pub(crate) fn markers(&self, name: &str) -> Option<Vec<MarkerIx>> {
        self.written_ids(name)?
            .into_iter()
            .map(|id| self.context.ids.marker(id))
            .collect()
    }

    /// The body an argument names: `space` is the id space of the argument.
    pub(crate) fn part(&self, name: &str, space: &'static str) -> Option<PartIx> {
        let id = self.written_id(name)?;
        self.context.ids.index(space, id).map(PartIx)
    }

    /// The joint with this id, and where it stands in the model's list.
    pub(crate) fn joint(&self, id: u32) -> Option<(usize, &Joint)> {
        let at = self.context.ids.joint(id)?;
        Some((at, self.context.joints.get(at)?))
    }

    /// The values of a MATRIX, row by row. Complains if they are not in the dataset.
    pub(crate) fn matrix(&mut self, name: &str, id: u32) -> Option<Vec<Vec<f64>>> {
        let statement = self.context.stated("MATRIX", id)?;
        let rows = statement.first("ROWS").unwrap_or(0.0) as usize;
        let columns = statement.first("COLUMNS").unwrap_or(0.0) as usize;
        let values = statement.numbers("VALUES");
        let by_columns = statement
            .choices("FULL")
            .is_some_and(|full| full.contains(&"CORDER"));
        let size = rows.max(1).checked_mul(columns.max(1));
        if statement.has("SPARSE") && size.is_some_and(|size| size <= MOST_VALUES) {
            let mut matrix = vec![vec![0.0; columns]; rows];
            let places = statement.numbers("I").iter().zip(statement.numbers("J"));
            for ((row, column), entry) in places.zip(values) {
                let (row, column) = (row.value as usize, column.value as usize);
                if (1..=rows).contains(&row) && (1..=columns).contains(&column) {
                    matrix[row - 1][column - 1] = entry.value;
                }
            }
            return Some(matrix);
        }
        if !values.is_empty() && rows.checked_mul(columns) != Some(values.len()) {
            // The matrix itself is complained about.
            return None;
        }
        if values.is_empty() {
            return self.missing(&format!(
                "{name} as a MATRIX with all its VALUES in the dataset"
            ));
        }
        let at = |row: usize, column: usize| {
            let k = if by_columns {
                column * rows + row
            } else {
                row * columns + column
            };
            values[k].value
        };
        Some(
            (0..rows)
                .map(|row| (0..columns).map(|column| at(row, column)).collect())
                .collect(),
        )
    }

    pub(crate) fn function(&self, name: &str) -> Option<Function> {
        match &self.argument(name)?.value {
            Value::Function(expression) => Some(Function::Expression(Arc::clone(expression))),
            Value::User(_) => Some(Function::User(self.text(name).unwrap_or_default())),
            _ => None,
        }
    }

    pub(crate) fn text(&self, name: &str) -> Option<String> {
        self.stated.text(name).map(Cow::into_owned)
    }

    pub(crate) fn texts(&self, name: &str) -> Option<Vec<String>> {
        let texts = self.stated.texts(name)?;
        Some(texts.into_iter().map(Cow::into_owned).collect())
    }

    pub(crate) fn choice(&self, name: &str) -> Option<&'static str> {
        self.choices(name)?.first().copied()
    }

    /// The first of the flags that is written.
    pub(crate) fn first_flag<T: Copy>(&self, flags: &[(&str, T)]) -> Option<T> {
        flags
            .iter()
            .find(|(name, _)| self.has(name))
            .map(|(_, value)| *value)
    }

    /// How the statement is called in messages: `BUSHING/3`.
    pub(crate) fn called(&self) -> String {
        match self.number() {
            Some(id) => format!("{}/{id}", self.def.name),
            None => self.def.name.to_string(),
        }
    }

    pub(crate) fn complain(&mut self, diagnostic: Diagnostic, (source, span): (&Source, Span)) {
        self.diagnostics
            .push(diagnostic.label(source.name(), span, ""));
    }

    /// Complains that an argument is needed and gives `None`.
    pub(crate) fn missing<T>(&mut self, needed: &str) -> Option<T> {
        let diagnostic = Diagnostic::error(
            Code::MissingArgument,
            format!("{} needs {needed}", self.called()),
        );
        self.complain(diagnostic, self.keyword());
        None
    }
}

/// A sparse matrix that would fill the memory is not made.
const MOST_VALUES: usize = 1_000_000;
