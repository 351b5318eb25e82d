//! MATLAB scripts of the kind used with ADAMS, run unchanged from `corpus/matlab` by GNU Octave.

use std::fs::{self, File};
use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use admire_results::{StepKind, XrfReader};

use crate::client::{LineEnds, copy, load_cases, project, run};
use crate::common::{missing, shared};
use crate::identification::by_admire;

/// Returns a command that runs a script by Octave; `None` if Octave is not installed.
fn octave(script: &Path) -> Option<Command> {
    let there = Command::new("octave-cli")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !there {
        missing("GNU Octave");
        return None;
    }
    let mut command = Command::new("octave-cli");
    command
        .args(["--quiet", "--norc", "--no-history"])
        .arg(script);
    Some(command)
}

/// Runs the lines of the guide page for MATLAB in the folder that the page names, except for lines that need MATLAB or Windows.
#[test]
fn the_page_for_matlab_runs_as_it_is_printed() {
    let page = admire_guide::page("matlab").expect("the page").text;
    let blocks = page.split("```matlab\n").skip(1);
    let blocks = blocks.map(|block| block.split("```").next().expect("an end"));
    let blocks: Vec<&str> = blocks
        .filter(|block| {
            !["setenv", "py.", "run.acf"]
                .iter()
                .any(|word| block.contains(word))
        })
        .collect();
    assert_eq!(blocks.len(), 3, "{blocks:?}");
    let folder = tempfile::tempdir().expect("a folder");
    let corpus = project("corpus/pseudo-mcpherson");
    for file in fs::read_dir(corpus).expect("the corpus") {
        let file = file.expect("a file");
        fs::copy(file.path(), folder.path().join(file.file_name())).expect("a copy");
    }
    let functions = project("corpus/matlab").display().to_string();
    let script = format!(
        "addpath('{functions}');\n{}\nfprintf('%.9g %.9g %.9g %d\\n', x(end, 3), z(end), stiffnesses(1), status);\n",
        blocks.concat()
    );
    let file = folder.path().join("page.m");
    fs::write(&file, script).expect("a script");
    let Some(mut octave) = octave(&file) else {
        return;
    };
    let said = run(octave.current_dir(folder.path()));
    let numbers: Vec<f64> = said
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    // Both ways give the same height of the knuckle; the true stiffness of the study is 13875 N/mm.
    assert!(
        (numbers[0] - numbers[1]).abs() < 1e-6 && numbers[0] > 200.0,
        "{said}"
    );
    assert!(
        (numbers[2] / 13875.0 - 1.0).abs() < 0.1 && numbers[3] == 0.0,
        "{said}"
    );
}

/// Stiffnesses found by a run of the paper's script, and its iterations.
struct Identified {
    iterations: u64,
    /// Stiffnesses of bushing 1, then of bushing 2: Kx Ky Kz KTx KTy KTz.
    stiffnesses: Vec<f64>,
}

/// Differences of a study from the study of the corpus.
#[derive(Clone, Copy)]
struct Variant {
    marks: &'static str,
    epsilon: f64,
    /// True if bushing 1 is round (equation 16).
    round: bool,
    line_ends: LineEnds,
}

const NOISE_FREE: Variant = Variant {
    marks: "marks_noise_free.csv",
    epsilon: 0.01,
    round: false,
    line_ends: LineEnds::Lf,
};

/// Writes the study of the corpus into a folder, for identification by the paper's loop.
fn study(folder: &Path, variant: Variant) {
    let corpus = project("corpus/pseudo-mcpherson");
    fs::create_dir_all(folder).expect("a folder");
    for (from, to) in [
        ("model.adm", "model.adm"),
        ("load_cases.csv", "load_cases.csv"),
        ("marks_on_parts.csv", "marks_on_parts.csv"),
        (variant.marks, "marks_measured.csv"),
    ] {
        copy(&corpus.join(from), &folder.join(to), variant.line_ends);
    }
    let symmetry = if variant.round {
        "symmetry = { default = \"none\", \"BUSHING/1\" = \"radial-z\" }"
    } else {
        ""
    };
    let epsilon = variant.epsilon;
    let text = format!(
        r#"[model]
deck = "model.adm"
[loads]
file = "load_cases.csv"
columns = {{ vertical = "SFORCE/3", lateral = "SFORCE/2", longitudinal = "SFORCE/1" }}
[marks]
on_parts = "marks_on_parts.csv"
measured = "marks_measured.csv"
[identify]
bushings = ["BUSHING/1", "BUSHING/2"]
method = "regression"
initial = {{ translational = 1.0e4, rotational_per_degree = 1.0e4 }}
{symmetry}
[regression]
epsilon = {epsilon}
max_iterations = 40
"#
    );
    fs::write(folder.join("study.toml"), text).expect("a writable folder");
}

