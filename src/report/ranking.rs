//! Table of causes, each with its probability as a bar and its rivals below.

use super::scene::Scene;
use super::{Align, Table, escape, number, short_unit};
use admire_diagnosis::{
    Cause, Diagnosis, Finding, LARGEST_DEFLECTION, LARGEST_RADIAL_DEFLECTION, STIFFNESS_RISES,
};
use admire_identify::LoadedStudy;
use admire_identify::settings::UNIDENTIFIABLE_LN_SD;
use admire_syntax::Address;

/// Width and height of a probability bar, in pixels.
const SIZE: (f64, f64) = (150.0, 14.0);

/// Tabulates the causes, the most important first. The indistinguishable rivals of a cause follow below it.
pub(super) fn ranking(diagnosis: &Diagnosis, loaded: &LoadedStudy, scene: &Scene) -> Table {
    let mut table = Table::new(&[
        ("cause", Align::Left),
        ("place", Align::Left),
        ("probability", Align::Left),
        ("", Align::Right),
        ("size", Align::Wrap),
    ]);
    for finding in &diagnosis.findings {
        let place = scene.named(&finding.address);
        let place = match finding.form.as_deref() {
            Some("point") => format!("{place}, all parts that meet there"),
            Some("part") => format!("{place}, this part only"),
            Some(form) => format!("{place} ({form})"),
            None => place,
        };
        let minor = if finding.minor { " (minor)" } else { "" };
        line(
            &mut table,
            format!("{}{minor}", words(finding.cause)),
            place,
            finding.probability,
            known_sizes(finding, loaded),
        );
        for rival in &finding.indistinguishable_from {
            line(
                &mut table,
                format!("or {}", words(rival.cause)),
                scene.named(&rival.address),
                rival.probability,
                String::new(),
            );
            table.mark(0, "soft");
        }
    }
    if !diagnosis.findings.is_empty() {
        line(
            &mut table,
            "no cause of the catalogue".to_string(),
            String::new(),
            diagnosis.none_of_these,
            String::new(),
        );
        table.mark(0, "soft");
    }
    table
}

fn line(table: &mut Table, cause: String, place: String, probability: f64, sizes: String) {
    let text = percent(probability);
    table.row([cause, place, text.clone(), text.clone(), sizes]);
    table.picture(2, bar(probability, &text));
}

/// Returns the name of a cause in words, without hyphens.
pub(super) fn words(cause: Cause) -> String {
    cause.to_string().replace('-', " ")
}

fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.0 => "> 99 %".to_string(),
        p if p < 1.0 => "< 1 %".to_string(),
        p => format!("{p:.0} %"),
    }
}

fn bar(probability: f64, text: &str) -> String {
    let (width, height) = SIZE;
    let full = width * probability.clamp(0.0, 1.0);
    format!(
        "<svg class=\"interval\" role=\"img\" aria-label=\"{}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\
         <path class=\"grid\" d=\"M0.5 1V{:.0}M{:.1} 1V{:.0}\"/><g class=\"s1\"><path d=\"M0 3H{full:.1}V{:.0}H0Z\"/></g></svg>",
        escape(text),
        height - 1.0,
        width - 0.5,
        height - 1.0,
        height - 3.0
    )
}

/// Lists the parameters of a finding with units and standard errors; angles are in degrees. A corrected parameter of the deck is followed by
/// its old value, its new value and the change in percent.
pub fn sizes(finding: &Finding, loaded: &LoadedStudy) -> String {
    listed(finding, loaded, &|_, _| true)
}

/// Lists the parameters of a finding as [`sizes`] does, without those that are not determined.
pub(super) fn known_sizes(finding: &Finding, loaded: &LoadedStudy) -> String {
    listed(finding, loaded, &|value, error| {
        error.is_none_or(|error| error <= UNIDENTIFIABLE_LN_SD * value.abs())
    })
}

fn listed(
    finding: &Finding,
    loaded: &LoadedStudy,
    is_shown: &dyn Fn(f64, Option<f64>) -> bool,
) -> String {
    let units = &loaded.model.units;
    let shown = finding.parameters.iter();
    let shown =
        shown.filter(|(name, value)| is_shown(**value, finding.std_error.get(*name).copied()));
    let texts = shown.map(|(name, value)| {
        let unit = unit(finding.cause, &finding.address, name, loaded);
        let (factor, unit) = match unit.as_str() {
            "rad" => (1f64.to_degrees(), "deg".to_string()),
            _ => (1.0, short_unit(&unit)),
        };
        let error = finding.std_error.get(name).copied();
        let error = error
            .filter(|error| *error > 0.0)
            .map(|error| factor * error);
        // Engineers think in stiffness: a compliance is given as its reciprocal, and itself without an interval.
        if name == "compliance" && *value > 0.0 {
            let (stiffness, error) = (1.0 / value, error.map(|error| error / (value * value)));
            let interval = error.map_or_else(String::new, |error| {
                format!(" ± {}", number(error, Some(error)))
            });
            return format!(
                "stiffness {}{interval} {}/{} (compliance {} {unit})",
                number(stiffness, error),
                short_unit(units.force.word),
                units.length.word,
                number(*value, Some(0.1 * value))
            );
        }
        let mut text = format!(
            "{} {}",
            name.replace('_', " "),
            number(factor * value, error)
        );
        if let Some(error) = error {
            text += &format!(" ± {}", number(error, Some(error)));
        }
        if !unit.is_empty() {
            text += &format!(" {unit}");
        }
        let address = Address::parse(&finding.address, &loaded.dataset).ok();
        let old = address.and_then(|address| loaded.dataset.number_at(&address));
        if let ("change", Some(old)) = (name.as_str(), old) {
            let [from, to] = [old.value, old.value + value].map(|v| number(v, error));
            text += &format!(", from {from} to {to} {unit}");
            if old.value != 0.0 {
                text += &format!(" ({:+.1} %)", 100.0 * value / old.value.abs());
            }
        }
        text
    });
    texts.collect::<Vec<_>>().join("; ")
}

