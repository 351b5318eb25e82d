//! Motions under functions that are not smooth: the events are located, and the error stays within the tolerance.

use std::f64::consts::PI;

use super::{Deck, begun, deck};
use crate::motion::MotionError;
use crate::system::State;

/// Returns a mass of 1 kg that moves along z under gravity and a force, from a given position and velocity.
fn along_z(gravity: f64, (z, vz): (f64, f64), force: &str) -> Deck {
    deck(&format!(
        "ACCGRAV/KGRAV={gravity}\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=0,0,{z}, VZ={vz}\nMARKER/20, PART=2\nJOINT/1, TRANSLATIONAL, I=20, J=1\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION={force}"
    ))
}

/// Motion along z with a known end. `place` and `velocity` contain the value at the end and the largest value on the way, to which errors are
/// relative.
struct Known {
    deck: Deck,
    end: f64,
    place: (f64, f64),
    velocity: (f64, f64),
    changes: usize,
}

impl Known {
    fn off(&self, state: &State) -> f64 {
        let place = (state.poses[1].p.z - self.place.0) / self.place.1;
        let velocity = (state.velocities[1].linear.z - self.velocity.0) / self.velocity.1;
        place.abs().max(velocity.abs())
    }
}

/// Returns the motion of a mass dropped from 1 m onto a contact of 1e4 N/m. The motion lasts two periods of 0.934906080799 s.
fn dropped(force: &str) -> Known {
    Known {
        deck: along_z(-9.81, (1.0, 0.0), force),
        end: 1.869_812_161_598_033,
        place: (1.0, 1.0),
        velocity: (0.0, 19.62_f64.sqrt()),
        changes: 4,
    }
}

/// Returns the motion of a mass on springs of 100 N/m above zero and 400 N/m below zero. The half periods are pi/10 s and pi/20 s.
fn between_springs(force: &str) -> Known {
    Known {
        deck: along_z(0.0, (1.0, 0.0), force),
        end: 0.45 * PI,
        place: (1.0, 1.0),
        velocity: (0.0, 10.0),
        changes: 6,
    }
}

/// Returns the motion of a mass on a spring of 100 N/m, with 5 N of friction. The amplitude falls by 0.1 m in each half swing of pi/10 s. The
/// motion ends after a third of the sixth half swing.
fn braked(force: &str) -> Known {
    Known {
        deck: along_z(0.0, (1.0, 0.0), force),
        end: (0.5 + 1.0 / 30.0) * PI,
        place: (-0.275, 1.0),
        velocity: (4.5 * (PI / 3.0).sin(), 9.5),
        changes: 6,
    }
}

fn known() -> Vec<Known> {
    let fall = 19.62_f64.sqrt();
    vec![
        dropped("IMPACT(DZ(20),VZ(20),0,1E4,1,0,1E-4)"),
        // The drop onto a contact with an exponent of 1.5 and k = 1e5. The contact lasts 0.0240555174853834 s by quadrature of the energy
        // integral.
        Known {
            deck: along_z(-9.81, (1.0, 0.0), "IMPACT(DZ(20),VZ(20),0,1E5,1.5,0,1E-4)"),
            end: 1.854_205_598_913_690_4,
            place: (1.0, 1.0),
            velocity: (0.0, fall),
            changes: 4,
        },
        // Flight between two stops of k = 1e4: each contact lasts half a period of the contact spring, and each flight from stop to stop 1 s.
        Known {
            deck: along_z(
                0.0,
                (0.0, 1.0),
                "BISTOP(DZ(20),VZ(20),-0.5,0.5,1E4,1,0,1E-4)",
            ),
            end: 4.0 + 4.0 * PI / 100.0,
            place: (0.0, 1.0),
            velocity: (1.0, 1.0),
            changes: 8,
        },
        between_springs("IF(DZ(20):-400*DZ(20),0,-100*DZ(20))"),
        braked("-100*DZ(20)+IF(VZ(20):5,0,-5)"),
        // The same motions, with forces written by other functions.
        dropped("MAX(0,-1E4*DZ(20))"),
        dropped("-1E4*MIN(DZ(20),0)"),
        dropped("1E4*DIM(0,DZ(20))"),
        between_springs("-250*DZ(20)+150*ABS(DZ(20))"),
        braked("-100*DZ(20)-SIGN(5,VZ(20))"),
    ]
}

