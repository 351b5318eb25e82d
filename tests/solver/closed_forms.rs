//! Equilibria with closed-form solutions.

use std::fmt::Write;

use admire_solver::mechanics::{Vec3, exp, log};
use admire_solver::statics::{StaticSettings, smallest_eigenvalue};

use crate::deck::{Solved, solve, solve_with};

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() < tolerance,
        "{value} instead of {expected}"
    );
}

/// Returns a part of mass 1 at a position, with unrotated axes. Its markers are 10 id + n.
fn part(id: u32, at: [f64; 3]) -> String {
    let [x, y, z] = at;
    format!(
        "PART/{id}, QG={x},{y},{z}, MASS=1, CM={cm}, IP=100,100,100\nMARKER/{cm}, PART={id}\n",
        cm = 10 * id
    )
}

/// Returns the rotation angle about z of a part that rotated only in the xy plane.
fn turn(solved: &Solved, part: u32) -> f64 {
    let turn = log(&solved.pose(part).R);
    assert!(turn.x.abs() + turn.y.abs() < 1e-9, "{turn}");
    turn.z
}

const BEAM: &str = "AREA=78.5, IXX=980, IYY=490, IZZ=490, EMODULUS=2.1E5, GMODULUS=8E4";
const EI: f64 = 2.1e5 * 490.0;

/// Checks a clamped beam under a transverse force at its tip: P L^3 / 3 E I and P L^2 / 2 E I. The law is linear and holds at any size.
#[test]
fn a_cantilever() {
    let (l, p) = (200.0, 500.0);
    let solved = solve(&format!(
        "{}BEAM/1, I=20, J=1, LENGTH={l}, {BEAM}\n\
         MARKER/2, PART=1, REULER=0D,-90D,0D\nSFORCE/1, I=20, J=2, TRANSLATIONAL, ACTIONONLY, FUNCTION={p}",
        part(2, [l, 0.0, 0.0])
    ));
    let tip = solved.pose(2).p;
    close(tip.x, l, 1e-9);
    close(tip.y, p * l.powi(3) / (3.0 * EI), 1e-9);
    close(turn(&solved, 2), p * l * l / (2.0 * EI), 1e-12);
    // The clamp carries the force, and the moment about its own position.
    let (F, T) = solved.on(1, "BEAM/1", &Vec3::zeros());
    close(F.y, p, 1e-7);
    close(T.z, p * l, 2e-5);
}

/// Checks beams in series under a moment M at the end. Each bends by c = M l / E I, and its end is at (l, l c / 2) in its own frame. The beams
/// form a polygon inscribed in a circle of curvature M / E I, which it approaches with many beams.
#[test]
fn beams_bent_to_a_circle() {
    let (n, l) = (20, 10.0);
    let curvature = std::f64::consts::FRAC_PI_2 / (f64::from(n) * l);
    let mut deck = String::new();
    for k in 1..=n {
        let id = k + 1;
        deck += &part(id, [l * f64::from(k), 0.0, 0.0]);
        let j = if k == 1 { 1 } else { 10 * (id - 1) };
        writeln!(deck, "BEAM/{k}, I={}, J={j}, LENGTH={l}, {BEAM}", 10 * id).unwrap();
    }
    let last = n + 1;
    writeln!(
        deck,
        "MARKER/2, PART=1, FLOATING\nVTORQUE/1, I={}, JFLOAT=2, RM=1, TZ={}",
        10 * last,
        EI * curvature
    )
    .unwrap();
    let solved = solve(&deck);
    let c = curvature * l;
    let mut at = Vec3::zeros();
    for k in 0..n {
        at += exp(&(Vec3::z() * c * f64::from(k))) * Vec3::new(l, l * c / 2.0, 0.0);
    }
    assert!((solved.pose(last).p - at).norm() < 1e-7, "{at}");
    close(turn(&solved, last), std::f64::consts::FRAC_PI_2, 1e-10);
    let radius = 1.0 / curvature;
    let circle = Vec3::new(radius, radius, 0.0);
    assert!((at - circle).norm() < 2e-3 * radius, "{at} {circle}");
}

