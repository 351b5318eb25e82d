use nalgebra::{DMatrix, DVector, Dyn, OMatrix, U3};

use admire_solver::mechanics::{Mat3, Pose, Vec3, log};

use super::least_squares::solve;
use super::record::Record;
use super::settings::{CLOSURE_OF_MOTION, CLOSURE_RELATIVE, DETERMINED_RELATIVE, NO_ROTATION_RAD};

/// Motion of a body B relative to a body A over all states. Fields ending in `_a` are in the frame of A, fields ending in `_b` in the frame of B.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Relation {
    /// No relative motion.
    Fixed,
    /// Rotation about one line.
    Revolute {
        /// Point of the line on A: the point of the line nearest to the origin of A's frame.
        point_a: Vec3,
        /// The same point on B.
        point_b: Vec3,
        /// Direction of the line on A.
        axis_a: Vec3,
        /// Direction of the line on B.
        axis_b: Vec3,
    },
    /// Rotation about one point.
    Spherical {
        /// The point on A.
        point_a: Vec3,
        /// The point on B.
        point_b: Vec3,
    },
    /// Motion along one direction without rotation.
    Translational {
        /// Direction on A.
        axis_a: Vec3,
        /// Direction on B.
        axis_b: Vec3,
    },
    /// Motion along a line and rotation about it.
    Cylindrical {
        /// Point of the line on A.
        point_a: Vec3,
        /// Point of the line on B.
        point_b: Vec3,
        /// Direction of the line on A.
        axis_a: Vec3,
        /// Direction of the line on B.
        axis_b: Vec3,
    },
    /// Any other motion.
    Free,
}

/// Returns the size of the mechanism, which is the largest distance between the origins of two parts at design.
pub(crate) fn size(record: &Record) -> f64 {
    let origins: Vec<Vec3> = record.bodies[1..]
        .iter()
        .map(|body| body.design.p)
        .collect();
    let mut size: f64 = 0.0;
    for (k, a) in origins.iter().enumerate() {
        for b in &origins[..k] {
            size = size.max((a - b).norm());
        }
    }
    if size > 0.0 { size } else { 1.0 }
}

/// Finds the motion of B relative to A. `size` is the size of the mechanism.
pub(crate) fn relation(a: &[Pose], b: &[Pose], size: f64) -> Relation {
    let relative: Vec<Pose> = a
        .iter()
        .zip(b)
        .map(|(a, b)| a.inverse().compose(b))
        .collect();
    let Some(first) = relative.first() else {
        return Relation::Free;
    };
    let turns: Vec<Vec3> = relative
        .iter()
        .map(|pose| log(&(first.R.transpose() * pose.R)))
        .collect();
    let moves: Vec<Vec3> = relative.iter().map(|pose| pose.p - first.p).collect();
    let turn = turns.iter().map(Vec3::norm).fold(0.0, f64::max);
    let way = moves.iter().map(Vec3::norm).fold(0.0, f64::max);
    // Size of the motion as a distance. The tolerance of a joint is a fraction of it.
    let reach = way + turn * size;
    let closure = (CLOSURE_RELATIVE * size).min(CLOSURE_OF_MOTION * reach);
    if turn <= NO_ROTATION_RAD {
        if way <= CLOSURE_RELATIVE * size {
            return Relation::Fixed;
        }
        let axis_a = principal(&moves);
        let off = |d: &Vec3| (d - axis_a * axis_a.dot(d)).norm();
        let missed = moves.iter().map(off).fold(0.0, f64::max);
        return if missed <= closure {
            Relation::Translational {
                axis_a,
                axis_b: first.R.transpose() * axis_a,
            }
        } else {
            Relation::Free
        };
    }
    let axis_b = principal(&turns);
    let off = |w: &Vec3| (w - axis_b * axis_b.dot(w)).norm();
    let one_axis = turns.iter().map(off).fold(0.0, f64::max) <= 1e-7 * turn + 1e-13;
    let axis_a = first.R * axis_b;
    if let Some((point_a, point_b)) = fixed_point(&relative, None, closure) {
        return if one_axis {
            Relation::Revolute {
                point_a,
                point_b,
                axis_a,
                axis_b,
            }
        } else {
            Relation::Spherical { point_a, point_b }
        };
    }
    if one_axis && let Some((point_a, point_b)) = fixed_point(&relative, Some(axis_a), closure) {
        return Relation::Cylindrical {
            point_a,
            point_b,
            axis_a,
            axis_b,
        };
    }
    Relation::Free
}

