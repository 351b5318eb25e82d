//! Recommended load cases, as rows in the format of the study's load case file.

use admire_design::{Plan, Ranked};
use admire_identify::LoadedStudy;

/// Formats load cases as rows of the study's load case file. The load cases of the first `count` candidates are used. If these have no load
/// cases, the best candidate with load cases is used. Lines that begin with `#` are comments.
pub(crate) fn suggested(loaded: &LoadedStudy, found: &Plan, count: usize) -> String {
    let table = &loaded.study.loads;
    let (label, programme) = (table.column("case"), &loaded.programme);
    let columns: Vec<Option<usize>> = programme
        .loads
        .iter()
        .map(|load| table.column(&load.name))
        .collect();
    let mut text = String::new();
    // The last row of the existing file must end before the first new row.
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
