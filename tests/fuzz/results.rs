//! Fuzz targets for results files of every format.

use admire_results::{
    FormattedResults, GraphicsFile, Header, MessageFile, NumberStyle, RequestFile, RequestWriter,
    ResultsReader, Style, Timestamp, XrfReader, XrfWriter, open_any, rewrite,
};
use admire_syntax::text::Source;
use admire_syntax::units::Units;
use rand::RngExt;

use crate::harness::{assert_inside, fuzz};
use crate::mutation::drawn;
use crate::seeds;

/// Steps of a results file: the kind and the values of each.
type Steps = Vec<(admire_results::StepKind, Vec<f64>)>;

fn steps(reader: &mut dyn ResultsReader) -> (Steps, bool) {
    let mut all = Vec::new();
    loop {
        match reader.next_step() {
            Ok(None) => return (all, true),
            Err(_) => return (all, false),
            Ok(Some(step)) => {
                let mut values = Vec::new();
                if step.values(&mut values).is_err() {
                    return (all, false);
                }
                all.push((step.kind, values));
            }
        }
    }
}

/// Formats a value for comparison, with each control character replaced by a blank as in XML output.
fn shown(of: &impl std::fmt::Debug) -> String {
    let text = format!("{of:?}");
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find('\\') {
        out.push_str(&rest[..at]);
        let escape = &rest[at + 1..];
        let length = match escape.as_bytes() {
            [b'u', ..] => escape.find('}').map_or(1, |end| end + 1),
            _ => 1,
        };
        match &escape[..length] {
            kept @ ("\"" | "\\" | "'") => out.push_str(kept),
            _ => out.push(' '),
        }
        rest = &escape[length..];
    }
    out + rest
}

/// Checks that an XRF file is copied byte for byte, and that its content is the same after writing and reading again.
pub fn xrf(bytes: &[u8]) {
    let Ok(mut reader) = XrfReader::open("a.res", bytes) else {
        return;
    };
    let (read, whole) = steps(&mut reader);
    assert_inside(reader.diagnostics(), "a.res", bytes);
    let columns = reader.columns();
    assert!(read.iter().all(|(_, values)| values.len() == columns));
    let mut copy = Vec::new();
    if rewrite("a.res", bytes, bytes, &mut copy, &[]).is_ok() {
        assert!(copy == bytes, "a copy differs");
    } else {
        assert!(!whole, "what can be read can be copied");
    }
    let style = Style {
        numbers: NumberStyle::SeventeenDigits,
        ..Style::default()
    };
    let mut writer =
        XrfWriter::create(Vec::new(), reader.header(), reader.catalogue(), style).expect("memory");
    let finite = |(_, values): &&(_, Vec<f64>)| values.iter().all(|value| value.is_finite());
    let kept: Vec<_> = read.iter().filter(finite).cloned().collect();
    for (kind, values) in &kept {
        writer
            .step(*kind, values)
            .expect("finite values of every column");
    }
    let written = writer.finish("Successful").expect("memory");
    let mut again = XrfReader::open("b.res", written.as_slice()).expect("what is written is read");
    // The end of the comment is trimmed, because a comment is written as whole lines.
    let of_lines = |header: &Header| Header {
        comment: header
            .comment
            .trim_end_matches(|c: char| c.is_control() || c.is_whitespace())
            .to_string(),
        ..header.clone()
    };
    assert_eq!(
        shown(&of_lines(again.header())),
        shown(&of_lines(reader.header()))
    );
    assert_eq!(shown(again.catalogue()), shown(reader.catalogue()));
    let (back, whole) = steps(&mut again);
    assert!(whole && back == kept, "what is written is read back");
}

/// Checks the bytes as an XRF file in memory, and then as a file of any format on disk.
pub fn xrf_or_other(bytes: &[u8]) {
    xrf(bytes);
    any(bytes);
}

/// Reads a file on disk in any format that is presented as XRF.
fn any(bytes: &[u8]) {
    // Only one case in eight is run, because disk access is slow.
    if drawn(bytes).random_range(0..8) > 0 {
        return;
    }
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), bytes).expect("a temporary file");
    let name = file.path().display().to_string();
    if let Ok(opened) = open_any(file.path()) {
        assert_inside(&opened.diagnostics, &name, bytes);
        let mut reader = opened.value;
        steps(reader.as_mut());
    }
}

