//! Decks of the corpus are solved under random loads. Their results alone must give decks with the same parameters.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use admire::Deck;
use admire_rebuild::{AxisLaw, Rebuilt, Role, rebuild};
use admire_solver::mechanics::Vec3;
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::text::Source;

/// Solves a deck of the corpus under random loads at the contact point, and writes the results. `has_load` tells whether loads act along x and
/// along y.
fn results(
    deck: &Path,
    (cases, seed): (usize, u64),
    has_load: [bool; 2],
    folder: &Path,
    name: &str,
) -> PathBuf {
    let mut state = seed;
    let mut draw = |from: f64, to: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut commands = format!("file/model=model, output_prefix={name}\n");
    for _ in 0..cases {
        let [x, y] = has_load.map(|has| if has { draw(-3000.0, 3000.0) } else { 0.0 });
        let z = draw(1500.0, 6500.0);
        let _ = write!(
            commands,
            "SFORCE/1, FUNCTION={x:.3}\nSFORCE/2, FUNCTION={y:.3}\nSFORCE/3, FUNCTION={z:.3}\nSIMULATE/STATIC\n"
        );
    }
    commands += "STOP\n";
    let file = folder.join(format!("{name}.acf"));
    std::fs::write(&file, commands).expect("a command file");
    let run = Deck::open(deck).expect("a deck").run(&file).expect("a run");
    run.succeeded().expect("equilibria");
    let path = folder.join(format!("{name}.res"));
    run.write(&path, false).expect("results");
    path
}

fn planted(deck: &str) -> (Model, Rebuilt) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(deck);
    let folder = tempfile::tempdir().expect("a folder");
    let seen = results(&path, (40, 1), [true; 2], folder.path(), "seen");
    let other = results(&path, (15, 2), [true; 2], folder.path(), "other");
    let answer = rebuild(&[&seen], &[&other]);
    let rebuilt = answer
        .value
        .unwrap_or_else(|| panic!("{:?}", answer.diagnostics));
    for (run, what) in rebuilt
        .record
        .runs
        .iter()
        .zip(["its own states", "other loads"])
    {
        let largest = rebuilt.repeat.largest(run.states.clone());
        assert!(
            largest.is_some_and(|apart| apart < 1e-3),
            "{deck}, {what}: {largest:?} {:?}",
            rebuilt.repeat.error
        );
    }
    let bytes = std::fs::read(&path).expect("a deck");
    let model = Model::lower(&Dataset::parse(Source::new(deck, bytes)).value).value;
    (model, rebuilt)
}

/// Returns the position of a marker of the planted deck, at the design position.
fn place(model: &Model, marker: admire_solver::model::MarkerIx) -> Vec3 {
    let marker = &model.markers[marker.0];
    model.parts[marker.part.0].pose.point(&marker.qp)
}

fn compare(model: &Model, rebuilt: &Rebuilt) {
    let (record, mechanism) = (&rebuilt.record, &rebuilt.mechanism);
    let mut bushings = 0;
    for member in &mechanism.members {
        let name = &record.elements[member.connection.element].name;
        let body = &record.bodies[member.connection.i];
        if let Role::Bushing { i, law, .. } = &member.role {
            let planted = model
                .bushings
                .iter()
                .find(|bushing| bushing.header.name == *name)
                .unwrap_or_else(|| panic!("no bushing {name}"));
            let point = body.design.point(&i.p);
            let apart = (point - place(model, planted.i)).norm();
            assert!(apart < 1e-6, "{name}: {apart}");
            let mut found: Vec<f64> = law
                .force
                .iter()
                .map(|axis| match axis {
                    AxisLaw::Linear { stiffness, .. } => *stiffness,
                    other => panic!("{name}: {other:?}"),
                })
                .collect();
            let mut wanted = planted.k;
            found.sort_by(f64::total_cmp);
            wanted.sort_by(f64::total_cmp);
            for (found, wanted) in found.iter().zip(&wanted) {
                assert!(
                    (found - wanted).abs() < 1e-6 * wanted,
                    "{name}: {found} {wanted}"
                );
            }
            bushings += 1;
        }
    }
    assert!(bushings > 0);
    for (body, mass) in record.bodies.iter().zip(&mechanism.bodies).skip(1) {
        let planted = model
            .parts
            .iter()
            .find(|part| part.header.name == body.name)
            .expect("a part");
        let wanted = planted.mass;
        assert!(
            (mass.mass - wanted).abs() < 1e-4 * wanted,
            "{}: {} {wanted}",
            body.name,
            mass.mass
        );
    }
}

#[test]
fn a_pseudo_mcpherson_comes_back() {
    let (model, rebuilt) = planted("pseudo-mcpherson/reference.adm");
    compare(&model, &rebuilt);
}

#[test]
fn a_multilink_on_bushings_comes_back() {
    let (model, rebuilt) = planted("multilink/reference.adm");
    compare(&model, &rebuilt);
}

/// Checks that a lateral and a longitudinal test together predict loads along both axes, and that one test alone gives a warning.
#[test]
fn two_tests_tell_what_one_does_not() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson/reference.adm");
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let lateral = results(&path, (30, 3), [false, true], folder, "lateral");
    let longitudinal = results(&path, (30, 4), [true, false], folder, "longitudinal");
    let both = results(&path, (15, 5), [true; 2], folder, "both");
    let missed = |from: &[&Path]| {
        let answer = rebuild(from, &[&both]);
        let warned = !answer.diagnostics.is_empty();
        let rebuilt = answer.value.expect("a deck");
        let states = rebuilt.record.runs.last().expect("a test").states.clone();
        (rebuilt.repeat.largest(states), warned)
    };
    let (together, warned) = missed(&[&lateral, &longitudinal]);
    assert!(together.is_some_and(|apart| apart < 1e-6), "{together:?}");
    assert!(!warned);
    let (alone, warned) = missed(&[&lateral]);
    assert!(warned && alone.is_none_or(|apart| apart > 0.1), "{alone:?}");
}
