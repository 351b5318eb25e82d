//! Tests of forces in elements and of load cases as goals. They are compared with closed forms, other computations and finite differences.

use std::path::Path;

use crate::bench::{KC, corpus, search, study};
use crate::evaluation::Evaluator;
use crate::{Tuning, settings};

/// Two carriers that slide along Z, each on a spring of 100 N/mm that is compressed by 20 mm in the design position.
const AXLE: &str = "Two wheels on springs\n\
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
PART/1, GROUND\n\
MARKER/10, PART=1, QP=0,-700,300\n\
MARKER/11, PART=1, QP=0,-600,700\n\
MARKER/12, PART=1, QP=0,700,300\n\
MARKER/13, PART=1, QP=0,600,700\n\
PART/2, MASS=10, CM=22, IP=1E5,1E5,1E5\n\
MARKER/20, PART=2, QP=0,-700,300\n\
MARKER/21, PART=2, QP=0,-600,300\n\
MARKER/22, PART=2, QP=0,-700,310\n\
MARKER/23, PART=2, QP=0,-800,300\n\
PART/3, MASS=10, CM=32, IP=1E5,1E5,1E5\n\
MARKER/30, PART=3, QP=0,700,300\n\
MARKER/31, PART=3, QP=0,600,300\n\
MARKER/32, PART=3, QP=0,700,310\n\
MARKER/33, PART=3, QP=0,800,300\n\
JOINT/1, TRANSLATIONAL, I=20, J=10\n\
JOINT/2, TRANSLATIONAL, I=30, J=12\n\
SPRINGDAMPER/1, TRANSLATION, I=21, J=11, K=100, LENGTH=420, FORCE=0\n\
SPRINGDAMPER/2, TRANSLATION, I=31, J=13, K=100, LENGTH=420, FORCE=0\n\
END\n";

const RIG: &str = "[deck]\naxes = \"adams-car\"\n[wheels]\n\
left = { centre = \"MARKER/20\", spin = \"MARKER/23\" }\nright = { centre = \"MARKER/30\", spin = \"MARKER/33\" }\n\
[tests.bounce]\nrange = [-20, 20]\npoints = 5\nwindow = 20\n";

/// A carrier that slides along Z on two springs and carries a vertical load.
const LOADED: &str = "A load on two springs\n\
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
PART/1, GROUND\n\
MARKER/10, PART=1, QP=0,-700,300\n\
MARKER/11, PART=1, QP=0,-600,0\n\
MARKER/12, PART=1, QP=0,-800,0\n\
PART/2, MASS=10, CM=22, IP=1E5,1E5,1E5\n\
MARKER/20, PART=2, QP=0,-700,300\n\
MARKER/21, PART=2, QP=0,-600,300\n\
MARKER/22, PART=2, QP=0,-700,310\n\
MARKER/23, PART=2, QP=0,-800,300\n\
JOINT/1, TRANSLATIONAL, I=20, J=10\n\
SPRINGDAMPER/1, TRANSLATION, I=21, J=11, K=100, LENGTH=300\n\
SPRINGDAMPER/2, TRANSLATION, I=23, J=12, K=50, LENGTH=300\n\
SFORCE/3, TRANSLATIONAL, I=20, J=10, ACTIONONLY, FUNCTION=0\n\
END\n";

/// Load cases of [`LOADED`]: no load, and 1000 N downward.
const LOADS: &str = "[loads]\nfile = \"load_cases.csv\"\ncolumns = { vertical = \"SFORCE/3\" }\n";

const RATE: &str =
    "[[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\nbounds = [20, 900]\n";

/// Reads a study of [`LOADED`] with goals in its load cases. The study has no `kc.toml`.
fn loaded(folder: &Path, target: &str) -> Tuning {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect(name);
    write("model.adm", LOADED);
    write("load_cases.csv", "case,vertical\n0,0\ndown,-1000\nup,500\n");
    let toml = format!("[model]\ndeck = \"model.adm\"\n{LOADS}[target]\nrestarts = 1\n{target}");
    write("study.toml", &toml);
    let (found, said) = Tuning::read(folder);
    found.unwrap_or_else(|_| panic!("{said:#?}"))
}

