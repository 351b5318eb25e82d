//! Measuring functions of markers.

use crate::run::run_deck as run;

#[test]
fn included_angle_runs_on() {
    let deck = "INCANG beyond 180 degrees
UNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=METER,TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1
MARKER/2,PART=1,QP=1,0,0
PART/2,MASS=1,CM=20,IP=1,1,1
MARKER/20,PART=2
MARKER/21,PART=2,QP=0.9,0.1,0
JOINT/1,REVOLUTE,I=20,J=1
MOTION/1,JOINT=1,ROTATIONAL,FUNCTION=4*TIME
VARIABLE/1,FUNCTION=RTOD*INCANG(21,1,2)
RESULTS/FORMATTED,XRF
END
";
    for command in ["SIM/KIN, END=4, STEPS=20", "SIM/DYN, END=4, STEPS=20"] {
        let (results, _, _) = run(deck, command);
        let (times, angles) = (
            results.column("time", "TIME"),
            results.column("VARIABLE_1", "Q"),
        );
        for (time, angle) in times.iter().zip(&angles) {
            let expected = (4.0 * time + (0.1_f64 / 0.9).atan()).to_degrees();
            assert!(
                (angle - expected).abs() < 1e-5,
                "{command} at {time}: {angle} {expected}"
            );
        }
        // The angle is 189.69 degrees at 0.8 s.
        assert!(
            (angles[angles.len() - 17] - 189.69).abs() < 0.01,
            "{angles:?}"
        );
    }
}

#[test]
fn a_floating_marker_is_where_i_is() {
    let deck = "floating marker
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1, QG=3,0,0
MARKER/10, PART=1, QP=1,0,0
MARKER/11, PART=1, FLOATING
MARKER/20, PART=2
MARKER/21, PART=2, QP=0,2,0
BUSHING/1, I=20, J=10, K=1E3,1E3,1E3, KT=1E3,1E3,1E3, FORCE=2000,0,0
GFORCE/1, I=21, JFLOAT=11, RM=10, FX=10\\ FY=0\\ FZ=0\\ TX=0\\ TY=0\\ TZ=5
VARIABLE/1, FUNCTION=GFORCE(1,0,8,0)
VARIABLE/2, FUNCTION=GFORCE(1,1,8,0)
VARIABLE/3, FUNCTION=DX(11,21)
VARIABLE/4, FUNCTION=DY(21,11)
VARIABLE/5, FUNCTION=FX(11,21)
VARIABLE/6, FUNCTION=TZ(11,21)
VARIABLE/7, FUNCTION=DX(11)-DX(21)
RESULTS/FORMATTED,XRF
END
";
    let (results, _, _) = run(deck, "SIM/STAT");
    for (k, expected) in [5.0, -5.0, 0.0, 0.0, -10.0, -5.0, 0.0]
        .into_iter()
        .enumerate()
    {
        let value = *results
            .column(&format!("VARIABLE_{}", k + 1), "Q")
            .last()
            .unwrap();
        assert!(
            (value - expected).abs() < 1e-9,
            "VARIABLE/{}: {value}",
            k + 1
        );
    }
}
