//! Simulations over time through `mdi`: comparisons with real ADAMS and closed forms, sensors, and sequences of simulations.

use std::fmt::Write as _;
use std::path::Path;

use admire_results::RequestFile;
use admire_syntax::text::Source;

use crate::common::shared;
use crate::run::{Ran, Results, folder, mdi};

/// Returns the requests of a run as (time, values of all requests).
fn requests(folder: &Path, name: &str) -> Vec<(f64, Vec<[f64; 6]>)> {
    let source = Source::new(name, std::fs::read(folder.join(name)).unwrap());
    let file = RequestFile::parse(&source).value;
    file.times.into_iter().zip(file.values).collect()
}

/// Returns the rows of a table of the joint cases: time, then values.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .filter(|line| line.starts_with(['+', '-']))
        .map(|line| {
            line.split_whitespace()
                .map(|x| x.parse().unwrap())
                .collect()
        })
        .collect()
}

/// A joint case with its relative tolerances: `position` for positions and velocities, `force` for accelerations and forces.
struct Case {
    name: &'static str,
    tables: &'static str,
    commands: &'static str,
    moved: f64,
    position: f64,
    force: f64,
}

/// Joint cases with tables from real ADAMS.
///
/// The tables of the spherical and universal joint lose 8e-3 J of 20 J in five seconds. They deviate from the closed form of the pendulum
/// by up to 4e-4 of its range, unlike the table of the revolute joint of the same pendulum. The tables of the two springs belong to other
/// constants than the decks; the commands set the constants found from the tables (torque 200 az + 10 wz, force 10 z + 0.5 vz).
const CASES: [Case; 8] = [
    Case {
        name: "Revolute",
        tables: "Revolute",
        commands: "",
        moved: 0.0,
        position: 1e-5,
        force: 1e-3,
    },
    Case {
        name: "Prismatic",
        tables: "Prismatic",
        commands: "",
        moved: 0.0,
        position: 1e-5,
        force: 1e-3,
    },
    Case {
        name: "Cylindrical",
        tables: "Cylindrical",
        commands: "",
        moved: 0.0,
        position: 1e-5,
        force: 1e-3,
    },
    Case {
        name: "Distance",
        tables: "Distance",
        commands: "",
        moved: 0.0,
        position: 1e-5,
        force: 1e-3,
    },
    Case {
        name: "Spherical",
        tables: "Spherical",
        commands: "",
        moved: 0.0,
        position: 5e-4,
        force: 1e-3,
    },
    Case {
        name: "Universal",
        tables: "Universal",
        commands: "",
        moved: 0.0,
        position: 5e-4,
        force: 1e-3,
    },
    Case {
        name: "RotSpring",
        tables: "RotSpring",
        commands: "SFORCE/1, FUNCTION=-200*AZ(207,208)-10*WZ(207,208,208)\n",
        moved: 0.0,
        position: 3e-5,
        force: 1e-3,
    },
    Case {
        name: "TransSpring",
        tables: "TranSpring",
        commands: "PART/2, QG=0,-2,-1\nSFORCE/1, FUNCTION=-10*(DM(204,205)-1)-0.5*VR(204,205)\n",
        moved: -1.0,
        position: 1e-5,
        force: 1e-3,
    },
];

