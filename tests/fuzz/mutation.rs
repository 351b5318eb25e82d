//! Mutations of files: changes of bytes, words and lines, insertion of grammar words, and splicing of two files.

use admire_syntax::grammar::{FUNCTIONS, STATEMENTS};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Maximum length of a seed, in bytes. A random piece of a longer file is used: it keeps a case short, and cuts the file at random
/// places.
const LONGEST: usize = 24_000;

const MARKS: &[u8] =
    b",,,;&\\/=()\"'!:+-*.0123456789EDed \t\r\n\0\x1a\x1b\xff\xb7\xc3\xef\xbb\xbf<>[]{}#$%KP";

/// Numbers at the edges of the accepted ranges and spellings.
pub const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "0.5",
    "1e-320",
    "4.9E-324",
    "1E308",
    "1.7976931348623157e308",
    "1e400",
    "-1e400",
    "1e-400",
    "nan",
    "NaN",
    "inf",
    "-Infinity",
    "1.#IND",
    "1D",
    "1e",
    "1e+",
    ".",
    "-",
    "+",
    "--1",
    "1.2.3",
    "0x10",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "99999999999999999999999999999999999999999999",
    "180D",
    "1d5",
    "1,5",
    "1e9999999999",
    "00000000000000000001",
    "1_000",
];

fn pick<'a, T>(all: &'a [T], random: &mut Pcg64) -> &'a T {
    &all[random.random_range(0..all.len())]
}

/// Returns a seed, or two spliced seeds, with one to five random changes.
pub fn mutated(seeds: &[Vec<u8>], words: &[String], random: &mut Pcg64) -> Vec<u8> {
    let mut out = window(pick::<Vec<u8>>(seeds, random), random);
    if random.random_range(0..5) == 0 {
        let other = window(pick::<Vec<u8>>(seeds, random), random);
        out = spliced(&out, &other, random);
    }
    for _ in 0..random.random_range(1..=5) {
        match random.random_range(0..3) {
            0 => change_bytes(&mut out, random),
            1 => change_words(&mut out, words, random),
            _ => change_lines(&mut out, random),
        }
        // The length is limited because repeated duplication of lines could produce gigabytes.
        out.truncate(2 * LONGEST);
    }
    out
}

/// Returns a file, or a random piece of a long one. Half of the pieces start at the beginning, because readers reject a file without its
/// header.
fn window(bytes: &[u8], random: &mut Pcg64) -> Vec<u8> {
    if bytes.len() <= LONGEST {
        return bytes.to_vec();
    }
    let from = if random.random() {
        0
    } else {
        random.random_range(0..bytes.len() - LONGEST / 2)
    };
    let length = random.random_range(LONGEST / 4..LONGEST);
    bytes[from..(from + length).min(bytes.len())].to_vec()
}

/// Joins the beginning of one file and the end of another, both cut at line ends.
fn spliced(a: &[u8], b: &[u8], random: &mut Pcg64) -> Vec<u8> {
    let cut = |bytes: &[u8], random: &mut Pcg64| {
        let at = random.random_range(0..=bytes.len());
        memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |end| at + end + 1)
    };
    let (end, start) = (cut(a, random), cut(b, random));
    [&a[..end], &b[start..]].concat()
}

fn change_bytes(out: &mut Vec<u8>, random: &mut Pcg64) {
    let at = random.random_range(0..=out.len());
    match random.random_range(0..6) {
        0 => out.truncate(at),
        1 => {
            let to = (at + random.random_range(0..40)).min(out.len());
            out.drain(at..to);
        }
        2 => {
            let some: Vec<u8> = (0..random.random_range(1..6))
                .map(|_| *pick(MARKS, random))
                .collect();
            out.splice(at..at, some);
        }
        3 if at < out.len() => out[at] = *pick(MARKS, random),
        4 if at < out.len() => out[at] = random.random(),
        _ => {
            let to = (at + random.random_range(0..400)).min(out.len());
            let text = out[at..to].to_vec();
            out.splice(at..at, text);
        }
    }
}

