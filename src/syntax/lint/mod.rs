//! Lint: what is wrong with a dataset that reads well, as data.
//!
//! One rule, one file; each rule is one line of [`RULES`], and its documentation is that of its code
//! (`admire explain CODE`). Rules see statements, not a model: what needs places and directions is in `model::lint`. What the
//! reader itself complains of (unknown keywords, values that cannot be read, a missing END) is not repeated here.

mod arguments;
mod context;
mod count;
mod derivative;
mod duplicate_id;
mod floating;
mod ground;
mod inertia;
mod kt_per_degree;
mod line_length;
mod mass_without_cm;
mod massless;
mod material;
mod motion;
mod native;
mod one_part;
mod presence;
mod range;
mod sequence;
mod spline;
mod step;
mod suppressed;
mod symmetry;
mod tabs;
mod undefined_id;
mod unit_dimension;
mod unreferenced;
mod value_type;

use super::{CommandFile, Dataset};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::Span;
use context::Context;

pub use suppressed::Suppressed;

/// What is looked for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Options {
    /// The deck is for the FORTRAN solver: lines have at most 80 columns.
    pub fortran: bool,
}

/// One rule: the code it reports and the function that looks for it.
pub struct Rule {
    /// The code of its complaints; its documentation is the rule's.
    pub code: Code,
    check: fn(&Context<'_>, &mut Vec<Diagnostic>),
}

/// Every rule there is.
pub static RULES: &[Rule] = &[
    rule(Code::UndefinedId, undefined_id::check),
    rule(Code::DuplicateId, duplicate_id::check),
    rule(Code::WrongCount, count::check),
    rule(Code::WrongType, value_type::check),
    rule(Code::OutOfRange, range::check),
    rule(Code::WrongDimension, unit_dimension::check),
    rule(Code::MissingArgument, presence::missing),
    rule(Code::ConflictingArguments, presence::conflicting),
    rule(Code::RepeatedArgument, arguments::check),
    rule(Code::MarkersOnOnePart, one_part::check),
    rule(Code::FloatingMarker, floating::check),
    rule(Code::NoGround, ground::check),
    rule(Code::MassWithoutCm, mass_without_cm::check),
    rule(Code::ImpossibleInertia, inertia::check),
    rule(Code::FreeWithoutMass, massless::check),
    rule(Code::UndefinedId, material::check),
    rule(Code::WrongMotion, motion::check),
    rule(Code::UnsymmetricStiffness, symmetry::check),
    rule(Code::StepWithoutWidth, step::check),
    rule(Code::KtPerDegree, kt_per_degree::check),
    rule(Code::SplineNotIncreasing, spline::check),
    rule(Code::NoDerivative, derivative::check),
    rule(Code::Unreferenced, unreferenced::check),
    rule(Code::NotSolvedNatively, native::check),
    rule(Code::Tab, tabs::check),
    rule(Code::LineTooLong, line_length::check),
];

const fn rule(code: Code, check: fn(&Context<'_>, &mut Vec<Diagnostic>)) -> Rule {
    Rule { code, check }
}

/// More complaints of one rule than anybody reads are counted, not kept.
const MOST_OF_A_RULE: usize = 10_000;

/// The first complaints of a rule, the last one saying how many more there are and as bad as the worst of them.
fn shortened(mut own: Vec<Diagnostic>, code: Code) -> Vec<Diagnostic> {
    let rest = own.split_off(MOST_OF_A_RULE);
    let worst = rest.iter().map(|d| d.severity).max();
    if let Some(last) = own.last_mut() {
        last.message = format!(
            "{} more complaints of {code} are not listed",
            rest.len() + 1
        );
        last.severity = last.severity.max(worst.unwrap_or(last.severity));
        last.fix = None;
    }
    own
}

/// Rules that hold for a statement by itself: for commands, too, which give only what they change.
const OF_COMMANDS: [Code; 7] = [
    Code::WrongCount,
    Code::WrongType,
    Code::OutOfRange,
    Code::WrongDimension,
    Code::ConflictingArguments,
    Code::RepeatedArgument,
    Code::StepWithoutWidth,
];

/// Runs the rules that need no dataset over the commands of a file. Complaints are in the order of their places in the file.
pub fn check_commands(file: &CommandFile) -> Vec<Diagnostic> {
    let commands = Dataset::of_commands(file);
    run(&commands, &Options::default(), |rule| {
        OF_COMMANDS.contains(&rule.code)
    })
}

/// Looks at the commands of a file in their order, against the decks they are run on: objects that are not there, and times
/// that cannot be. `deck_of` gives the deck behind the name of a model at a place of the file, or `None` where it could not be
/// read; then less is said. Complaints are in the order of the file.
pub fn check_sequence(
    file: &CommandFile,
    deck_of: impl FnMut(Span) -> Option<Dataset>,
) -> Vec<Diagnostic> {
    sequence::check(file, deck_of)
}

/// Runs every rule over a dataset. Complaints are in the order of their places in the file.
pub fn check(dataset: &Dataset, options: &Options) -> Vec<Diagnostic> {
    run(dataset, options, |_| true)
}

fn run(dataset: &Dataset, options: &Options, wanted: impl Fn(&Rule) -> bool) -> Vec<Diagnostic> {
    let context = Context::new(dataset, options);
    let mut found = Vec::new();
    for rule in RULES.iter().filter(|rule| wanted(rule)) {
        let mut own = Vec::new();
        (rule.check)(&context, &mut own);
        if own.len() > MOST_OF_A_RULE {
            own = shortened(own, rule.code);
        }
        found.extend(own);
    }
    found.sort_by_key(|diagnostic| {
        let place = diagnostic.labels.first().map(|label| label.span);
        (
            place.map(|span| (span.start(), span.end())),
            diagnostic.code,
        )
    });
    found
}
