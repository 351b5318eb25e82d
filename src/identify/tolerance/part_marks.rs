//! Rigidity check of the marks of one part in one load case against each other.

use crate::settings::{
    AGREEING_MARKS_CHI_SQUARE, CLEAR_OUTLIER_CHI_SQUARE, OUTLIER_MARK_SIGMA, SUSPECT_MARK_SIGMA,
};
use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DVector;

use admire_solver::mechanics::{Pose, Vec3};
use admire_study::Measurement;
use admire_study::orientation::absolute_orientation;

/// A mark: index of its part, and index of the mark on the part.
pub(super) type Mark = (usize, usize);

/// Block of marks: the readings of the marks of one part in one load case.
#[derive(Clone, PartialEq)]
pub(super) struct PartMarks {
    pub case: usize,
    pub part: usize,
    /// Indices into the mark readings of the case.
    pub readings: Vec<usize>,
}

impl PartMarks {
    /// Returns the listed positions of the marks on the part, each with its `shift` added, and the measured positions.
    pub(super) fn places(
        &self,
        measurement: &Measurement,
        shift: &BTreeMap<Mark, Vec3>,
    ) -> (Vec<Vec3>, Vec<Vec3>) {
        let marks = &measurement.cases[self.case].marks;
        let of = |reading: &usize| {
            let mark = marks[*reading];
            let own = (self.part, mark.mark);
            let shift = shift.get(&own).copied().unwrap_or_default();
            (
                measurement.parts[self.part].marks[mark.mark].p + shift,
                mark.x,
            )
        };
        self.readings.iter().map(of).unzip()
    }
}

/// Returns the block of marks of each part in each case, without the marks in `left_out`. Blocks with fewer than three marks are omitted.
pub(super) fn part_marks(measurement: &Measurement, left_out: &BTreeSet<Mark>) -> Vec<PartMarks> {
    let mut out = Vec::new();
    for (case, read) in measurement.cases.iter().enumerate() {
        for part in 0..measurement.parts.len() {
            let readings: Vec<usize> = (0..read.marks.len())
                .filter(|k| {
                    let mark = read.marks[*k];
                    mark.part == part && !left_out.contains(&(part, mark.mark))
                })
                .collect();
            if readings.len() > 2 {
                out.push(PartMarks {
                    case,
                    part,
                    readings,
                });
            }
        }
    }
    out
}

/// Key of a residual: index of the case, index of the reading in the case, and the mark.
pub(super) type Key = (usize, usize, Mark);

/// Groups residuals of marks by case and part.
fn by_block(residuals: &[(Key, Vec3)]) -> BTreeMap<(usize, usize), Vec<(Key, Vec3)>> {
    let mut out: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for (key, e) in residuals {
        let block: &mut Vec<(Key, Vec3)> = out.entry((key.0, key.2.0)).or_default();
        block.push((*key, *e));
    }
    out
}

/// Returns the residuals of all blocks after subtracting each mark's centre (its mean or median residual over the cases). They are
/// projected on the directions that no rigid motion changes.
pub(super) fn coordinates(
    measurement: &Measurement,
    residuals: &[(Key, Vec3)],
    centre: &BTreeMap<Mark, Vec3>,
) -> Vec<f64> {
    let mut out = Vec::new();
    for (block, own) in by_block(residuals) {
        let marks = &measurement.cases[block.0].marks;
        let place = |reading: usize| measurement.parts[block.1].marks[marks[reading].mark].p;
        let places: Vec<Vec3> = own.iter().map(|(key, _)| place(key.1)).collect();
        let e: Vec<f64> = own
            .iter()
            .flat_map(|(key, e)| {
                let e = e - centre.get(&key.2).copied().unwrap_or_default();
                [e.x, e.y, e.z]
            })
            .collect();
        out.extend(deformation_coordinates(&places, &DVector::from_vec(e)));
    }
    out
}

/// Projects the residuals `e` of the marks of one block on an orthonormal basis of the directions that no rigid motion changes. Each result has
/// the variance of one coordinate.
pub(super) fn deformation_coordinates(places: &[Vec3], e: &DVector<f64>) -> Vec<f64> {
    let n = e.len();
    let centroid = places.iter().sum::<Vec3>() / places.len() as f64;
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut orthogonal = |mut column: DVector<f64>, least: f64| {
        let size = column.norm();
        for _ in 0..2 {
            for known in &basis {
                let along = known.dot(&column);
                column.axpy(-along, known, 1.0);
            }
        }
        let left = column.norm();
        if left > least * size {
            basis.push(column / left);
        }
        basis.len()
    };
    let mut rigid = 0;
    for k in 0..6 {
        let of = |mark: &Vec3| {
            if k < 3 {
                Vec3::ith(k, 1.0)
            } else {
                Vec3::ith(k - 3, 1.0).cross(&(mark - centroid))
            }
        };
        let column = places.iter().flat_map(|mark| {
            let v = of(mark);
            [v.x, v.y, v.z]
        });
        rigid = orthogonal(DVector::from_iterator(n, column), 1e-9);
    }
    for k in 0..n {
        let mut unit = DVector::zeros(n);
        unit[k] = 1.0;
        orthogonal(unit, 1e-3);
    }
    basis[rigid..]
        .iter()
        .map(|direction| direction.dot(e))
        .collect()
}

