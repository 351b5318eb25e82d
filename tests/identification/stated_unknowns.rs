//! Tables `[[identify.unknown]]`: hardpoints, preloads and common factors, found from readings that a closed form gives.

use std::path::Path;

use admire_diagnosis::study_fit::identify;
use admire_diagnosis::{Cause, SharedProgress, diagnose, held_out};
use admire_identify::{Fit, LoadedStudy, ParameterFit, Status};
use admire_session::backend::NativeBackend;
use admire_sweep::{Stream, normal};

/// Noise of one mark coordinate, in mm.
const SIGMA: f64 = 0.02;

/// A pendulum on a revolute joint along y, whose mass is pushed along x.
const PENDULUM: &str = "pendulum
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, QP=0,0,300, REULER=180D,90D,180D
MARKER/4, PART=1, QP=0,0,0, REULER=90D,90D,0
PART/2, MASS=10, CM=3, IP=1E5,1E5,1E5
MARKER/2, PART=2, QP=0,0,300, REULER=180D,90D,180D
MARKER/3, PART=2, QP=40,0,0
JOINT/1, REVOLUTE, I=2, J=1
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=3, J=4, FUNCTION=0.0
ACCGRAV/KGRAV=-9806.65
END
";

/// A part on two springs side by side, which is pushed along z.
const SPRINGS: &str = "springs
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, QP=0,0,0
PART/2, MASS=10, CM=3, IP=1E5,1E5,1E5
MARKER/2, PART=2, QP=0,0,100
MARKER/3, PART=2, QP=0,0,100
JOINT/1, TRANSLATIONAL, I=2, J=1
SPRINGDAMPER/1, TRANSLATIONAL, I=2, J=1, K=20, C=0, FORCE=200, LENGTH=100
SPRINGDAMPER/2, TRANSLATIONAL, I=2, J=1, K=50, C=0, FORCE=0, LENGTH=100
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=3, J=1, FUNCTION=0.0
END
";

/// A part that slides along z against a curve of forces, which is pushed along z.
const CURVE: &str = "curve
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, QP=0,0,0
PART/2, MASS=10, CM=3, IP=1E5,1E5,1E5
MARKER/2, PART=2, QP=0,0,0
MARKER/3, PART=2, QP=0,0,0
JOINT/1, TRANSLATIONAL, I=2, J=1
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=3, J=1, FUNCTION=0.0
SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=2, J=1, FUNCTION=-AKISPL(DZ(2,1,1),0,3)
SPLINE/3, X=-20,-15,-10,-5,0,5,10,15,20
, Y=-800,-600,-400,-200,0,200,400,600,800
END
";

/// Places of the marks on PART/2, in mm.
const MARKS: [[f64; 3]; 4] = [
    [40.0, 30.0, 20.0],
    [-60.0, -20.0, 10.0],
    [10.0, 40.0, 150.0],
    [50.0, -30.0, 80.0],
];

