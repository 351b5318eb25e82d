/// What kind of analysis a step of results comes from.
#[derive(
    Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "camelCase")]
pub enum StepKind {
    /// The model as it was read, before any analysis.
    Input,
    /// The state at the start of a dynamic run.
    InitialConditions,
    /// A lone static equilibrium.
    Static,
    /// One of a sequence of static equilibria over time.
    QuasiStatic,
    /// An equilibrium, as some versions call a static one.
    Equilibrium,
    /// A kinematic step.
    Kinematic,
    /// A step of time integration.
    Dynamic,
    /// A kind that is not in this list. Its name stays with the block it stands in.
    Unlisted,
}

impl StepKind {
    /// Kinds with a name of their own.
    pub const NAMED: [Self; 7] = [
        Self::Input,
        Self::InitialConditions,
        Self::Static,
        Self::QuasiStatic,
        Self::Equilibrium,
        Self::Kinematic,
        Self::Dynamic,
    ];

    /// The attribute `type` of a Step.
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

    /// The name of a Data block without its number.
    pub(crate) const fn block_name(self) -> &'static str {
        match self {
            Self::Input => "modelInput",
            other => other.step_type(),
        }
    }

    /// The kind of a step from its `type`, upper and lower case alike.
    pub(crate) fn from_step_type(text: &str) -> Self {
        Self::NAMED
            .into_iter()
            .find(|kind| kind.step_type().eq_ignore_ascii_case(text))
            .unwrap_or(Self::Unlisted)
    }

    /// True for the kinds that hold a static equilibrium; all of them are read alike (guide/formats.md 12).
    pub const fn is_equilibrium(self) -> bool {
        matches!(self, Self::Static | Self::QuasiStatic | Self::Equilibrium)
    }
}
