//! Reading of large and of hostile decks: rates of the lossless document and of the typed model.
//!
//! `cargo bench --bench decks -- [MEGABYTES]`; the stated goals (150 MB/s to the document, 60 MB/s to the model) are for 100. A
//! hostile file is read twice, the second time doubled: time must not grow faster than the file.

#[path = "process.rs"]
mod process;

use std::fmt::Write;
use std::time::Instant;

use admire::model::Model;
use admire::syntax::{CommandFile, Dataset};
use admire::text::Source;
use process::{peak, rate, seconds};

fn main() {
    let megabytes = std::env::args()
        .skip(1)
        .find_map(|word| word.parse::<usize>().ok())
        .unwrap_or(100);
    println!("{} processors", rayon::current_num_threads());
    let bytes = deck(megabytes << 20);
    let size = bytes.len();
    println!("memory before reading: {}", peak());
    let source = Source::new("large.adm", bytes);
    for round in 1..=3 {
        let start = Instant::now();
        let read = rate(
            "lossless document",
            || size,
            || Dataset::parse(source.clone()),
        );
        assert_eq!(
            (read.value.bytes().len(), read.diagnostics.len()),
            (size, 0)
        );
        let statements = read.value.statements().len();
        let model = rate("its typed model", || size, || Model::lower(&read.value));
        assert!(model.diagnostics.is_empty());
        let seconds = start.elapsed().as_secs_f64();
        let megabytes = size as f64 / 1e6;
        println!(
            "round {round}, bytes to typed model   {megabytes:.0} MB: {:>6.0} MB/s; {statements} statements, {} markers",
            megabytes / seconds,
            model.value.markers.len()
        );
    }
    println!("peak memory: {}", peak());
    for (what, piece) in [
        ("one line of (", &b"("[..]),
        ("one line of ,", b","),
        ("lines of ,", b",\n"),
        ("one line of letters", b"A"),
        ("unmatched quotes", b"\"a\n"),
        ("quotes on one line", b"\""),
        ("statement heads", b"PART/"),
        ("nested calls", b"VARIABLE/1,FUNCTION=SIN("),
        ("equals signs", b"A="),
        ("backslashes", b"\\"),
        ("continued lines", b"&\n"),
        ("semicolons", b";"),
        ("NUL", b"\0"),
    ] {
        let once = time(piece, 10 << 20);
        let twice = time(piece, 20 << 20);
        println!(
            "hostile, {what:<22} 10 MB: {once:>6.2} s of processor, 20 MB: {twice:>6.2} s, ratio {:.1}",
            twice / once
        );
    }
}

/// Processor seconds to read so many bytes of a pattern as a dataset and as a command file.
fn time(piece: &[u8], size: usize) -> f64 {
    let mut bytes = b"title\n".to_vec();
    while bytes.len() < size {
        bytes.extend_from_slice(piece);
    }
    let source = Source::new("hostile", bytes);
    seconds(|| {
        let dataset = Dataset::parse(source.clone());
        let commands = CommandFile::parse(source.clone());
        assert_eq!(dataset.value.bytes(), commands.value.bytes());
    })
}

/// Parts with markers, bushings and forces in the way ADAMS/View writes them.
fn deck(size: usize) -> Vec<u8> {
    let mut out = String::with_capacity(size + 4096);
    out += "large deck\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";
    let mut id = 2u32;
    while out.len() < size {
        let x = (f64::from(id) * 0.37).sin() * 1000.0;
        let y = (f64::from(id) * 0.73).cos() * 500.0;
        let (cm, end) = (id * 10, id * 10 + 1);
        write!(
            out,
            "!\n!                             adams_view_name='part_{id}'\nPART/{id}\n, MASS = {:.6}\n, CM = {cm}\n\
             , IP = {:.4E}, {:.4E}, {:.4E}\n, QG = {x:.9}, {y:.9}, {:.9}\n, REULER = 90D, {:.3}D, 0D\n\
             !\n!                             adams_view_name='cm_{id}'\nMARKER/{cm}\n, PART = {id}\n, QP = {y:.9}, 0, {x:.9}\n\
             MARKER/{end}\n, PART = {id}\n, QP = {x:.9}, {y:.9}, -12.5\n, REULER = 0D, 90D, 45D\n\
             !                             adams_view_name='bush_{id}'\nBUSHING/{id}\n, I = {end}\n, J = 1\n\
             , K = 1.0E+04, 1.2E+04, {:.3}\n, KT = 5.0E+05, 5.0E+05, 3.0E+05\n, C = 10, 10, 10\n, CT = 100, 100, 100\n\
             SFORCE/{id}\n, TRANSLATIONAL\n, I = {cm}\n, J = 1\n, FUNCTION = {:.5}*STEP(TIME, 0, 0, 1, 1) - 0.5*DM({cm}, 1)\n",
            1.0 + y.abs() / 100.0,
            1e4 + x,
            2e4 + y,
            3e4,
            x - y,
            y / 10.0,
            1000.0 + y.abs(),
            x.abs(),
        )
        .expect("room");
        id += 1;
    }
    out += "ACCGRAV/\n, KGRAV = -9806.65\nEND\n";
    out.into_bytes()
}
