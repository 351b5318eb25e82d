//! Characteristics of an axle on one page, in the form used by rig laboratories: value, unit, and the sign in words.

use super::number::{rounded, unbroken};
use super::{Align, Table};
use admire_kc::{Gradient, KcRun, Side, TestKind, shown, slope};
use admire_syntax::units::Units;

/// Number of significant digits.
const DIGITS: i32 = 3;
/// Largest relative difference between left and right at which one value represents both sides.
const ALIKE: f64 = 5e-3;

/// Source of a characteristic.
#[derive(Clone, Copy, Debug)]
enum From {
    /// Reading at ride height, given by the name of its request. The component follows from the side.
    Ride(&'static str),
    /// Reading at ride height that belongs to the axle, given by the name of the request and the component.
    Axle(&'static str, &'static str),
    /// Slope of a reading at ride height, from a test.
    Slope(TestKind, &'static str),
}

/// Characteristic of the summary.
#[derive(Clone, Copy, Debug)]
struct Line {
    name: &'static str,
    from: From,
    /// Words for a positive and for a negative value; empty if the sign has no meaning.
    words: [&'static str; 2],
    /// Words after the value that state the condition, such as `bounce`.
    per: &'static str,
}

const fn line(name: &'static str, from: From, words: [&'static str; 2], per: &'static str) -> Line {
    Line {
        name,
        from,
        words,
        per,
    }
}

const TOE: [&str; 2] = ["toe-in", "toe-out"];
const CAMBER: [&str; 2] = ["top outboard", "top inboard"];

/// Sections of the summary with their characteristics.
///
/// Signs are those of the left wheel in the axes of Adams/Car. In a lateral test, the force points to the right, so the left wheel is the outer wheel
/// of a turn.
const SECTIONS: [(&str, &[Line]); 6] = [
    (
        "Ride height",
        &[
            line("toe", From::Ride("toe_angle"), TOE, ""),
            line("camber", From::Ride("camber_angle"), CAMBER, ""),
            line(
                "caster",
                From::Ride("caster_angle"),
                ["top rearward", "top forward"],
                "",
            ),
            line(
                "kingpin inclination",
                From::Ride("kingpin_incl_angle"),
                ["top inboard", "top outboard"],
                "",
            ),
            line(
                "scrub radius",
                From::Ride("scrub_radius"),
                [
                    "steer axis inboard of the patch",
                    "steer axis outboard of the patch",
                ],
                "",
            ),
            line(
                "caster trail",
                From::Ride("caster_moment_arm"),
                [
                    "patch behind the steer axis",
                    "patch ahead of the steer axis",
                ],
                "",
            ),
        ],
    ),
    (
        "Bounce",
        &[
            line("wheel rate", From::Ride("wheel_rate"), ["", ""], ""),
            line(
                "ride rate",
                From::Ride("ride_rate"),
                ["with the tyre", ""],
                "",
            ),
            line(
                "bump steer",
                From::Slope(TestKind::Bounce, "toe_angle"),
                TOE,
                "bounce",
            ),
            line(
                "bump camber",
                From::Slope(TestKind::Bounce, "camber_angle"),
                CAMBER,
                "bounce",
            ),
            line(
                "recession",
                From::Slope(TestKind::Bounce, "wheel_travel_base"),
                ["rearward", "forward"],
                "bounce",
            ),
            line(
                "track change, one wheel",
                From::Slope(TestKind::Bounce, "wheel_travel_track"),
                ["inboard", "outboard"],
                "bounce",
            ),
        ],
    ),
    (
        "Roll",
        &[
            line(
                "roll centre height",
                From::Axle("roll_center_location", "vertical"),
                ["above the road", "below the road"],
                "",
            ),
            line(
                "suspension roll rate",
                From::Axle("susp_roll_rate", "suspension_roll_rate"),
                ["", ""],
                "",
            ),
            line(
                "roll steer",
                From::Slope(TestKind::Roll, "toe_angle"),
                TOE,
                "jounce of the outer wheel",
            ),
            line(
                "roll camber",
                From::Slope(TestKind::Roll, "camber_angle"),
                CAMBER,
                "jounce of the outer wheel",
            ),
        ],
    ),
    (
        "Lateral force on both wheels",
        &[
            line(
                "lateral compliance",
                From::Ride("lat_force_defl_compliance"),
                ["with the force", "against the force"],
                "",
            ),
            line(
                "lateral force steer",
                From::Slope(TestKind::Lateral, "toe_angle"),
                TOE,
                "at the outer wheel",
            ),
            line(
                "lateral force camber",
                From::Slope(TestKind::Lateral, "camber_angle"),
                CAMBER,
                "at the outer wheel",
            ),
        ],
    ),
    (
        "Longitudinal force",
        &[
            line(
                "fore-aft stiffness, wheel centre",
                From::Ride("fore_aft_wheel_center_stiffness"),
                ["", ""],
                "",
            ),
            line(
                "braking force steer",
                From::Slope(TestKind::Braking, "toe_angle"),
                TOE,
                "braking",
            ),
            line(
                "recession",
                From::Slope(TestKind::Braking, "wheel_travel_base"),
                ["rearward", "forward"],
                "braking",
            ),
            line(
                "driving force steer",
                From::Slope(TestKind::Traction, "toe_angle"),
                TOE,
                "driving",
            ),
            line(
                "anti-dive (front), anti-lift (rear)",
                From::Ride("anti_dive_braking"),
                [
                    "of the load transfer, braking",
                    "of the load transfer, braking",
                ],
                "",
            ),
            line(
                "anti-lift (front), anti-squat (rear)",
                From::Ride("anti_squat_acceleration"),
                [
                    "of the load transfer, driving",
                    "of the load transfer, driving",
                ],
                "",
            ),
        ],
    ),
    (
        "Aligning torque",
        &[line(
            "aligning torque steer",
            From::Ride("alt_steer_compliance"),
            ["with the torque", "against the torque"],
            "",
        )],
    ),
];

/// Value of a characteristic, in display units.
#[derive(Clone, PartialEq, Debug)]
struct Value {
    value: f64,
    unit: String,
}

impl Line {
    /// Returns the value of one side in the axes of Adams/Car; `None` if the run does not contain it.
    fn value(&self, run: &KcRun, side: Side, units: &Units) -> Option<Value> {
        let ride = |entity: &str, fits: &dyn Fn(&str) -> bool| {
            let mut all = run.ride.readings.iter();
            let found = all.find(|r| r.entity == entity && fits(r.component))?;
            Some(shown(found.value, found.unit, units))
        };
        let (value, unit) = match self.from {
            From::Ride(entity) => ride(entity, &|component| component.contains(side.word()))?,
            From::Axle(entity, own) => ride(entity, &|component| component == own)?,
            From::Slope(kind, entity) => {
                let test = run.tests.iter().find(|test| test.kind == kind)?;
                let like = |g: &&Gradient| g.entity == entity && g.side == side;
                let found = test.gradients.iter().find(like)?;
                per_hundred(slope(found.tangent, found.unit, kind.driven(), units))
            }
        };
        value.is_finite().then_some(Value { value, unit })
    }

    /// Describes the sign and the value in words, such as `toe-in 0.31 deg/100 mm bounce`.
    fn words(&self, found: &Value) -> String {
        let Value { value, unit } = found;
        let word = self.words[usize::from(*value < 0.0)];
        if word.is_empty() || digits(*value) == "0" {
            return String::new();
        }
        let text = format!("{} {unit} {}", digits(value.abs()), self.per);
        let text = text.trim_end();
        // If the value comes first, the words state the reference of a percentage or the direction of the value.
        if matches!(self.from, From::Slope(..)) || word.starts_with("toe") {
            format!("{word} {text}")
        } else {
            word.to_string()
        }
    }
}

/// Converts a slope per metre to a slope per 100 mm, the usual unit of laboratories.
fn per_hundred((value, unit): (f64, String)) -> (f64, String) {
    match unit.strip_suffix("/m") {
        Some(of) => (value / 10.0, format!("{of}/100 mm")),
        None => (value, unit),
    }
}

/// Formats a value with three significant digits and at most four decimals, which is the resolution of rigs.
fn digits(value: f64) -> String {
    let value = (value * 1e4).round() / 1e4;
    if value == 0.0 {
        return "0".to_string();
    }
    rounded(value, DIGITS)
}

/// Returns the summary as one table per section. `others` are runs of other decks, with their names.
pub(super) fn summary(
    run: &KcRun,
    others: &[(String, KcRun)],
    sides: &[Side],
    units: &Units,
) -> Table {
    let runs: Vec<&KcRun> = std::iter::once(run)
        .chain(others.iter().map(|(_, run)| run))
        .collect();
    let all = || SECTIONS.iter().flat_map(|(_, lines)| lines.iter());
    // Track change and lateral effects have the opposite direction on the other side.
    let alike = |line: &Line| {
        let values = sides
            .iter()
            .filter_map(|side| line.value(run, *side, units));
        let values: Vec<f64> = values.map(|value| value.value.abs()).collect();
        let (low, high) = (
            values.iter().copied().fold(f64::INFINITY, f64::min),
            values.iter().copied().fold(0.0, f64::max),
        );
        values.len() < 2 || high - low <= ALIKE * high || high < 1e-9
    };
    let is_one = sides.len() < 2 || all().all(alike);
    let shown_sides = if is_one { &sides[..1] } else { sides };
    let mut heads = Vec::new();
    for k in 0..runs.len() {
        let name = match k {
            0 if others.is_empty() => "",
            0 => "this deck",
            _ => &others[k - 1].0,
        };
        for side in shown_sides {
            let side = if is_one { "" } else { side.word() };
            heads.push(match (name, side) {
                ("", "") => "value".to_string(),
                ("", side) => side.to_string(),
                (name, "") => name.to_string(),
                (name, side) => format!("{name}, {side}"),
            });
        }
    }
    let mut columns = vec![("characteristic", Align::Left)];
    columns.extend(heads.iter().map(|head| (head.as_str(), Align::Right)));
    columns.extend([("unit", Align::Left), ("in words", Align::Wrap)]);
    let mut table = Table::new(&columns);
    for (section, lines) in SECTIONS {
        let found: Vec<(&Line, Value)> = lines
            .iter()
            .filter_map(|line| Some((line, line.value(run, shown_sides[0], units)?)))
            .collect();
        if !found.is_empty() {
            table.group(section);
        }
        for (line, first) in found {
            let values = runs.iter().flat_map(|run| {
                shown_sides.iter().map(|side| {
                    let value = line.value(run, *side, units);
                    value.map_or_else(String::new, |found| digits(found.value))
                })
            });
            let words = line.words(&first);
            let cells = std::iter::once(line.name.to_string())
                .chain(values)
                .chain([unbroken(&first.unit), words]);
            table.row(cells.collect::<Vec<_>>());
        }
    }
    table
}

/// Returns the most frequently requested characteristics in a sentence.
pub(super) fn sentence(run: &KcRun, side: Side, units: &Units) -> String {
    let wanted = [
        "wheel rate",
        "bump steer",
        "lateral force steer",
        "roll centre height",
    ];
    let lines = SECTIONS.iter().flat_map(|(_, lines)| lines.iter());
    let told = lines
        .filter(|line| wanted.contains(&line.name))
        .filter_map(|line| {
            let found = line.value(run, side, units)?;
            let words = line.words(&found);
            let name = line.name;
            if matches!(line.from, From::Slope(..)) {
                return Some(format!("{name}: {words}"));
            }
            let text = format!(
                "{name} {} {} {words}",
                digits(found.value.abs()),
                found.unit
            );
            Some(text.trim_end().to_string())
        });
    let told: Vec<String> = told.collect();
    let mut text = told.join("; ");
    if let Some(first) = text.get(..1) {
        text = first.to_uppercase() + &text[1..];
    }
    text + "."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_said_in_words() {
        let steer = line(
            "bump steer",
            From::Slope(TestKind::Bounce, "toe_angle"),
            TOE,
            "bounce",
        );
        let of = |sign: f64| {
            let (value, unit) = per_hundred((sign * 3.1, "deg/m".to_string()));
            Value { value, unit }
        };
        assert_eq!(steer.words(&of(1.0)), "toe-in 0.31 deg/100 mm bounce");
        assert_eq!(steer.words(&of(-1.0)), "toe-out 0.31 deg/100 mm bounce");
        let scrub = SECTIONS[0].1[4];
        assert_eq!(scrub.words(&of(-1.0)), "steer axis outboard of the patch");
    }
}
