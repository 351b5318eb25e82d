//! Repetition of a fit, from the request to the entries in `identification.json` for every parameter.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::bootstrap::Bootstrap;
use super::estimate::Estimate;
use super::posterior::Posterior;
use super::spread::spread;
use crate::{
    Cases, Layout, Places, Progress, Row, SweepError, TableReader, run_cases, run_in_memory,
};
use admire_identify::global::Marginal;
use admire_identify::{BootstrapMade, Fit, IdentifyError, PosteriorMade, Problem};

/// Number of posterior chains. Eight chains are enough for a comparison between chains, and their warm-up is still cheap.
pub(crate) const CHAINS: u64 = 8;
/// Smallest number of bootstrap replicates that determines the ends of an interval.
pub const LEAST_REPLICATES: u64 = 100;
/// Smallest number of posterior draws that determines the ends of an interval and the agreement of chains.
pub const LEAST_DRAWS: u64 = 100;
/// Largest number of replicates or draws.
pub const MOST: u64 = 10_000_000;

/// Requested repetitions of a fit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Repeats {
    /// Number of bootstrap fits; `None` means no bootstrap.
    pub bootstrap: Option<u64>,
    /// Number of draws from the posterior, rounded up to a multiple of the number of chains; `None` means no draws.
    pub posterior: Option<u64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of parallel threads.
    pub threads: usize,
}

/// Method by which the uncertainty of a fit is sampled.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Bootstrap fits to resampled readings.
    Bootstrap,
    /// Draws from the posterior.
    Posterior,
}

impl Kind {
    /// Returns the file name of the table for this kind of repetition.
    pub const fn file(self) -> &'static str {
        match self {
            Self::Bootstrap => "bootstrap.parquet",
            Self::Posterior => "posterior.parquet",
        }
    }

    /// Returns the name of the kind, `bootstrap` or `posterior`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Bootstrap => "bootstrap",
            Self::Posterior => "posterior",
        }
    }
}

/// Callback that receives the progress and returns true if the run is to continue.
pub(crate) type Told<'a> = dyn FnMut(Kind, &Progress) -> bool + 'a;

/// Rows that a repetition produced.
#[derive(Clone, Debug)]
pub enum RepeatOutput {
    /// Path of the table with the rows.
    Table(PathBuf),
    /// Rows in memory, in the order of the table.
    Rows(Vec<Row>),
}

impl RepeatOutput {
    fn each(&self, layout: &Layout, mut take: impl FnMut(&Row)) -> Result<(), SweepError> {
        match self {
            Self::Rows(rows) => rows.iter().for_each(take),
            Self::Table(path) => {
                let (inputs, outputs) = (layout.inputs.len(), layout.outputs.len());
                TableReader::open(path)?.each(
                    inputs,
                    outputs,
                    |row, _| -> Result<(), SweepError> {
                        take(&row);
                        Ok(())
                    },
                )?;
            }
        }
        Ok(())
    }
}

/// Repeats a fit and stores the resulting intervals in `fit`. Journals and tables are kept in `folder`, so that an interrupted run can be
/// continued there. Without a folder all rows stay in memory. Returns the output of each repetition; `None` if the run was interrupted.
///
/// # Errors
/// When a journal or table cannot be written, or the fit cannot be repeated.
pub fn repeat(
    problem: &Problem<'_>,
    marginal: &Marginal,
    fit: &mut Fit,
    asked: &Repeats,
    folder: Option<&Path>,
    version: &str,
    tell: &mut Told<'_>,
) -> Result<Option<Vec<(Kind, RepeatOutput)>>, RepeatError> {
    let estimate = Estimate::new(problem, marginal)?.ok_or(RepeatError::NoEstimate)?;
    let addresses: Vec<String> = fit.parameters.iter().map(|p| p.address.clone()).collect();
    let mut done = Vec::new();
    let posterior = asked.posterior.map(|draws| draws.div_ceil(CHAINS) * CHAINS);
    let all = [
        (Kind::Bootstrap, asked.bootstrap),
        (Kind::Posterior, posterior),
    ];
    let hash = fit.inputs_sha256.clone();
    let away = addresses.iter().zip(&fit.parameters).enumerate();
    let away: Vec<&str> = away
        .filter(|(k, (_, parameter))| {
            let sd = estimate.covariance[(*k, *k)].sqrt();
            let reported = problem.unknowns[*k].coordinate(parameter.value);
            (estimate.minimum.x[*k] - reported).abs() > sd
        })
        .map(|(_, (address, _))| address.as_str())
        .collect();
    if !away.is_empty() {
        fit.remarks.push(format!(
            "With tolerances marginalised, the fitted values of {} differ by more than a standard deviation from those given here.",
            away.join(", ")
        ));
    }
    let profiles = estimate.profiles()?;
    for (parameter, profile) in fit.parameters.iter_mut().zip(&profiles) {
        parameter.profile95 = Some(*profile);
    }
    for (kind, count) in all {
        let Some(count) = count else { continue };
        let maker = match kind {
            Kind::Bootstrap => Maker::Bootstrap(Bootstrap::new(&estimate, asked.seed)),
            Kind::Posterior => {
                let length = count / CHAINS;
                Maker::Posterior(Posterior::new(&estimate, asked.seed, length), length)
            }
        };
        let work = Work {
            maker,
            addresses: &addresses,
            version,
            hash: &hash,
        };
        let mut tell = |progress: &Progress| tell(kind, progress);
        let made = match folder {
            Some(folder) => {
                let places = places(folder, &work, (kind, count, asked.seed));
                run_cases(&work, 0..count, &places, asked.threads, &mut tell)?
                    .is_complete()
                    .then_some(RepeatOutput::Table(places.table))
            }
            None => {
                run_in_memory(&work, 0..count, asked.threads, &mut tell)?.map(RepeatOutput::Rows)
            }
        };
        let Some(made) = made else { return Ok(None) };
        take(&work, (kind, count, asked.seed), &made, (problem, fit))?;
        done.push((kind, made));
    }
    Ok(Some(done))
}