/// Returns the direction in which the vectors differ most.
fn principal(vectors: &[Vec3]) -> Vec3 {
    let mut spread = Mat3::zeros();
    for v in vectors {
        spread += v * v.transpose();
    }
    let eigen = spread.symmetric_eigen();
    let mut axis: Vec3 = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imax())
        .into_owned();
    // The largest component determines the sign, so that equal mechanisms get equal axes.
    if axis[axis.iamax()] < 0.0 {
        axis = -axis;
    }
    axis
}

/// Finds the point of B that is at rest relative to A, and returns its position on A and on B. If `across` is given, only motion normal to this axis
/// counts.
fn fixed_point(relative: &[Pose], across: Option<Vec3>, closure: f64) -> Option<(Vec3, Vec3)> {
    let project = across.map_or_else(Mat3::identity, |n| Mat3::identity() - n * n.transpose());
    let count = relative.len() as f64;
    let mean_R = relative
        .iter()
        .fold(Mat3::zeros(), |sum, pose| sum + pose.R)
        / count;
    let mean_p = relative
        .iter()
        .fold(Vec3::zeros(), |sum, pose| sum + pose.p)
        / count;
    let mut A: OMatrix<f64, Dyn, U3> = OMatrix::<f64, Dyn, U3>::zeros(3 * relative.len());
    let mut right = DVector::zeros(3 * relative.len());
    for (k, pose) in relative.iter().enumerate() {
        A.fixed_view_mut::<3, 3>(3 * k, 0)
            .copy_from(&(project * (pose.R - mean_R)));
        right
            .fixed_rows_mut::<3>(3 * k)
            .copy_from(&(-project * (pose.p - mean_p)));
    }
    let A = DMatrix::from_iterator(A.nrows(), 3, A.iter().copied());
    let found = solve(&A, &right, &DVector::zeros(3), DETERMINED_RELATIVE.sqrt());
    if found.left > closure {
        return None;
    }
    let point_b = Vec3::new(found.x[0], found.x[1], found.x[2]);
    Some((mean_p + mean_R * point_b, point_b))
}

/// Clusters of bodies that never move relative to each other.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Clusters {
    /// Cluster of each body.
    pub(crate) of: Vec<usize>,
    /// Bodies of each cluster; the first cluster contains ground.
    pub(crate) members: Vec<Vec<usize>>,
}

impl Clusters {
    /// Finds the clusters of bodies that never move relative to each other.
    pub(crate) fn find(record: &Record, size: f64) -> Self {
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut of = Vec::new();
        for (k, body) in record.bodies.iter().enumerate() {
            let same = members.iter().position(|members| {
                let first = &record.bodies[members[0]];
                relation(&first.poses, &body.poses, size) == Relation::Fixed
            });
            if let Some(cluster) = same {
                members[cluster].push(k);
                of.push(cluster);
            } else {
                of.push(members.len());
                members.push(vec![k]);
            }
        }
        Self { of, members }
    }
}

/// Relations between all pairs of clusters, computed from the poses of their first bodies.
#[derive(Clone, Debug)]
pub(crate) struct Relations {
    count: usize,
    all: Vec<Relation>,
}

impl Relations {
    /// Finds the relations between all pairs of clusters.
    pub(crate) fn find(record: &Record, clusters: &Clusters, size: f64) -> Self {
        let count = clusters.members.len();
        let mut all = vec![Relation::Fixed; count * count];
        for a in 0..count {
            for b in 0..count {
                if a != b {
                    let body = |c: usize| &record.bodies[clusters.members[c][0]].poses;
                    all[a * count + b] = relation(body(a), body(b), size);
                }
            }
        }
        Self { count, all }
    }

    /// Returns the motion of the second cluster relative to the first.
    pub(crate) fn of(&self, a: usize, b: usize) -> Relation {
        self.all[a * self.count + b]
    }
}
