use std::io::{self, Write};

use super::Timestamp;
use super::fortran::exponential;

/// A request, as shown on the pages of tabular output.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TabularRequest {
    /// Id of the REQUEST statement.
    pub id: i64,
    /// Comment or name of the request.
    pub name: String,
    /// Headings of the eight columns of the request.
    pub headings: [String; 8],
}

/// Layout of the tables, as set by OUTPUT/FIXED and OUTPUT/TELETYPE.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Tabular {
    /// True if numbers are written in fixed point wherever they fit into their columns.
    pub fixed: bool,
    /// True if lines have at most 72 columns. TIME and four values are then on one line, and the other four values on the next line.
    pub narrow: bool,
}

/// Maximum number of output times on a page.
const PAGE: usize = 50;

/// Writes a tabular output file `.out`: for each request, pages with its eight columns over time.
///
/// The layout is specific to `admire`, because no such file of ADAMS is known (guide/formats.md 6.4). A form feed begins every page except
/// the first. A page contains the title, the request, a line of headings, and at most 50 output times. Each output time is a line with
/// `TIME` and eight columns in the format 1PE13.5 (or F13.5).
///
/// # Errors
/// Returns `InvalidInput` if a row does not have one entry for each request. Returns another error if the output cannot be written.
pub fn write_tabular(
    mut output: impl Write,
    title: &str,
    when: Timestamp,
    spelling: Tabular,
    requests: &[TabularRequest],
    rows: &[(f64, Vec<[f64; 8]>)],
) -> io::Result<()> {
    if rows.iter().any(|(_, row)| row.len() != requests.len()) {
        let message = "a row does not have one entry for each request";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut page = 0;
    let mut text = Vec::new();
    for (at, request) in requests.iter().enumerate() {
        for lines in rows.chunks(PAGE) {
            page += 1;
            if page > 1 {
                text.push(b'\x0c');
            }
            let title: String = title.chars().filter(|c| !c.is_control()).take(80).collect();
            writeln!(text, "1{title:<86}{:<20}PAGE{page:>6}", when.date_time())?;
            write!(
                text,
                "0REQUEST/{:<8} {}\n\n",
                request.id,
                request.name.trim()
            )?;
            let wide = if spelling.narrow { 4 } else { 8 };
            for (first, headings) in request.headings.chunks(wide).enumerate() {
                write!(text, " {:>13}", if first == 0 { "TIME" } else { "" })?;
                for heading in headings {
                    let heading: String = heading.chars().take(12).collect();
                    write!(text, "{heading:>13}")?;
                }
                text.push(b'\n');
            }
            for (time, row) in lines {
                for (first, values) in row[at].chunks(wide).enumerate() {
                    let begin = if first == 0 {
                        spelling.number(*time)
                    } else {
                        " ".repeat(13)
                    };
                    write!(text, " {begin}")?;
                    for &value in values {
                        text.extend_from_slice(spelling.number(value).as_bytes());
                    }
                    text.push(b'\n');
                }
            }
        }
    }
    output.write_all(&text)?;
    output.flush()
}

impl Tabular {
    /// Formats a number in a field of 13 columns.
    fn number(self, value: f64) -> String {
        let fixed = format!("{value:>13.5}");
        // A number is written with an exponent if in fixed point it would touch its neighbour or lose digits.
        if self.fixed
            && fixed.starts_with(' ')
            && fixed.len() == 13
            && (value == 0.0 || value.abs() >= 1e-4)
        {
            return fixed;
        }
        exponential(value, 13, 5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_hold_fifty_lines() {
        let request = TabularRequest {
            id: 4,
            name: "wheel force".to_string(),
            headings: ["MAG", "FX", "FY", "FZ", "TMAG", "TX", "TY", "TZ"].map(str::to_string),
        };
        let rows: Vec<_> = (0..51).map(|n| (f64::from(n), vec![[0.25; 8]])).collect();
        let mut out = Vec::new();
        let when = Timestamp::from_unix(0);
        let usual = Tabular::default();
        write_tabular(&mut out, "a model", when, usual, &[request], &rows).unwrap();
        let text = String::from_utf8(out).unwrap();
        let pages: Vec<&str> = text.split('\u{c}').collect();
        assert_eq!(pages.len(), 2);
        insta::assert_snapshot!(pages[1]);
    }
}
