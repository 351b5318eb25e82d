//! Impossible motions: each simulation ends with time, element and reason, with files up to that time, and with the exit code for no
//! solution.

use std::process::Command;

use crate::run::{Results, folder, mdi, mdi_with, text};

/// A ball of 1 kg on a rail along z, 1 m above ground.
const BALL: &str = "ball
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1, VZ=1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
RESULTS/XRF
OUTPUT/REQSAVE
REQUEST/1, F2=DZ(20)
";
const FORCE: &str = "SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=";

/// A failing simulation: added statements, commands, expected words of the message, and the bounds on the time of the last step.
///
/// `ends` is `None` if no step is written.
struct Bad {
    statements: String,
    commands: &'static str,
    told: &'static [&'static str],
    ends: Option<(f64, f64)>,
}

fn bad() -> Vec<Bad> {
    let plain = "SIM/DYN, END=1.2, STEPS=120";
    vec![
        Bad {
            statements: "MOTION/1, JOINT=1, FUNCTION=1\nMOTION/2, I=20, J=1, Z, FUNCTION=2\n".into(),
            commands: plain,
            told: &["time 0:", "MOTION/2", "initial conditions are inconsistent"],
            ends: None,
        },
        Bad {
            statements: "MOTION/1, JOINT=1, FUNCTION=1+TIME\nMOTION/2, I=20, J=1, Z, FUNCTION=1+2*TIME\n".into(),
            commands: plain,
            told: &["time 0:", "MOTION/2", "no velocities satisfy", "per unit of time"],
            ends: None,
        },
        // The two motions agree until 0.1 s.
        Bad {
            statements: "MOTION/1, JOINT=1, FUNCTION=1\nMOTION/2, I=20, J=1, Z, FUNCTION=1+MAX(0,TIME-0.1)**2\n".into(),
            commands: plain,
            told: &["time 0.1", "MOTION/2", "was removed as redundant but is now violated"],
            ends: Some((0.1, 0.12)),
        },
        Bad {
            statements: "PART/3, MASS=0, CM=40, QG=1,0,0\nMARKER/40, PART=3\n".into(),
            commands: plain,
            told: &["time 0:", "PART/3 along x", "mass matrix is singular"],
            ends: None,
        },
        // A variable equal to itself plus one has no value. The equation p^2 = 4 for an implicit rate p is singular at p = 0.
        Bad {
            statements: format!("VARIABLE/7, FUNCTION=VARVAL(7)+1\n{FORCE}VARVAL(7)\n"),
            commands: plain,
            told: &["time 0:", "VARIABLE/7 is undetermined"],
            ends: None,
        },
        Bad {
            statements: "DIFF/7, IC=1, IMPLICIT, FUNCTION=DIF1(7)**2-4\n".into(),
            commands: plain,
            told: &["time 0:", "DIFF/7 is undetermined"],
            ends: None,
        },
        // A frequency of 1,000 rad/s needs smaller steps than HMIN.
        Bad {
            statements: format!("{FORCE}-1E6*DZ(20)\n"),
            commands: "INTEGRATOR/HMIN=2E-3, ERROR=1E-7\nSIM/DYN, END=1.2, STEPS=120",
            told: &["time 0:", "smaller than HMIN", "PART/2 along z"],
            ends: Some((0.0, 0.0)),
        },
        // The ball moves at 1 m/s.
        Bad {
            statements: format!("{FORCE}SQRT(1.5-DZ(20))\n"),
            commands: plain,
            told: &["time 0.", "SFORCE/1", "SQRT is not defined"],
            ends: Some((0.3, 0.5)),
        },
        // The rounded force switches back and forth once the ball has come to rest, after 1/2 s.
        Bad {
            statements: format!("{FORCE}8-10*AINT(VZ(20)/2+1)\n"),
            commands: plain,
            told: &["time 0.5", "SFORCE/1 switches repeatedly", "smaller than HMIN"],
            ends: Some((0.49, 0.51)),
        },
        // Two stops, a hundred-thousandth of a metre apart.
        Bad {
            statements: format!("{FORCE}BISTOP(DZ(20),VZ(20),0.9999,1.0001,1E8,1,0,1E-4)\n"),
            commands: "SIM/DYN, END=2, STEPS=2",
            told: &["SFORCE/1 switches more than 1000 times"],
            ends: Some((0.0, 0.0)),
        },
    ]
}

