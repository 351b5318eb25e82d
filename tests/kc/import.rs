//! `admire import-kc`: tables of laboratories in several forms, and the commands that read the imported table.

use std::fmt::Write as _;
use std::path::Path;

use crate::run::{admire, corpus, said};

fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

/// One sample of the synthetic axle: travel, then toe and camber of the left and the right wheel, then lateral force on each wheel. In mm,
/// degrees and newtons, with the signs of the guide.
struct Sample {
    travel: [f64; 2],
    toe: [f64; 2],
    camber: [f64; 2],
    lateral: [f64; 2],
}

/// Returns the samples of a bounce loop or a roll loop, back and forth, with hysteresis in toe.
fn samples(test: &str) -> Vec<Sample> {
    let up = (-5..=5).map(|k| (f64::from(k) * 10.0, 0.002));
    let down = (-5..5).rev().map(|k| (f64::from(k) * 10.0, -0.002));
    let sign = if test == "roll" { -1.0 } else { 1.0 };
    up.chain(down)
        .map(|(z, width)| Sample {
            travel: [z, sign * z],
            toe: [0.1 - 0.003 * z + width, 0.12 - 0.0025 * sign * z + width],
            camber: [-0.5 - 0.01 * z, -0.45 - 0.012 * sign * z],
            lateral: [2.0 * z, 1.5 * z],
        })
        .collect()
}

/// Returns the table in the form of the guide: commas, degrees, millimetres, newtons, and the signs of the guide.
fn plain() -> String {
    let mut text = String::from(
        "Test,Travel left [mm],Travel right [mm],Toe left [deg],Toe right [deg],Camber left [deg],Camber right [deg],Fy left [N],Fy right [N]\n",
    );
    for test in ["bounce", "roll"] {
        for Sample {
            travel: [a, b],
            toe: [c, d],
            camber: [e, f],
            lateral: [g, h],
        } in samples(test)
        {
            writeln!(text, "{test},{a},{b},{c},{d},{e},{f},{g},{h}").unwrap();
        }
    }
    text
}

const PLAIN_MAP: &str = r#"
[columns]
"Test" = { is = "test" }
"Travel left" = { is = "wheel_travel", side = "left", positive = "up" }
"Travel right" = { is = "wheel_travel", side = "right", positive = "up" }
"Toe left" = { is = "toe_angle", side = "left", positive = "in" }
"Toe right" = { is = "toe_angle", side = "right", positive = "in" }
"Camber left" = { is = "camber_angle", side = "left", positive = "outboard" }
"Camber right" = { is = "camber_angle", side = "right", positive = "outboard" }
"Fy left" = { is = "lateral_force", side = "left", positive = "left" }
"Fy right" = { is = "lateral_force", side = "right", positive = "left" }
"#;

/// Returns the same samples by other conventions: UTF-16 with semicolons and decimal commas, title lines, a block for each test, and a row of
/// units. Toe is given as minutes of an angle to the right, and as millimetres over a rim with + outwards. Travel is positive downwards, camber
/// to the left, and forces are outboard in kN.
fn foreign() -> Vec<u8> {
    let mut text = String::from("Prüfstand 3;Achse hinten\r\nDatum;12.03.2026\r\n");
    for (test, title) in [("bounce", "Parallelhub"), ("roll", "Wanken 1")] {
        write!(
            text,
            "\r\nVersuch: {title}\r\nWeg VL;Weg VR;Spur VL;Spur VR;Sturz VL;Sturz VR;Fy VL;Fy VR;Temp\r\nmm;cm;min;mm;°;rad;kN;lbf;°C\r\n"
        )
        .unwrap();
        for Sample {
            travel,
            toe,
            camber,
            lateral,
        } in samples(test)
        {
            let cells = [
                -travel[0],
                -travel[1] / 10.0,
                toe[0] * 60.0,
                -toe[1].to_radians().sin() * 406.4,
                camber[0],
                -camber[1].to_radians(),
                lateral[0] / 1000.0,
                -lateral[1] / 4.448_221_615_260_5,
                21.5,
            ];
            let cells: Vec<String> = cells
                .iter()
                .map(|x| format!("{x}").replace('.', ","))
                .collect();
            write!(text, "{}\r\n", cells.join(";")).unwrap();
        }
    }
    let units = text.encode_utf16().flat_map(u16::to_le_bytes);
    [0xff, 0xfe].into_iter().chain(units).collect()
}

