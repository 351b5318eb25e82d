use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::{Mat3, Pose, Vec3, exp};

use super::least_squares::solve;

use super::names::joint_code;
use super::record::{Element, Record};
use super::relation::Relation;

/// A joint of the deck.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Joint {
    /// Keyword of the type of joint, for example `REVOLUTE`.
    pub kind: &'static str,
    /// Frame of the I marker on the I body.
    pub i: Pose,
    /// Frame of the J marker on the J body.
    pub j: Pose,
}

/// Returns a rotation whose z axis is `axis`.
pub(crate) fn frame_along(axis: &Vec3) -> Mat3 {
    let z = axis.normalize();
    let helper = if z.z.abs() < 0.9 {
        Vec3::z()
    } else {
        Vec3::x()
    };
    let x = helper.cross(&z).normalize();
    Mat3::from_columns(&[x, z.cross(&x), z])
}

/// Finds the joint between two bodies from their relative motion and from the torque that it carries. `None` if neither is consistent with a joint.
pub(crate) fn joint(
    record: &Record,
    element: &Element,
    i: usize,
    j: usize,
    relation: &Relation,
) -> Option<Joint> {
    let code = joint_code(&element.name);
    let first = |body: usize| record.bodies[body].poses[0];
    // The frame on the J body coincides with the frame on the I body in the first state.
    let both = |kind, p_i: Vec3, R_i: Mat3, p_j: Vec3| {
        let back = first(j).R.transpose() * first(i).R;
        Some(Joint {
            kind,
            i: Pose { p: p_i, R: R_i },
            j: Pose {
                p: p_j,
                R: back * R_i,
            },
        })
    };
    let on_j = |point: &Vec3| first(j).inverse().point(&first(i).point(point));
    match relation {
        Relation::Fixed => {
            let origin = Vec3::zeros();
            both("FIXED", origin, Mat3::identity(), on_j(&origin))
        }
        Relation::Revolute {
            point_a,
            point_b,
            axis_a,
            ..
        } if !matches!(code, Some("sph" | "con" | "hoo" | "uni")) => {
            both("REVOLUTE", *point_a, frame_along(axis_a), *point_b)
        }
        Relation::Translational { axis_a, .. } => {
            let origin = Vec3::zeros();
            let kind = if code == Some("cyl") {
                "CYLINDRICAL"
            } else {
                "TRANSLATIONAL"
            };
            both(kind, origin, frame_along(axis_a), on_j(&origin))
        }
        Relation::Cylindrical {
            point_a,
            point_b,
            axis_a,
            ..
        } => both("CYLINDRICAL", *point_a, frame_along(axis_a), *point_b),
        Relation::Spherical { point_a, point_b }
        | Relation::Revolute {
            point_a, point_b, ..
        } => {
            let (a, b) = (&record.bodies[i].poses, &record.bodies[j].poses);
            if code != Some("con")
                && let Some((x_i, x_j)) = cross(element, a, b)
            {
                // The pins of a UNIVERSAL are the z axes of its markers.
                return Some(Joint {
                    kind: "UNIVERSAL",
                    i: Pose {
                        p: *point_a,
                        R: frame_along(&x_i),
                    },
                    j: Pose {
                        p: *point_b,
                        R: frame_along(&x_j),
                    },
                });
            }
            if code == Some("con")
                && let Some((R_i, R_j)) = convel(a, b)
            {
                return Some(Joint {
                    kind: "CONVEL",
                    i: Pose {
                        p: *point_a,
                        R: R_i,
                    },
                    j: Pose {
                        p: *point_b,
                        R: R_j,
                    },
                });
            }
            both("SPHERICAL", *point_a, Mat3::identity(), *point_b)
        }
        Relation::Free => None,
    }
}

