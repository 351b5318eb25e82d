use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use admire_solver::mechanics::{Mat3, Pose, Vec3, exp, log, projected_angles};

use super::law::{AxisLaw, Law};
use super::least_squares::{solve, solve_scaled};
use super::record::{Element, Record};
use super::settings::{DETERMINED_RELATIVE, UNUSUAL_PAIR_FACTOR};

/// Axes of the I and J markers of a bushing, in the axes of their bodies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Axes {
    /// Axes of the I marker on the I body.
    pub(crate) i: Mat3,
    /// Axes of the J marker on the J body.
    pub(crate) j: Mat3,
    /// Largest difference from the angles of the results, in radians.
    pub(crate) left_rad: f64,
    /// True if the rotations do not determine a direction.
    pub(crate) open: bool,
}

/// Finds the axes of the markers from the angles AX, AY, AZ of the results.
///
/// To first order, the angles equal the components of the relative rotation vector in J axes, plus a constant. This determines the rotation between
/// the axes of the J body and the J axes (Kabsch, 1976). Newton's method for the exact angles then refines the axes of both markers.
pub(crate) fn axes(angles: &[Vec3], i: &[Pose], j: &[Pose]) -> Axes {
    let relative: Vec<Mat3> = i
        .iter()
        .zip(j)
        .map(|(i, j)| j.R.transpose() * i.R)
        .collect();
    let middle = relative[relative.len() / 2];
    let turns: Vec<Vec3> = relative
        .iter()
        .map(|R| log(&(R * middle.transpose())))
        .collect();
    let count = angles.len() as f64;
    let mean = |values: &[Vec3]| values.iter().fold(Vec3::zeros(), |sum, v| sum + v) / count;
    let (mean_turn, mean_angle) = (mean(&turns), mean(angles));
    let mut cross = Mat3::zeros();
    for (turn, angle) in turns.iter().zip(angles) {
        cross += (turn - mean_turn) * (angle - mean_angle).transpose();
    }
    let svd = cross.svd(true, true);
    let (Some(U), Some(Vt)) = (svd.u, svd.v_t) else {
        unreachable!("both were asked for")
    };
    let mut mirror = Mat3::identity();
    mirror[(2, 2)] = (U * Vt).determinant().signum();
    let j_axes = U * mirror * Vt;
    let first = angles[angles.len() / 2];
    // With known J axes, the I axes follow from the angles of one state.
    let i_axes = middle.transpose() * j_axes * exp(&first);
    let mut found = Axes {
        i: i_axes,
        j: j_axes,
        left_rad: f64::INFINITY,
        open: false,
    };
    for _ in 0..12 {
        let (step, left, open) = newton(&found, angles, &relative);
        found.left_rad = left;
        found.open = open;
        if step.norm() < 1e-15 {
            break;
        }
        found.i *= exp(&step.fixed_rows::<3>(0).into_owned());
        found.j *= exp(&step.fixed_rows::<3>(3).into_owned());
    }
    found
}

/// Returns one step of Newton's method for the rotations of the I and J axes, the largest residual angle in radians, and whether a rotation is
/// undetermined.
fn newton(at: &Axes, angles: &[Vec3], relative: &[Mat3]) -> (SVector<f64, 6>, f64, bool) {
    let h = 1e-6;
    let angle =
        |axes: (&Mat3, &Mat3), R: &Mat3| projected_angles(&(axes.1.transpose() * R * axes.0));
    let mut A = DMatrix::zeros(3 * angles.len(), 6);
    let mut right = DVector::zeros(3 * angles.len());
    for k in 0..6 {
        let turn = exp(&Vec3::ith(k % 3, h));
        let back = turn.transpose();
        let (plus, minus) = if k < 3 {
            ((at.i * turn, at.j), (at.i * back, at.j))
        } else {
            ((at.i, at.j * turn), (at.i, at.j * back))
        };
        for (row, R) in relative.iter().enumerate() {
            let rate = (angle((&plus.0, &plus.1), R) - angle((&minus.0, &minus.1), R)) / (2.0 * h);
            A.fixed_view_mut::<3, 1>(3 * row, k).copy_from(&rate);
        }
    }
    for (row, (R, wanted)) in relative.iter().zip(angles).enumerate() {
        let turn = std::f64::consts::TAU;
        let gap = (wanted - angle((&at.i, &at.j), R)).map(|a| a - (a / turn).round() * turn);
        right.fixed_rows_mut::<3>(3 * row).copy_from(&gap);
    }
    let found = solve(&A, &right, &DVector::zeros(6), 1e-7);
    let step = SMatrix::<f64, 6, 1>::from_iterator(found.x.iter().copied());
    (
        step,
        right.amax(),
        found.open.iter().any(|open| *open > 0.1),
    )
}

