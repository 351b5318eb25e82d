use std::fmt;

use serde::Serialize;

/// What can be wrong with a model or with its measurement (guide/study.md).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// Force grows faster than linearly with a deflection of a bushing.
    ProgressiveStiffness,
    /// Rate-independent hysteresis in a bushing or joint.
    DryFriction,
    /// Rubber flows from case to case.
    Creep,
    /// A part deforms along the line of its two joints.
    LinkCompliance,
    /// A joint of a part with two joints has play along their line.
    FreePlay,
    /// The ground-side attachment of a joint or spring yields.
    BodyCompliance,
    /// The two sides of a bushing sit displaced from where the deck says.
    AssemblyOffset,
    /// The connection point of a joint or spring is elsewhere.
    HardpointError,
    /// A bushing is mounted turned about an axis.
    BushingOrientation,
    /// Off-diagonal stiffness.
    BushingCoupling,
    /// A number taken as known is wrong.
    ElementParameter,
    /// A one-sided spring engages past a clearance.
    StopContact,
    /// A load is wrong by a factor.
    LoadGain,
    /// Part of one load acts along another.
    LoadCrosstalk,
    /// A load acts elsewhere than at its marker.
    LoadPointError,
    /// The measuring frame moved in one load case.
    FrameDrift,
    /// The declared noise is not the noise of the data.
    NoiseLevel,
    /// One mark reading is wrong.
    MarkOutlier,
    /// A mark sits elsewhere on its part than the list says, or came loose.
    MarkPlace,
    /// A reading's gain, zero or single value is wrong.
    ChannelFault,
    /// A force whose law no cause of the catalogue has: never a finding, shown as what remains.
    UnmodelledForce,
}

impl Cause {
    /// The name of `diagnosis.json`.
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

    /// True for faults of single readings, which no cross-validation by load case can name.
    pub const fn of_the_measurement(self) -> bool {
        matches!(
            self,
            Self::FrameDrift
                | Self::MarkOutlier
                | Self::MarkPlace
                | Self::ChannelFault
                | Self::NoiseLevel
        )
    }

    /// True for what the marks tell by themselves, without any model.
    pub const fn is_told_by_marks(self) -> bool {
        matches!(self, Self::MarkOutlier | Self::MarkPlace | Self::NoiseLevel)
    }

    /// True for a cause whose law is known in kind but not in shape.
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