/// Writes a study with one load in newtons. `place` gives the place of a mark under a load.
fn write(
    folder: &Path,
    (deck, loads): (&str, &[f64]),
    place: impl Fn([f64; 3], f64) -> [f64; 3],
    settings: &str,
) {
    let noise = Stream::named(5, "marks");
    let draw = |k: usize| SIGMA * normal::quantile(noise.uniform(k as u64));
    let (mut cases, mut on_part) = ("case,push\n".to_string(), "part,mark,x,y,z\n".to_string());
    let mut measured = "case,part,mark,x,y,z\n".to_string();
    for (k, mark) in MARKS.iter().enumerate() {
        let [x, y, z] = mark;
        on_part += &format!("PART/2,{k},{x},{y},{z}\n");
    }
    for (case, load) in loads.iter().enumerate() {
        cases += &format!("{case},{load}\n");
        for (k, mark) in MARKS.iter().enumerate() {
            let at = 3 * (MARKS.len() * case + k);
            let [x, y, z] = place(*mark, *load);
            let (x, y, z) = (x + draw(at), y + draw(at + 1), z + draw(at + 2));
            measured += &format!("{case},PART/2,{k},{x},{y},{z}\n");
        }
    }
    let study = format!(
        "[model]\ndeck = \"model.adm\"\n[loads]\nfile = \"load_cases.csv\"\ncolumns = {{ push = \"SFORCE/1\" }}\n\
         [marks]\non_parts = \"on_part.csv\"\nmeasured = \"measured.csv\"\nsigma = {SIGMA}\n{settings}"
    );
    for (name, text) in [
        ("model.adm", deck),
        ("load_cases.csv", &cases),
        ("on_part.csv", &on_part),
        ("measured.csv", &measured),
        ("study.toml", &study),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

fn fitted(folder: &Path) -> (LoadedStudy, Fit) {
    let read = LoadedStudy::read(folder);
    let mut loaded = read
        .value
        .unwrap_or_else(|| panic!("{:?}", read.diagnostics));
    let fit = identify(
        &mut loaded,
        &mut NativeBackend::new(),
        &SharedProgress::default(),
    )
    .unwrap();
    assert!(fit.converged, "{:?}", fit.remarks);
    (loaded, fit)
}

fn is_near(found: &ParameterFit, truth: f64, largest_error: f64) {
    let error = found.std_error.unwrap();
    assert_eq!(found.status, Status::Identified, "{found:?}");
    assert!((found.value - truth).abs() < 4.0 * error, "{found:?}");
    assert!(error < largest_error, "{found:?}");
    let [low, high] = found.interval95.map(Option::unwrap);
    assert!(low < found.value && found.value < high, "{found:?}");
}

/// Place of a mark of the pendulum with its joint moved by `d`. The line from the joint to the mass has the direction of the resultant force.
fn pendulum(mark: [f64; 3], push: f64, d: [f64; 3]) -> [f64; 3] {
    let joint = [d[0], 300.0 + d[2]];
    let arm = [40.0 - joint[0], -joint[1]];
    let force = [push, -10.0 * 9.806_65];
    let turn = f64::atan2(force[1], force[0]) - f64::atan2(arm[1], arm[0]);
    let from = [mark[0] - joint[0], mark[2] - joint[1]];
    let (sin, cos) = turn.sin_cos();
    [
        joint[0] + cos * from[0] - sin * from[1],
        mark[1],
        joint[1] + sin * from[0] + cos * from[1],
    ]
}

/// A hardpoint is found where it is, in ground axes; what the readings do not tell, its place along the axis of its joint, is not identified.
/// Hardpoints have a tolerance of half a millimetre. Counted beside the unknown, it would be its standard error.
#[test]
fn a_hardpoint_is_found_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let loads = [-60.0, -30.0, 0.0, 30.0, 60.0];
    let truth = [2.0, 1.0, -3.0];
    let settings = "[tolerances]\nhardpoints = 0.5\nload_gain = 0.001\n[[identify.unknown]]\nnumbers = [\"MARKER/1.QP\"]\nsd = \"5 mm\"\n";
    let place = |mark, push| pendulum(mark, push, truth);
    write(folder.path(), (PENDULUM, &loads), place, settings);
    let (loaded, fit) = fitted(folder.path());
    let [x, y, z] = &fit.parameters[..] else {
        panic!("{:?}", fit.parameters)
    };
    is_near(x, truth[0], 0.1);
    is_near(z, truth[2], 0.1);
    assert_eq!(y.status, Status::Unidentifiable, "{y:?}");
    assert_eq!(
        (z.address.as_str(), z.form),
        ("MARKER/1.QP.3", Some("change"))
    );
    let numbers: Vec<&str> = z.numbers.iter().map(|own| own.address.as_str()).collect();
    assert_eq!(numbers, ["MARKER/1.QP.3", "MARKER/2.QP.3"]);
    let deck = loaded.identified_deck(&fit.values()).unwrap();
    let deck = String::from_utf8(deck).unwrap();
    let height = format!("{:.4}", 300.0 + z.value);
    assert_eq!(deck.matches(&height[..6]).count(), 2, "{height} in {deck}");
    assert_eq!(deck.lines().count(), PENDULUM.lines().count());
    assert!(fit.history[0].iter().all(|value| *value == 0.0));
}

/// A common factor of two unequal rates, and a preload as a change of what the deck has.
#[test]
fn a_common_factor_and_a_preload_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let loads = [-900.0, -500.0, 0.0, 500.0, 900.0];
    let (factor, change) = (1.25, 150.0);
    let settings = "[tolerances]\nload_gain = 0.001\n[[identify.unknown]]\nnumbers = [\"SPRINGDAMPER/*.K\"]\nform = \"factor\"\ntogether = true\n\
                    [[identify.unknown]]\nnumbers = [\"SPRINGDAMPER/1.FORCE\"]\nsd = \"500 N\"\n";
    let place = |mark: [f64; 3], push: f64| {
        let up = (push + 200.0 + change) / (factor * 70.0);
        [mark[0], mark[1], mark[2] + up]
    };
    write(folder.path(), (SPRINGS, &loads), place, settings);
    let (loaded, fit) = fitted(folder.path());
    let [rate, preload] = &fit.parameters[..] else {
        panic!("{:?}", fit.parameters)
    };
    is_near(rate, factor, 0.02);
    is_near(preload, change, 20.0);
    assert_eq!((rate.form, preload.form), (Some("factor"), Some("change")));
    let rates: Vec<f64> = rate.numbers.iter().map(|own| own.after).collect();
    assert_eq!(rates, [20.0 * rate.value, 50.0 * rate.value]);
    assert_eq!((rate.unit.as_str(), preload.initial), ("", 0.0));
    let deck = loaded.identified_deck(&fit.values()).unwrap();
    let found = admire_syntax::Dataset::parse(admire_syntax::text::Source::new("d", deck)).value;
    let number = |text: &str| {
        let address = admire_syntax::Address::parse(text, &found).unwrap();
        found.value_at(&address).unwrap()
    };
    assert!((number("SPRINGDAMPER/1.K") / rates[0] - 1.0).abs() < 1e-9);
    assert!((number("SPRINGDAMPER/1.FORCE") / (200.0 + preload.value) - 1.0).abs() < 1e-9);
}