/// Checks a pendulum on a torsion spring: m g l cos(a) = KT a, with the spring relaxed at a level arm.
#[test]
fn a_pendulum_on_a_torsion_spring() {
    let (l, m, g, kt) = (150.0, 2.0, 9806.65, 4e3);
    let solved = solve(&format!(
        "ACCGRAV/JGRAV={}\nPART/2, QG=0,0,0, MASS={m}, CM=20, IP=1E4,1E4,1E4\nMARKER/20, PART=2, QP={l},0,0\nMARKER/21, PART=2\n\
         JOINT/1, REVOLUTE, I=21, J=1\nSPRINGDAMPER/1, I=21, J=1, ROTATIONAL, KT={kt}",
        -g
    ));
    let a = -turn(&solved, 2);
    let weight = m * g / 1000.0;
    close(weight * l * a.cos(), kt * a, 1e-6);
    assert!(a > 0.5, "{a}");
    // The hinge carries the weight, and the spring carries its moment.
    let (F, _) = solved.on(2, "JOINT/1", &Vec3::zeros());
    assert!((F - Vec3::y() * weight).norm() < 1e-8, "{F}");
    let (_, T) = solved.on(2, "SPRINGDAMPER/1", &Vec3::zeros());
    close(T.z, kt * a, 1e-9 * kt);
}

/// Checks four bushings at the corners of a square of half side a on ground. A force moves the link by F / 4 K. A moment rotates it by the angle
/// t with 4 K 2 a^2 sin(t) + 4 KT t = M: the springs of the corners follow the chord, the bushings' own torsion follows the angle.
#[test]
fn a_link_on_four_bushings() {
    let (a, k, kt, force, moment) = (50.0, 800.0, 2e5, 1000.0, 6e6);
    let mut deck = part(2, [0.0; 3]);
    for (n, (x, y)) in (1..).zip([(a, a), (a, -a), (-a, a), (-a, -a)]) {
        writeln!(
            deck,
            "MARKER/{i}, PART=2, QP={x},{y},0\nMARKER/{j}, PART=1, QP={x},{y},0\n\
             BUSHING/{n}, I={i}, J={j}, K={k},{k},{k}, KT=1E7,1E7,{kt}",
            i = 20 + n,
            j = 30 + n
        )
        .unwrap();
    }
    let pull = |fx: f64, tz: f64| {
        solve(&format!(
            "{deck}MARKER/9, PART=1, FLOATING\nGFORCE/1, I=20, JFLOAT=9, RM=1, FX={fx}\\, TZ={tz}"
        ))
    };
    let moved = pull(force, 0.0);
    assert!((moved.pose(2).p - Vec3::x() * force / (4.0 * k)).norm() < 1e-10);
    let turned = pull(0.0, moment);
    let t = turn(&turned, 2);
    close(8.0 * k * a * a * t.sin() + 4.0 * kt * t, moment, 1e-5);
    assert!(turned.pose(2).p.norm() < 1e-9 && t > 0.3, "{t}");
}

/// Checks a follower force, which keeps its lever arm: F r = KT t; and a force of constant direction, which loses it: F r cos(t) = KT t.
#[test]
fn follower_and_dead_loads() {
    let (r, force, kt) = (100.0, 60.0, 5e3);
    let deck = |j: u32| {
        solve(&format!(
            "{}MARKER/21, PART=2, QP={r},0,0, REULER=0D,-90D,0D\nMARKER/22, PART=2\nMARKER/2, PART=1, REULER=0D,-90D,0D\n\
             JOINT/1, REVOLUTE, I=22, J=1\nSPRINGDAMPER/1, I=22, J=1, ROTATIONAL, KT={kt}\n\
             SFORCE/1, I=21, J={j}, TRANSLATIONAL, ACTIONONLY, FUNCTION={force}",
            part(2, [0.0; 3])
        ))
    };
    close(turn(&deck(21), 2), force * r / kt, 1e-10);
    let t = turn(&deck(2), 2);
    close(force * r * t.cos(), kt * t, 1e-6);
}

