//! Bootstrap and posterior sampling, compared with closed forms. The bytes must not depend on the number of threads or on interruptions.

use std::path::Path;
use std::process::Command;

use admire_sweep::{Stream, normal};

/// A block on a bushing at its own centre, pushed along three axes.
const BLOCK: &str = "block
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1
MARKER/11,PART=1,REULER=90D,90D,0D
MARKER/12,PART=1,REULER=180D,90D,180D
PART/2,MASS=1,CM=2,IP=1,1,1
MARKER/2,PART=2
BUSHING/1,I=2,J=1,C=0,0,0,K=1000,1000,1000,CT=0,0,0,KT=1E8,1E8,1E8
SFORCE/1,TRANSLATIONAL,ACTIONONLY,I=2,J=11,FUNCTION=0
SFORCE/2,TRANSLATIONAL,ACTIONONLY,I=2,J=12,FUNCTION=0
SFORCE/3,TRANSLATIONAL,ACTIONONLY,I=2,J=1,FUNCTION=0
RESULTS/XRF
END
";
const TRUE: [f64; 3] = [700.0, 1100.0, 2000.0];
const SIGMA: f64 = 0.05;
const MARKS: usize = 6;
const FRAME: f64 = 0.01;

/// Writes the study, and returns the forces of each case along the three axes. In every case, the measuring frame has an unknown shift, which is
/// marginalised. All tolerances are off.
fn study(folder: &Path) -> Vec<[f64; 3]> {
    study_with(
        folder,
        &format!("frame_sd = {{ length = {FRAME}, angle_deg = 0.0 }}\n"),
    )
}

fn study_with(folder: &Path, more: &str) -> Vec<[f64; 3]> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("model.adm", BLOCK);
    let mut cases = Vec::new();
    for axis in 0..3 {
        for force in [-1500.0, -750.0, 750.0, 1500.0] {
            let mut case = [0.0; 3];
            case[axis] = force;
            cases.push(case);
        }
    }
    let (mut loads, mut on_parts) = ("case,x,y,z\n".to_string(), "part,mark,x,y,z\n".to_string());
    let mut measured = "case,part,mark,x,y,z\n".to_string();
    let place = |mark: usize| [100.0, 30.0, -70.0].map(|a: f64| a * (mark as f64 * a).sin());
    for mark in 0..MARKS {
        let [x, y, z] = place(mark);
        on_parts += &format!("2,{mark},{x:.9},{y:.9},{z:.9}\n");
    }
    let noise = Stream::named(1, "readings");
    let mut next = 0;
    let mut error = || {
        next += 1;
        SIGMA * normal::quantile(noise.uniform(next))
    };
    for (number, case) in cases.iter().enumerate() {
        loads += &format!("{number},{},{},{}\n", case[0], case[1], case[2]);
        for mark in 0..MARKS {
            let at = place(mark);
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + case[axis] / TRUE[axis] + error());
            measured += &format!("{number},2,{mark},{x:.9},{y:.9},{z:.9}\n");
        }
    }
    write("loads.csv", &loads);
    write("on_parts.csv", &on_parts);
    write("measured.csv", &measured);
    write(
        "study.toml",
        &format!(
            "[model]\ndeck = \"model.adm\"\n[loads]\nfile = \"loads.csv\"\ncolumns = {{ x = \"SFORCE/1\", y = \"SFORCE/2\", z = \"SFORCE/3\" }}\n\
             [marks]\non_parts = \"on_parts.csv\"\nmeasured = \"measured.csv\"\nsigma = {SIGMA}\n\
             [identify]\nbushings = []\nstiffnesses = [\"BUSHING/1.K.1\", \"BUSHING/1.K.2\", \"BUSHING/1.K.3\"]\n\
             offset_sd = {{ length = 0.0, angle_deg = 0.0 }}\n{more}"
        ),
    );
    cases
}

fn identify(folder: &Path, out: &str, more: &[&str]) -> (serde_json::Value, Vec<u8>) {
    let ran = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(["identify", ".", "--out", out])
        .args(more)
        .env("SOURCE_DATE_EPOCH", "951827696")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    let text = std::fs::read(folder.join(out).join("identification.json")).unwrap();
    (serde_json::from_slice(&text).unwrap(), ran.stdout)
}

