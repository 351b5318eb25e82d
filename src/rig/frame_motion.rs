//! Common rigid motion of all marks on a virtual rig, due to a misaligned measuring frame and a mount that yields under the loads.

use super::tolerances::Tolerances;
use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::{Mat3, Vec3, exp};
use admire_study::Noise;

/// Common rigid motion of all marks: misalignment of the measuring frame, and displacement of the mount under each load. Each consists of a
/// shift and a rotation vector.
pub(super) struct FrameMotion {
    alignment: (Vec3, Vec3),
    /// For each load: its largest absolute value, and the shift and rotation vector of the mount at that value.
    mount: Vec<(f64, Vec3, Vec3)>,
}

impl FrameMotion {
    /// Draws the motions at random. Returns `None` if all their standard deviations are zero.
    pub(super) fn new(
        tolerances: &Tolerances,
        seed: u64,
        programme: &LoadProgramme,
    ) -> Option<Self> {
        let t = tolerances;
        if [t.alignment, t.alignment_deg, t.mount, t.mount_deg] == [0.0; 4] {
            return None;
        }
        let drawn = |noise: &mut Noise, length: f64, degrees: f64| {
            (noise.vector(length), noise.vector(degrees.to_radians()))
        };
        let mut noise = Noise::new(seed, "alignment");
        let alignment = drawn(&mut noise, t.alignment, t.alignment_deg);
        let mut noise = Noise::new(seed, "mount");
        let of = |load: usize| {
            let values = programme.cases.iter().map(|case| case.values[load].abs());
            let (shift, turn) = drawn(&mut noise, t.mount, t.mount_deg);
            (values.fold(f64::MIN_POSITIVE, f64::max), shift, turn)
        };
        Some(Self {
            alignment,
            mount: (0..programme.loads.len()).map(of).collect(),
        })
    }

    /// Returns the common shift and rotation of all marks under these loads.
    pub(super) fn under(&self, loads: &[f64]) -> (Vec3, Mat3) {
        let (mut shift, mut turn) = self.alignment;
        for ((largest, by, about), load) in self.mount.iter().zip(loads) {
            shift += by * (load / largest);
            turn += about * (load / largest);
        }
        (shift, exp(&turn))
    }
}