/// Checks the buckling of Hencky's chain: n rigid links with a torsion spring at every hinge, the first link on the clamp. Under a load P along
/// the chain, the second variation is KT T - P l. Its smallest eigenvalue vanishes at P = 4 KT / l sin^2(pi / (2 (2 n + 1))). For many links,
/// this is Euler's pi^2 E I / 4 L^2 with E I = KT l and L = (n + 1/2) l.
#[test]
fn a_chain_of_bushings_buckles_where_euler_says() {
    let (n, l, kt) = (8_u32, 100.0, 1e6);
    let half = std::f64::consts::PI / (2.0 * f64::from(2 * n + 1));
    let critical = 4.0 * kt / l * half.sin().powi(2);
    let euler = std::f64::consts::PI.powi(2) * kt * l / (2.0 * l * (f64::from(n) + 0.5)).powi(2);
    assert!((critical / euler - 1.0).abs() < 3e-3, "{critical} {euler}");
    let stiffness = |load: f64| {
        let mut deck = String::new();
        for k in 0..n {
            let id = k + 2;
            deck += &part(id, [l * f64::from(k), 0.0, 0.0]);
            writeln!(deck, "MARKER/{}, PART={id}, QP={l},0,0", 10 * id + 1).unwrap();
            let j = if k == 0 { 1 } else { 10 * (id - 1) + 1 };
            writeln!(
                deck,
                "BUSHING/{id}, I={}, J={j}, K=1E8,1E8,1E8, KT=1E9,1E9,{kt}",
                10 * id
            )
            .unwrap();
        }
        // The direction of the load is fixed in ground: -x.
        writeln!(
            deck,
            "MARKER/2, PART=1, REULER=90D,-90D,0D\nSFORCE/1, I={}, J=2, TRANSLATIONAL, ACTIONONLY, FUNCTION={load}",
            10 * (n + 1) + 1
        )
        .unwrap();
        let solved = solve(&deck);
        assert!(solved.marker(10 * (n + 1) + 1).p.x < l * f64::from(n));
        smallest_eigenvalue(&solved.system, &solved.parameters, &solved.state)
            .unwrap()
            .unwrap()
    };
    let (mut below, mut above) = (0.5 * critical, 1.5 * critical);
    assert!(stiffness(below) > 0.0 && stiffness(above) < 0.0);
    while above - below > 1e-6 * critical {
        let middle = 0.5 * (below + above);
        if stiffness(middle) > 0.0 {
            below = middle;
        } else {
            above = middle;
        }
    }
    println!("buckles at {below} N, Hencky {critical} N, Euler {euler} N");
    // Each bushing is compressed by P / K, which is 3e-8 of the length of a link.
    assert!((below / critical - 1.0).abs() < 2e-6, "{below} {critical}");
}

/// Checks that FORCE and TORQUE of a bushing are added to the elastic part: d = FORCE / K at rest.
#[test]
fn bushing_preload() {
    let solved = solve(&format!(
        "{}BUSHING/1, I=20, J=1, K=100,200,400, KT=1E6,1E6,1E6, FORCE=30,-50,80, TORQUE=0,0,2E4",
        part(2, [0.0; 3])
    ));
    let p = solved.pose(2).p;
    assert!((p - Vec3::new(0.3, -0.25, 0.2)).norm() < 1e-11, "{p}");
    close(turn(&solved, 2), 0.02, 1e-12);
}

/// Checks F = -K (d - LENGTH) + FORCE with an unsymmetric K, which distinguishes an order by columns from an order by rows.
#[test]
fn a_field_reads_its_matrix_by_columns() {
    // Columns: (100, 10, 0), (20, 200, 30), (0, 40, 300).
    let mut k = vec![0.0; 36];
    for (row, column, value) in [
        (0, 0, 100.0),
        (1, 0, 10.0),
        (0, 1, 20.0),
        (1, 1, 200.0),
        (2, 1, 30.0),
        (1, 2, 40.0),
        (2, 2, 300.0),
        (3, 3, 1e6),
        (4, 4, 1e6),
        (5, 5, 1e6),
    ] {
        k[6 * column + row] = value;
    }
    let words: Vec<String> = k.iter().map(ToString::to_string).collect();
    let solved = solve(&format!(
        "{}FIELD/1, I=20, J=1, LENGTH=1,2,3,0,0,0, FORCE=5,6,7,0,0,0, KMATRIX={}\n\
         MARKER/9, PART=1, FLOATING\nVFORCE/1, I=20, JFLOAT=9, RM=1, FX=50\\, FY=-60\\, FZ=70",
        part(2, [0.0; 3]),
        words.join("\n,")
    ));
    let d = solved.pose(2).p - Vec3::new(1.0, 2.0, 3.0);
    let F = Vec3::new(
        100.0 * d.x + 20.0 * d.y,
        10.0 * d.x + 200.0 * d.y + 40.0 * d.z,
        30.0 * d.y + 300.0 * d.z,
    );
    assert!((F - Vec3::new(55.0, -54.0, 77.0)).norm() < 1e-8, "{F}");
}

