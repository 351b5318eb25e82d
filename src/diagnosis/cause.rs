use std::fmt;

use serde::Serialize;

/// Cause of a discrepancy: an error of the model or of its measurement (guide/study.md).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// Bushing force that grows faster than linearly with the deflection.
    ProgressiveStiffness,
    /// Rate-independent hysteresis in a bushing or joint.
    DryFriction,
    /// Viscous flow of rubber from one load case to the next.
    Creep,
    /// Compliance of a part along the line through its two joints.
    LinkCompliance,
    /// Free play in a joint of a part with two joints, along the line through them.
    FreePlay,
    /// Compliance of the ground-side attachment of a joint or spring.
    BodyCompliance,
    /// Offset between the two sides of a bushing as mounted, compared with the deck.
    AssemblyOffset,
    /// Wrong location of the connection point of a joint or spring.
    HardpointError,
    /// Bushing mounted with a rotation about one of its axes.
    BushingOrientation,
    /// Off-diagonal stiffness of a bushing, which couples two of its components.
    BushingCoupling,
    /// Wrong value of a deck parameter that the study takes as known.
    ElementParameter,
    /// One-sided spring (stop) that engages once a clearance is used up.
    StopContact,
    /// Wrong scale factor of a load.
    LoadGain,
    /// Cross-talk between loads: a fraction of one load also acts along another load.
    LoadCrosstalk,
    /// Load applied at a point other than its marker.
    LoadPointError,
    /// Displacement of the measuring frame in a single load case.
    FrameDrift,
    /// Declared noise level that disagrees with the noise of the data.
    NoiseLevel,
    /// Gross error of a single mark reading. A mark is a measured point on a part.
    MarkOutlier,
    /// Mark that is listed at a wrong position on its part, or has come loose.
    MarkPlace,
    /// Fault of a measuring channel: a wrong gain, a wrong zero, or a single wrong value.
    ChannelFault,
    /// Force whose law is not in the catalogue of causes. Such a force is never a finding; it is reported as the unexplained remainder.
    UnmodelledForce,
}

impl Cause {
    /// Returns the name used in `diagnosis.json`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::ProgressiveStiffness => "progressive-stiffness",
            Self::DryFriction => "dry-friction",
            Self::Creep => "creep",
            Self::LinkCompliance => "link-compliance",
            Self::FreePlay => "free-play",
            Self::BodyCompliance => "body-compliance",
            Self::AssemblyOffset => "assembly-offset",
            Self::HardpointError => "hardpoint-error",
            Self::BushingOrientation => "bushing-orientation",
            Self::BushingCoupling => "bushing-coupling",
            Self::ElementParameter => "element-parameter",
            Self::StopContact => "stop-contact",
            Self::LoadGain => "load-gain",
            Self::LoadCrosstalk => "load-crosstalk",
            Self::LoadPointError => "load-point-error",
            Self::FrameDrift => "frame-drift",
            Self::NoiseLevel => "noise-level",
            Self::MarkOutlier => "mark-outlier",
            Self::MarkPlace => "mark-place",
            Self::ChannelFault => "channel-fault",
            Self::UnmodelledForce => "unnamed-force",
        }
    }

    /// Returns true for faults of the readings themselves, which cross-validation by load case cannot confirm.
    pub const fn is_reading_fault(self) -> bool {
        matches!(
            self,
            Self::FrameDrift
                | Self::MarkOutlier
                | Self::MarkPlace
                | Self::ChannelFault
                | Self::NoiseLevel
        )
    }

    /// Returns true for causes that the marks of rigid parts reveal without a model of the axle.
    pub const fn is_told_by_marks(self) -> bool {
        matches!(self, Self::MarkOutlier | Self::MarkPlace | Self::NoiseLevel)
    }

    /// Returns true for a cause whose force law is known in kind but not in shape.
    pub const fn has_rough_law(self) -> bool {
        matches!(
            self,
            Self::DryFriction | Self::ProgressiveStiffness | Self::StopContact
        )
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
