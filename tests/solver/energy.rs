//! Elements with a potential: the potential is stationary at the equilibrium, and reactions are its derivatives.

use std::fs;
use std::path::Path;

use admire_solver::mechanics::{Pose, Vec3, exp};
use admire_solver::model::Model;
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::{Scratch, State, System};

use crate::deck::{self, solve};
use crate::reference::address;

/// Returns the potential of a pose, from the numbers of the deck: a body on three springs and a bushing without torsion, under gravity.
fn potential(pose: &Pose) -> f64 {
    let springs = [
        ([50.0, 0.0, 0.0], [120.0, 80.0, 10.0], 4.0, 90.0, 20.0),
        ([-50.0, 20.0, 0.0], [-110.0, 90.0, -20.0], 6.0, 70.0, -10.0),
        ([0.0, 0.0, 40.0], [10.0, 70.0, 110.0], 5.0, 100.0, 0.0),
    ];
    let mut out = 2.5 * 9.80665 * pose.point(&Vec3::new(3.0, 4.0, 5.0)).y;
    for (a, b, k, length, force) in springs {
        let r = (pose.point(&Vec3::from(a)) - Vec3::from(b)).norm();
        out += 0.5 * k * (r - length) * (r - length) - force * (r - length);
    }
    // The bushing acts along ground axes, because its J marker is on ground.
    let d = pose.point(&Vec3::new(0.0, -30.0, 0.0)) - Vec3::new(2.0, -35.0, 1.0);
    out + 0.5 * (30.0 * d.x * d.x + 20.0 * d.y * d.y + 10.0 * d.z * d.z) - 15.0 * d.x
}

#[test]
fn the_potential_is_least_at_the_equilibrium() {
    let solved = solve(
        "ACCGRAV/JGRAV=-9806.65\nPART/2, MASS=2.5, CM=20, IP=1E3,1E3,1E3\nMARKER/20, PART=2, QP=3,4,5\n\
         MARKER/21, PART=2, QP=50,0,0\nMARKER/22, PART=2, QP=-50,20,0\nMARKER/23, PART=2, QP=0,0,40\nMARKER/24, PART=2, QP=0,-30,0\n\
         MARKER/11, PART=1, QP=120,80,10\nMARKER/12, PART=1, QP=-110,90,-20\nMARKER/13, PART=1, QP=10,70,110\nMARKER/14, PART=1, QP=2,-35,1\n\
         SPRINGDAMPER/1, I=21, J=11, TRANSLATIONAL, K=4, LENGTH=90, FORCE=20\n\
         SPRINGDAMPER/2, I=22, J=12, TRANSLATIONAL, K=6, LENGTH=70, FORCE=-10\n\
         SPRINGDAMPER/3, I=13, J=23, TRANSLATIONAL, K=5, LENGTH=100\n\
         BUSHING/1, I=24, J=14, K=30,20,10, FORCE=15,0,0",
    );
    assert!(solved.report.free_motions.is_empty());
    let here = solved.pose(2);
    let moved = |d: &Vec3, turn: &Vec3| Pose {
        p: here.p + d,
        R: exp(turn) * here.R,
    };
    for k in 0..6 {
        let (shift, turn, h) = if k < 3 {
            (Vec3::ith(k, 1.0), Vec3::zeros(), 1e-3)
        } else {
            (Vec3::zeros(), Vec3::ith(k - 3, 1.0), 1e-5)
        };
        let (plus, minus) = (
            potential(&moved(&(shift * h), &(turn * h))),
            potential(&moved(&(shift * -h), &(turn * -h))),
        );
        let slope = (plus - minus) / (2.0 * h);
        assert!(slope.abs() < 1e-5 / h.sqrt(), "{k}: {slope}");
        assert!(plus + minus > 2.0 * potential(&here), "{k}");
    }
}

