//! Redefinition of statements by commands, and the time of quasi-static runs.

use crate::run::{Results, folder, mdi};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
    }
}

/// Runs a deck with some commands and returns the results.
fn results(deck: &str, commands: &str) -> Results {
    let acf = format!("\nfile/model=deck\n{commands}\nSTOP\n");
    let folder = folder(&[("deck.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{commands}: {}", ran.stdout);
    assert!(!ran.stdout.contains("ERROR"), "{commands}: {}", ran.stdout);
    Results::read(folder.path(), "deck.res")
}

const HEAD: &str = "deck\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
                    !                            adams_view_name='ground'\nPART/1, GROUND\nMARKER/1, PART=1\n";
const TAIL: &str = "EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8\nRESULTS/XRF\nEND\n";

/// Returns a deck of fourteen separate parts, each on a bushing and with one element of its own.
fn deck() -> String {
    let mut out = HEAD.to_string();
    for id in 2..16 {
        let x = 100 * id;
        out += &format!(
            "!                            adams_view_name='part{id}'\nPART/{id}, QG={x},0,0, MASS=1, CM={id}00, IP=9,9,9\nMARKER/{id}00, PART={id}\n\
             MARKER/{id}01, PART={id}, QP=30,0,0\nMARKER/{id}02, PART=1, QP={x},0,0\nMARKER/{id}03, PART=1, QP={x},60,0\nMARKER/{id}04, PART=1, FLOATING\n\
             BUSHING/{id}, I={id}00, J={id}02, K=100,100,100, KT=1E5,1E5,1E5, FORCE=3,4,5\n"
        );
    }
    let six = |k: i32| -> String {
        let all = (0..36).map(|n| {
            if n % 7 == 0 {
                k * (1 + n / 21 * 999)
            } else {
                0
            }
        });
        all.map(|n| n.to_string()).collect::<Vec<_>>().join(",")
    };
    out + &format!(
        "FIELD/1, I=301, J=303, KMATRIX={}, FORCE=1,2,3,0,0,0\n\
         BEAM/1, I=401, J=403, LENGTH=50, AREA=2, IXX=3, IYY=1, IZZ=2, EMODULUS=200, GMODULUS=80\n\
         SPRINGDAMPER/1, TRANSLATIONAL, I=501, J=503, K=20, LENGTH=50\n\
         SFORCE/1, TRANSLATIONAL, I=601, J=603, FUNCTION=7\n\
         GFORCE/1, I=701, JFLOAT=704, RM=1, FX=2\\, TX=30\n\
         VFORCE/1, I=801, JFLOAT=804, RM=1, FX=2\\, FZ=3\n\
         VTORQUE/1, I=901, JFLOAT=904, RM=1, TX=2\\, TZ=3\n\
         JPRIM/1, INPLANE, I=1001, J=1003\nMOTION/1, I=1100, J=1102, X, FUNCTION=0.5\n\
         VARIABLE/1, FUNCTION=4\nSFORCE/2, TRANSLATIONAL, I=1201, J=1203, FUNCTION=VARVAL(1)\n\
         SPLINE/1, X=0,1,2,3, Y=0,1,4,9\nSFORCE/3, TRANSLATIONAL, I=1301, J=1303, FUNCTION=AKISPL(2.5,0,1)\n\
         ARRAY/1, IC, SIZE=2, NUMBERS=5,6\nSFORCE/4, TRANSLATIONAL, I=1401, J=1403, FUNCTION=ARYVAL(1,2)\n\
         GCON/1, FUNCTION=DX(1500,1)-1501\nACCGRAV/KGRAV=-9806.65\n{TAIL}",
        six(20)
    )
}

/// Checks that a statement redefined by a command acts as if it had been written so in the dataset.
#[test]
fn a_redefinition_is_as_if_the_dataset_had_said_so() {
    let deck = deck();
    let places = |results: &Results| -> Vec<f64> {
        (2..16)
            .flat_map(|id| {
                ["X", "Y", "Z", "THETA"].map(|c| results.column(&format!("part{id}_XFORM"), c)[0])
            })
            .collect()
    };
    let before = places(&results(&deck, "SIM/STAT"));
    for (said, instead, command) in [
        (
            "FORCE=3,4,5\n!                            adams_view_name='part3'",
            "FORCE=9,4,5\n!                            adams_view_name='part3'",
            "BUSHING/2, FORCE=9,4,5",
        ),
        (
            "FORCE=1,2,3,0,0,0",
            "FORCE=1,2,9,0,0,0",
            "FIELD/1, FORCE=1,2,9,0,0,0",
        ),
        ("EMODULUS=200", "EMODULUS=900", "BEAM/1, EMODULUS=900"),
        (
            "K=20, LENGTH=50",
            "K=20, LENGTH=70",
            "SPRINGDAMPER/1, LENGTH=70",
        ),
        (
            "J=603, FUNCTION=7",
            "J=603, FUNCTION=17",
            "SFORCE/1, FUNCTION=17",
        ),
        ("FX=2\\, TX=30", "FX=2\\, TX=3000", "GFORCE/1, TX=3000"),
        ("FX=2\\, FZ=3", "FX=8\\, FZ=3", "VFORCE/1, FX=8"),
        ("TX=2\\, TZ=3", "TX=2000\\, TZ=3", "VTORQUE/1, TX=2000"),
        (
            "X, FUNCTION=0.5",
            "X, FUNCTION=1.5",
            "MOTION/1, FUNCTION=1.5",
        ),
        (
            "VARIABLE/1, FUNCTION=4",
            "VARIABLE/1, FUNCTION=14",
            "VARIABLE/1, FUNCTION=14",
        ),
        ("Y=0,1,4,9", "Y=0,1,8,9", "SPLINE/1, Y=0,1,8,9"),
        ("NUMBERS=5,6", "NUMBERS=5,16", "ARRAY/1, NUMBERS=5,16"),
        (
            "DX(1500,1)-1501",
            "DX(1500,1)-1503",
            "GCON/1, FUNCTION=DX(1500,1)-1503",
        ),
        ("KGRAV=-9806.65", "KGRAV=-980.665", "ACCGRAV/KGRAV=-980.665"),
        (
            "MARKER/601, PART=6, QP=30,0,0",
            "MARKER/601, PART=6, QP=10,0,5",
            "MARKER/601, QP=10,0,5",
        ),
        ("QG=900,0,0, MASS=1", "QG=900,0,0, MASS=3", "PART/9, MASS=3"),
    ] {
        assert_eq!(deck.matches(said).count(), 1, "{said}");
        let commanded = places(&results(&deck, &format!("{command}\nSIM/STAT")));
        let written = places(&results(&deck.replace(said, instead), "SIM/STAT"));
        for (a, b) in commanded.iter().zip(&written) {
            assert!((a - b).abs() < 1e-9, "{command}: {a} {b}");
        }
        let moved = commanded.iter().zip(&before).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f64::max) > 1e-4, "{command} does nothing");
    }
}

