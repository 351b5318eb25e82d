//! The study of section 4.4 of the paper equals the readings of the virtual rig with the specification kept beside it.

use std::path::{Path, PathBuf};

use admire_rig::effect::EffectSpec;
use admire_rig::{RigOptions, virtual_rig};

/// Seed stated in the README of the study.
const SEED: u64 = 44;

fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name)
}

#[test]
fn the_shipped_study_is_reproduced() {
    let specification = corpus("rigs/kc-experiment");
    let list = std::fs::read_to_string(specification.join("effects.txt")).unwrap();
    let options = RigOptions {
        seed: SEED,
        effects: EffectSpec::parse_list(&list).unwrap(),
        ..RigOptions::default()
    };
    let run = virtual_rig(&specification, &options).unwrap();
    let shipped = corpus("kc-experiment");
    for (name, bytes) in &run.files {
        let there = std::fs::read(shipped.join(name)).unwrap();
        if name.extension().is_some_and(|kind| kind == "csv") {
            same_numbers(
                std::str::from_utf8(bytes).unwrap(),
                std::str::from_utf8(&there).unwrap(),
            );
        } else {
            assert_eq!(bytes, &there, "{name:?}");
        }
    }
    // The planted effects are kept outside of the study.
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        for effect in &options.effects {
            assert!(!text.contains(&effect.cause), "{}", effect.text);
        }
    }
    let readme = std::fs::read_to_string(shipped.join("README.md")).unwrap();
    assert!(readme.contains(&format!("--seed {SEED}")));
}

/// Compares numbers to a millionth of a millimetre, because the last digits of an equilibrium may differ between machines.
fn same_numbers(ours: &str, theirs: &str) {
    assert_eq!(ours.lines().count(), theirs.lines().count());
    for (a, b) in ours.lines().zip(theirs.lines()) {
        for (a, b) in a.split(',').zip(b.split(',')) {
            match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(x), Ok(y)) => assert!((x - y).abs() < 1e-6, "{a} {b}"),
                _ => assert_eq!(a, b),
            }
        }
    }
}
