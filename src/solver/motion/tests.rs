//! Comparison of derivatives of the equations of motion with finite differences, and of motions with known solutions.

use super::{Consistent, Integrator, Kept, MotionSettings, assemble};
use crate::linear::Levels;
use crate::mechanics::{Vec3, exp};
use crate::model::Model;
use crate::system::{Parameters, PartRates, Rows, Scratch, State, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

mod events;
mod passages;
mod velocities;

struct Deck {
    system: System,
    parameters: Parameters,
    state: State,
}

const HEAD: &str = "motion\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";

fn deck(statements: &str) -> Deck {
    let text = format!("{HEAD}{statements}\nEND\n");
    let dataset = Dataset::parse(Source::new("motion.adm", text.into_bytes()));
    assert!(!dataset.has_errors(), "{:#?}", dataset.diagnostics);
    let model = Model::lower(&dataset.value);
    assert!(!model.has_errors(), "{:#?}", model.diagnostics);
    let compiled = System::compile(&model.value);
    assert!(!compiled.has_errors(), "{:#?}", compiled.diagnostics);
    let system = compiled.value;
    assert!(
        system.not_in_motion().is_empty(),
        "{:#?}",
        system.not_in_motion()
    );
    Deck {
        parameters: system.parameters(),
        state: system.state(),
        system,
    }
}

/// Parts in general position, with every kind of element whose equations contain rates.
const EVERYTHING: &str = "
ACCGRAV/KGRAV=-9.81
PART/2, MASS=2.3, CM=20, IP=0.4,0.7,0.9,0.05,-0.03,0.08, QG=0.3,-0.2,0.5, REULER=0.2,1.1,-0.7
MARKER/20, PART=2, QP=0.1,0.2,-0.15, REULER=0.4,0.8,-0.3
MARKER/21, PART=2, QP=-0.3,0.1,0.4, REULER=0.1,0.3,0.5
PART/3, MASS=1.1, CM=30, IP=0.2,0.3,0.25, QG=1.1,0.4,-0.3, REULER=-0.5,0.9,0.3
MARKER/30, PART=3, QP=0.05,-0.1,0.2, REULER=0.3,0.2,-0.3
MARKER/31, PART=3, QP=0.2,0.3,-0.1, REULER=-0.2,0.6,0.1
POINT_MASS/4, MASS=0.7, CM=40, QG=-0.4,0.8,0.2
MARKER/40, POINT_MASS=4
BUSHING/1, I=21, J=31, K=30,40,50, KT=3,4,5, C=2,3,4, CT=0.5,0.6,0.7, FORCE=1,2,3, TORQUE=0.1,0.2,0.3
FIELD/1, I=31, J=1, KMATRIX=9,1,0,0,0,1,1,8,0,0,2,0,0,0,7,1,0,0,0,0,1,5,0,0,0,2,0,0,6,0,1,0,0,0,0,4, CRATIO=0.3
BEAM/1, I=20, J=31, LENGTH=1.2, IXX=0.1, IYY=0.2, IZZ=0.15, AREA=0.4, EMODULUS=10, GMODULUS=4, CRATIO=0.2
SPRINGDAMPER/1, TRANSLATIONAL, I=40, J=21, K=20, C=3, LENGTH=0.4
SPRINGDAMPER/2, ROTATIONAL, I=30, J=1, KT=2, CT=0.4
SFORCE/1, TRANSLATIONAL, I=20, J=40, FUNCTION=-3*VR(20,40)-0.5*VM(20,31,30)+0.2*DIF(1)+VARVAL(1)
SFORCE/2, ROTATIONAL, I=31, J=1, FUNCTION=-0.3*WZ(31,1,1)-0.2*WM(31,21)+0.1*TIME**2
GFORCE/1, I=31, JFLOAT=50, RM=21, FX=-0.4*VX(31,21,21,30)\\ FY=0.1*ACCX(20,31,30,21)\\ FZ=0.1*ACCM(30,1)\\ TX=0.2*WDTY(20,31,21,30)\\ TY=-WX(20,30,31)\\ TZ=SIN(3*TIME)
MARKER/50, PART=1, FLOATING
VARIABLE/1, FUNCTION=0.3*VZ(21,31)+0.2*VARVAL(1)+DIF(1)
DIFF/1, IC=0.4, FUNCTION=-2*DIF(1)+VX(30)+VARVAL(1)
DIFF/2, IC=0.1, IMPLICIT, FUNCTION=DIF1(2)**3+DIF1(2)-TIME-DIF(1)
";

fn number(k: usize) -> f64 {
    (1.7 * k as f64 + 0.3).sin()
}

/// Returns a state in which everything moves.
fn moving(deck: &Deck) -> State {
    let mut state = deck.state.clone();
    state.time = 0.37;
    state.set_moving();
    let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
    for (part, body) in deck.system.bodies.iter().enumerate() {
        let angular = |k: usize| {
            if body.freedoms == 6 {
                vector(k)
            } else {
                Vec3::zeros()
            }
        };
        if body.freedoms > 0 {
            state.velocities[part] = PartRates {
                linear: vector(7 * part),
                angular: angular(7 * part + 3),
            };
            state.accelerations[part] = PartRates {
                linear: vector(11 * part + 5),
                angular: angular(11 * part + 2),
            };
        }
    }
    for (k, multiplier) in state.multipliers.iter_mut().enumerate() {
        *multiplier = number(k + 40);
    }
    for (k, variable) in state.variables.iter_mut().enumerate() {
        *variable = number(k + 60);
    }
    for (k, rate) in state.state_rates.iter_mut().enumerate() {
        *rate = number(k + 80);
    }
    state
}

/// Returns the state with one unknown changed by `h`. Level 0 changes the unknown itself, level 1 its first rate and level 2 its second rate.
fn moved(system: &System, state: &State, level: usize, column: usize, h: f64) -> State {
    let mut new = state.clone();
    let mut step = vec![0.0; system.moving_unknowns];
    step[column] = h;
    if level == 0 {
        system.advance(&mut new, &step);
        return new;
    }
    let first_state = system.first_state();
    if column >= first_state {
        for (k, equation) in system.states.iter().enumerate() {
            if equation.moving_unknown == column {
                new.state_rates[k] += h;
            }
        }
        return new;
    }
    let rates = if level == 1 {
        &mut new.velocities
    } else {
        &mut new.accelerations
    };
    let mut all = Vec::new();
    system.gathered(rates, &mut all);
    if column < all.len() {
        all[column] += h;
        system.scattered(&all, rates);
    }
    new
}

/// Returns statements with every kind of joint that has friction, between parts in general position. `stiction` is the stiction velocity.
fn frictions(stiction: f64) -> String {
    let parts: Vec<&str> = EVERYTHING
        .lines()
        .filter(|line| ["PART", "POIN", "MARK"].iter().any(|w| line.starts_with(w)))
        .collect();
    let mut all = parts.join("\n") + "\n";
    let joints = [
        (
            "TRANSLATIONAL",
            "20",
            "30",
            ", INITIAL_OVERLAP=2, OVERLAP_DELTA=INCREASE",
        ),
        ("REVOLUTE", "31", "21", ", BENDING_REACTION_ARM=0.3"),
        (
            "CYLINDRICAL",
            "21",
            "1",
            ", OVERLAP_DELTA=DECREASE, INITIAL_OVERLAP=3",
        ),
        ("HOOKE", "30", "1", ""),
        ("UNIVERSAL", "20", "31", ""),
        ("SPHERICAL", "31", "20", ""),
    ];
    for (k, (kind, i, j, more)) in joints.iter().enumerate() {
        all += &format!(
            "JOINT/{k}, {kind}, I={i}, J={j}\nFRICTION/{k}, JOINT={k}, INACTIVE=STATIC, MU_STATIC=0.5, MU_DYNAMIC=0.3, STICTION={stiction}, PIN_RADIUS=0.3, REACTION_ARM=0.7, FRICTION_ARM=0.4, BALL_RADIUS=0.6, MAX_STICTION=2, FRICTION_FORCE=0.2, FRICTION_TORQUE=0.1{more}\n",
            k = k + 1,
        );
    }
    // All outputs of the frictions that functions can read: force, torque, coefficients, velocities and creeps along every axis.
    for index in (1..13).chain(14..26) {
        let terms: Vec<String> = (1..=6)
            .map(|k| format!("0.{k}*FRICTION({k},{index})"))
            .collect();
        all += &format!("VARIABLE/{index}, FUNCTION={}\n", terms.join("+"));
    }
    all
}

/// Returns statements for three parts connected by multi-point forces with stiffness matrices. One force has a damping matrix, the other a
/// damping ratio.
fn damped_points() -> String {
    let matrix = |id: usize, first: usize| {
        let values: Vec<String> = (0..144)
            .map(|k| format!("{:.6}", number(first + k)))
            .collect();
        format!(
            "MATRIX/{id}, FULL=CORDER, ROWS=12, COLUMNS=12, VALUES={}\n",
            values.join("\n, ").replace("\n, ", ",\n, ")
        )
    };
    let parts: Vec<&str> = EVERYTHING
        .lines()
        .filter(|line| ["PART", "POIN", "MARK"].iter().any(|w| line.starts_with(w)))
        .collect();
    format!(
        "{}\nMARKER/50, PART=1, FLOATING\n{}{}NFORCE/1, IMARKERS=21,31, J=1, KMATRIX=1, CMATRIX=2\nNFORCE/2, IMARKERS=21,1, J=30, KMATRIX=1, CRATIO=0.3\n",
        parts[..parts.len() - 1].join("\n"),
        matrix(1, 0),
        matrix(2, 200)
    )
}

/// Returns statements in which forces, states and constraints read VARIABLEs. These VARIABLEs read other VARIABLEs, forces, reactions, rates
/// and outputs; one of them reads itself.
fn chained() -> String {
    "JOINT/1, UNIVERSAL, I=20, J=30
MOTION/1, I=21, J=1, B3, FUNCTION=0.3*VARVAL(11)
VARIABLE/11, FUNCTION=SIN(TIME)+0.1*VARVAL(12)
VARIABLE/12, FUNCTION=TIME**2/(2+TIME)
VARIABLE/13, FUNCTION=DX(30,21)*VARVAL(14)+VX(20,31)
VARIABLE/14, FUNCTION=SQRT(1+DM(40,20)**2)+VARVAL(12)
VARIABLE/15, FUNCTION=VARVAL(13)/VARVAL(14)+0.1*JOINT(1,0,3,20)
VARIABLE/16, FUNCTION=0.2*SFORCE(91,1,4,30)-ACCX(30,20)+0.3*VARVAL(16)
VARIABLE/17, FUNCTION=ARYVAL(93,1)*VARVAL(15)
SFORCE/91, TRANSLATIONAL, I=40, J=31, FUNCTION=VARVAL(15)**2+VARVAL(13)
SFORCE/92, TRANSLATIONAL, I=21, J=40, FUNCTION=VARVAL(16)*VARVAL(15)+VARVAL(17)
ARRAY/91, X, SIZE=1
ARRAY/92, U, SIZE=2, VARIABLES=13,16
ARRAY/93, Y, SIZE=1
MATRIX/91, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=-2
MATRIX/92, FULL=RORDER, ROWS=1, COLUMNS=2, VALUES=0.3,0.4
LSE/91, X=91, U=92, Y=93, A=91, B=92, C=91, D=92
DIFF/91, FUNCTION=VARVAL(15)-DIF(91)*VARVAL(14)
"
    .to_string()
}

/// Makes all frictions stick, with some creep.
fn stick(deck: &Deck, state: &mut State) {
    let mut scratch = Scratch::new(&deck.system);
    deck.system
        .advance_stiction(&deck.parameters, state, &mut scratch);
    for (k, grip) in state.grips.iter_mut().enumerate() {
        let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2)) * 0.3;
        grip.sticking = true;
        grip.creep = vector(3 * k);
        grip.place += 0.1;
        grip.turn = exp(&vector(5 * k + 1)) * grip.turn;
        grip.first = Some(grip.place - 0.2);
    }
}

