//! Tests of results files, both real and damaged.

use std::path::PathBuf;

use admire_results::{
    Change, EntityKind, GraphicsHead, GraphicsMarker, GraphicsWriter, Header, LineEnd, NumberStyle,
    Numbering, RequestFile, RequestWriter, ResultsError, Selection, StepKind, Stored, Style,
    Timestamp, Tolerance, XrfReader, XrfWriter, compare, rewrite,
};
use admire_syntax::diagnostic::Code;
use admire_syntax::text::Source;
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units};
use rand::{RngExt, SeedableRng};

use crate::common::{files_below, shared};

fn real_files() -> Vec<PathBuf> {
    shared("real-decks").map_or_else(Vec::new, |folder| files_below(&folder, "res"))
}

/// Returns a results file with two parts, a bushing and a variable. An input step precedes `steps` quasi-static steps of artificial values.
fn small_file(steps: usize) -> Vec<u8> {
    let units = Units::default();
    let mut numbering = Numbering::new(units, Stored::default());
    numbering.object(EntityKind::Part, Some(".m.rig.arm"), 2, 0);
    numbering.object(EntityKind::Part, Some(".m.knuckle"), 3, 0);
    numbering.object(EntityKind::Bushing, Some(".m.front"), 1, 0);
    numbering.object(EntityKind::Variable, Some(".m.load"), 1, 0);
    let catalogue = numbering.finish();
    let header = Header::new(
        "/run/small.res",
        "small & <round>",
        &units,
        Timestamp::from_unix(0),
    );
    let mut writer = XrfWriter::create(Vec::new(), &header, &catalogue, Style::default()).unwrap();
    let mut values = vec![0.0; catalogue.len()];
    writer.step(StepKind::Input, &values).unwrap();
    for step in 0..steps {
        for (at, value) in values.iter_mut().enumerate() {
            *value = (step as f64 + 1.0) * (at as f64 * 0.37).sin();
        }
        values[0] = step as f64;
        writer.step(StepKind::QuasiStatic, &values).unwrap();
    }
    writer.finish("Successful").unwrap()
}

type Steps = Vec<(StepKind, Vec<f64>)>;

fn read_all(bytes: &[u8]) -> (XrfReader<&[u8]>, Steps) {
    let mut reader = XrfReader::open("test.res", bytes).unwrap();
    let mut steps = Vec::new();
    while let Some(step) = reader.next_step().unwrap() {
        let mut values = Vec::new();
        step.values(&mut values).unwrap();
        steps.push((step.kind, values));
    }
    (reader, steps)
}

#[test]
fn writing_what_was_read_gives_the_same_bytes() {
    for path in real_files() {
        let bytes = std::fs::read(&path).unwrap();
        let (reader, steps) = read_all(&bytes);
        assert_eq!(reader.run_status(), Some("Successful"));
        assert!(reader.diagnostics().is_empty());
        let first = String::from_utf8_lossy(&bytes);
        // Exponents of three digits identify files written before 2017.
        let old = first.contains("E-0") && reader.line_end() == LineEnd::CrLf;
        let style = Style {
            numbers: if old {
                NumberStyle::SeventeenDigits
            } else {
                NumberStyle::default()
            },
            line_end: reader.line_end(),
            open_end: bytes.last() == Some(&b'>'),
        };
        let mut writer =
            XrfWriter::create(Vec::new(), reader.header(), reader.catalogue(), style).unwrap();
        for (kind, values) in &steps {
            writer.step(*kind, values).unwrap();
        }
        let written = writer.finish("Successful").unwrap();
        let same = written
            .iter()
            .zip(&bytes)
            .take_while(|(a, b)| a == b)
            .count();
        assert!(
            written == bytes,
            "{}: differs from byte {same} on: {:?} for {:?}",
            path.display(),
            String::from_utf8_lossy(
                &written[same.saturating_sub(60)..(same + 60).min(written.len())]
            ),
            String::from_utf8_lossy(&bytes[same.saturating_sub(60)..(same + 60).min(bytes.len())]),
        );
    }
}

