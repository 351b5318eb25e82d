//! Free motions, redundant and contradictory constraints, and stability, reported with the names of the user's deck.

use admire_solver::statics::{SolveError, Solver, StaticSettings, smallest_eigenvalue};
use admire_solver::system::System;

use crate::deck;

const HEAD: &str = "rank\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
                    PART/1, GROUND\nMARKER/1, PART=1\nACCGRAV/JGRAV=-9806.65\n";

fn solve(
    text: &str,
) -> (
    System,
    admire_solver::system::State,
    Result<admire_solver::statics::Report, SolveError>,
) {
    let model = deck::read(&format!("{HEAD}{text}\nEND\n"));
    let system = System::compile(&model).value;
    let mut state = system.state();
    let result = Solver::new(&system).solve(
        &system,
        &system.parameters(),
        &mut state,
        &StaticSettings::tight(),
    );
    (system, state, result)
}

/// Checks that a pendulum finds the position below its pivot from the side, and that the upright position is an unstable equilibrium. The mass
/// centre is the part origin, so only the multipliers contribute to the stiffness.
#[test]
fn pendulum() {
    let at = |x: f64, y: f64| {
        format!(
            "PART/2, QG={x},{y},0, MASS=2, CM=20, IP=100,100,100\nMARKER/20, PART=2\n\
             MARKER/21, PART=2, QP={},{},0\nJOINT/1, REVOLUTE, I=21, J=1",
            -x, -y
        )
    };
    let (system, state, result) = solve(&at(100.0, 0.0));
    let report = result.unwrap();
    println!(
        "{} iterations, {:?}",
        report.iterations, report.continuation
    );
    let p = state.poses[1].p;
    assert!((p.y + 100.0).abs() < 1e-7 && p.x.abs() < 1e-5, "{p}");
    let stiffness = smallest_eigenvalue(&system, &system.parameters(), &state).unwrap();
    assert!(stiffness.unwrap() > 0.0);
    let (system, state, result) = solve(&at(0.0, 100.0));
    result.unwrap();
    assert!((state.poses[1].p.y - 100.0).abs() < 1e-9);
    let stiffness = smallest_eigenvalue(&system, &system.parameters(), &state).unwrap();
    assert!(stiffness.unwrap() < 0.0);
}

/// Checks 300 masses in a row on bushings, the first to ground. The softest motion has 2 k (1 - cos(pi / (2 n + 1))). A force on the last mass
/// that grows by c per length pushes it away. The motion then decays by r = k / (c + k) per mass, with the stiffness k - c - k r.
#[test]
fn stiffness_of_many_masses() {
    let (n, k) = (300_u32, 50.0);
    let row = |c: f64| {
        let mut deck = String::new();
        for id in 2..n + 2 {
            let x = 10 * (id - 2);
            let before = if id == 2 { 1 } else { 10 * (id - 1) };
            deck += &format!(
                "POINT_MASS/{id}, MASS=1, CM={id}0, QG={x},0,0\nMARKER/{id}0, POINT_MASS={id}\n\
                 BUSHING/{id}, I={id}0, J={before}, K={k},{},{}, FORCE={},0,0\n",
                2.0 * k,
                3.0 * k,
                if id == 2 { 0.0 } else { 10.0 * k },
            );
        }
        let last = n + 1;
        deck + &format!(
            "MARKER/2, PART=1, REULER=90D,90D,0D\n\
             SFORCE/1, I={last}0, J=2, TRANSLATIONAL, ACTIONONLY, FUNCTION={c}*(DX({last}0,1)-{})",
            10 * (n - 1)
        )
    };
    let stiffness = |c: f64| {
        let (system, state, result) = solve(&row(c));
        result.unwrap();
        let all = smallest_eigenvalue(&system, &system.parameters(), &state);
        all.unwrap().unwrap()
    };
    let softest = 2.0 * k * (1.0 - (std::f64::consts::PI / f64::from(2 * n + 1)).cos());
    let found = stiffness(0.0);
    assert!((found / softest - 1.0).abs() < 1e-6, "{found} {softest}");
    for c in [10.0 * k, 1e5 * k] {
        let pushed = k - c - k * k / (c + k);
        let found = stiffness(c);
        assert!((found / pushed - 1.0).abs() < 1e-6, "{found} {pushed}");
    }
}

