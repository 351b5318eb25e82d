//! Measured curves for comparison with K&C tests.

use admire_kc::{Config, Driven, TestKind, driven_unit, unit_in_deck};
use admire_lab::Quantity;
use admire_report::MeasuredCurve;
use admire_study::{Cell, Table, did_you_mean};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::text::Source;
use admire_syntax::units::Units;

/// Reads a table with the columns `test`, `value` and characteristics, and `value_unit` if `value` is not in the units of the deck.
///
/// The heading of a column may end in a unit as in `curves.csv`, such as `[deg]`. Without a unit, values are in the deck's units and
/// radians. Cells may be empty. Commas, semicolons and tabs are accepted as separators; with the latter two, decimals may have commas.
///
/// # Errors
/// Returns a diagnostic with its place if a column is missing, a unit is unknown or a cell holds no number.
pub(crate) fn measured(
    source: &Source,
    config: &Config,
    units: &Units,
) -> Result<Checked<Vec<MeasuredCurve>>, Diagnostic> {
    let mut found = Vec::new();
    let table = Table::read(source.clone(), &mut found);
    let wanted = table.columns(["test", "value"], &mut found);
    refuse_errors(&mut found)?;
    let Some([test, value]) = wanted else {
        // The missing column has already been reported.
        return Ok(Checked::clean(Vec::new()));
    };
    let value_unit = table.column("value_unit");
    let wrong = |cell: &Cell, message: String, help: String| {
        let wrong = Diagnostic::error(Code::BadReading, message);
        wrong.label(table.source.name(), cell.span, "").help(help)
    };
    let mut columns = Vec::new();
    for (k, cell) in table.header_cells().iter().enumerate() {
        let (path, unit) = match cell.text.split_once('[') {
            Some((path, unit)) => (path, unit.trim_end_matches([']', ' ']).trim()),
            None => (cell.text.as_str(), ""),
        };
        if path.contains('.') {
            let factor = column_unit(unit, units).ok_or_else(|| {
                let help = "use deg, min or rad for angles, mm, m or in for lengths, N, kN or lbf for forces, Nm for torques, or a unit of curves.csv";
                wrong(cell, format!("`{unit}` is not a known unit"), help.to_string())
            })?;
            columns.push((k, path.trim().to_string(), factor));
        }
    }
    let mut curves: Vec<MeasuredCurve> = Vec::new();
    for row in table.rows() {
        let Some(name) = table.cell(row, test) else {
            continue;
        };
        let known = config
            .tests
            .iter()
            .find(|(kind, _)| kind.name() == name.text);
        let Some((kind, _)) = known else { continue };
        let mut number = |column: usize| {
            let number = table.number(row, column, &mut found);
            refuse_warnings(&mut found)?;
            Ok::<Option<f64>, Diagnostic>(number)
        };
        let Some(at) = number(value)? else { continue };
        let size = match value_unit.and_then(|column| table.cell(row, column)) {
            None => 1.0,
            Some(cell) => variable_unit(&cell.text, *kind, units).ok_or_else(|| {
                let words = [driven_unit(kind.driven(), units)];
                let message = format!(
                    "`{}` is not a unit of the variable of the test `{}`",
                    cell.text,
                    kind.name()
                );
                wrong(cell, message, did_you_mean(&cell.text, "the test", &words))
            })?,
        };
        for (k, path, factor) in &columns {
            let Some(read) = number(*k)? else { continue };
            let point = (at * size, read * factor);
            let same = |c: &&mut MeasuredCurve| c.test == name.text && c.path == *path;
            match curves.iter_mut().find(same) {
                Some(curve) => curve.points.push(point),
                None => curves.push(MeasuredCurve {
                    test: name.text.clone(),
                    path: path.clone(),
                    points: vec![point],
                }),
            }
        }
    }
    let mut diagnostics = Vec::new();
    if curves.is_empty() {
        let message = format!(
            "`{}` contains no curve of the tests in the configuration",
            source.name()
        );
        diagnostics.push(Diagnostic::warning(Code::MissingColumn, message));
    }
    Ok(Checked {
        value: curves,
        diagnostics,
    })
}

/// Returns the first error as `Err`, and discards notes about the format of the table.
fn refuse_errors(found: &mut Vec<Diagnostic>) -> Result<(), Diagnostic> {
    let is_error = |d: &Diagnostic| d.severity == Severity::Error;
    let first = found.iter().position(is_error);
    let error = first.map(|at| found.swap_remove(at));
    found.clear();
    error.map_or(Ok(()), Err)
}

/// Returns the first diagnostic about a cell as an error. Leaving out the cell would change the shape of the curve.
fn refuse_warnings(found: &mut Vec<Diagnostic>) -> Result<(), Diagnostic> {
    match found.pop() {
        None => Ok(()),
        Some(mut wrong) => {
            found.clear();
            wrong.severity = Severity::Error;
            Err(wrong)
        }
    }
}

/// Returns the size of a column's unit, in units of the deck and radians; `None` for an unknown word.
fn column_unit(word: &str, units: &Units) -> Option<f64> {
    unit_in_deck(word, units).or_else(|| {
        let (quantity, factor) = Quantity::of_unit(word)?;
        Some(factor * quantity.si() / in_deck(quantity, units))
    })
}

/// Returns the size of the unit of a test's variable, in units of the deck; `None` for the unit of another quantity. The steering input is in the
/// unit of the driven parameter.
fn variable_unit(word: &str, kind: TestKind, units: &Units) -> Option<f64> {
    let driven = kind.driven();
    if driven == Driven::Steering || word == driven_unit(driven, units) {
        return Some(1.0);
    }
    let wanted = match driven {
        Driven::Height(_) => Quantity::Length,
        Driven::Mz(_) => Quantity::Torque,
        Driven::Fx(_) | Driven::Fy(_) | Driven::Steering => Quantity::Force,
    };
    Some(wanted.factor(word)? * wanted.si() / in_deck(wanted, units))
}

/// Returns the size in SI units of the deck's unit for a quantity.
fn in_deck(quantity: Quantity, units: &Units) -> f64 {
    match quantity {
        Quantity::Angle => 1.0,
        Quantity::Length => units.length.si,
        Quantity::Force => units.force.si,
        Quantity::Torque => units.force.si * units.length.si,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_a_table_are_those_of_the_deck() {
        let units = Units::default();
        let near = |a: Option<f64>, b: f64| (a.expect("a known unit") - b).abs() < 1e-12 * b;
        assert!(near(
            column_unit("min", &units),
            (1.0_f64 / 60.0).to_radians()
        ));
        assert!(near(column_unit("Nm", &units), 1000.0));
        assert!(near(column_unit("deg/kN", &units), 1e-3_f64.to_radians()));
        assert!(near(column_unit("", &units), 1.0));
        assert_eq!(column_unit("minutes", &units), None);
        assert!(near(variable_unit("kN", TestKind::Lateral, &units), 1000.0));
        assert!(near(
            variable_unit("Nm", TestKind::Aligning, &units),
            1000.0
        ));
        assert_eq!(variable_unit("kN", TestKind::Bounce, &units), None);
    }
}
