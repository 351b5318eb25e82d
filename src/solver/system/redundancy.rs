//! Constraint equations that say nothing new.

use std::ops::Range;

use nalgebra::DVectorView;

use super::System;
use crate::constraint::Constraint as _;
use crate::linear::{Matrix, Sink as _, dependent_columns};

/// A constraint row that keeps less than this of its length when its share in the rows before is taken off is redundant. Decks give angles
/// and places with about seven digits: equations that agree within their rounding are dependent.
const REDUNDANT: f64 = 1e-6;

/// A distance that keeps less than this holds what other equations hold better: a rotation by a short lever.
const WEAK: f64 = 1e-3;

/// Beyond so many products an elimination finds redundant equations: fast in large mechanisms, and in an order of its own.
const LARGE: usize = 300_000_000;

/// What is smaller than this beside a row is its round-off. Shares of far ends of a mechanism are: without them the rows stay short.
const NOTHING: f64 = 1e-16;

/// A row that keeps more than this of its length is orthogonal to the others but for round-off.
const MOST: f64 = 0.7;

impl System {
    /// Which constraint equations depend on those before them, from the entries of their gradients by the parts: (equation, freedom,
    /// derivative), those of one equation in the order of the freedoms or not. The order is that of real message files: distances
    /// come first, so that a dependent rotation is left out rather than a distance (grammar/NOTES.md).
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
                Taken::In => {}
                Taken::Nothing => out[row] = true,
                Taken::Dependent => weak.push(row),
            }
        }
        for row in products.into_iter().chain(weak).chain(others) {
            // An equation without any gradient cannot be held by anything; the assembly reports it.
            out[row] = basis.take(&rows[row], REDUNDANT) != Taken::In;
        }
        if basis.given_up {
            return self.dependent_rows(&rows);
        }
        out
    }

    /// The same by an elimination, which may take out others; again what holds places goes before what holds velocities.
    fn dependent_rows(&self, rows: &[Vec<(usize, f64)>]) -> Vec<bool> {
        let mut out = self.dependent_among(rows, &self.is_nonholonomic);
        for equation in (0..self.equations).filter(|&k| self.is_nonholonomic[k]) {
            out[equation] = false;
            let mut whole = out.clone();
            whole[equation + 1..]
                .iter_mut()
                .zip(&self.is_nonholonomic[equation + 1..])
                .for_each(|(out, later)| *out |= later);
            // Those before depend on none of each other: with one more that does, one is left over.
            out[equation] = self.dependent_among(rows, &whole) != whole;
        }
        out
    }

    /// Which rows depend on others, those left aside among them.
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
            // The matrix is square: columns behind the equations are empty.
            if let Some(out) = out.get_mut(equation as usize) {
                *out = true;
            }
        }
        out
    }

    /// The equations in the order in which they are taken: distances of joints; scalar products of joints, the last of each joint first;
    /// all others, as motions and couplers, at last those of velocities.
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
        // What holds places goes before what holds velocities: that one of both is left out that leaves the places as they are.
        let (of_velocities, mut others): (Vec<usize>, Vec<usize>) = (0..self.equations)
            .filter(|&k| other[k])
            .partition(|&k| self.is_nonholonomic[k]);
        others.extend(of_velocities);
        [distances, products, others]
    }

    /// Of every equation the kind of those that may be left out in its place: scalar products of joints for each other, and distances; none of
    /// the others.
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

    /// What one unit of each body unknown moves: 1 for translations, the length of the model for rotations.
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

/// What came of a row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Taken {
    /// It says something new.
    In,
    /// It follows from those taken before.
    Dependent,
    /// It has no gradient.
    Nothing,
}

/// Orthonormal rows, each from the first to the last of its numbers that is not zero.
struct Basis {
    rows: Vec<(Range<usize>, Vec<f64>)>,
    /// Where each column stands.
    order: Vec<usize>,
    /// The row that is taken in.
    v: Vec<f64>,
    /// How many rows are to come in all, and how many came.
    all: usize,
    came: usize,
    /// How many products were made.
    products: usize,
    /// It would take more than [`LARGE`]: nothing is looked at any more.
    given_up: bool,
}

impl Basis {
    /// Of rows with so many columns in an order.
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

    /// Takes a row in that keeps more than a share of its length when its part in the basis is taken off.
    fn take(&mut self, row: &[(usize, f64)], share: f64) -> Taken {
        // Later rows take more products than those before, which more of the others overlap.
        self.came += 1;
        let many = self.products / self.came > LARGE / self.all.max(1);
        self.given_up |= many && self.products > LARGE / 10;
        if self.given_up {
            return Taken::In;
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
            return Taken::Nothing;
        }
        // Twice is enough (Kahan), and once for a row that keeps most of its length.
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
            return Taken::Dependent;
        }
        let within = support(v, NOTHING * after);
        let unit = v[within.clone()].iter().map(|x| x / after);
        rows.push((within.clone(), unit.collect()));
        Taken::In
    }
}

/// From the first to the last number that is larger than this.
fn support(v: &[f64], nothing: f64) -> Range<usize> {
    let first = v.iter().position(|x| x.abs() > nothing);
    let first = first.unwrap_or(v.len());
    let last = v.iter().rposition(|x| x.abs() > nothing);
    first..last.map_or(first, |k| k + 1)
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
