//! Interpolated curves of SPLINEs, whose y values can be changed.

use super::interpolant::{Interpolant, Method};
use crate::model::Spline;

/// Interpolation and extrapolation with which a SPLINE is read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum CurveForm {
    /// The given interpolation method, with the extrapolation that the SPLINE requests.
    By(Method),
    /// Akima's method with linear extrapolation, as in a bushing of Adams/Car.
    AkimaLine,
}

/// Interpolated SPLINEs. A SPLINE has one curve for each form in which functions and elements read it.
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

/// Returns the value of a SPLINE at x by Akima's method with linear extrapolation, as in a bushing of Adams/Car. Returns `None` if the data
/// define no curve.
pub fn akima_value(spline: &Spline, x: f64) -> Option<f64> {
    Some(Interpolant::akima_line(spline)?.at(x, 0.0, 0).0)
}

impl Curves {
    /// No curves.
    pub(super) const NONE: Self = Self { all: Vec::new() };

    /// Adds a SPLINE in a given form, if it is not yet there, and returns the index of the curve. Returns `None` if the data define no
    /// curve.
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

    /// Returns whether a curve belongs to a SPLINE, given by its index in the model.
    pub(crate) fn is_of(&self, curve: usize, spline: usize) -> bool {
        self.all[curve].spline == spline
    }

    /// Returns whether any curve belongs to a SPLINE, given by its index in the model.
    pub(crate) fn are_of(&self, spline: usize) -> bool {
        self.all.iter().any(|curve| curve.spline == spline)
    }

    /// Sets the y value of a knot in all curves of a SPLINE.
    pub(crate) fn set(&mut self, spline: usize, knot: usize, y: f64) {
        for curve in self.all.iter_mut().filter(|curve| curve.spline == spline) {
            curve.interpolant.set(knot, y);
        }
    }
}
