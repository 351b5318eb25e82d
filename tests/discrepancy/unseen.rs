//! Held-out cases are unknown to the choice of causes and to the fits that predict them.

use admire_diagnosis::{GainCheck, Outcome, Progress, diagnose_watched};
use admire_identify::LoadedStudy;

use super::plant::{Plant, study};

/// All cases with a lateral load to one side, where the wrong gain has the largest effect, and one with a longitudinal load.
const HELD_OUT: [usize; 3] = [7, 8, 11];

fn with_diagnosis(
    reading: fn(usize, usize, usize, &mut [f64; 3]),
    check: GainCheck,
    look: &mut dyn FnMut(&Outcome<'_>),
) {
    let plant = Plant {
        loads: |values| values[1] *= 1.06,
        reading,
        ..Plant::nothing()
    };
    let folder = study("pseudo-mcpherson", &plant, 0.02, 31, None);
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let count = loaded.measurement.cases.len();
    let held = (0..count).map(|case| HELD_OUT.contains(&case)).collect();
    let progress = Progress::default();
    let outcome = diagnose_watched(&loaded.problem(), held, check, &progress).unwrap();
    look(&outcome);
}

#[test]
fn what_is_read_in_cases_held_out_moves_no_fit_that_predicts_them() {
    let mut chosen = Vec::new();
    let mut look = |outcome: &Outcome<'_>| {
        let found = outcome.diagnosis.hold_out.clone().unwrap();
        println!("{found:?}");
        assert_eq!(found.cases, ["8", "9", "12"]);
        assert_eq!(found.causes[0], "load-gain SFORCE/2", "{found:?}");
        let unseen = outcome.unseen.as_ref().unwrap();
        chosen.push((unseen.chosen.x.clone(), outcome.extended.x.clone(), found));
    };
    let nothing: fn(usize, usize, usize, &mut [f64; 3]) = |_, _, _, _| {};
    with_diagnosis(nothing, GainCheck::HeldOut, &mut look);
    // Whole parts are read 0.3 mm off; the marks keep their relative positions, so that their apparent noise is unchanged.
    let shifted: fn(usize, usize, usize, &mut [f64; 3]) = |case, part, _, x| {
        if HELD_OUT.contains(&case) {
            x[part % 3] += 0.3;
        }
    };
    with_diagnosis(shifted, GainCheck::HeldOut, &mut look);
    with_diagnosis(nothing, GainCheck::Quick, &mut |outcome| {
        let found = outcome.diagnosis.hold_out.as_ref().unwrap();
        assert!(!found.searched && found.gain > 0.0, "{found:?}");
    });
    let [(own, all, found), (own_again, all_again, worse)] = &chosen[..] else {
        panic!("two diagnoses");
    };
    assert!(
        found.searched && found.gain > 0.0 && found.p_value > 0.01,
        "{found:?}"
    );
    // Only the weights of the rows change with the noise estimated from all marks, so the values agree to the last digits.
    for (a, b) in own.iter().zip(own_again) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    assert!(
        all.len() != all_again.len()
            || all.iter().zip(all_again).any(|(a, b)| (a - b).abs() > 1e-2)
    );
    assert!(
        worse.p_value < 0.01 && worse.rms_after > 3.0 * found.rms_after,
        "{worse:?}"
    );
}

#[test]
fn every_group_may_be_predicted_by_a_search_of_its_own() {
    let nothing: fn(usize, usize, usize, &mut [f64; 3]) = |_, _, _, _| {};
    with_diagnosis(nothing, GainCheck::Folds, &mut |outcome| {
        let found = outcome.diagnosis.cross_validation.as_ref().unwrap();
        assert!(found.searched);
        println!("{found:#?}");
        for group in &found.groups {
            let known = group.causes.iter();
            assert_eq!(
                known.collect::<Vec<_>>(),
                ["load-gain SFORCE/2"],
                "{group:?}"
            );
        }
        assert!(found.gain > 0.0, "{found:?}");
    });
}
