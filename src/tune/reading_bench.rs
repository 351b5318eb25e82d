//! Tests of forces and readings of load cases on the pseudo McPherson axle. Values are compared with the poses of a sweep, and derivatives
//! with finite differences.

use std::path::Path;

use crate::Tuning;
use crate::bench::{corpus, study};
use crate::evaluation::Evaluator;
use crate::force_bench::assert_derivatives;
use admire_identify::LoadedStudy;
use admire_identify::marker_pose;
use admire_session::backend::{Backend, NativeBackend, SweepRequest};
use admire_solver::model::MarkerIx;

/// Section `[target]` that reads everything available in a load case of the pseudo McPherson axle.
const MCPHERSON: &str = r#"
[loads]
file = "load_cases.csv"
columns = { vertical = "SFORCE/3", lateral = "SFORCE/2", longitudinal = "SFORCE/1" }
[marks]
on_parts = "marks_on_parts.csv"
measured = "marks_measured.csv"
sigma = 0.05
[wheel]
marker = "MARKER/20"
[readings]
file = "readings.csv"
[readings.channels]
spring = { function = "SPDP(1,0,4,0)", sigma = 1.0, unit = "N" }
top = { function = "DZ(5)", sigma = 1.0, relative_to = "previous" }
[tolerances]
hardpoints = 0.1
axes_deg = 0.1
[target]
restarts = 0
[[target.unknown]]
numbers = ["BUSHING/1.K.1", "BUSHING/3.K.3", "SPRINGDAMPER/1.K"]
form = "factor"
bounds = [0.5, 2.0]
[[target.unknown]]
numbers = ["MARKER/16.QP"]
bounds = ["-5 mm", "5 mm"]
[[target.unknown]]
numbers = ["MARKER/20.QP.2"]
alone = true
bounds = ["-5 mm", "5 mm"]
"#;

/// Reads a study of the pseudo McPherson axle in load case 6, with a goal for each reading.
fn mcpherson(folder: &Path, of: &[&str]) -> Tuning {
    for name in ["load_cases.csv", "marks_on_parts.csv", "marks_measured.csv"] {
        let bytes = corpus(&format!("pseudo-mcpherson/{name}"));
        std::fs::write(folder.join(name), bytes).expect(name);
    }
    std::fs::write(
        folder.join("readings.csv"),
        "case,spring,top\n1,0,0\n2,0,0\n",
    )
    .expect("readings");
    let goals = of.iter().map(|of| {
        format!("[[target.goal]]\ncase = \"6\"\nof = \"{of}\"\nvalue = 0\ntolerance = 1\n")
    });
    let target = format!("{MCPHERSON}{}", goals.collect::<String>());
    let deck = corpus("pseudo-mcpherson/model.adm");
    study(folder, &deck, "value\n", &target, "")
}

