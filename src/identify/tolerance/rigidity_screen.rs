//! Screening of marks for consistency with rigid parts, without a model of the axle.

use std::collections::BTreeMap;

use super::part_marks::{
    Mark, PartMarks, RigidityVerdict, centres, coordinates, find_single_outlier, residuals,
};
use crate::settings::{MARK_SCREENING_PASSES, SD_PER_MEDIAN_ABSOLUTE};
use admire_solver::mechanics::Vec3;
use admire_study::Measurement;

/// A single wrong reading of a mark.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkOutlier {
    /// Index of the load case.
    pub case: usize,
    /// Index into the mark readings of the case.
    pub reading: usize,
    /// Measured position minus the position that the other marks of the part imply, in ground axes.
    pub error: Vec3,
}

/// Result of the rigidity screen of all marks.
#[derive(Default)]
pub(super) struct RigidityScreen {
    /// Blocks of marks (one part in one case) that are consistent with a rigid part, without outliers.
    pub blocks: Vec<PartMarks>,
    /// Readings that are outliers.
    pub outliers: Vec<MarkOutlier>,
    /// Case and part of blocks that contain an error but do not show which mark is wrong.
    pub suspects: Vec<(usize, usize)>,
    /// Robust standard deviation per mark coordinate, from the median absolute residual.
    pub sigma: f64,
}

impl RigidityScreen {
    /// Screens the blocks of marks in `all`, which hold the marks of each part in each case.
    pub(super) fn new(measurement: &Measurement, all: &[PartMarks]) -> Self {
        let none = BTreeMap::new();
        // The first estimates are robust, so outliers do not define the normal spread. With few cases, outliers still affect the spread until
        // they are excluded, so the screen is repeated.
        let mut sorted = Self {
            blocks: all.to_vec(),
            ..Self::default()
        };
        for _ in 0..MARK_SCREENING_PASSES {
            let rough = residuals(measurement, &sorted.blocks, &none);
            let centre = centres(&rough, true);
            let sigma = mad_sigma(coordinates(measurement, &rough, &centre));
            let again = Self::at(measurement, all.to_vec(), &centre, sigma);
            let is_same = again.blocks == sorted.blocks && again.suspects == sorted.suspects;
            sorted = again;
            if is_same {
                break;
            }
        }
        sorted
    }

    /// Screens the blocks of marks. `centre` holds the offset of each mark from its listed position; `sigma` is the standard deviation per
    /// coordinate.
    fn at(
        measurement: &Measurement,
        mut blocks: Vec<PartMarks>,
        centre: &BTreeMap<Mark, Vec3>,
        sigma: f64,
    ) -> Self {
        let (mut outliers, mut suspects) = (Vec::new(), Vec::new());
        if sigma > 0.0 {
            blocks.retain_mut(|block| {
                loop {
                    let (on_part, measured) = block.places(measurement, centre);
                    match find_single_outlier(&on_part, &measured, sigma) {
                        RigidityVerdict::Fine => return true,
                        RigidityVerdict::Wrong(at, error) => outliers.push(MarkOutlier {
                            case: block.case,
                            reading: block.readings.remove(at),
                            error,
                        }),
                        RigidityVerdict::Mixed => {
                            suspects.push((block.case, block.part));
                            return false;
                        }
                    }
                }
            });
        }
        Self {
            blocks,
            outliers,
            suspects,
            sigma,
        }
    }
}

/// Returns the standard deviation of values about zero, estimated robustly from the median of their absolute values.
pub fn mad_sigma(mut values: Vec<f64>) -> f64 {
    values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    SD_PER_MEDIAN_ABSOLUTE
        * values
            .get(values.len() / 2)
            .map_or(0.0, |value| value.abs())
}
