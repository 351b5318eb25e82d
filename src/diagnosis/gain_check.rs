/// Effort spent to measure how much the causes improve the prediction of unused cases.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainCheck {
    /// Refits the models without the held-out cases. The causes were selected with those cases; no second search is run.
    Quick,
    /// Repeats the search without the held-out cases.
    #[default]
    HeldOut,
    /// Repeats the search without the held-out cases, and once for each group of the cross-validation.
    Folds,
}
