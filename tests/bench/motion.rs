//! Benchmark of integration errors: the error at the end of a motion relative to the requested ERROR, from 1e-2 to 1e-8, with the number of
//! steps.
//!
//! It also prints the energy drift of random trees and loops of joints for 200 seeds. `cargo bench --bench motion`; `-- SEEDS` sets another
//! number of seeds. The source of each closed-form solution is given beside its model.

#![allow(non_snake_case)] // Forces, moments and matrices keep their capitals.

#[path = "../common/conserved.rs"]
mod conserved;
#[path = "../common/squeezer.rs"]
mod squeezer;

use std::time::Instant;

use admire_solver::model::Model;
use admire_solver::motion::{Consistent, Integrator, Kept, MotionSettings, assemble};
use admire_solver::system::{State, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

const HEAD: &str = "motion\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";

/// A model with a known end state. `end` is its duration and `hmax` its largest step.
///
/// `off` returns the distance of a state from the known one, relative to the larger of one and the largest value.
struct Known {
    name: &'static str,
    deck: String,
    end: f64,
    hmax: f64,
    off: fn(&State) -> f64,
}

fn models() -> Vec<Known> {
    vec![
        Known {
            // End state by quadrature of the energy integral.
            name: "pendulum, 5 s",
            deck: format!(
                "{HEAD}ACCGRAV/KGRAV=-9.80665\nPART/2, MASS=1, CM=20, IP=0.04,0.1,0.1\nMARKER/20, PART=2, QP=2,0,0\nMARKER/21, PART=2, REULER=180D,90D,180D\nMARKER/11, PART=1, REULER=180D,90D,180D\nJOINT/1, REVOLUTE, I=21, J=11\nEND\n"
            ),
            end: 5.0,
            hmax: 5.0,
            off: |state| {
                let cm = state.poses[1].point(&admire_solver::mechanics::Vec3::new(2.0, 0.0, 0.0));
                let place = (cm.x + 1.999_683_868_884)
                    .abs()
                    .max((cm.z + 0.035_558_747_545).abs());
                let spin = state.velocities[1].angular.norm() - 0.412_436_065_475;
                (place / 2.0).max(spin.abs() / 4.0)
            },
        },
        Known {
            name: "Andrews' squeezer, 0.03 s",
            deck: squeezer::squeezer(),
            end: 0.03,
            hmax: 0.03,
            off: |state| {
                let ends = squeezer::expected();
                let angles = state.poses.iter().skip(1).zip(ends).map(|(pose, end)| {
                    let turn = std::f64::consts::TAU;
                    let off = (pose.R[(1, 0)].atan2(pose.R[(0, 0)]) - end) / turn;
                    ((off - off.round()) * turn).abs()
                });
                angles.fold(0.0, f64::max)
            },
        },
        Known {
            // Two masses on springs: frequencies and mode shapes of [2 -1; -1 1] k / m, released from rest at (1, 0).
            name: "two masses on springs, 20 s",
            deck: format!(
                "{HEAD}MARKER/2, PART=1, QP=0,0,-3\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1\nMARKER/20, PART=2\nPART/3, MASS=1, CM=30, IP=1,1,1, QG=0,0,5\nMARKER/30, PART=3\nJOINT/1, TRANSLATIONAL, I=20, J=1\nJOINT/2, TRANSLATIONAL, I=30, J=1\nSPRINGDAMPER/1, TRANSLATIONAL, I=20, J=2, K=1, LENGTH=3\nSPRINGDAMPER/2, TRANSLATIONAL, I=30, J=20, K=1, LENGTH=5\nEND\n"
            ),
            end: 20.0,
            hmax: 20.0,
            off: |state| {
                let root = 5.0_f64.sqrt();
                let (mut x, mut y) = (0.0, 0.0);
                for sign in [1.0, -1.0] {
                    let square = f64::midpoint(3.0, sign * root);
                    // Mode shape (1, 2 - square), with squared norm 1 + (2 - square)^2.
                    let other = 2.0 - square;
                    let part = (square.sqrt() * 20.0).cos() / (1.0 + other * other);
                    x += part;
                    y += other * part;
                }
                let off = (state.poses[1].p.z - x).abs();
                off.max((state.poses[2].p.z - 5.0 - y).abs())
            },
        },
        Known {
            // Dropped from 1 m onto k = 1e4, c = 0: the period is .934906080799 s, so the ball is at the top again after two periods.
            name: "ball on IMPACT, 1.869812161598 s",
            deck: format!(
                "{HEAD}ACCGRAV/KGRAV=-9.81\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=IMPACT(DZ(20),VZ(20),0,1E4,1,0,1E-4)\nEND\n"
            ),
            end: 1.869_812_161_598,
            hmax: 0.01,
            off: |state| {
                let off = (state.poses[1].p.z - 1.0).abs();
                off.max(state.velocities[1].linear.z.abs() / 4.43)
            },
        },
        Known {
            // Drop with an exponent of 1.5 and k = 1e5; end time by quadrature of the energy integral.
            name: "ball on IMPACT, exponent 1.5, 1.854205598914 s",
            deck: along_z(
                "ACCGRAV/KGRAV=-9.81",
                1.0,
                0.0,
                "IMPACT(DZ(20),VZ(20),0,1E5,1.5,0,1E-4)",
            ),
            end: 1.854_205_598_914,
            hmax: 10.0,
            off: |state| {
                let off = (state.poses[1].p.z - 1.0).abs();
                off.max(state.velocities[1].linear.z.abs() / 4.43)
            },
        },
        Known {
            // 1 kg at 1 m/s between two stops of k = 1e4; each contact lasts half a period of the spring.
            name: "between the stops of a BISTOP, two rounds",
            deck: along_z("", 0.0, 1.0, "BISTOP(DZ(20),VZ(20),-0.5,0.5,1E4,1,0,1E-4)"),
            end: 4.0 + 4.0 * std::f64::consts::PI / 100.0,
            hmax: 10.0,
            off: |state| {
                let off = state.poses[1].p.z.abs();
                off.max((state.velocities[1].linear.z - 1.0).abs())
            },
        },
        Known {
            // 100 N/m above and 400 N/m below, with half periods of pi/10 and pi/20.
            name: "spring of two rates by IF, three periods",
            deck: along_z("", 1.0, 0.0, "IF(DZ(20):-400*DZ(20),0,-100*DZ(20))"),
            end: 0.45 * std::f64::consts::PI,
            hmax: 10.0,
            off: |state| {
                let off = (state.poses[1].p.z - 1.0).abs();
                off.max(state.velocities[1].linear.z.abs() / 10.0)
            },
        },
        Known {
            // 5 N against the velocity and 100 N/m: each half swing takes pi/10 s, has its centre 0.05 m off zero, and is 0.1 m shorter
            // than the one before.
            name: "dry friction by IF, five half swings and a third",
            deck: along_z("", 1.0, 0.0, "-100*DZ(20)+IF(VZ(20):5,0,-5)"),
            end: (0.5 + 1.0 / 30.0) * std::f64::consts::PI,
            hmax: 10.0,
            off: |state| {
                let off = (state.poses[1].p.z + 0.275).abs();
                let rate = 4.5 * (std::f64::consts::PI / 3.0).sin();
                off.max((state.velocities[1].linear.z - rate).abs() / 9.5)
            },
        },
    ]
}

/// Returns a deck of a 1 kg mass that moves along z under a force, with its initial position and velocity.
fn along_z(gravity: &str, z: f64, vz: f64, force: &str) -> String {
    format!(
        "{HEAD}{gravity}\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,{z}, VZ={vz}\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION={force}\nEND\n"
    )
}

fn main() {
    let seeds = std::env::args()
        .skip(1)
        .find_map(|word| word.parse::<u64>().ok())
        .unwrap_or(200);
    for known in models() {
        println!("{}", known.name);
        println!("  ERROR   error/ERROR   steps  rejected  factorisations    ms");
        let dataset = Dataset::parse(Source::new("motion.adm", known.deck.clone().into_bytes()));
        let system = System::compile(&Model::lower(&dataset.value).value).value;
        for digits in 2..=8 {
            let error = 10.0_f64.powi(-digits);
            let start = Instant::now();
            let mut state = system.state();
            let parameters = system.parameters();
            let mut memory = Consistent::new(&system);
            assemble(
                &system,
                &parameters,
                &mut state,
                &mut memory,
                Kept::Data,
                1e-4,
            )
            .expect("the model can be assembled");
            let settings = MotionSettings {
                error,
                hinit: known.hmax / 20.0,
                hmax: known.hmax,
                hmin: 1e-9 * known.hmax,
                output: known.hmax,
                maxit: 10,
                corrector: 1.0,
                adaptivity: 0.0,
            };
            let mut integrator = Integrator::new(&system, &parameters, state, settings);
            integrator.advance_to(known.end).expect("the model moves");
            let done = integrator.statistics();
            let off = (known.off)(&integrator.output().expect("an output"));
            println!(
                "  {error:.0e}   {:11.4}  {:6}  {:8}  {:14}  {:4.0}",
                off / error,
                done.steps,
                done.rejected,
                done.factorisations,
                1e3 * start.elapsed().as_secs_f64()
            );
        }
    }
    let mut worst = (0.0_f64, 0);
    for seed in 1..=seeds {
        let off = conserved::energy_off(seed, 1e-6, 1.0);
        if !(off <= worst.0) {
            worst = (off, seed);
        }
    }
    println!(
        "energy of {seeds} random mechanisms after 1 s at ERROR 1e-6: off by {:.1e} at most, seed {}",
        worst.0, worst.1
    );
}