#[test]
fn derivatives_by_places_velocities_and_accelerations_are_those_of_differences() {
    let joints = "JOINT/1, UNIVERSAL, I=20, J=30\nJPRIM/1, INPLANE, I=40, J=21\nMOTION/1, I=21, J=1, B3, FUNCTION=0.3*TIME\nMOTION/2, I=31, J=1, X, VELOCITY, FUNCTION=0.2*TIME\nGCON/1, FUNCTION=VX(20,31,21)*DZ(40,1)+IF(TIME-1:WZ(31,20),0,0)-VR(40,21)/(1+TIME)+SIN(DX(30,21,20))\nGCON/2, FUNCTION=VY(21,40,30,31)-0.3*VARVAL(5)\nVARIABLE/5, FUNCTION=TIME**2\n";
    for (statements, sticking) in [
        (EVERYTHING.to_string(), false),
        (format!("{EVERYTHING}{joints}"), false),
        (frictions(0.2), false),
        (frictions(40.0), true),
        (damped_points(), false),
        (format!("{EVERYTHING}{}", chained()), false),
    ] {
        let deck = deck(&statements);
        let system = &deck.system;
        let mut state = moving(&deck);
        if sticking {
            stick(&deck, &mut state);
        }
        let n = system.moving_unknowns;
        let mut scratch = Scratch::new(system);
        let mut levels = Levels::new(n);
        let mut g = vec![0.0; n];
        system
            .assemble(&deck.parameters, &state, &mut scratch, &mut g, &mut levels)
            .unwrap();
        levels.finish();
        let mut exact = vec![vec![[0.0; 3]; n]; n];
        for (row, column, values) in levels.entries() {
            for level in 0..3 {
                exact[row][column][level] += values[level];
            }
        }
        let first_state = system.first_state();
        let mut seen = 0;
        for column in 0..n {
            for level in 0..3 {
                let body = column < system.first_equation;
                if level > 0 && !body && !(level == 1 && column >= first_state) {
                    continue;
                }
                let at = |h: f64| {
                    let state = moved(system, &state, level, column, h);
                    let mut g = vec![0.0; n];
                    let mut scratch = Scratch::new(system);
                    system
                        .residual(&deck.parameters, &state, &mut scratch, &mut g)
                        .unwrap();
                    g
                };
                let h = 1e-5;
                let (a, b, c, d) = (at(h), at(-h), at(2.0 * h), at(-2.0 * h));
                for row in 0..n {
                    let difference = (8.0 * (a[row] - b[row]) - (c[row] - d[row])) / (12.0 * h);
                    let found = exact[row][column][level];
                    assert!(
                        (found - difference).abs() < 2e-8 * (1.0 + difference.abs()),
                        "{} by {} at level {level}: {found} and {difference}",
                        system.equation_name(row),
                        system.freedom_name(column)
                    );
                    seen += usize::from(found != 0.0);
                }
            }
        }
        assert!(seen > 300, "{seen}");
    }
}

