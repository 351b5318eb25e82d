//! Velocity GCONs through `mdi`: rolling and sliding without slip, in millimetres, compared with closed forms; and refusals by name.

use std::path::Path;

use admire_results::RequestFile;
use admire_syntax::text::Source;

use crate::run::{Ran, Results, folder, mdi_with, text};

/// A uniform ball of 2 kg and 50 mm radius on a plane, pulled with 7 N along x.
const BALL: &str = "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
ACCGRAV/KGRAV=-9810
PART/1, GROUND
MARKER/1, PART=1
MARKER/2, PART=1, QP=0,0,50
PART/2, MASS=2, CM=20, IP=2000,2000,2000, QG=0,0,50
MARKER/20, PART=2
JPRIM/1, INPLANE, I=20, J=2
!                            adams_view_name='roll'
GCON/1, I=20, FUNCTION=VX(20)-50*WY(20)
GCON/2, I=20, FUNCTION=VY(20)+50*WX(20)
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=3, FUNCTION=7
MARKER/3, PART=1, QP=0,0,50, REULER=90D,90D,0
REQUEST/1, FORCE, I=20, J=1
RESULTS/FORMATTED, XRF
OUTPUT/REQSAVE
";

fn run(deck: &str, commands: &str, strict: bool) -> (tempfile::TempDir, Ran) {
    let acf = format!("\nfile/model=ball\n{commands}\nstop\n");
    let folder = folder(&[("ball.adm", &format!("{deck}END\n")), ("run.acf", &acf)]);
    let strict: &[_] = if strict { &[("MDI_STRICT", "1")] } else { &[] };
    let ran = mdi_with(folder.path(), &["ru-s", "run"], "", strict);
    (folder, ran)
}

fn requests(folder: &Path) -> Vec<Vec<[f64; 6]>> {
    let source = Source::new("ball.req", std::fs::read(folder.join("ball.req")).unwrap());
    RequestFile::parse(&source).value.values
}

/// Checks the acceleration 5 F / 7 m and the friction 2 F / 7 that rotates the ball, in the results and in the request of the marker.
#[test]
fn a_ball_rolls_as_the_closed_form_has_it() {
    rolls(BALL);
}

/// Checks rolling with variables in place of the velocities: the reaction acts on the quantities that the variables measure.
#[test]
fn variables_stand_for_what_they_read() {
    let through = BALL
        .replace("=VX(20)-50*WY(20)", "=VARVAL(1)-VARVAL(2)")
        .replace("=VY(20)+50*WX(20)", "=VY(20)+VARVAL(3)");
    assert_ne!(through, BALL);
    let variables = "VARIABLE/1, FUNCTION=VX(20)\nVARIABLE/2, FUNCTION=50*VARVAL(4)\nVARIABLE/3, FUNCTION=50*WX(20)\nVARIABLE/4, FUNCTION=WY(20)\n";
    rolls(&(through + variables));
}

/// Checks a GCON on a variable in statics and kinematics: it holds a block against its weight, and lowers it over time.
#[test]
fn a_variable_holds_its_place_in_statics_and_kinematics() {
    let deck = "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,2.9
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
VARIABLE/1, FUNCTION=DZ(20)+0.1*VARVAL(2)
VARIABLE/2, FUNCTION=TIME
GCON/1, I=20, FUNCTION=VARVAL(1)-3
ACCGRAV/KGRAV=-9.81
REQUEST/1, FORCE, I=20
REQUEST/2, F2=DZ(20)
OUTPUT/REQSAVE
";
    let commands = "SIM/STAT, END=1, STEPS=2\nSIM/KIN, END=2, STEPS=2";
    let (folder, ran) = run(deck, commands, true);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let rows = requests(folder.path());
    assert!(rows.len() >= 5, "{rows:?}");
    for row in &rows {
        assert!((row[0][2] - 9.81).abs() < 1e-4, "{row:?}");
    }
    let places: Vec<f64> = rows.iter().map(|row| row[1][0]).collect();
    assert!((places[0] - 3.0).abs() < 1e-5, "{places:?}");
    let last = places.last().unwrap();
    assert!((last - 2.8).abs() < 1e-5, "{places:?}");
}

