//! Tests of tolerances and Pareto fronts. Closed forms are checked on a wheel that a spring carries. On the double wishbone, the linear
//! model is compared with drawn axles.

use crate::bench::{KC, POINTS, corpus, search, study, wanted};
use crate::{Outcome, Robust, Tuning};

/// A carrier that slides along Z on a spring of 50 N/mm, so the wheel rate is the spring rate.
const DECK: &str = "A wheel on a spring\n\
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
PART/1, GROUND\n\
MARKER/10, PART=1, QP=0,-700,300\n\
MARKER/11, PART=1, QP=0,-600,700\n\
PART/2, MASS=10, CM=22, IP=1E5,1E5,1E5\n\
MARKER/20, PART=2, QP=0,-700,300\n\
MARKER/21, PART=2, QP=0,-600,300\n\
MARKER/22, PART=2, QP=0,-700,310\n\
MARKER/23, PART=2, QP=0,-800,300\n\
JOINT/1, TRANSLATIONAL, I=20, J=10\n\
SPRINGDAMPER/1, TRANSLATION, I=21, J=11, K=50, LENGTH=400\n\
END\n";

/// Rig of this deck: the wheel is held at several heights around the design position.
const RIG: &str = "[deck]\naxes = \"adams-car\"\n[wheels]\nmirror = true\n\
left = { centre = \"MARKER/20\", spin = \"MARKER/23\" }\n[tests.bounce]\nrange = [-20, 20]\npoints = 5\nwindow = 20\n";

/// Tolerances: the spring rates scatter by 5 percent, and nothing else scatters.
const SPRINGS: &str =
    "[tolerances]\nhardpoints = 0\naxes_deg = 0\npreloads = 0\nspring_rates = 0.05\n";

const RATE: &str =
    "[[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\nbounds = [20, 100]\n";

/// Returns a goal for the wheel rate.
fn goal(text: &str) -> String {
    format!(
        "[[target.goal]]\ntest = \"bounce\"\nof = \"wheel_load_vertical_force.vertical_left_force\"\n{text}\n"
    )
}

fn spring(target: &str) -> (tempfile::TempDir, Tuning) {
    let folder = tempfile::tempdir().expect("a folder");
    let toml = format!("[target]\nrestarts = 0\n{target}");
    let tuning = study(folder.path(), DECK.as_bytes(), "value\n", &toml, RIG);
    (folder, tuning)
}

fn robust(tuning: &Tuning, found: &Outcome, draws: usize) -> Robust {
    let robust = tuning.robust(&found.x, draws, &mut |_| true);
    robust.expect("tolerances and an equilibrium")
}

/// Probability of the interval between two limits under a normal distribution, integrated from its density.
fn share_between(least: f64, most: f64, mean: f64, sd: f64) -> f64 {
    let (from, to) = (least.max(mean - 12.0 * sd), most.min(mean + 12.0 * sd));
    let count = 20_000;
    let step = (to - from) / f64::from(count);
    let density = |x: f64| {
        let z = (x - mean) / sd;
        libm::exp(-0.5 * z * z) / (sd * (2.0 * std::f64::consts::PI).sqrt())
    };
    (0..count)
        .map(|k| step * density(from + step * (f64::from(k) + 0.5)))
        .sum()
}

/// Asserts that a share estimated from draws agrees with `share` within three standard deviations.
fn assert_drawn(drawn: f64, share: f64, count: usize) {
    let sd = (share * (1.0 - share) / count as f64).sqrt();
    assert!((drawn - share).abs() <= 3.0 * sd, "{drawn} {share} {sd}");
}

/// For a goal that is linear in one number, the share of good axles is that of the normal distribution. Halving the tolerance gives the
/// share of half the standard deviation.
#[test]
fn shares_of_a_linear_goal_are_those_of_the_normal_distribution() {
    // The spring stays at 52 N/mm: 2.6 N/mm is one standard deviation.
    let fixed = RATE.replace("[20, 100]", "[52, 52.000001]") + "start = 52\n";
    let wanted = goal("gradient = 50\ntolerance = 4");
    let limits = goal("least = 46\nlimits = \"gradient\"\ntolerance = 0.01");
    for (text, [least, most]) in [(wanted, [46.0, 54.0]), (limits, [46.0, f64::INFINITY])] {
        let (_folder, tuning) = spring(&format!("{fixed}{text}{SPRINGS}"));
        let found = robust(&tuning, &search(&tuning), 400);
        let share = share_between(least, most, 52.0, 2.6);
        assert!((found.share - share).abs() < 1e-4, "{found:#?} {share}");
        assert_eq!(found.share.to_bits(), found.goals[0].share.to_bits());
        assert!((found.goals[0].sd - 2.6).abs() < 1e-4, "{found:#?}");
        let halved = share_between(least, most, 52.0, 1.3);
        assert_eq!(found.tolerances.len(), 1, "{found:#?}");
        let spring = &found.tolerances[0];
        assert_eq!(
            (spring.group, spring.element.as_str(), spring.unit.as_str()),
            ("spring-rates", "SPRINGDAMPER/1", "%")
        );
        assert!((spring.share_if_halved - halved).abs() < 1e-4, "{spring:?}");
        assert!((spring.variance - 1.0).abs() < 1e-12 && (spring.sd - 5.0).abs() < 1e-9);
        // 52 + 5.2 is more than 54, 52 - 5.2 is more than 46.
        assert_eq!(found.met_two_sd, most.is_infinite());
        let drawn = found.drawn.expect("drawn axles");
        assert_eq!((drawn.count, drawn.failed), (400, 0));
        assert_drawn(drawn.share, share, 400);
    }
}

