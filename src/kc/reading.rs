use super::{Convention, Sense};
use admire_syntax::units::Units;

/// What a characteristic is measured in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// No unit.
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
    /// All of them.
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

    /// The unit as results files spell it.
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

    /// True for radians and what is per something in radians: shown in degrees to people.
    pub(crate) const fn is_angle(self) -> bool {
        matches!(
            self,
            Self::Angle | Self::AnglePerLength | Self::AnglePerForce | Self::AnglePerTorque
        )
    }
}

/// A characteristic in one state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reading {
    /// Name of the request in Adams/Car, or of our own where it has none.
    pub entity: &'static str,
    /// Component of the request.
    pub component: &'static str,
    /// Unit.
    pub unit: Unit,
    /// What its sign means.
    pub sense: Sense,
    /// Value in the axes of this room; not finite where it is not defined.
    pub value: f64,
}

impl Reading {
    /// `toe_angle.left`.
    pub fn path(&self) -> String {
        format!("{}.{}", self.entity, self.component)
    }

    /// The value in the axes of a convention.
    pub fn value_in(&self, convention: Convention) -> f64 {
        // A zero has no sign.
        convention.factor(self.sense) * self.value + 0.0
    }
}

/// Collects readings.
#[derive(Default, Debug)]
pub(super) struct Readings {
    pub all: Vec<Reading>,
}

impl Readings {
    pub(crate) fn push(
        &mut self,
        (entity, component): (&'static str, &'static str),
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
