//! `admire solve` with command files: another deck, columns as CSV and as plots, Ctrl-C.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::run::{Results, folder};

const SWING: &str = "swing
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
PART/2, MASS=1, CM=20, IP=0.1,0.1,0.1, QG=1,0,0
MARKER/20, PART=2
MARKER/21, PART=2, QP=-1,0,0, REULER=0,90D,0
MARKER/11, PART=1, REULER=0,90D,0
JOINT/1, REVOLUTE, I=21, J=11
ACCGRAV/KGRAV=-9.81
RESULTS/FORMATTED, XRF
END
";

fn solve(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .arg("solve")
        .args(words)
        .output()
        .unwrap()
}

#[test]
fn columns_become_a_table_and_a_page() {
    let acf = "\nfile/model=nothing\nsimulate/dynamic, end=1, steps=20\nstop\n";
    let bare = "\nsimulate/dynamic, end=1, steps=20\nstop\n";
    for acf in [acf, bare] {
        let folder = folder(&[("swing.adm", SWING), ("run.acf", acf), ("mine.csv", "mine")]);
        let words = [
            "swing.adm",
            "run.acf",
            "--columns",
            "PART_2_XFORM.?",
            "JOINT_1.F?",
        ];
        let ran = solve(
            folder.path(),
            &[&words[..], &["--csv", "swing.csv", "--plot", "swing.html"]].concat(),
        );
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        let shown = String::from_utf8_lossy(&ran.stdout).into_owned();
        assert_eq!(ran.status.code(), Some(0), "{said} {shown}");
        let csv = std::fs::read_to_string(folder.path().join("swing.csv")).unwrap();
        let head = csv.lines().next().unwrap();
        assert!(
            head.contains("TIME") && head.contains("PART_2_XFORM.Z [meter]"),
            "{head}"
        );
        assert!(
            head.contains("JOINT_1.FX [newton]") && !head.contains("VX"),
            "{head}"
        );
        let z: Vec<f64> = Results::read_all(folder.path(), "swing.res").column("PART_2_XFORM", "Z");
        let last: Vec<&str> = csv.lines().last().unwrap().split(',').collect();
        let at = head
            .split(',')
            .position(|name| name.contains("XFORM.Z"))
            .unwrap();
        assert_eq!(last[at].parse::<f64>().unwrap(), *z.last().unwrap());
        let page = std::fs::read_to_string(folder.path().join("swing.html")).unwrap();
        assert_eq!(page.matches("<figure>").count(), 2, "metres and newtons");
        assert!(page.contains("PART_2_XFORM.X") && page.contains("time [sec]"));
        // The step of the dataset itself is left out, because its joint forces are zero.
        assert!(page.contains("21 steps"), "the start and twenty outputs");
        // An existing file of the user is kept.
        let ran = solve(
            folder.path(),
            &[&words[..], &["--csv", "mine.csv"]].concat(),
        );
        assert_eq!(ran.status.code(), Some(1));
        let mine = std::fs::read_to_string(folder.path().join("mine.csv")).unwrap();
        assert_eq!(mine, "mine");
    }
    // Columns are available only for a run of a command file.
    let folder = folder(&[("swing.adm", SWING)]);
    let ran = solve(folder.path(), &["swing.adm", "--csv", "a.csv"]);
    assert_eq!(ran.status.code(), Some(2));
}

/// Checks that Ctrl-C ends a run after the current output, and that its files are complete.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_whole_files() {
    let acf = "\nfile/model=swing\nsimulate/dynamic, end=20000, steps=100000\nstop\n";
    let folder = folder(&[("swing.adm", SWING), ("run.acf", acf)]);
    let mut child = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder.path())
        .args(["solve", "run.acf"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let res = folder.path().join("swing.res");
    for _ in 0..600 {
        if std::fs::metadata(&res).is_ok_and(|m| m.len() > 20_000) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let ended = child.wait().unwrap();
    assert_eq!(ended.code(), Some(130));
    let text = std::fs::read_to_string(&res).unwrap();
    assert!(
        text.trim_end().ends_with("</Results>"),
        "{}",
        &text[text.len() - 200..]
    );
    let results = Results::read_all(folder.path(), "swing.res");
    let last = results.steps.last().unwrap()[0];
    assert!(last > 0.0 && last < 20000.0, "{last}");
    let message = std::fs::read_to_string(folder.path().join("swing.msg")).unwrap();
    assert!(message.contains("interrupted at time"), "{message}");
}
