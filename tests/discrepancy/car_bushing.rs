//! A bushing that the deck has as Adams/Car writes it: a FIELD with curves. Effects at it are planted, measured and named as at a BUSHING.

use std::path::Path;

use admire_diagnosis::{
    Cause, Finding, GainCheck, LARGEST_RADIAL_DEFLECTION, Progress, STIFFNESS_RISES, Verdict,
    diagnose_watched, held_out, spline_terms,
};
use admire_identify::LoadedStudy;
use admire_rig::{RigOptions, effect::EffectSpec, virtual_rig};

use crate::car_axle::with_field;

/// Radial stiffness without deflection, in N/mm. It is softer than that of the shipped BUSHING/3, so that the strut moves sideways.
const RADIAL: f64 = 1000.0;
/// Noise of the mark readings, in mm.
const SIGMA: f64 = 0.02;
/// Deflection at which the radial stiffness of the real bushing is cosh(1) times that, in mm.
const RUBBER: f64 = 1.0;

fn shipped(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Returns a folder with the shipped study, in which the deck is replaced by `deck`.
fn study(deck: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut toml = shipped("study.toml").replace("[reference]\ndeck = \"reference.adm\"\n", "");
    if !deck.contains("BUSHING/2\n") {
        toml = toml.replace("\"BUSHING/1\", \"BUSHING/2\"", "\"BUSHING/1\"");
    }
    for (name, text) in [
        ("study.toml", toml.as_str()),
        ("load_cases.csv", &shipped("load_cases.csv")),
        ("marks_on_parts.csv", &shipped("marks_on_parts.csv")),
        ("model.adm", deck),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Measures a study on the virtual rig, with these effects. Returns the files of the measurement.
fn measured(folder: &Path, effects: &[&str], sigma: Option<f64>) -> Vec<(String, Vec<u8>)> {
    let options = RigOptions {
        sigma,
        effects: effects
            .iter()
            .map(|text| EffectSpec::parse(text).expect(text))
            .collect(),
        ..RigOptions::default()
    };
    let run = virtual_rig(folder, &options).unwrap_or_else(|why| panic!("{effects:?}: {why:?}"));
    let files = run.files.into_iter();
    files
        .map(|(name, bytes)| (name.to_string_lossy().into_owned(), bytes))
        .collect()
}

/// Measures the shipped axle with the FIELD and these effects, and diagnoses it. `added` is added to
/// `study.toml`. Returns the verdict, and the findings
/// that are not minor.
fn named((truth, model): (&str, &str), effects: &[&str], added: &str) -> (Verdict, Vec<Finding>) {
    let folder = study(truth);
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    for (name, bytes) in measured(folder.path(), effects, Some(SIGMA)) {
        write(&name, &bytes);
    }
    let toml = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    write("study.toml", format!("{toml}\n{added}").as_bytes());
    write("model.adm", model.as_bytes());
    let loaded = LoadedStudy::read(folder.path()).value.expect("a study");
    let outcome = diagnose_watched(
        &loaded.problem(),
        held_out(&loaded.study, &loaded.measurement),
        GainCheck::Quick,
        &Progress::default(),
    )
    .expect("an answer");
    let diagnosis = outcome.diagnosis;
    let findings = diagnosis.findings.into_iter();
    (
        diagnosis.verdict,
        findings.filter(|finding| !finding.minor).collect(),
    )
}

#[test]
fn rubber_that_stiffens_is_found_in_a_field_of_adams_car() {
    let rubber = |x: f64| RADIAL * RUBBER * (x / RUBBER).sinh();
    let line = |x: f64| RADIAL * x;
    let deck = |name: &str, law: &dyn Fn(f64) -> f64| {
        with_field(&shipped(name), 3, "axle.top_mount", Some(law))
    };
    let (verdict, findings) = named(
        (&deck("reference.adm", &rubber), &deck("model.adm", &line)),
        &[],
        "",
    );
    assert_eq!(verdict, Verdict::Discrepancy, "{findings:?}");
    let first = &findings[0];
    assert_eq!(
        (first.cause, first.address.as_str()),
        (Cause::ProgressiveStiffness, "FIELD/9.FY"),
        "{findings:?}"
    );
    assert!(first.probability > 0.9, "{findings:?}");
}

/// Rubber whose stiffness falls to 60 percent within a band of radial deflections is no power law. The law that is found has the force of the real
/// one.
#[test]
fn rubber_that_softens_within_a_band_is_found_with_its_law() {
    // The stiffness falls as a cosine between 0.6 and 1.4 mm.
    let (from, to, lost) = (0.6, 1.4, 0.4);
    let force = |x: f64| {
        let beyond = (x.abs() - from).clamp(0.0, to - from);
        let w = std::f64::consts::PI / (to - from);
        let lost_force = 0.5 * (beyond - (w * beyond).sin() / w) + (x.abs() - to).max(0.0);
        RADIAL * (x.abs() - lost * lost_force) * x.signum()
    };
    let deck = |name: &str, law: &dyn Fn(f64) -> f64| {
        with_field(&shipped(name), 3, "axle.top_mount", Some(law))
    };
    let (truth, model) = (
        deck("reference.adm", &force),
        deck("model.adm", &|x| RADIAL * x),
    );
    let (_, findings) = named((&truth, &model), &[], "");
    let mut laws = findings.iter();
    let found = laws
        .find(|f| f.cause == Cause::ProgressiveStiffness && f.address == "FIELD/9.FY")
        .unwrap_or_else(|| panic!("{findings:?}"));
    assert!(found.probability > 0.9, "{findings:?}");
    let largest = found.parameters[LARGEST_RADIAL_DEFLECTION];
    let terms = spline_terms(largest, STIFFNESS_RISES.map(|name| found.parameters[name]));
    for k in 1..=6 {
        let u = largest * f64::from(k) / 6.0;
        let added = terms.iter().map(|[a, c]| c * (u - a).max(0.0).powi(2));
        let law = RADIAL * u + added.sum::<f64>();
        assert!(
            (law - force(u)).abs() < 0.05 * force(largest),
            "{u}: {law} {} {found:?}",
            force(u)
        );
    }
}

/// A FIELD with straight curves is the BUSHING with the same stiffnesses. Every effect at the FIELD gives the readings of that effect at the
/// BUSHING.
#[test]
fn an_effect_at_a_field_measures_as_at_a_bushing() {
    let bushing = study(&shipped("reference.adm"));
    let field = study(&with_field(
        &shipped("reference.adm"),
        3,
        "axle.top_mount",
        None,
    ));
    for (cause, at_bushing, at_field, values) in [
        (
            "progressive-stiffness",
            "BUSHING/3.K.2",
            "FIELD/9.FY",
            "law=cubic,cubic=900",
        ),
        (
            "progressive-stiffness",
            "BUSHING/3.K.1",
            "axle.top_mount.fx",
            "law=exponential,rate=0.4",
        ),
        (
            "dry-friction",
            "BUSHING/3.K.3",
            "FIELD/9.FZ",
            "force=150,stiffness=3000",
        ),
        ("creep", "BUSHING/3.K.2", "axle.top_mount.FY", "rate=0.3"),
        ("free-play", "BUSHING/3.K.1", "FIELD/9.FX", "gap=0.1"),
        (
            "assembly-offset",
            "BUSHING/3",
            "FIELD/9",
            "x=0.5,y=-0.3,az_deg=0.4",
        ),
        (
            "bushing-orientation",
            "BUSHING/3",
            "axle.top_mount",
            "ax_deg=5,ay_deg=-3",
        ),
        ("bushing-coupling", "BUSHING/3", "FIELD/9", "xy=400,reach=2"),
    ] {
        let [a, b] = [(&bushing, at_bushing), (&field, at_field)].map(|(folder, address)| {
            let effect = format!("{cause}@{address}:{values}");
            measured(folder.path(), &[&effect], Some(0.0))
        });
        let plain = measured(bushing.path(), &[], Some(0.0));
        let readings = |files: &[(String, Vec<u8>)]| -> Vec<f64> {
            let marks = files.iter().find(|(name, _)| name == "marks_measured.csv");
            let text = String::from_utf8_lossy(&marks.expect("the readings").1).into_owned();
            let words = text.split([',', '\n']);
            words.filter_map(|word| word.trim().parse().ok()).collect()
        };
        let [a, b, plain] = [&a, &b, &plain].map(|files| readings(files));
        let apart = |a: &[f64], b: &[f64]| {
            let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            each.fold(0.0, f64::max)
        };
        assert_eq!(a.len(), b.len());
        assert!(apart(&a, &b) < 1e-6, "{cause}: {}", apart(&a, &b));
        assert!(apart(&a, &plain) > 1e-3, "{cause} does not act");
    }
}

/// Offset, orientation and coupling of a FIELD are named there, while the scales of its curves are identified as the stiffnesses of a BUSHING are.
/// A wrong scale is named if it counts as known.
#[test]
fn errors_of_a_field_are_named_at_the_field() {
    let deck = with_field(&shipped("reference.adm"), 2, "axle.arm_front", None);
    let scales = "[[identify.unknown]]\nnumbers = [\"ARRAY/90?.NUMBERS.3\"]\nform = \"factor\"\n";
    let own = "FIELD/9";
    for (effect, added, cause, address) in [
        (
            "bushing-coupling@FIELD/9:xy=350",
            scales,
            Cause::BushingCoupling,
            own,
        ),
        (
            "bushing-orientation@FIELD/9:az_deg=14",
            scales,
            Cause::BushingOrientation,
            own,
        ),
        (
            "assembly-offset@FIELD/9:x=1.5,y=1.0",
            scales,
            Cause::AssemblyOffset,
            own,
        ),
        (
            "element-parameter@ARRAY/901.NUMBERS.3:factor=1.6",
            "",
            Cause::ElementParameter,
            "ARRAY/901.NUMBERS.3",
        ),
    ] {
        let (verdict, findings) = named((&deck, &deck), &[effect], added);
        let found: Vec<_> = findings
            .iter()
            .map(|f| (f.cause, f.address.as_str()))
            .collect();
        assert_eq!(
            found,
            [(cause, address)],
            "{effect}: {verdict:?} {findings:?}"
        );
    }
}