fn identify(study: &Path, variant: Variant) -> Option<Identified> {
    let mut octave = octave(&project("tests/octave/identify.m"))?;
    let work = study.join("work");
    fs::create_dir(&work).expect("a folder");
    octave
        .arg(study)
        .arg(&work)
        .args(["epsilon", &variant.epsilon.to_string()])
        .args(["max_iterations", "40"]);
    if variant.round {
        octave.args(["round", "1"]);
    }
    run(&mut octave);
    let text = fs::read_to_string(work.join("identified.txt")).expect("what the script wrote");
    let mut lines = text.lines();
    let iterations = lines.next().expect("iterations").parse().expect("a count");
    let stiffnesses = lines
        .flat_map(str::split_whitespace)
        .map(|word| word.parse().expect("a number"))
        .collect();
    Some(Identified {
        iterations,
        stiffnesses,
    })
}

/// Compares the script, which solves with `mdi` and reads `.res`, with `admire identify` and its built-in solver: the stiffnesses must be equal.
fn script_and_admire_agree(variant: Variant) -> Option<Vec<f64>> {
    let folder = tempfile::tempdir().expect("a folder");
    study(folder.path(), variant);
    let found = identify(folder.path(), variant)?;
    let ours = by_admire(folder.path());
    assert_eq!(found.iterations, ours.iterations);
    assert_eq!(found.stiffnesses.len(), 12);
    assert_eq!(ours.stiffnesses.len(), 12);
    for (address, value) in &ours.stiffnesses {
        let (bushing, rest) = address.split_once('.').expect("BUSHING/id.ARGUMENT.index");
        let (argument, index) = rest.split_once('.').expect("ARGUMENT.index");
        let at = if bushing == "BUSHING/1" { 0 } else { 6 }
            + if argument == "K" { 0 } else { 3 }
            + index.parse::<usize>().expect("an index")
            - 1;
        let theirs = found.stiffnesses[at];
        assert!(
            (theirs / value - 1.0).abs() < 1e-4,
            "{address}: {theirs} by the script, {value} by admire"
        );
    }
    Some(found.stiffnesses)
}

/// Also compares the results of the paper's loop for noise-free marks with those of an independent implementation. The step test stops the loop
/// after about 40 iterations, with a ratio of stiffness to reference of 0.997 and so on; slow stiffnesses have not converged by then.
#[test]
fn the_papers_script_finds_what_admire_finds() {
    let Some(found) = script_and_admire_agree(NOISE_FREE) else {
        return;
    };
    let per_degree = 57.295_779_513_082_32;
    let reference = [
        13875.0, 13875.0, 1370.0, 11000.0, 11000.0, 4000.0, 310.0, 2400.0, 180.0, 4500.0, 1100.0,
        1600.0,
    ];
    let ratios = [
        0.997, 0.997, 0.980, 0.908, 0.908, 0.884, 1.00, 1.00, 1.02, 5.2, 5.1, 2.2,
    ];
    for k in 0..12 {
        let unit = if k % 6 < 3 { 1.0 } else { per_degree };
        let ratio = found[k] / (reference[k] * unit);
        assert!(
            (ratio / ratios[k] - 1.0).abs() < 0.02,
            "stiffness {k}: {ratio} of the reference, {} was expected",
            ratios[k]
        );
    }
}

/// With noise of 0.05 mm, some lines fail the test of equation 15, and the loop does not converge. The 40 iterations must agree nevertheless.
#[test]
fn the_papers_script_follows_admire_through_noise() {
    script_and_admire_agree(Variant {
        marks: "marks_measured.csv",
        ..NOISE_FREE
    });
}

/// Checks files with Windows line ends, for the script and for `admire identify`.
#[test]
fn the_papers_script_finds_what_admire_finds_in_windows_files() {
    script_and_admire_agree(Variant {
        line_ends: LineEnds::CrLf,
        epsilon: 0.03,
        ..NOISE_FREE
    });
}

/// Checks equation 16 as printed.
#[test]
fn the_papers_script_averages_round_bushings_as_admire_does() {
    script_and_admire_agree(Variant {
        round: true,
        epsilon: 0.03,
        ..NOISE_FREE
    });
}

