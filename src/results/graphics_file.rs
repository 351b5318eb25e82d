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

/// Writes a `.gra` file (format A.G8, guide/formats.md 6.4): frames of part positions, each flushed.
///
/// Laid out after the one real file known (AHPC of guide/formats.md): nine counts, of which the first two (parts with ground,
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
        let mut text = Vec::new();
        writeln!(
            text,
            " A.G8    {:<19}  {} {}",
            when.date_time(),
            unit_code(units),
            exponential(1.0 / units.length.si, 21, 15)
        )?;
        text.extend_from_slice(title_line(title).as_bytes());
        write!(text, " {:>5}{:>5}", parts.len() + 1, markers.len())?;
        text.extend_from_slice("    0".repeat(7).as_bytes());
        text.push(b'\n');
        for part in std::iter::once(&ground).chain(parts) {
            writeln!(text, " {part:>10}{:>10}", 1)?;
        }
        for marker in markers {
            write!(text, " {:>10}{:>10}", marker.id, marker.part)?;
            for x in marker.position {
                text.extend_from_slice(exponential(x, 13, 5).as_bytes());
            }
            writeln!(text, "{:>8}", 0)?;
            text.extend_from_slice(line_of(&marker.angles).as_bytes());
        }
        text.extend_from_slice(line_of(&[-9.999_99e5]).as_bytes());
        text.extend_from_slice(line_of(&[0.0; 6]).as_bytes());
        output.write_all(&text)?;
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
        let mut text = line_of(&[time]).into_bytes();
        for pose in poses {
            text.extend_from_slice(line_of(pose).as_bytes());
        }
        self.output.write_all(&text)?;
        self.output.flush()
    }

    /// Gives the output back.
    pub fn finish(self) -> W {
        self.output
    }
}
