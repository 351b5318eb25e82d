//! External ADAMS command lines as a backend: misbehaving programs, and what is kept and reported of their runs.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use admire_results::{Change, XrfReader, rewrite};
use admire_session::backend::{Backend, CommandBackend, ForceFrame, Load, LoadCase};

use crate::run::folder;
use crate::task::{Task, after, backend, mdi, words};

/// Returns the error of a bad run; its folder must have been kept, and is then removed.
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

/// Returns the results file of a good run, to be modified by tests.
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

/// Returns the column ids of some components of an entity.
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
    // SFORCE/1 acts along ground z (K 400). SFORCE/2 acts along the z axis of marker 4: REULER 90, 90, 0 turns z to ground x, which is -y
    // of J (K 200).
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
    // Truncated half-way, with a good exit code.
    says(
        after("sed '/TerminationStatus/,$d' run.res > x; mv x run.res"),
        "it has no run status",
    );
    says(
        after("head -c 3000 run.res > x; mv x run.res"),
        "the file ends",
    );
    // One step is missing, while the messages claim convergence of all.
    let less = "awk '/<Step type=.static/ && !d {d=1; s=1} !s {print} /<.Step>/ {s=0}' run.res > x; mv x run.res";
    says(after(less), "1 equilibria for 2 load cases");
    // Good results with a bad exit code.
    says(after("exit 3"), "exit code 3");
    says(after("kill -9 $$"), "a crash");
    // A missing licence, reported only on the console.
    says(
        words(&["sh", "-c", "echo 'Adams Solver: license request denied'"]),
        "no licence: Adams",
    );
    // The file of an earlier run, copied back with its time stamp.
    says(
        words(&["cp", "-p", &good.to_string(), "run.res"]),
        "from an earlier run",
    );
    // Results of another model.
    says(
        after("sed 's/A block on a bushing/Another block/' run.res > x; mv x run.res"),
        "another model, `Another",
    );
    says(
        after("sed 's/length=\"mm\"/length=\"meter\"/' run.res > x; mv x run.res"),
        "of the results is meter",
    );
    says(
        after("sed 's/^0.25 /nan /; s/ 0.25 / nan /; s/ 0.25$/ nan/' run.res > x; mv x run.res"),
        "contains values that are not finite",
    );
    // A program that changes its deck has not solved the requested model.
    says(
        after("echo '! changed' >> run.adm"),
        "differs from the one that the run was given",
    );
    // The error message ends with the tail of the log.
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
    // As in ADAMS' own script, the solver is a child of the started program.
    let script = format!(
        "echo started; sh -c 'echo $$ > \"{}\"; sleep 60; true' & wait",
        id.display()
    );
    let mut backend = CommandBackend::new(words(&["sh", "-c", &script]), Duration::from_secs(1));
    backend.keep = Some(place.path().join("runs"));
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
    // The copy has a new time stamp, which reveals nothing.
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
        let bytes = std::fs::read(&good).unwrap();
        let mut changed = Vec::new();
        rewrite("good.res", &*bytes, &*bytes, &mut changed, changes).unwrap();
        std::fs::write(&file, changed).unwrap();
        let mut backend = backend(words(&["cp", &file.display().to_string(), "run.res"]));
        backend.keep = Some(place.path().join("runs"));
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
    // Steps 1 and 2 are the load cases. The force on I in ground axes is (-30, 0) and (20, 0) newton along x and y. J is rotated by a
    // quarter turn about z, so in its axes this is (0, 30) and (0, -20).
    let in_j = |step: usize, force: f64| {
        [(0, 0.0), (1, force)].map(|(k, value)| Change {
            step,
            id: ids[k],
            value,
        })
    };
    let (remarks, _) = serve(&[in_j(1, 30.0), in_j(2, -20.0)].concat());
    assert!(remarks.unwrap()[0].contains("axes of the J marker"));
    // One step in ground axes and the other in J axes contradict each other.
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
        // Two sleeps of equal length overlap if they run in parallel.
        assert!(jobs == 1 || most > 1);
    }
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
    // The missing step is replaced by a copy of the first one.
    let copied = "awk '/<Step type=.static/ && !n {n=1; s=1} s {b=b $0 \"\\n\"} {print} /<.Step>/ && s {printf \"%s\", b; s=0}' run.res > x; mv x run.res";
    for command in [mdi(), after(copied)] {
        let sweep = task.sweep(&mut backend(command)).unwrap();
        assert_eq!(sweep.equilibrium(0), good.equilibrium(0));
        assert!(sweep.equilibrium(1).is_none());
        assert_eq!(sweep.cases.len(), 3);
        assert!(sweep.equilibrium(2).is_some());
    }
}