/// Returns the unit of a coupling coefficient in a bushing's energy. The name lists the components that the coefficient multiplies, as in
/// `x-rzrzrz`.
fn of_coupling(name: &str, force: &str, length: &str) -> String {
    let turns = name.matches('r').count();
    let shifts = name.matches(['x', 'y', 'z']).count() - turns;
    let over = |unit: &str, power: usize| match power {
        0 => String::new(),
        1 => format!("/{unit}"),
        _ => format!("/{unit}^{power}"),
    };
    match shifts {
        0 => format!("{force}-{length}{}", over("rad", turns.saturating_sub(1))),
        _ => format!("{force}{}{}", over(length, shifts - 1), over("rad", turns)),
    }
}

/// Returns true for the address of a rotational component of a BUSHING or FIELD.
pub(super) fn is_rotation(address: &str) -> bool {
    address.contains(".KT")
        || [".TX", ".TY", ".TZ"]
            .iter()
            .any(|end| address.ends_with(end))
}

/// Returns the unit of a parameter of a cause; empty if the parameter is dimensionless, or if only the deck defines its unit.
pub(super) fn unit(cause: Cause, address: &str, name: &str, loaded: &LoadedStudy) -> String {
    let units = &loaded.model.units;
    let (force, length) = (units.force.word, units.length.word);
    let turns = is_rotation(address);
    let power = |power: u32| {
        if turns {
            format!("{force}-{length}/rad^{power}")
        } else {
            format!("{force}/{length}^{power}")
        }
    };
    if cause == Cause::ChannelFault && !name.starts_with("gain") {
        let mut channels = loaded.measurement.channels.iter();
        let unit = channels.find(|channel| channel.name == address);
        return unit
            .and_then(|channel| channel.unit.clone())
            .unwrap_or_default();
    }
    // The names of parameters of further terms of a law end in an index.
    let name = name.trim_end_matches(|c: char| c == '_' || c.is_ascii_digit());
    match name {
        _ if cause == Cause::BushingCoupling => of_coupling(name, force, length),
        "quadratic" => power(2),
        "cubic" | "hardening" => power(3),
        "compliance" => format!("{length}/{force}"),
        "force" | "asymmetry" | "law_misfit" if turns => format!("{force}-{length}"),
        "force" | "asymmetry" | "law_misfit" => force.to_string(),
        "anchor" | LARGEST_DEFLECTION if turns => "rad".to_string(),
        LARGEST_DEFLECTION | LARGEST_RADIAL_DEFLECTION => length.to_string(),
        _ if STIFFNESS_RISES.contains(&name) && turns => format!("{force}-{length}/rad"),
        _ if STIFFNESS_RISES.contains(&name) => format!("{force}/{length}"),
        "stiffness" if turns => format!("{force}-{length}/rad"),
        "stiffness" | "contact" => format!("{force}/{length}"),
        // The unit of a deck parameter follows from its argument.
        "change" => match address.split('.').nth(1) {
            Some("K") => format!("{force}/{length}"),
            Some("KT") => format!("{force}-{length}/rad"),
            Some("TORQUE") => format!("{force}-{length}"),
            Some("FORCE") => force.to_string(),
            Some("LENGTH") => length.to_string(),
            _ => String::new(),
        },
        "anchor" | "clearance_shift" | "play" | "sigma" => length.to_string(),
        "rx" | "ry" | "rz" => "rad".to_string(),
        _ if name.starts_with("angle_") => "rad".to_string(),
        "x" | "y" | "z" => match cause {
            Cause::HardpointError
            | Cause::AssemblyOffset
            | Cause::LoadPointError
            | Cause::FrameDrift
            | Cause::MarkPlace
            | Cause::MarkOutlier => length.to_string(),
            _ => String::new(),
        },
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn units_of_couplings() {
        let unit = |name: &str| super::of_coupling(name, "newton", "mm");
        assert_eq!(unit("x-y"), "newton/mm");
        assert_eq!(unit("x-yyy"), "newton/mm^3");
        assert_eq!(unit("y-rx"), "newton/rad");
        assert_eq!(unit("yyy-rx"), "newton/mm^2/rad");
        assert_eq!(unit("y-rxrxrx"), "newton/rad^3");
        assert_eq!(unit("rx-ry"), "newton-mm/rad");
        assert_eq!(unit("rx-ryryry"), "newton-mm/rad^3");
    }
}
