//! The same axle in other axes and units has the same characteristics.

use admire_kc::{KcRun, Unit, run};
use admire_solver::mechanics::{Mat3, Vec3, psi_theta_phi};
use admire_solver::model::{Model, Orientation, PartKind, convert_units};
use admire_syntax::text::Source;
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit as DeckUnit};
use admire_syntax::{Address, Dataset};

use crate::axles::{Axle, DOUBLE_WISHBONE, MCPHERSON, MULTILINK, corpus, double_wishbone, largest};

/// Returns the decks with their rigs, and the same rigs in metres.
fn decks() -> [(String, &'static str, String); 3] {
    let metres = |toml: &str, all: &[(&str, &str)]| {
        let mut text = toml.to_string();
        for (from, to) in all {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        text
    };
    let one_wheel = metres(
        MCPHERSON,
        &[
            ("300.0", "0.3"),
            ("220.0", "220000.0"),
            ("2700.0", "2.7"),
            ("540.0", "0.54"),
        ],
    );
    let two_wheels = metres(
        DOUBLE_WISHBONE,
        &[
            ("300.0", "0.3"),
            ("= 200.0", "= 200000.0"),
            ("2600.0", "2.6"),
            ("550.0", "0.55"),
            ("[-15, 15]", "[-0.015, 0.015]"),
        ],
    );
    [
        (
            corpus("pseudo-mcpherson/model.adm"),
            MCPHERSON,
            one_wheel.clone(),
        ),
        (corpus("multilink/reference.adm"), MULTILINK, one_wheel),
        (double_wishbone(), DOUBLE_WISHBONE, two_wheels),
    ]
}

fn tests_of(axle: &Axle) -> KcRun {
    let mut bench = axle.bench();
    run(&mut bench, &axle.model.units).unwrap_or_else(|why| panic!("{why}"))
}

/// Returns the deck with all positions and the gravity rotated: `x_new = Q x_old`.
fn turned(deck: &str, Q: &Mat3) -> String {
    let mut dataset = Dataset::parse(Source::new("deck.adm", deck.as_bytes())).value;
    let model = Model::lower(&dataset).value;
    let list = |v: &[f64]| {
        v.iter()
            .map(|x| format!("{x:.16E}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let mut set = |kind: &str, id: Option<u32>, argument: &str, values: &[f64]| {
        let address = Address {
            kind: kind.to_string(),
            id,
            argument: Some(argument.to_string()),
            index: None,
        };
        let edits = dataset.set_text(&address, &list(values)).unwrap();
        dataset = dataset.edited(&edits).unwrap().value;
    };
    for part in &model.parts {
        if part.kind == PartKind::Rigid {
            let p = Q * part.pose.p;
            set("PART", Some(part.header.id), "QG", p.as_slice());
            set(
                "PART",
                Some(part.header.id),
                "REULER",
                &psi_theta_phi(&(Q * part.pose.R)),
            );
        }
    }
    for marker in &model.markers {
        if model.parts[marker.part.0].kind == PartKind::Ground && !marker.floating {
            let p = Q * marker.qp;
            let id = Some(marker.header.id);
            set("MARKER", id, "QP", p.as_slice());
            let R = Q * marker.R;
            if marker.orientation == Orientation::Points {
                for (argument, axis) in [("ZP", 2), ("XP", 0)] {
                    let on = p + R.column(axis) * 100.0;
                    set("MARKER", id, argument, on.as_slice());
                }
            } else {
                set("MARKER", id, "REULER", &psi_theta_phi(&R));
            }
        }
    }
    let g: Vec3 = Q * model.gravity;
    if g.norm() > 0.0 {
        for (name, value) in ["IGRAV", "JGRAV", "KGRAV"].into_iter().zip(g.iter()) {
            set("ACCGRAV", None, name, &[*value]);
        }
    }
    String::from_utf8(dataset.bytes().to_vec()).unwrap()
}

/// Compares every reading of every sample, scaled from the units of the second deck to those of the first.
fn same(a: &KcRun, b: &KcRun, scale: impl Fn(Unit) -> f64, bar: f64) {
    let (mut compared, mut worst) = (0, (0.0, String::new()));
    let samples = |run: &KcRun| -> Vec<admire_kc::Sample> {
        let all = run.tests.iter().flat_map(|t| t.samples.iter());
        std::iter::once(&run.ride).chain(all).cloned().collect()
    };
    let (first, second) = (samples(a), samples(b));
    assert_eq!(first.len(), second.len());
    // If the wheels are steered to opposite sides, the axle does not turn, and round-off decides which wheel is the inside one. Near straight
    // ahead, the percentage is a quotient of differences that vanish with the square of the steer angle.
    let steered = |sample: &admire_kc::Sample| {
        let all = sample.readings.iter();
        let steer = all.filter(|r| r.path().starts_with("steer_angle"));
        let angles: Vec<f64> = steer.map(|r| r.value).collect();
        let alike = angles
            .windows(2)
            .all(|pair| pair[0].signum() == pair[1].signum());
        let least = angles.iter().map(|a| a.abs()).fold(f64::MAX, f64::min);
        if alike { least } else { 0.0 }
    };
    let of_a_turn = |path: &str| {
        ["ackerman", "ideal_steer", "turn"]
            .iter()
            .any(|word| path.contains(word))
    };
    // Scales of the columns. A value that is small relative to its column, or to the terms of which it is a difference, is round-off.
    let [moves, turns, twists] = largest(&a.ride.seen.axle.compliance.unwrap());
    for k in 0..first[0].readings.len() {
        let size = first
            .iter()
            .map(|s| s.readings[k].value.abs())
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max);
        for (x, y) in first.iter().zip(&second) {
            let steered = steered(x);
            let (x, y) = (x.readings[k], y.readings[k]);
            assert_eq!(x.path(), y.path());
            let ill = steered == 0.0 && of_a_turn(&x.path());
            if ill || (steered < 0.02 && x.path().contains("percent_ackerman")) {
                continue;
            }
            if !x.value.is_finite() || x.path().contains("swing_arm_length") {
                continue;
            }
            let floor = match x.unit {
                Unit::Length | Unit::Percent => 100.0,
                Unit::Angle => 0.1,
                Unit::Force => 1000.0,
                Unit::LengthPerForce => moves,
                Unit::AnglePerForce => turns,
                Unit::AnglePerTorque => twists,
                Unit::AnglePerLength => turns / moves,
                _ => 0.0,
            };
            let apart = (x.value - y.value * scale(x.unit)).abs() / size.max(floor);
            if apart > worst.0 {
                worst = (apart, x.path());
            }
            compared += 1;
        }
    }
    println!("{:.1e} {}", worst.0, worst.1);
    assert!(worst.0 <= bar, "{worst:?}");
    assert!(compared > 1000);
}

/// Relative agreement of characteristics that are solved with other round-off.
const SOLVED: f64 = 1e-11;

#[test]
fn axes() {
    std::thread::scope(|scope| {
        for (deck, toml, _) in decks() {
            scope.spawn(move || in_other_axes(&deck, toml));
        }
    });
}

fn in_other_axes(deck: &str, toml: &str) {
    let first = tests_of(&Axle::new(deck, toml));
    for (axes, diagonal) in [("iso", [-1.0, -1.0, 1.0]), ("sae", [-1.0, 1.0, -1.0])] {
        let Q = Mat3::from_diagonal(&Vec3::from(diagonal));
        let toml = toml.replace("[deck]", &format!("[deck]\naxes = '{axes}'"));
        let second = tests_of(&Axle::new(&turned(deck, &Q), &toml));
        same(&first, &second, |_| 1.0, SOLVED);
    }
    // Rotation to axes with x up, y rearward, z right.
    let Q = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let toml = toml.replace("[deck]", "[deck]\naxes = ['up', 'rearward', 'right']");
    let second = tests_of(&Axle::new(&turned(deck, &Q), &toml));
    same(&first, &second, |_| 1.0, SOLVED);
}

#[test]
fn units() {
    for (deck, toml, metres) in decks() {
        in_metres(&deck, toml, &metres);
    }
}

fn in_metres(deck: &str, toml: &str, toml_in_metres: &str) {
    let first = tests_of(&Axle::new(deck, toml));
    let dataset = Dataset::parse(Source::new("deck.adm", deck.as_bytes())).value;
    let model = Model::lower(&dataset).value;
    let unit =
        |all: &[DeckUnit], keyword: &str| *all.iter().find(|u| u.keyword == keyword).unwrap();
    let new = [
        unit(FORCE_UNITS, "NEWTON"),
        unit(MASS_UNITS, "KILOGRAM"),
        unit(LENGTH_UNITS, "METER"),
        unit(TIME_UNITS, "SECOND"),
    ];
    let edits = convert_units(&dataset, &model, new).unwrap().value;
    let metres = dataset.edited(&edits).unwrap().value;
    let second = tests_of(&Axle::new(
        &String::from_utf8_lossy(metres.bytes()),
        toml_in_metres,
    ));
    let scale = |unit: Unit| match unit {
        Unit::Length | Unit::LengthPerForce | Unit::LengthPerG | Unit::Torque | Unit::RollRate => {
            1e3
        }
        Unit::Rate | Unit::AnglePerLength | Unit::AnglePerTorque => 1e-3,
        _ => 1.0,
    };
    // Entries that have a unit of length of their own are removed: the axis point, and the radius of a straight wheel.
    let strip = |mut run: KcRun| {
        let odd = ["wheel_axis", "turn_radius", "outside_turn"];
        let clean = |sample: &mut admire_kc::Sample| {
            sample
                .readings
                .retain(|r| !odd.iter().any(|o| r.path().contains(o)));
        };
        clean(&mut run.ride);
        run.tests
            .iter_mut()
            .flat_map(|t| t.samples.iter_mut())
            .for_each(clean);
        run
    };
    same(&strip(first), &strip(second), scale, SOLVED);
}

/// Measures the time of all standard tests of a multilink axle, with 13 points up and 13 down each; `--nocapture` shows it. There is no limit,
/// because the machine may be busy.
#[test]
fn speed() {
    let axle = Axle::new(&corpus("multilink/reference.adm"), MCPHERSON);
    let one = Axle::new(
        &corpus("multilink/reference.adm"),
        &MCPHERSON.replace("[choices]", "[choices]\nbranches = 'up'"),
    );
    for (name, axle) in [("up", one), ("up and down", axle)] {
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let start = std::time::Instant::now();
            let run = tests_of(&axle);
            best = best.min(start.elapsed().as_secs_f64());
            assert_eq!(run.tests.len(), 8);
        }
        println!("{name}: {:.1} ms", 1e3 * best);
    }
}
