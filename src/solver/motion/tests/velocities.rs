//! Nonholonomic GCONs, such as rolling and gliding without side slip, compared with closed-form solutions and with holonomic constraints.

use super::*;

/// Mass of the sleigh.
const M: f64 = 2.0;
/// Distance of the mass centre ahead of the edge along x. The edge is at the origin.
const A: f64 = 0.3;
/// Moment of inertia of the sleigh about z through its mass centre.
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

/// Chaplygin's sleigh. Let u be the speed along the edge, w the spin and k^2 = a^2 + I/m. Then `u' = a w^2` and `w' = -a u w/k^2`. Hence
/// `u = c tanh(a c t/k^2 + s)` and `k w = c sech(...)`. The edge is pushed sideways by the force `m u w (1 - a^2/k^2)`.
#[test]
fn a_sleigh_turns_until_it_glides_straight() {
    let deck = sleigh("GCON/1, I=21, FUNCTION=VY(21,1,21)");
    let mut integrator = begun(&deck, 1e-8, 0.1);
    let start = integrator.output().expect("an output");
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
        integrator.advance_to(time).expect("no error");
        let state = integrator.output().expect("an output");
        let (u, w) = along(&state);
        let tau = A * c * time / k2 + s;
        let (known_u, known_w) = (c * tau.tanh(), -c / k2.sqrt() / tau.cosh());
        assert!((u - known_u).abs() < 1e-7, "{time}: {u} {known_u}");
        assert!((w - known_w).abs() < 1e-7, "{time}: {w} {known_w}");
        let mut scratch = Scratch::new(&deck.system);
        let here = deck
            .system
            .evaluate(&deck.parameters, &state, &mut scratch)
            .expect("no error");
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

/// A uniform ball of radius R rolls on a plane that turns at the rate O. The centre of the ball moves on a circle at the rate 2/7 O, wherever
/// it starts.
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
    let start = integrator.output().expect("an output");
    let (p, v) = (start.poses[1].p, start.velocities[1].linear);
    assert!((start.velocities[1].linear.z).abs() < 1e-12);
    let rate = 2.0 / 7.0 * O;
    // v turns at this rate; the centre of the circle is p + z x v / rate.
    let centre = p + Vec3::z().cross(&v) / rate;
    for step in 1..=40 {
        let time = 0.25 * f64::from(step);
        integrator.advance_to(time).expect("no error");
        let state = integrator.output().expect("an output");
        let known = centre + exp(&(Vec3::z() * rate * time)) * (p - centre);
        assert!(
            (state.poses[1].p - known).norm() < 1e-6,
            "{time}: {} {known}",
            state.poses[1].p
        );
        // The spin about z is not constrained and stays constant.
        assert!((state.velocities[1].angular.z - start.velocities[1].angular.z).abs() < 1e-8);
    }
}

