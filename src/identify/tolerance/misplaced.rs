//! Detection of misplaced marks: marks whose position on the part differs from the listed position, while the other marks of the part agree
//! with the list.

use std::collections::{BTreeMap, BTreeSet};

use super::part_marks::{
    Mark, PartMarks, RigidityVerdict, centres, deformation_coordinates, find_single_outlier,
    part_marks, pose_of_others, residuals,
};
use super::rigidity_screen::{RigidityScreen, mad_sigma};
use crate::settings::{LOOSE_MARK_READINGS, LOOSE_MARK_SPREAD, OUTLIER_MARK_SIGMA};
use admire_solver::mechanics::Vec3;
use admire_study::Measurement;
use nalgebra::DVector;

/// A mark whose position on its part differs from the listed position.
#[derive(Clone, PartialEq, Debug)]
pub struct Misplaced {
    /// Index of the marked part.
    pub part: usize,
    /// Index of the mark on the part.
    pub mark: usize,
    /// Actual minus listed position in part axes, the median over the cases in which the mark is displaced.
    pub error: Vec3,
    /// Standard error of each coordinate of `error`.
    pub sd: f64,
    /// Cases in which the mark is displaced, in ascending order.
    pub cases: Vec<usize>,
    /// Number of cases in which the mark was read together with at least three other marks of its part.
    pub read: usize,
}

impl Misplaced {
    /// Returns true if the mark came loose during the measurement: it is displaced only in some of the cases in which it was read.
    pub fn is_loose(&self) -> bool {
        self.cases.len() < self.read
    }
}

/// Returns the misplaced marks. These are the marks whose median residual over all cases contradicts the list, and the marks with several wrong
/// readings that agree with each other.
pub(super) fn misplaced(measurement: &Measurement, sorted: &RigidityScreen) -> BTreeSet<Mark> {
    let centre = centres(
        &residuals(measurement, &sorted.blocks, &BTreeMap::new()),
        true,
    );
    let mut out = off_the_list(measurement, sorted, &centre);
    let mut wrong: BTreeMap<Mark, Vec<Vec3>> = BTreeMap::new();
    for outlier in &sorted.outliers {
        let read = measurement.cases[outlier.case].marks[outlier.reading];
        let of: &mut Vec<Vec3> = wrong.entry((read.part, read.mark)).or_default();
        of.push(outlier.error);
    }
    for (mark, errors) in wrong {
        let mean = errors.iter().sum::<Vec3>() / errors.len() as f64;
        let is_alike = |e: &Vec3| (e - mean).norm() < LOOSE_MARK_SPREAD * mean.norm();
        if errors.len() >= LOOSE_MARK_READINGS && errors.iter().all(is_alike) {
            out.insert(mark);
        }
    }
    out
}

/// Returns the marks whose median residual contradicts the listed position. A common rigid motion of all listed positions of a part and a small
/// error of each mark do not count.
fn off_the_list(
    measurement: &Measurement,
    sorted: &RigidityScreen,
    centre: &BTreeMap<Mark, Vec3>,
) -> BTreeSet<Mark> {
    let mut parts: BTreeMap<usize, Vec<(usize, Vec3)>> = BTreeMap::new();
    for ((part, mark), shift) in centre {
        let of: &mut Vec<(usize, Vec3)> = parts.entry(*part).or_default();
        of.push((*mark, *shift));
    }
    parts.retain(|_, marks| marks.len() > 2);
    let place = |part: usize, mark: usize| measurement.parts[part].marks[mark].p;
    let listed = |part: usize, marks: &[(usize, Vec3)]| -> Vec<Vec3> {
        marks.iter().map(|(mark, _)| place(part, *mark)).collect()
    };
    let left = parts.iter().flat_map(|(part, marks)| {
        let shifts = marks.iter().flat_map(|(_, e)| [e.x, e.y, e.z]);
        deformation_coordinates(
            &listed(*part, marks),
            &DVector::from_iterator(3 * marks.len(), shifts),
        )
    });
    let usual = mad_sigma(left.collect());
    let cases = measurement.cases.len().max(1) as f64;
    let least = measurement.sigma_on_parts.max(sorted.sigma / cases.sqrt());
    let sigma = usual.max(least);
    let mut out = BTreeSet::new();
    for (part, marks) in &parts {
        let listed = listed(*part, marks);
        let shifts = marks.iter().map(|(_, shift)| shift);
        let seen: Vec<Vec3> = listed.iter().zip(shifts).map(|(p, e)| p + e).collect();
        if sigma > 0.0
            && let RigidityVerdict::Wrong(at, _) = find_single_outlier(&listed, &seen, sigma)
        {
            out.insert((*part, marks[at].0));
        }
    }
    out
}

/// Returns the displacement of each mark in `left_out`, relative to the part poses that the other marks determine. Marks that were never read
/// together with three other marks are omitted.
pub(super) fn misplaced_marks(
    measurement: &Measurement,
    sorted: &RigidityScreen,
    left_out: &BTreeSet<Mark>,
) -> Vec<Misplaced> {
    let centre = centres(
        &residuals(measurement, &sorted.blocks, &BTreeMap::new()),
        false,
    );
    let mut out = Vec::new();
    for &(part, mark) in left_out {
        // Blocks of marks that contain this mark but no other excluded mark.
        let mut others = left_out.clone();
        others.remove(&(part, mark));
        let beside = part_marks(measurement, &others);
        let agrees = |block: &PartMarks, reading: usize| {
            let mut own = sorted.blocks.iter();
            own.any(|of| (of.case, of.part) == (block.case, part) && of.readings.contains(&reading))
        };
        let mut errors: Vec<(usize, Vec3)> = Vec::new();
        for mut block in beside.into_iter().filter(|block| block.part == part) {
            let marks = &measurement.cases[block.case].marks;
            let is_it = |reading: usize| marks[reading].mark == mark;
            let kept = block.clone();
            block.readings.retain(|k| is_it(*k) || agrees(&kept, *k));
            let Some(at) = block.readings.iter().position(|k| is_it(*k)) else {
                continue;
            };
            let (on_part, measured) = block.places(measurement, &centre);
            if block.readings.len() > 3
                && let Some((pose, _)) = pose_of_others(&on_part, &measured, at)
            {
                errors.push((
                    block.case,
                    pose.R.transpose() * (measured[at] - pose.point(&on_part[at])),
                ));
            }
        }
        let read = errors.len();
        if read == 0 {
            continue;
        }
        let far = OUTLIER_MARK_SIGMA * sorted.sigma;
        let mut off = errors.clone();
        off.retain(|(_, error)| error.amax() > far);
        if off.is_empty() {
            off.clone_from(&errors);
        }
        let error = median(&off);
        // If the displacement is clear, only the cases that show it are kept.
        if error.amax() > far {
            off = errors;
            off.retain(|(_, e)| e.dot(&error) > 0.5 * error.norm_squared());
        } else {
            off = errors;
        }
        let around = off.iter().flat_map(|(_, e)| {
            let e = e - error;
            [e.x, e.y, e.z]
        });
        out.push(Misplaced {
            part,
            mark,
            error,
            sd: mad_sigma(around.collect()).max(sorted.sigma) / (off.len() as f64).sqrt(),
            cases: off.into_iter().map(|(case, _)| case).collect(),
            read,
        });
    }
    out
}

/// Returns the median of each component of the errors.
fn median(errors: &[(usize, Vec3)]) -> Vec3 {
    Vec3::from_fn(|axis, _| {
        let mut values: Vec<f64> = errors.iter().map(|(_, e)| e[axis]).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    })
}