/// Checks that a ball of the deck BALL rolls from rest.
fn rolls(deck: &str) {
    let (folder, ran) = run(
        deck,
        "INTEGRATOR/ERROR=1E-7\nSIM/DYN, END=1, STEPS=20",
        true,
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read_all(folder.path(), "ball.res");
    let acceleration = 5.0 / 7.0 * 7000.0 / 2.0;
    let times = results.column("time", "TIME");
    let part = |component: &str| results.column("PART_2_XFORM", component);
    let (x, vx, wy, ax) = (part("X"), part("VX"), part("WY"), part("ACCX"));
    let friction = results.column("roll", "FX");
    let torque = results.column("roll", "TY");
    assert_eq!(times.len(), 21);
    for (k, t) in times.iter().enumerate() {
        let near = |found: f64, known: f64, error: f64| {
            assert!((found - known).abs() < error, "{t}: {found} {known}");
        };
        near(x[k], 0.5 * acceleration * t * t, 1e-3);
        near(vx[k], acceleration * t, 1e-3);
        near(wy[k] * 50.0, vx[k], 1e-6);
        near(ax[k], acceleration, 1e-6);
        near(friction[k], -2.0, 1e-9);
        // 2 N act at the contact 50 mm below the centre.
        near(torque[k], 100.0, 1e-7);
    }
    // The request of marker 20 shows the forces of its GCONs.
    for row in requests(folder.path()) {
        let [fx, fy, _, _, ty, _] = row[0];
        assert!(
            (fx + 2.0).abs() < 1e-4 && fy.abs() < 1e-4 && (ty - 100.0).abs() < 1e-3,
            "{row:?}"
        );
    }
}

/// Checks a driven wheel whose angle is prescribed while its path is not: no freedom is left, and the path is integrated.
#[test]
fn a_driven_wheel_goes_its_way() {
    let wheel = BALL.replace(
        "SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=3, FUNCTION=7\n",
        "",
    ) + "JPRIM/2, INPLANE, I=20, J=4\nMARKER/4, PART=1, REULER=0,90D,0\nMARKER/5, PART=2, REULER=0,90D,0\nJPRIM/3, PARALLEL, I=5, J=4\nMOTION/1, I=5, J=4, B3, FUNCTION=-TIME**2\n";
    for kind in ["DYN", "TRANS"] {
        let commands = format!("INTEGRATOR/ERROR=1E-6\nSIM/{kind}, END=2, STEPS=10");
        let (folder, ran) = run(&wheel, &commands, true);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let results = Results::read_all(folder.path(), "ball.res");
        let x = results.column("PART_2_XFORM", "X");
        let friction = results.column("roll", "FX");
        for ((t, x), friction) in results.column("time", "TIME").iter().zip(x).zip(friction) {
            assert!((x - 50.0 * t * t).abs() < 1e-3, "{t}: {x}");
            assert!(
                (friction - 2.0 * 100.0 * 1e-3).abs() < 1e-9,
                "{t}: {friction}"
            );
        }
    }
    let (folder, ran) = run(&wheel, "SIM/KIN, END=2, STEPS=10", true);
    assert_eq!(ran.code, 3, "{}", ran.stdout);
    let told = text(folder.path(), "ball.msg");
    assert!(told.contains("constrains velocities"), "{told}");
}

/// Checks that statics ignores the GCON with a message, and that a following motion applies it again.
#[test]
fn statics_leaves_it_out_by_name() {
    let held = BALL.to_string()
        + "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=6, K=1, C=0, LENGTH=100\nMARKER/6, PART=1, QP=-100,0,50\nBUSHING/1, I=20, J=2, K=0,1,0, KT=1E5,1E5,1E5\n";
    let (folder, ran) = run(&held, "SIM/STAT\nSIM/DYN, END=0.1, STEPS=10", false);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("GCON/1 'roll' constrains velocities"),
        "{}",
        ran.stdout
    );
    let results = Results::read_all(folder.path(), "ball.res");
    let x = results.column("PART_2_XFORM", "X");
    assert!((x[0] - 7.0).abs() < 1e-6, "{x:?}");
    let friction = results.column("roll", "FX");
    for friction in friction {
        assert!(friction.abs() < 1e-6, "at rest: {friction}");
    }
}

