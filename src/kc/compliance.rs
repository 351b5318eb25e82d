use super::Side;
use admire_solver::mechanics::{Vec3, skew};

pub(crate) type Mat12 = nalgebra::SMatrix<f64, 12, 12>;

/// Compliance of both wheel centres: displacement i per unit load j, in the axes X rearward, Y right, Z up.
///
/// Rows and columns 1 to 6 are X, Y, Z, RX, RY, RZ of the left wheel centre, 7 to 12 the same of the right wheel centre. Loads are forces
/// and moments at the wheel centre, fixed in direction. The tyre is not included. Blocks of a missing wheel are zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Compliance {
    /// Compliance matrix.
    pub matrix: Mat12,
    /// Wheels present, left and right.
    pub present: [bool; 2],
}

impl Compliance {
    /// Returns entry C_ij of the matrix. Indices count from 1, as in the formulas.
    pub fn c(&self, i: usize, j: usize) -> f64 {
        self.matrix[(i - 1, j - 1)]
    }

    /// Returns the displacement of one wheel per unit load on the same or the other wheel. `row` is (wheel, displacement) and `column` is
    /// (wheel, load); displacements and loads count from 1 to 6.
    pub fn of(&self, row: (Side, usize), column: (Side, usize)) -> f64 {
        self.c(6 * row.0.index() + row.1, 6 * column.0.index() + column.1)
    }

    /// Returns displacement `i` of a wheel centre per unit of load `j` on both wheels.
    pub(crate) fn in_phase(&self, side: Side, i: usize, j: usize) -> f64 {
        self.of((side, i), (side, j)) + self.of((side, i), (side.other(), j))
    }

    /// Returns displacement `i` of a wheel centre per unit of load `j` on this wheel and the opposite load on the other wheel.
    pub(crate) fn antiphase(&self, side: Side, i: usize, j: usize) -> f64 {
        self.of((side, i), (side, j)) - self.of((side, i), (side.other(), j))
    }

    /// Returns the compliance at other points of the carriers, `wheel centre + d`. It is `J C J^T` with the block
    /// `J = [[I, -[d]x], [0, I]]` for each wheel.
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

    /// Returns the relative asymmetry `|C - C'| / |C|`, with lengths in units of `length` so that translations and rotations have similar
    /// weight. It is zero for a conservative deck. The torques of loaded bushings are not conservative and make it nonzero.
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

    /// Describes a zero-stiffness motion of a wheel in words; `None` if there is none. A motion counts as without stiffness if its compliance
    /// exceeds 1 m/N, more than that of any axle. Rotations and torques are converted to displacements and forces at a lever of 100 mm. `length`
    /// and `force` are the sizes of the deck's units in m and N.
    pub(crate) fn free_motion(&self, length: f64, force: f64) -> Option<String> {
        const LEVER: f64 = 0.1;
        const MOST: f64 = 1.0;
        let si = |i: usize, j: usize| {
            let size = |k: usize| if k % 6 > 2 { LEVER } else { length };
            // A rotation is measured by the displacement at the lever's end, a torque by the force there.
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
            "the {} wheel {verb} ({:.3}, {:.3}, {:.3}) (axes: X rearward, Y right, Z up)",
            side.word(),
            axis.x,
            axis.y,
            axis.z
        ))
    }

    /// Returns the compliance of an axle made of one wheel and its mirror image about Y = 0, without coupling between the wheels.
    #[must_use]
    pub(crate) fn mirrored(&self, from: Side) -> Self {
        // Under this reflection y, and rotations about x and z, change sign.
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

    /// Returns the compliance with the heights of the wheel centres held, as in a load test: `C - C(:,z) C(z,z)^-1 C(z,:)`, where z are the
    /// heights of the wheels present. `None` if `C(z,z)` is singular.
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