/// Reason why a fit cannot be repeated.
#[derive(Debug, thiserror::Error)]
pub enum RepeatError {
    /// The identification problem cannot be set up.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// There is no minimum to start from.
    #[error("the fit with tolerances marginalised has no minimum from which it could be repeated")]
    NoEstimate,
    /// A journal or table cannot be used.
    #[error(transparent)]
    Harness(#[from] SweepError),
    /// No replicate has a result.
    #[error("no replicate has a result: {0}")]
    NoReplicate(String),
}

/// Returns the paths of journal and table for a run with these options.
fn places(folder: &Path, work: &Work<'_>, (kind, count, seed): (Kind, u64, u64)) -> Places {
    let key = format!(
        "{}\n{}\n{}\n{count}\n{seed}",
        kind.word(),
        work.version,
        work.hash
    );
    let stem = format!("{}-{}", kind.word(), short(&key));
    Places {
        journal: folder.join(format!("{stem}.journal")),
        table: folder.join(format!("{stem}.parquet")),
        key: key.into_bytes(),
    }
}

/// Returns a code of twelve digits that distinguishes runs with different options.
fn short(key: &str) -> String {
    let digest = Sha256::digest(key.as_bytes());
    let hexadecimal = digest.iter().take(6).map(|byte| format!("{byte:02x}"));
    hexadecimal.collect::<Vec<_>>().concat()
}

enum Maker<'a> {
    Bootstrap(Bootstrap<'a>),
    Posterior(Posterior<'a>, u64),
}

struct Work<'a> {
    maker: Maker<'a>,
    addresses: &'a [String],
    version: &'a str,
    hash: &'a str,
}

impl Cases for Work<'_> {
    fn chain(&self) -> u64 {
        match self.maker {
            Maker::Bootstrap(_) => 1,
            Maker::Posterior(_, length) => length,
        }
    }

    fn run(&self, case: u64, before: Option<&Row>) -> Row {
        match &self.maker {
            Maker::Bootstrap(bootstrap) => bootstrap.run(case),
            Maker::Posterior(posterior, _) => posterior.run(case, before),
        }
    }

    fn inputs(&self, case: u64) -> Vec<f64> {
        match &self.maker {
            Maker::Bootstrap(_) => Vec::new(),
            Maker::Posterior(posterior, _) => {
                let (chain, draw) = posterior.place(case);
                vec![chain as f64, draw as f64]
            }
        }
    }

    fn layout(&self) -> Layout {
        let words = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
        let (inputs, others) = match self.maker {
            Maker::Bootstrap(_) => (words(&[]), words(&["half_chi_square"])),
            Maker::Posterior(..) => (
                words(&["chain", "draw"]),
                words(&["half_chi_square", "acceptance"]),
            ),
        };
        Layout {
            inputs,
            outputs: self.addresses.iter().cloned().chain(others).collect(),
            version: self.version.to_string(),
            hash: self.hash.to_string(),
            facts: vec![
                ("admire.version".to_string(), self.version.to_string()),
                ("admire.inputs_sha256".to_string(), self.hash.to_string()),
            ],
        }
    }
}

