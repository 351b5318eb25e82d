//! Whether curves and sensors move as the model does at its start values: another sign, unit or zero shows before any fit.

use admire_identify::LoadedStudy;
use admire_identify::global::Row;

/// So many readings tell whether a channel moves as the model does.
const ENOUGH: usize = 6;
/// A channel that moves with the model, or against it, has at least this correlation with it.
const TOGETHER: f64 = 0.95;
/// A channel moves if its readings spread by so many of its own noise.
const MOVES: f64 = 10.0;
/// Two sizes are those of a unit apart if they agree with it to this part.
const NEAR: f64 = 0.25;
/// Readings and model have other zeros if they differ by so many times the scatter of their difference.
const SHIFTED: f64 = 3.0;
/// Readings begin at zero if the first is below this part of their spread.
const ZERO: f64 = 0.02;

/// What units are apart: minutes, radians, inches, centimetres, metres.
const UNITS: [(f64, &str); 5] = [
    (60.0, "degrees and minutes"),
    (57.296, "degrees and radians"),
    (25.4, "inches and mm"),
    (10.0, "mm and cm"),
    (1000.0, "mm and m"),
];

/// A channel in the cases where it was read.
struct Beside {
    channel: usize,
    read: Vec<f64>,
    model: Vec<f64>,
}

/// How many channels plainly move as the model does, and what is odd of others; `None` without channels. `residual` is prediction less
/// reading over sigma.
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
            odd.push(format!("{name} moves against the model ({key})"));
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
                "{name} differs by a factor near {factor:.0}: {units}?"
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
                "{name} begins at zero and the model does not ({key})"
            ));
            continue;
        }
        alike += 1;
    }
    (!all.is_empty()).then_some((alike, odd))
}

/// Mean, and standard deviation.
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
