use admire_diagnosis::GainCheck;
use admire_identify::LoadedStudy;
use admire_kc::Config;
use admire_syntax::text::Source;

/// Task run for every case.
#[derive(Clone, Debug)]
pub enum Task {
    /// Command file.
    Commands(Source),
    /// K&C tests of a `kc.toml`.
    Tests(Box<Config>),
    /// Identification or diagnosis of a study whose deck varies, and how thoroughly the gain of the causes is checked.
    Study(Box<LoadedStudy>, GainCheck),
}
