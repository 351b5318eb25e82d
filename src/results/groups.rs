use super::{Catalogue, NumberStyle, StepKind, write_number};

/// Maximum length, in characters, of a line of values in an XRF file.
const WIDTH: usize = 120;

/// Positions of the line breaks between the values of an output step in an XRF file.
///
/// The rules were derived from all available real files. TIME has its own line. Every entity starts a new line; in a body, displacements,
/// velocities and accelerations start a new line each. A line that would exceed 120 characters is wrapped before the number that does not
/// fit.
///
/// In the step of kind `input`, the values after the bodies are not grouped by entity: their first line has six values, each later line
/// seven.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Groups {
    breaks: Vec<bool>,
    bodies_end: usize,
}

impl Groups {
    /// Determines the positions of the line breaks from a catalogue.
    pub(crate) fn new(catalogue: &Catalogue) -> Self {
        let mut breaks = Vec::with_capacity(catalogue.len());
        let mut bodies_end = 1;
        let mut previous: Option<&super::Entity> = None;
        for (at, column) in catalogue.by_position().into_iter().enumerate() {
            let Some(column) = column else {
                breaks.push(at == 0);
                continue;
            };
            let entity = column.entity;
            let follows = previous.is_some_and(|before| std::ptr::eq(before, entity));
            let body = matches!(
                entity.ent_type.as_deref(),
                Some("Part" | "Point_Mass" | "Flexible_Body")
            );
            let order = body && matches!(column.component.name.as_str(), "VX" | "ACCX");
            if body {
                bodies_end = bodies_end.max(column.component.id);
            }
            breaks.push(!follows || order);
            previous = Some(entity);
        }
        Self { breaks, bodies_end }
    }

    /// Returns the number of values in a step.
    pub(crate) fn len(&self) -> usize {
        self.breaks.len()
    }

    /// Appends the lines of one output step to `out`. Each line ends with `line_end`, and `values` contains one value for each column.
    pub(crate) fn write(
        &self,
        out: &mut Vec<u8>,
        kind: StepKind,
        values: &[f64],
        style: NumberStyle,
        line_end: &[u8],
    ) {
        let mut column = 0;
        let mut number = Vec::with_capacity(32);
        for (at, &value) in values.iter().enumerate() {
            number.clear();
            write_number(&mut number, value, style);
            let new_line = if kind == StepKind::Input && at > self.bodies_end {
                (at - self.bodies_end + 1).is_multiple_of(7)
            } else {
                self.breaks.get(at).copied().unwrap_or(false)
            };
            if at == 0 {
                column = number.len();
            } else if new_line || column + 1 + number.len() > WIDTH {
                out.extend_from_slice(line_end);
                column = number.len();
            } else {
                out.push(b' ');
                column += 1 + number.len();
            }
            out.extend_from_slice(&number);
        }
        if !values.is_empty() {
            out.extend_from_slice(line_end);
        }
    }
}
