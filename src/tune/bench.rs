//! Tests of the search on the double wishbone of the corpus, and of derivatives against finite differences.

use std::path::Path;

use crate::{Outcome, Tuning};
use admire_study::Noise;

const CORPUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpus");

/// Rig of the double wishbone. The wheel motions of the deck itself are removed.
pub(crate) const KC: &str = r#"
[deck]
axes = "adams-car"
without = ["MOTION/2", "MOTION/3"]
[wheels]
left = { centre = "MARKER/130", spin = "MARKER/134" }
right = { centre = "MARKER/230", spin = "MARKER/234" }
[tests.bounce]
range = [-80, 80]
points = 17
"#;

/// Hardpoints of both ball joints and of both ends of the tie rod: 12 coordinates, each with its mirror image on the right.
pub(crate) const POINTS: &str = r#"
[[target.unknown]]
numbers = ["MARKER/112.QP", "MARKER/122.QP", "MARKER/142.QP", "MARKER/141.QP"]
bounds = ["-15 mm", "15 mm"]
symmetric = true
"#;

pub(crate) const TOE_AND_CAMBER: &str = r#"
[[target.goal]]
test = "bounce"
of = "toe_angle.left"
curve = "wanted.csv"
tolerance = 0.001
[[target.goal]]
test = "bounce"
of = "camber_angle.left"
curve = "wanted.csv"
tolerance = 0.001
"#;

/// Writes a study into a folder and reads it.
pub(crate) fn study(folder: &Path, deck: &[u8], wanted: &str, target: &str, kc: &str) -> Tuning {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).expect(name);
    write("model.adm", deck);
    write("kc.toml", kc.as_bytes());
    write("wanted.csv", wanted.as_bytes());
    let toml = format!("[model]\ndeck = \"model.adm\"\n{target}");
    write("study.toml", toml.as_bytes());
    let (found, said) = Tuning::read(folder);
    found.unwrap_or_else(|_| panic!("{said:#?}"))
}

pub(crate) fn search(tuning: &Tuning) -> Outcome {
    let found = tuning.search(&mut |_, _| true);
    found.expect("an equilibrium at the start")
}

pub(crate) fn corpus(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(CORPUS).join(name)).expect(name)
}

/// Runs the deck unchanged and returns the curves as a table of target curves.
pub(crate) fn wanted(tuning: &Tuning, of: &[&str]) -> String {
    let mut text = format!(
        "test,value,{}\n",
        of.iter()
            .map(|path| format!("{path} [deg]"))
            .collect::<Vec<_>>()
            .join(",")
    );
    for test in tuning.before.run.iter().flat_map(|run| &run.tests) {
        for sample in &test.samples {
            let reading = |path: &&str| {
                let mut all = sample.readings.iter();
                let found = all
                    .find(|reading| reading.path() == **path)
                    .expect("a reading");
                format!("{:?}", found.value.to_degrees())
            };
            let cells: Vec<String> = of.iter().map(reading).collect();
            text += &format!(
                "{},{},{}\n",
                test.kind.name(),
                sample.value,
                cells.join(",")
            );
        }
    }
    text
}

/// Checks that the search corrects hardpoints that were moved by up to 10 mm. Afterwards, toe and camber over 80 mm of travel in both
/// directions equal those of the original deck.
#[test]
fn moved_hardpoints_find_the_curves_of_the_original() {
    let original = corpus("double-wishbone/model.adm");
    let folder = tempfile::tempdir().expect("a folder");
    let flat = "value,toe_angle.left [deg],camber_angle.left [deg]\n-80,0,0\n80,0,0\n";
    let target = format!("[target]\nrestarts = 0\nevaluations = 50\n{POINTS}{TOE_AND_CAMBER}");
    let first = study(folder.path(), &original, flat, &target, KC);
    assert_eq!(first.unknowns.len(), 12);
    let curves = wanted(&first, &["toe_angle.left", "camber_angle.left"]);
    let (mut met, mut told) = (0, String::new());
    for draw in 0..20 {
        let mut noise = Noise::new(draw, "moved hardpoints");
        let moved: Vec<f64> = (0..12).map(|_| noise.within(10.0)).collect();
        let deck = first.deck(&moved).expect("a deck");
        let tuning = study(folder.path(), deck.bytes(), &curves, &target, KC);
        let found = search(&tuning);
        let rms = found
            .goals
            .iter()
            .map(|goal| goal.rms_after)
            .fold(0.0, f64::max);
        told += &format!(
            "{draw}: {} evaluations, {} runs, rms {rms:.2e} deg, before {:.3}\n",
            found.evaluations, found.runs, found.goals[0].rms_before
        );
        assert!(found.evaluations <= 50);
        if rms <= 1e-3 {
            met += 1;
            continue;
        }
        let again = target.replace("restarts = 0", "restarts = 8");
        let tuning = study(folder.path(), deck.bytes(), &curves, &again, KC);
        let found = search(&tuning);
        let rms = found
            .goals
            .iter()
            .map(|goal| goal.rms_after)
            .fold(0.0, f64::max);
        assert!(rms <= 1e-3, "{told}restarts: {rms}");
    }
    println!("{told}");
    assert!(met >= 18, "{told}");
}