/// Returns the residual of each reading in part axes, after the best-fit rigid motion of its block. `centre` holds an offset of each mark
/// that is added to its listed position.
pub(super) fn residuals(
    measurement: &Measurement,
    blocks: &[PartMarks],
    centre: &BTreeMap<Mark, Vec3>,
) -> Vec<(Key, Vec3)> {
    let mut out = Vec::new();
    for block in blocks {
        let marks = &measurement.cases[block.case].marks;
        let (on_part, measured) = block.places(measurement, centre);
        let Ok(fit) = absolute_orientation(&on_part, &measured, 1.0) else {
            continue;
        };
        for (k, e) in block.readings.iter().zip(&fit.residuals) {
            let key = (block.case, *k, (block.part, marks[*k].mark));
            out.push((key, fit.pose.R.transpose() * e));
        }
    }
    out
}

/// Returns the centre of each mark: its mean or median residual over the cases. The result is empty for fewer than three cases, because the
/// centres would then absorb most of the noise.
pub(super) fn centres(residuals: &[(Key, Vec3)], median: bool) -> BTreeMap<Mark, Vec3> {
    let mut by_mark: BTreeMap<Mark, Vec<Vec3>> = BTreeMap::new();
    for (key, e) in residuals {
        by_mark.entry(key.2).or_default().push(*e);
    }
    let cases = by_mark.values().map(Vec::len).max().unwrap_or(0);
    if cases < 3 {
        return BTreeMap::new();
    }
    let centre = |list: Vec<Vec3>| {
        Vec3::from_fn(|axis, _| {
            let mut values: Vec<f64> = list.iter().map(|e| e[axis]).collect();
            if median {
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            } else {
                values.iter().sum::<f64>() / values.len() as f64
            }
        })
    };
    by_mark
        .into_iter()
        .map(|(key, list)| (key, centre(list)))
        .collect()
}

/// Verdict on whether the marks of a block fit a rigid part.
pub(super) enum RigidityVerdict {
    /// The marks are consistent with one rigid part.
    Fine,
    /// A single mark is wrong, and the other marks agree with each other. The fields are the index of the wrong mark and its error.
    Wrong(usize, Vec3),
    /// The marks are inconsistent, but no single mark can be named as the cause.
    Mixed,
}

/// Looks for a single wrong mark in a block. `sigma` is the standard deviation per mark coordinate.
pub(super) fn find_single_outlier(
    on_part: &[Vec3],
    measured: &[Vec3],
    sigma: f64,
) -> RigidityVerdict {
    let count = on_part.len();
    if count < 3 {
        return RigidityVerdict::Fine;
    }
    let Ok(all) = absolute_orientation(on_part, measured, 1.0) else {
        return RigidityVerdict::Fine;
    };
    let largest = all.residuals.iter().map(Vec3::amax).fold(0.0, f64::max);
    let usual = sigma * (1.0 - 6.0 / (3.0 * count as f64)).sqrt();
    if count == 3 {
        // Three marks reveal an error in their plane, but not which mark is wrong.
        return if largest > 2.0 * SUSPECT_MARK_SIGMA * usual {
            RigidityVerdict::Mixed
        } else {
            RigidityVerdict::Fine
        };
    }
    if largest < SUSPECT_MARK_SIGMA * usual {
        return RigidityVerdict::Fine;
    }
    let mut without: Vec<(f64, usize, Vec3)> = (0..count)
        .filter_map(|out| {
            let (pose, rest) = pose_of_others(on_part, measured, out)?;
            Some((rest, out, measured[out] - pose.point(&on_part[out])))
        })
        .collect();
    without.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(rest, at, error)) = without.first() else {
        return RigidityVerdict::Fine;
    };
    let variance = sigma * sigma;
    let freedom = (3 * (count - 1) - 6) as f64;
    let agree = rest < AGREEING_MARKS_CHI_SQUARE * freedom * variance;
    // If four marks lie in a plane and one is displaced perpendicular to it, any of the four may be the wrong one.
    let is_clear = without
        .get(1)
        .is_none_or(|next| next.0 - rest > CLEAR_OUTLIER_CHI_SQUARE * variance);
    let is_far = error.amax() > OUTLIER_MARK_SIGMA * sigma;
    match (agree && is_far, is_clear) {
        (true, true) => RigidityVerdict::Wrong(at, error),
        (true, false) => RigidityVerdict::Mixed,
        // Heavy-tailed noise produces such blocks as well, so only blocks with large residuals are rejected.
        _ if !(agree && is_clear) && largest > 2.0 * SUSPECT_MARK_SIGMA * sigma => {
            RigidityVerdict::Mixed
        }
        _ => RigidityVerdict::Fine,
    }
}

/// Returns the pose from all marks of a block except mark `out`, and the sum of the squared residuals of these marks.
pub(super) fn pose_of_others(
    on_part: &[Vec3],
    measured: &[Vec3],
    out: usize,
) -> Option<(Pose, f64)> {
    let keep = |list: &[Vec3]| -> Vec<Vec3> {
        let kept = list.iter().enumerate().filter(|(k, _)| *k != out);
        kept.map(|(_, v)| *v).collect()
    };
    let fit = absolute_orientation(&keep(on_part), &keep(measured), 1.0).ok()?;
    Some((fit.pose, fit.residuals.iter().map(Vec3::norm_squared).sum()))
}
