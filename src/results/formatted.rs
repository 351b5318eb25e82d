use std::collections::BTreeMap;

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Displacements of the parts, read from a formatted (ASCII) results file.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct FormattedResults {
    /// The 12-letter code for the units of the model, such as `MMKGS_N_RACA`.
    pub unit_code: String,
    /// Title of the dataset.
    pub title: String,
    /// Parts in the order of the file.
    pub parts: Vec<FormattedPart>,
    /// Output steps, in the order of the file.
    pub steps: Vec<FormattedStep>,
}

/// A part listed in a formatted results file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FormattedPart {
    /// Id of the PART statement.
    pub id: i64,
    /// Full name of the part; `None` if the file contains no names.
    pub name: Option<String>,
}

/// One output step of a formatted results file.
#[derive(Clone, PartialEq, Debug)]
pub struct FormattedStep {
    /// Kind of analysis, as spelled in the file, in which the step was computed.
    pub kind: String,
    /// Time of the output step.
    pub time: f64,
    /// X, Y, Z and PSI, THETA, PHI (radians) of each part. The angles are converted from the Euler parameters in the file.
    pub displacements: Vec<[f64; 6]>,
}

/// A block of the file: a label and the lines that follow it, up to a line that contains only `!`.
struct Block<'a> {
    label: String,
    span: Span,
    lines: Vec<(Span, &'a [u8])>,
}

type LocatedFault = (Code, String, Span);

impl FormattedResults {
    /// Reads the displacements of the parts (guide/formats.md 6.2).
    ///
    /// The layout of the blocks for other objects is unknown. Each of these blocks is skipped with a warning that names it. If the file
    /// ends inside an output step, the steps before it are returned with a warning.
    pub fn parse(source: &Source) -> Checked<Self> {
        let mut results = Checked::clean(Self::default());
        let mut rest = lines(source.bytes());
        let mut displacements: Vec<usize> = Vec::new();
        loop {
            let outcome = match next_block(&mut rest) {
                Ok(None) => break,
                Ok(Some(block)) => results.value.take(&block, &mut displacements),
                Err(trouble) => Err(trouble),
            };
            let Err((code, message, span)) = outcome else {
                continue;
            };
            let unknown = code == Code::UnsupportedResults;
            let diagnostic = if unknown || code == Code::TruncatedResults {
                Diagnostic::warning(code, message)
            } else {
                Diagnostic::error(code, message)
            };
            results
                .diagnostics
                .push(diagnostic.label(source.name(), span, ""));
            if !unknown {
                break;
            }
        }
        results
    }

    fn take(
        &mut self,
        block: &Block<'_>,
        displacements: &mut Vec<usize>,
    ) -> Result<(), LocatedFault> {
        let line = |at: usize| block.lines.get(at).copied();
        match block.label.as_str() {
            "FILE TYPE AND SOURCE" => {
                let first = line(0).map_or("", |(_, line)| ascii(line));
                if !first.starts_with("ADAMS RESULTS FILE") {
                    let message = "this is not an ADAMS results file".to_string();
                    return Err((Code::MalformedResults, message, block.span));
                }
                self.unit_code = first.get(25..37).unwrap_or_default().trim().to_string();
            }
            "DATA SET TITLE" => {
                self.title = line(0)
                    .map_or("", |(_, line)| ascii(line))
                    .trim()
                    .to_string();
            }
            "RESULTS TITLE" | "NUMBER OF ANALYSIS BLOCKS" | "MODE SHAPES MAP" => {}
            "RIGID PARTS MAP" => self.parts_map(block, displacements)?,
            "NAME MAP" => self.name_map(block),
            "ANALYSIS OUTPUT BLOCK" => self.step(block, displacements)?,
            label => {
                let count = line(0).and_then(|(_, line)| {
                    let count = ascii(line).get(..8)?;
                    count.trim().parse::<i64>().ok()
                });
                if count != Some(0) {
                    let message = format!(
                        "the block `{}` of the formatted results file is unknown and was left out",
                        label.escape_debug()
                    );
                    return Err((Code::UnsupportedResults, message, block.span));
                }
            }
        }
        Ok(())
    }

