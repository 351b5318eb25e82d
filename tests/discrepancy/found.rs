use super::plant::{Friction, Plant, study};
use admire::backend::{Backend, NativeBackend, SweepRequest};
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

/// Where the contact patch is on the knuckle, and where it is on the rig.
const CONTACT: &str = ", QP = -17.07941120175, -94.82756163548, -302.8878130055\n";
const CONTACT_MOVED: &str = ", QP = -11.079411201749998, -94.82756163548, -302.8878130055\n";

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
        (
            Plant {
                truth: ("link-compliance", "PART/6"),
                edits: vec![(", PART = 6\n, QP = -350.0, -10.50965490998, -9.462935785116\n", ", PART = 906\n, QP = -350.0, -10.50965490998, -9.462935785116\n".to_string())],
                added: "PART/906, QG = 130.0, -345.0, 232.0, REULER = 90.0D, 3.0D, 0.0D\nMARKER/991, PART = 906, QP = -350.0, -10.50965490998, -9.462935785116, REULER = 0, 0, 0\nMARKER/992, PART = 6, QP = -350.0, -10.50965490998, -9.462935785116, REULER = 0, 0, 0\nBUSHING/990, I = 991, J = 992, C = 0, 0, 0, K = 8000, 1E7, 1E7, CT = 0, 0, 0, KT = 1E10, 1E10, 1E10\n".to_string(),
                ..none()
            },
            None,
        ),
        (
            Plant {
                truth: ("load-point-error", "MARKER/19"),
                loads: |_| {},
                edits: vec![(CONTACT, CONTACT_MOVED.to_string())],
                ..none()
            },
            None,
        ),
    ]
}

/// The extended deck alone, solved anew, is the extended fit.
fn reproduces(outcome: &Outcome<'_>, loaded: &LoadedStudy) {
    let source = admire::text::Source::new("extended.adm".to_string(), outcome.extended_deck());
    let dataset = admire::syntax::Dataset::parse(source).value;
    let lowered = admire::model::lower(&dataset);
    assert!(!lowered.has_errors(), "{:?}", lowered.diagnostics);
    let request = SweepRequest {
        dataset: &dataset,
        model: &lowered.value,
        theta: &[],
        programme: &loaded.programme,
    };
    let swept = NativeBackend::new().sweep(&request).unwrap();
    for (case, state) in outcome.extended.states.iter().enumerate() {
        let solved = swept.equilibrium(case).unwrap();
        for (a, b) in solved.poses.iter().zip(&state.poses) {
            assert!((a.p - b.p).norm() < 1e-3, "case {case}: {} {}", a.p, b.p);
        }
    }
}

/// Plants that come first are found; those after them are not held to yet.
const HELD_TO: usize = 8;

#[test]
fn planted_causes_are_named() {
    named(|k| k < HELD_TO);
}

#[test]
#[ignore = "friction, split parts and load points are planted but not held to yet"]
fn further_causes_are_named() {
    named(|k| k >= HELD_TO);
}

fn named(choose: impl Fn(usize) -> bool) {
    let mut wrong = Vec::new();
    for (k, (plant, loads)) in plants().iter().enumerate() {
        if !choose(k) {
            continue;
        }
        let folder = study("pseudo-mcpherson", plant, 0.02, 11 + k as u64, *loads);
        let loaded = LoadedStudy::read(folder.path()).value.unwrap();
        let problem = loaded.problem();
        let started = std::time::Instant::now();
        let outcome: Outcome<'_> =
            diagnose(&problem, held_out(&loaded.study, &loaded.measurement)).unwrap();
        let diagnosis = &outcome.diagnosis;
        println!(
            "{:?}: {:.1} s, {}",
            plant.truth,
            started.elapsed().as_secs_f64(),
            diagnosis.to_json()
        );
        let first = diagnosis.findings.first();
        let named = first.map_or(("", ""), |f| (f.cause.as_str(), f.address.as_str()));
        let among = first.is_some_and(|f| {
            let rivals = &f.indistinguishable_from;
            rivals.len() <= 3
                && rivals
                    .iter()
                    .any(|r| (r.cause.as_str(), r.address.as_str()) == plant.truth)
        });
        if named != plant.truth && !among {
            wrong.push((plant.truth, named.0.to_string(), named.1.to_string()));
        }
        if k >= HELD_TO
            && matches!(
                plant.truth.0,
                "hardpoint-error" | "progressive-stiffness" | "link-compliance"
            )
        {
            reproduces(&outcome, &loaded);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