/// Checks that angles count turns in a quasi-static run: AZ follows the driven angle over one and a half turns, and MOD reduces it.
#[test]
fn angles_count_turns() {
    let deck = format!(
        "{HEAD}!                            adams_view_name='shaft'\nPART/2, MASS=1, CM=20, IP=9,9,9\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
         JOINT/1, REVOLUTE, I=20, J=1\nMOTION/1, JOINT=1, FUNCTION=TIME\n\
         SPRINGDAMPER/1, ROTATIONAL, I=21, J=1, KT=100\n\
         REQUEST/1, CNAMES=\"\", \"az\", \"within\", \"torque\", RESULTS_NAME=angles\n, F2=AZ(20,1)\\\n, F3=MOD(AZ(20,1)+PI,2*PI)-PI\\\n, F4=SPDP(1,0,8,0)\n{TAIL}"
    );
    let results = results(&deck, "SIM/STAT, END=10, STEPS=20");
    let time = results.column("time", "TIME");
    assert_eq!(time.len(), 21);
    near(&results.column("angles", "az"), &time);
    let torque: Vec<f64> = time.iter().map(|t| -100.0 * t).collect();
    for (a, b) in results.column("angles", "torque").iter().zip(&torque) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    let pi = std::f64::consts::PI;
    let within: Vec<f64> = time.iter().map(|t| (t + pi) % (2.0 * pi) - pi).collect();
    near(&results.column("angles", "within"), &within);
    // A single step of ten radians, which is solved in parts, loses no turn.
    let at_once = self::results(&deck, "SIM/STAT, END=10, STEPS=1");
    near(&at_once.column("time", "TIME"), &[0.0, 10.0]);
    near(&at_once.column("angles", "az"), &[0.0, 10.0]);
}

