//! Motions without resistance: neither the predictions nor the results of any solver depend on the positions along them.

use std::path::{Path, PathBuf};
use std::process::Command;

use admire::{Identification, SharedProgress, Study};
use admire_identify::global::{Options, Prepared, fit_study};
use admire_identify::{FitVerdict, LoadedStudy, compare};
use admire_session::backend::{Backend, BackendError, NativeBackend, Sweep, SweepRequest};
use admire_solver::mechanics::{Vec3, exp};
use admire_solver::statics::Balance;

use crate::setup::{copy, replace};

/// Measures the shipped McPherson on the virtual rig, with its reference deck as the reality and with `effects`.
fn measured(change: impl Fn(&Path), effects: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let (folder, path) = copy("pseudo-mcpherson");
    std::fs::rename(path.join("reference.adm"), path.join("model.adm")).unwrap();
    let reference = "[reference]\ndeck = \"reference.adm\"\n";
    replace(&path, "study.toml", reference, "");
    change(&path);
    let out = path.join("measured");
    let mut rig = Command::new(env!("CARGO_BIN_EXE_admire"));
    rig.arg("rig").arg(&path).arg("--out").arg(&out);
    rig.args(["--programme", "up-and-down"]);
    for effect in effects {
        rig.args(["--effect", effect]);
    }
    let done = rig.output().unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    (folder, out)
}

/// Puts ball joints at both ends of the tie rod.
fn spins(folder: &Path) {
    let inner = "JOINT/5\n, UNIVERSAL";
    replace(folder, "model.adm", inner, "JOINT/5\n, SPHERICAL");
}

/// Splits the tie rod into two parts with marks, which spin together if the rod has ball joints.
fn in_two(folder: &Path) {
    let end = "MARKER/15\n, PART = 6\n";
    replace(folder, "model.adm", end, "MARKER/15\n, PART = 50\n");
    let inner = "JOINT/5\n";
    let middle = "-175.0, -5.25482745499, -4.731467892558";
    let more = format!(
        "PART/50, QG = 130.0, -345.0, 232.0, REULER = 90.0D, 3.0D, 0.0D, MASS = 0.2, CM = 53, IP = 1.0E+03, 1.0E+03, 1.0E+03\n\
         MARKER/51, PART = 6, QP = {middle}\nMARKER/52, PART = 50, QP = {middle}\nMARKER/53, PART = 50, QP = 0, 0, 0\n\
         JOINT/50, FIXED, I = 51, J = 52\n{inner}"
    );
    replace(folder, "model.adm", inner, &more);
    let marks = folder.join("marks_on_parts.csv");
    let mut text = std::fs::read_to_string(&marks).unwrap();
    for (mark, place) in [
        (1, "-20.0, 18.0, 4.0"),
        (2, "-60.0, -15.0, 9.0"),
        (3, "-90.0, 6.0, -21.0"),
        (4, "-120.0, -9.0, 14.0"),
    ] {
        text += &format!("PART/50,{mark},{place}\n");
    }
    std::fs::write(marks, text).unwrap();
}

fn spins_in_two(folder: &Path) {
    in_two(folder);
    spins(folder);
}

fn identified(folder: &Path) -> Identification {
    let study = Study::open(folder).unwrap();
    study.identify(false, &SharedProgress::default()).unwrap()
}

/// Checks that estimates and intervals equal those of a rod that cannot spin, with the same noise.
#[test]
fn a_link_that_spins_is_as_good_as_one_that_is_held() {
    let nothing: fn(&Path) = |_| {};
    for (held, free) in [(nothing, spins as fn(&Path)), (in_two, spins_in_two)] {
        let (_a, folder) = measured(held, &[]);
        let held = identified(&folder).fit;
        let (_b, folder) = measured(free, &[]);
        let free = identified(&folder).fit;
        assert!(free.converged);
        let test = free.fit_test.as_ref().unwrap();
        assert_eq!(test.verdict, FitVerdict::Noise, "{test:?}");
        let mut compared = 0;
        for (a, b) in held.parameters.iter().zip(&free.parameters) {
            let share = |p: &admire::fit::ParameterFit| p.std_error.unwrap() / p.value;
            // The interval of a poorly determined parameter depends on its estimated value.
            if share(a) > 0.1 {
                continue;
            }
            compared += 1;
            let wider = share(b) / share(a);
            assert!((wider - 1.0).abs() < 0.1, "{}: {wider}", a.address);
            let apart = (b.value / a.value).ln() / share(a);
            assert!(apart.abs() < 1.0, "{}: {apart}", a.address);
        }
        assert!(compared > 1, "{compared}");
    }
}