/// Along a motion with constant accelerations, first and second differences of the constraint residuals match the computed first and second
/// rates.
#[test]
fn rates_of_constraints_are_those_of_the_residuals_along_a_motion() {
    let joints = "
JOINT/1, UNIVERSAL, I=20, J=30
JOINT/2, CYLINDRICAL, I=21, J=1
JOINT/3, SCREW, I=21, J=1, PITCH=0.3
JOINT/4, CONVEL, I=31, J=1
JOINT/5, RACKPIN, I=31, J=21, PD=0.4
COUPLER/1, JOINTS=2,6, SCALES=2
JOINT/6, REVOLUTE, I=30, J=1
JPRIM/1, INLINE, I=40, J=21
JPRIM/2, PERPENDICULAR, I=30, J=20
GCON/1, I=20, FUNCTION=DM(20,40)*DX(30,1,21)-2+SIN(TIME)
MOTION/1, I=21, J=30, B1, FUNCTION=0.3*SIN(2*TIME)
MOTION/2, I=21, J=30, B2, FUNCTION=VARVAL(2)
MOTION/3, I=31, J=1, B3, VELOCITY, FUNCTION=0.2*TIME**2
MOTION/4, I=31, J=21, Y, ACCELERATION, ICVEL=0.3, FUNCTION=COS(TIME)
VARIABLE/2, FUNCTION=0.1*TIME**3+VARVAL(3)
VARIABLE/3, FUNCTION=0.2*SIN(TIME)
";
    let deck = deck(&format!("{EVERYTHING}{joints}"));
    let system = &deck.system;
    let mut state = moving(&deck);
    let mut scratch = Scratch::new(system);
    let settle = |state: &mut State, scratch: &mut Scratch| {
        system
            .settle_variables(&deck.parameters, state, scratch)
            .unwrap();
    };
    settle(&mut state, &mut scratch);
    let n = system.moving_unknowns;
    let (mut g, mut rows) = (vec![0.0; n], Rows::new(system));
    system
        .constraints_and_rows(&deck.parameters, &state, &mut scratch, &mut g, &mut rows)
        .unwrap();
    let (mut v, mut a) = (Vec::new(), Vec::new());
    system.velocity_vector(&state, &mut v);
    system.gathered(&state.accelerations, &mut a);
    let mut rate = rows.time.clone();
    rows.times(&v, &mut rate);
    let mut gamma = vec![0.0; system.equations];
    let mut here = system
        .evaluate(&deck.parameters, &state, &mut scratch)
        .unwrap();
    here.gamma(1e-3, &mut gamma).unwrap();
    rows.times(&a, &mut gamma);
    let along = |t: f64| {
        let mut at = state.clone();
        at.time += t;
        for (part, pose) in at.poses.iter_mut().enumerate() {
            let (velocity, acceleration) = (&state.velocities[part], &state.accelerations[part]);
            pose.p += velocity.linear * t + acceleration.linear * (0.5 * t * t);
            // To second order: w' is the acceleration, and w x w vanishes.
            pose.R = exp(&(velocity.angular * t + acceleration.angular * (0.5 * t * t))) * pose.R;
        }
        let mut scratch = Scratch::new(system);
        settle(&mut at, &mut scratch);
        let mut g = vec![0.0; n];
        let mut rows = Rows::new(system);
        system
            .constraints_and_rows(&deck.parameters, &at, &mut scratch, &mut g, &mut rows)
            .unwrap();
        g
    };
    let h = 1e-3;
    let values: Vec<Vec<f64>> = [-2.0, -1.0, 0.0, 1.0, 2.0]
        .iter()
        .map(|k| along(k * h))
        .collect();
    for k in 0..system.equations {
        let f = |at: usize| values[at][system.first_equation + k];
        let first = (8.0 * (f(3) - f(1)) - (f(4) - f(0))) / (12.0 * h);
        let second = (16.0 * (f(3) + f(1)) - (f(4) + f(0)) - 30.0 * f(2)) / (12.0 * h * h);
        let name = system.constraint_equation_name(k);
        assert!(
            (rate[k] - first).abs() < 1e-8,
            "{name}: {} {first}",
            rate[k]
        );
        assert!(
            (gamma[k] - second).abs() < 2e-6 * (1.0 + second.abs()),
            "{name}: {} {second}",
            gamma[k]
        );
    }
}

