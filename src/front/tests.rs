use std::io;
use std::path::{Path, PathBuf};

use super::{Deck, ErrorKind};
use admire_session::Session;

fn corpus(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(file)
}

/// Returns the lines of a file that contain neither the time nor the folder of writing.
fn lasting(text: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(text);
    let own = ["<File ", "<Analysis ", " A.R3", " A.G8"];
    text.lines()
        .filter(|line| !own.iter().any(|word| line.starts_with(word)))
        .map(str::to_string)
        .collect()
}

#[test]
fn a_run_in_memory_is_the_run_with_files() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    for name in ["model.adm", "states.acf"] {
        std::fs::copy(corpus("double-wishbone").join(name), place(name)).unwrap();
    }
    let ending = Session::new(Box::new(io::sink()), folder.path()).run_file("states.acf");
    assert_eq!(ending.exit_code(true), 0);
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    let run = Deck::open(place("model.adm"))
        .unwrap()
        .run(place("states.acf"))
        .unwrap();
    run.succeeded().unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before);
    for extension in ["res", "req"] {
        let theirs = std::fs::read(place("states").with_extension(extension)).unwrap();
        let ours = place(&format!("ours.{extension}"));
        run.write(&ours, false).unwrap();
        let ours = std::fs::read(ours).unwrap();
        assert!(lasting(&ours).len() > 3, "{extension}");
        assert_eq!(lasting(&ours), lasting(&theirs), "{extension}");
    }
}

#[test]
fn nothing_is_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let (mine, other) = (folder.path().join("a.adm"), folder.path().join("b.adm"));
    std::fs::copy(corpus("pseudo-mcpherson/model.adm"), &mine).unwrap();
    std::fs::write(&other, "of somebody else").unwrap();
    let mut deck = Deck::open(&mine).unwrap();
    deck.set("BUSHING/1.K.1", 7.0).unwrap();
    let there = deck.save_as(&other, false, false).unwrap_err();
    assert_eq!(there.kind, ErrorKind::File(io::ErrorKind::AlreadyExists));
    deck.save(false).unwrap();
    assert_eq!(
        Deck::open(&mine).unwrap().number("BUSHING/1.K.1").unwrap(),
        7.0
    );
    // Another program changes the file after the deck was read.
    std::fs::copy(corpus("pseudo-mcpherson/model.adm"), &mine).unwrap();
    deck.set("BUSHING/1.K.1", 8.0).unwrap();
    assert!(deck.save(false).is_err());
    // A negative stiffness is a fault, and the stored file does not have this fault.
    let mut deck = Deck::open(&mine).unwrap();
    deck.set("BUSHING/1.K.1", -7.0).unwrap();
    assert_eq!(deck.save(false).unwrap_err().kind, ErrorKind::Input);
    deck.save(true).unwrap();
}

#[test]
fn a_failed_change_leaves_the_deck_as_it_is() {
    let mut deck = Deck::open(corpus("pseudo-mcpherson/model.adm")).unwrap();
    let before = deck.bytes().to_vec();
    for address in ["BUSHING/99.K.1", "BUSHING/1.KK", "nothing_*.K"] {
        assert_eq!(deck.set(address, 1.0).unwrap_err().kind, ErrorKind::Usage);
    }
    assert!(deck.set("BUSHING/1.K.1", f64::NAN).is_err());
    assert_eq!(deck.bytes(), before);
    let none = deck.set("SFORCE/3", 1e12).unwrap().solve().unwrap_err();
    assert_eq!(none.kind, ErrorKind::NoAnswer);
}