/// Two goals read the same value. The share of axles that meet both is that of the goal with the narrower band.
#[test]
fn shares_of_several_values_are_drawn() {
    let fixed = RATE.replace("[20, 100]", "[52, 52.000001]") + "start = 52\n";
    let goals = goal("gradient = 50\ntolerance = 4")
        + &goal("least = 46\nlimits = \"gradient\"\ntolerance = 0.01");
    let (_folder, tuning) = spring(&format!("{fixed}{goals}{SPRINGS}"));
    let found = robust(&tuning, &search(&tuning), 0);
    assert!(found.drawn.is_none());
    assert_drawn(found.share, share_between(46.0, 54.0, 52.0, 2.6), 20_000);
}

/// A robust search keeps a limit at two standard deviations from the mean. The standard deviation grows with the number. A robust goal is a
/// compromise between miss and scatter.
#[test]
fn a_robust_search_keeps_two_standard_deviations() {
    // K - 2 (0.05 K) = 45, while another goal pulls down.
    let limited = goal("gradient = 20\ntolerance = 1")
        + &goal("least = 45\nlimits = \"gradient\"\ntolerance = 0.01");
    let (_folder, tuning) = spring(&format!("robust = true\n{RATE}{limited}{SPRINGS}"));
    let found = search(&tuning);
    assert!(found.converged && found.keeps_limits, "{found:#?}");
    assert!((found.unknowns[0].value - 50.0).abs() < 1e-3, "{found:#?}");
    assert!(found.goals[1].is_met && robust(&tuning, &found, 0).goals[1].is_met_two_sd);
    // (K - 60)^2 + (0.1 K)^2 is least at 60 / 1.01.
    let wanted = goal("gradient = 60\ntolerance = 7");
    let (_folder, tuning) = spring(&format!("robust = true\n{RATE}{wanted}{SPRINGS}"));
    let found = search(&tuning);
    assert!(
        (found.unknowns[0].value - 60.0 / 1.01).abs() < 1e-4,
        "{found:#?}"
    );
    // 0.6 off and 5.94 of spread are within 7.
    assert!(found.met && robust(&tuning, &found, 0).met_two_sd);
}

/// A robust target without tolerances is rejected, and the diagnostic points at its position.
#[test]
fn a_robust_target_needs_tolerances() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect(name);
    write("model.adm", DECK);
    write("kc.toml", RIG);
    let wanted = goal("gradient = 60\ntolerance = 7");
    let toml = format!("[model]\ndeck = \"model.adm\"\n[target]\nrobust = true\n{RATE}{wanted}");
    write("study.toml", &toml);
    let (found, said) = Tuning::read(folder.path());
    assert!(found.is_err());
    let spans: Vec<&str> = said
        .iter()
        .flat_map(|one| &one.labels)
        .map(|label| &toml[label.span.range()])
        .collect();
    assert_eq!(spans, ["true"], "{said:#?}");
}

