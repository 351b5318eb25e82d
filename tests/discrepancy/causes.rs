//! One study per cause, planted where possible by a law that differs from its hypothesis.

use super::extension::reproduces;
use super::found::{UP_AND_DOWN, named};
use super::plant::{Friction, FrictionLaw, Plant, gforce};
use admire_diagnosis::{Cause, Verdict};

fn found(plant: Plant, seed: u64, loads: Option<&str>) {
    named("pseudo-mcpherson", &plant, seed, loads, reproduces);
}

fn nothing() -> Plant {
    Plant::nothing()
}

#[test]
fn a_sound_model_is_consistent() {
    found(nothing(), 11, None);
}

#[test]
fn a_joint_that_sits_elsewhere() {
    let moved = "QP = -350.0, -8.5, -7.0".to_string();
    let edits = vec![("QP = -350.0, -10.50965490998, -9.462935785116", moved)];
    found(
        Plant {
            truth: ("hardpoint-error", "MARKER/13"),
            edits,
            ..nothing()
        },
        12,
        None,
    );
}

/// Checks that a spring is found whose rate deviates by more than springs of one production do.
#[test]
fn a_spring_that_is_stiffer() {
    found(
        Plant {
            truth: ("element-parameter", "SPRINGDAMPER/1.K"),
            edits: vec![("K = 60.0", "K = 66.0".to_string())],
            ..nothing()
        },
        13,
        None,
    );
}

/// Checks that preload and free length of a spring are reported as rivals.
///
/// Both shift the force of the spring by the same constant. Neither is certain alone, but it is certain that one of them is wrong.
#[test]
fn a_preload_and_a_free_length_are_rivals() {
    let of_the_spring = |outcome: &admire_diagnosis::Outcome<'_>| {
        let first = &outcome.diagnosis.findings[0];
        let rivals = first.indistinguishable_from.iter();
        let names: Vec<&str> = std::iter::once(first.address.as_str())
            .chain(rivals.map(|rival| rival.address.as_str()))
            .collect();
        for number in ["SPRINGDAMPER/1.FORCE", "SPRINGDAMPER/1.LENGTH"] {
            assert!(names.contains(&number), "{names:?}");
        }
        for rival in &first.indistinguishable_from {
            assert!(rival.bic_behind >= 0.0, "{rival:?}");
        }
        let single = first.indistinguishable_from.iter().map(|r| r.probability);
        let most = single.fold(first.probability, f64::max);
        assert!(most < 0.9 && first.group_probability > 0.99, "{first:?}");
    };
    let plant = Plant {
        truth: ("element-parameter", "SPRINGDAMPER/1.FORCE"),
        edits: vec![("FORCE = 4700.0", "FORCE = 4900.0".to_string())],
        ..nothing()
    };
    named("pseudo-mcpherson", &plant, 40, None, of_the_spring);
}

#[test]
fn a_load_cell_that_reads_too_little() {
    found(
        Plant {
            truth: ("load-gain", "SFORCE/2"),
            loads: |v| v[1] *= 1.06,
            ..nothing()
        },
        14,
        None,
    );
}

#[test]
fn a_rig_that_pulls_sideways() {
    found(
        Plant {
            truth: ("load-crosstalk", "SFORCE/1<-SFORCE/3"),
            loads: |v| v[2] += 0.03 * v[0],
            ..nothing()
        },
        15,
        None,
    );
}

#[test]
fn a_frame_that_was_knocked() {
    let reading = |case: usize, _: usize, _: usize, x: &mut [f64; 3]| {
        if case == 6 {
            x[0] += 0.15;
            x[2] -= 0.1;
        }
    };
    found(
        Plant {
            truth: ("frame-drift", "case 7"),
            reading,
            ..nothing()
        },
        16,
        None,
    );
}

/// Checks a frame shift of fourteen times the usual size, for which the prior of the shift leaves a residual that is no unexplained
/// structure.
#[test]
fn a_frame_that_moved_far() {
    let reading = |case: usize, _: usize, _: usize, x: &mut [f64; 3]| {
        if case == 6 {
            x[0] += 2.8;
            x[2] -= 1.4;
        }
    };
    let plant = Plant {
        truth: ("frame-drift", "case 7"),
        reading,
        ..nothing()
    };
    named("pseudo-mcpherson", &plant, 16, None, |outcome| {
        assert_eq!(outcome.diagnosis.verdict, Verdict::Discrepancy);
    });
}

/// Checks that a frame shift is found in the fourth case, which is held out by default.
#[test]
fn a_frame_that_was_knocked_in_a_case_no_fit_saw() {
    let reading = |case: usize, _: usize, _: usize, x: &mut [f64; 3]| {
        if case == 3 {
            x[1] -= 0.2;
        }
    };
    found(
        Plant {
            truth: ("frame-drift", "case 4"),
            reading,
            ..nothing()
        },
        26,
        None,
    );
}