/// The error is below a tenth of ERROR. Steps are rejected only when they are repeated at events.
#[test]
fn the_error_of_motions_with_kinks_is_what_is_asked_for() {
    for (k, known) in known().iter().enumerate() {
        let mut steps = 0;
        for digits in 2..=8 {
            let error = 10.0_f64.powi(-digits);
            let mut integrator = begun(&known.deck, error, known.end);
            integrator.advance_to(known.end).expect("a motion");
            let done = integrator.statistics();
            let off = known.off(&integrator.output().expect("an output"));
            println!("{k} {error:e}: {} {done:?}", off / error);
            assert!(off < 0.1 * error, "{k}, {error:e}: {off:e}");
            assert!(
                done.rejected <= 5 * known.changes,
                "{k}, {error:e}: {done:?}"
            );
            assert!(done.steps > steps);
            steps = done.steps;
        }
    }
}

/// Piecewise constant forces give parabolas, which the method integrates exactly if no step crosses a jump.
#[test]
fn no_step_goes_over_a_jump_of_whole_numbers() {
    let root = f64::sqrt;
    let stairs = Known {
        deck: along_z(0.0, (0.0, 1.0), "AINT(2*DZ(20))"),
        end: 0.5 + (root(2.0) - 1.0) + (2.0 - root(2.0)) / 2.0 + (root(5.5) - 2.0) / 3.0,
        place: (1.75, 1.75),
        velocity: (root(5.5), root(5.5)),
        changes: 3,
    };
    let across = Known {
        deck: along_z(0.0, (2.2, 0.0), "-ANINT(DZ(20))"),
        end: root(2.8) / 2.0 + (root(4.8) - root(2.8)) + 1.0 / root(4.8) + (root(4.8) - root(3.8)),
        place: (-1.0, 2.2),
        velocity: (-root(3.8), root(4.8)),
        changes: 3,
    };
    let saw = Known {
        deck: along_z(0.0, (0.0, 0.0), "MOD(TIME,0.3)"),
        end: 1.0,
        place: (0.203 / 3.0, 1.0),
        velocity: (0.14, 1.0),
        changes: 3,
    };
    for (k, known) in [stairs, across, saw].iter().enumerate() {
        let mut integrator = begun(&known.deck, 1e-3, known.end);
        integrator.advance_to(known.end).expect("a motion");
        let off = known.off(&integrator.output().expect("an output"));
        let done = integrator.statistics();
        println!("{k}: {off:e} {done:?}");
        assert!(off < 1e-12, "{k}: {off:e}");
        assert!(done.rejected <= 5 * known.changes, "{k}: {done:?}");
    }
}

/// A step ends exactly at each event: there the function is zero to the last digits, both at contact and at release.
#[test]
fn a_step_ends_where_the_contact_begins_and_where_it_ends() {
    let contacts = &known()[0];
    let mut integrator = begun(&contacts.deck, 1e-6, 0.1);
    let first = (2.0_f64 / 9.81).sqrt();
    let last = contacts.end / 2.0 - first;
    let mut ends = Vec::new();
    while integrator.step_towards(contacts.end / 2.0).expect("a step") {
        ends.push((integrator.state().time, integrator.state().poses[1].p.z));
    }
    for time in [first, last] {
        let near = |end: &&(f64, f64)| (end.0 - time).abs() < 1e-8;
        let (at, z) = ends.iter().find(near).expect("a step that ends there");
        assert!(z.abs() < 1e-13, "{at}: {z:e}");
    }
}

/// A system has discrete states only if a function can switch at a time that is not known in advance.
#[test]
fn smooth_systems_have_no_regimes() {
    let smooth = [
        "-3*DZ(20)+STEP(TIME,0.1,0,0.2,1)+IF(TIME-0.3:0,0,1)",
        "MAX(0,TIME-0.1)+ABS(TIME-0.2)+SIGN(2,0.3-TIME)+DIM(TIME,0.5)*DZ(20)",
    ];
    for smooth in smooth {
        let deck = along_z(0.0, (1.0, 0.0), smooth);
        assert!(begun(&deck, 1e-3, 0.1).regimes.is_none());
    }
    for known in &known()[3..] {
        assert!(begun(&known.deck, 1e-3, 0.1).regimes.is_some());
    }
}

fn failure(deck: &Deck, hmax: f64, end: f64) -> MotionError {
    let mut integrator = begun(deck, 1e-4, hmax);
    integrator.advance_to(end).unwrap_err()
}

/// Dry friction of 5 N on a block of 1 kg, in different forms found in decks.
const BRAKES: [&str; 3] = [
    "-SIGN(5,VZ(20))",
    "IF(VZ(20):5,0,-5)",
    "-0.5*SIGN(10,VZ(20))",
];