/// On the double wishbone, the linear model and the drawn axles agree in shares and standard deviations. Reducing a tolerance helps most if
/// its fraction of the variance is large.
#[test]
fn linear_and_drawn_axles_agree_on_the_double_wishbone() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = corpus("double-wishbone/model.adm");
    let goals = |toe: f64, camber: f64| {
        let curve = |of: &str, tolerance: f64| {
            format!(
                "[[target.goal]]\ntest = \"bounce\"\nof = \"{of}\"\ncurve = \"wanted.csv\"\ntolerance = {tolerance}\n"
            )
        };
        let both = curve("toe_angle.left", toe) + &curve("camber_angle.left", camber);
        format!("[target]\nrestarts = 0\n{POINTS}{both}[tolerances]\nhardpoints = 0.5\n")
    };
    let flat = "value,toe_angle.left [deg],camber_angle.left [deg]\n-80,0,0\n80,0,0\n";
    let first = study(folder.path(), &deck, flat, &goals(0.4, 0.2), KC);
    let curves = wanted(&first, &["toe_angle.left", "camber_angle.left"]);
    let tuning = study(folder.path(), &deck, &curves, &goals(0.4, 0.2), KC);
    let at = vec![0.0; 12];
    let count = 400;
    let found = tuning
        .robust(&at, count, &mut |_| true)
        .expect("an equilibrium");
    println!("{found:#?}");
    let drawn = found.drawn.as_ref().expect("drawn axles");
    assert_eq!(drawn.failed, 0);
    assert_drawn(drawn.share, found.share, count);
    for goal in &found.goals {
        assert_drawn(goal.share_drawn.expect("a share"), goal.share, count);
        let ratio = goal.sd_drawn.expect("a standard deviation") / goal.sd;
        // Three standard deviations of a standard deviation of 400 draws.
        assert!(
            (ratio - 1.0).abs() < 3.0 / (2.0 * count as f64).sqrt(),
            "{goal:?}"
        );
    }
    let sum: f64 = found.tolerances.iter().map(|own| own.variance).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    assert!(found.tolerances[0].share_if_halved > found.share);
    // What the tolerances of the right side do to the left is nothing, but for the rack between them.
    assert!(
        found.tolerances[0].variance > 0.05,
        "{:#?}",
        found.tolerances[0]
    );
}

/// For two goals of one value, the front is the line on which the sum of the misses equals the distance between the wanted values.
#[test]
fn the_front_of_two_values_of_one_number_is_a_line() {
    let goals = goal("gradient = 50\ntolerance = 1") + &goal("gradient = 60\ntolerance = 3");
    let (_folder, tuning) = spring(&format!("{RATE}{goals}"));
    let found = search(&tuning);
    let front = tuning.front(&found.x, [0, 1], &mut |_, _| true);
    println!("{front:#?}");
    assert!((9..=15).contains(&front.points.len()), "{front:#?}");
    for point in &front.points {
        assert!(
            (point.misses[0] + point.misses[1] - 10.0).abs() < 1e-3,
            "{point:?}"
        );
        assert!(point.converged && (point.values[0] - 50.0 - point.misses[0]).abs() < 1e-3);
    }
    // From one end to the other, without a gap of more than a quarter.
    let misses: Vec<f64> = front.points.iter().map(|point| point.misses[0]).collect();
    assert!(
        misses[0] < 0.01 && misses[misses.len() - 1] > 9.9,
        "{misses:?}"
    );
    assert!(
        misses.windows(2).all(|pair| pair[1] - pair[0] < 2.5),
        "{misses:?}"
    );
    // On a front, a limit becomes a goal, so the front of a limit and a goal is the same line.
    let goals = goal("gradient = 50\ntolerance = 1")
        + &goal("least = 60\nlimits = \"gradient\"\ntolerance = 3");
    let (_folder, tuning) = spring(&format!("{RATE}{goals}"));
    let found = search(&tuning);
    let front = tuning.front(&found.x, [0, 1], &mut |_, _| true);
    assert_eq!(front.measures, ["rms", "largest"]);
    for point in &front.points {
        assert!(
            (point.misses[0] + point.misses[1] - 10.0).abs() < 1e-2,
            "{point:?}"
        );
    }
}

/// Along the front of the double wishbone, one miss increases and the other decreases.
#[test]
fn the_front_of_the_double_wishbone_is_monotone() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = corpus("double-wishbone/model.adm");
    let unknown = "[[target.unknown]]\nnumbers = [\"MARKER/141.QP\", \"MARKER/122.QP\"]\nbounds = [-20, 20]\nsymmetric = true\nsd = 50\n";
    let goals = "[[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\ncurve = \"wanted.csv\"\ntolerance = 0.05\n\
        [[target.goal]]\ntest = \"bounce\"\nof = \"camber_angle.left\"\ncurve = \"wanted.csv\"\ntolerance = 0.05\n";
    let wanted = "value,toe_angle.left [deg],camber_angle.left [deg]\n-80,-2,4\n80,2,-6\n";
    let toml = format!("[target]\nrestarts = 0\n{unknown}{goals}");
    let tuning = study(folder.path(), &deck, wanted, &toml, KC);
    let found = search(&tuning);
    let front = tuning.front(&found.x, [0, 1], &mut |_, _| true);
    println!("{front:#?}");
    assert!((9..=15).contains(&front.points.len()), "{front:#?}");
    for pair in front.points.windows(2) {
        assert!(pair[1].misses[0] >= pair[0].misses[0] && pair[1].misses[1] <= pair[0].misses[1]);
    }
}

