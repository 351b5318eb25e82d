//! Units of a dataset, and physical dimensions of its values.

/// Physical dimension, given by the exponents of force, mass, length, time and angle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Dimension {
    /// Exponent of force.
    pub force: i8,
    /// Exponent of mass.
    pub mass: i8,
    /// Exponent of length.
    pub length: i8,
    /// Exponent of time.
    pub time: i8,
    /// Exponent of plane angle; angles are in radians internally.
    pub angle: i8,
}

impl Dimension {
    /// Dimension of a dimensionless number.
    pub const NONE: Self = Self::new(0, 0, 0, 0, 0);
    /// Dimension of length.
    pub const LENGTH: Self = Self::new(0, 0, 1, 0, 0);
    /// Dimension of plane angle.
    pub const ANGLE: Self = Self::new(0, 0, 0, 0, 1);
    /// Dimension of force.
    pub const FORCE: Self = Self::new(1, 0, 0, 0, 0);
    /// Dimension of torque.
    pub const TORQUE: Self = Self::new(1, 0, 1, 0, 0);
    /// Dimension of mass.
    pub const MASS: Self = Self::new(0, 1, 0, 0, 0);
    /// Dimension of time.
    pub const TIME: Self = Self::new(0, 0, 0, 1, 0);

    /// Creates a dimension from its exponents.
    pub const fn new(force: i8, mass: i8, length: i8, time: i8, angle: i8) -> Self {
        Self {
            force,
            mass,
            length,
            time,
            angle,
        }
    }
}

/// A unit: its keyword in ADAMS, its spelling in results files, and its size in SI units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Unit {
    /// Full keyword of the UNITS statement, in capitals.
    pub keyword: &'static str,
    /// Spelling in results files, for example `mm`.
    pub word: &'static str,
    /// Size of the unit in SI units (N, kg, m or s).
    pub si: f64,
}

const fn unit(keyword: &'static str, word: &'static str, si: f64) -> Unit {
    Unit { keyword, word, si }
}

const POUND: f64 = 0.453_592_37;
const G0: f64 = 9.806_65;
const INCH: f64 = 0.0254;

/// Units of force.
pub const FORCE_UNITS: &[Unit] = &[
    unit("NEWTON", "newton", 1.0),
    unit("KNEWTON", "knewton", 1e3),
    unit("KILOGRAM_FORCE", "kg_force", G0),
    unit("DYNE", "dyne", 1e-5),
    unit("POUND_FORCE", "pound_force", POUND * G0),
    unit("KPOUND_FORCE", "kpound_force", 1e3 * POUND * G0),
    unit("OUNCE_FORCE", "ounce_force", POUND * G0 / 16.0),
    unit("POUNDAL", "poundal", POUND * 0.3048),
    unit("CENTINEWTON", "centinewton", 1e-2),
    unit("MILLINEWTON", "millinewton", 1e-3),
    unit("MICRONEWTON", "micronewton", 1e-6),
    unit("NANONEWTON", "nanonewton", 1e-9),
    unit("MEGANEWTON", "meganewton", 1e6),
];
/// Units of mass.
pub const MASS_UNITS: &[Unit] = &[
    unit("KILOGRAM", "kg", 1.0),
    unit("GRAM", "gram", 1e-3),
    unit("MILLIGRAM", "milligram", 1e-6),
    unit("MICROGRAM", "microgram", 1e-9),
    unit("NANOGRAM", "nanogram", 1e-12),
    unit("TONNE", "tonne", 1e3),
    unit("POUND_MASS", "pound_mass", POUND),
    unit("KPOUND_MASS", "kpound_mass", 1e3 * POUND),
    unit("OUNCE_MASS", "ounce_mass", POUND / 16.0),
    unit("SLUG", "slug", POUND * G0 / 0.3048),
    unit("SLINCH", "slinch", POUND * G0 / INCH),
    unit("US_TON", "us_ton", 2e3 * POUND),
];
/// Units of length.
pub const LENGTH_UNITS: &[Unit] = &[
    unit("MILLIMETER", "mm", 1e-3),
    unit("CENTIMETER", "cm", 1e-2),
    unit("METER", "meter", 1.0),
    unit("KILOMETER", "km", 1e3),
    unit("MICROMETER", "micrometer", 1e-6),
    unit("NANOMETER", "nanometer", 1e-9),
    unit("ANGSTROM", "angstrom", 1e-10),
    unit("INCH", "inch", INCH),
    unit("FOOT", "foot", 0.3048),
    unit("YARD", "yard", 0.9144),
    unit("MILE", "mile", 1609.344),
    unit("MILS", "mils", INCH / 1e3),
    unit("MICROINCH", "microinch", INCH / 1e6),
];
/// Units of time.
pub const TIME_UNITS: &[Unit] = &[
    unit("SECOND", "sec", 1.0),
    unit("MILLISECOND", "ms", 1e-3),
    unit("MICROSECOND", "microsec", 1e-6),
    unit("NANOSECOND", "nanosec", 1e-9),
    unit("MINUTE", "min", 60.0),
    unit("HOUR", "hour", 3600.0),
    unit("DAY", "day", 86400.0),
];

