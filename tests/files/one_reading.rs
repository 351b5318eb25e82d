//! Tests that values, editors, `admire check` and the solver agree about a deck.

use std::process::Command;

use super::folder::Folder;

const HEAD: &str = "deck
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/1, PART=1
MARKER/2, PART=1
MARKER/20, PART=2
ACCGRAV/KGRAV=-9806.65
RESULTS/FORMATTED, XRF
";

fn deck(more: &str) -> String {
    format!("{HEAD}{more}END\n")
}

/// Runs the drop-in solver on `d.adm` and returns its exit code and output.
fn mdi(folder: &Folder, commands: &str) -> (i32, String) {
    folder.write("r.acf", &format!("d\n\n{commands}\nSTOP\n"));
    let output = Command::new(env!("CARGO_BIN_EXE_mdi"))
        .current_dir(folder.path())
        .args(["ru-s", "r.acf"])
        .output()
        .expect("mdi runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code().expect("no signal"), said)
}

/// Checks that every reader uses the last of a repeated argument. The part sinks by 9.80665 N / (200 N/mm); with the first K it would sink
/// by a tenth of this.
#[test]
fn the_last_of_a_repeated_argument_counts_for_everyone() {
    let folder = Folder::with(&deck(
        "BUSHING/1, I=20, J=1, K=100,100,2000, KT=1E6,1E6,1E6\n, K=200,200,200\n",
    ));
    assert_eq!(folder.run(&["get", "d.adm", "BUSHING/1.K.3"]).1, "200.0\n");
    assert_eq!(
        folder.run(&["get", "d.adm", "BUSHING/1.K"]).1,
        "200.0, 200.0, 200.0\n"
    );
    let (code, said, _) = folder.run(&["check", "d.adm", "--format", "plain"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("K twice; the later one is used"), "{said}");
    let drop = |text: &str| {
        let read = admire::Deck::parse("d.adm", text.as_bytes());
        let run = read.solve().unwrap();
        -run.column("PART_2.Z").unwrap().last().copied().unwrap()
    };
    assert!((drop(&folder.read("d.adm")) - 9.80665 / 200.0).abs() < 1e-6);
    let (code, changed, _) = folder.run(&["set", "d.adm", "BUSHING/1.K.3=400"]);
    assert_eq!(code, 0);
    assert!((drop(&changed) - 9.80665 / 400.0).abs() < 1e-6, "{changed}");
    let (_, changed, _) = folder.run(&["set", "d.adm", "BUSHING/1.K.3*=4"]);
    assert!((drop(&changed) - 9.80665 / 800.0).abs() < 1e-6, "{changed}");
}

#[test]
fn check_and_solver_refuse_the_same_decks() {
    for (more, code) in [
        ("WIDGET/1, I=20, J=1\n", "unknown-statement"),
        (
            "VFORCE/1, I=20, JFLOAT=2, RM=1, FX=1\\ FY=0\\ FZ=0\n",
            "floating-marker",
        ),
        (
            "MARKER/3, PART=1, FLOATING\nJOINT/1, FIXED, I=20, J=3\n",
            "floating-marker",
        ),
        (
            "LSE/1, X=1, A=1\nARRAY/1, X, SIZE=2\nMATRIX/1, FULL=RORDER, ROWS=1, COLUMNS=2, VALUES=0,1\n",
            "wrong-count",
        ),
    ] {
        let folder = Folder::with(&deck(more));
        let (exit, said, _) = folder.run(&["check", "d.adm", "--format", "plain"]);
        assert!(exit == 1 && said.contains(code), "{more}: {said}");
        let (exit, said) = mdi(&folder, "file/model=d\nSIMULATE/STATICS");
        assert!(exit != 0 && said.contains(code), "{more}: {exit} {said}");
        let (exit, _, said) = folder.run(&["summary", "d.adm"]);
        assert_eq!(exit, 1, "{more}: {said}");
    }
}

#[test]
fn what_real_decks_hold_is_no_error() {
    let folder = Folder::with(&deck("INTEGRATOR/GSTIFF, SCALE=1,1,1,1,1\n"));
    let (code, said, _) = folder.run(&["check", "d.adm", "--format", "plain"]);
    assert_eq!(code, 0, "{said}");
    for component in [7, 8, 9] {
        let request = format!("REQUEST/1, F2=ORIENT(26,{component},20,1)\n");
        let folder = Folder::with(&deck(&request));
        let (code, said, _) = folder.run(&["check", "d.adm", "--format", "plain"]);
        assert!(code == 0 && !said.contains("error"), "{said}");
    }
}

#[test]
fn a_file_of_adams_car_is_named() {
    let folder = Folder::with("");
    let header = "$-----MDI_HEADER\n[MDI_HEADER]\n FILE_TYPE = 'sub'\n FILE_VERSION = 7.0\n FILE_FORMAT = 'ASCII'\n";
    folder.write("x.sub", header);
    let (code, out, said) = folder.run(&["summary", "x.sub"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(said.contains("is a subsystem file of Adams/Car"), "{said}");
}
