//! Removal of the directions in the space of rows along which readings carry no information.
//!
//! A free (zero-stiffness) motion moves the readings of its case along a direction `s` in the space of rows. Its amount is unknown, so errors
//! along `s` have infinite variance. The rows are transformed so that one new row is the component along `s`, and this row is dropped.
//!
//! Orthogonal to `s`, the remaining rigid-motion rows are no longer independent. They are replaced by the eigenvectors of their covariance,
//! computed at the prior medians of the variance components. At other values of the variance components, the variance of each row is exact, but
//! covariances between rows are neglected.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::DMatrix;

use super::class::{RotatedBlock, VarianceClass};
use crate::settings::{FREE_DIRECTION_ROUND_OFF, VARIANCE_TERM_ROUND_OFF};
use admire_solver::mechanics::eigen::symmetric_eigen;

/// Removes the row directions listed in `free`. All blocks and single rows that one direction involves are merged into one block. `usual` holds
/// the log standard deviations at the prior medians.
pub(super) fn without(
    blocks: &mut Vec<RotatedBlock>,
    alone: &mut Vec<(usize, f64, VarianceClass)>,
    free: &[Vec<(usize, f64)>],
    usual: &[f64],
) {
    if free.is_empty() {
        return;
    }
    let moved: BTreeSet<usize> = free.iter().flatten().map(|(row, _)| *row).collect();
    alone.retain(|(row, root, class)| {
        let is_moved = moved.contains(row);
        if is_moved {
            blocks.push(RotatedBlock {
                places: vec![*row],
                matrix: DMatrix::from_element(1, 1, *root),
                rigid: 1,
                classes: vec![Some(class.clone())],
            });
        }
        !is_moved
    });
    let mut block_of = BTreeMap::new();
    for (k, block) in blocks.iter().enumerate() {
        block_of.extend(block.places.iter().map(|place| (*place, k)));
    }
    // Group of each block, identified by the first block of the group. Blocks that share a free direction form a group.
    let mut with: Vec<usize> = (0..blocks.len()).collect();
    let reached: Vec<BTreeSet<usize>> = free
        .iter()
        .map(|direction| {
            let rows = direction.iter();
            rows.filter_map(|(row, _)| block_of.get(row).copied())
                .collect()
        })
        .collect();
    for reached in &reached {
        let groups: BTreeSet<usize> = reached.iter().map(|k| with[*k]).collect();
        let Some(&first) = groups.first() else {
            continue;
        };
        for group in &mut with {
            if groups.contains(group) {
                *group = first;
            }
        }
    }
    let mut groups: BTreeMap<usize, (Vec<RotatedBlock>, Vec<usize>)> = BTreeMap::new();
    for (block, group) in blocks.drain(..).zip(&with) {
        groups.entry(*group).or_default().0.push(block);
    }
    for (direction, reached) in reached.iter().enumerate() {
        if let Some(first) = reached.first()
            && let Some(group) = groups.get_mut(&with[*first])
        {
            group.1.push(direction);
        }
    }
    for (_, (mut own, directions)) in groups {
        if directions.is_empty() {
            blocks.append(&mut own);
        } else {
            let directions = directions.iter().map(|k| free[*k].as_slice());
            blocks.push(turned(&joined(own), directions, usual));
        }
    }
}

/// Merges several blocks into one, with the rigid-motion directions of all blocks first.
fn joined(blocks: Vec<RotatedBlock>) -> RotatedBlock {
    let count = blocks.iter().map(|block| block.places.len()).sum();
    let rigid = blocks.iter().map(|block| block.rigid).sum();
    let mut out = RotatedBlock {
        places: Vec::with_capacity(count),
        matrix: DMatrix::zeros(count, count),
        rigid,
        classes: vec![None; count],
    };
    let (mut next, mut rest) = (0, rigid);
    for block in blocks {
        let column = out.places.len();
        for (k, class) in block.classes.into_iter().enumerate() {
            let row = if k < block.rigid {
                &mut next
            } else {
                &mut rest
            };
            out.matrix
                .view_mut((*row, column), (1, block.places.len()))
                .copy_from(&block.matrix.row(k));
            out.classes[*row] = class;
            *row += 1;
        }
        out.places.extend(block.places);
    }
    out
}