const FOREIGN_MAP: &str = r#"
[columns]
"Weg VL" = { is = "wheel_travel", side = "left", positive = "down" }
"Weg VR" = { is = "wheel_travel", side = "right", positive = "down" }
"Spur VL" = { is = "toe_angle", side = "left", positive = "right" }
"Spur VR" = { is = "toe_angle", side = "right", positive = "out", over_mm = 406.4 }
"Sturz VL" = { is = "camber_angle", side = "left", positive = "left" }
"Sturz VR" = { is = "camber_angle", side = "right", positive = "left" }
"Fy VL" = { is = "lateral_force", side = "left", positive = "outboard" }
"Fy VR" = { is = "lateral_force", side = "right", positive = "outboard" }
[tests]
"Wanken 1" = "roll"
"#;

/// Returns the columns of a table by heading, with unconverted words.
fn columns(text: &str) -> Vec<(String, Vec<String>)> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let heads = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let column = |k: usize| rows.iter().map(|row| row[k].to_string()).collect();
    heads
        .iter()
        .enumerate()
        .map(|(k, head)| (head.to_string(), column(k)))
        .collect()
}

#[track_caller]
fn same(a: &str, b: &str) {
    let (a, b) = (columns(a), columns(b));
    assert_eq!(a.len(), b.len());
    for ((head, x), (other, y)) in a.iter().zip(&b) {
        assert_eq!((head, x.len()), (other, y.len()));
        for (x, y) in x.iter().zip(y) {
            match (x.parse::<f64>(), y.parse::<f64>()) {
                (Ok(x), Ok(y)) => {
                    assert!((x - y).abs() < 1e-9 * (1.0 + x.abs()), "{head}: {x} {y}");
                }
                _ => assert_eq!(x, y, "{head}"),
            }
        }
    }
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Checks that a table by other conventions gives the curves of the plain table, and that the assumptions are reported column by column.
#[test]
fn other_conventions_give_the_same_curves() {
    let foreign = foreign();
    let folder = folder(&[
        ("plain.csv", plain().as_bytes()),
        ("plain.toml", PLAIN_MAP.as_bytes()),
        ("lab.txt", &foreign),
        ("lab.toml", FOREIGN_MAP.as_bytes()),
    ]);
    let at = folder.path();
    said(
        &admire(at, &["import-kc", "plain.csv", "--map", "plain.toml"]),
        0,
    );
    let run = admire(at, &["import-kc", "lab.txt", "--map", "lab.toml"]);
    said(&run, 0);
    let plain = read(at, "plain-kc.csv");
    same(&plain, &read(at, "lab-kc.csv"));
    // The values themselves are checked as well, not only their agreement.
    let all = columns(&plain);
    let column = |name: &str| -> Vec<f64> {
        let found = all.iter().find(|(head, _)| head == name);
        found
            .unwrap()
            .1
            .iter()
            .map(|x| x.parse().unwrap())
            .collect()
    };
    let wanted: Vec<f64> = ["bounce", "roll"]
        .iter()
        .flat_map(|test| samples(test))
        .map(|s| s.toe[1])
        .collect();
    for (x, y) in column("toe_angle.right [deg]").iter().zip(&wanted) {
        assert!((x - y).abs() < 1e-10, "{x} {y}");
    }
    let value = column("value");
    assert_eq!(
        (value.len(), value[0], value[21], value[31]),
        (42, -50.0, -50.0, 50.0)
    );
    // The report of the assumptions.
    let told = String::from_utf8_lossy(&run.stdout).into_owned();
    let line = |word: &str| {
        told.lines()
            .find(|line| line.trim_start().starts_with(word))
            .unwrap()
            .to_string()
    };
    let toe = line("Spur VR");
    for word in [
        "toe_angle",
        "mm over 406.4 mm",
        "+ out, sign changed",
        "right",
    ] {
        assert!(toe.contains(word), "{toe}");
    }
    assert!(line("columns left out").contains("Temp"));
    assert!(line("rows").contains("bounce 21, roll 21"), "{told}");
}

/// Checks that `admire kc --measured` reads the imported table: its slope is shown beside that of the deck.
#[test]
fn the_imported_table_stands_in_the_report() {
    let foreign = foreign();
    let folder = folder(&[
        ("lab.txt", &foreign),
        ("import-kc.toml", FOREIGN_MAP.as_bytes()),
    ]);
    let at = folder.path();
    // The mapping beside the file is found without an option.
    let told = said(&admire(at, &["import-kc", "lab.txt", "-o", "rig.csv"]), 0);
    assert!(told.contains("import-kc.toml"), "{told}");
    let (deck, config) = (corpus("multilink/model.adm"), corpus("multilink/kc.toml"));
    let arguments = [
        "kc",
        &deck,
        "--config",
        &config,
        "--out",
        "out",
        "--measured",
        "rig.csv",
    ];
    said(&admire(at, &arguments), 0);
    let page = read(at, "out/report.html");
    assert!(page.contains("left measured"));
    // Toe of the left wheel over bounce is -0.003 deg/mm, that is -3 deg/m, the mean of both branches.
    assert!(page.contains("-3.000"), "no slope of the measured toe");
}

/// Checks one file per side, with a common mapping whose words name no side: the rows of both files are joined.
#[test]
fn sides_in_separate_files_are_joined() {
    let side = |k: usize| {
        let mut text = String::from("z (mm)\tToe-in (deg)\n");
        for sample in samples("roll") {
            writeln!(text, "{}\t{}", sample.travel[k], sample.toe[k]).unwrap();
        }
        text
    };
    let map = "[columns]\nz = { is = \"wheel_travel\", positive = \"up\" }\n\"Toe-in\" = { is = \"toe_angle\", positive = \"in\" }\n";
    let (left, right) = (side(0), side(1));
    let folder = folder(&[
        ("l.txt", left.as_bytes()),
        ("r.txt", right.as_bytes()),
        ("map.toml", map.as_bytes()),
    ]);
    let at = folder.path();
    let arguments = [
        "import-kc",
        "l.txt",
        "r.txt",
        "--map",
        "map.toml",
        "--side",
        "left,right",
        "--test",
        "roll",
        "-o",
        "both.csv",
    ];
    said(&admire(at, &arguments), 0);
    let all = columns(&read(at, "both.csv"));
    let column = |name: &str| &all.iter().find(|(head, _)| head == name).unwrap().1;
    assert_eq!(column("value").len(), 21);
    // In a roll, the left wheel moves up, by half the difference of the travels.
    assert_eq!(column("value")[20], "-50");
    assert_eq!(column("wheel_travel.vertical_right [mm]")[20], "50");
    assert_eq!(column("toe_angle.left [deg]").len(), 21);
}

/// Checks that nothing unclear is guessed without a terminal. Messages have positions and show the lines to write, and standard output is the
/// mapping. With the missing entries filled in, it imports the file.
#[test]
fn what_is_unclear_is_asked_with_its_place() {
    let text = "Einfederung VL [mm];Spur VL [min];Sturz VL;Kraft [lb]\n-10;1,5;0,1;3\n0;0,5;0,2;4\n10;-0,5;0,3;5\n";
    // The shell creates an empty file before the command starts: `> import-kc.toml`.
    let folder = folder(&[("lab.csv", text.as_bytes()), ("import-kc.toml", b"")]);
    let at = folder.path();
    let run = admire(at, &["import-kc", "lab.csv"]);
    let errors = said(&run, 1);
    for word in [
        "unclear-column",
        "lab.csv:1:21",
        "positive: in, out, right, left",
        "unit: deg, min",
        "test = \"bounce\"",
    ] {
        assert!(errors.contains(word), "{word}: {errors}");
    }
    assert!(!at.join("lab-kc.csv").exists());
    let proposal = String::from_utf8(run.stdout).unwrap();
    // `Einfederung` means positive upwards. The unknown column is left out.
    assert!(
        proposal.contains("side = \"left\", positive = \"up\""),
        "{proposal}"
    );
    assert!(!proposal.contains("Kraft"), "{proposal}");
    let still_open = folder_file(at, "open.toml", &proposal);
    said(
        &admire(at, &["import-kc", "lab.csv", "--map", still_open]),
        1,
    );
    let filled = proposal
        .replace("test = \"?\"", "test = \"bounce\"")
        .replace(
            "unit = \"?\", positive = \"?\"",
            "unit = \"deg\", positive = \"inboard\"",
        )
        .replace("positive = \"?\"", "positive = \"out\"");
    assert!(!filled.contains("\"?\""), "{filled}");
    let filled = folder_file(at, "filled.toml", &filled);
    said(&admire(at, &["import-kc", "lab.csv", "--map", filled]), 0);
    let table = read(at, "lab-kc.csv");
    let last = table.lines().last().unwrap();
    // 10 mm upwards; 0.5 min of toe-in; 0.3 deg with the top inboard.
    assert_eq!(last, "3,bounce,10,mm,0.00833333333333,-0.3,10");
    // An existing file is replaced only on request.
    let errors = said(&admire(at, &["import-kc", "lab.csv", "--map", filled]), 1);
    assert!(errors.contains("--force"), "{errors}");
    said(
        &admire(at, &["import-kc", "lab.csv", "--map", filled, "--force"]),
        0,
    );
}

fn folder_file<'a>(folder: &Path, name: &'a str, text: &str) -> &'a str {
    std::fs::write(folder.join(name), text).unwrap();
    name
}