/// Checks that the derivatives agree with finite differences, for hardpoints, bushings, springs, factors and mirror images.
#[test]
fn derivatives_are_those_of_differences() {
    let folder = tempfile::tempdir().expect("a folder");
    let flat = "value,toe_angle.left [deg],camber_angle.left [deg]\n-80,0,0\n80,0,0\n";
    let target = format!("[target]\n{POINTS}{TOE_AND_CAMBER}");
    let wishbone = study(
        folder.path(),
        &corpus("double-wishbone/model.adm"),
        flat,
        &target,
        KC,
    );
    let other = tempfile::tempdir().expect("a folder");
    let target = r#"
[target]
[[target.unknown]]
numbers = ["BUSHING/1.K.1", "BUSHING/2.KT.3"]
form = "factor"
bounds = [0.5, 2.0]
[[target.unknown]]
numbers = ["BUSHING/3.K"]
form = "factor"
together = true
bounds = [0.5, 2.0]
[[target.unknown]]
numbers = ["MARKER/10.QP.3"]
bounds = [-5, 5]
[[target.goal]]
test = "bounce"
of = "toe_angle.left"
gradient = 1.0
tolerance = 0.1
[[target.goal]]
test = "roll"
of = "camber_angle.right"
value = 1.0
at = 20.0
tolerance = 0.1
[[target.goal]]
test = "lateral"
of = "toe_angle.right"
least = -1.0
limits = "gradient"
tolerance = 0.1
[[target.goal]]
test = "braking"
of = "wheel_travel_base.base_left"
value = 1.0
at = 1000
tolerance = 0.1
[[target.goal]]
test = "ride"
of = "side_view_angle.left"
value = 0.0
tolerance = 0.1
[[target.goal]]
test = "bounce"
of = "wheel_load_vertical_force.vertical_left_force"
gradient = 20.0
tolerance = 1.0
"#;
    let kc = String::from_utf8(corpus("multilink/kc.toml")).expect("text");
    let multilink = study(
        other.path(),
        &corpus("multilink/model.adm"),
        flat,
        target,
        &kc,
    );
    for tuning in [&wishbone, &multilink] {
        let mut evaluator = crate::evaluation::Evaluator::new(tuning);
        assert!(evaluator.is_exact.iter().all(|exact| *exact));
        assert!(tuning.goals.iter().all(|goal| goal.is_exact));
        let x: Vec<f64> = tuning.scale().iter().map(|scale| 0.1 * scale).collect();
        let exact = evaluator
            .evaluate(&x, true)
            .expect("an equilibrium")
            .jacobian;
        for k in 0..x.len() {
            let step = 1e-3 * tuning.scale()[k];
            let mut values = |h: f64| {
                let mut moved = x.clone();
                moved[k] += h;
                evaluator
                    .evaluate(&moved, false)
                    .expect("an equilibrium")
                    .values
            };
            let (plus, minus) = (values(step), values(-step));
            for row in 0..plus.len() {
                let difference = (plus[row] - minus[row]) / (2.0 * step);
                let size = exact.row(row).amax().max(1e-5);
                assert!(
                    (difference - exact[(row, k)]).abs() < 1e-5 * size,
                    "{} row {row}: {difference} {}",
                    tuning.unknowns[k].name,
                    exact[(row, k)]
                );
            }
        }
    }
}