/// Checks that the work of the MOTION, while a part moves once along its rail, is the energy stored in the springs (Simpson's rule over 40
/// intervals).
#[test]
fn work_is_stored() {
    let deck = |z: f64| {
        solve(&format!(
            "PART/2, MASS=1, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2\nJOINT/1, TRANSLATIONAL, I=21, J=1\n\
             MARKER/2, PART=1, QP=30,0,20\nMARKER/3, PART=1, QP=0,-40,-10\n\
             SPRINGDAMPER/1, I=21, J=2, TRANSLATIONAL, K=7, LENGTH=40\nSPRINGDAMPER/2, I=3, J=21, TRANSLATIONAL, K=3, LENGTH=30, FORCE=12\n\
             MOTION/1, JOINT=1, FUNCTION={z}"
        ))
    };
    let stored = |z: f64| {
        let (a, b) = (30_f64.hypot(z - 20.0) - 40.0, 40_f64.hypot(z + 10.0) - 30.0);
        0.5 * 7.0 * a * a + 0.5 * 3.0 * b * b - 12.0 * b
    };
    let (n, end) = (40, 50.0);
    let h = end / f64::from(n);
    let mut work = 0.0;
    for k in 0..=n {
        let z = h * f64::from(k);
        let (F, _) = deck(z).on(2, "MOTION/1", &Vec3::zeros());
        let weight = match k {
            0 => 1.0,
            k if k == n => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        work += weight * F.z * h / 3.0;
    }
    let gained = stored(end) - stored(0.0);
    assert!((work / gained - 1.0).abs() < 1e-6, "{work} {gained}");
}

/// Checks virtual work on a whole axle with weight. The forces of the MOTIONs of the double wishbone are the derivatives of the potential energy
/// with respect to the prescribed displacements, however many joints are in between.
#[test]
fn motions_feel_the_slope_of_the_potential() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/double-wishbone/model.adm");
    let mut model: Model = deck::read(&fs::read_to_string(path).unwrap());
    model.gravity = Vec3::new(800.0, -500.0, -9806.65);
    let system = System::compile(&model).value;
    let mut solver = Solver::new(&system);
    let mut parameters = system.parameters();
    let slots = [1, 2, 3].map(|id| system.catalogue().slot(&address("MOTION", id)).unwrap());
    let mut at = |driven: [f64; 3]| -> (State, f64) {
        for (slot, value) in slots.iter().zip(driven) {
            parameters.set(*slot, value);
        }
        let mut state = system.state();
        solver
            .solve(&system, &parameters, &mut state, &StaticSettings::tight())
            .unwrap();
        let mut potential = 0.0;
        for (part, pose) in model.parts.iter().zip(&state.poses) {
            if let Some(cm) = part.cm {
                let cm = pose.point(&model.markers[cm.0].qp);
                potential -= part.mass * cm.dot(&model.gravity) / 1000.0;
            }
        }
        (state, potential)
    };
    let here = [4.0, 25.0, -30.0];
    let (state, _) = at(here);
    let mut slopes = [0.0; 3];
    for k in 0..3 {
        let mut difference = |h: f64| {
            let (mut plus, mut minus) = (here, here);
            plus[k] += h;
            minus[k] -= h;
            (at(plus).1 - at(minus).1) / (2.0 * h)
        };
        slopes[k] = (4.0 * difference(0.05) - difference(0.1)) / 3.0;
    }
    for (slot, value) in slots.iter().zip(here) {
        parameters.set(*slot, value);
    }
    let mut scratch = Scratch::new(&system);
    let mut here = system.evaluate(&parameters, &state, &mut scratch).unwrap();
    let loads = here.loads().unwrap();
    for (id, slope) in (1..).zip(slopes) {
        let axis = if id == 1 { Vec3::y() } else { Vec3::z() };
        let force: f64 = loads
            .iter()
            .filter(|l| {
                l.by.as_ref()
                    .is_some_and(|n| n.kind == "MOTION" && n.id == id)
            })
            .filter(|l| model.parts[l.part.0].header.name != "ground")
            .map(|l| l.force.dot(&axis))
            .sum();
        assert!(
            (force - slope).abs() < 1e-6 * slope.abs(),
            "{id}: {force} {slope}"
        );
        assert!(slope.abs() > 1.0);
    }
}
