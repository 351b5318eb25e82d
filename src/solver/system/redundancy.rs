//! Detection of redundant constraint equations.

use std::ops::Range;

use nalgebra::DVectorView;

use super::System;
use crate::constraint::Constraint as _;
use crate::linear::{Matrix, Sink as _, dependent_columns};

/// Share of its length that a constraint row must keep after projection onto the complement of the earlier rows; otherwise the row is
/// redundant. Decks give angles and positions with about seven digits, so equations that agree within this rounding are dependent.
const REDUNDANT: f64 = 1e-6;

/// Share of its length that the row of a distance equation must keep after projection onto the complement of the earlier rows; otherwise
/// the equation is postponed. Other equations then constrain the same motion better, for example a rotation by a short lever.
const WEAK: f64 = 1e-3;

/// Number of multiplications above which orthogonalisation is abandoned and an elimination finds the redundant equations instead. The
/// elimination is fast for large mechanisms but chooses its own order of equations.
const LARGE: usize = 300_000_000;

/// Entries smaller than this, relative to the length of the row, are round-off. Components at remote ends of a mechanism fall below this
/// limit, so the stored rows stay short.
const NOTHING: f64 = 1e-16;

/// A row that keeps more than this share of its length after one pass is orthogonal to the other rows up to round-off.
const MOST: f64 = 0.7;

impl System {
    /// Returns which constraint equations depend on earlier ones.
    ///
    /// `entries` holds the gradients with respect to the part unknowns as (equation, unknown, derivative), in any order. The order of the
    /// equations follows real message files: distances come first, so that a dependent rotation is dropped rather than a distance
    /// (grammar/NOTES.md).
    pub(crate) fn redundant_rows(&self, entries: &[(u32, u32, f64)]) -> Vec<bool> {
        let columns = self.first_equation;
        let scale = self.column_lengths();
        let mut rows = vec![Vec::new(); self.equations];
        for &(row, column, value) in entries {
            rows[row as usize].push((column as usize, value / scale[column as usize]));
        }
        let mut basis = Basis::of(
            columns,
            self.bandwidth_reducing_order(&rows),
            self.equations,
        );
        let mut out = vec![false; self.equations];
        let [distances, products, others] = self.in_order();
        let mut weak = Vec::new();
        for row in distances {
            match basis.take(&rows[row], WEAK) {
                RowStatus::In => {}
                RowStatus::Nothing => out[row] = true,
                RowStatus::Dependent => weak.push(row),
            }
        }
        for row in products.into_iter().chain(weak).chain(others) {
            // An equation without any gradient cannot be satisfied by any reaction; the assembly reports it.
            out[row] = basis.take(&rows[row], REDUNDANT) != RowStatus::In;
        }
        if basis.given_up {
            return self.dependent_rows(&rows);
        }
        out
    }

    /// Finds the dependent rows by an elimination. It may drop other rows than [`Self::redundant_rows`] does. Both functions keep holonomic
    /// equations in preference to nonholonomic ones.
    fn dependent_rows(&self, rows: &[Vec<(usize, f64)>]) -> Vec<bool> {
        let mut out = self.dependent_among(rows, &self.is_nonholonomic);
        for equation in (0..self.equations).filter(|&k| self.is_nonholonomic[k]) {
            out[equation] = false;
            let mut whole = out.clone();
            whole[equation + 1..]
                .iter_mut()
                .zip(&self.is_nonholonomic[equation + 1..])
                .for_each(|(out, later)| *out |= later);
            // The rows kept so far are independent. If this row depends on them, the elimination finds one more dependent row.
            out[equation] = self.dependent_among(rows, &whole) != whole;
        }
        out
    }

    /// Returns which rows depend on other rows. The rows in `aside` are excluded and reported as dependent.
    fn dependent_among(&self, rows: &[Vec<(usize, f64)>], aside: &[bool]) -> Vec<bool> {
        let mut matrix = Matrix::new(self.equations.max(self.first_equation));
        for (equation, row) in rows.iter().enumerate().filter(|(k, _)| !aside[*k]) {
            for &(column, value) in row {
                matrix.add(column, equation, value);
            }
        }
        matrix.finish();
        let mut out = aside.to_vec();
        for equation in dependent_columns(&matrix.view()) {
            // The matrix is square and may have empty columns after the columns of the equations.
            if let Some(out) = out.get_mut(equation as usize) {
                *out = true;
            }
        }
        out
    }

    /// Returns the equations in the order in which they are processed, in three groups. The groups are: distances of joints; scalar
    /// products of joints, starting with the last product of each joint; all others, such as motions and couplers, with the nonholonomic
    /// equations last.
    fn in_order(&self) -> [Vec<usize>; 3] {
        let [mut distances, mut products] = [Vec::new(), Vec::new()];
        let mut other = vec![true; self.equations];
        for joint in &self.joints {
            let [term] = joint.terms.as_slice() else {
                continue;
            };
            for k in 0..joint.count {
                if term.law.equation_name(k).starts_with("D.") {
                    distances.push(joint.first + k);
                    other[joint.first + k] = false;
                }
            }
            for k in (0..joint.count).rev() {
                if term.law.equation_name(k).contains("i.") {
                    products.push(joint.first + k);
                    other[joint.first + k] = false;
                }
            }
        }
        // Holonomic equations come before nonholonomic ones. If two equations depend on each other, the one that constrains positions is
        // then kept.
        let (of_velocities, mut others): (Vec<usize>, Vec<usize>) = (0..self.equations)
            .filter(|&k| other[k])
            .partition(|&k| self.is_nonholonomic[k]);
        others.extend(of_velocities);
        [distances, products, others]
    }