/// Identifies the pseudo McPherson axle, whose spring is 25 percent too stiff in the deck, with this section of `study.toml`.
fn identified(section: &str) -> admire_identify::Fit {
    let folder = tempfile::tempdir().expect("a folder");
    let names = ["load_cases.csv", "marks_on_parts.csv", "marks_measured.csv"];
    for name in names {
        let bytes = corpus(&format!("pseudo-mcpherson/{name}"));
        std::fs::write(folder.path().join(name), bytes).expect(name);
    }
    let deck = String::from_utf8(corpus("pseudo-mcpherson/model.adm")).expect("text");
    let deck = deck.replace(", K = 60.0\n", ", K = 75.0\n");
    std::fs::write(folder.path().join("model.adm"), deck).expect("a deck");
    let toml = format!(
        "[model]\ndeck = \"model.adm\"\n[loads]\nfile = \"load_cases.csv\"\n\
         columns = {{ vertical = \"SFORCE/3\", lateral = \"SFORCE/2\", longitudinal = \"SFORCE/1\" }}\n\
         [marks]\non_parts = \"marks_on_parts.csv\"\nmeasured = \"marks_measured.csv\"\nsigma = 0.05\n{section}"
    );
    std::fs::write(folder.path().join("study.toml"), toml).expect("a study");
    let read = admire_identify::LoadedStudy::read(folder.path());
    let loaded = read
        .value
        .unwrap_or_else(|| panic!("{:#?}", read.diagnostics));
    let problem = loaded.problem();
    let prepared = admire_identify::global::Prepared::new(&problem).expect("a model");
    let options = admire_identify::global::Options::default();
    let found = admire_identify::global::fit_study(&problem, &prepared, None, options);
    found.expect("a fit").fit
}

/// Checks three properties of a table `[[identify.unknown]]`: it identifies a spring rate like the short form, it keeps its bounds, and it
/// ties two numbers.
#[test]
fn tables_of_unknowns_are_identified_like_the_short_form() {
    let bushings = "[identify]\nbushings = [\"BUSHING/1\", \"BUSHING/2\"]\n";
    let value = |fit: &admire_identify::Fit, address: &str| {
        let found = fit.parameters.iter().find(|own| own.address == address);
        found.map(|own| own.value).expect("a parameter")
    };
    let short = identified(&format!("{bushings}stiffnesses = [\"SPRINGDAMPER/1.K\"]\n"));
    let spring = "[[identify.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\n";
    let table = identified(&format!("{bushings}{spring}"));
    let (a, b) = (
        value(&short, "SPRINGDAMPER/1.K"),
        value(&table, "SPRINGDAMPER/1.K"),
    );
    assert!(
        (a - b).abs() < 1e-6 * a && (a - 60.0).abs() < 2.0,
        "{a} {b}"
    );
    let bounded = format!("{bushings}{spring}bounds = [\"65 N/mm\", \"80 N/mm\"]\n");
    let bounded = value(&identified(&bounded), "SPRINGDAMPER/1.K");
    assert!((bounded - 65.0).abs() < 1e-6, "{bounded}");
    let tied = "[[identify.unknown]]\nnumbers = [\"BUSHING/1.K.1\", \"BUSHING/1.K.2\"]\nform = \"factor\"\ntogether = true\n";
    let tied = identified(&format!("{bushings}{tied}"));
    // Two of the twelve stiffnesses are tied, so eleven are left.
    assert_eq!(tied.parameters.len(), 11);
    assert!(value(&tied, "BUSHING/1.K.1") > 0.0);
}