/// Checks that functions are refused by name if they are nonlinear in the velocities or read more than positions, velocities and time.
#[test]
fn others_are_refused_by_name() {
    for (function, told) in [
        ("VM(20)-3", "is not linear in the velocities"),
        ("VX(20)*WY(20)", "is not linear in the velocities"),
        ("1/(2+VX(20))-0.5", "is not linear in the velocities"),
        ("STEP(VX(20),0,0,1,1)", "is not linear in the velocities"),
        ("IF(VX(20):0,0,1)", "is not linear in the velocities"),
        ("VX(20)-ACCX(20)", "reads a velocity or an acceleration"),
        ("VX(20)*VARVAL(9)", "is not linear in the velocities"),
        ("VX(20)-VARVAL(8)", "reads a variable that reads itself"),
        (
            "VX(20)-DIF(9)",
            "reads a dynamic state that depends on accelerations",
        ),
        (
            "DX(20)-DIF(8)",
            "reads a dynamic state that depends on velocities",
        ),
        (
            "DX(20)-DIF(7)",
            "reads a dynamic state that depends on forces",
        ),
        ("DX(20)-DIF(6)", "reads an implicit dynamic state"),
        ("DX(20)-DIF1(8)", "reads the rate of a dynamic state"),
        ("VX(20)-SFORCE(1,0,3,0)", "reads a force"),
    ] {
        let deck = BALL.to_string()
            + &format!(
                "GCON/3, FUNCTION={function}
VARIABLE/8, FUNCTION=DX(20)+0.5*VARVAL(8)
VARIABLE/9, FUNCTION=WY(20)
DIFF/6, IC=0, IMPLICIT, FUNCTION=DIF1(6)-DX(20)
DIFF/7, IC=0, FUNCTION=SFORCE(1,0,3,0)
DIFF/8, IC=0, FUNCTION=VARVAL(9)
DIFF/9, IC=0, FUNCTION=ACCX(20)
"
            );
        let (folder, ran) = run(&deck, "SIM/DYN, END=1, STEPS=10", true);
        assert_eq!(ran.code, 1, "{}", ran.stdout);
        let message = text(folder.path(), "ball.msg") + &ran.stdout;
        assert!(
            message.contains("GCON/3") && message.contains(told),
            "{function}: {message}"
        );
    }
}

/// Checks deactivation and reactivation: after reactivation the velocities satisfy the GCON at once.
#[test]
fn it_is_switched_off_and_on() {
    let commands = "DEACT/GCON, ID=1\nDEACT/GCON, ID=2\nSIM/DYN, END=0.5, STEPS=5\nACT/GCON, ID=1\nACT/GCON, ID=2\nSIM/DYN, END=1, STEPS=5";
    let (folder, ran) = run(BALL, commands, true);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read_all(folder.path(), "ball.res");
    let part = |component: &str| results.column("PART_2_XFORM", component);
    let (time, vx, wy) = (results.column("time", "TIME"), part("VX"), part("WY"));
    let free = 7000.0 / 2.0 * 0.5;
    // The velocity jump conserves m v r + I w about the contact, with I = 2 m r^2 / 5.
    let after = free / 1.4;
    for (k, t) in time.iter().enumerate() {
        let (v, w) = if *t < 0.5 + 1e-9 {
            (7000.0 / 2.0 * t, 0.0)
        } else {
            let v = after + 2500.0 * (t - 0.5);
            (v, v / 50.0)
        };
        assert!((vx[k] - v).abs() < 1e-2, "{t}: {} {v}", vx[k]);
        assert!((wy[k] - w).abs() < 1e-3, "{t}: {} {w}", wy[k]);
    }
}

