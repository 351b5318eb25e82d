//! Tyre data that the characteristics of an axle need.

/// Tyre data in the units of the deck.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tyre {
    /// Unloaded radius R0.
    pub radius: f64,
    /// Vertical stiffness Kt of one tyre; `None` means a rigid tyre.
    pub stiffness: Option<f64>,
}