/// Finds the two pins of a universal joint. Each pin is a direction on its body that is always normal to the torque, and the pins remain at right
/// angles. `None` without a torque or without such pins.
fn cross(element: &Element, i: &[Pose], j: &[Pose]) -> Option<(Vec3, Vec3)> {
    let most = |values: &[Vec3]| values.iter().map(Vec3::norm).fold(0.0, f64::max);
    let (force, torque) = (most(&element.force), most(&element.torque));
    if torque <= 1e-8 * force {
        return None;
    }
    let across = |poses: &[Pose]| {
        let mut spread = Mat3::zeros();
        for (pose, torque) in poses.iter().zip(&element.torque) {
            let t = pose.R.transpose() * torque;
            spread += t * t.transpose();
        }
        let eigen = spread.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        order.map(|k| eigen.eigenvectors.column(k).into_owned())
    };
    let (a, b) = (across(i), across(j));
    // If the torque has a constant direction on a body, two directions are normal to it. Their combinations are then searched.
    let mut best: Option<(f64, Vec3, Vec3)> = None;
    let angle = |k: usize| std::f64::consts::PI * k as f64 / 720.0;
    let mix = |pair: &[Vec3; 3], k: usize| {
        let (sine, cosine) = libm::sincos(angle(k));
        pair[0] * cosine + pair[1] * sine
    };
    let lost = |poses: &[Pose], pin: &Vec3| {
        let along = poses.iter().zip(&element.torque);
        along
            .map(|(pose, t)| (pose.R * pin).dot(t).abs())
            .fold(0.0, f64::max)
            / torque
    };
    for k in 0..720 {
        let pin_i = mix(&a, k);
        if lost(i, &pin_i) > 1e-5 {
            continue;
        }
        for l in 0..720 {
            let pin_j = mix(&b, l);
            if lost(j, &pin_j) > 1e-5 {
                continue;
            }
            let right = i
                .iter()
                .zip(j)
                .map(|(i, j)| (i.R * pin_i).dot(&(j.R * pin_j)).abs());
            let worst = right.fold(0.0, f64::max);
            if best.as_ref().is_none_or(|(least, ..)| worst < *least) {
                best = Some((worst, pin_i, pin_j));
            }
        }
    }
    let found = best
        .filter(|(worst, ..)| *worst < 1e-6)
        .map(|(_, i, j)| (i, j));
    // A unique direction needs no search over angles.
    found.or_else(|| {
        let (pin_i, pin_j) = (a[0], b[0]);
        let right = i
            .iter()
            .zip(j)
            .map(|(i, j)| (i.R * pin_i).dot(&(j.R * pin_j)).abs());
        let worst = right.fold(0.0, f64::max);
        (worst < 1e-6 && lost(i, &pin_i) < 1e-5 && lost(j, &pin_j) < 1e-5).then_some((pin_i, pin_j))
    })
}

/// Finds two pins, one on each body, that remain at right angles in all states. They are the pins of a universal joint that carries no torque. The
/// third value is the largest magnitude of the cosine of the angle between them. `None` if no such pins exist.
///
/// Newton's method starts with pins along the axes of the frames, and with pins between these axes.
pub(crate) fn pins(i: &[Pose], j: &[Pose]) -> Option<(Vec3, Vec3, f64)> {
    let relative: Vec<Mat3> = i
        .iter()
        .zip(j)
        .map(|(i, j)| j.R.transpose() * i.R)
        .collect();
    let mut starts = Vec::new();
    for x in [-1.0, 0.0, 1.0] {
        for y in [-1.0, 0.0, 1.0] {
            for z in [0.0, 1.0] {
                let v = Vec3::new(x, y, z);
                if v.norm() > 0.0 {
                    starts.push(frame_along(&v));
                }
            }
        }
    }
    let cosine = |R_i: &Mat3, R_j: &Mat3, R: &Mat3| R_j.column(2).dot(&(R * R_i.column(2)));
    let mut best: Option<(Vec3, Vec3, f64)> = None;
    for start in &starts {
        for other in &starts {
            // The initial J pin is normal to the I pin.
            let carried = relative[0] * start.column(2);
            let across = carried.cross(&other.column(2));
            if across.norm() < 0.1 {
                continue;
            }
            let (mut R_i, mut R_j) = (*start, frame_along(&across));
            for _ in 0..15 {
                let h = 1e-6;
                let turned = |k: usize, h: f64| {
                    let step = exp(&Vec3::ith(k % 2, h));
                    if k < 2 {
                        (R_i * step, R_j)
                    } else {
                        (R_i, R_j * step)
                    }
                };
                let mut A = DMatrix::zeros(relative.len(), 4);
                for k in 0..4 {
                    let (plus, minus) = (turned(k, h), turned(k, -h));
                    for (row, R) in relative.iter().enumerate() {
                        A[(row, k)] = (cosine(&plus.0, &plus.1, R) - cosine(&minus.0, &minus.1, R))
                            / (2.0 * h);
                    }
                }
                let each = relative.iter().map(|R| -cosine(&R_i, &R_j, R));
                let right = DVector::from_iterator(relative.len(), each);
                let step = solve(&A, &right, &DVector::zeros(4), 1e-9).x;
                if !step.amax().is_finite() || step.amax() > 1.0 {
                    break;
                }
                R_i *= exp(&Vec3::new(step[0], step[1], 0.0));
                R_j *= exp(&Vec3::new(step[2], step[3], 0.0));
                if step.amax() < 1e-13 {
                    break;
                }
            }
            let each = relative.iter().map(|R| cosine(&R_i, &R_j, R).abs());
            let worst = each.fold(0.0, f64::max);
            if best.as_ref().is_none_or(|(.., least)| worst < *least) {
                best = Some((
                    R_i.column(2).into_owned(),
                    R_j.column(2).into_owned(),
                    worst,
                ));
            }
        }
    }
    best.filter(|(.., worst)| *worst < 1e-9)
}

