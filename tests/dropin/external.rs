//! Any ADAMS command line behind the backend: programs that behave badly in every way, and what is kept and said of their runs.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use admire::backend::{
    Backend, CommandBackend, ForceFrame, Load, LoadCase, LoadProgramme, Recording, ReplayBackend,
    Sweep, SweepRequest,
};
use admire::model::Model;
use admire::results::{Change, XrfReader, rewrite_file};
use admire::syntax::{Address, Dataset};
use admire::text::Source;

use crate::run::folder;

/// A block on a bushing whose J marker is turned by a quarter about z, so that ground axes and J axes differ.
const DECK: &str = "\
A block on a bushing
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, REULER=90D,0D,0D
PART/2, MASS=2, CM=20, IP=100, 100, 100
MARKER/20, PART=2, REULER=90D,0D,0D
MARKER/3, PART=1
MARKER/4, PART=1, REULER=90D,90D,0D
BUSHING/1, I=20, J=1, K=100, 200, 400, KT=1E5, 1E5, 1E5
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=3
, FUNCTION = 0
SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=20, J=4
, FUNCTION = 0
EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8
RESULTS/XRF
END
";

/// A deck, its cases and what is changed of it between runs.
struct Task {
    dataset: Dataset,
    model: Model,
    programme: LoadProgramme,
    theta: Vec<(Address, f64)>,
}

impl Task {
    fn new() -> Self {
        let dataset = Dataset::parse(Source::new("block.adm", DECK.as_bytes())).value;
        let model = Model::lower(&dataset).value;
        let load = |id: u32| Load {
            name: format!("load {id}"),
            target: Address::parse(&format!("SFORCE/{id}"), &dataset).unwrap(),
        };
        let case = |label: &str, values: [f64; 2]| LoadCase {
            label: label.to_string(),
            values: values.to_vec(),
        };
        let loads = vec![load(1), load(2)];
        Self {
            dataset,
            model,
            programme: LoadProgramme {
                loads,
                cases: vec![case("a", [100.0, 30.0]), case("b", [200.0, -20.0])],
            },
            theta: Vec::new(),
        }
    }

    fn at(&self, address: &str) -> Address {
        Address::parse(address, &self.dataset).unwrap()
    }

    fn request(&self) -> SweepRequest<'_> {
        SweepRequest {
            dataset: &self.dataset,
            model: &self.model,
            theta: &self.theta,
            programme: &self.programme,
        }
    }

    fn sweep(&self, backend: &mut CommandBackend) -> Result<Sweep, String> {
        backend
            .sweep(&self.request())
            .map_err(|error| error.to_string())
    }
}

fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

fn mdi() -> Vec<String> {
    words(&[
        env!("CARGO_BIN_EXE_mdi"),
        "-c",
        "ru-standard",
        "i",
        "{acf}",
        "exit",
    ])
}

/// A program that runs `mdi` and then a piece of shell.
fn after(script: &str) -> Vec<String> {
    let mdi = env!("CARGO_BIN_EXE_mdi");
    words(&[
        "sh",
        "-c",
        &format!("'{mdi}' -c ru-standard i run.acf exit >/dev/null; {script}"),
    ])
}

fn backend(command: Vec<String>) -> CommandBackend {
    CommandBackend::new(command, Duration::from_secs(30))
}

/// What a bad run is called; its folder must have been kept, and is removed.
fn refusal(command: Vec<String>, task: &Task) -> String {
    let mut backend = backend(command);
    let error = task
        .sweep(&mut backend)
        .expect_err("nothing of a bad run is an answer");
    let (_, rest) = error.rsplit_once("(files kept in ").expect(&error);
    let kept = Path::new(rest.trim_end_matches(')'));
    assert!(
        kept.join("run.adm").is_file() && kept.join("run.acf").is_file(),
        "{error}"
    );
    std::fs::remove_dir_all(kept).unwrap();
    assert_eq!(backend.tally(), (1, 1));
    error
}