#[test]
fn a_mark_that_was_misread() {
    let reading = |case: usize, part: usize, mark: usize, x: &mut [f64; 3]| {
        if case == 4 && part == 2 && mark == 1 {
            x[1] += 0.6;
        }
    };
    found(
        Plant {
            truth: ("mark-outlier", "case 5 KNUCKLE 2"),
            reading,
            ..nothing()
        },
        17,
        None,
    );
}

/// Checks a bushing whose rate grows exponentially, which is not a polynomial.
#[test]
fn a_bushing_that_stiffens() {
    let law = "-400.0*(SINH(DX(3,4,4)/0.9)-DX(3,4,4)/0.9)";
    found(
        Plant {
            truth: ("progressive-stiffness", "BUSHING/2.K.1"),
            added: gforce(1, (3, 4), 0, law),
            ..nothing()
        },
        18,
        None,
    );
}

#[test]
fn a_bushing_that_sticks_and_slips() {
    found(
        Plant {
            truth: ("dry-friction", "BUSHING/2.K.1"),
            friction: Some(Friction {
                law: FrictionLaw::ElastoSlip,
                force: 300.0,
                stiffness: 4000.0,
                i: 3,
                j: 4,
                part_of_j: 1,
                axis: 0,
            }),
            ..nothing()
        },
        19,
        Some(UP_AND_DOWN),
    );
}

/// Checks a tie rod with compliance at both ends.
#[test]
fn a_tie_rod_that_yields() {
    let outer = "QP = -350.0, -10.50965490998, -9.462935785116";
    let angles = "REULER = 90.0D, 3.0D, 0.0D";
    let axes = "REULER = 91.7197D, 91.5486D, 0.0D";
    let inner = ", PART = 6\n, QP = 0.0, 0.0, 0.0\n, REULER = -178.3611782324D";
    let edits = vec![
        (
            ", PART = 6\n, QP = -350.0, -10.50965490998, -9.462935785116\n",
            format!(", PART = 906\n, {outer}\n"),
        ),
        (inner, inner.replace("PART = 6", "PART = 907")),
    ];
    // The z axes of the bushings are along the line between the two joints: psi = atan2(350, -10.5) and so on, with as many digits as
    // needed.
    let added = format!(
        "PART/906, QG = 130.0, -345.0, 232.0, {angles}\nPART/907, QG = 130.0, -345.0, 232.0, {angles}\nMARKER/991, PART = 906, {outer}, {axes}\nMARKER/992, PART = 6, {outer}, {axes}\nMARKER/993, PART = 907, QP = 0.0, 0.0, 0.0, {axes}\nMARKER/994, PART = 6, QP = 0.0, 0.0, 0.0, {axes}\nBUSHING/990, I = 991, J = 992, C = 0, 0, 0, K = 1E7, 1E7, 9000, CT = 0, 0, 0, KT = 1E10, 1E10, 1E10\nBUSHING/991, I = 993, J = 994, C = 0, 0, 0, K = 1E7, 1E7, 25000, CT = 0, 0, 0, KT = 1E10, 1E10, 1E10\n"
    );
    found(
        Plant {
            truth: ("link-compliance", "PART/6"),
            edits,
            added,
            ..nothing()
        },
        20,
        None,
    );
}

/// Checks a ball joint whose force rises with the ninth power of its displacement. Neither rubber nor a load may be named besides.
#[test]
fn a_tie_rod_with_play() {
    ball_with_play("0.15", 60, 0.2..0.36);
}

/// Checks a ball joint with a softer contact than a tight ball. No compliance may be named besides the play.
#[test]
fn a_tie_rod_with_much_play() {
    ball_with_play("0.7", 15, 1.0..1.6);
}

/// Plants play in a ball of the tie rod: half the play in mm, beyond which more than 1000 N is needed, and the stiffness within it in N/mm.
fn ball_with_play(half: &str, within: u32, play: std::ops::Range<f64>) {
    let outer = "QP = -350.0, -10.50965490998, -9.462935785116";
    let axes = "REULER = 91.7197D, 91.5486D, 0.0D";
    let edits = vec![(
        ", PART = 6\n, QP = -350.0, -10.50965490998, -9.462935785116\n",
        format!(", PART = 906\n, {outer}\n"),
    )];
    let law = format!("-1000.0*(DZ(991,992,992)/{half})**9");
    let law = gforce(6, (991, 992), 2, &law);
    let added = format!(
        "PART/906, QG = 130.0, -345.0, 232.0, REULER = 90.0D, 3.0D, 0.0D\nMARKER/991, PART = 906, {outer}, {axes}\nMARKER/992, PART = 6, {outer}, {axes}\nBUSHING/990, I = 991, J = 992, C = 0, 0, 0, K = 1E7, 1E7, {within}, CT = 0, 0, 0, KT = 1E10, 1E10, 1E10\n{law}"
    );
    let plant = Plant {
        truth: ("free-play", "PART/6"),
        edits,
        added,
        ..nothing()
    };
    named("pseudo-mcpherson", &plant, 22, None, |outcome| {
        reproduces(outcome);
        let findings = &outcome.diagnosis.findings;
        assert_eq!(findings.len(), 1, "{findings:?}");
        let found = findings[0].parameters["play"];
        assert!(play.contains(&found), "{found}");
        assert_eq!(outcome.diagnosis.verdict, Verdict::Discrepancy);
    });
}

