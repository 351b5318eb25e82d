//! `admire reproduce`: values printed in the paper, beside the results of the same methods on our axles.

use admire_report::ReproducedSection as Section;
use reproduction::{STAGES, reproduce};

#[path = "../../corpus/rust/reproduce_paper/mod.rs"]
mod reproduction;

fn cell<'a>(section: &'a Section, table: &str, row: &str, column: &str) -> &'a str {
    let table = section
        .tables
        .iter()
        .find(|t| t.title.contains(table))
        .unwrap_or_else(|| panic!("{table}"));
    let at = table.head.iter().position(|head| head == column).unwrap();
    let row = table.rows.iter().find(|of| of[0].contains(row));
    &row.unwrap_or_else(|| panic!("{row:?}"))[at]
}

#[test]
fn the_papers_tables_stand_beside_ours() {
    let corpus = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let mut told = 0;
    let sections = reproduce(&corpus, &mut |_| told += 1).unwrap();
    assert_eq!(told, STAGES);
    let [mcpherson, multilink, experiment] = &sections[..] else {
        panic!("three sections")
    };
    // Figure 7 of the paper and the text about it.
    assert_eq!(
        cell(mcpherson, "convergence", "iterations", "the paper"),
        "24"
    );
    assert_eq!(
        cell(mcpherson, "convergence", "iterations", "our loop"),
        "40"
    );
    assert_eq!(cell(mcpherson, "figure 7", "A, our loop", "Ktx"), "1.00");
    assert_eq!(cell(mcpherson, "figure 7", "B, our fit", "Krx"), "1.00");
    assert_eq!(
        cell(multilink, "all stiffnesses", "the paper", "unidentifiable"),
        "17 of 48"
    );
    assert_eq!(multilink.figures.len(), 2);
    assert_eq!(multilink.figures[0].curves.len(), 6);
    assert_eq!(
        cell(experiment, "bushing A", "nominal, the paper", "Ktx"),
        "13000"
    );
    assert_eq!(experiment.figures.len(), 2);
}
