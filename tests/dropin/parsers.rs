//! Message files read by regular expressions of existing scripts, taken from adamspy 0.33 (`postprocess/msg.py`).

use regex_lite::Regex;

use crate::run::{SLIDER, folder, generic_model, mdi, text};

const TIMESTAMP: &str = r"(?m)^\s+(\d\.\d{5}E[\+\-]\d{2})\s+(\d\.\d{5}E[\+\-]\d{2})\s+(\d+)\s+(\d+)\s+(\d+)\s+(\d+(?:[\.:]\d{2}){1,2})\s*$";
const FINISH: &str = r"(?m)^Finished -----\s*$";
const RUNTIME: &str =
    r"(?m)^Elapsed time = (\d+\.\d{2})s,  CPU time = (\d+\.\d{2})s,  (\d+\.\d{2})%\s*$";
const ERROR: &str = r"(?m)^---- START: ERROR ----\s*$";
const FULL_ERROR: &str = r"(?m)---- START: ERROR ----.*(?:.*\n)*?---- END: ERROR ----$";
const CXX: &str = r"(?i)a *d *a *m *s *c\+\+ *s *o *l *v *e *r";
const PROCESS_ID: &str = r"(?im)^[^\w]*Process ID:\s*(\d+)[^\w]*$";
const EIGENVALUES: &str = r"(?m)^\s*E I G E N V A L U E S  at time = [\d+-\.E]+\s*$";

fn found<'t>(pattern: &str, text: &'t str) -> Vec<Vec<&'t str>> {
    let regex = Regex::new(pattern).unwrap();
    let groups = regex.captures_iter(text).map(|found| {
        let groups = found.iter().map(|group| group.map_or("", |g| g.as_str()));
        groups.collect()
    });
    groups.collect()
}

/// Returns the results of adamspy's functions for a message file: solver, completion, errors, and the times of the table.
fn told(messages: &str) -> (bool, bool, usize, usize, usize, usize, Vec<String>) {
    let times = found(TIMESTAMP, messages);
    (
        found(CXX, messages).is_empty(),
        !found(FINISH, messages).is_empty(),
        found(ERROR, messages).len(),
        found(FULL_ERROR, messages).len(),
        found(RUNTIME, messages).len(),
        found(PROCESS_ID, messages).len(),
        times.iter().map(|row| row[1].to_string()).collect(),
    )
}

#[test]
fn a_dynamic_run_tells_scripts_what_adams_tells_them() {
    let Some([ours, real]) = generic_model() else {
        return;
    };
    assert_eq!(told(&ours), told(&real));
    assert_eq!(told(&real).6.len(), 11);
}

#[test]
fn errors_are_found_whole_and_name_their_objects() {
    let deck = SLIDER
        .replace("I=21, J=11, K=10", "I=21, J=99, K=10")
        .replace(
            "SPRINGDAMPER/1",
            "!            adams_view_name='spring'\nSPRINGDAMPER/1",
        )
        .replace(
            "MARKER/21, PART=2, QP",
            "!            adams_view_name='tip'\nMARKER/21, PART=2, QPP",
        );
    let folder = folder(&[("slider.adm", &deck), ("run.acf", "\nfile/model=slider\n")]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 1);
    let messages = text(folder.path(), "slider.msg");
    let (fortran, finished, starts, errors, runtime, process, _) = told(&messages);
    assert_eq!((fortran, finished, runtime, process), (false, true, 1, 1));
    // Two errors, and a third one that the model cannot be used.
    assert_eq!((starts, errors), (3, 3), "{messages}");
    let errors = found(FULL_ERROR, &messages);
    let of = |word: &str| errors.iter().find(|e| e[0].contains(word)).unwrap()[0];
    assert!(of("QPP").contains("\n  object: model.block.tip\n"));
    assert!(of("MARKER/99").contains("\n  object: model.spring\n"));
}

/// Checks the eigenvalue table for a block of 1 kg on a spring of 100 and a damper of 2, and for a block held only by a damper.
#[test]
fn eigenvalues_stand_in_the_table_of_adams() {
    let deck = "two
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
MARKER/2, PART=1, QP=0,0,1
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/20, PART=2, QP=0,0,1
JOINT/1, TRANSLATIONAL, I=20, J=1
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=1, K=100, C=2, LENGTH=1
PART/3, MASS=1, CM=30, IP=1,1,1
MARKER/30, PART=3, QP=0,0,2
JOINT/2, TRANSLATIONAL, I=30, J=2
SPRINGDAMPER/2, TRANSLATIONAL, I=30, J=2, K=0, C=4, LENGTH=1
END
";
    let acf = "\nfile/model=two\nSIMULATE/INITIAL_CONDITIONS\nLINEAR/EIGENSOL\nstop\n";
    let folder = folder(&[("two.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let messages = text(folder.path(), "two.msg");
    assert_eq!(found(EIGENVALUES, &messages).len(), 1, "{messages}");
    let table = messages.split("E I G E N V A L U E S").nth(1).unwrap();
    let mut lines = table.lines().skip(1).take_while(|line| !line.is_empty());
    let head: Vec<&str> = lines.next().unwrap().split_whitespace().collect();
    assert_eq!(
        head,
        ["Number", "Real(cycles/second)", "Imag.(cycles/second)"]
    );
    let rows: Vec<Vec<f64>> = lines
        .map(|line| {
            let cells = line.replace("+/-", "   ");
            let cells = cells.split_whitespace().map(|cell| cell.parse().unwrap());
            cells.collect()
        })
        .collect();
    let turn = std::f64::consts::TAU;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-5, "{a} {b} {rows:?}");
    // Real eigenvalues come first, then pairs: 0 and -4; -1 +- i sqrt(99).
    assert_eq!(rows.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 3]);
    assert_eq!(
        rows.iter().map(|r| r[0]).collect::<Vec<_>>(),
        [1.0, 2.0, 3.0]
    );
    near(rows[0][1], 0.0);
    near(rows[1][1], -4.0 / turn);
    near(rows[2][1], -1.0 / turn);
    near(rows[2][2], 99f64.sqrt() / turn);
}
