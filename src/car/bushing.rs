//! Bushing property files (`.bus`): typed view, and the writer of learned curves.

use std::fmt::Write as _;

use admire_syntax::property::{PropertyFile, PropertyUnits};
use admire_syntax::units::{Dimension, Units};

use crate::settings::{LEARNED_CURVE_POINTS, LINEAR_CURVE_POINTS};

/// Curve of one component of a bushing: force against displacement, or torque against angle in radians. The elastic force on the I side is the
/// negative of the curve.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Curve {
    /// Displacements or angles, increasing.
    pub x: Vec<f64>,
    /// Forces or torques.
    pub y: Vec<f64>,
}

/// Force law that is odd in the deflection: stiffness times u, plus further terms.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct OddLaw {
    /// Stiffness at zero deflection.
    pub stiffness: f64,
    /// Further terms.
    pub terms: Vec<OddTerm>,
}

/// Term of a force law that begins at a deflection: `c sgn(u) max(0, |u| - from)^power`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OddTerm {
    /// Deflection at which the term begins.
    pub from: f64,
    /// Power of the deflection beyond `from`.
    pub power: i32,
    /// Coefficient c.
    pub coefficient: f64,
}

impl OddTerm {
    /// Returns a power of the whole deflection.
    pub const fn power(power: i32, coefficient: f64) -> Self {
        Self {
            from: 0.0,
            power,
            coefficient,
        }
    }
}

impl OddLaw {
    /// Returns the force at a deflection.
    pub fn force(&self, deflection: f64) -> f64 {
        let size = deflection.abs();
        let term = |t: &OddTerm| t.coefficient * (size - t.from).max(0.0).powi(t.power);
        let sum: f64 = self.terms.iter().map(term).sum();
        self.stiffness * deflection + if deflection < 0.0 { -sum } else { sum }
    }

    /// Returns the law as a curve of equally spaced points from -`range` to `range`. A law without further terms has few points.
    pub fn curve(&self, range: f64) -> Curve {
        let points = if self.terms.is_empty() {
            LINEAR_CURVE_POINTS
        } else {
            LEARNED_CURVE_POINTS
        };
        let half = (points - 1) / 2;
        let x: Vec<f64> = (0..points)
            .map(|k| range * (k as f64 - half as f64) / half as f64)
            .collect();
        let y = x.iter().map(|u| self.force(*u)).collect();
        Curve { x, y }
    }
}

/// Contents of a bushing property file, in the units of a model with angles in radians. The components are forces along x, y, z, then torques
/// about x, y, z.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct BushingProperty {
    /// The six curves; `None` for a component without a curve, which has no force.
    pub curves: [Option<Curve>; 6],
    /// The six damping coefficients: force per velocity, then torque per angular velocity.
    pub damping: [f64; 6],
}

const COMPONENTS: [&str; 6] = admire_syntax::FORCE_COMPONENTS;
const ABSCISSAE: [&str; 6] = ["x", "y", "z", "ax", "ay", "az"];

/// Units of the files that are written: newton, kilogram, millimetre, second, degree.
fn written_units() -> PropertyUnits {
    PropertyUnits {
        force: 1.0,
        mass: 1.0,
        length: 1e-3,
        time: 1.0,
        angle: 1f64.to_radians(),
    }
}

impl BushingProperty {
    /// Reads the contents of a parsed file in the units of a model.
    pub fn of(file: &PropertyFile, units: &Units) -> Self {
        Self {
            curves: file
                .bushing_curves(units)
                .map(|curve| curve.map(|(x, y)| Curve { x, y })),
            damping: file.bushing_damping(units),
        }
    }

