use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::{Pose, Vec3, skew};

use super::least_squares::{Solution, solve};
use super::record::Record;
use super::settings::DETERMINED_RELATIVE;

/// A force on a body: the element and the sign of its action, 1 on its I part and -1 on its J part.
pub(crate) type Term = (usize, f64);

/// Result of a fit to the moments on one body.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    /// Largest residual moment divided by the largest force, in length units.
    pub(crate) lever: f64,
}

/// Returns the states that the search uses: at most `most`, evenly spaced.
pub(crate) fn spread(states: usize, most: usize) -> Vec<usize> {
    let count = states.min(most);
    (0..count)
        .map(|k| k * (states - 1) / (count - 1).max(1))
        .collect()
}

/// Returns the derivative of the moment of a force F about the ground origin with respect to u, the point of attack in body axes. The moment is the
/// cross product of x = p + R u and F.
fn lever_columns(pose: &Pose, force: &Vec3) -> nalgebra::Matrix3<f64> {
    -skew(force) * pose.R
}

/// Balances the moments of forces on one body. Each force acts at an unknown point that is fixed on the I part of its element. `on` gives the I part
/// of each term.
pub(crate) fn fit_body(
    record: &Record,
    body: usize,
    terms: &[Term],
    on: &[usize],
    states: &[usize],
) -> Fitted {
    let poses = &record.bodies[body].poses;
    let total = |state: usize| {
        let mut forces = terms.iter();
        forces.by_ref().fold(Vec3::zeros(), |sum, (e, s)| {
            sum + record.elements[*e].force[state] * *s
        })
    };
    let sum = states
        .iter()
        .fold(Vec3::zeros(), |sum, state| sum + total(*state));
    let weight = -sum / states.len() as f64;
    let columns = 3 * (terms.len() + 1);
    let mut A = DMatrix::zeros(3 * states.len(), columns);
    let mut right = DVector::zeros(3 * states.len());
    let mut largest = 0.0_f64;
    for (row, state) in states.iter().enumerate() {
        let pose = &poses[*state];
        let mut known = pose.p.cross(&weight);
        for (k, (element, sign)) in terms.iter().enumerate() {
            let force = record.elements[*element].force[*state] * *sign;
            let at = &record.bodies[on[k]].poses[*state];
            largest = largest.max(force.norm());
            known += at.p.cross(&force) + record.elements[*element].torque[*state] * *sign;
            A.fixed_view_mut::<3, 3>(3 * row, 3 * k)
                .copy_from(&lever_columns(at, &force));
        }
        A.fixed_view_mut::<3, 3>(3 * row, 3 * terms.len())
            .copy_from(&lever_columns(pose, &weight));
        right.fixed_rows_mut::<3>(3 * row).copy_from(&-known);
    }
    let found = solve(
        &A,
        &right,
        &DVector::zeros(columns),
        DETERMINED_RELATIVE * 1e-2,
    );
    Fitted {
        lever: found.left / largest.max(f64::MIN_POSITIVE),
    }
}

/// Point at which an element acts on its I part.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Point {
    /// Known point, in the axes of the I body.
    Known(Vec3),
    /// Unknown point near this position, in the axes of the I body.
    Near(Vec3),
}

/// Forces on all bodies, for a joint balance of all moments.
pub(crate) struct Whole<'a> {
    /// The states.
    pub(crate) record: &'a Record,
    /// I body of each element with a force or torque, and the point on this body.
    pub(crate) points: &'a [(usize, usize, Point)],
    /// Forces on each body other than ground, as indices into `points`.
    pub(crate) bodies: &'a [(usize, Vec<Term>)],
    /// Weight of each body in `bodies`, and an initial guess of its mass centre in the axes of the body.
    pub(crate) weights: &'a [(Vec3, Vec3)],
}

