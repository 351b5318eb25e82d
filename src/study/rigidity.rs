use super::measurement::Measurement;
use super::orientation::{absolute_orientation, extents};
use admire_solver::mechanics::Vec3;

/// Upper limit of a suspension part's deformation, as a fraction of the extent of its marks.
const BENT: f64 = 0.05;
/// Multiple of the noise up to which a misfit is not significant.
const NOISE: f64 = 10.0;

/// A part whose marks cannot all be on it: their misfit to a rigid body far exceeds the deformation of any part.
#[derive(Clone, PartialEq, Debug)]
pub struct ForeignMarks {
    /// Index of the marked part.
    pub part: usize,
    /// Indices of the load cases, more than one; a single case may contain a single wrong reading.
    pub cases: Vec<usize>,
    /// Largest rms of a coordinate's residual after the best rigid motion, in the deck's length unit.
    pub rms: f64,
}

/// Returns every part whose marks belong elsewhere in several cases. No model of an axle explains such readings.
pub fn foreign_marks(measurement: &Measurement) -> Vec<ForeignMarks> {
    let of = |part: usize| {
        let mut cases = Vec::new();
        let mut worst: f64 = 0.0;
        for case in 0..measurement.cases.len() {
            let (on_part, measured) = measurement.pairs(case, part);
            let Ok(fit) = absolute_orientation(&on_part, &measured, 1.0) else {
                continue;
            };
            let squares: f64 = fit.residuals.iter().map(Vec3::norm_squared).sum();
            let rms = (squares / (fit.dof.max(1)) as f64).sqrt();
            if fit.dof > 0 && rms > (BENT * extents(&on_part)[0]).max(NOISE * measurement.sigma) {
                cases.push(case);
                worst = worst.max(rms);
            }
        }
        (cases.len() > 1).then_some(ForeignMarks {
            part,
            cases,
            rms: worst,
        })
    };
    (0..measurement.parts.len()).filter_map(of).collect()
}
