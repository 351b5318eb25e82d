//! Identifies bushing stiffnesses from measured marks (points on the parts): `cargo run --release --example identify [STUDY]`.

use admire::{Error, SharedProgress, Study};

fn main() -> Result<(), Error> {
    let folder = std::env::args().nth(1);
    let study = Study::open(folder.as_deref().unwrap_or("corpus/pseudo-mcpherson"))?;
    let answer = study.identify(false, &SharedProgress::default())?;
    for number in &answer.fit.parameters {
        match number.std_error {
            Some(error) => println!(
                "{:16} {:12.1} +- {:.1}",
                number.address, number.value, error
            ),
            None => println!(
                "{:16} {:12.1}, which the readings do not determine",
                number.address, number.value
            ),
        }
    }
    println!("converged: {}", answer.fit.converged);
    Ok(())
}
