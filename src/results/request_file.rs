use std::io::{self, Write};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use admire_syntax::units::Units;

use super::Timestamp;
use super::fortran::{exponential, line_of, title_line, unit_code};

/// A request listed in the head of a request file `.req`.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct RequestEntry {
    /// Id of the REQUEST statement.
    pub id: i64,
    /// Comment or name of the request. A writer cuts it to 80 characters.
    pub name: String,
    /// Integers that follow the id in the file: codes of the measured quantity and ids of its markers.
    pub numbers: Vec<i64>,
}

/// Writer of a request file `.req` (guide/formats.md 6.3). The values of each output time are flushed as soon as they are written.
///
/// The three lines of the head and the values have the layout of real files. How real files list the requests in the head is unknown. This
/// writer writes the name of each request on one line, and its id and other integers on another line, as existing readers expect. A name
/// that consists of integers gets the prefix `REQUEST`.
#[derive(Debug)]
pub struct RequestWriter<W: Write> {
    output: W,
    requests: usize,
}

impl<W: Write> RequestWriter<W> {
    /// Writes the head of the file.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    pub fn create(
        mut output: W,
        title: &str,
        units: &Units,
        when: Timestamp,
        requests: &[RequestEntry],
    ) -> io::Result<Self> {
        let mut text = Vec::new();
        writeln!(
            text,
            " A.R3    {:<19}{:>16}{:>10}  3D",
            when.date_time(),
            0,
            0
        )?;
        text.extend_from_slice(title_line(title).as_bytes());
        writeln!(
            text,
            "{:>5}     {} {}",
            requests.len(),
            unit_code(units),
            exponential(1.0 / units.length.si, 21, 15)
        )?;
        for request in requests {
            // The name is checked in the form in which it will be written: shortened, and with blanks in place of control characters.
            let mut name = title_line(request.name.trim());
            if whole_numbers(name.as_bytes()).is_some() {
                name = title_line(&format!("REQUEST {}", name.trim()));
            }
            text.extend_from_slice(name.as_bytes());
            write!(text, "{:>10}", request.id)?;
            for number in &request.numbers {
                // Each integer fills at least ten columns and begins with a blank, so that long integers stay separate.
                write!(text, " {number:>9}")?;
            }
            text.push(b'\n');
        }
        output.write_all(&text)?;
        output.flush()?;
        Ok(Self {
            output,
            requests: requests.len(),
        })
    }

    /// Writes the values at one output time: columns 2, 3, 4, 6, 7 and 8 of each request, in the order of the head.
    ///
    /// # Errors
    /// Returns `InvalidInput` if `values` does not have one entry for each request. Returns another error if the output cannot be written.
    pub fn step(&mut self, time: f64, values: &[[f64; 6]]) -> io::Result<()> {
        if values.len() != self.requests {
            let message = format!(
                "the output time has values for {} requests, but the file has {}",
                values.len(),
                self.requests
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let mut text = line_of(&[time]).into_bytes();
        for six in values {
            text.extend_from_slice(line_of(six).as_bytes());
        }
        self.output.write_all(&text)?;
        self.output.flush()
    }

    /// Returns the output, which is complete after each output time.
    pub fn finish(self) -> W {
        self.output
    }
}

/// Content of a request file `.req`.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RequestFile {
    /// Date and time of the run.
    pub date: String,
    /// Title of the model.
    pub title: String,
    /// The 12-letter code for the units of the model.
    pub unit_code: String,
    /// Requests, in the order in which their values are listed.
    pub requests: Vec<RequestEntry>,
    /// Output times, in the order of the file.
    pub times: Vec<f64>,
    /// Columns 2, 3, 4, 6, 7 and 8 of each request at each output time; the outer index is the output time.
    pub values: Vec<Vec<[f64; 6]>>,
}

impl RequestFile {
    /// Reads a request file `.req`.
    ///
    /// In the head, the name of a request may come before or after its line of integers. The values at an output time may be split into
    /// lines in any way. If the file ends inside an output time, all output times before it are returned with a warning.
    pub fn parse(source: &Source) -> Checked<Self> {
        let mut file = Checked::clean(Self::default());
        let mut lines = Lines::new(source.bytes());
        let trouble = file
            .value
            .head(&mut lines)
            .err()
            .or_else(|| file.value.data(&mut lines).unwrap_or_else(Some));
        if let Some(RequestFault {
            code,
            message,
            span,
        }) = trouble
        {
            let diagnostic = if code == Code::TruncatedResults {
                Diagnostic::warning(code, message)
            } else {
                Diagnostic::error(code, message)
            };
            file.diagnostics
                .push(diagnostic.label(source.name(), span, ""));
        }
        file
    }