/// Stores the results of a repetition in the fit.
fn take(
    work: &Work<'_>,
    (kind, count, seed): (Kind, u64, u64),
    made: &RepeatOutput,
    (problem, fit): (&Problem<'_>, &mut Fit),
) -> Result<(), RepeatError> {
    let mut values: Vec<Vec<Vec<f64>>> = vec![vec![Vec::new()]; fit.parameters.len()];
    let (mut without, mut why, mut acceptance) = (0, String::new(), 0.0);
    made.each(&work.layout(), |row| {
        if !row.reason.is_empty() {
            without += 1;
            why.clone_from(&row.reason);
            return;
        }
        let fresh = kind == Kind::Posterior && row.case % work.chain() == 0 && row.case > 0;
        for (chains, value) in values.iter_mut().zip(&row.outputs) {
            if fresh {
                chains.push(Vec::new());
            }
            chains.last_mut().expect("one at least").push(*value);
        }
        acceptance += row.outputs.last().copied().unwrap_or_default() / count as f64;
    })?;
    if count - without < 2 {
        return Err(RepeatError::NoReplicate(why));
    }
    let unknowns = problem.unknowns.iter().zip(&values);
    for (parameter, (unknown, chains)) in fit.parameters.iter_mut().zip(unknowns) {
        let profile = parameter.profile95.unwrap_or_default();
        let is_chained = kind == Kind::Posterior;
        let found = spread(chains, unknown, (parameter.value, profile), is_chained);
        match kind {
            Kind::Bootstrap => parameter.bootstrap = Some(found),
            Kind::Posterior => parameter.posterior = Some(found),
        }
    }
    match &work.maker {
        Maker::Bootstrap(bootstrap) => {
            fit.bootstrap = Some(BootstrapMade {
                replicates: count,
                without_answer: without,
                seed,
                noise_ratio: bootstrap.noise_ratio,
            });
        }
        Maker::Posterior(posterior, _) => {
            fit.posterior = Some(PosteriorMade {
                draws: count,
                chains: CHAINS,
                seed,
                acceptance,
                steps: posterior.steps,
            });
        }
    }
    remark(kind, fit);
    Ok(())
}

/// Upper limit of R-hat below which chains count as converged.
const APART: f64 = 1.05;
/// Ratio of two interval widths from which the intervals count as different.
const DIFFERENT: f64 = 1.25;

/// Adds remarks on the agreement between repetition and profile likelihood, and on convergence, to the fit.
fn remark(kind: Kind, fit: &mut Fit) {
    let of = |k: usize| match kind {
        Kind::Bootstrap => fit.parameters[k].bootstrap,
        Kind::Posterior => fit.parameters[k].posterior,
    };
    let name = |k: &usize| fit.parameters[*k].address.clone();
    let numbers = 0..fit.parameters.len();
    let different: Vec<String> = numbers
        .clone()
        .filter_map(|k| {
            let ratio = of(k)?.width_ratio?;
            let far = !(1.0 / DIFFERENT..=DIFFERENT).contains(&ratio);
            far.then(|| format!("{} ({ratio:.2})", name(&k)))
        })
        .collect();
    let compared = numbers
        .clone()
        .filter(|k| of(*k).is_some_and(|found| found.width_ratio.is_some()))
        .count();
    let mut remarks = vec![if different.is_empty() {
        format!(
            "Intervals by {} and by profile likelihood agree for all {compared} numbers that have both: their widths differ by less than a quarter.",
            kind.word()
        )
    } else {
        format!(
            "Intervals by {} differ in width from those by profile likelihood for {} of {compared} numbers; the ratios of the widths are: {}.",
            kind.word(),
            different.len(),
            different.join(", ")
        )
    }];
    let apart: Vec<String> = numbers
        .filter(|k| {
            of(*k)
                .and_then(|found| found.r_hat)
                .is_some_and(|r| !(r < APART))
        })
        .map(|k| name(&k))
        .collect();
    if !apart.is_empty() {
        remarks.push(format!(
            "The chains of the posterior have not converged for {}: take more draws.",
            apart.join(", ")
        ));
    }
    if let (Kind::Bootstrap, Some(made)) = (kind, fit.bootstrap)
        && made.without_answer > 0
    {
        remarks.push(format!(
            "{} of {} bootstrap fits have no result and are left out of the intervals.",
            made.without_answer, made.replicates
        ));
    }
    fit.remarks.extend(remarks);
}
