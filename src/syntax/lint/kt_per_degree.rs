use super::context::Context;
use crate::Argument;
use crate::diagnostic::{Code, Diagnostic};
use crate::units::LENGTH_UNITS;

/// Shortest plausible lever arm sqrt(KT/K), in m. A shorter lever arm suggests that the rotational stiffness KT was given per degree.
const SHORTEST_LEVER: f64 = 2.5e-3;

/// Reports a KT of a bushing that looks like a stiffness per degree.
///
/// sqrt(KT/K) is the lever arm at which a translational stiffness K gives the rotational stiffness KT. In rubber bushings, it is about as
/// long as the rubber, 5 to 50 mm. A KT per degree is 57.3 times too small, so its lever arm is sqrt(57.3) = 7.6 times too short.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    let Some(metre) = length_unit(context) else {
        return;
    };
    for bushing in context.of_kind("BUSHING") {
        let largest = |name| {
            let values = bushing.numbers(name).iter().map(|number| number.value);
            values.fold(0.0, f64::max)
        };
        let (k, kt) = (largest("K"), largest("KT"));
        let degrees = bushing.numbers("KT").iter().any(|number| number.degrees);
        if !(k > 0.0 && kt > 0.0) || degrees || was_converted(kt) {
            continue;
        }
        let lever = (kt / k).sqrt() * metre;
        if lever >= SHORTEST_LEVER {
            continue;
        }
        let place = bushing
            .argument("KT")
            .map_or(bushing.keyword, Argument::value_span);
        let message = format!(
            "KT of {} looks like a stiffness per degree: sqrt(KT/K) is only {:.2} mm",
            context.title(bushing),
            lever * 1e3
        );
        found.push(
            context
                .warning(Code::KtPerDegree, place, message)
                .help("KT is per radian: multiply a stiffness per degree by 57.29578"),
        );
    }
}

/// Returns true if KT is 57.29578 times a number with few digits. Such a value was already converted from per degree to per radian.
fn was_converted(kt: f64) -> bool {
    let digits = |value: f64| {
        let scaled = value / 10f64.powi(libm::log10(value).floor() as i32 - 3);
        (scaled - scaled.round()).abs() < 1e-5 * scaled
    };
    digits(kt.to_radians()) && !digits(kt)
}

/// Returns the length unit of the dataset in metres, if the dataset states it.
fn length_unit(context: &Context<'_>) -> Option<f64> {
    let units = context.of_kind("UNITS").next()?;
    let word = *units
        .argument("LENGTH")?
        .choices(context.dataset.source())
        .first()?;
    let unit = LENGTH_UNITS.iter().find(|unit| unit.keyword == word)?;
    Some(unit.si)
}