    fn parts_map(
        &mut self,
        block: &Block<'_>,
        displacements: &mut Vec<usize>,
    ) -> Result<(), LocatedFault> {
        let mut lines = block.lines.iter();
        let head = lines.next().map_or("", |(_, line)| ascii(line));
        if !head.get(8..).unwrap_or_default().starts_with("YES") {
            let message = "the file contains no displacements of parts; run again without NODISPLACEMENTS in RESULTS";
            return Err((Code::UnsupportedResults, message.to_string(), block.span));
        }
        for &(span, line) in lines {
            let numbers: Option<Vec<i64>> = words(line).map(|word| word.parse().ok()).collect();
            let (Some(numbers), true) = (numbers, displacements.len() < block.lines.len()) else {
                return Err((
                    Code::BadNumber,
                    "this line does not contain the numbers of a part".to_string(),
                    span,
                ));
            };
            let (Some(&id), Some(&record)) = (numbers.first(), numbers.get(1)) else {
                return Err((
                    Code::WrongCount,
                    "this line lacks the id or the record number of the part".to_string(),
                    span,
                ));
            };
            let Some(at) = usize::try_from(record).ok().filter(|&record| record >= 5) else {
                return Err((
                    Code::OutOfRange,
                    "the record number of a part must be at least 5".to_string(),
                    span,
                ));
            };
            self.parts.push(FormattedPart { id, name: None });
            displacements.push(at - 1);
        }
        Ok(())
    }

    fn name_map(&mut self, block: &Block<'_>) {
        let mut names = BTreeMap::new();
        let mut lines = block.lines.iter().skip(1);
        while let (Some((_, head)), Some((_, name))) = (lines.next(), lines.next()) {
            let head = ascii(head);
            let id = head.get(..20).and_then(|id| id.trim().parse::<i64>().ok());
            if let (Some(id), true) = (id, head.contains("RIGID PART")) {
                names.insert(id, ascii(name).trim().to_string());
            }
        }
        for part in &mut self.parts {
            part.name = names.get(&part.id).cloned();
        }
    }

    fn step(&mut self, block: &Block<'_>, displacements: &[usize]) -> Result<(), LocatedFault> {
        let record = |at: usize| {
            let missing = || {
                let message = format!("the step has no record {}", at + 1);
                (Code::WrongCount, message, block.span)
            };
            block.lines.get(at).copied().ok_or_else(missing)
        };
        let (_, head) = record(0)?;
        let (_, time) = record(1)?;
        let number = |span: Span, word: Option<&str>| {
            word.and_then(|word| word.parse::<f64>().ok())
                .ok_or_else(|| (Code::BadNumber, "this is not a number".to_string(), span))
        };
        let mut step = FormattedStep {
            kind: ascii(head)
                .get(8..28)
                .unwrap_or_default()
                .trim()
                .to_string(),
            time: number(block.span, words(time).next())?,
            displacements: Vec::with_capacity(displacements.len()),
        };
        for &at in displacements {
            let (span, line) = record(at)?;
            let mut fields = words(line);
            let mut q = [0.0; 7];
            for value in &mut q {
                *value = number(span, fields.next())?;
            }
            let Some([psi, theta, phi]) = psi_theta_phi([q[3], q[4], q[5], q[6]]) else {
                let message = "the Euler parameters of the part are all zero".to_string();
                return Err((Code::OutOfRange, message, span));
            };
            step.displacements.push([q[0], q[1], q[2], psi, theta, phi]);
        }
        self.steps.push(step);
        Ok(())
    }
}

/// Converts Euler parameters, normalised or not, to PSI, THETA, PHI (guide/formats.md 4.1). Returns `None` if their norm is at most 1e-6.
///
/// THETA is in [0, pi]; PSI and PHI are in (-pi, pi]. At THETA = 0 or pi, PSI is the whole rotation about z and PHI is 0.
fn psi_theta_phi(e: [f64; 4]) -> Option<[f64; 3]> {
    let length = e.iter().map(|e| e * e).sum::<f64>().sqrt();
    if !(length > 1e-6) {
        return None;
    }
    let [w, i, j, k] = e.map(|e| e / length);
    let (R00, R10) = (w * w + i * i - j * j - k * k, 2.0 * (w * k + i * j));
    let (R01, R11) = (2.0 * (i * j - w * k), w * w - i * i + j * j - k * k);
    let (R02, R12) = (2.0 * (w * j + i * k), 2.0 * (j * k - w * i));
    let R22 = w * w - i * i - j * j + k * k;
    let s = libm::hypot(R02, R12);
    if s < 1e-12 {
        let theta = if R22 > 0.0 { 0.0 } else { std::f64::consts::PI };
        return Some([libm::atan2(R10, R00), theta, 0.0]);
    }
    let (sin, cos) = (R02 / s, -R12 / s);
    let phi = libm::atan2(0.0 - (cos * R01 + sin * R11), cos * R00 + sin * R10);
    Some([libm::atan2(sin, cos), libm::atan2(s, R22), phi])
}

fn lines(bytes: &[u8]) -> impl Iterator<Item = (Span, &[u8])> {
    let mut at = 0;
    bytes
        .split_inclusive(|&byte| byte == b'\n')
        .map(move |line| {
            let span = Span::new(at, at + line.len());
            at += line.len();
            (span, line.trim_ascii_end())
        })
}

