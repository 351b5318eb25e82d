//! Numbers of the file that go ill with the deck's own geometry: most are meant in another unit.

use super::bench::Bench;
use super::config::place_of;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Radii of tyres as shares of the track, from those of racing karts to those of tractors.
const RADIUS: (f64, f64) = (0.07, 0.6);
/// Distances of axles as shares of the track, from the axles of a bogie to lorries.
const WHEELBASE: (f64, f64) = (0.5, 6.0);
/// Heights of the centre of mass as shares of the track.
const HEIGHT: (f64, f64) = (0.05, 1.5);

impl Bench<'_> {
    /// Warnings of lengths that no vehicle with this track has.
    pub fn implausible(&self) -> Vec<Diagnostic> {
        let Some(track) = self.track().filter(|track| *track > 0.0) else {
            return Vec::new();
        };
        let config = self.config();
        let (tyre, vehicle) = (config.tyre.as_ref(), config.vehicle.as_ref());
        let lengths = [
            ("tyre.radius", tyre.map(|tyre| tyre.radius), RADIUS),
            ("vehicle.wheelbase", vehicle.map(|v| v.wheelbase), WHEELBASE),
            ("vehicle.cg_height", vehicle.map(|v| v.cg_height), HEIGHT),
        ];
        let warning = |(name, value, (least, most)): (&str, Option<f64>, (f64, f64))| {
            let value = value.filter(|value| !(least..=most).contains(&(value / track)))?;
            let message = format!(
                "`{name}` = {value} is {:.3} of the deck's track of {track:.0}: usual are {least} to {most}",
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