#[test]
fn rewriting_prints_every_real_step_anew_and_loses_nothing() {
    for path in real_files() {
        let bytes = std::fs::read(&path).unwrap();
        let mut out = Vec::new();
        let report = rewrite("real.res", &bytes[..], &bytes[..], &mut out, &[]).unwrap();
        assert!(out == bytes, "{}", path.display());
        assert_eq!(report.kept, 0, "{}", path.display());
        assert!(report.reprinted >= 2);
    }
}

#[test]
fn editing_one_value_changes_its_span_only() {
    let mut files: Vec<Vec<u8>> = real_files()
        .iter()
        .map(|p| std::fs::read(p).unwrap())
        .collect();
    files.push(small_file(3));
    for bytes in files {
        let change = Change {
            step: 1,
            id: 5,
            value: 0.125,
        };
        let mut out = Vec::new();
        let report = rewrite("x.res", &bytes[..], &bytes[..], &mut out, &[change]).unwrap();
        assert_eq!(report.changed, 1);
        let front = out.iter().zip(&bytes).take_while(|(a, b)| a == b).count();
        let back = out
            .iter()
            .rev()
            .zip(bytes.iter().rev())
            .take_while(|(a, b)| a == b)
            .count();
        // The old number has at most 24 characters; the new number is `0.125`.
        assert!(front + back + 24 >= bytes.len() && front + back + 5 >= out.len());
        let (_, before) = read_all(&bytes);
        let (_, after) = read_all(&out);
        for (step, ((_, before), (_, after))) in before.iter().zip(&after).enumerate() {
            for (at, (before, after)) in before.iter().zip(after).enumerate() {
                let wanted = if (step, at) == (1, 4) { 0.125 } else { *before };
                assert_eq!(*after, wanted);
            }
        }
        let beyond = Change {
            step: 1_000_000,
            ..change
        };
        assert!(rewrite("x", &bytes[..], &bytes[..], &mut Vec::new(), &[beyond]).is_err());
    }
}

#[test]
fn columns_of_a_real_suspension_are_those_of_its_header() {
    // The file is an Adams/Car 2020 result of 101 quasi-static steps (guide/formats.md 12).
    let Some(path) = shared("real-decks/kinbench-kc/NRAC_G023_Lat_static_load.res") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let (reader, steps) = read_all(&bytes);
    let catalogue = reader.catalogue();
    assert_eq!(catalogue.len(), 1315);
    assert_eq!(
        reader.header().solver,
        "Adams 2020                   Adams Solver (C++)"
    );
    assert_eq!(reader.header().units.length, "mm");
    let columns = catalogue.by_position();
    let kind_of = |id: usize| columns[id - 1].unwrap().entity.ent_type.as_deref();
    for (id, kind) in [
        (2, "Part"),
        (416, "Differential_Equation"),
        (430, "Joint"),
        (556, "Primitive_Joint"),
        (574, "Motion"),
        (598, "Single_Component_Force"),
        (694, "Bushing"),
        (703, "Field"),
        (775, "Request"),
        (1225, "ADAMS_Variable"),
        (1280, "General_Force"),
        (1292, "Floating_Marker"),
    ] {
        assert_eq!(kind_of(id), Some(kind));
    }
    assert_eq!(
        columns[693].unwrap().component.units.as_deref(),
        Some("newton")
    );
    assert_eq!(columns[7].unwrap().path(), "testrig.whl_wheel_XFORM.X");
    assert_eq!(steps.len(), 102);
    assert_eq!(steps[0].0, StepKind::Input);
    for (at, (kind, values)) in steps[1..].iter().enumerate() {
        assert_eq!((*kind, values[0]), (StepKind::QuasiStatic, at as f64 + 1.0));
        assert_eq!(values.len(), 1315);
    }
    // The order of entity kinds in this file equals the order of [`Numbering`].
    let kinds: Vec<&str> = catalogue
        .entities
        .iter()
        .filter_map(|e| e.ent_type.as_deref())
        .collect();
    assert!(kinds.is_sorted_by_key(|kind| catalogue_order(kind)));
}

