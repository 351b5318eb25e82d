//! `admire tune` as a process.

use std::path::Path;
use std::process::Output;

use crate::run;

/// Runs `admire` in the folder of the corpus.
fn admire(arguments: &[&str]) -> Output {
    run::admire(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Returns the text of a stream with one kind of line end.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).replace("\r\n", "\n")
}

/// Checks that the page of the guide shows the output of the command. The deck of the study is unchanged, and the tuned deck differs only in
/// markers.
#[test]
fn the_page_shows_what_the_command_prints() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tuned");
    let shown = out.display().to_string();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/double-wishbone");
    let before = std::fs::read(study.join("model.adm")).unwrap();
    let ran = admire(&["tune", "corpus/double-wishbone", "--out", &shown]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let said = text(&ran.stdout).replace('\\', "/");
    let said = said.replace(&shown.replace('\\', "/"), "target/tuned");
    let page = include_str!("../../src/guide/tune.md");
    let command = "$ admire tune corpus/double-wishbone --out target/tuned\n";
    let (_, rest) = page.split_once(command).expect("the command");
    let (block, _) = rest.split_once("```").expect("a block");
    // A line that ends in three points is compared up to these points; a line of three points stands for any number of lines.
    let mut lines = said.lines();
    for shown in block.lines().filter(|line| *line != "...") {
        let found = match shown.strip_suffix("...") {
            Some(begin) => lines.any(|line| line.starts_with(begin)),
            None => lines.any(|line| line == shown),
        };
        assert!(found, "{shown} in\n{said}");
    }

    assert_eq!(std::fs::read(study.join("model.adm")).unwrap(), before);
    let tuned = std::fs::read(out.join("tuned.adm")).unwrap();
    let (old, new) = (text(&before), text(&tuned));
    let changed: Vec<(&str, &str)> = old
        .lines()
        .zip(new.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(old.lines().count(), new.lines().count());
    assert!(!changed.is_empty());
    for (old, new) in changed {
        let number =
            old.starts_with("MARKER/") || old.starts_with(", ZP") || old.starts_with(", XP");
        assert!(number, "{old} | {new}");
    }
    // The tests of the tuned deck give the values that the search reports.
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("tuning.json")).unwrap()).unwrap();
    let kc = folder.path().join("kc");
    let config = study.join("kc.toml").display().to_string();
    let deck = out.join("tuned.adm").display().to_string();
    let ran = admire(&[
        "kc",
        &deck,
        "--config",
        &config,
        "--out",
        &kc.display().to_string(),
    ]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let curves = std::fs::read_to_string(kc.join("curves.csv")).unwrap();
    let lines: Vec<Vec<&str>> = curves
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
        .collect();
    let column = |name: &str| lines[0].iter().position(|head| *head == name).expect(name);
    let (test, branch) = (column("test"), column("branch"));
    let own = column("toe_angle.left [deg]");
    let toe: Vec<f64> = lines[1..]
        .iter()
        .filter(|row| row[test] == "bounce" && row[branch] == "up")
        .map(|row| row[own].parse().unwrap())
        .collect();
    let rows = json["goals"][0]["rows"].as_array().unwrap();
    assert_eq!(toe.len(), rows.len());
    for (toe, row) in toe.iter().zip(rows) {
        assert!((toe - row["after"].as_f64().unwrap()).abs() < 1e-6);
    }
}

