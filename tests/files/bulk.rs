//! Tests of commands that treat many values or objects at once: patterns, arithmetic, command files, cascading removal, extracts, unit
//! conversion and results.

use std::path::Path;

use admire_results::{GraphicsFile, MessageFile, StepKind};
use admire_solver::model::{Model, convert_units};
use admire_solver::statics::{FreedomCount, StaticSettings, solve};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit};

use super::folder::{Folder, run};
use crate::common::{files_below, shared};

pub const DECK: &str = "a title\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/10, PART=1\n\
MARKER/11, PART=1, QP=0, 100, 0\n! adams_view_name='arm'\nPART/2, MASS=1.5, CM=20, IP=1E4, 1E4, 1E4, QG=100, 0, 0\nMARKER/20, PART=2, REULER=30D, 0, 0.5\n\
MARKER/21, PART=2, QP=50, 0, 0\nPART/3, MASS=1, CM=30, IP=1E3, 1E3, 1E3, QG=150, 20, 0\nMARKER/30, PART=3\n! adams_view_name='front_left'\n\
BUSHING/1, I=20, J=10, K=1000, 2000, 3000.0, KT=1E5, 1E5, 1E5\n! adams_view_name='front_right'\nBUSHING/12, I=21, J=11, K=0.1, 2, 3\n\
BUSHING/3, I=30, J=21, K=50, 60, 70, KT=1000, 1000, 1000\nSFORCE/4, I=30, J=10, TRANSLATIONAL, FUNCTION=-0.5*(DM(30,10)-150)+VARVAL(1)\n\
VARIABLE/1, FUNCTION=3*DX(30,10)\nREQUEST/1, DISPLACEMENT, I=30, J=10\nACCGRAV/KGRAV=-9806.65\nEND\n";

#[test]
fn patterns_and_arithmetic_change_many_values() {
    let folder = Folder::with(DECK);
    let set = |words: &[&str]| {
        let mut all = vec!["set", "d.adm"];
        all.extend(words);
        let (code, out, err) = folder.run(&all);
        assert_eq!(code, 0, "{words:?}: {err}");
        out
    };
    assert_eq!(
        set(&["BUSHING/*.K.1*=1.2"]),
        DECK.replace("K=1000,", "K=1200,")
            .replace("K=0.1,", "K=0.12,")
            .replace("K=50,", "K=60,")
    );
    assert_eq!(
        set(&["front_*.K*=2", "BUSHING/3.K.* -= 10"]),
        DECK.replace("K=1000, 2000, 3000.0", "K=2000, 4000, 6000.0")
            .replace("K=0.1, 2, 3", "K=0.2, 4, 6")
            .replace("K=50, 60, 70", "K=40, 50, 60")
    );
    assert_eq!(set(&["BUSHING/*.K=1,1,1"]).matches("K=1,1,1").count(), 3);
    assert_eq!(
        set(&["MARKER/20.REULER.1+=15", "--degrees"]),
        DECK.replace("30D", "45D")
    );
    assert_eq!(
        set(&["MARKER/20.REULER.1=45", "--degrees"]),
        DECK.replace("30D", "45D")
    );
    let (code, _, err) = folder.run(&["set", "d.adm", "BUSHING/*.K*=x"]);
    assert!(code == 2 && err.contains("not a number"), "{err}");
    let (code, _, err) = folder.run(&["set", "d.adm", "JOINT/*.K*=2"]);
    assert!(code == 1 && err.contains("JOINT"), "{err}");
    let (_, out, _) = folder.run(&["get", "d.adm", "BUSHING/*.K.2"]);
    assert_eq!(
        out,
        "BUSHING/1.K.2 = 2000.0\nBUSHING/12.K.2 = 2.0\nBUSHING/3.K.2 = 60.0\n"
    );
    let (_, out, _) = folder.run(&["get", "d.adm", "MARKER/20.REULER", "--degrees"]);
    assert_eq!(out, "30.0, 0.0, 28.6478897565412\n");
}

