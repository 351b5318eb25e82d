use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Tolerated difference between two mirrored matrix elements, relative to the larger element; it allows for the rounding of printed
/// numbers.
const ROUNDING: f64 = 1e-3;

/// Reports stiffness matrices of a FIELD that are not symmetric; their elastic forces do net work on a closed path.
///
/// ADAMS accepts such a matrix. Most often, the numbers were listed in the wrong order or a digit was mistyped.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for field in context.of_kind("FIELD") {
        let numbers = field.numbers("KMATRIX");
        if numbers.len() != 36 {
            continue;
        }
        // The element at (row, column) has the index 6 column + row.
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