/// Checks that the search finds a spring rate and a preload that give a wanted force at ride height and a wanted change of force with
/// travel. The spring force is `FORCE + K (420 - 400 + z)` with the free length 420, the installed length 400 and the wheel travel `z`. It acts
/// upward on the upper marker and downward on the carrier.
#[test]
fn a_spring_has_its_wanted_force_at_ride_height() {
    let folder = tempfile::tempdir().expect("a folder");
    let target = "[target]\nrestarts = 1\n\
        [[target.goal]]\ntest = \"ride\"\nof = \"SPRINGDAMPER/1.FZ\"\nvalue = -3500\ntolerance = 1\n\
        [[target.goal]]\ntest = \"bounce\"\nof = \"SPRINGDAMPER/1.FZ\"\ngradient = -150\ntolerance = 0.1\n\
        [[target.goal]]\ntest = \"bounce\"\nof = \"SPRINGDAMPER/1.FM\"\nvalue = 5000\nat = 10\ntolerance = 1\n\
        [[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\nbounds = [20, 500]\n\
        [[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.FORCE\"]\nform = \"value\"\nbounds = [-5000, 5000]\n";
    let tuning = study(folder.path(), AXLE.as_bytes(), "value\n", target, RIG);
    let before: Vec<f64> = tuning
        .goals
        .iter()
        .map(|goal| goal.value(&goal.rows[0], &tuning.before))
        .collect();
    for (value, closed) in before.iter().zip([-2000.0, -100.0, 3000.0]) {
        assert!((value - closed).abs() < 1e-6, "{before:?}");
    }
    let units: Vec<&str> = tuning.goals.iter().map(|goal| goal.unit.as_str()).collect();
    assert_eq!(units, ["N", "N/mm", "N"]);
    assert!(tuning.goals.iter().all(|goal| goal.is_exact));
    let found = search(&tuning);
    assert!(found.met && found.converged, "{found:#?}");
    for (unknown, closed) in found.unknowns.iter().zip([150.0, 500.0]) {
        assert!((unknown.value - closed).abs() < 1e-3, "{found:#?}");
        assert!(unknown.exact_derivatives);
    }
    assert_eq!(found.agreeing, 2);
}

/// Checks the spring rates found from load cases against closed forms. The displacement `z` under a load P gives `P / z - K2`. The share
/// `s` of a spring in the load gives `K2 s / (1 - s)`. Neither goal needs `kc.toml`.
#[test]
fn load_cases_give_the_rates_of_the_closed_form() {
    let goal =
        |text: &str| format!("[[target.goal]]\ncase = \"down\"\ntolerance = 0.001\n{text}\n");
    let place = "of = \"MARKER/20.Z\"\nrelative_to = \"0\"\nvalue = -4";
    let share = "of = \"SPRINGDAMPER/1.FZ\"\nvalue = 800";
    let larger = "of = \"SPRINGDAMPER/1.FZ\"\nvalue = 800\nminimax = true";
    for (text, rate) in [(place, 200.0), (share, 200.0), (larger, 200.0)] {
        let folder = tempfile::tempdir().expect("a folder");
        let tuning = loaded(folder.path(), &format!("{RATE}{}", goal(text)));
        assert!(tuning.config.is_none() && tuning.before.run.is_none());
        let found = search(&tuning);
        assert!(found.converged && found.met, "{found:#?}");
        assert!((found.unknowns[0].value - rate).abs() < 1e-3, "{found:#?}");
        assert!(found.unknowns[0].exact_derivatives && found.goals[0].exact_derivatives);
        assert_eq!(found.goals[0].case.as_deref(), Some("down"));
    }
    // A limit on the force of the other spring, which a goal for the displacement pulls beyond: K1 = 50 (1000 - 250) / 250.
    let folder = tempfile::tempdir().expect("a folder");
    let limit = goal("of = \"SPRINGDAMPER/2.FM\"\nleast = 250");
    let stiff = goal("of = \"MARKER/20.Z\"\nvalue = 299");
    let found = search(&loaded(folder.path(), &format!("{RATE}{limit}{stiff}")));
    assert!(found.converged && found.goals[0].is_met && !found.goals[1].is_met);
    assert!((found.unknowns[0].value - 150.0).abs() < 1e-2, "{found:#?}");
    assert!(found.goals[0].multiplier > 0.0);
    assert_eq!(found.conflicts.len(), 1);
    assert_eq!(found.goals[0].name, "case down SPRINGDAMPER/2.FM, limits");
}

