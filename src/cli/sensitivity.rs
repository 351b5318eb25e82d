use std::path::PathBuf;

use clap_complete::ArgValueCompleter;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;

use crate::diagnostic::{Code, Diagnostic};
use crate::model::{Model, PartIx};
use crate::statics::{Sensitivity, Settings, solve};
use crate::syntax::Dataset;
use crate::system::{Quantity, Slot, System};

use super::Outcome;
use super::addresses::complete;
use super::get;
use super::input::{Solvable, solvable};
use super::render::table_text;
use super::shell::{Exit, Format, Shell};

/// Show how the equilibrium changes with the numbers of a dataset.
///
/// The derivatives of motions, forces or measures by stiffnesses, preloads, marker positions, spring lengths, loads: exact,
/// from the tangent of the equilibrium, in the deck's units (angles in radians).
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire sensitivity front.adm --of KNUCKLE --by BUSHING/1.K")]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// What changes: a part (its motion), a force element or a joint (its force on I), or `REQUEST/1.F2`.
    #[arg(long, required = true, num_args = 1.., add = ArgValueCompleter::new(complete))]
    of: Vec<String>,
    /// By which numbers: `BUSHING/1.K`, `BUSHING/1`, `MARKER/4.QP.2`; all that have an effect if absent.
    #[arg(long, num_args = 1.., add = ArgValueCompleter::new(complete))]
    by: Vec<String>,
    /// TIME of the equilibrium.
    #[arg(long, default_value_t = 0.0)]
    time: f64,
}

/// What the columns of the table are.
struct Column {
    head: String,
    quantity: Quantity,
}

/// Solves, differentiates and prints.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let Solvable {
        dataset,
        model,
        system,
        ..
    } = solvable(&arguments.deck, &[], shell)?;
    let mut columns = Vec::new();
    for text in &arguments.of {
        columns.extend(quantities(text, (&dataset, &model, &system), shell)?);
    }
    let slots = slots(&arguments.by, (&dataset, &system), shell)?;
    let (parameters, mut state) = (system.parameters(), system.state());
    state.time = arguments.time;
    let settings = Settings::from(system.settings());
    let solved = solve(&system, &parameters, &mut state, &settings).and_then(|_| {
        let quantities: Vec<Quantity> = columns.iter().map(|c| c.quantity).collect();
        Sensitivity::new(&system, &parameters, &state)?.table(&quantities, &slots)
    });
    let rows = match solved {
        Ok(rows) => rows,
        Err(error) => {
            shell.complain(&[Diagnostic::error(Code::NoEquilibrium, error.to_string())]);
            return Err(Exit::NoAnswer);
        }
    };
    let named = slots.iter().zip(rows).map(|(&slot, row)| {
        let address = system.catalogue().info(slot).address.to_string();
        (address, parameters.get(slot), row)
    });
    // Asked for by name even a zero is an answer; else only what has an effect.
    let all = !arguments.by.is_empty();
    let rows: Vec<_> = named
        .filter(|(_, _, row)| all || row.iter().any(|d| *d != 0.0))
        .collect();
    shell.print(&match shell.format {
        Format::Json => {
            let rows: Vec<_> = rows
                .iter()
                .map(|(address, value, row)| {
                    let value = Some(*value).filter(|v| v.is_finite());
                    json!({ "by": address, "value": value, "derivatives": row })
                })
                .collect();
            let heads: Vec<&str> = columns.iter().map(|c| c.head.as_str()).collect();
            serde_json::to_string_pretty(&json!({ "of": heads, "rows": rows }))
                .expect("JSON values print")
                + "\n"
        }
        _ => text(&columns, &rows),
    });
    Ok(Exit::Fine)
}

/// The quantities that a word of the command line means.
fn quantities(
    text: &str,
    (dataset, model, system): (&Dataset, &Model, &System),
    shell: &Shell,
) -> Result<Vec<Column>, Exit> {
    const MOTION: [&str; 6] = ["x", "y", "z", "about x", "about y", "about z"];
    const WRENCH: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
    let address = get::parse(text, dataset, shell)?;
    let id = address.id.unwrap_or_default();
    let kind = address.kind.as_str();
    let six = |names: [&str; 6], make: &dyn Fn(usize) -> Quantity| {
        (0..6)
            .map(|k| Column {
                head: format!("{text} {}", names[k]),
                quantity: make(k),
            })
            .collect()
    };
    if matches!(kind, "PART" | "POINT_MASS") {
        let part = model.parts.iter().position(|p| p.header.id == id);
        if let Some(part) = part {
            return Ok(six(MOTION, &|k| Quantity::Motion(PartIx(part), k)));
        }
    }
    if let Some(element) = system.element(kind, id) {
        return Ok(six(WRENCH, &|k| Quantity::Element(element, k)));
    }
    if let Some(constraint) = system.constraint(kind, id) {
        return Ok(six(WRENCH, &|k| Quantity::Constraint(constraint, k)));
    }
    let component = address
        .argument
        .as_deref()
        .and_then(|a| a.strip_prefix('F'))
        .and_then(|n| n.parse::<usize>().ok())
        .filter(|n| (1..=8).contains(n));
    let request = model.requests.iter().position(|r| r.header.id == id);
    if let ("REQUEST", Some(component), Some(index)) = (kind, component, request) {
        return Ok(vec![Column {
            head: text.to_string(),
            quantity: Quantity::Request(index, component - 1),
        }]);
    }
    let message = format!("`{text}` is no part, force, joint or REQUEST/id.F2");
    shell.complain(&[Diagnostic::error(Code::WrongType, message)]);
    Err(Exit::Findings)
}

/// The numbers that the words mean: those whose address begins so. Without any, all but the literals of functions.
fn slots(
    words: &[String],
    (dataset, system): (&Dataset, &System),
    shell: &Shell,
) -> Result<Vec<Slot>, Exit> {
    let catalogue = system.catalogue();
    let all: Vec<(Slot, String)> = catalogue
        .slots()
        .map(|slot| (slot, catalogue.info(slot).address.to_string()))
        .collect();
    if words.is_empty() {
        let readings = ["REQUEST", "SENSOR"];
        let literal = |slot: Slot| {
            let address = catalogue.info(slot).address;
            let function = address.argument.as_deref().is_some_and(|a| a == "FUNCTION");
            readings.contains(&address.kind.as_str()) || (function && address.index.is_some())
        };
        return Ok(all
            .into_iter()
            .map(|a| a.0)
            .filter(|s| !literal(*s))
            .collect());
    }
    let mut out = Vec::new();
    for word in words {
        let wanted = get::parse(word, dataset, shell)?.to_string();
        let before = out.len();
        for (slot, address) in &all {
            let rest = address.strip_prefix(&wanted);
            if rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) {
                out.push(*slot);
            }
        }
        if out.len() == before {
            let message = format!("`{word}` has no number that the equilibrium depends on");
            shell.complain(&[Diagnostic::error(Code::UndefinedId, message)]);
            return Err(Exit::Findings);
        }
    }
    Ok(out)
}

fn text(columns: &[Column], rows: &[(String, f64, Vec<f64>)]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let heads = ["d / d".to_string(), "value".to_string()];
    table.set_header(
        heads
            .into_iter()
            .chain(columns.iter().map(|c| c.head.clone())),
    );
    for (address, value, row) in rows {
        let value = if value.is_nan() {
            "function".to_string()
        } else {
            format!("{value}")
        };
        let cells = row.iter().map(|d| format!("{d:.5e}"));
        table.add_row([address.clone(), value].into_iter().chain(cells));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table_text(&table)
}
