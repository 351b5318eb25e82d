//! Physical quantities of columns, and the units that laboratories use for them.

/// Physical quantity of a column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Quantity {
    /// Angle; converted to degrees.
    Angle,
    /// Length; converted to millimetres.
    Length,
    /// Force; converted to newtons.
    Force,
    /// Torque; converted to newton-metres.
    Torque,
}

const POUND_FORCE: f64 = 4.448_221_615_260_5;
const KILOGRAM_FORCE: f64 = 9.806_65;

/// Units of angle. Each entry holds the spellings of a unit, simplified by [`plain`], and the factor from it to [`Quantity::unit`]. The tables of
/// the other quantities have the same form.
const ANGLES: &[(&[&str], f64)] = &[
    (&["deg", "degree", "degrees", "\u{b0}"], 1.0),
    (&["min", "arcmin", "'", "\u{2032}"], 1.0 / 60.0),
    (&["arcsec", "\u{2033}"], 1.0 / 3600.0),
    (&["rad", "radian", "radians"], 180.0 / std::f64::consts::PI),
    (&["mrad"], 0.18 / std::f64::consts::PI),
];
const LENGTHS: &[(&[&str], f64)] = &[
    (&["mm", "millimeter", "millimetre"], 1.0),
    (&["cm", "centimeter", "centimetre"], 10.0),
    (&["m", "meter", "metre"], 1000.0),
    (&["\u{b5}m", "\u{3bc}m", "um"], 1e-3),
    (&["in", "inch", "inches"], 25.4),
    (&["ft", "foot", "feet"], 304.8),
];
const FORCES: &[(&[&str], f64)] = &[
    (&["n", "newton"], 1.0),
    (&["dan"], 10.0),
    (&["kn", "knewton"], 1000.0),
    (&["lbf", "pound_force"], POUND_FORCE),
    (&["kgf", "kp"], KILOGRAM_FORCE),
];
const TORQUES: &[(&[&str], f64)] = &[
    (&["nm"], 1.0),
    (&["danm"], 10.0),
    (&["knm"], 1000.0),
    (&["nmm"], 1e-3),
    (&["ncm"], 1e-2),
    (&["lbfft", "ftlbf"], POUND_FORCE * 0.3048),
    (&["lbfin", "inlbf"], POUND_FORCE * 0.0254),
];

impl Quantity {
    /// All quantities.
    pub(crate) const ALL: [Self; 4] = [Self::Angle, Self::Length, Self::Force, Self::Torque];

    const fn units(self) -> &'static [(&'static [&'static str], f64)] {
        match self {
            Self::Angle => ANGLES,
            Self::Length => LENGTHS,
            Self::Force => FORCES,
            Self::Torque => TORQUES,
        }
    }

    /// Returns the unit to which values of this quantity are converted.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Angle => "deg",
            Self::Length => "mm",
            Self::Force => "N",
            Self::Torque => "Nm",
        }
    }

    /// Returns the factor from a unit to [`Self::unit`]; `None` if the word is no unit of this quantity.
    pub fn factor(self, word: &str) -> Option<f64> {
        let plain = plain(word);
        let found = |(words, _): &&(&[&str], f64)| words.contains(&plain.as_str());
        self.units().iter().find(found).map(|(_, factor)| *factor)
    }

    /// Returns the size of [`Self::unit`] in SI units, with angles in radians.
    pub const fn si(self) -> f64 {
        match self {
            Self::Angle => std::f64::consts::PI / 180.0,
            Self::Length => 1e-3,
            Self::Force | Self::Torque => 1.0,
        }
    }

    /// Returns the quantity of a unit, and the factor from it to [`Self::unit`]. Returns `None` for an unknown word.
    pub fn of_unit(word: &str) -> Option<(Self, f64)> {
        Self::ALL
            .into_iter()
            .find_map(|quantity| Some((quantity, quantity.factor(word)?)))
    }

    /// Returns the most common units of the quantity, for messages.
    pub(crate) const fn described(self) -> &'static str {
        match self {
            Self::Angle => "deg, min, rad, mrad",
            Self::Length => "mm, cm, m, in",
            Self::Force => "N, daN, kN, lbf, kgf",
            Self::Torque => "Nm, kNm, Nmm, lbf ft, lbf in",
        }
    }
}

/// Returns the spelling of a unit in lower case, without blanks and multiplication signs.
fn plain(word: &str) -> String {
    let kept = word
        .trim()
        .chars()
        .filter(|c| !c.is_whitespace() && !matches!(c, '*' | '.' | '\u{b7}' | '\u{22c5}'));
    let text: String = kept.flat_map(char::to_lowercase).collect();
    match text.as_str() {
        "n-m" => "nm".to_string(),
        "n-mm" => "nmm".to_string(),
        "lbf-ft" | "ft-lbf" => "lbfft".to_string(),
        "lbf-in" | "in-lbf" => "lbfin".to_string(),
        _ => text,
    }
}

/// Returns true if the word is a unit of any quantity or of time, or states that a column is dimensionless.
pub(crate) fn is_unit(word: &str) -> bool {
    const OTHERS: [&str; 12] = [
        "s", "sec", "ms", "h", "hz", "%", "-", "1", "\u{b0}c", "kg", "lb", "bar",
    ];
    let word = word.trim();
    Quantity::of_unit(word).is_some() || OTHERS.contains(&word.to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_laboratories_are_converted() {
        let near = |a: Option<f64>, b: f64| (a.expect("a known unit") - b).abs() < 1e-12 * b;
        assert!(near(Quantity::Angle.factor("min"), 1.0 / 60.0));
        assert!(near(Quantity::Angle.factor("mrad"), 1e-3_f64.to_degrees()));
        assert!(near(Quantity::Force.factor(" kN "), 1000.0));
        assert!(near(Quantity::Torque.factor("N\u{b7}m"), 1.0));
        assert!(near(Quantity::Torque.factor("lbf ft"), 1.355_817_948_331_4));
        assert_eq!(Quantity::of_unit("in"), Some((Quantity::Length, 25.4)));
    }

    /// A pound or a kilogram may be a mass, and `Grad` may mean degrees or gon. They are not accepted as units of force or angle.
    #[test]
    fn unclear_units_are_unknown() {
        for word in ["lb", "kg", "grad", "gon", "", "mm/m", "to"] {
            assert_eq!(Quantity::of_unit(word), None, "{word}");
        }
    }
}
