//! Runs the cases of a shard on all cores, and ends with its part file.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use crossbeam_channel::{RecvTimeoutError, bounded};
use parquet::errors::ParquetError;

use super::folder::SweepFolder;
use super::journal::{Journal, JournalError};
use super::plan::SweepPlan;
use super::row::Row;
use super::runner::Runner;
use super::shard::Shard;
use super::table_writer::{Layout, TableWriter};

/// Why a shard was not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Its journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A table cannot be written or read.
    #[error("{0}")]
    Table(#[from] ParquetError),
}

/// How far a shard is.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Progress {
    /// Cases of the shard.
    pub all: u64,
    /// Cases that an earlier run had finished.
    pub before: u64,
    /// Cases this run finished.
    pub done: u64,
    /// Of these, those without an answer.
    pub failed: u64,
}

impl Progress {
    /// True if nothing is left.
    pub const fn is_complete(&self) -> bool {
        self.before + self.done == self.all
    }
}

/// Runs what is left of a shard with so many threads. `tell` is told after every few cases; when it says false the run ends with what
/// is finished so far.
///
/// # Errors
/// When the journal or the part file cannot be written.
pub fn run_shard(
    runner: &Runner<'_>,
    plan: &SweepPlan,
    (folder, shard): (&SweepFolder, Shard),
    threads: usize,
    mut tell: impl FnMut(&Progress) -> bool,
) -> Result<Progress, SweepError> {
    let cases = shard.cases(plan.cases());
    let mut progress = Progress {
        all: cases.end - cases.start,
        ..Progress::default()
    };
    if folder.part(shard).is_file() {
        progress.before = progress.all;
        return Ok(progress);
    }
    let mut journal = Journal::open(&folder.journal(shard), &folder.manifest.key(shard))?;
    if folder.part(shard).is_file() {
        // Another process ended it just now.
        let _ = std::fs::remove_file(folder.journal(shard));
        progress.before = progress.all;
        return Ok(progress);
    }
    let mut finished = vec![false; progress.all as usize];
    for case in journal.cases() {
        finished[(case - cases.start) as usize] = true;
    }
    progress.before = finished.iter().filter(|done| **done).count() as u64;
    let next = AtomicU64::new(cases.start);
    let stop = AtomicBool::new(false);
    let (send, receive) = bounded::<Row>(4 * threads.max(1) + 64);
    let finished = &finished;
    std::thread::scope(|scope| -> Result<(), SweepError> {
        for _ in 0..threads.max(1) {
            let (send, next, stop) = (send.clone(), &next, &stop);
            let (first, end) = (cases.start, cases.end);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let case = next.fetch_add(1, Ordering::Relaxed);
                    if case >= end {
                        break;
                    }
                    if !finished[(case - first) as usize] && send.send(runner.run(case)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut take = || -> Result<(), SweepError> {
            loop {
                match receive.recv_timeout(Duration::from_millis(100)) {
                    Ok(first) => {
                        for row in std::iter::once(first).chain(receive.try_iter()) {
                            progress.done += 1;
                            progress.failed += u64::from(!row.reason.is_empty());
                            journal.add(&row)?;
                        }
                        journal.flush()?;
                    }
                    Err(RecvTimeoutError::Timeout) => journal.flush()?,
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                }
                if !tell(&progress) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        };
        let taken = take();
        // Threads that still wait to hand over a case end.
        stop.store(true, Ordering::Relaxed);
        drop(receive);
        taken
    })?;
    journal.sync()?;
    if progress.is_complete() {
        write_part(runner, plan, (folder, shard), &mut journal)?;
    }
    Ok(progress)
}

/// The columns of a part or of the whole.
pub fn layout(runner: &Runner<'_>, plan: &SweepPlan, folder: &SweepFolder, shard: Shard) -> Layout {
    let units: serde_json::Map<String, serde_json::Value> = runner
        .outputs
        .iter()
        .filter_map(|output| Some((output.name.clone(), output.unit.clone()?.into())))
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

fn write_part(
    runner: &Runner<'_>,
    plan: &SweepPlan,
    (folder, shard): (&SweepFolder, Shard),
    journal: &mut Journal,
) -> Result<(), SweepError> {
    let layout = layout(runner, plan, folder, shard);
    let mut table = TableWriter::create(&folder.part(shard), layout)?;
    journal.in_order(|row| -> Result<(), SweepError> {
        let numbers = plan.numbers(row.case);
        Ok(table.add(row, numbers)?)
    })?;
    table.finish()?;
    // The part is whole and on the disk: the journal has done its work. One that stays is only in the way.
    let _ = std::fs::remove_file(folder.journal(shard));
    Ok(())
}
