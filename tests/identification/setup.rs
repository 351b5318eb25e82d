//! The shipped studies, ready to identify.

use std::path::{Path, PathBuf};

use admire_identify::{Problem, Unknown, unknowns};
use admire_session::backend::{Backend, FreeMotions, LoadProgramme, NativeBackend, SweepRequest};
use admire_solver::model::Model;
use admire_study::noise::Noise;
use admire_study::{Measurement, Study, programme};
use admire_syntax::Dataset;

pub struct Loaded {
    pub study: Study,
    pub dataset: Dataset,
    pub model: Model,
    pub measurement: Measurement,
    pub programme: LoadProgramme,
    pub unknowns: Vec<Unknown>,
    pub free: FreeMotions,
    /// Reference values of the unknowns, read from the reference deck.
    pub reference: Vec<f64>,
}

impl Loaded {
    pub fn problem(&self) -> Problem<'_> {
        Problem {
            dataset: &self.dataset,
            model: &self.model,
            programme: &self.programme,
            measurement: &self.measurement,
            settings: &self.study.identify,
            regression: &self.study.regression,
            tolerances: &self.study.tolerances,
            priors: &self.study.priors,
            free: &self.free,
            unknowns: self.unknowns.clone(),
        }
    }
}

pub fn copy(name: &str) -> (tempfile::TempDir, PathBuf) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let path = folder.path().to_path_buf();
    (folder, path)
}

/// A shipped study with its `study.toml` and files changed before it is read.
pub fn load(name: &str, change: impl Fn(&Path)) -> Loaded {
    let (_folder, path) = copy(name);
    change(&path);
    let checked = Study::read(&path);
    assert!(checked.diagnostics.is_empty(), "{:?}", checked.diagnostics);
    let study = checked.value.unwrap();
    let dataset = Dataset::parse(study.deck.clone()).value;
    let model = crate::deck::read(std::str::from_utf8(study.deck.bytes()).unwrap());
    let measured = Measurement::resolve(&study, &model);
    assert!(
        measured.diagnostics.is_empty(),
        "{:?}",
        measured.diagnostics
    );
    let mut out = Vec::new();
    let programme = programme(&study, &dataset, &measured.value, &mut out);
    let unknowns = unknowns(&study, &model, |_| None, &mut out);
    assert!(out.is_empty(), "{out:?}");
    let reference = study.reference.as_ref().unwrap();
    let truth = crate::deck::read(std::str::from_utf8(reference.bytes()).unwrap());
    let reference = unknowns
        .iter()
        .map(|unknown| {
            let (bushing, axis) = unknown.axes()[0];
            let law = &truth.bushings[bushing];
            if axis < 3 {
                law.k[axis]
            } else {
                law.kt[axis - 3]
            }
        })
        .collect();
    Loaded {
        study,
        dataset,
        model,
        measurement: measured.value,
        programme,
        unknowns,
        free: FreeMotions::default(),
        reference,
    }
}

/// Replaces text in a file of a study.
pub fn replace(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(path, text.replace(from, to)).unwrap();
}

/// The McPherson with its noise-free marks.
pub fn exact_mcpherson(change: impl Fn(&Path)) -> Loaded {
    load("pseudo-mcpherson", |folder| {
        replace(
            folder,
            "study.toml",
            "marks_measured.csv",
            "marks_noise_free.csv",
        );
        replace(folder, "study.toml", "sigma = 0.05", "sigma = 1e-4");
        change(folder);
    })
}

/// Replaces the readings of a study by what its reference deck does, with normal noise.
pub fn measure(loaded: &mut Loaded, sigma: f64, seed: u64) {
    let reference = loaded.study.reference.as_ref().unwrap();
    let truth = crate::deck::read(std::str::from_utf8(reference.bytes()).unwrap());
    let sweep = NativeBackend::new()
        .sweep(&SweepRequest {
            dataset: &loaded.dataset,
            model: &truth,
            theta: &[],
            programme: &loaded.programme,
        })
        .unwrap();
    let mut noise = Noise::new(seed, "marks");
    let measurement = &mut loaded.measurement;
    for (case, outcome) in measurement.cases.iter_mut().zip(&sweep.cases) {
        let poses = &outcome.as_ref().unwrap().poses;
        for reading in &mut case.marks {
            let marked = &measurement.parts[reading.part];
            let x = poses[marked.part.0].point(&marked.marks[reading.mark].p);
            reading.x = x + noise.vector(sigma);
        }
    }
    measurement.sigma = sigma;
}
