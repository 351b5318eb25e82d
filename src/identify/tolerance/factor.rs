//! Cholesky factor of a symmetric positive definite matrix, computed by the library faer. Errors of single load cases form blocks that are
//! factorised separately.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::{Accum, Auto, Par, Spec};
use nalgebra::{DMatrix, DVector};

use super::product::{dot, gram, read, transposed, write};

/// Factorisation of a symmetric positive definite matrix `M`. Some unknowns, such as errors of single load cases, may form blocks. Unknowns
/// of different blocks are coupled only through the unknowns outside of all blocks, the rest. The blocks are eliminated first; the rest
/// then costs as much as a matrix without blocks.
///
/// Let block `i` have the matrix `D = F F'`, and let `B` be its coupling with the rest. With `W = F^-1 B`, the rest has the Schur complement
/// `S = M_rest - sum W'W = L L'`.
///
/// Source: Golub and Van Loan, Matrix Computations, section 4.3 (block arrow matrices).
#[derive(Clone, Debug)]
pub struct Factor {
    blocks: Vec<BlockFactor>,
    /// Indices of the unknowns outside of all blocks.
    rest: Vec<usize>,
    /// Cholesky factor of the Schur complement. Entries above the diagonal are undefined.
    L: DMatrix<f64>,
    /// Number of unknowns.
    count: usize,
}

/// Factor of one block.
#[derive(Clone, Debug)]
struct BlockFactor {
    /// Indices of its unknowns.
    own: Vec<usize>,
    /// Cholesky factor of its matrix. Entries above the diagonal are undefined.
    F: DMatrix<f64>,
    /// `F^-1 B`, with one column per unknown of the rest.
    W: DMatrix<f64>,
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; `None` if the matrix is not positive definite.
fn cholesky(M: &mut DMatrix<f64>) -> Option<()> {
    let params: Spec<llt::factor::LltParams, f64> = Spec::new(Auto::<f64>::auto());
    let n = M.nrows();
    let mut memory = MemBuffer::new(llt::factor::cholesky_in_place_scratch(n, Par::Seq, params));
    llt::factor::cholesky_in_place(
        write(M),
        llt::factor::LltRegularization::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        params,
    )
    .ok()?;
    (0..n)
        .all(|k| M[(k, k)] > 0.0 && M[(k, k)].is_finite())
        .then_some(())
}

/// Computes the inverse of a lower triangular matrix.
fn inverse_of(L: &DMatrix<f64>) -> DMatrix<f64> {
    let n = L.nrows();
    let mut V = DMatrix::<f64>::zeros(n, n);
    invert_lower_triangular(write(&mut V), read(L), Par::Seq);
    V
}

/// Computes the lower triangle of `(L L')^-1`; entries above the diagonal are zero.
fn inverse_of_product(L: &DMatrix<f64>) -> DMatrix<f64> {
    let n = L.nrows();
    let mut out = DMatrix::<f64>::zeros(n, n);
    let V = inverse_of(L);
    let V = read(&V);
    triangular::matmul(
        write(&mut out),
        BlockStructure::TriangularLower,
        Accum::Replace,
        V.transpose(),
        BlockStructure::TriangularUpper,
        V,
        BlockStructure::TriangularLower,
        1.0,
        Par::Seq,
    );
    out
}

/// Solves `L x = b` in place.
fn forward(L: &DMatrix<f64>, x: &mut [f64]) {
    let n = x.len();
    for k in 0..n {
        let column = &L.as_slice()[k * n..(k + 1) * n];
        let value = x[k] / column[k];
        x[k] = value;
        for (x, l) in x[k + 1..].iter_mut().zip(&column[k + 1..]) {
            *x -= value * l;
        }
    }
}

/// Solves `L'x = b` in place.
fn backward(L: &DMatrix<f64>, x: &mut [f64]) {
    let n = x.len();
    for k in (0..n).rev() {
        let column = &L.as_slice()[k * n..(k + 1) * n];
        let sum = dot(&x[k + 1..], &column[k + 1..]);
        x[k] = (x[k] - sum) / column[k];
    }
}

/// Computes `|L'v|^2`, with `further` added to `L'v`.
fn norm_squared(L: &DMatrix<f64>, v: &[f64], further: &[f64]) -> f64 {
    let n = v.len();
    let of = |k: usize| {
        let column = &L.as_slice()[k * n..(k + 1) * n];
        dot(&column[k..], &v[k..]) + further[k]
    };
    (0..n).map(|k| of(k).powi(2)).sum()
}

impl Factor {
    /// Factorises the symmetric matrix `M`, of which only the lower triangle is read. Returns `None` if `M` is not positive definite.
    pub fn new(M: DMatrix<f64>) -> Option<Self> {
        Self::with_blocks(M, &[])
    }

