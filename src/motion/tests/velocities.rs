//! GCONs of velocities: rolling and sliding without slip, against closed forms and constraints of places.

use super::*;

/// The sleigh's part: its edge at the origin, the mass centre A ahead on x.
const M: f64 = 2.0;
const A: f64 = 0.3;
const I: f64 = 0.5;

fn sleigh(gcon: &str) -> Deck {
    deck(&format!(
        "PART/2, MASS={M}, CM=20, IP=0.2,0.4,{I}, QG=0,0,0, VX=0.1, VY=-0.6, WZ=-2
MARKER/20, PART=2, QP={A},0,0
MARKER/21, PART=2
JOINT/1, PLANAR, I=21, J=1
{gcon}"
    ))
}

/// Chaplygin's sleigh: with u the speed along the edge, w the spin and k^2 = a^2 + I/m, `u' = a w^2`, `w' = -a u w/k^2`, so that
/// `u = c tanh(a c t/k^2 + s)`, `k w = c sech(...)`; the edge is pushed across by `m u w (1 - a^2/k^2)`.
#[test]
fn a_sleigh_turns_until_it_glides_straight() {
    let deck = sleigh("GCON/1, I=21, FUNCTION=VY(21,1,21)");
    let mut integrator = begun(&deck, 1e-8, 0.1);
    let start = integrator.output().unwrap();
    let along = |state: &State| {
        let x: Vec3 = state.poses[1].R.column(0).into();
        (
            x.dot(&state.velocities[1].linear),
            state.velocities[1].angular.z,
        )
    };
    let k2 = A * A + I / M;
    let (u, w) = along(&start);
    let c = (u * u + k2 * w * w).sqrt();
    let s = (u / c).atanh();
    assert!(w < -0.5, "{u} {w}");
    for step in 1..=50 {
        let time = 0.1 * f64::from(step);
        integrator.advance_to(time).unwrap();
        let state = integrator.output().unwrap();
        let (u, w) = along(&state);
        let tau = A * c * time / k2 + s;
        let (known_u, known_w) = (c * tau.tanh(), -c / k2.sqrt() / tau.cosh());
        assert!((u - known_u).abs() < 1e-7, "{time}: {u} {known_u}");
        assert!((w - known_w).abs() < 1e-7, "{time}: {w} {known_w}");
        let mut scratch = Scratch::new(&deck.system);
        let here = deck
            .system
            .look(&deck.parameters, &state, &mut scratch)
            .unwrap();
        let marker = crate::model::MarkerIx(2);
        let (force, torque) = here.read_condition(1, marker);
        let across = state.poses[1].R.transpose() * force;
        let known = M * u * w * (1.0 - A * A / k2);
        assert!(
            (across - Vec3::new(0.0, known, 0.0)).norm() < 1e-9,
            "{across} {known}"
        );
        assert!(torque.norm() < 1e-9, "{torque}");
    }
}

/// A ball of radius R on a plane that turns at O: its centre goes round a circle at 2/7 O, wherever it begins (the uniform ball).
#[test]
fn a_ball_on_a_turntable_goes_round_a_circle() {
    let (R, O) = (0.2, 3.0);
    let inertia = 0.4 * 1.5 * R * R;
    let deck = deck(&format!(
        "ACCGRAV/KGRAV=-9.81
PART/2, MASS=1.5, CM=20, IP={inertia},{inertia},{inertia}, QG=1,0.5,{R}, VX=0.4, VY=-0.3, WZ=1.2
MARKER/20, PART=2
JPRIM/1, INPLANE, I=20, J=2
MARKER/2, PART=1, QP=0,0,{R}
GCON/1, I=20, FUNCTION=VX(20)-{R}*WY(20)+{O}*DY(20,1)
GCON/2, I=20, FUNCTION=VY(20)+{R}*WX(20)-{O}*DX(20,1)"
    ));
    let mut integrator = begun(&deck, 1e-7, 0.1);
    let start = integrator.output().unwrap();
    let (p, v) = (start.poses[1].p, start.velocities[1].linear);
    assert!((start.velocities[1].linear.z).abs() < 1e-12);
    let rate = 2.0 / 7.0 * O;
    // v turns at the rate; the centre of the circle is p + z x v / rate.
    let centre = p + Vec3::z().cross(&v) / rate;
    for step in 1..=40 {
        let time = 0.25 * f64::from(step);
        integrator.advance_to(time).unwrap();
        let state = integrator.output().unwrap();
        let known = centre + exp(&(Vec3::z() * rate * time)) * (p - centre);
        assert!(
            (state.poses[1].p - known).norm() < 1e-6,
            "{time}: {} {known}",
            state.poses[1].p
        );
        // What is not held keeps.
        assert!((state.velocities[1].angular.z - start.velocities[1].angular.z).abs() < 1e-8);
    }
}

/// The same constraint as a function of places and as its rate.
#[test]
fn the_rate_of_a_constraint_is_the_constraint() {
    let with = |gcon: &str| {
        deck(&format!(
            "ACCGRAV/KGRAV=-9.81
PART/2, MASS=1, CM=20, IP=0.04,0.1,0.2, REULER=0.3,0.9,0.1, WY=1
MARKER/20, PART=2, QP=0.4,0.1,0
MARKER/21, PART=2, QP=0,0.3,0.2
MARKER/2, PART=1, QP=1.5,0,0.2
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=20, C=0.3, LENGTH=0.4
{gcon}"
        ))
    };
    let places = with("GCON/1, FUNCTION=DM(21,2)-0.2*DX(20,21)*TIME-1.4142135623730951");
    let distance = |state: &State| {
        let at = |q: Vec3| state.poses[1].point(&q);
        let (a, b) = (at(Vec3::new(0.0, 0.3, 0.2)), at(Vec3::new(0.4, 0.1, 0.0)));
        (a - Vec3::new(1.5, 0.0, 0.2)).norm() - 0.2 * (b - a).x * state.time
    };
    for error in [1e-4, 1e-6, 1e-8] {
        // The length begins where the other does.
        let (start, _) = integrated(&places, error, 0.05, 1e-9);
        let held = with(&format!(
            "GCON/1, FUNCTION=VR(21,2)-0.2*VX(20,21)*TIME-0.2*DX(20,21)"
        ));
        let mut held = held;
        held.state.poses = start.poses.clone();
        let (a, _) = integrated(&places, error, 0.05, 2.0);
        let (b, _) = integrated(&held, error, 0.05, 2.0);
        let apart = (a.poses[1].p - b.poses[1].p).norm();
        let faster = (a.velocities[1].linear - b.velocities[1].linear).norm();
        println!("{error:e}: {apart:e} {faster:e}");
        assert!(
            apart < 10.0 * error && faster < 10.0 * error * 5.0,
            "{error}: {apart} {faster}"
        );
        assert!((distance(&a) - distance(&start)).abs() < 1e-10);
        assert!((distance(&b) - distance(&start)).abs() < 10.0 * error);
        // Reactions at the end: the same force.
        assert!((a.multipliers[0] - b.multipliers[0]).abs() < 1e3 * error * 10.0);
    }
}