    fn head(&mut self, lines: &mut Lines<'_>) -> Result<(), RequestFault> {
        let (span, first) = lines.needed()?;
        let first = first.trim_ascii_start();
        if !first.starts_with(b"A.R3") {
            return Err(RequestFault {
                code: Code::UnsupportedResults,
                message: "this is not a request file of format A.R3".to_string(),
                span,
            });
        }
        self.date = text(first.get(4..).unwrap_or_default().trim_ascii().get(..19));
        // If the model has no title, the title line is blank.
        let has_count = |line: &[u8]| {
            words(line)
                .next()
                .is_some_and(|w| w.parse::<usize>().is_ok())
        };
        if !(lines.is_at_blank() && lines.peek().is_some_and(has_count)) {
            self.title = text(Some(lines.needed()?.1));
        }
        let (span, third) = lines.needed()?;
        let mut words = third
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        let count = words
            .next()
            .and_then(|word| text(Some(word)).parse::<usize>().ok());
        let Some(count) = count else {
            return Err(malformed("the number of requests is missing", span));
        };
        self.unit_code = text(words.next());
        let mut name = Vec::new();
        while self.requests.len() < count {
            let (_, line) = lines.needed()?;
            match whole_numbers(line) {
                Some(numbers) => self.requests.push(RequestEntry {
                    id: numbers[0],
                    numbers: numbers[1..].to_vec(),
                    name: text(Some(&std::mem::take(&mut name))),
                }),
                None => name = line.to_vec(),
            }
        }
        // If each name follows its line of integers, the name of the last request has not been read yet.
        let behind = lines.peek().is_some_and(|line| numbers(line).is_none());
        if behind && count > 0 {
            let last = text(Some(lines.needed()?.1));
            for at in 1..count {
                self.requests[at - 1].name = std::mem::take(&mut self.requests[at].name);
            }
            self.requests[count - 1].name = last;
        }
        Ok(())
    }

    fn data(&mut self, lines: &mut Lines<'_>) -> Result<Option<RequestFault>, RequestFault> {
        let wanted = 1 + 6 * self.requests.len();
        let mut values: Vec<f64> = Vec::new();
        // Lengths of the lines at this output time, and of the lines at the previous output time.
        let (mut lengths, mut before) = (Vec::new(), Vec::new());
        while let Some((span, line)) = lines.next() {
            // If the last line has no line end, digits may be missing: `1.0`, cut off from `1.00000E-02`, is still a number. The length of
            // the line is therefore compared with the length of the same line at the previous output time.
            if lines.open && before.get(lengths.len()) != Some(&line.len()) {
                return Ok(Some(lines.cut_off(self.times.len())));
            }
            lengths.push(line.len());
            let found = numbers(line)
                .ok_or_else(|| malformed("this line must contain only numbers", span))?;
            values.extend(found);
            if values.len() > wanted {
                let message = "an output time has more values than the requests";
                return Err(malformed(message, span));
            }
            if values.len() == wanted {
                self.times.push(values[0]);
                let sixes = values[1..].chunks_exact(6);
                let sixes = sixes.map(|six| std::array::from_fn(|at| six[at]));
                self.values.push(sixes.collect());
                values.clear();
                before = std::mem::take(&mut lengths);
            }
        }
        if values.is_empty() {
            return Ok(None);
        }
        Ok(Some(lines.cut_off(self.times.len())))
    }
}

struct RequestFault {
    code: Code,
    message: String,
    span: Span,
}

fn malformed(message: &str, span: Span) -> RequestFault {
    RequestFault {
        code: Code::MalformedResults,
        message: message.to_string(),
        span,
    }
}

/// Iterator over the lines of a text and their spans; blank lines are skipped.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// True if the last line read had no line end.
    open: bool,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            open: false,
        }
    }

    fn peek(&self) -> Option<&'a [u8]> {
        let mut ahead = Lines {
            bytes: self.bytes,
            at: self.at,
            open: false,
        };
        ahead.next().map(|(_, line)| line)
    }

    /// Returns true if the next line is blank.
    fn is_at_blank(&self) -> bool {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let line = rest.split(|byte| *byte == b'\n').next();
        line.is_some_and(|line| line.trim_ascii().is_empty())
    }

    /// Returns the next line of the head. Returns an error if the file ends before the line end.
    fn needed(&mut self) -> Result<(Span, &'a [u8]), RequestFault> {
        match self.next() {
            Some(line) if !self.open => Ok(line),
            _ => Err(self.cut_off(0)),
        }
    }

    fn cut_off(&self, times: usize) -> RequestFault {
        RequestFault {
            code: Code::TruncatedResults,
            message: format!(
                "the file ends too early; the number of complete output times is {times}"
            ),
            span: Span::at(self.bytes.len()),
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (Span, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        while self.at < self.bytes.len() {
            let rest = &self.bytes[self.at..];
            let line_end = memchr::memchr(b'\n', rest);
            self.open = line_end.is_none();
            let end = line_end.unwrap_or(rest.len());
            let span = Span::new(self.at, self.at + end);
            self.at += end + 1;
            if !rest[..end].trim_ascii().is_empty() {
                return Some((span, &rest[..end]));
            }
        }
        None
    }
}

fn text(bytes: Option<&[u8]>) -> String {
    String::from_utf8_lossy(bytes.unwrap_or_default().trim_ascii()).into_owned()
}

fn words(line: &[u8]) -> impl Iterator<Item = &str> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .map(|word| std::str::from_utf8(word).unwrap_or("?"))
}

