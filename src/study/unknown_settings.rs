//! Tables `[[identify.unknown]]` and `[[target.unknown]]`: numbers of the deck to be determined.

use super::quantity::Quantity;
use super::section::{Section, SpannedText};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Relation between an unknown and the numbers of the deck that it sets.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum UnknownForm {
    /// A change that is added to the numbers.
    #[default]
    Change,
    /// A factor by which the numbers are multiplied. Its logarithm is fitted.
    Factor,
    /// The value of the numbers.
    Value,
}

impl UnknownForm {
    /// Returns the keyword in `study.toml`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Change => "change",
            Self::Factor => "factor",
            Self::Value => "value",
        }
    }
}

/// One table `[[identify.unknown]]` or `[[target.unknown]]`. Names are not yet resolved in the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct UnknownSettings {
    /// Position of the table in `study.toml`.
    pub span: Span,
    /// Addresses of the numbers, or patterns with `*`.
    pub numbers: Vec<SpannedText>,
    /// Relation between the unknown and the numbers.
    pub form: UnknownForm,
    /// True if one unknown sets all the numbers; otherwise each number is an unknown of its own.
    pub together: bool,
    /// Factors of the numbers, in the order of `numbers`, for an unknown that sets several numbers.
    pub factors: Option<Vec<f64>>,
    /// True if the numbers on the other side of the vehicle change as the mirror image.
    pub symmetric: bool,
    /// True if only the named marker moves on its part; false if the other markers at the same point move along with it.
    pub alone: bool,
    /// Correlation length of the change of a SPLINE along x, in the unit of x. `None` if the points change independently.
    pub smooth: Option<f64>,
    /// Initial value of the search.
    pub start: Option<Quantity>,
    /// Lower and upper bound.
    pub bounds: Option<[Quantity; 2]>,
    /// Mean of the prior.
    pub mean: Option<Quantity>,
    /// Standard deviation of the prior. In a target, a change of this size costs as much as missing a goal by its tolerance.
    pub sd: Option<Quantity>,
}

impl UnknownSettings {
    /// Reads all tables `unknown` of a section.
    pub(super) fn read_all(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Vec<Self> {
        let tables = section.tables("unknown", out);
        tables
            .into_iter()
            .filter_map(|table| Self::read(table, out))
            .collect()
    }

    fn read(mut table: Section<'_>, out: &mut Vec<Diagnostic>) -> Option<Self> {
        let forms = [UnknownForm::Change, UnknownForm::Factor, UnknownForm::Value]
            .map(|form| (form.word(), form));
        let numbers = table.texts("numbers", out);
        let span = table.span();
        if numbers.as_ref().is_none_or(Vec::is_empty) && !table.is_inquiry() {
            let message = format!("an unknown needs `{}`", table.name("numbers"));
            out.push(
                Diagnostic::error(Code::MissingSetting, message)
                    .label(table.file(), span, "")
                    .help(
                        "list the numbers of the deck to identify, for example numbers = [\"MARKER/7.QP\"]",
                    ),
            );
        }
        let found = Self {
            span,
            numbers: numbers.unwrap_or_default(),
            form: table.choice("form", UnknownForm::Change, &forms, out),
            together: table.flag("together", out),
            factors: table.numbers("factors", out),
            symmetric: table.flag("symmetric", out),
            alone: table.flag("alone", out),
            smooth: table.optional_number("smooth", f64::MIN_POSITIVE..=f64::INFINITY, out),
            start: table.quantity("start", out),
            bounds: table.bounds("bounds", out),
            mean: table.quantity("mean", out),
            sd: table.quantity("sd", out),
        };
        if let Some(sd) = found.sd.as_ref().filter(|sd| sd.value <= 0.0) {
            table.wrong("sd", sd.spelled.span, "more than 0", out);
        }
        table.finish(out);
        (!found.numbers.is_empty()).then_some(found)
    }
}
