use std::sync::Arc;

use super::ids::Ids;
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::StatementDef;
use crate::mechanics::Vec3;
use crate::model::{Function, Header, Joint, MarkerIx, PartIx};
use crate::syntax::{Argument, Dataset, Statement, Value};
use crate::text::{Source, Span};

/// One statement as typed values. Every method takes the object's old value, if there is one: a statement of a dataset starts
/// from the grammar's defaults, a command of a command file from what the model holds.
pub(super) struct Reader<'a> {
    pub source: &'a Source,
    pub statement: &'a Statement,
    pub def: &'static StatementDef,
    pub ids: &'a Ids<'a>,
    /// The joints of the model, already lowered.
    pub joints: &'a [Joint],
    pub diagnostics: &'a mut Vec<Diagnostic>,
    /// Index of the statement in its dataset.
    pub origin: usize,
    /// The dataset, which gives new objects their names; a command makes none.
    pub dataset: Option<&'a Dataset>,
}

impl<'a> Reader<'a> {
    /// Reads the statement of a dataset that stands at `origin` among its statements.
    pub fn of_dataset(
        dataset: &'a Dataset,
        origin: usize,
        def: &'static StatementDef,
        ids: &'a Ids<'a>,
        joints: &'a [Joint],
        diagnostics: &'a mut Vec<Diagnostic>,
    ) -> Self {
        Self {
            source: dataset.source(),
            statement: &dataset.statements()[origin],
            def,
            ids,
            joints,
            diagnostics,
            origin,
            dataset: Some(dataset),
        }
    }
}

