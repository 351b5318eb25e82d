//! Summary of the table of results: quantiles, failures, and the importance of each parameter.

use std::collections::BTreeMap;

use parquet::errors::ParquetError;
use serde::Serialize;

use super::engine::SweepError;
use super::folder::SweepFolder;
use super::indices::indices;
use super::merge::Columns;
use super::morris::effects;
use super::regression::Regression;
use super::row::Status;
use super::table_reader::TableReader;

/// Probabilities of the reported quantiles.
pub(crate) const SHARES: [f64; 9] = [0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999];

/// Number of bars of a histogram.
const BARS: usize = 40;

/// Largest number of failure reasons listed individually.
const REASONS: usize = 20;

/// Summary of a sweep.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Summary {
    /// Kind of plan.
    pub plan: String,
    /// Number of cases.
    pub cases: u64,
    /// Number of cases by status.
    pub statuses: BTreeMap<&'static str, u64>,
    /// Failure reasons, each with its number of cases, the most frequent reason first.
    pub reasons: Vec<(String, u64)>,
    /// Number of cases with reasons that are not listed individually.
    pub more_reasons: u64,
    /// Total wall time of all cases in seconds.
    pub seconds: f64,
    /// Distribution of each varied parameter.
    pub inputs: Vec<Spread>,
    /// Summary of each recorded output.
    pub outputs: Vec<OutputSummary>,
}

/// Distribution of the values in a column.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Spread {
    /// Name of the column.
    pub name: String,
    /// Unit, if known.
    pub unit: Option<String>,
    /// Number of cases with a value.
    pub count: u64,
    /// Mean of the values.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Smallest and largest value.
    pub ends: [f64; 2],
    /// Quantiles at [`SHARES`], by linear interpolation.
    pub quantiles: Vec<f64>,
    /// Number of cases in each histogram bar. The bars have equal width and extend from the smallest value to the largest.
    pub bars: Vec<u64>,
}

/// Largest number of cases in a scatter plot.
const SCATTERED: usize = 1000;

/// Summary of one recorded output.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OutputSummary {
    /// Distribution of its values.
    pub spread: Spread,
    /// Value of the nominal deck.
    pub nominal: Option<f64>,
    /// Linear effects of the parameters, the largest first; empty if the linear model is undefined.
    pub swings: Vec<LinearEffect>,
    /// Share of the variance explained by the linear model.
    pub explained: Option<f64>,
    /// Sobol indices, empty unless the plan is `sobol-indices`.
    pub indices: Vec<NamedIndex>,
    /// Elementary effects, empty unless the plan is `morris`.
    pub effects: Vec<NamedEffect>,
    /// Values of the output over the parameter with the largest linear effect, for a picture; at most [`SCATTERED`] cases.
    #[serde(skip)]
    pub scatter: Vec<(f64, f64)>,
}

/// Change of a result in the linear model as one parameter goes from its 5 percent to its 95 percent quantile.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct LinearEffect {
    /// Name of the parameter.
    pub name: String,
    /// Change of the result from the parameter's mean to its 5 percent quantile.
    pub low: f64,
    /// Change of the result from the parameter's mean to its 95 percent quantile.
    pub high: f64,
    /// Standard error of the change between the two quantiles.
    pub error: f64,
}

/// Sobol indices of a named parameter.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NamedIndex {
    /// Name of the parameter.
    pub name: String,
    /// First-order index and its standard error.
    pub first: [f64; 2],
    /// Total index and its standard error.
    pub total: [f64; 2],
}

/// Elementary effects of a named parameter.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NamedEffect {
    /// Name of the parameter.
    pub name: String,
    /// Mean of the effects.
    pub mean: f64,
    /// Mean of the absolute effects and its standard error.
    pub size: [f64; 2],
    /// Standard deviation of the effects.
    pub spread: f64,
    /// Number of valid steps, whose two cases both have a result.
    pub count: usize,
}

impl Spread {
    fn of(name: &str, unit: Option<String>, values: &[f64]) -> Self {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let count = sorted.len();
        let n = count as f64;
        let mean = sorted.iter().sum::<f64>() / n;
        let variance = sorted.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let ends = match (sorted.first(), sorted.last()) {
            (Some(first), Some(last)) => [*first, *last],
            _ => [f64::NAN; 2],
        };
        let wide = ends[1] - ends[0];
        let mut bars = vec![
            0;
            if wide > 0.0 {
                BARS
            } else {
                usize::from(count > 0)
            }
        ];
        for value in &sorted {
            let at = if wide > 0.0 {
                ((value - ends[0]) / wide * BARS as f64) as usize
            } else {
                0
            };
            bars[at.min(BARS - 1)] += 1;
        }
        Self {
            name: name.to_string(),
            unit,
            count: count as u64,
            mean,
            sd: if count > 1 { variance.sqrt() } else { 0.0 },
            ends,
            quantiles: SHARES
                .iter()
                .map(|share| quantile(&sorted, *share))
                .collect(),
            bars,
        }
    }

