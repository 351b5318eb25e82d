//! SENSORs in static and quasi-static simulations, evaluated after each output step.

use crate::run::{Ran, Results, SLIDER, folder, mdi, run_deck};

/// Runs the slider, which is at z = TIME, with a sensor, and asserts success.
fn run(sensor: &str, commands: &str) -> (Results, Ran) {
    let (results, ran) = run_any(sensor, commands);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    (results, ran)
}

/// Runs the slider with a sensor, with any exit code.
fn run_any(sensor: &str, commands: &str) -> (Results, Ran) {
    let deck = SLIDER.replacen("REQUEST/1", &format!("{sensor}\nREQUEST/1"), 1);
    let acf = format!("\nfile/model=slider\n{commands}\n");
    let folder = folder(&[("slider.adm", &deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read(folder.path(), "slider.res"), ran)
}

fn times(results: &Results) -> Vec<f64> {
    results
        .column("time", "TIME")
        .iter()
        .map(|t| (t * 1e6).round() / 1e6)
        .collect()
}

const RUN: &str = "SIM/STAT, END=1, STEPS=10\nSIM/STAT\nSTOP";

#[test]
fn return_ends_the_simulation_and_halt_the_run() {
    let to = |end: usize| -> Vec<f64> { (0..=end).map(|k| k as f64 / 10.0).collect() };
    // The following single static runs at the time that was reached.
    let (results, ran) = run(
        "SENSOR/1, GE, VALUE=0.5, ERROR=0.001, RETURN, FUNCTION=DZ(20,1)",
        RUN,
    );
    let mut expected = to(5);
    expected.push(0.5);
    assert_eq!(times(&results), expected);
    assert!(
        ran.stdout
            .contains("SENSOR/1 'SENSOR_1' is active at T = 5.00000E-01"),
        "{}",
        ran.stdout
    );
    assert!(ran.stdout.contains("it ends the simulation"));

    let (results, ran) = run(
        "SENSOR/1, GE, VALUE=0.5, ERROR=0.001, HALT, FUNCTION=DZ(20,1)",
        RUN,
    );
    assert_eq!(times(&results), to(5));
    assert!(
        ran.stdout.contains("it halts the run") && !ran.stdout.contains(" command: SIM/STAT\n")
    );
    // The file is complete nevertheless.
    assert!(ran.stdout.contains("Finished -----"));

    // EQ must be met within ERROR; LE, and a function of time alone.
    for (event, last) in [
        ("EQ, VALUE=0.35, ERROR=0.01", 10),
        ("EQ, VALUE=0.35, ERROR=0.06", 3),
        ("LE, VALUE=-5, ERROR=0.001", 10),
        ("GE, VALUE=2, ERROR=0.001", 10),
    ] {
        let (results, _) = run(&format!("SENSOR/1, {event}, HALT, FUNCTION=TIME"), RUN);
        let expected = if last == 10 {
            to(10).len() + 1
        } else {
            last + 1
        };
        assert_eq!(times(&results).len(), expected, "{event}");
    }
}

/// Checks that kinematics continues from the time at which the sensor fired, between two outputs.
#[test]
fn a_sensor_fires_at_its_time_in_kinematics() {
    let sensor = "SENSOR/1, GE, VALUE=0.0625, ERROR=1E-9, RETURN, FUNCTION=DZ(20,1)**2\nMOTION/1, JOINT=1, FUNCTION=TIME";
    for command in ["KINEMATIC", "DYNAMIC"] {
        let commands = format!(
            "SIM/{command}, END=1, STEPS=10\nDEACTIVATE/SENSOR, ID=1\nSIM/{command}, END=1, STEPS=3\nSTOP"
        );
        let deck = SLIDER.replacen("REQUEST/1", &format!("{sensor}\nREQUEST/1"), 1);
        let acf = format!("\nfile/model=slider\n{commands}\n");
        let folder = folder(&[("slider.adm", &deck), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        let results = Results::read_all(folder.path(), "slider.res");
        assert!(
            ran.stdout
                .contains("Sensor/1 has become active at time = 0.250000"),
            "{}",
            ran.stdout
        );
        let (found, z) = (times(&results), results.column("block_XFORM", "Z"));
        assert!(found.ends_with(&[0.5, 0.75, 1.0]), "{command}: {found:?}");
        for (time, z) in results.column("time", "TIME").iter().zip(z) {
            assert!((time - z).abs() < 1e-12, "{command}: {time} {z}");
        }
    }
}

#[test]
fn a_sensor_that_is_switched_off_senses_nothing() {
    let sensor = "SENSOR/1, GE, VALUE=0.5, ERROR=0.001, HALT, FUNCTION=TIME";
    let (results, _) = run(sensor, &format!("DEACTIVATE/SENSOR, ID=1\n{RUN}"));
    assert_eq!(times(&results).len(), 12);
    // A redefined sensor uses its new value.
    let (results, _) = run(sensor, &format!("SENSOR/1, VALUE=0.25\n{RUN}"));
    assert_eq!(times(&results).last(), Some(&0.3));
}

#[test]
fn evaluate_is_kept_for_senval() {
    // After firing at 0.5, SENVAL keeps the force at 5 (ten times z at that time), whatever the time.
    let deck = "SENSOR/1, EQ, VALUE=0.5, ERROR=0.001, FUNCTION=TIME\\, EVALUATE=10*DZ(20,1)\nREQUEST/9, F2=SENVAL(1)\\";
    let (results, _) = run(
        deck,
        "SIM/STAT, END=1, STEPS=10\nSFORCE/1, FUNCTION=SENVAL(1)\nSIM/STAT\nDEACTIVATE/SENSOR, ID=1\nSIM/STAT",
    );
    let z = results.column("block_XFORM", "Z");
    assert!((z[11] - 0.5).abs() < 1e-9 && z[12].abs() < 1e-9, "{z:?}");
    let kept = results.column("REQUEST_9", "U2");
    assert!(
        kept[..6].iter().all(|v| *v == 0.0) && (kept[6] - 5.0).abs() < 1e-6,
        "{kept:?}"
    );
}

#[test]
fn dt_changes_the_steps_that_follow() {
    let (results, _) = run(
        "SENSOR/1, EQ, VALUE=0.5, ERROR=0.001, DT=0.25, PRINT, FUNCTION=TIME",
        "SIM/STAT, END=1, STEPS=10",
    );
    assert_eq!(times(&results), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1.0]);
    // A step that would never end is refused.
    let (results, ran) = run_any(
        "SENSOR/1, EQ, VALUE=0.5, ERROR=0.001, DT=1E-12, FUNCTION=TIME",
        "SIM/STAT, END=1, STEPS=10",
    );
    assert_eq!(times(&results).len(), 6);
    assert!(ran.stdout.contains("[limit-exceeded]"), "{}", ran.stdout);
    assert_eq!(ran.code, 1);
}

#[test]
fn a_value_may_be_given_in_degrees() {
    // 36 degrees are a fifth of PI.
    let (results, _) = run(
        "SENSOR/1, VALUE=36D, ERROR=0.001, RETURN, FUNCTION=TIME*PI",
        "SIM/STAT, END=1, STEPS=10",
    );
    assert_eq!(times(&results).last(), Some(&0.2));
}

/// Checks a sensor at 0.25 m above ground, at time sqrt(1.5/g), inside a step that ends at the next kink of a function of time.
#[test]
fn a_sensor_fires_in_a_step_that_ends_at_a_kink_in_time() {
    let deck = "ball\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nACCGRAV/KGRAV=-9.81\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=STEP(TIME,0.392,0,0.5,1)\nSENSOR/1, LE, VALUE=0.25, ERROR=1E-6, RETURN, FUNCTION=DZ(20,1), EVALUATE=TIME\nEND\n";
    let acf = "\nfile/model=ball\nSIM/DYN, END=1, STEPS=1\nstop\n";
    let folder = folder(&[("ball.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let fall = (1.5_f64 / 9.81).sqrt();
    let said = format!("Sensor/1 has become active at time = {fall:.6}.");
    assert!(ran.stdout.contains(&said), "{}", ran.stdout);
}

/// Checks sensors on a reaction and on an acceleration, for a pendulum (1 m, 2 kg, 0.1 kg m2 about its centre) released from the
/// horizontal.
///
/// With `I = 2.1` about the pin, the rate is `w^2 = 2 (2 g / I) sin q`. The force along the arm is `2 (w^2 + g sin q)`, and across it `2 g
/// cos q (1 - 2 / I)`. The sensors must find the angles at which the total force is 30 N and the acceleration is 12 m/s2.
#[test]
fn a_sensor_of_a_reaction_or_an_acceleration_fires_at_its_time() {
    let g = 9.81;
    let along = |s: f64| 4.0 * g / 2.1 * s;
    let force = |s: f64| {
        let across = 2.0 * g * (1.0 - s * s).sqrt() * (1.0 - 2.0 / 2.1);
        (2.0 * along(s) + 2.0 * g * s).hypot(across)
    };
    let acceleration = |s: f64| along(s).hypot(2.0 * g / 2.1 * (1.0 - s * s).sqrt());
    let half = |f: &dyn Fn(f64) -> f64, value: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if f(middle) < value {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    for (function, value, s) in [
        ("FM(21,1)", 30.0, half(&force, 30.0)),
        ("ACCM(20)", 12.0, half(&acceleration, 12.0)),
        ("VARVAL(1)", 30.0, half(&force, 30.0)),
    ] {
        let deck = format!(
            "pendulum\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
             PART/2, MASS=2, CM=20, IP=0.1,0.1,0.1, QG=1,0,0\nMARKER/20, PART=2\nMARKER/21, PART=2, QP=-1,0,0\n\
             JOINT/1, REVOLUTE, I=21, J=1\nACCGRAV/JGRAV=-9.81\nVARIABLE/1, FUNCTION=FM(21,1)\n\
             SENSOR/1, GE, VALUE={value}, ERROR=1E-6, RETURN, FUNCTION={function}\nREQUEST/1, F2=DY(20,1)\n\
             INTEGRATOR/ERROR=1E-8\nRESULTS/FORMATTED, XRF\nEND\n"
        );
        let commands = "SIM/DYN, END=0.45, DTOUT=0.05\nSIM/INITIAL";
        let folder = folder(&[
            ("m.adm", &deck),
            ("run.acf", &format!("\nfile/model=m\n{commands}\nstop\n")),
        ]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        assert!(
            ran.stdout.contains("Sensor/1 has become active"),
            "{}",
            ran.stdout
        );
        let found = Results::read_all(folder.path(), "m.res");
        let y = *found.column("PART_2_XFORM", "Y").last().unwrap();
        assert!((y + s).abs() < 1e-6, "{function}: {y} and {s}");
    }
}

/// Runs a block that moves at 1 m/s from 0.5 m, with a sensor.
fn glide(sensor: &str, commands: &str) -> (Results, Ran) {
    let deck = format!(
        "block\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
         PART/2, MASS=2, CM=20, IP=1,1,1, QG=0,0,0.5, VZ=1\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\n{sensor}\n\
         REQUEST/1, F2=DZ(20,1)\\F3=DZ(20,1)-SENVAL(1)\nRESULTS/FORMATTED, XRF\nEND\n"
    );
    let acf = format!("\nfile/model=block\n{commands}\nstop\n");
    let folder = folder(&[("block.adm", &deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (Results::read_all(folder.path(), "block.res"), ran)
}

/// Checks EVALUATE at time zero, which stores the initial position, as in a real deck; without `VALUE` the value is zero.
#[test]
fn a_sensor_that_is_at_its_value_acts_where_the_motion_begins() {
    for value in ["VALUE=0, ", ""] {
        let sensor = format!("SENSOR/1, {value}EQ, FUNCTION=TIME\\, EVALUATE=DZ(20,1)");
        let (results, ran) = glide(&sensor, "SIM/DYN, END=1, STEPS=4");
        assert!(
            ran.stdout.contains("become active at time = 0.000000."),
            "{}",
            ran.stdout
        );
        let times = results.column("time", "TIME");
        for (time, travel) in times.iter().zip(results.column("REQUEST_1", "U3")) {
            assert!((time - travel).abs() < 1e-12, "{time} {travel}");
        }
    }
    // A sensor with RETURN at the start allows the first step of each simulation and is not missed.
    let run = "SIM/DYN, END=1, STEPS=4\nSIM/DYN, END=1, STEPS=4\nSIM/INITIAL";
    let (results, ran) = glide("SENSOR/1, GE, RETURN, FUNCTION=DZ(20,1)", run);
    assert_eq!(ran.stdout.matches("has become active").count(), 2);
    let end = *results.column("time", "TIME").last().unwrap();
    assert!(end > 0.0 && end < 0.25, "{end}");
    // An output interval set by a sensor applies from the start.
    let (results, _) = glide("SENSOR/1, DT=0.5, FUNCTION=TIME", "SIM/DYN, END=1, STEPS=4");
    assert_eq!(times(&results), [0.0, 0.5, 1.0]);
}

#[test]
fn print_writes_the_step_at_which_a_sensor_fires() {
    let sensor = "SENSOR/1, GE, VALUE=0.8, ERROR=1E-9, PRINT, YYDUMP, FUNCTION=DZ(20,1)";
    let (results, ran) = glide(sensor, "SIM/DYN, END=1, STEPS=2");
    assert_eq!(times(&results), [0.0, 0.3, 0.5, 1.0]);
    assert!(ran.stdout.contains("Triggered action PRINT"));
    assert!(ran.stdout.contains("Action YYDUMP has no effect"));
}

#[test]
fn arguments_without_sense_are_refused() {
    for (argument, name) in [
        ("DT=-1", "DT"),
        ("STEPSIZE=0", "STEPSIZE"),
        ("ERROR=-1", "ERROR"),
        ("BISECTION, TIME_ERROR=0", "TIME_ERROR"),
    ] {
        let (_, ran) = run_any(
            &format!("SENSOR/1, VALUE=1, {argument}, FUNCTION=TIME"),
            RUN,
        );
        assert_eq!(ran.code, 1, "{}", ran.stdout);
        let said = format!("{name} of SENSOR must be more than 0");
        assert!(ran.stdout.contains(&said), "{}", ran.stdout);
    }
}

#[test]
fn a_sensor_that_halts_at_an_output_leaves_that_output_in() {
    let deck = "a sensor at an output
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/1, PART=1
MARKER/20, PART=2
BUSHING/1, I=20, J=1, K=1E3,1E3,1E3, KT=1E3,1E3,1E3, C=30,30,30, CT=1,1,1
SFORCE/1, TRANS, ACTIONONLY, I=20, J=1, FUNCTION=TIME
SENSOR/1, GE, VALUE=0.5, ERROR=1E-6, HALT, FUNCTION=TIME
RESULTS/FORMATTED, XRF
END
";
    let fixed = deck.replace("BUSHING/1,", "JOINT/1, FIXED, I=20, J=1\nBUSHING/1,");
    for (deck, command) in [(deck, "DYN"), (&fixed[..], "KIN")] {
        let (results, _, _) = run_deck(deck, &format!("SIM/{command}, END=1, STEPS=10"));
        let times = results.column("time", "TIME");
        assert!(
            (times[times.len() - 1] - 0.5).abs() < 1e-9,
            "{command}: {times:?}"
        );
        assert_eq!(times.len(), 6, "{command}: {times:?}");
    }
}