    /// Factorises the symmetric matrix `M`, of which only the lower triangle is read. `blocks` lists unknowns that are coupled only with those of
    /// the same block and with the rest; other entries are not read. Returns `None` if `M` is not positive definite.
    pub fn with_blocks(mut M: DMatrix<f64>, blocks: &[Vec<usize>]) -> Option<Self> {
        let count = M.nrows();
        let mut is_rest = vec![true; count];
        for k in blocks.iter().flatten() {
            is_rest[*k] = false;
        }
        let rest: Vec<usize> = (0..count).filter(|k| is_rest[*k]).collect();
        let p = rest.len();
        let at = |i: usize, j: usize| M[(i.max(j), i.min(j))];
        let height: usize = blocks.iter().map(Vec::len).sum();
        let mut factors = Vec::with_capacity(blocks.len());
        let mut stacked = DMatrix::<f64>::zeros(height, p);
        let mut first = 0;
        for own in blocks {
            let q = own.len();
            let mut F = DMatrix::from_fn(q, q, |i, j| at(own[i], own[j]));
            cholesky(&mut F)?;
            let mut W = DMatrix::from_fn(q, p, |i, j| at(own[i], rest[j]));
            for mut column in W.column_iter_mut() {
                forward(&F, column.as_mut_slice());
            }
            stacked.rows_mut(first, q).copy_from(&W);
            first += q;
            factors.push(BlockFactor {
                own: own.clone(),
                F,
                W,
            });
        }
        let mut L = if factors.is_empty() {
            std::mem::take(&mut M)
        } else {
            DMatrix::from_fn(p, p, |i, j| if i < j { 0.0 } else { at(rest[i], rest[j]) })
                - gram(&stacked)
        };
        cholesky(&mut L)?;
        let factor = Self {
            blocks: factors,
            rest,
            L,
            count,
        };
        factor.ln_det().is_finite().then_some(factor)
    }

    /// Returns the natural logarithm of the determinant of `M`.
    pub(crate) fn ln_det(&self) -> f64 {
        let all = self.blocks.iter().map(|block| &block.F).chain([&self.L]);
        let logs = all.flat_map(|L| (0..L.nrows()).map(|k| libm::log(L[(k, k)])));
        2.0 * logs.sum::<f64>()
    }

    /// Computes `M^-1 b`.
    pub fn solve(&self, b: &DVector<f64>) -> DVector<f64> {
        if self.blocks.is_empty() {
            let mut x = b.clone();
            forward(&self.L, x.as_mut_slice());
            backward(&self.L, x.as_mut_slice());
            return x;
        }
        let mut inner = b.select_rows(&self.rest);
        let each = self.blocks.iter().map(|block| {
            let mut own = b.select_rows(&block.own);
            forward(&block.F, own.as_mut_slice());
            inner -= block.W.tr_mul(&own);
            own
        });
        let halfway: Vec<DVector<f64>> = each.collect();
        forward(&self.L, inner.as_mut_slice());
        backward(&self.L, inner.as_mut_slice());
        let mut x = DVector::zeros(self.count);
        for (k, value) in self.rest.iter().zip(inner.iter()) {
            x[*k] = *value;
        }
        for (block, half) in self.blocks.iter().zip(halfway) {
            let mut own = half - &block.W * &inner;
            backward(&block.F, own.as_mut_slice());
            for (k, value) in block.own.iter().zip(own.iter()) {
                x[*k] = *value;
            }
        }
        x
    }

    /// Computes `v'M v`.
    pub(crate) fn quadratic(&self, v: &DVector<f64>) -> f64 {
        let inner = v.select_rows(&self.rest);
        let of = |block: &BlockFactor| {
            let own = v.select_rows(&block.own);
            norm_squared(&block.F, own.as_slice(), (&block.W * &inner).as_slice())
        };
        let nothing = vec![0.0; inner.len()];
        norm_squared(&self.L, inner.as_slice(), &nothing) + self.blocks.iter().map(of).sum::<f64>()
    }

    /// Returns the trace of `M^-1`.
    pub fn inverse_trace(&self) -> f64 {
        if self.blocks.is_empty() {
            return inverse_of(&self.L).norm_squared();
        }
        self.inverse().trace()
    }