/// A constraint on positions gives the same motion as the constraint whose function is its time derivative.
#[test]
fn the_rate_of_a_constraint_is_the_constraint() {
    let with = |statement: &str| {
        deck(&format!(
            "ACCGRAV/KGRAV=-9.81
PART/2, MASS=1, CM=20, IP=0.04,0.1,0.2, REULER=0.3,0.9,0.1, WY=1
MARKER/20, PART=2, QP=0.4,0.1,0
MARKER/21, PART=2, QP=0,0.3,0.2
MARKER/2, PART=1, QP=1.5,0,0.2
POINT_MASS/3, MASS=0.5, CM=30, QG=0.4,-0.3,0.6
MARKER/30, POINT_MASS=3
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=20, C=0.3, LENGTH=0.4
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=21, K=30, C=0.1, LENGTH=0.3
{statement}"
        ))
    };
    for (places, rate) in [
        ("DM(21,2)", "VR(21,2)"),
        (
            "DM(21,30)-0.2*DX(20,21)*TIME",
            "VR(21,30)-0.2*VX(20,21)*TIME-0.2*DX(20,21)",
        ),
        (
            "DX(21,2)*DY(20,2)+DZ(30,20)**2",
            "VX(21,2)*DY(20,2)+DX(21,2)*VY(20,2)+2*DZ(30,20)*VZ(30,20)",
        ),
        // In rotating axes, the derivative is the rate seen in these axes.
        ("DX(30,2,21)", "VX(30,2,21,21)"),
        (
            "SIN(DX(21,1))+VARVAL(1)*DZ(20,1)",
            "COS(DX(21,1))*VX(21,1)+0.4*TIME*DZ(20,1)+VARVAL(1)*VZ(20,1)",
        ),
    ] {
        let variables = "VARIABLE/1, FUNCTION=0.2*TIME**2";
        let told = with(&format!("{variables}\nVARIABLE/2, FUNCTION={places}"));
        let mut scratch = Scratch::new(&told.system);
        let here = told
            .system
            .evaluate(&told.parameters, &told.state, &mut scratch);
        let value = here
            .and_then(|mut here| here.read_variable(1))
            .expect("no error");
        let of_places = with(&format!(
            "{variables}\nGCON/1, FUNCTION={places}-({value:e})"
        ));
        let of_rate = with(&format!("{variables}\nGCON/1, FUNCTION={rate}"));
        for error in [1e-4, 1e-6, 1e-8] {
            let (a, _) = integrated(&of_places, error, 0.05, 1.0);
            let (b, _) = integrated(&of_rate, error, 0.05, 1.0);
            let apart = (a.poses[1].p - b.poses[1].p).norm();
            let faster = (a.velocities[1].linear - b.velocities[1].linear).norm();
            println!("{places} {error:e}: {apart:e} {faster:e}");
            assert!(
                apart < 10.0 * error && faster < 50.0 * error,
                "{rate}, {error}: {apart} {faster}"
            );
            let force = (a.multipliers[0] - b.multipliers[0]).abs();
            assert!(
                force < 1e3 * error * (1.0 + a.multipliers[0].abs()),
                "{rate}, {error}: {force}"
            );
        }
    }
}

/// Returns the constraints of a disc that rolls on the plane z = 0 and touches it at the lowest point of its rim. The marker at the centre of
/// the disc has the id 10 times `disc`. The marker on the axis of the disc has the next id.
fn rolling(disc: u32, radius: f64) -> String {
    let (cm, axis) = (disc * 10, disc * 10 + 1);
    // Let a be the axis of the disc. The lowest point is the centre minus R (z - a_z a)/s, with s^2 = 1 - a_z^2.
    let a = |k: char| format!("D{k}({axis},{cm})");
    let s = format!("SQRT(1-{z}**2)", z = a('Z'));
    let arm = |k: char| match k {
        'Z' => format!("(-{radius}*{s})"),
        _ => format!("({radius}*{}*{}/{s})", a('Z'), a(k)),
    };
    let (x, y, z) = (arm('X'), arm('Y'), arm('Z'));
    format!(
        "GCON/{disc}1, I={cm}, FUNCTION=DZ({cm})+{z}
GCON/{disc}2, I={cm}, FUNCTION=VX({cm})+WY({cm})*{z}-WZ({cm})*{y}
GCON/{disc}3, I={cm}, FUNCTION=VY({cm})+WZ({cm})*{x}-WX({cm})*{z}"
    )
}

/// Checks that the loads on part 2, whose mass centre is its origin, equal the rates of its momentum and angular momentum.
fn loads_make_the_motion(deck: &Deck, state: &State) {
    let mut scratch = Scratch::new(&deck.system);
    let look = deck.system.evaluate(&deck.parameters, state, &mut scratch);
    let loads = look.expect("a value").loads().expect("no error");
    let (pose, v, a) = (
        state.poses[1],
        &state.velocities[1],
        &state.accelerations[1],
    );
    let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
    for load in loads.iter().filter(|load| load.part.0 == 1) {
        force += load.force;
        torque += load.torque_about(&pose.p);
    }
    let inertia = pose.R
        * crate::mechanics::Mat3::from_diagonal(&Vec3::new(0.045, 0.045, 0.09))
        * pose.R.transpose();
    let spun = inertia * a.angular + v.angular.cross(&(inertia * v.angular));
    assert!(
        (force - a.linear * 2.0).norm() < 1e-9 * 20.0,
        "{force} {}",
        a.linear
    );
    assert!((torque - spun).norm() < 1e-9 * 5.0, "{torque} {spun}");
}