/// Returns the ranges of the words of a text. A word is a run of letters, digits, `_`, `.` and `-`; any other visible character is a word by
/// itself.
fn words_of(bytes: &[u8]) -> Vec<std::ops::Range<usize>> {
    let belongs = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'-');
    let mut all = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let from = at;
        at += 1;
        if belongs(bytes[from]) {
            while at < bytes.len() && belongs(bytes[at]) {
                at += 1;
            }
        } else if bytes[from].is_ascii_whitespace() {
            continue;
        }
        all.push(from..at);
    }
    all
}

fn change_words(out: &mut Vec<u8>, words: &[String], random: &mut Pcg64) {
    let all = words_of(out);
    if all.is_empty() {
        return;
    }
    let at = pick(&all, random).clone();
    let new: Vec<u8> = match random.random_range(0..5) {
        0 => Vec::new(),
        1 => out[pick(&all, random).clone()].to_vec(),
        2 => pick(NUMBERS, random).as_bytes().to_vec(),
        3 if !words.is_empty() => pick(words, random).as_bytes().to_vec(),
        _ => {
            // Two words are swapped.
            let other = pick(&all, random).clone();
            let (a, b) = (out[at.clone()].to_vec(), out[other.clone()].to_vec());
            let (first, then) = if at.start < other.start {
                ((at, b), (other, a))
            } else {
                ((other, a), (at, b))
            };
            out.splice(then.0, then.1);
            out.splice(first.0, first.1);
            return;
        }
    };
    out.splice(at, new);
}

fn change_lines(out: &mut Vec<u8>, random: &mut Pcg64) {
    let mut lines: Vec<Vec<u8>> = out
        .split_inclusive(|byte| *byte == b'\n')
        .map(<[u8]>::to_vec)
        .collect();
    if lines.is_empty() {
        return;
    }
    let (a, b) = (
        random.random_range(0..lines.len()),
        random.random_range(0..lines.len()),
    );
    match random.random_range(0..5) {
        0 => drop(lines.remove(a)),
        1 => lines.swap(a, b),
        2 => {
            let line = lines[a].clone();
            lines.insert(b, line);
        }
        3 => {
            // A line is repeated, to produce many rows or many objects with the same id.
            let line = lines[a].clone();
            for _ in 0..random.random_range(2..30) {
                lines.insert(b, line.clone());
            }
        }
        _ => {
            // The line ends are changed from some line on.
            let dos = random.random();
            for line in lines.iter_mut().skip(a) {
                line.retain(|byte| *byte != b'\r');
                if dos && line.last() == Some(&b'\n') {
                    line.insert(line.len() - 1, b'\r');
                }
            }
        }
    }
    *out = lines.concat();
}

/// Returns every word of the dataset language, both alone and with the punctuation of its usual context.
pub fn grammar_words() -> Vec<String> {
    let mut all = Vec::new();
    for statement in STATEMENTS {
        all.push(statement.name.to_string());
        all.push(format!("\n{}/1", statement.name));
        for argument in statement.arguments {
            all.push(argument.name.to_string());
            all.push(format!(", {}=", argument.name));
        }
    }
    all.extend(function_words());
    all.sort();
    all.dedup();
    all
}

/// Returns every function name, both alone and as a call, and further words of expressions.
pub fn function_words() -> Vec<String> {
    let mut all: Vec<String> = FUNCTIONS
        .iter()
        .flat_map(|function| {
            [
                function.name.to_string(),
                format!("{}(1,2,3)", function.name),
            ]
        })
        .collect();
    all.extend(
        [
            "TIME", "PI", "DTOR", "**", "(", ")", "IF(", ":", "\\", "&\n,", "!x\n",
        ]
        .map(String::from),
    );
    all
}

/// Returns a random number generator seeded by the bytes, so that the choices of a case are reproducible.
pub fn drawn(bytes: &[u8]) -> Pcg64 {
    Pcg64::seed_from_u64(bytes.iter().fold(7, |sum: u64, byte| {
        sum.wrapping_mul(31).wrapping_add(u64::from(*byte))
    }))
}
