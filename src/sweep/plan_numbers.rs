//! Reader of the varied parameters and their design: `[sampling]`, `[[vary]]` and `[[correlate]]` of SWEEP.toml.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use nalgebra::DMatrix;
use toml::Spanned;

use admire_syntax::diagnostic::Code;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

use super::complaints::CollectedDiagnostics;
use super::correlation::Correlation;
use super::design::{Design, MOST_SOBOL, Plan};
use super::distribution::Distribution;
use super::plan_file::{OneOrMore, PlanFile, PlanWord, Vary};
use super::variation::{Apply, Variation, varied};

/// Largest accepted number of cases; a larger value is probably a mistake.
const MOST_CASES: u64 = 1_000_000_000;

/// Varied parameters and their design, as read from SWEEP.toml.
pub(super) struct Numbers {
    pub variations: Vec<Variation>,
    pub correlations: Vec<Correlation>,
    pub design: Design,
    /// Source of the table of cases, for `plan = "table"`.
    pub table: Option<Source>,
}

/// Reads the varied parameters and their design.
pub(super) fn numbers(
    file: &PlanFile,
    deck: &Dataset,
    folder: &Path,
    out: &mut CollectedDiagnostics,
) -> Option<Numbers> {
    let plan = file.sampling.plan.get_ref();
    let is_table = *plan == PlanWord::Table;
    let before = out.all.len();
    let mut variations = Vec::new();
    let mut levels = Vec::new();
    for vary in &file.vary {
        if let Some((variation, count)) = variation(vary, deck, *plan, out) {
            variations.push(variation);
            levels.push(count);
        }
    }
    let mut table = None;
    let mut rows = Vec::new();
    if let Some(name) = &file.sampling.file {
        if is_table {
            let source = out.file(folder, name)?;
            rows = cases_of(&source, (&mut variations, deck), name.span(), out)?;
            table = Some(source);
        } else {
            let message = "`file` applies only to `plan = \"table\"`";
            out.wrong(Code::BadSetting, name.span(), message);
        }
    } else if is_table {
        let message = "`plan = \"table\"` needs `file = \"cases.csv\"`";
        out.wrong(Code::MissingArgument, file.sampling.plan.span(), message);
    }
    if variations.is_empty() && out.all.len() == before {
        let message = "nothing varies: add a `[[vary]]` with an address and a distribution";
        out.wrong(Code::MissingArgument, file.sampling.plan.span(), message);
    }
    let mut names = BTreeSet::new();
    let spans = file
        .vary
        .iter()
        .map(Spanned::span)
        .chain(std::iter::repeat(file.sampling.plan.span()));
    for (variation, span) in variations.iter().zip(spans) {
        if !names.insert(variation.name.clone()) {
            let message = format!("two variations are called `{}`", variation.name);
            out.wrong(Code::DuplicateId, span, &message);
            out.help("give every variation its own `name = \"...\"`");
        }
    }
    twice(&variations, file, out);
    let correlations = correlations(file, &variations, out);
    let design = design(file, (&variations, levels, rows), out)?;
    if out.all.len() > before {
        return None;
    }
    if let Some(first) = (!is_table).then_some(&variations) {
        // Trial values are written to each address, so that unwritable values are reported before any case runs.
        for (variation, vary) in first.iter().zip(&file.vary) {
            let typical = [0.2, 0.7].map(|u| variation.distribution.quantile(u));
            let refused = typical
                .iter()
                .find_map(|number| varied(deck, std::slice::from_ref(variation), &[*number]).err());
            if let Some(why) = refused {
                out.refused(vary.get_ref().address.span(), *why);
            }
        }
    }
    Some(Numbers {
        variations,
        correlations,
        design,
        table,
    })
}

/// Reports values in the deck that two variations change. One variation would overwrite the other.
fn twice(variations: &[Variation], file: &PlanFile, out: &mut CollectedDiagnostics) {
    let mut seen: Vec<(&Address, &str)> = Vec::new();
    for (at, variation) in variations.iter().enumerate() {
        for (address, _) in &variation.targets {
            if let Some((_, other)) = seen.iter().find(|(known, _)| *known == address) {
                let message = format!("{address} is also varied by `{other}`");
                let span = file
                    .vary
                    .get(at)
                    .map_or(0..0, |v| v.get_ref().address.span());
                out.wrong(Code::ConflictingArguments, span, &message);
            }
        }
        seen.extend(
            variation
                .targets
                .iter()
                .map(|(a, _)| (a, variation.name.as_str())),
        );
    }
}

