//! SIGKILL at every file operation of whole runs; strace counts the operations and sends the signal.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::skipped;
use crate::faults::{ADMIRE, MDI, long_deck, not_believed, strangers};
use crate::run::{Results, SLIDER, folder, mdi};

/// System calls that change the content or existence of files.
const CHANGES: &str = "write,pwrite64,writev,copy_file_range,ftruncate,openat,rename,renameat,renameat2,link,linkat,unlink,unlinkat,\
                       mkdir,mkdirat,chmod,fchmod,fchmodat,fsync,fdatasync";

/// Returns true if strace can trace programs here.
fn strace_works() -> bool {
    let run = Command::new("strace")
        .args(["-qq", "-o", "/dev/null", "true"])
        .output();
    let works = run.is_ok_and(|run| run.status.success());
    if !works {
        skipped("strace cannot follow programs here");
    }
    works
}

/// Runs a program that gets SIGKILL at its `at`-th changing system call; returns false if it finished earlier.
fn killed_at(at: usize, place: &Path, program: &str, words: &[&str]) -> bool {
    let output = Command::new("strace")
        .args(["-f", "-qq", "-o", "/dev/null", "-e"])
        .arg(format!("inject={CHANGES}:signal=SIGKILL:when={at}"))
        .arg(program)
        .args(words)
        .current_dir(place)
        .stdin(Stdio::null())
        .output()
        .expect("strace");
    match output.status.code() {
        Some(0) => false,
        None => true,
        code => panic!(
            "{at}: {code:?}, {}",
            String::from_utf8_lossy(&output.stderr)
        ),
    }
}

/// Checks SIGKILL at every write and every other file operation of a whole run.
#[test]
fn a_run_may_be_killed_at_every_write() {
    if !strace_works() {
        return;
    }
    let acf = |force: i32| {
        format!(
            "\nfile/model=slider\nSFORCE/1, FUNCTION={force}*TIME\nSIM/STAT, END=1, STEPS=6\nSTOP\n"
        )
    };
    let place = folder(&[("slider.adm", SLIDER), ("run.acf", &acf(7))]);
    let read = || Results::read(place.path(), "slider.res").steps;
    assert_eq!(mdi(place.path(), &["ru-s", "run"]).code, 0);
    let new = read();
    // Results of another, longer run exist before.
    let long = acf(3).replace("STEPS=6", "STEPS=60");
    std::fs::write(place.path().join("old.acf"), long).unwrap();
    assert_eq!(mdi(place.path(), &["ru-s", "old"]).code, 0);
    let old = read();
    let mut kills = 0;
    let own = [
        "slider.adm",
        "run.acf",
        "old.acf",
        "slider.res",
        "slider.msg",
        "slider.out",
        "slider.req",
    ];
    while killed_at(kills + 1, place.path(), MDI, &["ru-s", "run"]) {
        kills += 1;
        let what = format!("killed at change {kills}");
        let deck = std::fs::read(place.path().join("slider.adm")).unwrap();
        assert!(deck == SLIDER.as_bytes(), "{what}: the deck");
        let bytes = std::fs::read(place.path().join("slider.res")).unwrap();
        if String::from_utf8_lossy(&bytes).contains("runStatus=\"Successful\"") {
            // Either the old results or all of the new ones.
            let steps = read();
            assert!(
                steps == old || steps == new,
                "{what}: {} steps",
                steps.len()
            );
        } else {
            not_believed(&bytes, &new, &what);
        }
        assert_eq!(
            strangers(place.path(), &own),
            Vec::<String>::new(),
            "{what}"
        );
        // The next run is unaffected.
        let again = mdi(place.path(), &["ru-s", "old"]);
        assert_eq!(again.code, 0, "{what}: {}", again.stdout);
        assert_eq!(read(), old, "{what}");
    }
    println!("a run was killed at {kills} changes");
    assert!(kills > 30, "{kills}");
    assert_eq!(read(), new);
}

/// Checks an edit in place, of a file with one name and of a file with two hard links.
#[test]
fn an_edit_may_be_killed_at_every_write() {
    if !strace_works() {
        return;
    }
    let old = long_deck();
    let edit = ["set", "slider.adm", "MARKER/100.QP.3=7", "--in-place"];
    let new = old.replace(
        "MARKER/100, PART=2, QP=100, 0, 0",
        "MARKER/100, PART=2, QP=100, 0, 7",
    );
    assert_ne!(new, old);
    for names in [1, 2] {
        let mut kills = 0;
        loop {
            let place = folder(&[("slider.adm", &old)]);
            let deck = place.path().join("slider.adm");
            if names == 2 {
                std::fs::hard_link(&deck, place.path().join("other.adm")).unwrap();
            }
            let killed = killed_at(kills + 1, place.path(), ADMIRE, &edit);
            let what = format!("killed at change {}, {names} names", kills + 1);
            let found = std::fs::read(&deck).unwrap();
            let mut strangers = strangers(place.path(), &["slider.adm", "other.adm"]);
            // A file with two hard links is overwritten in place; its complete new text is kept beside it until that is done.
            if let Some(beside) = strangers.pop() {
                assert!(
                    killed && names == 2 && beside.starts_with("slider.adm.whole-"),
                    "{what}: {beside}"
                );
                let beside = std::fs::read(place.path().join(beside)).unwrap();
                assert!(beside == new.as_bytes(), "{what}: the text beside");
                assert_eq!(strangers, Vec::<String>::new(), "{what}");
            } else {
                let whole = found == old.as_bytes() || found == new.as_bytes();
                assert!(whole, "{what}: a torn deck");
            }
            if !killed {
                assert!(found == new.as_bytes(), "{what}");
                break;
            }
            kills += 1;
        }
        println!("an edit was killed at {kills} changes");
        assert!(kills >= 4 * names, "{kills}");
    }
}
