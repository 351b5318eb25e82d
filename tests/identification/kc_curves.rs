//! Curves of a K&C rig as measurements: their definition, the reader of their file, and stiffnesses identified from them alone.

use std::path::{Path, PathBuf};

use admire_identify::LoadedStudy;
use admire_rig::effect::EffectSpec;
use admire_rig::{RigOptions, RigRun, Tolerances, virtual_rig};

use crate::setup::replace;

fn rigs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/rigs/kc-curves")
}

/// Copies the shipped rig, with further lines in its study.
fn folder(more: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["model.adm", "kc.csv", "study.toml"] {
        std::fs::copy(rigs().join(name), folder.path().join(name)).unwrap();
    }
    let toml = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    std::fs::write(folder.path().join("study.toml"), toml + more).unwrap();
    folder
}

fn written(run: &RigRun, to: &Path) {
    for (name, bytes) in &run.files {
        std::fs::write(to.join(name), bytes).unwrap();
    }
}

fn columns(run: &RigRun, name: &str) -> Vec<Vec<f64>> {
    let found = run.files.iter().find(|(path, _)| path == Path::new(name));
    let text = String::from_utf8(found.unwrap().1.clone()).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    (0..rows[0].len())
        .map(|k| rows.iter().map(|row| row[k]).collect())
        .collect()
}

/// Checks the curves against the section for the wheel, which has separate code. Its angles are relative to the design position and right-handed
/// about z; its position is absolute.
#[test]
fn curves_are_those_of_the_wheel() {
    let wheel = "[wheel]\nmarker = \"MARKER/20\"\naxis = \"y\"\n";
    let tilt = "[readings]\nfile = \"readings.csv\"\n[readings.channels]\n\
                rear = { function = \"DX(20)\", sigma = 1.0 }\n";
    let folder = folder(&format!("{wheel}{tilt}"));
    std::fs::write(folder.path().join("readings.csv"), "case,rear\n").unwrap();
    // A soft bushing moves the wheel far from design, where the tie rod rotates as well.
    let effects = ["element-parameter@BUSHING/2.K.2:factor=0.1"];
    let options = RigOptions {
        sigma: Some(0.0),
        effects: effects.map(|e| EffectSpec::parse(e).unwrap()).to_vec(),
        ..RigOptions::default()
    };
    let run = virtual_rig(folder.path(), &options).unwrap_or_else(|why| panic!("{why:#?}"));
    let (kc, wheel) = (columns(&run, "kc.csv"), columns(&run, "wheel.csv"));
    let rear = columns(&run, "readings.csv");
    assert_eq!(kc[0].len(), 47);
    let since = |column: &[f64], k: usize| column[k] - column[0];
    let mut widest = [0.0_f64; 6];
    for k in 0..47 {
        let [x, y, z, camber, steer] = [1, 2, 3, 4, 5].map(|c| since(&wheel[c], k));
        // For a left wheel, toe-in is a rotation to the right, against z.
        let expected = [-steer, camber, f64::NAN, z, x, y];
        for (curve, expected) in expected.into_iter().enumerate() {
            let found = kc[4 + curve][k];
            if expected.is_finite() {
                assert!(
                    (found - expected).abs() < 2e-7,
                    "{k} {curve}: {found} {expected}"
                );
            }
            widest[curve] = widest[curve].max(found.abs());
        }
        assert!((since(&rear[1], k) - x).abs() < 2e-7);
    }
    assert!(widest.iter().all(|w| *w > 0.01), "{widest:?}");
}

/// Checks a file of another laboratory: semicolons, decimal commas, other names and units, no labels, and gauges set to zero in another case.
#[test]
fn files_of_other_labs_are_read() {
    let plain = folder("");
    let options = RigOptions {
        sigma: Some(0.0),
        ..RigOptions::default()
    };
    let run = virtual_rig(plain.path(), &options).unwrap();
    written(&run, plain.path());
    let expected = LoadedStudy::read(plain.path()).value.unwrap().measurement;

    let other = folder("");
    let kc = columns(&run, "kc.csv");
    let comma = |x: f64| format!("{x:.9}").replace('.', ",");
    let mut text = String::from("Fz [N];Fy [N];Fx [N];Vorspur (min);CAMBER / rad;z_m\n");
    for k in 0..kc[0].len() {
        let row = [
            kc[1][k],
            kc[2][k],
            kc[3][k],
            60.0 * kc[4][k],
            kc[5][k].to_radians(),
            1e-3 * kc[7][k],
        ];
        text += &row.map(comma).join(";");
        text.push('\n');
    }
    std::fs::write(other.path().join("kc.csv"), text).unwrap();
    for (name, line) in [("caster", ""), ("base", ""), ("track", "")] {
        let toml = std::fs::read_to_string(other.path().join("study.toml")).unwrap();
        let kept: String = toml
            .split_inclusive('\n')
            .filter(|l| !l.starts_with(name))
            .collect();
        std::fs::write(other.path().join("study.toml"), kept + line).unwrap();
    }
    replace(
        other.path(),
        "study.toml",
        "toe = { sigma",
        "toe = { column = \"Vorspur (min)\", sigma",
    );
    replace(
        other.path(),
        "study.toml",
        "\"Wheel travel [mm]\"",
        "\"z_m\"",
    );
    let read = LoadedStudy::read(other.path());
    let notes: Vec<&str> = read.diagnostics.iter().map(|d| d.code.as_str()).collect();
    assert_eq!(
        notes,
        ["csv-dialect", "csv-dialect", "kc-curves"],
        "{:#?}",
        read.diagnostics
    );
    let found = read.value.unwrap().measurement;
    assert_eq!(found.channels.len(), 3);
    // The standard deviation is stated in the column's unit, minutes of arc.
    assert!((found.channels[0].sigma - 0.005 / 60.0).abs() < 1e-12);
    for (case, other) in expected.cases.iter().zip(&found.cases) {
        assert_eq!(case.loads, other.loads);
        for (k, of) in [0, 1, 3].into_iter().enumerate() {
            let (a, b) = (case.channels[of].unwrap(), other.channels[k].unwrap());
            assert!((a - b).abs() < 1e-6, "{} {k}: {a} {b}", case.label);
        }
    }
}