#[test]
fn commands_are_read_and_changed_like_statements() {
    let folder = Folder::with(DECK);
    let commands = "file/model=d\nequil/maxit=100, error=1E-3\nsimulate/statics, end=1, steps=10\nsforce/4, function=2*TIME\nsimulate/statics, end=2, steps=5\nstop\n";
    folder.write("r.acf", commands);
    let (_, out, _) = folder.run(&[
        "get",
        "r.acf",
        "SIMULATE#2.END",
        "EQUILIBRIUM.MAXIT",
        "SFORCE/4.FUNCTION",
    ]);
    assert_eq!(out, "2.0\n100\n2*TIME\n");
    let (_, out, _) = folder.run(&["get", "r.acf", "SIMULATE#*.STEPS"]);
    assert_eq!(out, "SIMULATE#1.STEPS = 10\nSIMULATE#2.STEPS = 5\n");
    let (code, _, err) = folder.run(&["get", "r.acf", "SIMULATE.END"]);
    assert!(
        code == 1 && err.contains("SIMULATE#1 to SIMULATE#2"),
        "{err}"
    );
    let words = [
        "set",
        "r.acf",
        "SIMULATE#2.END=4",
        "EQUIL.MAXIT=200",
        "SFORCE/4.FUNCTION=3*TIME",
        "--in-place",
    ];
    assert_eq!(folder.run(&words).0, 0);
    let expected = commands
        .replace("end=2", "end=4")
        .replace("maxit=100", "maxit=200")
        .replace("2*TIME", "3*TIME");
    assert_eq!(folder.read("r.acf"), expected);
    let (code, _, _) = folder.run(&["set", "r.acf", "SIMULATE#1.STEPS=many", "--in-place"]);
    assert_eq!((code, folder.read("r.acf")), (1, expected.clone()));
    // Arithmetic applies to a single command or to all commands of a kind.
    let words = [
        "set",
        "r.acf",
        "SIMULATE#*.STEPS*=2",
        "EQUIL.ERROR/=10",
        "SIMULATE#2.END+=1",
        "--in-place",
    ];
    assert_eq!(folder.run(&words).0, 0);
    let expected = expected
        .replace("steps=10", "steps=20")
        .replace("steps=5", "steps=10")
        .replace("error=1E-3", "error=1E-4")
        .replace("end=4", "end=5");
    assert_eq!(folder.read("r.acf"), expected);
    // A change that introduces a fault is refused unless `--force` is given. Text that cannot be parsed is refused even with `--force`.
    let backwards = ["set", "r.acf", "EQUIL.ERROR=-1", "--in-place"];
    let (code, _, err) = folder.run(&backwards);
    assert!(code == 1 && err.contains("--force"), "{err}");
    assert_eq!(folder.read("r.acf"), expected);
    let (code, _, _) = folder.run(&["set", "r.acf", "EQUIL.ERROR=-1", "--force", "--in-place"]);
    assert_eq!(
        (code, folder.read("r.acf")),
        (0, expected.replace("error=1E-4", "error=-1"))
    );
    let (code, _, _) = folder.run(&["set", "r.acf", "EQUIL.ERROR=(", "--force", "--in-place"]);
    assert_eq!(code, 1);
}

#[test]
fn a_part_goes_with_all_that_hangs_on_it() {
    let folder = Folder::with(DECK);
    let (code, _, err) = folder.run(&["remove", "d.adm", "PART/3"]);
    assert_eq!(code, 1, "markers would be left alone: {err}");
    let (code, out, err) = folder.run(&["remove", "d.adm", "PART/3", "--cascade"]);
    assert_eq!(code, 0, "{err}");
    for gone in [
        "PART/3",
        "MARKER/30",
        "BUSHING/3",
        "SFORCE/4",
        "VARIABLE/1",
        "REQUEST/1",
    ] {
        assert!(!out.contains(gone), "{gone}: {out}");
        assert!(gone == "PART/3" || err.contains(gone), "{gone}: {err}");
    }
    assert!(out.contains("BUSHING/1,") && out.contains("BUSHING/12,"));
    let (code, _, said) = folder.run(&["remove", "d.adm", "REQUEST/*"]);
    assert_eq!(code, 0, "{said}");
}

/// Checks that the forces on the extracted part equal its forces in the whole model at the design position.
#[test]
fn an_extract_feels_the_forces_of_the_whole() {
    let folder = Folder::with(DECK);
    let (code, out, err) = folder.run(&["extract", "d.adm", "PART/3"]);
    assert_eq!(code, 0, "{err}");
    assert!(
        out.contains("BUSHING/3") && out.contains("SFORCE/4") && out.contains("VARIABLE/1"),
        "{out}"
    );
    assert!(
        !out.contains("PART/2") && !out.contains("BUSHING/12,"),
        "{out}"
    );
    let forces = |text: &str| {
        let dataset = Dataset::parse(Source::new("x", text.as_bytes())).value;
        let model = Model::lower(&dataset);
        assert!(!model.has_errors(), "{:?}", model.diagnostics);
        let part = model
            .value
            .parts
            .iter()
            .position(|part| part.header.id == 3)
            .expect("there");
        let system = System::compile(&model.value).value;
        let mut g = vec![0.0; system.unknowns()];
        let mut scratch = admire_solver::system::Scratch::new(&system);
        system
            .residual(&system.parameters(), &system.state(), &mut scratch, &mut g)
            .expect("a value");
        g[system.part_unknowns(admire_solver::model::PartIx(part))].to_vec()
    };
    let (whole, alone) = (forces(DECK), forces(&out));
    let size = whole.iter().map(|x| x.abs()).fold(0.0, f64::max);
    assert!(size > 1.0, "{whole:?}");
    for (a, b) in whole.iter().zip(&alone) {
        assert!((a - b).abs() < 1e-9 * size, "{whole:?} {alone:?}");
    }
    let (code, _, err) = folder.run(&["extract", "d.adm", "PART/1"]);
    assert!(code == 1 && err.contains("not a moving part"), "{err}");
}