/// Finds the axes of a constant-velocity joint on both bodies. Its shafts are along z, so that xi.yj = yi.xj in every state.
///
/// The search starts with shafts along the axes of the bodies' own frames, and continues with Newton's method. `None` if no such axes exist.
fn convel(i: &[Pose], j: &[Pose]) -> Option<(Mat3, Mat3)> {
    let relative: Vec<Mat3> = i
        .iter()
        .zip(j)
        .map(|(i, j)| j.R.transpose() * i.R)
        .collect();
    let first = *relative.first()?;
    let missed = |R_i: &Mat3, R_j: &Mat3, R: &Mat3| {
        let R_ji = R_j.transpose() * R * R_i;
        R_ji[(1, 0)] - R_ji[(0, 1)]
    };
    let worst = |R_i: &Mat3, R_j: &Mat3| {
        let each = relative.iter().map(|R| missed(R_i, R_j, R).abs());
        each.fold(0.0, f64::max)
    };
    let mut best: Option<(f64, Mat3, Mat3)> = None;
    for a in 0..3 {
        for b in 0..3 {
            for sign in [1.0, -1.0] {
                let start_i = frame_along(&Vec3::ith(a, 1.0));
                let mut R_i = start_i;
                let z_j = Vec3::ith(b, sign);
                // The J frame is the I frame of the first state, tilted so that z is along its own shaft.
                let carried = first * R_i;
                // With shafts in opposite directions, the equation would hold for every twist.
                if carried.column(2).dot(&z_j) < 0.5 {
                    continue;
                }
                let bend =
                    nalgebra::Rotation3::rotation_between(&carried.column(2).into_owned(), &z_j);
                let Some(bend) = bend else { continue };
                let mut R_j = bend.into_inner() * carried;
                for _ in 0..20 {
                    let h = 1e-6;
                    let turned = |k: usize, h: f64| {
                        let step = exp(&Vec3::ith(k % 3, h));
                        if k < 3 {
                            (R_i * step, R_j)
                        } else {
                            (R_i, R_j * step)
                        }
                    };
                    let mut A = DMatrix::zeros(relative.len(), 6);
                    for k in 0..6 {
                        let (plus, minus) = (turned(k, h), turned(k, -h));
                        for (row, R) in relative.iter().enumerate() {
                            A[(row, k)] = (missed(&plus.0, &plus.1, R)
                                - missed(&minus.0, &minus.1, R))
                                / (2.0 * h);
                        }
                    }
                    let right = DVector::from_iterator(
                        relative.len(),
                        relative.iter().map(|R| -missed(&R_i, &R_j, R)),
                    );
                    let step = solve(&A, &right, &DVector::zeros(6), 1e-8).x;
                    if !step.amax().is_finite() || step.amax() > 1.0 {
                        break;
                    }
                    R_i *= exp(&Vec3::new(step[0], step[1], step[2]));
                    R_j *= exp(&Vec3::new(step[3], step[4], step[5]));
                    if step.amax() < 1e-13 {
                        break;
                    }
                }
                if worst(&R_i, &R_j) > 1e-9 {
                    continue;
                }
                // Several axes may fit the states. Preferred are shafts along the axes of their frames.
                let off = start_i.column(2).cross(&R_i.column(2)).norm()
                    + z_j.cross(&R_j.column(2)).norm();
                if best.as_ref().is_none_or(|(least, ..)| off < *least) {
                    best = Some((off, R_i, R_j));
                }
            }
        }
    }
    best.map(|(_, R_i, R_j)| (R_i, R_j))
}
