//! Sensors with unknown noise, gauges that are set to zero before each load, and a real measured robot.

use std::path::Path;

use admire_identify::global::{Options, Prepared, fit_study};
use admire_identify::{LoadedStudy, Status, estimate_noise};
use admire_rig::{LoadTable, RigOptions, virtual_rig};

use crate::setup::{copy, replace};

fn write(files: &[(std::path::PathBuf, Vec<u8>)], folder: &Path) {
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

fn read(folder: &Path) -> LoadedStudy {
    let read = LoadedStudy::read(folder);
    let diagnostics = read.diagnostics;
    read.value.unwrap_or_else(|| panic!("{diagnostics:?}"))
}

/// Measures the shipped McPherson in 31 cases with these channels; its reference deck is the reality.
fn measured(channels: &str, sigma: Option<f64>) -> tempfile::TempDir {
    let (_folder, path) = copy("pseudo-mcpherson");
    std::fs::rename(path.join("reference.adm"), path.join("model.adm")).unwrap();
    let reference = "[reference]\ndeck = \"reference.adm\"\n";
    replace(&path, "study.toml", reference, "");
    let toml = std::fs::read_to_string(path.join("study.toml")).unwrap();
    let more = format!("[readings]\nfile = \"readings.csv\"\n[readings.channels]\n{channels}");
    std::fs::write(path.join("study.toml"), toml + &more).unwrap();
    let options = RigOptions {
        seed: 11,
        sigma,
        programme: Some(LoadTable::UpAndDown),
        ..RigOptions::default()
    };
    let run = virtual_rig(&path, &options).unwrap_or_else(|why| panic!("{why:#?}"));
    let folder = tempfile::tempdir().unwrap();
    write(&run.files, folder.path());
    folder
}

fn column(folder: &Path, name: &str) -> Vec<Option<f64>> {
    let text = std::fs::read_to_string(folder.join("readings.csv")).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|own| own == name);
    let cell = |line: &str| line.split(',').nth(at.unwrap()).unwrap().parse().ok();
    lines.map(cell).collect()
}

#[test]
fn a_gauge_set_to_zero_before_each_load_reads_the_steps() {
    let channels = "whole = { function = \"DM(18,17)\", sigma = 0.1 }\n\
                    step = { function = \"DM(18,17)\", sigma = 0.1, relative_to = \"previous\" }\n";
    let folder = measured(channels, Some(0.0));
    let (whole, step) = (
        column(folder.path(), "whole"),
        column(folder.path(), "step"),
    );
    assert_eq!(step[0], None);
    for k in 1..whole.len() {
        let moved = whole[k].unwrap() - whole[k - 1].unwrap();
        assert!((step[k].unwrap() - moved).abs() < 1e-6, "case {k}");
    }
    assert!(step.iter().flatten().any(|step| step.abs() > 5.0));
    // A reading in the first case, which has no preceding case, is left out with a warning.
    let path = folder.path().join("readings.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let first = text.lines().nth(1).unwrap().to_string();
    std::fs::write(&path, text.replace(&first, &format!("{first}7.0"))).unwrap();
    let read = LoadedStudy::read(folder.path());
    let said: Vec<String> = read.diagnostics.iter().map(|d| d.message.clone()).collect();
    assert!(
        said.iter()
            .any(|text| text.contains("the first case has none")),
        "{said:?}"
    );
    assert_eq!(read.value.unwrap().measurement.cases[0].channels[1], None);
}

/// Checks the estimated noise of 31 readings with 0.2 mm; its relative standard error is 13 percent.
#[test]
fn noise_that_is_not_stated_is_what_the_fit_leaves() {
    let channels = "travel = { function = \"DM(18,17)\", sigma = 0.2 }\n";
    let folder = measured(channels, Some(0.05));
    replace(folder.path(), "study.toml", ", sigma = 0.2", "");
    let mut loaded = read(folder.path());
    assert!(loaded.measurement.channels[0].sigma_estimated);
    // Before the fit, only the magnitude of the readings is known.
    assert!(loaded.measurement.channels[0].sigma > 10.0);
    estimate_noise(&mut loaded, None).unwrap();
    let found = loaded.measurement.channels[0].sigma;
    assert!((found / 0.2 - 1.0).abs() < 0.35, "{found}");
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let fit = fit_study(&problem, &prepared, None, Options::default())
        .unwrap()
        .fit;
    let said = fit.remarks.join(" ");
    assert!(said.contains("The noise of travel is not stated"), "{said}");
}

/// Checks 43 poses of a robot that is pulled by a cable. Each joint bends by its torque over its stiffness, so the displacement is linear in the
/// six compliances. `linear` is the least-squares solution of this closed form in N.mm/rad (by numpy from the same tables, each axis weighted by
/// its own residuals). `authors` are the values of the robot's authors, by their own method.
#[test]
fn the_joints_of_a_robot() {
    let mut loaded = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/fanuc-r2000ic"));
    estimate_noise(&mut loaded, None).unwrap();
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).unwrap();
    let fit = fit_study(&problem, &prepared, None, Options::default())
        .unwrap()
        .fit;
    assert!(fit.converged);
    let linear = [862.9e6, 2500.4e6, 2062.7e6, 275.07e6, 470.12e6, 158.07e6];
    let authors = [861.58e6, 2856.0e6, 1848.3e6, 279.35e6, 418.67e6, 277.72e6];
    for ((parameter, linear), authors) in fit.parameters.iter().zip(linear).zip(authors) {
        let (value, error) = (parameter.value, parameter.std_error.unwrap());
        println!("{} {value:.4e} +- {error:.1e}", parameter.address);
        // The fit estimates the noise of each axis separately, so its weights differ slightly.
        assert!(
            (value - linear).abs() < 0.7 * error,
            "{} {value:e}",
            parameter.address
        );
        let [low, high] = parameter.interval95;
        assert!(low.is_none_or(|low| low < authors) && high.is_none_or(|high| authors < high));
    }
    let identified = fit
        .parameters
        .iter()
        .filter(|p| p.status == Status::Identified);
    assert!(identified.count() >= 5);
    for channel in &loaded.measurement.channels {
        assert!(
            (0.1..0.35).contains(&channel.sigma),
            "{} {}",
            channel.name,
            channel.sigma
        );
    }
}