/// Checks a point mass on two springs in a V: 2 K (r - LENGTH) sin = weight, by symmetry.
#[test]
fn a_point_mass_on_two_springs() {
    let (k, length, b, m) = (3.0, 80.0, 60.0_f64, 4.0);
    let solved = solve(&format!(
        "ACCGRAV/JGRAV=-9806.65\nPOINT_MASS/7, MASS={m}, CM=5, QG=3,-60,1\nMARKER/5, POINT_MASS=7\n\
         MARKER/2, PART=1, QP={b},0,0\nMARKER/3, PART=1, QP={},0,0\n\
         SPRINGDAMPER/1, I=5, J=2, TRANSLATIONAL, K={k}, LENGTH={length}\nSPRINGDAMPER/2, I=5, J=3, TRANSLATIONAL, K={k}, LENGTH={length}",
        -b
    ));
    let p = solved.pose(7).p;
    assert!(p.x.abs() < 1e-8 && p.z.abs() < 1e-8, "{p}");
    let r = b.hypot(p.y);
    close(2.0 * k * (r - length) * -p.y / r, m * 9.80665, 1e-7);
}

/// Checks that a positive SFORCE along a line pushes its markers apart.
#[test]
fn a_scalar_force_pushes_apart() {
    let solved = solve(&format!(
        "{}MARKER/2, PART=1, QP=-50,0,0\nBUSHING/1, I=20, J=1, K=10,10,10, KT=1E6,1E6,1E6\nSFORCE/1, I=20, J=2, TRANSLATIONAL, FUNCTION=25",
        part(2, [0.0; 3])
    ));
    close(solved.pose(2).p.x, 2.5, 1e-11);
    let (F, _) = solved.on(1, "SFORCE/1", &Vec3::zeros());
    close(F.x, -25.0, 1e-9);
}

/// Checks that the reaction of a GFORCE acts at the position of I, without a lever arm to the part of JFLOAT. Force and torque then cancel about
/// any point.
#[test]
fn the_reaction_of_a_vector_force_stands_at_i() {
    let solved = solve(&format!(
        "{}{}MARKER/21, PART=2, QP=0,40,0\nMARKER/31, PART=3, FLOATING\n\
         BUSHING/1, I=20, J=1, K=10,10,10, KT=1E6,1E6,1E6\nMARKER/3, PART=1, QP=200,0,0\nBUSHING/2, I=30, J=3, K=10,10,10, KT=1E6,1E6,1E6\n\
         GFORCE/1, I=21, JFLOAT=31, RM=1, FX=10\\, FY=20\\, TZ=300",
        part(2, [0.0; 3]),
        part(3, [200.0, 0.0, 0.0])
    ));
    let about = Vec3::new(7.0, -3.0, 2.0);
    let (F2, T2) = solved.on(2, "GFORCE/1", &about);
    let (F3, T3) = solved.on(3, "GFORCE/1", &about);
    assert!((F2 - Vec3::new(10.0, 20.0, 0.0)).norm() < 1e-12);
    assert!((F2 + F3).norm() < 1e-12 && (T2 + T3).norm() < 1e-9);
    // Part 3 rotates about its own bushing, by the moment of the force at I.
    let arm = solved.marker(21).p - solved.marker(30).p;
    let torque = arm.cross(&F3).z - 300.0;
    close(turn(&solved, 3), torque / 1e6, 1e-10);
}

/// Checks a multi-point force between two markers and ground, which couples them along x with K = [[a, -b], [-b, a]].
#[test]
fn a_multi_point_force() {
    let (a, b) = (30.0, 10.0);
    let mut k = vec![0.0; 144];
    for n in 0..12 {
        k[13 * n] = if n % 6 < 3 { a } else { 1e6 };
    }
    k[6] = -b;
    k[12 * 6] = -b;
    let words: Vec<String> = k.iter().map(ToString::to_string).collect();
    let solved = solve(&format!(
        "{}{}MATRIX/1, FULL=CORDER, ROWS=12, COLUMNS=12, VALUES={}\nNFORCE/1, I=20,30, J=1, KMATRIX=1\n\
         MARKER/9, PART=1, FLOATING\nVFORCE/1, I=20, JFLOAT=9, RM=1, FX=100",
        part(2, [0.0; 3]),
        part(3, [0.0; 3]),
        words.join("\n,")
    ));
    // a x2 - b x3 = 100, a x3 - b x2 = 0.
    let x2 = 100.0 * a / (a * a - b * b);
    close(solved.pose(2).p.x, x2, 1e-9);
    close(solved.pose(3).p.x, x2 * b / a, 1e-9);
}

