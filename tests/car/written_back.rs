//! Results of `identify` and `diagnose`, written back with the terms of Adams/Car.

use std::path::Path;

use admire_car::{BushingProperty, Side, Subsystem, diff};
use admire_syntax::diff::{DiffKind, DiffTolerance};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::Source;
use admire_syntax::units::Units;

use crate::toolkit::{admire, corpus};

const CAR: &str = "[car]\nsubsystem = \"front.sub\"\n";
const BUSHINGS: &str = "[car.bushings]\n\"BUSHING/1\" = \"bkl_arm_rear\"\n\"BUSHING/2\" = \"bkl_arm_front\"\n\"BUSHING/3\" = \"bkl_top_mount\"\n";

/// Copies a shipped study with its subsystem, and adds a text to `study.toml`.
fn study(added: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(corpus("pseudo-mcpherson")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let sub = corpus("adams-car/front.sub");
    std::fs::copy(sub, folder.path().join("front.sub")).unwrap();
    let toml = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    std::fs::write(&toml, format!("{text}\n{added}")).unwrap();
    folder
}

fn parse(path: &Path) -> PropertyFile {
    let bytes = std::fs::read(path).unwrap();
    PropertyFile::parse(Source::new(path.display().to_string(), bytes)).value
}

fn changes(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).expect("JSON")
}

#[test]
fn check_says_what_the_deck_and_the_subsystem_share() {
    let folder = study(&format!("{CAR}{BUSHINGS}"));
    let (code, out, errors) = admire(folder.path(), &["check", ".", "--format", "plain"]);
    let said = out + &errors;
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains("9 of 10 hardpoints and 3 of 6 bushings of the subsystem are in the deck"),
        "{said}"
    );
    // With the coordinates taken as metres, no hardpoint coincides with a marker.
    let sub = folder.path().join("front.sub");
    let text = std::fs::read_to_string(&sub).unwrap();
    std::fs::write(&sub, text.replace("LENGTH  =  'mm'", "LENGTH  =  'meter'")).unwrap();
    let (_, out, errors) = admire(folder.path(), &["check", ".", "--format", "plain"]);
    let said = out + &errors;
    assert!(
        said.contains("warning[car-subsystem]: 0 of 10 hardpoints"),
        "{said}"
    );
}

/// Checks that a study measured by the virtual rig has all the files that it names.
#[test]
fn a_measured_study_keeps_its_subsystem() {
    let folder = study(&format!("{CAR}{BUSHINGS}"));
    let (code, _, errors) = admire(folder.path(), &["rig", ".", "--out", "measured"]);
    assert_eq!(code, 0, "{errors}");
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("measured/front.sub"), read("front.sub"));
    let (code, out, errors) = admire(folder.path(), &["check", "measured", "--format", "plain"]);
    assert_eq!(code, 0, "{out}{errors}");
}

#[test]
fn names_that_exist_nowhere_are_refused_at_their_place() {
    for (added, says) in [
        ("[car]\n", "a study needs `car.subsystem`"),
        (
            "[car]\nsubsystem = \"other.sub\"\n",
            "`other.sub` cannot be read",
        ),
        (
            "[car]\nsubsystem = \"../front.sub\"\n",
            "outside of the study folder",
        ),
        (
            "[car]\nsubsystm = \"front.sub\"\n",
            "`car.subsystm` is not a key",
        ),
        (
            "[car]\nsubsystem = \"front.sub\"\n[car.bushings]\n\"BUSHING/9\" = \"bkl_arm_rear\"\n",
            "the deck has no bushing `BUSHING/9`",
        ),
        (
            "[car]\nsubsystem = \"front.sub\"\n[car.bushings]\n\"BUSHING/1\" = \"bkl_arm\"\n",
            "the subsystem has no bushing `bkl_arm`",
        ),
        (
            "[car]\nsubsystem = \"front.sub\"\n[car.hardpoints]\n\"MARKER/7\" = \"arm\"\n",
            "the subsystem has no hardpoint `arm`",
        ),
    ] {
        let folder = study(added);
        let words = ["identify", ".", "--out", "out", "--format", "plain"];
        let (code, out, errors) = admire(folder.path(), &words);
        let said = out + &errors;
        assert_eq!(code, 1, "{added}: {said}");
        assert!(said.contains(says), "{added}: {said}");
        assert!(!folder.path().join("out").exists());
    }
}

