//! Rigs with imperfect loads: the table states the requested loads, but the actual loads differ slightly from case to case.

use std::path::Path;

use admire_diagnosis::Verdict;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::axles::{Judged, copied, judge};

/// Judges an axle of the independent simulator whose table of loads has errors of 0.3 percent of the largest value of each load, case by
/// case.
///
/// The readings belong to the true loads.
fn scattered(name: &str, seed: u64) -> Option<Judged> {
    let folder = copied(name)?;
    scatter(&folder.path().join(name).join("load_cases.csv"), seed);
    Some(judge(folder.path(), name))
}

fn scatter(table: &Path, seed: u64) {
    let text = std::fs::read_to_string(table).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap();
    let rows: Vec<(&str, Vec<f64>)> = lines
        .map(|line| {
            let (label, values) = line.split_once(',').unwrap();
            let values = values.split(',').map(|v| v.parse().unwrap());
            (label, values.collect())
        })
        .collect();
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut out = format!("{head}\n");
    for (label, values) in &rows {
        out += label;
        for (k, value) in values.iter().enumerate() {
            let largest = rows.iter().map(|(_, of)| of[k].abs()).fold(0.0, f64::max);
            // A jack that is not connected exerts no load.
            let off: f64 = match *value {
                0.0 => 0.0,
                _ => StandardNormal.sample(&mut random),
            };
            out += &format!(",{}", value + 0.003 * largest * off);
        }
        out.push('\n');
    }
    std::fs::write(table, out).unwrap();
}

/// Checks an axle with usual tolerances only; the estimated size of load errors must match the simulated one.
#[test]
fn loads_that_scatter_are_no_cause() {
    let Some(judged) = scattered("tolerances-1", 1) else {
        return;
    };
    assert_eq!(judged.diagnosis.verdict, Verdict::Consistent);
    assert!(judged.false_names.is_empty(), "{:?}", judged.false_names);
    let size = judged.diagnosis.tolerances["load-repeatability"].sd;
    assert!((0.0015..0.006).contains(&size), "{size}");
    assert!(judged.held.0 + 2 >= judged.held.1, "{:?}", judged.held);
}

/// Checks that the search considers load errors early, because their expected gain is much larger than the gain of any cause.
///
/// It must not first try the causes that could replace them.
#[test]
fn loads_that_scatter_are_seen_before_causes_are_sought() {
    let (Some(calm), Some(judged)) = (copied("clean-0"), scattered("clean-0", 3)) else {
        return;
    };
    let calm = judge(calm.path(), "clean-0");
    assert_eq!(judged.diagnosis.verdict, Verdict::Consistent);
    let (sweeps, of_calm) = (judged.sweeps, calm.sweeps);
    assert!(sweeps < 8 * of_calm, "{sweeps}, {of_calm}");
}

#[test]
fn a_cause_is_named_among_loads_that_scatter() {
    let Some(judged) = scattered("tolerances-tie-rod-1", 2) else {
        return;
    };
    assert_eq!(judged.diagnosis.verdict, Verdict::Discrepancy);
    assert!(judged.named.iter().all(|named| *named));
    assert!(judged.false_names.is_empty(), "{:?}", judged.false_names);
}
