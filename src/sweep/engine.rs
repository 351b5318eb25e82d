//! Engine that runs the cases of a shard on all cores and writes its part file.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use crossbeam_channel::{RecvTimeoutError, bounded};
use parquet::errors::ParquetError;

use super::checksum::{Damage, verify};
use super::folder::SweepFolder;
use super::journal::{Journal, JournalError};
use super::plan::SweepPlan;
use super::row::Row;
use super::runner::Runner;
use super::shard::Shard;
use super::table_writer::{Layout, TableWriter};

/// Reason why a shard did not finish.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The journal of the shard cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A table cannot be written or read.
    #[error("{0}")]
    Table(#[from] ParquetError),
    /// A finished table is damaged.
    #[error("`{}`: {damage}; delete the file to run its cases again", path.display())]
    Damaged {
        /// Path of the table.
        path: PathBuf,
        /// Kind of damage.
        damage: Damage,
    },
}

/// Progress of a shard.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Progress {
    /// Number of cases in the shard.
    pub all: u64,
    /// Number of cases finished by earlier runs.
    pub before: u64,
    /// Number of cases finished by this run.
    pub done: u64,
    /// Number of cases, among those in `done`, without a result.
    pub failed: u64,
}

impl Progress {
    /// Returns true if all cases are finished.
    pub const fn is_complete(&self) -> bool {
        self.before + self.done == self.all
    }

    fn count(&mut self, row: &Row) {
        self.done += 1;
        self.failed += u64::from(!row.reason.is_empty());
    }
}

/// Large set of cases to run. A case depends only on the inputs and its case number; in a chain it also depends on the previous case.
pub trait Cases: Sync {
    /// Returns the number of cases in a chain. Each case of a chain starts where the previous case ended. Chains are independent of each
    /// other.
    fn chain(&self) -> u64 {
        1
    }

    /// Runs a case; `before` is the previous case of its chain.
    fn run(&self, case: u64, before: Option<&Row>) -> Row;

    /// Returns the input values of a case, which the table lists between case number and results.
    fn inputs(&self, case: u64) -> Vec<f64>;

    /// Returns the columns of the table.
    fn layout(&self) -> Layout;
}

/// Paths of the journal and of the finished table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Places {
    /// Path of the journal.
    pub journal: PathBuf,
    /// Path of the table.
    pub table: PathBuf,
    /// Key that identifies the owner of the journal.
    pub key: Vec<u8>,
}

/// Cases of one shard of a sweep.
struct OfShard<'a> {
    runner: &'a Runner<'a>,
    plan: &'a SweepPlan,
    folder: &'a SweepFolder,
    shard: Shard,
}

impl Cases for OfShard<'_> {
    fn run(&self, case: u64, _before: Option<&Row>) -> Row {
        self.runner.run(case)
    }

    fn inputs(&self, case: u64) -> Vec<f64> {
        self.plan.numbers(case)
    }

    fn layout(&self) -> Layout {
        layout(self.runner, self.plan, self.folder, self.shard)
    }
}

/// Runs the unfinished cases of a shard on `threads` threads. `tell` receives the progress after every few cases. If it returns false, the
/// run stops and keeps the cases finished so far.
///
/// # Errors
/// When the journal or the part file cannot be written.
pub fn run_shard(
    runner: &Runner<'_>,
    plan: &SweepPlan,
    folder: &SweepFolder,
    shard: Shard,
    threads: usize,
    tell: impl FnMut(&Progress) -> bool,
) -> Result<Progress, SweepError> {
    let places = Places {
        journal: folder.journal(shard),
        table: folder.part(shard),
        key: folder.manifest.key(shard),
    };
    let cases = OfShard {
        runner,
        plan,
        folder,
        shard,
    };
    run_cases(&cases, shard.cases(plan.cases()), &places, threads, tell)
}

/// Runs the unfinished cases of a range, which must start at the beginning of a chain. No case is run if the table exists and is intact.
///
/// # Errors
/// When the journal or the table cannot be written, or when the existing table is damaged.
pub(crate) fn run_cases(
    work: &dyn Cases,
    cases: Range<u64>,
    places: &Places,
    threads: usize,
    mut tell: impl FnMut(&Progress) -> bool,
) -> Result<Progress, SweepError> {
    let mut progress = Progress {
        all: cases.end - cases.start,
        ..Progress::default()
    };
    if places.table.is_file() {
        verify(&places.table).map_err(|damage| SweepError::Damaged {
            path: places.table.clone(),
            damage,
        })?;
        progress.before = progress.all;
        return Ok(progress);
    }
    let mut journal = Journal::open(&places.journal, &places.key)?;
    if places.table.is_file() {
        // Another process has just finished the shard.
        let _ = std::fs::remove_file(&places.journal);
        progress.before = progress.all;
        return Ok(progress);
    }
    let mut finished = vec![false; progress.all as usize];
    for case in journal.cases() {
        finished[(case - cases.start) as usize] = true;
    }
    progress.before = finished.iter().filter(|done| **done).count() as u64;
    let last = last_of_chains(work.chain(), &cases, &mut journal)?;
    let left = (finished.as_slice(), &last);
    run_left(work, &cases, left, threads, &mut |rows| {
        for row in &rows {
            progress.count(row);
            journal.add(row)?;
        }
        journal.flush()?;
        Ok(tell(&progress))
    })?;
    journal.sync()?;
    if progress.is_complete() {
        write_table(work, places, &mut journal)?;
    }
    Ok(progress)
}

