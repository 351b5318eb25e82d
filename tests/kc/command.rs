//! `admire kc` as a process.
use serde_json::Value;

use crate::run::{admire, corpus, said};

/// Returns the values of one reading in a test of `kc.json`.
fn values(json: &Value, test: &str, path: &str) -> Vec<f64> {
    let columns = json["columns"].as_array().unwrap();
    let at = columns.iter().position(|c| c["path"] == path).unwrap();
    let tests = json["tests"].as_array().unwrap();
    let test = tests.iter().find(|t| t["test"] == test).unwrap();
    let samples = test["samples"].as_array().unwrap();
    samples
        .iter()
        .map(|s| s["values"][at].as_f64().unwrap())
        .collect()
}

#[test]
fn the_written_decks_give_the_same_wheels() {
    let folder = tempfile::tempdir().unwrap();
    let config = corpus("pseudo-mcpherson/kc.toml");
    let deck = corpus("pseudo-mcpherson/model.adm");
    let output = admire(
        folder.path(),
        &[
            "kc",
            &deck,
            "--config",
            &config,
            "--out",
            "kc",
            "--write-deck",
        ],
    );
    said(&output, 0);
    let out = folder.path().join("kc");
    let json: Value = serde_json::from_slice(&std::fs::read(out.join("kc.json")).unwrap()).unwrap();
    for test in ["bounce", "lateral", "braking", "aligning"] {
        // The command file runs in any ADAMS, and its results contain the motions of the carrier.
        let solved = admire(&out, &["solve", &format!("{test}.acf")]);
        assert!(solved.status.success(), "{test}");
        if test == "bounce" {
            // The word after the two points of the steer axis is parsed as a separate flag.
            let points = ["KNUCKLE@0,0,0", "KNUCKLE@0,0,200"];
            let mut arguments = vec!["results", "bounce.res", "--kc", "--wheel", "KNUCKLE"];
            arguments.extend(["--spin", "y", "--steer-axis", points[0], points[1]]);
            arguments.extend(["--radius", "300", "--json"]);
            let read = admire(&out, &arguments);
            said(&read, 0);
            let read: Value = serde_json::from_slice(&read.stdout).unwrap();
            let paths: Vec<&str> = read["columns"]
                .as_array()
                .unwrap()
                .iter()
                .map(|c| c["path"].as_str().unwrap())
                .collect();
            let at = |path: &str| paths.iter().position(|p| *p == path).unwrap();
            let steps = read["steps"].as_array().unwrap();
            let of = |step: &Value, path: &str| step["values"][at(path)].as_f64().unwrap();
            let (first, last) = (&steps[0], &steps[steps.len() / 2]);
            let turned = of(last, "caster_angle.left") - of(first, "caster_angle.left");
            assert!(turned.abs() > 1e-5, "{turned}");
            assert!(paths.contains(&"scrub_radius.left") && paths.contains(&"hub_lead.left"));
        }
        let centre = "-17.07941120175,-68.68083881118,-4.029403578004";
        let read = admire(
            &out,
            &[
                "results",
                &format!("{test}.res"),
                "--kc",
                "--wheel",
                "KNUCKLE",
                "--centre",
                centre,
                "--spin",
                "y",
                "--json",
            ],
        );
        said(&read, 0);
        let read: Value = serde_json::from_slice(&read.stdout).unwrap();
        for path in [
            // Only positions and the pitch since design are compared, because the axes of the part differ from those of the wheel.
            "side_view_angle.left",
            "wheel_travel_track.track_left",
            "wheel_travel.vertical_left",
            "wheel_travel_base.base_left",
        ] {
            let expected = values(&json, test, path);
            let columns = read["columns"].as_array().unwrap();
            let at = columns.iter().position(|c| c["path"] == path).unwrap();
            let steps = read["steps"].as_array().unwrap();
            assert_eq!(steps.len(), expected.len(), "{test}");
            for (step, expected) in steps.iter().zip(expected) {
                let value = step["values"][at].as_f64().unwrap();
                // The EQUILIBRIUM of the deck has a looser tolerance than the tests.
                assert!(
                    (value - expected).abs() < 2e-5,
                    "{test} {path}: {value} {expected}"
                );
            }
        }
    }
}

