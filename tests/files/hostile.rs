//! Tests that any bytes give a document and diagnostics, without a panic or a hang, in time at most proportional to the file size.

use std::time::{Duration, Instant};

use admire_solver::model::Model;
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rayon::prelude::*;

use super::lossless::{assert_commands, assert_dataset, real_files};

/// Applies one to four random changes: truncation, deletion, insertion, duplication, or another line end.
fn mutate(bytes: &[u8], random: &mut impl Rng) -> Vec<u8> {
    const SPICE: &[u8] = b",,,;&\\/=()\"'!:+-*.0123456789EDed \t\r\n\0\x1a\xff\xb7AKPFUNCTION";
    let mut out = bytes.to_vec();
    for _ in 0..random.random_range(1..=4) {
        let at = random.random_range(0..=out.len());
        match random.random_range(0..7) {
            0 => out.truncate(at),
            1 => {
                let to = (at + random.random_range(0..40)).min(out.len());
                out.drain(at..to);
            }
            2 | 3 => {
                let count = random.random_range(1..6);
                let spice: Vec<u8> = (0..count)
                    .map(|_| SPICE[random.random_range(0..SPICE.len())])
                    .collect();
                out.splice(at..at, spice);
            }
            4 if at < out.len() => out[at] = SPICE[random.random_range(0..SPICE.len())],
            5 => {
                let to = (at + random.random_range(0..400)).min(out.len());
                let text: Vec<u8> = out[at..to].to_vec();
                out.splice(at..at, text);
            }
            _ if out.contains(&b'\r') => out.retain(|byte| *byte != b'\r'),
            _ => {
                out = out
                    .iter()
                    .flat_map(|byte| match byte {
                        b'\n' => vec![b'\r', b'\n'],
                        byte => vec![*byte],
                    })
                    .collect();
            }
        }
    }
    out
}

#[test]
fn ten_thousand_mutations_of_real_files_are_read_without_loss() {
    let decks = real_files("adm");
    let commands = real_files("acf");
    if decks.is_empty() {
        return;
    }
    (0..10_000u64).into_par_iter().for_each(|seed| {
        let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
        if seed % 8 == 0 {
            let (name, bytes) = &commands[random.random_range(0..commands.len())];
            let bytes = mutate(bytes, &mut random);
            let file = CommandFile::parse(Source::new(name.as_str(), bytes.clone())).value;
            assert_commands(&file, &bytes);
            return;
        }
        let (name, bytes) = &decks[random.random_range(0..decks.len())];
        // A long deck is cut to a random window, so that its end too falls at random places.
        let from = random.random_range(0..bytes.len());
        let window = if bytes.len() > 60_000 {
            &bytes[from..(from + 30_000).min(bytes.len())]
        } else {
            bytes
        };
        let bytes = mutate(window, &mut random);
        let checked = Dataset::parse(Source::new(name.as_str(), bytes.clone()));
        assert_dataset(&checked.value, &bytes);
        for diagnostic in &checked.diagnostics {
            assert!(
                diagnostic
                    .labels
                    .iter()
                    .all(|label| label.span.end() <= bytes.len())
            );
        }
        Model::lower(&checked.value);
    });
}

proptest! {
    #[test]
    fn any_bytes_are_a_dataset_and_a_command_file(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let dataset = Dataset::parse(Source::new("any", bytes.clone())).value;
        assert_dataset(&dataset, &bytes);
        Model::lower(&dataset);
        assert_commands(&CommandFile::parse(Source::new("any", bytes.clone())).value, &bytes);
    }

    #[test]
    fn any_text_of_the_language_s_marks_is_read(text in "[A-J/,;&!=\\\\():\"0-9.ED\r\n \t+*-]{0,300}") {
        let bytes = format!("title\nSFORCE/1, FUNCTION={text}").into_bytes();
        let dataset = Dataset::parse(Source::new("any", bytes.clone())).value;
        assert_dataset(&dataset, &bytes);
        Model::lower(&dataset);
    }
}

fn time(bytes: &[u8]) -> Duration {
    let source = Source::new("hostile", bytes);
    let start = Instant::now();
    let dataset = Dataset::parse(source).value;
    Model::lower(&dataset);
    start.elapsed()
}

#[test]
fn time_grows_with_the_file_and_not_faster() {
    for (lead, unit) in [
        ("t\n", "("),
        ("t\n", ")"),
        ("t\n", ","),
        ("t\n", "\""),
        ("t\n", "\"\n"),
        ("t\n", ";"),
        ("t\n", "&"),
        ("t\n", "& "),
        ("t\n", "&\n"),
        ("t\n", "!"),
        ("t\n", "!\n"),
        ("t\n", "\r"),
        ("t\n", "a"),
        ("t\n", "a "),
        ("t\n", "a\n"),
        ("t\n", ",\n"),
        ("t\nPART/1", ",A"),
        ("t\nPART/1", ",\n"),
        ("t\nPART/1, QG=", "1,"),
        ("t\nPART/1, QG=", "1"),
        ("t\nPART/1, QG=", "-"),
        ("t\nPART/1, EXACT=", "X:"),
        ("t\nSFORCE/1, FUNCTION=", "("),
        ("t\nSFORCE/1, FUNCTION=", "-"),
        ("t\nSFORCE/1, FUNCTION=", "1+"),
        ("t\nSFORCE/1, FUNCTION=", "\n, I"),
        ("t\nSFORCE/1, FUNCTION=1", "\\"),
        ("t\nREQUEST/1, COMMENT=", "a,"),
        ("t\nREQUEST/1, COMMENT=", "a\n,"),
        ("t\nREQUEST/1, TITLE=", ":"),
        ("t\nREQUEST/1, CNAMES=", "\"\","),
        ("t\n", "MARKER/1, PART=1, QP=1,2,3\n"),
        ("t\n", "ENDD\n"),
    ] {
        let make = |length: usize| {
            let mut bytes = lead.as_bytes().to_vec();
            while bytes.len() < length {
                bytes.extend_from_slice(unit.as_bytes());
            }
            bytes
        };
        let (short, long) = (make(200_000), make(1_600_000));
        // The long text has eight times the bytes of the short one, so quadratic time would be 64 times as long. Other programs can only
        // lengthen a measurement. The short text therefore counts with its best of three, and one good measurement of the long text is
        // enough. Two seconds are added as slack.
        let mut seen = Vec::new();
        let linear = (0..18).any(|_| {
            let of_short = (0..3).map(|_| time(&short)).min().unwrap();
            let (short, long) = (of_short, time(&long));
            seen.push((short, long));
            long < short * 24 + Duration::from_secs(2)
        });
        assert!(linear, "{lead:?} {unit:?}: {seen:?}");
    }
}

/// Checks that the number of diagnostics of a nonsense file is limited, and that a last message reports the unlisted ones.
#[test]
fn complaints_are_counted_not_kept_without_end() {
    for line in ["A\n", "XYZ/1\n", "PART/1\n", "VARIABLE/1, FUNCTION=SIN(\n"] {
        let text = format!("t\n{}END\n", line.repeat(60_000));
        let read = Dataset::parse(Source::new("a.adm", text.as_bytes()));
        let found =
            admire_syntax::lint::check(&read.value, &admire_syntax::lint::Options::default());
        assert!(read.diagnostics.len() <= 10_001, "{line}");
        let all: Vec<_> = read.diagnostics.iter().chain(&found).collect();
        assert!(all.len() < 60_000, "{line}");
        let told = all.iter().any(|d| d.message.ends_with("are not listed"));
        assert!(told, "{line}");
    }
}