/// Checks that a joint takes no force along its sliding direction. Checks that limits over several load cases act together.
#[test]
fn several_goals_may_name_the_same_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = |case: &str, rest: &str| {
        format!("[[target.goal]]\ncase = \"{case}\"\ntolerance = 0.001\n{rest}\n")
    };
    let target = format!(
        "{RATE}{}{}{}",
        one("down", "of = \"JOINT/1.FZ\"\nvalue = 0"),
        one("up", "of = \"MARKER/20.Z\"\nleast = 302"),
        one("down", "of = \"MARKER/20.Z\"\nvalue = 299"),
    );
    let found = search(&loaded(folder.path(), &target));
    // 500 N lift the carrier by 2 mm if both springs have 250 N/mm together.
    assert!((found.unknowns[0].value - 200.0).abs() < 1e-2, "{found:#?}");
    assert!(found.goals[0].is_met && found.goals[1].is_met && !found.goals[2].is_met);
    assert!(found.goals[0].rows[0].after.abs() < 1e-9);
}

/// Checks the share of good axles against the normal distribution. The displacement under a load is proportional to 1/K, so a tolerance of
/// 2 percent on the spring rates scatters it by 2 percent.
#[test]
fn tolerances_scatter_the_readings_of_load_cases() {
    let folder = tempfile::tempdir().expect("a folder");
    let target = "[[target.goal]]\ncase = \"down\"\nof = \"SPRINGDAMPER/1.FZ\"\nvalue = 800\ntolerance = 4\n\
        [tolerances]\nhardpoints = 0\naxes_deg = 0\npreloads = 0\nspring_rates = 0.02\n";
    let tuning = loaded(folder.path(), &format!("{RATE}{target}"));
    let found = search(&tuning);
    let robust = tuning
        .robust(&found.x, 400, &mut |_| true)
        .expect("tolerances");
    // F = 1000 K1 / (K1 + K2): dF = 800 (1 - 0.8) (dK1 / K1 - dK2 / K2), with two independent springs.
    let sd = 800.0 * 0.2 * 0.02 * 2.0_f64.sqrt();
    let goal = &robust.goals[0];
    assert!((goal.sd - sd).abs() < 1e-4 * sd, "{} {sd}", goal.sd);
    let share = libm::erf(4.0 / sd / 2.0_f64.sqrt());
    assert!((goal.share - share).abs() < 1e-4, "{} {share}", goal.share);
    let drawn = goal.share_drawn.expect("drawn axles");
    let sd = (share * (1.0 - share) / 400.0).sqrt();
    assert!((drawn - share).abs() < 3.5 * sd, "{drawn} {share}");
}

/// Compares the exact derivatives of all values with central differences. Deviations are in units of the largest derivative of the row.
pub(crate) fn assert_derivatives(tuning: &Tuning, within: f64) {
    let mut evaluator = Evaluator::new(tuning);
    assert!(evaluator.is_exact.iter().all(|exact| *exact));
    assert!(tuning.goals.iter().all(|goal| goal.is_exact));
    let scale = tuning.scale();
    let x: Vec<f64> = scale.iter().map(|scale| 0.1 * scale).collect();
    let exact = evaluator.evaluate(&x, true).expect("an equilibrium");
    let mut differences = exact.jacobian.clone();
    for k in 0..x.len() {
        let step = 1e-3 * scale[k];
        let mut values = |h: f64| {
            let mut moved = x.clone();
            moved[k] += h;
            let found = evaluator.evaluate(&moved, false);
            found.expect("an equilibrium").values
        };
        let (plus, minus) = (values(step), values(-step));
        for (row, (plus, minus)) in plus.iter().zip(&minus).enumerate() {
            differences[(row, k)] = (plus - minus) / (2.0 * step);
        }
    }
    let mut row = 0;
    for goal in &tuning.goals {
        for _ in &goal.rows {
            let scaled = |k: usize, d: &nalgebra::DMatrix<f64>| d[(row, k)] * scale[k];
            let sizes = (0..x.len()).map(|k| scaled(k, &exact.jacobian).abs());
            let size = sizes.fold(1e-3, f64::max);
            for k in 0..x.len() {
                let (a, b) = (scaled(k, &exact.jacobian), scaled(k, &differences));
                let name = goal.name();
                let own = &tuning.unknowns[k].name;
                assert!(
                    (a - b).abs() < within * size,
                    "{name} by {own}: {a} {b} of {size}"
                );
            }
            row += 1;
        }
    }
}