    /// Returns the exchange class of every equation. Equations of one class may be dropped in place of each other. The scalar products of
    /// joints form one class, the distances another. All other equations have no class.
    pub(crate) fn exchangeable(&self) -> Vec<Option<u8>> {
        let mut kinds = vec![None; self.equations];
        let [distances, products, _] = self.in_order();
        for (kind, equations) in [(0, distances), (1, products)] {
            for equation in equations {
                kinds[equation] = Some(kind);
            }
        }
        kinds
    }

    /// Returns the length that corresponds to one unit of each body unknown: 1 for translations, the length scale of the model for
    /// rotations.
    fn column_lengths(&self) -> Vec<f64> {
        let mut out = vec![1.0; self.first_equation];
        for body in &self.bodies {
            for k in 3..body.freedoms.max(3) {
                out[body.first + k] = self.length;
            }
        }
        out
    }
}

/// Result of adding a row to the basis.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RowStatus {
    /// The row is independent of the earlier ones.
    In,
    /// The row depends on the earlier ones.
    Dependent,
    /// The row has no gradient.
    Nothing,
}

/// Orthonormal basis of the constraint rows. Each row is stored from its first to its last nonzero entry.
struct Basis {
    rows: Vec<(Range<usize>, Vec<f64>)>,
    /// Position of each column in the bandwidth-reducing order.
    order: Vec<usize>,
    /// Row that is currently being added.
    v: Vec<f64>,
    /// Total number of rows to be added.
    all: usize,
    /// Number of rows processed so far.
    came: usize,
    /// Number of multiplications so far.
    products: usize,
    /// Whether the work would exceed [`LARGE`]. No further row is then processed.
    given_up: bool,
}

impl Basis {
    /// Creates a basis for `all` rows with `columns` columns, stored in the given order.
    fn of(columns: usize, order: Vec<usize>, all: usize) -> Self {
        Self {
            rows: Vec::new(),
            order,
            v: vec![0.0; columns],
            all,
            came: 0,
            products: 0,
            given_up: false,
        }
    }

    /// Adds a row to the basis if it keeps more than `share` of its length after its projection onto the basis is subtracted.
    fn take(&mut self, row: &[(usize, f64)], share: f64) -> RowStatus {
        // Later rows need more multiplications than earlier rows, because they overlap with more rows.
        self.came += 1;
        let many = self.products / self.came > LARGE / self.all.max(1);
        self.given_up |= many && self.products > LARGE / 10;
        if self.given_up {
            return RowStatus::In;
        }
        let Self {
            rows,
            order,
            v,
            products,
            ..
        } = self;
        v.fill(0.0);
        for &(column, value) in row {
            v[order[column]] += value;
        }
        let mut within = support(v, 0.0);
        let before = norm(&v[within.clone()]);
        if before == 0.0 {
            return RowStatus::Nothing;
        }
        // Two passes of orthogonalisation suffice (Kahan). One pass suffices for a row that keeps most of its length.
        for _ in 0..2 {
            *products += rows.len();
            for (of, b) in rows.iter() {
                let common = within.start.max(of.start)..within.end.min(of.end);
                if common.is_empty() {
                    continue;
                }
                let its = &b[common.start - of.start..common.end - of.start];
                let mine = &v[common.clone()];
                *products += mine.len();
                let part = DVectorView::from_slice(mine, mine.len())
                    .dot(&DVectorView::from_slice(its, its.len()));
                if part.abs() <= NOTHING * before {
                    continue;
                }
                *products += b.len();
                for (x, y) in v[of.clone()].iter_mut().zip(b) {
                    *x -= part * y;
                }
                within = within.start.min(of.start)..within.end.max(of.end);
            }
            if norm(&v[within.clone()]) > MOST * before {
                break;
            }
        }
        let after = norm(&v[within.clone()]);
        if after < share * before {
            return RowStatus::Dependent;
        }
        let within = support(v, NOTHING * after);
        let unit = v[within.clone()].iter().map(|x| x / after);
        rows.push((within.clone(), unit.collect()));
        RowStatus::In
    }
}

/// Returns the range from the first to the last entry whose magnitude exceeds `nothing`.
fn support(v: &[f64], nothing: f64) -> Range<usize> {
    let first = v.iter().position(|x| x.abs() > nothing);
    let first = first.unwrap_or(v.len());
    let last = v.iter().rposition(|x| x.abs() > nothing);
    first..last.map_or(first, |k| k + 1)
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