fn catalogue_order(ent_type: &str) -> usize {
    [
        EntityKind::Part,
        EntityKind::DifferentialEquation,
        EntityKind::Joint,
        EntityKind::PrimitiveJoint,
        EntityKind::Motion,
        EntityKind::SingleComponentForce,
        EntityKind::Bushing,
        EntityKind::Field,
        EntityKind::Request,
        EntityKind::Variable,
        EntityKind::GeneralForce,
        EntityKind::FloatingMarker,
    ]
    .iter()
    .position(|kind| kind.ent_type() == ent_type)
    .unwrap()
}

#[test]
fn cut_files_give_their_whole_steps_and_a_warning() {
    let mut files = vec![small_file(12)];
    if let Some(path) = shared("real-decks/photocaber/adams1.res") {
        files.push(std::fs::read(path).unwrap());
    }
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    for bytes in files {
        let (_, whole) = read_all(&bytes);
        let ends: Vec<usize> = memchr::memmem::find_iter(&bytes, "</Step>")
            .map(|at| at + 7)
            .collect();
        for _ in 0..200 {
            let cut = random.random_range(0..bytes.len() - 1);
            let mut reader = match XrfReader::open("cut.res", &bytes[..cut]) {
                Ok(reader) => reader,
                Err(error) => {
                    assert!(cut < ends[0]);
                    let code = error.into_diagnostic().code;
                    assert!(matches!(
                        code,
                        Code::TruncatedResults | Code::UnsupportedResults
                    ));
                    continue;
                }
            };
            let (mut count, mut values) = (0, Vec::new());
            while let Some(step) = reader.next_step().unwrap() {
                step.values(&mut values).unwrap();
                assert_eq!((step.kind, &values), (whole[count].0, &whole[count].1));
                count += 1;
            }
            assert_eq!(count, ends.iter().filter(|&&end| end <= cut).count());
            let complete = bytes[..cut].ends_with(b"</Results>");
            assert_eq!(reader.diagnostics().is_empty(), complete);
            if let Some(warning) = reader.diagnostics().first() {
                assert_eq!(warning.code, Code::TruncatedResults);
            }
            // A truncated file is copied byte for byte.
            let mut out = Vec::new();
            rewrite("cut.res", &bytes[..cut], &bytes[..cut], &mut out, &[]).unwrap();
            assert!(out == bytes[..cut]);
        }
    }
}

fn read_to_the_end(bytes: &[u8]) -> Result<usize, Code> {
    let code = |error: ResultsError| error.into_diagnostic().code;
    let mut reader = XrfReader::open("broken.res", bytes).map_err(code)?;
    let (mut count, mut values) = (0, Vec::new());
    while let Some(step) = reader.next_step().map_err(code)? {
        step.values(&mut values).map_err(code)?;
        assert_eq!(values.len(), reader.columns());
        count += 1;
    }
    Ok(count)
}

#[test]
fn changed_bytes_never_panic_and_never_shift_columns() {
    let good = small_file(6);
    let mut random = rand_pcg::Pcg64::seed_from_u64(11);
    for _ in 0..5000 {
        let mut bytes = good.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..bytes.len());
            match random.random_range(0..4) {
                0 => bytes[at] = random.random(),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, b"<>\" \n\0&"[random.random_range(0..7)]),
                _ => {
                    let end = (at + random.random_range(1..400)).min(bytes.len());
                    bytes.drain(at..end);
                }
            }
        }
        let _ = read_to_the_end(&bytes);
    }
}

