//! Warnings about lengths in the file that do not fit the deck's track, usually because of a wrong unit.

use super::bench::Bench;
use super::config::place_of;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Smallest and largest plausible ratio of tyre radius to track, from racing karts to tractors.
const RADIUS_PER_TRACK: (f64, f64) = (0.07, 0.6);
/// Smallest and largest plausible ratio of wheelbase to track, from bogies to lorries.
const WHEELBASE_PER_TRACK: (f64, f64) = (0.5, 6.0);
/// Smallest and largest plausible ratio of the height of the centre of mass to track.
const CG_HEIGHT_PER_TRACK: (f64, f64) = (0.05, 1.5);

impl Bench<'_> {
    /// Returns one warning for each length that is implausible for the deck's track.
    pub fn implausible(&self) -> Vec<Diagnostic> {
        let Some(track) = self.track().filter(|track| *track > 0.0) else {
            return Vec::new();
        };
        let config = self.config();
        let (tyre, vehicle) = (config.tyre.as_ref(), config.vehicle.as_ref());
        let lengths = [
            (
                "tyre.radius",
                tyre.map(|tyre| tyre.radius),
                RADIUS_PER_TRACK,
            ),
            (
                "vehicle.wheelbase",
                vehicle.map(|v| v.wheelbase),
                WHEELBASE_PER_TRACK,
            ),
            (
                "vehicle.cg_height",
                vehicle.map(|v| v.cg_height),
                CG_HEIGHT_PER_TRACK,
            ),
        ];
        let warning = |(name, value, (least, most)): (&str, Option<f64>, (f64, f64))| {
            let value = value.filter(|value| !(least..=most).contains(&(value / track)))?;
            let message = format!(
                "`{name}` = {value} is {:.3} times the track of {track:.0} (both in the deck's length unit); usual ratios are {least} to {most}",
                value / track
            );
            let span = Span::from(place_of(&config.source, name));
            let warning = Diagnostic::warning(Code::BadSetting, message);
            Some(warning.label(config.source.name(), span, ""))
        };
        lengths.into_iter().filter_map(warning).collect()
    }

    /// Returns the lateral distance between the wheel centres at design.
    fn track(&self) -> Option<f64> {
        let frame = &self.config().frame;
        let across = |wheel: &super::rig::FoundWheel| frame.vector(&wheel.design.p).y;
        match self.wheels.as_slice() {
            [one] if self.config().mirror => Some(2.0 * across(one).abs()),
            [one, other] => Some((across(one) - across(other)).abs()),
            _ => None,
        }
    }
}