/// A rig that neither yields nor moves its frame, and markers at their places. Otherwise these cannot be told from a rate and an offset.
const STIFF_RIG: &str =
    "[tolerances]\nload_gain = 0.001\nalignment = 0\nmount = 0\nhardpoints = 0\n";

/// Loads on the part that slides, in N.
fn pushes() -> Vec<f64> {
    (-9..=9).map(|k| 80.0 * f64::from(k)).collect()
}

/// A curve of forces with a common factor, and with an offset: the closed forms of a straight line.
#[test]
fn a_spline_is_scaled_and_shifted() {
    let settings = |form: &str| {
        format!(
            "{STIFF_RIG}[[identify.unknown]]\nnumbers = [\"SPLINE/3.Y\"]\ntogether = true\n{form}\n"
        )
    };
    let curves: [(&str, [f64; 2], &dyn Fn(f64) -> f64); 2] = [
        ("form = \"factor\"", [1.3, 0.01], &|push| {
            push / (1.3 * 40.0)
        }),
        ("sd = 100", [-70.0, 1.0], &|push| (push + 70.0) / 40.0),
    ];
    for (form, [truth, largest_error], up) in curves {
        let folder = tempfile::tempdir().unwrap();
        let place = |mark: [f64; 3], push: f64| [mark[0], mark[1], mark[2] + up(push)];
        write(folder.path(), (CURVE, &pushes()), place, &settings(form));
        let (_, fit) = fitted(folder.path());
        let [found] = &fit.parameters[..] else {
            panic!("{:?}", fit.parameters)
        };
        is_near(found, truth, largest_error);
        // A factor leaves the origin of the curve where it is.
        let points = if form.contains("factor") { 8 } else { 9 };
        assert_eq!(found.numbers.len(), points, "{found:?}");
    }
}

