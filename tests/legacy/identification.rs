//! `admire identify` on a study folder, for comparison with clients.

use std::path::Path;
use std::process::Command;

/// Result of `admire identify`.
pub struct Fit {
    /// Number of iterations of the loop.
    pub iterations: u64,
    /// Address and value of every stiffness, including those that symmetry makes equal to another one.
    pub stiffnesses: Vec<(String, f64)>,
}

/// Runs the command as a user would, with the method that `study.toml` selects.
pub fn by_admire(study: &Path) -> Fit {
    let out = study.join("by-admire");
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .arg("identify")
        .arg(study)
        .arg("--out")
        .arg(&out)
        .output()
        .expect("admire starts");
    // A loop that reaches its iteration limit still writes its result, and exits with 3.
    assert!(matches!(run.status.code(), Some(0 | 3)), "{run:?}");
    let text = std::fs::read_to_string(out.join("identification.json")).expect("an answer");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["method"], "regression");
    let mut stiffnesses = Vec::new();
    for parameter in json["parameters"].as_array().expect("parameters") {
        let value = parameter["value"].as_f64().expect("a value");
        let tied = parameter["tied"].as_array().into_iter().flatten();
        for address in std::iter::once(&parameter["address"]).chain(tied) {
            let address = address.as_str().expect("an address").to_string();
            stiffnesses.push((address, value));
        }
    }
    Fit {
        iterations: json["iterations"].as_u64().expect("a count"),
        stiffnesses,
    }
}
