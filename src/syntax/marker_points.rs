//! Update of the points ZP and XP, which define the axes of a marker, when the marker moves.

use std::collections::{BTreeMap, BTreeSet};

use super::{Address, Dataset, Statement};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::Edit;

/// Arguments of a MARKER that give a point on its z axis and a point in its x-z plane, in the same frame as QP (`state_marker`).
const POINTS: [&str; 2] = ["ZP", "XP"];

impl Dataset {
    /// Returns the edits that shift ZP and XP of a marker by the change of its QP, so that the marker keeps its orientation.
    ///
    /// `values` are the new values of QP, beginning with the addressed component. A point whose address is in `beside` gets its own value
    /// and is not shifted. If `address` is not the QP of a marker, there are no edits.
    ///
    /// # Errors
    /// Returns the errors of [`Dataset::set`].
    pub(super) fn move_points(
        &self,
        address: &Address,
        values: &[f64],
        beside: &BTreeSet<&Address>,
    ) -> Result<Vec<Edit>, Diagnostic> {
        let mut edits = Vec::new();
        if !moves_marker(address) {
            return Ok(edits);
        }
        let first = address.index.unwrap_or(1);
        for (k, value) in values.iter().enumerate() {
            let component = |name: &str| Address {
                argument: Some(name.to_string()),
                index: Some(first + k),
                ..address.clone()
            };
            let Some(old) = self.value_at(&component("QP")) else {
                continue;
            };
            for point in POINTS.map(component) {
                let whole = Address {
                    index: None,
                    ..point.clone()
                };
                let number = self.number_at(&point);
                if let Some(number) = number
                    && ![&point, &whole].iter().any(|given| beside.contains(given))
                {
                    let moved = number.value + (value - old);
                    edits.extend(self.set_alone(&point, fifteen_digits(moved))?);
                }
            }
        }
        Ok(edits)
    }
}

/// Points QP, ZP and XP of all markers in a deck whose axes are given by points; the key is the marker id.
#[derive(Clone, Debug)]
pub struct MarkerPoints(BTreeMap<u32, [Option<Point>; 3]>);

type Point = [f64; 3];

impl MarkerPoints {
    /// Collects the marker points of a deck.
    pub fn of(dataset: &Dataset) -> Self {
        let place = |marker: &Statement, name: &str| match marker.numbers(name) {
            [x, y, z] => Some([x.value, y.value, z.value]),
            _ => None,
        };
        let markers = dataset.statements().iter().filter(|marker| {
            marker.kind() == Some("MARKER") && POINTS.iter().any(|name| marker.has(name))
        });
        let each = |marker: &Statement| {
            let origin = place(marker, "QP").unwrap_or_default();
            let [z, x] = POINTS.map(|name| place(marker, name));
            Some((marker.number()?, [Some(origin), z, x]))
        };
        Self(markers.filter_map(each).collect())
    }

    /// Compares these marker points with the marker points of the changed deck.
    ///
    /// Returns a note for each moved marker whose points moved along, and a warning for each moved marker that rotates.
    pub fn moved(&self, after: &Dataset) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        for (id, [origin, points @ ..]) in Self::of(after).0 {
            let Some([old_origin, old_points @ ..]) = self.0.get(&id) else {
                continue;
            };
            let shift = difference(&origin.unwrap_or_default(), &old_origin.unwrap_or_default());
            if shift == Point::default() {
                continue;
            }
            let follows = |(new, old): (&Option<Point>, &Option<Point>)| match (new, old) {
                (Some(new), Some(old)) => {
                    let left = difference(&difference(new, old), &shift);
                    largest(&left) <= ROUND_OFF * (largest(new) + largest(old))
                }
                (new, old) => new == old,
            };
            found.push(if points.iter().zip(old_points).all(follows) {
                Diagnostic::note(
                    Code::MarkerPoints,
                    format!(
                        "MARKER/{id} keeps its orientation: ZP and XP were moved along with QP"
                    ),
                )
            } else {
                Diagnostic::warning(
                    Code::MarkerPoints,
                    format!("MARKER/{id} rotates: QP was moved, but ZP and XP were not"),
                )
            });
        }
        found
    }
}

/// Relative rounding error in a sum of decimal numbers with fifteen digits.
const ROUND_OFF: f64 = 1e-14;

fn difference(a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| a[k] - b[k])
}

fn largest(point: &Point) -> f64 {
    point.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Returns true if the address refers to the origin QP of a marker.
fn moves_marker(address: &Address) -> bool {
    address.kind == "MARKER" && address.argument.as_deref() == Some("QP")
}

/// Rounds a value to fifteen digits, because sums of decimal numbers are not exact in binary.
fn fifteen_digits(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}
