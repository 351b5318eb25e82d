//! Load cases of a plan as rows of the study's own table.

use admire_design::{Plan, Ranked};
use admire_identify::LoadedStudy;

/// Load cases among the first candidates, or the best one, as rows of the study's own file of load cases; what begins with # is no row.
pub(crate) fn suggested(loaded: &LoadedStudy, found: &Plan, count: usize) -> String {
    let table = &loaded.study.loads;
    let (label, programme) = (table.column("case"), &loaded.programme);
    let columns: Vec<Option<usize>> = programme
        .loads
        .iter()
        .map(|load| table.column(&load.name))
        .collect();
    let mut text = String::new();
    // So that the last row of the file ends before the first one of these begins.
    if !table.source.bytes().ends_with(b"\n") {
        text += "\n";
    }
    let with_cases = |ranked: &&Ranked| !ranked.cases.is_empty();
    let mut chosen: Vec<&Ranked> = found
        .candidates
        .iter()
        .take(count)
        .filter(with_cases)
        .collect();
    if chosen.is_empty() {
        chosen.extend(found.candidates.iter().find(with_cases));
    }
    let taken = |label: &str| loaded.measurement.case(label).is_some();
    let mut labels = (1..).map(|k| format!("plan-{k}")).filter(|l| !taken(l));
    for ranked in chosen {
        text += &format!("# {}\n", ranked.what);
        for case in &ranked.cases {
            let mut cells: Vec<(usize, String)> = Vec::new();
            cells.extend(label.zip(labels.next()));
            for (load, column) in programme.loads.iter().zip(&columns) {
                let value = case.get(&load.name).copied().unwrap_or_default();
                cells.extend(column.map(|column| (column, format!("{value}"))));
            }
            text += &table.further_row(&cells);
        }
    }
    text
}