/// Axles that differ and what one goal costs the other are in the output, in `tuning.json` and in the report.
#[test]
fn tolerances_and_fronts_are_in_every_output() {
    let folder = tempfile::tempdir().unwrap();
    let shown = folder.path().join("front").display().to_string();
    let base = [
        "tune",
        "corpus/double-wishbone",
        "--restarts",
        "0",
        "--draws",
        "30",
        "--out",
        &shown,
    ];
    let pair = ["--pareto", "1", "bounce camber_angle.left, gradient"];
    let ran = admire(&[&base[..], &pair].concat());
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let said = text(&ran.stdout);
    assert!(
        said.starts_with(
            "Pareto front, miss of each goal:\n  A  bounce toe_angle.left, rms [deg]\n"
        ),
        "{said}"
    );
    assert!(
        said.contains("% of axles within the tolerances meet all goals"),
        "{said}"
    );
    assert!(said.contains("Monte Carlo axles do"), "{said}");
    let out = Path::new(&shown);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("tuning.json")).unwrap()).unwrap();
    let points = json["pareto"]["points"].as_array().unwrap();
    // As many rows stand in the table, with its heads and the tuned deck.
    let table = said
        .lines()
        .skip(3)
        .take_while(|line| line.starts_with("  ") && !line.contains(" of "));
    assert_eq!(table.count(), points.len() + 2, "{said}");
    assert_eq!(json["robust"]["drawn"]["count"], 30);
    assert_eq!(json["robust"]["goals"].as_array().unwrap().len(), 3);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for piece in [
        "Trade-off between two goals",
        "Pareto front",
        "good, Monte Carlo",
        "good if halved",
        "hardpoint MARKER/",
    ] {
        assert!(page.contains(piece), "the report has no {piece}");
    }

    let wrong = admire(&[&base[..], &["--pareto", "toe", "2", "--force"]].concat());
    assert_eq!(wrong.status.code(), Some(2));
    let said = text(&wrong.stderr);
    assert!(
        said.contains("`toe` is not a goal of this target"),
        "{said}"
    );
    assert!(said.contains("1 \"bounce toe_angle.left\""), "{said}");
}

/// Exit codes: 1 for a fault of the study, 2 for the command line, and a file of the user is not replaced.
#[test]
fn faults_have_their_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().display().to_string();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("study.toml", "[model]\ndeck = \"model.adm\"\n[target]\n");
    write("model.adm", "title\nEND\n");
    let ran = admire(&["tune", &study]);
    assert_eq!(ran.status.code(), Some(1));
    assert!(
        text(&ran.stderr).contains("kc.toml"),
        "{}",
        text(&ran.stderr)
    );
    let ran = admire(&["tune"]);
    assert_eq!(ran.status.code(), Some(2));
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("tuned.adm"), "mine").unwrap();
    let shown = out.display().to_string();
    let ran = admire(&[
        "tune",
        "corpus/double-wishbone",
        "--out",
        &shown,
        "--restarts",
        "0",
    ]);
    assert_eq!(ran.status.code(), Some(1));
    assert_eq!(
        std::fs::read_to_string(out.join("tuned.adm")).unwrap(),
        "mine"
    );
}

/// Checks that `admire check` accepts a study with only a target as complete, and that it finds faults of the target.
#[test]
fn a_study_with_a_target_alone_is_checked() {
    let ran = admire(&["check", "corpus/double-wishbone"]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stdout));
    let folder = tempfile::tempdir().unwrap();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/double-wishbone");
    for name in ["model.adm", "kc.toml", "wanted.csv", "study.toml"] {
        std::fs::copy(study.join(name), folder.path().join(name)).unwrap();
    }
    let toml = std::fs::read_to_string(study.join("study.toml")).unwrap();
    let wrong = toml.replace("MARKER/141.QP", "MARKER/941.QP");
    std::fs::write(folder.path().join("study.toml"), wrong).unwrap();
    let ran = admire(&["check", &folder.path().display().to_string()]);
    assert_eq!(ran.status.code(), Some(1));
    let said = text(&ran.stdout);
    assert!(said.contains("MARKER/941 is not in this dataset"), "{said}");
    assert!(said.contains("did you mean MARKER/141?"), "{said}");
}