#[test]
fn attacks_through_xml_are_refused() {
    let good = String::from_utf8(small_file(1)).unwrap();
    let with = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let bomb =
        "<!DOCTYPE lolz [<!ENTITY lol \"lol\"><!ENTITY lol2 \"&lol;&lol;&lol;\">]>\n<Results";
    assert_eq!(
        read_to_the_end(&with("<Results", bomb)),
        Err(Code::MalformedResults)
    );
    let external = with("title=\"small", "title=\"&xxe;small");
    assert_eq!(read_to_the_end(&external), Err(Code::MalformedResults));
    let nested = with("<StepMap", &format!("{}<StepMap", "<a>".repeat(100_000)));
    assert_eq!(read_to_the_end(&nested), Err(Code::MalformedResults));
    let data = with("<Comment>\n", "<Comment>\n<![CDATA[ x ]]>");
    assert_eq!(read_to_the_end(&data), Err(Code::MalformedResults));
    let endless = with("<Author", &format!("<Author x=\"{}", "y".repeat(1 << 22)));
    assert!(read_to_the_end(&endless).is_err());
    let huge_id = with("id=\"3\"", "id=\"18446744073709551615\"");
    assert_eq!(read_to_the_end(&huge_id), Err(Code::MalformedResults));
    let twice = with("id=\"3\"", "id=\"2\"");
    assert_eq!(read_to_the_end(&twice), Err(Code::DuplicateId));
    let other_root = with("<Results", "<html").replace_end("</Results>", "</html>");
    assert_eq!(read_to_the_end(&other_root), Err(Code::UnsupportedResults));
    let short = with(
        "<Step type=\"quasiStatic\">\n0\n",
        "<Step type=\"quasiStatic\">\n",
    );
    assert_eq!(read_to_the_end(&short), Err(Code::WrongCount));
    let words = with(
        "<Step type=\"quasiStatic\">\n0\n",
        "<Step type=\"quasiStatic\">\nzero\n",
    );
    assert_eq!(read_to_the_end(&words), Err(Code::BadNumber));
    let tags = with(
        "<Step type=\"quasiStatic\">\n0\n",
        "<Step type=\"quasiStatic\">\n0<b/>\n",
    );
    assert_eq!(read_to_the_end(&tags), Err(Code::MalformedResults));
    let long = with(
        "<Step type=\"quasiStatic\">\n",
        &format!("<Step type=\"quasiStatic\">\n{}", "0 ".repeat(1 << 20)),
    );
    assert_eq!(read_to_the_end(&long), Err(Code::WrongCount));
    let maps = with(
        "<Data name=\"quasi",
        "<StepMap name=\"map_002\"></StepMap><Data name=\"quasi",
    );
    assert_eq!(read_to_the_end(&maps), Err(Code::UnsupportedResults));
    let older = b"FILE TYPE AND SOURCE                           6\n";
    assert_eq!(read_to_the_end(older), Err(Code::UnsupportedResults));
    assert_eq!(read_to_the_end(b""), Err(Code::UnsupportedResults));
}

trait ReplaceEnd {
    fn replace_end(self, from: &str, to: &str) -> Vec<u8>;
}

impl ReplaceEnd for Vec<u8> {
    fn replace_end(self, from: &str, to: &str) -> Vec<u8> {
        String::from_utf8(self)
            .unwrap()
            .replace(from, to)
            .into_bytes()
    }
}

#[test]
fn tags_may_share_lines_and_attributes_may_change_places() {
    // XML ignores line breaks. ADAMS writes one tag per line, but other tools may not.
    let text = "<?xml version='1.0'?><Results><Analysis><StepMap name='m'><Entity name='time'><Component id='1' \
                name='TIME'/></Entity><Entity name='v'><Component name='Q' id='2'></Component></Entity></StepMap><Data \
                name='s'><Step type='static'>0 1e-3</Step><!-- <Step> --><Step type='static'> 1\t2 </Step></Data>\
                </Analysis></Results>";
    let (reader, steps) = read_all(text.as_bytes());
    assert!(reader.diagnostics().is_empty());
    assert_eq!(
        steps,
        [
            (StepKind::Static, vec![0.0, 1e-3]),
            (StepKind::Static, vec![1.0, 2.0])
        ]
    );
}