/// Checks that the results file of a test has the requests of Adams/Car, in which existing scripts find their columns.
#[test]
fn results_have_the_names_of_adams_car() {
    let folder = tempfile::tempdir().unwrap();
    let (deck, config) = (corpus("multilink/model.adm"), corpus("multilink/kc.toml"));
    said(
        &admire(
            folder.path(),
            &["kc", &deck, "--config", &config, "--out", "."],
        ),
        0,
    );
    let json: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("kc.json")).unwrap()).unwrap();
    let names = [
        "toe_angle.left",
        "wheel_rate.right",
        "roll_center_location.vertical",
        "lat_force_steer_compliance.left",
        "total_track.track",
        "wheel_load_vertical_force.vertical_left_force",
        "anti_dive_braking.left",
    ];
    for test in ["bounce", "roll", "lateral"] {
        let mut arguments = vec![
            "results".to_string(),
            format!("{test}.res"),
            "--plain".to_string(),
            "--get".to_string(),
        ];
        arguments.extend(names.map(str::to_string));
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = admire(folder.path(), &arguments);
        said(&output, 0);
        let text = String::from_utf8(output.stdout).unwrap();
        let mut lines = text.lines();
        let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|l| l.split(',').map(|c| c.parse().unwrap()).collect())
            .collect();
        for name in names {
            let at = heads.iter().position(|h| *h == name).unwrap();
            let expected = values(&json, test, name);
            assert_eq!(rows.len(), expected.len());
            for (row, expected) in rows.iter().zip(expected) {
                assert!(
                    (row[at] - expected).abs() <= 1e-9 * expected.abs().max(1e-12),
                    "{test} {name}"
                );
            }
        }
    }
}

/// Checks that vectors are rotated with the axes, and that quantities with a definition of their own are not.
#[test]
fn conventions_turn_vectors() {
    let folder = tempfile::tempdir().unwrap();
    let (deck, config) = (corpus("multilink/model.adm"), corpus("multilink/kc.toml"));
    let mut found = Vec::new();
    for convention in ["adams-car", "iso", "sae"] {
        let arguments = [
            "kc",
            &deck,
            "--config",
            &config,
            "--out",
            convention,
            "--convention",
            convention,
        ];
        said(&admire(folder.path(), &arguments), 0);
        let path = folder.path().join(convention).join("kc.json");
        let json: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        found.push(json);
    }
    for (path, iso, sae) in [
        ("toe_angle.left", 1.0, 1.0),
        ("camber_angle.right", 1.0, 1.0),
        ("steer_angle.left", -1.0, 1.0),
        ("inclination_angle.left", -1.0, -1.0),
        ("wheel_travel.vertical_left", 1.0, 1.0),
        ("wheel_travel_base.base_left", -1.0, -1.0),
        ("wheel_travel_track.track_left", -1.0, 1.0),
        ("wheelenv_output.wheel_ctr_z_left", 1.0, -1.0),
        ("ride_steer.left", -1.0, 1.0),
        ("wheel_rate.left", 1.0, 1.0),
        ("lat_force_steer_compliance.left", -1.0, -1.0),
    ] {
        let of = |k: usize| values(&found[k], "bounce", path);
        for ((a, i), s) in of(0).into_iter().zip(of(1)).zip(of(2)) {
            assert!(a != 0.0 || path.contains("travel"), "{path}");
            assert_eq!((iso * a, sae * a), (i, s), "{path}");
        }
    }
}

#[test]
fn wrong_files_are_refused_at_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let deck = corpus("pseudo-mcpherson/model.adm");
    let good = std::fs::read_to_string(corpus("pseudo-mcpherson/kc.toml")).unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("kc.toml"), text).unwrap();
    let run = || {
        admire(
            folder.path(),
            &["kc", &deck, "--out", "out", "--format", "plain"],
        )
    };
    for (from, to, place, why) in [
        ("\"WC\"", "\"WCX\"", "kc.toml:9", "WCX"),
        (
            "spin = \"y\"",
            "spin = \"z\"",
            "kc.toml:9",
            "does not lie across",
        ),
        (
            "left = {",
            "right = {",
            "kc.toml:9",
            "not on the right side",
        ),
        (
            "\"adams-car\"",
            "[\"forward\", \"right\", \"up\"]",
            "kc.toml:4",
            "right-handed",
        ),
        ("SFORCE/3", "SFORCE/33", "kc.toml:5", "SFORCE/33"),
        ("SFORCE/3\"", "KNUCKLE\"", "kc.toml:5", "cannot be left out"),
        ("radius = 300.0", "radius = -1.0", "kc.toml", "tyre.radius"),
        // Metres in a deck in millimetres, and percent.
        (
            "radius = 300.0",
            "radius = 0.3",
            "kc.toml:12",
            "tyre.radius",
        ),
        (
            "wheelbase = 2600.0",
            "wheelbase = 2.6",
            "kc.toml:16",
            "vehicle.wheelbase",
        ),
        (
            "front_brake = 0.65",
            "front_brake = 65",
            "kc.toml:19",
            "0 to 1",
        ),
        ("[ride]", "[tests.bonce]\n[ride]", "kc.toml", "bonce"),
        (
            "[ride]",
            "[tests.bounce]\nrange = [3, 1]\n[ride]",
            "kc.toml",
            "range",
        ),
        ("load = 4500.0", "lod = 4500.0", "kc.toml", "lod"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        write(&text);
        let errors = said(&run(), 1);
        assert!(
            errors.contains(place) && errors.contains(why),
            "{to}: {errors}"
        );
    }
    write(&(good.replace("mirror = true", "mirror = false") + "[tests.roll]\n"));
    assert!(said(&run(), 1).contains("needs two wheels"));
    // The radius is within its bounds, but not that of this axle.
    write(&good.replacen("radius = 300.0", "radius = 30.0", 1));
    let warned = said(&run(), 0);
    assert!(
        warned.contains("kc.toml:12") && warned.contains("times the track of"),
        "{warned}"
    );
    write(&good);
    assert!(!said(&run(), 0).contains("times the track of"));
    // A second run replaces its own files, and leaves the files of the user.
    said(&run(), 0);
    std::fs::write(folder.path().join("out/report.html"), "mine").unwrap();
    said(&run(), 1);
    // The load is out of reach.
    write(&(good + "[tests.lateral]\nrange = [-1e7, 1e7]\n"));
    let errors = said(
        &admire(
            folder.path(),
            &["kc", &deck, "--out", "far", "--format", "plain"],
        ),
        3,
    );
    assert!(errors.contains("test lateral"), "{errors}");
    assert!(!folder.path().join("far").exists());
}

