use super::plant::{Plant, study};
use admire_diagnosis::{Outcome, diagnose, held_out};
use admire_identify::LoadedStudy;
use admire_report::diagnosis_sentences;

/// Table 2 of the paper, with increasing and decreasing loads so that hysteresis shows.
pub const UP_AND_DOWN: &str = "case,vertical,lateral,longitudinal
1,1500,0,0
2,3000,0,0
3,4500,0,0
4,6000,0,0
5,4500,0,0
6,3000,0,0
7,3000,1000,0
8,3000,2000,0
9,3000,1000,0
10,3000,0,0
11,3000,-1000,0
12,3000,-2000,0
13,3000,0,0
14,3000,0,1500
15,3000,0,3000
16,3000,0,1500
17,3000,0,0
18,3000,0,-1500
19,3000,0,0
";

/// Plants an effect, diagnoses the folder, and then compares with the truth; `check` makes further checks.
pub fn named(
    axle: &str,
    plant: &Plant,
    seed: u64,
    loads: Option<&str>,
    check: impl Fn(&Outcome<'_>),
) {
    let folder = study(axle, plant, 0.02, seed, loads);
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let problem = loaded.problem();
    let started = std::time::Instant::now();
    let outcome: Outcome<'_> =
        diagnose(&problem, held_out(&loaded.study, &loaded.measurement)).unwrap();
    let diagnosis = &outcome.diagnosis;
    println!(
        "{:?}: {:.1} s, {}",
        plant.truth,
        started.elapsed().as_secs_f64(),
        diagnosis.to_json()
    );
    println!("{}", diagnosis_sentences(&outcome).join("\n"));
    let first = diagnosis.findings.first();
    let named = first.map_or(("", ""), |f| (f.cause.as_str(), f.address.as_str()));
    let among = first.is_some_and(|f| {
        let rivals = &f.indistinguishable_from;
        rivals.len() <= 3
            && rivals
                .iter()
                .any(|r| (r.cause.as_str(), r.address.as_str()) == plant.truth)
    });
    assert!(named == plant.truth || among, "{named:?}");
    check(&outcome);
}
