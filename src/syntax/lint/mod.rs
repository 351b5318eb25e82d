//! Lint: rules that find problems in a dataset that was parsed without errors. The results are diagnostics.
//!
//! Each rule is one file and one entry of [`RULES`]. Rules that need only the grammar use the faults of `syntax::fault`, as the model does.
//! The documentation of a rule is the documentation of its code (`admire explain CODE`).
//!
//! Rules see statements but no model; checks of positions and directions are in `model::lint`. The parser has already reported unknown
//! keywords, unreadable values and a missing END; the rules do not repeat this.

mod arguments;
mod context;
mod derivative;
mod duplicate_id;
mod fault;
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
mod options;
mod range;
mod sequence;
mod spline;
mod step;
mod suppressed;
mod symmetry;
mod tabs;
mod unit_dimension;
mod unreferenced;

use super::{CommandFile, Dataset};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::Span;
use context::Context;

pub use options::Options;
pub use suppressed::Suppressed;

/// The part of a file that a rule reads to judge one statement. A change outside of this part does not alter the diagnostics of the
/// statement.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Reach {
    /// Only the statement itself.
    Statement,
    /// The statement, all statements with the same id, the statements it refers to, and the body before a marker that names no body.
    Neighbours,
    /// The whole file.
    File,
}

/// A lint rule: the code under which it reports problems, and the function that checks a dataset.
pub struct Rule {
    /// Code of the diagnostics that the rule reports; the documentation of the code is the documentation of the rule.
    pub code: Code,
    /// Part of the file that the rule reads to judge one statement.
    pub reach: Reach,
    check: fn(&Context<'_>, &mut Vec<Diagnostic>),
}

/// All lint rules.
pub static RULES: &[Rule] = &[
    rule(Code::UndefinedId, Reach::Neighbours, fault::undefined_id),
    rule(Code::DuplicateId, Reach::Neighbours, duplicate_id::check),
    rule(Code::WrongCount, Reach::Statement, fault::count),
    rule(Code::WrongType, Reach::Statement, fault::value_type),
    rule(Code::OutOfRange, Reach::Statement, range::check),
    rule(
        Code::WrongDimension,
        Reach::Statement,
        unit_dimension::check,
    ),
    rule(Code::MissingArgument, Reach::Statement, fault::missing),
    rule(
        Code::ConflictingArguments,
        Reach::Statement,
        fault::conflicting,
    ),
    rule(Code::RepeatedArgument, Reach::Statement, arguments::check),
    rule(Code::MarkersOnOnePart, Reach::Neighbours, one_part::check),
    rule(Code::FloatingMarker, Reach::Neighbours, floating::check),
    rule(Code::NoGround, Reach::File, ground::check),
    rule(
        Code::MassWithoutCm,
        Reach::Neighbours,
        mass_without_cm::check,
    ),
    rule(Code::ImpossibleInertia, Reach::Statement, inertia::check),
    rule(Code::FreeWithoutMass, Reach::File, massless::check),
    rule(Code::UndefinedId, Reach::File, material::check),
    rule(Code::WrongMotion, Reach::File, motion::check),
    rule(
        Code::UnsymmetricStiffness,
        Reach::Statement,
        symmetry::check,
    ),
    rule(Code::StepWithoutWidth, Reach::Statement, step::check),
    rule(Code::KtPerDegree, Reach::File, kt_per_degree::check),
    rule(Code::SplineNotIncreasing, Reach::Statement, spline::check),
    rule(Code::NoDerivative, Reach::Statement, derivative::check),
    rule(Code::Unreferenced, Reach::File, unreferenced::check),
    rule(Code::NotSolvedNatively, Reach::File, native::check),
    rule(Code::Tab, Reach::File, tabs::check),
    rule(Code::LineTooLong, Reach::File, line_length::check),
];

const fn rule(code: Code, reach: Reach, check: fn(&Context<'_>, &mut Vec<Diagnostic>)) -> Rule {
    Rule { code, reach, check }
}

/// Maximum number of diagnostics kept per rule; the rest is only counted.
const MOST_OF_A_RULE: usize = 10_000;

/// Keeps the first [`MOST_OF_A_RULE`] diagnostics of a rule.
///
/// The last of them is replaced by a count of the diagnostics that are not listed, with the highest severity of these.
fn shortened(mut own: Vec<Diagnostic>, code: Code) -> Vec<Diagnostic> {
    let rest = own.split_off(MOST_OF_A_RULE);
    let worst = rest.iter().map(|d| d.severity).max();
    if let Some(last) = own.last_mut() {
        last.message = format!("{} more messages of {code} are not listed", rest.len() + 1);
        last.severity = last.severity.max(worst.unwrap_or(last.severity));
        last.fix = None;
    }
    own
}

/// Rules that need only the statement itself. These rules also apply to commands, which give only the arguments that they change.
const OF_COMMANDS: [Code; 7] = [
    Code::WrongCount,
    Code::WrongType,
    Code::OutOfRange,
    Code::WrongDimension,
    Code::ConflictingArguments,
    Code::RepeatedArgument,
    Code::StepWithoutWidth,
];

/// Runs the rules that need no dataset on the commands of a file. The diagnostics are ordered by their positions in the file.
pub fn check_commands(file: &CommandFile) -> Vec<Diagnostic> {
    let commands = Dataset::of_commands(file);
    let of_commands = |rule: &Rule| OF_COMMANDS.contains(&rule.code);
    let found = run(&commands, &Options::default(), of_commands, || false).unwrap_or_default();
    found
        .into_iter()
        .map(|(_, diagnostic)| diagnostic)
        .collect()
}

/// Checks the commands of a file in sequence, together with the decks on which they run: missing objects and impossible times.
///
/// `deck_of` returns the deck whose name is at the given span of the file, or `None` if that deck could not be read. Checks that need the
/// deck are then skipped. The diagnostics are in the order of the commands.
pub fn check_sequence(
    file: &CommandFile,
    deck_of: impl FnMut(Span) -> Option<Dataset>,
) -> Vec<Diagnostic> {
    sequence::check(file, deck_of)
}

/// Runs all rules on a dataset. The diagnostics are ordered by their positions in the file.
pub fn check(dataset: &Dataset, options: &Options) -> Vec<Diagnostic> {
    let found = check_until(dataset, options, Reach::File, || false).unwrap_or_default();
    found
        .into_iter()
        .map(|(_, diagnostic)| diagnostic)
        .collect()
}

/// Runs the rules whose reach is at most `reach` on a dataset, and returns each diagnostic with the reach of its rule.
///
/// `outdated` is called before each rule; once it returns true, the run ends and the result is `None`.
pub fn check_until(
    dataset: &Dataset,
    options: &Options,
    reach: Reach,
    outdated: impl Fn() -> bool,
) -> Option<Vec<(Reach, Diagnostic)>> {
    run(dataset, options, |rule| rule.reach <= reach, outdated)
}

fn run(
    dataset: &Dataset,
    options: &Options,
    wanted: impl Fn(&Rule) -> bool,
    outdated: impl Fn() -> bool,
) -> Option<Vec<(Reach, Diagnostic)>> {
    let context = Context::new(dataset, options);
    let mut found = Vec::new();
    for rule in RULES.iter().filter(|rule| wanted(rule)) {
        if outdated() {
            return None;
        }
        let mut own = Vec::new();
        (rule.check)(&context, &mut own);
        if own.len() > MOST_OF_A_RULE {
            own = shortened(own, rule.code);
        }
        found.extend(own.into_iter().map(|diagnostic| (rule.reach, diagnostic)));
    }
    found.sort_by_key(|(_, diagnostic)| {
        let place = diagnostic.labels.first().map(|label| label.span);
        (
            place.map(|span| (span.start(), span.end())),
            diagnostic.code,
        )
    });
    Some(found)
}