/// Checks two revolute joints on one axis: five of the ten equations are redundant, and the part rotates freely.
#[test]
fn redundant_hinges() {
    let (_, _, result) = solve(
        "PART/2, MASS=2, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/22, PART=2, QP=0,0,100\n\
         MARKER/2, PART=1, QP=0,0,100\nJOINT/1, REVOLUTE, I=21, J=1\nJOINT/2, REVOLUTE, I=22, J=2",
    );
    let report = result.unwrap();
    assert_eq!(report.redundant.len(), 5, "{:?}", report.redundant);
    let names: Vec<_> = report.redundant.iter().map(ToString::to_string).collect();
    assert!(
        names.iter().any(|name| name == "Zi.Xj in JOINT/2"),
        "{names:?}"
    );
    assert_eq!(
        report.free_motions[0].to_string(),
        "PART/2 spins freely about the line MARKER/21-MARKER/22"
    );
}

/// Checks a part on an inplane primitive, which falls along x because nothing holds it.
#[test]
fn held_by_nothing() {
    let (_, _, result) = solve(
        "PART/2, MASS=0, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
         MARKER/2, PART=1, REULER=90D,90D,0D\nMARKER/22, PART=2, REULER=90D,90D,0D\nJOINT/1, TRANSLATIONAL, I=22, J=2",
    );
    let error = result.unwrap_err();
    assert_eq!(
        error.to_string(),
        "PART/2 is free to translate along x: this motion has neither stiffness nor mass"
    );
}

/// Checks a bar between two spherical joints whose distance exceeds its length.
#[test]
fn contradicting_joints() {
    let (_, _, result) = solve(
        "PART/2, MASS=2, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/22, PART=2, QP=0,100,0\n\
         MARKER/2, PART=1, QP=0,101,0\nJOINT/1, FIXED, I=21, J=1\nJOINT/2, SPHERICAL, I=22, J=2",
    );
    let error = result.unwrap_err();
    assert!(
        matches!(&error, SolveError::Inconsistent { equation, violation } if equation == "D.Yj in JOINT/2" && (violation - 1.0).abs() < 1e-9),
        "{error}"
    );
}

/// Checks a constant load without stiffness, which has no equilibrium: the worst equation and the cause are reported.
#[test]
fn no_equilibrium() {
    let (_, _, result) = solve(
        "PART/2, MASS=2, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2, REULER=0D,90D,0D\n\
         MARKER/2, PART=1, REULER=0D,90D,0D\nJOINT/1, TRANSLATIONAL, I=21, J=2",
    );
    let Err(SolveError::NotConverged { worst, causes, .. }) = result else {
        panic!("{result:?}");
    };
    assert_eq!(worst, "PART/2 force along y");
    assert_eq!(
        causes[0],
        "PART/2 is free to translate along y; this motion is driven by the weight of PART/2"
    );
}

/// Checks a state with a constant rate, which never comes to rest. With STATIC_HOLD, the state is no unknown.
#[test]
fn a_state_that_never_rests() {
    let (_, _, result) = solve("DIFF/1, IC=0, FUNCTION=2.0\nDIFF/2, IC=1, FUNCTION=-DIF(2)");
    let Err(SolveError::NotConverged { worst, causes, .. }) = result else {
        panic!("{result:?}");
    };
    assert_eq!(worst, "DIFF/1");
    let rate = "the rate of DIFF/1 is constant here, 2.0000e0 per unit of time: ";
    assert!(causes.iter().any(|c| c.starts_with(rate)), "{causes:?}");
    assert!(!causes.iter().any(|c| c.contains("DIFF/2")), "{causes:?}");
    let (_, _, held) = solve("DIFF/1, IC=0, STATIC_HOLD, FUNCTION=2.0");
    assert!(held.is_ok(), "{held:?}");
}

/// Checks the reported causes of non-convergence: an open joint, a discontinuous function, and the history of the iterations.
#[test]
fn causes_that_are_present() {
    let (_, _, result) = solve(
        "PART/2, MASS=2, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/21, PART=2, REULER=0D,90D,0D, QP=3,0,0\n\
         MARKER/2, PART=1, REULER=0D,90D,0D\nJOINT/1, TRANSLATIONAL, I=21, J=2\n\
         SFORCE/1, I=21, J=2, TRANSLATIONAL, ACTIONONLY, FUNCTION=IF(DY(21,2)+50: 15, 15, 25)",
    );
    let Err(SolveError::NotConverged {
        causes, history, ..
    }) = result
    else {
        panic!("{result:?}");
    };
    println!("{causes:#?}");
    let has = |words: &str| causes.iter().any(|c| c.contains(words));
    assert!(has("D.Xj in JOINT/1 is violated by 3.000 at the start"));
    assert!(has("the function of SFORCE/1 has an IF"));
    assert!(history.len() > 5);
    let table = admire_solver::statics::history_table(&history);
    assert!(table.len() <= 14 && table[1].trim_start().starts_with('1'));
}
