/// Kind of analysis that produced a step of results.
#[derive(
    Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "camelCase")]
pub enum StepKind {
    /// The model as it was read, before any analysis.
    Input,
    /// The state at the start of a dynamic run.
    InitialConditions,
    /// A single static equilibrium.
    Static,
    /// One of a sequence of static equilibria over time.
    QuasiStatic,
    /// A static equilibrium, as some versions call it.
    Equilibrium,
    /// A kinematic step.
    Kinematic,
    /// A step of time integration.
    Dynamic,
    /// A kind that is not in this list; the name of its Data block shows which.
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

    /// Returns the `type` attribute of a Step element.
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

    /// Returns the name of a Data block of this kind without its number.
    pub(crate) const fn block_name(self) -> &'static str {
        match self {
            Self::Input => "modelInput",
            other => other.step_type(),
        }
    }

    /// Returns the kind for a `type` attribute; case is ignored.
    pub(crate) fn from_step_type(text: &str) -> Self {
        Self::NAMED
            .into_iter()
            .find(|kind| kind.step_type().eq_ignore_ascii_case(text))
            .unwrap_or(Self::Unlisted)
    }

    /// Returns true for the kinds that hold a static equilibrium; readers treat them alike (guide/formats.md 12).
    pub const fn is_equilibrium(self) -> bool {
        matches!(self, Self::Static | Self::QuasiStatic | Self::Equilibrium)
    }
}
