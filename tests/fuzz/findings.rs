//! Regression tests for faults found by fuzzing, each with the smallest input that showed it.

use admire_kc as kc;
use admire_results::{RequestFile, rewrite};
use admire_session::check;
use admire_study::{Study, Table};
use admire_syntax::text::{Source, Span};

use crate::{results, studies};

/// Checks the results of a diverged run, which contain infinities and NaN. Copying or editing them panicked, because these values have no
/// exponent.
#[test]
fn results_of_a_diverged_run_are_copied_as_they_are() {
    for value in ["inf", "-inf", "nan", "1.#INF", "-1.#IND"] {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<Results>\n<Analysis>\n<StepMap name=\"map\">\n<Entity name=\"time\">\n<Component name=\"TIME\" id=\"1\" />\n\
             </Entity>\n<Entity name=\"a\">\n<Component name=\"X\" id=\"2\" />\n</Entity>\n</StepMap>\n<Data name=\"d\" id=\"1\">\n\
             <Step type=\"dynamic\">\n1.5\n{value}\n</Step>\n</Data>\n</Analysis>\n</Results>\n"
        );
        results::xrf(text.as_bytes());
        let mut copy = Vec::new();
        let report = rewrite("a.res", text.as_bytes(), text.as_bytes(), &mut copy, &[]).unwrap();
        assert_eq!((report.kept, report.reprinted), (1, 0), "{value}");
        assert_eq!(copy, text.as_bytes());
    }
}

/// Checks a request whose name reads as a number once its control character is replaced by a blank. The name was then taken for a number.
#[test]
fn a_request_whose_name_becomes_a_number_keeps_its_values() {
    results::requests(
        b"A.R3\na\n2\n1\n4\n\x1b1\n0\n0 0 0 0 0 6 0 0 0 0 0 0\n1 0 0 0 0 0 0\n0 0 0 0 0 0\n",
    );
}

/// Checks a file of a model without a title. The blank title line was skipped, and the next line was taken for the title.
#[test]
fn a_title_of_blanks_is_one() {
    for title in ["", "\x01\x04"] {
        let text = format!("A.R3\n{title}\n1\nname\n1 1 2 3\n0\n1 2 3 4 5 6\n");
        results::requests(text.as_bytes());
        let read = RequestFile::parse(&Source::new("a.req", text.as_bytes()));
        assert_eq!(read.diagnostics, []);
        assert_eq!((read.value.requests[0].id, read.value.times.len()), (1, 1));
    }
}

/// Checks numbers that fill their columns. They were written without a blank between them, so that they were read as one number or not at
/// all.
#[test]
fn numbers_that_fill_their_columns_stay_two() {
    for text in [
        "A.R3\na\n1\n1 4294967295 -4294967295\n0\n1 2 3 4 5 6\n",
        "A.R3\na\n1\n1\n0\n-1E109 -1E109 0 -1E-300 0 0\n",
    ] {
        results::requests(text.as_bytes());
    }
}

/// Checks that a quotation mark inside a cell is an ordinary character. The spans of later cells were wrong.
#[test]
fn a_quote_within_a_cell_ends_no_cell() {
    for text in [
        "case,x\n5\",1.5\n",
        "case,x\n \"a,b\n",
        "case,x\n\"a\"b\",c\n",
        "case,x\n\"a\"\"b\",c\n",
    ] {
        studies::table(text.as_bytes());
        let table = Table::read(Source::new("a.csv", text.as_bytes()), &mut Vec::new());
        let row = &table.rows()[0];
        assert_eq!(row.len(), 2, "{text}");
        assert_eq!(table.source.text(row[1].span), row[1].text, "{text}");
    }
}

/// Checks that a byte order mark is skipped only at the start of a file. Elsewhere its three bytes are text.
#[test]
fn a_mark_of_utf_8_within_a_table_is_text() {
    let text = "0\n\u{feff}\n";
    studies::table(text.as_bytes());
    let table = Table::read(Source::new("a.csv", text.as_bytes()), &mut Vec::new());
    assert_eq!(table.rows()[0][0].span, Span::new(2, 5));
}

/// Checks that names in a Latin-1 table match names in a Latin-1 deck.
#[test]
fn a_table_in_latin_1_has_the_names_of_the_deck() {
    let text = b"case,part\n1,Quertr\xe4ger\n";
    let table = Table::read(Source::new("a.csv", &text[..]), &mut Vec::new());
    assert_eq!(table.rows()[0][1].text, "Quertr\u{e4}ger");
}

/// Checks settings in Latin-1, which are refused at the first invalid byte. Each such byte was counted as two, so spans exceeded the file.
#[test]
fn settings_that_are_not_utf_8_are_refused_at_the_byte() {
    let bytes = b"# \xe4\n\xe4";
    let there = Span::new(2, 3);
    let test_rig = kc::Config::read(&Source::new("kc.toml", &bytes[..]), 1.0, 1.0);
    assert!(test_rig.value.is_none());
    assert_eq!(test_rig.diagnostics[0].labels[0].span, there);
    let wrong = check::Settings::parse(&Source::new("admire.toml", &bytes[..])).unwrap_err();
    assert_eq!(wrong[0].labels[0].span, there);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), bytes).unwrap();
    let study = Study::read(folder.path());
    assert!(study.value.is_none());
    assert_eq!(study.diagnostics[0].labels[0].span, there);
}