pub fn requests(bytes: &[u8]) {
    any(bytes);
    let read = RequestFile::parse(&Source::new("a.req", bytes));
    assert_inside(&read.diagnostics, "a.req", bytes);
    let file = read.value;
    assert_eq!(file.times.len(), file.values.len());
    assert!(
        file.values
            .iter()
            .all(|sixes| sixes.len() == file.requests.len())
    );
    // Numbers are written with six digits, so values may differ after reading again.
    let when = Timestamp::from_unix(0);
    let mut writer = RequestWriter::create(
        Vec::new(),
        &file.title,
        &Units::default(),
        when,
        &file.requests,
    )
    .expect("memory");
    for (time, values) in file.times.iter().zip(&file.values) {
        writer.step(*time, values).expect("values of every request");
    }
    let again = RequestFile::parse(&Source::new("b.req", writer.finish()));
    if read.diagnostics.is_empty() {
        assert_eq!(again.diagnostics, []);
        let ids = |file: &RequestFile| -> Vec<i64> { file.requests.iter().map(|r| r.id).collect() };
        assert_eq!(ids(&again.value), ids(&file));
        assert_eq!(again.value.times.len(), file.times.len());
        let flat = |file: &RequestFile| -> Vec<f64> {
            file.values.iter().flatten().flatten().copied().collect()
        };
        for (a, b) in flat(&file).into_iter().zip(flat(&again.value)) {
            assert!(
                (a - b).abs() <= 1e-5 * a.abs() || a.to_bits() == b.to_bits(),
                "{a} is read back as {b}"
            );
        }
    }
}

pub fn graphics(bytes: &[u8]) {
    any(bytes);
    let read = GraphicsFile::parse(&Source::new("a.gra", bytes));
    assert_inside(&read.diagnostics, "a.gra", bytes);
    let frames = read.value.times.len();
    assert_eq!(frames, read.value.poses.len());
    assert_eq!(
        (read.value.kinds.len(), read.value.loads.len()),
        (frames, frames)
    );
    let forces = read.value.forces.len();
    assert!(read.value.loads.iter().all(|loads| loads.len() == forces));
    assert!(
        read.value
            .poses
            .iter()
            .all(|poses| poses.len() == read.value.parts.len())
    );
}

pub fn formatted(bytes: &[u8]) {
    any(bytes);
    let read = FormattedResults::parse(&Source::new("a.res", bytes));
    assert_inside(&read.diagnostics, "a.res", bytes);
}

pub fn messages(bytes: &[u8]) {
    let source = Source::new("a.msg", bytes);
    MessageFile::is_one(&source);
    let file = MessageFile::parse(&source);
    let lines = bytes.iter().filter(|byte| **byte == b'\n').count() + 1;
    let places = file
        .analyses
        .iter()
        .map(|a| a.line)
        .chain(file.frames.iter().map(|f| f.line));
    for line in places {
        assert!(line >= 1 && line <= lines, "line {line} of {lines}");
    }
}

#[test]
fn xrf_files() {
    let real = seeds::all("res")
        .into_iter()
        .filter(|bytes| bytes.starts_with(b"<"));
    let seeds: Vec<_> = real.chain([seeds::xrf()]).collect();
    let words = [
        "<Step type=\"quasiStatic\">\n",
        "</Step>\n",
        "<Data name=\"x\" id=\"1\">",
        "</Data>",
        "<Entity name=\"a\">",
        "</Entity>",
        "<Component name=\"X\" id=\"2\" />",
        "<!-- -->",
        "<![CDATA[",
        "]]>",
        "<!DOCTYPE a [<!ENTITY b \"c\">]>",
        "&lt;",
        "&#0;",
        "&#x1F600;",
        "&amp",
        "&b;",
        "<?xml version=\"1.0\" encoding=\"UTF-16\"?>",
        "</Results>",
        "</Analysis>",
        "</StepMap>",
        " />",
    ];
    fuzz("xrf", 2500, &seeds, &words.map(String::from));
}

#[test]
fn request_files() {
    let seeds: Vec<_> = seeds::all("req")
        .into_iter()
        .chain([seeds::req()])
        .collect();
    let words = [" A.R3    ", "REQUEST 1", "MMKGS_N_RACA", "1.00000E+00"];
    fuzz("request-file", 4000, &seeds, &words.map(String::from));
}

#[test]
fn graphics_files() {
    let seeds: Vec<_> = seeds::all("gra")
        .into_iter()
        .chain([seeds::gra()])
        .collect();
    let words = [" A.G8", "-0.999999E+06", "MMKGS_N_RACA"];
    fuzz("graphics-file", 4000, &seeds, &words.map(String::from));
}

#[test]
fn formatted_files() {
    let real = seeds::all("res")
        .into_iter()
        .filter(|bytes| bytes.starts_with(b"FILE TYPE"));
    let seeds: Vec<_> = real.chain([seeds::formatted()]).collect();
    let words = [
        "RIGID PARTS MAP",
        "ANALYSIS BLOCK",
        "YES",
        "NO ",
        "STATIC",
        "NAME MAP",
    ];
    fuzz("formatted-file", 4000, &seeds, &words.map(String::from));
}

#[test]
fn message_files() {
    let seeds: Vec<_> = seeds::all("msg")
        .into_iter()
        .chain([seeds::MSG.as_bytes().to_vec()])
        .collect();
    let words = [
        "---- START: ERROR ----\n",
        "---- END: ERROR ----\n",
        "  Begin Simulation\n",
        "  End Simulation\n",
        "Finished -----\n",
        "Elapsed time = ",
        " command: ",
        "|   Model Title  |\n",
    ];
    fuzz("message-file", 3000, &seeds, &words.map(String::from));
}
