use super::block::{Block, Table};
use super::{PropertyKind, PropertyUnits};
use crate::Number;
use crate::diagnostic::{Code, Diagnostic};
use crate::text::{Source, Span};
use crate::units::{Dimension, Units};

/// A curve y(x) of a property file, in the units of the file.
#[derive(Clone, PartialEq, Debug)]
pub struct PropertyCurve {
    /// Name of the block that contains the curve, in capitals.
    pub block: String,
    /// Name of the part of the block that contains the curve, in capitals; `None` if the curve is not in a part.
    pub part: Option<String>,
    /// Abscissae, with their locations in the file.
    pub x: Vec<Number>,
    /// Ordinates, with their locations in the file.
    pub y: Vec<Number>,
    /// Dimensions of x and y; `None` if neither the kind of file nor the table heading determines them.
    pub dimensions: Option<(Dimension, Dimension)>,
    /// Location of the table.
    pub span: Span,
}

const VELOCITY: Dimension = Dimension::new(0, 0, 1, -1, 0);

impl PropertyCurve {
    /// Returns the curve of a table with two columns, or `None` if no row contains two numbers. Rows with other cells are left out.
    pub(super) fn of(kind: &PropertyKind, block: &Block, table: &Table) -> Option<Self> {
        let mut curve = Self {
            block: block.name.clone(),
            part: block.part.clone(),
            x: Vec::new(),
            y: Vec::new(),
            dimensions: dimensions(kind, &block.name, &table.columns),
            span: table.span,
        };
        for row in &table.rows {
            if let [super::Cell::Number(x), super::Cell::Number(y)] = row.as_slice() {
                curve.x.push(*x);
                curve.y.push(*y);
            }
        }
        (!curve.x.is_empty()).then_some(curve)
    }

    /// Returns x and y in the units of a model, with angles in radians.
    ///
    /// `own` holds the units of the file. The values are not converted if `own` is `None` or the dimensions of the curve are unknown.
    pub fn in_units(&self, own: Option<&PropertyUnits>, units: &Units) -> (Vec<f64>, Vec<f64>) {
        let (fx, fy) = match (own, self.dimensions) {
            (Some(own), Some((x, y))) => (own.factor(x, units), own.factor(y, units)),
            _ => (1.0, 1.0),
        };
        let scaled = |numbers: &[Number], factor: f64| {
            numbers.iter().map(|number| number.value * factor).collect()
        };
        (scaled(&self.x, fx), scaled(&self.y, fy))
    }

    /// Reports abscissae that do not increase, and table cells that are not numbers.
    pub(super) fn check(&self, table: &Table, source: &Source, diagnostics: &mut Vec<Diagnostic>) {
        let pairs = table.rows.iter().filter(|row| row.len() == 2);
        for cell in pairs.flatten() {
            if let super::Cell::Text(span) = cell {
                let message = format!("{} is a curve, but this cell is not a number", self.block);
                diagnostics.push(
                    Diagnostic::error(Code::BadNumber, message)
                        .label(source.name(), *span, "")
                        .help("this row is left out of the curve"),
                );
            }
        }
        if let Some(pair) = self
            .x
            .windows(2)
            .find(|pair| pair[1].value <= pair[0].value)
        {
            diagnostics.push(
                Diagnostic::error(
                    Code::SplineNotIncreasing,
                    format!("the x values of {} do not increase here", self.block),
                )
                .label(source.name(), pair[1].span, ""),
            );
        }
    }
}

/// Returns the dimensions of the two columns. They follow from the kind of element, or else from the words of the table heading.
fn dimensions(
    kind: &PropertyKind,
    block: &str,
    columns: &[String],
) -> Option<(Dimension, Dimension)> {
    match (kind, block.as_bytes()) {
        (PropertyKind::Bushing, [b'F', ..]) => Some((Dimension::LENGTH, Dimension::FORCE)),
        (PropertyKind::Bushing, [b'T', ..]) => Some((Dimension::ANGLE, Dimension::TORQUE)),
        (PropertyKind::Spring | PropertyKind::Stop, _) => {
            Some((Dimension::LENGTH, Dimension::FORCE))
        }
        (PropertyKind::Damper, _) => Some((VELOCITY, Dimension::FORCE)),
        _ => match columns {
            [x, y] => Some((word_dimension(x)?, word_dimension(y)?)),
            _ => None,
        },
    }
}

fn word_dimension(word: &str) -> Option<Dimension> {
    let begins = |starts: &[&str]| starts.iter().any(|start| word.starts_with(start));
    if begins(&["disp", "length", "trav", "penetr"]) {
        Some(Dimension::LENGTH)
    } else if begins(&["vel"]) {
        Some(VELOCITY)
    } else if begins(&["force"]) {
        Some(Dimension::FORCE)
    } else if begins(&["torque", "moment"]) {
        Some(Dimension::TORQUE)
    } else if begins(&["ang"]) {
        Some(Dimension::ANGLE)
    } else {
        None
    }
}
