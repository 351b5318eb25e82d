use crate::output_files::{blocks, request_times};
use crate::run::{Results, SLIDER, folder, mdi, mdi_with, text};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
    }
}

fn run(commands: &str) -> (tempfile::TempDir, crate::run::Ran) {
    let acf = format!("\nfile/model=slider\n{commands}\n");
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (folder, ran)
}

#[test]
fn redefinitions_take_effect_at_the_next_simulation() {
    let (folder, ran) = run(
        "SFORCE/1, FUNCTION=5\nsim/stat\nSPRINGDAMPER/1, K=20\nsim/sta\nSPRINGDAMPER/1, K=10\n\
        accg/kgrav=-9806.65\nSIMULATE/STATICS\nSTOP",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "slider.res");
    // z = F / K; then F - m g with m = 2 kg.
    near(
        &results.column("block_XFORM", "Z"),
        &[0.5, 0.25, (5.0 - 19.6133) / 10.0],
    );
    near(
        &results.column("travel", "dz"),
        &[0.5, 0.25, (5.0 - 19.6133) / 10.0],
    );
    near(&results.column("time", "TIME"), &[0.0; 3]);
    assert_eq!(
        ran.stdout.matches("Static Solution converged in").count(),
        3
    );
}

#[test]
fn a_quasi_static_run_outputs_its_start_and_then_each_step() {
    let (folder, ran) =
        run("SIMULATE/STATICS, END=1, STEPS=4\nSIMULATE/STATICS, DURATION=0.5, DTOUT=0.2\nSTOP");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "slider.res");
    let times = [0.0, 0.25, 0.5, 0.75, 1.0, 1.2, 1.4, 1.5];
    near(&results.column("time", "TIME"), &times);
    near(&results.column("block_XFORM", "Z"), &times);
    for line in [
        "  ****** Performing Quasi-Static Simulation ******",
        "  End Simulation",
        " command: SIMULATE/STATICS, END=1, STEPS=4",
    ] {
        assert!(ran.stdout.contains(line), "{line}");
    }
    // A single static has its own block; the sequences have 2 N + 1 steps, as counted in real batches (guide/formats.md 6.1).
    let (folder, _) = run("sim/stat\nsim/stat, end=1, steps=4\nsim/stat, end=2, steps=4\nstop");
    assert_eq!(
        blocks(folder.path(), "slider.res"),
        [
            ("modelInput_001", "input", 1),
            ("static_001", "static", 1),
            ("quasiStatic_001", "quasiStatic", 9)
        ]
        .map(|(name, kind, count)| (name.to_string(), kind.to_string(), count))
    );
    let times: Vec<f64> = (0..9).map(|k| f64::from(k) / 4.0).collect();
    near(&request_times(folder.path()), &times);
}

#[test]
fn a_failed_static_writes_no_step_and_the_run_goes_on() {
    // Without the spring nothing supports the loaded slider.
    let commands =
        "SFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSPRINGDAMPER/1, K=10\nSIM/STAT\n";
    let (folder, ran) = run(commands);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(
        ran.stdout.contains("---- START: ERROR ----"),
        "{}",
        ran.stdout
    );
    assert!(
        ran.stdout.contains("olution failed to converge"),
        "{}",
        ran.stdout
    );
    near(
        &Results::read(folder.path(), "slider.res").column("block_XFORM", "Z"),
        &[0.5],
    );

    let acf = format!("\nfile/model=slider\n{commands}");
    std::fs::write(folder.path().join("run.acf"), &acf).unwrap();
    let strict = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
    assert_eq!(strict.code, 3);

    let acf = format!("\nfile/model=slider\nPREFERENCES/SIMFAIL=STOPCF\n{commands}");
    std::fs::write(folder.path().join("run.acf"), &acf).unwrap();
    let stopped = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(stopped.code, 3);
    // The file is complete with its columns, but has no step.
    let left = text(folder.path(), "slider.res");
    assert!(
        left.contains("<Entity name=\"block_XFORM\"") && left.trim_end().ends_with("</Results>")
    );
    assert!(Results::read(folder.path(), "slider.res").steps.is_empty());
}

