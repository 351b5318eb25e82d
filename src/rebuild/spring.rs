use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::{Vec3, skew};

use super::law::AxisLaw;
use super::least_squares::solve;
use super::record::{Element, Record};
use super::settings::{CLOSURE_RELATIVE, NO_FORCE_RELATIVE};

/// A force along the line through two points.
#[derive(Clone, PartialEq, Debug)]
pub struct Spring {
    /// Point on the I body, in its axes.
    pub i: Vec3,
    /// Point on the J body, in its axes.
    pub j: Vec3,
    /// Force as a function of the length. A positive force pushes the points apart.
    pub law: AxisLaw,
    /// Smallest and largest length in the states.
    pub visited: (f64, f64),
    /// True if the results do not determine the position of a point along the line.
    pub open: bool,
}

/// Returns true if the direction of a force is constant in ground axes.
pub(crate) fn keeps_direction(element: &Element) -> bool {
    let most = element.force.iter().map(Vec3::norm).fold(0.0, f64::max);
    let acting = || element.force.iter().filter(|f| f.norm() > 1e-6 * most);
    let Some(first) = acting().max_by(|a, b| a.norm().total_cmp(&b.norm())) else {
        return true;
    };
    let axis = first.normalize();
    acting().all(|f| (f - axis * axis.dot(f)).norm() <= 1e-9 * f.norm())
}

/// Finds the spring between two bodies. The force must be along the line through two points, and must be a function of the distance between them.
///
/// `near` is the point on the I body from the moments, and its indeterminacy. `None` if no such points exist.
pub(crate) fn spring(
    record: &Record,
    element: &Element,
    i: usize,
    j: usize,
    near: (&Vec3, f64),
    size: f64,
) -> Option<Spring> {
    if keeps_direction(element) {
        return None;
    }
    let (a, b) = (&record.bodies[i].poses, &record.bodies[j].poses);
    let most = element.force.iter().map(Vec3::norm).fold(0.0, f64::max);
    let acting: Vec<usize> = (0..element.force.len())
        .filter(|k| element.force[*k].norm() > 1e4 * NO_FORCE_RELATIVE * most)
        .collect();
    let mut A = DMatrix::zeros(3 * acting.len(), 6);
    let mut right = DVector::zeros(3 * acting.len());
    for (row, k) in acting.iter().enumerate() {
        let line = skew(&element.force[*k].normalize());
        A.fixed_view_mut::<3, 3>(3 * row, 0)
            .copy_from(&(line * a[*k].R));
        A.fixed_view_mut::<3, 3>(3 * row, 3)
            .copy_from(&(-line * b[*k].R));
        right
            .fixed_rows_mut::<3>(3 * row)
            .copy_from(&(-line * (a[*k].p - b[*k].p)));
    }
    let start = b[0].inverse().point(&a[0].point(near.0));
    let prior = DVector::from_iterator(6, near.0.iter().chain(start.iter()).copied());
    let found = solve(&A, &right, &prior, 1e-8);
    if found.left > 1e2 * CLOSURE_RELATIVE * size {
        return None;
    }
    let point = |at: usize| Vec3::new(found.x[at], found.x[at + 1], found.x[at + 2]);
    let (u, v) = (point(0), point(3));
    let (mut lengths, mut forces) = (Vec::new(), Vec::new());
    for (k, force) in element.force.iter().enumerate() {
        let line = a[k].point(&u) - b[k].point(&v);
        if line.norm() > 10.0 * size {
            return None;
        }
        lengths.push(line.norm());
        forces.push(force.dot(&line.normalize()));
    }
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let law = AxisLaw::linear(&lengths, &forces, 1e-9 * size)
        .unwrap_or_else(|| AxisLaw::curve(&lengths, &forces));
    Some(Spring {
        i: u,
        j: v,
        law,
        visited: (least, longest),
        open: near.1 > 0.1 && found.open.iter().any(|open| *open > 0.1),
    })
}
