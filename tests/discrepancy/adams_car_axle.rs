//! The shipped axle of Adams/Car: its deck has linear bushings, and its readings are positions of a real axle with noise.

use std::path::Path;

use admire_diagnosis::{
    Cause, GainCheck, LARGEST_RADIAL_DEFLECTION, Progress, STIFFNESS_RISES, Verdict,
    diagnose_watched, held_out,
};
use admire_identify::LoadedStudy;

/// Checks that exactly the progressive components are named: both bushings of the arm soften along their axes beyond 3 mm, to 72 percent of their
/// stiffness, and the inner one softens across its axis. The stiffnesses along the axes without deflection are those of the real bushings.
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
    let findings = diagnosis.findings.iter();
    let mut named: Vec<&str> = findings.map(|finding| finding.address.as_str()).collect();
    named.sort_unstable();
    assert_eq!(named, ["BUSHING/3.K.3", "BUSHING/4.K.2", "BUSHING/4.K.3"]);
    let across = diagnosis
        .findings
        .iter()
        .find(|f| f.address == "BUSHING/4.K.2");
    let across = &across.expect("it is named").parameters;
    let rises = STIFFNESS_RISES.map(|name| across[name]);
    // The real stiffness of 9839 N/mm falls by 14 percent.
    let fall = rises.iter().sum::<f64>() / 9839.0;
    assert!((-0.5..-0.1).contains(&fall), "{across:?}");
    assert!(across.contains_key(LARGEST_RADIAL_DEFLECTION), "{across:?}");
    for (address, stiffness) in [("BUSHING/3.K.3", 299.0), ("BUSHING/4.K.3", 448.0)] {
        let mut findings = diagnosis.findings.iter();
        let found = findings
            .find(|f| f.cause == Cause::ProgressiveStiffness && f.address == address)
            .unwrap_or_else(|| panic!("{address} is not among {:?}", diagnosis.findings));
        let mut parameters = diagnosis.parameters.iter();
        let own = parameters.find(|parameter| parameter.address == address);
        let value = own.expect("it is identified").value;
        assert!((value / stiffness - 1.0).abs() < 0.04, "{address}: {value}");
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
