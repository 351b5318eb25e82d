//! `channel-fault`: the gain, the zero or a single value of a measuring channel is wrong.

use admire_identify::global::Row;

use super::super::candidate_effect::{
    CandidateEffect, EffectParameter, Parametrisation, Sensitivity,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;

/// Adds candidates for a wrong gain, a wrong zero and each single wrong reading of every channel.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let measurement = survey.measurement;
    for (channel, info) in measurement.channels.iter().enumerate() {
        let read: Vec<(usize, usize, f64)> = survey
            .rows()
            .iter()
            .enumerate()
            .filter_map(|(at, row)| match *row {
                Row::Channel { case, channel: of } if of == channel => {
                    Some((at, case, measurement.cases[case].channels[channel]?))
                }
                _ => None,
            })
            .collect();
        let size = read
            .iter()
            .map(|(_, _, value)| value.abs())
            .fold(info.sigma, f64::max);
        let mut put = |form: &'static str, number: EffectParameter| {
            let (cause, address) = (Cause::ChannelFault, info.name.clone());
            out.push(CandidateEffect::plain(cause, address, form, vec![number]));
        };
        let off = |name: &str, rows: Vec<(usize, f64)>| {
            EffectParameter::linear(name, size, Sensitivity::Rows(rows))
        };
        // A reading is (1 + gain) times the true value plus the zero; the fit's prediction is taken as the true value. A factor on the
        // reading itself could explain anything, by making the reading vanish. A summary channel has a single value, and therefore neither a
        // gain nor a zero.
        if info.summary.is_some() {
            for (at, ..) in &read {
                put("value", off("value", vec![(*at, -1.0 / info.sigma)]));
            }
            continue;
        }
        let readings: Vec<(usize, f64)> = read
            .iter()
            .map(|(at, _, value)| (*at, value / info.sigma))
            .collect();
        let predicted = readings
            .iter()
            .map(|(at, reading)| (*at, reading + survey.residual(*at)));
        let gain = EffectParameter {
            column: Sensitivity::Rows(predicted.collect()),
            ..EffectParameter::new(
                "gain",
                survey.priors().channel_gain,
                Parametrisation::Gain(readings),
            )
        };
        put("gain", gain);
        let zero = read.iter().map(|(at, _, _)| (*at, -1.0 / info.sigma));
        put("zero", off("zero", zero.collect()));
        for (at, case, _) in &read {
            let label = &measurement.cases[*case].label;
            let name = format!("case {label}");
            put("value", off(&name, vec![(*at, -1.0 / info.sigma)]));
        }
    }
}
