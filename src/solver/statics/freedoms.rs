use super::rank::redundant_equations;
use crate::linear::Matrix;
use crate::system::{Parameters, Scratch, State, System};

/// Degrees of freedom of a mechanism in one configuration.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize)]
pub struct FreedomCount {
    /// Degrees of freedom of the unconstrained parts: six for every part that can move, three for every point mass.
    pub of_parts: usize,
    /// Number of scalar equations of joints, primitives, motions, couplers, gears and general constraints.
    pub equations: usize,
    /// Names of the equations that are redundant in this configuration, in the notation of ADAMS.
    pub redundant: Vec<String>,
    /// Message that names an element without a value in this configuration, and the reason. The equations of joints and motions are counted
    /// nevertheless.
    pub without_value: Option<String>,
}

impl FreedomCount {
    /// Counts the constraint equations and finds the rank of their Jacobian at a state.
    pub fn of(system: &System, parameters: &Parameters, state: &State) -> Self {
        let n = system.unknowns();
        let mut whole = state.clone();
        whole.redundant.clear();
        let (mut matrix, mut g) = (Matrix::new(n), vec![0.0; n]);
        let mut scratch = Scratch::new(system);
        matrix.clear();
        let assembled = system.assemble(parameters, &whole, &mut scratch, &mut g, &mut matrix);
        let without_value = assembled.err().map(|error| error.to_string());
        if without_value.is_some() {
            matrix = Matrix::new(n);
            matrix.clear();
            scratch = Scratch::new(system);
            system.assemble_joints(parameters, &whole, &mut scratch, &mut g, &mut matrix);
        }
        matrix.finish();
        let mut redundant = redundant_equations(system, &matrix);
        if without_value.is_some() {
            // The gradients of GCONs are not available here, so their equations count as independent.
            for condition in &system.conditions {
                redundant[condition.equation] = false;
            }
        }
        Self {
            of_parts: system.first_equation,
            equations: redundant.len(),
            redundant: (0..redundant.len())
                .filter(|k| redundant[*k])
                .map(|k| system.constraint_equation_name(k).to_string())
                .collect(),
            without_value,
        }
    }

    /// Returns the Gruebler count: the degrees of freedom of the unconstrained parts minus the number of equations. It is negative for
    /// overconstrained mechanisms.
    pub fn gruebler(&self) -> i64 {
        self.of_parts as i64 - self.equations as i64
    }

    /// Returns the actual number of degrees of freedom: the Gruebler count with the redundant equations left out.
    pub fn actual(&self) -> i64 {
        self.gruebler() + self.redundant.len() as i64
    }
}
