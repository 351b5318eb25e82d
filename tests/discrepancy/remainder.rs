//! Unexplained residual forces: shown at their location, and used to predict unseen cases with calibrated bands.

use std::fmt::Write as _;

use admire_diagnosis::{Over, Verdict, diagnose, held_out};
use admire_identify::LoadedStudy;

use super::plant::{Plant, gforce, study};

/// Returns load cases with small steps of the longitudinal load, and the other loads of the shipped study.
fn cases() -> String {
    let mut out = String::from("case,vertical,lateral,longitudinal\n");
    for (k, [vertical, lateral]) in [
        [1500.0, 0.0],
        [3000.0, 0.0],
        [6000.0, 0.0],
        [7500.0, 0.0],
        [4500.0, -4000.0],
        [4500.0, -2000.0],
        [4500.0, 2000.0],
        [4500.0, 4000.0],
    ]
    .into_iter()
    .enumerate()
    {
        writeln!(out, "{},{vertical},{lateral},0", k + 1).unwrap();
    }
    for k in 0..=32 {
        // The load alternates, so that the order of the cases differs from the order of the load.
        let step = 7 * k % 33;
        writeln!(out, "{},4500,0,{}", k + 9, -4000 + 250 * step).unwrap();
    }
    out
}

/// Returns the fraction of held-out readings within the predicted 95 percent bands, and their number, for a seed.
fn predicted(seed: u64) -> (f64, usize) {
    let plant = Plant {
        added: gforce(1, (3, 4), 0, "150.0*SIN(0.4*DX(3,4,4))"),
        ..Plant::nothing()
    };
    let folder = study("pseudo-mcpherson", &plant, 0.02, seed, Some(&cases()));
    let toml = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    let kept: Vec<&str> = toml
        .lines()
        .filter(|line| !line.starts_with("hold_out"))
        .collect();
    std::fs::write(folder.path().join("study.toml"), kept.join("\n")).unwrap();
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let held = held_out(&loaded.study, &loaded.measurement);
    let diagnosis = diagnose(&loaded.problem(), held).unwrap().diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Unexplained, "{diagnosis:#?}");
    let remainder = diagnosis.unexplained.remainder.unwrap();
    assert_eq!(
        (remainder.address.as_str(), remainder.over),
        ("BUSHING/2.K.1", Over::Deflection)
    );
    let predicted = remainder.held_out.unwrap();
    println!("{predicted:?}");
    assert_eq!(predicted.address, "BUSHING/2.K.1");
    assert!(
        predicted.rms_after < 0.7 * predicted.rms_before,
        "{predicted:?}"
    );
    (predicted.within95, predicted.readings)
}

/// Plants a force with a period of about 16 mm over the 40 mm travel of a bushing, a law that no hypothesis has.
#[test]
#[ignore = "minutes: .ci/full"]
fn what_remains_predicts_cases_that_were_held_out() {
    let each: Vec<(f64, usize)> = std::thread::scope(|scope| {
        let begun = [71, 72, 73].map(|seed| scope.spawn(move || predicted(seed)));
        begun.map(|one| one.join().unwrap()).to_vec()
    });
    let within: f64 = each.iter().map(|(share, n)| share * *n as f64).sum();
    let readings: usize = each.iter().map(|(_, n)| n).sum();
    let share = within / readings as f64;
    assert!((0.9..0.99).contains(&share), "{share} of {readings}");
}