/// Checks that a compliant tie rod is found with the same probability whether it can spin or not, and that its deck keeps its masses.
#[test]
fn a_cause_in_a_link_that_spins_is_as_probable_as_in_one_that_is_held() {
    let yields = ["link-compliance@PART/6:stiffness=6000"];
    let nothing: fn(&Path) = |_| {};
    let found = [nothing, spins].map(|change| {
        let (_folder, folder) = measured(change, &yields);
        let study = Study::open(&folder).unwrap();
        let answer = study.diagnose(false, &SharedProgress::default()).unwrap();
        let first = answer
            .diagnosis
            .findings
            .first()
            .expect("a finding")
            .clone();
        let deck = String::from_utf8(answer.deck).unwrap();
        assert!(deck.contains("MASS = 0.9") && deck.contains("MASS = 14.0"));
        first
    });
    let [held, free] = &found;
    assert_eq!((held.cause, &held.address), (free.cause, &free.address));
    let apart = held.probability - free.probability;
    assert!(apart.abs() < 0.1, "{apart}");
    assert!(free.group_probability > 0.95);
    let compliance = |of: &admire::diagnosis::Finding| of.parameters["compliance"] * 6000.0;
    assert!(
        (compliance(free) - compliance(held)).abs() < 0.1,
        "{found:?}"
    );
}

/// Checks that `check` names the motion, and that repeated loads show the noise of the marks, 0.05 mm.
#[test]
fn check_says_what_is_ignored() {
    for (change, name) in [
        (
            spins as fn(&Path),
            "TIE_ROD spins freely; its rotation about its own axis is ignored",
        ),
        (spins_in_two, "this motion is ignored"),
    ] {
        let (_folder, study) = measured(change, &[]);
        let mut check = Command::new(env!("CARGO_BIN_EXE_admire"));
        let done = check.arg("check").arg(&study).output().unwrap();
        let both = [done.stdout, done.stderr].concat();
        let text = String::from_utf8(both).unwrap();
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(name), "{text}");
        assert!(text.contains("in repeated cases 0.05"), "{text}");
    }
}

/// Solver that leaves the tie rod rotated by an arbitrary angle.
#[derive(Debug)]
struct Spun {
    solver: NativeBackend,
    turned: f64,
}

impl Backend for Spun {
    fn name(&self) -> &'static str {
        "spun"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let mut sweep = self.solver.sweep(request)?;
        let model = request.model;
        let [a, b] = [13, 15].map(|id| model.marker(id).unwrap());
        let part = model.markers[a.0].part.0;
        for found in sweep.cases.iter_mut().flatten() {
            // The angle differs for every case.
            self.turned = (self.turned * 7.3 + 0.2) % 0.9;
            let pose = &mut found.poses[part];
            let [a, b] = [a, b].map(|marker| pose.point(&model.markers[marker.0].qp));
            let turn = exp(&(self.turned * (b - a).normalize()));
            pose.p = a + turn * (pose.p - a);
            pose.R = turn * pose.R;
        }
        Ok(sweep)
    }

    fn balance(&self) -> Option<&Balance> {
        self.solver.balance()
    }
}

fn spun() -> Spun {
    Spun {
        solver: NativeBackend::new(),
        turned: 0.4,
    }
}

#[test]
fn nothing_depends_on_where_a_solver_leaves_the_link() {
    let (_folder, study) = measured(spins, &[]);
    let loaded = LoadedStudy::read(&study).value.unwrap();
    let problem = loaded.problem();
    let values = problem.initial();
    let own = problem.sweep(&mut NativeBackend::new(), &values).unwrap();
    let other = problem.sweep(&mut spun(), &values).unwrap();
    let cases = || 0..loaded.measurement.cases.len();
    let rms = |sweep| {
        let found = compare(&loaded.model, &loaded.measurement, sweep, cases());
        found.marks_rms.unwrap()
    };
    let apart = rms(&own) - rms(&other);
    assert!(apart.abs() < 1e-4, "{apart}");
    let mut worst = 0.0_f64;
    for case in cases() {
        let poses = |sweep: &Sweep| sweep.equilibrium(case).unwrap().poses.clone();
        for (a, b) in poses(&own).iter().zip(&poses(&other)) {
            let far = Vec3::new(-200.0, 30.0, 30.0);
            worst = worst.max((a.point(&far) - b.point(&far)).norm());
        }
    }
    assert!(worst < 0.02, "{worst}");

    let prepared = Prepared::new(&problem).unwrap();
    let native = fit_study(&problem, &prepared, None, Options::default()).unwrap();
    let mut solver = spun();
    let options = Options::default();
    let by_other = fit_study(&problem, &prepared, Some(&mut solver), options).unwrap();
    for (a, b) in native.fit.parameters.iter().zip(&by_other.fit.parameters) {
        let sd = a.std_error.unwrap() / a.value;
        let apart = (a.value / b.value).ln() / sd;
        assert!(apart.abs() < 0.1, "{}: {apart}", a.address);
    }
}

/// Checks that the stated errors before and after the fit are those of the two decks on their own.
#[test]
fn errors_are_those_of_the_decks_that_are_written() {
    let (_folder, study) = measured(spins, &[]);
    let fit = identified(&study).fit;
    let loaded = LoadedStudy::read(&study).value.unwrap();
    let problem = loaded.problem();
    let written = fit.written.unwrap();
    let said = [written.marks_rms_before, written.marks_rms_after];
    for (values, said) in [problem.initial(), fit.values()].iter().zip(said) {
        let sweep = problem.sweep(&mut NativeBackend::new(), values).unwrap();
        let cases = problem.measurement.fitted_cases();
        let found = compare(problem.model, problem.measurement, &sweep, cases);
        let rms = found.marks_rms.unwrap();
        assert!((rms / said - 1.0).abs() < 1e-3, "{rms} {said}");
    }
}
