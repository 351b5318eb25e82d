//! Unstable equilibria, the continuation from them to stable ones, and starts that stay.

use admire_solver::statics::{Softest, SolveError, Solver, StaticSettings};
use admire_solver::system::Scratch;

use crate::deck::{Solved, solve, solve_with};

/// A rod of 2 kg, 100 mm to its mass centre, upright on a hinge with a rotational spring of 1000 N mm.
const PENDULUM: &str = "ACCGRAV/JGRAV=-9806.65\nPART/2, MASS=2, CM=20, IP=1E4,1E4,1E4\nMARKER/20, PART=2, QP=0,100,0\n\
    MARKER/21, PART=2\nJOINT/1, REVOLUTE, I=21, J=1\nSPRINGDAMPER/1, ROTATIONAL, I=21, J=1, KT=1000\n";
const WEIGHT: f64 = 2.0 * 9.806_65 * 100.0;

fn softest(solved: &Solved) -> Softest {
    Softest::of(&solved.system, &solved.parameters, &solved.state)
        .unwrap()
        .unwrap()
}

/// Checks an upright pendulum, whose stiffness KT - m g h is negative and reported with part and axis. In both directions it ends at KT a = m g
/// h sin a.
#[test]
fn an_upright_pendulum_is_left_both_ways() {
    let mut solved = solve(PENDULUM);
    let unstable = softest(&solved);
    // Mean distance of the part's markers from its mass centre. The mass centre moves by the rotation times this length.
    let length = 100.0;
    let expected = (1000.0 - WEIGHT) / (2.0 * length * length);
    assert!(
        (unstable.stiffness - expected).abs() < 1e-6 * expected.abs(),
        "{unstable:?} {expected}"
    );
    let (system, parameters) = (&solved.system, &solved.parameters);
    let words = unstable
        .described(system, parameters, &solved.state)
        .unwrap();
    assert_eq!(words, "PART/2 turns about z through MARKER/21");
    let mut scratch = Scratch::new(system);
    let doubtful = Softest::doubtful(system, parameters, &solved.state, &mut scratch).unwrap();
    let doubtful = doubtful.unwrap();
    assert!(doubtful.is_unstable() && doubtful.motion == unstable.motion);

    let mut solver = Solver::new(system);
    let settings = StaticSettings::tight();
    let found = solver
        .settle(system, parameters, &mut solved.state, &settings, &unstable)
        .unwrap();
    let x = solved.state.poses[1].R.column(0);
    let angle = x.y.atan2(x.x);
    assert!(
        (1000.0 * angle - WEIGHT * angle.sin()).abs() < 1e-5,
        "{angle}"
    );
    assert!((1.8..2.0).contains(&angle.abs()), "{angle}");
    assert!(found.softest.unwrap().stiffness > 0.0);
    let other = found.other.unwrap();
    assert!(
        (other - found.moved).abs() < 1e-6 * other,
        "{other} {}",
        found.moved
    );
    assert_eq!(
        Softest::doubtful(system, parameters, &solved.state, &mut scratch).unwrap(),
        None
    );
}

/// Checks a strut between two springs that push it together: it snaps to one of two sides, and the nearer one is taken.
#[test]
fn the_nearer_of_two_stable_equilibria_is_taken() {
    // Along x, F = x (x - 10) (x + 30) / 100. It is stable at 10 and at -30, with the sign of a restoring force.
    let deck = "PART/2, MASS=1, CM=20, IP=9,9,9\nMARKER/20, PART=2\nMARKER/22, PART=2, REULER=90D,90D,0D\n\
        MARKER/2, PART=1, REULER=90D,90D,0D\nJOINT/1, TRANSLATIONAL, I=22, J=2\n\
        SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=2, FUNCTION=-DX(20,1)*(DX(20,1)-10)*(DX(20,1)+30)/100\n";
    let mut solved = solve(deck);
    let unstable = softest(&solved);
    assert!((unstable.stiffness + 3.0).abs() < 1e-9, "{unstable:?}");
    let mut solver = Solver::new(&solved.system);
    let settings = StaticSettings::tight();
    let found = solver
        .settle(
            &solved.system,
            &solved.parameters,
            &mut solved.state,
            &settings,
            &unstable,
        )
        .unwrap();
    assert!((solved.state.poses[1].p.x - 10.0).abs() < 1e-9);
    assert!((found.moved - 10.0).abs() < 1e-9 && (found.other.unwrap() - 30.0).abs() < 1e-9);
}

