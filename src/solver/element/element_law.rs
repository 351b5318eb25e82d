use super::car_bushing::{CarBushing, CarNumbers};
use super::{Degenerate, Law, Wrench};
use crate::function::Curves;
use crate::mechanics::RelativeMotion;

/// Law of an element: a law shared by all elements of its kind, or a separate law with curves for this element.
#[derive(Debug)]
pub(crate) enum ElementLaw {
    Shared(&'static dyn Law),
    Car(CarBushing),
}

impl ElementLaw {
    /// Returns whether the law reads `RelativeMotion::angles`.
    pub(crate) fn uses_angles(&self) -> bool {
        match self {
            Self::Shared(law) => law.uses_angles(),
            Self::Car(_) => true,
        }
    }

    /// Returns whether the law reads a SPLINE, given by its index in the model.
    pub(crate) fn reads_spline(&self, curves: &Curves, spline: usize) -> bool {
        match self {
            Self::Shared(_) => false,
            Self::Car(car) => car.reads_spline(curves, spline),
        }
    }

    /// Computes the wrench like [`Law::evaluate`], with the given curves of the SPLINEs.
    ///
    /// # Errors
    /// Returns [`Degenerate`] where the law is undefined at this motion; `out` is then unspecified.
    pub(crate) fn evaluate(
        &self,
        motion: &RelativeMotion,
        numbers: CarNumbers<'_>,
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        match self {
            Self::Shared(law) => law.evaluate(motion, numbers.theta, with_parameters, out),
            Self::Car(car) => car.evaluate(motion, numbers, with_parameters, out),
        }
    }
}
