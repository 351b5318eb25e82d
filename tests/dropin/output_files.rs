//! Kinds of steps in `.res`, times in `.req` and frames in `.gra`, as written by ADAMS.

use crate::run::{SLIDER, folder, mdi, text};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
    }
}

fn run(commands: &str) -> (tempfile::TempDir, crate::run::Ran) {
    let acf = format!("\nfile/model=slider\n{commands}\n");
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (folder, ran)
}

/// Returns name, type and number of steps of each Data block.
pub fn blocks(folder: &std::path::Path, name: &str) -> Vec<(String, String, usize)> {
    let mut found: Vec<(String, String, usize)> = Vec::new();
    for line in text(folder, name).lines() {
        let quoted = || line.split('"').nth(1).unwrap_or_default().to_string();
        if line.starts_with("<Data ") {
            found.push((quoted(), String::new(), 0));
        } else if line.starts_with("<Step ") {
            let last = found.last_mut().expect("steps are in blocks");
            last.1 = quoted();
            last.2 += 1;
        }
    }
    found
}

/// Returns the times of `slider.req`.
pub fn request_times(folder: &std::path::Path) -> Vec<f64> {
    let bytes = text(folder, "slider.req").into_bytes();
    let source = admire_syntax::text::Source::new("slider.req", bytes);
    admire_results::RequestFile::parse(&source).value.times
}

/// Checks a single static followed by a motion as in ADAMS 2020: `static_001` of type `static`, and no repeated time in `.req`.
#[test]
fn a_lone_static_is_a_step_of_type_static_and_its_time_is_not_repeated() {
    let commands =
        "SIMULATE/STATIC\nINTEGRATOR/ERROR=1E-4\nSIMULATE/DYNAMIC, END=0.2, STEPS=2\nSTOP";
    let (folder, ran) = run(commands);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let found = blocks(folder.path(), "slider.res");
    let names: Vec<(&str, &str)> = found.iter().map(|(n, t, _)| (&**n, &**t)).collect();
    assert_eq!(
        names,
        [
            ("modelInput_001", "input"),
            ("static_001", "static"),
            ("initialConditions_001", "initialConditions"),
            ("dynamic_001", "dynamic")
        ]
    );
    near(&request_times(folder.path()), &[0.0, 0.1, 0.2]);
    // Two single solutions at the same time are both output.
    let (folder, _) = run("SIM/STAT\nSFORCE/1, FUNCTION=5\nSIM/STAT");
    near(&request_times(folder.path()), &[0.0, 0.0]);
}

/// Checks that static frames have a label in place of a time, and that each force has one line, at the marker of its statement.
#[test]
fn frames_of_graphics_have_a_line_for_each_part_and_each_force() {
    let deck = SLIDER
        .replace("OUTPUT/REQSAVE", "OUTPUT/REQSAVE, GRSAVE")
        .replace(
            "END\n",
            "PART/3, MASS=1, CM=31\nMARKER/31, PART=3\nJOINT/9, FIXED, I=31, J=11\n\
             GRAPHICS/1, CYLINDER, CM=21, LENGTH=5, RADIUS=2\nGRAPHICS/2, ELLIPSOID, CM=21, XSCALE=1, YSCALE=1, ZSCALE=1\n\
             GRAPHICS/7, FORCE, ETYPE=SFORCE, EID=1, EMARKER=20\nGRAPHICS/8, FORCE, ETYPE=SPRINGDAMPER, EID=1, EMARKER=11\nEND\n",
        );
    let acf =
        "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSIM/STAT\nSIM/STAT, END=1, STEPS=2\nSTOP\n";
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let written = text(folder.path(), "slider.gra");
    let counts: Vec<&str> = written.lines().nth(2).unwrap().split_whitespace().collect();
    // Number of parts including ground, then of drawn shapes and of forces; shapes fixed to their parts are not in the file.
    assert_eq!(
        (counts[0], counts[2], counts[8]),
        ("3", "2", "2"),
        "{written}"
    );
    let (_, frames) = written.split_once("-9.99999E+05\n").unwrap();
    // The frames are: as read, the static solution, and three times. Each has two parts and two forces, and all but the first have a label.
    assert_eq!(frames.lines().count(), 4 + 4 * 5, "{frames}");
    assert!(
        frames.lines().nth(4).unwrap().contains("-5.55555E+05"),
        "{frames}"
    );
    let source = admire_syntax::text::Source::new("slider.gra", written.into_bytes());
    let read = admire_results::GraphicsFile::parse(&source);
    assert_eq!(read.diagnostics, []);
    let file = read.value;
    assert_eq!((&*file.parts, &*file.forces), (&[2, 3][..], &[7, 8][..]));
    near(&file.times, &[0.0, 0.0, 0.5, 1.0]);
    // 5 newton push the block; the spring transmits the same force to the ground.
    let z: Vec<f64> = file.loads.iter().map(|loads| loads[0][2]).collect();
    near(&z, &[5.0; 4]);
    let z: Vec<f64> = file.loads.iter().map(|loads| loads[1][2]).collect();
    near(&z, &[5.0; 4]);
    let (code, out) = {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .args([
                "results",
                "slider.gra",
                "--get",
                "GRAPHICS_7.FZ",
                "PART_2.Z",
                "--plain",
            ])
            .current_dir(folder.path())
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
        )
    };
    assert_eq!(code, Some(0));
    assert!(
        out.starts_with("PART_2_XFORM.Z,GRAPHICS_7.FZ\n0.5,5\n"),
        "{out}"
    );
}
