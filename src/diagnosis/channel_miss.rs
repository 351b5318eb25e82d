use super::diagnose::Outcome;
use super::fit::FittedModel;
use admire_identify::global::Row;

/// Rms errors of the original and of the extended model over all readings of one channel.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelMiss {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel with a leading blank; empty if the channel has no unit.
    pub behind: String,
    /// Rms error of the original model after its best fit.
    pub before: f64,
    /// Rms error of the extended model after its fit.
    pub after: f64,
    /// Standard deviation of the noise of one reading.
    pub noise: f64,
}

impl Outcome<'_> {
    /// Returns the rms errors of both models for each channel.
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
