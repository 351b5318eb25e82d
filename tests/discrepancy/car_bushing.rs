//! A bushing that the deck has as Adams/Car writes it: a FIELD with curves. The real bushing stiffens with the deflection.

use std::path::Path;

use admire_diagnosis::{Cause, GainCheck, Progress, Verdict, diagnose_watched, held_out};
use admire_identify::LoadedStudy;
use admire_rig::{RigOptions, virtual_rig};

/// Radial stiffness without deflection, in N/mm. It is softer than that of the shipped BUSHING/3, so that the strut moves sideways.
const RADIAL: f64 = 1000.0;
/// Deflection at which the radial stiffness of the real bushing is cosh(1) times that, in mm.
const RUBBER: f64 = 1.0;

/// Returns the statements of a FIELD in place of the shipped BUSHING/3. Its radial force is `law`.
fn field(law: impl Fn(f64) -> f64) -> String {
    let words = ["tx", "ty", "tz", "rx", "ry", "rz"];
    let stiffness = [
        3500.0,
        3500.0,
        1500.0,
        143_239.448_782_7,
        143_239.448_782_7,
        34_377.467_707_85,
    ];
    let mut text = String::new();
    let list = |values: Vec<f64>| {
        let words: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        words.join(", ")
    };
    for (axis, word) in words.into_iter().enumerate() {
        let unit = if axis < 3 { 0.5 } else { 0.05 };
        let x: Vec<f64> = (-16..=16).map(|k| f64::from(k) * unit).collect();
        let force = |x: &f64| {
            if axis < 2 {
                law(*x)
            } else {
                stiffness[axis] * x
            }
        };
        let y = x.iter().map(force).collect();
        let id = 901 + axis;
        text += &format!(
            "! adams_view_name='axle.top_mount.{word}_spline'\nSPLINE/{id}, LINEAR_EXTRAPOLATE, X = {}\n, Y = {}\n\
             ! adams_view_name='axle.top_mount.{word}_data_array'\nARRAY/{id}, NUMBERS = 2, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1\n",
            list(x),
            list(y),
        );
    }
    text + "! adams_view_name='axle.top_mount.field'\n\
            FIELD/9, I = 5, J = 6, FUNCTION = USER(902, 901, 902, 903, 904, 905, 906)\\\n, ROUTINE = abgVDM::fie900\n"
}

/// Returns a shipped deck with the FIELD in place of BUSHING/3.
fn deck(name: &str, law: impl Fn(f64) -> f64) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let at = text.find("BUSHING/3\n").expect("the bushing");
    let lines = text[at..].split_inclusive('\n');
    let length: usize = lines.take(7).map(str::len).sum();
    let rest = &text[at + length..];
    assert!(!rest.trim_start().starts_with(','), "{}", &rest[..80]);
    format!("{}{}{rest}", &text[..at], field(law))
}

#[test]
fn rubber_that_stiffens_is_found_in_a_field_of_adams_car() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).unwrap();
    let read = |name: &str| std::fs::read_to_string(shipped.join(name)).unwrap();
    let toml = read("study.toml").replace("[reference]\ndeck = \"reference.adm\"\n", "");
    write("study.toml", toml.as_bytes());
    for name in ["load_cases.csv", "marks_on_parts.csv"] {
        write(name, read(name).as_bytes());
    }
    let rubber = |x: f64| RADIAL * RUBBER * (x / RUBBER).sinh();
    write("model.adm", deck("reference.adm", rubber).as_bytes());
    let measured = virtual_rig(folder.path(), &RigOptions::default()).expect("equilibria");
    for (name, bytes) in &measured.files {
        write(&name.to_string_lossy(), bytes);
    }
    write("model.adm", deck("model.adm", |x| RADIAL * x).as_bytes());
    let loaded = LoadedStudy::read(folder.path()).value.expect("a study");
    let outcome = diagnose_watched(
        &loaded.problem(),
        held_out(&loaded.study, &loaded.measurement),
        GainCheck::Quick,
        &Progress::default(),
    )
    .expect("an answer");
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Discrepancy, "{diagnosis:#?}");
    let first = &diagnosis.findings[0];
    let named = (first.cause, first.address.as_str());
    assert_eq!(
        named,
        (Cause::ProgressiveStiffness, "FIELD/9.FY"),
        "{first:#?}"
    );
    assert!(first.probability > 0.9, "{first:#?}");
}