/// Checks that the force on the block is in balance, and that the block has moved only by a creep far below the tolerance.
fn is_at_rest(state: &State, from: f64, time: f64, error: f64) {
    let (z, v, a) = (
        state.poses[1].p.z - from,
        state.velocities[1].linear.z,
        state.accelerations[1].linear.z,
    );
    assert!(
        v.abs() <= 1e-3 * error && z.abs() <= 1e-3 * error * time,
        "{z:e} {v:e}"
    );
    assert!(a.abs() < 1e-9, "{a:e}");
}

/// A block with 5 N of dry friction is pulled by 3 N. It stays at rest from the start, or comes to rest from 1 m/s at 2 m/s2 and then stays at
/// rest.
#[test]
fn dry_friction_holds_a_block() {
    for brake in BRAKES {
        for error in [1e-3, 1e-6] {
            for (speed, from) in [(1.0, 0.25), (0.0, 0.0)] {
                let deck = along_z(0.0, (0.0, speed), &format!("3+{brake}"));
                let mut integrator = begun(&deck, error, 0.1);
                integrator.advance_to(2.0).expect("a motion");
                is_at_rest(&integrator.output().expect("an output"), from, 2.0, error);
                assert!(integrator.statistics().steps < 60);
            }
        }
    }
}

/// A force that grows by 10 N per second pulls a block at rest that has 5 N of dry friction. The block slides from 0.5 s on, with
/// `v = 5 (t - 0.5)^2`.
#[test]
fn a_block_breaks_loose_in_time() {
    for brake in BRAKES {
        for error in [1e-3, 1e-6] {
            let deck = along_z(0.0, (0.0, 0.0), &format!("10*TIME+{brake}"));
            let mut integrator = begun(&deck, error, 0.1);
            integrator.advance_to(2.0).expect("a motion");
            let state = integrator.output().expect("an output");
            let (z, v) = (state.poses[1].p.z, state.velocities[1].linear.z);
            assert!((z - 5.625).abs() < 0.1 * error, "{z}");
            assert!((v - 11.25).abs() < 0.1 * error, "{v}");
        }
    }
}

/// A block of 1 kg lies on a block of 2 kg, with friction of 6 N between them and 4 N on the ground. A force of 9 sin 2t N pulls the upper
/// block. It drags the lower block along from the time when `sin 2t = 4/9`. The upper block slides on the lower one from the time when
/// `6 - 4 = 2 (9 sin 2t - 6)`. The reference values come from a piecewise solution by RK4 with steps of 2e-5 s.
#[test]
fn of_two_blocks_each_sticks_by_itself() {
    let deck = deck(
        "PART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\nPART/3, MASS=1, CM=30, IP=1,1,1, QG=0,0,1\nMARKER/30, PART=3\n\
         JOINT/1, TRANSLATIONAL, I=20, J=1\nJOINT/2, TRANSLATIONAL, I=30, J=20\n\
         SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=-SIGN(4,VZ(20))\n\
         SFORCE/2, TRANSLATIONAL, I=30, J=20, FUNCTION=-SIGN(6,VZ(30,20))\n\
         SFORCE/3, TRANSLATIONAL, ACTIONONLY, I=30, J=1, FUNCTION=9*SIN(2*TIME)",
    );
    for error in [1e-3, 1e-6] {
        let mut integrator = begun(&deck, error, 0.1);
        integrator.advance_to(4.0).expect("a motion");
        let state = integrator.output().expect("an output");
        let found = [1, 2].map(|k| (state.poses[k].p.z, state.velocities[k].linear.z));
        for ((z, v), known) in found
            .iter()
            .zip([(0.249_80, 0.459_19), (1.344_90, 1.052_44)])
        {
            let off = (z - known.0).abs().max((v - known.1).abs());
            assert!(off < error.max(3e-5), "{error:e}: {off:e}");
        }
    }
}

/// A relay force of 5 N against the sign of `v + 2 z` brings a mass of 1 kg onto the line `v = -2 z` and keeps it there. The line is reached at
/// the root of `5 t^2 + 5 t = 2`. From then on, z falls like `exp(-2 t)` under the mean force `4 z`.
#[test]
fn a_relay_slides_along_its_line() {
    let deck = along_z(0.0, (1.0, 0.0), "-SIGN(5,VZ(20)+2*DZ(20))");
    let reached = (65_f64.sqrt() - 5.0) / 10.0;
    let there = 1.0 - 2.5 * reached * reached;
    for error in [1e-3, 1e-6] {
        let mut integrator = begun(&deck, error, 0.25);
        for time in [1.0, 2.0, 4.0] {
            integrator.advance_to(time).expect("a motion");
            let state = integrator.output().expect("an output");
            let z = there * (2.0 * (reached - time)).exp();
            let (place, rate) = (state.poses[1].p.z, state.velocities[1].linear.z);
            let off = (place - z).abs().max((rate + 2.0 * z).abs());
            assert!(off < 0.1 * error, "{error:e} {time}: {off:e}");
            let a = state.accelerations[1].linear.z;
            assert!((a - 4.0 * z).abs() < 5.0 * error, "{error:e} {time}: {a}");
        }
    }
}

