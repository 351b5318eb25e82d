//! Full disks at any byte and processes killed at any write: no user file is lost, and no torn file is accepted.
//!
//! A limit on the file size simulates both. If its signal is ignored, the write fails as on a full disk; otherwise the process ends at that
//! write without clean-up, as by SIGKILL.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use admire_results::XrfReader;

use crate::run::{Results, SLIDER, folder, mdi};

/// Effect of the limit on a program.
#[derive(Clone, Copy, PartialEq, Debug)]
enum End {
    Full,
    Killed,
}

pub const ADMIRE: &str = env!("CARGO_BIN_EXE_admire");
pub const MDI: &str = env!("CARGO_BIN_EXE_mdi");

/// Runs a program in a folder where no file may exceed a number of blocks of 512 bytes.
fn limited(end: End, blocks: usize, place: &Path, program: &str, words: &[&str]) -> Output {
    let ignored = if end == End::Full {
        "trap '' XFSZ; "
    } else {
        ""
    };
    let script = format!("{ignored}ulimit -c 0; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    Command::new("sh")
        .args(["-c", &script, program])
        .args(words)
        .current_dir(place)
        .output()
        .expect("a shell")
}

/// Returns true if the program ended at the limit, with a message unless it was killed; false if it finished.
fn ended(output: &Output, what: &str) -> bool {
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(!said.contains("panicked"), "{what}: {said}");
    match output.status.code() {
        Some(0) => false,
        Some(1 | 2) => {
            let told = said.contains("cannot be written")
                || said.contains("cannot write")
                || said.contains("File too large");
            assert!(told, "{what}: {said}");
            true
        }
        None => true,
        code => panic!("{what}: {code:?}, {said}"),
    }
}

/// Returns the files of a folder that are neither the user's own nor temporary files that the next run removes.
pub fn strangers(place: &Path, own: &[&str]) -> Vec<String> {
    let names = std::fs::read_dir(place)
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    let names = names.map(|name| name.to_string_lossy().into_owned());
    names
        .filter(|name| !own.contains(&name.as_str()) && !name.starts_with(".admire-"))
        .collect()
}

/// Returns a deck of several pages, to be edited in place.
pub fn long_deck() -> String {
    let more = (100..180).map(|id| format!("MARKER/{id}, PART=2, QP={id}, 0, 0\n"));
    let more = more.collect::<Vec<_>>().concat();
    SLIDER.replacen("MARKER/21", &format!("{more}MARKER/21"), 1)
}

#[test]
fn an_edited_deck_is_the_old_one_or_the_new_one() {
    let old = long_deck();
    let edit = ["set", "slider.adm", "MARKER/100.QP.3=7", "--in-place"];
    let whole = folder(&[("slider.adm", &old)]);
    let done = Command::new(ADMIRE)
        .args(edit)
        .current_dir(whole.path())
        .output()
        .unwrap();
    assert!(done.status.success(), "{done:?}");
    let new = std::fs::read(whole.path().join("slider.adm")).unwrap();
    assert_ne!(new, old.as_bytes());
    for end in [End::Full, End::Killed] {
        for names in [1, 2] {
            let mut stopped = 0;
            for blocks in 0..=new.len() / 512 + 1 {
                let what = format!("{end:?} at {blocks}, {names} names");
                let place = folder(&[("slider.adm", &old)]);
                let deck = place.path().join("slider.adm");
                if names == 2 {
                    std::fs::hard_link(&deck, place.path().join("other.adm")).unwrap();
                }
                let output = limited(end, blocks, place.path(), ADMIRE, &edit);
                let at_limit = ended(&output, &what);
                stopped += usize::from(at_limit);
                let found = std::fs::read(&deck).unwrap();
                let expected = if at_limit { old.as_bytes() } else { &new };
                assert!(found == expected, "{what}: a torn deck");
                assert_eq!(
                    strangers(place.path(), &["slider.adm", "other.adm"]),
                    Vec::<String>::new(),
                    "{what}"
                );
                // The next edit succeeds and removes leftover files.
                let again = limited(End::Full, 1 << 20, place.path(), ADMIRE, &edit);
                assert!(again.status.success(), "{what}: {again:?}");
                assert!(std::fs::read(&deck).unwrap() == new, "{what}");
                assert_eq!(
                    std::fs::read_dir(place.path()).unwrap().count(),
                    names,
                    "{what}"
                );
            }
            assert!(stopped >= 3, "{stopped}");
        }
    }
}

/// Checks that results of an incomplete run are marked as such and hold only complete steps, and that the next run is unaffected.
#[test]
fn no_torn_results_are_believed() {
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=60\nSTOP\n";
    let files = [("slider.adm", SLIDER), ("run.acf", acf)];
    let whole = folder(&files);
    assert_eq!(mdi(whole.path(), &["ru-s", "run"]).code, 0);
    let expected = Results::read(whole.path(), "slider.res").steps;
    let size = std::fs::metadata(whole.path().join("slider.res"))
        .unwrap()
        .len() as usize;
    for end in [End::Full, End::Killed] {
        let mut stopped = 0;
        for blocks in (0..=size / 512 + 1).step_by(3) {
            let what = format!("{end:?} at {blocks}");
            let place = folder(&files);
            let output = limited(end, blocks, place.path(), MDI, &["ru-s", "run"]);
            if !ended(&output, &what) {
                continue;
            }
            stopped += 1;
            assert_eq!(
                std::fs::read(place.path().join("slider.adm")).unwrap(),
                SLIDER.as_bytes()
            );
            if let Ok(bytes) = std::fs::read(place.path().join("slider.res")) {
                not_believed(&bytes, &expected, &what);
            }
            let message = crate::run::text(place.path(), "slider.msg");
            let finished = message.contains("Finished -----");
            assert!(
                !finished || message.contains("The run is not complete"),
                "{what}: {message}"
            );
            let again = mdi(place.path(), &["ru-s", "run"]);
            assert_eq!(again.code, 0, "{what}: {}", again.stdout);
            assert_eq!(
                Results::read(place.path(), "slider.res").steps,
                expected,
                "{what}"
            );
        }
        assert!(stopped >= 3, "{stopped}");
    }
}

/// Asserts that a reader reports an incomplete file and returns only true steps before its end.
pub fn not_believed(bytes: &[u8], expected: &[Vec<f64>], what: &str) {
    let text = String::from_utf8_lossy(bytes);
    assert!(!text.contains("runStatus=\"Successful\""), "{what}");
    let Ok(mut reader) = XrfReader::open("slider.res", bytes) else {
        return;
    };
    let (mut count, mut values) = (0, Vec::new());
    let mut whole = true;
    loop {
        match reader.next_step() {
            Ok(Some(step)) if step.values(&mut values).is_ok() => {
                if expected.contains(&values) {
                    count += 1;
                } else {
                    assert_eq!(values[0], 0.0, "{what}: {values:?}");
                }
            }
            Ok(None) => break,
            _ => {
                whole = false;
                break;
            }
        }
    }
    // The step `input` may equal the first step.
    assert!(count <= expected.len() + 1, "{what}: {count}");
    let told = !whole || !reader.diagnostics().is_empty() || !text.contains("</Results>");
    assert!(told, "{what}: taken for a whole file");
}

/// Checks SIGKILL at any moment of a run.
#[test]
fn a_run_may_be_killed_at_any_moment() {
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=400\nSTOP\n";
    let place = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
    let start = std::time::Instant::now();
    assert_eq!(mdi(place.path(), &["ru-s", "run"]).code, 0);
    let lasts = start.elapsed();
    let expected = Results::read(place.path(), "slider.res").steps;
    let mut kills = 0;
    for moment in 1..=24 {
        let mut child = Command::new(MDI)
            .args(["ru-s", "run"])
            .current_dir(place.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(lasts.max(Duration::from_millis(2)) * moment / 20);
        let ended = child.try_wait().unwrap().is_some();
        child.kill().unwrap_or(());
        child.wait().unwrap();
        let what = format!("moment {moment}");
        let bytes = std::fs::read(place.path().join("slider.res")).unwrap();
        if String::from_utf8_lossy(&bytes).contains("runStatus=\"Successful\"") {
            assert_eq!(
                Results::read(place.path(), "slider.res").steps,
                expected,
                "{what}"
            );
        } else {
            assert!(!ended, "{what}");
            kills += 1;
            not_believed(&bytes, &expected, &what);
        }
    }
    println!("{kills} of 24 runs were killed");
    assert_eq!(mdi(place.path(), &["ru-s", "run"]).code, 0);
    assert_eq!(Results::read(place.path(), "slider.res").steps, expected);
    let left = strangers(
        place.path(),
        &[
            "slider.adm",
            "run.acf",
            "slider.res",
            "slider.msg",
            "slider.out",
            "slider.req",
        ],
    );
    assert_eq!(left, Vec::<String>::new());
}

/// Checks a read-only folder: nothing is written, and both programs report it.
#[test]
fn a_folder_that_is_read_only_is_told_of() {
    use std::os::unix::fs::PermissionsExt;
    let mode = |path: &Path, mode| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    let tools = folder(&[]);
    let place = folder(&[
        ("slider.adm", SLIDER),
        ("run.acf", "\nfile/model=slider\nSIM/STAT\nSTOP\n"),
    ]);
    for (from, name) in [(ADMIRE, "admire"), (MDI, "mdi")] {
        std::fs::copy(from, tools.path().join(name)).unwrap();
    }
    mode(tools.path(), 0o755);
    mode(place.path(), 0o555);
    // A user with unlimited rights (root) is switched to one without write access.
    let all_may = std::fs::write(place.path().join("try"), "").is_ok();
    if all_may {
        std::fs::remove_file(place.path().join("try")).unwrap();
    }
    let run = |name: &str, words: &[&str]| {
        let program = tools.path().join(name);
        let mut command = Command::new(if all_may {
            "setpriv".as_ref()
        } else {
            program.as_os_str()
        });
        if all_may {
            command
                .args(["--reuid=65534", "--regid=65534", "--clear-groups"])
                .arg(&program);
        }
        command
            .args(words)
            .current_dir(place.path())
            .output()
            .expect("setpriv of util-linux")
    };
    let set = ["set", "slider.adm", "SPRINGDAMPER/1.K=12", "--in-place"];
    for (name, words, code, file) in [
        (
            "mdi",
            &["-c", "ru-standard", "i", "run.acf", "exit"][..],
            2,
            "slider.res",
        ),
        (
            "admire",
            &["solve", "slider.adm", "run.acf"],
            2,
            "slider.res",
        ),
        ("admire", &set, 1, "slider.adm"),
        (
            "admire",
            &["renumber", "slider.adm", "MARKER=500", "-o", "new.adm"],
            1,
            "new.adm",
        ),
    ] {
        let output = run(name, words);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        let told = said.contains(file) && said.contains("cannot be written");
        assert!(
            told && said.contains("Permission denied"),
            "{words:?}: {said}"
        );
    }
    let left = std::fs::read_to_string(place.path().join("slider.adm")).unwrap();
    assert_eq!(left, SLIDER);
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 2);
    mode(place.path(), 0o755);
}

/// Checks that the outputs of an identification are either complete or still the old ones.
#[test]
fn outputs_of_a_study_are_whole_or_not_there() {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let study = study.to_str().unwrap();
    let words = ["identify", study, "--out", "out"];
    let whole = folder(&[]);
    assert!(
        limited(End::Full, 1 << 20, whole.path(), ADMIRE, &words)
            .status
            .success()
    );
    let files = |place: &Path| -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(place.join("out"))
            .map(|all| {
                all.map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
                    .collect()
            })
            .unwrap_or_default();
        names.sort();
        names
    };
    let largest = files(whole.path())
        .iter()
        .map(|name| {
            std::fs::metadata(whole.path().join("out").join(name))
                .unwrap()
                .len()
        })
        .max()
        .unwrap();
    for end in [End::Full, End::Killed] {
        let mut stopped = 0;
        for part in [0, 1, 3, 10, 40, 90] {
            let blocks = (largest / 512) as usize * part / 100;
            let what = format!("{end:?} at {blocks}");
            let place = folder(&[]);
            let output = limited(end, blocks, place.path(), ADMIRE, &words);
            if !ended(&output, &what) {
                continue;
            }
            stopped += 1;
            for name in files(place.path()) {
                if name.starts_with(".admire-") {
                    continue;
                }
                let found = std::fs::metadata(place.path().join("out").join(&name))
                    .unwrap()
                    .len();
                let expected = std::fs::metadata(whole.path().join("out").join(&name))
                    .unwrap()
                    .len();
                // Dates have a fixed length.
                assert!(
                    found.abs_diff(expected) <= 16,
                    "{what}: {name} has {found} bytes of {expected}"
                );
            }
            let again = limited(End::Full, 1 << 20, place.path(), ADMIRE, &words);
            assert!(
                again.status.success(),
                "{what}: {}",
                String::from_utf8_lossy(&again.stderr)
            );
            assert_eq!(files(place.path()), files(whole.path()), "{what}");
        }
        assert!(stopped >= 3, "{stopped}");
    }
}