/// Points whose change varies smoothly follow a curve that is no spline, also between two points; beyond the readings they are uncertain.
#[test]
fn a_smooth_change_of_a_spline_follows_the_readings() {
    let folder = tempfile::tempdir().unwrap();
    let law = |z: f64| 40.0 * z + 0.03 * z.powi(3) - 0.4 * z * z;
    let place = |mark: [f64; 3], push: f64| {
        let (mut low, mut high) = (-30.0, 30.0);
        while high - low > 1e-10 {
            let middle = f64::midpoint(low, high);
            if law(middle) < push {
                low = middle;
            } else {
                high = middle;
            }
        }
        [mark[0], mark[1], mark[2] + low]
    };
    let settings = format!(
        "{STIFF_RIG}[reference]\ndeck = \"truth.adm\"\n[[identify.unknown]]\nnumbers = [\"SPLINE/3.Y\"]\nsd = 200\nsmooth = 12\n"
    );
    let points = |of: &dyn Fn(f64) -> f64| {
        let each = (-4..=4).map(|k| format!("{}", of(5.0 * f64::from(k))));
        each.collect::<Vec<_>>().join(",")
    };
    let truth = CURVE.replace(&points(&|z| 40.0 * z), &points(&law));
    assert_ne!(truth, CURVE);
    std::fs::write(folder.path().join("truth.adm"), truth).unwrap();
    write(folder.path(), (CURVE, &pushes()), place, &settings);
    let (loaded, fit) = fitted(folder.path());
    let curve = |values: &[f64]| -> Vec<f64> {
        let deck = loaded.identified_deck(values).unwrap();
        let found = admire_syntax::Dataset::parse(admire_syntax::text::Source::new("d", deck));
        let number = |k: usize| {
            let address = format!("SPLINE/3.Y.{k}");
            let address = admire_syntax::Address::parse(&address, &found.value).unwrap();
            found.value.value_at(&address).unwrap()
        };
        (1..=9).map(number).collect()
    };
    let reference: Vec<f64> = loaded.reference_values().into_iter().flatten().collect();
    assert_eq!(reference.len(), fit.parameters.len());
    for (k, (found, exact)) in curve(&fit.values())
        .into_iter()
        .zip(curve(&reference))
        .enumerate()
    {
        let z = 5.0 * (k as f64 - 4.0);
        assert!((exact - law(z)).abs() < 0.5, "{z}: {exact}");
        // The pushes reach from -14 to 17 mm.
        if z.abs() <= 10.0 {
            assert!((found - law(z)).abs() < 5.0, "{z}: {found} {}", law(z));
        }
    }
    for own in &fit.parameters {
        assert_eq!(own.status, Status::Identified, "{own:?}");
    }
    let at = |name: &str| {
        let mut all = fit.parameters.iter();
        all.find(|own| own.address == name)
            .and_then(|own| own.std_error)
    };
    let (Some(end), Some(middle)) = (at("SPLINE/3.Y.1"), at("SPLINE/3.Y.9")) else {
        panic!("{:?}", fit.parameters)
    };
    assert!(end > 5.0 && middle < end, "{:?}", fit.parameters);
}

/// Between two bounds alone every value is equally probable; a number that the readings push beyond its bound is there, and it is said.
#[test]
fn a_bound_holds_a_change() {
    let folder = tempfile::tempdir().unwrap();
    let loads = [-60.0, 0.0, 60.0];
    let settings = "[tolerances]\nload_gain = 0.001\n[[identify.unknown]]\nnumbers = [\"MARKER/1.QP.3\"]\nbounds = [\"-2 mm\", \"2 mm\"]\n";
    let place = |mark, push| pendulum(mark, push, [0.0, 0.0, -3.0]);
    write(folder.path(), (PENDULUM, &loads), place, settings);
    let (_, fit) = fitted(folder.path());
    let found = &fit.parameters[0];
    assert_eq!(found.status, Status::Bound, "{found:?}");
    assert!((found.value + 2.0).abs() < 1e-6, "{found:?}");
}