/// A thin disc that wobbles as it rolls keeps its energy, and the loads match its motion.
#[test]
fn a_rolling_disc_keeps_its_energy() {
    let deck = deck(&format!(
        "ACCGRAV/KGRAV=-9.81
PART/2, MASS=2, CM=20, IP=0.045,0.045,0.09, QG=0,0,0.28, REULER=0.2,1.2,0, VX=0.2, WX=0.5, WZ=-8
MARKER/20, PART=2
MARKER/21, PART=2, QP=0,0,1
{}",
        rolling(2, 0.3)
    ));
    let energy = |state: &State| {
        let spin = state.poses[1].R.transpose() * state.velocities[1].angular;
        let turning = 0.045 * (spin.x * spin.x + spin.y * spin.y) + 0.09 * spin.z * spin.z;
        let v = state.velocities[1].linear;
        0.5 * (2.0 * v.norm_squared() + turning) + 2.0 * 9.81 * state.poses[1].p.z
    };
    let mut before = f64::INFINITY;
    for error in [1e-5, 1e-7] {
        let mut integrator = begun(&deck, error, 0.1);
        let start = integrator.output().expect("an output");
        let mut most = 0.0_f64;
        let mut tilt = Vec::new();
        for step in 1..=50 {
            integrator
                .advance_to(0.1 * f64::from(step))
                .expect("no error");
            let state = integrator.output().expect("an output");
            most = most.max((energy(&state) - energy(&start)).abs());
            loads_make_the_motion(&deck, &state);
            tilt.push(state.poses[1].R[(2, 2)]);
        }
        println!("{error:e}: {most:e} of {}", energy(&start));
        let range = |x: f64, y: f64| {
            tilt.iter()
                .copied()
                .fold(x, if x > y { f64::min } else { f64::max })
        };
        assert!(
            range(-1.0, 1.0) - range(1.0, -1.0) > 0.1,
            "it wobbles: {tilt:?}"
        );
        assert!(most < 100.0 * error, "{most}");
        assert!(most < 0.2 * before);
        before = most;
    }
}

