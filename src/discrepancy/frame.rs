//! The measuring frame of a case: what a shift and a turn of it do to the readings of marks.

use std::f64::consts::PI;

use crate::identify::global::Row;
use crate::mechanics::Vec3;

/// Rows of marks by a shift of the frame of case `of` along each axis and a turn about each, through the centroid of the marks; `places` are
/// those of its readings. One unit of a row is `unit` long.
pub(super) fn by_frame(
    rows: &[Row],
    of: usize,
    places: &[Vec3],
    unit: f64,
) -> [Vec<(usize, f64)>; 6] {
    let mut columns: [Vec<(usize, f64)>; 6] = Default::default();
    let centre = centroid(places);
    for (at, row) in rows.iter().enumerate() {
        let Row::Mark {
            case,
            reading,
            axis,
        } = *row
        else {
            continue;
        };
        if case != of {
            continue;
        }
        let by = at_point(&(places[reading] - centre));
        for (k, column) in columns.iter_mut().enumerate() {
            if by[k][axis] != 0.0 {
                column.push((at, by[k][axis] / unit));
            }
        }
    }
    columns
}

/// What three shifts and three turns do at a point, `lever` away from the centre of the turns.
pub(super) fn at_point(lever: &Vec3) -> [Vec3; 6] {
    std::array::from_fn(|k| match k.checked_sub(3) {
        None => Vec3::ith(k, 1.0),
        Some(k) => Vec3::ith(k, 1.0).cross(lever),
    })
}

/// The mean; zero of none.
pub(super) fn centroid(places: &[Vec3]) -> Vec3 {
    places.iter().sum::<Vec3>() / places.len().max(1) as f64
}

/// A frame that goes on from case to case is followed by so many functions of their order.
pub(super) const DRIFTS: usize = 6;

/// The leading functions of a random walk over `count` cases whose steps have a variance of one, in case `of`: Karhunen and Loeve's
/// `sqrt(2 n) sin(w t / n) / w`, `w = (k - 1/2) pi`.
pub(super) fn drifts(of: usize, count: usize) -> [f64; DRIFTS] {
    let n = count as f64;
    std::array::from_fn(|k| {
        let w = (k as f64 + 0.5) * PI;
        (2.0 * n).sqrt() * libm::sin(w * (of + 1) as f64 / n) / w
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_functions_have_the_variance_of_a_random_walk() {
        for (case, least) in [(5, 0.8), (15, 0.9), (30, 0.95)] {
            let sum: f64 = drifts(case, 31).iter().map(|value| value * value).sum();
            let variance = (case + 1) as f64;
            assert!(sum > least * variance && sum < variance, "{case}: {sum}");
        }
    }
}