/// Checks a spring seat on a bracket that is softest in the lateral direction; the hypothesis has one stiffness for all directions.
#[test]
fn a_spring_seat_that_yields() {
    let seat = ", PART = 1\n, QP = 33.03140499192, -581.7807161389, 830.6280998384";
    let place = "QP = 33.03140499192, -581.7807161389, 830.6280998384";
    let added = format!(
        "PART/906, QG = 0.0, 0.0, 0.0\nMARKER/991, PART = 906, {place}\nMARKER/992, PART = 1, {place}\nBUSHING/990, I = 991, J = 992, C = 0, 0, 0, K = 900, 700, 1100, CT = 0, 0, 0, KT = 1E10, 1E10, 1E10\n"
    );
    found(
        Plant {
            truth: ("body-compliance", "SPRINGDAMPER/1"),
            edits: vec![(seat, seat.replace("PART = 1", "PART = 906"))],
            added,
            ..nothing()
        },
        21,
        None,
    );
}

#[test]
fn a_bushing_that_was_pressed_in_askew() {
    found(
        Plant {
            truth: ("assembly-offset", "BUSHING/2"),
            edits: vec![(
                ", K = 310.0, 2400.0, 180.0",
                ", K = 310.0, 2400.0, 180.0\n, FORCE = 400.0, -2500.0, 300.0".to_string(),
            )],
            ..nothing()
        },
        22,
        None,
    );
}

#[test]
fn a_bushing_that_was_mounted_turned() {
    found(
        Plant {
            truth: ("bushing-orientation", "BUSHING/1"),
            turned: vec![(1, 0, 14.0), (2, 0, 14.0)],
            ..nothing()
        },
        23,
        None,
    );
}

#[test]
fn a_conical_bushing() {
    let law = "MARKER/990, PART = 1, FLOATING\nGFORCE/990\n, I = 3\n, JFLOAT = 990\n, RM = 4\n, FX = -350.0*DY(3,4,4)\\\n, FY = -350.0*DX(3,4,4)\\\n, FZ = 0.0\\\n, TX = 0.0\\\n, TY = 0.0\\\n, TZ = 0.0\n";
    found(
        Plant {
            truth: ("bushing-coupling", "BUSHING/2"),
            added: law.to_string(),
            ..nothing()
        },
        24,
        None,
    );
}

/// Checks a coupling with the energy `k r y sinh(x / r)`, which is not a polynomial.
///
/// With only its constant part, progressive rubber or a load cell would be the first finding.
#[test]
fn a_conical_bushing_that_hardens() {
    let [x, y] = ["DX(3,4,4)", "DY(3,4,4)"];
    let law = format!(
        "MARKER/990, PART = 1, FLOATING\nGFORCE/990\n, I = 3\n, JFLOAT = 990\n, RM = 4\n, FX = -150.0*{y}*COSH({x}/30.0)\\\n, FY = -150.0*30.0*SINH({x}/30.0)\\\n, FZ = 0.0\\\n, TX = 0.0\\\n, TY = 0.0\\\n, TZ = 0.0\n"
    );
    for seed in [24, 31] {
        let plant = Plant {
            truth: ("bushing-coupling", "BUSHING/2"),
            added: law.clone(),
            ..nothing()
        };
        named("pseudo-mcpherson", &plant, seed, None, |outcome| {
            let findings = &outcome.diagnosis.findings;
            assert_eq!(findings[0].cause, Cause::BushingCoupling);
            assert_eq!(findings.len(), 1, "{findings:#?}");
        });
    }
}

/// Checks a bump stop with a parabolic instead of a linear force.
#[test]
fn a_bump_stop_that_is_not_in_the_model() {
    let law = "4.0*MAX(0.0,DZ(11,12,12)-12.0)**2";
    found(
        Plant {
            truth: ("stop-contact", "JOINT/3"),
            added: gforce(4, (11, 12), 2, &format!("-{law}")),
            ..nothing()
        },
        25,
        None,
    );
}

#[test]
fn a_contact_patch_that_is_elsewhere() {
    let contact = ", QP = -17.07941120175, -94.82756163548, -302.8878130055\n";
    let moved = ", QP = -7.07941120175, -94.82756163548, -302.8878130055\n";
    found(
        Plant {
            truth: ("load-point-error", "MARKER/19"),
            edits: vec![(contact, moved.to_string())],
            ..nothing()
        },
        21,
        None,
    );
}

#[test]
fn a_string_pot_of_wrong_gain() {
    found(
        Plant {
            truth: ("channel-fault", "strut"),
            channel: Some(("strut", 18, 17, |length| 1.004 * length)),
            ..nothing()
        },
        28,
        None,
    );
}
