//! Summaries of curves as readings: gradients and loop widths, as a laboratory reports them.
//!
//! A gradient is the slope of the least-squares line through a curve `y` plotted over `x`, which is a load or another curve, within a sequence
//! of load cases: `g = sum (x - mean x)(y - mean y) / sum (x - mean x)^2`. The loop width at a load value is the mean of the curve at this
//! value while the load falls, minus its mean while the load rises. Between cases, the curve is interpolated linearly. Source: guide page
//! `study`, section "Gradients and widths".

/// Kind of summary of a curve.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SummaryKind {
    /// Gradient: slope of the least-squares line.
    Gradient,
    /// Width of the loop at this value of the load.
    Width(f64),
}

/// Abscissa over which a curve is plotted.
#[derive(Clone, PartialEq, Debug)]
pub enum Over {
    /// A load. The vector holds its value in each of the cases, in the unit of the study's file.
    Load(Vec<f64>),
    /// A channel, given by its index.
    Channel(usize),
}

/// A summary of a channel over several load cases.
#[derive(Clone, PartialEq, Debug)]
pub struct Summary {
    /// Kind of the summary.
    pub kind: SummaryKind,
    /// Abscissa over which the channel is plotted.
    pub over: Over,
    /// Load cases of the curve, in the order of application.
    pub cases: Vec<usize>,
    /// Change of the abscissa that a gradient refers to, such as 100 for a gradient per 100 N.
    pub per: f64,
}

/// Value of a summary, with its derivatives with respect to all values of the curve and of the abscissa.
#[derive(Clone, PartialEq, Debug)]
pub struct Taken {
    /// Value of the summary.
    pub value: f64,
    /// Derivative with respect to the value of the curve in each case.
    pub by_curve: Vec<f64>,
    /// Derivative with respect to the abscissa in each case.
    pub by_over: Vec<f64>,
}

impl Summary {
    /// Computes the summary of a curve. `curve` holds the values of the curve in the cases of the summary. If the abscissa is a channel,
    /// `channel` returns the values of this channel in the same cases. If the summary is undefined, its value is zero.
    pub fn take(&self, curve: &[f64], channel: &dyn Fn(usize) -> Vec<f64>) -> Taken {
        let x = match &self.over {
            Over::Load(values) => values.clone(),
            Over::Channel(other) => channel(*other),
        };
        match self.kind {
            SummaryKind::Gradient => gradient(&x, curve, self.per),
            SummaryKind::Width(at) => {
                let by_curve = weights(&x, at).unwrap_or_else(|| vec![0.0; x.len()]);
                Taken {
                    value: by_curve.iter().zip(curve).map(|(w, y)| w * y).sum(),
                    by_over: vec![0.0; x.len()],
                    by_curve,
                }
            }
        }
    }
}

fn gradient(x: &[f64], y: &[f64], per: f64) -> Taken {
    let count = x.len() as f64;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
    let (middle, height) = (mean(x), mean(y));
    let square: f64 = x.iter().map(|x| (x - middle).powi(2)).sum();
    let scale = if square > 0.0 { per / square } else { 0.0 };
    let by_curve: Vec<f64> = x.iter().map(|x| (x - middle) * scale).collect();
    let value: f64 = by_curve.iter().zip(y).map(|(w, y)| w * y).sum();
    let each = x.iter().zip(y);
    let by_over =
        each.map(|(x, y)| ((y - height) * scale) - 2.0 * value * (x - middle) * scale / per);
    Taken {
        value,
        by_over: by_over.collect(),
        by_curve,
    }
}

/// Returns the weights of the curve values in the loop width at the load value `at`. `x` holds the load in each case. Returns `None` if the
/// load does not pass this value in both directions.
pub(super) fn weights(x: &[f64], at: f64) -> Option<Vec<f64>> {
    let mut ways = [vec![0.0; x.len()], vec![0.0; x.len()]];
    let mut counts = [0.0; 2];
    for k in 0..x.len() {
        if x[k] == at {
            let before = if k == 0 { x[k] } else { x[k - 1] };
            let after = x.get(k + 1).copied().unwrap_or(x[k]);
            let way = match after - before {
                rise if rise > 0.0 => 1,
                rise if rise < 0.0 => 0,
                _ => continue,
            };
            ways[way][k] += 1.0;
            counts[way] += 1.0;
        } else if let Some(next) = x.get(k + 1)
            && (x[k] - at) * (next - at) < 0.0
        {
            let way = usize::from(*next > x[k]);
            let part = (at - x[k]) / (next - x[k]);
            ways[way][k] += 1.0 - part;
            ways[way][k + 1] += part;
            counts[way] += 1.0;
        }
    }
    let [falling, rising] = counts;
    let both = falling > 0.0 && rising > 0.0;
    let each = ways[0].iter().zip(&ways[1]);
    both.then(|| {
        each.map(|(down, up)| down / falling - up / rising)
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(kind: SummaryKind, over: Over, count: usize) -> Summary {
        Summary {
            kind,
            over,
            cases: (0..count).collect(),
            per: 100.0,
        }
    }

    #[test]
    fn a_line_has_its_slope_and_derivatives_are_those_of_differences() {
        let x = [-20.0, -5.0, 3.0, 11.0, 30.0];
        let line: Vec<f64> = x.iter().map(|x| 0.7 - 0.0032 * x).collect();
        let own = summary(SummaryKind::Gradient, Over::Channel(0), 5);
        let taken = own.take(&line, &|_| x.to_vec());
        assert!((taken.value + 0.32).abs() < 1e-12);
        let y = [0.3, -0.4, 0.9, 0.2, 1.7];
        let taken = own.take(&y, &|_| x.to_vec());
        let step = 1e-5;
        for k in 0..5 {
            let at = |of_x: f64, of_y: f64| {
                let (mut x, mut y) = (x.to_vec(), y);
                x[k] += of_x;
                y[k] += of_y;
                own.take(&y, &|_| x.clone()).value
            };
            let by_x = (at(step, 0.0) - at(-step, 0.0)) / (2.0 * step);
            let by_y = (at(0.0, step) - at(0.0, -step)) / (2.0 * step);
            assert!((by_x - taken.by_over[k]).abs() < 1e-7, "{k}");
            assert!((by_y - taken.by_curve[k]).abs() < 1e-7, "{k}");
        }
    }

    /// A straight line that is shifted by 0.4 against the direction of loading, as by dry friction, has a loop width of 0.8. This holds at a
    /// measured point and between two points.
    #[test]
    fn a_loop_has_its_width() {
        let x = [0.0, 10.0, 20.0, 10.0, 0.0, -10.0, -20.0, -10.0, 0.0, 10.0];
        let ways = [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
        let y: Vec<f64> = x
            .iter()
            .zip(ways)
            .map(|(x, way)| 0.1 * x - 0.4 * way)
            .collect();
        for at in [0.0, 5.0] {
            let own = summary(SummaryKind::Width(at), Over::Load(x.to_vec()), 10);
            let taken = own.take(&y, &|_| Vec::new());
            assert!((taken.value - 0.8).abs() < 1e-12, "{at}: {}", taken.value);
        }
        assert!(weights(&x, 25.0).is_none() && weights(&[0.0, 1.0, 2.0], 1.0).is_none());
    }
}
