//! All pair laws behind one type. Knows no formula.

use super::{
    Beam, Bushing, Degenerate, ElastoSlip, Field, Law, RotationalSpring, ScalarForce,
    TranslationalSpring, Wrench,
};
use crate::mechanics::RelativeMotion;

/// Any law between one pair of markers, without a pointer: systems hold thousands side by side.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // Each variant is the law of its name.
pub enum ForceLaw {
    Bushing(Bushing),
    Field(Field),
    Beam(Beam),
    TranslationalSpring(TranslationalSpring),
    RotationalSpring(RotationalSpring),
    ScalarForce(ScalarForce),
    ElastoSlip(ElastoSlip),
}

impl ForceLaw {
    /// Whether `RelativeMotion::angles` is read; if not, the caller need not work it out.
    pub fn uses_angles(&self) -> bool {
        match self {
            Self::Bushing(_) | Self::Field(_) | Self::Beam(_) | Self::RotationalSpring(_) => true,
            Self::TranslationalSpring(_) | Self::ScalarForce(_) => false,
            Self::ElastoSlip(slip) => slip.component >= 3,
        }
    }
}

impl Law for ForceLaw {
    fn parameter_count(&self) -> usize {
        match self {
            Self::Bushing(law) => law.parameter_count(),
            Self::Field(law) => law.parameter_count(),
            Self::Beam(law) => law.parameter_count(),
            Self::TranslationalSpring(law) => law.parameter_count(),
            Self::RotationalSpring(law) => law.parameter_count(),
            Self::ScalarForce(law) => law.parameter_count(),
            Self::ElastoSlip(law) => law.parameter_count(),
        }
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        match self {
            Self::Bushing(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::Field(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::Beam(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::TranslationalSpring(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::RotationalSpring(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::ScalarForce(law) => law.evaluate(motion, theta, with_parameters, out),
            Self::ElastoSlip(law) => law.evaluate(motion, theta, with_parameters, out),
        }
    }

    fn energy(&self, motion: &RelativeMotion, theta: &[f64]) -> Option<f64> {
        match self {
            Self::Bushing(law) => law.energy(motion, theta),
            Self::Field(law) => law.energy(motion, theta),
            Self::Beam(law) => law.energy(motion, theta),
            Self::TranslationalSpring(law) => law.energy(motion, theta),
            Self::RotationalSpring(law) => law.energy(motion, theta),
            Self::ScalarForce(law) => law.energy(motion, theta),
            Self::ElastoSlip(law) => law.energy(motion, theta),
        }
    }
}
