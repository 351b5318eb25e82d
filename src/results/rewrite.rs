use std::io::{self, Read, Write};

use admire_syntax::diagnostic::Diagnostic;

use super::step::tokens;
use super::{Groups, NumberStyle, ResultsError, Step, XrfReader, write_number};

/// A new value for one column in one output step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Change {
    /// Position of the output step in the file, from 0.
    pub step: usize,
    /// Id of the column, from 1.
    pub id: usize,
    /// New value; must be finite.
    pub value: f64,
}

/// Report of a rewrite.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Rewritten {
    /// Number of output steps whose text was reproduced exactly by printing their numbers again.
    pub reprinted: usize,
    /// Number of output steps that are spelled in another way; their original text was kept.
    pub kept: usize,
    /// Number of changes that were applied.
    pub changed: usize,
    /// Diagnostics of the reader of the input.
    pub diagnostics: Vec<Diagnostic>,
}

/// Copies an XRF file; every output step is printed again from its numbers, and `changes` are applied.
///
/// `verbatim` is a second reader of the same bytes; everything except the numbers is copied from it. Without changes, the output equals the
/// input byte for byte. A change replaces only the text of its number, so a line may become longer than usual. Memory is needed for only
/// one output step.
///
/// # Errors
/// Returns an error if the input cannot be read or is malformed, or if the output cannot be written; the output is then incomplete. Returns
/// an error for a change whose step or column does not exist, or whose value is not finite.
pub fn rewrite<R: Read, V: Read, W: Write>(
    file: &str,
    input: R,
    mut verbatim: V,
    mut output: W,
    changes: &[Change],
) -> Result<Rewritten, ResultsError> {
    let mut changes = changes.to_vec();
    changes.sort_by_key(|change| (change.step, change.id));
    let mut reader = XrfReader::open(file, input)?;
    let groups = Groups::new(reader.catalogue());
    let line_end = reader.line_end().bytes();
    let mut styles = vec![NumberStyle::default(), NumberStyle::SeventeenDigits];
    let mut report = Rewritten::default();
    let (mut copied, mut values, mut text) = (0_u64, Vec::new(), Vec::new());
    while let Some(step) = reader.next_step()? {
        copy(&mut verbatim, &mut output, step.offset() - copied)?;
        step.values(&mut values)?;
        let style = reprint(&step, &groups, &values, &mut styles, line_end, &mut text);
        if style.is_some() {
            report.reprinted += 1;
        } else {
            report.kept += 1;
            text.clear();
            text.extend_from_slice(step.text());
        }
        let here = changes.partition_point(|change| change.step == step.index);
        for change in changes.drain(..here).rev() {
            splice(&step, &mut text, change, style.unwrap_or(styles[0]))?;
            report.changed += 1;
        }
        output.write_all(&text)?;
        skip(&mut verbatim, step.text().len() as u64)?;
        copied = step.offset() + step.text().len() as u64;
    }
    if let Some(change) = changes.first() {
        let message = format!("there is no step {}", change.step + 1);
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message).into());
    }
    io::copy(&mut verbatim, &mut output)?;
    output.flush()?;
    report.diagnostics = reader.diagnostics().to_vec();
    Ok(report)
}

/// Prints an output step in the number style that reproduces its text exactly, and moves this style to the front of `styles`.
///
/// Returns `None` if no style reproduces the text.
fn reprint(
    step: &Step<'_>,
    groups: &Groups,
    values: &[f64],
    styles: &mut Vec<NumberStyle>,
    line_end: &[u8],
    text: &mut Vec<u8>,
) -> Option<NumberStyle> {
    // The styles have no spelling for the infinities and NaN values of a diverged run.
    if values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    for at in 0..=styles.len() {
        let style = match styles.get(at) {
            Some(&style) => style,
            None => NumberStyle::Decimals(most_decimals(step.text())),
        };
        text.clear();
        text.extend_from_slice(line_end);
        groups.write(text, step.kind, values, style, line_end);
        if text == step.text() {
            styles.retain(|&other| other != style);
            styles.insert(0, style);
            return Some(style);
        }
    }
    None
}

/// Returns the largest number of decimals of any number in the text, but at most 30. This is RESULTS/DECIMALPLACES, unless trailing zeros
/// were trimmed from every number.
fn most_decimals(text: &[u8]) -> u8 {
    tokens(text)
        .map(|token| {
            let digits = text[token].iter().skip_while(|&&byte| byte != b'.').skip(1);
            digits.take_while(|byte| byte.is_ascii_digit()).count()
        })
        .max()
        .unwrap_or(0)
        .min(30) as u8
}

fn splice(
    step: &Step<'_>,
    text: &mut Vec<u8>,
    change: Change,
    style: NumberStyle,
) -> Result<(), ResultsError> {
    let place = change.id.checked_sub(1).and_then(|at| tokens(text).nth(at));
    let place = place.filter(|_| change.value.is_finite()).ok_or_else(|| {
        let message = format!(
            "column {} of step {} cannot be {}",
            change.id,
            step.index + 1,
            change.value
        );
        io::Error::new(io::ErrorKind::InvalidInput, message)
    })?;
    let old = super::step::parse_number(&text[place.clone()]);
    if old == Some(change.value) {
        return Ok(());
    }
    let mut number = Vec::new();
    write_number(&mut number, change.value, style);
    text.splice(place, number);
    Ok(())
}

fn copy(from: &mut impl Read, to: &mut impl Write, count: u64) -> io::Result<()> {
    let copied = io::copy(&mut from.by_ref().take(count), to)?;
    complete(copied, count)
}

fn skip(from: &mut impl Read, count: u64) -> io::Result<()> {
    let skipped = io::copy(&mut from.by_ref().take(count), &mut io::sink())?;
    complete(skipped, count)
}

fn complete(done: u64, wanted: u64) -> io::Result<()> {
    if done == wanted {
        return Ok(());
    }
    let message = "the file became shorter while it was read";
    Err(io::Error::new(io::ErrorKind::UnexpectedEof, message))
}
