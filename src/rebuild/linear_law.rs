use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::{Mat3, Vec3};

use super::least_squares::solve_scaled;
use super::record::{Element, Record};
use super::settings::LINEAR_RELATIVE;

/// Point of a bushing on its I body, found from its law.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct ByLaw {
    /// The point, in the axes of the I body.
    pub(crate) point: Vec3,
    /// Indeterminacy of the point: 0 determined by the states, 1 undetermined.
    pub(crate) open: f64,
}

/// Finds the point of a linear bushing from its forces. Only for the correct point are the forces linear in the deflection.
///
/// `axes` are the axes of the J marker on the J body, and `near` is an initial guess. Let y be the position of the I body's origin in J axes, A the
/// axes of the I body in J axes, and u the point. Then axis k has the force c_k - K_k (y_k + a_k u), where a_k is row k of A. Newton's method
/// determines c, K and u. `None` if no point makes the forces linear.
pub(crate) fn point_by_law(
    record: &Record,
    element: &Element,
    bodies: (usize, usize),
    axes: &Mat3,
    near: &Vec3,
) -> Option<ByLaw> {
    let (i, j) = (
        &record.bodies[bodies.0].poses,
        &record.bodies[bodies.1].poses,
    );
    let states = element.force.len();
    let mut places = Vec::new();
    let mut turned = Vec::new();
    let mut forces = Vec::new();
    for k in 0..states {
        let back = (j[k].R * axes).transpose();
        places.push(back * (i[k].p - j[k].p));
        turned.push(back * i[k].R);
        forces.push(back * element.force[k]);
    }
    let range = |values: &[Vec3]| {
        values
            .iter()
            .map(|v| (v - values[0]).amax())
            .fold(0.0, f64::max)
    };
    let room = LINEAR_RELATIVE * range(&forces);
    // Deflections are relative to the first state, so that c remains small.
    let mut u = *near;
    let mut stiffness = Vec3::zeros();
    let mut open = 1.0;
    let mut left = f64::INFINITY;
    for round in 0..25 {
        // Each iteration starts with the stiffness that best fits the current point.
        let deflection: Vec<Vec3> = (0..states)
            .map(|k| places[k] + turned[k] * u - places[0] - turned[0] * u)
            .collect();
        let mut A = DMatrix::zeros(3 * states, 9);
        let mut right = DVector::zeros(3 * states);
        if round == 0 {
            for axis in 0..3 {
                let mut own = DMatrix::zeros(states, 2);
                let mut force = DVector::zeros(states);
                for k in 0..states {
                    own[(k, 0)] = 1.0;
                    own[(k, 1)] = -deflection[k][axis];
                    force[k] = forces[k][axis];
                }
                stiffness[axis] = solve_scaled(&own, &force, &DVector::zeros(2), 1e-12).x[1];
            }
        }
        for k in 0..states {
            for axis in 0..3 {
                let row = 3 * k + axis;
                A[(row, axis)] = 1.0;
                A[(row, 3 + axis)] = -deflection[k][axis];
                for column in 0..3 {
                    A[(row, 6 + column)] =
                        -stiffness[axis] * (turned[k][(axis, column)] - turned[0][(axis, column)]);
                }
                right[row] = forces[k][axis];
            }
        }
        let mut prior = DVector::zeros(9);
        for axis in 0..3 {
            prior[3 + axis] = stiffness[axis];
        }
        let found = solve_scaled(&A, &right, &prior, 1e-9);
        stiffness = Vec3::new(found.x[3], found.x[4], found.x[5]);
        let step = Vec3::new(found.x[6], found.x[7], found.x[8]);
        u += step;
        open = found.open[6..9].iter().copied().fold(0.0, f64::max);
        left = found.left;
        if !u.amax().is_finite() {
            return None;
        }
        if step.norm() <= 1e-13 * (1.0 + u.norm()) {
            break;
        }
    }
    (left <= room).then_some(ByLaw { point: u, open })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Body;
    use admire_solver::mechanics::{Pose, exp};
    use std::collections::BTreeMap;

    /// A bushing with known numbers between ground and a body that takes 30 poses.
    #[test]
    fn the_point_of_a_linear_bushing_is_found() {
        let axes = exp(&Vec3::new(0.3, -0.2, 0.5));
        let stiffness = Vec3::new(900.0, 4000.0, 300.0);
        let (on_i, on_j) = (Vec3::new(40.0, -10.0, 25.0), Vec3::new(141.0, 190.0, 26.0));
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 23) - 1.0
        };
        let poses: Vec<Pose> = (0..30)
            .map(|_| Pose {
                p: Vec3::new(100.0 + next(), 200.0 + next(), next()),
                R: exp(&Vec3::new(0.03 * next(), 0.03 * next(), 0.03 * next())),
            })
            .collect();
        let force = poses
            .iter()
            .map(|pose| {
                let d = axes.transpose() * (pose.point(&on_i) - on_j);
                axes * (Vec3::new(5.0, 6.0, 7.0) - stiffness.component_mul(&d))
            })
            .collect();
        let element = Element {
            name: "b".to_string(),
            ent_type: "Bushing".to_string(),
            id: 1,
            force,
            torque: vec![Vec3::zeros(); 30],
            angles: None,
        };
        let body = |name: &str, poses: Vec<Pose>| Body {
            name: name.to_string(),
            design: poses[0],
            poses,
        };
        let record = Record {
            runs: Vec::new(),
            bodies: vec![
                body("ground", vec![Pose::identity(); 30]),
                body("arm", poses),
            ],
            elements: Vec::new(),
            requests: BTreeMap::new(),
            floating: Vec::new(),
            units: admire_syntax::units::Units::default(),
            title: String::new(),
            has_design: true,
        };
        let near = Vec3::new(60.0, 0.0, 0.0);
        let found = point_by_law(&record, &element, (1, 0), &axes, &near).expect("linear");
        assert!((found.point - on_i).norm() < 1e-7, "{found:?}");
        assert!(found.open < 1e-6);
    }
}
