use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::{Mat3, Pose, Vec3};

use super::least_squares::solve;
use super::record::{Element, Record};
use super::settings::CLOSURE_RELATIVE;

/// Markers of a bushing from requests of Adams/Car, which contain the deflection and the force in J axes, state by state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct FromRequests {
    /// Point of I on its body.
    pub(crate) point_i: Vec3,
    /// Point of J on its body.
    pub(crate) point_j: Vec3,
    /// Axes of J on its body.
    pub(crate) axes_j: Mat3,
}

/// Returns the vector whose components in a request are named `prefix` and x, y or z, optionally with a suffix (`dx_rear`, `dy_rear` ...).
fn vector(record: &Record, request: &str, prefix: char) -> Option<Vec<Vec3>> {
    let components = record.requests.get(request)?;
    let column = |axis: char| {
        let begins = |name: &&String| {
            let mut letters = name.chars();
            let start = (letters.next(), letters.next()) == (Some(prefix), Some(axis));
            start && matches!(letters.next(), None | Some('_'))
        };
        let name = components.keys().find(begins)?;
        components.get(name)
    };
    let (x, y, z) = (column('x')?, column('y')?, column('z')?);
    let rows = x.iter().zip(y).zip(z);
    Some(rows.map(|((x, y), z)| Vec3::new(*x, *y, *z)).collect())
}

/// Finds the markers of a bushing from its requests `NAME_disp` and `NAME_force`, which Adams/Car writes for each bushing. `None` if the requests are
/// missing, or if they do not belong to these two bodies.
pub(crate) fn markers(
    record: &Record,
    element: &Element,
    i: usize,
    j: usize,
    size: f64,
) -> Option<FromRequests> {
    let pieces: Vec<&str> = element.name.split('.').collect();
    let base = pieces.iter().rev().nth(1).or(pieces.last())?;
    let deflection = vector(record, &format!("{base}_disp"), 'd')?;
    let force = vector(record, &format!("{base}_force"), 'f')?;
    let (a, b) = (&record.bodies[i].poses, &record.bodies[j].poses);
    // The J axes follow from the rotation between the force in the axes of the J body and the force in J axes (Kabsch, 1976).
    let in_body: Vec<Vec3> = b
        .iter()
        .zip(&element.force)
        .map(|(b, f)| b.R.transpose() * f)
        .collect();
    let mut cross = Mat3::zeros();
    for (body, own) in in_body.iter().zip(&force) {
        cross += own * body.transpose();
    }
    let svd = cross.svd(true, true);
    let (U, Vt) = (svd.u?, svd.v_t?);
    let V = Vt.transpose();
    let mut mirror = Mat3::identity();
    mirror[(2, 2)] = (V * U.transpose()).determinant().signum();
    let axes_j = V * mirror * U.transpose();
    let most = force.iter().map(Vec3::norm).fold(0.0, f64::max);
    let apart = in_body
        .iter()
        .zip(&force)
        .map(|(body, own)| (body - axes_j * own).norm());
    if apart.fold(0.0, f64::max) > 1e-6 * most {
        return None;
    }
    let (point_i, point_j) = points(&deflection, &axes_j, a, b, size)?;
    Some(FromRequests {
        point_i,
        point_j,
        axes_j,
    })
}

/// Finds the points u of I and v of J, in the axes of their bodies, from the deflections d in J axes. They satisfy `p + R u - v = axes_j d`, where p
/// and R are the pose of the I body relative to the J body.
fn points(
    deflection: &[Vec3],
    axes_j: &Mat3,
    a: &[Pose],
    b: &[Pose],
    size: f64,
) -> Option<(Vec3, Vec3)> {
    let mut A = DMatrix::zeros(3 * deflection.len(), 6);
    let mut right = DVector::zeros(3 * deflection.len());
    for (k, d) in deflection.iter().enumerate() {
        let relative = b[k].inverse().compose(&a[k]);
        A.fixed_view_mut::<3, 3>(3 * k, 0).copy_from(&relative.R);
        A.fixed_view_mut::<3, 3>(3 * k, 3)
            .copy_from(&-Mat3::identity());
        right
            .fixed_rows_mut::<3>(3 * k)
            .copy_from(&(axes_j * d - relative.p));
    }
    let found = solve(&A, &right, &DVector::zeros(6), 1e-9);
    let point = |at: usize| Vec3::new(found.x[at], found.x[at + 1], found.x[at + 2]);
    (found.left <= CLOSURE_RELATIVE * size).then(|| (point(0), point(3)))
}
