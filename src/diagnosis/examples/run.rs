use admire_diagnosis::*;
use admire_identify::LoadedStudy;
fn main() {
    for arg in std::env::args().skip(1) {
        let started = std::time::Instant::now();
        let loaded = LoadedStudy::read(std::path::Path::new(&arg)).value.expect("study");
        let problem = loaded.problem();
        let held = held_out(&loaded.study, &loaded.measurement);
        let progress = Progress::default();
        let check = if std::env::var("FULL").is_ok() { GainCheck::default() } else { GainCheck::Quick };
        let found = diagnose_watched(&problem, held, check, &progress);
        let Ok(found) = found else { println!("{arg}\tFAILED"); continue };
        let d = &found.diagnosis;
        let names: Vec<String> = d.findings.iter().map(|f| format!("{} {}{} p={:.3} g={:.3}", f.cause, f.address, if f.minor {" (minor)"} else {""}, f.probability, f.group_probability)).collect();
        println!("{arg}\t{:?}\tnone={:.3}\t{:?}\tsweeps={}\t{:.1} s\t{:?}", d.verdict, d.none_of_these, names, progress.sweeps(), started.elapsed().as_secs_f64(), d.unexplained.places);
        if let Ok(out) = std::env::var("OUT") {
            std::fs::create_dir_all(&out).unwrap();
            let name = std::path::Path::new(&arg).file_name().unwrap().to_string_lossy().into_owned();
            std::fs::write(format!("{out}/{name}.json"), d.to_json()).unwrap();
        }
    }
}
