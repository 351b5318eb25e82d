use admire_study::Study;

use super::run::{admire, change, copied, corpus};

/// Checks that a study is created from a deck alone: loads, bushings and the wheel are found, and missing items are listed in order.
#[test]
fn a_study_begins_with_a_deck() {
    let folder = tempfile::tempdir().unwrap();
    let deck = corpus("pseudo-mcpherson/model.adm");
    let deck = deck.to_str().unwrap();
    let said = admire(
        folder.path(),
        &[
            "new",
            "axle",
            "--from",
            deck,
            "--measured",
            "marks,wheel,readings",
        ],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.err.contains("SFORCE/1, SFORCE/2, SFORCE/3"),
        "{}",
        said.err
    );
    let study = folder.path().join("axle");
    let read = Study::read(&study);
    assert!(!read.has_errors(), "{:?}", read.diagnostics);
    let read = read.value.unwrap();
    let columns: Vec<(&str, &str)> = read
        .columns
        .iter()
        .map(|(name, target)| (name.text.as_str(), target.text.as_str()))
        .collect();
    assert_eq!(
        columns,
        [
            ("longitudinal", "SFORCE/1"),
            ("lateral", "SFORCE/2"),
            ("vertical", "SFORCE/3")
        ]
    );
    assert!(read.wheel.is_some() && read.readings.is_some());
    let said = admire(folder.path(), &["check", "axle"]);
    assert_eq!(said.code, 1);
    let order = [
        "load_cases.csv",
        "marks_on_parts.csv",
        "marks_measured.csv",
        "wheel.csv",
        "readings.csv",
    ];
    let places: Vec<usize> = order
        .iter()
        .map(|name| {
            said.err
                .find(&format!("{name}: "))
                .unwrap_or_else(|| panic!("{name}: {}", said.err))
        })
        .collect();
    assert!(places.is_sorted(), "{}", said.err);
    // The K&C tests run on the new study: its own loads are left out, and the one wheel gets its mirror image.
    let kc = [
        "kc",
        "axle/model.adm",
        "--config",
        "axle/kc.toml",
        "--out",
        "kc",
    ];
    let said = admire(folder.path(), &kc);
    assert_eq!(said.code, 0, "{}", said.err);
    let begun = std::fs::read_to_string(study.join("kc.toml")).unwrap();
    for text in [
        "SFORCE/1",
        "SFORCE/2",
        "SFORCE/3",
        "[wheels.left]",
        "mirror = true",
    ] {
        assert!(begun.contains(text), "{begun}");
    }
    // Files of the user are replaced only on request.
    change(
        &study.join("study.toml"),
        "deck = \"model.adm\"",
        "deck = \"model.adm\" # mine",
    );
    let said = admire(folder.path(), &["new", "axle", "--from", deck]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(
        std::fs::read_to_string(study.join("study.toml"))
            .unwrap()
            .contains("# mine")
    );
}

/// Checks that both wheels of an axle are found, left and right by their positions.
#[test]
fn both_wheels_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let deck = "AXLE
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
!                 adams_view_name='nsl_upright'
PART/2, MASS=20, CM=21, IP=1E5,1E5,1E5
!                 adams_view_name='nsl_wheel_center'
MARKER/20, PART=2, QP=3000, -760, 310
MARKER/21, PART=2, QP=3000, -700, 310
!                 adams_view_name='nsr_upright'
PART/3, MASS=20, CM=31, IP=1E5,1E5,1E5
!                 adams_view_name='nsr_wheel_center'
MARKER/30, PART=3, QP=3000, 760, 310
MARKER/31, PART=3, QP=3000, 700, 310
END
";
    std::fs::write(folder.path().join("axle.adm"), deck).unwrap();
    let said = admire(folder.path(), &["new", "axle", "--from", "axle.adm"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let begun = std::fs::read_to_string(folder.path().join("axle/kc.toml")).unwrap();
    let (left, right) = begun.split_once("[wheels.right]").unwrap();
    assert!(
        left.contains("MARKER/20") && right.contains("MARKER/30"),
        "{begun}"
    );
    assert!(!begun.contains("mirror"), "{begun}");
}

/// Checks a study of K&C curves only: the wheel is found, the unfilled study has steps but no faults, and a filled table is read.
#[test]
fn a_study_of_curves_begins_with_a_deck() {
    let folder = tempfile::tempdir().unwrap();
    let deck = corpus("pseudo-mcpherson/model.adm");
    let deck = deck.to_str().unwrap();
    let said = admire(
        folder.path(),
        &["new", "axle", "--from", deck, "--measured", "curves"],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    let said = admire(folder.path(), &["check", "axle", "--format", "text"]);
    assert_eq!(said.code, 1);
    assert_eq!(said.out, "", "nothing is wrong, only missing");
    let at = |name: &str| {
        said.err
            .find(name)
            .unwrap_or_else(|| panic!("{}", said.err))
    };
    assert!(at("load_cases.csv: ") < at("kc.csv: "), "{}", said.err);
    assert!(!said.err.contains("1 error"), "{}", said.err);
    let study = folder.path().join("axle");
    change(
        &study.join("load_cases.csv"),
        "# 1,0,0,1500\n",
        "1,0,0,1500\n2,0,0,3000\n",
    );
    change(
        &study.join("kc.csv"),
        "# 1,0.012,-0.310,0.040,12.5,0.42,-0.15\n",
        "1,0.012,-0.310,0.040,12.5,0.42,-0.15\n2,0.02,-0.5,0.05,20,0.6,-0.2\n",
    );
    let said = admire(folder.path(), &["check", "axle"]);
    assert!(
        said.out.contains("toe from `toe_deg` in deg") && said.out.contains("track_mm"),
        "{}",
        said.out
    );
    assert!(said.err.contains("channels"), "{}", said.err);
}

/// Checks that a deck that is already in its study stays there, and that no study is created from a deck with errors.
#[test]
fn a_deck_stays_in_its_own_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(
        corpus("double-wishbone/model.adm"),
        folder.path().join("front.adm"),
    )
    .unwrap();
    let said = admire(folder.path(), &["new", ".", "--from", "front.adm"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(folder.path().join("study.toml").is_file());
    std::fs::write(folder.path().join("bad.adm"), "t\nMARKER/1, PART=9\nEND\n").unwrap();
    let said = admire(folder.path(), &["new", "other", "--from", "bad.adm"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("MARKER/1 names PART/9"), "{}", said.err);
    assert!(!folder.path().join("other").exists());
    let said = admire(
        folder.path(),
        &["new", "other", "--from", "front.adm", "--bushings", "999"],
    );
    assert_eq!(said.code, 2, "{}", said.err);
}

/// Checks that the table of plausibility precedes the fit, and that noise stated three orders of magnitude too small is refused.
#[test]
fn a_study_that_cannot_be_meant_is_refused_before_the_fit() {
    let (folder, study) = copied("pseudo-mcpherson");
    let fit = |more: &[&str]| {
        let arguments = [
            &["identify", "study", "--out", "out", "--method", "direct"],
            more,
        ]
        .concat();
        admire(folder.path(), &arguments)
    };
    let said = fit(&["-v"]);
    assert!(
        said.err.contains("noise of a mark") && said.err.contains("forecast"),
        "{}",
        said.err
    );
    assert_eq!(fit(&["-q"]).err.find("forecast"), None);
    change(&study.join("study.toml"), "sigma = 0.05", "sigma = 5e-5");
    let said = fit(&[]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(
        said.err.contains("times as much as marks.sigma states") && said.err.contains("--force"),
        "{}",
        said.err
    );
    let said = fit(&["--force"]);
    assert!(said.code == 0 || said.code == 3, "{}", said.err);
    assert!(folder.path().join("out/report.html").is_file());
}

/// Checks millimetres read as metres: the lint of the deck and the table of plausibility report it.
#[test]
fn a_unit_slip_of_the_deck_is_seen() {
    let (folder, study) = copied("pseudo-mcpherson");
    let deck = study.join("model.adm");
    let text = std::fs::read_to_string(&deck).unwrap();
    let changed = text
        .replace("LENGTH = MILLIMETER", "LENGTH = METER")
        .replace("LENGTH=MILLIMETER", "LENGTH=METER");
    assert_ne!(text, changed);
    std::fs::write(&deck, changed).unwrap();
    let said = admire(folder.path(), &["check", "study"]);
    assert!(
        said.err.contains("no axle has this size"),
        "{}\n{}",
        said.out,
        said.err
    );
}

/// Checks that a wrong sign or unit of a curve is detected before any fit, and that a sign can be stated.
#[test]
fn curves_that_move_otherwise_than_the_model_are_seen() {
    let (folder, study) = copied("kc-curves");
    let told = || admire(folder.path(), &["check", "study"]).err;
    let said = told();
    assert!(
        said.contains(" ok  agreement") && said.contains("move as the model does"),
        "{said}"
    );
    let toml = study.join("study.toml");
    let shipped = std::fs::read_to_string(&toml).unwrap();
    let (key, _) = shipped
        .split_once("[kc.curves]")
        .unwrap()
        .1
        .split_once("camber = {")
        .unwrap();
    let key = format!("[kc.curves]{key}camber = {{");
    change(&toml, &key, &format!("{key} sign = \"-\","));
    let said = told();
    assert!(
        said.contains("warn") && said.contains("camber moves against the model"),
        "{said}"
    );
    std::fs::write(&toml, &shipped).unwrap();
    change(&study.join("kc.csv"), "Camber [deg]", "Camber [min]");
    let said = told();
    assert!(said.contains("degrees and minutes"), "{said}");
}

/// Checks that faults are detected before any fit: a column of loads with the opposite sign or in kilonewtons, marks from another origin, and
/// two exchanged cases.
#[test]
fn a_table_of_loads_that_marks_do_not_follow_is_seen() {
    let (folder, study) = copied("pseudo-mcpherson");
    let told = || {
        let said = admire(folder.path(), &["check", "study"]).err;
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let odd = "do not follow the table of loads";
    assert!(!told().contains(odd), "{}", told());
    let table = study.join("load_cases.csv");
    let shipped = std::fs::read_to_string(&table).unwrap();
    let lateral = shipped.lines().next().unwrap();
    let lateral = lateral.split(',').position(|name| name == "lateral");
    let changed = |factor: f64| {
        let line = |(at, line): (usize, &str)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_string).collect();
            if at > 0 {
                let value = &mut fields[lateral.unwrap()];
                *value = (factor * value.parse::<f64>().unwrap()).to_string();
            }
            fields.join(",")
        };
        let lines: Vec<String> = shipped.lines().enumerate().map(line).collect();
        std::fs::write(&table, lines.join("\n") + "\n").unwrap();
    };
    changed(-1.0);
    let said = told();
    let wanted = "the load column `lateral` with the opposite sign";
    assert!(said.contains(wanted) && !said.contains(odd), "{said}");
    let refused = admire(folder.path(), &["diagnose", "study", "--out", "told"]);
    assert_eq!(refused.code, 1, "{}", refused.err);
    assert!(!folder.path().join("told/diagnosis.json").exists());
    changed(0.001);
    let said = told();
    let wanted = "the load column `lateral` multiplied by 1000, as if stated in knewton";
    assert!(said.contains(wanted) && !said.contains(odd), "{said}");
    let exchanged = shipped.replacen("lateral", "?", 1);
    let exchanged = exchanged.replacen("longitudinal", "lateral", 1);
    std::fs::write(&table, exchanged.replacen('?', "longitudinal", 1)).unwrap();
    let said = told();
    let wanted = "the load columns `";
    assert!(
        said.contains(wanted) && said.contains("fail slip"),
        "{said}"
    );
    std::fs::write(&table, &shipped).unwrap();
    // Marks from another origin.
    let marks = study.join("marks_measured.csv");
    let read = std::fs::read_to_string(&marks).unwrap();
    let shifted = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        match fields[3].parse::<f64>() {
            Ok(x) => format!(
                "{},{},{}",
                fields[..3].join(","),
                x + 1500.0,
                fields[4..].join(",")
            ),
            Err(_) => line.to_string(),
        }
    };
    let lines: Vec<String> = read.lines().map(shifted).collect();
    std::fs::write(&marks, lines.join("\n") + "\n").unwrap();
    let said = told();
    assert!(
        said.contains("displaced alike, by (1") && said.contains("deck's frame"),
        "{said}"
    );
    let refused = admire(folder.path(), &["identify", "study", "--out", "told"]);
    assert_eq!(refused.code, 1, "{}", refused.err);
    std::fs::write(&marks, read).unwrap();
    let labels: Vec<&str> = shipped
        .lines()
        .skip(1)
        .map(|line| line.split_once(',').unwrap().0)
        .collect();
    let (a, b) = (labels[2], labels[9]);
    let lines = std::fs::read_to_string(&marks).unwrap();
    let exchanged = |line: &str| match line.split_once(',') {
        Some((case, rest)) if case == a => format!("{b},{rest}"),
        Some((case, rest)) if case == b => format!("{a},{rest}"),
        _ => line.to_string(),
    };
    let lines: Vec<String> = lines.lines().map(exchanged).collect();
    std::fs::write(&marks, lines.join("\n") + "\n").unwrap();
    let said = told();
    assert!(
        said.contains(&format!("the marks of case {a} fit the loads of case {b}")),
        "{said}"
    );
}

/// Checks a deck with names in another language, loads of a GFORCE, and terms of a laboratory: wheel, directions and curves are found. A
/// complaint that applies to several curves is made once.
#[test]
fn a_deck_and_a_table_in_german_are_understood() {
    let folder = tempfile::tempdir().unwrap();
    let deck = "ACHSE links
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/10, PART=1
MARKER/11, PART=1, FLOATING
MARKER/12, PART=1, QP=0, 400, 300
!                 adams_view_name='Radtraeger'
PART/2, MASS=20, CM=21, IP=1E5,1E5,1E5
MARKER/21, PART=2, QP=0, 700, 300
!                 adams_view_name='Radmitte'
MARKER/22, PART=2, QP=0, 760, 310
MARKER/23, PART=2, QP=0, 400, 300
BUSHING/1, I=23, J=12, K=1E4,1E4,1E4, KT=1E8,1E8,1E8
GFORCE/4, I=22, JFLOAT=11, RM=10, FX=0\\
, FY=0\\
, FZ=-3000\\
, TX=0\\
, TY=0\\
, TZ=0
END
";
    std::fs::write(folder.path().join("achse.adm"), deck).unwrap();
    let new = ["new", "s", "--from", "achse.adm", "--measured", "curves"];
    let said = admire(folder.path(), &new);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("MARKER/22 on Radtraeger"), "{}", said.err);
    let study = folder.path().join("s");
    // A left wheel at y > 0 means the axes of ISO 8855.
    let toml = std::fs::read_to_string(study.join("study.toml")).unwrap();
    let rig = std::fs::read_to_string(study.join("kc.toml")).unwrap();
    assert!(toml.contains("forward = \"+x\""), "{toml}");
    assert!(
        rig.contains("axes = \"iso\"") && rig.contains("[wheels.left]"),
        "{rig}"
    );
    let loads = std::fs::read_to_string(study.join("load_cases.csv")).unwrap();
    assert!(
        loads.starts_with("case,longitudinal,lateral,vertical,longitudinal_torque,")
            && loads.contains("FZ of GFORCE/4 on Radtraeger")
            && loads.contains("-3000 in the deck"),
        "{loads}"
    );
    let cases = "case,longitudinal,lateral,vertical,longitudinal_torque,lateral_torque,vertical_torque\n1,0,0,0,0,0,0\n2,0,0,-3000,0,0,0\n";
    std::fs::write(study.join("load_cases.csv"), cases).unwrap();
    let curves = "Spur [min];Sturz (min);Nachlauf [deg];Radhub [mm];Radstandsänderung [mm];Spurweite [mm]\n0,1;0,2;0;0;0;0\n1,5;2,5;0,1;-3,1;0;0,2\n";
    std::fs::write(study.join("kc.csv"), curves).unwrap();
    let said = admire(folder.path(), &["check", "s", "--format", "plain"]);
    for text in [
        "toe from `Spur [min]` in min",
        "camber from `Sturz (min)`",
        "travel from `Radhub [mm]`",
        "base from `Radstandsänderung [mm]`",
        "track from `Spurweite [mm]`",
    ] {
        assert!(said.out.contains(text), "{text}: {}{}", said.out, said.err);
    }
    let quiet = admire(folder.path(), &["check", "s", "-q", "--format", "plain"]);
    assert_eq!((quiet.code, quiet.out.as_str()), (0, ""), "{}", quiet.err);
    change(&study.join("study.toml"), "MARKER/22", "MARKER/99");
    let said = admire(folder.path(), &["check", "s", "--format", "plain"]);
    let count = said
        .out
        .matches("the deck has no marker `MARKER/99`")
        .count();
    assert_eq!(count, 1, "{}", said.out);
}
