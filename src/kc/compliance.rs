use super::Side;
use admire_solver::mechanics::{Vec3, skew};

/// A 12 by 12 matrix.
pub(crate) type Mat12 = nalgebra::SMatrix<f64, 12, 12>;

/// The compliance of both wheel centres: displacement i per unit load j, X rearward, Y right, Z up.
///
/// Rows and columns 1 to 6 are X, Y, Z, RX, RY, RZ of the left wheel centre, 7 to 12 those of the right one; loads are forces and
/// moments at the wheel centre, fixed in direction. No tyre in it. Of an axle with one wheel the blocks of the other are zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Compliance {
    /// The matrix.
    pub matrix: Mat12,
    /// Which wheels there are.
    pub present: [bool; 2],
}

impl Compliance {
    /// An entry as the formulas count, from 1.
    pub fn c(&self, i: usize, j: usize) -> f64 {
        self.matrix[(i - 1, j - 1)]
    }

    /// An entry by wheel: row `i` of one wheel, column `j` of another, each 1 to 6.
    pub fn of(&self, row: (Side, usize), column: (Side, usize)) -> f64 {
        self.c(6 * row.0.index() + row.1, 6 * column.0.index() + column.1)
    }

    /// Row `i` of a wheel for loads `j` on both wheels in phase.
    pub(crate) fn in_phase(&self, side: Side, i: usize, j: usize) -> f64 {
        self.of((side, i), (side, j)) + self.of((side, i), (side.other(), j))
    }

    /// Row `i` of a wheel for a load `j` on it and the opposite load on the other wheel.
    pub(crate) fn antiphase(&self, side: Side, i: usize, j: usize) -> f64 {
        self.of((side, i), (side, j)) - self.of((side, i), (side.other(), j))
    }

    /// The same for points `p = wheel centre + d` of the carriers: `J C J^T`, `J = [[I, -[d]x], [0, I]]` for each wheel.
    #[must_use]
    pub(crate) fn at(&self, d: [Vec3; 2]) -> Self {
        let mut j = Mat12::identity();
        for (k, d) in d.iter().enumerate() {
            j.fixed_view_mut::<3, 3>(6 * k, 6 * k + 3)
                .copy_from(&-skew(d));
        }
        Self {
            matrix: j * self.matrix * j.transpose(),
            present: self.present,
        }
    }

    /// `|C - C'| / |C|`, lengths in units of `length` so that translations and rotations count alike. Zero for conservative decks; the
    /// torques of loaded bushings are not conservative.
    pub fn asymmetry(&self, length: f64) -> f64 {
        let mut scaled = self.matrix;
        for i in 0..12 {
            for j in 0..12 {
                let power = i32::from(i % 6 > 2) + i32::from(j % 6 > 2);
                scaled[(i, j)] *= length.powi(power);
            }
        }
        (scaled - scaled.transpose()).norm() / scaled.norm()
    }

    /// The motion of a wheel that nothing resists, in words: a compliance beyond what any axle has, 1 m/N or as much turning on a lever of
    /// 100 mm. `length` and `force` are the sizes of the units in m and N.
    pub(crate) fn free_motion(&self, (length, force): (f64, f64)) -> Option<String> {
        const LEVER: f64 = 0.1;
        const MOST: f64 = 1.0;
        let si = |i: usize, j: usize| {
            let size = |k: usize| if k % 6 > 2 { LEVER } else { length };
            // A rotation counts by its path on the lever, a torque by its force there.
            let per = |k: usize| {
                if k % 6 > 2 {
                    force * length / LEVER
                } else {
                    force
                }
            };
            self.matrix[(i, j)] * size(i) / per(j)
        };
        let (mut largest, mut at) = (MOST, None);
        for j in 0..12 {
            for i in 0..12 {
                let size = si(i, j).abs();
                if !(size <= largest) {
                    (largest, at) = (size, Some((i, j)));
                }
            }
        }
        let (i, j) = at?;
        let side = if i < 6 { Side::Left } else { Side::Right };
        let first = 6 * side.index() + 3 * (i % 6 / 3);
        let axis = Vec3::new(si(first, j), si(first + 1, j), si(first + 2, j)).normalize();
        let verb = if i % 6 > 2 {
            "turns freely about"
        } else {
            "moves freely along"
        };
        Some(format!(
            "the {} wheel {verb} ({:.3}, {:.3}, {:.3}) in X rearward, Y right, Z up",
            side.word(),
            axis.x,
            axis.y,
            axis.z
        ))
    }

    /// One wheel on its own becomes an axle that is its mirror image about Y = 0, without a coupling.
    #[must_use]
    pub(crate) fn mirrored(&self, from: Side) -> Self {
        // Polar y and axial x, z change sign.
        const SIGN: [f64; 6] = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        let (a, b) = (6 * from.index(), 6 * from.other().index());
        let mut matrix = Mat12::zeros();
        for i in 0..6 {
            for j in 0..6 {
                let c = self.matrix[(a + i, a + j)];
                matrix[(a + i, a + j)] = c;
                matrix[(b + i, b + j)] = SIGN[i] * SIGN[j] * c;
            }
        }
        Self {
            matrix,
            present: [true; 2],
        }
    }

    /// What a load test with the wheel centres' heights held gives: `C - C(:,z) C(z,z)^-1 C(z,:)`, z the heights of the wheels present.
    #[must_use]
    pub fn height_held(&self) -> Option<Self> {
        let rows: Vec<usize> = Side::BOTH
            .into_iter()
            .filter(|side| self.present[side.index()])
            .map(|side| 6 * side.index() + 2)
            .collect();
        let n = rows.len();
        let zz = nalgebra::DMatrix::from_fn(n, n, |i, j| self.matrix[(rows[i], rows[j])]);
        let inverse = zz.try_inverse()?;
        let mut matrix = self.matrix;
        for (i, &zi) in rows.iter().enumerate() {
            for (j, &zj) in rows.iter().enumerate() {
                matrix -= self.matrix.column(zi) * self.matrix.row(zj) * inverse[(i, j)];
            }
        }
        Some(Self {
            matrix,
            present: self.present,
        })
    }
}