/// Checks that rows which repeat a case are averaged, and that they determine the noise if it is not stated. A missing column is reported.
#[test]
fn repeats_tell_the_noise() {
    let study = folder("");
    let mut text = String::from("case,Fz [N],Fy [N],Fx [N],Toe [deg]\n");
    for round in 0..3 {
        for case in 1..=5 {
            let toe = 0.1 * f64::from(case) + [0.01, 0.0, -0.01][round];
            text += &format!("{case},{},0,0,{toe}\n", 4000 + 100 * case);
        }
    }
    std::fs::write(study.path().join("kc.csv"), &text).unwrap();
    let toml = std::fs::read_to_string(study.path().join("study.toml")).unwrap();
    let kept: String = toml
        .split_inclusive('\n')
        .filter(|l| {
            !["caster", "base", "track", "travel"]
                .iter()
                .any(|n| l.starts_with(n))
        })
        .collect();
    std::fs::write(study.path().join("study.toml"), kept).unwrap();
    replace(
        study.path(),
        "study.toml",
        "toe = { sigma = 0.005 }",
        "toe = {}",
    );
    let read = LoadedStudy::read(study.path());
    let said: Vec<&str> = read.diagnostics.iter().map(|d| d.code.as_str()).collect();
    assert!(said.contains(&"missing-column"), "{said:?}");
    replace(
        study.path(),
        "study.toml",
        "camber = { sigma = 0.005 }\n",
        "",
    );
    let found = LoadedStudy::read(study.path()).value.unwrap().measurement;
    assert!((found.cases[2].channels[0].unwrap() - 0.3).abs() < 1e-12);
    // Standard error of the mean of three readings with a standard deviation of 0.01.
    assert!((found.channels[0].sigma - 0.01 / 3f64.sqrt()).abs() < 1e-9);
    assert!(!found.channels[0].sigma_estimated);
}

/// Checks the stiffnesses identified from the curves of the wheel alone, with small errors of hardpoints and gains: the intervals contain the
/// true values.
#[test]
fn intervals_from_curves_alone_hold_the_truth() {
    let study = folder("");
    let truth: Vec<String> = std::fs::read_to_string(rigs().join("effects.txt"))
        .unwrap()
        .lines()
        .filter(|line| line.starts_with("element-parameter"))
        .map(ToString::to_string)
        .collect();
    let (mut held, mut all, mut narrow) = (0, 0, 0);
    for seed in 1..=10 {
        let options = RigOptions {
            seed,
            effects: truth
                .iter()
                .map(|e| EffectSpec::parse(e).unwrap())
                .collect(),
            tolerances: Tolerances::parse("hardpoints=0.1,load_gain=0.002").unwrap(),
            ..RigOptions::default()
        };
        let run = virtual_rig(study.path(), &options).unwrap_or_else(|why| panic!("{why:#?}"));
        let to = tempfile::tempdir().unwrap();
        written(&run, to.path());
        let loaded = LoadedStudy::read(to.path()).value.unwrap();
        let fitted = vec![false; loaded.measurement.cases.len()];
        let outcome = admire_diagnosis::diagnose(&loaded.problem(), fitted).unwrap();
        for parameter in &outcome.diagnosis.parameters {
            let address = &parameter.address;
            let own = truth
                .iter()
                .find(|line| line.contains(&format!("@{address}:")));
            let factor: f64 = own.map_or(1.0, |l| l.rsplit_once('=').unwrap().1.parse().unwrap());
            let deck = admire_syntax::Address::parse(address, &loaded.dataset).unwrap();
            let value = factor * loaded.dataset.value_at(&deck).unwrap();
            let [low, high] = parameter.interval95;
            all += 1;
            held += usize::from(
                low.is_none_or(|low| low <= value) && high.is_none_or(|high| value <= high),
            );
            narrow += usize::from(parameter.std_error < 0.2 * parameter.value);
        }
    }
    println!("{held} of {all} intervals hold the truth, {narrow} are narrower than 20 percent");
    assert!(held as f64 >= 0.88 * f64::from(all), "{held} of {all}");
    assert!(narrow as f64 >= 0.15 * f64::from(all), "{narrow} of {all}");
}
