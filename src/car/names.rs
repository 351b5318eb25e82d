//! Names that Adams/Car gives to objects of a model.

use crate::side::Side;

/// Bushing of a subsystem, identified by the name of an object in a deck.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct BushingName {
    /// Side of the vehicle.
    pub side: Side,
    /// Name of the bushing in the subsystem (USAGE), in lower case.
    pub usage: String,
}

/// Parses the name of an object: `.axle.rear.bkl_arm_outer.field` is the bushing `arm_outer` on the left side.
///
/// The component must begin with `b`, a letter, the letter of a side and an underscore. If several components do, the last one applies.
/// `None` if no component has this form.
pub fn bushing_name(object: &str) -> Option<BushingName> {
    object.rsplit('.').find_map(|component| {
        let component = component.trim().to_ascii_lowercase();
        let (prefix, usage) = component.split_once('_')?;
        let mut letters = prefix.chars();
        let found = [letters.next()?, letters.next()?, letters.next()?];
        let whole = letters.next().is_none() && found[0] == 'b' && found[1].is_ascii_alphabetic();
        let side = Side::of_letter(found[2]).filter(|_| whole && !usage.is_empty())?;
        Some(BushingName {
            side,
            usage: usage.to_string(),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_and_the_usage_are_in_the_name() {
        let read = |text: &str| bushing_name(text).map(|name| (name.side, name.usage));
        let of = |side, usage: &str| Some((side, usage.to_string()));
        assert_eq!(
            read(".axle.rear.bkl_arm_outer.field"),
            of(Side::Left, "arm_outer")
        );
        assert_eq!(read("BGR_mount"), of(Side::Right, "mount"));
        assert_eq!(read("bks_rack_house"), of(Side::Single, "rack_house"));
        for other in [
            "",
            "bushing_1",
            "bkl_",
            "bkx_a",
            "nsl_spring",
            "bl_a",
            "b12_a",
        ] {
            assert_eq!(read(other), None, "{other}");
        }
    }
}