/// Returns the principal axes of the linear stiffness that fits the forces best, in the axes of the J body. They replace the axes of the J marker if
/// no angles in the results determine those.
pub(crate) fn stiffness_axes(
    record: &Record,
    element: &Element,
    i: usize,
    j: usize,
    point: &Vec3,
) -> Mat3 {
    let (a, b) = (&record.bodies[i].poses, &record.bodies[j].poses);
    let place = |k: usize| b[k].inverse().point(&a[k].point(point));
    let states = element.force.len();
    // The unknowns of f = c - K p with symmetric K are three constants and six stiffnesses.
    let mut A = DMatrix::zeros(3 * states, 9);
    let mut right = DVector::zeros(3 * states);
    let at = [[0, 3, 4], [3, 1, 5], [4, 5, 2]];
    let centre = place(0);
    for k in 0..states {
        let d = place(k) - centre;
        let f = b[k].R.transpose() * element.force[k];
        for row in 0..3 {
            A[(3 * k + row, 6 + row)] = 1.0;
            for column in 0..3 {
                A[(3 * k + row, at[row][column])] -= d[column];
            }
            right[3 * k + row] = f[row];
        }
    }
    let found = solve_scaled(&A, &right, &DVector::zeros(9), DETERMINED_RELATIVE).x;
    let K = Mat3::from_fn(|row, column| found[at[row][column]]);
    let mut axes = K.symmetric_eigen().eigenvectors;
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2));
    }
    axes
}

/// Deflection of a bushing in J axes, its force and torque in J axes, and its angles, state by state.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Position of I relative to J in J axes.
    pub deflection: Vec<Vec3>,
    /// Angles AX, AY, AZ.
    pub angles: Vec<Vec3>,
    /// Force on I in J axes.
    pub force: Vec<Vec3>,
    /// Torque on I in J axes.
    pub torque: Vec<Vec3>,
}

impl Motion {
    /// Returns the motion of a bushing between its markers, each given as a frame on its body.
    pub(crate) fn of(
        record: &Record,
        element: &Element,
        i: (usize, &Pose),
        j: (usize, &Pose),
    ) -> Self {
        let mut motion = Self::default();
        for k in 0..element.force.len() {
            let at_i = record.bodies[i.0].poses[k].compose(i.1);
            let at_j = record.bodies[j.0].poses[k].compose(j.1);
            let back = at_j.R.transpose();
            motion.deflection.push(back * (at_i.p - at_j.p));
            motion.angles.push(projected_angles(&(back * at_i.R)));
            motion.force.push(back * element.force[k]);
            motion.torque.push(back * element.torque[k]);
        }
        motion
    }
}

/// Finds the law of a bushing. Each axis is linear or a curve; radial axes are coupled if this fits best.
pub(crate) fn law(motion: &Motion, size: f64) -> Law {
    let column =
        |values: &[Vec3], axis: usize| -> Vec<f64> { values.iter().map(|v| v[axis]).collect() };
    let d = [0, 1, 2].map(|axis| column(&motion.deflection, axis));
    let f = [0, 1, 2].map(|axis| column(&motion.force, axis));
    let a = [0, 1, 2].map(|axis| column(&motion.angles, axis));
    let t = [0, 1, 2].map(|axis| column(&motion.torque, axis));
    let linear = [0, 1, 2].map(|axis| AxisLaw::linear(&d[axis], &f[axis], 1e-9 * size));
    let curved: Vec<usize> = (0..3).filter(|axis| linear[*axis].is_none()).collect();
    let torque = [0, 1, 2].map(|axis| {
        AxisLaw::linear(&a[axis], &t[axis], 1e-10)
            .unwrap_or_else(|| AxisLaw::curve(&a[axis], &t[axis]))
    });
    if curved.is_empty() {
        return Law {
            force: linear.map(|law| law.unwrap_or(AxisLaw::Unseen(0.0))),
            torque,
            coupled: None,
        };
    }
    // Each pair of axes that may be coupled is tried, and also no coupling. The best choice has the smallest residual of the nonlinear axes.
    let pairs = [None, Some([0, 1]), Some([1, 2]), Some([2, 0])];
    let tried = pairs.map(|pair| {
        let mut left = 0.0;
        let force = [0, 1, 2].map(|axis| {
            let partner = pair.and_then(|[p, q]| match axis {
                _ if axis == p => Some(q),
                _ if axis == q => Some(p),
                _ => None,
            });
            match (partner, linear[axis].clone()) {
                (None, Some(law)) => law,
                (Some(partner), _) => {
                    let (law, missed) = AxisLaw::radial(&d[axis], &d[partner], &f[axis]);
                    left += missed;
                    law
                }
                (None, None) => {
                    let (law, missed) = AxisLaw::odd(&d[axis], &f[axis]);
                    left += missed;
                    law
                }
            }
        });
        (left, force, pair)
    });
    // The radial axes of Adams/Car are x and y. Another pair is accepted only if it fits far better.
    let usual = |pair: &Option<[usize; 2]>| matches!(pair, None | Some([0, 1]));
    let score = |(left, _, pair): &(f64, [AxisLaw; 3], Option<[usize; 2]>)| {
        if usual(pair) {
            *left
        } else {
            UNUSUAL_PAIR_FACTOR * left
        }
    };
    let best = tried
        .into_iter()
        .min_by(|a, b| score(a).total_cmp(&score(b)));
    let Some((_, force, coupled)) = best else {
        unreachable!("four are tried")
    };
    // An axis without coupling needs no separate preload, because its curve contains the preload.
    let force = [0, 1, 2].map(|axis| match (&force[axis], coupled) {
        (AxisLaw::Odd { .. }, Some(pair)) if pair.contains(&axis) => force[axis].clone(),
        (AxisLaw::Odd { .. }, _) => AxisLaw::curve(&d[axis], &f[axis]),
        (law, _) => law.clone(),
    });
    Law {
        force,
        torque,
        coupled,
    }
}
