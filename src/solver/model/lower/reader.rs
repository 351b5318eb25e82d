use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use super::ids::Ids;
use crate::mechanics::Vec3;
use crate::model::{Function, Header, Joint, MarkerIx, PartIx};
use admire_syntax::car_field::CarField;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::StatementDef;
use admire_syntax::text::{Source, Span};
use admire_syntax::{Dataset, Number, Overlay, Stated, Value, as_id};

/// Current forms of redefined statements, with the commands overlaid on them, by keyword and id.
pub(super) type Overlays = BTreeMap<(&'static str, Option<u32>), Overlay>;

/// Access to the current statements of a dataset and to the model indices of the objects they define.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub dataset: &'a Dataset,
    pub over: &'a Overlays,
    pub ids: &'a Ids,
    /// Joints of the model, already lowered.
    pub joints: &'a [Joint],
}

impl<'a> Context<'a> {
    /// Returns the current form of a statement, with all commands overlaid.
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

/// Reader that returns the arguments of one statement as typed values. For absent arguments, it returns the defaults of the grammar.
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
    /// Creates a reader of the statement at index `origin` of its dataset.
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

    /// Returns the header of the object that the statement defines.
    pub(crate) fn header(&self) -> Header {
        let statement = &self.context.dataset.statements()[self.origin];
        Header {
            id: self.number().unwrap_or(0),
            name: self.context.dataset.name(statement).into_owned(),
            origin: self.origin,
            active: true,
        }
    }

    /// Returns the default values of an argument from the grammar.
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

    /// Returns the first `N` numbers of an argument. Absent numbers are replaced by their defaults.
    pub(crate) fn array<const N: usize>(&self, name: &str) -> [f64; N] {
        std::array::from_fn(self.row(name))
    }

    /// Returns a function that maps an index to the number of an argument, or to its default if the number is absent.
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

    /// Returns the point that an argument gives, or `None` if the argument is absent. Arguments that give points have no default.
    pub(crate) fn point(&self, name: &str) -> Option<Vec3> {
        self.has(name).then(|| self.vector(name))
    }

    pub(crate) fn reals(&self, name: &str) -> Option<Vec<f64>> {
        let numbers = self.argument(name)?.numbers();
        Some(numbers.iter().map(|number| number.value).collect())
    }

    /// Returns the ids that an argument lists. Numbers that are not ids are omitted; the grammar rules report them.
    pub(crate) fn written_ids(&self, name: &str) -> Option<Vec<u32>> {
        let numbers = self.argument(name)?.numbers();
        Some(numbers.iter().filter_map(Number::as_id).collect())
    }

    pub(crate) fn written_id(&self, name: &str) -> Option<u32> {
        self.first(name).and_then(as_id)
    }

    /// Returns the marker that an argument names.
    pub(crate) fn marker(&self, name: &str) -> Option<MarkerIx> {
        self.context.ids.marker(self.written_id(name)?)
    }

    /// Returns the markers that an argument names.
    pub(crate) fn markers(&self, name: &str) -> Option<Vec<MarkerIx>> {
        self.written_ids(name)?
            .into_iter()
            .map(|id| self.context.ids.marker(id))
            .collect()
    }

    /// Returns the body that an argument names. `space` is the id space of that body.
    pub(crate) fn part(&self, name: &str, space: &'static str) -> Option<PartIx> {
        let id = self.written_id(name)?;
        self.context.ids.index(space, id).map(PartIx)
    }

    /// Returns the joint with this id and its index in the model's list.
    pub(crate) fn joint(&self, id: u32) -> Option<(usize, &Joint)> {
        let at = self.context.ids.joint(id)?;
        Some((at, self.context.joints.get(at)?))
    }

    /// Returns the entries of a MATRIX, row by row. Reports a MATRIX whose values are not in the dataset.
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
            // This fault is reported at the MATRIX itself.
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

    /// Reads a FIELD that calls a user subroutine, and interprets it as a bushing of Adams/Car. Returns `None` for other statements, and for a
    /// FIELD whose parameters name no curve or array of a bushing. The error is the reason why these objects are unsuitable.
    pub(crate) fn car_field(&self) -> Option<Result<CarField, String>> {
        if self.def.name != "FIELD" || !self.is_user("FUNCTION") {
            return None;
        }
        let dataset = self.context.dataset;
        let field = &dataset.statements()[self.origin];
        let user = self.text("FUNCTION")?;
        CarField::read(dataset, field, &user, |kind, id| {
            self.context.stated(kind, id)
        })
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

    /// Returns the value paired with the first flag of the list that the statement contains.
    pub(crate) fn first_flag<T: Copy>(&self, flags: &[(&str, T)]) -> Option<T> {
        flags
            .iter()
            .find(|(name, _)| self.has(name))
            .map(|(_, value)| *value)
    }

    /// Returns the name of the statement for messages: `BUSHING/3`.
    pub(crate) fn called(&self) -> String {
        match self.number() {
            Some(id) => format!("{}/{id}", self.def.name),
            None => self.def.name.to_string(),
        }
    }

    pub(crate) fn complain(&mut self, diagnostic: Diagnostic, source: &Source, span: Span) {
        self.diagnostics
            .push(diagnostic.label(source.name(), span, ""));
    }

    /// Reports that the statement lacks a required argument, and returns `None`.
    pub(crate) fn missing<T>(&mut self, needed: &str) -> Option<T> {
        let diagnostic = Diagnostic::error(
            Code::MissingArgument,
            format!("{} needs {needed}", self.called()),
        );
        let (source, span) = self.keyword();
        self.complain(diagnostic, source, span);
        None
    }
}

/// Maximum size (rows times columns) of a SPARSE matrix that is expanded to a full matrix. It limits the memory used.
const MOST_VALUES: usize = 1_000_000;