/// Checks the scale factors. The deck has 10000 N/mm for every stiffness, so each factor is the ratio of the identified stiffness to this value.
/// Expected values come from `identified.adm`.
#[test]
fn identified_stiffnesses_are_scale_factors_of_the_subsystem() {
    let folder = study(&format!("{CAR}{BUSHINGS}"));
    let here = folder.path();
    let before = std::fs::read(here.join("front.sub")).unwrap();
    let words = ["identify", ".", "--method", "direct", "--out", "out", "-v"];
    let (code, out, errors) = admire(here, &words);
    assert_eq!(code, 0, "{errors}");
    assert!(errors.contains("fx_scaling_factor"), "{errors}");
    assert!(out.contains("\nfor Adams/Car: out/adams_car\n"), "{out}");
    // The user's own file is unchanged.
    assert!(std::fs::read(here.join("front.sub")).unwrap() == before);
    let new = parse(&here.join("out/adams_car/front.sub"));
    let found = diff(
        &parse(&here.join("front.sub")),
        &new,
        DiffTolerance::default(),
    );
    assert_eq!(found.len(), 12, "{found:#?}");
    let identified = |address: &str| -> f64 {
        let (_, out, _) = admire(here, &["get", "out/identified.adm", address]);
        out.trim().parse().expect("a number")
    };
    for (usage, id) in [("arm_rear", 1), ("arm_front", 2)] {
        for (key, address, old) in [
            ("FX", format!("BUSHING/{id}.K.1"), 1e4),
            ("FZ", format!("BUSHING/{id}.K.3"), 1e4),
            ("TY", format!("BUSHING/{id}.KT.2"), 572_957.795_130_8),
        ] {
            let value = new
                .blocks
                .iter()
                .filter(|block| block.name == "BUSHING_ASSEMBLY")
                .find(|block| {
                    let own = block.parameter("USAGE").expect("USAGE");
                    own.text(new.source()) == usage
                })
                .and_then(|block| block.parameter(&format!("{key}_SCALING_FACTOR"))?.number())
                .expect("a factor");
            let expected = identified(&address) / old;
            assert!(
                (value / expected - 1.0).abs() < 1e-9,
                "{usage} {key}: {value} {expected}"
            );
        }
    }
    let list = changes(&here.join("out/adams_car/changes.json"));
    let first = &list["changes"][0];
    assert_eq!(first["element"], "bushing arm_rear");
    assert_eq!(first["factor"], "fx_scaling_factor");
    assert_eq!(first["symmetry"], "left/right");
    assert!(first["std_error"].as_f64().expect("a number") > 0.0);
    assert_eq!(list["not_written"].as_array().map(Vec::len), Some(0));
    // A second run replaces its own files; a file of the user is not replaced.
    assert_eq!(admire(here, &words).0, 0);
    std::fs::write(here.join("out/adams_car/front.sub"), "mine").unwrap();
    let (code, _, errors) = admire(here, &words);
    assert_eq!(code, 1, "{errors}");
    assert_eq!(
        std::fs::read(here.join("out/adams_car/front.sub")).unwrap(),
        b"mine"
    );
}

/// An arm on two bushings with a spring. The names are those of Adams/Car.
const ARM: &str = "An arm on two bushings that share an axis
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/2, PART = 1, QP = 150, 0, 0, REULER = 90D, 90D, 0D
MARKER/4, PART = 1, QP = -170, 20, 10, REULER = 90D, 90D, 0D
MARKER/18, PART = 1, QP = 10, -250, 400
MARKER/46, PART = 1, REULER = 90D, 90D, 0D
MARKER/47, PART = 1, REULER = 180D, 90D, 180D
MARKER/48, PART = 1
PART/2, MASS = 3, CM = 41, IP = 1E4, 1E4, 1E4
MARKER/1, PART = 2, QP = 150, 0, 0, REULER = 90D, 90D, 0D
MARKER/3, PART = 2, QP = -170, 20, 10, REULER = 90D, 90D, 0D
MARKER/17, PART = 2, QP = 10, -250, 0
MARKER/19, PART = 2, QP = 0, -380, -20
MARKER/41, PART = 2, QP = 0, -180, 0
! adams_view_name='.axle.front.bkl_arm_front.field'
BUSHING/1, I = 1, J = 2, C = 0, 0, 0, K = 9000, 9000, 1200, CT = 0, 0, 0, KT = 6E5, 6E5, 2E5
! adams_view_name='.axle.front.bkl_arm_rear.field'
BUSHING/2, I = 3, J = 4, C = 0, 0, 0, K = 6000, 6000, 900, CT = 0, 0, 0, KT = 6E5, 6E5, 2E5
SPRINGDAMPER/1, TRANSLATION, I = 17, J = 18, C = 0, K = 60, FORCE = 3000, LENGTH = 400
SFORCE/1, TRANSLATIONAL, I = 19, J = 46, ACTIONONLY, FUNCTION = 0
SFORCE/2, TRANSLATIONAL, I = 19, J = 47, ACTIONONLY, FUNCTION = 0
SFORCE/3, TRANSLATIONAL, I = 19, J = 48, ACTIONONLY, FUNCTION = 2000
ACCGRAV/KGRAV = -9806.65
END
";