/// Units of a dataset, and whether the dataset states them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Units {
    /// Unit of force.
    pub force: Unit,
    /// Unit of mass.
    pub mass: Unit,
    /// Unit of length.
    pub length: Unit,
    /// Unit of time.
    pub time: Unit,
    /// Units consistency factor UCF, defined by force * UCF = mass * acceleration (guide/formats.md 2.15).
    pub ucf: f64,
    /// True if the dataset contains a UNITS statement.
    pub stated: bool,
}

impl Units {
    /// Creates the units of a dataset that states them, and computes their consistency factor.
    pub fn new(force: Unit, mass: Unit, length: Unit, time: Unit) -> Self {
        let ucf = force.si * time.si * time.si / (mass.si * length.si);
        Self {
            force,
            mass,
            length,
            time,
            ucf,
            stated: true,
        }
    }

    /// Returns the size in SI units (N, kg, m, s, rad) of the unit that a dimension has in this dataset.
    pub fn si(&self, dimension: Dimension) -> f64 {
        let powers = [
            (self.force.si, dimension.force),
            (self.mass.si, dimension.mass),
            (self.length.si, dimension.length),
            (self.time.si, dimension.time),
        ];
        let product = powers.map(|(size, exponent)| size.powi(exponent.into()));
        product.iter().product()
    }

    /// Returns the name of the unit that a dimension has in this dataset, spelled as in results files, for example `newton-mm` or
    /// `mm/sec**2`. The name of a dimensionless unit is empty.
    pub fn name(&self, dimension: Dimension) -> String {
        let parts = [
            (self.force.word, dimension.force),
            (self.mass.word, dimension.mass),
            (self.length.word, dimension.length),
            (self.time.word, dimension.time),
            ("rad", dimension.angle),
        ];
        let power = |(word, exponent): &(&str, i8)| match exponent.abs() {
            1 => (*word).to_string(),
            n => format!("{word}**{n}"),
        };
        let join = |sign: i8| {
            parts
                .iter()
                .filter(|p| p.1.signum() == sign)
                .map(power)
                .collect::<Vec<_>>()
                .join("-")
        };
        match (join(1), join(-1)) {
            (above, below) if below.is_empty() => above,
            (above, below) if above.is_empty() => format!("1/{below}"),
            (above, below) => format!("{above}/{below}"),
        }
    }
}

/// Returns the usual short form of a unit that is spelled as in results files: `N/mm` for `newton/mm`, `N mm/rad` for `newton-mm/rad`.
pub fn short_unit(unit: &str) -> String {
    let starts = |word: &str| unit.starts_with(word) || unit.contains(&format!("/{word}"));
    if starts("newton") || starts("knewton") {
        unit.replace("newton-", "N ").replace("newton", "N")
    } else {
        unit.to_string()
    }
}

impl Default for Units {
    /// Returns the units that ADAMS assumes for a dataset without UNITS. ADAMS computes with UCF = 1, and results files name millimetres,
    /// newtons, kilograms and seconds.
    fn default() -> Self {
        Self {
            ucf: 1.0,
            stated: false,
            ..Self::new(
                FORCE_UNITS[0],
                MASS_UNITS[0],
                LENGTH_UNITS[0],
                TIME_UNITS[0],
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consistency_factors_are_the_documented_ones() {
        // guide/formats.md 2.15: N, kg, mm, s gives 1000; lbf, lbm, in, s gives 386.0886.
        assert!(
            (Units::new(
                FORCE_UNITS[0],
                MASS_UNITS[0],
                LENGTH_UNITS[0],
                TIME_UNITS[0]
            )
            .ucf - 1000.0)
                .abs()
                < 1e-9
        );
        let find = |units: &[Unit], word| *units.iter().find(|u| u.keyword == word).unwrap();
        let inch = Units::new(
            find(FORCE_UNITS, "POUND_FORCE"),
            find(MASS_UNITS, "POUND_MASS"),
            find(LENGTH_UNITS, "INCH"),
            TIME_UNITS[0],
        );
        assert!((inch.ucf - 386.0886).abs() < 1e-4);
        assert_eq!(inch.name(Dimension::TORQUE), "pound_force-inch");
        assert_eq!(
            Units::default().name(Dimension::new(0, 0, 1, -2, 0)),
            "mm/sec**2"
        );
    }
}
