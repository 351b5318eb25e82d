use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;

use crate::front::{SensitivityRow, SensitivityTable, Unavailable};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::short_unit;

use super::Outcome;
use super::addresses::complete;
use super::format::Format;
use super::input::{Solvable, solvable};
use super::shell::{Exit, Shell};
use super::width::table_text;

/// Show how the equilibrium changes with the parameters of a dataset.
///
/// Prints the derivatives of motions, forces or measures with respect to stiffnesses, preloads, marker positions, spring lengths and loads. The
/// derivatives are exact, from the tangent of the equilibrium. They are in the deck's units, which are printed (angles in radians). A change of QP
/// moves a marker as `admire set` does: without rotation, together with ZP and XP, and with the markers in its frame (RM).
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire sensitivity front.adm --of KNUCKLE --by BUSHING/1.K")]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Results to differentiate: a part (its motion), a force element or a joint (its force on I), or `REQUEST/1.F2`.
    #[arg(long, required = true, num_args = 1.., add = ArgValueCompleter::new(complete))]
    of: Vec<String>,
    /// Parameters with respect to which derivatives are taken: `BUSHING/1.K`, `BUSHING/1`, `MARKER/4.QP.2`; by default, all
    /// parameters with an effect.
    #[arg(long, num_args = 1.., add = ArgValueCompleter::new(complete))]
    by: Vec<String>,
    /// TIME at which the equilibrium is solved.
    #[arg(long, default_value_t = 0.0)]
    time: f64,
}

/// Solves the equilibrium, differentiates it and prints the table.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let Solvable {
        dataset,
        model,
        system,
        ..
    } = solvable(&arguments.deck, &[], shell)?;
    let found = SensitivityTable::new(
        &dataset,
        &model,
        &system,
        &arguments.of,
        &arguments.by,
        arguments.time,
    );
    let SensitivityTable {
        of,
        units,
        by: rows,
    } = match found {
        Ok(table) => table,
        Err(Unavailable::Word(refused)) => return Err(shell.fail(refused)),
        Err(Unavailable::NoAnswer(error)) => {
            shell.complain(&[Diagnostic::error(Code::NoEquilibrium, error.to_string())]);
            return Err(Exit::NoAnswer);
        }
    };
    shell.print(&match shell.format {
        Format::Json => {
            let rows: Vec<_> = rows
                .iter()
                .map(|row| {
                    let value = Some(row.value).filter(|v| v.is_finite());
                    json!({ "by": row.address, "value": value, "unit": row.unit, "derivatives": row.derivatives })
                })
                .collect();
            serde_json::to_string_pretty(&json!({ "of": of, "units": units, "rows": rows }))
                .expect("JSON values print")
                + "\n"
        }
        _ => text((&of, &units), &rows),
    });
    Ok(Exit::Fine)
}

fn text((of, units): (&[String], &[String]), rows: &[SensitivityRow]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let heads = ["parameter", "value", "unit"].map(str::to_string);
    let columns = of
        .iter()
        .zip(units)
        .map(|(name, unit)| match unit.as_str() {
            "" => name.clone(),
            unit => format!("{name} [{}]", short_unit(unit)),
        });
    table.set_header(heads.into_iter().chain(columns));
    for row in rows {
        let value = if row.value.is_nan() {
            "function".to_string()
        } else {
            format!("{}", row.value)
        };
        let cells = row.derivatives.iter().map(|d| format!("{d:.5e}"));
        let first = [row.address.clone(), value, short_unit(&row.unit)];
        table.add_row(first.into_iter().chain(cells));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for column in table.column_iter_mut().skip(2).take(1) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    table_text(&table)
        + "derivatives with respect to the parameters, in the unit of the column per unit of the parameter\n"
}
