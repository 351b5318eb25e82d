use admire_diagnosis::GainCheck;
use admire_identify::LoadedStudy;
use admire_kc::Config;
use admire_syntax::text::Source;

/// Task run for every case.
#[derive(Clone, Debug)]
pub enum Task {
    /// Runs a command file.
    Commands(Source),
    /// Runs the K&C tests of a `kc.toml`.
    Tests(Box<Config>),
    /// Identification or diagnosis of a study whose deck is varied. The second field says how thoroughly the gain of each cause is checked.
    Study(Box<LoadedStudy>, GainCheck),
}
