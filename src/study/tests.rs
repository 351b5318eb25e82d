//! Tests of the checks of readings: each kind of fault is planted in the study that is shipped with the program.

use std::path::Path;

use super::{Measurement, Study, foreign_marks};
use admire_solver::mechanics::{Mat3, Pose, Vec3};
use admire_solver::model::{Header, Marker, Model, Orientation, Part, PartIx, PartKind};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

/// Returns a minimal model that contains ground, the parts with marks, and a marker at each mark.
fn model(on_parts: &str) -> Model {
    let mut model = Model::default();
    let mut names = vec!["GROUND"];
    for line in on_parts.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        if !names.contains(&cells[0]) {
            names.push(cells[0]);
        }
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        model.markers.push(Marker {
            header: Header::default(),
            part: PartIx(names.iter().position(|name| *name == cells[0]).unwrap()),
            qp: Vec3::new(number(2), number(3), number(4)),
            orientation: Orientation::Points,
            R: Mat3::identity(),
            floating: false,
            relative: None,
        });
    }
    for (at, name) in names.iter().enumerate() {
        model.parts.push(Part {
            header: Header {
                id: at as u32 + 1,
                name: (*name).to_string(),
                ..Header::default()
            },
            kind: if at == 0 {
                PartKind::Ground
            } else {
                PartKind::Rigid
            },
            mass: 0.0,
            cm: None,
            ip: [0.0; 6],
            pose: Pose::identity(),
            exact: [false; 6],
            start: admire_solver::model::InitialVelocity::default(),
        });
    }
    model
}

/// Reads the shipped study with one of its files changed.
fn study(file: &str, change: impl Fn(&str) -> String) -> (Measurement, Vec<Diagnostic>) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpus/pseudo-mcpherson");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_string();
        let mut text = std::fs::read_to_string(&path).unwrap();
        if name == file {
            text = change(&text);
        }
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let on_parts = std::fs::read_to_string(shipped.join("marks_on_parts.csv")).unwrap();
    let checked = Study::read(folder.path());
    let mut diagnostics = checked.diagnostics;
    let study = checked.value.unwrap();
    let measured = Measurement::resolve(&study, &model(&on_parts));
    diagnostics.extend(measured.diagnostics);
    (measured.value, diagnostics)
}

fn as_shipped() -> Measurement {
    study("", str::to_string).0
}

/// Checks that there is exactly one diagnostic with this code, and returns its severity and message.
fn only(diagnostics: &[Diagnostic], code: Code) -> (Severity, &str) {
    let found: Vec<&Diagnostic> = diagnostics.iter().filter(|d| d.code == code).collect();
    assert_eq!(found.len(), 1, "{code} in {diagnostics:#?}");
    assert!(!found[0].labels.is_empty(), "{code} has no place");
    (found[0].severity, &found[0].message)
}

