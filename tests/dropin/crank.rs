//! A crank with constraints that are only approximately redundant.

use crate::run::run_deck as run;

/// Checks a crank whose redundant equation changes during a turn.
///
/// A crank drives a rod with a ball joint at its far end and a slider 0.1 beside the line of the pivot. One of the two products of the
/// rod's pin keeps the rod from spinning; which one depends on the crank angle. The pivot of the crank is out of square by the round-off of
/// an angle with seven digits.
#[test]
fn which_equation_is_left_out_changes_as_a_crank_turns() {
    for turned in ["0", "90D", "45D"] {
        for (askew, command) in [
            ("1E-9", "KINEMATIC"),
            ("1E-9", "DYNAMIC"),
            ("5E-7", "KINEMATIC"),
            ("5E-7", "DYNAMIC"),
        ] {
            let deck = format!(
                "crank whose redundancy is not exact
UNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=METER,TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1
MARKER/2,PART=1,QP=0,0.1,0,REULER=90D,90D,0
PART/2,MASS=1,CM=21,IP=1E-2,1E-2,1E-2
MARKER/20,PART=2,REULER=0,{askew},0
MARKER/21,PART=2,QP=0.05,0,0
MARKER/22,PART=2,QP=0.1,0,0,REULER={turned},0,0
PART/3,MASS=1,CM=31,IP=1E-2,1E-2,1E-2
MARKER/30,PART=3,QP=0.1,0,0
MARKER/31,PART=3,QP=0.25,0.05,0
MARKER/32,PART=3,QP=0.4,0.1,0
PART/4,MASS=1,CM=40,IP=1E-2,1E-2,1E-2,QG=0.4,0.1,0
MARKER/40,PART=4
MARKER/41,PART=4,REULER=90D,90D,0
JOINT/1,REVOLUTE,I=20,J=1
JOINT/2,REVOLUTE,I=30,J=22
JOINT/3,SPHERICAL,I=32,J=40
JOINT/4,TRANSLATIONAL,I=41,J=2
MOTION/1,JOINT=1,ROTATIONAL,FUNCTION=2*PI*TIME
INTEGRATOR/GSTIFF,ERROR=1E-6
RESULTS/FORMATTED,XRF
END
"
            );
            let (results, ran, _) = run(&deck, &format!("SIMULATE/{command},END=1,STEPS=36"));
            assert!(
                !ran.stdout.contains("ERROR"),
                "{turned} {askew} {command}: {}",
                ran.stdout
            );
            let (times, x) = (
                results.column("time", "TIME"),
                results.column("PART_4_XFORM", "X"),
            );
            assert!(times.len() >= 37, "{}", times.len());
            let length2 = 0.3_f64.powi(2) + 0.1_f64.powi(2);
            for (time, x) in times.iter().zip(&x) {
                let angle = std::f64::consts::TAU * time;
                let beside = 0.1 * angle.sin() - 0.1;
                let expected = 0.1 * angle.cos() + (length2 - beside * beside).sqrt();
                assert!(
                    (x - expected).abs() < 1e-6,
                    "{turned} {command} at {time}: {x} {expected}"
                );
            }
        }
    }
}