/// Checks that the script reads files with Windows line ends, as ADAMS/View writes them, and writes such files.
#[test]
fn the_papers_script_takes_both_line_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let both = [LineEnds::Lf, LineEnds::CrLf].map(|line_ends| {
        let variant = Variant {
            epsilon: 0.5,
            line_ends,
            ..NOISE_FREE
        };
        let name = if line_ends == LineEnds::Lf {
            "lf"
        } else {
            "crlf"
        };
        let folder = folder.path().join(name);
        study(&folder, variant);
        let found = identify(&folder, variant)?;
        let deck = fs::read(folder.join("work/identified.adm")).expect("the last deck");
        let crlf = deck.windows(2).filter(|pair| pair == b"\r\n").count();
        let lf = deck.iter().filter(|&&byte| byte == b'\n').count();
        assert_eq!(crlf, if line_ends == LineEnds::Lf { 0 } else { lf });
        Some(found)
    });
    if let [Some(lf), Some(crlf)] = both {
        assert_eq!(lf.iterations, crlf.iterations);
        assert_eq!(lf.stiffnesses, crlf.stiffnesses);
    }
}

/// Compares both MATLAB readers with our own reader, value for value: every named entity in all quasi-static steps.
fn both_readers_agree(results: &Path) -> Option<usize> {
    let open = || {
        let file = File::open(results).expect("the results");
        XrfReader::open("results", BufReader::new(file)).expect("an XRF file")
    };
    let mut reader = open();
    let entities = reader.catalogue().entities.clone();
    let mut steps: Vec<Vec<f64>> = Vec::new();
    while let Some(step) = reader.next_step().expect("a whole step") {
        if matches!(step.kind, StepKind::QuasiStatic | StepKind::Static) {
            let mut values = Vec::new();
            step.values(&mut values).expect("numbers");
            steps.push(values);
        }
    }
    assert!(!steps.is_empty());

    let folder = tempfile::tempdir().expect("a folder");
    let (names, out) = (folder.path().join("names"), folder.path().join("out"));
    let mut asked: Vec<&admire_results::Entity> = Vec::new();
    for entity in &entities {
        if asked.iter().all(|other| other.name != entity.name) && !entity.components.is_empty() {
            asked.push(entity);
        }
    }
    let mut file = File::create(&names).expect("a writable folder");
    for entity in &asked {
        writeln!(file, "{}", entity.name).expect("a writable file");
    }
    run(octave(&project("tests/octave/readers.m"))?
        .arg(results)
        .arg(&names)
        .arg(&out));

    let text = fs::read_to_string(&out).expect("what the readers found");
    let mut lines = text.lines();
    let mut compared = 0;
    for entity in asked {
        let (columns, rows) = (entity.components.len(), steps.len());
        let head = format!("{} {columns} {rows}", entity.name);
        assert_eq!(lines.next(), Some(head.as_str()));
        for reader in ["read_kc", "read_xrf"] {
            for step in &steps {
                let found: Vec<f64> = lines
                    .next()
                    .expect("a row")
                    .split_whitespace()
                    .map(|word| word.parse().expect("a number"))
                    .collect();
                let expected: Vec<f64> = entity
                    .components
                    .iter()
                    .map(|component| step[component.id - 1])
                    .collect();
                assert_eq!(found, expected, "{reader}, {}", entity.name);
                compared += columns;
            }
        }
    }
    assert_eq!(lines.next(), None);
    Some(compared)
}

/// Reads a K&C run of Adams/Car 2020: 101 equilibria, 1315 columns.
#[test]
fn matlab_readers_read_what_adams_wrote() {
    let Some(results) = shared("real-decks/kinbench-kc/NRAC_G023_Lat_static_load.res") else {
        return;
    };
    if let Some(compared) = both_readers_agree(&results) {
        assert!(compared > 2 * 101 * 1000, "only {compared} values");
    }
}

/// Reads the 13 load cases of the paper, solved by `mdi` from files with Windows and Unix line ends.
#[test]
fn matlab_readers_read_what_mdi_writes() {
    for line_ends in [LineEnds::Lf, LineEnds::CrLf] {
        let folder = tempfile::tempdir().expect("a folder");
        let deck = project("corpus/pseudo-mcpherson/reference.adm");
        copy(&deck, &folder.path().join("run.adm"), line_ends);
        let acf = folder.path().join("run.acf");
        fs::write(acf, load_cases(line_ends)).expect("a writable folder");
        run(Command::new("mdi")
            .args(["-c", "ru-standard", "i", "run.acf", "exit"])
            .current_dir(folder.path()));
        both_readers_agree(&folder.path().join("run.res"));
    }
}
