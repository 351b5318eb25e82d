//! An arm on two bushings that share an axis, under loads in equal steps.
//!
//! Friction in one bushing, creep of its rubber, and both in the other bushing give nearly the same readings.

use std::path::Path;
use std::process::Command;

use admire_diagnosis::{Cause, Diagnosis, Finding, diagnose, held_out};
use admire_identify::LoadedStudy;

const DECK: &str = "An arm on two bushings that share an axis
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/2, PART = 1, QP = 150, 0, 0, REULER = 90D, 90D, 0D
MARKER/4, PART = 1, QP = -170, 20, 10, REULER = 90D, 90D, 0D
MARKER/18, PART = 1, QP = 10, -250, 400
MARKER/46, PART = 1, REULER = 90D, 90D, 0D
MARKER/47, PART = 1, REULER = 180D, 90D, 180D
MARKER/48, PART = 1
PART/2, MASS = 3, CM = 41, IP = 1E4, 1E4, 1E4
MARKER/1, PART = 2, QP = 150, 0, 0, REULER = 90D, 90D, 0D
MARKER/3, PART = 2, QP = -170, 20, 10, REULER = 90D, 90D, 0D
MARKER/17, PART = 2, QP = 10, -250, 0
MARKER/19, PART = 2, QP = 0, -380, -20
MARKER/41, PART = 2, QP = 0, -180, 0
BUSHING/1, I = 1, J = 2, C = 0, 0, 0, K = 9000, 9000, 1200, CT = 0, 0, 0, KT = 6E5, 6E5, 2E5
BUSHING/2, I = 3, J = 4, C = 0, 0, 0, K = 6000, 6000, 900, CT = 0, 0, 0, KT = 6E5, 6E5, 2E5
SPRINGDAMPER/1, TRANSLATION, I = 17, J = 18, C = 0, K = 60, FORCE = 3000, LENGTH = 400
SFORCE/1, TRANSLATIONAL, I = 19, J = 46, ACTIONONLY, FUNCTION = 0
SFORCE/2, TRANSLATIONAL, I = 19, J = 47, ACTIONONLY, FUNCTION = 0
SFORCE/3, TRANSLATIONAL, I = 19, J = 48, ACTIONONLY, FUNCTION = 2000
ACCGRAV/KGRAV = -9806.65
END
";