impl Reader<'_> {
    /// The header of a new object, or the old one.
    pub fn header(&self, old: Option<&Header>) -> Header {
        old.cloned().unwrap_or_else(|| Header {
            id: self.statement.number().unwrap_or(0),
            name: self
                .dataset
                .map(|dataset| dataset.name(self.statement).into_owned())
                .unwrap_or_default(),
            origin: self.origin,
            active: true,
        })
    }

    /// The argument as written, if it is there.
    pub fn given(&self, name: &str) -> Option<&Argument> {
        self.statement.argument(name)
    }

    /// True if any of the arguments is there.
    pub fn any(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.statement.has(name))
    }

    pub fn flag(&self, name: &str, old: bool) -> bool {
        old || self.statement.has(name)
    }

    /// Default values of an argument as the grammar states them.
    fn default(&self, name: &str) -> &'static [f64] {
        self.def
            .arguments
            .iter()
            .find(|argument| argument.name == name)
            .map_or(&[], |argument| argument.default)
    }

    pub fn real(&self, name: &str, old: Option<f64>) -> f64 {
        self.statement
            .first(name)
            .or(old)
            .or_else(|| self.default(name).first().copied())
            .unwrap_or(0.0)
    }

    /// The first `N` numbers; those that are not written keep their old value.
    pub fn array<const N: usize>(&self, name: &str, old: Option<[f64; N]>) -> [f64; N] {
        let mut values = old.unwrap_or_else(|| {
            let mut values = [0.0; N];
            for (value, default) in values.iter_mut().zip(self.default(name)) {
                *value = *default;
            }
            values
        });
        for (value, number) in values.iter_mut().zip(self.statement.numbers(name)) {
            *value = number.value;
        }
        values
    }

    /// So many numbers; those that are not written keep their old value.
    pub fn numbers(&self, name: &str, count: usize, old: Option<&[f64]>) -> Vec<f64> {
        let written = self.statement.numbers(name);
        let before = old.unwrap_or_else(|| self.default(name));
        (0..count)
            .map(|k| {
                let written = written.get(k).map(|number| number.value);
                written.or(before.get(k).copied()).unwrap_or(0.0)
            })
            .collect()
    }

    pub fn vector(&self, name: &str, old: Option<Vec3>) -> Vec3 {
        Vec3::from(self.array(name, old.map(Into::into)))
    }

    /// A point that has no default.
    pub fn point(&self, name: &str) -> Option<Vec3> {
        self.statement.has(name).then(|| self.vector(name, None))
    }

    pub fn reals(&self, name: &str) -> Option<Vec<f64>> {
        let numbers = self.given(name)?.numbers();
        Some(numbers.iter().map(|number| number.value).collect())
    }

    /// Ids as written; numbers that are no ids are left out (the grammar rules complain about them).
    pub fn written_ids(&self, name: &str) -> Option<Vec<u32>> {
        let numbers = self.given(name)?.numbers();
        Some(numbers.iter().filter_map(|n| as_id(n.value)).collect())
    }

    pub fn written_id(&self, name: &str, old: Option<u32>) -> Option<u32> {
        self.statement.first(name).and_then(as_id).or(old)
    }

    /// The marker an argument names.
    pub fn marker(&self, name: &str, old: Option<MarkerIx>) -> Option<MarkerIx> {
        match self.given(name) {
            Some(argument) => {
                let id = as_id(argument.numbers().first()?.value)?;
                self.ids.marker(id)
            }
            None => old,
        }
    }

    /// The markers an argument names.
    pub fn markers(&self, name: &str) -> Option<Vec<MarkerIx>> {
        self.written_ids(name)?
            .into_iter()
            .map(|id| self.ids.marker(id))
            .collect()
    }

    /// The body an argument names: `space` is the id space of the argument.
    pub fn part(&self, name: &str, space: &'static str) -> Option<PartIx> {
        self.ids
            .index(space, self.written_id(name, None)?)
            .map(PartIx)
    }

    /// The joint with this id, and where it stands in the model's list.
    pub fn joint(&self, id: u32) -> Option<(usize, &Joint)> {
        let at = self.ids.joint(id)?;
        Some((at, self.joints.get(at)?))
    }

    /// The values of a MATRIX, row by row. Complains if they are not in the dataset.
    pub fn matrix(&mut self, name: &str, id: u32) -> Option<Vec<Vec<f64>>> {
        let statement = self.ids.statement("MATRIX", id)?;
        let rows = statement.first("ROWS").unwrap_or(0.0) as usize;
        let columns = statement.first("COLUMNS").unwrap_or(0.0) as usize;
        let values = statement.numbers("VALUES");
        let by_columns = statement
            .argument("FULL")
            .is_some_and(|full| full.choices(self.source).contains(&"CORDER"));
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

    pub fn function(&self, name: &str, old: Option<&Function>) -> Option<Function> {
        let Some(argument) = self.given(name) else {
            return old.cloned();
        };
        match &argument.value {
            Value::Function(expression) => Some(Function::Expression(Arc::clone(expression))),
            Value::User(_) => Some(Function::User(
                argument.text(self.source).unwrap_or_default().into_owned(),
            )),
            _ => None,
        }
    }

    pub fn text(&self, name: &str, old: Option<String>) -> Option<String> {
        self.statement
            .text(name, self.source)
            .map(std::borrow::Cow::into_owned)
            .or(old)
    }

    pub fn texts(&self, name: &str) -> Option<Vec<String>> {
        let texts = self.given(name)?.texts(self.source);
        Some(
            texts
                .into_iter()
                .map(std::borrow::Cow::into_owned)
                .collect(),
        )
    }

    /// The choice words of an argument, whole and in capitals.
    pub fn choices(&self, name: &str) -> Option<Vec<&'static str>> {
        self.given(name)
            .map(|argument| argument.choices(self.source))
    }

    pub fn choice(&self, name: &str) -> Option<&'static str> {
        self.choices(name)?.first().copied()
    }

    /// The first of the flags that is written.
    pub fn first_flag<T: Copy>(&self, flags: &[(&str, T)]) -> Option<T> {
        flags
            .iter()
            .find(|(name, _)| self.statement.has(name))
            .map(|(_, value)| *value)
    }

    /// How the statement is called in messages: `BUSHING/3`.
    pub fn called(&self) -> String {
        match self.statement.number() {
            Some(id) => format!("{}/{id}", self.def.name),
            None => self.def.name.to_string(),
        }
    }

    pub fn complain(&mut self, diagnostic: Diagnostic, span: Span) {
        self.diagnostics
            .push(diagnostic.label(self.source.name(), span, ""));
    }

    /// Where an argument's value stands; the keyword of the statement if it is not written.
    pub fn place(&self, name: &str) -> Span {
        self.given(name)
            .map_or(self.statement.keyword, Argument::value_span)
    }

    /// Complains that an argument is needed and gives `None`.
    pub fn missing<T>(&mut self, needed: &str) -> Option<T> {
        let diagnostic = Diagnostic::error(
            Code::MissingArgument,
            format!("{} needs {needed}", self.called()),
        );
        self.complain(diagnostic, self.statement.keyword);
        None
    }
}

/// A sparse matrix that would fill the memory is not made.
const MOST_VALUES: usize = 1_000_000;

/// A number as an id, if it is one.
pub(super) fn as_id(value: f64) -> Option<u32> {
    (value > 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}
