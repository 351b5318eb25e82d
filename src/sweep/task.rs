use crate::discrepancy::GainCheck;
use crate::identify::LoadedStudy;
use crate::kc::Config;
use crate::text::Source;

/// What is run for a case.
#[derive(Clone, Debug)]
pub enum Task {
    /// A command file.
    Commands(Source),
    /// The K&C tests of a `kc.toml`.
    Tests(Box<Config>),
    /// Identification or diagnosis of a study, whose deck varies, and how much is done to learn what the causes gain.
    Study(Box<LoadedStudy>, GainCheck),
}
