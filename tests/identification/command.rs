//! The command backend: it gives the results of the built-in solver if it runs our own `mdi`, and no results if a program misbehaves.

use std::time::Duration;

use admire_identify::{LoadedStudy, regression};
use admire_session::backend::{Backend, CommandBackend, NativeBackend, SweepRequest};

fn study(method: &str) -> LoadedStudy {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let mut loaded = LoadedStudy::read(&folder).value.unwrap();
    assert_eq!(method, "regression");
    loaded.study.regression.max_iterations = 6;
    loaded
}

fn mdi() -> Vec<String> {
    let words = [
        env!("CARGO_BIN_EXE_mdi"),
        "-c",
        "ru-standard",
        "i",
        "{acf}",
        "exit",
    ];
    words.map(String::from).to_vec()
}

#[test]
fn regression_agrees_on_both_backends() {
    let loaded = study("regression");
    let problem = loaded.problem();
    let mut quiet = |_: usize, _: &[f64], _: f64| std::ops::ControlFlow::Continue(());
    let native = regression::identify(&problem, &mut NativeBackend::new(), &mut quiet).unwrap();
    let mut external = CommandBackend::new(mdi(), Duration::from_secs(60));
    let command = regression::identify(&problem, &mut external, &mut quiet).unwrap();
    assert_eq!(command.backend, "command");
    for (a, b) in native.parameters.iter().zip(&command.parameters) {
        assert!(
            (a.value / b.value - 1.0).abs() < 1e-6,
            "{}: {} {}",
            a.address,
            a.value,
            b.value
        );
    }
}

#[test]
fn nothing_of_a_bad_run_is_taken_for_an_answer() {
    let loaded = study("regression");
    let request = SweepRequest {
        dataset: &loaded.dataset,
        model: &loaded.model,
        theta: &[],
        programme: &loaded.programme,
    };
    let run = |words: &[&str], seconds: f64| {
        let words = words.iter().map(ToString::to_string).collect();
        let mut backend = CommandBackend::new(words, Duration::from_secs_f64(seconds));
        let error = backend.sweep(&request).unwrap_err().to_string();
        let folder = error
            .rsplit_once("(files kept in ")
            .map(|(_, rest)| rest.trim_end_matches(')').to_string());
        if let Some(folder) = folder {
            assert!(
                std::path::Path::new(&folder).join("run.adm").exists(),
                "{error}"
            );
            std::fs::remove_dir_all(folder).unwrap();
        }
        error
    };
    let fake = env!("CARGO_BIN_EXE_mdi");
    assert!(run(&["no-such-program-anywhere"], 5.0).contains("cannot be started"));
    // A program that exits successfully without writing results.
    assert!(
        run(&[fake, "-c", "ru-standard", "i", "absent.acf", "exit"], 5.0).contains("exit code")
    );
    if cfg!(unix) {
        assert!(run(&["sleep", "30"], 0.2).contains("killed after 0.2 s"));
        assert!(run(&["true"], 5.0).contains("no results file"));
        assert!(run(&["false"], 5.0).contains("exit code 1"));
        let after = |script: &str| {
            let script = format!("'{fake}' -c ru-standard i run.acf exit >/dev/null; {script}");
            run(&["sh", "-c", &script], 20.0)
        };
        assert!(
            after("exit 3").contains("exit code 3"),
            "good results, bad exit code"
        );
        assert!(after("head -c 20000 run.res > x; mv x run.res").contains("results file"));
        let less = "awk '/<Step type=.static/ && !d {d=1; s=1} !s {print} /<.Step>/ {s=0}' run.res > x; mv x run.res";
        let error = after(less);
        assert!(error.contains("12 equilibria for 13 load cases"), "{error}");
        assert!(after("echo 'ERROR: could not checkout license' >> run.msg").contains("licence"));
        assert!(after("kill -9 $$").contains("crash"));
    }
}

