//! What was found, each with the smallest input that shows it.

use admire_kc as kc;
use admire_results::{RequestFile, rewrite};
use admire_session::check;
use admire_study::{Study, Table};
use admire_syntax::text::{Source, Span};

use crate::{results, studies};

/// A run that diverged leaves infinities and NaN; copying or editing its results panicked on the exponent they do not have.
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

/// A name that was no number until its control character had become a blank was read as one.
#[test]
fn a_request_whose_name_becomes_a_number_keeps_its_values() {
    results::requests(
        b"A.R3\na\n2\n1\n4\n\x1b1\n0\n0 0 0 0 0 6 0 0 0 0 0 0\n1 0 0 0 0 0 0\n0 0 0 0 0 0\n",
    );
}

/// A model without a title: its line is blank, and the one behind it was taken for it.
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

/// Numbers that fill their columns were written without a blank between them, and read as one or as none.
#[test]
fn numbers_that_fill_their_columns_stay_two() {
    for text in [
        "A.R3\na\n1\n1 4294967295 -4294967295\n0\n1 2 3 4 5 6\n",
        "A.R3\na\n1\n1\n0\n-1E109 -1E109 0 -1E-300 0 0\n",
    ] {
        results::requests(text.as_bytes());
    }
}

/// A quote within a cell is a letter; the places of the cells behind it were lost.
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

/// The mark of UTF-8 stands in front of a file; three bytes of it elsewhere are text.
#[test]
fn a_mark_of_utf_8_within_a_table_is_text() {
    let text = "0\n\u{feff}\n";
    studies::table(text.as_bytes());
    let table = Table::read(Source::new("a.csv", text.as_bytes()), &mut Vec::new());
    assert_eq!(table.rows()[0][0].span, Span::new(2, 5));
}

/// A table in Latin-1 names the parts that a deck in Latin-1 does.
#[test]
fn a_table_in_latin_1_has_the_names_of_the_deck() {
    let text = b"case,part\n1,Quertr\xe4ger\n";
    let table = Table::read(Source::new("a.csv", &text[..]), &mut Vec::new());
    assert_eq!(table.rows()[0][1].text, "Quertr\u{e4}ger");
}

/// Settings in Latin-1 were read as if each such byte were two, and complaints stood behind the end of the file.
#[test]
fn settings_that_are_not_utf_8_are_refused_at_the_byte() {
    let bytes = b"# \xe4\n\xe4";
    let there = Span::new(2, 3);
    let test_rig = kc::Config::read(&Source::new("kc.toml", &bytes[..]), (1.0, 1.0));
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