/// Finds the addresses that match the patterns, each with its value in the deck.
fn targets(
    patterns: &[&str],
    span: &Range<usize>,
    (deck, apply): (&Dataset, Apply),
    out: &mut CollectedDiagnostics,
) -> Option<Vec<(Address, f64)>> {
    let mut all = Vec::new();
    for pattern in patterns {
        let found = match Address::matching(pattern, deck) {
            Ok(found) => found,
            Err(why) => {
                out.refused(span.clone(), why);
                return None;
            }
        };
        for address in found {
            let old = deck.value_at(&address).unwrap_or(f64::NAN);
            if apply != Apply::Set && old.is_nan() {
                let message = format!(
                    "{address} is not a number of the deck, so a factor or an offset cannot change it"
                );
                out.wrong(Code::WrongType, span.clone(), &message);
                return None;
            }
            all.push((address, old));
        }
    }
    Some(all)
}

fn variation(
    vary: &Spanned<Vary>,
    deck: &Dataset,
    plan: PlanWord,
    out: &mut CollectedDiagnostics,
) -> Option<(Variation, (u64, Range<usize>))> {
    let (span, vary) = (vary.span(), vary.get_ref());
    let patterns: Vec<&str> = match vary.address.get_ref() {
        OneOrMore::One(one) => vec![one],
        OneOrMore::More(more) => more.iter().map(String::as_str).collect(),
    };
    let targets = targets(&patterns, &vary.address.span(), (deck, vary.apply), out)?;
    if targets.is_empty() {
        out.wrong(
            Code::MissingArgument,
            vary.address.span(),
            "`address` is empty",
        );
        return None;
    }
    let name = vary
        .name
        .as_ref()
        .map_or_else(|| patterns.join(" "), |name| name.get_ref().clone());
    let distribution = distribution(vary, &span, plan, out)?;
    let levels = match (distribution.count(), &vary.levels) {
        (Some(count), None) => count,
        (None, Some(levels)) if *levels.get_ref() > 0 => *levels.get_ref(),
        (Some(_), Some(levels)) => {
            let message = "`values` are the levels, so `levels` cannot be given too";
            out.wrong(Code::ConflictingArguments, levels.span(), message);
            return None;
        }
        (None, Some(levels)) => {
            out.wrong(
                Code::OutOfRange,
                levels.span(),
                "`levels` must be above zero",
            );
            return None;
        }
        (None, None) if plan == PlanWord::FullFactorial => {
            let message = "a full factorial needs `values` or `levels` of every variation";
            out.wrong(Code::MissingArgument, span, message);
            return None;
        }
        (None, None) => 1,
    };
    let variation = Variation {
        name,
        targets,
        apply: vary.apply,
        degrees: vary.degrees,
        distribution,
    };
    Some((variation, (levels, span)))
}

fn distribution(
    vary: &Vary,
    span: &Range<usize>,
    plan: PlanWord,
    out: &mut CollectedDiagnostics,
) -> Option<Distribution> {
    let named = [
        vary.uniform.is_some(),
        vary.normal.is_some(),
        vary.log_normal.is_some(),
        vary.values.is_some(),
    ];
    let count = named.iter().filter(|named| **named).count();
    if plan == PlanWord::Table {
        if count > 0 {
            let message =
                "the values of this plan are in its table, so no distribution can be given";
            out.wrong(Code::ConflictingArguments, span.clone(), message);
            return None;
        }
        return Some(Distribution::Given);
    }
    if count != 1 {
        let message = "one distribution is needed: uniform = [low, high], normal = { mean, sd }, log-normal = { median, sigma } or values = [...]";
        out.wrong(Code::MissingArgument, span.clone(), message);
        return None;
    }
    if let (Some(weights), None) = (&vary.weights, &vary.values) {
        out.wrong(Code::BadSetting, weights.span(), "`weights` need `values`");
        return None;
    }
    let mut refuse = |span: Range<usize>, message: &str| {
        out.wrong(Code::OutOfRange, span, message);
        None
    };
    if let Some(uniform) = &vary.uniform {
        let [low, high] = *uniform.get_ref();
        if !(low < high && low.is_finite() && high.is_finite()) {
            return refuse(
                uniform.span(),
                "`uniform` needs two finite bounds, the lower one first",
            );
        }
        return Some(Distribution::Uniform([low, high]));
    }
    if let Some(normal) = &vary.normal {
        let n = *normal.get_ref();
        if !(n.sd > 0.0 && n.sd.is_finite() && n.mean.is_finite()) {
            return refuse(
                normal.span(),
                "`mean` and `sd` must be finite, and `sd` must be above zero",
            );
        }
        return Some(Distribution::Normal {
            mean: n.mean,
            sd: n.sd,
        });
    }
    if let Some(log) = &vary.log_normal {
        let n = *log.get_ref();
        if !(n.sigma > 0.0 && n.median > 0.0 && n.sigma.is_finite() && n.median.is_finite()) {
            return refuse(
                log.span(),
                "`median` and `sigma`, the standard deviation of the natural logarithm, must be above zero",
            );
        }
        return Some(Distribution::LogNormal {
            median: n.median,
            sigma: n.sigma,
        });
    }
    let values = vary.values.as_ref()?;
    if values.get_ref().is_empty() || values.get_ref().iter().any(|v| !v.is_finite()) {
        return refuse(
            values.span(),
            "`values` must be a list of one or more finite numbers",
        );
    }
    let count = values.get_ref().len();
    let weights = match &vary.weights {
        None => vec![1.0; count],
        Some(weights) => {
            let all = weights.get_ref();
            let fine = all.len() == count
                && all.iter().all(|w| *w >= 0.0 && w.is_finite())
                && all.iter().sum::<f64>() > 0.0;
            if !fine {
                return refuse(
                    weights.span(),
                    "every value needs a weight of zero or more, and one weight must be above zero",
                );
            }
            all.clone()
        }
    };
    let sum: f64 = weights.iter().sum();
    let mut so_far = 0.0;
    let cumulative = weights.iter().map(|weight| {
        so_far += weight / sum;
        so_far
    });
    let mut cumulative: Vec<f64> = cumulative.collect();
    // The last value with a positive weight absorbs the round-off of the sum.
    let last = weights.iter().rposition(|w| *w > 0.0).unwrap_or(0);
    cumulative[last..].fill(1.0);
    Some(Distribution::Discrete {
        values: values.get_ref().clone(),
        cumulative,
    })
}

