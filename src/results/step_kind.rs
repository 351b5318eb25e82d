/// Kind of analysis in which an output step was computed.
#[derive(
    Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "camelCase")]
pub enum StepKind {
    /// The model as it was read, before any analysis.
    Input,
    /// The state at the start of a dynamic simulation, after its initial conditions were computed.
    InitialConditions,
    /// A single static equilibrium.
    Static,
    /// One of several static equilibria in a simulation over time.
    QuasiStatic,
    /// A static equilibrium, under the name that some versions of ADAMS use.
    Equilibrium,
    /// A step of a kinematic simulation.
    Kinematic,
    /// A step of a dynamic simulation, found by time integration.
    Dynamic,
    /// A kind that this list does not contain; the name of the Data block shows which kind it is.
    Unlisted,
}

impl StepKind {
    /// All kinds except `Unlisted`.
    pub const NAMED: [Self; 7] = [
        Self::Input,
        Self::InitialConditions,
        Self::Static,
        Self::QuasiStatic,
        Self::Equilibrium,
        Self::Kinematic,
        Self::Dynamic,
    ];

    /// Returns the `type` attribute that a Step element of this kind has in XRF files.
    pub const fn step_type(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::InitialConditions => "initialConditions",
            Self::Static => "static",
            Self::QuasiStatic => "quasiStatic",
            Self::Equilibrium => "equilibrium",
            Self::Kinematic => "kinematic",
            Self::Dynamic => "dynamic",
            Self::Unlisted => "unlisted",
        }
    }

    /// Returns the name of a Data block of this kind, without the number at its end.
    pub(crate) const fn block_name(self) -> &'static str {
        match self {
            Self::Input => "modelInput",
            other => other.step_type(),
        }
    }

    /// Returns the kind that belongs to a `type` attribute; case is ignored.
    pub(crate) fn from_step_type(text: &str) -> Self {
        Self::NAMED
            .into_iter()
            .find(|kind| kind.step_type().eq_ignore_ascii_case(text))
            .unwrap_or(Self::Unlisted)
    }

    /// Returns true for all kinds of static equilibria, which readers treat alike (guide/formats.md 12).
    pub const fn is_equilibrium(self) -> bool {
        matches!(self, Self::Static | Self::QuasiStatic | Self::Equilibrium)
    }
}
