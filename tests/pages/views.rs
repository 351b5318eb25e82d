use std::path::{Path, PathBuf};
use std::process::Command;

use super::browser::{chromium, sound};
use super::common::shared;

fn view(arguments: &[&Path], out: &Path) {
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .arg("view")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .expect("admire runs");
    assert!(
        out.is_file(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&run.stderr)
    );
}

fn corpus(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(path)
}

#[test]
fn the_view_of_a_deck_turns_under_mouse_and_keys() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("view.html");
    view(&[&corpus("pseudo-mcpherson/model.adm")], &page);
    let seen = sound(&chromium, &page);
    assert_eq!(seen.scenes.len(), 1);
    assert_eq!(seen.scenes[0].slider, None, "nothing moves without results");
}

/// A frame 1,000 mm wide across the car (y), 700 mm high on the side of negative y, and 200 mm long (x). A load acts against a marker on ground
/// 5 m away, which supports no part.
const FRAME: &str = "a frame
UNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=MILLIMETER,TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1,QP=0,-500,0
MARKER/2,PART=1,QP=200,500,0
MARKER/3,PART=1,QP=100,-500,700
MARKER/4,PART=1,QP=5000,0,-5000
PART/2,MASS=1,CM=11,IP=1,1,1
MARKER/11,PART=2,QP=0,-500,0
MARKER/12,PART=2,QP=200,500,0
MARKER/13,PART=2,QP=100,-500,700
BUSHING/1,I=11,J=1,K=1E4,1E4,1E4,KT=1E6,1E6,1E6
BUSHING/2,I=12,J=2,K=1E4,1E4,1E4,KT=1E6,1E6,1E6
BUSHING/3,I=13,J=3,K=1E4,1E4,1E4,KT=1E6,1E6,1E6
SFORCE/1,TRANSLATIONAL,ACTIONONLY,I=12,J=4,FUNCTION=10
ACCGRAV/KGRAV=-9806.65
END
";

/// Checks the views Front, along the car, and Side, across it. The whole mechanism is in the picture, which is not mirrored. Markers that
/// support no part do not affect the scale.
#[test]
fn the_front_view_shows_the_width_of_the_car() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (deck, page) = (
        folder.path().join("frame.adm"),
        folder.path().join("view.html"),
    );
    std::fs::write(&deck, FRAME).unwrap();
    view(&[&deck], &page);
    let seen = sound(&chromium, &page);
    let views = &seen.scenes[0].views;
    println!("{views:?}");
    let size = |name: &str| {
        let [left, right, top, bottom, _] = views[name];
        ((right - left), (bottom - top))
    };
    let ((wide, high), (long, tall)) = (size("Front"), size("Side"));
    // The front view shows 1,000 by 700 mm, the side view 200 by 700 mm.
    assert!(wide / high > 2.0 * long / tall, "{views:?}");
    for [left, right, top, bottom, _] in views.values() {
        assert!(*left > 0.01 && *right < 0.99 && *top > 0.01, "{views:?}");
        let filled = (right - left).max(bottom - top);
        assert!(filled > 0.4, "{views:?}");
    }
    // Seen along +x with z up, negative y is on the right.
    assert!(views["Front"][4] > 0.5, "{views:?}");
}

/// Checks the view of our own results: the wheel of a double wishbone travels and is steered.
#[test]
fn the_view_of_results_moves_with_step_and_slider() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("model.adm");
    std::fs::copy(corpus("double-wishbone/model.adm"), &deck).unwrap();
    let (run, page) = (
        folder.path().join("run.res"),
        folder.path().join("view.html"),
    );
    let acf = std::fs::read_to_string(corpus("double-wishbone/states.acf")).unwrap();
    let mut lines: Vec<&str> = acf.lines().collect();
    lines[1] = "file/model=model, output_prefix=run";
    std::fs::write(folder.path().join("run.acf"), lines.join("\n") + "\n").unwrap();
    let solved = Command::new(env!("CARGO_BIN_EXE_mdi"))
        .args(["-c", "ru-standard", "i", "run.acf", "exit"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.is_file(), "{}", String::from_utf8_lossy(&solved.stdout));
    view(&[&deck, &run], &page);
    let seen = sound(&chromium, &page);
    assert_eq!(
        (seen.scenes[0].slider, seen.scenes[0].step),
        (Some(true), Some(true))
    );
}

#[test]
#[ignore = "minutes: .ci/full"]
fn decks_and_results_of_others_are_drawn() {
    let (Some(chromium), Some(real)) = (chromium(), shared("real-decks")) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let pairs: [&[&str]; 4] = [
        &["photocaber/adams1.adm", "photocaber/adams1.res"],
        &[
            "inverted-pendulum/Controls_Plant_1.adm",
            "inverted-pendulum/Controls_Plant_1.res",
        ],
        &["aview-hpc/test.adm", "aview-hpc/test.res"],
        &["kinbench-kc/NRAC_G023_Lat_static_load.res"],
    ];
    for (k, pair) in pairs.iter().enumerate() {
        let paths: Vec<PathBuf> = pair.iter().map(|name| real.join(name)).collect();
        let page = folder.path().join(format!("{k}.html"));
        view(
            &paths.iter().map(PathBuf::as_path).collect::<Vec<_>>(),
            &page,
        );
        let seen = sound(&chromium, &page);
        assert_eq!(seen.scenes.len(), 1, "{pair:?}");
    }
}

/// Checks that every available deck gives a page, whatever its faults, and that an existing file is replaced only on request.
#[test]
fn every_deck_of_others_gives_a_page() {
    let Some(real) = shared("real-decks") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (k, deck) in super::common::files_below(&real, "adm").iter().enumerate() {
        view(&[deck], &folder.path().join(format!("{k}.html")));
    }
}

#[test]
fn a_file_that_is_there_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.html"), "mine").unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .arg("view")
        .arg(corpus("pseudo-mcpherson/model.adm"))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1));
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(
        said.contains("`model.html` already exists") && said.contains("--out model.html"),
        "{said}"
    );
    assert_eq!(
        std::fs::read_to_string(folder.path().join("model.html")).unwrap(),
        "mine"
    );
}