    /// Returns the quantile for a probability in [`SHARES`]; NaN for any other probability.
    pub fn quantile(&self, share: f64) -> f64 {
        let at = SHARES.iter().position(|s| *s == share);
        at.map_or(f64::NAN, |at| self.quantiles[at])
    }
}

/// Returns a quantile by definition 7 of Hyndman and Fan 1996, the default of NumPy and R.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let at = share * last as f64;
    let below = at.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

impl Summary {
    /// Summarises the table of a sweep. Only two columns are in memory at a time; for the plan `morris`, all varied parameters are in memory as well.
    /// # Errors
    /// When the table cannot be read.
    pub fn of(folder: &SweepFolder) -> Result<Self, SweepError> {
        let table = TableReader::open(&folder.results())?;
        let columns = Columns::of(&table, folder.manifest.vary.len());
        let object = |key: &str| -> serde_json::Map<String, serde_json::Value> {
            let text = table.fact(key).unwrap_or("{}");
            serde_json::from_str(text).unwrap_or_default()
        };
        let (units, nominal) = (object("admire.units"), object("admire.nominal"));
        let (ins, outs) = (columns.inputs.len(), columns.outputs.len());
        let mut inputs = Vec::new();
        for (k, name) in columns.inputs.iter().enumerate() {
            let unit = units.get(name).and_then(|unit| unit.as_str());
            let unit = unit.map(str::to_string);
            inputs.push(Spread::of(name, unit, &table.numbers(1 + k)?));
        }
        let mut outputs = Vec::new();
        for (k, name) in columns.outputs.iter().enumerate() {
            let values = table.numbers(1 + ins + k)?;
            let unit = units.get(name).and_then(|unit| unit.as_str());
            outputs.push(OutputSummary {
                spread: Spread::of(name, unit.map(str::to_string), &values),
                nominal: nominal.get(name).and_then(serde_json::Value::as_f64),
                swings: Vec::new(),
                explained: None,
                indices: if folder.manifest.plan == "sobol-indices" {
                    named_indices(&values, &columns.inputs)
                } else {
                    Vec::new()
                },
                effects: Vec::new(),
                scatter: Vec::new(),
            });
        }
        if folder.manifest.plan == "morris" {
            let numbers: Vec<Vec<f64>> = (1..=ins)
                .map(|k| table.numbers(k))
                .collect::<Result<_, _>>()?;
            for (k, output) in outputs.iter_mut().enumerate() {
                let answers = table.numbers(1 + ins + k)?;
                output.effects = named_effects(&answers, &numbers, &columns.inputs);
            }
        }
        let mut statuses = BTreeMap::new();
        table.texts(1 + ins + outs, |word| {
            if let Some(status) = Status::of_word(word) {
                *statuses.entry(status.word()).or_default() += 1;
            }
        })?;
        let mut reasons: BTreeMap<String, u64> = BTreeMap::new();
        let mut more_reasons = 0;
        table.texts(2 + ins + outs, |reason| {
            if reason.is_empty() {
                return;
            }
            let reason = without_numbers(reason);
            if let Some(count) = reasons.get_mut(&reason) {
                *count += 1;
            } else if reasons.len() < 1000 {
                reasons.insert(reason, 1);
            } else {
                more_reasons += 1;
            }
        })?;
        let mut reasons: Vec<(String, u64)> = reasons.into_iter().collect();
        reasons.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        more_reasons += reasons
            .iter()
            .skip(REASONS)
            .map(|(_, count)| count)
            .sum::<u64>();
        reasons.truncate(REASONS);
        let mut summary = Self {
            plan: folder.manifest.plan.clone(),
            cases: table.rows(),
            statuses,
            reasons,
            more_reasons,
            seconds: table.numbers(3 + ins + outs)?.iter().sum(),
            inputs,
            outputs,
        };
        summary.find_swings(&table, ins, outs)?;
        for (k, output) in summary.outputs.iter_mut().enumerate() {
            let first = output.swings.first();
            let input =
                first.and_then(|swing| columns.inputs.iter().position(|n| *n == swing.name));
            if let Some(input) = input {
                let (x, y) = (table.numbers(1 + input)?, table.numbers(1 + ins + k)?);
                let every = x.len().div_ceil(SCATTERED).max(1);
                output.scatter = x.into_iter().zip(y).step_by(every).collect();
            }
        }
        Ok(summary)
    }

