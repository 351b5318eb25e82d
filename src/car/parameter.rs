//! Parameters of subsystem and assembly files.

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::property::{Cell, PropertyFile};

use crate::hardpoint::{columns, symmetry_of};
use crate::side::Symmetry;

/// One row of the table `[PARAMETER]`.
#[derive(Clone, PartialEq, Debug)]
pub struct Parameter {
    /// Name without surrounding blanks.
    pub name: String,
    /// Sides on which the parameter exists.
    pub symmetry: Symmetry,
    /// Type as the file names it: `real`, `integer`, `string`.
    pub kind: String,
    /// Value. The file does not state its unit.
    pub value: Cell,
    /// Remark below the row, if there is one.
    pub remark: Option<String>,
}

/// Reads all parameters of a file. Rows that cannot be read are reported and left out.
pub(crate) fn read(file: &PropertyFile, out: &mut Vec<Diagnostic>) -> Vec<Parameter> {
    let source = file.source();
    let mut found: Vec<Parameter> = Vec::new();
    for block in file.blocks.iter().filter(|b| b.name == "PARAMETER") {
        for table in &block.tables {
            let Some(columns) = columns(table, ["parameter_name", "symmetry", "type", "value"])
            else {
                out.push(
                    Diagnostic::warning(
                        Code::MissingArgument,
                        "a table of parameters needs the columns parameter_name, symmetry, type and value",
                    )
                    .label(source.name(), block.heading, "its rows are not read"),
                );
                continue;
            };
            for row in &table.rows {
                if table.is_remark(row) {
                    let text = row.first().map(|cell| cell.text(source).into_owned());
                    if let Some(above) = found.last_mut() {
                        above.remark = text;
                    }
                    continue;
                }
                let [Some(name), Some(symmetry), Some(kind), Some(value)] =
                    columns.map(|column| row.get(column))
                else {
                    continue;
                };
                let Some(symmetry) = symmetry_of(file, symmetry, out) else {
                    continue;
                };
                let kind = kind.text(source).to_ascii_lowercase();
                let number = value.number();
                let wrong = match kind.as_str() {
                    "real" => number.is_none(),
                    "integer" => number.is_none_or(|value| value.fract() != 0.0),
                    _ => false,
                };
                if wrong {
                    let message = format!("this is not a value for a parameter of type {kind}");
                    out.push(Diagnostic::error(Code::WrongType, message).label(
                        source.name(),
                        value.span(),
                        "",
                    ));
                }
                found.push(Parameter {
                    name: name.text(source).into_owned(),
                    symmetry,
                    kind,
                    value: *value,
                    remark: None,
                });
            }
        }
    }
    found
}
