use admire_solver::mechanics::Vec3;

/// Convex hull of a point cloud: flat faces and the edges between them.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Hull {
    /// Corners of each face as indices of points, in order around the face.
    pub faces: Vec<Vec<usize>>,
    /// Edges as pairs of point indices, each edge listed once.
    pub edges: Vec<[usize; 2]>,
}

/// Maximum number of points used. Larger clouds are first thinned to their extreme points, because every triple of points is tested.
const MOST: usize = 40;
/// Distance from a plane, relative to the size of the cloud, below which a point counts as lying in the plane.
const FLAT: f64 = 1e-4;

/// Computes the convex hull of points. Points on a line give one edge; points in a plane give one face.
pub(crate) fn hull(points: &[Vec3]) -> Hull {
    let chosen = extreme(points);
    let at = |k: usize| points[chosen[k]];
    let size = chosen
        .iter()
        .map(|&k| (points[k] - points[chosen[0]]).norm())
        .fold(0.0, f64::max);
    if chosen.len() < 2 || size == 0.0 {
        return Hull::default();
    }
    let near = FLAT * size;
    let mut out = Hull::default();
    let mut planes: Vec<(Vec3, f64)> = Vec::new();
    for a in 0..chosen.len() {
        for b in a + 1..chosen.len() {
            for c in b + 1..chosen.len() {
                let normal = (at(b) - at(a)).cross(&(at(c) - at(a)));
                if normal.norm() < near * size {
                    continue;
                }
                let normal = normal.normalize();
                let level = normal.dot(&at(a));
                let known = |(n, d): &(Vec3, f64)| {
                    let same = n.dot(&normal).signum();
                    n.dot(&normal).abs() > 1.0 - 1e-6 && (d * same - level).abs() < near
                };
                if planes.iter().any(known) {
                    continue;
                }
                let heights: Vec<f64> = (0..chosen.len())
                    .map(|k| normal.dot(&at(k)) - level)
                    .collect();
                let above = heights.iter().any(|h| *h > near);
                let below = heights.iter().any(|h| *h < -near);
                if above && below {
                    continue;
                }
                planes.push((normal, level));
                let inside = (0..chosen.len()).filter(|k| heights[*k].abs() <= near);
                let face = around(
                    &inside.map(|k| chosen[k]).collect::<Vec<_>>(),
                    points,
                    &normal,
                );
                out.add(face);
            }
        }
    }
    if out.faces.is_empty() {
        out.edges.push(ends(&chosen, points));
    }
    out
}

impl Hull {
    fn add(&mut self, face: Vec<usize>) {
        for (k, &from) in face.iter().enumerate() {
            let to = face[(k + 1) % face.len()];
            let edge = [from.min(to), from.max(to)];
            if !self.edges.contains(&edge) {
                self.edges.push(edge);
            }
        }
        self.faces.push(face);
    }
}

/// Returns the indices of distinct points. Large clouds are thinned to the points farthest out in many directions.
fn extreme(points: &[Vec3]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    let size = points
        .iter()
        .map(|p| (p - points[0]).norm())
        .fold(0.0, f64::max);
    let fresh = |kept: &[usize], k: usize| {
        kept.iter()
            .all(|&other| (points[other] - points[k]).norm() > FLAT * size)
    };
    if points.len() <= MOST {
        for k in 0..points.len() {
            if fresh(&kept, k) {
                kept.push(k);
            }
        }
        return kept;
    }
    for n in 0..MOST {
        // The golden angle spreads directions evenly over the sphere.
        let z = 1.0 - 2.0 * (n as f64 + 0.5) / MOST as f64;
        let turn = 2.399_963_229_728_653 * n as f64;
        let across = (1.0 - z * z).sqrt();
        let direction = Vec3::new(across * libm::cos(turn), across * libm::sin(turn), z);
        let farthest = (0..points.len()).max_by(|a, b| {
            direction
                .dot(&points[*a])
                .total_cmp(&direction.dot(&points[*b]))
        });
        if let Some(k) = farthest.filter(|k| fresh(&kept, *k)) {
            kept.push(k);
        }
    }
    kept
}