/// Results of a good run, to be tampered with.
fn good_results(into: &Path) -> PathBuf {
    let task = Task::new();
    let mut backend = backend(mdi());
    backend.keep = Some(into.join("runs"));
    task.sweep(&mut backend).unwrap();
    let run = std::fs::read_dir(into.join("runs"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    run.path().join("run.res")
}

/// Ids of columns of the bushing.
fn columns(results: &Path, entity: &str, names: &[&str]) -> Vec<usize> {
    let reader = XrfReader::open("run.res", std::fs::File::open(results).unwrap()).unwrap();
    let entity = reader
        .catalogue()
        .entities
        .iter()
        .find(|e| e.name == entity)
        .unwrap();
    names
        .iter()
        .map(|name| entity.component(name).unwrap().id)
        .collect()
}

#[test]
fn the_answer_of_a_good_run_is_the_law_of_the_bushing() {
    let task = Task::new();
    let sweep = task.sweep(&mut backend(mdi())).unwrap();
    // SFORCE/1 pushes along ground z (K 400); SFORCE/2 along the z axis of marker 4: REULER 90, 90, 0 turns z to ground x, which is
    // -y of J (K 200).
    let p = sweep.equilibrium(0).unwrap().poses[1].p;
    assert!((p.z - 100.0 / 400.0).abs() < 1e-9, "{p}");
    assert!((p.x - 30.0 / 200.0).abs() < 1e-9 && p.y.abs() < 1e-9, "{p}");
}

#[cfg(unix)]
#[test]
fn no_bad_run_is_taken_for_an_answer() {
    let task = Task::new();
    let place = folder(&[]);
    let good = good_results(place.path());
    let good = good.display();
    let says = |command: Vec<String>, part: &str| {
        let error = refusal(command, &task);
        assert!(error.contains(part), "expected `{part}` in: {error}");
        error
    };
    // Cut off half-way, with a good exit code.
    says(
        after("sed '/TerminationStatus/,$d' run.res > x; mv x run.res"),
        "ends before the run did",
    );
    says(
        after("head -c 3000 run.res > x; mv x run.res"),
        "the file ends",
    );
    // A step too few, and messages that claim all converged.
    let less = "awk '/<Step type=.quasiStatic/ && !d {d=1; s=1} !s {print} /<.Step>/ {s=0}' run.res > x; mv x run.res";
    says(after(less), "1 equilibria for 2 load cases");
    // Good results, bad exit code.
    says(after("exit 3"), "exit code 3");
    says(after("kill -9 $$"), "a crash");
    // No licence, said on the console alone.
    says(
        words(&["sh", "-c", "echo 'Adams Solver: license request denied'"]),
        "no licence: Adams",
    );
    // The file of an earlier run, copied back with its time of writing.
    says(
        words(&["cp", "-p", &good.to_string(), "run.res"]),
        "that of an earlier one",
    );
    // That of another model.
    says(
        after("sed 's/A block on a bushing/Another block/' run.res > x; mv x run.res"),
        "another model, `Another",
    );
    says(
        after("sed 's/length=\"mm\"/length=\"meter\"/' run.res > x; mv x run.res"),
        "are in meter",
    );
    says(
        after("sed 's/^0.25 /nan /; s/ 0.25 / nan /; s/ 0.25$/ nan/' run.res > x; mv x run.res"),
        "holds values that are no numbers",
    );
    // A program that changes the deck it was given has not solved what was asked.
    says(
        after("echo '! changed' >> run.adm"),
        "no longer what the run was given",
    );
    // The report ends with the tail of the log.
    let error = says(
        words(&["sh", "-c", "echo first; echo 'the solver gave up'; exit 7"]),
        "exit code 7",
    );
    assert!(error.contains("first\nthe solver gave up"), "{error}");
    let error = says(
        words(&["sh", "-c", "echo 'no time for results'"]),
        "no results file",
    );
    assert!(error.contains("no time for results"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_run_that_hangs_is_killed_with_all_it_started() {
    let task = Task::new();
    let place = folder(&[]);
    let id = place.path().join("id");
    // As ADAMS' own script does: the solver is a child of the program that was started.
    let script = format!(
        "echo started; sh -c 'echo $$ > \"{}\"; sleep 60; true' & wait",
        id.display()
    );
    let mut backend = CommandBackend::new(words(&["sh", "-c", &script]), Duration::from_secs(1));
    let start = Instant::now();
    let error = task.sweep(&mut backend).unwrap_err();
    assert!(start.elapsed() < Duration::from_secs(20));
    assert!(
        error.contains("killed after 1 s") && error.contains("started"),
        "{error}"
    );
    let child = std::fs::read_to_string(&id).unwrap();
    let alive = || {
        let list = std::process::Command::new("ps")
            .args(["-o", "stat=", "-p", child.trim()])
            .output()
            .unwrap();
        let state = String::from_utf8_lossy(&list.stdout).trim().to_string();
        !(state.is_empty() || state.starts_with('Z'))
    };
    for _ in 0..50 {
        if !alive() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(!alive(), "the solver behind the program still runs");
}

#[cfg(unix)]
#[test]
fn a_stale_file_with_other_stiffnesses_does_not_fit_its_own_law() {
    let place = folder(&[]);
    let good = good_results(place.path());
    let mut task = Task::new();
    task.theta = vec![(task.at("BUSHING/1.K.3"), 500.0)];
    // Copied anew, so that its time tells nothing.
    let error = refusal(
        words(&["cp", &good.display().to_string(), "run.res"]),
        &task,
    );
    assert!(
        error.contains("the force of BUSHING/1 fits its deflection neither"),
        "{error}"
    );
}

#[cfg(unix)]
#[test]
fn the_frame_of_bushing_forces_is_found_and_named() {
    let place = folder(&[]);
    let good = good_results(place.path());
    let ids = columns(&good, "BUSHING_1", &["FX", "FY", "TX", "ANGX"]);
    let serve = |changes: &[Change]| {
        let file = place.path().join("tampered.res");
        rewrite_file(&good, &file, changes).unwrap();
        let mut backend = backend(words(&["cp", &file.display().to_string(), "run.res"]));
        (
            Task::new().sweep(&mut backend).map(|_| backend.remarks()),
            backend,
        )
    };
    let (remarks, _) = serve(&[]);
    assert!(
        remarks.unwrap()[0].contains("in ground axes"),
        "our own files"
    );
    // Steps 1 and 2 are the load cases. Force on I in ground axes: (-30, 0) and (20, 0) newton along x and y; J is turned by a
    // quarter about z, so that in its axes this is (0, 30) and (0, -20).
    let in_j = |step: usize, force: f64| {
        [(0, 0.0), (1, force)].map(|(k, value)| Change {
            step,
            id: ids[k],
            value,
        })
    };
    let (remarks, _) = serve(&[in_j(1, 30.0), in_j(2, -20.0)].concat());
    assert!(remarks.unwrap()[0].contains("axes of the J marker"));
    // One step in ground axes, the other in J axes: contradicts itself.
    let (error, _) = serve(&in_j(2, -20.0));
    assert!(
        error
            .unwrap_err()
            .contains("does not fit its deflection in ground axes")
    );
    for (column, what) in [
        (2, "neither in ground axes nor in those of its J marker"),
        (3, "the angles of BUSHING/1"),
    ] {
        let (error, _) = serve(&[Change {
            step: 1,
            id: ids[column],
            value: 0.5,
        }]);
        let error = error.unwrap_err();
        assert!(error.contains(what), "{error}");
    }
    assert_eq!(ForceFrame::J.to_string(), "the axes of the J marker");
}

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

    // A temporary folder of a good run is gone: the program says where it ran.
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

#[cfg(unix)]
#[test]
fn no_more_runs_go_at_a_time_than_jobs_says() {
    let task = Task::new();
    let place = folder(&[]);
    for jobs in [1, 2, 3] {
        let log = place.path().join(format!("log{jobs}"));
        let script = format!("echo + >> '{0}'; sleep 0.3; echo - >> '{0}'", log.display());
        let mut backend = backend(after(&script));
        backend.jobs = jobs;
        let answers = backend.sweeps(&[task.request(); 4]);
        assert_eq!(answers.len(), 4);
        let single = task.sweep(&mut self::backend(mdi())).unwrap();
        assert!(answers.into_iter().all(|answer| answer.unwrap() == single));
        let (mut now, mut most) = (0, 0);
        for line in std::fs::read_to_string(&log).unwrap().lines() {
            now += if line == "+" { 1 } else { -1 };
            most = most.max(now);
        }
        assert!(
            now == 0 && most <= jobs as i32,
            "{most} runs at a time for {jobs}"
        );
        // Two sleeps of the same length side by side overlap.
        assert!(jobs == 1 || most > 1);
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

    // Another stiffness, or another load, is another run.
    task.theta = vec![(task.at("BUSHING/1.K.1"), 101.0)];
    let missing = replay.sweep(&task.request()).unwrap_err();
    assert!(missing.is_lasting());
    let missing = missing.to_string();
    assert!(
        missing.contains("no recorded run") && missing.contains("1 runs"),
        "{missing}"
    );
    task.theta.clear();
    task.programme.cases[1].values[0] = 201.0;
    assert!(replay.sweep(&task.request()).is_err());
    task.programme.cases[1].values[0] = 200.0;

    // A recording that somebody damaged is no answer either.
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

/// Runs a program that only writes down what it was given, and returns deck and command file.
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
    // A blank first line, then the model: what ADAMS/View writes for the C++ solver.
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

    // XRF is asked for where the deck does not.
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
    // Along z the spring of the file gives 100 newton per millimetre beside the 400 of the bushing.
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

#[cfg(unix)]
#[test]
fn a_case_that_failed_has_no_answer_whether_a_step_was_written_or_not() {
    let mut task = Task::new();
    let good = task.sweep(&mut backend(mdi())).unwrap();
    // In case b nothing holds the block against its load.
    task.programme.loads.push(Load {
        name: "stiffness".to_string(),
        target: task.at("BUSHING/1.K.3"),
    });
    for (case, value) in task.programme.cases.iter_mut().zip([400.0, 0.0]) {
        case.values.push(value);
    }
    task.programme.cases.push(LoadCase {
        label: "c".to_string(),
        values: vec![100.0, 30.0, 400.0],
    });
    // The step that is missing, as a copy of the first one.
    let copied = "awk '/<Step type=.quasiStatic/ && !n {n=1; s=1} s {b=b $0 \"\\n\"} {print} /<.Step>/ && s {printf \"%s\", b; s=0}' run.res > x; mv x run.res";
    for command in [mdi(), after(copied)] {
        let sweep = task.sweep(&mut backend(command)).unwrap();
        assert_eq!(sweep.equilibrium(0), good.equilibrium(0));
        assert!(sweep.equilibrium(1).is_none());
        assert_eq!(sweep.cases.len(), 3);
        assert!(sweep.equilibrium(2).is_some());
    }
}
