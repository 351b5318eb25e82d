use std::fmt::Write as _;

/// Width and height of the picture of an interval, in pixels.
const SIZE: (f64, f64) = (136.0, 20.0);

/// Logarithmic scale on which intervals are drawn relative to their estimates. It makes parameters of very different size comparable.
#[derive(Clone, Copy, Debug)]
pub(super) struct IntervalScale {
    /// Upper end of the scale, as a ratio to the estimate. The lower end is its reciprocal.
    reach: f64,
    /// Colour class in which the intervals are drawn.
    colour: &'static str,
}

impl IntervalScale {
    /// Creates a scale from the ends of 95 percent intervals, divided by their estimates. The scale covers at most a factor of ten; wider
    /// intervals end in arrows.
    ///
    /// `colour` is the colour class of the intervals.
    pub(crate) fn over(ratios: impl Iterator<Item = f64>, colour: &'static str) -> Self {
        let widest = ratios
            .filter(|ratio| *ratio > 0.0 && ratio.is_finite())
            .map(|ratio| ratio.max(1.0 / ratio))
            .fold(1.0, f64::max);
        let round = [1.02, 1.05, 1.1, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0];
        Self {
            reach: round.into_iter().find(|r| *r >= widest).unwrap_or(10.0),
            colour,
        }
    }

    /// Returns the two ends of the scale as text, for the heading of the column.
    pub(crate) fn ends(&self) -> String {
        let reach = shown(self.reach);
        format!("÷{reach} … ×{reach}")
    }

    /// Draws an interval as a bar, with a dot for the estimate in the middle. `low`, `high` and the reference value are ratios to the
    /// estimate. The reference value is drawn as a diamond of the given colour class. A side that is unbounded
    /// or beyond the scale ends in an arrow.
    pub(crate) fn svg(
        &self,
        low: Option<f64>,
        high: Option<f64>,
        reference: Option<(f64, &str)>,
        text: &str,
    ) -> String {
        let (width, height) = SIZE;
        let (left, right, middle) = (8.0, width - 8.0, height / 2.0);
        let place = |ratio: f64| {
            let share = 0.5 + 0.5 * libm::log(ratio) / libm::log(self.reach);
            left + share.clamp(0.0, 1.0) * (right - left)
        };
        let mut out = format!(
            "<svg class=\"interval\" role=\"img\" aria-label=\"{}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\
             <path class=\"grid\" d=\"M{left} {middle}H{right}M{:.1} 2V{}\"/><g class=\"{}\">",
            super::escape(text),
            width / 2.0,
            height - 2.0,
            self.colour
        );
        let beyond = |side: Option<f64>| {
            side.is_none_or(|ratio| {
                !(1.0 / self.reach * 0.999..=self.reach * 1.001).contains(&ratio)
            })
        };
        let from = low.filter(|ratio| *ratio > 0.0).map_or(left, place);
        let to = high.map_or(right, place);
        let mut push =
            |text: std::fmt::Arguments<'_>| out.write_fmt(text).expect("a String takes all");
        push(format_args!(
            "<path class=\"line\" d=\"M{from:.1} {middle}H{to:.1}\"/>"
        ));
        for (at, open, back) in [(from, beyond(low), 6.0), (to, beyond(high), -6.0)] {
            let (up, down) = (middle - 5.0, middle + 5.0);
            if open {
                push(format_args!(
                    "<path class=\"line\" d=\"M{:.1} {up}L{at:.1} {middle}L{:.1} {down}\"/>",
                    at + back,
                    at + back
                ));
            } else {
                push(format_args!(
                    "<path class=\"line\" d=\"M{at:.1} {up}V{down}\"/>"
                ));
            }
        }
        push(format_args!(
            "<circle cx=\"{:.1}\" cy=\"{middle}\" r=\"3.4\"/></g>",
            place(1.0)
        ));
        if let Some((reference, colour)) = reference.filter(|(ratio, _)| *ratio > 0.0) {
            let at = place(reference);
            push(format_args!(
                "<g class=\"{colour}\"><path d=\"M{at:.1} 3l4.5 7l-4.5 7l-4.5 -7z\" class=\"hollow\"/></g>"
            ));
        }
        push(format_args!("</svg>"));
        out
    }
}

fn shown(ratio: f64) -> String {
    let text = format!("{ratio:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_holds_its_intervals_and_open_sides_end_in_arrows() {
        let scale = IntervalScale::over([0.9, 1.12].into_iter(), "s1");
        assert_eq!(scale.ends(), "÷1.2 … ×1.2");
        let closed = scale.svg(Some(0.9), Some(1.12), Some((1.0, "s4")), "a <b>");
        assert!(closed.contains("a &lt;b&gt;") && closed.matches("class=\"line\"").count() == 3);
        let open = scale.svg(None, Some(3.0), None, "");
        assert_eq!(open.matches('L').count(), 4, "two arrows: {open}");
    }
}
