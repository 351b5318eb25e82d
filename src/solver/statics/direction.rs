use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::{SolveError, Tangent};
use crate::mechanics::Vec3;
use crate::model::MarkerIx;
use crate::system::{Parameters, Scratch, Slot, State, System};

/// Direction in the space of parameters: the change of each parameter per unit of a coordinate.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Direction {
    /// Parameters of the system, each with its change per unit.
    pub slots: Vec<(Slot, f64)>,
    /// Markers that rotate on their parts, each with its rotation vector per unit. The vector is in radians and in the axes of the marker.
    pub turns: Vec<(MarkerIx, Vec3)>,
}

impl Tangent {
    /// Returns the derivatives of the unknowns along each direction, concatenated in order. A parameter that occurs in several directions is
    /// differentiated once.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn along(
        &mut self,
        (system, parameters, state): (&System, &Parameters, &State),
        scratch: &mut Scratch,
        directions: &[Direction],
    ) -> Result<Vec<f64>, SolveError> {
        let n = system.unknowns();
        let mut out = vec![0.0; n * directions.len()];
        if directions.is_empty() {
            return Ok(out);
        }
        let mut column = vec![0.0; n];
        let mut known: BTreeMap<Slot, Vec<f64>> = BTreeMap::new();
        let mut here = system.evaluate(parameters, state, scratch)?;
        for (direction, dg) in directions.iter().zip(out.chunks_mut(n.max(1))) {
            for (marker, turn) in &direction.turns {
                let size = turn.norm();
                if size == 0.0 {
                    continue;
                }
                here.residual_by_turn(*marker, &(turn / size), &mut column)?;
                for (sum, value) in dg.iter_mut().zip(&column) {
                    *sum += size * value;
                }
            }
            for (slot, factor) in &direction.slots {
                let by_slot = match known.entry(*slot) {
                    Entry::Occupied(found) => found.into_mut(),
                    Entry::Vacant(place) => {
                        here.residual_by_slot(*slot, &mut column)?;
                        place.insert(column.clone())
                    }
                };
                for (sum, value) in dg.iter_mut().zip(by_slot.iter()) {
                    *sum += factor * value;
                }
            }
        }
        self.respond_to_all(&mut out);
        Ok(out)
    }
}