/// A block is held between two steps of AINT, and the function switches again and again. The error message names the function.
#[test]
fn a_function_that_chatters_is_named() {
    let deck = along_z(0.0, (0.0, 1.0), "8-10*AINT(VZ(20)/2+1)");
    let error = failure(&deck, 0.1, 2.0);
    // The block comes to rest after 0.5 s: it starts at 1 m/s and is braked by 2 m/s2.
    assert!((error.time - 0.5).abs() < 1e-3, "{error}");
    let text = error.to_string();
    assert!(
        text.contains("SFORCE/1") && text.contains("repeatedly"),
        "{text}"
    );
}

/// More than a thousand switches of one function between two outputs are an error. Here a mass rattles between two stops.
#[test]
fn a_thousand_changes_between_two_outputs_are_too_many() {
    let rattle = "BISTOP(DZ(20),VZ(20),-0.0001,0.0001,1E8,1,0,1E-4)";
    let deck = along_z(0.0, (0.0, 1.0), rattle);
    let error = failure(&deck, 1.0, 1.0);
    let text = error.to_string();
    assert!(text.contains("SFORCE/1") && text.contains("1000"), "{text}");
    // Each flight is 0.2 mm at 1 m/s, and each contact lasts pi/10 ms. A thousand switches take 0.25 s.
    let round = 2.0 * (2e-4 + PI * 1e-4);
    assert!((error.time / (250.0 * round) - 1.0).abs() < 0.02, "{error}");
    // If the outputs are closer together, the number of switches between two outputs stays below the limit.
    let mut integrator = begun(&deck, 1e-4, 0.1);
    integrator.advance_to(1.0).expect("a motion");
}

/// A sawtooth of time with 5,000 teeth between two outputs does not count as chatter, because time alone selects its pieces. N teeth of length
/// T with `N T = 1` give the velocity T/2.
#[test]
fn jumps_of_the_time_may_be_many() {
    let tooth = 2e-4;
    let deck = along_z(0.0, (0.0, 0.0), "MOD(TIME,0.0002)");
    let mut integrator = begun(&deck, 1e-4, 1.0);
    integrator.advance_to(1.0).expect("a motion");
    let state = integrator.output().expect("an output");
    let place = tooth / 4.0 * (1.0 - tooth) + tooth * tooth / 6.0;
    let (z, speed) = (state.poses[1].p.z, state.velocities[1].linear.z);
    assert!((speed / (tooth / 2.0) - 1.0).abs() < 1e-9, "{speed:e}");
    assert!((z / place - 1.0).abs() < 1e-9, "{z:e}");
    assert!(integrator.statistics().steps >= 5000);
}

/// A force equal to the square root of the height acts only above the ground. The mass starts at 1 m with -2 m/s. Below the ground, the motion
/// continues with `v^2 = 4 - 4/3`.
#[test]
fn a_piece_that_ends_where_its_function_ends_is_left() {
    let deck = along_z(0.0, (1.0, -2.0), "IF(DZ(20):0,0,SQRT(DZ(20)))");
    let mut integrator = begun(&deck, 1e-6, 1.0);
    integrator.advance_to(2.0).expect("a motion");
    let state = integrator.output().expect("an output");
    let speed = state.velocities[1].linear.z + (8.0_f64 / 3.0).sqrt();
    assert!(speed.abs() < 1e-5, "{speed:e}");
    assert_eq!(integrator.state().pieces, [Some(0)]);
}

/// A contact force with an exponent of zero: 500 N while the stop is pressed, and no force afterwards.
#[test]
fn a_stop_of_constant_force_is_left() {
    let fall = 19.62_f64.sqrt();
    for force in [
        "IMPACT(DZ(20),VZ(20),0,500,0,0,0)",
        "BISTOP(DZ(20),VZ(20),0,9,500,0,0,0)",
    ] {
        let known = Known {
            end: 4.0 * fall / 9.81 + 4.0 * fall / 490.19,
            ..dropped(force)
        };
        let mut integrator = begun(&known.deck, 1e-6, known.end);
        integrator.advance_to(known.end).expect("a motion");
        let off = known.off(&integrator.output().expect("an output"));
        assert!(off < 1e-7, "{force}: {off:e}");
    }
}
