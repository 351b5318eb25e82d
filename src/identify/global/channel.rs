//! Sensitivities of the channels (scalar sensors) of a study with respect to the unknowns of a fit.

use nalgebra::DMatrix;

use admire_solver::system::{NoValue, Parameters, Scratch, State, System};
use admire_study::Channels;

use super::unknown::Direction;
use crate::settings::CHANNEL_DIFFERENCE_STEP;

/// Sensitivities of the system's unknowns along directions in parameter space.
#[derive(Clone, Copy, Debug)]
pub struct StateSensitivities<'a> {
    /// Directions in parameter space.
    pub directions: &'a [Direction],
    /// Changes of the system's unknowns, one column per direction.
    pub responses: &'a DMatrix<f64>,
}

/// Computes the changes of all channels in a load case along each direction, one column per direction.
///
/// # Errors
/// Returns [`NoValue`] if the function of a channel is undefined at the state.
pub fn channel_changes(
    channels: Channels,
    system: &System,
    theta: &Parameters,
    case: usize,
    state: &State,
    scratch: &mut Scratch,
    along: StateSensitivities<'_>,
) -> Result<DMatrix<f64>, NoValue> {
    let StateSensitivities {
        directions,
        responses,
    } = along;
    let mut out = DMatrix::zeros(channels.count, directions.len());
    if channels.count == 0 {
        return Ok(out);
    }
    let mut here = system.evaluate(theta, state, scratch)?;
    for k in 0..channels.count {
        let Some((_, gradient)) = here.read_function(channels.first + k, 1)? else {
            continue;
        };
        for (change, response) in out.row_mut(k).iter_mut().zip(responses.column_iter()) {
            *change = gradient
                .iter()
                .map(|(unknown, by)| by * response[*unknown])
                .sum();
        }
    }
    // Direct effect of the parameters while all parts are fixed: a spring force depends on the stiffness, the position of a point on its
    // marker.
    let mut near = theta.clone();
    for (mut changes, direction) in out.column_iter_mut().zip(directions) {
        if !reads(channels, system, direction, case) {
            continue;
        }
        let mut at = |step: f64| {
            near.clone_from(theta);
            for (slot, factor) in direction.in_case(case) {
                near.set(slot, near.get(slot) + step * factor);
            }
            for (marker, axis) in &direction.turns {
                near.turn(*marker, axis, step);
            }
            channels.values(system, &near, state, scratch)
        };
        let (up, down) = (at(CHANNEL_DIFFERENCE_STEP)?, at(-CHANNEL_DIFFERENCE_STEP)?);
        for (change, (up, down)) in changes.iter_mut().zip(up.iter().zip(&down)) {
            *change += (up - down) / (2.0 * CHANNEL_DIFFERENCE_STEP);
        }
    }
    Ok(out)
}

/// Returns true if any channel may change along a direction while all parts are fixed.
fn reads(channels: Channels, system: &System, direction: &Direction, case: usize) -> bool {
    let mut numbers = direction.in_case(case).filter(|(_, weight)| *weight != 0.0);
    let mut requests = channels.first..channels.first + channels.count;
    numbers.any(|(slot, _)| requests.clone().any(|k| system.request_reads(k, 1, slot)))
        || requests.any(|k| {
            let mut turns = direction.turns.iter();
            turns.any(|(marker, _)| system.request_reads_marker(k, 1, *marker))
        })
}