/// Checks that wrong input is refused with its position: a word among numbers, an ambiguous decimal mark, a missing column, a contradictory
/// unit.
#[test]
fn faults_have_places() {
    let map = "[file]\ntest = \"bounce\"\nside = \"left\"\n[columns]\nz = { is = \"wheel_travel\", positive = \"up\", unit = \"mm\" }\ntoe = { is = \"toe_angle\", positive = \"in\", unit = \"deg\" }\n";
    let cases = [
        (
            "z;toe\n1;2\n3;bad\n4;5\n",
            "lab.csv:3:3",
            "`bad` is not a number",
        ),
        ("z;toe\n1,5;2\n3;1.500\n4;5\n", "lab.csv:3:3", "decimal"),
        ("z;tow\n1;2\n3;4\n", "map.toml:6:1", "no column `toe`"),
        (
            "z [m];toe\n1;2\n3;4\n",
            "lab.csv:1:1",
            "the mapping states `mm`",
        ),
        (
            "z,toe\n1,5,2,5\n3,5,4,5\n",
            "lab.csv:2:1",
            "decimal commas need semicolons",
        ),
        ("nothing here\n", "lab.csv:1:1", "neither semicolons"),
    ];
    for (text, place, word) in cases {
        let folder = folder(&[("lab.csv", text.as_bytes()), ("map.toml", map.as_bytes())]);
        let errors = said(
            &admire(
                folder.path(),
                &["import-kc", "lab.csv", "--map", "map.toml"],
            ),
            1,
        );
        assert!(
            errors.contains(place) && errors.contains(word),
            "{text}: {errors}"
        );
        assert!(!folder.path().join("lab-kc.csv").exists());
    }
    let folder = folder(&[
        ("lab.csv", b"z;toe\n1;2\n3;4\n"),
        ("map.toml", map.as_bytes()),
    ]);
    let arguments = [
        "import-kc",
        "lab.csv",
        "--map",
        "map.toml",
        "--test",
        "bounse",
    ];
    said(&admire(folder.path(), &arguments), 2);
}

