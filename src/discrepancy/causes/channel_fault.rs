//! `channel-fault`: a reading's gain, zero or single value is wrong.

use crate::identify::global::Row;

use super::super::cause::Cause;
use super::super::hypothesis::{Column, Hypothesis, Number};
use super::super::survey::Survey;

/// Every channel: its gain, its zero, and each single reading.
pub(super) fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
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
        let mut put = |form: &'static str, name: &str, sd: f64, rows: Vec<(usize, f64)>| {
            out.push(Hypothesis::plain(
                Cause::ChannelFault,
                info.name.clone(),
                form,
                vec![Number::linear(name, sd, Column::Rows(rows))],
            ));
        };
        // The reading is (1 + gain) times the truth plus a zero. The truth is what the fit predicts: a factor on the reading itself
        // would explain anything by making it nothing.
        // A single number has no gain and zero of its own.
        if info.summary.is_some() {
            for (at, ..) in &read {
                put("value", "value", size, vec![(*at, -1.0 / info.sigma)]);
            }
            continue;
        }
        let gain = read
            .iter()
            .map(|(at, _, value)| (*at, value / info.sigma + survey.misfit(*at)));
        put("gain", "gain", 0.1, gain.collect());
        let zero = read.iter().map(|(at, _, _)| (*at, -1.0 / info.sigma));
        put("zero", "zero", size, zero.collect());
        for (at, case, _) in &read {
            let label = &measurement.cases[*case].label;
            put(
                "value",
                &format!("case {label}"),
                size,
                vec![(*at, -1.0 / info.sigma)],
            );
        }
    }
}
