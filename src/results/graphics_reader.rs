use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};

use super::StepKind;
use super::graphics_file::{INPUT, STATIC};

/// Content of a graphics file `.gra` (format A.G8): poses of the parts and the forces, frame by frame. Shapes that are fixed to parts are
/// not in the file but in the dataset.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct GraphicsFile {
    /// Date and time of the run.
    pub date: String,
    /// Title of the model.
    pub title: String,
    /// Ids of the moving parts, in the order in which frames list their poses.
    pub parts: Vec<i64>,
    /// Ids of the GRAPHICS statements that draw the forces, in the order of the frames. If the head does not list them, the ids are 1, 2,
    /// ...
    pub forces: Vec<i64>,
    /// Time of each frame. The file gives no time for a static solution; such a frame gets the time of the frame before it.
    pub times: Vec<f64>,
    /// Kind of each frame: `Static` or `Unlisted`. The file does not distinguish other kinds.
    pub kinds: Vec<StepKind>,
    /// X, Y, Z, PSI, THETA, PHI (radians) of each part in each frame; the outer index is the frame.
    pub poses: Vec<Vec<[f64; 6]>>,
    /// FX, FY, FZ, TX, TY, TZ of each force in each frame, in ground axes; the outer index is the frame.
    pub loads: Vec<Vec<[f64; 6]>>,
}

impl GraphicsFile {
    /// Reads a graphics file. An incomplete last frame is dropped with a warning.
    ///
    /// A frame has one line for each part and one for each force. The number of lines is counted in the first frame, between its label and
    /// the next label, so that the reader does not depend on the counts in the head.
    pub fn parse(source: &Source) -> Checked<Self> {
        let text = source.text(Span::new(0, source.bytes().len()));
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        let mut file = Self {
            date: first
                .split_whitespace()
                .skip(1)
                .take(2)
                .collect::<Vec<_>>()
                .join(" "),
            title: lines.next().unwrap_or_default().trim().to_string(),
            ..Self::default()
        };
        let count = lines
            .next()
            .and_then(|line| line.split_whitespace().next()?.parse::<usize>().ok())
            .unwrap_or(0);
        for line in lines.by_ref().take(count) {
            file.parts.extend(
                line.split_whitespace()
                    .next()
                    .and_then(|id| id.parse::<i64>().ok()),
            );
        }
        // The first part is the ground, which does not move.
        if !file.parts.is_empty() {
            file.parts.remove(0);
        }
        let cut = file.frames(&mut lines);
        let complain = |message| {
            let warning = Diagnostic::warning(Code::TruncatedResults, message);
            let end = Span::at(source.bytes().len());
            warning.label(source.name(), end, "it ends here")
        };
        Checked {
            value: file,
            diagnostics: cut.err().map(complain).into_iter().collect(),
        }
    }

    /// Reads the frames, after the list of parts was read.
    ///
    /// # Errors
    /// Returns the reason as text if the file is cut off or contains a line that is not part of a frame.
    fn frames(&mut self, lines: &mut std::str::Lines<'_>) -> Result<(), String> {
        const NONE: &str = "the file ends before its first frame";
        let mut forces = Vec::new();
        let mut before: Vec<i64> = Vec::new();
        loop {
            let line = lines.next().ok_or(NONE)?;
            if line.trim().parse() == Ok(INPUT) {
                break;
            }
            let whole: Option<Vec<i64>> = line.split_whitespace().map(|n| n.parse().ok()).collect();
            let whole = whole.unwrap_or_default();
            // A force has two lines in the head: its id, the code 5 and the count 2, and then two integers.
            if let ([id, 5, 2], 2) = (before.as_slice(), whole.len()) {
                forces.push(*id);
            }
            before = whole;
        }
        let mut size = 0_usize;
        let mut label = loop {
            match lines.next().map(values) {
                Some(Some(numbers)) if numbers.len() == 6 => size += 1,
                Some(Some(numbers)) if numbers.len() == 1 => break Some(numbers[0]),
                None => break None,
                Some(_) => return Err(NONE.to_string()),
            }
        };
        let Some(loads) = size.checked_sub(self.parts.len()) else {
            return Err(NONE.to_string());
        };
        self.forces = if forces.len() == loads {
            forces
        } else {
            (1..=loads as i64).collect()
        };
        while let Some(time) = label {
            let mut frame = Vec::with_capacity(size);
            for _ in 0..size {
                let six = lines.next().and_then(values);
                let six: Option<[f64; 6]> = six.and_then(|numbers| numbers.try_into().ok());
                frame.push(six.ok_or("the last frame is cut off; the frames before it are read")?);
            }
            let (kind, time) = if time == STATIC {
                (StepKind::Static, self.times.last().copied().unwrap_or(0.0))
            } else {
                (StepKind::Unlisted, time)
            };
            self.kinds.push(kind);
            self.times.push(time);
            self.loads.push(frame.split_off(self.parts.len()));
            self.poses.push(frame);
            label = match lines.next() {
                None => None,
                Some(line) => Some(line.trim().parse().map_err(|_| {
                    format!(
                        "the line after frame {} is not a time; the frames before it are read",
                        self.times.len()
                    )
                })?),
            };
        }
        Ok(())
    }
}