    /// Computes the lower triangle of `M^-1`; entries above the diagonal are zero.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        let inner = inverse_of_product(&self.L);
        if self.blocks.is_empty() {
            return inner;
        }
        let (n, p) = (self.count, self.rest.len());
        let mut inner = inner;
        inner.fill_upper_triangle_with_lower_triangle();
        // Let `C` be the inverse of the Schur complement, and `R` the matrices `F'^-1 W` of all blocks, stacked. The covariance of the blocks
        // with the rest is `-R C`. Among the blocks it is `R C R'`, plus `(F F')^-1` within each block.
        let own: Vec<usize> = self
            .blocks
            .iter()
            .flat_map(|block| block.own.clone())
            .collect();
        let mut R = DMatrix::<f64>::zeros(own.len(), p);
        let mut first = 0;
        for block in &self.blocks {
            let mut part = block.W.clone();
            for mut column in part.column_iter_mut() {
                backward(&block.F, column.as_mut_slice());
            }
            R.rows_mut(first, part.nrows()).copy_from(&part);
            first += part.nrows();
        }
        let RC = transposed(&R.transpose(), &inner);
        let mut among = transposed(&RC.transpose(), &R.transpose());
        first = 0;
        for block in &self.blocks {
            let mut alone = inverse_of_product(&block.F);
            alone.fill_upper_triangle_with_lower_triangle();
            let mut part = among.view_mut((first, first), alone.shape());
            part += &alone;
            first += alone.nrows();
        }
        let mut out = DMatrix::<f64>::zeros(n, n);
        let mut put = |i: usize, j: usize, value: f64| out[(i.max(j), i.min(j))] = value;
        for (j, to) in self.rest.iter().enumerate() {
            for (i, row) in self.rest.iter().enumerate().skip(j) {
                put(*row, *to, inner[(i, j)]);
            }
            for (i, row) in own.iter().enumerate() {
                put(*row, *to, -RC[(i, j)]);
            }
        }
        for (j, to) in own.iter().enumerate() {
            for (i, row) in own.iter().enumerate().skip(j) {
                put(*row, *to, among[(i, j)]);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::product::gram;
    use super::*;
    use admire_study::noise::Noise;

    /// Checks determinant, solution and inverse against the results of nalgebra for the same matrix.
    #[test]
    fn factor_and_inverse_are_those_of_another_library() {
        for n in [0, 1, 2, 5, 40, 131] {
            let mut noise = Noise::new(5, "factor");
            let A = DMatrix::from_fn(n + 20, n, |_, _| noise.normal());
            let b = DVector::from_fn(n, |_, _| noise.normal());
            let G = gram(&A);
            let M = A.tr_mul(&A);
            assert!((&G - M.lower_triangle()).amax() < 1e-12 * (1.0 + M.amax()) || n == 0);
            let own = Factor::new(G).unwrap();
            let other = nalgebra::Cholesky::new(M.clone()).unwrap();
            if n == 0 {
                continue;
            }
            assert!((own.solve(&b) - other.solve(&b)).amax() < 1e-9);
            assert!((own.inverse() - other.inverse().lower_triangle()).amax() < 1e-9);
            let trace = own.inverse_trace() / other.inverse().trace();
            assert!((trace - 1.0).abs() < 1e-9);
            let quadratic = own.quadratic(&b) / b.dot(&(&M * &b));
            assert!((quadratic - 1.0).abs() < 1e-12);
            assert!((own.ln_det() - other.determinant().ln()).abs() < 1e-9);
        }
        assert!(Factor::new(-DMatrix::<f64>::identity(3, 3)).is_none());
        assert!(Factor::new(DMatrix::from_element(2, 2, f64::NAN)).is_none());
    }

    /// Checks that a factorisation by blocks gives the same results as a factorisation without blocks.
    #[test]
    fn blocks_change_nothing_but_the_order() {
        let (n, mut noise) = (23, Noise::new(9, "blocks"));
        let blocks = vec![vec![1, 2, 3], vec![10, 7], vec![20, 21, 22]];
        let block = |k: usize| blocks.iter().position(|block| block.contains(&k));
        // The rows of a case depend on the unknowns of one block and of the rest.
        let A = DMatrix::from_fn(90, n, |row, column| match block(column) {
            Some(own) if own != row % 3 => 0.0,
            _ => noise.normal(),
        });
        let b = DVector::from_fn(n, |_, _| noise.normal());
        let M = A.tr_mul(&A) + DMatrix::identity(n, n);
        let [whole, by_block] = [&[][..], &blocks].map(|blocks| {
            Factor::with_blocks(M.lower_triangle(), blocks).expect("positive definite")
        });
        assert!((whole.solve(&b) - by_block.solve(&b)).amax() < 1e-12);
        assert!((whole.inverse() - by_block.inverse()).amax() < 1e-12);
        assert!((whole.ln_det() - by_block.ln_det()).abs() < 1e-10);
        let quadratic = by_block.quadratic(&b) / b.dot(&(&M * &b));
        assert!((quadratic - 1.0).abs() < 1e-12);
        assert!((whole.inverse_trace() - by_block.inverse_trace()).abs() < 1e-10);
    }
}