/// Checks that a run is repeated while the licence server refuses a licence, until the run gets one.
#[test]
#[cfg(unix)]
fn a_refused_licence_is_waited_for() {
    let loaded = study("regression");
    let request = SweepRequest {
        dataset: &loaded.dataset,
        model: &loaded.model,
        theta: &[],
        programme: &loaded.programme,
    };
    let seen = tempfile::tempdir().unwrap();
    let script = format!(
        "if mkdir {seen}/refused 2>/dev/null; then echo 'License request denied: all in use' >&2; exit 1; fi; \
         exec {mdi} -c ru-standard i run.acf exit",
        seen = seen.path().display(),
        mdi = env!("CARGO_BIN_EXE_mdi"),
    );
    let command = ["sh", "-c", &script].map(String::from).to_vec();
    let mut backend = CommandBackend::new(command, Duration::from_secs(60));
    let refused = backend.sweep(&request).unwrap_err();
    assert!(refused.to_string().contains("denied"), "{refused}");
    std::fs::remove_dir(seen.path().join("refused")).unwrap();
    backend.licence_wait = Duration::from_secs(60);
    let sweep = backend.sweep(&request).unwrap();
    assert_eq!(sweep.cases.len(), loaded.programme.cases.len());
}

/// Checks that Ctrl-C ends a diagnosis after its current step. The diagnosis writes its results so far, marked as interrupted, and states the
/// folder.
#[test]
#[cfg(unix)]
fn an_interrupted_diagnosis_writes_what_it_has() {
    let study = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/kc-experiment");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["diagnose", "--out"])
        .args([&out, &study])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    let interrupt = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.starts_with("interrupted, so far "), "{said}");
    assert!(said.contains("out/report.html"), "{said}");
    let json = std::fs::read_to_string(out.join("diagnosis.json")).unwrap();
    assert!(json.contains("\"interrupted\": true"), "{json}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("The diagnosis was interrupted; the result is preliminary."));
    assert!(out.join("extended.adm").exists());
}

/// Checks that `--budget` ends a diagnosis with what it has, and that the answer, the JSON and the page say so. A budget that is no time is
/// refused.
#[test]
fn a_diagnosis_keeps_its_budget_of_time() {
    let study = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/kc-experiment");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = |budget: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(["diagnose", "--budget", budget, "--out"])
            .args([&out, &study])
            .output()
            .unwrap()
    };
    let ended = run("0.2");
    let said = String::from_utf8_lossy(&ended.stdout);
    assert_eq!(ended.status.code(), Some(0), "{said}");
    assert!(
        said.starts_with("stopped by the time limit, so far "),
        "{said}"
    );
    assert!(said.contains("a larger `--budget`"), "{said}");
    let json = std::fs::read_to_string(out.join("diagnosis.json")).unwrap();
    assert!(json.contains("\"interrupted\": true"), "{json}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("The diagnosis reached its time limit; the result is preliminary."));
    for wrong in ["soon", "-1"] {
        assert_eq!(run(wrong).status.code(), Some(2), "{wrong}");
    }
}

/// Checks that Ctrl-C ends a run after its current step. The run keeps its results, reports the interruption, and exits with 130 as shells do.
#[test]
#[cfg(unix)]
fn an_interrupted_run_keeps_what_it_found() {
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    // With this step test, which is never met, the run would take hours.
    let settings = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&settings).unwrap()
        + "\n[regression]\nepsilon = 1e-12\nmax_iterations = 1000000\n";
    std::fs::write(&settings, text).unwrap();
    let out = folder.path().join("out");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["identify", "--method", "regression", "--out"])
        .args([&out, folder.path()])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    assert!(child.try_wait().unwrap().is_none(), "it still runs");
    let interrupt = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let json = std::fs::read_to_string(out.join("identification.json")).unwrap();
    assert!(json.contains("\"converged\": false"), "{json}");
    assert!(json.contains("\"interrupted\": true"), "{json}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("stopped before the step test was met"));
    assert!(out.join("identified.adm").exists());
}
