/// Effort for measuring how much the causes improve the prediction of cases that no fit used.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainCheck {
    /// Refits the selected models without the held-out cases. The causes themselves were selected with those cases.
    Quick,
    /// Repeats the search without the held-out cases.
    #[default]
    HeldOut,
    /// Repeats the search without the held-out cases, and once more without each group of the cross-validation.
    Folds,
}