/// Rotates the rigid-motion directions of a block so that the free directions come first, and declares the rows of the free directions unused.
fn turned<'a>(
    block: &RotatedBlock,
    free: impl Iterator<Item = &'a [(usize, f64)]>,
    usual: &[f64],
) -> RotatedBlock {
    let rigid = block.matrix.rows(0, block.rigid);
    let at: BTreeMap<usize, usize> = block.places.iter().copied().zip(0..).collect();
    // Components of each free direction along the rigid-motion directions of the block.
    let columns: Vec<_> = free
        .map(|direction| {
            let mut own = nalgebra::DVector::zeros(block.places.len());
            for (row, value) in direction {
                if let Some(k) = at.get(row) {
                    own[*k] = *value;
                }
            }
            rigid * own
        })
        .collect();
    let free = DMatrix::from_columns(&columns);
    let eigen = symmetric_eigen(&free * free.transpose());
    let least = FREE_DIRECTION_ROUND_OFF * eigen.eigenvalues.max();
    let (left_out, rest): (Vec<usize>, Vec<usize>) =
        (0..block.rigid).partition(|k| eigen.eigenvalues[*k] > least);
    let (left_out, rest) = (
        eigen.eigenvectors.select_columns(&left_out),
        eigen.eigenvectors.select_columns(&rest),
    );
    let variance = |k: usize| {
        block.classes[k]
            .as_ref()
            .map_or(1.0, |class| class.variance(usual))
    };
    let diagonal = DMatrix::from_fn(block.rigid, block.rigid, |i, j| {
        if i == j { variance(i) } else { 0.0 }
    });
    let directions = if rest.is_empty() {
        rest
    } else {
        let own = symmetric_eigen(rest.transpose() * &diagonal * &rest).eigenvectors;
        rest * own
    };
    let mut out = RotatedBlock {
        places: block.places.clone(),
        matrix: block.matrix.clone(),
        rigid: block.rigid,
        classes: block.classes.clone(),
    };
    let unused = left_out.ncols();
    out.matrix
        .rows_mut(0, unused)
        .copy_from(&(left_out.transpose() * rigid));
    out.matrix
        .rows_mut(unused, directions.ncols())
        .copy_from(&(directions.transpose() * rigid));
    out.classes[..unused].fill(None);
    for (k, direction) in directions.column_iter().enumerate() {
        let shares = direction.iter().map(|x| x * x);
        let pairs: Vec<(f64, &VarianceClass)> =
            shares.zip(block.classes.iter().flatten()).collect();
        out.classes[unused + k] = Some(mixed(&pairs, usual));
    }
    out
}