fn begun(deck: &Deck, error: f64, hmax: f64) -> Integrator<'_> {
    let mut state = deck.state.clone();
    let mut memory = Consistent::new(&deck.system);
    assemble(
        &deck.system,
        &deck.parameters,
        &mut state,
        &mut memory,
        Kept::Data,
        1e-3,
    )
    .unwrap();
    let settings = MotionSettings {
        error,
        hinit: hmax / 20.0,
        hmax,
        hmin: 1e-9 * hmax,
        output: hmax,
        maxit: 10,
        corrector: 1.0,
        adaptivity: 0.0,
    };
    Integrator::new(&deck.system, &deck.parameters, state, settings)
}

fn integrated(
    deck: &Deck,
    error: f64,
    hmax: f64,
    end: f64,
) -> (State, super::integrator::Statistics) {
    let mut integrator = begun(deck, error, hmax);
    integrator.advance_to(end).unwrap();
    let state = integrator.output().unwrap();
    (state, integrator.statistics())
}

/// The error of a pendulum is of the order of the tolerance. The pendulum has m = 1 kg, l = 2 m and IP = (0.04, 0.1, 0.1) kg m2, and swings on
/// a revolute joint for 5 s. Quadrature of the energy integral gives theta = -3.123812342989 rad and theta' = -0.412436065475 rad/s, hence x =
/// -1.999683868884 m and z = -0.035558747545 m.
#[test]
fn the_error_of_a_pendulum_is_what_is_asked_for() {
    let deck = deck(
        "ACCGRAV/KGRAV=-9.80665\nPART/2, MASS=1, CM=20, IP=0.04,0.1,0.1\nMARKER/20, PART=2, QP=2,0,0\nMARKER/21, PART=2, REULER=180D,90D,180D\nMARKER/11, PART=1, REULER=180D,90D,180D\nJOINT/1, REVOLUTE, I=21, J=11",
    );
    let mut before = f64::INFINITY;
    for error in [1e-3, 1e-5, 1e-7] {
        let (state, statistics) = integrated(&deck, error, 5.0, 5.0);
        let pose = &state.poses[1];
        let cm = pose.point(&Vec3::new(2.0, 0.0, 0.0));
        let off = (cm.x + 1.999683868884)
            .abs()
            .max((cm.z + 0.035558747545).abs());
        let spin = (state.velocities[1].angular.norm() - 0.412436065475).abs();
        println!("{error:e}: {off:e} {spin:e} {statistics:?}");
        // Positions reach 2 m, angular velocities 3.1 rad/s.
        assert!(
            off < 10.0 * error * 2.0 && spin < 10.0 * error * 4.0,
            "{error}: {off} {spin}"
        );
        assert!(off < before);
        before = off;
    }
}