/// Returns all numbers in a line, or `None` if the line contains anything else.
fn values(line: &str) -> Option<Vec<f64>> {
    numbers(line).collect()
}

/// Iterates over the numbers in a line with fields of 13 columns. A minus sign may directly follow the preceding number.
fn numbers(line: &str) -> impl Iterator<Item = Option<f64>> + '_ {
    let mut rest = line.trim_end();
    std::iter::from_fn(move || {
        rest = rest.trim_start();
        if rest.is_empty() {
            return None;
        }
        let end = rest
            .char_indices()
            .skip(1)
            .find(|(at, c)| c.is_whitespace() || *c == '-' && !rest[..*at].ends_with(['E', 'e']))
            .map_or(rest.len(), |(at, _)| at);
        let (word, behind) = rest.split_at(end);
        rest = behind;
        Some(word.parse().ok())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GraphicsHead, GraphicsShape, GraphicsWriter, Timestamp};

    #[test]
    fn what_is_written_is_read_and_a_cut_frame_is_told() {
        let head = GraphicsHead {
            title: "a title".to_string(),
            ground: 1,
            parts: vec![2, 3],
            shapes: vec![GraphicsShape::Force { id: 70, marker: 4 }],
            input: vec![[0.0; 6]; 2],
            ..GraphicsHead::default()
        };
        let mut writer = GraphicsWriter::create(Vec::new(), Timestamp::now(), &head).unwrap();
        let poses = [
            [1.0, -2.0, 3.0, -0.5, 0.25, 0.0],
            [-1e-10, 0.0, 0.0, 0.0, 1.5, 0.0],
        ];
        let loads = [[0.0, -6.0, 0.0, 0.0, 0.0, 2.5]];
        let mut frame = |kind, time| writer.frame(kind, time, &poses, &loads).unwrap();
        frame(StepKind::Dynamic, 0.0);
        frame(StepKind::Dynamic, 0.5);
        frame(StepKind::Static, 0.5);
        let bytes = writer.finish();
        let read = GraphicsFile::parse(&Source::new("a.gra", bytes.clone()));
        assert!(read.diagnostics.is_empty());
        let file = &read.value;
        assert_eq!(
            (file.title.as_str(), &*file.parts),
            ("a title", &[2, 3][..])
        );
        assert_eq!(file.forces, [70]);
        assert_eq!(file.times, [0.0, 0.5, 0.5]);
        assert_eq!(file.kinds[1..], [StepKind::Unlisted, StepKind::Static]);
        assert_eq!(file.poses[1], poses);
        assert_eq!(file.loads[2], loads);
        let cut = GraphicsFile::parse(&Source::new("a.gra", &bytes[..bytes.len() - 40]));
        assert_eq!((cut.value.times.len(), cut.diagnostics.len()), (2, 1));
        // While the first frame is incomplete, the number of lines in a frame is unknown.
        let text = String::from_utf8(bytes).unwrap();
        let short = text.find("-9.99999E+05").unwrap() + 100;
        let none = GraphicsFile::parse(&Source::new("a.gra", &text.as_bytes()[..short]));
        assert_eq!((none.value.times.len(), none.diagnostics.len()), (0, 1));
    }
}
