use rayon::prelude::*;

use super::{SolveError, Tangent};
use crate::system::{Parameters, Quantity, Scratch, Slot, State, System};

/// Sensitivity of an equilibrium, and of quantities measured at it, to the parameters of the model, which form the vector theta.
///
/// The residual is g(x, theta) = 0, a quantity is q(x, theta), and J = dg/dx. Then `dq/dtheta = q_theta - q_x J^-1 g_theta`. The direct method
/// solves `J dx = -g_theta` once per parameter. The adjoint method solves `J' a = -q_x` once per quantity; then
/// `dq/dtheta = q_theta + a . g_theta`. Source: Haug, Choi, Komkov, Design Sensitivity Analysis, 1986, ch. 1.
#[derive(Clone, Debug)]
pub struct Sensitivity<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    state: &'a State,
    tangent: Tangent,
    scratch: Scratch,
}

impl<'a> Sensitivity<'a> {
    /// Linearises the equations at an equilibrium.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn new(
        system: &'a System,
        parameters: &'a Parameters,
        state: &'a State,
    ) -> Result<Self, SolveError> {
        Ok(Self {
            system,
            parameters,
            state,
            tangent: Tangent::new(system, parameters, state)?,
            scratch: Scratch::new(system),
        })
    }

    /// Returns the derivatives of several quantities with respect to one parameter, by the direct method.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn direct(&mut self, quantities: &[Quantity], slot: Slot) -> Result<Vec<f64>, SolveError> {
        let (system, parameters, state) = (self.system, self.parameters, self.state);
        let dx = self.tangent.by_slot(system, parameters, state, slot)?;
        let mut out = Vec::with_capacity(quantities.len());
        let mut by = vec![0.0; system.unknowns()];
        for &quantity in quantities {
            by.fill(0.0);
            let mut here = system.evaluate(parameters, state, &mut self.scratch)?;
            here.quantity_by_unknowns(quantity, &mut by)?;
            let through: f64 = by.iter().zip(&dx).map(|(a, b)| a * b).sum();
            out.push(through + here.quantity_by_slot(quantity, slot)?);
        }
        Ok(out)
    }

    /// Returns the derivatives of all quantities (columns) with respect to all parameters (rows). The direct or the adjoint method is used,
    /// whichever needs fewer back-substitutions. The computation uses all cores; the result does not depend on their number.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn table(
        &self,
        quantities: &[Quantity],
        slots: &[Slot],
    ) -> Result<Vec<Vec<f64>>, SolveError> {
        if slots.len() <= quantities.len() {
            return slots
                .par_iter()
                .map_init(|| self.clone(), |own, &slot| own.direct(quantities, slot))
                .collect();
        }
        let columns: Vec<Vec<f64>> = quantities
            .par_iter()
            .map_init(
                || self.clone(),
                |own, &quantity| own.adjoint(quantity, slots),
            )
            .collect::<Result<_, _>>()?;
        let row = |k: usize| columns.iter().map(|column| column[k]).collect();
        Ok((0..slots.len()).map(row).collect())
    }

    /// Returns the derivatives of one quantity with respect to several parameters, by the adjoint method.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn adjoint(&mut self, quantity: Quantity, slots: &[Slot]) -> Result<Vec<f64>, SolveError> {
        let (system, parameters, state) = (self.system, self.parameters, self.state);
        let mut here = system.evaluate(parameters, state, &mut self.scratch)?;
        let mut weights = vec![0.0; system.unknowns()];
        here.quantity_by_unknowns(quantity, &mut weights)?;
        self.tangent.adjoint(&mut weights);
        let mut dg = vec![0.0; system.unknowns()];
        let mut out = Vec::with_capacity(slots.len());
        for &slot in slots {
            here.residual_by_slot(slot, &mut dg)?;
            let through: f64 = weights.iter().zip(&dg).map(|(a, b)| a * b).sum();
            out.push(through + here.quantity_by_slot(quantity, slot)?);
        }
        Ok(out)
    }
}
