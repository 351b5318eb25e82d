use admire_diagnosis::{GainCheck, Progress, diagnose_watched, held_out};
use admire_identify::LoadedStudy;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    // run diagnose STUDY --out OUT
    let loaded = LoadedStudy::read(std::path::Path::new(&a[2])).value.expect("study");
    let held = held_out(&loaded.study, &loaded.measurement);
    let problem = loaded.problem();
    let found = diagnose_watched(&problem, held, GainCheck::default(), &Progress::default()).expect("found");
    std::fs::create_dir_all(&a[4]).unwrap();
    std::fs::write(format!("{}/diagnosis.json", a[4]), serde_json::to_string_pretty(&found.diagnosis).unwrap()).unwrap();
}