/// Checks a part without any stop, which has no stable equilibrium: this is reported, and the state is unchanged.
#[test]
fn a_fall_without_end_is_told() {
    let deck = "PART/2, MASS=1, CM=20, IP=9,9,9\nMARKER/20, PART=2\nMARKER/22, PART=2, REULER=90D,90D,0D\n\
        MARKER/2, PART=1, REULER=90D,90D,0D\nJOINT/1, TRANSLATIONAL, I=22, J=2\n\
        SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=2, FUNCTION=3*DX(20,1)\n";
    let solved = solve(deck);
    let unstable = softest(&solved);
    let mut state = solved.state.clone();
    let mut solver = Solver::new(&solved.system);
    let failed = solver.settle(
        &solved.system,
        &solved.parameters,
        &mut state,
        &StaticSettings::tight(),
        &unstable,
    );
    let said = failed.unwrap_err().to_string();
    assert!(
        said.starts_with("no stable equilibrium was found"),
        "{said}"
    );
    assert_eq!(state, solved.state);
}

/// Checks two links on hinges, the first massless. Any rotation of the first link moves the second one, which has mass.
#[test]
fn a_mass_later_in_a_chain_counts_through_the_joints() {
    let chain = "PART/2\nMARKER/21, PART=2\nMARKER/22, PART=2, QP=100,0,0\nJOINT/1, REVOLUTE, I=21, J=1\n\
        PART/3, QG=100,0,0, MASS=1, CM=30, IP=10,10,10\nMARKER/30, PART=3, QP=50,0,0\nMARKER/31, PART=3\n\
        JOINT/2, REVOLUTE, I=31, J=22\n";
    let solved = solve(chain);
    assert_eq!(solved.report.free_motions.len(), 2);
    assert!((solved.pose(3).p.x - 100.0).abs() < 1e-12);
    // With the second hinge at the mass centre and without inertia there, a rotation of the second link moves no mass.
    let spin = chain
        .replace("IP=10,10,10", "IP=0,0,0")
        .replace("MARKER/30, PART=3, QP=50,0,0", "MARKER/30, PART=3");
    let error = std::panic::catch_unwind(|| solve(&spin));
    assert!(error.is_err());
}

/// Checks that a stated MAXIT limits all iterations, including those of the continuation. Without a stated MAXIT, more are allowed.
#[test]
fn as_many_iterations_as_stated_and_no_more() {
    let far = PENDULUM.replace("KT=1000", "KT=1E5, TORQUE=1E5");
    for most in [1, 2, 3] {
        let settings = StaticSettings {
            maxit: most,
            budget: Some(most),
            ..StaticSettings::default()
        };
        let text = format!("{}{far}EQUILIBRIUM/MAXIT={most}\nEND\n", crate::deck::HEAD);
        let model = crate::deck::read(&text);
        let system = admire_solver::system::System::compile(&model).value;
        assert_eq!(
            StaticSettings::from(system.settings()),
            StaticSettings {
                stability: system.settings().stability,
                ..settings
            }
        );
        let mut state = system.state();
        let settings = StaticSettings::from(system.settings());
        let mut solver = Solver::new(&system);
        match solver.solve(&system, &system.parameters(), &mut state, &settings) {
            Ok(report) => assert!(report.iterations <= most, "{most}: {}", report.iterations),
            Err(SolveError::NotConverged {
                history, causes, ..
            }) => {
                assert!(history.len() <= most);
                assert!(
                    causes
                        .iter()
                        .any(|c| *c == format!("the iteration reached MAXIT={most}")),
                    "{causes:?}"
                );
            }
            Err(other) => panic!("{other}"),
        }
    }
    let settings = StaticSettings {
        maxit: 1,
        budget: Some(1),
        ..StaticSettings::default()
    };
    let text = format!("{}{far}END\n", crate::deck::HEAD);
    let model = crate::deck::read(&text);
    let system = admire_solver::system::System::compile(&model).value;
    let solved = Solver::new(&system).solve(
        &system,
        &system.parameters(),
        &mut system.state(),
        &settings,
    );
    assert!(matches!(solved, Err(SolveError::NotConverged { .. })));
    assert!(
        solve_with(&far, &StaticSettings::default())
            .report
            .iterations
            > 1
    );
}