/// Checks an export sorted by travel, which mixes both branches: its time column restores the order of the measurement.
#[test]
fn time_restores_the_order_driven() {
    let mut rows: Vec<(f64, f64, f64)> = samples("bounce")
        .iter()
        .enumerate()
        .map(|(k, sample)| (sample.travel[0], sample.toe[0], k as f64 * 0.5))
        .collect();
    let driven: Vec<String> = rows.iter().map(|row| row.0.to_string()).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = String::from("Time [s],Jounce left [mm],Toe-in left [deg]\n");
    for (z, toe, time) in rows {
        writeln!(text, "{time},{z},{toe}").unwrap();
    }
    let folder = folder(&[("lab.csv", text.as_bytes())]);
    // The headings state everything except the test.
    let errors = said(
        &admire(folder.path(), &["import-kc", "lab.csv", "--test", "bounce"]),
        0,
    );
    assert!(errors.contains("sorted by time"), "{errors}");
    let all = columns(&read(folder.path(), "lab-kc.csv"));
    assert_eq!(
        all.iter().find(|(head, _)| head == "value").unwrap().1,
        driven
    );
}

/// Checks that the imported table serves as the file of a study's load cases and curves, with the lines that the command prints.
#[test]
fn a_study_reads_the_imported_table() {
    let shipped = std::fs::read_to_string(corpus("kc-curves/kc.csv")).unwrap();
    let mut lab = String::from("Radlast;Fy;Fx;Spur;Sturz;Laengs;Weg\nkN;N;N;min;deg;mm;mm\n");
    let mut reader = csv::Reader::from_reader(shipped.as_bytes());
    for record in reader.records() {
        let record = record.unwrap();
        let x = |k: usize| record[k].parse::<f64>().unwrap();
        let cells = [x(1) / 1000.0, -x(2), x(3), -x(4) * 60.0, x(5), x(8), -x(7)];
        let cells: Vec<String> = cells.iter().map(ToString::to_string).collect();
        writeln!(lab, "{}", cells.join(";")).unwrap();
    }
    let map = "[file]\ntest = \"bounce\"\nside = \"left\"\n[columns]\nRadlast = { load = \"Fz\", load_sign = \"+\" }\nFy = { load = \"Fy\", load_sign = \"-\" }\nFx = { load = \"Fx\", load_sign = \"+\" }\nSpur = { is = \"toe_angle\", positive = \"out\" }\nSturz = { is = \"camber_angle\", positive = \"outboard\" }\nLaengs = { is = \"wheel_travel_base\", positive = \"rearward\" }\nWeg = { is = \"wheel_travel\", positive = \"down\" }\n";
    let study = std::fs::read_to_string(corpus("kc-curves/study.toml")).unwrap();
    let model = std::fs::read(corpus("kc-curves/model.adm")).unwrap();
    let folder = folder(&[
        ("lab.csv", lab.as_bytes()),
        ("map.toml", map.as_bytes()),
        ("model.adm", &model),
        ("study.toml", study.as_bytes()),
        ("kc.csv", shipped.as_bytes()),
    ]);
    let at = folder.path();
    let run = admire(at, &["import-kc", "lab.csv", "--map", "map.toml"]);
    said(&run, 0);
    let told = String::from_utf8_lossy(&run.stdout).into_owned();
    let lines: Vec<&str> = told.lines().skip_while(|line| *line != "[loads]").collect();
    let toml = lines
        .join("\n")
        .replace("\"Fz [N]\" = \"?\"", "\"Fz [N]\" = \"SFORCE/3\"")
        .replace("\"Fy [N]\" = \"?\"", "\"Fy [N]\" = \"SFORCE/2\"")
        .replace("\"Fx [N]\" = \"?\"", "\"Fx [N]\" = \"SFORCE/1\"")
        .replace("[kc.curves]", "marker = \"MARKER/20\"\naxis = \"y\"\nforward = \"-x\"\nrelative_to = \"1\"\n[kc.curves]");
    let head = "[model]\ndeck = \"model.adm\"\n";
    let tail = "[identify]\nbushings = [\"BUSHING/1\", \"BUSHING/2\"]\ninitial = \"deck\"\n";
    std::fs::write(at.join("study.toml"), format!("{head}{toml}\n{tail}")).unwrap();
    let read = admire_study::Study::read(at);
    let own = read
        .value
        .unwrap_or_else(|| panic!("{:?}", read.diagnostics));
    let original = admire_study::Study::read(Path::new(&corpus("kc-curves")))
        .value
        .unwrap();
    let deck = admire_syntax::Dataset::parse(admire_syntax::text::Source::new("model.adm", model));
    let lowered = admire_solver::model::Model::lower(&deck.value).value;
    let values = |study: &admire_study::Study, name: &str| -> Vec<f64> {
        let measured = admire_study::Measurement::resolve(study, &lowered).value;
        let at = measured
            .channels
            .iter()
            .position(|channel| channel.name == name)
            .unwrap();
        measured
            .cases
            .iter()
            .map(|case| case.channels[at].unwrap())
            .collect()
    };
    for name in ["toe", "camber", "travel", "base"] {
        let (a, b) = (values(&own, name), values(&original, name));
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(&b) {
            assert!((x - y).abs() < 1e-9, "{name}: {x} {y}");
        }
    }
    // Loads are compared by name, because the table has them in another order.
    let loads = |study: &admire_study::Study, name: &str| -> Vec<f64> {
        let at = study.columns.iter().position(|(own, _)| own.text == name);
        let measured = admire_study::Measurement::resolve(study, &lowered).value;
        let cases = measured.cases.iter();
        cases.map(|case| case.loads[at.unwrap()]).collect()
    };
    for name in ["Fx [N]", "Fy [N]", "Fz [N]"] {
        assert_eq!(loads(&own, name), loads(&original, name), "{name}");
    }
}

