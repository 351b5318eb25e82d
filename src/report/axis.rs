/// Axis of a chart, with its range and ticks.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    log: bool,
    /// Values at which the axis has a grid line and a label.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// Creates an axis that covers all given values, with about `wanted` ticks. Values that are not finite are ignored. A logarithmic axis
    /// also ignores values that are not positive.
    pub(crate) fn over(values: impl Iterator<Item = f64>, log: bool, wanted: usize) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite() && (!log || *v > 0.0))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        if log {
            Self::logarithmic(low, high, wanted)
        } else {
            Self::linear(low, high, wanted)
        }
    }

    fn linear(low: f64, high: f64, wanted: usize) -> Self {
        let (mut low, mut high) = if low > high { (0.0, 1.0) } else { (low, high) };
        // A range too narrow for double precision is widened.
        let least = 1e-9 * low.abs().max(high.abs()).max(1e-300);
        if high - low <= least {
            let room = if low == 0.0 { 1.0 } else { low.abs() * 0.1 };
            (low, high) = (low - room, high + room);
        }
        let room = 0.05 * (high - low);
        (low, high) = (low - room, high + room);
        let rough = (high - low) / wanted as f64;
        let power = libm::pow(10f64, libm::log10(rough).floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|k| k * power)
            .into_iter()
            .find(|step| *step >= rough)
            .unwrap_or(10.0 * power);
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        Self {
            low,
            high,
            log: false,
            ticks: (first..=last).map(|k| k as f64 * step).collect(),
        }
    }

    fn logarithmic(low: f64, high: f64, wanted: usize) -> Self {
        let (low, high) = if low > high { (0.1, 10.0) } else { (low, high) };
        let (low, high) = (low / 1.25, high * 1.25);
        let decades = libm::log10(high / low);
        // If the axis covers few decades, more ticks are labelled in each decade.
        let steps: &[f64] = if decades < 1.2 {
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0]
        } else if decades < 3.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let every = ((decades / wanted as f64).ceil() as i32).max(1);
        let from = libm::log10(low).floor() as i32;
        let to = libm::log10(high).ceil() as i32;
        let ticks = (from..=to)
            .filter(|power| steps.len() > 1 || power % every == 0)
            .flat_map(|power| steps.iter().map(move |k| k * 10f64.powi(power)))
            .filter(|tick| (low..=high).contains(tick));
        Self {
            low,
            high,
            log: true,
            ticks: ticks.collect(),
        }
    }

    /// Returns both ends as text, followed by 1 if the axis is logarithmic and by 0 otherwise.
    pub(crate) fn ends(&self) -> String {
        format!("{:e} {:e} {}", self.low, self.high, u8::from(self.log))
    }

    /// Returns the position of a value as a fraction of the axis, from 0 to 1. Returns `None` if the value cannot be drawn.
    pub(crate) fn share(&self, value: f64) -> Option<f64> {
        let share = if self.log {
            libm::log(value / self.low) / libm::log(self.high / self.low)
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.is_finite().then_some(share)
    }
}

/// Returns the label of an axis: the quantity with its unit in brackets, such as `toe [deg]`. A name that states its unit stays as it is.
pub fn axis_label(name: &str, unit: &str) -> String {
    if unit.is_empty() || name.ends_with([']', ')']) {
        name.to_string()
    } else {
        format!("{name} [{unit}]")
    }
}

/// Formats the label of a tick without superfluous digits.
pub(super) fn short(value: f64) -> String {
    // A tick at zero may have a rounding error, because ticks are multiples of a step.
    if value.abs() < 1e-12 {
        return "0".to_string();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let digits = (3 - libm::log10(size).floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis::over([0.0, 3.7].into_iter(), false, 5);
        assert_eq!(axis.ticks, [0.0, 1.0, 2.0, 3.0]);
        let narrow = Axis::over([0.9, 1.3].into_iter(), true, 4);
        assert_eq!(narrow.ticks, [1.0, 1.5]);
        let wide = Axis::over([1e-3, 1e9].into_iter(), true, 4);
        assert!((3..=6).contains(&wide.ticks.len()), "{:?}", wide.ticks);
    }

    #[test]
    fn nothing_and_one_value_still_make_an_axis() {
        for log in [false, true] {
            for values in [vec![], vec![f64::NAN], vec![5.0], vec![0.0, -1.0]] {
                let axis = Axis::over(values.into_iter(), log, 5);
                assert!(axis.low < axis.high && axis.low.is_finite());
            }
        }
    }

    #[test]
    fn tick_labels_are_short() {
        let shown = [0.0, 0.5, 1200.0, 1e-5, 2e6].map(short);
        assert_eq!(shown, ["0", "0.5", "1200", "1e-5", "2e6"]);
    }
}
