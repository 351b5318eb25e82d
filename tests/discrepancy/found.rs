use super::plant::{Friction, Plant, study};
use admire::discrepancy::{Outcome, diagnose, held_out};
use admire::identify::LoadedStudy;

/// Table 2 of the paper: up and down, so that hysteresis shows.
const UP_AND_DOWN: &str = "case,vertical,lateral,longitudinal
1,1500,0,0
2,3000,0,0
3,4500,0,0
4,6000,0,0
5,4500,0,0
6,3000,0,0
7,3000,1000,0
8,3000,2000,0
9,3000,1000,0
10,3000,0,0
11,3000,-1000,0
12,3000,-2000,0
13,3000,0,0
14,3000,0,1500
15,3000,0,3000
16,3000,0,1500
17,3000,0,0
18,3000,0,-1500
19,3000,0,0
";

fn plants() -> Vec<(Plant, Option<&'static str>)> {
    let none = Plant::nothing;
    vec![
        (none(), None),
        (
            Plant {
                truth: ("hardpoint-error", "MARKER/13"),
                edits: vec![("QP = -350.0, -10.50965490998, -9.462935785116", "QP = -350.0, -8.5, -7.0".to_string())],
                ..none()
            },
            None,
        ),
        (
            Plant { truth: ("element-parameter", "SPRINGDAMPER/1.K"), edits: vec![("K = 60.0", "K = 66.0".to_string())], ..none() },
            None,
        ),
        (Plant { truth: ("load-gain", "SFORCE/2"), loads: |v| v[1] *= 1.06, ..none() }, None),
        (
            Plant { truth: ("load-crosstalk", "SFORCE/1<-SFORCE/3"), loads: |v| v[2] += 0.03 * v[0], ..none() },
            None,
        ),
        (
            Plant {
                truth: ("frame-drift", "case 7"),
                reading: |case, _, _, x| {
                    if case == 6 {
                        x[0] += 0.15;
                        x[2] -= 0.1;
                    }
                },
                ..none()
            },
            None,
        ),
        (
            Plant {
                truth: ("mark-outlier", "case 5 KNUCKLE 2"),
                reading: |case, part, mark, x| {
                    if case == 4 && part == 2 && mark == 1 {
                        x[1] += 0.6;
                    }
                },
                ..none()
            },
            None,
        ),
        (
            Plant {
                truth: ("progressive-stiffness", "BUSHING/2.K.1"),
                added: "MARKER/990, PART = 1, FLOATING\nGFORCE/990\n, I = 3\n, JFLOAT = 990\n, RM = 4\n, FX = -6000.0*DX(3,4,4)**3\\\n, FY = 0.0\\\n, FZ = 0.0\\\n, TX = 0.0\\\n, TY = 0.0\\\n, TZ = 0.0\n".to_string(),
                ..none()
            },
            None,
        ),
        (
            Plant {
                truth: ("dry-friction", "BUSHING/2.K.1"),
                friction: Some(Friction { force: 300.0, stiffness: 4000.0, i: 3, j: 4, part_of_j: 1, axis: 0 }),
                ..none()
            },
            Some(UP_AND_DOWN),
        ),
    ]
}

#[test]
fn planted_causes_are_named() {
    let only = std::env::var("ADMIRE_PLANT")
        .ok()
        .and_then(|k| k.parse::<usize>().ok());
    for (k, (plant, loads)) in plants().iter().enumerate() {
        if only.is_some_and(|only| only != k) {
            continue;
        }
        let folder = study("pseudo-mcpherson", plant, 0.02, 11 + k as u64, *loads);
        let loaded = LoadedStudy::read(folder.path()).value.unwrap();
        let started = std::time::Instant::now();
        let problem = loaded.problem();
        let outcome: Outcome<'_> =
            diagnose(&problem, held_out(&loaded.study, &loaded.measurement)).unwrap();
        let seconds = started.elapsed().as_secs_f64();
        println!(
            "== {:?} in {seconds:.2} s, {} places, verdict {:?}, baseline {:?}",
            plant.truth, outcome.places, outcome.diagnosis.verdict, outcome.diagnosis.baseline
        );
        for f in &outcome.diagnosis.findings {
            println!(
                "   {} {} {:?} +- {:?} minor {} gain {:.1} bic {:.1} held {:?}->{:?} p {:?}",
                f.cause,
                f.address,
                f.parameters,
                f.std_error,
                f.minor,
                f.evidence.value,
                f.evidence.bic_gain,
                f.gain.held_out_rms_before,
                f.gain.held_out_rms_after,
                f.gain.held_out_p_value
            );
            for r in &f.indistinguishable_from {
                println!(
                    "      or {} {} behind {:.2}",
                    r.cause, r.address, r.bic_behind
                );
            }
        }
        println!("   left {:?}", outcome.diagnosis.unexplained);
    }
}