/// Checks switching between ACTIONONLY, which acts on I along zj alone, and REACTION, which acts on J as well, along the line from J to I.
#[test]
fn a_force_gets_its_reaction_back() {
    let pair = "pair\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
                !                            adams_view_name='ground'\nPART/1, GROUND\nMARKER/11, PART=1\nMARKER/12, PART=1, QP=0,0,100\n\
                !                            adams_view_name='above'\nPART/2, QG=0,0,100, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\n\
                !                            adams_view_name='below'\nPART/3, MASS=1, CM=30, IP=1,1,1\nMARKER/30, PART=3\n\
                BUSHING/1, I=20, J=12, K=10,10,10, KT=1E5,1E5,1E5\nBUSHING/2, I=30, J=11, K=20,20,20, KT=1E5,1E5,1E5\n\
                SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=30, FUNCTION=5\nEQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8\nRESULTS/XRF\nEND\n";
    let acf = "\nfile/model=pair\nSIM/STAT\nSFORCE/1, REACTION\nSIM/STAT\nSFORCE/1, ACTIONONLY\nSIM/STAT\nSTOP\n";
    let folder = folder(&[("pair.adm", pair), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "pair.res");
    near(&results.column("above_XFORM", "Z"), &[100.5, 100.5, 100.5]);
    near(&results.column("below_XFORM", "Z"), &[0.0, -0.25, 0.0]);
}

/// Checks that turns are counted from the same angle and not from another function that was measured before.
#[test]
fn another_angle_does_not_begin_at_the_turn_of_the_one_before() {
    let deck = format!(
        "{HEAD}PART/2, MASS=1, CM=20, IP=9,9,9\nMARKER/20, PART=2\nMARKER/30, PART=2, ZP=0.75, 0.6, -1\nJOINT/1, FIXED, I=20, J=1\n\
         SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=AY(30,1)\n{TAIL}"
    );
    let found = results(
        &deck,
        "SIM/STAT\nSFORCE/1, FUNCTION=AX(30,1)\nSIM/STAT\nSFORCE/1, FUNCTION=AY(30,1)\nSIM/STAT",
    );
    let (x, y) = ((-0.6_f64).atan2(-1.0), 0.75_f64.atan2(-1.0));
    near(&found.column("SFORCE_1", "FZ"), &[y, x, y]);
}

#[test]
fn the_column_of_a_floating_marker_stays_when_a_force_is_redefined() {
    // The first force comes from a subroutine, is deactivated, and then becomes a solvable one, which precedes the other one.
    let deck = format!(
        "{HEAD}MARKER/8, PART=1, FLOATING\nMARKER/9, PART=1, FLOATING\n\
         PART/2, MASS=1, CM=20, IP=1,1,1, QG=1,2,3\nMARKER/20, PART=2\n\
         PART/3, MASS=1, CM=30, IP=1,1,1, QG=4,5,6\nMARKER/30, PART=3\n\
         MARKER/12, PART=1, QP=1,2,3\nMARKER/13, PART=1, QP=4,5,6\n\
         BUSHING/1, I=20, J=12, K=1000,1000,1000, KT=100,100,100\n\
         BUSHING/2, I=30, J=13, K=1000,1000,1000, KT=100,100,100\n\
         GFORCE/1, I=20, JFLOAT=8, RM=1, FUNCTION=USER(1,2)\\\n\
         GFORCE/2, I=30, JFLOAT=9, RM=1, FX=1\\ FY=0\\ FZ=0\\ TX=0\\ TY=0\\ TZ=0\n{TAIL}"
    );
    let commands = "DEACTIVATE/GFORCE, ID=1\nSIM/STAT\n\
                    GFORCE/1, FX=2\\ FY=0\\ FZ=0\\ TX=0\\ TY=0\\ TZ=0\nACTIVATE/GFORCE, ID=1\nSIM/STAT";
    let results = results(&deck, commands);
    near(&results.column("MARKER_9_XFORM", "X"), &[4.001, 4.001]);
    near(&results.column("MARKER_9_XFORM", "Z"), &[6.0, 6.0]);
}

#[test]
fn columns_of_variables_states_and_requests_stay_when_others_become_solved() {
    // Objects that are first given by subroutines precede the others in the dataset.
    let deck = format!(
        "{HEAD}PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\n\
         BUSHING/1, I=20, J=1, K=1000,1000,1000, KT=100,100,100\n\
         VARIABLE/1, FUNCTION=USER(1)\nVARIABLE/2, FUNCTION=22\nARRAY/1, U, VARIABLES=2\nPOUTPUT/1, VARIABLES=2\n\
         DIFF/1, IC=5, FUNCTION=5-DIF(1)\nDIFF/2, IC=7, FUNCTION=7-DIF(2)\n\
         ARRAY/2, X\nARRAY/3, Y\nTFSISO/1, X=2, U=1, Y=3, NUMERATOR=3, DENOMINATOR=1,1\n\
         REQUEST/1, FUNCTION=USER(3)\nREQUEST/2, F2=10*VARVAL(2)\n{TAIL}"
    );
    let commands = "DEACTIVATE/VARIABLE, ID=1\nSIM/STAT\n\
                    VARIABLE/1, FUNCTION=11\nACTIVATE/VARIABLE, ID=1\nDIFF/1, FUNCTION=3-DIF(1)\n\
                    REQUEST/1, F2=1\nSIM/STAT";
    let results = results(&deck, commands);
    near(&results.column("VARIABLE_2", "Q"), &[22.0, 22.0]);
    near(&results.column("DIFF_2", "Q"), &[7.0, 7.0]);
    near(&results.column("REQUEST_2", "U2"), &[220.0, 220.0]);
    near(&results.column("VARIABLE_1", "Q")[1..], &[11.0]);
    near(&results.column("DIFF_1", "Q"), &[5.0, 3.0]);
}

/// Checks that a motion at a joint is left unchanged, with a message, if a command gives it one marker without the other.
#[test]
fn a_command_that_leaves_an_object_without_what_it_needs_is_refused() {
    let deck = format!(
        "{HEAD}PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
         JOINT/1, TRANSLATIONAL, I=20, J=1\nMOTION/1, JOINT=1, TRANSLATIONAL, FUNCTION=2\n{TAIL}"
    );
    let run = |command: &str| {
        let acf = format!("\nfile/model=deck\n{command}\nSIM/STAT\nSTOP\n");
        let folder = folder(&[("deck.adm", &deck), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        let z = Results::read(folder.path(), "deck.res").column("PART_2_XFORM", "Z");
        (ran.stdout, z)
    };
    let (said, z) = run("MOTION/1, I=20");
    assert!(said.contains("MOTION/1 needs all of I, J"), "{said}");
    near(&z, &[2.0]);
    let (said, z) = run("MOTION/1, I=21, J=1, Z, FUNCTION=3");
    assert!(!said.contains("needs"), "{said}");
    near(&z, &[3.0]);
}
