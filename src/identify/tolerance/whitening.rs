//! Transformation of the readings to independent rows.
//!
//! The mark coordinates of one part in one case share a small rigid-motion error that is not part of the motion of the axle. It comes from
//! fixtures, photogrammetry or temperature.
//!
//! Let `C` be the covariance of the coordinates and `D` their precision without this error. Then `D^1/2 C D^1/2 = I + tau_t^2 T T' + tau_r^2 R
//! R'`, where `tau_t` and `tau_r` are the standard deviations of translation and rotation. `T` holds the effect of the three translations. `R`
//! holds the effect of the three rotations, orthogonalised against the translations. An orthonormal basis of `T`, `R` and their complement
//! makes this matrix diagonal for all values of `tau_t` and `tau_r`.

use std::collections::BTreeMap;

use faer::linalg::matmul::matmul;
use faer::{Accum, Par};
use nalgebra::{DMatrix, DVector};

use super::class::{RotatedBlock, VarianceClass};
use super::free::without;
use super::group::{NoiseScale, VarianceComponents};
use super::product::{read, write};
use crate::settings::MARK_ROTATION_ROUND_OFF;
use admire_solver::mechanics::Vec3;
use admire_solver::mechanics::eigen::symmetric_eigen;

/// Rows of the mark coordinates of one part in one case.
#[derive(Clone, PartialEq, Debug)]
pub struct MarkBlock {
    /// Index of the first row of each mark. The rows of its other two coordinates follow.
    pub rows: Vec<usize>,
    /// Vector from a common point to each mark, in ground axes.
    pub levers: Vec<Vec3>,
    /// Length that corresponds to a row value of 1.
    pub unit: f64,
}

/// Transformation of readings to independent rows: scaling by the square roots of their precisions, then an orthonormal change of
/// directions. Each transformed row belongs to a variance class, a set of rows with equal variance.
#[derive(Clone, Debug)]
pub struct Whitening {
    /// Blocks of rows that are transformed together: the row indices and the transformation matrix of each block.
    blocks: Vec<(Vec<usize>, DMatrix<f64>)>,
    /// Rows that are transformed alone, each with the square root of its precision.
    alone: Vec<(usize, f64)>,
    /// Distinct variance classes (sets of rows with equal variance) of the transformed rows.
    pub classes: Vec<VarianceClass>,
    /// Index of the variance class of each transformed row; `None` if the row is not used.
    pub class_of: Vec<Option<usize>>,
    /// Indices of the transformed rows in each variance class, in ascending order.
    pub rows_of: Vec<Vec<usize>>,
    /// Location of each reading's row: the index of its block (`None` for a row transformed alone) and its position there. The whole entry
    /// is `None` if the row is not used.
    place_of: Vec<Option<(Option<usize>, usize)>>,
}

impl Whitening {
    /// Builds the transformation for blocks of marks, and for `single` rows with their noise scales.
    ///
    /// `precision` holds the precision of every row; it is zero for a row that is not used. Along the row directions listed in `free`, readings
    /// carry no weight.
    pub fn new(
        marks: &[MarkBlock],
        single: &[(usize, Option<NoiseScale>)],
        precision: &[f64],
        sizes: &VarianceComponents,
        free: &[Vec<(usize, f64)>],
    ) -> Self {
        let mut new = Self {
            blocks: Vec::new(),
            alone: Vec::new(),
            classes: Vec::new(),
            class_of: vec![None; precision.len()],
            rows_of: Vec::new(),
            place_of: vec![None; precision.len()],
        };
        let own = sizes.scale(NoiseScale::Marks);
        let rigid = |(turn, mu): &(bool, f64)| {
            let scale = [NoiseScale::PoseShift, NoiseScale::PoseTurn][usize::from(*turn)];
            Some((sizes.scale(scale)?, *mu))
        };
        let mut all = Vec::new();
        for block in marks {
            let (places, matrix, squares) = turned(block, precision);
            let of = |k: usize| Some(VarianceClass::new(own, squares.get(k).and_then(rigid)));
            all.push(RotatedBlock {
                classes: (0..places.len()).map(of).collect(),
                rigid: squares.len().min(places.len()),
                places,
                matrix,
            });
        }
        let mut alone = Vec::new();
        for (row, scale) in single {
            if precision[*row] > 0.0 {
                let scale = scale.and_then(|scale| sizes.scale(scale));
                alone.push((
                    *row,
                    precision[*row].sqrt(),
                    VarianceClass::new(scale, None),
                ));
            }
        }
        without(&mut all, &mut alone, free, &sizes.usual());
        let mut known = BTreeMap::new();
        let mut class = |classes: &mut Vec<VarianceClass>, class: VarianceClass| {
            *known.entry(class.key()).or_insert_with(|| {
                classes.push(class);
                classes.len() - 1
            })
        };
        for block in all {
            for (k, (place, own)) in block.places.iter().zip(block.classes).enumerate() {
                new.class_of[*place] = own.map(|own| class(&mut new.classes, own));
                new.place_of[*place] = Some((Some(new.blocks.len()), k));
            }
            new.blocks.push((block.places, block.matrix));
        }
        for (row, root, own) in alone {
            new.place_of[row] = Some((None, new.alone.len()));
            new.alone.push((row, root));
            new.class_of[row] = Some(class(&mut new.classes, own));
        }
        new.rows_of = vec![Vec::new(); new.classes.len()];
        for (row, class) in new.class_of.iter().enumerate() {
            if let Some(class) = class {
                new.rows_of[*class].push(row);
            }
        }
        new
    }