/// Toe and camber of Adams/Car in its own lateral test are the target of the shipped axle, whose hardpoints were moved. The search brings its
/// curves as near to the real ones as the unmoved deck has them, over the loads at which the real bushings are straight.
#[test]
fn real_curves_are_the_target_of_a_moved_axle() {
    for run in crate::real::runs().iter().filter(|run| !run.rolls) {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let axle = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/adams-car-axle");
        let read = |name: &str| std::fs::read_to_string(axle.join(name)).unwrap();
        let mut wanted = "value,toe_angle.left [deg],camber_angle.left [deg]\n".to_string();
        run.each(|of, _| {
            let force = -of("wheel_load_lateral.lateral_left");
            let angles = ["toe_angle.left", "camber_angle.left"].map(|name| of(name).to_degrees());
            wanted += &format!("{force},{},{}\n", angles[0], angles[1]);
        });
        write("wanted.csv", &wanted);
        let kc = read("kc.toml").replace(
            "range = [-4000, 4000]",
            "range = [-1000, 1000]\npoints = 9\nhold = \"height\"",
        );
        write("kc.toml", &kc);
        let goal = |of: &str| {
            format!(
                "[[target.goal]]\ntest = \"lateral\"\nof = \"{of}\"\ncurve = \"wanted.csv\"\ntolerance = 0.001\n"
            )
        };
        let goals = goal("toe_angle.left") + &goal("camber_angle.left");
        let unknown = "[[target.unknown]]\nnumbers = [\"MARKER/48.QP\", \"MARKER/54.QP\", \"MARKER/64.QP\"]\nbounds = [\"-15 mm\", \"15 mm\"]\nsd = \"50 mm\"\n";
        let study =
            format!("[model]\ndeck = \"model.adm\"\n[target]\nrestarts = 0\n{unknown}{goals}");
        write("study.toml", &study);
        write("model.adm", &read("model.adm"));
        let target = || {
            admire_tune::Tuning::read(folder.path())
                .0
                .expect("a target")
        };
        let own = target();
        let deck = own
            .deck(&[6.0, -5.0, 4.0, -3.0, 7.0, -6.0, 5.0, 4.0, -7.0])
            .unwrap();
        std::fs::write(folder.path().join("model.adm"), deck.bytes()).unwrap();
        let found = target().search(&mut |_, _| true).unwrap();
        for (goal, own_goal) in found.goals.iter().zip(&own.goals) {
            let misses = own_goal
                .rows
                .iter()
                .map(|row| row.miss(own_goal.value(row, &own.before)));
            let squares: f64 = misses.map(|miss| miss * miss).sum();
            let unmoved = (squares / own_goal.rows.len() as f64).sqrt();
            println!(
                "{}: {:.2e}, moved {:.2e}, tuned {:.2e} deg rms",
                goal.name, unmoved, goal.rms_before, goal.rms_after
            );
            assert!(goal.rms_before > 10.0 * unmoved && goal.rms_after <= unmoved.max(1e-4));
        }
        assert!(found.converged);
    }
}

/// A carrier that slides along Z on two springs, under a load of its own: 100 N/mm and 50 N/mm.
const TWO_SPRINGS: &str = "A load on two springs\n\
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
RESULTS/XRF\n\
END\n";

/// Its load cases, two goals that stand against each other, and tolerances.
const LOAD_CASES: &str = "[model]\ndeck = \"model.adm\"\n\
[loads]\nfile = \"load_cases.csv\"\ncolumns = { vertical = \"SFORCE/3\" }\n\
[tolerances]\nspring_rates = 0.02\n\
[target]\nrestarts = 1\n\
[[target.goal]]\ncase = \"down\"\nof = \"MARKER/20.Z\"\nrelative_to = \"0\"\nvalue = -4\ntolerance = 0.1\n\
[[target.goal]]\ncase = \"down\"\nof = \"SPRINGDAMPER/2.FZ\"\nvalue = 150\ntolerance = 5\n\
[[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"value\"\nbounds = [20, 900]\n";

/// Checks that `admire check` finds faults of the target in a study that has readings too.
#[test]
fn the_target_of_a_study_with_readings_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/multilink");
    for entry in std::fs::read_dir(shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let toml = folder.path().join("study.toml");
    let study = std::fs::read_to_string(&toml).unwrap();
    let goal = |of: &str| {
        format!(
            "{study}\n[target]\n[[target.goal]]\ncase = \"3\"\nof = \"{of}\"\nvalue = 1\ntolerance = 1\n[[target.unknown]]\nnumbers = [\"SPRINGDAMPER/1.K\"]\nform = \"factor\"\nbounds = [0.5, 2]\n"
        )
    };
    let path = folder.path().display().to_string();
    std::fs::write(&toml, goal("SPRINGDAMPER/1.FM")).unwrap();
    let ran = admire(&["check", &path]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stdout));
    std::fs::write(&toml, goal("SPRINGDAMPER/7.FM")).unwrap();
    let ran = admire(&["check", &path]);
    let said = text(&ran.stdout);
    assert_eq!(ran.status.code(), Some(1), "{said}");
    let complaint = "SPRINGDAMPER/7 is not in this dataset";
    assert_eq!(said.matches(complaint).count(), 1, "{said}");
}

