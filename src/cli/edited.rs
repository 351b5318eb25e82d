//! What an edit does to a deck beyond the value it is about: looked at before anything is written.

use crate::front::Before;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Diagnostic};
use admire_syntax::text::Edit;

use super::shell::{Exit, Shell};

/// The deck after edits of its text.
pub(super) fn edited(
    deck: &Dataset,
    edits: &[Edit],
    shell: &Shell,
) -> Result<Checked<Dataset>, Exit> {
    crate::front::edited(deck, edits).map_err(|refused| shell.fail(refused))
}

/// Gives up, having said why, if a deck has an error that it had not before; with `force` the errors are only told.
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
                "nothing is written: the deck would have a new fault",
            )
            .help("change what it concerns too, or --force"),
        )),
        _ => Ok(()),
    }
}