/// Returns the processes that still run among those whose ids a run wrote into a file.
#[cfg(unix)]
fn alive(ids: &Path) -> Vec<String> {
    let running = |id: &&str| {
        let list = std::process::Command::new("ps")
            .args(["-o", "stat=", "-p", id])
            .output()
            .unwrap();
        let state = String::from_utf8_lossy(&list.stdout).trim().to_string();
        !(state.is_empty() || state.starts_with('Z'))
    };
    let text = std::fs::read_to_string(ids).unwrap_or_default();
    text.split_whitespace()
        .filter(running)
        .map(str::to_string)
        .collect()
}

/// Checks that all processes of a run end with it, even a process with its own session, an orphan, or one left over by a good run.
#[cfg(target_os = "linux")]
#[test]
fn what_left_the_group_of_a_run_ends_with_it() {
    let task = Task::new();
    let place = folder(&[]);
    let at = |name: &str| place.path().join(name).display().to_string();
    let ids = place.path().join("ids");
    // The second process also clears its environment.
    let first = format!(
        "echo $$ >> '{}'\nsetsid env -i /bin/sh '{}' &\nexec sleep 300\n",
        at("ids"),
        at("second.sh")
    );
    std::fs::write(at("first.sh"), first).unwrap();
    let second = format!("echo $$ >> '{}'\nexec sleep 300\n", at("ids"));
    std::fs::write(at("second.sh"), second).unwrap();
    let escape = format!(
        "touch '{1}'; setsid sh '{0}' >/dev/null 2>&1 & while [ \"$(cat '{1}' | wc -l)\" -lt 2 ]; do sleep 0.02; done",
        at("first.sh"),
        at("ids")
    );
    task.sweep(&mut backend(after(&escape))).unwrap();
    assert_eq!(std::fs::read_to_string(&ids).unwrap().lines().count(), 2);
    assert!(alive(&ids).is_empty(), "{:?}", alive(&ids));
    std::fs::remove_file(&ids).unwrap();
    let script = format!("{escape}; sleep 300");
    let mut backend = CommandBackend::new(words(&["sh", "-c", &script]), Duration::from_secs(3));
    backend.keep = Some(place.path().join("runs"));
    task.sweep(&mut backend).unwrap_err();
    assert_eq!(std::fs::read_to_string(&ids).unwrap().lines().count(), 2);
    assert!(alive(&ids).is_empty(), "{:?}", alive(&ids));
}

#[cfg(unix)]
#[test]
fn a_run_that_prints_without_end_is_killed() {
    let task = Task::new();
    let error = refusal(words(&["sh", "-c", "yes 'no solver says so much'"]), &task);
    assert!(error.contains("printed more than 64 MB"), "{error}");
    assert!(
        error.len() < 2000 && error.contains("no solver says"),
        "{error}"
    );
}

