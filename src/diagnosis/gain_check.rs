/// How much is done to learn what the causes gain in cases that were not used.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainCheck {
    /// Refits without these cases, causes chosen with them: no search besides the first.
    Quick,
    /// A second search that does not see the cases held out.
    #[default]
    HeldOut,
    /// Besides, one for each group of the cross-validation.
    Folds,
}