/// A lower bound of zero has no logarithm. It is no reason to report a number far from both bounds as held by one.
#[test]
fn a_value_between_zero_and_a_bound_is_free() {
    let folder = tempfile::tempdir().unwrap();
    let loads = [-900.0, 0.0, 900.0];
    let settings = "[tolerances]\nload_gain = 0.001\n[[identify.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\nbounds = [0, \"100 N/mm\"]\n";
    let place = |mark: [f64; 3], push: f64| [mark[0], mark[1], mark[2] + (push + 200.0) / 75.0];
    write(folder.path(), (SPRINGS, &loads), place, settings);
    let (_, fit) = fitted(folder.path());
    is_near(&fit.parameters[0], 25.0, 2.0);
}

/// A study that identifies one coordinate of a hardpoint leaves the other two to the diagnosis, each under its own name: in the finding of a
/// hardpoint that is too low, and in the detection limits.
#[test]
fn the_other_coordinates_of_a_hardpoint_are_left_to_the_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    let loads = [-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0];
    let settings = "[tolerances]\nhardpoints = 0.1\nload_gain = 0.001\n[[identify.unknown]]\nnumbers = [\"MARKER/1.QP.1\"]\nsd = \"5 mm\"\n";
    let place = |mark, push| pendulum(mark, push, [0.0, 0.0, -3.0]);
    write(folder.path(), (PENDULUM, &loads), place, settings);
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let problem = loaded.problem();
    let held_out = held_out(&loaded.study, &loaded.measurement);
    let found = diagnose(&problem, held_out).unwrap().diagnosis;
    let mut findings = found.findings.iter();
    let hardpoint = findings.find(|own| own.cause == Cause::HardpointError);
    let hardpoint = hardpoint.unwrap_or_else(|| panic!("{:?}", found.findings));
    let [Some(z), x] = ["z", "x"].map(|axis| hardpoint.parameters.get(axis)) else {
        panic!("{hardpoint:?}")
    };
    assert!((z + 3.0).abs() < 0.3 && x.is_none(), "{hardpoint:?}");
    let limits = &found.detection_limits;
    let own = limits
        .iter()
        .find(|own| own.members.iter().any(|name| name == "MARKER/1"));
    let own = own.unwrap_or_else(|| panic!("{limits:?}"));
    assert!(own.mm[0].is_none() && own.mm[2].is_some(), "{own:?}");
}

/// A change without a size, and a method that has no changes, are refused at the table.
#[test]
fn what_a_fit_cannot_seek_is_refused_at_its_place() {
    let table = "[[identify.unknown]]\nnumbers = [\"MARKER/1.QP\"]\n";
    for (settings, message) in [
        (
            table.to_string(),
            "MARKER/1 x has neither `sd` nor `bounds`",
        ),
        (
            format!("[identify]\nmethod = \"direct\"\n{table}sd = \"5 mm\"\n"),
            "MARKER/1 x is identified as a change, which method = \"direct\" does not support",
        ),
        (
            "[[identify.unknown]]\nnumbers = [\"PART/2.IP.1\"]\nform = \"factor\"\n".to_string(),
            "the solver keeps PART/2.IP.1 constant",
        ),
        (
            format!("{table}sd = \"5 mm\"\nsmooth = 10\n"),
            "MARKER/1.QP.1 is not a point of a curve of a SPLINE",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let place = |mark, push| pendulum(mark, push, [0.0; 3]);
        write(folder.path(), (PENDULUM, &[0.0, 30.0]), place, &settings);
        let read = LoadedStudy::read(folder.path());
        assert!(read.value.is_none());
        let found = read.diagnostics.iter().find(|own| own.message == message);
        let found = found.unwrap_or_else(|| panic!("{message}: {:?}", read.diagnostics));
        assert_eq!(
            found.labels[0].file.to_string().rsplit('/').next(),
            Some("study.toml")
        );
    }
}