/// Goals of load cases need no `kc.toml`: check, search, tolerances, Pareto front and report. The forces of the tuned deck are those that its own
/// static simulation writes into a results file.
#[test]
fn load_cases_are_tuned_without_tests() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("model.adm", TWO_SPRINGS);
    write("load_cases.csv", "case,vertical\n0,0\ndown,-1000\n");
    write("study.toml", LOAD_CASES);
    let study = folder.path().display().to_string();
    let ran = admire(&["check", &study]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stdout));
    let out = folder.path().join("out");
    let shown = out.display().to_string();
    let base = ["tune", &study, "--out", &shown, "--draws", "20"];
    let pair = ["--pareto", "case down MARKER/20.Z", "2"];
    let ran = admire(&[&base[..], &pair].concat());
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let said = text(&ran.stdout);
    assert!(said.contains("case down MARKER/20.Z: off by"), "{said}");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("tuning.json")).unwrap()).unwrap();
    let goals = json["goals"].as_array().unwrap();
    assert_eq!(goals[0]["case"], "down");
    assert_eq!(goals[0]["test"], "");
    assert_eq!(goals[0]["unit"], "mm");
    assert_eq!(goals[1]["unit"], "N");
    assert_eq!(goals[1]["exact_derivatives"], true);
    assert_eq!(json["robust"]["goals"].as_array().unwrap().len(), 2);
    assert!(json["pareto"]["points"].as_array().unwrap().len() > 1);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for piece in [
        "case down SPRINGDAMPER/2.FZ",
        "load_cases.csv",
        "Pareto front",
    ] {
        assert!(page.contains(piece), "the report has no {piece}");
    }

    // The results file of a static simulation of the tuned deck, by the path of the commands.
    let mut deck = admire::Deck::open(out.join("tuned.adm")).unwrap();
    let solved = deck.set("SFORCE/3", -1000.0).unwrap().solve().unwrap();
    let force = solved.column("SPRINGDAMPER_2.FZ").unwrap();
    let after = goals[1]["rows"][0]["after"].as_f64().unwrap();
    let last = force.last().unwrap();
    assert!((last - after).abs() < 1e-6 * after, "{force:?} {after}");
}

/// A goal for an element that is not in the deck: exit code 1, the place in `study.toml`, and what was meant. So are load cases that there are not.
#[test]
fn wrong_elements_and_cases_of_goals_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("model.adm", TWO_SPRINGS);
    write("load_cases.csv", "case,vertical\n0,0\ndown,-1000\n");
    let study = folder.path().display().to_string();
    for (from, to, message, help) in [
        (
            "SPRINGDAMPER/2.FZ",
            "SPRINGDAMPER/22.FZ",
            "SPRINGDAMPER/22 is not in this dataset",
            "did you mean SPRINGDAMPER/2?",
        ),
        (
            "SPRINGDAMPER/2.FZ",
            "SPRINGDAMPER/2.F",
            "`F` is not a component of SPRINGDAMPER/2",
            "did you mean `FM`?",
        ),
        (
            "case = \"down\"",
            "case = \"dwn\"",
            "there is no load case `dwn`",
            "did you mean `down`?",
        ),
    ] {
        write("study.toml", &LOAD_CASES.replace(from, to));
        let ran = admire(&["tune", &study, "--force"]);
        assert_eq!(ran.status.code(), Some(1));
        let said = text(&ran.stderr);
        assert!(said.contains(message) && said.contains(help), "{said}");
        assert!(said.contains("study.toml"), "{said}");
    }
    let loads = "[loads]\nfile = \"load_cases.csv\"\ncolumns = { vertical = \"SFORCE/3\" }\n";
    write("study.toml", &LOAD_CASES.replace(loads, ""));
    let ran = admire(&["tune", &study, "--force"]);
    assert_eq!(ran.status.code(), Some(1));
    let said = text(&ran.stderr);
    assert!(said.contains("the study has no load cases"), "{said}");
}
