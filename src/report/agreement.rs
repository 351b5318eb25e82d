//! Check of the channels (curves and sensors) against the model at its start values. Before any fit, it reveals a wrong sign, unit or zero.

use admire_identify::LoadedStudy;
use admire_identify::global::Row;

/// Minimum number of readings for judging a channel.
const ENOUGH: usize = 6;
/// Minimum absolute correlation at which a channel counts as moving with the model, or against it.
const TOGETHER: f64 = 0.95;
/// Minimum standard deviation of a channel's readings, in units of its noise, at which the channel counts as moving.
const MOVES: f64 = 10.0;
/// Relative tolerance for comparing a ratio of motions with a ratio of units.
const NEAR: f64 = 0.25;
/// Ratio of the mean difference between readings and model to its standard deviation, above which the zero of the channel counts as different.
const SHIFTED: f64 = 3.0;
/// Largest first reading that counts as zero, relative to the standard deviation of the readings.
const ZERO: f64 = 0.02;

/// Ratios between units that are easily confused, and the names of these units.
const UNITS: [(f64, &str); 5] = [
    (60.0, "degrees and minutes"),
    (57.296, "degrees and radians"),
    (25.4, "inches and mm"),
    (10.0, "mm and cm"),
    (1000.0, "mm and m"),
];

/// Readings of one channel, and the model's values in the same cases.
struct Beside {
    channel: usize,
    read: Vec<f64>,
    model: Vec<f64>,
}

/// Compares each channel with the model. Returns the number of channels that clearly follow the model, and one sentence for each suspicious
/// channel. Returns `None` without channels. `residual` is prediction minus reading, in units of sigma.
pub(super) fn agreement(
    loaded: &LoadedStudy,
    rows: &[Row],
    residual: &[f64],
) -> Option<(usize, Vec<String>)> {
    let to = &loaded.measurement;
    let mut all: Vec<Beside> = (0..to.channels.len())
        .map(|channel| Beside {
            channel,
            read: Vec::new(),
            model: Vec::new(),
        })
        .collect();
    for (row, residual) in rows.iter().zip(residual) {
        let Row::Channel { case, channel } = *row else {
            continue;
        };
        if let Some(read) = to.cases[case].channels[channel] {
            let beside = &mut all[channel];
            let model = read + residual * to.channels[channel].sigma;
            beside.read.push(read);
            beside.model.push(model);
        }
    }
    let mut alike = 0;
    let mut odd = Vec::new();
    for beside in &all {
        let channel = &to.channels[beside.channel];
        let noise = if channel.sigma_estimated {
            0.0
        } else {
            channel.sigma
        };
        let [(_, read), (_, model)] = [&beside.read, &beside.model].map(|values| spread(values));
        let together = correlation(&beside.read, &beside.model);
        if beside.read.len() < ENOUGH || read <= MOVES * noise || channel.summary.is_some() {
            continue;
        }
        let is_curve = !channel.helpers.is_empty();
        let name = &channel.name;
        if together < -TOGETHER {
            let key = if is_curve {
                format!("kc.curves.{name}.sign, kc.forward")
            } else {
                format!("readings.channels.{name}.function")
            };
            odd.push(format!(
                "{name} moves against the model: check its sign ({key})"
            ));
            continue;
        }
        if together < TOGETHER {
            continue;
        }
        let times = (model / read).max(read / model);
        let unit = UNITS
            .iter()
            .find(|(factor, _)| (times / factor - 1.0).abs() < NEAR);
        if let Some((factor, units)) = unit {
            odd.push(format!(
                "{name} differs from the model by a factor of about {factor:.0}: were {units} confused?"
            ));
            continue;
        }
        let begins = channel.relative_to.is_none() && beside.read[0].abs() < ZERO * read;
        let apart: Vec<f64> = beside
            .read
            .iter()
            .zip(&beside.model)
            .map(|(a, b)| a - b)
            .collect();
        let (mean, scatter) = spread(&apart);
        if begins && mean.abs() > SHIFTED * scatter {
            let key = if is_curve {
                "kc.relative_to"
            } else {
                "relative_to"
            };
            odd.push(format!(
                "{name} starts at zero but the model does not: check {key}"
            ));
            continue;
        }
        alike += 1;
    }
    (!all.is_empty()).then_some((alike, odd))
}

/// Returns the mean and the standard deviation of the values.
fn spread(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / count).sqrt())
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let ((ma, sa), (mb, sb)) = (spread(a), spread(b));
    let products: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    let size = sa * sb * a.len().max(1) as f64;
    if size > 0.0 { products / size } else { 0.0 }
}
