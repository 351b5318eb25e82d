//! Curves of one reading over one load, with the measurement and the models.

use super::axis::axis_label;
use super::number::capitalised;
use super::scene::Role;
use super::{Chart, DrawingError, Figure, Series};

/// Curve of one reading over one load, with all other loads constant and the cases in the order of application. It is given as measured, and as
/// computed by each model.
#[derive(Clone, Debug)]
pub(super) struct LoadRun {
    /// Name of the reading, such as `toe`.
    pub what: String,
    /// Unit of the reading; empty if it has none.
    pub unit: String,
    /// Label of the load, with its unit.
    pub load: String,
    /// Series of the measurement and of the models, the best model last.
    pub series: Vec<Series>,
    /// True if no fit saw the readings.
    pub unseen: bool,
}

/// Most informative readings of an axle, in the order in which they are shown.
const FIRST: [&[&str]; 2] = [&["toe", "steer"], &["camber"]];

impl LoadRun {
    /// Returns the chart of the run. The label of its y axis states the positive direction.
    fn chart(&self) -> Chart {
        let mut y = axis_label(&self.what, &self.unit);
        if let Some(sign) = positive(&self.what) {
            y += &format!(", + {sign}");
        }
        // The label of the axis contains the unit, so the title omits it.
        let load = self.load.split(" [").next().unwrap_or_default();
        let is_word = load.chars().all(|c| c.is_ascii_lowercase());
        let end = if is_word { " load" } else { "" };
        Chart {
            title: capitalised(&format!("{} against {load}{end}", self.what)),
            x: self.load.clone(),
            y,
            series: self.series.clone(),
            ..Chart::default()
        }
    }

    /// Returns the reduction of the error from the first model to the last, relative to the range of the reading. NaN without readings or without a
    /// second model.
    pub(super) fn gain(&self) -> f64 {
        let is_read = |series: &&Series| series.role == Some(Role::Measured);
        let (read, models): (Vec<_>, Vec<_>) = self.series.iter().partition(is_read);
        let ([read], [first, .., last]) = (read.as_slice(), models.as_slice()) else {
            return f64::NAN;
        };
        let read = &read.points;
        let [low, high] = read
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
                [low.min(p.1), high.max(p.1)]
            });
        let error = |model: &[(f64, f64)]| {
            let squares = read.iter().enumerate().filter_map(|(k, p)| {
                // The model has fewer points than the readings if its loop was reduced to a single pass.
                let own = if model.len() == read.len() {
                    model.get(k)
                } else {
                    model.iter().find(|own| own.0 == p.0)
                };
                Some((own?.1 - p.1).powi(2))
            });
            (squares.sum::<f64>() / read.len() as f64).sqrt()
        };
        (error(&first.points) - error(&last.points)) / (high - low)
    }
}

/// Draws runs. Charts of the same reading share one scale. The caption states whether a fit used the readings.
pub(super) fn figures(runs: &[LoadRun]) -> Result<Vec<Figure>, DrawingError> {
    let mut charts: Vec<Chart> = runs.iter().map(LoadRun::chart).collect();
    Chart::equalise(&mut charts);
    let drawn = charts.iter().zip(runs).map(|(chart, run)| {
        let caption = if run.unseen {
            "The other loads are constant. These readings are held out of the fit."
        } else {
            "The other loads are constant."
        };
        Figure::chart(chart, caption)
    });
    drawn.collect()
}

/// Chooses the pair of runs that best shows the improvement by a fit. The pair is toe and camber over the load at which the model gains most on both
/// together. If there is no such pair, the two runs with the largest gain are chosen.
pub(super) fn telling(runs: &[LoadRun]) -> Vec<LoadRun> {
    let known: Vec<&LoadRun> = runs.iter().filter(|run| run.gain().is_finite()).collect();
    let pair = |load: &str| -> Vec<&LoadRun> {
        let of = |names: &&[&str]| {
            let mut own = known.iter().copied();
            own.find(|run| run.load == load && names.contains(&run.what.as_str()))
        };
        FIRST.iter().filter_map(of).collect()
    };
    let pairs = known.iter().map(|run| pair(&run.load));
    let gain = |pair: &[&LoadRun]| pair.iter().map(|run| run.gain()).sum::<f64>();
    let best = pairs
        .filter(|pair| !pair.is_empty())
        .max_by(|a, b| gain(a).total_cmp(&gain(b)));
    let chosen = best.unwrap_or_else(|| {
        let mut sorted = known.clone();
        sorted.sort_by(|a, b| b.gain().total_cmp(&a.gain()));
        sorted.truncate(2);
        sorted
    });
    chosen.into_iter().cloned().collect()
}

/// Returns the positive direction of a reading of a wheel, in words.
pub(super) fn positive(what: &str) -> Option<&'static str> {
    Some(match what {
        "toe" => "toe-in",
        "camber" => "top outboard",
        "caster" => "top rearward",
        "steer" => "about +z",
        "travel" | "wheel travel" => "jounce",
        "base" | "base change" => "rearward",
        "track" | "track change" => "right",
        "roll centre height" => "up",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(what: &str, load: &str, off: f64) -> LoadRun {
        let line = |by: f64| vec![(0.0, by), (1.0, 1.0 + by)];
        LoadRun {
            what: what.to_string(),
            unit: "deg".to_string(),
            load: load.to_string(),
            series: vec![
                Series::of(Role::Measured, line(0.0)),
                Series::of(Role::Given, line(off)),
                Series::of(Role::Extended, line(0.0)),
            ],
            unseen: false,
        }
    }

    #[test]
    fn toe_and_camber_of_the_load_that_tells_most_are_chosen() {
        let runs = [
            run("travel", "Fz [N]", 0.1),
            run("toe", "Fz [N]", 0.1),
            run("toe", "Fy [N]", 0.3),
            run("camber", "Fz [N]", 0.2),
            run("camber", "Fy [N]", 0.2),
        ];
        let names = |runs: &[LoadRun]| -> Vec<String> {
            let chosen = telling(runs);
            chosen.iter().map(|run| run.chart().title).collect()
        };
        assert_eq!(names(&runs), ["Toe against Fy", "Camber against Fy"]);
        assert_eq!(names(&runs[..1]), ["Travel against Fz"]);
        assert_eq!(runs[1].chart().y, "toe [deg], + toe-in");
    }
}