/// The same points in metres.
const ARM_SUB: &str = "[MDI_HEADER]\r\n FILE_TYPE  =  'sub'\r\n[UNITS]\r\n LENGTH  =  'meter'\r\n FORCE  =  'newton'\r\n ANGLE  =  'deg'\r\n\
    [HARDPOINT]\r\n{hardpoint_name  symmetry  x_value  y_value  z_value}\r\n\
    \x20'arm_front   '  'single    '   0.15   0.0   0.0\r\n 'arm_rear    '  'single    '   -0.17   0.02   0.01\r\n\
    \x20'spring_lower'  'left/right'   0.01   -0.25   0.0  $ on the arm\r\n 'spring_upper'  'left/right'   0.01   -0.25   0.4\r\n\
    [BUSHING_ASSEMBLY]\r\n USAGE              =  'arm_front'\r\n SYMMETRY           =  'left/right'\r\n\
    \x20PROPERTY_FILE      =  'mdids://car/bushings.tbl/front.bus'\r\n FX_SCALING_FACTOR  =  2.0\r\n\
    [BUSHING_ASSEMBLY]\r\n USAGE              =  'arm_rear'\r\n SYMMETRY           =  'left/right'\r\n\
    \x20PROPERTY_FILE      =  'mdids://car/bushings.tbl/rear.bus'\r\n FX_SCALING_FACTOR  =  1.0\r\n";

const ARM_STUDY: &str = "[model]\ndeck = \"model.adm\"\n[loads]\nfile = \"load_cases.csv\"\n\
    columns = { vertical = \"SFORCE/3\", lateral = \"SFORCE/2\", longitudinal = \"SFORCE/1\" }\n\
    [marks]\non_parts = \"marks_on_parts.csv\"\nmeasured = \"marks_measured.csv\"\nsigma = 0.02\n\
    [identify]\nbushings = [\"BUSHING/1\", \"BUSHING/2\"]\n[car]\nsubsystem = \"front.sub\"\n";

const ARM_MARKS: &str = "part,mark,x,y,z\nPART/2,1,100,-50,20\nPART/2,2,-120,-60,10\nPART/2,3,20,-300,30\nPART/2,4,-30,-340,-20\n";

