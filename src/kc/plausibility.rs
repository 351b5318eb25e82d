//! Lengths of the file that do not fit the deck's track. The usual reason is another unit.

use super::bench::Bench;
use super::config::place_of;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Least and largest radius of a tyre per track, from racing karts to tractors.
const RADIUS_PER_TRACK: (f64, f64) = (0.07, 0.6);
/// Least and largest wheelbase per track, from the axles of a bogie to lorries.
const WHEELBASE_PER_TRACK: (f64, f64) = (0.5, 6.0);
/// Least and largest height of the centre of mass per track.
const CG_HEIGHT_PER_TRACK: (f64, f64) = (0.05, 1.5);

impl Bench<'_> {
    /// One warning for each length that no vehicle with this track has.
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
                "`{name}` = {value} is {:.3} of the deck's track of {track:.0}; usual shares are {least} to {most}",
                value / track
            );
            let span = Span::from(place_of(&config.source, name));
            let warning = Diagnostic::warning(Code::BadSetting, message);
            Some(warning.label(config.source.name(), span, ""))
        };
        lengths.into_iter().filter_map(warning).collect()
    }

    /// Distance of the wheel centres at design, across the vehicle.
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
