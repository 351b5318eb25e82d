//! The true axle, in a folder that the diagnosis never sees.

use std::path::Path;

use admire_identify::LoadedStudy;
use admire_rig::LoadTable;
use admire_study::noise::Noise;
use tempfile::TempDir;

use super::draw::Axle;

/// Relative scatter of the true stiffnesses about the values of the reference deck.
const SCATTER: f64 = 0.15;

/// The folder of the truth, and the parts of it that a diagnosis may see.
pub struct Truth {
    /// Study with the true deck, not measured yet.
    pub folder: TempDir,
    /// Deck of the user, in which the stiffnesses of the identified bushings are unknown.
    pub nominal: Vec<u8>,
    /// True values of the unknowns.
    pub values: Vec<f64>,
}

/// Sections of the study for readings besides marks: wheel and channels.
const WHEEL: [&str; 2] = [
    "\n[wheel]\nmarker = \"MARKER/20\"\naxis = \"y\"\nsigma = { position = 0.05, angle_deg = 0.01 }\n",
    "\n[wheel]\nmarker = \"MARKER/30\"\naxis = \"y\"\nsigma = { position = 0.05, angle_deg = 0.01 }\n",
];
const READINGS: [&str; 2] = [
    "\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\nheight = { function = \"DZ(20,48)\", sigma = 0.05 }\n\
     travel = { function = \"DM(18,17)\", sigma = 0.05 }\n",
    "\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\nheight = { function = \"DZ(30,68)\", sigma = 0.05 }\n\
     travel = { function = \"DM(26,25)\", sigma = 0.05 }\n",
];

/// Draws the true stiffnesses and writes the folder.
pub fn truth(
    axle: Axle,
    seed: u64,
    sigma: f64,
    programme: LoadTable,
    (wheel, readings): (bool, bool),
) -> Truth {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(axle.name());
    let read = |name: &str| std::fs::read_to_string(shipped.join(name)).expect("shipped");
    let folder = tempfile::tempdir().expect("a folder for the truth");
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("written");
    };
    let mut toml: String = read("study.toml")
        .replace("[reference]\ndeck = \"reference.adm\"\n", "")
        .replace("sigma = 0.05", &format!("sigma = {sigma}"))
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.to_string() + "\n")
        .collect();
    let k = axle as usize;
    if wheel {
        toml += WHEEL[k];
    }
    if readings {
        toml += READINGS[k];
    }
    write("study.toml", toml.as_bytes());
    write("load_cases.csv", programme.csv().as_bytes());
    write("marks_on_parts.csv", read("marks_on_parts.csv").as_bytes());
    write("model.adm", read("reference.adm").as_bytes());
    // Unknowns are defined by a measured study; the shipped one is used.
    let shipped = LoadedStudy::read(&shipped).value.expect("a shipped study");
    let mut scatter = Noise::new(seed, "stiffness");
    let values: Vec<f64> = shipped
        .reference_values()
        .into_iter()
        .map(|value| value.expect("in the reference") * (SCATTER * scatter.normal()).exp())
        .collect();
    let reference = LoadedStudy {
        dataset: shipped.reference.clone().expect("a reference deck"),
        ..shipped
    };
    let deck = reference
        .identified_deck(&values)
        .expect("numbers of the deck");
    write("model.adm", &deck);
    Truth {
        folder,
        nominal: read("model.adm").into_bytes(),
        values,
    }
}
