//! Checks that every reader takes time and memory in proportion to the size of its file, at eight times the bytes.
//!
//! Quadratic growth would be a factor of 64. A factor of up to 16 counts as linear, because buffers double their capacity now and then. The test
//! has its own process, because every allocation of the process is counted.

use std::alloc::System as Memory;

use admire_kc::Config;
use admire_results::{
    FormattedResults, GraphicsFile, GraphicsHead, GraphicsShape, GraphicsWriter, MessageFile,
    RequestFile, StepKind, Timestamp, XrfReader, rewrite,
};
use admire_session::check;
use admire_solver::model;
use admire_solver::model::Model;
use admire_study::{Study, Table};
use admire_syntax::lint::{Options, check as lint, check_commands};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::{CommandFile, Dataset, Expression, all_fixes};
use cpu_time::ProcessTime;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<Memory> = &INSTRUMENTED_SYSTEM;

/// File filled by a pattern: kind, reader, beginning, and repeated text. In the repeated text, `#` is replaced by the number of the repetition.
type Filled<'a> = (&'a str, fn(&[u8]), &'a str, &'a str);

const SHORT: usize = 40_000;
const TIMES: usize = 8;

const FILES: &[Filled<'static>] = &[
    // Long valid files.
    (
        "dataset",
        dataset,
        "t\nPART/1, GROUND\nMARKER/1, PART=1\n",
        "PART/1#, MASS=1, CM=1#, IP=1,1,1\nMARKER/1#, PART=1#, QP=#,2,3\nBUSHING/1#, I=1#, J=1, K=1,2,3, KT=4,5,6\n",
    ),
    (
        "dataset",
        dataset,
        "t\nPART/1, GROUND\nMARKER/1, PART=1\n",
        "VARIABLE/1#, FUNCTION=STEP(TIME,0,0,1,#)*DX(1,1)\\\n",
    ),
    (
        "dataset",
        dataset,
        "t\nVARIABLE/1, FUNCTION=1",
        "\n, +#*TIME",
    ),
    ("dataset", dataset, "t\nSPLINE/1, X=0, Y=0", "\n, #"),
    (
        "command-file",
        commands,
        "\nfile/model=a\n",
        "SFORCE/1, FUNCTION=#\nSIM/STAT\n",
    ),
    ("table", table, "case,part,x\n", "#,\"arm \"\"a\"\"\",1.5\n"),
    (
        "study.toml",
        study,
        "",
        "[[channels]]\nname = \"c#\"\nexpression = \"DX(1,#)\"\n",
    ),
    ("kc.toml", settings, "", "[wheels.w#]\npart = \"PART/#\"\n"),
    ("admire.toml", rules, "", "[rules.r#]\nlevel = \"warn\"\n"),
    (
        "xrf",
        xrf,
        XRF_HEAD,
        "<Step type=\"quasiStatic\">\n#\n1.5\n</Step>\n",
    ),
    (
        "xrf",
        xrf,
        "<?xml version=\"1.0\"?>\n<Results>\n<Analysis>\n<StepMap name=\"map\">\n",
        "<Entity name=\"e#\" entity=\"a\">\n<Component name=\"X\" id=\"1#\" />\n</Entity>\n",
    ),
    (
        "request-file",
        requests,
        "A.R3\na\n1\nname\n1 1 2 3\n",
        "#\n1 2 3 4 5 6\n",
    ),
    (
        "message-file",
        messages,
        "",
        "---- START: WARNING ----\nfirst #\n second\n---- END: WARNING ----\n",
    ),
    (
        "message-file",
        messages,
        "",
        " command: file/model=a#\n  Begin Simulation\n   2.50000E-01  1.0E-02  3  4\n  End Simulation\n",
    ),
    (
        "property-file",
        property,
        "[MDI_HEADER]\nFILE_TYPE='spr'\n[CURVE]\n{ disp force}\n",
        "# #.5\n",
    ),
    (
        "property-file",
        property,
        "[MDI_HEADER]\nFILE_TYPE='bus'\n",
        "[B#]\n{a b}\n# 2\n",
    ),
    ("expression", expression, "1", "+#*TIME"),
    ("expression", expression, "MAX(1", ",MIN(1,#)"),
    // Long malicious files.
    ("dataset", dataset, "t\n", "BUSHING/#, I=#, J=#\n"),
    ("dataset", dataset, "t\n", "PRAT/#, MAS=#\n"),
    ("dataset", dataset, "t\n", "MARKER/1, PART=#, ZP=1,2,3\n"),
    ("dataset", dataset, "t\nVARIABLE/1, FUNCTION=", "SIN("),
    ("dataset", dataset, "t\nVARIABLE/1, FUNCTION=", "(1+"),
    ("dataset", dataset, "t\nPART/1", ", X#=1"),
    (
        "dataset",
        dataset,
        "t\n",
        "!adams_view_name='same'\nPART/#\n",
    ),
    ("command-file", commands, "\n", "SIMULAET/STAT, EDN=#\n"),
    ("command-file", commands, "\n", "SIM/STAT, &\n"),
    ("expression", expression, "", "("),
    ("expression", expression, "", "-"),
    ("expression", expression, "", "SIN("),
    ("expression", expression, "2", "**2"),
    ("table", table, "case,x\n", "\""),
    ("table", table, "case,x\n", ","),
    ("table", table, "case,x\n", "\"\n"),
    ("table", table, "case,x\n", "#\n"),
    ("table", table, "", "\n"),
    ("study.toml", study, "a = ", "["),
    ("study.toml", study, "a = ", "{a="),
    ("study.toml", study, "", "k# = #\n"),
    ("study.toml", study, "", "[a#.b]\n"),
    ("study.toml", study, "", "a."),
    ("study.toml", study, "", "[[a.b]]\n"),
    ("study.toml", study, "a = \"", "\\n"),
    ("kc.toml", settings, "", "k# = #\n"),
    ("admire.toml", rules, "", "k# = #\n"),
    ("xrf", xrf, "", "<a>"),
    ("xrf", xrf, "<Results>", "<a b=\"c\" "),
    ("xrf", xrf, "<Results>", "&lt;"),
    ("xrf", xrf, "<Results>", "<![CDATA["),
    ("xrf", xrf, "<Results>", "<!--"),
    ("xrf", xrf, "", "<!DOCTYPE a [<!ENTITY b \"&b;&b;\">]>"),
    ("xrf", xrf, XRF_HEAD, "<Step type=\"quasiStatic\">\n"),
    ("xrf", xrf, XRF_HEAD, "1 "),
    (
        "request-file",
        requests,
        "A.R3\na\n1\nname\n1 1 2 3\n0\n",
        "1 ",
    ),
    ("request-file", requests, "A.R3\na\n999999\n", "name\n"),
    ("graphics-file", graphics, "A.G8\na\n 999999 999999\n", "1 "),
    (
        "formatted-file",
        formatted,
        "",
        "RIGID PARTS MAP                                1\n",
    ),
    ("message-file", messages, "", "---- START: ERROR ----\n"),
    ("message-file", messages, "", "----"),
    ("property-file", property, "", "["),
    ("property-file", property, "", "[A]\n"),
    ("property-file", property, "[MDI_HEADER]\n", "{a b}\n"),
    ("property-file", property, "[A]\n", "a=1\n"),
    ("property-file", property, "[A]\n", "'"),
];

