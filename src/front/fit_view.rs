//! Views of a fit: positions of the parts, and changed lines of the deck.

use admire_identify::{Fit, LoadedStudy};
use admire_report::Positions;
use admire_report::scene::Role;
use admire_session::backend::Backend;
use admire_study::settings::BackendChoice;

/// Returns the positions of the parts with the initial and with the identified parameters. Positions for which the solver finds no
/// equilibrium are left out.
pub(crate) fn positions(
    loaded: &LoadedStudy,
    fit: &Fit,
    backend: &mut dyn Backend,
) -> Vec<Positions> {
    // Drawing pictures does not justify the use of another solver's licences.
    if loaded.study.solver.backend != BackendChoice::Native {
        return Vec::new();
    }
    let problem = loaded.problem();
    let wanted = [
        (Role::Given, problem.initial()),
        (Role::Identified, fit.values()),
    ];
    let solved = wanted.into_iter().filter_map(|(role, values)| {
        let sweep = problem.sweep(backend, &values).ok()?;
        Some(Positions::of(role, &sweep))
    });
    solved.collect()
}

/// Returns the changed lines as a unified diff, with three lines of context.
pub(crate) fn changed_lines(before: &[u8], after: &[u8]) -> String {
    let (before, after) = (
        String::from_utf8_lossy(before),
        String::from_utf8_lossy(after),
    );
    let diff = similar::TextDiff::from_lines(before.as_ref(), after.as_ref());
    let text = diff.unified_diff().context_radius(3).to_string();
    text.replace('\r', "")
}
