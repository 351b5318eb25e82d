//! Section `[solver]` of a study: an external program in one line, announced before its start; its runs are recorded and replayed.

use std::path::Path;
use std::process::{Command, Output};

use crate::run::{folder, text};

/// Copies the study of the corpus into a folder, with a `[solver]` section and at most three iterations of the loop.
fn study(folder: &Path, solver: &str, identify: &str) {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    for name in [
        "model.adm",
        "load_cases.csv",
        "marks_on_parts.csv",
        "marks_measured.csv",
    ] {
        std::fs::copy(corpus.join(name), folder.join(name)).unwrap();
    }
    let toml = format!(
        "[model]\ndeck = \"model.adm\"\n{solver}\n[loads]\nfile = \"load_cases.csv\"\n\
        columns = {{ vertical = \"SFORCE/3\", lateral = \"SFORCE/2\", longitudinal = \"SFORCE/1\" }}\n\
        [marks]\non_parts = \"marks_on_parts.csv\"\nmeasured = \"marks_measured.csv\"\nsigma = 0.05\n\
        [identify]\n{identify}\n[regression]\nmax_iterations = 3\n"
    );
    std::fs::write(folder.join("study.toml"), toml).unwrap();
}

fn admire(folder: &Path, words: &[&str], path: &str) -> Output {
    // A study that names its own program counts as foreign here.
    let starts = ["identify", "diagnose", "record"].contains(&words[0]);
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(words)
        .args(starts.then_some("--allow-command"))
        .env("NO_COLOR", "1")
        .env("PATH", path)
        // Folders of failed runs are kept, but here not longer than the study.
        .env("TMPDIR", folder)
        .output()
        .unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn folder_of_mdi() -> String {
    Path::new(env!("CARGO_BIN_EXE_mdi"))
        .parent()
        .unwrap()
        .display()
        .to_string()
}

fn values(folder: &Path) -> Vec<(String, f64)> {
    let json: serde_json::Value =
        serde_json::from_str(&text(folder, "identification.json")).unwrap();
    let parameters = json["parameters"].as_array().unwrap();
    parameters
        .iter()
        .map(|p| {
            (
                p["address"].as_str().unwrap().to_string(),
                p["value"].as_f64().unwrap(),
            )
        })
        .collect()
}

const REGRESSION: &str = "method = \"regression\"\nbushings = [\"BUSHING/1\", \"BUSHING/2\"]";

#[test]
fn one_line_changes_the_solver_and_a_recording_needs_none() {
    let place = folder(&[]);
    let folder = place.path();
    let path = folder_of_mdi();
    study(folder, "", REGRESSION);
    // Three iterations do not converge, which is reported.
    let native = admire(folder, &["identify", ".", "--out", "native"], "");
    assert_eq!(native.status.code(), Some(3), "{}", errors(&native));
    assert!(!errors(&native).contains("[runs-program]"));

    // The default command is the one of ADAMS; the PATH determines its `mdi`, and `admire` announces it before the start.
    study(folder, "[solver]\nbackend = \"command\"", REGRESSION);
    for format in ["text", "plain", "json"] {
        let run = admire(
            folder,
            &["identify", ".", "--out", "none", "--format", format],
            "/nonexistent",
        );
        let said = errors(&run);
        assert_eq!(run.status.code(), Some(3), "{said}");
        assert!(
            said.contains("runs-program") && said.contains("computer)"),
            "{format}: {said}"
        );
        assert!(said.contains("cannot be started"), "{said}");
    }
    let command = admire(
        folder,
        &["identify", ".", "--out", "command", "--keep", "-v"],
        &path,
    );
    // A long message is wrapped.
    let said = errors(&command).replace("\n  │ ", "");
    let shown = Path::new(&path).join(format!("mdi{}", std::env::consts::EXE_SUFFIX));
    assert!(said.contains(&shown.display().to_string()), "{said}");
    assert!(
        said.contains("the bushing forces of the results are in ground axes"),
        "{said}"
    );
    for ((address, a), (_, b)) in values(&folder.join("native"))
        .iter()
        .zip(values(&folder.join("command")))
    {
        assert!((a / b - 1.0).abs() < 1e-6, "{address}: {a} {b}");
    }
    let kept = std::fs::read_dir(folder.join("command/runs"))
        .unwrap()
        .count();

    let record = admire(folder, &["record", "."], &path);
    assert_eq!(record.status.code(), Some(3), "{}", errors(&record));
    let said = String::from_utf8_lossy(&record.stdout).into_owned();
    assert!(
        said.contains(&format!("recorded: {kept} of {kept}")),
        "{said}"
    );

    study(folder, "[solver]\nbackend = \"replay\"", REGRESSION);
    let replay = admire(
        folder,
        &["identify", ".", "--out", "replay"],
        "/nonexistent",
    );
    assert!(!errors(&replay).contains("[runs-program]"));
    assert_eq!(
        values(&folder.join("replay")),
        values(&folder.join("command"))
    );
    assert!(
        text(&folder.join("replay"), "identification.json").contains("\"backend\": \"replay\"")
    );

    // A deck that has changed since has no recording.
    let deck = text(folder, "model.adm");
    std::fs::write(
        folder.join("model.adm"),
        deck.replacen("KGRAV", "KGRAV ", 1),
    )
    .unwrap();
    let stale = admire(folder, &["identify", ".", "--out", "stale"], &path);
    assert_eq!(stale.status.code(), Some(3));
    assert!(
        errors(&stale).contains("no recorded run has this deck"),
        "{}",
        errors(&stale)
    );
    assert!(!folder.join("stale/identified.adm").exists());
}

#[test]
fn the_global_fit_says_why_it_got_no_answer() {
    let place = folder(&[]);
    let folder = place.path();
    let one = "bushings = [\"BUSHING/2\"]";
    study(
        folder,
        "[solver]\nbackend = \"replay\"\nrecordings = \"runs\"",
        one,
    );
    let run = admire(folder, &["identify", ".", "--out", "out"], "");
    assert_eq!(run.status.code(), Some(3));
    assert!(
        errors(&run).contains("no recorded run") && errors(&run).contains("runs"),
        "{}",
        errors(&run)
    );
    study(
        folder,
        "[solver]\nbackend = \"command\"\ncommand = [\"no-such-solver\", \"{acf}\"]",
        one,
    );
    let run = admire(folder, &["identify", ".", "--out", "out"], "");
    assert_eq!(run.status.code(), Some(3));
    assert!(
        errors(&run).contains("`no-such-solver` cannot be started"),
        "{}",
        errors(&run)
    );
}

/// Checks that links out of the study are detected, including links to files that do not exist yet.
#[cfg(unix)]
#[test]
fn no_link_leads_recordings_out_of_the_study() {
    let (place, outside) = (folder(&[]), folder(&[]));
    let link = std::os::unix::fs::symlink::<&Path, &Path>;
    let (up, dangling) = (place.path().join("up"), place.path().join("dangling"));
    link(outside.path(), &up).unwrap();
    link(&outside.path().join("new"), &dangling).unwrap();
    for recordings in [
        "up",
        "up/new",
        "up/new/deeper",
        "dangling",
        "dangling/x",
        "a/../../b",
    ] {
        let solver = format!("[solver]\nbackend = \"command\"\nrecordings = \"{recordings}\"");
        study(place.path(), &solver, REGRESSION);
        let run = admire(place.path(), &["record", "."], &folder_of_mdi());
        assert_eq!(run.status.code(), Some(1), "{recordings}: {}", errors(&run));
        assert!(errors(&run).contains("outside-study"), "{}", errors(&run));
    }
    assert_eq!(std::fs::read_dir(outside.path()).unwrap().count(), 0);
}

#[test]
fn recordings_lie_below_the_study() {
    for outside in ["../elsewhere", "/tmp/elsewhere"] {
        let place = folder(&[]);
        study(
            place.path(),
            &format!("[solver]\nbackend = \"replay\"\nrecordings = \"{outside}\""),
            REGRESSION,
        );
        let run = admire(place.path(), &["identify", ".", "--out", "out"], "");
        assert!(errors(&run).contains("outside-study"), "{}", errors(&run));
        assert_ne!(run.status.code(), Some(0));
    }
}

#[test]
fn no_file_of_a_study_lies_outside_of_it() {
    for (key, with) in [
        ("deck = \"model.adm\"", "deck = \"../model.adm\""),
        (
            "file = \"load_cases.csv\"",
            "file = \"PLACE/load_cases.csv\"",
        ),
        (
            "measured = \"marks_measured.csv\"",
            "measured = \"link.csv\"",
        ),
    ] {
        let place = folder(&[]);
        let inside = place.path().join("study");
        std::fs::create_dir(&inside).unwrap();
        study(&inside, "", REGRESSION);
        for name in ["model.adm", "load_cases.csv", "marks_measured.csv"] {
            std::fs::copy(inside.join(name), place.path().join(name)).unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(
            place.path().join("marks_measured.csv"),
            inside.join("link.csv"),
        )
        .unwrap();
        let toml = text(&inside, "study.toml");
        assert!(toml.contains(key));
        let with = with.replace("PLACE", &place.path().display().to_string());
        std::fs::write(inside.join("study.toml"), toml.replace(key, &with)).unwrap();
        let run = admire(&inside, &["identify", ".", "--out", "out"], "");
        assert!(
            cfg!(not(unix)) || errors(&run).contains("outside-study"),
            "{with}: {}",
            errors(&run)
        );
        assert!(!inside.join("out/identified.adm").exists(), "{with}");
    }
}

/// Writes an `adams` script that solves the deck of a run after an `edit` by sed, and then restores the deck.
#[cfg(unix)]
fn stand_in(folder: &Path, edit: &str) {
    let mdi = env!("CARGO_BIN_EXE_mdi");
    let script = format!(
        "#!/bin/sh\ncp run.adm kept\nsed '{edit}' kept > run.adm\n\
         '{mdi}' ru-standard \"$1\"\ncode=$?\nmv kept run.adm\nexit $code\n"
    );
    std::fs::write(folder.join("adams"), script).unwrap();
    let executable = Command::new("chmod")
        .args(["+x", "adams"])
        .current_dir(folder)
        .status()
        .unwrap();
    assert!(executable.success());
}

/// A force that only a subroutine of ADAMS defines, to be added to the deck.
const USER_FORCE: &str = "SFORCE/99, TRANSLATIONAL, I=20, J=48\n, FUNCTION=USER(1)\nEND";

#[cfg(unix)]
#[test]
fn what_only_adams_solves_is_left_to_it() {
    let place = folder(&[]);
    let folder = place.path();
    study(folder, "", REGRESSION);
    let plain = admire(folder, &["identify", ".", "--out", "plain"], "");
    assert_eq!(plain.status.code(), Some(3), "{}", errors(&plain));

    let deck = text(folder, "model.adm");
    let (before, _) = deck.rsplit_once("END").unwrap();
    std::fs::write(folder.join("model.adm"), format!("{before}{USER_FORCE}\n")).unwrap();
    let alone = admire(folder, &["identify", ".", "--out", "alone"], "");
    assert_eq!(alone.status.code(), Some(1), "{}", errors(&alone));
    assert!(errors(&alone).contains("user-written subroutine"));

    // An ADAMS with the subroutine, whose force is zero, beside the study; a relative path starts there.
    stand_in(folder, "s/USER(1)/0/");
    let solver = "[solver]\nbackend = \"command\"\ncommand = [\"./adams\", \"{acf}\"]";
    let toml = text(folder, "study.toml").replacen("[loads]", &format!("{solver}\n[loads]"), 1);
    std::fs::write(folder.join("study.toml"), toml).unwrap();
    let path = "/usr/local/bin:/usr/bin:/bin";
    let run = admire(folder, &["identify", ".", "--out", "adams.out"], path);
    assert!(
        errors(&run).contains("user-written subroutine"),
        "{}",
        errors(&run)
    );
    for ((address, a), (_, b)) in values(&folder.join("plain"))
        .iter()
        .zip(values(&folder.join("adams.out")))
    {
        assert!((a / b - 1.0).abs() < 1e-6, "{address}: {a} {b}");
    }
}

/// Checks that waiting for a licence is reported, with the message of the program.
#[cfg(unix)]
#[test]
fn waiting_for_a_licence_is_told() {
    let place = folder(&[]);
    let folder = place.path();
    let script = "mkdir ../refused 2>/dev/null && echo 'License request denied: all in use' && exit 1; exec mdi -c ru-standard i $0 exit";
    let solver = format!(
        "[solver]\nbackend = \"command\"\ncommand = ['sh', '-c', \"{}\", '{{acf}}']\nlicence_wait_s = 60",
        script.replace("../refused", &folder.join("refused").display().to_string())
    );
    study(folder, &solver, REGRESSION);
    let path = format!("{}:/usr/local/bin:/usr/bin:/bin", folder_of_mdi());
    let run = admire(folder, &["identify", ".", "--out", "out"], &path);
    let told =
        "no licence (License request denied: all in use): requesting it again for up to 60 s";
    assert_eq!(errors(&run).matches(told).count(), 1, "{}", errors(&run));
    assert!(folder.join("out/identification.json").exists());
}

/// Checks that a diagnosis, which searches with the built-in solver, first reports the difference from the study's solver.
///
/// The difference is large for a stand-in with another spring, and zero for `mdi` itself.
#[cfg(unix)]
#[test]
fn a_diagnosis_says_first_how_the_solvers_differ() {
    let place = folder(&[]);
    let folder = place.path();
    stand_in(folder, "s/K = 60.0$/K = 58.0/");
    let path = format!("{}:/usr/local/bin:/usr/bin:/bin", folder_of_mdi());
    let diagnosed = |command: &str, out: &str| -> serde_json::Value {
        let solver = format!("[solver]\nbackend = \"command\"\ncommand = {command}");
        let gauss = "method = \"gauss-newton\"\nbushings = [\"BUSHING/1\", \"BUSHING/2\"]";
        study(folder, &solver, gauss);
        let run = admire(folder, &["diagnose", ".", "--out", out, "-v"], &path);
        assert_eq!(run.status.code(), Some(0), "{}", errors(&run));
        let said = String::from_utf8_lossy(&run.stdout).into_owned();
        let first = said
            .lines()
            .find(|line| line.starts_with("With the fitted"));
        assert!(first.is_some(), "{said}");
        // The last lines also state a difference that matters.
        let words: Vec<&str> = said.split_whitespace().collect();
        let warned = words
            .join(" ")
            .contains("the findings may be due to this difference");
        assert_eq!(warned, out == "other", "{said}");
        serde_json::from_str(&text(&folder.join(out), "diagnosis.json")).unwrap()
    };
    let other = diagnosed("[\"./adams\", \"{acf}\"]", "other");
    assert!(
        other["solver"]["rms"].as_f64().unwrap() > 0.05,
        "{}",
        other["solver"]
    );
    let [own, foreign] = [0, 1].map(|k| other["solver"]["residual_rms"][k].as_f64().unwrap());
    assert!(foreign > 1.2 * own, "{own} {foreign}");
    // The parameters are fitted to the other solver and explain the readings as well as its law permits.
    let refitted = other["solver"]["refitted_rms"].as_f64().unwrap();
    assert!(refitted < 0.9 * foreign, "{refitted} {foreign}");

    let same = diagnosed(
        "[\"mdi\", \"ru-standard\", \"i\", \"{acf}\", \"exit\"]",
        "same",
    );
    assert_eq!(same["solver"]["solver"], "command");
    // Agreement to the digits of a .res.
    assert!(
        same["solver"]["rms"].as_f64().unwrap() < 1e-5,
        "{}",
        same["solver"]
    );
    let of = |diagnosis: &serde_json::Value, k: usize| {
        let parameter = &diagnosis["parameters"][k];
        ["value", "std_error"].map(|key| parameter[key].as_f64().unwrap())
    };
    let count = same["parameters"].as_array().unwrap().len();
    let apart = (0..count).map(|k| {
        let ([a, sd], [b, _]) = (of(&same, k), of(&other, k));
        (a - b).abs() / sd
    });
    // With the built-in solver alone the parameters would be equal.
    assert!(apart.fold(0.0, f64::max) > 0.02);
}

/// Checks that the program of a foreign study is started only with permission; without a terminal the option is named.
#[cfg(unix)]
#[test]
fn a_program_of_a_study_from_elsewhere_needs_permission() {
    let place = folder(&[]);
    let all = place.path();
    let settings = all.join("settings");
    let run = |folder: &Path, words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder)
            .args(words)
            .env("XDG_CONFIG_HOME", &settings)
            .env("PATH", "/usr/local/bin:/usr/bin:/bin")
            .env("TMPDIR", all)
            .output()
            .unwrap();
        (output.status.code(), errors(&output))
    };
    let touches = |mark: &Path| {
        let script = format!("touch {}; exit 7", mark.display());
        format!("[solver]\nbackend = \"command\"\ncommand = ['sh', '-c', '{script}', '{{acf}}']\n")
    };
    let foreign = all.join("foreign");
    std::fs::create_dir(&foreign).unwrap();
    let mark = all.join("started");
    study(&foreign, &touches(&mark), REGRESSION);
    for words in [
        &["identify", ".", "--out", "out"][..],
        &["diagnose", ".", "--out", "out"],
        &["record", "."],
        &["doctor", "."],
    ] {
        let (code, said) = run(&foreign, words);
        assert_eq!(code, Some(2), "{words:?}: {said}");
        assert!(said.contains("--allow-command"), "{words:?}: {said}");
        assert!(!mark.exists() && !foreign.join("out").exists(), "{words:?}");
    }
    let plan = "study = \".\"\n[sampling]\nplan = \"random\"\ncases = 2\n[[vary]]\naddress = \"BUSHING/1.K.1\"\n\
                uniform = [9000.0, 11000.0]\n[[keep]]\nidentification = \"chi_square\"\n";
    std::fs::write(foreign.join("sweep.toml"), plan).unwrap();
    let (code, said) = run(&foreign, &["sweep", "sweep.toml", "--out", "swept"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("--allow-command") && !foreign.join("swept").exists(),
        "{said}"
    );
    std::fs::write(
        foreign.join("own.toml"),
        format!(
            "deck = \"model.adm\"\ncommands = \"run.acf\"\n[sampling]\nplan = \"random\"\ncases = 2\n[[vary]]\naddress = \"BUSHING/1.K.1\"\n\
             uniform = [9000.0, 11000.0]\n[[keep]]\ncolumn = \"KNUCKLE_XFORM.Z\"\n{}",
            touches(&mark).replace("backend = \"command\"\n", "")
        ),
    )
    .unwrap();
    std::fs::write(foreign.join("run.acf"), "\nfile/model=model\nSIM/STAT\n").unwrap();
    let (code, said) = run(&foreign, &["sweep", "own.toml", "--out", "swept"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("--allow-command") && !mark.exists(), "{said}");

    // The option starts the program, for this call only.
    let (code, said) = run(
        &foreign,
        &["identify", ".", "--out", "out", "--allow-command"],
    );
    assert_eq!(code, Some(3), "{said}");
    assert!(mark.exists() && said.contains("exit code 7"), "{said}");
    std::fs::remove_file(&mark).unwrap();
    assert_eq!(run(&foreign, &["identify", ".", "--out", "out"]).0, Some(2));

    // A study created here is the user's own; a copy of it elsewhere is not.
    let deck = foreign.join("model.adm").display().to_string();
    let (code, said) = run(all, &["new", "own", "--from", &deck]);
    assert_eq!(code, Some(0), "{said}");
    let own = all.join("own");
    study(&own, &touches(&mark), REGRESSION);
    let (code, said) = run(all, &["identify", "own", "--out", "answer"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(mark.exists(), "{said}");
    let copy = all.join("copy");
    std::fs::create_dir(&copy).unwrap();
    study(&copy, &touches(&mark), REGRESSION);
    assert_eq!(
        run(all, &["identify", "copy", "--out", "answer2"]).0,
        Some(2)
    );
}
