//! The shipped study of K&C curves: toe, camber, caster and displacements of one wheel in loops, nothing else.

use std::path::Path;

use admire::discrepancy::{Verdict, diagnose, held_out};
use admire::identify::LoadedStudy;

#[test]
fn a_wrong_hardpoint_and_friction_are_found_from_curves_of_the_wheel() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let loaded = LoadedStudy::read(&root.join("kc-curves")).value.unwrap();
    let problem = loaded.problem();
    let outcome = diagnose(&problem, held_out(&loaded.study, &loaded.measurement)).unwrap();
    println!("{}", outcome.sentences().join("\n"));
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Discrepancy);
    let truth = std::fs::read_to_string(root.join("rigs/kc-curves/effects.txt")).unwrap();
    let planted = truth
        .lines()
        .filter(|line| line.starts_with("hardpoint-error@") || line.starts_with("dry-friction@"));
    let mut count = 0;
    for line in planted {
        let (cause, rest) = line.split_once('@').unwrap();
        let (address, _) = rest.split_once(':').unwrap();
        let named = diagnosis.findings.iter().find(|f| {
            let here = f.address == address || f.members.iter().any(|m| m == address);
            f.cause.as_str() == cause && here
        });
        assert!(
            named.is_some_and(|f| f.probability > 0.5),
            "{line}: {:?}",
            diagnosis.findings
        );
        count += 1;
    }
    assert_eq!(count, 2);
    assert_eq!(diagnosis.findings.len(), 2, "{:?}", diagnosis.findings);
    // The loops come out: every curve is met to its noise in the cases no fit saw.
    let [before, after] = outcome.unseen.as_ref().unwrap().tests;
    assert!(
        after.chi_square < 1.5 * after.dof as f64 && before.chi_square > 5.0 * after.chi_square
    );
}