/// Checks the constraints that couple joints. Each part is on a rail, and a function of its own position pulls it back.
#[test]
fn constraints_transmit_as_they_say() {
    let wheel = |id: u32, at: f64, kind: &str| {
        format!(
            "{}MARKER/{}, PART={id}\nMARKER/{}, PART=1, QP=0,{at},0\nJOINT/{id}, {kind}, I={}, J={}\n",
            part(id, [0.0, at, 0.0]),
            10 * id + 1,
            100 + id,
            10 * id + 1,
            100 + id
        )
    };
    // COUPLER: 2 q2 + 6 q3 = 0.
    let solved = solve(&format!(
        "{}{}COUPLER/1, JOINTS=2,3, TYPE=R:R, SCALES=2,6\nMOTION/1, JOINT=2, FUNCTION=0.9",
        wheel(2, 0.0, "REVOLUTE"),
        wheel(3, 50.0, "REVOLUTE")
    ));
    close(turn(&solved, 3), -0.3, 1e-12);
    // A torque on one part is held by a torque at the MOTION, in the ratio of the scales.
    let solved = solve(&format!(
        "{}{}COUPLER/1, JOINTS=2,3, TYPE=R:R, SCALES=2,6\nMOTION/1, JOINT=2, FUNCTION=0\n\
         MARKER/9, PART=1, FLOATING\nVTORQUE/1, I=31, JFLOAT=9, RM=1, TZ=900",
        wheel(2, 0.0, "REVOLUTE"),
        wheel(3, 50.0, "REVOLUTE")
    ));
    // The work of both torques vanishes along dq2 = -3 dq3.
    let (_, T) = solved.on(2, "MOTION/1", &Vec3::zeros());
    close(T.z, 900.0 / 3.0, 1e-8);
    // SCREW with a CYLINDRICAL joint: two and a half turns with a pitch of 4.
    let screw = wheel(2, 0.0, "CYLINDRICAL") + "JOINT/9, SCREW, I=21, J=102, PITCH=4\n";
    let solved = solve_with(
        &format!("{screw}MOTION/1, JOINT=2, ROTATIONAL, FUNCTION=0.75*PI"),
        &StaticSettings::tight(),
    );
    close(solved.pose(2).p.z, 4.0 * 0.375, 1e-10);
    // GCON: a rod of constant length.
    let solved = solve(
        "ACCGRAV/JGRAV=-9806.65\nPOINT_MASS/2, MASS=2, CM=5, QG=60,-80,0\nMARKER/5, POINT_MASS=2\nGCON/1, FUNCTION=DM(5,1)-100",
    );
    close(solved.pose(2).p.norm(), 100.0, 1e-8);
    close(solved.pose(2).p.y, -100.0, 1e-6);
    // Its multiplier is the tension.
    let (F, _) = solved.on(2, "GCON/1", &Vec3::zeros());
    close(F.y, 2.0 * 9.80665, 1e-6);
}

/// Checks a lever whose angle starts close to 180 degrees and passes it on the way to the first equilibrium. AZ "accounts for angle wrapping"
/// (`cfunc_ax`). The equation `k (AZ - 3) = M` holds only at `AZ = 3 + M / k`, for a function and for a bushing.
#[test]
fn past_half_a_turn_from_the_dataset() {
    let (k, moment) = (2e3, 1e3);
    let lever = "PART/2, MASS=1, CM=20, IP=100,100,100, REULER=3.0, 0, 0\nMARKER/20, PART=2\n\
                 JOINT/1, REVOLUTE, I=20, J=1\n";
    let function =
        format!("SFORCE/1, ROTATIONAL, ACTIONONLY, I=20, J=1, FUNCTION={moment}-{k}*(AZ(20,1)-3)");
    let bushing = format!(
        "BUSHING/1, I=20, J=1, K=0,0,0, KT=0,0,{k}\nSFORCE/1, ROTATIONAL, ACTIONONLY, I=20, J=1, FUNCTION={}",
        moment + 3.0 * k
    );
    for law in [function, bushing] {
        let solved = solve(&format!("{lever}{law}"));
        // The angle goes from 3 to 3.5, which a rotation matrix shows as 3.5 - 2 pi.
        close(
            turn(&solved, 2),
            3.0 + moment / k - 2.0 * std::f64::consts::PI,
            1e-9,
        );
    }
}
