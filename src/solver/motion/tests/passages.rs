//! Motions that pass through singular positions.

use super::{begun, deck};

/// Mechanism A02 of the IFToMM benchmark: two windows side by side, made of rods of 1 m and 1 kg. All uprights stay parallel:
/// `J q'' = m g sin q`.
///
/// All rods lie in one line at about 0.7 s. There the derivatives of one stage do not suffice, but the derivatives of every stage, solved one
/// after the other, do. The coupled iteration is not needed.
#[test]
fn the_stages_one_after_the_other_lead_through_a_singular_position() {
    let (across, along) = (1.0 / 12.0 + 0.01 / 16.0, 0.01 / 8.0);
    let mut statements = String::from("ACCGRAV/JGRAV=-9.81\n");
    for k in 0..3 {
        let part = 2 + k;
        statements += &format!(
            "PART/{part}, MASS=1, CM={part}00, IP={across},{along},{across}, QG={k},0,0, VX=0.5, WZ=-1\nMARKER/{part}00, PART={part}, QP=0,0.5,0\nMARKER/{part}01, PART={part}\nMARKER/{part}02, PART={part}, QP=0,1,0\nMARKER/{}, PART=1, QP={k},0,0\nJOINT/{}, REVOLUTE, I={part}01, J={}\n",
            10 + k,
            1 + k,
            10 + k
        );
    }
    for k in 0..2 {
        let part = 5 + k;
        statements += &format!(
            "PART/{part}, MASS=1, CM={part}00, IP={along},{across},{across}, QG={k},1,0, VX=1\nMARKER/{part}00, PART={part}, QP=0.5,0,0\nMARKER/{part}01, PART={part}\nMARKER/{part}02, PART={part}, QP=1,0,0\nJOINT/{}, REVOLUTE, I={part}01, J={}02\nJOINT/{}, REVOLUTE, I={part}02, J={}02\n",
            4 + 2 * k,
            2 + k,
            5 + 2 * k,
            3 + k
        );
    }
    let deck = deck(statements.trim_end());
    let mut integrator = begun(&deck, 1e-4, 0.2);
    integrator.advance_to(1.0).expect("the row moves");
    assert!(integrator.sequence.is_some());
    assert!(integrator.coupled.is_none());

    let inertia = 3.0 * (1.0 / 3.0 + 0.01 / 16.0) + 2.0;
    let rate = |[q, w]: [f64; 2]| [w, 3.5 * 9.81 * q.sin() / inertia];
    let (mut s, h) = ([0.0, 1.0], 1e-3);
    for _ in 0..1000 {
        let ahead = |by: f64, k: [f64; 2]| rate([s[0] + by * k[0], s[1] + by * k[1]]);
        let a = rate(s);
        let b = ahead(h / 2.0, a);
        let c = ahead(h / 2.0, b);
        let d = ahead(h, c);
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    let reached = integrator.output().expect("an output").poses[4].p;
    assert!((reached.x - s[0].sin()).abs() < 1e-3, "{reached} {s:?}");
    assert!((reached.y - s[0].cos()).abs() < 1e-3, "{reached} {s:?}");
}
