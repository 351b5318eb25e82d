//! Unknowns of a study's fit, with their starting values.

use super::unknown::{Component, FitUnknown, FitUnknowns, UnknownTarget};
use crate::unknowns::{Place, bushing_number};
use crate::{Assignment, Problem, SetNumber};
use admire_solver::system::{Slot, System};

/// Starting values of a fit.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct StartValues {
    /// Starting values of the identified parameters, in the order of [`Problem::unknowns`].
    pub values: Vec<f64>,
    /// Starting values of assembly offsets, as (bushing, axis, delta0). Offsets that are not listed start at zero.
    pub offsets: Vec<(usize, usize, f64)>,
}

/// Returns the unknowns of a study's fit: first the coordinate of each parameter to identify, then the assembly offsets of the bushings.
pub fn fit_unknowns(
    problem: &Problem<'_>,
    system: &System,
    start: Option<&StartValues>,
) -> FitUnknowns {
    let slot = |address: &admire_syntax::Address| system.catalogue().slot(address);
    let settings = problem.settings;
    let (mut list, mut offsets) = (Vec::new(), Vec::new());
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        let preload = |axis: usize| match unknown.place {
            Place::Bushing { bushing, .. } => slot(&bushing_number(
                problem.model.bushings[bushing].header.id,
                ["FORCE", "TORQUE"],
                axis,
            )),
            Place::Number => None,
        };
        let addresses: Vec<_> = std::iter::once(&unknown.address)
            .chain(unknown.tied())
            .cloned()
            .collect();
        let axes: Vec<Option<usize>> = match unknown.place {
            Place::Bushing { .. } => unknown
                .axes()
                .into_iter()
                .map(|(_, axis)| Some(axis))
                .collect(),
            Place::Number => vec![None; addresses.len()],
        };
        let components: Vec<Component> = addresses
            .iter()
            .zip(&axes)
            .filter_map(|(address, axis)| {
                Some(Component {
                    stiffness: slot(address)?,
                    preload: axis.and_then(preload),
                })
            })
            .collect();
        let mean = unknown.coordinate(unknown.initial);
        let within = |x: f64| {
            unknown
                .bounds
                .map_or(x, |[least, most]| x.clamp(least, most))
        };
        for (component, axis) in components.iter().zip(&axes) {
            let Some(axis) = axis else { continue };
            let sd = (settings.offset_sd).of_axis(*axis, &problem.model.units);
            if sd > 0.0 && component.preload.is_some() {
                let known = start.into_iter().flat_map(|start| &start.offsets);
                let found = known
                    .filter(|(bushing, of, _)| {
                        unknown.axes().contains(&(*bushing, *of)) && of == axis
                    })
                    .map(|(_, _, delta)| *delta)
                    .next();
                offsets.push(FitUnknown {
                    addresses: vec![unknown.address.clone()],
                    target: UnknownTarget::Offset(*component),
                    start: found.unwrap_or(0.0),
                    mean: 0.0,
                    sd,
                    bounds: None,
                });
            }
        }
        let slots = |numbers: &[SetNumber], unit: f64| -> Vec<(Slot, f64)> {
            let numbers = numbers.iter();
            numbers
                .filter_map(|own| Some((slot(&own.address)?, own.factor * unit)))
                .collect()
        };
        list.push(FitUnknown {
            target: match &unknown.assignment {
                Assignment::Equal(_) => UnknownTarget::Stiffness(components),
                Assignment::Factor(numbers) => UnknownTarget::Factor(slots(numbers, 1.0)),
                Assignment::Change { numbers, sd } => UnknownTarget::Number(slots(numbers, *sd)),
            },
            addresses,
            start: within(start.map_or(mean, |start| unknown.coordinate(start.values[k]))),
            mean: unknown.mean.unwrap_or(mean),
            sd: unknown.sd.unwrap_or(settings.prior_log_sd),
            bounds: unknown.bounds,
        });
    }
    list.append(&mut offsets);
    FitUnknowns::new(list)
}