const STUDY: &str = "[model]
deck = \"model.adm\"
[loads]
file = \"load_cases.csv\"
columns = { vertical = \"SFORCE/3\", lateral = \"SFORCE/2\", longitudinal = \"SFORCE/1\" }
[marks]
on_parts = \"marks_on_parts.csv\"
measured = \"marks_measured.csv\"
sigma = 0.03
[identify]
bushings = [\"BUSHING/1\", \"BUSHING/2\"]
";

const MARKS: &str = "part,mark,x,y,z
PART/2,1,100,-50,20
PART/2,2,-120,-60,10
PART/2,3,20,-300,30
PART/2,4,-30,-340,-20
";

/// Returns the loads of the study in kilonewtons (vertical, lateral, longitudinal): several loops of equal steps.
fn loops() -> Vec<[f64; 3]> {
    let loop_of = |k: usize| {
        let thousands = [1, 2, 3, 2, 1, 0, -1, -2, -3, -2, -1, 0];
        thousands.map(|t| {
            if k == 0 {
                [2.0, f64::from(t), 0.0]
            } else {
                [2.0, 0.0, f64::from(t)]
            }
        })
    };
    let vertical = [1.5, 2.5, 3.5, 2.5, 1.5].map(|v| [v, 0.0, 0.0]);
    vertical
        .into_iter()
        .chain(loop_of(0))
        .chain(loop_of(1))
        .collect()
}

/// Returns loads without repetition.
fn all_round() -> Vec<[f64; 3]> {
    let levels = [1.0, 2.0, 3.0, -1.0, -2.0, -3.0];
    let vertical = [1.5, 2.5, 3.5, 2.0].map(|v| [v, 0.0, 0.0]);
    let lateral = levels.map(|l| [2.0, l, 0.0]);
    let longitudinal = levels.map(|l| [2.0, 0.0, l]);
    let both = [1.5, -1.5, 2.5, -2.5].map(|l| [2.5, l, -l]);
    let loads = vertical.into_iter().chain(lateral);
    loads.chain(longitudinal).chain(both).collect()
}

/// Writes the study of a deck without readings, for a rig to measure.
fn write(folder: &Path, deck: &str, loads: &[[f64; 3]]) {
    let (mut cases, mut marks) = (
        "case,vertical,lateral,longitudinal\n".to_string(),
        "case,part,mark,x,y,z\n".to_string(),
    );
    for (k, load) in (1..).zip(loads) {
        let [v, l, b] = load.map(|kilonewton| 1000.0 * kilonewton);
        cases += &format!("{k},{v},{l},{b}\n");
        for mark in 1..=4 {
            marks += &format!("{k},PART/2,{mark},0,0,0\n");
        }
    }
    let files = [
        ("model.adm", deck),
        ("study.toml", STUDY),
        ("marks_on_parts.csv", MARKS),
        ("load_cases.csv", &cases),
        ("marks_measured.csv", &marks),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

/// Returns the diagnosis of an arm with these effects, measured by the rig with this seed.
fn diagnosis((deck, loads): (&str, &[[f64; 3]]), effects: &[String], seed: u64) -> Diagnosis {
    let base = tempfile::tempdir().unwrap();
    write(base.path(), deck, loads);
    let out = base.path().join("measured");
    let mut rig = Command::new(env!("CARGO_BIN_EXE_admire"));
    rig.arg("rig").arg(base.path()).arg("--out").arg(&out);
    rig.args(["--seed", &seed.to_string()]);
    rig.args(effects.iter().flat_map(|effect| ["--effect", effect]));
    let done = rig.output().unwrap();
    assert!(done.status.success(), "{done:?}");
    let loaded = LoadedStudy::read(&out).value.unwrap();
    let held = held_out(&loaded.study, &loaded.measurement);
    diagnose(&loaded.problem(), held).unwrap().diagnosis
}

/// Returns the probability of a cause in either bushing, summed over a finding and its rivals.
fn told(finding: &Finding, cause: Cause) -> f64 {
    let rivals = finding.indistinguishable_from.iter();
    let rivals = rivals.map(|r| (r.cause, r.probability));
    let all = std::iter::once((finding.cause, finding.probability)).chain(rivals);
    all.filter(|(of, _)| *of == cause).map(|(_, p)| p).sum()
}

/// Checks that friction is found in each study and is on average more probable than creep.
///
/// It is certain that one of them acts on this axis, but not in which bushing.
#[test]
fn friction_in_equal_steps_is_not_called_creep() {
    let mut sum = 0.0;
    let studies = [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)];
    for (bushing, seed) in studies {
        let effect = format!("dry-friction@BUSHING/{bushing}.K.3:force=300,stiffness=3000");
        let diagnosis = diagnosis((DECK, &loops()), std::slice::from_ref(&effect), seed);
        let [finding] = &diagnosis.findings[..] else {
            panic!("{:#?}", diagnosis.findings);
        };
        let (friction, creep) = (
            told(finding, Cause::DryFriction),
            told(finding, Cause::Creep),
        );
        println!("{effect} {seed}: friction {friction:.2}, creep {creep:.2}");
        assert!(finding.probability < 0.95, "{finding:#?}");
        assert!(finding.group_probability > 0.95, "{finding:#?}");
        assert!(friction > 0.1, "{finding:#?}");
        sum += friction;
    }
    assert!(sum > 0.7 * studies.len() as f64, "{sum}");
}

/// Checks that the estimated rate of creep is the planted one. Here the whole stiffness of a bushing creeps, which is more than usual.
#[test]
fn rubber_flows_at_the_planted_rate() {
    for seed in [1, 2, 3] {
        let diagnosis = diagnosis(
            (DECK, &loops()),
            &["creep@BUSHING/1.K.3:rate=0.15".to_string()],
            seed,
        );
        let finding = &diagnosis.findings[0];
        assert!(told(finding, Cause::Creep) > 0.9, "{finding:#?}");
        let (rate, error) = (finding.parameters["rate"], finding.std_error["rate"]);
        println!("{} {rate} +- {error}", finding.address);
        assert!((rate - 0.15).abs() < 3.0 * error, "{rate} +- {error}");
        assert!(error < 0.05, "{error}");
    }
}

/// Checks progressive rubber along two axes of two bushings. The bushings are rotated relative to the loads, so that all axes are loaded.
#[test]
fn rubber_that_is_progressive_along_two_axes_of_two_bushings() {
    let deck = DECK
        .replace(
            "QP = 150, 0, 0, REULER = 90D, 90D, 0D",
            "QP = 150, 0, 0, REULER = 90D, 90D, 40D",
        )
        .replace(
            "QP = -170, 20, 10, REULER = 90D, 90D, 0D",
            "QP = -170, 20, 10, REULER = 90D, 90D, -35D",
        )
        .replace("K = 9000, 9000, 1200", "K = 1500, 1200, 1200")
        .replace("K = 6000, 6000, 900", "K = 1100, 1600, 900");
    let planted = [
        ("1.K.1", 300),
        ("1.K.2", 250),
        ("2.K.1", 200),
        ("2.K.2", 300),
    ];
    let effects = planted
        .map(|(at, cubic)| format!("progressive-stiffness@BUSHING/{at}:law=cubic,cubic={cubic}"));
    for seed in [1, 2, 3] {
        let diagnosis = diagnosis((&deck, &all_round()), &effects, seed);
        let mut found: Vec<(Cause, &str)> = Vec::new();
        for finding in &diagnosis.findings {
            assert!(finding.probability > 0.9, "{finding:#?}");
            found.push((finding.cause, &finding.address));
        }
        found.sort_by_key(|(_, at)| *at);
        let expected = planted.map(|(at, _)| format!("BUSHING/{at}"));
        let expected: Vec<_> = expected
            .iter()
            .map(|at| (Cause::ProgressiveStiffness, at.as_str()))
            .collect();
        assert_eq!(found, expected, "seed {seed}");
    }
}