/// Returns the peak memory, in bytes, of a run with a number of load cases.
fn most_memory(cases: usize) -> u64 {
    let loads = (0..cases).map(|case| format!("SFORCE/1, FUNCTION={}\nSIM/STAT\n", case % 97));
    let loads = loads.collect::<Vec<_>>().concat();
    let acf = format!("\nfile/model=slider\n{loads}STOP\n");
    let place = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let mut child = Command::new(MDI)
        .args(["ru-s", "run"])
        .current_dir(place.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    let ended = loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        most = most.max(1024 * kilobytes.unwrap_or(0));
        if let Some(ended) = child.try_wait().unwrap() {
            break ended;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(ended.success());
    let z = Results::read(place.path(), "slider.res").column("block_XFORM", "Z");
    assert_eq!(z.len(), cases);
    for (case, z) in z.iter().enumerate() {
        assert!((z - (case % 97) as f64 / 10.0).abs() < 1e-9, "{case}: {z}");
    }
    most
}

#[test]
fn memory_does_not_grow_with_the_load_cases() {
    let (few, many) = (most_memory(500), most_memory(10_000));
    // The command file itself takes about 400 bytes per case in memory.
    assert!(many < few + (8 << 20), "{few} and {many} bytes");
}

/// Checks that another language, time and time zone give the same bytes.
#[test]
fn clock_and_locale_change_no_results() {
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=5\nSTOP\n";
    let written = |variables: &[(&str, &str)]| {
        let place = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
        let ran = crate::run::mdi_with(place.path(), &["ru-s", "run"], "", variables);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let text = crate::run::text(place.path(), "slider.res");
        let own = place.path().canonicalize().unwrap();
        text.replace(&own.display().to_string(), "HERE")
    };
    let usual = written(&[("SOURCE_DATE_EPOCH", "1600000000")]);
    let other = written(&[
        ("SOURCE_DATE_EPOCH", "1600000000"),
        ("LC_ALL", "de_DE.UTF-8"),
        ("LANG", "tr_TR.UTF-8"),
        ("TZ", "Pacific/Kiritimati"),
    ]);
    assert_eq!(usual, other);
    // A clock before 1970 or in the far future must not stop the run.
    for time in ["0", "99999999999", "-1", "soon"] {
        let there = written(&[("SOURCE_DATE_EPOCH", time)]);
        assert_eq!(there.lines().count(), usual.lines().count(), "{time}");
    }
}
