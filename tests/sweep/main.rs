//! Sweeps: the same result for any sharding and after any kill, refusals before any run, and the recorded quantities.

mod kept;
mod kills;
mod refused;
mod shards;
mod studies;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use admire_sweep::{Columns, Row, TableReader};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn admire(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_admire"));
    command.args(words).output().expect("admire starts")
}

/// Returns the standard error of a run.
fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn shown(path: &Path) -> &str {
    path.to_str().expect("a plain path")
}

/// A folder with the pseudo McPherson deck, its command file, and a SWEEP.toml. The text of the SWEEP.toml is that of the corpus after `change`.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(change: impl Fn(String) -> String) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let corpus = root().join("corpus/pseudo-mcpherson");
        for name in ["model.adm", "lateral.acf", "kc.toml"] {
            std::fs::copy(corpus.join(name), folder.path().join(name)).expect("a copy");
        }
        let text = std::fs::read_to_string(corpus.join("sweep.toml")).expect("the plan");
        std::fs::write(folder.path().join("sweep.toml"), change(text)).expect("written");
        Self { folder }
    }

    fn cases(count: usize) -> Self {
        Self::new(|text| text.replace("cases = 1000", &format!("cases = {count}")))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `admire sweep` with output into a folder of this name.
    fn sweep(&self, out: &str, more: &[&str]) -> Output {
        let (plan, out) = (self.path("sweep.toml"), self.path(out));
        let mut words = vec!["sweep", shown(&plan), "--out", shown(&out)];
        words.extend(more);
        admire(&words)
    }

    /// Returns the rows of a result, each with the numbers of its run.
    fn rows(&self, out: &str, inputs: usize) -> Vec<(Row, Vec<f64>)> {
        let table = TableReader::open(&self.path(out).join("results.parquet")).expect("the answer");
        let columns = Columns::of(&table, inputs);
        let mut rows = Vec::new();
        table
            .each(
                inputs,
                columns.outputs.len(),
                |row, numbers| -> Result<(), parquet::errors::ParquetError> {
                    rows.push((row, numbers));
                    Ok(())
                },
            )
            .expect("rows");
        rows
    }
}

/// Returns the bits of everything in a row except the elapsed time.
fn bits((row, numbers): &(Row, Vec<f64>)) -> (u64, &'static str, String, Vec<u64>) {
    let all = numbers.iter().chain(&row.outputs);
    let all = all.map(|value| value.to_bits()).collect();
    (row.case, row.status.word(), row.reason.clone(), all)
}

/// Number of varied numbers in the plan of the corpus.
const NUMBERS: usize = 5;
