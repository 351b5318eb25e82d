use admire_solver::mechanics::Pose;
use admire_solver::model::{MarkerIx, Model};

/// Part poses and channel values of one case.
pub(super) struct Rest {
    /// In the order of the reality's parts.
    pub poses: Vec<Pose>,
    /// In the order of the measurement's channels.
    pub channels: Vec<f64>,
}

/// Where a marker is.
pub(super) fn place(model: &Model, poses: &[Pose], marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    poses[frame.part.0].compose(&Pose {
        p: frame.qp,
        R: frame.R,
    })
}
