use admire_syntax::text::Decimals;

/// Rms error of a model over all readings of one channel.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelMiss {
    /// Name of the channel.
    pub name: String,
    /// Unit with a leading blank; empty if the channel has none.
    pub behind: String,
    /// Rms error of the original model after its best fit.
    pub before: f64,
    /// Rms error of the extended model.
    pub after: f64,
    /// Standard deviation of the noise of one reading.
    pub noise: f64,
}

impl ChannelMiss {
    /// Returns a sentence that states both errors and the noise.
    pub fn sentence(&self) -> String {
        let decimals = Decimals::of_error(self.noise);
        let [before, after, noise] =
            [self.before, self.after, self.noise].map(|x| decimals.told(x));
        format!(
            "Channel {} is missed by {before}{unit} rms as the model was and by {after}{unit} as it is extended, where its noise is {noise}{unit}.",
            self.name,
            unit = self.behind
        )
    }
}
