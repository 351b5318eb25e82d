//! Marks sorted into those that fit rigid parts and others, without any model.

use std::collections::BTreeMap;

use super::part_marks::{
    Mark, PartMarks, RigidityVerdict, centres, coordinates, find_single_outlier, residuals,
};
use admire_solver::mechanics::Vec3;
use admire_study::Measurement;

/// Marks are sorted so often at most.
const PASSES: usize = 4;
/// Scale of the median of absolute values for a Gaussian.
const MAD: f64 = 1.4826;

/// One reading of one mark that is wrong.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkOutlier {
    /// Load case.
    pub case: usize,
    /// Index into the readings of the case.
    pub reading: usize,
    /// How far it lies from where the other marks put it, ground axes.
    pub error: Vec3,
}

/// What fits rigid parts, and what does not.
#[derive(Default)]
pub(super) struct RigidityScreen {
    /// Marks that agree.
    pub blocks: Vec<PartMarks>,
    /// Readings that are plainly wrong.
    pub outliers: Vec<MarkOutlier>,
    /// Case and part of marks of which some are wrong that cannot be told from the others.
    pub suspects: Vec<(usize, usize)>,
    /// Standard deviation of a coordinate, by the median.
    pub sigma: f64,
}

impl RigidityScreen {
    /// Sorts the marks of all parts in all cases.
    pub(super) fn new(measurement: &Measurement, all: &[PartMarks]) -> Self {
        let none = BTreeMap::new();
        // Robust first: what is plainly wrong must not decide what plain is. In few cases it does, until it is left out.
        let mut sorted = Self {
            blocks: all.to_vec(),
            ..Self::default()
        };
        for _ in 0..PASSES {
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

    /// By what the others of each part say.
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
                    match find_single_outlier((&on_part, &measured), sigma) {
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

/// Standard deviation by the median of absolute values.
pub fn mad_sigma(mut values: Vec<f64>) -> f64 {
    values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    MAD * values
        .get(values.len() / 2)
        .map_or(0.0, |value| value.abs())
}
