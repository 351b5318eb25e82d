use admire_solver::mechanics::Pose;
use admire_solver::model::{MarkerIx, Model};

/// Part poses and channel values at the equilibrium of one case.
pub(super) struct Rest {
    /// Part poses, in the order of the ground truth's parts.
    pub poses: Vec<Pose>,
    /// Channel values, in the order of the measurement's channels.
    pub channels: Vec<f64>,
}

/// Returns the pose of a marker in ground.
pub(super) fn place(model: &Model, poses: &[Pose], marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    poses[frame.part.0].compose(&Pose {
        p: frame.qp,
        R: frame.R,
    })
}