/// A free body keeps its momentum and its energy while it tumbles.
#[test]
fn a_free_body_keeps_momentum_and_energy() {
    let deck = deck(
        "PART/2, MASS=2, CM=20, IP=0.1,0.2,0.25, VX=1, VY=-2, VZ=0.5, WX=3, WY=0.2, WZ=-0.1\nMARKER/20, PART=2, QP=0.3,0.2,-0.4",
    );
    let (state, _) = integrated(&deck, 1e-8, 0.5, 3.0);
    let momentum = |state: &State| {
        let M = deck
            .system
            .mass_matrix(&deck.parameters, state, crate::model::PartIx(1));
        let V = &state.velocities[1];
        let V = crate::mechanics::Vec6::new(
            V.linear.x,
            V.linear.y,
            V.linear.z,
            V.angular.x,
            V.angular.y,
            V.angular.z,
        );
        let p = M * V;
        let linear = Vec3::new(p[0], p[1], p[2]);
        let about = Vec3::new(p[3], p[4], p[5]) + state.poses[1].p.cross(&linear);
        (linear, about, 0.5 * V.dot(&p))
    };
    let mut start = deck.state.clone();
    let mut memory = Consistent::new(&deck.system);
    assemble(
        &deck.system,
        &deck.parameters,
        &mut start,
        &mut memory,
        Kept::Data,
        1e-3,
    )
    .unwrap();
    let (a, b) = (momentum(&start), momentum(&state));
    assert!((a.0 - Vec3::new(2.0, -4.0, 1.0)).norm() < 1e-12, "{}", a.0);
    assert!((a.0 - b.0).norm() < 1e-7, "{} {}", a.0, b.0);
    assert!((a.1 - b.1).norm() < 1e-7, "{} {}", a.1, b.1);
    assert!((a.2 - b.2).abs() < 1e-7, "{} {}", a.2, b.2);
    assert!((start.poses[1].R - state.poses[1].R).norm() > 0.1);
}

/// The axes of the joint turn with the part, and its multipliers change with them. Over many steps they stay close to the multipliers that
/// follow from the force balances.
#[test]
fn multipliers_of_turning_axes_stay() {
    let deck = deck(
        "ACCGRAV/KGRAV=-9.80665\nPART/2, MASS=1, CM=20, IP=0.04,0.1,0.1\nMARKER/20, PART=2, QP=2,0,0\nMARKER/21, PART=2\nMARKER/11, PART=1\nJOINT/1, SPHERICAL, I=11, J=21",
    );
    let mut integrator = begun(&deck, 1e-8, 0.01);
    for k in 1..=500 {
        integrator.advance_to(f64::from(k) * 0.01).unwrap();
    }
    let found = integrator.state().multipliers.clone();
    let exact = integrator.output().unwrap();
    for (found, exact) in found.iter().zip(&exact.multipliers) {
        assert!((found - exact).abs() < 1e-3 * 30.0, "{found} {exact}");
    }
    let cm = exact.poses[1].point(&Vec3::new(2.0, 0.0, 0.0));
    assert!((cm.x + 1.999683868884).abs() < 1e-6, "{}", cm.x);
}