#[test]
fn names_survive_xml() {
    let bytes = small_file(0);
    let (reader, _) = read_all(&bytes);
    assert_eq!(reader.header().title, "small & <round>");
}

#[test]
fn patterns_pick_columns_with_units() {
    let bytes = small_file(2);
    let mut reader = XrfReader::open("s.res", &bytes[..]).unwrap();
    let (selection, unused) = Selection::matching(
        reader.catalogue(),
        &["front.T?", "rig.arm.psi", "none.*", "LOAD"],
    );
    assert_eq!(unused, ["none.*"]);
    let mut csv = Vec::new();
    assert_eq!(selection.write_csv(&mut reader, &mut csv).unwrap(), 3);
    insta::assert_snapshot!(String::from_utf8(csv).unwrap());
    let mut reader = XrfReader::open("s.res", &bytes[..]).unwrap();
    let mut json = Vec::new();
    selection.write_json(&mut reader, &mut json).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["columns"][0]["path"], "rig.arm_XFORM.PSI");
    assert_eq!(json["columns"][1]["units"], "newton-mm");
    assert_eq!(json["steps"][2]["values"].as_array().unwrap().len(), 5);
}

#[test]
fn comparing_finds_the_column_the_step_and_the_amount() {
    let a = small_file(4);
    let open = |bytes: &'static [u8]| XrfReader::open("c.res", bytes).unwrap();
    let a: &'static [u8] = a.leak();
    let strict = Tolerance {
        absolute: 0.0,
        relative: 0.0,
    };
    let same = compare(&mut open(a), &mut open(a), strict).unwrap();
    assert!(same.agrees());
    assert_eq!(same.steps, 4);
    // Step 3 of the file is the third quasi-static step, and id 38 is FX of the bushing.
    let (_, steps) = read_all(a);
    let old = steps[3].1[37];
    let mut changed = Vec::new();
    let turned = steps[2].1[4] + std::f64::consts::TAU;
    let changes = [
        Change {
            step: 3,
            id: 38,
            value: old + 1e-3,
        },
        Change {
            step: 2,
            id: 5,
            value: turned,
        },
    ];
    rewrite("a", a, a, &mut changed, &changes).unwrap();
    let changed: &'static [u8] = changed.leak();
    let loose = Tolerance {
        absolute: 1e-12,
        relative: 0.0,
    };
    let report = compare(&mut open(a), &mut open(changed), loose).unwrap();
    assert!(!report.agrees());
    let worst: Vec<_> = report.columns.iter().filter(|c| c.beyond > 0).collect();
    assert_eq!(worst.len(), 1, "a full turn of PSI is no difference");
    assert_eq!(
        (worst[0].path.as_str(), worst[0].units.as_deref()),
        ("front.FX", Some("newton"))
    );
    assert!((worst[0].largest - 1e-3).abs() < 1e-12);
    assert_eq!(worst[0].worst.unwrap().step, 3);
    let wide = Tolerance {
        absolute: 2e-3,
        relative: 0.0,
    };
    assert!(
        compare(&mut open(a), &mut open(changed), wide)
            .unwrap()
            .agrees()
    );
    // A missing step, a different unit and a different name count as differences too.
    let fewer: &'static [u8] = small_file(3).leak();
    let report = compare(&mut open(a), &mut open(fewer), wide).unwrap();
    assert_eq!(
        (report.steps, report.steps_only_in_a, report.agrees()),
        (3, 1, false)
    );
    let text = std::str::from_utf8(a).unwrap();
    let units: &'static [u8] = text
        .replace("\"newton\"", "\"knewton\"")
        .into_bytes()
        .leak();
    assert_eq!(
        compare(&mut open(a), &mut open(units), wide)
            .unwrap()
            .units_differ
            .len(),
        3
    );
    let named: &'static [u8] = text.replace("\"load\"", "\"lord\"").into_bytes().leak();
    let report = compare(&mut open(a), &mut open(named), wide).unwrap();
    assert_eq!(
        (report.only_in_a, report.only_in_b),
        (vec!["load.Q".to_string()], vec!["lord.Q".to_string()])
    );
}

