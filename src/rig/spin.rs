//! Random displacement of parts along free (zero-stiffness) motions, as it occurs on a real rig.

use admire_session::backend::CaseSweeper;
use admire_solver::model::PartIx;
use admire_solver::statics::{displace, twist};
use admire_solver::system::{Parameters, State, System};
use admire_study::Noise;

/// Largest random rotation along a free motion, in degrees. Friction in ball joints can hold a link at this angle.
const TURN_DEG: f64 = 30.0;
/// Largest random displacement along a free sliding motion, in metres.
const SHIFT: f64 = 1e-3;
/// Maximum number of attempts to find a displaced equilibrium. After each failed attempt, the displacement is halved.
const MAX_ATTEMPTS: usize = 6;

/// Returns an equilibrium of a load case that is displaced from the equilibrium `state` by a random amount along each free motion. Returns
/// `state` itself if there are no free motions, or if no displaced equilibrium is found.
pub(super) fn spun(
    system: &System,
    parameters: &Parameters,
    sweeper: &mut CaseSweeper,
    case: usize,
    state: &State,
    metre: f64,
    noise: &mut Noise,
) -> State {
    if !sweeper.solver().has_free_motions() {
        return state.clone();
    }
    let Ok(tangent) = sweeper.solver().tangent(system, parameters, state) else {
        return state.clone();
    };
    let motions = tangent.free_motions(system);
    sweeper.solver().give_back(tangent);
    let largest = |motion: &[f64]| {
        let of = |part| twist(system, state, PartIx(part), motion);
        let twists = (0..state.poses.len()).map(of);
        twists.fold((0.0_f64, 0.0_f64), |(v, w), (own_v, own_w)| {
            (v.max(own_v.norm()), w.max(own_w.norm()))
        })
    };
    let amount = |motion: &Vec<f64>| {
        let (shift, turn) = largest(motion);
        let most = if turn > 0.0 {
            TURN_DEG.to_radians() / turn
        } else {
            SHIFT * metre / shift
        };
        noise.within(most)
    };
    let amounts: Vec<f64> = motions.iter().map(amount).collect();
    let mut part = 1.0;
    for _ in 0..MAX_ATTEMPTS {
        let mut moved = state.clone();
        for (motion, amount) in motions.iter().zip(&amounts) {
            displace(system, &mut moved, motion, part * amount);
        }
        if let Ok(found) = sweeper.solve(system, parameters, case, Some(moved)) {
            return found;
        }
        part *= 0.5;
    }
    state.clone()
}