/// Returns the variance class of a linear combination of independent rows. `parts` holds the squared coefficient and the class of each row.
fn mixed(parts: &[(f64, &VarianceClass)], usual: &[f64]) -> VarianceClass {
    let known: f64 = parts.iter().map(|(share, class)| share * class.known).sum();
    let mut terms: BTreeMap<usize, f64> = BTreeMap::new();
    for (share, class) in parts {
        for (at, mu) in class.terms.iter() {
            *terms.entry(*at).or_default() += share * mu;
        }
    }
    let size = |at: usize| libm::exp(2.0 * usual[at]);
    let whole = known + terms.iter().map(|(at, mu)| mu * size(*at)).sum::<f64>();
    terms.retain(|at, mu| *mu * size(*at) > VARIANCE_TERM_ROUND_OFF * whole);
    // Coefficients that are one except for round-off are set to one.
    let settled = |x: f64| {
        if (x - 1.0).abs() < VARIANCE_TERM_ROUND_OFF {
            1.0
        } else {
            x
        }
    };
    VarianceClass {
        known: if known > VARIANCE_TERM_ROUND_OFF * whole {
            settled(known)
        } else {
            0.0
        },
        terms: terms
            .into_iter()
            .map(|(at, mu)| (at, settled(mu)))
            .collect::<Arc<[_]>>(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DVector};

    use super::super::group::{NoiseScale, VarianceComponents};
    use super::super::whitening::{MarkBlock, Whitening};
    use super::*;
    use admire_solver::mechanics::Vec3;
    use admire_study::ToleranceSettings;
    use admire_study::noise::Noise;

    /// At the prior medians, the transformed rows must have the density of the original rows with infinite variance along the free directions.
    /// Tested are one part that spins, and two parts that spin together with a channel that measures the spin.
    #[test]
    fn nothing_along_a_free_direction_counts() {
        let mut sizes = VarianceComponents::new(&ToleranceSettings::default(), 0.0, [0.0; 2], 1.0);
        sizes.add_scale(NoiseScale::Channel(0), true);
        let mut noise = Noise::new(5, "free directions");
        let mut block = |first: usize| MarkBlock {
            rows: (0..4).map(|k| first + 3 * k).collect(),
            levers: (0..4)
                .map(|_| Vec3::from_fn(|_, _| 100.0 * noise.normal()))
                .collect(),
            unit: 0.03,
        };
        let blocks = [block(0), block(12), block(24)];
        let single = [(36, Some(NoiseScale::Channel(0)))];
        let axis = Vec3::new(0.3, -0.8, 0.5).normalize();
        let through = Vec3::new(10.0, -4.0, 7.0);
        let spin = |block: &MarkBlock| {
            let marks = block.rows.iter().zip(&block.levers);
            let rows =
                marks.map(|(row, lever)| (*row, axis.cross(&(lever - through)) / block.unit));
            let each = rows.flat_map(|(row, by)| (0..3).map(move |k| (row + k, by[k])));
            each.collect::<Vec<_>>()
        };
        let alone = spin(&blocks[0]);
        let mut together = [spin(&blocks[1]), spin(&blocks[2])].concat();
        together.push((36, 40.0));
        let free = [alone, together];
        let precision = vec![1.0; 37];
        let whitening = Whitening::new(&blocks, &single, &precision, &sizes, &free);
        let residual = DVector::from_fn(37, |_, _| noise.normal());

        let size = |scale| libm::exp(2.0 * sizes.ln[sizes.scale(scale).unwrap()]);
        let mut C = DMatrix::identity(37, 37);
        C[(36, 36)] = size(NoiseScale::Channel(0));
        for block in &blocks {
            let (mut T, mut R) = (DMatrix::zeros(37, 3), DMatrix::zeros(37, 3));
            for (row, lever) in block.rows.iter().zip(&block.levers) {
                for axis in 0..3 {
                    T[(row + axis, axis)] = 1.0 / block.unit;
                    for k in 0..3 {
                        let by = Vec3::ith(k, 1.0).cross(lever)[axis];
                        R[(row + axis, k)] = by / block.unit;
                    }
                }
            }
            // Rotations, orthogonalised against the translations.
            let shares = (T.tr_mul(&T)).try_inverse().unwrap() * T.tr_mul(&R);
            let R = R - &T * shares;
            C += size(NoiseScale::PoseShift) * &T * T.transpose();
            C += size(NoiseScale::PoseTurn) * &R * R.transpose();
        }
        let density = |z: &DVector<f64>| {
            let weights = whitening.weights(&sizes.ln);
            let z = whitening.apply_vector(z).component_mul(&weights);
            -0.5 * z.norm_squared()
        };
        // The exact density has infinite variance along the free directions.
        let mut F = DMatrix::zeros(37, 2);
        for (k, direction) in free.iter().enumerate() {
            for (row, value) in direction {
                F[(*row, k)] = *value;
            }
        }
        let factor = Cholesky::new(C).unwrap();
        let P = factor.inverse();
        let across =
            &P - &P * &F * (F.tr_mul(&(&P * &F))).try_inverse().unwrap() * F.transpose() * &P;
        let exact = |z: &DVector<f64>| -0.5 * z.dot(&(&across * z));
        let moved = &residual + &F * DVector::from_vec(vec![3.0, -50.0]);
        for z in [&residual, &moved] {
            // Variances that differ by a few percent share a class, so the densities agree only approximately.
            assert!((density(z) - exact(z)).abs() < 1e-3 * exact(z).abs());
        }
        assert!((density(&moved) - density(&residual)).abs() < 1e-6);
        let used = whitening.class_of.iter().flatten().count();
        assert_eq!(used, 35);
    }
}