fn numbers(line: &[u8]) -> Option<Vec<f64>> {
    words(line).map(|word| word.parse().ok()).collect()
}

fn whole_numbers(line: &[u8]) -> Option<Vec<i64>> {
    let all: Option<Vec<i64>> = words(line).map(|word| word.parse().ok()).collect();
    all.filter(|all| !all.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requests() -> Vec<RequestEntry> {
        vec![
            RequestEntry {
                id: 7,
                name: "12".to_string(),
                numbers: vec![1, 4, 5, 0],
            },
            RequestEntry {
                id: 3,
                name: "wheel force".to_string(),
                numbers: vec![4, 6, 7, 0],
            },
        ]
    }

    #[test]
    fn what_is_written_is_read() {
        let when = Timestamp::from_unix(0);
        let units = Units::default();
        let mut writer =
            RequestWriter::create(Vec::new(), "a title", &units, when, &requests()).unwrap();
        writer.step(0.0, &[[1.0; 6], [-2.5; 6]]).unwrap();
        writer.step(1.0, &[[0.0; 6], [3e-7; 6]]).unwrap();
        assert!(writer.step(2.0, &[[0.0; 6]]).is_err());
        let bytes = writer.finish();
        insta::assert_snapshot!(String::from_utf8(bytes.clone()).unwrap());
        let read = RequestFile::parse(&Source::new("a.req", bytes.clone()));
        assert!(read.diagnostics.is_empty());
        assert_eq!(read.value.title, "a title");
        assert_eq!(read.value.requests[0].name, "REQUEST 12");
        assert_eq!(read.value.requests[1], requests()[1]);
        assert_eq!(read.value.times, [0.0, 1.0]);
        assert_eq!(read.value.values[1][1], [3e-7; 6]);
    }

    #[test]
    fn a_file_cut_anywhere_gives_whole_output_times_and_no_number_that_was_not_written() {
        let when = Timestamp::from_unix(0);
        let units = Units::default();
        for requests in [requests(), Vec::new()] {
            let mut writer =
                RequestWriter::create(Vec::new(), "a title", &units, when, &requests).unwrap();
            for step in 0..20 {
                let time = f64::from(step) * 0.01;
                writer.step(time, &vec![[time; 6]; requests.len()]).unwrap();
            }
            let bytes = writer.finish();
            let whole = RequestFile::parse(&Source::new("a.req", bytes.clone())).value;
            let mut steps = 0;
            for cut in 0..bytes.len() {
                let read = RequestFile::parse(&Source::new("a.req", &bytes[..cut]));
                let count = read.value.times.len();
                assert_eq!(read.value.times, whole.times[..count], "cut at {cut}");
                assert_eq!(read.value.values, whole.values[..count], "cut at {cut}");
                assert!(count >= steps, "cut at {cut}");
                // A file that is cut off inside a line must be reported as truncated.
                let line = bytes[..cut].rsplit(|byte| *byte == b'\n').next().unwrap();
                let inside = !line.trim_ascii().is_empty() && bytes[cut] != b'\n';
                let seen = read
                    .diagnostics
                    .iter()
                    .any(|d| d.code == Code::TruncatedResults);
                assert!(seen || !inside, "cut at {cut}");
                steps = count;
            }
        }
    }

    #[test]
    fn names_behind_their_numbers_are_read_too() {
        let text = " A.R3    2020-01-01 00:00:00               0         0  3D\nt\n 2 MMKGS_N_RACA 1.0E+03\n \
                    5 1 2 3 4\nfirst\n 6 1 2 3 4\nsecond\n 0.0\n 1 2 3 4 5 6\n 7 8 9 10 11 12\n";
        let read = RequestFile::parse(&Source::new("a.req", text.as_bytes()));
        assert!(read.diagnostics.is_empty());
        let names: Vec<_> = read
            .value
            .requests
            .iter()
            .map(|r| (r.id, r.name.as_str()))
            .collect();
        assert_eq!(names, [(5, "first"), (6, "second")]);
        assert_eq!(read.value.values[0][1][0], 7.0);
    }
}
