//! The tangent compared with finite differences: of the residual along random motions, and of the equilibrium with respect to every parameter.

use admire_solver::statics::{Solver, StaticSettings, Tangent};
use admire_solver::system::{Parameters, Slot, State, System};

use crate::differences::{along, richardson, step};
use crate::reference::{AXLES, load};

fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut x = seed;
    (0..n)
        .map(|_| {
            x = x
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (x >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
        })
        .collect()
}

/// Returns scales that make lengths, forces and angles comparable.
fn scales(system: &System) -> Vec<f64> {
    let bodies = system.equations_start();
    (0..system.unknowns())
        .map(|k| match k {
            k if k < bodies && k % 6 < 3 => 1.0,
            k if k < bodies => 0.01,
            _ => 100.0,
        })
        .collect()
}

/// Checks that the tangent recovers `dx` from `J dx`, computed by differences of the residual.
pub fn check_tangent(system: &System, parameters: &Parameters, state: &State, tolerance: f64) {
    let mut tangent = Tangent::new(system, parameters, state).unwrap();
    assert_eq!(tangent.deficiency(), 0);
    let scales = scales(system);
    let n = system.unknowns();
    for seed in 1..6 {
        let dx: Vec<f64> = random(n, seed)
            .iter()
            .zip(&scales)
            .map(|(r, s)| r * s)
            .collect();
        let (coarse, fine) = along(system, parameters, state, &dx);
        let mut dg = richardson(&coarse, &fine);
        tangent.respond(&mut dg);
        for k in 0..n {
            let error = (dg[k] + dx[k]).abs() / scales[k];
            assert!(error < tolerance, "unknown {k}: {} for {}", -dg[k], dx[k]);
        }
    }
}

#[test]
fn tangent_is_the_derivative_of_the_residual() {
    for stem in AXLES {
        let Some((model, _)) = load(stem) else { return };
        let system = System::compile(&model).value;
        let (parameters, mut state) = (system.parameters(), system.state());
        Solver::new(&system)
            .solve(&system, &parameters, &mut state, &StaticSettings::tight())
            .unwrap();
        // The check is also made away from equilibrium, so that it does not rely on balanced forces or closed joints.
        let away: Vec<f64> = random(system.unknowns(), 7)
            .iter()
            .zip(scales(&system))
            .map(|(r, s)| r * s * 3.0)
            .collect();
        check_tangent(&system, &parameters, &state, 1e-6);
        system.advance(&mut state, &away);
        check_tangent(&system, &parameters, &state, 1e-6);
    }
}

/// Compares Richardson differences of the equilibrium with respect to one parameter with the tangent. Returns the error relative to the norm of
/// the column.
pub fn check_slot(
    system: &System,
    solver: &mut Solver,
    parameters: &Parameters,
    state: &State,
    slot: Slot,
    tangent: &mut Tangent,
) -> f64 {
    let here = parameters.get(slot);
    let h = step(system, slot, here);
    let mut difference = |h: f64| -> Vec<f64> {
        let mut ends = [h, -h].map(|h| {
            let mut parameters = parameters.clone();
            parameters.set(slot, here + h);
            let mut state = state.clone();
            solver
                .solve(system, &parameters, &mut state, &StaticSettings::tight())
                .unwrap();
            state
        });
        // Logarithm of the rotation between the two ends. It is centred, so errors of even order cancel.
        let [plus, minus] = &mut ends;
        let mut out = Vec::new();
        for (k, (p, m)) in plus.poses.iter().zip(&minus.poses).enumerate() {
            // Displacement of the reference point, to which the translational unknowns refer.
            let part = admire_solver::model::PartIx(k);
            let shift = system.reference_point(plus, part) - system.reference_point(minus, part);
            out.extend((shift / (2.0 * h)).iter());
            let turn = admire_solver::mechanics::log(&(p.R * m.R.transpose())) / (2.0 * h);
            out.extend((turn * 100.0).iter());
        }
        out
    };
    let (coarse, fine) = (difference(h), difference(h / 2.0));
    let column = tangent.by_slot(system, parameters, state, slot).unwrap();
    let mut exact = Vec::new();
    for part in 0..state.poses.len() {
        let range = system.part_unknowns(admire_solver::model::PartIx(part));
        if range.is_empty() {
            exact.extend([0.0; 6]);
        } else {
            exact.extend(
                column[range.clone()].iter().enumerate().map(
                    |(k, d)| {
                        if k < 3 { *d } else { *d * 100.0 }
                    },
                ),
            );
        }
    }
    let norm = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
    let error = richardson(&coarse, &fine)
        .iter()
        .zip(&exact)
        .map(|(difference, exact)| (difference - exact).powi(2))
        .sum::<f64>()
        .sqrt();
    // Round-off of a difference due to the tolerance of the solver.
    let noise = 1e-9 / h;
    error / (norm + noise * 1e5)
}

#[test]
fn every_number_of_theta() {
    for stem in AXLES {
        let Some((model, _)) = load(stem) else { return };
        let system = System::compile(&model).value;
        let (mut parameters, mut state) = (system.parameters(), system.state());
        for slot in system.catalogue().slots() {
            if parameters.get(slot).is_nan() {
                parameters.set(slot, 700.0);
            }
        }
        let mut solver = Solver::new(&system);
        solver
            .solve(&system, &parameters, &mut state, &StaticSettings::tight())
            .unwrap();
        let mut tangent = Tangent::new(&system, &parameters, &state).unwrap();
        let mut worst = (0.0, String::new());
        for slot in system.catalogue().slots() {
            let address = system.catalogue().info(slot).address;
            if address.argument.as_deref() == Some("FUNCTION") {
                continue;
            }
            assert_eq!(system.catalogue().slot(&address), Some(slot), "{address}");
            let error = check_slot(
                &system,
                &mut solver,
                &parameters,
                &state,
                slot,
                &mut tangent,
            );
            if error > worst.0 {
                worst = (error, address.to_string());
            }
        }
        println!(
            "{stem}: {} numbers, worst {worst:?}",
            system.catalogue().len()
        );
        assert!(worst.0 < 1e-5, "{worst:?}");
    }
}