/// Checks the derivatives of forces in every test against finite differences. The forces are those of bushings (with respect to their
/// stiffnesses and hardpoints), of a spring and of joints, and magnitudes.
#[test]
fn derivatives_of_forces_in_tests_are_those_of_differences() {
    let goal = |test: &str, of: &str, rest: &str| {
        format!("[[target.goal]]\ntest = \"{test}\"\nof = \"{of}\"\ntolerance = 1\n{rest}\n")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let target = [
        "[target]\n[[target.unknown]]\nnumbers = [\"BUSHING/1.K.1\", \"BUSHING/2.KT.3\", \"SPRINGDAMPER/1.FORCE\"]\nform = \"factor\"\nbounds = [0.5, 2.0]\n",
        "[[target.unknown]]\nnumbers = [\"MARKER/10.QP\"]\nbounds = [-5, 5]\n",
        &goal("bounce", "BUSHING/1.FX", "least = -9999"),
        &goal("roll", "BUSHING/2.TZ", "value = 0\nat = 20"),
        &goal("lateral", "BUSHING/1.FM", "gradient = 1"),
        &goal("braking", "BUSHING/3.TM", "least = 0"),
        &goal("ride", "SPRINGDAMPER/1.FZ", "value = 4000"),
        &goal("bounce", "MARKER/30.X", "least = -9999"),
        &goal("bounce", "WC.AZ", "least = -9999"),
    ]
    .concat();
    let kc = String::from_utf8(corpus("multilink/kc.toml")).expect("text");
    let deck = corpus("multilink/model.adm");
    let multilink = study(folder.path(), &deck, "value\n", &target, &kc);
    assert_derivatives(&multilink, 2e-5);

    let folder = tempfile::tempdir().expect("a folder");
    let target = [
        "[target]\n[[target.unknown]]\nnumbers = [\"MARKER/112.QP\", \"MARKER/142.QP\"]\nbounds = [-15, 15]\nsymmetric = true\n",
        &goal("lateral", "JOINT/13.FX", "least = -99999"),
        &goal("lateral", "JOINT/11.FY", "gradient = 1"),
        &goal("lateral", "JOINT/11.TM", "least = -9999999"),
    ]
    .concat();
    let kc = KC.replace(
        "[tests.bounce]",
        "[tests.lateral]\nhold = \"height\"\nwindow = 1000",
    );
    let kc = kc.replace(
        "range = [-80, 80]\npoints = 17",
        "range = [-2000, 2000]\npoints = 5",
    );
    let deck = corpus("double-wishbone/model.adm");
    let wishbone = study(folder.path(), &deck, "value\n", &target, &kc);
    assert_derivatives(&wishbone, 2e-5);
}

/// Checks that a limit on the force of a joint holds on the double wishbone under lateral force, while a goal for toe is met.
#[test]
fn a_limit_on_a_joint_force_holds_in_a_test() {
    let folder = tempfile::tempdir().expect("a folder");
    let kc = KC.replace(
        "[tests.bounce]",
        "[tests.lateral]\nhold = \"height\"\nwindow = 1000",
    );
    let kc = kc.replace(
        "range = [-80, 80]\npoints = 17",
        "range = [-2000, 2000]\npoints = 5",
    );
    let unknown = "[[target.unknown]]\nnumbers = [\"MARKER/122.QP.3\"]\nbounds = [-60, 60]\nsymmetric = true\n";
    let goal = |rest: &str| {
        format!(
            "[[target.goal]]\ntest = \"lateral\"\nof = \"JOINT/12.FM\"\ntolerance = 1\n{rest}\n"
        )
    };
    let deck = corpus("double-wishbone/model.adm");
    let target = format!("[target]\nrestarts = 0\n{unknown}{}", goal("least = 0"));
    let tuning = study(folder.path(), &deck, "value\n", &target, &kc);
    let values = |tuning: &Tuning| -> Vec<f64> {
        let goal = &tuning.goals[0];
        let rows = goal.rows.iter();
        rows.map(|row| goal.value(row, &tuning.before)).collect()
    };
    let before = values(&tuning);
    let largest = before.iter().copied().fold(0.0, f64::max);
    assert!(largest > 100.0, "{before:?}");
    let most = 0.95 * largest;
    let target = format!(
        "[target]\nrestarts = 0\n{unknown}{}",
        goal(&format!("most = {most}"))
    );
    let tuning = study(folder.path(), &deck, "value\n", &target, &kc);
    let found = search(&tuning);
    assert!(found.keeps_limits && found.met, "{found:#?}");
    // The tuned deck, read anew, has these forces.
    let again = study(folder.path(), &found.deck, "value\n", &target, &kc);
    for (value, row) in values(&again).iter().zip(&found.goals[0].rows) {
        assert!(
            (value - row.after).abs() < 1e-6 * largest,
            "{value} {}",
            row.after
        );
        assert!(*value <= most + settings::LIMIT_SLACK, "{value} {most}");
    }
}

/// Checks that wrong names are reported at their position, with a suggestion.
#[test]
fn wrong_names_are_reported_at_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = "[[target.goal]]\ncase = \"down\"\nof = \"SPRINGDAMPER/1.FZ\"\nvalue = 800\ntolerance = 1\n";
    let force = "SPRINGDAMPER/1.FZ";
    let table = "[[target.goal]]";
    let component = "is not a component of";
    let cases = [
        (("\"down\"", "\"dwn\""), "\"dwn\"", "`down`"),
        ((force, "SPRINGDAMPER/1.FQ"), "1.FQ\"", component),
        ((force, "SPRINGDAMPR/1.FZ"), "R/1.FZ\"", "SPRINGDAMPER/1"),
        ((force, "SPRINGDAMPER/11.FZ"), "11.FZ\"", "SPRINGDAMPER/1"),
        ((force, "SPRINGDAMPER/1"), "R/1\"", "needs a component"),
        ((force, "PART/2.FZ"), "\"PART/2.FZ\"", "exerts no force"),
        ((force, "MARKER/20.W"), "\"MARKER/20.W\"", component),
        ((force, "wheel.x"), "\"wheel.x\"", "the study has"),
        (
            ("value = 800", "gradient = 1"),
            table,
            "a load case takes `value`",
        ),
        (
            ("value", "at = 3\nvalue"),
            table,
            "`at` applies only to a goal of a test",
        ),
        (("value", "test = \"ride\"\nvalue"), table, "needs one of"),
        (("case = \"down\"\n", ""), table, "needs one of"),
        (
            ("value", "relative_to = \"2\"\nvalue"),
            "\"2\"",
            "no load case `2`",
        ),
    ];
    for ((from, to), place, words) in cases {
        let target = good.replacen(from, to, 1);
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect(name);
        write("model.adm", LOADED);
        write("load_cases.csv", "case,vertical\n0,0\ndown,-1000\n");
        write("kc.toml", RIG);
        let toml = format!("[model]\ndeck = \"model.adm\"\n{LOADS}[target]\n{RATE}{target}");
        write("study.toml", &toml);
        let (found, said) = Tuning::read(folder.path());
        assert!(found.is_err(), "{target}");
        let error = said.first().expect("a diagnostic");
        let label = error.labels.first().expect("a place");
        assert!(label.file.ends_with("study.toml"), "{error:?}");
        let text = &toml[label.span.start()..label.span.end()];
        assert!(text.contains(place), "{place}: {text}: {error:?}");
        let said = format!(
            "{} {}",
            error.message,
            error.help.clone().unwrap_or_default()
        );
        assert!(said.contains(words), "{target}\n{error:?}");
    }
}