/// Checks a spring of 1 N/mm on the centre: the stiffness acts on 7/5 of the mass, by EIGENSOL and in the state matrices.
///
/// The rates of the states are three of the five freedoms.
#[test]
fn a_ball_on_a_spring_swings_as_it_rolls() {
    let deck = BALL.replace("FUNCTION=7\n", "FUNCTION=VARVAL(1)\n")
        + "SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=6, K=1, C=0, LENGTH=100
MARKER/6, PART=1, QP=-100,0,50
VARIABLE/1, FUNCTION=0
VARIABLE/2, FUNCTION=DX(20)
PINPUT/1, VARIABLES=1
POUTPUT/1, VARIABLES=2
";
    let commands =
        "SIM/STAT\nLINEAR/EIGENSOL\nLINEAR/STATEMAT, PINPUT=1, POUTPUT=1, FILE=mat, FORMAT=MATLAB";
    let (folder, ran) = run(&deck, commands, false);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let square = 1000.0 / (1.4 * 2.0);
    let modes: serde_json::Value =
        serde_json::from_str(&text(folder.path(), "ball.modes.json")).unwrap();
    let rates = modes["modes"].as_array().unwrap().iter();
    let rates: Vec<f64> = rates.map(|m| m["imaginary"].as_f64().unwrap()).collect();
    let last = rates.last().unwrap();
    assert!((last - f64::sqrt(square)).abs() < 1e-9, "{rates:?}");
    let states = text(folder.path(), "matst");
    assert_eq!(states.lines().count(), 8, "{states}");
    let a = text(folder.path(), "mata");
    let numbers = a.split_whitespace().map(|x| x.parse::<f64>().unwrap());
    let least = numbers.fold(0.0, f64::min);
    assert!((least + square).abs() < 1e-9, "{a}");
}

/// Checks that a controller's state can prescribe a speed or a position through a GCON or a MOTION, compared with a closed form.
///
/// Acceleration and force are checked too. Few steps suffice because the error estimate uses the rate of the state. EIGENSOL refuses the
/// model by name.
#[test]
fn states_drive_what_is_held() {
    let block = |constraint: &str| {
        format!(
            "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=2, CM=20, IP=1,1,1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
DIFF/1, IC=0, FUNCTION=2*VARVAL(1)
DIFF/2, IC=30, FUNCTION=-2*DIF(1)
VARIABLE/1, FUNCTION=DIF(2)
VARIABLE/2, FUNCTION=DIF(1)
!                            adams_view_name='drive'
{constraint}
RESULTS/FORMATTED, XRF
"
        )
    };
    let f = 2.0_f64;
    for (constraint, rate) in [
        ("MOTION/1, JOINT=1, FUNCTION=DIF(1)", 0),
        ("MOTION/1, JOINT=1, FUNCTION=VARVAL(2)", 0),
        ("GCON/1, I=20, FUNCTION=DZ(20)-VARVAL(2)", 0),
        ("GCON/1, I=20, FUNCTION=VARVAL(2)-VZ(20)", 1),
    ] {
        let commands = "INTEGRATOR/ERROR=1E-6, HMAX=0.25\nSIM/DYN, END=1, STEPS=20";
        let (folder, ran) = run(&block(constraint), commands, true);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let results = Results::read_all(folder.path(), "ball.res");
        let part = |component: &str| results.column("PART_2_XFORM", component);
        let (z, v, a) = (part("Z"), part("VZ"), part("ACCZ"));
        let force = results.column("drive", "FZ");
        for (k, t) in results.column("time", "TIME").iter().enumerate() {
            // 30 sin(f t) is the position or the speed.
            let (sin, cos) = (f * t).sin_cos();
            let known = if rate == 0 {
                [30.0 * sin, 30.0 * f * cos, -30.0 * f * f * sin]
            } else {
                [30.0 / f * (1.0 - cos), 30.0 * sin, 30.0 * f * cos]
            };
            for (found, known) in [z[k], v[k], a[k]].into_iter().zip(known) {
                assert!(
                    (found - known).abs() < 3e-4,
                    "{constraint} {t}: {found} {known}"
                );
            }
            assert!((force[k] - 2e-3 * a[k]).abs() < 1e-9, "{constraint} {t}");
        }
        let table = text(folder.path(), "ball.msg");
        let last = table
            .lines()
            .find(|line| line.starts_with("   1.00000E+00"));
        let steps = last.and_then(|line| line.split_whitespace().nth(3)?.parse::<u32>().ok());
        assert!(
            steps.is_some_and(|steps| steps < 80),
            "{constraint}: {last:?}"
        );
        let (folder, ran) = run(&block(constraint), "LINEAR/EIGENSOL", true);
        let told = text(folder.path(), "ball.msg");
        assert!(
            ran.code != 0 && told.contains("reads dynamic states"),
            "{told}"
        );
    }
}
