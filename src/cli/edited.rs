//! Checks of a deck after an edit, before anything is written.

use crate::front::Before;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Diagnostic};
use admire_syntax::text::Edit;

use super::shell::{Exit, Shell};

/// Applies edits to the text of a deck.
pub(super) fn edited(
    deck: &Dataset,
    edits: &[Edit],
    shell: &Shell,
) -> Result<Checked<Dataset>, Exit> {
    crate::front::edited(deck, edits).map_err(|refused| shell.fail(refused))
}

/// Reports new errors in an edited deck and refuses to continue. With `force`, the errors are reported only.
pub(super) fn refuse_faults(
    before: &Before,
    after: &Checked<Dataset>,
    force: bool,
    shell: &Shell,
) -> Result<(), Exit> {
    let found = before.new_faults(after);
    shell.complain(&found);
    match found.first() {
        Some(first) if !force => Err(shell.fail(
            Diagnostic::error(
                first.code,
                "nothing is written: the deck would have a new error, shown above",
            )
            .help("change the dependent statements in the same command, or write the deck anyway with --force"),
        )),
        _ => Ok(()),
    }
}