fn unit(table: &[Unit], name: &str) -> Unit {
    *table
        .iter()
        .find(|unit| unit.keyword == name)
        .expect("a unit")
}

/// Returns the positions of all parts of a deck at equilibrium, in metres.
fn equilibrium(text: &[u8]) -> Vec<[f64; 3]> {
    let dataset = Dataset::parse(Source::new("x", text)).value;
    let model = Model::lower(&dataset);
    assert!(!model.has_errors(), "{:?}", model.diagnostics);
    let system = System::compile(&model.value).value;
    let mut state = system.state();
    let units = &model.value.units;
    // The same tolerances and limits in any units.
    let settings = StaticSettings {
        imbalance: 1e-6 / units.force.si,
        tlimit: 0.02 / units.length.si,
        ..StaticSettings::tight()
    };
    solve(&system, &system.parameters(), &mut state, &settings).expect("an equilibrium");
    let si = units.length.si;
    state
        .poses
        .iter()
        .map(|pose| [pose.p.x * si, pose.p.y * si, pose.p.z * si])
        .collect()
}

/// Checks that a deck converted to other units has the same equilibrium positions in metres.
#[test]
fn other_units_are_the_same_mechanism() {
    let deck = DECK
        .replace("REULER=30D, 0, 0.5", "REULER=3D, 0, 0.01")
        .replace("QG=100, 0, 0", "QG=1, 0, 0")
        .replace("QG=150, 20, 0", "QG=52, 1, 0");
    let dataset = Dataset::parse(Source::new("d.adm", deck.as_bytes())).value;
    let model = Model::lower(&dataset).value;
    let here = equilibrium(deck.as_bytes());
    let mut moved = 0.0_f64;
    for (force, mass, length) in [
        ("NEWTON", "KILOGRAM", "METER"),
        ("POUND_FORCE", "POUND_MASS", "INCH"),
        ("DYNE", "GRAM", "CENTIMETER"),
    ] {
        let new = [
            unit(FORCE_UNITS, force),
            unit(MASS_UNITS, mass),
            unit(LENGTH_UNITS, length),
            unit(TIME_UNITS, "SECOND"),
        ];
        let edits = convert_units(&dataset, &model, new)
            .expect("converted")
            .value;
        let bytes = apply_edits(dataset.bytes(), &edits).expect("apart");
        for (a, b) in here.iter().zip(equilibrium(&bytes)) {
            for k in 0..3 {
                assert!((a[k] - b[k]).abs() < 1e-7, "{length}: {a:?} {b:?}");
                moved = moved.max(b[k].abs());
            }
        }
    }
    assert!(moved > 0.01);
}

