//! State matrices of small motions about a state: from inputs to outputs.

use nalgebra::DMatrix;

use super::error::Reason;
use super::linearised::{Basis, Linearised};
use crate::system::{Parameters, State, System};

/// `u' = A u + B w, z = C u + D w` about a state.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StateMatrices {
    /// States by states.
    pub A: DMatrix<f64>,
    /// States by inputs.
    pub B: DMatrix<f64>,
    /// Outputs by states.
    pub C: DMatrix<f64>,
    /// Outputs by inputs.
    pub D: DMatrix<f64>,
    /// What each state is: displacements and rotations (radians) of parts along ground axes, their velocities, dynamic states.
    pub states: Vec<String>,
}

/// The state matrices from some VARIABLEs to others, by their places in the model. An input is what is added to its variable.
///
/// The displacements among the states are coordinates of parts, as many as there are freedoms; the others follow from the constraints.
///
/// # Errors
/// [`Reason`] where an element has no value, or a motion has no mass.
pub(crate) fn state_matrices(
    system: &System,
    parameters: &Parameters,
    state: &State,
    (inputs, outputs): (&[usize], &[usize]),
) -> Result<StateMatrices, Reason> {
    let about = Linearised::new(system, parameters, state, true, Basis::Coordinates)?;
    let size = about.E.nrows();
    let lu = about.E.clone().full_piv_lu();
    let pivots = lu.u().diagonal();
    let regular = pivots.iter().all(|p| p.abs() > 1e-12 * pivots.amax());
    let by_inputs = about.B.select_columns(inputs);
    let (Some(A), Some(B), true) = (lu.solve(&about.F), lu.solve(&by_inputs), regular) else {
        let massless = about.chosen.first().copied().unwrap_or(0);
        return Err(Reason::MassSingular {
            freedom: system.freedom_name(massless),
        });
    };
    let (by_u, by_rate) = (
        about.by_u.select_rows(outputs),
        about.by_rate.select_rows(outputs),
    );
    let direct = about.by_input.select_rows(outputs).select_columns(inputs);
    let C = by_u + &by_rate * &A;
    let D = direct + &by_rate * &B;
    let mut names: Vec<String> = about
        .chosen
        .iter()
        .map(|&unknown| system.freedom_name(unknown))
        .collect();
    let rates: Vec<String> = names.iter().map(|name| format!("rate of {name}")).collect();
    names.extend(rates);
    let mut states: Vec<_> = system.states.iter().collect();
    states.sort_by_key(|equation| equation.moving_unknown);
    names.extend(states.iter().map(|equation| equation.name.to_string()));
    debug_assert_eq!(names.len(), size);
    Ok(StateMatrices {
        A,
        B,
        C,
        D,
        states: names,
    })
}
