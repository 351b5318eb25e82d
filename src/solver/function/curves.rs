//! Curves of SPLINEs for the present y values of their points.

use super::interpolant::{Interpolant, Method};
use crate::model::Spline;

/// Form in which a SPLINE is read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum CurveForm {
    /// A method, with the extrapolation that the SPLINE requests.
    By(Method),
    /// Akima's method with linear extrapolation: a bushing of Adams/Car.
    AkimaLine,
}

/// Interpolated SPLINEs, each in every form in which functions and elements read it.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Curves {
    all: Vec<Curve>,
}

#[derive(Clone, PartialEq, Debug)]
struct Curve {
    /// Index of the SPLINE in the model.
    spline: usize,
    form: CurveForm,
    interpolant: Interpolant,
}

impl Curves {
    /// No curves.
    pub(super) const NONE: Self = Self { all: Vec::new() };

    /// Prepares a SPLINE for a form and returns the index of the curve. Returns `None` for data that define no curve.
    pub(super) fn enter(
        &mut self,
        (index, spline): (usize, &Spline),
        form: CurveForm,
    ) -> Option<usize> {
        let mut known = self.all.iter();
        if let Some(at) = known.position(|curve| curve.spline == index && curve.form == form) {
            return Some(at);
        }
        let interpolant = match form {
            CurveForm::By(method) => Interpolant::new(spline, method),
            CurveForm::AkimaLine => Interpolant::akima_line(spline),
        }?;
        self.all.push(Curve {
            spline: index,
            form,
            interpolant,
        });
        Some(self.all.len() - 1)
    }

    /// Returns the curves of the axes of a bushing of Adams/Car.
    #[cfg(test)]
    pub(crate) fn of_bushing(splines: &[Spline; 6]) -> Self {
        let mut curves = Self::default();
        for (index, spline) in splines.iter().enumerate() {
            let entered = curves.enter((index, spline), CurveForm::AkimaLine);
            assert_eq!(entered, Some(index));
        }
        curves
    }

    /// Returns a curve.
    pub(crate) fn get(&self, curve: usize) -> &Interpolant {
        &self.all[curve].interpolant
    }

    /// Returns whether a curve is that of a SPLINE.
    pub(crate) fn is_of(&self, curve: usize, spline: usize) -> bool {
        self.all[curve].spline == spline
    }

    /// Returns whether any curve is that of a SPLINE.
    pub(crate) fn are_of(&self, spline: usize) -> bool {
        self.all.iter().any(|curve| curve.spline == spline)
    }

    /// Sets the y value of a knot of a SPLINE that is a curve.
    pub(crate) fn set(&mut self, spline: usize, knot: usize, y: f64) {
        for curve in self.all.iter_mut().filter(|curve| curve.spline == spline) {
            curve.interpolant.set(knot, y);
        }
    }
}
