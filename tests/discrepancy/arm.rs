//! An arm on two bushings that share an axis, in loads of equal steps: friction in one of them, rubber that flows, and both again in the
//! other bushing are nearly the same readings.

use std::path::Path;
use std::process::Command;

use admire::discrepancy::{Cause, Diagnosis, Finding, diagnose, held_out};
use admire::identify::LoadedStudy;

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

/// The study without readings, for a rig to measure.
fn write(folder: &Path) {
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
    let loads = vertical.into_iter().chain(loop_of(0)).chain(loop_of(1));
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
        ("model.adm", DECK),
        ("study.toml", STUDY),
        ("marks_on_parts.csv", MARKS),
        ("load_cases.csv", &cases),
        ("marks_measured.csv", &marks),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

/// What is found on the arm with one effect, as the rig reads it with this seed.
fn diagnosis(effect: &str, seed: u64) -> Diagnosis {
    let base = tempfile::tempdir().unwrap();
    write(base.path());
    let out = base.path().join("measured");
    let mut rig = Command::new(env!("CARGO_BIN_EXE_admire"));
    rig.arg("rig").arg(base.path()).arg("--out").arg(&out);
    rig.args(["--seed", &seed.to_string(), "--effect", effect]);
    let done = rig.output().unwrap();
    assert!(done.status.success(), "{done:?}");
    let loaded = LoadedStudy::read(&out).value.unwrap();
    let held = held_out(&loaded.study, &loaded.measurement);
    diagnose(&loaded.problem(), held).unwrap().diagnosis
}

/// The probability of a cause in either bushing, as a finding and its rivals tell it.
fn told(finding: &Finding, cause: Cause) -> f64 {
    let rivals = finding.indistinguishable_from.iter();
    let rivals = rivals.map(|r| (r.cause, r.probability));
    let all = std::iter::once((finding.cause, finding.probability)).chain(rivals);
    all.filter(|(of, _)| *of == cause).map(|(_, p)| p).sum()
}

/// Friction is told in each study, and more probable than rubber that flows on the whole. That one of them acts on this axis is sure, in which
/// bushing is not.
#[test]
fn friction_in_equal_steps_is_not_called_creep() {
    let mut sum = 0.0;
    let studies = [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)];
    for (bushing, seed) in studies {
        let effect = format!("dry-friction@BUSHING/{bushing}.K.3:force=300,stiffness=3000");
        let diagnosis = diagnosis(&effect, seed);
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

/// The rate that rubber flows with is the one that was planted. A bushing's whole stiffness flows here, more than is usual.
#[test]
fn rubber_flows_at_the_planted_rate() {
    for seed in [1, 2, 3] {
        let diagnosis = diagnosis("creep@BUSHING/1.K.3:rate=0.15", seed);
        let finding = &diagnosis.findings[0];
        assert!(told(finding, Cause::Creep) > 0.9, "{finding:#?}");
        let (rate, error) = (finding.parameters["rate"], finding.std_error["rate"]);
        println!("{} {rate} +- {error}", finding.address);
        assert!((rate - 0.15).abs() < 3.0 * error, "{rate} +- {error}");
        assert!(error < 0.05, "{error}");
    }
}
