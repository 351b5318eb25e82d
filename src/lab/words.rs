//! Words of headings and titles, in English, German and French.

use super::characteristic::{Characteristic, Target};
use admire_kc::{Side, TestKind};

/// Words of a heading that name the content of a column. The first entry with a group whose words all occur in the heading applies.
const TARGETS: &[(Target, &[&[&str]])] = &[
    (Target::Time, &[&["time"], &["zeit"], &["temps"]]),
    (
        Target::Test,
        &[&["test"], &["versuch"], &["essai"], &["pr\u{fc}fung"]],
    ),
    (Target::Side, &[&["side"], &["seite"], &["c\u{f4}t\u{e9}"]]),
    (
        Target::Characteristic(Characteristic::SideViewAngle),
        &[&["side", "view", "angle"]],
    ),
    (
        Target::Characteristic(Characteristic::ToeAngle),
        &[
            &["toe"],
            &["spur"],
            &["vorspur"],
            &["nachspur"],
            &["spurwinkel"],
            &["pincement"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::CamberAngle),
        &[&["camber"], &["sturz"], &["sturzwinkel"], &["carrossage"]],
    ),
    (
        Target::Characteristic(Characteristic::SteerAngle),
        &[
            &["steer", "angle"],
            &["lenkwinkel"],
            &["radlenkwinkel"],
            &["braquage"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::CasterAngle),
        &[&["caster"], &["castor"], &["nachlaufwinkel"], &["chasse"]],
    ),
    (
        Target::Characteristic(Characteristic::KingpinInclAngle),
        &[
            &["kingpin"],
            &["kpi"],
            &["spreizung"],
            &["spreizungswinkel"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::WheelTravel),
        &[
            &["travel"],
            &["jounce"],
            &["bounce"],
            &["rebound"],
            &["radhub"],
            &["federweg"],
            &["einfederung"],
            &["ausfederung"],
            &["d\u{e9}battement"],
            &["debattement"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::WheelTravelBase),
        &[
            &["wheelbase"],
            &["recession"],
            &["radstand"],
            &["radstands\u{e4}nderung"],
            &["radstandsaenderung"],
            &["empattement"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::TotalTrack),
        &[&["total", "track"], &["track", "width"]],
    ),
    (
        Target::Characteristic(Characteristic::VerticalForce),
        &[
            &["fz"],
            &["wheel", "load"],
            &["vertical", "force"],
            &["vertical", "load"],
            &["radlast"],
            &["aufstandskraft"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::LateralForce),
        &[
            &["fy"],
            &["lateral", "force"],
            &["side", "force"],
            &["seitenkraft"],
            &["querkraft"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::BrakingForce),
        &[&["braking", "force"], &["brake", "force"], &["bremskraft"]],
    ),
    (
        Target::Characteristic(Characteristic::DrivingForce),
        &[
            &["driving", "force"],
            &["drive", "force"],
            &["traction", "force"],
            &["antriebskraft"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::AligningTorque),
        &[
            &["mz"],
            &["aligning", "torque"],
            &["aligning", "moment"],
            &["r\u{fc}ckstellmoment"],
            &["rueckstellmoment"],
        ],
    ),
    (
        Target::Characteristic(Characteristic::RollAngle),
        &[&["roll", "angle"], &["wankwinkel"]],
    ),
];

/// Words that state the positive direction of a characteristic.
const SIGNS: &[(Characteristic, &[&str], &str)] = &[
    (Characteristic::ToeAngle, &["toe", "in"], "in"),
    (Characteristic::ToeAngle, &["toe", "out"], "out"),
    (Characteristic::ToeAngle, &["vorspur"], "in"),
    (Characteristic::ToeAngle, &["nachspur"], "out"),
    (Characteristic::WheelTravel, &["jounce"], "up"),
    (Characteristic::WheelTravel, &["rebound"], "down"),
    (Characteristic::WheelTravel, &["einfederung"], "up"),
    (Characteristic::WheelTravel, &["ausfederung"], "down"),
    (Characteristic::BrakingForce, &["bremskraft"], "rearward"),
    (
        Characteristic::BrakingForce,
        &["braking", "force"],
        "rearward",
    ),
    (Characteristic::DrivingForce, &["antriebskraft"], "forward"),
    (
        Characteristic::DrivingForce,
        &["driving", "force"],
        "forward",
    ),
    (Characteristic::WheelTravelBase, &["recession"], "rearward"),
];

/// Words for the sides. Single letters are excluded: `L` may mean a length, and `R` may mean the rear.
const SIDES: [&[&str]; 2] = [
    &[
        "left", "lh", "lhs", "links", "li", "gauche", "vl", "hl", "fl",
    ],
    &[
        "right", "rh", "rhs", "rechts", "re", "droite", "droit", "vr", "hr",
    ],
];

/// Titles that name a test unambiguously.
const TESTS: &[(TestKind, &[&str])] = &[
    (
        TestKind::Bounce,
        &[
            "bounce",
            "parallel travel",
            "parallel wheel travel",
            "parallelhub",
            "gleichseitiges einfedern",
        ],
    ),
    (
        TestKind::Roll,
        &[
            "roll",
            "opposite travel",
            "opposite wheel travel",
            "wechselhub",
            "wechselseitiges einfedern",
        ],
    ),
    (TestKind::Steering, &["steering", "lenken"]),
];

/// Returns the words of a heading in lower case. For example, `ToeLeft` has two words.
fn words(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let (mut is_open, mut was_lower) = (false, false);
    for c in text.chars() {
        if !c.is_alphanumeric() {
            is_open = false;
            continue;
        }
        if !is_open || (was_lower && c.is_uppercase()) {
            found.push(String::new());
        }
        (is_open, was_lower) = (true, c.is_lowercase());
        if let Some(last) = found.last_mut() {
            last.extend(c.to_lowercase());
        }
    }
    found
}

fn has_all(words: &[String], wanted: &[&str]) -> bool {
    wanted
        .iter()
        .all(|one| words.iter().any(|word| word == one))
}

/// Returns the content of a column according to the words of its heading. `None` if no word is known, or if the words name several characteristics.
pub(crate) fn target(heading: &str) -> Option<Target> {
    let words = words(heading);
    let known =
        |(_, groups): &&(Target, &[&[&str]])| groups.iter().any(|group| has_all(&words, group));
    let mut found = TARGETS.iter().filter(known);
    let first = found.next().map(|(target, _)| *target)?;
    // `side` and `time` also occur in names of characteristics. In that case, only the more specific entry applies.
    let others: Vec<Target> = found.map(|(target, _)| *target).collect();
    let is_meta = |target: &Target| !matches!(target, Target::Characteristic(_));
    let all = || std::iter::once(&first).chain(&others);
    let mut characteristics = all().filter(|target| !is_meta(target));
    match (characteristics.next(), characteristics.next()) {
        (Some(only), None) => Some(*only),
        (None, _) if others.is_empty() => Some(first),
        _ => None,
    }
}

/// Returns the positive direction of a characteristic, if the words of the heading state it.
pub(crate) fn sign(heading: &str, of: Characteristic) -> Option<&'static str> {
    let words = words(heading);
    let mut found = SIGNS
        .iter()
        .filter(|(own, wanted, _)| *own == of && has_all(&words, wanted));
    let first = found.next()?.2;
    found.all(|(_, _, word)| *word == first).then_some(first)
}

/// Returns the side that the words of a text name; `None` if they name none or both.
pub(crate) fn side(text: &str) -> Option<Side> {
    let words = words(text);
    let names = |side: Side| {
        let known = SIDES[side.index()];
        words.iter().any(|word| known.contains(&word.as_str()))
    };
    match Side::BOTH.map(names) {
        [true, false] => Some(Side::Left),
        [false, true] => Some(Side::Right),
        _ => None,
    }
}

/// Returns the test with this name in the guide page `kc`, or with a title that names it unambiguously.
pub(crate) fn test(title: &str) -> Option<TestKind> {
    let title = super::heading::folded(title);
    let own = TestKind::ALL.into_iter().find(|kind| kind.name() == title);
    own.or_else(|| {
        let known = |(_, titles): &&(TestKind, &[&str])| titles.contains(&title.as_str());
        TESTS.iter().find(known).map(|(kind, _)| *kind)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_name_characteristics_sides_and_signs() {
        let toe = Characteristic::ToeAngle;
        assert_eq!(target("Vorspur VL"), Some(Target::Characteristic(toe)));
        assert_eq!(sign("Vorspur VL", toe), Some("in"));
        assert_eq!(sign("Spur VL", toe), None);
        assert_eq!(target("ToeLeft"), Some(Target::Characteristic(toe)));
        assert_eq!(side("ToeLeft"), Some(Side::Left));
        assert_eq!(side("Toe left / right"), None);
        assert_eq!(side("Toe L"), None);
        let lateral = Target::Characteristic(Characteristic::LateralForce);
        assert_eq!(target("Side Force"), Some(lateral));
        assert_eq!(target("Time"), Some(Target::Time));
        // Both words name a characteristic, so the content of the column is ambiguous.
        assert_eq!(target("Toe over travel"), None);
        assert_eq!(target("Temperature"), None);
    }

    #[test]
    fn titles_name_tests_without_doubt_or_not_at_all() {
        assert_eq!(test("Parallelhub"), Some(TestKind::Bounce));
        assert_eq!(test("lateral_opposed"), Some(TestKind::LateralOpposed));
        // The title does not state whether both wheels have the same load or opposite loads.
        assert_eq!(test("Seitenkraft"), None);
    }
}
