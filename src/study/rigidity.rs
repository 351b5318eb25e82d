use super::measurement::Measurement;
use super::orientation::{absolute_orientation, extents};
use admire_solver::mechanics::Vec3;

/// Upper limit for the deformation of a suspension part, as a fraction of the extent of its marks.
const BENT: f64 = 0.05;
/// Upper limit for a misfit that noise may explain, as a multiple of the noise.
const NOISE: f64 = 10.0;

/// A part with foreign marks: marks (measured points) that cannot all be on this part, because their misfit to a rigid body far exceeds the
/// deformation of any part.
#[derive(Clone, PartialEq, Debug)]
pub struct ForeignMarks {
    /// Index of the marked part.
    pub part: usize,
    /// Indices of the load cases with such a misfit. There are at least two; the misfit in a single case may be due to a wrong reading.
    pub cases: Vec<usize>,
    /// Largest rms residual of the marks in any of these cases after the best-fit rigid motion, per coordinate and in the deck's length unit.
    pub rms: f64,
}

/// Returns every part whose marks do not fit it in several cases. No model of an axle can explain such readings.
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
