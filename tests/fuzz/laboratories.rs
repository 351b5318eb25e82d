//! Fuzz targets for tables of laboratories and their mappings.

use admire_lab::{Block, CurveTable, FileOptions, Mapping, blocks, sheets};
use admire_syntax::text::Source;

use crate::harness::{assert_inside, fuzz};

/// Replies to the questions about a table, given in turn.
const REPLIES: [&str; 12] = [
    "left",
    "up",
    "in",
    "mm",
    "deg",
    "bounce",
    "406.4",
    "1",
    "+",
    "skip",
    "wheel_travel",
    "load F",
];

/// Checks that complaints are inside of the file and that an imported table is a table of numbers.
pub fn table(bytes: &[u8]) {
    let (options, mut out) = (FileOptions::default(), Vec::new());
    let source = Source::new("lab.csv", bytes);
    let Ok(read) = sheets(&source, &options, &mut out) else {
        return;
    };
    let mut found: Vec<Block> = Vec::new();
    for (index, sheet) in read.iter().enumerate() {
        found.extend(blocks(sheet, index, &options, &mut out));
    }
    let mut mapping = Mapping::proposed(&found, options);
    let mut count = 0;
    let answered = mapping.complete(&found, &read, &mut |_| {
        count += 1;
        Some(REPLIES[count % REPLIES.len()].to_string())
    });
    let table = CurveTable::new(&mapping, None, &found, &read, &mut out);
    for sheet in &read {
        let own = |d: &&admire_syntax::diagnostic::Diagnostic| {
            d.labels
                .iter()
                .all(|label| *label.file == *sheet.source.name())
        };
        let own: Vec<_> = out.iter().filter(own).cloned().collect();
        assert_inside(&own, sheet.source.name(), sheet.source.bytes());
    }
    let Some(table) = table.filter(|_| answered) else {
        return;
    };
    let mut reader = csv::Reader::from_reader(table.text.as_bytes());
    let width = reader.headers().expect("headings").len();
    for record in reader.records() {
        // Rows of another width are an error of the reader.
        let record = record.expect("a row as wide as the headings");
        for cell in record
            .iter()
            .skip(4)
            .take(width)
            .filter(|cell| !cell.is_empty())
        {
            let number: f64 = cell.parse().expect("a number");
            assert!(number.is_finite(), "{cell}");
        }
    }
}

/// Checks that complaints are inside of the file, and that a mapping that was read is written and read again.
pub fn mapping(bytes: &[u8]) {
    let read = Mapping::read(&Source::new("lab.toml", bytes));
    assert_inside(&read.diagnostics, "lab.toml", bytes);
    let Some(mapping) = read.value else {
        assert!(
            read.diagnostics.iter().any(|d| !d.message.is_empty()),
            "no mapping, and no reason"
        );
        return;
    };
    let text = mapping.text(&[]);
    let again = Mapping::read(&Source::new("again.toml", text.as_str())).value;
    let mut again = again.unwrap_or_else(|| panic!("what is written is not read: {text}"));
    for (own, before) in again.columns.iter_mut().zip(&mapping.columns) {
        own.span = before.span;
    }
    assert_eq!(again.columns, mapping.columns);
}

#[test]
fn tables_of_laboratories() {
    let plain = b"Rig 3;12.03.2026\nVersuch: Parallelhub\nEinfederung VL;Spur VL [min];Zeit;Seite\nmm;;s;\n-10;1,5;0,0;VL\n0;0,5;0,1;VL\n10;-,5;0,2;VR\nWank\n1;2;3;4\n";
    let book = include_bytes!("../kc/two_tests.xlsx");
    let seeds = [
        plain.to_vec(),
        book.to_vec(),
        b"t,z mm,toe\n0,1,2\n1,2,3\n".to_vec(),
    ];
    let words = [
        ";", ",", "\t", "\n", "\"", "1.500", "0,5", "[mm]", "min", "toe", "Radhub", "links", "nan",
        "-", "\u{feff}",
    ];
    fuzz("lab-table", 400, &seeds, &words.map(String::from));
}

#[test]
fn mappings_of_laboratories() {
    let plain = b"[file]\nheader = [2, 3]\ndecimal = \",\"\ntest = \"roll\"\n[columns]\n\"Toe\" = { is = \"toe_angle\", side = \"left\", positive = \"in\", over_mm = 400.0, unit = \"mm\" }\nF = { load = \"Fy\", load_sign = \"-\" }\n[tests]\nA = \"skip\"\n[sides]\nVL = \"left\"\n";
    let words = [
        "is = ",
        "\"time\"",
        "[columns]\n",
        "{",
        "}",
        "=",
        "\"\"",
        "every = 0",
        "nan",
        "inf",
        "\"?\"",
    ];
    fuzz(
        "lab-mapping",
        300,
        &[plain.to_vec()],
        &words.map(String::from),
    );
}
