use super::{Convention, Sense};
use admire_syntax::units::Units;

/// Unit of a characteristic.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// Dimensionless.
    One,
    /// Percent.
    Percent,
    /// Radians.
    Angle,
    /// Length.
    Length,
    /// Force.
    Force,
    /// Torque.
    Torque,
    /// Force per length.
    Rate,
    /// Torque per radian.
    RollRate,
    /// Radians per length.
    AnglePerLength,
    /// Length per force.
    LengthPerForce,
    /// Radians per force.
    AnglePerForce,
    /// Radians per torque.
    AnglePerTorque,
    /// Length per g.
    LengthPerG,
    /// Hz.
    Frequency,
}

impl Unit {
    /// All units.
    pub(crate) const ALL: [Self; 14] = [
        Self::One,
        Self::Percent,
        Self::Angle,
        Self::Length,
        Self::Force,
        Self::Torque,
        Self::Rate,
        Self::RollRate,
        Self::AnglePerLength,
        Self::LengthPerForce,
        Self::AnglePerForce,
        Self::AnglePerTorque,
        Self::LengthPerG,
        Self::Frequency,
    ];

    /// Returns the name of the unit as spelled in results files.
    pub fn word(self, units: &Units) -> String {
        let (f, l) = (units.force.word, units.length.word);
        match self {
            Self::One => String::new(),
            Self::Percent => "percent".to_string(),
            Self::Angle => "rad".to_string(),
            Self::Length => l.to_string(),
            Self::Force => f.to_string(),
            Self::Torque => format!("{f}-{l}"),
            Self::Rate => format!("{f}/{l}"),
            Self::RollRate => format!("{f}-{l}/rad"),
            Self::AnglePerLength => format!("rad/{l}"),
            Self::LengthPerForce => format!("{l}/{f}"),
            Self::AnglePerForce => format!("rad/{f}"),
            Self::AnglePerTorque => format!("rad/{f}-{l}"),
            Self::LengthPerG => format!("{l}/g"),
            Self::Frequency => "hertz".to_string(),
        }
    }

    /// Returns true for radians and for radians per another unit; these are displayed in degrees.
    pub(crate) const fn is_angle(self) -> bool {
        matches!(
            self,
            Self::Angle | Self::AnglePerLength | Self::AnglePerForce | Self::AnglePerTorque
        )
    }
}

/// One characteristic in one state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reading {
    /// Request name in Adams/Car, or a name of our own where Adams/Car has none.
    pub entity: &'static str,
    /// Name of the request's component.
    pub component: &'static str,
    /// Unit.
    pub unit: Unit,
    /// Meaning of the value's sign.
    pub sense: Sense,
    /// Value in this crate's axes; not finite where undefined.
    pub value: f64,
}

impl Reading {
    /// Returns the path of the reading, such as `toe_angle.left`.
    pub fn path(&self) -> String {
        format!("{}.{}", self.entity, self.component)
    }

    /// Returns the value in the axes of a convention.
    pub fn value_in(&self, convention: Convention) -> f64 {
        // Adding 0 turns a negative zero into zero.
        convention.factor(self.sense) * self.value + 0.0
    }
}

/// Collector of readings.
#[derive(Default, Debug)]
pub(super) struct Readings {
    pub all: Vec<Reading>,
}

impl Readings {
    pub(crate) fn push(
        &mut self,
        entity: &'static str,
        component: &'static str,
        unit: Unit,
        sense: Sense,
        value: f64,
    ) {
        self.all.push(Reading {
            entity,
            component,
            unit,
            sense,
            value,
        });
    }
}
