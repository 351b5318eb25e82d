//! Reduction of a study to a few load cases that span the range of the loads.

use crate::LoadedStudy;
use crate::settings::SLIP_MAX_CASES;
use admire_study::Reference;

/// Returns the study with at most [`SLIP_MAX_CASES`] of its fitted cases. If a channel is read relative to the previous case or is a summary
/// over several cases, the study keeps all its cases. The reference cases of channels are kept in addition.
pub(super) fn thinned(of: &LoadedStudy) -> LoadedStudy {
    let mut study = of.clone();
    let to = &mut study.measurement;
    let over_cases = to
        .channels
        .iter()
        .any(|c| c.summary.is_some() || c.relative_to == Some(Reference::Previous));
    let fitted: Vec<usize> = to.fitted_cases().collect();
    if over_cases || fitted.len() <= SLIP_MAX_CASES {
        return study;
    }
    let mut kept = spread(of, &fitted);
    for channel in &to.channels {
        if let Some(Reference::Case(zero)) = channel.relative_to {
            kept.push(zero);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    for channel in &mut to.channels {
        if let Some(Reference::Case(zero)) = &mut channel.relative_to {
            let first = *zero;
            *zero = kept.partition_point(|case| *case < first);
        }
    }
    to.cases = kept.iter().map(|k| to.cases[*k].clone()).collect();
    let programme = &mut study.programme;
    programme.cases = kept.iter().map(|k| programme.cases[*k].clone()).collect();
    study
}

/// Selects widely spaced load cases. The first is the case with the largest loads; each further one is the case farthest from all cases
/// selected before. Each load is scaled by its largest value.
fn spread(study: &LoadedStudy, cases: &[usize]) -> Vec<usize> {
    let values = |case: usize| &study.programme.cases[case].values;
    let largest = |load: usize| {
        let all = cases.iter().map(|case| values(*case)[load].abs());
        all.fold(f64::MIN_POSITIVE, f64::max)
    };
    let scale: Vec<f64> = (0..study.programme.loads.len()).map(largest).collect();
    let distance = |a: usize, b: Option<usize>| -> f64 {
        let of = |(load, scale): (usize, &f64)| {
            let other = b.map_or(0.0, |b| values(b)[load]);
            ((values(a)[load] - other) / scale).powi(2)
        };
        scale.iter().enumerate().map(of).sum()
    };
    let mut nearest: Vec<f64> = cases.iter().map(|case| distance(*case, None)).collect();
    let mut kept = Vec::new();
    while kept.len() < SLIP_MAX_CASES {
        let far = nearest.iter().enumerate();
        let Some((at, _)) = far.max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0))) else {
            break;
        };
        let next = cases[at];
        for (known, case) in nearest.iter_mut().zip(cases) {
            let own = distance(*case, Some(next));
            *known = if kept.is_empty() { own } else { known.min(own) };
        }
        kept.push(next);
    }
    kept
}
