use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Elements on both sides of the diagonal may differ by this share of the larger one: what printed digits leave.
const ROUNDING: f64 = 1e-3;

/// Stiffness matrices of FIELD that are not symmetric: elastic forces would give or take energy on a closed path. ADAMS accepts them;
/// most come from a list in the wrong order or a mistyped digit.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for field in context.of_kind("FIELD") {
        let numbers = field.numbers("KMATRIX");
        if numbers.len() != 36 {
            continue;
        }
        // Element (row, column) stands at 6 column + row.
        let at = |row: usize, column: usize| &numbers[6 * column + row];
        let mut worst: Option<(f64, usize, usize)> = None;
        for row in 0..6 {
            for column in 0..row {
                let (below, above) = (at(row, column).value, at(column, row).value);
                let larger = below.abs().max(above.abs());
                let apart = (below - above).abs();
                if apart > ROUNDING * larger && worst.is_none_or(|(w, _, _)| apart > w) {
                    worst = Some((apart, row, column));
                }
            }
        }
        let Some((_, row, column)) = worst else {
            continue;
        };
        let (below, above) = (at(row, column), at(column, row));
        let message = format!(
            "the stiffness matrix of {} is not symmetric: element {},{} is {} and element {},{} is {}",
            context.title(field),
            row + 1,
            column + 1,
            below.value,
            column + 1,
            row + 1,
            above.value
        );
        found.push(
            context
                .warning(Code::UnsymmetricStiffness, below.span, message)
                .label(
                    context.dataset.source().name(),
                    above.span,
                    "the element across the diagonal",
                )
                .help("KMATRIX is written column by column, 36 values"),
        );
    }
}
