use std::io::{self, Write};

use crate::units::Units;

use super::Timestamp;
use super::fortran::{exponential, line_of, title_line, unit_code};

/// A marker in a graphics file.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct GraphicsMarker {
    /// Id of the marker.
    pub id: i64,
    /// Id of its part.
    pub part: i64,
    /// Position on the part.
    pub position: [f64; 3],
    /// PSI, THETA, PHI on the part, radians.
    pub angles: [f64; 3],
}

/// Writes a `.gra` file (format A.G8, ADAMS-FORMATS 6.4): frames of part positions, each flushed.
///
/// Laid out after the real file of ../shared/real-decks/aview-hpc: nine counts, of which the first two (parts with ground,
/// markers) are known and the others zero; the parts; the markers; a sentinel; the pose of ground; then for each frame the
/// time and the pose of every other part. The shapes that hang on the markers are in the dataset, not here.
#[derive(Debug)]
pub struct GraphicsWriter<W: Write> {
    output: W,
    parts: usize,
}

impl<W: Write> GraphicsWriter<W> {
    /// Writes the head. `parts` are the ids in the order of the frames, without ground, whose id is `ground`.
    ///
    /// # Errors
    /// When the output cannot be written.
    pub fn create(
        mut output: W,
        title: &str,
        units: &Units,
        when: Timestamp,
        ground: i64,
        parts: &[i64],
        markers: &[GraphicsMarker],
    ) -> io::Result<Self> {
        let mut text = format!(
            " A.G8    {:<19}  {} {}\n",
            when.date_time(),
            unit_code(units),
            exponential(1.0 / units.length.si, 21, 15)
        );
        text.push_str(&title_line(title));
        text.push_str(&format!(" {:>5}{:>5}", parts.len() + 1, markers.len()));
        text.push_str(&"    0".repeat(7));
        text.push('\n');
        for part in std::iter::once(&ground).chain(parts) {
            text.push_str(&format!(" {part:>10}{:>10}\n", 1));
        }
        for marker in markers {
            text.push_str(&format!(" {:>10}{:>10}", marker.id, marker.part));
            for x in marker.position {
                text.push_str(&exponential(x, 13, 5));
            }
            text.push_str(&format!("{:>8}\n", 0));
            text.push_str(&line_of(&marker.angles));
        }
        text.push_str(&line_of(&[-9.999_99e5]));
        text.push_str(&line_of(&[0.0; 6]));
        output.write_all(text.as_bytes())?;
        output.flush()?;
        Ok(Self {
            output,
            parts: parts.len(),
        })
    }

    /// Writes one frame: X, Y, Z, PSI, THETA, PHI (radians) of each part in the order of the head.
    ///
    /// # Errors
    /// `InvalidInput` when there are not as many as parts; otherwise when the output cannot be written.
    pub fn frame(&mut self, time: f64, poses: &[[f64; 6]]) -> io::Result<()> {
        if poses.len() != self.parts {
            let message = format!("{} poses for {} parts", poses.len(), self.parts);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let mut text = line_of(&[time]);
        for pose in poses {
            text.push_str(&line_of(pose));
        }
        self.output.write_all(text.as_bytes())?;
        self.output.flush()
    }

    /// Gives the output back.
    pub fn finish(self) -> W {
        self.output
    }
}