#[test]
fn each_ends_with_time_element_and_reason_and_whole_files() {
    for bad in bad() {
        let deck = format!("{BALL}{}END\n", bad.statements);
        let acf = format!("\nfile/model=ball\n{}\nstop\n", bad.commands);
        let folder = folder(&[("ball.adm", &deck), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        let said = ran.stdout.split("the simulation ends at ").nth(1);
        let said = said.unwrap_or_else(|| panic!("{}", ran.stdout));
        let said = said.lines().next().unwrap();
        for words in bad.told {
            assert!(said.contains(words), "{words}: {said}");
        }
        // The command file continues, as in ADAMS; the results state the failure.
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let results = text(folder.path(), "ball.res");
        assert!(results.contains("runStatus=\"Failed\""), "{said}");
        assert!(results.trim_end().ends_with("</Results>"), "{said}");
        let steps = Results::read_all(folder.path(), "ball.res");
        let last = if steps.steps.is_empty() {
            None
        } else {
            steps.column("time", "TIME").last().copied()
        };
        match (last, bad.ends) {
            (None, None) => {}
            (Some(last), Some((from, to))) => {
                assert!((from..=to).contains(&last), "{last}: {said}");
            }
            other => panic!("{other:?}: {said}"),
        }
        let strict = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
        assert_eq!(strict.code, 3, "{}", strict.stdout);
        let solved = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(["solve", "ball.adm", "run.acf"])
            .output()
            .unwrap();
        assert_eq!(solved.status.code(), Some(3), "{said}");
    }
}

/// Checks that an HINIT below HMIN, and outputs closer together than HMIN, do not end a simulation.
#[test]
fn a_least_step_is_one_of_the_error_control_alone() {
    let deck = format!("{BALL}ACCGRAV/KGRAV=-9.81\nEND\n");
    let acf = "\nfile/model=ball\nINTEGRATOR/HMIN=6E-3, HMAX=1E-2\nSIM/DYN, END=0.5, DTOUT=0.0077\nstop\n";
    let folder = folder(&[("ball.adm", &deck), ("run.acf", acf)]);
    let ran = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let z = Results::read_all(folder.path(), "ball.res").column("PART_2_XFORM", "Z");
    let known = 1.0 + 0.5 - 0.5 * 9.81 * 0.25;
    assert!((z.last().unwrap() - known).abs() < 1e-6, "{z:?}");
}

/// Checks that values outside of their bounds, and references to displacements that a joint lacks, are reported at their location.
///
/// This holds for the dataset and for commands.
#[test]
fn what_an_argument_cannot_be_is_an_input_error() {
    for (statement, command, told) in [
        (
            "FRICTION/1, JOINT=1, STICTION_TRANSITION_VELOCITY=0\n",
            "",
            "ball.adm:11:51: STICTION_TRANSITION_VELOCITY of FRICTION must be more than 0",
        ),
        (
            "PART/3, MASS=-1, CM=30, IP=1,1,1\nMARKER/30, PART=3\n",
            "",
            "ball.adm:11:14: MASS of PART must be 0 or more",
        ),
        (
            "MOTION/1, JOINT=1, ROTATIONAL, FUNCTION=0\n",
            "",
            "ball.adm:11:17: MOTION/1 uses the rotation of JOINT/1, which is TRANSLATIONAL",
        ),
        (
            "MARKER/21, PART=2\nJOINT/2, HOOKE, I=21, J=1\nMOTION/2, JOINT=2, FUNCTION=TIME\n",
            "",
            "ball.adm:13:17: MOTION/2 uses JOINT/2, which is HOOKE",
        ),
        (
            "MARKER/21, PART=2\nJOINT/2, SPHERICAL, I=21, J=1\nGEAR/1, JOINTS=1,2, CV=1\n",
            "",
            "ball.adm:13:16: GEAR/1 uses JOINT/2, which is SPHERICAL",
        ),
        (
            "MARKER/21, PART=2\nJOINT/2, REVOLUTE, I=21, J=1\nCOUPLER/1, JOINTS=1,2, TYPE=T:T, SCALES=1,1\n",
            "",
            "ball.adm:13:29: COUPLER/1 uses the translation of JOINT/2, which is REVOLUTE",
        ),
        (
            "",
            "INTEGRATOR/ERROR=-1",
            "run.acf:3:18: ERROR of INTEGRATOR must be more than 0",
        ),
        (
            "",
            "INTEGRATOR/ERROR=1E-3, HMAX=0",
            "run.acf:3:29: HMAX of INTEGRATOR must be more than 0",
        ),
        (
            "",
            "SIM/DYN, END=0.05, STEPS=2.5",
            "run.acf:3:26: STEPS of SIMULATE takes a whole number, not 2.5",
        ),
        (
            "",
            "INTEGRATOR/MAXIT=7.5",
            "run.acf:3:18: MAXIT of INTEGRATOR takes a whole number, not 7.5",
        ),
        (
            "EQUILIBRIUM/MAXIT=30.5\n",
            "",
            "ball.adm:11:19: MAXIT of EQUILIBRIUM takes a whole number, not 30.5",
        ),
        (
            "MOTION/1, JOINT=1, VELOCITY=3*TIME\n",
            "",
            "VELOCITY is a flag without a value, and the expression belongs to FUNCTION: write `VELOCITY, FUNCTION=` before it",
        ),
    ] {
        let deck = format!("{BALL}{statement}END\n");
        let acf = format!("\nfile/model=ball\n{command}\nSIM/DYN, END=0.1, STEPS=1\nstop\n");
        let folder = folder(&[("ball.adm", &deck), ("run.acf", &acf)]);
        let solved = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(["solve", "run.acf"])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&solved.stdout);
        assert!(said.contains(told), "{said}");
        assert_eq!(solved.status.code(), Some(1), "{said}");
    }
}

/// Checks the progress messages while a ball of one milligram on an undamped spring swings at 100,000 rad/s between two outputs.
#[test]
fn many_steps_between_two_outputs_are_told_of() {
    let deck = BALL.replace("MASS=1, CM=20, IP=1,1,1", "MASS=1E-6, CM=20, IP=1,1,1");
    let run = |damping: &str| {
        let deck = format!("{deck}{FORCE}-1E4*DZ(20){damping}\nEND\n");
        let acf = "\nfile/model=ball\nSIM/DYN, END=0.1, STEPS=1\nstop\n";
        let folder = folder(&[("ball.adm", &deck), ("run.acf", acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        ran.stdout
    };
    let said = run("");
    let told = "20000 steps since time 0 without an output";
    assert_eq!(said.matches(told).count(), 1, "{said}");
    assert!(
        said.contains("the next step is 3.0e-6 long: the largest error is that of PART/2 along z."),
        "{said}"
    );
    let said = run("-0.1*VZ(20)");
    assert!(!said.contains(told), "{said}");
}

/// Checks that elements refused at the start of a simulation are reported at their statements, with their ADAMS names.
#[test]
fn refusals_point_at_their_statements() {
    let deck = format!(
        "{BALL}!                 adams_view_name='string'
BEAM/1, I=20, J=1, LENGTH=1, IXX=1, IYY=1, IZZ=1, AREA=1,
, EMODULUS=1, GMODULUS=1, FORMULATION=STRING
FIELD/1, I=20, J=1, FUNCTION=USER(1)
GCON/1, FUNCTION=VM(20)-3
END
"
    );
    let acf = "\nfile/model=ball\nSIM/DYN, END=0.1, STEPS=1\nstop\n";
    let folder = folder(&[("ball.adm", &deck), ("run.acf", acf)]);
    let told = |deck: &str| {
        std::fs::write(folder.path().join("ball.adm"), deck).unwrap();
        mdi(folder.path(), &["ru-s", "run"]).stdout
    };
    let said = told(&deck);
    for place in [
        "ball.adm:12:1: BEAM/1 'string' is not solved",
        "object: model.string",
        "ball.adm:14:1: FIELD/1 is not solved",
        "  14 | FIELD/1, I=20, J=1, FUNCTION=USER(1)\n     | ^^^^^^^\n",
    ] {
        assert!(said.contains(place), "{place}: {said}");
    }
    // Refusals that occur only in motion.
    let said = told(
        &deck
            .replace("BEAM/1", "!")
            .replace("FIELD/1", "!")
            .replace(", EM", "!"),
    );
    let place = "ball.adm:15:1: the function of GCON/1 'string' is not linear in the velocities";
    assert!(said.contains(place), "{said}");
}