/// Checks that a limit holds although a goal pulls beyond it. Checks that a minimax goal ends with two equal misses. Both are reported with
/// their kind.
#[test]
fn limits_hold_and_minimax_levels_the_misses() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = corpus("double-wishbone/model.adm");
    let unknown = "[[target.unknown]]\nnumbers = [\"MARKER/141.QP.3\"]\nbounds = [-45, 45]\nsymmetric = true\n";
    let flat = "value,toe_angle.left [deg]\n-80,0.0\n80,0.0\n";
    let limited = format!(
        "[target]\nrestarts = 2\n{unknown}\
         [[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\ngradient = 20.0\ntolerance = 0.1\n\
         [[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\nleast = -2.0\nmost = 2.0\ntolerance = 0.001\n"
    );
    let found = search(&study(folder.path(), &deck, flat, &limited, KC));
    let (goal, limit) = (&found.goals[0], &found.goals[1]);
    assert!(
        found.converged && !goal.is_met && limit.is_met,
        "{found:#?}"
    );
    let reached = limit
        .rows
        .iter()
        .map(|row| row.after.abs())
        .fold(0.0, f64::max);
    assert!((reached - 2.0).abs() < 1e-5, "{reached}");
    assert!(limit.multiplier > 0.0);
    assert_eq!(found.conflicts.len(), 1, "{:?}", found.conflicts);
    assert_eq!(found.agreeing, 3);

    let goal = |minimax: &str| {
        format!(
            "[target]\nrestarts = 0\n{unknown}[[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\ncurve = \"wanted.csv\"\ntolerance = 0.01\n{minimax}"
        )
    };
    let wanted = "value,toe_angle.left [deg]\n-80,0.4\n0,0.0\n80,0.1\n";
    let squares = search(&study(folder.path(), &deck, wanted, &goal(""), KC));
    let largest = search(&study(
        folder.path(),
        &deck,
        wanted,
        &goal("minimax = true\n"),
        KC,
    ));
    let (a, b) = (&squares.goals[0], &largest.goals[0]);
    assert!(
        largest.converged && b.largest_after < 0.999 * a.largest_after,
        "{a:#?} {b:#?}"
    );
    assert!(b.rms_after > a.rms_after);
    let misses = b
        .rows
        .iter()
        .map(|row| row.after - row.least.unwrap_or_default());
    let near = misses.filter(|miss| (miss.abs() - b.largest_after).abs() < 1e-3 * b.largest_after);
    assert!(near.count() >= 2, "{b:#?}");
}

/// Checks that bad input is reported at its position in `study.toml`.
#[test]
fn every_complaint_points_at_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = corpus("double-wishbone/model.adm");
    let good = "[[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\ngradient = 1\ntolerance = 0.1\n";
    let unknown = "[[target.unknown]]\nnumbers = [\"MARKER/141.QP\"]\nbounds = [-15, 15]\n";
    let cases = [
        (
            format!("{good}{}", unknown.replace("MARKER/141", "MARKER/999")),
            "\"MARKER/999.QP\"",
        ),
        (
            format!("{good}{}", unknown.replace("bounds = [-15, 15]\n", "")),
            "[[target.unknown]]",
        ),
        (
            format!("{good}{}", unknown.replace("[-15, 15]", "[\"-15 kg\", 15]")),
            "\"-15 kg\"",
        ),
        (
            format!("{good}{}", unknown.replace("[-15, 15]", "[15, -15]")),
            "15",
        ),
        (
            format!("{good}{unknown}form = \"factor\"\n"),
            "\"MARKER/141.QP\"",
        ),
        (format!("{good}{unknown}sd = 0\n"), "0"),
        (
            format!("{unknown}{}", good.replace("bounce", "bonce")),
            "\"bonce\"",
        ),
        (
            format!("{unknown}{}", good.replace("toe_angle.left", "toe.left")),
            "\"toe.left\"",
        ),
        (
            format!("{unknown}{}", good.replace("gradient = 1\n", "")),
            "[[target.goal]]",
        ),
        (format!("{unknown}{good}value = 1\n"), "[[target.goal]]"),
        (format!("{unknown}{good}weight = 1\n"), "weight"),
        (unknown.to_string(), "target"),
        (
            format!(
                "{good}{}",
                unknown.replace("MARKER/141.QP", "MARKER/20.QP.2") + "symmetric = true\n"
            ),
            "\"MARKER/20.QP.2\"",
        ),
    ];
    for (text, place) in cases {
        let toml = format!("[model]\ndeck = \"model.adm\"\n[target]\n{text}");
        std::fs::write(folder.path().join("model.adm"), &deck).expect("a deck");
        std::fs::write(folder.path().join("kc.toml"), KC).expect("a rig");
        std::fs::write(folder.path().join("study.toml"), &toml).expect("a study");
        let (found, said) = Tuning::read(folder.path());
        assert!(found.is_err(), "{toml}");
        let spans: Vec<&str> = said
            .iter()
            .flat_map(|one| &one.labels)
            .map(|label| &toml[label.span.range()])
            .collect();
        let is_there =
            |span: &&str| *span == place || (place.starts_with("[[") && span.starts_with("[["));
        assert!(spans.iter().any(is_there), "{place}: {spans:?} {said:#?}");
    }
}
