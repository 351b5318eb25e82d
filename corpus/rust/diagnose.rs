//! Diagnoses the faults of a model, and writes a deck extended by their causes: `cargo run --release --example diagnose [STUDY]`.

use admire::{Error, SharedProgress, Study};

fn main() -> Result<(), Error> {
    let folder = std::env::args().nth(1);
    let study = Study::open(folder.as_deref().unwrap_or("corpus/pseudo-mcpherson"))?;
    let answer = study.diagnose(false, &SharedProgress::default())?;
    println!("verdict: {:?}", answer.diagnosis.verdict);
    for finding in &answer.diagnosis.findings {
        println!(
            "{} at {}, probability {:.2}: {:?}",
            finding.cause, finding.address, finding.probability, finding.parameters
        );
    }
    let file = std::env::temp_dir().join("admire-extended.adm");
    std::fs::write(&file, &answer.deck).expect("a temporary file");
    println!("the extended deck: {}", file.display());
    Ok(())
}
