use super::{Direction, SolveError};
use crate::mechanics::Vec3;
use crate::model::{Marker, Model, Request};
use crate::system::{NoValue, Parameters, Quantity, Scratch, State, System};
use admire_syntax::diagnostic::Diagnostic;

/// Names of the components of a force and torque: magnitude, x, y, z of the force, then of the torque. The order is that of the element
/// functions of ADAMS.
pub const FORCE_COMPONENTS: [&str; 8] = ["FM", "FX", "FY", "FZ", "TM", "TX", "TY", "TZ"];

/// Scalar quantity that is read at an equilibrium, in units of the deck and radians.
#[derive(Clone, PartialEq, Debug)]
pub enum Probe {
    /// Force of an element or constraint on its I marker, or torque about the origin of I. Both are in ground axes, as in result files.
    Force {
        /// Keyword of the statement in capitals.
        kind: String,
        /// Id of the statement.
        id: u32,
        /// Index in [`FORCE_COMPONENTS`].
        component: usize,
    },
    /// Value of an ADAMS function.
    Function {
        /// Text of the function.
        text: String,
        /// Additional markers that the function needs. No marker of the deck has one of their ids.
        markers: Vec<Marker>,
    },
}

/// Probes of a compiled system.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    all: Vec<Read>,
}

/// Source of the value of a probe.
#[derive(Clone, Debug)]
enum Read {
    /// The system does not contain the element.
    Missing,
    One(Quantity),
    Magnitude([Quantity; 3]),
}

impl Read {
    fn quantities(&self) -> &[Quantity] {
        match self {
            Self::Missing => &[],
            Self::One(quantity) => std::slice::from_ref(quantity),
            Self::Magnitude(quantities) => quantities,
        }
    }
}

impl Probes {
    /// Adds the functions of probes and the markers that they need to a model. The functions are appended as requests to the requests of
    /// the deck.
    ///
    /// # Errors
    /// Fails if a text is not a function.
    pub fn extend(model: &mut Model, all: &[Probe]) -> Result<(), Diagnostic> {
        for probe in all {
            let Probe::Function { text, markers } = probe else {
                continue;
            };
            for marker in markers {
                if model.marker(marker.header.id).is_none() {
                    model.markers.push(marker.clone());
                }
            }
            model.requests.push(Request::of_function("", text)?);
        }
        Ok(())
    }

    /// Locates probes in the system of a model to which [`Self::extend`] has added them. `requests` is the number of requests before the
    /// addition.
    pub fn new(all: &[Probe], system: &System, requests: usize) -> Self {
        let mut next = requests;
        let mut of = |probe: &Probe| match probe {
            Probe::Force {
                kind,
                id,
                component,
            } => {
                let element = system.element(kind, *id);
                let constraint = system.constraint(kind, *id);
                // Component 0 of a quantity is x of the force, component 3 is x of the torque.
                let quantity = |k: usize| {
                    let element = element.map(|element| Quantity::Element(element, k));
                    element.or(constraint.map(|own| Quantity::Constraint(own, k)))
                };
                let first = 3 * (component / 4);
                let read = match component % 4 {
                    0 => quantity(first)
                        .zip(quantity(first + 1))
                        .zip(quantity(first + 2))
                        .map(|((x, y), z)| Read::Magnitude([x, y, z])),
                    k => quantity(first + k - 1).map(Read::One),
                };
                read.unwrap_or(Read::Missing)
            }
            Probe::Function { .. } => {
                next += 1;
                Read::One(Quantity::Request(next - 1, 1))
            }
        };
        Self {
            all: all.iter().map(&mut of).collect(),
        }
    }

    /// Returns the values at a state. The value of a force is NaN if the system has no such element.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element or a function is undefined in this state.
    pub fn values(
        &self,
        (system, parameters, state): (&System, &Parameters, &State),
        scratch: &mut Scratch,
    ) -> Result<Vec<f64>, NoValue> {
        if self.all.is_empty() {
            return Ok(Vec::new());
        }
        let mut here = system.evaluate(parameters, state, scratch)?;
        let mut value = |read: &Read| -> Result<f64, NoValue> {
            match read {
                Read::Missing => Ok(f64::NAN),
                Read::One(quantity) => here.quantity(*quantity),
                Read::Magnitude([x, y, z]) => {
                    Ok(
                        Vec3::new(here.quantity(*x)?, here.quantity(*y)?, here.quantity(*z)?)
                            .norm(),
                    )
                }
            }
        };
        self.all.iter().map(&mut value).collect()
    }

    /// Returns the derivatives along a change of the parameters: one value for each probe. `dx` is the change of the unknowns per unit of
    /// this change, as returned by [`Tangent::along`](super::Tangent::along).
    ///
    /// For a force of zero, the derivative of the magnitude is returned as zero.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element or a function is undefined in this state.
    pub fn changes(
        &self,
        (system, parameters, state): (&System, &Parameters, &State),
        scratch: &mut Scratch,
        dx: &[f64],
        direction: &Direction,
    ) -> Result<Vec<f64>, SolveError> {
        if self.all.is_empty() {
            return Ok(Vec::new());
        }
        let all: Vec<Quantity> = self
            .all
            .iter()
            .flat_map(|read| read.quantities().iter().copied())
            .collect();
        let mut here = system.evaluate(parameters, state, scratch)?;
        let mut changes = here.quantities_along(&all, (&direction.slots, &direction.turns))?;
        let mut values = Vec::with_capacity(all.len());
        let mut by = vec![0.0; system.unknowns()];
        for (quantity, change) in all.iter().zip(&mut changes) {
            by.fill(0.0);
            here.quantity_by_unknowns(*quantity, &mut by)?;
            *change += by.iter().zip(dx).map(|(a, b)| a * b).sum::<f64>();
            values.push(here.quantity(*quantity)?);
        }
        let mut first = 0;
        let each = self.all.iter().map(|read| {
            let range = first..first + read.quantities().len();
            first = range.end;
            let (values, changes) = (&values[range.clone()], &changes[range]);
            match read {
                Read::Missing => f64::NAN,
                Read::One(_) => changes[0],
                Read::Magnitude(_) => {
                    let size = Vec3::from_column_slice(values).norm();
                    let along: f64 = values.iter().zip(changes).map(|(a, b)| a * b).sum();
                    if size > 0.0 { along / size } else { 0.0 }
                }
            }
        });
        Ok(each.collect())
    }
}