/// Points and mass centres that balance the moments of all bodies.
#[derive(Clone, Debug)]
pub(crate) struct Balanced {
    /// Points of the elements, in the axes of their I bodies.
    pub(crate) points: Vec<Vec3>,
    /// Indeterminacy of each point: 0 determined by the moments, 1 undetermined.
    pub(crate) points_open: Vec<f64>,
    /// Mass centres, in the axes of the bodies.
    pub(crate) centres: Vec<Vec3>,
    /// Indeterminacy of each mass centre, as for the points.
    pub(crate) centres_open: Vec<f64>,
    /// Largest residual moment.
    pub(crate) left: f64,
}

impl Whole<'_> {
    /// Balances the moments of all bodies in the states `states`.
    pub(crate) fn balance(&self, states: &[usize]) -> Balanced {
        let free: Vec<usize> = (0..self.points.len())
            .filter(|k| matches!(self.points[*k].2, Point::Near(_)))
            .collect();
        let column_of = |point: usize| free.iter().position(|k| *k == point);
        let columns = 3 * (free.len() + self.bodies.len());
        let mut A = DMatrix::zeros(3 * states.len() * self.bodies.len(), columns);
        let mut right = DVector::zeros(A.nrows());
        let mut prior = DVector::zeros(columns);
        for (k, point) in free.iter().enumerate() {
            if let Point::Near(near) = self.points[*point].2 {
                prior.fixed_rows_mut::<3>(3 * k).copy_from(&near);
            }
        }
        let mut row = 0;
        for (k, (body, terms)) in self.bodies.iter().enumerate() {
            let (weight, centre) = self.weights[k];
            let centre_column = 3 * (free.len() + k);
            prior.fixed_rows_mut::<3>(centre_column).copy_from(&centre);
            for state in states {
                let pose = &self.record.bodies[*body].poses[*state];
                let mut known = pose.p.cross(&weight);
                A.fixed_view_mut::<3, 3>(row, centre_column)
                    .copy_from(&lever_columns(pose, &weight));
                for (point, sign) in terms {
                    let (element, on, place) = self.points[*point];
                    let element = &self.record.elements[element];
                    let force = element.force[*state] * *sign;
                    let at = &self.record.bodies[on].poses[*state];
                    known += element.torque[*state] * *sign;
                    match (place, column_of(*point)) {
                        (Point::Known(u), _) => known += at.point(&u).cross(&force),
                        (Point::Near(_), Some(column)) => {
                            known += at.p.cross(&force);
                            let mut block = A.fixed_view_mut::<3, 3>(row, 3 * column);
                            block += lever_columns(at, &force);
                        }
                        (Point::Near(_), None) => unreachable!("every open point has a column"),
                    }
                }
                right.fixed_rows_mut::<3>(row).copy_from(&-known);
                row += 3;
            }
        }
        let found = solve(&A, &right, &prior, DETERMINED_RELATIVE);
        self.answer(&free, &found)
    }

    fn answer(&self, free: &[usize], found: &Solution) -> Balanced {
        let vector = |at: usize| Vec3::new(found.x[at], found.x[at + 1], found.x[at + 2]);
        let open = |at: usize| found.open[at..at + 3].iter().copied().fold(0.0, f64::max);
        let mut points = Vec::new();
        let mut points_open = Vec::new();
        for (k, (_, _, place)) in self.points.iter().enumerate() {
            match (place, free.iter().position(|f| *f == k)) {
                (Point::Near(_), Some(at)) => {
                    points.push(vector(3 * at));
                    points_open.push(open(3 * at));
                }
                (Point::Known(u) | Point::Near(u), _) => {
                    points.push(*u);
                    points_open.push(0.0);
                }
            }
        }
        let bodies = 0..self.bodies.len();
        let column = |k: usize| 3 * (free.len() + k);
        Balanced {
            points,
            points_open,
            centres: bodies.clone().map(|k| vector(column(k))).collect(),
            centres_open: bodies.map(|k| open(column(k))).collect(),
            left: found.left,
        }
    }
}