/// Checks that the sheets of a workbook are tests by their names, and that a message states the row of the sheet.
#[test]
fn sheets_of_a_workbook_are_tests() {
    let book = std::fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/kc/two_tests.xlsx"
    ));
    let folder = folder(&[("rig.xlsx", &book.unwrap())]);
    let at = folder.path();
    let run = admire(at, &["import-kc", "rig.xlsx"]);
    let errors = said(&run, 1);
    // The heading does not state the direction of the lateral force, and its test may be one of three.
    assert!(
        errors.contains("rig.xlsx[Seitenkraft gleich]:3:1"),
        "{errors}"
    );
    let proposal = String::from_utf8(run.stdout).unwrap();
    let filled = proposal
        .replace(
            "\"Seitenkraft gleich\" = \"?\"",
            "\"Seitenkraft gleich\" = \"lateral\"",
        )
        .replace("positive = \"?\"", "positive = \"right\"");
    std::fs::write(at.join("import-kc.toml"), filled).unwrap();
    said(&admire(at, &["import-kc", "rig.xlsx"]), 0);
    let table = read(at, "rig-kc.csv");
    // A mapping may name the only sheet to read.
    let only = |sheet: &str| {
        let all = read(at, "import-kc.toml");
        let map = format!(
            "[file]\nsheet = \"{sheet}\"\n{}",
            &all[all.find("[columns]").unwrap()..]
        );
        std::fs::write(at.join("one.toml"), map).unwrap();
        admire(
            at,
            &[
                "import-kc",
                "rig.xlsx",
                "--map",
                "one.toml",
                "-o",
                "one.csv",
            ],
        )
    };
    let errors = said(&only("Paralelhub"), 1);
    assert!(errors.contains("did you mean `Parallelhub`?"), "{errors}");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "case,test,value,value_unit,toe_angle.left [deg],wheel_travel.vertical_left [mm],wheel_load_lateral.lateral_left [N]"
    );
    assert_eq!(lines[1], "1,bounce,-20,mm,0.2,-20,");
    // A force of 1.5 kN to the right drives the test; the column is positive to the left.
    assert_eq!(lines[6], "6,lateral,1500,N,0.075,,-1500");
}
