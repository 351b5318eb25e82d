//! State matrices, which relate the outputs of small motions about a state to the inputs.

use nalgebra::DMatrix;

use super::coordinates::Coordinates;
use super::error::MotionFailure;
use super::linearised::Linearised;
use super::reduced::{Irreducible, Reduced};
use crate::system::{Parameters, State, System};

/// Rates whose coefficients in E are below this share of the largest count as massless.
const NO_MASS: f64 = 1e-12;

/// State equations `u' = A u + B w, z = C u + D w` about a state, with states u, inputs w and outputs z.
#[derive(Clone, PartialEq, Debug)]
pub struct StateMatrices {
    /// State matrix; its rows and columns are states.
    pub A: DMatrix<f64>,
    /// Input matrix; its rows are states, its columns inputs.
    pub B: DMatrix<f64>,
    /// Output matrix; its rows are outputs, its columns states.
    pub C: DMatrix<f64>,
    /// Feedthrough matrix; its rows are outputs, its columns inputs.
    pub D: DMatrix<f64>,
    /// Name of each state. The states are coordinates (for example displacements and rotations of parts, in radians), rates of coordinates, and
    /// dynamic states.
    pub states: Vec<String>,
}

/// Computes the state matrices from the VARIABLEs `inputs` to the VARIABLEs `outputs`, which are given by their index in the model. An input is
/// added to the value of its VARIABLE.
///
/// The states contain as many coordinates as there are degrees of freedom, and the time derivatives of these coordinates. The position of a
/// motion without inertia is a state only where damping acts; elsewhere it follows from the stiffness.
///
/// # Errors
/// Returns [`MotionFailure`] if an element has no value, a motion without mass is not restrained, or the rate of an input is needed.
pub fn state_matrices(
    system: &System,
    parameters: &Parameters,
    state: &State,
    inputs: &[usize],
    outputs: &[usize],
    coordinates: &Coordinates,
) -> Result<StateMatrices, MotionFailure> {
    let about = Linearised::new(system, parameters, state, true, Some(coordinates))?;
    let (p, r) = (about.chosen.len(), about.rates);
    // A coordinate and its rate have inertia if the time derivative of the rate enters the equations.
    let by_rate = about.E.rows(p, about.E.nrows() - p);
    let weight: Vec<f64> = by_rate.column_iter().map(|column| column.amax()).collect();
    let most = weight[p..p + r].iter().fold(0.0_f64, |a, b| a.max(*b));
    let rate_of = |k: usize| {
        let mut rates = about.chosen_rates.iter();
        let at = rates.position(|rate| *rate == about.chosen[k]);
        at.map(|at| p + at)
    };
    let is_light = |k: usize| !(weight[k] > NO_MASS * most);
    // Rates without inertia are eliminated first, so that a motion restrained by damping keeps its position as a state.
    let lightness: Vec<u8> = (0..weight.len())
        .map(|k| match k {
            k if k < p => u8::from(rate_of(k).is_some_and(is_light)),
            k if k < p + r && is_light(k) => 2,
            _ => 0,
        })
        .collect();
    let by_inputs = about.B.select_columns(inputs);
    let of = |row: &usize| coordinates.name(system, *row);
    let mut names: Vec<String> = about.chosen.iter().map(of).collect();
    let rates = about.chosen_rates.iter().map(of);
    names.extend(rates.map(|name| format!("rate of {name}")));
    let mut states: Vec<_> = system.states.iter().collect();
    states.sort_by_key(|equation| equation.moving_unknown);
    names.extend(states.iter().map(|equation| equation.name.to_string()));
    let reduced = Reduced::new(&about.E, &about.F, &by_inputs, &lightness);
    let reduced = reduced.map_err(|why| match why {
        Irreducible::Undetermined => {
            let light = (0..p).find(|k| lightness[*k] > 0).unwrap_or(0);
            MotionFailure::MassSingular {
                freedom: names.get(light).cloned().unwrap_or_default(),
            }
        }
        Irreducible::StateByInputRate(state) => MotionFailure::InputRate {
            what: names[state].clone(),
        },
    })?;
    let (by_u, by_rate) = (
        about.by_u.select_rows(outputs),
        about.by_rate.select_rows(outputs),
    );
    let direct = about.by_input.select_rows(outputs).select_columns(inputs);
    let (C, D) =
        reduced
            .output(&by_u, &by_rate, &direct)
            .map_err(|row| MotionFailure::InputRate {
                what: system.variables[outputs[row]].name.to_string(),
            })?;
    let states = reduced.kept.iter().map(|k| names[*k].clone()).collect();
    let B = reduced.B.columns(0, inputs.len()).into_owned();
    Ok(StateMatrices {
        A: reduced.A,
        B,
        C,
        D,
        states,
    })
}