/// Returns the solution of a lamp whose spring balances its weight in every position (k a h = m g l), on a base of this stiffness.
fn lamp(kt: &str) -> Solved {
    solve(&format!(
        "PART/2, MASS=5, CM=20, IP=1E4,1E4,1E4\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/22, PART=2, QP=0,0,100\n\
         MARKER/23, PART=2, REULER=0,90D,0\nPART/3, MASS=2, CM=30, IP=2E3,2E3,2E3\nMARKER/30, PART=3, QP=320,0,240\n\
         MARKER/31, PART=3, REULER=0,90D,0\nMARKER/32, PART=3, QP=160,0,120\n\
         BUSHING/1, I=21, J=1, K=300,500,400, KT={kt},{kt},{kt}\nJOINT/1, REVOLUTE, I=31, J=23\n\
         SPRINGDAMPER/1, TRANSLATION, I=32, J=22, K=0.392266, LENGTH=0\nACCGRAV/KGRAV=-9806.65"
    ))
}

/// Checks a neutral equilibrium. Errors of the reactions within a usual tolerance give it a stiffness of either sign, so it must count as
/// neutral. An equilibrium that is unstable by more than this error must stay unstable.
#[test]
fn a_stiffness_within_its_error_is_neutral() {
    for (solved, unstable) in [(lamp("1E12"), false), (solve(PENDULUM), true)] {
        let (system, parameters) = (&solved.system, &solved.parameters);
        let mut scratch = Scratch::new(system);
        let mut signs = Vec::new();
        for off in [-1e-2, 1e-2] {
            let mut state = solved.state.clone();
            for multiplier in &mut state.multipliers {
                *multiplier += off;
            }
            let softest = Softest::of(system, parameters, &state).unwrap().unwrap();
            signs.push(softest.stiffness > 0.0);
            let softest =
                Softest::at_equilibrium(system, parameters, &state, &mut scratch).unwrap();
            let softest = softest.unwrap();
            assert_eq!(softest.is_unstable(), unstable, "{off}: {softest:?}");
            assert_eq!(softest.is_neutral(), !unstable, "{off}: {softest:?}");
        }
        assert_eq!(signs[0] != signs[1], !unstable, "{signs:?}");
    }
}

/// Checks that an arm that starts level and falls by 90 degrees is reported, and that an arm that starts near its equilibrium is not.
#[test]
fn a_part_that_goes_far_is_told() {
    let arm = |turned: f64| {
        solve(&format!(
            "MARKER/10, PART=1, REULER=0,90D,0\nPART/2, MASS=2, CM=20, IP=2E4,2E4,2E4, QG=0,0,0, REULER=0,90D,{turned}D\n\
             MARKER/20, PART=2, QP=200,0,0\nMARKER/21, PART=2\nJOINT/1, REVOLUTE, I=21, J=10\nACCGRAV/KGRAV=-9806.65"
        ))
    };
    let far = arm(-5.0).report.far;
    assert_eq!(far.len(), 1);
    assert!((far[0].turn.to_degrees() - 85.0).abs() < 1e-6, "{far:?}");
    assert!(arm(-50.0).report.far.is_empty());
    // A block on a spring moves down by ten times the size of the mechanism.
    let far = solve(
        "MARKER/11, PART=1, QP=0,0,10\nPART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n\
         SPRINGDAMPER/1, TRANSLATION, I=20, J=11, K=0.0980665, LENGTH=10\nACCGRAV/KGRAV=-9806.65",
    );
    let far = far.report.far;
    assert_eq!(far.len(), 1);
    assert!((far[0].shift - 100.0).abs() < 1e-6, "{far:?}");
}
