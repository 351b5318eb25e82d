use super::diagnose::Outcome;
use super::fit::FittedModel;
use admire_identify::global::Row;

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

impl Outcome<'_> {
    /// How far each channel is missed.
    pub fn channels(&self) -> Vec<ChannelMiss> {
        let measurement = self.subject.problem.measurement;
        let mut out = Vec::new();
        for (channel, info) in measurement.channels.iter().enumerate() {
            let rows = self.subject.rows.iter().enumerate().filter(
                |(_, row)| matches!(row, Row::Channel { channel: of, .. } if *of == channel),
            );
            let of = |fitted: &FittedModel| {
                let squares = rows.clone().map(|(k, _)| fitted.residual[k].powi(2));
                (squares.sum::<f64>() / rows.clone().count().max(1) as f64).sqrt() * info.sigma
            };
            if rows.clone().next().is_some() {
                out.push(ChannelMiss {
                    name: info.name.clone(),
                    behind: info.behind(),
                    before: of(&self.baseline),
                    after: of(&self.extended),
                    noise: info.sigma,
                });
            }
        }
        out
    }
}
