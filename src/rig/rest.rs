use admire_solver::mechanics::Pose;
use admire_solver::model::{MarkerIx, Model};

/// Equilibrium of one load case: part poses and channel values.
pub(super) struct Rest {
    /// Poses of the parts, in the order of the model's parts.
    pub poses: Vec<Pose>,
    /// Channel values, in the order of the channels of the measurement.
    pub channels: Vec<f64>,
}

/// Returns the pose of a marker in ground, given the poses of all parts.
pub(super) fn place(model: &Model, poses: &[Pose], marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    poses[frame.part.0].compose(&Pose {
        p: frame.qp,
        R: frame.R,
    })
}
