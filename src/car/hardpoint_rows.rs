//! Rows of displaced hardpoints.

use std::collections::{BTreeMap, BTreeSet};

use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Edit, Span, apply_edits};
use admire_syntax::units::{Dimension, Units};

use crate::block_edit::{line_end, whole_lines};
use crate::edit::{rounded, spelled, with_blanks};
use crate::file_units::{factor, length_word};
use crate::hardpoint::Hardpoint;
use crate::settings::SMALLEST_MOVE_MM;
use crate::side::{Side, Symmetry};
use crate::subsystem::Subsystem;
use crate::word_change::WordChange;

/// Displacement of a hardpoint on one side of the vehicle.
#[derive(Clone, PartialEq, Debug)]
pub struct HardpointMove {
    /// Index among the hardpoints of the subsystem.
    pub hardpoint: usize,
    /// Side that moved.
    pub side: Side,
    /// Displacement along x, y and z in the length unit of the deck.
    pub by: [f64; 3],
    /// Standard errors of the displacement, if known.
    pub std_error: [Option<f64>; 3],
    /// Origin of the displacement, such as `hardpoint-error MARKER/7`.
    pub because: String,
}

/// Returns the edits of all hardpoint rows, and adds the changes to the list.
pub(crate) fn move_hardpoints(
    subsystem: &Subsystem,
    units: &Units,
    in_deck: &BTreeSet<(usize, Side)>,
    moves: &[HardpointMove],
    words: &mut Vec<WordChange>,
) -> Vec<Edit> {
    let mut of: BTreeMap<usize, Vec<&HardpointMove>> = BTreeMap::new();
    for one in moves {
        of.entry(one.hardpoint).or_default().push(one);
    }
    let scale = factor(&subsystem.file, Dimension::LENGTH, units);
    let row = RowEdit {
        file: &subsystem.file,
        scale,
        smallest: SMALLEST_MOVE_MM * 1e-3 / (units.length.si * scale),
        unit: length_word(&subsystem.file, units),
    };
    let mut edits = Vec::new();
    for (at, moves) in of {
        let Some(point) = subsystem.hardpoints.get(at) else {
            continue;
        };
        let by = |side: Side| moves.iter().copied().find(|one| one.side == side);
        if point.symmetry != Symmetry::Pair {
            let side = point.symmetry.sides()[0];
            if let Some(one) = by(side) {
                edits.extend(row.one_row(point, one, side, words));
            }
            continue;
        }
        let both = [Side::Left, Side::Right].map(|side| in_deck.contains(&(at, side)));
        match (by(Side::Left), by(Side::Right)) {
            (Some(left), Some(right)) if !row.are_mirrored(left, right) => {
                edits.push(row.two_rows(point, [Some(left), Some(right)], words));
            }
            (Some(left), None) if both[1] => {
                edits.push(row.two_rows(point, [Some(left), None], words));
            }
            (None, Some(right)) if both[0] => {
                edits.push(row.two_rows(point, [None, Some(right)], words));
            }
            (Some(left), _) => {
                edits.extend(row.one_row(point, left, Side::Left, words));
            }
            (None, Some(right)) => {
                edits.extend(row.one_row(point, right, Side::Right, words));
            }
            (None, None) => {}
        }
    }
    edits
}

/// Edits of the rows of hardpoints.
struct RowEdit<'a> {
    file: &'a PropertyFile,
    /// Factor from the length unit of the file to the length unit of the deck.
    scale: f64,
    /// Smallest change of a coordinate that is written, in the unit of the file.
    smallest: f64,
    unit: String,
}

impl RowEdit<'_> {
    /// Returns true if the displacement on the right side is the mirror image of the displacement on the left side.
    fn are_mirrored(&self, left: &HardpointMove, right: &HardpointMove) -> bool {
        let mirror = [1.0, -1.0, 1.0];
        (0..3).all(|k| (left.by[k] - mirror[k] * right.by[k]).abs() <= self.smallest * self.scale)
    }

    /// Returns the new coordinate of an axis and its text; `None` if it does not change.
    fn coordinate(&self, old: f64, by: f64, style: &[u8]) -> Option<(f64, String)> {
        let by = by / self.scale;
        if !by.is_finite() || by.abs() <= self.smallest {
            return None;
        }
        let new = rounded(old + by);
        Some((new, spelled(new, style)))
    }

    /// Changes the coordinates of a row that remains a single row.
    fn one_row(
        &self,
        point: &Hardpoint,
        one: &HardpointMove,
        side: Side,
        out: &mut Vec<WordChange>,
    ) -> Vec<Edit> {
        // The row of a pair holds the left side.
        let mirrored = point.symmetry == Symmetry::Pair && side == Side::Right;
        let (named, symmetry) = match point.symmetry {
            Symmetry::Pair => (Side::Left, "left/right"),
            Symmetry::Left => (Side::Left, "left"),
            Symmetry::Right => (Side::Right, "right"),
            Symmetry::Single => (Side::Single, "single"),
        };
        let mut edits = Vec::new();
        for (k, number) in point.coordinates.iter().enumerate() {
            let by = if mirrored && k == 1 {
                -one.by[k]
            } else {
                one.by[k]
            };
            let style = self.file.source().slice(number.span);
            if let Some((_, text)) = self.coordinate(number.value, by, style) {
                out.push(self.word((point, named, symmetry), k, number.value, &text, one));
                edits.push(Edit::new(number.span, text));
            }
        }
        edits
    }

    /// Replaces the row of a pair by one row for the left side and one for the right side.
    fn two_rows(
        &self,
        point: &Hardpoint,
        moves: [Option<&HardpointMove>; 2],
        out: &mut Vec<WordChange>,
    ) -> Edit {
        let bytes = self.file.source().bytes();
        let line = whole_lines(bytes, point.row);
        let mut rows = Vec::new();
        for ((side, word), one) in [(Side::Left, "left"), (Side::Right, "right")]
            .into_iter()
            .zip(moves)
        {
            let old = point.place(side).unwrap_or_default();
            let width = point.symmetry_span.len();
            let mut edits = vec![Edit::new(point.symmetry_span, with_blanks(word, width))];
            for (k, number) in point.coordinates.iter().enumerate() {
                let style = self.file.source().slice(number.span);
                let moved = one.and_then(|one| self.coordinate(old[k], one.by[k], style));
                if let (Some((_, text)), Some(one)) = (&moved, one) {
                    out.push(self.word((point, side, word), k, old[k], text, one));
                }
                let text = match moved {
                    Some((_, text)) => text,
                    None if old[k].to_bits() == number.value.to_bits() => continue,
                    None => spelled(old[k], style),
                };
                edits.push(Edit::new(number.span, text));
            }
            for edit in &mut edits {
                edit.span = Span::new(
                    edit.span.start() - line.start(),
                    edit.span.end() - line.start(),
                );
            }
            if !rows.is_empty() {
                rows.extend_from_slice(line_end(bytes, line.end()));
            }
            rows.extend(apply_edits(&bytes[line.range()], &edits).unwrap_or_default());
        }
        Edit::new(line, rows)
    }

    fn word(
        &self,
        (point, side, symmetry): (&Hardpoint, Side, &'static str),
        axis: usize,
        before: f64,
        after: &str,
        one: &HardpointMove,
    ) -> WordChange {
        WordChange {
            element: point.full_name(side),
            symmetry,
            factor: ["x", "y", "z"][axis].to_string(),
            before: format!("{before}"),
            after: after.to_string(),
            unit: self.unit.clone(),
            std_error: one.std_error[axis].map(|error| error / self.scale),
            because: one.because.clone(),
        }
    }
}