fn correlations(
    file: &PlanFile,
    variations: &[Variation],
    out: &mut CollectedDiagnostics,
) -> Vec<Correlation> {
    let mut groups = Vec::new();
    let mut taken = BTreeSet::new();
    for group in &file.correlate {
        let (span, group) = (group.span(), group.get_ref());
        let plan = *file.sampling.plan.get_ref();
        if !matches!(
            plan,
            PlanWord::Random | PlanWord::LatinHypercube | PlanWord::Sobol
        ) {
            let message = "this plan does not support correlations: use plan = \"random\", \"latin-hypercube\" or \"sobol\"";
            out.wrong(Code::ConflictingArguments, span, message);
            continue;
        }
        let mut members = Vec::new();
        for name in &group.names {
            match variations.iter().position(|v| v.name == *name.get_ref()) {
                Some(at) if taken.insert(at) => members.push(at),
                Some(_) => {
                    let message = format!("`{}` is already in a correlation group", name.get_ref());
                    out.wrong(Code::ConflictingArguments, name.span(), &message);
                }
                None => {
                    let message = format!("there is no variation `{}`", name.get_ref());
                    out.wrong(Code::UndefinedId, name.span(), &message);
                }
            }
        }
        if members.len() != group.names.len() {
            continue;
        }
        let n = members.len();
        let matrix = match (&group.coefficient, &group.matrix) {
            (Some(r), None) => DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { *r }),
            (None, Some(rows)) if rows.len() == n && rows.iter().all(|row| row.len() == n) => {
                DMatrix::from_fn(n, n, |i, j| rows[i][j])
            }
            _ => {
                let message = format!(
                    "give the correlation as `coefficient = r`, or as a `matrix` with {n} rows of {n} numbers"
                );
                out.wrong(Code::WrongCount, span, &message);
                continue;
            }
        };
        let proper = (0..n).all(|i| matrix[(i, i)] == 1.0) && matrix == matrix.transpose() && n > 1;
        if let Some(found) = Correlation::new(members, &matrix).filter(|_| proper) {
            groups.push(found);
        } else {
            let message = "these correlations are impossible: the matrix must be symmetric with ones on its diagonal, and positive definite";
            out.wrong(Code::OutOfRange, span, message);
        }
    }
    groups
}

