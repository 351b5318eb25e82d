//! The shipped axle of Adams/Car: its deck has linear bushings, and its readings are positions of a real axle with noise.

use std::path::Path;

use admire_diagnosis::{Cause, GainCheck, Progress, Verdict, diagnose_watched, held_out};
use admire_identify::LoadedStudy;

/// Checks that both bushings of the arm are found to soften along their axes beyond 3 mm, to 72 percent of their stiffness.
#[test]
#[ignore = "minutes: .ci/full"]
fn the_curves_of_a_real_axle_are_found_from_linear_bushings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/adams-car-axle");
    let loaded = LoadedStudy::read(&folder).value.unwrap();
    let outcome = diagnose_watched(
        &loaded.problem(),
        held_out(&loaded.study, &loaded.measurement),
        GainCheck::Quick,
        &Progress::default(),
    )
    .unwrap();
    let diagnosis = &outcome.diagnosis;
    println!("{}", diagnosis.to_json());
    assert_eq!(diagnosis.verdict, Verdict::Discrepancy);
    for (address, stiffness) in [("BUSHING/3.K.3", 299.0), ("BUSHING/4.K.3", 448.0)] {
        let mut findings = diagnosis.findings.iter();
        let found = findings
            .find(|f| f.cause == Cause::ProgressiveStiffness && f.address == address)
            .unwrap_or_else(|| panic!("{address} is not among {:?}", diagnosis.findings));
        // The stiffness is constant over the first third of the deflections, falls over the second, and is constant again.
        let rise = |name: &str| found.parameters[name] / stiffness;
        assert!(rise("rise_first_third").abs() < 0.1, "{address}: {found:?}");
        assert!(
            (rise("rise_second_third") + 0.28).abs() < 0.06,
            "{address}: {found:?}"
        );
        assert!(rise("rise_last_third").abs() < 0.1, "{address}: {found:?}");
    }
}