#[cfg(unix)]
#[test]
fn a_dead_program_is_started_once() {
    let task = Task::new();
    let place = folder(&[]);
    for (jobs, command, timeout) in [
        (1, "sleep 60", 0.3),
        (3, "sleep 60", 0.3),
        (3, "exit 9", 30.0),
    ] {
        let mut backend = CommandBackend::new(
            words(&["sh", "-c", command]),
            Duration::from_secs_f64(timeout),
        );
        backend.jobs = jobs;
        backend.keep = Some(place.path().join("runs"));
        let answers = backend.sweeps(&[task.request(); 20]);
        assert_eq!(answers.len(), 20);
        for answer in answers {
            let error = answer.unwrap_err();
            assert!(
                error.is_lasting() && error.to_string().contains("files kept in"),
                "{error}"
            );
        }
        assert_eq!(backend.tally(), (1, 1), "{command}");
    }
    // A program that has answered once may hang later without being given up.
    let script = format!(
        "[ -e '{0}' ] && sleep 60; touch '{0}'",
        place.path().join("once").display()
    );
    let mut backend = CommandBackend::new(after(&script), Duration::from_secs(4));
    backend.jobs = 2;
    let answers = backend.sweeps(&[task.request(); 12]);
    assert_eq!(answers.len(), 12);
    assert!(
        answers[0].is_ok()
            && answers[11]
                .as_ref()
                .is_err_and(admire_session::backend::BackendError::is_lasting)
    );
    assert!(backend.tally().0 <= 5, "{:?}", backend.tally());
}

/// Checks steps of the file in another order, or the first one twice: every force fits its own poses, but the loads reveal the error.
#[cfg(unix)]
#[test]
fn swapped_and_repeated_cases_are_refused() {
    let order = |order: &str| {
        after(&format!(
            "awk '{{l[NR]=$0}} /<Step type=.static/ {{f[++n]=NR}} /<.Step>/ {{t[n]=NR}} END {{split(\"{order}\", o, \" \"); \
             for (i=1; i<f[1]; i++) print l[i]; for (k=1; k<=2; k++) for (i=f[o[k]]; i<=t[o[k]]; i++) print l[i]; \
             for (i=t[2]+1; i<=NR; i++) print l[i]}}' run.res > x; mv x run.res"
        ))
    };
    Task::new().sweep(&mut backend(order("1 2"))).unwrap();
    for (steps, says) in [("2 1", "`b`"), ("1 1", "`a`")] {
        let error = refusal(order(steps), &Task::new());
        assert!(error.contains("swapped") && error.contains(says), "{error}");
    }
    // For loads of equal size, their sign reveals the error.
    let mut task = Task::new();
    task.programme.cases[0].values = vec![200.0, 30.0];
    task.programme.cases[1].values = vec![-200.0, 30.0];
    task.sweep(&mut backend(mdi())).unwrap();
    let error = refusal(order("1 1"), &task);
    assert!(error.contains("wrong sign"), "{error}");
}

/// Checks that the name of a load case is only a comment in the command file, whatever it contains: no command for ADAMS or a shell.
#[test]
fn names_of_load_cases_are_remarks() {
    let mut task = Task::new();
    let plain = task.sweep(&mut backend(mdi())).unwrap();
    task.programme.cases[0].label =
        "a\nSTOP\r\n$(touch owned)\u{b}STOP; `touch owned` & | touch owned &\0\u{85}STOP &"
            .to_string();
    let place = folder(&[]);
    let mut backend = backend(mdi());
    backend.keep = Some(place.path().join("runs"));
    let sweep = task.sweep(&mut backend).unwrap();
    for case in 0..2 {
        let places = |of: &admire_session::backend::Sweep| of.equilibrium(case).unwrap().poses[1].p;
        assert_eq!(places(&sweep), places(&plain));
    }
    let mut runs = std::fs::read_dir(place.path().join("runs")).unwrap();
    let run = runs.next().unwrap().unwrap().path();
    let commands = std::fs::read_to_string(run.join("run.acf")).unwrap();
    let stops = commands
        .lines()
        .filter(|line| !line.starts_with('!') && line.to_lowercase().contains("stop"));
    assert_eq!(stops.count(), 1, "{commands}");
    assert!(!run.join("owned").exists() && !Path::new("owned").exists());
}
