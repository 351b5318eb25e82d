//! Runs `mdi` in its own folder, and reads its files like existing scripts do.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// A slider on a spring: z = (force + weight) / 10. A force of 10 TIME newton gives z = TIME.
pub const SLIDER: &str = "\
A slider on a spring
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
!                            adams_view_name='block'
PART/2, MASS=2, CM=20, IP=100, 100, 100
MARKER/20, PART=2
MARKER/21, PART=2, QP=0, 0, 50
MARKER/11, PART=1, QP=0, 0, -50
!                            adams_view_name='guide'
JOINT/1, TRANSLATIONAL, I=20, J=1
SPRINGDAMPER/1, TRANSLATIONAL, I=21, J=11, K=10, LENGTH=100
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1
, FUNCTION = 10*TIME
REQUEST/1, CNAMES=\"\", \"\", \"\", \"dz\", RESULTS_NAME=travel
, F4 = DZ(20,1,1)
EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8
OUTPUT/REQSAVE
RESULTS/FORMATTED, XRF
END
";

/// Exit code and output of a process.
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

/// Runs `mdi` with some arguments in a folder.
pub fn mdi(folder: &Path, words: &[&str]) -> Ran {
    mdi_with(folder, words, "", &[])
}

/// Runs `mdi` with text on standard input and environment variables.
pub fn mdi_with(folder: &Path, words: &[&str], input: &str, variables: &[(&str, &str)]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mdi"));
    command
        .current_dir(folder)
        .args(words)
        .env_remove("MDI_STRICT")
        .env_remove("ADMIRE_ALLOW_PATH")
        .envs(variables.iter().copied())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(input.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    Ran {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Creates a temporary folder with some files.
pub fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Runs a deck with some commands; returns its results, the process output and the message file.
pub fn run_deck(deck: &str, commands: &str) -> (Results, Ran, String) {
    let acf = format!("deck\n\n{commands}\nSTOP\n");
    let folder = folder(&[("deck.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "b", "run.acf"]);
    let message = text(folder.path(), "deck.msg");
    (Results::read_all(folder.path(), "deck.res"), ran, message)
}

/// Returns the text of a file of a run, or an empty text if there is none; line ends become LF.
pub fn text(folder: &Path, name: &str) -> String {
    std::fs::read(folder.join(name))
        .map(|bytes| String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
        .unwrap_or_default()
}

/// Returns the message files of the moving deck `generic_model`, ours and the one of real ADAMS; `None` if the shared decks are missing.
pub fn generic_model() -> Option<[String; 2]> {
    let real = crate::common::shared("real-decks")?.join("adamspy-generic");
    let (deck, acf) = (
        text(&real, "generic_model.adm"),
        text(&real, "generic_model.acf"),
    );
    let folder = folder(&[("generic_model.adm", &deck), ("run.acf", &acf)]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 0);
    Some([folder.path(), &real].map(|of| text(of, "generic_model.msg")))
}

/// The steps of a `.res`, read like existing readers do (guide/formats.md 12).
///
/// Ids come from the lines after `<Entity name=`, and values from the numeric lines after each step tag, indexed by id.
pub struct Results {
    ids: BTreeMap<(String, String), usize>,
    pub steps: Vec<Vec<f64>>,
}

impl Results {
    /// Reads the steps of a static or quasi-static run.
    pub fn read(folder: &Path, name: &str) -> Self {
        Self::read_steps(folder, name, |line| {
            line.contains("\"quasiStatic\"") || line.contains("\"static\"")
        })
    }

    /// Reads the steps of a run of any kind.
    pub fn read_all(folder: &Path, name: &str) -> Self {
        Self::read_steps(folder, name, |line| !line.contains("\"input\""))
    }

    fn read_steps(folder: &Path, name: &str, wanted: impl Fn(&str) -> bool) -> Self {
        let text = text(folder, name);
        let between = |line: &str, before: &str| {
            let start = line.find(before)? + before.len();
            let rest = &line[start..];
            Some(rest[..rest.find('"')?].to_string())
        };
        let (mut ids, mut entity, mut steps) = (BTreeMap::new(), String::new(), Vec::new());
        let mut open: Option<Vec<f64>> = None;
        for line in text.lines() {
            if let Some(values) = &mut open {
                let numbers: Result<Vec<f64>, _> =
                    line.split_whitespace().map(str::parse).collect();
                match numbers {
                    Ok(more) => values.extend(more),
                    Err(_) => steps.extend(open.take()),
                }
            }
            if line.starts_with("<Entity ") {
                entity = between(line, "name=\"").unwrap();
            } else if line.starts_with("<Component ") {
                let name = between(line, "name=\"").unwrap();
                ids.insert(
                    (entity.clone(), name),
                    between(line, " id=\"").unwrap().parse().unwrap(),
                );
            } else if line.starts_with("<Step ") && wanted(line) {
                open = Some(Vec::new());
            }
        }
        Self { ids, steps }
    }

    /// Returns the names of the entities that have components.
    pub fn entities(&self) -> Vec<String> {
        let mut names: Vec<String> = self.ids.keys().map(|(entity, _)| entity.clone()).collect();
        names.dedup();
        names
    }

    /// Returns the values of a component in every step.
    pub fn column(&self, entity: &str, component: &str) -> Vec<f64> {
        let id = self.ids[&(entity.to_string(), component.to_string())];
        self.steps.iter().map(|step| step[id - 1]).collect()
    }
}