#[test]
fn joints_move_as_real_adams_has_it() {
    let Some(decks) = shared("real-dynamics/chrono-joints") else {
        return;
    };
    let mut told = String::new();
    for case in &CASES {
        let deck =
            std::fs::read_to_string(decks.join(format!("test_{}_Case01.adm", case.name))).unwrap();
        let acf = format!(
            "\nfile/model=m\n{}INTEGRATOR/GSTIFF, ERROR=1e-8\nSIMULATE/DYNAMIC, END=5, STEPS=500\nstop\n",
            case.commands
        );
        let folder = folder(&[("m.adm", &deck), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}: {}", case.name, ran.stdout);
        let ours = requests(folder.path(), "m.req");
        assert_eq!(ours.len(), 501, "{}", case.name);
        let table =
            |what: &str| rows(&decks.join(format!("{}_Case01_ADAMS_{what}.txt", case.tables)));
        let peak = |rows: &[Vec<f64>]| {
            let all = rows.iter().flat_map(|row| &row[1..]);
            all.fold(0.0_f64, |a, b| a.max(b.abs()))
        };
        let force = peak(&table("Rforce"));
        for (what, request, first) in [
            ("Pos", 0, 0),
            ("Vel", 1, 0),
            ("Avel", 1, 3),
            ("Acc", 2, 0),
            ("Aacc", 2, 3),
            ("Rforce", 4, 0),
            ("Rtorque", 4, 3),
        ] {
            // The request of the sprung joint is the torque of its spring.
            if case.name == "RotSpring" && what == "Rforce" {
                continue;
            }
            let theirs = table(what);
            for c in 0..3 {
                let column = || theirs.iter().map(|row| row[1 + c]);
                let most = column().fold(0.0_f64, |a, b| a.max(b.abs()));
                let (low, high) =
                    column().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
                let allowed = if request < 2 {
                    // One unit of the last of the six digits of a `.req`.
                    let digit = 10f64.powf(most.max(1e-6).log10().floor() - 5.0);
                    (case.position * (high - low)).max(digit).max(1e-10)
                } else {
                    case.force * most.max(1e-3 * force)
                };
                let shift = if what == "Pos" && c == 2 {
                    case.moved
                } else {
                    0.0
                };
                for (row, (time, values)) in theirs.iter().zip(&ours) {
                    assert!((row[0] - time).abs() < 1e-9);
                    let apart = (row[1 + c] - (values[request][first + c] - shift)).abs();
                    if apart > allowed.max(1e-9) {
                        writeln!(
                            told,
                            "{} {what} {c} at {time}: {} and {}, {apart:.2e} of {allowed:.2e}",
                            case.name,
                            row[1 + c],
                            values[request][first + c]
                        )
                        .unwrap();
                        break;
                    }
                }
            }
        }
    }
    assert!(told.is_empty(), "{told}");
}

/// Checks `photocaber/adams5`, a velocity-driven chain of nineteen joints with nineteen redundant equations, in the motions determined by
/// the drive.
#[test]
fn a_driven_chain_moves_as_real_adams_has_it() {
    let Some(from) = shared("real-dynamics/photocaber") else {
        return;
    };
    let deck = std::fs::read_to_string(from.join("adams5.adm")).unwrap();
    let acf = "\nfile/model=adams5\nSIMULATE/DYNAMIC, END=5, DTOUT=0.04\nstop\n";
    let folder = folder(&[("adams5.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(
        ran.stdout
            .matches("deactivating constraint equation")
            .count(),
        19
    );
    let theirs = Results::read_all(&from, "adams5.res");
    let ours = Results::read_all(folder.path(), "adams5.res");
    for part in [
        "p0-1",
        "p1-1",
        "a1103zc-2",
        "cro1-1",
        "cro2-1",
        "cro3-1",
        "plaform-1",
    ] {
        for (component, allowed) in [("X", 1e-8), ("Y", 1e-8), ("Z", 1e-8)] {
            let entity = format!("{part}_XFORM");
            let (a, b) = (
                theirs.column(&entity, component),
                ours.column(&entity, component),
            );
            assert_eq!(a.len(), b.len(), "{part}");
            let apart = a
                .iter()
                .zip(&b)
                .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            // The spin of the platform and its crosses is not driven; it starts as in ADAMS and then drifts by integration error.
            let free = ["cro2-1", "cro3-1", "plaform-1"].contains(&part);
            let allowed = if free { 2e-3 } else { allowed };
            assert!(apart < allowed, "{part} {component}: {apart:e}");
        }
    }
    // Velocities determined by the drive, relative to their peak; the file is in degrees. The drive turns at 600 degrees per second, but
    // the real file contains up to 602: its velocities deviate by 0.33 percent. Its first output deviates by more, as the
    // velocity of a fixed point shows.
    let deviation = |part: &str, components: [&str; 3], unit: f64| {
        let entity = format!("{part}_XFORM");
        let (mut peak, mut apart) = (0.0_f64, vec![0.0_f64; theirs.steps.len()]);
        for component in components {
            let pairs = theirs
                .column(&entity, component)
                .into_iter()
                .zip(ours.column(&entity, component));
            for ((a, b), apart) in pairs.zip(&mut apart) {
                peak = peak.max(a.abs());
                *apart = apart.max((a - unit * b).abs());
            }
        }
        let first = apart.iter().take(2).fold(0.0_f64, |a, b| a.max(*b));
        let rest = apart.iter().skip(2).fold(0.0_f64, |a, b| a.max(*b));
        (first / peak, rest / peak)
    };
    let (first, rest) = deviation("p1-1", ["VX", "VY", "VZ"], 1.0);
    assert!(first < 1e-2 && rest < 3e-3, "{first:e} {rest:e}");
    for part in ["p0-1", "a1103zc-2"] {
        let (first, rest) = deviation(part, ["WX", "WY", "WZ"], 1.0_f64.to_degrees());
        assert!(first < 4e-3 && rest < 4e-3, "{part}: {first:e} {rest:e}");
    }
}

const BALL: &str = "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
ACCGRAV/KGRAV=-9.81
";

fn ball(statements: &str, commands: &str) -> (Results, Ran) {
    let deck = format!("{BALL}{statements}RESULTS/XRF\nOUTPUT/REQSAVE\nEND\n");
    let acf = format!("\nfile/model=ball\n{commands}\nstop\n");
    let folder = folder(&[("ball.adm", &deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read_all(folder.path(), "ball.res"), ran)
}

fn near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() < error, "{found} and {expected}");
}

/// Checks a drop from 1 m onto k = 1e4: penetration .045286331067, contact .031858798828 s, period .934906080799 s.
#[test]
fn a_ball_bounces_by_the_closed_form() {
    let force = "SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=IMPACT(DZ(20,1),VZ(20,1),0,1E4,1,0,1E-3)\n";
    let (results, ran) = ball(
        force,
        "INTEGRATOR/ERROR=1E-8\nSIM/DYN, END=0.934906080799, STEPS=400\nSIM/DYN, END=1.869812161598, STEPS=4000",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let z = results.column("PART_2_XFORM", "Z");
    let v = results.column("PART_2_XFORM", "VZ");
    // The ball is at the top again after one period and after two.
    near(z[400], 1.0, 1e-6);
    near(v[400], 0.0, 1e-5);
    near(*z.last().unwrap(), 1.0, 2e-6);
    let deepest = z.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    near(deepest, -0.045286331067, 1e-5);
}

/// Checks a sensor: falling 1 m takes sqrt(2/g); the sensor fires during the fall, ends the simulation, and the next one continues from
/// there.
#[test]
fn a_sensor_fires_at_its_time() {
    let sensor = "SENSOR/1, LE, VALUE=0.25, ERROR=1E-6, RETURN, FUNCTION=DZ(20,1), EVALUATE=TIME\nREQUEST/1, F2=SENVAL(1)\n";
    let (results, ran) = ball(
        sensor,
        "SIM/DYN, END=1, DTOUT=0.1\nDEACTIVATE/SENSOR, ID=1\nSIM/DYN, DURATION=0.1, DTOUT=0.1",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let fall = (2.0 * 0.75 / 9.81_f64).sqrt();
    assert!(
        ran.stdout
            .contains(&format!("Sensor/1 has become active at time = {fall:.6}.")),
        "{}",
        ran.stdout
    );
    assert!(ran.stdout.contains("   Triggered action RETURN."));
    let times = results.column("time", "TIME");
    near(times[3], 0.3, 1e-12);
    near(times[4], fall + 0.1, 1e-6);
    let end = fall + 0.1;
    near(
        results.column("PART_2_XFORM", "Z")[4],
        1.0 - 0.5 * 9.81 * end * end,
        1e-6,
    );
}

/// Checks MOTIONs by velocity, acceleration and displacement, which give the same motion.
#[test]
fn rates_of_motions_are_integrated() {
    for motion in [
        "MOTION/1, JOINT=1, TRANSLATIONAL, VELOCITY, FUNCTION=0.3*COS(TIME)",
        "MOTION/1, JOINT=1, TRANSLATIONAL, ACCELERATION, ICVEL=0.3, FUNCTION=-0.3*SIN(TIME)",
        "MOTION/1, JOINT=1, TRANSLATIONAL, FUNCTION=1+0.3*SIN(TIME)",
    ] {
        let (results, ran) = ball(&format!("{motion}\n"), "SIM/TRANSIENT, END=2, STEPS=20");
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        assert!(ran.stdout.contains("Performing Kinematic Simulation"));
        let times = results.column("time", "TIME");
        for (k, t) in times.iter().enumerate() {
            near(
                results.column("PART_2_XFORM", "Z")[k],
                1.0 + 0.3 * t.sin(),
                1e-10,
            );
            near(
                results.column("PART_2_XFORM", "VZ")[k],
                0.3 * t.cos(),
                1e-10,
            );
            near(
                results.column("PART_2_XFORM", "ACCZ")[k],
                -0.3 * t.sin(),
                1e-8,
            );
            // The motion carries weight and inertia.
            let force = results.column("MOTION_1", "FZ")[k];
            near(force, 9.81 - 0.3 * t.sin(), 1e-7);
        }
    }
    // For DYNAMIC without degrees of freedom, ADAMS' warning is issued and the results are the same.
    let (results, ran) = ball(
        "MOTION/1, JOINT=1, FUNCTION=1+0.3*SIN(TIME)\n",
        "SIM/DYNAMIC, END=2, STEPS=20",
    );
    assert!(
        ran.stdout
            .contains("The data set is kinematically determinate."),
        "{}",
        ran.stdout
    );
    near(
        results.column("PART_2_XFORM", "Z")[20],
        1.0 + 0.3 * 2f64.sin(),
        1e-10,
    );
}

/// Checks x'' = -g - c x' on a spring with initial velocities, over two consecutive simulations.
#[test]
fn simulations_follow_each_other() {
    let (results, ran) = ball(
        "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=30, K=100, C=2, LENGTH=0.5\nMARKER/30, PART=1, QP=0,0,2\nPART/3, MASS=1, CM=40, IP=1,1,1, QG=5,0,0, VX=2, WZ=3\nMARKER/40, PART=3\n",
        "SIM/DYN, END=0.5, STEPS=50\nSIM/DYN, END=1, STEPS=50",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    // Times: the initial conditions, then every output once.
    let times = results.column("time", "TIME");
    assert_eq!(times.len(), 101);
    // m x'' = -m g + k (s - 0.5) - c x', s = 2 - x, from rest at 1.
    let (k, c, g) = (100.0, 2.0, 9.81);
    let rest = 1.5 - g / k;
    let w = (k - c * c / 4.0_f64).sqrt();
    let exact = |t: f64| {
        let d = 1.0 - rest;
        rest + d * (-c * t / 2.0).exp() * ((w * t).cos() + c / 2.0 / w * (w * t).sin())
    };
    for (at, t) in times.iter().enumerate() {
        near(results.column("PART_2_XFORM", "Z")[at], exact(*t), 2e-4);
        near(results.column("PART_3_XFORM", "X")[at], 5.0 + 2.0 * t, 1e-9);
    }
}

#[test]
fn bad_motions_end_with_time_element_and_reason() {
    // A function that leaves its domain.
    let (results, ran) = ball(
        "SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=SQRT(DZ(20,1)-0.5)\n",
        "SIM/DYN, END=1, STEPS=100",
    );
    assert!(
        ran.stdout.contains("SFORCE/1") && ran.stdout.contains("[no-motion]"),
        "{}",
        ran.stdout
    );
    let times = results.column("time", "TIME");
    assert!(
        times.len() > 20 && *times.last().unwrap() < 0.4,
        "{times:?}"
    );
    // A missing mass.
    let (_, ran) = ball(
        "PART/3, MASS=0, CM=40, QG=1,0,0\nMARKER/40, PART=3\n",
        "SIM/DYN, END=1, STEPS=10",
    );
    assert!(
        ran.stdout.contains("PART/3") && ran.stdout.contains("singular"),
        "{}",
        ran.stdout
    );
    // Contradictory constraints.
    let (_, ran) = ball(
        "MOTION/1, JOINT=1, FUNCTION=1\nMOTION/2, I=20, J=1, Z, FUNCTION=2\n",
        "SIM/DYN, END=1, STEPS=10",
    );
    assert!(ran.stdout.contains("violated"), "{}", ran.stdout);
    // Elements that are not supported in motion are refused by name, and statics continues.
    let (_, ran) = ball(
        "FRICTION/1, JOINT=1, FORMULATION=LUGRE, MU_STATIC=0.1, MU_DYNAMIC=0.1, INACTIVE=STATIC\n",
        "SIM/DYN, END=1, STEPS=10\nSPRINGDAMPER/9, K=1",
    );
    assert!(
        ran.stdout.contains("FRICTION/1") && ran.code == 1,
        "{}",
        ran.stdout
    );
}

#[test]
fn the_table_of_a_simulation_has_its_rows() {
    let (_, ran) = ball("", "SIM/DYN, END=1, STEPS=25");
    let from = ran.stdout.find("   0.00000E+00").unwrap();
    let rows: Vec<&str> = ran.stdout[from..]
        .lines()
        .take_while(|line| line.contains("E+0") || line.contains("E-0"))
        .collect();
    // The start, every second output, and the last one.
    assert_eq!(rows.len(), 14, "{rows:#?}");
    assert!(ran.stdout.contains("Radau IIA order 5"));
}

/// Returns the eigenvalues of a run as (real, imaginary) in radians per time, with one of each complex pair.
fn eigenvalues(deck: &str, commands: &str) -> (Vec<(f64, f64)>, Ran) {
    let acf = format!("\nfile/model=small\n{commands}\nstop\n");
    let folder = folder(&[("small.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let text = std::fs::read(folder.path().join("small.modes.json"));
    let text = text.unwrap_or_else(|_| panic!("{}", ran.stdout));
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let number = |mode: &serde_json::Value, key: &str| mode[key].as_f64().unwrap();
    let modes = value["modes"].as_array().unwrap();
    let found = modes
        .iter()
        .map(|mode| (number(mode, "real"), number(mode, "imaginary")))
        .collect();
    (found, ran)
}

/// Checks eigenvalues against closed forms.
///
/// The block on a spring has -1 +- i sqrt(99), without damping +- 10 i. A sleeping top with A = 0.3 about its tip, C = 0.1, m g l = 4.905
/// and spin 60 has the roots of A s^2 - i C 60 s - m g l.
#[test]
fn eigenvalues_are_those_of_closed_forms() {
    let block = format!(
        "{BALL}SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=30, K=100, C=2, LENGTH=0.5\nMARKER/30, PART=1, QP=0,0,2\nEND\n"
    );
    let (found, ran) = eigenvalues(&block, "SIM/STAT\nLINEAR/EIGENSOL");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(found.len(), 1, "{found:?}");
    near(found[0].0, -1.0, 1e-9);
    near(found[0].1, 99f64.sqrt(), 1e-9);
    assert!(ran.stdout.contains("UNDAMPED NATURAL"));
    let (found, _) = eigenvalues(&block, "SIM/STAT\nLINEAR/EIGENSOL, NODAMPIN");
    near(found[0].1, 10.0, 1e-9);
    let (found, ran) = sleeping_top(60.0);
    let sizes: Vec<f64> = found.iter().map(|v| v.1).collect();
    for expected in [0.85396260668, 19.14603739332] {
        let off = sizes
            .iter()
            .fold(f64::MAX, |m, v| m.min((v - expected).abs()));
        assert!(off < 1e-6, "{found:?} {}", ran.stdout);
    }
}

/// Returns the eigenvalues of an upright (sleeping) top.
fn sleeping_top(spin: f64) -> (Vec<(f64, f64)>, Ran) {
    let top = format!(
        "top
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=0.05,0.05,0.1, WX=0, WY=0, WZ={spin}
MARKER/20, PART=2, QP=0,0,0.5
MARKER/21, PART=2
JOINT/1, SPHERICAL, I=21, J=1
ACCGRAV/KGRAV=-9.81
END
"
    );
    eigenvalues(&top, "SIM/INITIAL_CONDITIONS\nLINEAR/EIGENSOL")
}

/// Checks that the top is unstable below a spin of 24.26107994: `s = i C w / 2 A +- sqrt(m g l / A - (C w / 2 A)^2)` and their conjugates.
#[test]
fn a_slow_top_falls() {
    for spin in [5.0, 20.0, 24.2, 24.26107, 24.26109, 25.0] {
        let (found, ran) = sleeping_top(spin);
        let turn: f64 = 0.1 * spin / 0.6;
        let square = 4.905 / 0.3 - turn * turn;
        let (growth, apart) = (square.max(0.0).sqrt(), (-square).max(0.0).sqrt());
        let moving: Vec<_> = found.iter().filter(|v| v.0.hypot(v.1) > 1e-6).collect();
        for (real, imaginary) in [
            (growth, turn + apart),
            (growth, turn - apart),
            (-growth, turn + apart),
            (-growth, turn - apart),
        ] {
            // Near the limit two eigenvalues nearly coincide, so that their error is the square root of the round-off.
            let off = moving
                .iter()
                .fold(f64::MAX, |m, v| m.min((v.0 - real).hypot(v.1 - imaginary)));
            assert!(off < 1e-6, "{spin}: {found:?} {}", ran.stdout);
        }
        let grow = moving.iter().any(|v| v.0 > 1e-4);
        assert_eq!(grow, square > 0.0, "{spin}: {found:?}");
    }
}

/// Checks that joints start at their IC, in position and rate, and that a driven joint more than half a turn away starts at the nearest
/// turn.
#[test]
fn joints_begin_where_they_are_told() {
    let bar = "bar
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=0.1,0.1,0.1
MARKER/20, PART=2, QP=1,0,0
MARKER/21, PART=2
RESULTS/XRF
";
    let begin = |statements: &str| {
        let deck = format!("{bar}{statements}END\n");
        let acf = "\nfile/model=bar\nSIM/DYN, END=1, STEPS=10\nstop\n";
        let folder = folder(&[("bar.adm", &deck), ("run.acf", acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        Results::read_all(folder.path(), "bar.res")
    };
    let results = begin("JOINT/1, REVOLUTE, I=21, J=1, IC=30D, 0.2\n");
    for (at, t) in results.column("time", "TIME").iter().enumerate() {
        near(
            results.column("PART_2_XFORM", "PSI")[at],
            30f64.to_radians() + 0.2 * t,
            1e-9,
        );
        near(results.column("PART_2_XFORM", "WZ")[at], 0.2, 1e-9);
    }
    let results = begin(
        "JOINT/1, REVOLUTE, I=21, J=1\nMOTION/1, JOINT=1, VELOCITY, ICDISP=3.5, FUNCTION=0.1\n",
    );
    let last = *results.column("PART_2_XFORM", "PSI").last().unwrap();
    near(last, 3.6 - std::f64::consts::TAU, 1e-9);
}
