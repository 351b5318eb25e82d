//! Behaviour specific to Windows: batch files, jobs, open files, device names, long paths.

use std::os::windows::fs::OpenOptionsExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use admire_session::backend::CommandBackend;

use crate::run::{Results, SLIDER, folder, mdi};
use crate::task::{Task, words};

fn admire(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

#[test]
fn a_batch_file_ends_with_all_it_started() {
    // Each loop runs for ever and writes a trace in every pass.
    let spin = ":again\r\n@echo x>>%1\r\n@goto again\r\n";
    let tools = folder(&[("spin.bat", spin)]);
    let (first, second) = (tools.path().join("first"), tools.path().join("second"));
    let spin = tools.path().join("spin.bat");
    let solver = format!(
        "@start /b cmd /c \"{spin}\" {}\r\n@call \"{spin}\" {}\r\n",
        second.display(),
        first.display(),
        spin = spin.display()
    );
    std::fs::write(tools.path().join("solver.bat"), solver).unwrap();
    let program = tools.path().join("solver.bat").display().to_string();
    let mut backend = CommandBackend::new(words(&[&program, "{acf}"]), Duration::from_secs(5));
    let error = Task::new().sweep(&mut backend).expect_err("it never ends");
    assert!(error.contains("killed"), "{error}");
    let size = |path: &Path| std::fs::metadata(path).unwrap().len();
    // A process may take a moment to end.
    std::thread::sleep(Duration::from_secs(1));
    let before = (size(&first), size(&second));
    assert!(before.0 > 0 && before.1 > 0);
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!((size(&first), size(&second)), before);
}

#[test]
fn a_file_that_somebody_reads_is_replaced_when_he_lets_go_and_told_of_if_he_does_not() {
    let place = folder(&[("a.adm", SLIDER)]);
    let path = place.path().join("a.adm");
    let held = || {
        // Opened like the C runtime, and thus MATLAB, does: others may read and write the file, but not remove it.
        let mut options = std::fs::File::options();
        options.read(true).share_mode(1 | 2).open(&path).unwrap()
    };
    let set = ["set", "a.adm", "SPRINGDAMPER/1.K=12", "--in-place"];
    let reader = held();
    let waiter = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(700));
        drop(reader);
    });
    let (code, said) = admire(place.path(), &set);
    waiter.join().unwrap();
    assert_eq!(code, Some(0), "{said}");
    assert!(std::fs::read_to_string(&path).unwrap().contains("K=12"));

    let _reader = held();
    let before = std::fs::read(&path).unwrap();
    let (code, said) = admire(
        place.path(),
        &["set", "a.adm", "SPRINGDAMPER/1.K=13", "--in-place"],
    );
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("another program may hold it open"), "{said}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
}

#[test]
fn a_deck_that_is_read_only_stays_so() {
    let place = folder(&[("a.adm", SLIDER)]);
    let path = place.path().join("a.adm");
    let mut permissions = std::fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();
    let (code, said) = admire(
        place.path(),
        &["set", "a.adm", "SPRINGDAMPER/1.K=12", "--in-place"],
    );
    assert_eq!(code, Some(0), "{said}");
    assert!(std::fs::read_to_string(&path).unwrap().contains("K=12"));
    assert!(std::fs::metadata(&path).unwrap().permissions().readonly());
}

#[test]
fn devices_are_refused_by_name() {
    let acf = "\nfile/model=slider, output_prefix=NUL\nsimulate/static\nstop\n";
    let place = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
    let ran = mdi(place.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("`NUL` is a Windows device"),
        "{}",
        ran.stdout
    );
    let ran = mdi(place.path(), &["ru-s", "CON"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("`CON` is a Windows device"),
        "{}",
        ran.stdout
    );
    for words in [
        &["check", "CON"][..],
        &["summary", "aux.adm"],
        &["set", "slider.adm", "SPRINGDAMPER/1.K=12", "-o", "AUX.adm"],
        &["set", "slider.adm", "SPRINGDAMPER/1.K=12", "-o", "out:1"],
    ] {
        let (code, said) = admire(place.path(), words);
        assert_eq!(code, Some(1), "{words:?}: {said}");
        let why = ["is a Windows device", "a colon may appear only"];
        assert!(
            why.iter().any(|why| said.contains(why)),
            "{words:?}: {said}"
        );
    }
}

#[test]
fn paths_may_be_longer_than_260_characters() {
    let place = folder(&[]);
    let mut deep = place.path().to_path_buf();
    while deep.as_os_str().len() < 300 {
        deep.push("a folder with a rather long name");
    }
    std::fs::create_dir_all(&deep).unwrap();
    std::fs::write(deep.join("slider.adm"), SLIDER).unwrap();
    let acf = deep.join("run.acf");
    let model = deep.join("slider").display().to_string();
    std::fs::write(
        &acf,
        format!("\nfile/model={model}, output_prefix={model}\nsimulate/static\nstop\n"),
    )
    .unwrap();
    let acf = acf.display().to_string();
    let ran = mdi(place.path(), &["-c", "ru-standard", "i", &acf, "exit"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(&deep, "slider.res").steps.len(), 1);
    let deck = format!("{model}.adm");
    let set = ["set", &deck, "SPRINGDAMPER/1.K=12"];
    let (code, said) = admire(place.path(), &[&set[..], &["--in-place"]].concat());
    assert_eq!(code, Some(0), "{said}");
    let copy = format!("{model}-2.adm");
    let (code, said) = admire(place.path(), &[&set[..], &["-o", &copy]].concat());
    assert_eq!(code, Some(0), "{said}");
    assert!(std::fs::read_to_string(&copy).unwrap().contains("K=12"));
}

#[test]
fn files_of_a_run_have_the_line_ends_of_windows() {
    let acf = "\nfile/model=SLIDER\nsimulate/static\nstop\n";
    let place = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
    let ran = mdi(place.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    // On Windows, file names that differ in case give no warning.
    assert!(!ran.stdout.contains("WARNING"), "{}", ran.stdout);
    for extension in ["res", "msg", "req"] {
        let text =
            std::fs::read_to_string(place.path().join(format!("slider.{extension}"))).unwrap();
        assert!(text.lines().count() > 3, "{extension}");
        assert_eq!(
            text.matches('\n').count(),
            text.matches("\r\n").count(),
            "{extension}"
        );
    }
}