/// Checks the readings of a load case against the poses of a sweep of the study. The readings are positions of markers and marks, wheel
/// readings as defined by the measurement, and the spring force by its law. The load follows from the force balance of the knuckle.
#[test]
fn readings_of_a_load_case_are_those_of_the_sweep() {
    let of = [
        "MARKER/20.X",
        "MARKER/20.Z",
        "FRONT_ARM 2.Y",
        "wheel.y",
        "wheel.camber_deg",
        "wheel.steer_deg",
        "SPRINGDAMPER/1.FM",
        "spring",
        "SFORCE/3.FZ",
        "top",
        "COIL.FZ",
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let tuning = mcpherson(folder.path(), &of);
    let value = |name: &str| {
        let goal = tuning.goals.iter().find(|goal| goal.of == name);
        let goal = goal.expect(name);
        goal.value(&goal.rows[0], &tuning.before)
    };
    let read = LoadedStudy::read(folder.path());
    let own = read
        .value
        .unwrap_or_else(|| panic!("{:#?}", read.diagnostics));
    let request = SweepRequest {
        dataset: &own.dataset,
        model: &own.model,
        theta: &[],
        programme: &own.programme,
    };
    let sweep = NativeBackend::new().sweep(&request).expect("a sweep");
    let case = own.measurement.case("6").expect("case 6");
    let poses = &sweep.equilibrium(case).expect("an equilibrium").poses;
    let before = &sweep.equilibrium(case - 1).expect("an equilibrium").poses;
    let marker = |id: u32| -> MarkerIx { own.model.marker(id).expect("a marker") };
    let place = |id: u32| marker_pose(&own.model, poses, marker(id)).p;
    let near = |name: &str, wanted: f64| {
        let found = value(name);
        assert!(
            (found - wanted).abs() < 1e-6 * wanted.abs().max(1.0),
            "{name}: {found} {wanted}"
        );
    };
    near("MARKER/20.X", place(20).x);
    near("MARKER/20.Z", place(20).z);
    near("wheel.y", place(20).y);
    let arm = own
        .measurement
        .parts
        .iter()
        .find(|part| part.name == "FRONT_ARM");
    let arm = arm.expect("the arm");
    let mark = arm
        .marks
        .iter()
        .find(|mark| mark.label == "2")
        .expect("its mark");
    near("FRONT_ARM 2.Y", poses[arm.part.0].point(&mark.p).y);
    let wheel = own.measurement.wheel.as_ref().expect("a wheel");
    let now = wheel
        .spin
        .reading(&marker_pose(&own.model, poses, wheel.marker));
    near("wheel.camber_deg", now.camber_deg);
    near("wheel.steer_deg", now.steer_deg);
    let along = place(18) - place(17);
    let force = 4700.0 + 60.0 * (261.738_040_359_5 - along.norm());
    near("SPRINGDAMPER/1.FM", force);
    near("spring", force * along.z / along.norm());
    near("COIL.FZ", force * along.z / along.norm());
    near("SFORCE/3.FZ", own.programme.cases[case].values[0]);
    let top = place(5).z - marker_pose(&own.model, before, marker(5)).p.z;
    near("top", top);
}

/// Checks the derivatives of all kinds of readings in a load case against finite differences.
#[test]
fn derivatives_in_load_cases_are_those_of_differences() {
    let of = [
        "BUSHING/1.FX",
        "BUSHING/3.TM",
        "JOINT/1.FZ",
        "JOINT/3.FM",
        "SPRINGDAMPER/1.FZ",
        "MARKER/20.Y",
        "MARKER/20.AX",
        "FRONT_ARM 2.Z",
        "wheel.camber_deg",
        "wheel.steer_deg",
        "spring",
        "top",
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let tuning = mcpherson(folder.path(), &of);
    assert_eq!(tuning.goals.len(), of.len());
    assert_eq!(tuning.before.cases.len(), 2);
    assert_derivatives(&tuning, 2e-5);
}

/// Checks the effect of the axle's tolerances on forces and readings of a load case and of a test against central differences. The
/// tolerances are those of hardpoints, axes of bushings and joints, preloads and spring rates.
#[test]
fn changes_by_tolerances_are_those_of_differences() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = [
        "BUSHING/1.FX",
        "JOINT/3.FM",
        "FRONT_ARM 2.Z",
        "wheel.camber_deg",
        "spring",
    ];
    let axle = mcpherson(folder.path(), &of);
    let folder = tempfile::tempdir().expect("a folder");
    let target = "[tolerances]\nhardpoints = 0.1\naxes_deg = 0.1\n[target]\n\
        [[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.FORCE\"]\nform = \"factor\"\nbounds = [0.5, 2.0]\n\
        [[target.goal]]\ntest = \"ride\"\nof = \"BUSHING/1.FX\"\nvalue = 0\ntolerance = 1\n\
        [[target.goal]]\ntest = \"lateral\"\nof = \"BUSHING/2.TM\"\nvalue = 0\nat = 1000\ntolerance = 1\n";
    let kc = String::from_utf8(corpus("multilink/kc.toml")).expect("text");
    let deck = corpus("multilink/model.adm");
    let rigged = study(folder.path(), &deck, "value\n", target, &kc);
    for tuning in [&axle, &rigged] {
        let mut evaluator = Evaluator::new(tuning);
        let scatter = evaluator
            .scattered(&tuning.start())
            .expect("an equilibrium");
        let count = scatter.tolerances.len();
        assert!(count > 20);
        let sd = scatter.sd();
        let mut turned = 0;
        for (k, tolerance) in scatter.tolerances.iter().enumerate().step_by(3) {
            turned += usize::from(!tolerance.change.turns.is_empty());
            let mut values = |z: f64| {
                let mut all = vec![0.0; count];
                all[k] = z;
                let found = evaluator.drawn(&scatter.dataset, &scatter.tolerances, &all);
                found.expect("an equilibrium")
            };
            let (plus, minus) = (values(0.1), values(-0.1));
            for (row, sd) in sd.iter().enumerate() {
                let difference = (plus[row] - minus[row]) / 0.2;
                let exact = scatter.columns[(row, k)];
                let what = (&tolerance.element, tuning.goals[row].name());
                assert!(
                    (difference - exact).abs() < 1e-4 * sd,
                    "{what:?}: {difference} {exact} {sd}"
                );
            }
        }
        assert!(turned > 0);
    }
}