/// The Newton iteration of a step gives the same result with every kind of derivatives.
#[test]
fn every_iteration_finds_the_same_step() {
    use crate::motion::derivatives::Derivatives;
    let deck = sleigh("GCON/1, FUNCTION=VY(21,1,21)-0.2*DX(20,1)*TIME+0.1*WZ(20)*DY(20)");
    let h = 0.05;
    let mut found: Vec<Vec<f64>> = Vec::new();
    let kinds = [
        Derivatives::Single,
        Derivatives::Sequence,
        Derivatives::Kept,
        Derivatives::Renewed,
    ];
    for derivatives in kinds {
        let mut integrator = begun(&deck, 1e-9, 0.1);
        integrator.predict(h);
        integrator.prepare(h).expect("no error");
        let iterations = integrator
            .solve(h, derivatives)
            .map_err(|not| not.why)
            .expect("no error");
        println!("{derivatives:?} {iterations}");
        assert!(iterations <= 10, "{derivatives:?}");
        let unknowns = &integrator.unknowns;
        let all = unknowns.z.iter().chain(&unknowns.w).flatten().copied();
        found.push(all.collect());
    }
    for other in &found[1..] {
        for (a, b) in other.iter().zip(&found[0]) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

/// A nonholonomic constraint that other constraints imply is redundant, whatever the order of the statements. If two nonholonomic constraints
/// are equivalent, the later one is redundant.
#[test]
fn what_says_nothing_new_is_left_out() {
    let deck = sleigh(
        "GCON/1, FUNCTION=VX(21)-0.1
GCON/2, FUNCTION=WX(21)
GCON/3, FUNCTION=2*VX(21)-0.2
MOTION/1, I=21, J=1, X, FUNCTION=0.1*TIME",
    );
    let (state, _) = integrated(&deck, 1e-6, 0.1, 1.0);
    let out: Vec<String> = (0..deck.system.equations)
        .filter(|k| state.redundant[*k])
        .map(|k| deck.system.constraint_equation_name(k).to_string())
        .collect();
    assert_eq!(out, ["GCON/1", "GCON/2", "GCON/3"]);
    assert!((state.velocities[1].linear.x - 0.1).abs() < 1e-9);
    // A contradicting constraint is reported.
    let other = sleigh("GCON/1, FUNCTION=VX(21)-0.2\nMOTION/1, I=21, J=1, X, FUNCTION=0.1*TIME");
    let mut state = other.state.clone();
    let mut memory = Consistent::new(&other.system);
    let (system, parameters) = (&other.system, &other.parameters);
    let told = assemble(
        system,
        parameters,
        &mut state,
        &mut memory,
        Kept::Data,
        1e-3,
    );
    assert!(told.unwrap_err().to_string().contains("GCON/1"));
}

/// The wobble of an upright disc that rolls at the rate O has an eigenvalue s with `s^2 = -(C (C + m R^2) O^2 - A m g R)/(A (A + m R^2))`. A is
/// the moment of inertia across the axis, and C about it. All other small motions drift (E. J. Routh, Dynamics of a System of Rigid Bodies,
/// part II, 244).
#[test]
fn an_upright_disc_is_stable_at_speed() {
    let (m, R, across, along) = (2.0, 0.3, 0.05, 0.08);
    for spin in [0.5, 3.0, 6.0, 20.0] {
        let deck = deck(&format!(
            "ACCGRAV/KGRAV=-9.81
PART/2, MASS={m}, CM=20, IP={across},{across},{along}, QG=0,0,{R}, REULER=0,90D,0, VX={}, WZ={}
MARKER/20, PART=2
MARKER/21, PART=2, QP=0,0,1
{}",
            spin * R,
            -spin,
            rolling(2, R)
        ));
        let (state, _) = integrated(&deck, 1e-8, 0.1, 1e-6);
        let modes =
            crate::motion::modes(&deck.system, &deck.parameters, &state, true).expect("no error");
        assert_eq!(modes.len(), 8);
        let whole = m * R * R;
        let square = -(along * (along + whole) * spin * spin - across * m * 9.81 * R)
            / (across * (across + whole));
        for mode in &modes[..6] {
            assert!(mode.value.norm() < 2e-3, "{}", mode.value);
        }
        for mode in &modes[6..] {
            let off = mode.value * mode.value - square;
            assert!(
                off.norm() < 1e-5 * square.abs(),
                "{spin}: {} {square}",
                mode.value
            );
        }
    }
}

/// The benchmark bicycle of Meijaard, Papadopoulos, Ruina and Schwab (Proc. R. Soc. A 463, 2007). The test checks the published eigenvalues at
/// 5 m/s, and the speed at which the weave mode changes its stability.
#[test]
fn a_bicycle_has_the_eigenvalues_of_the_benchmark() {
    let (wheelbase, trail, tilt) = (1.02, 0.08, std::f64::consts::PI / 10.0);
    let (rear, front) = (0.3, 0.35);
    let modes = |v: f64| {
        let steer = wheelbase + trail;
        let deck = deck(&format!(
            "ACCGRAV/KGRAV=-9.81
PART/2, MASS=2, CM=20, IP=0.0603,0.12,0.0603, QG=0,0,{rear}, VX={v}, WY={}
MARKER/20, PART=2
MARKER/21, PART=2, QP=0,1,0
MARKER/22, PART=2, REULER=0,90D,0
PART/3, MASS=3, CM=30, IP=0.1405,0.28,0.1405, QG={wheelbase},0,{front}, VX={v}, WY={}
MARKER/30, PART=3
MARKER/31, PART=3, QP=0,1,0
MARKER/32, PART=3, REULER=0,90D,0
PART/4, MASS=85, CM=40, IP=9.2,11,2.8,0,2.4,0, VX={v}
MARKER/40, PART=4, QP=0.3,0,0.9
MARKER/41, PART=4, QP=0,0,{rear}, REULER=0,90D,0
MARKER/42, PART=4, QP={steer},0,0, REULER=-90D,{tilt},0
PART/5, MASS=4, CM=50, IP=0.05892,0.06,0.00708,0,-0.00756,0, VX={v}
MARKER/50, PART=5, QP=0.9,0,0.7
MARKER/51, PART=5, QP={wheelbase},0,{front}, REULER=0,90D,0
MARKER/52, PART=5, QP={steer},0,0, REULER=-90D,{tilt},0
JOINT/1, REVOLUTE, I=22, J=41
JOINT/2, REVOLUTE, I=32, J=51
JOINT/3, REVOLUTE, I=52, J=42
{}
{}",
            v / rear,
            v / front,
            rolling(2, rear),
            rolling(3, front)
        ));
        let (state, _) = integrated(&deck, 1e-8, 0.1, 1e-6);
        let modes =
            crate::motion::modes(&deck.system, &deck.parameters, &state, true).expect("no error");
        assert_eq!(modes.len(), 10);
        // Six motions neither grow nor oscillate.
        let values: Vec<_> = modes.iter().map(|mode| mode.value).collect();
        values
    };
    let has = |values: &[nalgebra::Complex<f64>], re: f64, im: f64| {
        let near = |value: &nalgebra::Complex<f64>| {
            (value.re - re).abs() < 1e-6 && (value.im - im).abs() < 1e-6
        };
        assert!(values.iter().any(near), "{re} {im}: {values:?}");
    };
    let at = modes(5.0);
    has(&at, -0.775341882195845, 4.46486771378823);
    has(&at, -0.775341882195845, -4.46486771378823);
    has(&at, -0.322866429004087, 0.0);
    has(&at, -14.0783896927982, 0.0);
    let weave = modes(4.29238253634111);
    let swings = weave.iter().filter(|value| value.im > 1.0);
    let swings: Vec<f64> = swings.map(|value| value.re).collect();
    assert!(matches!(swings[..], [re] if re.abs() < 1e-6), "{weave:?}");
}

/// Returns the model of [`the_rate_of_a_constraint_is_the_constraint`] without the point mass and its spring, with the given additional
/// statements.
fn pulled(statements: &str) -> Deck {
    deck(&format!(
        "ACCGRAV/KGRAV=-9.81
PART/2, MASS=1, CM=20, IP=0.04,0.1,0.2, REULER=0.3,0.9,0.1, WY=1
MARKER/20, PART=2, QP=0.4,0.1,0
MARKER/21, PART=2, QP=0,0.3,0.2
MARKER/2, PART=1, QP=1.5,0,0.2
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=20, C=0.3, LENGTH=0.4
{statements}"
    ))
}

/// A constraint whose function reads VARIABLEs gives the same motion and the same reaction as a constraint whose function contains the
/// expressions of these VARIABLEs.
#[test]
fn variables_of_places_and_velocities_stand_for_what_they_read() {
    for (written, variables, function) in [
        (
            "DX(21,2)*DY(20,2)+DZ(20)**2-0.1*TIME",
            "VARIABLE/1, FUNCTION=DX(21,2)*VARVAL(2)
VARIABLE/2, FUNCTION=DY(20,2)
VARIABLE/3, FUNCTION=VARVAL(1)-VARVAL(4)
VARIABLE/4, FUNCTION=0.1*TIME",
            "VARVAL(3)+DZ(20)**2",
        ),
        (
            "VX(21,2)*DY(20,2)-0.2*WZ(20)+0.1*SIN(TIME)",
            "ARRAY/1, U, SIZE=2, VARIABLES=1,2
VARIABLE/1, FUNCTION=VX(21,2)*VARVAL(3)
VARIABLE/2, FUNCTION=0.2*WZ(20)-0.1*SIN(TIME)
VARIABLE/3, FUNCTION=DY(20,2)",
            "ARYVAL(1,1)-ARYVAL(1,2)",
        ),
    ] {
        // This is the value at the start; subtracting it makes the constraint zero there.
        let probe = pulled(&format!("VARIABLE/9, FUNCTION={written}"));
        let mut scratch = Scratch::new(&probe.system);
        let here = probe
            .system
            .evaluate(&probe.parameters, &probe.state, &mut scratch);
        let value = here
            .and_then(|mut here| here.read_variable(0))
            .expect("no error");
        let direct = pulled(&format!("GCON/1, I=21, FUNCTION={written}-({value:e})"));
        let through = pulled(&format!(
            "{variables}\nGCON/1, I=21, FUNCTION={function}-({value:e})"
        ));
        let (a, _) = integrated(&direct, 1e-6, 0.05, 1.0);
        let (b, _) = integrated(&through, 1e-6, 0.05, 1.0);
        let apart = (a.poses[1].p - b.poses[1].p).norm();
        let force = (a.multipliers[0] - b.multipliers[0]).abs();
        assert!(a.multipliers[0].abs() > 0.1, "{}", a.multipliers[0]);
        assert!(apart < 1e-8 && force < 1e-6, "{function}: {apart} {force}");
    }
}

/// A constraint may read dynamic states. Its rates then contain the rates of these states.
#[test]
fn states_that_are_known_drive_constraints() {
    // A position is prescribed by one of two oscillating states, s1 = 0.3 sin(2 t).
    let sine = "DIFF/1, IC=0, FUNCTION=2*DIF(2)\nDIFF/2, IC=0.3, FUNCTION=-2*DIF(1)";
    let held = pulled(
        &format!("{sine}\nGCON/1, FUNCTION=DX(20)-DX(20)@0-DIF(1)").replace("DX(20)@0", &place(0)),
    );
    let known =
        pulled(&"GCON/1, FUNCTION=DX(20)-DX(20)@0-0.3*SIN(2*TIME)".replace("DX(20)@0", &place(0)));
    let (a, _) = integrated(&held, 1e-7, 0.05, 1.0);
    let (b, _) = integrated(&known, 1e-7, 0.05, 1.0);
    let apart = (a.poses[1].p - b.poses[1].p).norm();
    let force = (a.multipliers[0] - b.multipliers[0]).abs();
    assert!(apart < 1e-6 && force < 1e-5, "{apart} {force}");
    assert!((a.states[0] - 0.3 * 2.0_f64.sin()).abs() < 1e-6);

    // A state prescribes a speed. In the first case, the state is independent; in the second, it reads the speed that it prescribes.
    for (state, speed, factor) in [
        (
            "IC=0, FUNCTION=2*(1-DIF(1))",
            1.0 - (-2.0_f64).exp(),
            2.0 * (-2.0_f64).exp(),
        ),
        (
            "IC=0.5, FUNCTION=-3*VX(20)",
            0.5 * (-3.0_f64).exp(),
            -1.5 * (-3.0_f64).exp(),
        ),
    ] {
        let driven = pulled(&format!("DIFF/1, {state}\nGCON/1, FUNCTION=VX(20)-DIF(1)"));
        let (end, _) = integrated(&driven, 1e-7, 0.05, 1.0);
        let r = end.poses[1].R * Vec3::new(0.4, 0.1, 0.0);
        let w = end.velocities[1].angular;
        let vx = (end.velocities[1].linear + w.cross(&r)).x;
        assert!((vx - speed).abs() < 1e-6, "{state}: {vx} {speed}");
        let turned = end.accelerations[1].angular.cross(&r) + w.cross(&w.cross(&r));
        let ax = (end.accelerations[1].linear + turned).x;
        assert!((ax - factor).abs() < 1e-5, "{state}: {ax} {factor}");
    }
}

/// Returns the position of marker 20 at the start along an axis of ground, as a literal.
fn place(axis: usize) -> String {
    let deck = pulled("");
    let pose = &deck.state.poses[1];
    let p = pose.p + pose.R * Vec3::new(0.4, 0.1, 0.0);
    format!("({:e})", p[axis])
}