/// Multiplies the last three columns by `factor` in all lines that start with `prefix`.
fn scaled(text: &str, prefix: &str, factor: f64) -> String {
    let line = |line: &str| {
        if !line.starts_with(prefix) || line.contains("mark") {
            return line.to_string();
        }
        let cells: Vec<&str> = line.split(',').collect();
        let (labels, numbers) = cells.split_at(cells.len() - 3);
        let numbers = numbers
            .iter()
            .map(|x| format!("{:.12}", x.parse::<f64>().unwrap() * factor));
        labels
            .iter()
            .map(ToString::to_string)
            .chain(numbers)
            .collect::<Vec<_>>()
            .join(",")
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_shipped_study_is_clean() {
    let (measured, diagnostics) = study("", str::to_string);
    assert!(diagnostics.is_empty(), "{diagnostics:#?}");
    assert_eq!((measured.cases.len(), measured.parts.len()), (13, 5));
    assert!(measured.cases.iter().all(|case| case.marks.len() == 20));
    assert_eq!(measured.cases[5].loads, [4500.0, -4000.0, 0.0]);
    let poses = measured.poses(
        0,
        &model(include_str!(
            "../../corpus/pseudo-mcpherson/marks_on_parts.csv"
        )),
    );
    // The pose of KNUCKLE must agree with the reference equilibrium, within the noise of its origin.
    let knuckle = poses[3].as_ref().unwrap();
    assert!((knuckle.pose.p - Vec3::new(2.165960, -685.397962, 256.535840)).norm() < 0.2);
}

#[test]
fn noise_is_estimated_when_not_given() {
    let (measured, _) = study("study.toml", |text| text.replace("sigma = 0.05", ""));
    assert!(measured.sigma_estimated);
    // Five parts with four marks in 13 cases give 360 degrees of freedom, so the relative standard error of sigma is 3.7 percent.
    assert!(
        (measured.sigma / 0.05 - 1.0).abs() < 0.12,
        "{}",
        measured.sigma
    );
}

#[test]
fn metres_are_millimetres_again() {
    let change = |text: &str| scaled(text, "", 1e-3);
    let (measured, diagnostics) = study("marks_measured.csv", change);
    let (severity, message) = only(&diagnostics, Code::WrongUnits);
    assert_eq!(severity, Severity::Warning);
    assert!(
        message.contains("all measured marks seem to be in metres"),
        "{message}"
    );
    let difference = measured.cases[3].marks[7].x - as_shipped().cases[3].marks[7].x;
    assert!(difference.norm() < 1e-6);

    let (_, diagnostics) = study("marks_measured.csv", |text| scaled(text, "4,", 1e-3));
    assert!(only(&diagnostics, Code::WrongUnits).1.contains("in case 4"));

    let (measured, diagnostics) = study("marks_on_parts.csv", change);
    assert!(
        only(&diagnostics, Code::WrongUnits)
            .1
            .contains("listed on FRONT_ARM seem to be in metres")
    );
    assert!((measured.parts[0].marks[0].p - as_shipped().parts[0].marks[0].p).norm() < 1e-6);
}

#[test]
fn swapped_marks_are_put_right() {
    let swap = |text: &str, before: &str| {
        let mark = |k: u8| format!("\n{before}KNUCKLE,{k},");
        text.replace(&mark(1), "swap")
            .replace(&mark(2), &mark(1))
            .replace("swap", &mark(2))
    };
    let (measured, diagnostics) = study("marks_measured.csv", |text| swap(text, "7,"));
    let (severity, message) = only(&diagnostics, Code::SwappedMarks);
    assert_eq!(severity, Severity::Warning);
    assert!(
        message.contains("marks 1 and 2 of KNUCKLE are swapped in case 7"),
        "{message}"
    );
    for (a, b) in measured.cases[6]
        .marks
        .iter()
        .zip(&as_shipped().cases[6].marks)
    {
        assert_eq!((a.part, a.mark, a.x), (b.part, b.mark, b.x));
    }
    let (_, diagnostics) = study("marks_on_parts.csv", |text| swap(text, ""));
    assert!(
        only(&diagnostics, Code::SwappedMarks)
            .1
            .contains("in every case")
    );
}

/// The readings of two parts are exchanged from case 8 on. Both parts must be reported.
#[test]
fn marks_of_another_part_are_told_from_a_wrong_reading() {
    let exchange = |text: &str| {
        let lines = text.lines().map(|line| {
            let case = line.split(',').next().and_then(|case| case.parse().ok());
            let later = case.is_some_and(|case: u32| case >= 8);
            match line.split(',').nth(1) {
                Some("KNUCKLE") if later => line.replace("KNUCKLE", "ROD"),
                Some("ROD") if later => line.replace("ROD", "KNUCKLE"),
                _ => line.to_string(),
            }
        });
        lines.map(|line| line + "\n").collect()
    };
    let (measured, _) = study("marks_measured.csv", exchange);
    let foreign = foreign_marks(&measured);
    let names: Vec<&str> = foreign
        .iter()
        .map(|foreign| measured.parts[foreign.part].name.as_str())
        .collect();
    assert_eq!(names, ["KNUCKLE", "ROD"]);
    for foreign in &foreign {
        assert_eq!(foreign.cases, (7..measured.cases.len()).collect::<Vec<_>>());
        assert!(foreign.rms > 10.0, "{foreign:?}");
    }
    assert_eq!(foreign_marks(&as_shipped()), []);
    let (wrong, _) = study("marks_measured.csv", |text| {
        let at = text.find("\n9,REAR_ARM,3,").unwrap() + "\n9,REAR_ARM,3,".len();
        format!("{}9{}", &text[..at], &text[at..])
    });
    assert_eq!(foreign_marks(&wrong), []);
}

#[test]
fn a_wrong_reading_is_named_and_kept() {
    let (measured, diagnostics) = study("marks_measured.csv", |text| {
        let at = text.find("\n9,REAR_ARM,3,").unwrap() + "\n9,REAR_ARM,3,".len();
        format!("{}9{}", &text[..at], &text[at..])
    });
    let (severity, message) = only(&diagnostics, Code::InconsistentMarks);
    assert_eq!(severity, Severity::Warning);
    assert!(message.contains("REAR_ARM in case 9"), "{message}");
    assert_eq!(measured.cases[8].marks.len(), 20);
}

#[test]
fn missing_marks_nan_and_unknown_names() {
    let (measured, diagnostics) = study("marks_measured.csv", |text| {
        let kept = text
            .lines()
            .filter(|l| !l.starts_with("3,ROD,2") && !l.starts_with("3,ROD,3"));
        kept.collect::<Vec<_>>().join("\n")
    });
    let (severity, message) = only(&diagnostics, Code::MissingMarks);
    assert_eq!(severity, Severity::Warning);
    assert!(
        message.contains("ROD has fewer than three marks in case 3"),
        "{message}"
    );
    assert_eq!(measured.cases[2].marks.len(), 18);

    let (measured, diagnostics) = study("marks_measured.csv", |text| {
        let at = text.find("\n2,TIE_ROD,4,").unwrap() + "\n2,TIE_ROD,4,".len();
        let end = at + text[at..].find(',').unwrap();
        format!("{}NaN{}", &text[..at], &text[end..])
    });
    assert!(only(&diagnostics, Code::BadReading).1.contains("`NaN`"));
    assert_eq!(measured.cases[1].marks.len(), 19);

    let change = |text: &str| text.replace("KNUCKLE", "KNUCKEL");
    let (_, diagnostics) = study("marks_measured.csv", change);
    let (severity, message) = only(&diagnostics, Code::UnknownPart);
    assert_eq!(severity, Severity::Error);
    assert!(message.contains("`KNUCKEL` (in 52 places)"), "{message}");
    let unknown = diagnostics
        .iter()
        .find(|d| d.code == Code::UnknownPart)
        .unwrap();
    assert_eq!(unknown.help.as_deref(), Some("did you mean `KNUCKLE`?"));

    let (_, diagnostics) = study("load_cases.csv", |text| text.replace("\n5,", "\n50,"));
    assert!(
        only(&diagnostics, Code::UnknownCase)
            .1
            .contains("no load case `5`")
    );
}

#[test]
fn duplicated_cases() {
    let (measured, diagnostics) = study("load_cases.csv", |text| {
        text.to_string() + "13,4500,0,4000\n"
    });
    assert_eq!(only(&diagnostics, Code::DuplicateCase).0, Severity::Warning);
    assert_eq!(measured.cases.len(), 13);
    let (_, diagnostics) = study("load_cases.csv", |text| {
        text.to_string() + "13,4500,0,1000\n"
    });
    assert_eq!(only(&diagnostics, Code::DuplicateCase).0, Severity::Error);
    // The readings of case 12 appear a second time as case 13.
    let (measured, diagnostics) = study("marks_measured.csv", |text| {
        let kept: Vec<&str> = text
            .lines()
            .filter(|line| !line.starts_with("13,"))
            .collect();
        let copies: Vec<String> = kept
            .iter()
            .filter_map(|line| line.strip_prefix("12,"))
            .map(|rest| format!("13,{rest}"))
            .collect();
        kept.join("\n") + "\n" + &copies.join("\n")
    });
    let (severity, message) = only(&diagnostics, Code::DuplicateCase);
    assert_eq!(severity, Severity::Warning);
    assert!(message.contains("cases 12 and 13 are copies"), "{message}");
    assert!(measured.cases[11].marks.is_empty() && measured.cases[12].marks.is_empty());
}

#[test]
fn collinear_marks() {
    let (measured, diagnostics) = study("marks_on_parts.csv", |text| {
        let line = |line: &str| match line.strip_prefix("TIE_ROD,") {
            Some(rest) => {
                let mark: f64 = rest.split(',').next().unwrap().parse().unwrap();
                format!("TIE_ROD,{mark},{},5,5", 50.0 * mark)
            }
            None => line.to_string(),
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    });
    let (severity, message) = only(&diagnostics, Code::CollinearMarks);
    assert_eq!(severity, Severity::Warning);
    assert!(message.contains("TIE_ROD lie on one line"), "{message}");
    assert!(measured.orientation(0, 4).is_err());
}