#[test]
fn what_cannot_be_converted_is_named() {
    let folder = Folder::with(DECK);
    folder.write(
        "x.adm",
        &DECK.replace("FUNCTION=3*DX(30,10)", "FUNCTION=USER(1,2)"),
    );
    let (code, out, err) = folder.run(&["convert-units", "x.adm", "--to", "mks"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains("VARIABLE/1 is not converted"), "{err}");
    let (code, _, err) = folder.run(&["convert-units", "d.adm", "--to", "metre"]);
    assert!(code == 2 && err.contains("did you mean meter"), "{err}");
    let (code, out, _) = folder.run(&["convert-units", "d.adm", "--to", "mmks"]);
    assert_eq!(
        (code, out.as_str()),
        (0, DECK),
        "they are its units already"
    );
}

#[test]
fn graphs_name_bodies_and_what_joins_them() {
    let folder = Folder::with(DECK);
    let (_, dot, _) = folder.run(&["graph", "d.adm", "--dot"]);
    assert!(
        dot.contains("\"PART/2\" -- \"PART/1\" [label = \"front_left\""),
        "{dot}"
    );
    assert!(
        dot.contains("\"PART/3\" -- \"PART/2\" [label = \"BUSHING/3\""),
        "{dot}"
    );
    assert_eq!(folder.run(&["graph", "d.adm", "-o", "d.svg"]).0, 0);
    assert!(
        folder.read("d.svg").starts_with("<svg") && folder.read("d.svg").contains(">arm</text>")
    );
}

/// Checks that degrees of freedom are counted even if a function has no value at the design position, and in decks with errors.
#[test]
fn freedoms_are_always_counted() {
    let folder = Folder::with(DECK);
    // The two moving parts have twelve degrees of freedom and no constraints. DX from a marker to itself is zero, so the function divides
    // by zero.
    let broken = DECK.replace("-0.5*(DM(30,10)-150)+VARVAL(1)", "1/DX(20,20)");
    folder.write("x.adm", &broken);
    let (_, out, _) = folder.run(&["summary", "x.adm"]);
    assert!(
        out.contains(
            "degrees of freedom: 12 (Gruebler count 12: 12 of the parts less 0 constraint"
        ),
        "{out}"
    );
    assert!(
        out.contains("not defined at the design position: SFORCE/4"),
        "{out}"
    );
    folder.write("y.adm", &DECK.replace("I=21, J=11", "I=21, J=99"));
    let (code, out, _) = folder.run(&["summary", "y.adm"]);
    assert_eq!(code, 1);
    assert!(
        out.contains("degrees of freedom: 12 (Gruebler count 12"),
        "{out}"
    );
    let dataset = Dataset::parse(Source::new(
        "x",
        broken
            .replace("SFORCE/4", "JOINT/1, REVOLUTE, I=20, J=10\nSFORCE/4")
            .into_bytes(),
    ))
    .value;
    let system = System::compile(&Model::lower(&dataset).value).value;
    let found = FreedomCount::of(&system, &system.parameters(), &system.state());
    assert_eq!(
        (found.gruebler(), found.actual(), found.redundant.len()),
        (7, 7, 0)
    );
    assert!(found.without_value.is_some());
}

#[test]
fn results_are_filtered_and_rewritten() {
    let Some(folder) = shared("real-decks/aview-hpc") else {
        return;
    };
    let file = folder.join("test.res");
    let name = file.to_str().expect("a name");
    let here = tempfile::tempdir().expect("a folder");
    let (code, all, err) = run(here.path(), &["results", name, "--get", "time", "PART_2.Y"]);
    assert_eq!(code, 0, "{err}");
    let rows = all.lines().count() - 1;
    assert!(rows > 10);
    let count = |words: &[&str]| {
        let mut given = vec!["results", name, "--get", "time"];
        given.extend(words);
        let (code, out, err) = run(here.path(), &given);
        assert_eq!(code, 0, "{err}");
        out.lines().count() - 1
    };
    assert_eq!(count(&["--steps", "2,4-6"]), 4);
    assert_eq!(count(&["--steps", "last"]), 1);
    let dynamic = count(&["--kind", "dynamic"]);
    assert!(dynamic > 10 && dynamic < rows, "{dynamic} of {rows}");
    let early = count(&["--kind", "dynamic", "--to", "0.1"]);
    assert!(early > 5 && early < dynamic);
    let (_, plain, _) = run(
        here.path(),
        &[
            "results", name, "--get", "PART_2.Y", "--plain", "--steps", "last",
        ],
    );
    let lines: Vec<&str> = plain.lines().collect();
    assert!(lines[0].ends_with("PART_2_XFORM.Y"), "{plain}");
    let last: f64 = lines[1].parse().expect("a number alone");

    let (code, _, err) = run(
        here.path(),
        &[
            "results",
            name,
            "--set",
            "PART_2.Y+=1",
            "--steps",
            "last",
            "-o",
            "new.res",
        ],
    );
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("changed values: 1"), "{err}");
    // Editing in place through one hard link changes the file for both names.
    let (first, second) = (here.path().join("a.res"), here.path().join("b.res"));
    std::fs::copy(&file, &first).expect("a copy");
    std::fs::hard_link(&first, &second).expect("a second name");
    let edit = [
        "results",
        "a.res",
        "--set",
        "PART_2.Y+=1",
        "--steps",
        "last",
    ];
    let in_place = [&edit[..], &["--in-place"]].concat();
    let (code, _, err) = run(here.path(), &in_place);
    assert_eq!(code, 0, "{err}");
    let text = |path: &Path| std::fs::read(path).expect("readable");
    assert!(text(&first) == text(&second) && text(&first) == text(&here.path().join("new.res")));
    let (_, changed, _) = run(
        here.path(),
        &[
            "results", "new.res", "--get", "PART_2.Y", "--plain", "--steps", "last",
        ],
    );
    let new: f64 = changed
        .lines()
        .nth(1)
        .expect("a row")
        .parse()
        .expect("a number");
    assert!(
        (new - last - 1.0).abs() < 1e-9 * last.abs().max(1.0),
        "{new} {last}"
    );
    let bytes = std::fs::read(here.path().join("new.res")).expect("written");
    let before = std::fs::read(&file).expect("readable");
    let different = before
        .split(|b| *b == b'\n')
        .zip(bytes.split(|b| *b == b'\n'))
        .filter(|(a, b)| a != b)
        .count();
    assert_eq!(different, 1, "one line has the new number");
    assert_eq!(
        run(here.path(), &["results", name, "--set", "PART_2.Y=1"]).0,
        2,
        "results need a place to go"
    );
    // An edit that changes no value writes an identical copy.
    let same = ["results", name, "--set", "PART_2.Y*=1", "-o", "same.res"];
    assert_eq!(run(here.path(), &same).0, 0);
    assert!(std::fs::read(here.path().join("same.res")).expect("written") == before);
}