/// The solver's derivatives along a tolerance agree with solutions of decks with that tolerance. This holds for hardpoints, offsets, axes,
/// springs and bushings.
#[test]
fn changes_by_tolerances_are_those_of_solved_decks() {
    let bounce = "[[target.goal]]\ntest = \"bounce\"\nof = \"toe_angle.left\"\ngradient = 1.0\ntolerance = 0.1\n\
        [[target.goal]]\ntest = \"bounce\"\nof = \"camber_angle.left\"\nvalue = 1.0\nat = 20\ntolerance = 0.1\n";
    let lateral = "[[target.goal]]\ntest = \"lateral\"\nof = \"toe_angle.left\"\nvalue = 1.0\nat = 1000\ntolerance = 0.1\n\
        [[target.goal]]\ntest = \"bounce\"\nof = \"wheel_load_vertical_force.vertical_left_force\"\ngradient = 20\ntolerance = 1\n";
    let small = "[tolerances]\nhardpoints = 0.01\naxes_deg = 0.01\npreloads = 1e-3\nspring_rates = 1e-3\nstiffnesses = 1e-3\n";
    let unknown =
        |marker: &str| format!("[[target.unknown]]\nnumbers = [\"{marker}\"]\nbounds = [-5, 5]\n");
    let multilink = String::from_utf8(corpus("multilink/kc.toml")).expect("text");
    for (name, marker, kc, goals) in [
        ("double-wishbone", "MARKER/141.QP.3", KC, bounce.to_string()),
        (
            "multilink",
            "MARKER/10.QP.3",
            &multilink,
            format!("{bounce}{lateral}"),
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let toml = format!("[target]\n{}{goals}{small}", unknown(marker));
        let deck = corpus(&format!("{name}/model.adm"));
        let tuning = study(folder.path(), &deck, "value\n", &toml, kc);
        let mut evaluator = crate::evaluation::Evaluator::new(&tuning);
        let found = evaluator.scattered(&[0.0]).expect("an equilibrium");
        let sd = found.sd();
        let mut groups: Vec<&str> = Vec::new();
        for (k, own) in found.tolerances.iter().enumerate() {
            let mut at = |z: f64| {
                let mut all = vec![0.0; found.tolerances.len()];
                all[k] = z;
                let drawn = evaluator.drawn(&found.dataset, &found.tolerances, &all);
                drawn.expect("an equilibrium")
            };
            let (plus, minus) = (at(1.0), at(-1.0));
            for row in 0..sd.len() {
                let difference = 0.5 * (plus[row] - minus[row]);
                let apart = (difference - found.columns[(row, k)]).abs();
                assert!(
                    apart < 1e-4 * sd[row],
                    "{name} {own:?} row {row}: {difference} {}",
                    found.columns[(row, k)]
                );
            }
            if found
                .columns
                .column(k)
                .iter()
                .zip(&sd)
                .any(|(entry, sd)| entry.abs() > 1e-3 * sd)
            {
                groups.push(own.group.as_str());
            }
        }
        groups.dedup();
        groups.sort_unstable();
        groups.dedup();
        println!("{name}: {} tolerances, {groups:?}", found.tolerances.len());
        let expected: &[&str] = if name == "multilink" {
            &[
                "assembly-offsets",
                "hardpoints",
                "known-stiffnesses",
                "spring-rates",
            ]
        } else {
            &["assembly-offsets", "axes", "hardpoints"]
        };
        for group in expected {
            assert!(groups.contains(group), "{name} has no {group}: {groups:?}");
        }
    }
}

/// Every point of the front keeps a limit that is not one of the two goals.
#[test]
fn a_front_keeps_the_other_limits() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpus/double-wishbone");
    let mut tuning = Tuning::read(std::path::Path::new(corpus))
        .0
        .expect("a target");
    tuning.target.restarts = 0;
    let found = search(&tuning);
    let front = tuning.front(&found.x, [0, 1], &mut |_, _| true);
    println!("{front:#?}");
    for point in &front.points {
        assert!(point.converged && point.keeps_limits, "{point:?}");
    }
    for pair in front.points.windows(2) {
        assert!(pair[1].misses[0] >= pair[0].misses[0] && pair[1].misses[1] <= pair[0].misses[1]);
    }
    // Its ends are no worse than the tuned deck.
    let (first, last) = (&front.points[0], &front.points[front.points.len() - 1]);
    assert!(
        first.misses[0] <= front.tuned[0] * (1.0 + 1e-6),
        "{front:#?}"
    );
    assert!(
        last.misses[1] <= front.tuned[1] * (1.0 + 1e-6),
        "{front:#?}"
    );
}
