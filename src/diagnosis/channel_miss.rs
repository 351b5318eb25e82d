use admire_syntax::text::Decimals;

/// How far the model misses a channel, rms over all its readings.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelMiss {
    /// The channel.
    pub name: String,
    /// Its unit with a blank before it, or nothing.
    pub behind: String,
    /// As the model was, after its best fit.
    pub before: f64,
    /// As it is extended.
    pub after: f64,
    /// Of a reading.
    pub noise: f64,
}

impl ChannelMiss {
    /// The same in words.
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
