//! Information from names and round numbers. It decides only between connections that are equally consistent with the forces and motions.

/// Returns the kind of joint in a name of Adams/Car; for example, `jolrev_wheel_bearing` is a revolute joint on the left side. Source: Adams/Car
/// help, "Naming conventions of entities": two letters of the type, one of the side, then for joints three of the kind.
pub(crate) fn joint_code(name: &str) -> Option<&'static str> {
    let last = name.rsplit('.').next()?;
    let (code, _) = last.split_once('_')?;
    let known = [
        "rev", "tra", "cyl", "sph", "hoo", "con", "fix", "inp", "inl", "uni", "per", "ori", "par",
    ];
    if code.len() != 6 || !code.starts_with("jo") {
        return None;
    }
    known.into_iter().find(|kind| code.ends_with(kind))
}

/// Returns the side of the car in a name of Adams/Car: `l` or `r`, the third letter of the code with which a component of the name starts. The last
/// such component counts. `None` for other names.
fn side(name: &str) -> Option<char> {
    let letter = |piece: &str| {
        let (code, _) = piece.split_once('_')?;
        let letter = code.chars().nth(2)?;
        (matches!(code.len(), 3 | 6) && matches!(letter, 'l' | 'r')).then_some(letter)
    };
    name.rsplit('.').find_map(letter)
}

/// Returns the words of a name without its codes and short components.
fn words(name: &str) -> impl Iterator<Item = String> + '_ {
    let pieces = name.split(['.', '_', ' ', '-']);
    pieces
        .filter(|piece| piece.len() > 2)
        .map(str::to_ascii_lowercase)
}

/// Returns the agreement between the name of an element and the name of a part: common words, the same submodel, the same side.
pub(crate) fn affinity(element: &str, part: &str) -> f64 {
    let common = words(element)
        .filter(|word| words(part).any(|other| other == *word))
        .count();
    let submodel = |name: &str| name.split_once('.').map(|(model, _)| model.to_string());
    let same_model = submodel(element).is_some() && submodel(element) == submodel(part);
    let sides = match (side(element), side(part)) {
        (Some(a), Some(b)) if a == b => 2.0,
        (Some(_), Some(_)) => -2.0,
        _ => 0.0,
    };
    // The name of the submodel is already one of the words. As a whole, it counts as half a word.
    let in_model = submodel(element).filter(|_| same_model);
    let repeated = in_model.map_or(0, |model| words(&model).count());
    (common - repeated.min(common)) as f64 + if same_model { 0.5 } else { 0.0 } + sides
}

/// Returns the number of decimals of a number, at most seven.
pub(crate) fn digits(number: f64) -> u8 {
    let mut scaled = number;
    for count in 0..7 {
        if (scaled - scaled.round()).abs() <= 1e-6 * scaled.abs().max(1e-3) {
            return count;
        }
        scaled *= 10.0;
    }
    7
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_need_few_digits() {
        assert_eq!(digits(20.0), 0);
        assert_eq!(digits(1.1), 1);
        assert_eq!(digits(3.671_69), 5);
    }

    #[test]
    fn names_of_a_car_tell_side_and_kind() {
        assert_eq!(joint_code("rear.jolrev_wheel_bearing"), Some("rev"));
        assert_eq!(joint_code("STRUT"), None);
        let bearing = "testrig.jolrev_wheel_bearing";
        assert!(affinity(bearing, "testrig.whl_wheel") > affinity(bearing, "testrig.whr_wheel"));
        assert!(affinity(bearing, "testrig.whl_wheel") > affinity(bearing, "rear.gel_spindle"));
        assert_eq!(side("sub_rear_susp.bgr_arm_bushing.field"), Some('r'));
    }
}
