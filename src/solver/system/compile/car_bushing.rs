//! Compilation of FIELDs that Adams/Car writes for its bushings. Their parameters in theta are the values of their arrays.

use super::{SystemCompiler, name};
use crate::element::{CarBushing, Damping, ElementLaw};
use crate::mechanics::{Mat6, Vec6};
use crate::model::PairForce;
use crate::system::catalogue::{GroupDimensions, Role};
use crate::system::structure::{Action, ParameterSource};
use admire_syntax::car_field::{CarAxis, CarField, reading};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;

const PLAIN: Dimension = Dimension::NONE;
/// Dimensions of the array of a translational axis.
const TRANSLATION: [Dimension; CarAxis::LENGTH] = [
    PLAIN,
    Dimension::new(1, 0, -1, 0, 0),
    PLAIN,
    PLAIN,
    Dimension::new(1, 0, -1, 1, 0),
    PLAIN,
    Dimension::FORCE,
    Dimension::LENGTH,
    PLAIN,
    Dimension::new(0, 0, 1, -1, 0),
    PLAIN,
];
/// Dimensions of the array of a rotational axis.
const ROTATION: [Dimension; CarAxis::LENGTH] = [
    PLAIN,
    Dimension::new(1, 0, 1, 0, -1),
    PLAIN,
    PLAIN,
    Dimension::new(1, 0, 1, 1, -1),
    PLAIN,
    Dimension::TORQUE,
    Dimension::ANGLE,
    PLAIN,
    Dimension::new(0, 0, 0, -1, 1),
    PLAIN,
];

impl SystemCompiler<'_> {
    /// Compiles a FIELD of Adams/Car. If a command has changed its objects so that they are unsuitable, the FIELD exerts no force and an
    /// error is reported.
    pub(super) fn car_bushing(&mut self, field: &PairForce, car: &CarField) {
        let (i, j) = (field.i.0, field.j.0);
        let of = ("FIELD", &field.header);
        let markers = (i, j, Some(j));
        let reaction = Some(self.part_of(j));
        let curves = match self.curves(car) {
            Ok(curves) => curves,
            Err(why) => {
                let owner = name("FIELD", &field.header);
                let message = format!("{owner} is not solved: {why}");
                let diagnostic = Diagnostic::error(Code::CarBushing, message);
                self.complain_of(&owner, diagnostic.about(owner.object()));
                self.push_element(of, markers, reaction, Action::Vector([None; 6]));
                return;
            }
        };
        let element = self.elements.len();
        let start = self.theta.len();
        let mut c = Vec6::zeros();
        for (axis, array) in car.arrays.into_iter().enumerate() {
            let numbers = self.programs.numbers(array).unwrap_or_default();
            if let Ok(axis_numbers) = CarAxis::read(numbers) {
                c[axis] = axis_numbers.damping;
            }
            let dimensions: &'static [Dimension] = match axis {
                0..3 => &TRANSLATION,
                _ => &ROTATION,
            };
            let bounds = (GroupDimensions::Each(dimensions), f64::NEG_INFINITY);
            let role = Role::Law { element };
            self.numbers(
                ("ARRAY", Some(array)),
                Some("NUMBERS"),
                numbers,
                bounds,
                role,
            );
        }
        let law = ElementLaw::Car(CarBushing::new(curves));
        let theta = ParameterSource::Theta(start..self.theta.len());
        self.push_element(of, markers, reaction, Action::Law(law, theta));
        let C = Mat6::from_diagonal(&c);
        self.damp((c != Vec6::zeros()).then(|| Damping::Matrix(Box::new(C))));
    }

    /// Returns the index of the curve of each axis of a bushing. The error is the reason why the objects are unsuitable.
    fn curves(&mut self, car: &CarField) -> Result<[usize; 6], String> {
        let programs = &self.programs;
        let array = |id| programs.numbers(id).unwrap_or_default().to_vec();
        let points = |id| {
            let spline = programs.spline(id)?;
            Some((spline.x.clone(), spline.y.first()?.clone()))
        };
        if let Some(why) = car.misfit(array, points) {
            return Err(why);
        }
        let mut curves = Vec::new();
        for (axis, id) in car.curves.into_iter().enumerate() {
            let curve = programs.bushing_curve(id);
            let no = || {
                format!(
                    "the SPLINE of `{}` needs strictly increasing x values with one y for each x",
                    car.axis(axis)
                )
            };
            curves.push(curve.ok_or_else(no)?);
        }
        for array in car.arrays {
            if !self.car_arrays.insert(array) {
                return Err(format!("ARRAY/{array} is used by another FIELD, too"));
            }
        }
        curves
            .try_into()
            .map_err(|_| "a bushing has six curves".to_string())
    }

    /// Adds a warning that explains how FIELDs of Adams/Car are read.
    pub(super) fn report_car_bushings(&mut self) {
        let active = self.model.pair_forces.iter().filter(|f| f.header.active);
        let read: Vec<&CarField> = active.filter_map(|field| field.car.as_ref()).collect();
        let others: Vec<f64> = read.iter().flat_map(|car| car.others.clone()).collect();
        if !read.is_empty() {
            let (message, help) = reading(read.len(), &others);
            let warning = Diagnostic::warning(Code::CarBushing, message);
            self.diagnostics.push(warning.help(help));
        }
    }
}