/// Checks toe per lateral force: the terminal, the table and the page have degrees per kilonewton, kc.json of the same run has radians per
/// newton. A table of curves must be readable as a measurement.
#[test]
fn units_are_the_same_on_the_terminal_in_tables_and_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let (deck, config) = (corpus("multilink/model.adm"), corpus("multilink/kc.toml"));
    let arguments = ["kc", &deck, "--config", &config, "--out", "out"];
    let run = admire(folder.path(), &arguments);
    said(&run, 0);
    let terminal = String::from_utf8_lossy(&run.stdout).into_owned();
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let json: Value = serde_json::from_str(&read("kc.json")).unwrap();
    let mut tests = json["tests"].as_array().unwrap().iter();
    let lateral = tests.find(|test| test["test"] == "lateral").unwrap();
    let mut gradients = lateral["gradients"].as_array().unwrap().iter();
    let toe = gradients
        .find(|g| g["quantity"] == "toe_angle.left")
        .unwrap();
    let shown = toe["tangent"].as_f64().unwrap().to_degrees() * 1000.0;
    let gradients = read("gradients.csv");
    let mut table = csv::Reader::from_reader(gradients.as_bytes());
    let heads = table.headers().unwrap().clone();
    let at = |name: &str| heads.iter().position(|head| head == name).unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let row = rows
        .iter()
        .find(|row| &row[at("test")] == "lateral" && &row[at("quantity")] == "toe_angle.left")
        .unwrap();
    assert_eq!(&row[at("unit")], "deg/kN");
    let tangent: f64 = row[at("tangent")].parse().unwrap();
    assert!(
        (tangent - shown).abs() < 1e-9 * shown.abs(),
        "{tangent} {shown}"
    );
    assert_eq!(&row[at("hysteresis_unit")], "deg");
    let line = terminal
        .lines()
        .find(|line| line.trim().starts_with("lateral "))
        .unwrap();
    let words: Vec<&str> = line.split_whitespace().collect();
    let said: f64 = words[1].parse().unwrap();
    assert!((said - shown).abs() < 1e-4 * shown.abs(), "{line}");
    assert!(words.contains(&"deg/kN"), "{line}");
    assert!(!terminal.contains(" rad"), "{terminal}");
    assert!(read("report.html").contains("deg/kN"));
    let curves = read("curves.csv");
    let head = curves.lines().next().unwrap();
    assert!(
        head.contains("toe_angle.left [deg]") && !head.contains("[rad"),
        "{head}"
    );
    assert!(
        head.contains("lat_force_steer_compliance.left [deg/kN]"),
        "{head}"
    );
    let mut again = arguments.to_vec();
    again.extend(["--measured", "out/curves.csv"]);
    again[5] = "again";
    self::said(&admire(folder.path(), &again), 0);
    let page = std::fs::read_to_string(folder.path().join("again/report.html")).unwrap();
    assert!(page.contains("measured, fitted"), "curves of itself");
}

/// Checks that the report shows curves of another deck and of a measurement.
#[test]
fn the_report_compares() {
    let folder = tempfile::tempdir().unwrap();
    let config = corpus("pseudo-mcpherson/kc.toml");
    let (deck, other) = (
        corpus("pseudo-mcpherson/model.adm"),
        corpus("pseudo-mcpherson/reference.adm"),
    );
    let measured = "test;value;toe_angle.left [deg];camber_angle.left [deg]\nbounce;-10;0,02;\nbounce;0;0,01;0,03\nbounce;10;0,00;0,02\n";
    std::fs::write(folder.path().join("rig.csv"), measured).unwrap();
    let arguments = [
        "kc",
        &deck,
        "--config",
        &config,
        "--out",
        "out",
        "--compare",
        &other,
        "--measured",
        "rig.csv",
    ];
    said(&admire(folder.path(), &arguments), 0);
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("left measured") && page.contains("left reference"));
    // The slope of the three measured points, in degrees per metre.
    assert!(page.contains("-1.0000") && page.contains("deg/m"));
    assert!(!page.contains("NaN"));
}