    /// Fits a linear model to every output, for its linear effects.
    fn find_swings(
        &mut self,
        table: &TableReader,
        ins: usize,
        outs: usize,
    ) -> Result<(), SweepError> {
        let moving: Vec<usize> = (0..ins).filter(|k| self.inputs[*k].sd > 0.0).collect();
        let mut fits: Vec<Regression> = (0..outs).map(|_| Regression::new(moving.len())).collect();
        let (inputs, outputs) = (&self.inputs, &self.outputs);
        let mut numbers = vec![0.0; moving.len()];
        table.each(ins, outs, |row, values| -> Result<(), ParquetError> {
            for (number, k) in numbers.iter_mut().zip(&moving) {
                *number = (values[*k] - inputs[*k].mean) / inputs[*k].sd;
            }
            for ((fit, output), value) in fits.iter_mut().zip(outputs).zip(&row.outputs) {
                if value.is_finite() {
                    fit.add(&numbers, value - output.spread.mean);
                }
            }
            Ok(())
        })?;
        for (output, fit) in self.outputs.iter_mut().zip(fits) {
            // The variation of a nearly constant output is round-off, so such an output gets no fit.
            let varies = output.spread.sd > 1e-13 * output.spread.mean.abs();
            let Some((slopes, explained)) = fit.slopes().filter(|_| varies) else {
                continue;
            };
            output.explained = Some(explained);
            output.swings = moving
                .iter()
                .zip(slopes)
                .map(|(k, slope)| {
                    let input = &self.inputs[*k];
                    let ends = [0.05, 0.95].map(|s| (input.quantile(s) - input.mean) / input.sd);
                    LinearEffect {
                        name: input.name.clone(),
                        low: slope.slope * ends[0],
                        high: slope.slope * ends[1],
                        error: slope.error * (ends[1] - ends[0]),
                    }
                })
                .collect();
            let size = |swing: &LinearEffect| (swing.high - swing.low).abs();
            output.swings.sort_by(|a, b| size(b).total_cmp(&size(a)));
        }
        Ok(())
    }
}

/// Replaces the numbers in a reason by `...`, so that cases that fail for the same reason are counted together.
fn without_numbers(reason: &str) -> String {
    let words = reason.split(' ').map(|word| {
        let bare = word.trim_end_matches([',', ':', ';']);
        if bare.parse::<f64>().is_ok() && bare.contains(['.', 'e', 'E']) {
            format!("...{}", &word[bare.len()..])
        } else {
            word.to_string()
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

fn named_indices(values: &[f64], names: &[String]) -> Vec<NamedIndex> {
    let Some((found, _)) = indices(values, names.len()) else {
        return Vec::new();
    };
    let named = names.iter().zip(found).map(|(name, index)| NamedIndex {
        name: name.clone(),
        first: [index.first, index.first_error],
        total: [index.total, index.total_error],
    });
    named.collect()
}

fn named_effects(answers: &[f64], numbers: &[Vec<f64>], names: &[String]) -> Vec<NamedEffect> {
    let found = effects(answers, numbers).into_iter();
    let named = names.iter().zip(found).map(|(name, effect)| NamedEffect {
        name: name.clone(),
        mean: effect.mean,
        size: [effect.size, effect.size_error],
        spread: effect.spread,
        count: effect.count,
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_numpy() {
        // numpy.quantile([1, 2, 4, 8], [0.05, 0.25, 0.5, 0.99]).
        let sorted = [1.0, 2.0, 4.0, 8.0];
        for (share, expected) in [(0.05, 1.15), (0.25, 1.75), (0.5, 3.0), (0.99, 7.88)] {
            assert!((quantile(&sorted, share) - expected).abs() < 1e-12);
        }
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn failures_that_differ_by_a_number_are_one_reason() {
        assert_eq!(
            without_numbers("no equilibrium after 25 iterations: imbalance 1.5e8, at PART/2"),
            "no equilibrium after 25 iterations: imbalance ..., at PART/2"
        );
    }

    #[test]
    fn a_spread_counts_every_value_once() {
        let values: Vec<f64> = (0..1000)
            .map(|k| f64::from(k) / 7.0)
            .chain([f64::NAN])
            .collect();
        let spread = Spread::of("x", None, &values);
        assert_eq!(
            (spread.count, spread.bars.iter().sum::<u64>()),
            (1000, 1000)
        );
        assert_eq!(spread.bars, vec![25; 40]);
        let one = Spread::of("x", None, &[3.0, 3.0]);
        assert_eq!((one.bars, one.sd), (vec![2], 0.0));
    }
}