/// Returns the units with these keywords and seconds.
pub(super) fn units(force: &str, mass: &str, length: &str) -> Units {
    let find = |units: &[Unit], word| *units.iter().find(|u| u.keyword == word).unwrap();
    Units::new(
        find(FORCE_UNITS, force),
        find(MASS_UNITS, mass),
        find(LENGTH_UNITS, length),
        TIME_UNITS[0],
    )
}

#[test]
fn request_and_graphics_files_have_the_bytes_of_real_ones() {
    let inch = units("POUND_FORCE", "POUND_MASS", "INCH");
    let title = "Adams View model name: MODEL_1";
    // The times of the two files are 2023-06-13 22:52:01 and 2021-02-05 19:56:30, taken as UTC.
    let when = Timestamp::from_unix(1_686_696_721);
    if let Some(path) = shared("real-decks/aview-hpc/test.req") {
        let bytes = std::fs::read(path).unwrap();
        let read = RequestFile::parse(&Source::new("test.req", bytes.clone()));
        assert!(read.diagnostics.is_empty());
        assert_eq!(read.value.times.len(), 26);
        let mut writer = RequestWriter::create(Vec::new(), title, &inch, when, &[]).unwrap();
        for &time in &read.value.times {
            writer.step(time, &[]).unwrap();
        }
        assert_eq!(
            String::from_utf8(writer.finish()).unwrap(),
            String::from_utf8(bytes).unwrap()
        );
    }
    if let Some(path) = shared("real-decks/inverted-pendulum/Controls_Plant_1.req") {
        let text = std::fs::read_to_string(path).unwrap().replace("\r\n", "\n");
        let metre = units("NEWTON", "KILOGRAM", "METER");
        let when = Timestamp::from_unix(1_612_554_990);
        let title = "Adams View model name: Contorl_Automatic";
        let mut writer = RequestWriter::create(Vec::new(), title, &metre, when, &[]).unwrap();
        writer.step(0.0, &[]).unwrap();
        assert_eq!(String::from_utf8(writer.finish()).unwrap(), text);
    }
    if let Some(path) = shared("real-decks/aview-hpc/test.gra") {
        let text = std::fs::read_to_string(path).unwrap();
        let marker = |id| GraphicsMarker {
            id,
            part: 2,
            position: [0.0; 3],
            angles: [0.0; 3],
        };
        let head = GraphicsHead {
            title: title.to_string(),
            units: inch,
            ground: 1,
            parts: vec![2],
            markers: vec![marker(1), marker(2)],
            input: vec![[0.0; 6]],
            ..GraphicsHead::default()
        };
        let mut writer = GraphicsWriter::create(Vec::new(), when, &head).unwrap();
        let numbers = |line: &str| {
            line.split_whitespace()
                .map(|n| n.parse().unwrap())
                .collect::<Vec<f64>>()
        };
        let frames: Vec<&str> = text.lines().skip(11).collect();
        for frame in frames.chunks(2) {
            let pose = numbers(frame[1]);
            let pose = std::array::from_fn(|at| pose[at]);
            writer
                .frame(StepKind::Dynamic, numbers(frame[0])[0], &[pose], &[])
                .unwrap();
        }
        assert_eq!(String::from_utf8(writer.finish()).unwrap(), text);
    }
}