const XRF_HEAD: &str = "<?xml version=\"1.0\"?>\n<Results>\n<Analysis>\n<StepMap name=\"map\">\n<Entity name=\"time\">\n\
    <Component name=\"TIME\" id=\"1\" />\n</Entity>\n<Entity name=\"a\">\n<Component name=\"X\" id=\"2\" />\n</Entity>\n</StepMap>\n\
    <Data name=\"d\" id=\"1\">\n";

fn dataset(bytes: &[u8]) {
    let read = Dataset::parse(Source::new("a.adm", bytes));
    let said = lint(&read.value, &Options::default());
    for found in [&read.diagnostics, &said] {
        apply_edits(bytes, &all_fixes(found, "a.adm")).expect("fixes that can be made");
    }
    let lowered = Model::lower(&read.value);
    model::lint::check(&read.value, &lowered.value);
}

fn commands(bytes: &[u8]) {
    check_commands(&CommandFile::parse(Source::new("a.acf", bytes)).value);
}

fn expression(bytes: &[u8]) {
    _ = Expression::parse_str(str::from_utf8(bytes).expect("text"));
}

fn table(bytes: &[u8]) {
    let mut said = Vec::new();
    let table = Table::read(Source::new("a.csv", bytes), &mut said);
    table.columns(["case", "x"], &mut said);
    for row in table.rows() {
        for at in 0..row.len() {
            table.number(row, at, &mut said);
        }
    }
}

fn study(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("study.toml"), bytes).expect("a file");
    Study::read(folder.path());
}

fn settings(bytes: &[u8]) {
    Config::read(&Source::new("kc.toml", bytes), 1.0, 1.0);
}

fn rules(bytes: &[u8]) {
    _ = check::Settings::parse(&Source::new("admire.toml", bytes));
}

fn xrf(bytes: &[u8]) {
    _ = rewrite("a.res", bytes, bytes, &mut std::io::sink(), &[]);
    let Ok(mut reader) = XrfReader::open("a.res", bytes) else {
        return;
    };
    let mut values = Vec::new();
    while let Ok(Some(step)) = reader.next_step() {
        if step.values(&mut values).is_err() {
            return;
        }
    }
}

fn requests(bytes: &[u8]) {
    RequestFile::parse(&Source::new("a.req", bytes));
}

fn graphics(bytes: &[u8]) {
    GraphicsFile::parse(&Source::new("a.gra", bytes));
}

