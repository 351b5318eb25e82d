//! Repeats the three validations of the paper and prints the paper's results beside ours. `admire reproduce` also writes a report page.
//!
//! `cargo run --release --example reproduce_paper`

use std::path::Path;

#[path = "mod.rs"]
mod reproduction;

fn main() -> Result<(), reproduction::ReproductionError> {
    let sections = reproduction::reproduce(Path::new("corpus"), &mut |stage| eprintln!("{stage}"))?;
    assert_eq!(sections.len(), 3);
    for section in &sections {
        println!("{}", section.title);
        for comparison in &section.tables {
            println!("\n{}\n{}", comparison.title, comparison.head.join("; "));
            for row in &comparison.rows {
                println!("{}", row.join("; "));
            }
        }
        for finding in &section.findings {
            println!("- {finding}");
        }
        println!();
    }
    eprintln!("{} stages", reproduction::STAGES);
    Ok(())
}