    /// Returns the text of a bushing property file with these contents. `units` are the units of the contents; the file is in millimetres, newtons
    /// and degrees. `remark` is written as a comment in the header.
    pub fn text(&self, units: &Units, remark: &str) -> String {
        let rule = |name: &str| format!("${name:->79}\n");
        let own = written_units();
        let remark: String = remark
            .chars()
            .map(|c| if c.is_control() || c == '\'' { ' ' } else { c })
            .collect();
        let mut text = rule("MDI_HEADER");
        text += "[MDI_HEADER]\n FILE_TYPE     =  'bus'\n FILE_VERSION  =  4.0\n FILE_FORMAT   =  'ASCII'\n";
        _ = write!(text, "(COMMENTS)\n{{comment_string}}\n'{remark}'\n");
        text += &rule("UNITS");
        text += "[UNITS]\n LENGTH  =  'mm'\n ANGLE   =  'degrees'\n FORCE   =  'newton'\n MASS    =  'kg'\n TIME    =  'second'\n";
        text += &rule("DAMPING");
        text += "[DAMPING]\n";
        for (k, name) in COMPONENTS.iter().enumerate() {
            let dimension = if k < 3 {
                Dimension::new(1, 0, -1, 1, 0)
            } else {
                Dimension::new(1, 0, 1, 1, -1)
            };
            let rate = self.damping[k] / own.factor(dimension, units);
            _ = writeln!(text, " {name}_DAMPING  =  {rate:?}");
        }
        for (k, name) in COMPONENTS.iter().enumerate() {
            let Some(curve) = &self.curves[k] else {
                continue;
            };
            let (dx, dy) = if k < 3 {
                (Dimension::LENGTH, Dimension::FORCE)
            } else {
                (Dimension::ANGLE, Dimension::TORQUE)
            };
            let (fx, fy) = (own.factor(dx, units), own.factor(dy, units));
            text += &rule(&format!("{name}_CURVE"));
            _ = writeln!(
                text,
                "[{name}_CURVE]\n{{ {}  {}}}",
                ABSCISSAE[k],
                name.to_lowercase()
            );
            for (x, y) in curve.x.iter().zip(&curve.y) {
                // Adding zero turns a negative zero into a positive zero.
                let (x, y) = (x / fx + 0.0, y / fy + 0.0);
                _ = writeln!(text, " {x:?}  {y:?}");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::Source;
    use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS};

    #[test]
    fn a_written_bushing_reads_back_in_any_units() {
        let law = OddLaw {
            stiffness: 1200.0,
            terms: vec![OddTerm::power(3, 55.5), OddTerm::power(5, -0.25)],
        };
        let torque = OddLaw {
            stiffness: 8.0e5,
            terms: vec![OddTerm::power(2, 1e6)],
        };
        let mut property = BushingProperty {
            damping: [1.5, 0.0, 0.0, 200.0, 0.0, 0.0],
            ..BushingProperty::default()
        };
        property.curves[0] = Some(law.curve(3.0));
        property.curves[3] = Some(torque.curve(0.2));
        let metre = Units::new(
            FORCE_UNITS[0],
            MASS_UNITS[0],
            *LENGTH_UNITS
                .iter()
                .find(|unit| unit.keyword == "METER")
                .expect("metre"),
            TIME_UNITS[0],
        );
        for units in [Units::default(), metre] {
            let text = property.text(&units, "of a test's own");
            let read = admire_syntax::property::PropertyFile::parse(Source::new("a.bus", text));
            assert_eq!(read.diagnostics, []);
            let back = BushingProperty::of(&read.value, &units);
            for (curve, expected) in back.curves.iter().zip(&property.curves) {
                let (Some(curve), Some(expected)) = (curve, expected) else {
                    assert_eq!(curve, expected);
                    continue;
                };
                for (a, b) in curve.x.iter().zip(&expected.x) {
                    assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} {b}");
                }
                for (a, b) in curve.y.iter().zip(&expected.y) {
                    assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} {b}");
                }
            }
            assert!((back.damping[0] - 1.5).abs() < 1e-14);
            assert!((back.damping[3] - 200.0).abs() < 1e-11);
        }
    }

    /// The force must equal 2 u - 3 u^3 + u^2 for u >= 0, and must be odd in u.
    #[test]
    fn an_odd_law_is_odd() {
        let law = OddLaw {
            stiffness: 2.0,
            terms: vec![OddTerm::power(3, -3.0), OddTerm::power(2, 1.0)],
        };
        for u in [0.0, 0.5, 2.0] {
            let expected = 2.0 * u - 3.0 * u * u * u + u * u;
            assert!((law.force(u) - expected).abs() < 1e-12);
            assert!((law.force(-u) + expected).abs() < 1e-12);
        }
    }
}