#[test]
fn graphics_show_the_same_motion_as_results() {
    let Some(folder) = shared("real-decks/aview-hpc") else {
        return;
    };
    let bytes = std::fs::read(folder.join("test.gra")).expect("readable");
    let read = GraphicsFile::parse(&Source::new("test.gra", bytes));
    assert_eq!(read.diagnostics, []);
    assert_eq!(read.value.parts, [2]);
    let column = |file: &str, extra: &[&str]| {
        let path = folder.join(file);
        let mut words = vec![
            "results",
            path.to_str().expect("a name"),
            "--get",
            "PART_2.Y",
            "--plain",
        ];
        words.extend(extra);
        let (code, out, err) = run(&folder, &words);
        assert_eq!(code, 0, "{err}");
        out.lines()
            .skip(1)
            .map(|line| line.parse::<f64>().expect("a number"))
            .collect::<Vec<f64>>()
    };
    let drawn = column("test.gra", &[]);
    let solved = column("test.res", &["--kind", StepKind::Dynamic.step_type()]);
    assert!(drawn.len() > 20);
    // Graphics files have six digits. The initial position, 0, may be absent from the dynamic steps.
    for place in &drawn {
        let near = solved
            .iter()
            .any(|other| (other - place).abs() <= 1e-5 * place.abs().max(1e-3));
        assert!(near || *place == 0.0, "{place} is not among {solved:?}");
    }
}

/// Checks the summary of every real message file against its text: the numbers of analyses, message frames and commands, the convergence of
/// static solutions, and the closing lines.
#[test]
fn messages_of_real_runs_are_summed_up() {
    let Some(folder) = shared("real-decks") else {
        return;
    };
    let files = files_below(&folder, "msg");
    assert!(files.len() >= 5);
    for path in files {
        let bytes = std::fs::read(&path).expect("readable");
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let source = Source::new(path.display().to_string(), bytes);
        assert!(MessageFile::is_one(&source), "{}", path.display());
        let file = MessageFile::parse(&source);
        let count = |what: &str| {
            text.lines()
                .filter(|line| line.trim_start().starts_with(what))
                .count()
        };
        assert_eq!(file.analyses.len(), count("Begin "), "{}", path.display());
        assert_eq!(
            file.frames.len(),
            count("---- START:"),
            "{}",
            path.display()
        );
        assert_eq!(file.commands, count("command:"), "{}", path.display());
        let converged = file
            .analyses
            .iter()
            .filter(|analysis| analysis.iterations.is_some())
            .count();
        assert_eq!(
            converged,
            count("Static Solution converged"),
            "{}",
            path.display()
        );
        assert_eq!(
            file.finished,
            count("Finished -----") == 1,
            "{}",
            path.display()
        );
        assert_eq!(file.elapsed.is_some(), count("Elapsed time") == 1);
        assert!(
            file.solver.contains("C++"),
            "{}: {}",
            path.display(),
            file.solver
        );
        let name = path.to_str().expect("a name");
        let (code, out, _) = run(&folder, &["results", name]);
        let bad = !file.finished || file.frames.iter().any(|frame| frame.kind == "ERROR");
        assert_eq!(code, i32::from(bad), "{out}");
    }
}
