//! Fuzz targets for the settings and tables of study folders.

use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use admire_kc::Config;
use admire_solver::model::Model;
use admire_study::{Measurement, Study, Table};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use crate::harness::{assert_inside, fuzz};
use crate::seeds;

/// Copy of a study of the corpus, in which one file at a time is replaced.
struct Folder {
    place: tempfile::TempDir,
    model: Model,
}

impl Folder {
    fn of(study: &str) -> Self {
        let from = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(study);
        let place = tempfile::tempdir().expect("a temporary folder");
        for entry in std::fs::read_dir(from).expect("the corpus") {
            let path = entry.expect("the corpus").path();
            if path.is_file() {
                std::fs::copy(&path, place.path().join(path.file_name().expect("a name")))
                    .expect("a copy");
            }
        }
        let deck = Source::read(&place.path().join("model.adm")).expect("a deck");
        let model = Model::lower(&Dataset::parse(deck).value).value;
        Self { place, model }
    }

    fn path(&self, file: &str) -> PathBuf {
        self.place.path().join(file)
    }

    /// Reads the study with one file replaced by the given bytes, and checks the result.
    fn with(&self, file: &str, bytes: &[u8]) {
        let path = self.path(file);
        std::fs::write(&path, bytes).expect("a file of the study");
        let study = Study::read(self.place.path());
        let name = path.display().to_string();
        assert_inside(&study.diagnostics, &name, bytes);
        assert!(
            study.value.is_some() || study.has_errors(),
            "no study, and no reason"
        );
        let Some(study) = study.value else {
            return;
        };
        study.inputs_sha256();
        let measured = Measurement::resolve(&study, &self.model);
        assert_inside(&measured.diagnostics, &name, bytes);
        // Every accepted reading is a finite number.
        let measured = measured.value;
        for case in 0..measured.cases.len() {
            for part in 0..measured.parts.len() {
                let (on_part, seen) = measured.pairs(case, part);
                let mut numbers = on_part.iter().chain(&seen).flat_map(|point| point.iter());
                assert!(
                    numbers.all(|x| x.is_finite()),
                    "a reading that is no number"
                );
            }
        }
    }
}

/// Returns a reader that replaces one file of a study. Each running case uses a folder of its own.
fn in_folders(study: &'static str, file: &'static str) -> impl Fn(&[u8]) + Send + Sync {
    let free: Mutex<Vec<Folder>> = Mutex::default();
    move |bytes| {
        let free = || free.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = free().pop();
        let folder = taken.unwrap_or_else(|| Folder::of(study));
        folder.with(file, bytes);
        free().push(folder);
    }
}

const STUDY: (&str, &str) = ("pseudo-mcpherson", "study.toml");
const LOAD_CASES: (&str, &str) = ("pseudo-mcpherson", "load_cases.csv");
const MARKS_ON_PARTS: (&str, &str) = ("pseudo-mcpherson", "marks_on_parts.csv");
const MARKS_MEASURED: (&str, &str) = ("pseudo-mcpherson", "marks_measured.csv");
const WHEEL: (&str, &str) = ("kc-experiment", "wheel.csv");

/// Defines a fuzz target for each of these files of a study.
macro_rules! readers {
    ($($reader:ident $file:ident),+) => {
        $(
            pub fn $reader(bytes: &[u8]) {
                type Reader = Box<dyn Fn(&[u8]) + Send + Sync>;
                static READ: LazyLock<Reader> = LazyLock::new(|| Box::new(in_folders($file.0, $file.1)));
                READ(bytes);
            }
        )+
    };
}
readers!(study_file STUDY, load_cases LOAD_CASES, marks_on_parts MARKS_ON_PARTS, marks_measured MARKS_MEASURED, wheel WHEEL);

fn own(study: &str, file: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(study)
        .join(file);
    std::fs::read(path).expect("a file of the corpus")
}

#[test]
fn study_files() {
    let seeds: Vec<_> = seeds::all("toml")
        .into_iter()
        .chain([own("pseudo-mcpherson", "study.toml")])
        .collect();
    let words = [
        "[model]\n",
        "[marks]\n",
        "[identify]\n",
        "[loads]\n",
        "[wheel]\n",
        "[solver]\n",
        "[[channels]]\n",
        "sigma = ",
        "deck = ",
        "{",
        "}",
        "[",
        "]",
        "=",
        "\"\"\"",
        "'''",
        "true",
        "nan",
        "inf",
        "\"model.adm\"",
        "\"/dev/zero\"",
        "\"..\"",
        "\"\"",
        "\"SFORCE/99\"",
        "\"BUSHING/1.K\"",
        "1979-05-27T07:32:00Z",
    ];
    fuzz("study.toml", 600, &seeds, &words.map(String::from));
}

#[test]
fn tables_of_studies() {
    let words = [
        "case", ",", ";", "\t", "\"", "#", "part", "mark", "x", "\u{feff}",
    ]
    .map(String::from);
    for (name, (study, file), cases) in [
        ("load-cases", LOAD_CASES, 250),
        ("marks-on-parts", MARKS_ON_PARTS, 250),
        ("marks-measured", MARKS_MEASURED, 250),
        ("wheel", WHEEL, 150),
    ] {
        fuzz(name, cases, &[own(study, file)], &words);
    }
}

/// Checks that the cells of a table have the text of their spans.
pub fn table(bytes: &[u8]) {
    let mut diagnostics = Vec::new();
    let table = Table::read(Source::new("a.csv", bytes), &mut diagnostics);
    table.columns(["case", "x"], &mut diagnostics);
    assert!(table.header_span().end() <= bytes.len());
    for row in table.rows() {
        assert!(table.row_span(row).end() <= bytes.len());
        for (at, cell) in row.iter().enumerate() {
            assert!(cell.span.start() <= cell.span.end() && cell.span.end() <= bytes.len());
            table.number(row, at, &mut diagnostics);
            // The text of a cell without quotation marks equals the text of its span.
            let shown = table.source.text(cell.span);
            assert!(
                shown.contains('"') || shown.trim() == cell.text,
                "{shown:?} is not {:?}",
                cell.text
            );
        }
    }
    assert_inside(&diagnostics, "a.csv", bytes);
}

#[test]
fn tables() {
    let words = [
        "case", ",", ";", "\t", "\"", "\"\"", "#", "\r", "1,5", "\u{feff}", "\n#\n",
    ]
    .map(String::from);
    fuzz("table", 4000, &seeds::all("csv"), &words);
}

/// Checks that settings are read or that an error is reported.
pub fn settings(bytes: &[u8]) {
    let read = Config::read(&Source::new("kc.toml", bytes), 1.0, 1.0);
    assert_inside(&read.diagnostics, "kc.toml", bytes);
    assert!(
        read.value.is_some() || read.has_errors(),
        "no settings, and no reason"
    );
}

#[test]
fn settings_of_the_test_rig() {
    let seeds = seeds::all("toml");
    let words = [
        "[deck]\n",
        "[wheels]\n",
        "[steering]\n",
        "axes = ",
        "[tyre]\n",
        "nan",
        "\"up\"",
        "{}",
    ]
    .map(String::from);
    fuzz("kc.toml", 3000, &seeds, &words);
}