fn design(
    file: &PlanFile,
    (variations, levels, rows): (&[Variation], Vec<(u64, Range<usize>)>, Vec<Vec<f64>>),
    out: &mut CollectedDiagnostics,
) -> Option<Design> {
    let sampling = &file.sampling;
    let word = *sampling.plan.get_ref();
    let names: Vec<&str> = variations.iter().map(|v| v.name.as_str()).collect();
    let sized = !matches!(word, PlanWord::FullFactorial | PlanWord::Table);
    let size = match &sampling.cases {
        Some(cases) if sized && *cases.get_ref() > 0 => *cases.get_ref(),
        Some(cases) if !sized => {
            let message = "this plan determines the number of cases, so `cases` cannot be given";
            out.wrong(Code::ConflictingArguments, cases.span(), message);
            return None;
        }
        Some(cases) => {
            out.wrong(Code::OutOfRange, cases.span(), "`cases` must be above zero");
            return None;
        }
        None if sized => {
            let message = "`cases` is missing: the number of cases, of base points for sobol-indices, or of trajectories for morris";
            out.wrong(Code::MissingArgument, sampling.plan.span(), message);
            return None;
        }
        None => 0,
    };
    let mut grid = 4;
    if let Some(asked) = &sampling.levels {
        grid = *asked.get_ref();
        if word != PlanWord::Morris || grid < 2 || grid % 2 == 1 || grid > 1 << 20 {
            let message = "`levels` of [sampling] applies only to `plan = \"morris\"` and must be an even number up to 1048576";
            out.wrong(Code::OutOfRange, asked.span(), message);
            return None;
        }
    }
    let needed = match word {
        PlanWord::Sobol => names.len(),
        PlanWord::SobolIndices => 2 * names.len(),
        _ => 0,
    };
    if needed > MOST_SOBOL {
        let message = format!(
            "the Sobol sequence supports {MOST_SOBOL} dimensions, but this plan needs {needed}"
        );
        out.wrong(Code::LimitExceeded, sampling.plan.span(), &message);
        return None;
    }
    let plan = match word {
        PlanWord::Random => Plan::Random,
        PlanWord::LatinHypercube => Plan::LatinHypercube,
        PlanWord::Sobol => Plan::Sobol,
        PlanWord::FullFactorial => Plan::FullFactorial(levels.iter().map(|(n, _)| *n).collect()),
        PlanWord::SobolIndices => Plan::SobolIndices,
        PlanWord::Morris => Plan::Morris { levels: grid },
        PlanWord::Table => Plan::Table(rows),
    };
    let runs = match &plan {
        Plan::FullFactorial(levels) => levels.iter().try_fold(1_u64, |all, n| all.checked_mul(*n)),
        Plan::SobolIndices => size.checked_mul(names.len() as u64 + 2),
        Plan::Morris { .. } => size.checked_mul(names.len() as u64 + 1),
        Plan::Table(rows) => Some(rows.len() as u64),
        _ => Some(size),
    };
    if runs.is_none_or(|runs| runs > MOST_CASES) {
        let message = format!("the plan has more than {MOST_CASES} cases");
        out.wrong(Code::LimitExceeded, sampling.plan.span(), &message);
        return None;
    }
    Some(Design::new(plan, size, file.seed, &names))
}

/// Reads the rows of a table of cases, with the columns in the order of the variations. A column that is not named after a variation must
/// be an address, and becomes a new variation.
fn cases_of(
    source: &Source,
    (variations, deck): (&mut Vec<Variation>, &Dataset),
    span: Range<usize>,
    out: &mut CollectedDiagnostics,
) -> Option<Vec<Vec<f64>>> {
    let mut refuse = |row: usize, why: &str| {
        let message = format!("`{}`, line {row}: {why}", source.name());
        out.wrong(Code::BadNumber, span.clone(), &message);
        None
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(source.bytes());
    let heads = match reader.headers() {
        Ok(heads) => heads.clone(),
        Err(error) => return refuse(1, &error.to_string()),
    };
    let mut places = Vec::new();
    for head in &heads {
        let known = variations.iter().position(|v| v.name == head);
        let place = if let Some(place) = known {
            place
        } else {
            let found = match Address::matching(head, deck) {
                Ok(found) => found,
                Err(why) => {
                    return refuse(
                        1,
                        &format!(
                            "`{head}` is neither a variation nor an address: {}",
                            why.message
                        ),
                    );
                }
            };
            variations.push(Variation {
                name: head.to_string(),
                targets: found
                    .into_iter()
                    .map(|address| {
                        let old = deck.value_at(&address).unwrap_or(f64::NAN);
                        (address, old)
                    })
                    .collect(),
                apply: Apply::Set,
                degrees: false,
                distribution: Distribution::Given,
            });
            variations.len() - 1
        };
        if places.contains(&place) {
            return refuse(1, &format!("there are two columns `{head}`"));
        }
        places.push(place);
    }
    if let Some(missing) = (0..variations.len()).find(|k| !places.contains(k)) {
        return refuse(
            1,
            &format!("there is no column `{}`", variations[missing].name),
        );
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map_or(0, csv::Position::line) as usize;
                return refuse(line, &error.to_string());
            }
        };
        let line = record.position().map_or(0, csv::Position::line) as usize;
        let mut row = vec![f64::NAN; places.len()];
        for (cell, place) in record.iter().zip(&places) {
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => row[*place] = value,
                _ => return refuse(line, &format!("`{cell}` is not a number")),
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return refuse(1, "the table has no cases");
    }
    for (k, variation) in variations.iter().enumerate() {
        if let Err(why) = varied(deck, std::slice::from_ref(variation), &[rows[0][k]]) {
            return refuse(2, &why.message);
        }
    }
    Some(rows)
}
