//! Access to the rows of a study's tables: the load case and the point that a row contains.

use super::measurement::{Grouped, Measurement};
use super::table::{Cell, Table};
use admire_solver::mechanics::Vec3;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Returns the label of a row: the cell in `column`, or the number of the row counted from 1 if the file has no such column.
pub(super) fn label_of(
    table: &Table,
    row: &[Cell],
    column: Option<usize>,
    number: usize,
) -> Option<Cell> {
    match column {
        Some(column) => table.cell(row, column).cloned(),
        None => Some(Cell {
            text: (number + 1).to_string(),
            span: table.row_span(row),
        }),
    }
}

/// Returns the index of the load case that `cell` names, or reports that there is no such load case.
pub(super) fn case_of(
    cell: &Cell,
    table: &Table,
    to: &Measurement,
    grouped: &mut Grouped,
) -> Option<usize> {
    let found = to.case(&cell.text);
    // If the study has no load cases at all, this has been reported already.
    if found.is_none() && !to.cases.is_empty() {
        grouped.add(format!("case {}", cell.text), || {
            let message = format!(
                "there is no load case `{}`; its readings are left out",
                cell.text
            );
            Diagnostic::warning(Code::UnknownCase, message).label(
                table.source.name(),
                cell.span,
                "",
            )
        });
    }
    found
}

pub(super) fn point(
    table: &Table,
    row: &[Cell],
    columns: [usize; 3],
    out: &mut Vec<Diagnostic>,
) -> Option<Vec3> {
    let values = columns.map(|column| table.number(row, column, out));
    match values {
        [Some(x), Some(y), Some(z)] => Some(Vec3::new(x, y, z)),
        _ => None,
    }
}

pub(super) fn labels(to: &Measurement) -> Vec<String> {
    to.cases.iter().map(|case| case.label.clone()).collect()
}
