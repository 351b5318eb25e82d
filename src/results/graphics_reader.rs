use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::text::{Source, Span};

/// What a `.gra` file (format A.G8) holds: where the parts are, frame by frame. The shapes that hang on them are in the dataset.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct GraphicsFile {
    /// When the run was made.
    pub date: String,
    /// Title of the model.
    pub title: String,
    /// Ids of the parts that move, in the order of the frames.
    pub parts: Vec<i64>,
    /// The time of each frame.
    pub times: Vec<f64>,
    /// For each frame X, Y, Z, PSI, THETA, PHI (radians) of each part.
    pub poses: Vec<Vec<[f64; 6]>>,
}

/// The number that ends the list of markers.
const SENTINEL: f64 = -9.999_99e5;

impl GraphicsFile {
    /// Reads a file. A frame that is cut off is left out with a warning.
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
        let mut diagnostics = Vec::new();
        let mut complain = |message: &str| {
            diagnostics.push(Diagnostic::warning(Code::TruncatedResults, message).label(
                source.name(),
                Span::at(source.bytes().len()),
                "it ends here",
            ));
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
        // The first part is the ground: its pose stands once, behind the markers.
        if !file.parts.is_empty() {
            file.parts.remove(0);
        }
        let found = lines
            .by_ref()
            .any(|line| line.trim().parse() == Ok(SENTINEL));
        if !found || lines.next().is_none() {
            complain("the file ends before its first frame");
            return Checked {
                value: file,
                diagnostics,
            };
        }
        'frames: while let Some(line) = lines.next() {
            let Ok(time) = line.trim().parse::<f64>() else {
                complain("a line is not the time of a frame; the frames before it are read");
                break;
            };
            let mut poses = Vec::with_capacity(file.parts.len());
            for _ in &file.parts {
                let pose: Option<[f64; 6]> = lines.next().and_then(|line| {
                    let values: Option<Vec<f64>> = numbers(line).collect();
                    values?.try_into().ok()
                });
                let Some(pose) = pose else {
                    complain("the last frame is cut off; the frames before it are read");
                    break 'frames;
                };
                poses.push(pose);
            }
            file.times.push(time);
            file.poses.push(poses);
        }
        Checked {
            value: file,
            diagnostics,
        }
    }
}

/// Numbers of a line of 13 columns each: a minus sign may touch the number before it.
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
    use crate::results::{GraphicsWriter, Timestamp};
    use crate::units::Units;

    #[test]
    fn what_is_written_is_read_and_a_cut_frame_is_told() {
        let mut writer = GraphicsWriter::create(
            Vec::new(),
            "a title",
            &Units::default(),
            Timestamp::now(),
            1,
            &[2, 3],
            &[],
        )
        .unwrap();
        let poses = [
            [1.0, -2.0, 3.0, -0.5, 0.25, 0.0],
            [-1e-10, 0.0, 0.0, 0.0, 1.5, 0.0],
        ];
        writer.frame(0.0, &poses).unwrap();
        writer.frame(0.5, &poses).unwrap();
        let bytes = writer.finish();
        let read = GraphicsFile::parse(&Source::new("a.gra", bytes.clone()));
        assert!(read.diagnostics.is_empty());
        assert_eq!(
            (read.value.title.as_str(), read.value.parts.as_slice()),
            ("a title", &[2, 3][..])
        );
        assert_eq!(read.value.times, [0.0, 0.5]);
        assert_eq!(read.value.poses[1], poses);
        let cut = GraphicsFile::parse(&Source::new("a.gra", &bytes[..bytes.len() - 40]));
        assert_eq!((cut.value.times.len(), cut.diagnostics.len()), (1, 1));
    }
}
