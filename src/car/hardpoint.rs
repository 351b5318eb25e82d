//! Hardpoints of subsystem and assembly files.

use admire_syntax::Number;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::property::{Cell, PropertyFile, Table};
use admire_syntax::text::Span;
use admire_syntax::units::{Dimension, Units};

use crate::file_units::factor;
use crate::side::{Side, Symmetry};

/// One row of the table `[HARDPOINT]`.
#[derive(Clone, PartialEq, Debug)]
pub struct Hardpoint {
    /// Name without surrounding blanks.
    pub name: String,
    /// Sides on which the hardpoint exists.
    pub symmetry: Symmetry,
    /// x, y and z in the length unit of the file, with their locations. For `left/right`, they are the coordinates of the left side.
    pub coordinates: [Number; 3],
    /// Location of the word for the symmetry, without its quotes.
    pub symmetry_span: Span,
    /// Location of the row, from its first cell to its last.
    pub row: Span,
}

impl Hardpoint {
    /// Returns the position of the hardpoint on one side, in the units of the file. The right side of a pair is the mirror image of the left side in
    /// the plane y = 0. `None` if the hardpoint does not exist on that side.
    pub fn place(&self, side: Side) -> Option<[f64; 3]> {
        let [x, y, z] = self.coordinates.map(|number| number.value);
        let exists = self.symmetry.sides().contains(&side);
        let mirrored = self.symmetry == Symmetry::Pair && side == Side::Right;
        exists.then_some([x, if mirrored { -y } else { y }, z])
    }

    /// Returns the name of the hardpoint in a model of Adams/Car: `hpl_lca_outer`, `hpr_lca_outer`, `hps_rack_house`.
    pub fn full_name(&self, side: Side) -> String {
        format!("hp{}_{}", side.letter(), self.name)
    }
}

/// Reads all hardpoints of a file. Rows that cannot be read are reported and left out.
pub(crate) fn read(file: &PropertyFile, out: &mut Vec<Diagnostic>) -> Vec<Hardpoint> {
    let source = file.source();
    let mut found: Vec<Hardpoint> = Vec::new();
    for block in file.blocks.iter().filter(|b| b.name == "HARDPOINT") {
        for table in &block.tables {
            let Some(columns) = columns(
                table,
                [
                    "hardpoint_name",
                    "symmetry",
                    "x_value",
                    "y_value",
                    "z_value",
                ],
            ) else {
                out.push(
                    Diagnostic::warning(
                        Code::MissingArgument,
                        "a table of hardpoints needs the columns hardpoint_name, symmetry, x_value, y_value and z_value",
                    )
                    .label(source.name(), block.heading, "its rows are not read"),
                );
                continue;
            };
            for row in &table.rows {
                let [Some(name), Some(symmetry), Some(x), Some(y), Some(z)] =
                    columns.map(|column| row.get(column))
                else {
                    // A row that is too short was reported when the file was parsed.
                    continue;
                };
                let Some(sides) = symmetry_of(file, symmetry, out) else {
                    continue;
                };
                let cells = [x, y, z];
                let numbers = cells.map(|cell| match cell {
                    Cell::Number(number) => Some(*number),
                    Cell::Text(_) => None,
                });
                let [Some(x), Some(y), Some(z)] = numbers else {
                    let bad = cells.into_iter().find(|cell| cell.number().is_none());
                    let place = bad.unwrap_or(name).span();
                    out.push(
                        Diagnostic::error(Code::BadNumber, "a coordinate must be a number").label(
                            source.name(),
                            place,
                            "the hardpoint is left out",
                        ),
                    );
                    continue;
                };
                let last = row.last().unwrap_or(name).span();
                let new = Hardpoint {
                    name: name.text(source).into_owned(),
                    symmetry: sides,
                    coordinates: [x, y, z],
                    symmetry_span: symmetry.span(),
                    row: name.span().join(last),
                };
                found.push(new);
            }
        }
    }
    repeated(file, &found, out);
    found
}

/// Returns the indices of the named columns of a table.
pub(crate) fn columns<const N: usize>(table: &Table, names: [&str; N]) -> Option<[usize; N]> {
    let found = names.map(|name| table.columns.iter().position(|column| column == name));
    found
        .iter()
        .all(Option::is_some)
        .then(|| found.map(Option::unwrap_or_default))
}

/// Reads the symmetry of an entry and reports an unknown word.
pub(crate) fn symmetry_of(
    file: &PropertyFile,
    cell: &Cell,
    out: &mut Vec<Diagnostic>,
) -> Option<Symmetry> {
    let word = cell.text(file.source());
    let known = Symmetry::parse(&word);
    if known.is_none() {
        let message = format!("`{word}` is not a symmetry");
        out.push(
            Diagnostic::error(Code::WrongType, message)
                .label(file.source().name(), cell.span(), "")
                .help("write 'left/right', 'left', 'right' or 'single'"),
        );
    }
    known
}

/// Reports hardpoints that occur twice on one side.
fn repeated(file: &PropertyFile, all: &[Hardpoint], out: &mut Vec<Diagnostic>) {
    let mut seen: std::collections::HashMap<(String, Side), Span> =
        std::collections::HashMap::new();
    for point in all {
        for side in point.symmetry.sides() {
            let key = (point.name.to_ascii_lowercase(), *side);
            if let Some(first) = seen.insert(key, point.row) {
                let message = format!("hardpoint {} is defined twice", point.full_name(*side));
                out.push(
                    Diagnostic::error(Code::DuplicateId, message)
                        .label(file.source().name(), point.row, "")
                        .label(file.source().name(), first, "the first one"),
                );
                break;
            }
        }
    }
}

impl Hardpoint {
    /// Returns the position on one side in the length unit of a model; `None` if the hardpoint does not exist on that side.
    pub fn place_in(&self, file: &PropertyFile, side: Side, units: &Units) -> Option<[f64; 3]> {
        let scale = factor(file, Dimension::LENGTH, units);
        Some(self.place(side)?.map(|x| x * scale))
    }
}