#[test]
fn no_step_of_an_earlier_run_survives() {
    let (folder, ran) = run("SIMULATE/STATICS\nSTOP");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(folder.path(), "slider.res").steps.len(), 1);
    let broken = SLIDER.replace("I=21, J=11", "I=99, J=11");
    std::fs::write(folder.path().join("slider.adm"), broken).unwrap();
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 1, "{}", ran.stdout);
    assert!(Results::read(folder.path(), "slider.res").steps.is_empty());
    for old in ["slider.res", "slider.req"] {
        assert!(!text(folder.path(), old).contains("E+"), "{old}");
    }
    assert!(text(folder.path(), "slider.msg").contains("[undefined-id]"));
}

#[test]
fn what_is_switched_off_exerts_nothing() {
    let (folder, ran) = run(
        "SFORCE/1, FUNCTION=5\nSIM/STAT\nDEACTIVATE/SFORCE, ID=1\nSIM/STAT\nACTIVATE/SFORCE, RANGE=1,100000000\nSIM/STAT",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    near(
        &Results::read(folder.path(), "slider.res").column("block_XFORM", "Z"),
        &[0.5, 0.0, 0.5],
    );
    let (_folder, ran) = run("DEACTIVATE/JOINT, ID=7");
    assert!(ran.stdout.contains("[undefined-id]"), "{}", ran.stdout);
}

#[test]
fn kinematics_without_freedoms_and_nothing_else() {
    let driven = SLIDER.replace("REQUEST/1", "MOTION/1, JOINT=1, FUNCTION=3*TIME\nREQUEST/1");
    let acf = "\nfile/model=slider\nSIMULATE/KINEMATIC, END=2, STEPS=2\n";
    let folder = folder(&[("slider.adm", &driven), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let res = text(folder.path(), "slider.res");
    assert_eq!(res.matches("<Step type=\"kinematic\">").count(), 3);

    let (_folder, ran) = run("SIMULATE/KINEMATIC, END=2, STEPS=2");
    assert!(
        ran.stdout
            .contains("zero degrees of freedom, but this model has 1"),
        "{}",
        ran.stdout
    );
    let (_folder, ran) = run("SIMULATE/DYNAMIC, END=2, STEPS=2\nSIM/STAT");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(ran.stdout.contains("Performing Dynamic Simulation"));
    assert!(ran.stdout.contains("End Static Solution"));
}

#[test]
fn requests_and_frames_stop_and_resume_on_command() {
    let deck = SLIDER.replace("OUTPUT/REQSAVE", "OUTPUT/REQSAVE, GRSAVE");
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=2\nOUTPUT/NOREQSAVE, NOGRSAVE\n\
               SIM/STAT, END=2, STEPS=2\nOUTPUT/REQSAVE\nSIM/STAT, END=3, STEPS=1\nSTOP\n";
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let source = admire_syntax::text::Source::new(
        "slider.req",
        text(folder.path(), "slider.req").into_bytes(),
    );
    let requests = admire_results::RequestFile::parse(&source).value;
    assert_eq!(requests.times.last(), Some(&3.0));
    assert!(!requests.times.contains(&1.5), "{:?}", requests.times);
    let frames = text(folder.path(), "slider.gra");
    let after: Vec<&str> = frames.split("-9.99999E+05").collect();
    assert_eq!(after[1].trim_start_matches('\n').lines().count(), 1 + 3 * 2);
}

#[test]
fn requests_and_frames_are_written_beside_the_results() {
    let deck = SLIDER.replace("OUTPUT/REQSAVE", "OUTPUT/REQSAVE, GRSAVE");
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=2\nSTOP\n";
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let source = admire_syntax::text::Source::new(
        "slider.req",
        text(folder.path(), "slider.req").into_bytes(),
    );
    let requests = admire_results::RequestFile::parse(&source);
    assert!(
        requests.diagnostics.is_empty(),
        "{:?}",
        requests.diagnostics
    );
    near(&requests.value.times, &[0.0, 0.5, 1.0]);
    // F4 is the third of the six written columns.
    let dz: Vec<f64> = requests
        .value
        .values
        .iter()
        .map(|step| step[0][2])
        .collect();
    near(&dz, &[0.0, 0.5, 1.0]);
    let frames = text(folder.path(), "slider.gra");
    let after: Vec<&str> = frames.split("-9.99999E+05").collect();
    // The block as it was read; then, for each of three times, one line for the time and one for the block.
    assert_eq!(
        after[1].trim_start_matches('\n').lines().count(),
        1 + 3 * 2,
        "{frames}"
    );
    assert!(text(folder.path(), "slider.out").contains("REQUEST/1"));
    // Without these keywords no files are written.
    let (folder, _) = run("SIM/STAT");
    assert!(!folder.path().join("slider.gra").exists());
}

#[test]
fn results_options_leave_columns_out() {
    let deck = SLIDER.replace(
        "XRF",
        "XRF, NOVELOCITIES, NOACCELERATIONS, NOAPPLIEDFORCES, NOREACTIONFORCES",
    );
    let folder = folder(&[
        ("slider.adm", &deck),
        ("run.acf", "\nfile/model=slider\nSIM/STAT\n"),
    ]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 0);
    // TIME, the six displacements of the block, the request.
    assert_eq!(
        Results::read(folder.path(), "slider.res").steps[0].len(),
        1 + 6 + 1
    );
    let bare = SLIDER.replace("RESULTS/FORMATTED, XRF\n", "");
    std::fs::write(folder.path().join("slider.adm"), bare).unwrap();
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 0);
    assert_eq!(text(folder.path(), "slider.res"), "");
}

#[test]
fn other_readers_find_every_column_of_our_results() {
    let (folder, _) = run("SIM/STAT, END=1, STEPS=2");
    let file = std::fs::File::open(folder.path().join("slider.res")).unwrap();
    let mut reader = admire_results::XrfReader::open("slider.res", file).unwrap();
    let mut kinds = Vec::new();
    while let Some(step) = reader.next_step().unwrap() {
        kinds.push(step.block.to_string());
    }
    assert_eq!(
        kinds,
        [
            "modelInput_001",
            "quasiStatic_001",
            "quasiStatic_001",
            "quasiStatic_001"
        ]
    );
    assert_eq!(reader.run_status(), Some("Successful"));
    let types: Vec<_> = reader
        .catalogue()
        .entities
        .iter()
        .filter_map(|e| e.ent_type.clone())
        .collect();
    assert_eq!(
        types,
        [
            "Part",
            "Joint",
            "Single_Component_Force",
            "Translational_Spring_Damper",
            "Request"
        ]
    );
    // Force on I of the spring at z = 0: K (100 - 100) = 0; on the joint: zero apart from gravity.
    near(
        &Results::read(folder.path(), "slider.res").column("SFORCE_1", "FZ"),
        &[0.0, 5.0, 10.0],
    );
}

#[test]
fn exit_codes_are_those_of_adams_or_of_the_house() {
    // Commands; usual exit code; exit code with MDI_STRICT and of `admire solve`.
    for (acf, usual, strict) in [
        ("\nfile/model=slider\nSIM/STAT\nSTOP\n", 0, 0),
        // Without STOP the run ends at the end of the file.
        ("\nfile/model=slider\nSIM/STAT\n", 0, 0),
        ("\nfile/model=absent\nSIM/STAT\nSTOP\n", 2, 2),
        ("\nfile/model=broken\nSIM/STAT\nSTOP\n", 1, 1),
        // Commands after STOP are not executed.
        (
            "\nfile/model=slider\nSIM/STAT\nSTOP\nfile/model=absent\n",
            0,
            0,
        ),
        (
            "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSTOP\n",
            0,
            3,
        ),
        (
            "\nfile/model=slider\nPREFERENCES/SIMFAIL=STOPCF\nSFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSTOP\n",
            3,
            3,
        ),
        (
            "\nfile/model=slider\nPREFERENCES/SIMFAIL=NOSTOPCF\nSFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSTOP\n",
            0,
            3,
        ),
        ("\nfile/model=slider\nLINEAR/MKB\nSTOP\n", 1, 1),
    ] {
        let broken = SLIDER.replace("I=21, J=11", "I=99, J=11");
        let folder = folder(&[
            ("slider.adm", SLIDER),
            ("broken.adm", &broken),
            ("run.acf", acf),
        ]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, usual, "{acf:?}: {}", ran.stdout);
        let ran = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
        assert_eq!(ran.code, strict, "{acf:?} strictly: {}", ran.stdout);
        let solved = std::process::Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(["solve", "run.acf"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(solved.status.code(), Some(strict), "{acf:?} by admire");
    }
    let folder = folder(&[]);
    assert_eq!(mdi(folder.path(), &["ru-s", "absent"]).code, 2);
}

#[test]
fn callers_find_the_text_they_look_for_in_both_places() {
    let commands = "! a remark\nSFORCE/1, FUNCTION=5\n\nSIM/STAT\nSIM/STAT, END=1, STEPS=2\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSTOP";
    let (folder, ran) = run(commands);
    assert_eq!(ran.code, 0);
    assert_eq!(ran.stdout, text(folder.path(), "slider.msg"));
    for line in [
        " command: FILE/COMMAND=run",
        " command: ",
        " command: file/model=slider",
    ]
    .into_iter()
    .map(String::from)
    .chain(commands.lines().map(|line| format!(" command: {line}")))
    {
        assert!(
            ran.stdout.lines().any(|said| said == line),
            "{line:?} in {}",
            ran.stdout
        );
    }
    let found = |part: &str| {
        ran.stdout
            .find(part)
            .unwrap_or_else(|| panic!("{part} in {}", ran.stdout))
    };
    let order = [
        "A slider on a spring",
        " command: SIM/STAT\n",
        "  Begin Static Solution",
        "  Static Solution converged in ",
        "  End Static Solution",
        " command: SIM/STAT, END=1",
        "****** Performing Quasi-Static Simulation ******",
        "  End Simulation",
        "---- START: ERROR ----",
        "---- END: ERROR ----",
        " command: STOP",
        "Finished -----",
    ]
    .map(found);
    assert!(order.is_sorted(), "{order:?}");
}

#[test]
fn the_files_grow_step_by_step_and_hold_whole_steps() {
    // The second simulation fails; the results of the first one remain, and there are none of the second.
    let deck = SLIDER.replace("OUTPUT/REQSAVE", "OUTPUT/REQSAVE, GRSAVE");
    let acf = "\nfile/model=slider\nSFORCE/1, FUNCTION=5+0*TIME\nSIM/STAT, END=1, STEPS=2\nSPRINGDAMPER/1, K=0\nSIM/STAT\nSIM/STAT, END=2, STEPS=2\nSTOP\n";
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(folder.path(), "slider.res").steps.len(), 3);
    let source = admire_syntax::text::Source::new(
        "slider.req",
        text(folder.path(), "slider.req").into_bytes(),
    );
    near(
        &admire_results::RequestFile::parse(&source).value.times,
        &[0.0, 0.5, 1.0],
    );
    assert!(text(folder.path(), "slider.gra").contains("1.00000E+00"));
    assert!(text(folder.path(), "slider.out").contains("1.00000E+00"));

    // Results of an earlier run are removed from every file once the model is named, even if the deck cannot be read or requests other
    // files.
    for deck in [
        deck.replace("I=21, J=11", "I=99, J=11"),
        deck.replace(
            "OUTPUT/REQSAVE, GRSAVE\nRESULTS/FORMATTED, XRF\n",
            "OUTPUT/NOPRINT\n",
        ),
        "no deck at all".to_string(),
    ] {
        let other = self::folder(&[("slider.adm", &deck), ("run.acf", acf)]);
        for extension in ["res", "req", "gra", "out", "msg"] {
            std::fs::write(
                other.path().join(format!("slider.{extension}")),
                "the answer before",
            )
            .unwrap();
        }
        mdi(other.path(), &["ru-s", "run"]);
        for extension in ["res", "req", "gra", "out", "msg"] {
            let left = text(other.path(), &format!("slider.{extension}"));
            assert!(!left.contains("the answer before"), "{extension}");
            assert!(
                extension == "msg"
                    || deck.contains("K=10") && deck.contains("I=21")
                    || left.is_empty(),
                "{extension}: {left}"
            );
        }
    }
}

#[test]
fn a_killed_run_leaves_every_step_it_had_written() {
    let acf = "\nfile/model=slider\nSIM/STAT, END=1, STEPS=100000\nSTOP\n";
    let deck = SLIDER.replace("OUTPUT/REQSAVE", "OUTPUT/REQSAVE, GRSAVE");
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let mut running = std::process::Command::new(env!("CARGO_BIN_EXE_mdi"))
        .args(["ru-s", "run"])
        .current_dir(folder.path())
        .stdin(std::process::Stdio::null())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let grown =
        || std::fs::metadata(folder.path().join("slider.res")).is_ok_and(|m| m.len() > 40_000);
    for _ in 0..3000 {
        if grown() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    running.kill().unwrap();
    running.wait().unwrap();
    let res = text(folder.path(), "slider.res");
    assert!(!res.contains("</Results>"), "it was killed on the way");
    let mut reader = admire_results::XrfReader::open("slider.res", res.as_bytes()).unwrap();
    let mut times = Vec::new();
    let mut values = Vec::new();
    while let Ok(Some(step)) = reader.next_step() {
        if step.kind == admire_results::StepKind::QuasiStatic {
            step.values(&mut values).unwrap();
            times.push(values[0]);
        }
    }
    assert!(times.len() > 20, "{} steps", times.len());
    for (k, time) in times.iter().enumerate() {
        assert!((time - k as f64 * 1e-5).abs() < 1e-12);
    }
    // The other files are equally complete, except possibly for their last line.
    let source = admire_syntax::text::Source::new(
        "slider.req",
        text(folder.path(), "slider.req").into_bytes(),
    );
    let requests = admire_results::RequestFile::parse(&source)
        .value
        .times
        .len();
    assert!(requests + 2 > times.len(), "{requests} of {}", times.len());
    let said = text(folder.path(), "slider.msg");
    assert!(said.contains("Performing Quasi-Static Simulation"));
    let steps_said = said.lines().filter(|line| {
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        matches!(
            (words.next(), words.next(), words.next(), words.next()),
            (Some(Ok(_)), Some(Ok(_)), Some(Ok(_)), None)
        )
    });
    let steps_said = steps_said.count();
    assert!(
        steps_said + 2 > times.len(),
        "{steps_said} of {}",
        times.len()
    );
}

#[test]
fn loads_given_as_constants_and_as_functions_take_turns() {
    // A constant changes a parameter of the equations, a function changes the equations themselves; the solution must not depend on which
    // is used.
    let (folder, ran) = run(
        "SIM/STAT\nSFORCE/1, FUNCTION=5\nSIM/STAT\nSFORCE/1, FUNC=-2.5\nSIM/STAT\nSFORCE/1, FUNCTION=5+5\nSIM/STAT\n\
        SFORCE/1, FUNCTION=3\nSPRINGDAMPER/1, K=30\nSIM/STAT\nSPRINGDAMPER/1, K=10\nSIM/STAT\nSFORCE/1, FUNCTION=4+2*TIME\nSIM/STAT, END=1, STEPS=1\n\
        SFORCE/1, FUNCTION=7\nSIM/STAT\nSFORCE/1, FUNCTION=90D\nSIM/STAT\nDEACTIVATE/SFORCE, ID=1\nSIM/STAT\nSFORCE/1, FUNCTION=8\nSIM/STAT\nACTIVATE/SFORCE, ID=1\nSIM/STAT",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let quarter = std::f64::consts::FRAC_PI_2;
    near(
        &Results::read(folder.path(), "slider.res").column("block_XFORM", "Z"),
        &[
            0.0,
            0.5,
            -0.25,
            1.0,
            0.1,
            0.3,
            0.4,
            0.6,
            0.7,
            quarter / 10.0,
            0.0,
            0.0,
            0.8,
        ],
    );
    // The same check for the components of a vector force, one at a time.
    let deck = SLIDER.replacen(
        "REQUEST/1",
        "MARKER/32, PART=1, FLOATING\nGFORCE/1, I=20, JFLOAT=32, FX=0\\FZ=2*TIME\nREQUEST/1",
        1,
    );
    let acf = "\nfile/model=slider\nSFORCE/1, FUNCTION=0\nSIM/STAT\nGFORCE/1, FZ=5\nSIM/STAT\nGFORCE/1, FX=3\\FZ=6\nSIM/STAT\nGFORCE/1, FY=1\nSIM/STAT\nGFORCE/1, FZ=1+DZ(20,1)\nSIM/STAT\n";
    let folder = folder_of(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let results = Results::read(folder.path(), "slider.res");
    near(
        &results.column("block_XFORM", "Z"),
        &[0.0, 0.5, 0.6, 0.6, 1.0 / 9.0],
    );
    // The guide reacts with the forces that it blocks.
    near(
        &results.column("guide", "FX"),
        &[0.0, 0.0, -3.0, -3.0, -3.0],
    );
    near(&results.column("guide", "FY"), &[0.0, 0.0, 0.0, -1.0, -1.0]);
}

fn folder_of(files: &[(&str, &str)]) -> tempfile::TempDir {
    folder(files)
}
