use admire_diagnosis::GainCheck;
use admire_identify::LoadedStudy;
use admire_kc::Config;
use admire_syntax::text::Source;

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
