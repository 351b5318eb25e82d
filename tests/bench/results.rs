//! Benchmark of scanning a large XRF file, compared with quick-xml's event rate on the same file in the same run.
//!
//! `cargo bench --bench results -- [MEGABYTES]`; the goal (300 MB/s, memory independent of size) applies to 500 MB.

#[path = "process.rs"]
mod process;

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

use admire_results::{
    EntityKind, Header, Numbering, StepKind, Stored, Style, Timestamp, XrfReader, XrfWriter,
};
use admire_syntax::units::Units;
use process::{peak, rate};

fn main() {
    let megabytes = std::env::args()
        .skip(1)
        .find_map(|word| word.parse::<u64>().ok())
        .unwrap_or(50);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.res");
    timed("write", &path, || write(&path, megabytes << 20));
    println!("peak memory after writing: {}", peak());
    let steps = timed("scan, every step checked", &path, || scan(&path));
    println!("peak memory after scanning: {}", peak());
    timed("one column of every step", &path, || column(&path));
    timed("every value", &path, || values(&path));
    println!("peak memory after reading: {}", peak());
    let seen = timed("quick-xml, raw events", &path, || events(&path));
    assert_eq!(steps, seen);
}

fn timed<T>(what: &str, path: &Path, work: impl Fn() -> T) -> T {
    let size = || std::fs::metadata(path).expect("the file is there").len() as usize;
    rate(what, size, work)
}

/// Writes the results of a suspension of 30 parts, 30 joints and 20 bushings, with numbers that have no pattern.
fn write(path: &Path, size: u64) {
    let units = Units::default();
    let mut numbering = Numbering::new(units, Stored::default());
    for id in 1..=30 {
        numbering.object(EntityKind::Part, None, id, 0);
        numbering.object(EntityKind::Joint, None, id, 0);
    }
    for id in 1..=20 {
        numbering.object(EntityKind::Bushing, None, id, 0);
    }
    let catalogue = numbering.finish();
    let header = Header::new("large.res", "bench", &units, Timestamp::from_unix(0));
    let file = BufWriter::new(File::create(path).expect("a new file"));
    let mut writer = XrfWriter::create(file, &header, &catalogue, Style::default()).expect("room");
    let mut values = vec![0.0; catalogue.len()];
    let steps = size / (catalogue.len() as u64 * 20);
    for step in 0..steps {
        for (at, value) in values.iter_mut().enumerate() {
            *value = 300.0 * ((at as f64 + 1.0) * 0.37 + step as f64 * 0.011).sin();
        }
        values[0] = step as f64;
        writer.step(StepKind::QuasiStatic, &values).expect("room");
    }
    writer.finish("Successful").expect("room");
}

fn open(path: &Path) -> XrfReader<File> {
    XrfReader::open("large.res", File::open(path).expect("the file is there")).expect("good file")
}

fn scan(path: &Path) -> usize {
    let mut reader = open(path);
    let mut count = 0;
    while reader.next_step().expect("good file").is_some() {
        count += 1;
    }
    count
}

fn column(path: &Path) -> f64 {
    let mut reader = open(path);
    let mut picked = Vec::new();
    while let Some(step) = reader.next_step().expect("good file") {
        picked.clear();
        step.pick(&[1, 100], &mut picked).expect("numbers");
    }
    picked[1]
}

fn values(path: &Path) -> f64 {
    let mut reader = open(path);
    let mut values = Vec::new();
    let mut sum = 0.0;
    while let Some(step) = reader.next_step().expect("good file") {
        step.values(&mut values).expect("numbers");
        sum += values[1];
    }
    sum
}

fn events(path: &Path) -> usize {
    let file = BufReader::with_capacity(1 << 18, File::open(path).expect("the file is there"));
    let mut reader = quick_xml::Reader::from_reader(file);
    let (mut buffer, mut steps) = (Vec::new(), 0);
    loop {
        match reader.read_event_into(&mut buffer).expect("good XML") {
            quick_xml::events::Event::Eof => return steps,
            quick_xml::events::Event::Start(tag) if tag.name().as_ref() == "Step" => steps += 1,
            _ => {}
        }
        buffer.clear();
    }
}