/// Checks that a reading along a direction without stiffness is refused.
#[test]
fn a_free_motion_determines_no_reading() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect(name);
    // A cylindrical joint lets the carrier turn about the line of the spring.
    let deck = LOADED
        .replace("JOINT/1, TRANSLATIONAL", "JOINT/1, CYLINDRICAL")
        .replace("QP=0,-600,0", "QP=0,-700,0")
        .replace("QP=0,-600,300", "QP=0,-700,300")
        .replace(
            "SPRINGDAMPER/2, TRANSLATION, I=23, J=12",
            "SPRINGDAMPER/2, TRANSLATION, I=21, J=11",
        );
    write("model.adm", &deck);
    write("load_cases.csv", "case,vertical\ndown,-1000\n");
    let goal = |of: &str| {
        format!("[[target.goal]]\ncase = \"down\"\nof = \"{of}\"\nvalue = 0\ntolerance = 1\n")
    };
    for (of, is_right) in [
        ("MARKER/20.Z", true),
        ("MARKER/23.X", false),
        ("MARKER/20.AZ", false),
    ] {
        let toml = format!(
            "[model]\ndeck = \"model.adm\"\n{LOADS}[target]\n{RATE}{}",
            goal(of)
        );
        write("study.toml", &toml);
        let (found, said) = Tuning::read(folder.path());
        assert_eq!(found.is_ok(), is_right, "{of}: {said:#?}");
    }
}