/// Measures the arm with planted effects on the virtual rig, and diagnoses it. Returns the folder of the study, with the results in `out`.
fn diagnosed(effects: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let levels = [1.0, 2.0, 3.0, -1.0, -2.0, -3.0];
    let vertical = [1.5, 2.5, 3.5, 2.0].map(|v| [v, 0.0, 0.0]);
    let lateral = levels.map(|l| [2.0, l, 0.0]);
    let longitudinal = levels.map(|l| [2.0, 0.0, l]);
    let both = [1.5, -1.5, 2.5, -2.5].map(|l| [2.5, l, -l]);
    let loads: Vec<[f64; 3]> = [&vertical[..], &lateral, &longitudinal, &both].concat();
    let (mut cases, mut marks) = (
        "case,vertical,lateral,longitudinal\n".to_string(),
        "case,part,mark,x,y,z\n".to_string(),
    );
    for (k, load) in (1..).zip(loads) {
        let [v, l, b] = load.map(|kilonewton| 1000.0 * kilonewton);
        cases += &format!("{k},{v},{l},{b}\n");
        for mark in 1..=4 {
            marks += &format!("{k},PART/2,{mark},0,0,0\n");
        }
    }
    for (name, text) in [
        ("model.adm", ARM),
        ("study.toml", ARM_STUDY),
        ("front.sub", ARM_SUB),
        ("marks_on_parts.csv", ARM_MARKS),
        ("load_cases.csv", &cases),
        ("marks_measured.csv", &marks),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut words = vec!["rig", ".", "--out", "measured", "--seed", "1"];
    words.extend(effects.iter().flat_map(|effect| ["--effect", effect]));
    let (code, _, errors) = admire(folder.path(), &words);
    assert_eq!(code, 0, "{errors}");
    std::fs::write(folder.path().join("measured/front.sub"), ARM_SUB).unwrap();
    let toml = folder.path().join("measured/study.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    if !text.contains("[car]") {
        std::fs::write(&toml, format!("{text}\n{CAR}")).unwrap();
    }
    let words = [
        "diagnose",
        "measured",
        "--out",
        "out",
        "--check-gain",
        "quick",
    ];
    let (code, _, errors) = admire(folder.path(), &words);
    assert_eq!(code, 0, "{errors}");
    folder
}

/// Checks a front bushing that stiffens across its axis. The `.bus` file must hold the fitted law, and the subsystem must name this file.
#[test]
fn a_learned_curve_is_a_property_file_with_the_law_of_the_extended_deck() {
    let folder = diagnosed(&["progressive-stiffness@BUSHING/1.K.1:law=cubic,cubic=30000"]);
    let here = folder.path();
    let list = changes(&here.join("out/adams_car/changes.json"));
    assert_eq!(
        list["property_files"],
        serde_json::json!(["arm_front_learned.bus"]),
        "{list:#}"
    );
    let read = PropertyFile::parse(Source::new(
        "a.bus",
        std::fs::read(here.join("out/adams_car/arm_front_learned.bus")).unwrap(),
    ));
    assert_eq!(read.diagnostics, []);
    let property = BushingProperty::of(&read.value, &Units::default());
    // The law of the finding and the law of the extended deck, with its stiffness, agree at every point.
    let diagnosis = changes(&here.join("out/diagnosis.json"));
    let finding = diagnosis["findings"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|finding| finding["cause"] == "progressive-stiffness")
        .expect("a finding");
    assert_eq!(finding["address"], "BUSHING/1.K.1");
    let number = |name: &str| finding["parameters"][name].as_f64().unwrap_or(0.0);
    let (_, out, _) = admire(here, &["get", "out/extended.adm", "BUSHING/1.K.1"]);
    let stiffness: f64 = out.trim().parse().expect("a number");
    let curve = property.curves[0].as_ref().expect("FX_CURVE");
    assert!(curve.x.len() > 50 && curve.x[curve.x.len() - 1] > 0.2);
    for (u, force) in curve.x.iter().zip(&curve.y) {
        let law = stiffness * u
            + number("quadratic") * u * u.abs()
            + number("cubic") * u * u * u
            + number("quintic") * u.powi(5);
        assert!(
            (force - law).abs() <= 1e-9 * law.abs(),
            "{u}: {force} {law}"
        );
    }
    let source = Source::new(
        "front.sub",
        std::fs::read(here.join("out/adams_car/front.sub")).unwrap(),
    );
    let new = Subsystem::parse(source);
    assert_eq!(new.diagnostics, []);
    let front = &new.value.bushings[0];
    assert_eq!(
        front.property_file.as_deref(),
        Some("mdids://car/bushings.tbl/arm_front_learned.bus")
    );
    let block = &new.value.file.blocks[front.block];
    let factor = block.parameter("FX_SCALING_FACTOR").expect("a factor");
    assert_eq!(factor.number(), Some(1.0));
    assert_eq!(
        new.value.hardpoints[0].place(Side::Single),
        Some([0.15, 0.0, 0.0])
    );
    // Only the blocks of bushings differ.
    let old = PropertyFile::parse(Source::new("front.sub", ARM_SUB)).value;
    for one in diff(&old, &new.value.file, DiffTolerance::default()) {
        assert!(one.address.starts_with("BUSHING_ASSEMBLY/"), "{one:?}");
        assert!(!matches!(one.change, DiffKind::Removed), "{one:?}");
    }
}
