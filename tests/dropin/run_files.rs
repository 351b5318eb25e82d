//! Files given to an external solver, the folders of its runs, and recordings of runs.

use std::path::Path;

use admire_session::backend::{Backend, Recording, ReplayBackend};
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use crate::run::folder;
use crate::task::{DECK, Task, after, backend, mdi, words};

#[test]
fn runs_are_kept_where_they_are_wanted_and_nowhere_else() {
    let place = folder(&[]);
    let task = Task::new();
    let mut quiet = backend(mdi());
    quiet.keep = Some(place.path().join("runs"));
    task.sweep(&mut quiet).unwrap();
    task.sweep(&mut quiet).unwrap();
    let mut names: Vec<String> = std::fs::read_dir(place.path().join("runs"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names.len(), 2);
    assert!(
        names[0].starts_with("run-0001-") && names[1].starts_with("run-0002-"),
        "{names:?}"
    );

    // The temporary folder of a good run is removed; the program writes down its path.
    if cfg!(unix) {
        let note = place.path().join("where");
        let mut backend = backend(after(&format!("pwd > '{}'", note.display())));
        task.sweep(&mut backend).unwrap();
        let there = std::fs::read_to_string(&note).unwrap();
        assert!(
            !there.trim().is_empty() && !Path::new(there.trim()).exists(),
            "{there}"
        );
    }
}

#[test]
fn recorded_runs_are_served_by_their_content() {
    let place = folder(&[]);
    let recording = Recording::new(place.path().join("recorded"));
    let mut task = Task::new();
    let mut recorder = backend(mdi());
    recorder.record = Some(recording.clone());
    let recorded = task.sweep(&mut recorder).unwrap();
    assert_eq!(recording.count(), 1);

    let mut replay = ReplayBackend::new(recording.clone());
    assert_eq!(replay.sweep(&task.request()).unwrap(), recorded);
    assert!(replay.remarks()[0].contains("ground axes"));

    // Another stiffness or load is another run.
    task.theta = vec![(task.at("BUSHING/1.K.1"), 101.0)];
    let missing = replay.sweep(&task.request()).unwrap_err();
    assert!(missing.is_lasting());
    let missing = missing.to_string();
    assert!(
        missing.contains("no recorded run") && missing.contains("1 run in"),
        "{missing}"
    );
    task.theta.clear();
    task.programme.cases[1].values[0] = 201.0;
    assert!(replay.sweep(&task.request()).is_err());
    task.programme.cases[1].values[0] = 200.0;

    // A damaged recording is not accepted either.
    let run = std::fs::read_dir(&recording.folder)
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let whole = std::fs::read(run.join("run.res")).unwrap();
    std::fs::write(run.join("run.res"), &whole[..whole.len() / 2]).unwrap();
    assert!(replay.sweep(&task.request()).is_err());
    std::fs::write(run.join("run.res"), &whole).unwrap();
    std::fs::write(run.join("run.adm"), DECK.replace("K=100", "K=300")).unwrap();
    assert!(
        replay
            .sweep(&task.request())
            .unwrap_err()
            .to_string()
            .contains("no recorded run")
    );
}

/// Returns the deck and command file of a task, from the files kept after a program that cannot be started.
fn given(task: &Task) -> (String, String) {
    let mut backend = backend(words(&["no-such-program-anywhere"]));
    let error = task.sweep(&mut backend).unwrap_err();
    let (_, rest) = error.rsplit_once("(files kept in ").expect(&error);
    let kept = Path::new(rest.trim_end_matches(')')).to_path_buf();
    let read = |name: &str| String::from_utf8(std::fs::read(kept.join(name)).unwrap()).unwrap();
    let files = (read("run.adm"), read("run.acf"));
    std::fs::remove_dir_all(kept).unwrap();
    files
}

#[test]
fn the_deck_is_the_users_own_but_for_the_lines_that_are_meant() {
    let mut task = Task::new();
    let (deck, commands) = given(&task);
    assert_eq!(deck, DECK);
    // A blank first line and then the model, as ADAMS/View writes for the C++ solver.
    assert!(commands.starts_with("\nfile/model=run\n"), "{commands}");
    assert_eq!(
        commands.lines().skip(2).collect::<Vec<_>>(),
        [
            "! case a",
            "SFORCE/1, FUNCTION=100.0",
            "SFORCE/2, FUNCTION=30.0",
            "simulate/static",
            "! case b",
            "SFORCE/1, FUNCTION=200.0",
            "SFORCE/2, FUNCTION=-20.0",
            "simulate/static",
            "stop"
        ]
    );
    task.theta = vec![(task.at("BUSHING/1.K.2"), 250.0)];
    let (deck, _) = given(&task);
    let changed: Vec<_> = deck
        .lines()
        .zip(DECK.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(changed.len(), 1);
    assert_eq!(
        changed[0].0,
        "BUSHING/1, I=20, J=1, K=100, 250, 400, KT=1E5, 1E5, 1E5"
    );
    assert_eq!(deck.lines().count(), DECK.lines().count());

    // XRF results are requested if the deck does not request them.
    let of = |text: &str| {
        let dataset = Dataset::parse(Source::new("block.adm", text.as_bytes())).value;
        let model = Model::lower(&dataset).value;
        given(&Task {
            dataset,
            model,
            ..Task::new()
        })
        .0
    };
    let deck = of(&DECK.replace("RESULTS/XRF", "RESULTS/FORMATTED"));
    assert_eq!(deck, DECK.replace("RESULTS/XRF", "RESULTS/FORMATTED, XRF"));
    let deck = of(&DECK.replace("RESULTS/XRF\n", "").replace('\n', "\r\n"));
    assert!(deck.contains("RESULTS/") && deck.contains("XRF"), "{deck}");
    assert!(deck.lines().count() <= DECK.lines().count() + 2);
    assert!(
        deck.matches('\n').count() == deck.matches("\r\n").count(),
        "{deck:?}"
    );
}

#[test]
fn files_that_a_deck_names_come_along() {
    let place = folder(&[]);
    let study = place.path().join("study");
    std::fs::create_dir_all(study.join("curves")).unwrap();
    let curve = |top: f64| {
        format!(
            "[MDI_HEADER]\nFILE_TYPE='spr'\n[CURVE]\n{{disp force}}\n-10 {0}\n-5 {1}\n5 -{1}\n10 -{0}\n",
            2.0 * top,
            top
        )
    };
    std::fs::write(study.join("curves/a.spr"), curve(500.0)).unwrap();
    std::fs::write(place.path().join("secret.spr"), curve(1.0)).unwrap();
    let text = DECK.replacen(
        "EQUILIBRIUM",
        "SPLINE/1, FILE=curves/a.spr\nSTRING/2, STRING=../secret.spr\n\
        SFORCE/3, TRANSLATIONAL, ACTIONONLY, I=20, J=3\n, FUNCTION = AKISPL(DZ(20,3),0,1)\nEQUILIBRIUM",
        1,
    );
    let deck = study.join("deck.adm");
    std::fs::write(&deck, &text).unwrap();
    let dataset = Dataset::parse(Source::new(deck.display().to_string(), text.as_bytes())).value;
    let model = Model::lower(&dataset).value;
    let task = Task {
        dataset,
        model,
        ..Task::new()
    };
    let mut first = backend(mdi());
    first.keep = Some(place.path().join("runs"));
    let sweep = task.sweep(&mut first).unwrap();
    // Along z the spring of the file adds 100 newton per millimetre to the 400 of the bushing.
    let p = sweep.equilibrium(0).unwrap().poses[1].p;
    assert!((p.z - 100.0 / 500.0).abs() < 1e-6, "{p}");
    let run = std::fs::read_dir(place.path().join("runs"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    assert!(run.join("curves/a.spr").is_file());
    assert!(!place.path().join("runs/secret.spr").exists() && !run.join("secret.spr").exists());
    // Another curve is another run.
    let recording = Recording::new(place.path().join("recorded"));
    first.record = Some(recording.clone());
    task.sweep(&mut first).unwrap();
    let mut replay = ReplayBackend::new(recording);
    assert!(replay.sweep(&task.request()).is_ok());
    std::fs::write(study.join("curves/a.spr"), curve(600.0)).unwrap();
    assert!(replay.sweep(&task.request()).is_err());
}