/// Returns the corners of the convex polygon around points in a plane, in order (Andrew's monotone chain). `inside` holds the indices of the
/// points.
fn around(inside: &[usize], points: &[Vec3], normal: &Vec3) -> Vec<usize> {
    let first = points[inside[0]];
    let across = inside
        .iter()
        .map(|&k| points[k] - first)
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_else(Vec3::x)
        .normalize();
    let up = normal.cross(&across);
    let flat = |k: usize| {
        let p = points[k] - first;
        (p.dot(&across), p.dot(&up))
    };
    let mut sorted: Vec<usize> = inside.to_vec();
    sorted.sort_by(|&a, &b| {
        let (a, b) = (flat(a), flat(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let area = |o: usize, a: usize, b: usize| {
        let (o, a, b) = (flat(o), flat(a), flat(b));
        (a.0 - o.0) * (b.1 - o.1) - (a.1 - o.1) * (b.0 - o.0)
    };
    let chain = |order: &mut dyn Iterator<Item = usize>| {
        let mut out: Vec<usize> = Vec::new();
        for k in order {
            while out.len() > 1 && area(out[out.len() - 2], out[out.len() - 1], k) <= 0.0 {
                out.pop();
            }
            out.push(k);
        }
        out.pop();
        out
    };
    let mut out = chain(&mut sorted.iter().copied());
    out.extend(chain(&mut sorted.iter().rev().copied()));
    out
}

/// Returns the two chosen points that are farthest apart.
fn ends(chosen: &[usize], points: &[Vec3]) -> [usize; 2] {
    let mut best = ([chosen[0], chosen[0]], -1.0);
    for &a in chosen {
        for &b in chosen {
            let length = (points[a] - points[b]).norm();
            if a < b && length > best.1 {
                best = ([a, b], length);
            }
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[[f64; 3]]) -> Vec<Vec3> {
        list.iter().map(|p| Vec3::from(*p)).collect()
    }

    #[test]
    fn a_cube_has_six_square_faces_and_hides_what_is_inside() {
        let mut corners: Vec<[f64; 3]> = (0..8)
            .map(|k| [f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)])
            .collect();
        corners.push([0.5, 0.5, 0.5]);
        corners.push([0.5, 0.5, 1.0]);
        corners.push([0.0, 0.0, 0.0]);
        let hull = hull(&points(&corners));
        assert_eq!(hull.faces.len(), 6);
        assert!(hull.faces.iter().all(|face| face.len() == 4));
        assert_eq!(hull.edges.len(), 12);
        assert!(hull.edges.iter().flatten().all(|k| *k < 8));
    }

    #[test]
    fn flat_and_straight_clouds_keep_their_dimension() {
        let square = points(&[
            [0., 0., 0.],
            [2., 0., 0.],
            [2., 2., 0.],
            [0., 2., 0.],
            [1., 1., 0.],
        ]);
        let flat = hull(&square);
        assert_eq!((flat.faces.len(), flat.edges.len()), (1, 4));
        let line = points(&[[0., 0., 0.], [3., 0., 0.], [1., 0., 0.]]);
        assert_eq!(hull(&line).edges, vec![[0, 1]]);
        assert_eq!(hull(&line[..1]), Hull::default());
        assert_eq!(hull(&[]), Hull::default());
    }

    #[test]
    fn of_a_ball_of_many_points_enough_is_left() {
        let ball: Vec<Vec3> = (0..500)
            .map(|k| {
                let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 500.0;
                let across = (1.0 - z * z).sqrt();
                let turn = 2.4 * f64::from(k);
                Vec3::new(across * turn.cos(), across * turn.sin(), z)
            })
            .collect();
        let hull = hull(&ball);
        // Euler's formula: corners - edges + faces = 2.
        let mut corners: Vec<usize> = hull.edges.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        assert_eq!(corners.len() + hull.faces.len(), hull.edges.len() + 2);
        assert!(corners.len() > 20);
    }
}