/// Reads the next block and checks that it has as many lines as its label announces.
///
/// Memory grows only with the lines actually read, so a wrong large number in a label does no harm.
fn next_block<'a>(
    rest: &mut impl Iterator<Item = (Span, &'a [u8])>,
) -> Result<Option<Block<'a>>, LocatedFault> {
    let Some((span, label)) = rest.by_ref().find(|(_, line)| !line.is_empty()) else {
        return Ok(None);
    };
    let text = ascii(label);
    let count = text
        .get(40..)
        .and_then(|count| count.trim().parse::<usize>().ok());
    let Some(count) = count else {
        let message = "this line is not a block label with a number of lines".to_string();
        return Err((Code::MalformedResults, message, span));
    };
    let mut block = Block {
        label: text[..40].trim_end().to_string(),
        span,
        lines: Vec::new(),
    };
    for at in 1..=count {
        let Some((line_span, line)) = rest.next() else {
            let message = "the file ends inside a block; the complete steps before it were read";
            return Err((Code::TruncatedResults, message.to_string(), span));
        };
        if (line == b"!") != (at == count) {
            let message = format!(
                "the block `{}` does not have the number of lines that its label states",
                block.label.escape_debug()
            );
            return Err((Code::MalformedResults, message, line_span));
        }
        block.lines.push((line_span, line));
    }
    block.lines.pop();
    Ok(Some(block))
}

/// Returns the text of a line, or an empty text if the line contains other than ASCII characters. ASCII text can be split at any column.
fn ascii(line: &[u8]) -> &str {
    std::str::from_utf8(line)
        .ok()
        .filter(|line| line.is_ascii())
        .unwrap_or_default()
}

fn words(line: &[u8]) -> impl Iterator<Item = &str> {
    ascii(line).split_whitespace()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(label: &str, lines: &[&str]) -> String {
        format!(
            "{label:<40}{:>8}\n{}\n!\n",
            lines.len() + 1,
            lines.join("\n")
        )
    }

    fn file() -> String {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let quarter_turn_about_z = format!(" 1.0 2.0 3.0 {half} 0.0 0.0 {half}");
        [
            block(
                "FILE TYPE AND SOURCE",
                &["ADAMS RESULTS FILE       MMKGS_N_RACA 0.100000000000000E+01"],
            ),
            block("DATA SET TITLE", &["a model", ""]),
            block("NUMBER OF ANALYSIS BLOCKS", &["       1       6"]),
            block(
                "RIGID PARTS MAP",
                &[
                    "       1YESNO NO ",
                    "                   2       5       0       0",
                ],
            ),
            block("JOINTS MAP", &["       0YES"]),
            block("BUSHINGS MAP", &["       1YES", "  1  6"]),
            block(
                "NAME MAP",
                &[
                    "       1YES",
                    "                   2RIGID PART                 1",
                    ".m.arm",
                ],
            ),
            block(
                "ANALYSIS OUTPUT BLOCK",
                &[
                    "       1STATIC              1",
                    " 0.00000E+00",
                    "",
                    "",
                    &quarter_turn_about_z,
                ],
            ),
        ]
        .concat()
    }

    #[test]
    fn displacements_of_parts_are_read_and_the_rest_is_named() {
        let text = file();
        let read = FormattedResults::parse(&Source::new("a.res", text.as_bytes()));
        assert_eq!(read.value.parts[0].name.as_deref(), Some(".m.arm"));
        let step = &read.value.steps[0];
        assert_eq!((step.kind.as_str(), step.time), ("STATIC", 0.0));
        // At THETA = 0, a rotation by a quarter turn about z means PSI + PHI = 90 degrees.
        let [x, y, z, psi, theta, phi] = step.displacements[0];
        assert_eq!([x, y, z], [1.0, 2.0, 3.0]);
        assert!(theta.abs() < 1e-12);
        assert!((psi + phi - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let said: Vec<_> = read
            .diagnostics
            .iter()
            .map(|d| d.message.as_str())
            .collect();
        assert_eq!(
            said,
            ["the block `BUSHINGS MAP` of the formatted results file is unknown and was left out"]
        );
    }

    #[test]
    fn broken_files_give_a_complaint() {
        let text = file();
        for cut in 0..text.len() - 2 {
            let read = FormattedResults::parse(&Source::new("a.res", &text.as_bytes()[..cut]));
            assert!(read.value.steps.is_empty());
        }
        let huge = format!("{:<40}{:>8}\n!\n", "NAME MAP", 99_999_999);
        let read = FormattedResults::parse(&Source::new("a.res", huge.as_bytes()));
        assert!(!read.diagnostics.is_empty());
        let binary: Vec<u8> = (0..=255).cycle().take(4000).collect();
        assert!(
            !FormattedResults::parse(&Source::new("a.res", binary))
                .diagnostics
                .is_empty()
        );
    }
}