/// Runs cases in memory, without journal and table. Returns all rows in the order of the cases; `None` if `tell` stopped the run before the
/// last case.
///
/// # Errors
/// None in practice, because no file is used.
pub(crate) fn run_in_memory(
    work: &dyn Cases,
    cases: Range<u64>,
    threads: usize,
    mut tell: impl FnMut(&Progress) -> bool,
) -> Result<Option<Vec<Row>>, SweepError> {
    let mut progress = Progress {
        all: cases.end - cases.start,
        ..Progress::default()
    };
    let mut all = Vec::new();
    let left = (vec![false; progress.all as usize], BTreeMap::new());
    let left = (left.0.as_slice(), &left.1);
    run_left(work, &cases, left, threads, &mut |rows| {
        for row in &rows {
            progress.count(row);
        }
        all.extend(rows);
        Ok(tell(&progress))
    })?;
    all.sort_by_key(|row| row.case);
    Ok(progress.is_complete().then_some(all))
}

/// Runs the unfinished cases on several threads. `take` receives the rows as they finish, and an empty list at intervals; the run stops
/// when it returns false. Each unfinished chain continues after its finished case in `last`.
fn run_left(
    work: &dyn Cases,
    cases: &Range<u64>,
    (finished, last): (&[bool], &BTreeMap<u64, Row>),
    threads: usize,
    take: &mut dyn FnMut(Vec<Row>) -> Result<bool, SweepError>,
) -> Result<(), SweepError> {
    let next = AtomicU64::new(cases.start);
    let stop = AtomicBool::new(false);
    let (send, receive) = bounded::<Row>(4 * threads.max(1) + 64);
    std::thread::scope(|scope| -> Result<(), SweepError> {
        for _ in 0..threads.max(1) {
            let (send, next, stop) = (send.clone(), &next, &stop);
            let (first, end, chain) = (cases.start, cases.end, work.chain());
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let begin = next.fetch_add(chain, Ordering::Relaxed);
                    if begin >= end {
                        break;
                    }
                    let mut before = last.get(&begin).cloned();
                    for case in begin..(begin + chain).min(end) {
                        if finished[(case - first) as usize] {
                            continue;
                        }
                        let row = work.run(case, before.as_ref());
                        before = (chain > 1).then(|| row.clone());
                        if send.send(row).is_err() || stop.load(Ordering::Relaxed) {
                            return;
                        }
                    }
                }
            });
        }
        drop(send);
        let taken = loop {
            let rows = match receive.recv_timeout(Duration::from_millis(100)) {
                Ok(first) => std::iter::once(first).chain(receive.try_iter()).collect(),
                Err(RecvTimeoutError::Timeout) => Vec::new(),
                Err(RecvTimeoutError::Disconnected) => break Ok(()),
            };
            match take(rows) {
                Ok(true) => {}
                Ok(false) => stop.store(true, Ordering::Relaxed),
                Err(error) => break Err(error),
            }
        };
        // Threads that are waiting to send a row end now.
        stop.store(true, Ordering::Relaxed);
        drop(receive);
        taken
    })
}

/// Returns the last finished case of every chain in the journal, keyed by the first case of the chain.
fn last_of_chains(
    chain: u64,
    cases: &Range<u64>,
    journal: &mut Journal,
) -> Result<BTreeMap<u64, Row>, SweepError> {
    let mut last = BTreeMap::new();
    if chain > 1 {
        journal.in_order(|row| -> Result<(), SweepError> {
            let begin = row.case - (row.case - cases.start) % chain;
            last.insert(begin, row);
            Ok(())
        })?;
    }
    Ok(last)
}

/// Returns the columns of a shard's part file, which are also the columns of the whole table.
pub(crate) fn layout(
    runner: &Runner<'_>,
    plan: &SweepPlan,
    folder: &SweepFolder,
    shard: Shard,
) -> Layout {
    let of_deck = runner.units();
    let outputs = runner.outputs.iter();
    let outputs = outputs.map(|output| (&output.name, output.unit.clone()));
    let inputs = plan.variations.iter().map(|v| (&v.name, v.unit(&of_deck)));
    let units: serde_json::Map<String, serde_json::Value> = inputs
        .chain(outputs)
        .filter_map(|(name, unit)| Some((name.clone(), unit?.into())))
        .collect();
    let nominal: serde_json::Map<String, serde_json::Value> = runner
        .outputs
        .iter()
        .zip(&runner.nominal.outputs)
        .map(|(output, value)| (output.name.clone(), (*value).into()))
        .collect();
    Layout {
        inputs: plan.variations.iter().map(|v| v.name.clone()).collect(),
        outputs: runner.outputs.iter().map(|o| o.name.clone()).collect(),
        version: folder.manifest.version.clone(),
        hash: folder.manifest.inputs_sha256.clone(),
        facts: vec![
            (
                "admire.version".to_string(),
                folder.manifest.version.clone(),
            ),
            (
                "admire.inputs_sha256".to_string(),
                folder.manifest.inputs_sha256.clone(),
            ),
            ("admire.shard".to_string(), shard.to_string()),
            (
                "admire.units".to_string(),
                serde_json::Value::Object(units).to_string(),
            ),
            (
                "admire.nominal".to_string(),
                serde_json::Value::Object(nominal).to_string(),
            ),
        ],
    }
}

fn write_table(work: &dyn Cases, places: &Places, journal: &mut Journal) -> Result<(), SweepError> {
    let mut table = TableWriter::create(&places.table, work.layout())?;
    journal.in_order(|row| -> Result<(), SweepError> {
        let inputs = work.inputs(row.case);
        Ok(table.add(row, inputs)?)
    })?;
    table.finish()?;
    // The table is complete and on disk, so the journal is no longer needed. Failure to remove it is harmless.
    let _ = std::fs::remove_file(&places.journal);
    Ok(())
}