fn formatted(bytes: &[u8]) {
    FormattedResults::parse(&Source::new("a.res", bytes));
}

fn messages(bytes: &[u8]) {
    MessageFile::parse(&Source::new("a.msg", bytes));
}

fn property(bytes: &[u8]) {
    PropertyFile::parse(Source::new("a.bus", bytes));
}

/// Returns the graphics of one part: the beginning of the file, and one frame.
fn pictures() -> (String, String) {
    let head = GraphicsHead {
        title: "a title".to_string(),
        ground: 1,
        parts: vec![2],
        shapes: vec![GraphicsShape::Force { id: 1, marker: 1 }],
        input: vec![[0.0; 6]],
        ..GraphicsHead::default()
    };
    let frames = |count: usize| {
        let when = Timestamp::from_unix(0);
        let mut writer = GraphicsWriter::create(Vec::new(), when, &head).unwrap();
        for _ in 0..count {
            let pose = [1.0, -2.0, 3.0, -0.5, 0.25, 0.0];
            writer
                .frame(StepKind::Dynamic, 0.0, &[pose], &[pose])
                .unwrap();
        }
        String::from_utf8(writer.finish()).unwrap()
    };
    let (none, one) = (frames(0), frames(1));
    let frame = one[none.len()..].to_string();
    (none, frame)
}

/// Returns the results of one part in the format before XRF: the beginning of the file, and one equilibrium.
fn equilibria() -> (String, String) {
    let block = |name: &str, lines: &[&str]| {
        format!(
            "{name:<40}{:>8}\n{}\n!\n",
            lines.len() + 1,
            lines.join("\n")
        )
    };
    let head = [
        block(
            "FILE TYPE AND SOURCE",
            &["ADAMS RESULTS FILE       MMKGS_N_RACA 0.100000000000000E+01"],
        ),
        block("DATA SET TITLE", &["a model", ""]),
        block("NUMBER OF ANALYSIS BLOCKS", &["  999999       6"]),
        block(
            "RIGID PARTS MAP",
            &[
                "       1YESNO NO ",
                "                   2       5       0       0",
            ],
        ),
        block(
            "NAME MAP",
            &[
                "       1YES",
                "                   2RIGID PART                 1",
                ".m.arm",
            ],
        ),
    ];
    let lines = [
        "       1STATIC              1",
        " #.00000E+00",
        "",
        "",
        " 1.0 2.0 3.0 1.0 0.0 0.0 0.0",
    ];
    (head.concat(), block("ANALYSIS OUTPUT BLOCK", &lines))
}

fn filled(lead: &str, piece: &str, size: usize) -> Vec<u8> {
    let mut text = lead.to_string();
    let mut round = 100;
    while text.len() < size {
        text += &piece.replace('#', &round.to_string());
        round += 1;
    }
    text.into_bytes()
}

/// Returns the total number of allocated bytes, and the processor time in seconds.
fn taken(read: fn(&[u8]), bytes: &[u8]) -> (usize, f64) {
    let (region, start) = (Region::new(COUNTED), ProcessTime::now());
    read(bytes);
    let seconds = start.elapsed().as_secs_f64();
    let change = region.change();
    (change.bytes_allocated, seconds)
}

#[test]
fn time_and_memory_grow_with_the_file_and_not_faster() {
    let mut wrong = Vec::new();
    let (lead, piece) = pictures();
    let pictures: Filled = ("graphics-file", graphics, &lead, &piece);
    let read = GraphicsFile::parse(&Source::new("a.gra", filled(&lead, &piece, SHORT)));
    assert!(read.value.times.len() > 100, "{:?}", read.diagnostics);
    let (lead, piece) = equilibria();
    let equilibria: Filled = ("formatted-file", formatted, &lead, &piece);
    let read = FormattedResults::parse(&Source::new("a.res", filled(&lead, &piece, SHORT)));
    assert!(
        read.value.steps.len() > 100,
        "{:?}",
        read.diagnostics.first()
    );
    for &(kind, read, lead, piece) in FILES.iter().chain([&pictures, &equilibria]) {
        let (short, long) = (
            filled(lead, piece, SHORT),
            filled(lead, piece, TIMES * SHORT),
        );
        // Tables that are created once are created here, before the measurement.
        read(&short);
        let what = format!("{kind}, {lead:.20?} {piece:?}");
        let (less, more) = (taken(read, &short), taken(read, &long));
        println!("{what}: {less:?}, {more:?}");
        if more.0 > 2 * TIMES * less.0 + (1 << 20) {
            wrong.push(format!("{what}: {} and {} bytes", less.0, more.0));
        }
        // One good measurement among several is enough.
        let slow = |(less, more): (f64, f64)| more > 3.0 * TIMES as f64 * less + 0.5;
        let again = || (taken(read, &short).1, taken(read, &long).1);
        if slow((less.1, more.1)) && (0..4).all(|_| slow(again())) {
            wrong.push(format!("{what}: {} and {} s", less.1, more.1));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