#[test]
fn bootstrap_and_posterior_have_the_spread_of_the_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let cases = study(folder.path());
    let options = ["--bootstrap", "2000", "--posterior", "2000"];
    let (answer, _) = identify(folder.path(), "out", &options);
    let noise_ratio = answer["bootstrap"]["noise_ratio"].as_f64().unwrap();
    // The ratio of the residuals to the stated noise is one, within the uncertainty of their number.
    assert!(
        (noise_ratio - 1.0).abs() < 4.0 / f64::sqrt(2.0 * 216.0),
        "{noise_ratio}"
    );
    for axis in 0..3 {
        let found = &answer["parameters"][axis];
        let value = found["value"].as_f64().unwrap();
        // The displacement is u = F / K, so its derivative by ln K is -u. All marks of a case read it, and they share the shift of the frame.
        let squares: f64 = cases.iter().map(|case| (case[axis] / value).powi(2)).sum();
        let sd = ((SIGMA.powi(2) / MARKS as f64 + FRAME.powi(2)) / squares).sqrt();
        let relative = |key: &str| found[key]["std_error"].as_f64().unwrap() / value / sd;
        let spread = 4.0 / f64::sqrt(2.0 * 2000.0);
        assert!(
            (relative("bootstrap") / noise_ratio - 1.0).abs() < spread,
            "bootstrap {}",
            relative("bootstrap")
        );
        let worth = found["posterior"]["effective_draws"].as_f64().unwrap();
        assert!(worth > 1000.0, "{worth}");
        let spread = 4.0 / f64::sqrt(2.0 * worth);
        assert!(
            (relative("posterior") - 1.0).abs() < spread,
            "posterior {}",
            relative("posterior")
        );
        for (key, scale, n) in [
            ("bootstrap", noise_ratio, 2000.0),
            ("posterior", 1.0, worth),
        ] {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let end = found[key]["interval95"][side].as_f64().unwrap();
                let expected = sign * 1.959_964 * scale;
                // The 97.5 percent quantile of n normal draws has a standard error of 2.67 / sqrt(n).
                let off = (end / value).ln() / sd - expected;
                assert!(
                    off.abs() < 4.0 * 2.67 / f64::sqrt(n) + 0.05,
                    "{key} {side}: {off}"
                );
            }
            let ratio = found[key]["width_ratio"].as_f64().unwrap();
            assert!((ratio / scale - 1.0).abs() < 0.12, "{key}: {ratio}");
        }
        let r_hat = found["posterior"]["r_hat"].as_f64().unwrap();
        assert!((r_hat - 1.0).abs() < 0.02, "{r_hat}");
    }
}

/// Checks a tolerance that no reading can separate from the result: the gain error of a load is equivalent to an error of the stiffness along
/// it.
#[test]
fn tolerances_widen_both_as_the_closed_form_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let gain = 0.03;
    let cases = study_with(
        folder.path(),
        &format!(
            "[tolerances]\nload_gain = {gain}\nload_direction_deg = 0\nhardpoints = 0\nmarks_on_parts = 0\npose = 0\nload_repeatability = 0\nalignment = 0\nmount = 0\n"
        ),
    );
    let options = ["--bootstrap", "1000", "--posterior", "1000"];
    let (answer, _) = identify(folder.path(), "out", &options);
    let noise_ratio = answer["bootstrap"]["noise_ratio"].as_f64().unwrap();
    for axis in 0..3 {
        let found = &answer["parameters"][axis];
        let value = found["value"].as_f64().unwrap();
        let squares: f64 = cases.iter().map(|case| (case[axis] / value).powi(2)).sum();
        let noise = SIGMA / (MARKS as f64 * squares).sqrt();
        let sd = noise.hypot(gain);
        assert!(sd > 2.0 * noise, "the tolerance decides");
        let worth = found["posterior"]["effective_draws"].as_f64().unwrap();
        assert!(worth > 500.0, "{worth}");
        for (key, scale, n) in [
            ("bootstrap", noise_ratio, 1000.0),
            ("posterior", 1.0, worth),
        ] {
            let relative = found[key]["std_error"].as_f64().unwrap() / value / sd / scale;
            assert!(
                (relative - 1.0).abs() < 4.0 / f64::sqrt(2.0 * n),
                "{key}: {relative}"
            );
        }
    }
}

#[test]
fn repeats_are_the_same_on_any_number_of_threads_and_after_an_end_in_the_middle() {
    let folder = tempfile::tempdir().unwrap();
    study(folder.path());
    let options = ["--bootstrap", "300", "--posterior", "304", "--jobs"];
    let run = |out: &str, jobs: &str| {
        let options: Vec<&str> = options.into_iter().chain([jobs]).collect();
        identify(folder.path(), out, &options);
        std::fs::read(folder.path().join(out).join("identification.json")).unwrap()
    };
    let one = run("one", "1");
    assert!(one == run("four", "4"), "other threads, other bytes");
    // A killed run leaves its journal, and the next run continues from it. Here, the journal of the posterior sampling arises from runs that are
    // ended early.
    let mut seen = 0;
    for wait in [150, 250, 350, 500, 700] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(["identify", ".", "--out", "killed"])
            .args(&options[..4])
            .args(["--jobs", "2"])
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait));
        let _ = child.kill();
        child.wait().unwrap();
        seen += usize::from(folder.path().join("killed/unfinished").is_dir());
    }
    println!("{seen} runs were killed while they repeated");
    assert!(
        one == run("killed", "3"),
        "a run that was killed has other bytes"
    );
    assert!(!folder.path().join("killed/unfinished").exists());
}

#[test]
fn what_cannot_be_repeated_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    study(folder.path());
    for (options, code, message) in [
        (["--bootstrap", "5"], 2, "100"),
        (["--posterior", "none"], 2, "invalid value"),
    ] {
        let ran = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(["identify", ".", "--out", "out"])
            .args(options)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(code), "{said}");
        assert!(said.contains(message), "{said}");
    }
    let ran = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder.path())
        .args([
            "identify",
            ".",
            "--out",
            "out",
            "--method",
            "direct",
            "--bootstrap",
            "200",
        ])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(said.contains("gauss-newton"), "{said}");
    assert!(!folder.path().join("out").exists());
}