    /// Transforms the rows of a matrix. Rows that are not used become zero.
    pub fn apply(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let rows = columns.nrows();
        let mut out = DMatrix::zeros(rows, columns.ncols());
        if rows == 0 {
            return out;
        }
        let count = columns.ncols();
        for (places, matrix) in &self.blocks {
            let (Some(first), height) = (places.first(), places.len()) else {
                continue;
            };
            let follow = places
                .iter()
                .zip(*first..)
                .all(|(place, next)| *place == next);
            if follow {
                let block = read(columns).submatrix(*first, 0, height, count);
                let to = write(&mut out).submatrix_mut(*first, 0, height, count);
                matmul(to, Accum::Replace, read(matrix), block, 1.0, Par::Seq);
                continue;
            }
            let turned = matrix * columns.select_rows(places);
            for (k, place) in places.iter().enumerate() {
                out.set_row(*place, &turned.row(k));
            }
        }
        for (row, scale) in &self.alone {
            for (to, from) in out.row_mut(*row).iter_mut().zip(columns.row(*row).iter()) {
                *to = from * scale;
            }
        }
        out
    }

    /// Transforms a single column. Rows that are not used become zero.
    pub fn apply_vector(&self, column: &DVector<f64>) -> DVector<f64> {
        let out = self.apply(&DMatrix::from_column_slice(
            column.len(),
            1,
            column.as_slice(),
        ));
        out.column(0).into_owned()
    }

    /// Transforms a sparse column, given as pairs of row and value. The result maps transformed rows to values.
    pub fn apply_sparse(&self, column: &[(usize, f64)]) -> BTreeMap<usize, f64> {
        let mut out = BTreeMap::new();
        for (row, value) in column {
            match self.place_of[*row] {
                Some((Some(block), at)) => {
                    let (places, matrix) = &self.blocks[block];
                    for (k, place) in places.iter().enumerate() {
                        *out.entry(*place).or_insert(0.0) += matrix[(k, at)] * value;
                    }
                }
                Some((None, at)) => {
                    *out.entry(*row).or_insert(0.0) += self.alone[at].1 * value;
                }
                None => {}
            }
        }
        out
    }

    /// Returns the reciprocal standard deviation of each transformed row at the log standard deviations `ln`; zero for a row that is not
    /// used.
    pub fn weights(&self, ln: &[f64]) -> DVector<f64> {
        let of: Vec<f64> = self
            .classes
            .iter()
            .map(|class| class.variance(ln).sqrt().recip())
            .collect();
        DVector::from_iterator(
            self.class_of.len(),
            self.class_of
                .iter()
                .map(|class| class.map_or(0.0, |class| of[class])),
        )
    }
}

/// Returns the transformation of a block of marks: the rows that are used, the transformation matrix, and an entry for each rigid motion. The
/// matrix has one row per orthonormal direction, first those of rigid motions; its columns are multiplied by the square roots of the
/// precisions. An entry tells whether the motion is a rotation, and holds its squared norm before normalisation.
fn turned(block: &MarkBlock, precision: &[f64]) -> (Vec<usize>, DMatrix<f64>, Vec<(bool, f64)>) {
    let mut places = Vec::new();
    let mut rigid: Vec<[f64; 6]> = Vec::new();
    for (first, lever) in block.rows.iter().zip(&block.levers) {
        for axis in 0..3 {
            let root = precision[first + axis].sqrt();
            if root == 0.0 {
                continue;
            }
            places.push(first + axis);
            let mut row = [0.0; 6];
            row[axis] = root / block.unit;
            for k in 0..3 {
                row[3 + k] = Vec3::ith(k, 1.0).cross(lever)[axis] * root / block.unit;
            }
            rigid.push(row);
        }
    }
    let m = places.len();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut squares = Vec::new();
    let column = |k: usize| DVector::from_iterator(m, rigid.iter().map(|row| row[k]));
    for k in 0..3 {
        let shift = column(k);
        let norm = shift.norm();
        if norm > 0.0 {
            squares.push((false, norm * norm));
            basis.push(shift / norm);
        }
    }
    // Rotations, orthogonalised against the translations.
    let mut turns = DMatrix::zeros(m, 3);
    for k in 0..3 {
        let mut turn = column(3 + k);
        for shift in &basis {
            let along = shift.dot(&turn);
            turn.axpy(-along, shift, 1.0);
        }
        turns.set_column(k, &turn);
    }
    let eigen = symmetric_eigen(turns.tr_mul(&turns));
    let largest = eigen.eigenvalues.max();
    for k in 0..3 {
        let mu = eigen.eigenvalues[k];
        if mu > MARK_ROTATION_ROUND_OFF * largest && mu > 0.0 {
            let direction = &turns * eigen.eigenvectors.column(k) / mu.sqrt();
            squares.push((true, mu));
            basis.push(direction);
        }
    }
    // Orthogonal complement, by Gram-Schmidt with reorthogonalisation.
    for k in 0..m {
        if basis.len() >= m {
            break;
        }
        let mut unit = DVector::zeros(m);
        unit[k] = 1.0;
        for _ in 0..2 {
            for known in &basis {
                let along = known.dot(&unit);
                unit.axpy(-along, known, 1.0);
            }
        }
        let norm = unit.norm();
        if norm > 1e-3 {
            basis.push(unit / norm);
        }
    }
    let mut matrix = DMatrix::zeros(m, m);
    for (k, direction) in basis.iter().take(m).enumerate() {
        for (j, place) in places.iter().enumerate() {
            matrix[(k, j)] = direction[j] * precision[*place].sqrt();
        }
    }
    (places, matrix, squares)
}
