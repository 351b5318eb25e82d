//! Edits a deck: `cargo run --example edit_a_deck`.
//!
//! Every byte outside the edited values stays unchanged. A change that would leave a fault, such as a reference to a missing marker, is
//! refused.

use admire::{Deck, Error};

fn main() -> Result<(), Error> {
    let original = Deck::open("corpus/pseudo-mcpherson/model.adm")?;
    let mut deck = original.clone();
    deck.set("BUSHING/1.K", vec![12_000.0, 12_000.0, 900.0])?;
    deck.add("MARKER/900, PART=4, QP=0, 0, 100")?;
    deck.add("REQUEST/900, DISPLACEMENT, I=900, J=2")?;
    let refused = deck.add("REQUEST/901, DISPLACEMENT, I=901, J=2");
    println!("refused: {}", refused.expect_err("there is no MARKER/901"));
    deck.renumber("REQUEST", 100, 10)?;

    let mut metres = deck.clone();
    metres.convert_units("mks")?;
    println!(
        "SPRINGDAMPER/1.K: {} N/mm, {} N/m",
        deck.number("SPRINGDAMPER/1.K")?,
        metres.number("SPRINGDAMPER/1.K")?
    );

    let folder = std::env::temp_dir().join("admire-edit-a-deck");
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    deck.save_as(folder.join("edited.adm"), true, false)?;
    println!("written: {}", folder.join("edited.adm").display());
    for difference in original.diff(&deck, admire::DiffTolerance::default()) {
        println!("{}: {:?}", difference.address, difference.change);
    }
    Ok(())
}
